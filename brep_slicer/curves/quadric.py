"""Quadric surfaces (cylinders, cones, spheres in any position), unrolled: the root v of a quadratic in v.

In: the quadratic's trigonometric coefficients in theta = kappa / R, the branch, the range. Out: a Curve.

Words: *fold*, an interval of kappa at whose ends the two roots meet; there the curve is parametrised by an angle s so
that it passes from one root to the other without a singularity.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar, Self

import numpy as np

from brep_slicer.maps import Array

from .base import Curve, CurveKind, frozen_array


@dataclass(frozen=True, slots=True, kw_only=True, eq=False, repr=False)
class QuadricCurve(Curve):
    """The curve a v**2 + 2 b(theta) v + c(theta) = 0 on the cylinder, theta = kappa / radius.

    b(theta) = b[0] + b[1] cos + b[2] sin; c(theta) = c[0] + c[1] cos + c[2] sin + c[3] cos 2theta + c[4] sin 2theta
    (all with the squares of the cutting radius already multiplied in, so the coefficients depend on theta alone).

    Without a fold, kappa itself runs from range[0] to range[1] and `branch` (+1 or -1) chooses the root
    v = (-b + branch sqrt(b**2 - a c)) / a. With `fold` = (middle, half) in mm, kappa = middle - half cos(p), the angle p
    runs from range[0] to range[1], and the root is branch * sign(sin p): p in (0, pi) is one root, (pi, 2 pi) the other.
    Where a = 0 the equation is linear: v = -c / (2 b).
    """

    kind: ClassVar[CurveKind] = CurveKind.QUADRIC

    a: float
    b: Array  # (3,)
    c: Array  # (5,)
    radius: float
    branch: int
    range: tuple[float, float]
    fold: tuple[float, float] | None = None
    face: int = -1

    def __post_init__(self) -> None:
        object.__setattr__(self, "b", frozen_array(self.b, name="b", shape=(3,)))
        object.__setattr__(self, "c", frozen_array(self.c, name="c", shape=(5,)))

    def _own_parameter(self, s: Array) -> Array:
        s = np.asarray(s, dtype=np.float64)
        return (1.0 - s) * self.range[0] + s * self.range[1]

    def _kappa_and_sign(self, p: Array) -> tuple[Array, Array]:
        if self.fold is None:
            return p, np.full_like(p, float(self.branch))
        middle, half = self.fold
        return middle - half * np.cos(p), self.branch * np.where(np.sin(p) >= 0.0, 1.0, -1.0)

    def _terms(self, theta: Array) -> tuple[Array, Array]:
        cos, sin = np.cos(theta), np.sin(theta)
        b = self.b[0] + self.b[1] * cos + self.b[2] * sin
        c = self.c[0] + self.c[1] * cos + self.c[2] * sin
        return b, c + self.c[3] * np.cos(2.0 * theta) + self.c[4] * np.sin(2.0 * theta)

    def points(self, s: Array) -> Array:
        kappa, sign = self._kappa_and_sign(self._own_parameter(s))
        b, c = self._terms(kappa / self.radius)
        if self.a == 0.0:
            return np.stack([kappa, -0.5 * c / b], axis=-1)
        root = np.sqrt(np.maximum(b * b - self.a * c, 0.0))
        return np.stack([kappa, (-b + sign * root) / self.a], axis=-1)

    def derivatives(self, s: Array) -> Array:
        p = self._own_parameter(s)
        span = self.range[1] - self.range[0]
        kappa, _ = self._kappa_and_sign(p)
        v = self.points(s)[:, 1]
        theta = kappa / self.radius
        cos, sin = np.cos(theta), np.sin(theta)
        b, _ = self._terms(theta)
        db = -self.b[1] * sin + self.b[2] * cos
        dc = -self.c[1] * sin + self.c[2] * cos
        dc = dc - 2.0 * self.c[3] * np.sin(2.0 * theta) + 2.0 * self.c[4] * np.cos(2.0 * theta)
        # implicit function theorem: 2 (a v + b) dv + (2 v db + dc) dtheta = 0
        across, along = 2.0 * (self.a * v + b), -(2.0 * v * db + dc) / self.radius
        if self.fold is None:
            # at the end of the range the curve may be upright: steep beyond measure, but a number
            across = np.where(across == 0.0, 1e-100, across)
            return np.stack([np.full_like(kappa, span), span * along / across], axis=-1)
        dkappa = self.fold[1] * np.sin(p)
        return span * np.stack([dkappa, self._folded_slope(s, p, dkappa, along, across)], axis=-1)

    def _folded_slope(self, s: Array, p: Array, dkappa: Array, along: Array, across: Array) -> Array:
        """dv/dp; at the ends of the fold, where it is 0/0, by a central difference over a small angle."""
        safe = (np.abs(np.sin(p)) > 1e-4) & (across != 0.0)
        slope = np.where(safe, along * dkappa / np.where(safe, across, 1.0), 0.0)
        if not safe.all():
            step = 1e-3
            wide = replace(self, range=(0.0, 1.0))
            v = [wide.points(p[~safe] + k * step)[:, 1] for k in (-2, -1, 1, 2)]
            slope[~safe] = (v[0] - 8.0 * v[1] + 8.0 * v[2] - v[3]) / (12.0 * step)
        return slope

    def reversed(self) -> Self:
        return replace(self, range=(self.range[1], self.range[0]))

    def trimmed(self, s0: float, s1: float) -> QuadricCurve:
        a, b = self._own_parameter(np.array([s0, s1]))
        return replace(self, range=(float(a), float(b)))

    def shifted(self, dkappa: float) -> Self:
        if self.fold is None:
            return replace(self, range=(self.range[0] + dkappa, self.range[1] + dkappa))
        return replace(self, fold=(self.fold[0] + dkappa, self.fold[1]))

    def on_radius(self, old: float, new: float) -> Self:
        scale = new / old
        if self.fold is None:
            return replace(self, radius=self.radius * scale, range=(self.range[0] * scale, self.range[1] * scale))
        return replace(self, radius=self.radius * scale, fold=(self.fold[0] * scale, self.fold[1] * scale))
