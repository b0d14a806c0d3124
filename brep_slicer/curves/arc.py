"""Circular arcs of the plane: rings of a cone, which unroll about its apex.

In: a point, a direction, a length, a curvature. Out: a Curve. The centre is not used: it lies a thousand times as far away as
the part is long where a cone is nearly a cylinder, and no digits are lost for that.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import ClassVar, Self

import numpy as np

from brep_slicer.layers import Motion
from brep_slicer.maps import Array

from .base import Curve, CurveKind, frozen_array

# A chord spans no more than this of an arc, rad: a quarter turn.
MOST_SPAN = 0.5 * math.pi


@dataclass(frozen=True, slots=True, kw_only=True, eq=False, repr=False)
class ArcCurve(Curve):
    """The arc from `origin` (kappa, v) on, first along `heading` (rad from +kappa towards +v), `size` mm long.

    It bends to the left by `curvature` (1/mm; negative: to the right).
    """

    kind: ClassVar[CurveKind] = CurveKind.ARC

    origin: Array
    heading: float
    size: float
    curvature: float
    face: int = -1

    def __post_init__(self) -> None:
        object.__setattr__(self, "origin", frozen_array(self.origin, name="origin", shape=(2,)))

    def points(self, s: Array) -> Array:
        way = self.size * np.asarray(s, dtype=np.float64)
        half = 0.5 * self.curvature * way
        chord = way * np.sinc(half / np.pi)
        angle = self.heading + half
        return self.origin + chord[..., None] * np.stack([np.cos(angle), np.sin(angle)], axis=-1)

    def derivatives(self, s: Array) -> Array:
        angle = self.heading + self.curvature * self.size * np.asarray(s, dtype=np.float64)
        return self.size * np.stack([np.cos(angle), np.sin(angle)], axis=-1)

    def reversed(self) -> Self:
        back = self.heading + self.curvature * self.size + math.pi
        return replace(self, origin=self.end, heading=back, curvature=-self.curvature)

    def trimmed(self, s0: float, s1: float) -> ArcCurve:
        origin = self.points(np.array([s0]))[0]
        heading = self.heading + self.curvature * self.size * s0
        return replace(self, origin=origin, heading=heading, size=self.size * (s1 - s0))

    def moved(self, motion: Motion) -> Self:
        # a motion turns clockwise
        return replace(self, origin=motion.points(self.origin), heading=self.heading - math.atan2(motion.sin, motion.cos))

    def raised(self, dv: float) -> Self:
        return replace(self, origin=self.origin + np.array([0.0, dv]))

    def on_radius(self, old: float, new: float) -> Self:
        raise ValueError("an arc is no curve of a cylinder's plane: it has no image at the same angles on another radius")

    def length(self) -> float:
        return self.size

    def parameters(self, chord: float) -> Array:
        """Evenly cut, so that the sagitta of each part is within the chord."""
        span = abs(self.curvature) * self.size
        sagitta = min(chord * abs(self.curvature), 1.0)
        most = min(2.0 * math.acos(1.0 - sagitta), MOST_SPAN)
        # acos loses half of the digits of a chord that is nothing beside the radius
        most = max(most, min(math.sqrt(8.0 * sagitta), MOST_SPAN)) if sagitta < 1e-8 else most
        return np.linspace(0.0, 1.0, max(1, math.ceil(span / most)) + 1) if most > 0.0 else np.array([0.0, 1.0])
