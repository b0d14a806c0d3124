"""Families of layers: level sets of one function with unit gradient, all of them developable.

In: points of the axis frame. Out: the value c there, its gradient, the quadric of a level, the sheet of a level.

|grad c| = 1, so that the integral of the section's area over c is the volume, and levels t apart are layers of thickness t.
"""

from __future__ import annotations

import abc
import math
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np

from brep_slicer.maps import TURN, Array

from .closure import NO_CLOSURE, Closure
from .sheet import Sheet, space_of_revolution

# A cone flatter or steeper than this is none: |alpha| = 90 degrees is a plane, said so (rad).
MOST_HALF_ANGLE = 0.5 * math.pi - 1e-6


class LayerFamily(abc.ABC):
    """What layers may lie on; frozen, compared by value."""

    __slots__ = ()

    name: ClassVar[str]
    # Whether the sheets are surfaces of revolution about the axis.
    is_revolved: ClassVar[bool] = True

    @abc.abstractmethod
    def value(self, points: Array) -> Array:
        """c (...) at points (..., 3) of the axis frame, mm."""

    @abc.abstractmethod
    def gradient(self, points: Array) -> Array:
        """The unit gradient (..., 3) of c; zero on the axis itself where it has none."""

    @abc.abstractmethod
    def rise(self, points: Array, directions: Array) -> Array:
        """What has the sign of dc along directions (..., 3) at points (..., 3), and is smooth where c has a kink, (...)."""

    def change(self, points: Array, directions: Array) -> Array:
        """dc along directions (..., 3) at points (..., 3), (...)."""
        return np.asarray((self.gradient(points) * directions).sum(axis=-1))

    def equation(self, points: Array, levels: Array) -> Array:
        """A smooth function (...) of points (..., 3) that is 0 on the sheet at its level and grows with c."""
        return self.value(points) - levels

    def equation_slope(self, points: Array, directions: Array) -> Array:
        """The change of `equation` along directions (..., 3), (...)."""
        return self.change(points, directions)

    def equation_size(self, points: Array, levels: Array) -> Array:
        """What the rounding of `equation` at points near their levels is a share of, (...)."""
        return np.abs(points).sum(axis=-1) + np.abs(levels)

    def spread(self, points: Array, level: float) -> Array:
        """How much narrower the sheet at a level is than that through points (..., 3): what makes grad c free of divergence."""
        return np.ones(np.shape(points)[:-1])

    def reach(self, points: Array, level: float) -> float:
        """The radius (mm) by which the sheet at a level bends near points (n, 3), or how far these reach where it is flat."""
        return float(np.ptp(points, axis=0).max())

    @abc.abstractmethod
    def unrolled(self, points: Array, levels: Array) -> Array:
        """(kappa, v) of ways' points (..., n, 3) on the sheets at `levels` (...), each way followed from its first point."""

    @abc.abstractmethod
    def heights(self, points: Array) -> Array:
        """How high points (..., 3) lie along their generators, (...), mm: z on cylinders; 0 where there are none."""

    @abc.abstractmethod
    def flat_vectors(self, points: Array, vectors: Array) -> Array:
        """Tangents (..., 3) of the sheets at points (..., 3) in the plane, (..., 2): of the copy with theta in (-pi, pi]."""

    @abc.abstractmethod
    def owns(self, kind: str) -> bool:
        """Whether a coaxial surface of a kind ("plane", "cylinder", "cone") may be one of the family's sheets."""

    @abc.abstractmethod
    def quadric(self, level: float) -> Array:
        """The symmetric matrix Q (4, 4) with p Q p = 0 at the homogeneous points p = (x, y, z, 1) of a level's surface."""

    @abc.abstractmethod
    def closure(self, level: Any) -> Closure:
        """The closure of the sheet at a level; of several at `level` (...), see there."""

    @abc.abstractmethod
    def space_from_flat(self, points: Array, level: float) -> Array:
        """See `Sheet.space_from_flat`."""

    @abc.abstractmethod
    def flat_from_space(self, points: Array, level: float) -> Array:
        """See `Sheet.flat_from_space`."""

    @abc.abstractmethod
    def normals_from_flat(self, points: Array, level: float) -> Array:
        """See `Sheet.normals_from_flat`."""

    def label(self, level: float) -> str:
        """A level in words."""
        return f"level {level:.6g} mm"

    def radius(self, level: float) -> float:
        """The radius of a level's sheet where that is a cylinder, mm.

        Raises
        ------
        TypeError
            If it is none.
        """
        raise TypeError(f"layers that are {self.name} have no radius: ask for their level")

    def sheet(self, level: float) -> Sheet:
        """The sheet at a level (mm)."""
        return Sheet(self, float(level))


@dataclass(frozen=True, slots=True)
class Cones(LayerFamily):
    """c = rho cos(alpha) + z sin(alpha): cones at a constant distance from each other, alpha = `half_angle_deg` (degrees).

    They taper towards +z where alpha > 0; alpha = 0 are cylinders, see there. The nappe with rho >= 0 counts: where a level's
    apex lies inside of the part, its ring ends there.
    """

    name: ClassVar[str] = "cones"

    half_angle_deg: float

    def __post_init__(self) -> None:
        if not abs(self.half_angle) <= MOST_HALF_ANGLE:
            raise ValueError(
                f"half_angle_deg is the angle between a cone's generator and the axis, less than 90 degrees"
                f" ({self.half_angle_deg:g} given): planes across the axis are a family of their own"
            )

    @property
    def half_angle(self) -> float:
        """alpha in rad."""
        return math.radians(self.half_angle_deg)

    def value(self, points: Array) -> Array:
        rho = np.hypot(points[..., 0], points[..., 1])
        return rho * math.cos(self.half_angle) + points[..., 2] * math.sin(self.half_angle)

    def gradient(self, points: Array) -> Array:
        rho = np.hypot(points[..., 0], points[..., 1])
        safe = np.where(rho > 0.0, rho, 1.0)
        cos, sin = math.cos(self.half_angle), math.sin(self.half_angle)
        return np.stack([points[..., 0] / safe * cos, points[..., 1] / safe * cos, np.full_like(rho, sin)], axis=-1)

    def rise(self, points: Array, directions: Array) -> Array:
        cos, sin = math.cos(self.half_angle), math.sin(self.half_angle)
        across = points[..., 0] * directions[..., 0] + points[..., 1] * directions[..., 1]
        if sin == 0.0:
            return across
        return across * cos + np.hypot(points[..., 0], points[..., 1]) * directions[..., 2] * sin

    def unrolled(self, points: Array, levels: Array) -> Array:
        turns = np.unwrap(np.arctan2(points[..., 1], points[..., 0]), axis=-1) / TURN
        return self.closure(np.asarray(levels)[..., None]).at(turns, self.heights(points))

    def heights(self, points: Array) -> Array:
        cos, sin = math.cos(self.half_angle), math.sin(self.half_angle)
        return points[..., 2] if sin == 0.0 else points[..., 2] * cos - np.hypot(points[..., 0], points[..., 1]) * sin

    def spread(self, points: Array, level: float) -> Array:
        rho = np.hypot(points[..., 0], points[..., 1])
        foot = rho - (self.value(points) - level) * math.cos(self.half_angle)
        return np.asarray(np.maximum(foot, 0.0) / np.maximum(rho, 1e-300))

    def along_generators(self, points: Array, vectors: Array) -> Array:
        """How far vectors (..., 3) at points (..., 3) go up along the generators, (...)."""
        rho = np.maximum(np.hypot(points[..., 0], points[..., 1]), 1e-300)
        outwards = (points[..., 0] * vectors[..., 0] + points[..., 1] * vectors[..., 1]) / rho
        return np.asarray(vectors[..., 2] * math.cos(self.half_angle) - outwards * math.sin(self.half_angle))

    def flat_vectors(self, points: Array, vectors: Array) -> Array:
        rho = np.maximum(np.hypot(points[..., 0], points[..., 1]), 1e-300)
        along = (points[..., 0] * vectors[..., 1] - points[..., 1] * vectors[..., 0]) / rho
        turns = np.arctan2(points[..., 1], points[..., 0]) / TURN
        flat = np.stack([along, self.along_generators(points, vectors)], axis=-1)
        return self.closure(1.0).turned(flat, turns)

    def owns(self, kind: str) -> bool:
        return kind == "cone"

    def quadric(self, level: float) -> Array:
        cos, sin = math.cos(self.half_angle), math.sin(self.half_angle)
        q = np.diag([cos * cos, cos * cos, -sin * sin, -level * level])
        q[2, 3] = q[3, 2] = level * sin
        return q

    def closure(self, level: Any) -> Closure:
        return Closure(TURN * level * math.cos(self.half_angle), -TURN * math.sin(self.half_angle))

    def space_from_flat(self, points: Array, level: float) -> Array:
        return space_of_revolution(points, self.closure(level), level, self.half_angle)

    def flat_from_space(self, points: Array, level: float) -> Array:
        return self.closure(level).at(np.arctan2(points[..., 1], points[..., 0]) / TURN, self.heights(points))

    def normals_from_flat(self, points: Array, level: float) -> Array:
        theta, cos = TURN * self.closure(level).turns_of(points), math.cos(self.half_angle)
        return np.stack([cos * np.cos(theta), cos * np.sin(theta), np.full_like(theta, math.sin(self.half_angle))], axis=-1)


@dataclass(frozen=True, slots=True)
class Cylinders(Cones):
    """c = rho: coaxial cylinders, the paper's layers. kappa = c theta, v = z."""

    name: ClassVar[str] = "cylinders"

    half_angle_deg: float = field(default=0.0, init=False)

    def __repr__(self) -> str:
        return "Cylinders()"

    def value(self, points: Array) -> Array:
        return np.hypot(points[..., 0], points[..., 1])

    def change(self, points: Array, directions: Array) -> Array:
        across = points[..., 0] * directions[..., 0] + points[..., 1] * directions[..., 1]
        return np.asarray(across / np.maximum(self.value(points), 1e-300))

    def equation(self, points: Array, levels: Array) -> Array:
        return (points[..., 0] ** 2 + points[..., 1] ** 2) - levels**2

    def equation_slope(self, points: Array, directions: Array) -> Array:
        return 2.0 * (points[..., 0] * directions[..., 0] + points[..., 1] * directions[..., 1])

    def equation_size(self, points: Array, levels: Array) -> Array:
        return np.square(levels)

    def reach(self, points: Array, level: float) -> float:
        return level

    def owns(self, kind: str) -> bool:
        return kind == "cylinder"

    def label(self, level: float) -> str:
        return f"R {level:.6g} mm"

    def radius(self, level: float) -> float:
        return level


CYLINDERS = Cylinders()


def cylinder(radius: float) -> Sheet:
    """The sheet of the coaxial cylinder of a radius (mm)."""
    return CYLINDERS.sheet(radius)


@dataclass(frozen=True, slots=True)
class Planes(LayerFamily):
    """c = n p: parallel planes of any unit `normal` (3,) in the axis frame; (0, 0, 1), across the axis, by default.

    In the plane, kappa runs along `kappa_direction` (the frame's x, cast on the plane; y where that is upright), v = n x kappa.
    """

    name: ClassVar[str] = "planes"
    is_revolved: ClassVar[bool] = False

    normal: tuple[float, float, float] = (0.0, 0.0, 1.0)

    def __post_init__(self) -> None:
        if len(self.normal) != 3 or not math.isclose(math.hypot(*self.normal), 1.0, rel_tol=1e-12):
            raise ValueError(f"the normal of a family of planes must be a unit vector of three numbers, got {self.normal}")

    def frame(self) -> Array:
        """The directions of kappa, v and the normal, rows of (3, 3)."""
        n = np.array(self.normal)
        x = np.array([0.0, 1.0, 0.0]) if abs(n[0]) > 1.0 - 1e-9 else np.array([1.0, 0.0, 0.0])
        kappa = x - (x @ n) * n
        kappa /= np.linalg.norm(kappa)
        return np.stack([kappa, np.cross(n, kappa), n])

    def value(self, points: Array) -> Array:
        return np.asarray(points @ np.array(self.normal))

    def gradient(self, points: Array) -> Array:
        return np.broadcast_to(np.array(self.normal), points.shape).copy()

    def rise(self, points: Array, directions: Array) -> Array:
        return np.asarray(directions @ np.array(self.normal))

    def unrolled(self, points: Array, levels: Array) -> Array:
        return np.asarray(points @ self.frame()[:2].T)

    def heights(self, points: Array) -> Array:
        return np.zeros(np.shape(points)[:-1])

    def flat_vectors(self, points: Array, vectors: Array) -> Array:
        return np.asarray(vectors @ self.frame()[:2].T)

    def owns(self, kind: str) -> bool:
        return kind == "plane"

    def quadric(self, level: float) -> Array:
        q = np.zeros((4, 4))
        q[:3, 3] = q[3, :3] = 0.5 * np.array(self.normal)
        q[3, 3] = -level
        return q

    def closure(self, level: Any) -> Closure:
        return NO_CLOSURE

    def space_from_flat(self, points: Array, level: float) -> Array:
        kappa, v, n = self.frame()
        return points[..., :1] * kappa + points[..., 1:] * v + level * n

    def flat_from_space(self, points: Array, level: float) -> Array:
        return np.asarray(points @ self.frame()[:2].T)

    def normals_from_flat(self, points: Array, level: float) -> Array:
        return np.broadcast_to(np.array(self.normal), (*points.shape[:-1], 3)).copy()
