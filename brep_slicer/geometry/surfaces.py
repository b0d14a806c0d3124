"""Surfaces of faces, evaluated over whole arrays.

In: what the kernel stores, in the axis frame. Out: points (n, 3), first derivatives, parameters of points.
"""

from __future__ import annotations

import abc
import enum
from dataclasses import dataclass, field

import numpy as np

from brep_slicer.maps import TURN, Array

from .edge_curves import EdgeCurve
from .polynomials import SpanTable, bernstein_with_slope, bezier_spans, breaks_between, projected, spans_of, wrapped


class SurfaceKind(enum.Enum):
    """How a surface is stored."""

    PLANE = "plane"
    CYLINDER = "cylinder"
    CONE = "cone"
    SPHERE = "sphere"
    TORUS = "torus"
    BSPLINE = "bspline"
    EXTRUSION = "extrusion"
    REVOLUTION = "revolution"


class Surface(abc.ABC):
    """A surface S(u, v)."""

    __slots__ = ()

    kind: SurfaceKind

    @abc.abstractmethod
    def derivatives(self, uv: Array) -> tuple[Array, Array, Array]:
        """(S, S_u, S_v) at uv (n, 2), each (n, 3)."""

    def points(self, uv: Array) -> Array:
        """Points (n, 3) at uv (n, 2)."""
        return self.derivatives(uv)[0]

    def periods(self) -> tuple[float, float]:
        """Periods in u and v; 0 where the surface is not periodic."""
        return (0.0, 0.0)

    def breaks(self, box: Array) -> tuple[Array, Array]:
        """Parameters in u and in v, over box (2, 2) = [[u0, v0], [u1, v1]], between which the surface is smooth."""
        return box[:, 0], box[:, 1]


# Points evaluated at a time on a B-spline surface.
BLOCK = 4096


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ElementarySurface(Surface):
    """Plane, cylinder, cone, sphere or torus, as OCCT parametrises them.

    `frame` (3, 3) holds the x, y and z directions as rows (left-handed ones occur); `radius` is the cylinder's, the
    cone's at v = 0, the sphere's or the torus's major one; `minor` the torus's minor one; `half_angle` the cone's.
    """

    kind: SurfaceKind
    origin: Array
    frame: Array
    radius: float = 0.0
    minor: float = 0.0
    half_angle: float = 0.0

    def derivatives(self, uv: Array) -> tuple[Array, Array, Array]:
        u, v = uv[:, 0], uv[:, 1]
        zero, one = np.zeros_like(u), np.ones_like(u)
        if self.kind is SurfaceKind.PLANE:
            return self._place([u, v, zero]), self._turn([one, zero, zero]), self._turn([zero, one, zero])
        cos, sin = np.cos(u), np.sin(u)
        rho, height, drho, dheight = self._profile(v)
        point = self._place([rho * cos, rho * sin, height])
        return point, self._turn([-rho * sin, rho * cos, zero]), self._turn([drho * cos, drho * sin, dheight])

    def _profile(self, v: Array) -> tuple[Array, Array, Array, Array]:
        """Distance from the surface's own axis, height along it, and their derivatives, at v."""
        one, zero = np.ones_like(v), np.zeros_like(v)
        if self.kind is SurfaceKind.CYLINDER:
            return self.radius * one, v, zero, one
        if self.kind is SurfaceKind.CONE:
            sin, cos = np.sin(self.half_angle), np.cos(self.half_angle)
            return self.radius + v * sin, v * cos, sin * one, cos * one
        cos, sin = np.cos(v), np.sin(v)
        if self.kind is SurfaceKind.SPHERE:
            return self.radius * cos, self.radius * sin, -self.radius * sin, self.radius * cos
        return self.radius + self.minor * cos, self.minor * sin, -self.minor * sin, self.minor * cos

    def _turn(self, local: list[Array]) -> Array:
        return np.stack(local, axis=1) @ self.frame

    def _place(self, local: list[Array]) -> Array:
        return self.origin + self._turn(local)

    def local_from_points(self, points: Array) -> Array:
        """Coordinates (n, 3) in the surface's own frame."""
        return (points - self.origin) @ self.frame.T

    def parameters(self, points: Array) -> Array:
        """(u, v) of points (n, 3) on the surface; u in [0, 2 pi)."""
        x, y, z = self.local_from_points(points).T
        if self.kind is SurfaceKind.PLANE:
            return np.stack([x, y], axis=1)
        u = np.mod(np.arctan2(y, x), TURN)
        rho = np.hypot(x, y)
        if self.kind is SurfaceKind.CYLINDER:
            return np.stack([u, z], axis=1)
        if self.kind is SurfaceKind.CONE:
            v = z / np.cos(self.half_angle)
            behind = self.radius + v * np.sin(self.half_angle) < 0.0
            return np.stack([np.mod(u + np.pi * behind, TURN), v], axis=1)
        if self.kind is SurfaceKind.SPHERE:
            return np.stack([u, np.arctan2(z, rho)], axis=1)
        return np.stack([u, np.mod(np.arctan2(z, rho - self.radius), TURN)], axis=1)

    def periods(self) -> tuple[float, float]:
        if self.kind is SurfaceKind.PLANE:
            return (0.0, 0.0)
        return (TURN, TURN if self.kind is SurfaceKind.TORUS else 0.0)

    def breaks(self, box: Array) -> tuple[Array, Array]:
        periods = self.periods()
        cuts = [max(1, int(np.ceil((box[1, i] - box[0, i]) / (0.25 * TURN) - 1e-9))) if p else 1 for i, p in enumerate(periods)]
        if self.kind is SurfaceKind.SPHERE:
            cuts[1] = 2
        return np.linspace(box[0, 0], box[1, 0], cuts[0] + 1), np.linspace(box[0, 1], box[1, 1], cuts[1] + 1)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BSplineSurface(Surface):
    """A tensor-product B-spline: degrees, full clamped knots, `poles` (n, m, 3), `weights` (n, m) or None.

    `period` (u, v) is 0 where the surface does not go on periodically.
    """

    degrees: tuple[int, int]
    knots_u: Array
    knots_v: Array
    poles: Array
    weights: Array | None
    kind: SurfaceKind = SurfaceKind.BSPLINE
    period: tuple[float, float] = (0.0, 0.0)
    _breaks: tuple[Array, Array] = field(init=False)
    _coefficients: Array = field(init=False)

    def __post_init__(self) -> None:
        poles = self.poles
        if self.weights is not None:
            poles = np.concatenate([poles * self.weights[..., None], self.weights[..., None]], axis=-1)
        bu, along_u = bezier_spans(self.knots_u, poles, self.degrees[0])
        bv, both = bezier_spans(self.knots_v, np.moveaxis(along_u, 2, 0), self.degrees[1])
        # both: (spans v, power v, spans u, power u, dim) -> (spans u, spans v, power u, power v, dim)
        object.__setattr__(self, "_coefficients", np.ascontiguousarray(np.transpose(both, (2, 0, 3, 1, 4))))
        object.__setattr__(self, "_breaks", (bu, bv))

    def derivatives(self, uv: Array) -> tuple[Array, Array, Array]:
        su, x, wu = spans_of(self._breaks[0], wrapped(uv[:, 0], self._breaks[0], self.period[0]))
        sv, y, wv = spans_of(self._breaks[1], wrapped(uv[:, 1], self._breaks[1], self.period[1]))
        patches = self._coefficients.reshape(-1, *self._coefficients.shape[2:])
        s, s_u, s_v = _tensor(patches, su * self._coefficients.shape[1] + sv, self.degrees, (x, y), (wu, wv))
        if self.weights is None:
            return s, s_u, s_v
        point, d_u = projected([s, s_u])
        return point, d_u, projected([s, s_v])[1]

    def breaks(self, box: Array) -> tuple[Array, Array]:
        u, v = (
            breaks_between(b, p, box[0, i], box[1, i]) for i, (b, p) in enumerate(zip(self._breaks, self.period, strict=True))
        )
        return u, v

    def periods(self) -> tuple[float, float]:
        return self.period


def _tensor(patches: Array, which: Array, degrees: tuple[int, int], at: tuple[Array, Array], widths: tuple[Array, Array]):
    """S, S_u, S_v (n, dim) on Bezier patches (m, p + 1, q + 1, dim), at local coordinates of the patches `which` (n,).

    By blocks of points that fit into the processor's cache: a gathered patch takes a kilobyte. Far outside of its patch a
    surface of high degree is beyond all numbers; whoever asks there takes no such answer.
    """
    with np.errstate(over="ignore", invalid="ignore"):
        return _tensor_by_blocks(patches, which, degrees, at, widths)


def _tensor_by_blocks(
    patches: Array, which: Array, degrees: tuple[int, int], at: tuple[Array, Array], widths: tuple[Array, Array]
) -> Array:
    out = np.empty((3, len(which), patches.shape[-1]))
    for begin in range(0, len(which), BLOCK):
        rows = slice(begin, begin + BLOCK)
        local = patches[which[rows]]
        n, p1, q1, dim = local.shape
        px, dx = bernstein_with_slope(at[0][rows], degrees[0])
        py, dy = bernstein_with_slope(at[1][rows], degrees[1])
        along = np.matmul(np.stack([px, dx], axis=1), local.reshape(n, p1, q1 * dim)).reshape(n, 2, q1, dim)
        out[0, rows] = np.matmul(py[:, None, :], along[:, 0])[:, 0]
        out[1, rows] = np.matmul(py[:, None, :], along[:, 1])[:, 0] / widths[0][rows, None]
        out[2, rows] = np.matmul(dy[:, None, :], along[:, 0])[:, 0] / widths[1][rows, None]
    return out


class BSplineSurfacePack:
    """Several polynomial B-spline surfaces of the same degrees, evaluated together: which one is said by its number."""

    def __init__(self, surfaces: list[BSplineSurface]) -> None:
        self.degrees = surfaces[0].degrees
        self.u, self.v = (SpanTable([s._breaks[k] for s in surfaces]) for k in (0, 1))
        patches = self.u.count * self.v.count
        self.first = np.cumsum(patches) - patches
        self.coefficients = np.concatenate([s._coefficients.reshape(-1, *s._coefficients.shape[2:]) for s in surfaces])

    @staticmethod
    def takes(surface: Surface) -> bool:
        """Whether a surface may be packed."""
        return isinstance(surface, BSplineSurface) and surface.weights is None and not any(surface.period)

    def derivatives(self, which: Array, uv: Array) -> tuple[Array, Array, Array]:
        """S, S_u, S_v as `Surface.derivatives` has them."""
        su, x, wu = self.u.find(which, uv[:, 0])
        sv, y, wv = self.v.find(which, uv[:, 1])
        patch = self.first[which] + (su - self.u.first[which]) * self.v.count[which] + (sv - self.v.first[which])
        s, s_u, s_v = _tensor(self.coefficients, patch, self.degrees, (x, y), (wu, wv))
        return s, s_u, s_v


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Extrusion(Surface):
    """C(u) + v * direction."""

    curve: EdgeCurve
    direction: Array
    kind: SurfaceKind = SurfaceKind.EXTRUSION
    period: float = 0.0

    def derivatives(self, uv: Array) -> tuple[Array, Array, Array]:
        point, along = self.curve.derivatives(uv[:, 0], 1)
        return point + uv[:, 1:] * self.direction, along, np.broadcast_to(self.direction, along.shape)

    def periods(self) -> tuple[float, float]:
        return (self.period, 0.0)

    def breaks(self, box: Array) -> tuple[Array, Array]:
        return self.curve.breaks(float(box[0, 0]), float(box[1, 0])), box[:, 1]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Revolution(Surface):
    """C(v) turned by the angle u about the line through `origin` along `axis` (unit)."""

    curve: EdgeCurve
    origin: Array
    axis: Array
    kind: SurfaceKind = SurfaceKind.REVOLUTION
    period: float = 0.0

    def derivatives(self, uv: Array) -> tuple[Array, Array, Array]:
        point, along = self.curve.derivatives(uv[:, 1], 1)
        cos, sin = np.cos(uv[:, :1]), np.sin(uv[:, :1])
        arm = self._turned(point - self.origin, cos, sin)
        return self.origin + arm, np.cross(self.axis, arm), self._turned(along, cos, sin)

    def _turned(self, vectors: Array, cos: Array, sin: Array) -> Array:
        along = (vectors @ self.axis)[:, None] * self.axis
        return along + cos * (vectors - along) + sin * np.cross(self.axis, vectors)

    def periods(self) -> tuple[float, float]:
        return (TURN, self.period)

    def breaks(self, box: Array) -> tuple[Array, Array]:
        cuts = max(1, int(np.ceil((box[1, 0] - box[0, 0]) / (0.25 * TURN) - 1e-9)))
        return np.linspace(box[0, 0], box[1, 0], cuts + 1), self.curve.breaks(float(box[0, 1]), float(box[1, 1]))
