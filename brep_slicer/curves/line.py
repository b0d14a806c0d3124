"""Straight lines of the plane: kappa = const (planes through or beside the axis), v = const, helices.

In: two end points. Out: a Curve.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from brep_slicer.layers import Motion
from brep_slicer.maps import Array

from .base import Curve, CurveKind, frozen_array


@dataclass(frozen=True, slots=True, kw_only=True, eq=False, repr=False)
class LineCurve(Curve):
    """The segment from `p0` to `p1`, each (kappa, v) in mm, shape (2,)."""

    kind: ClassVar[CurveKind] = CurveKind.LINE

    p0: Array
    p1: Array
    face: int = -1

    def __post_init__(self) -> None:
        object.__setattr__(self, "p0", frozen_array(self.p0, name="p0", shape=(2,)))
        object.__setattr__(self, "p1", frozen_array(self.p1, name="p1", shape=(2,)))

    @classmethod
    def between(cls, p0: tuple[float, float], p1: tuple[float, float], *, face: int = -1) -> LineCurve:
        """The segment between two points given as pairs (kappa, v), mm."""
        return cls(p0=np.array(p0, dtype=np.float64), p1=np.array(p1, dtype=np.float64), face=face)

    @property
    def start(self) -> Array:
        return self.p0

    @property
    def end(self) -> Array:
        return self.p1

    def points(self, s: Array) -> Array:
        s = np.asarray(s, dtype=np.float64)[:, None]
        return (1.0 - s) * self.p0 + s * self.p1

    def derivatives(self, s: Array) -> Array:
        return np.broadcast_to(self.p1 - self.p0, (len(s), 2)).copy()

    def reversed(self) -> Self:
        return type(self)(p0=self.p1, p1=self.p0, face=self.face)

    def trimmed(self, s0: float, s1: float) -> LineCurve:
        p = self.points(np.array([s0, s1]))
        return LineCurve(p0=p[0], p1=p[1], face=self.face)

    def moved(self, motion: Motion) -> Self:
        return type(self)(p0=motion.points(self.p0), p1=motion.points(self.p1), face=self.face)

    def raised(self, dv: float) -> Self:
        move = np.array([0.0, dv])
        return type(self)(p0=self.p0 + move, p1=self.p1 + move, face=self.face)

    def on_radius(self, old: float, new: float) -> Self:
        scale = np.array([new / old, 1.0])
        return type(self)(p0=self.p0 * scale, p1=self.p1 * scale, face=self.face)

    def moment(self, power: int = 1) -> float:
        """Closed form of the integral of v**power dkappa: dkappa times the mean of v**power over the segment."""
        a, b = self.p0[1], self.p1[1]
        mean = sum(a**i * b ** (power - i) for i in range(power + 1)) / (power + 1)
        return float((self.p1[0] - self.p0[0]) * mean)

    def length(self) -> float:
        return float(np.hypot(*(self.p1 - self.p0)))

    def bounds(self) -> tuple[float, float, float, float]:
        low, high = np.minimum(self.p0, self.p1), np.maximum(self.p0, self.p1)
        return float(low[0]), float(low[1]), float(high[0]), float(high[1])

    def parameters(self, chord: float) -> Array:
        return np.array([0.0, 1.0])
