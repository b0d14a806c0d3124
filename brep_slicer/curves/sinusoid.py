"""Oblique planes, unrolled: v = a0 + a1 cos(kappa / R) + a2 sin(kappa / R).

In: the coefficients, the radius and the range of kappa. Out: a Curve.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar, Self

import numpy as np

from brep_slicer.layers import Motion
from brep_slicer.maps import Array

from .base import Curve, CurveKind, frozen_array


@dataclass(frozen=True, slots=True, kw_only=True, eq=False, repr=False)
class SinusoidCurve(Curve):
    """v(kappa) = a0 + a1 cos(kappa / radius) + a2 sin(kappa / radius), kappa from range[0] to range[1] (mm).

    The plane a x + b y + n z = c gives a0 = c / n, a1 = -a R / n, a2 = -b R / n.
    """

    kind: ClassVar[CurveKind] = CurveKind.SINUSOID

    coefficients: Array  # (3,) mm
    radius: float
    range: tuple[float, float]
    face: int = -1

    def __post_init__(self) -> None:
        object.__setattr__(self, "coefficients", frozen_array(self.coefficients, name="coefficients", shape=(3,)))

    def _kappa(self, s: Array) -> Array:
        s = np.asarray(s, dtype=np.float64)
        return (1.0 - s) * self.range[0] + s * self.range[1]

    def points(self, s: Array) -> Array:
        kappa = self._kappa(s)
        a0, a1, a2 = self.coefficients
        theta = kappa / self.radius
        return np.stack([kappa, a0 + a1 * np.cos(theta) + a2 * np.sin(theta)], axis=-1)

    def derivatives(self, s: Array) -> Array:
        span = self.range[1] - self.range[0]
        _, a1, a2 = self.coefficients
        theta = self._kappa(s) / self.radius
        slope = (-a1 * np.sin(theta) + a2 * np.cos(theta)) / self.radius
        return np.stack([np.full_like(theta, span), span * slope], axis=-1)

    def reversed(self) -> Self:
        return replace(self, range=(self.range[1], self.range[0]))

    def trimmed(self, s0: float, s1: float) -> SinusoidCurve:
        a, b = self._kappa(np.array([s0, s1]))
        return replace(self, range=(float(a), float(b)))

    def moved(self, motion: Motion) -> Self:
        return replace(self, range=(self.range[0] + motion.along_kappa, self.range[1] + motion.along_kappa))

    def raised(self, dv: float) -> Self:
        return replace(self, coefficients=self.coefficients + np.array([dv, 0.0, 0.0]))

    def on_radius(self, old: float, new: float) -> Self:
        scale = new / old
        return replace(self, radius=self.radius * scale, range=(self.range[0] * scale, self.range[1] * scale))

    def moment(self, power: int = 1) -> float:
        """Closed form for power 1 and 2, from the antiderivatives in theta."""
        if power not in (1, 2):
            # the explicit class: a dataclass with slots has no zero-argument super() on every Python
            return Curve.moment(self, power)
        a0, a1, a2 = self.coefficients
        t = np.array(self.range) / self.radius
        sin, cos = np.sin(t), np.cos(t)
        if power == 1:
            value = a0 * t + a1 * sin - a2 * cos
        else:
            sin2, cos2 = np.sin(2.0 * t), np.cos(2.0 * t)
            value = (a0**2 + 0.5 * (a1**2 + a2**2)) * t + 2.0 * a0 * (a1 * sin - a2 * cos)
            value = value + 0.25 * (a1**2 - a2**2) * sin2 - 0.5 * a1 * a2 * cos2
        return float(self.radius * (value[1] - value[0]))
