"""The developable surface of one layer, and how it lies in its plane.

In: a family and a level. Out: a Sheet: maps between space (axis frame) and plane, isometries both, and the closure.

Words: *generator*, a straight line of the sheet: along the axis on a cylinder, through the apex on a cone; *kappa*, *v*, the
coordinates of the plane, mm: v runs along the generator at theta = 0, kappa away from it, counter-clockwise seen from outside.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from brep_slicer.maps import TURN, Array, check_points

from .closure import Closure

if TYPE_CHECKING:
    from .family import LayerFamily


@dataclass(frozen=True, slots=True)
class Sheet:
    """The layer of a `family` at `level` c (mm): all points with value(p) = c.

    On a sheet of revolution a point is (rho, z) = (c cos(alpha) - h sin(alpha), c sin(alpha) + h cos(alpha)) at the height h of
    its generator (on a cylinder rho = c, z = h), and its ring develops into an arc about the apex.
    """

    family: LayerFamily
    level: float
    closure: Closure = field(init=False, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "closure", self.family.closure(self.level))

    def __repr__(self) -> str:
        return f"Sheet({self.family.name}: {self.label})"

    @property
    def label(self) -> str:
        """Which one of its family, in words."""
        return self.family.label(self.level)

    @property
    def radius(self) -> float:
        """The level of a cylinder: its radius, mm.

        Raises
        ------
        TypeError
            If the sheet is none.
        """
        return self.family.radius(self.level)

    def space_from_flat(self, points: ArrayLike) -> Array:
        """Points (..., 3) of the axis frame at (kappa, v), shape (..., 2)."""
        return self.family.space_from_flat(check_points(points, columns=2, name="points"), self.level)

    def flat_from_space(self, points: ArrayLike) -> Array:
        """(kappa, v), shape (..., 2), of points (..., 3) of the sheet: of the copy with theta in (-pi, pi]."""
        return self.family.flat_from_space(check_points(points, columns=3, name="points"), self.level)

    def flat_along(self, points: ArrayLike) -> Array:
        """(kappa, v), shape (n, 2), of a way's points (n, 3), followed from the first: continuous over the seam."""
        flat = self.flat_from_space(points)
        turns = self.closure.turns_of(flat)
        return self.closure.moved(flat, np.concatenate([[0.0], -np.cumsum(np.round(np.diff(turns)))]))

    def normals_from_flat(self, points: ArrayLike) -> Array:
        """Outward unit normals (the value's gradient) at (kappa, v), shape (..., 3)."""
        flat = check_points(points, columns=2, name="points")
        return self.family.normals_from_flat(flat, self.level)


def space_of_revolution(flat: Array, closure: Closure, level: float, half_angle: float) -> Array:
    """The same for cylinders and cones: theta from the turn, rho and z from the height."""
    theta, h = TURN * closure.turns_of(flat), closure.heights_of(flat)
    cos, sin = math.cos(half_angle), math.sin(half_angle)
    rho = level * cos - h * sin
    return np.stack([rho * np.cos(theta), rho * np.sin(theta), level * sin + h * cos], axis=-1)
