"""Quadric surfaces (cylinders, cones, spheres in any position), unrolled: the root v of a quadratic in v.

In: the quadratic's trigonometric coefficients in theta = kappa / R, the branch, the range. Out: a Curve.

Words: *fold*, an interval of kappa at whose ends the two roots meet; there the curve is parametrised by an angle s so
that it passes from one root to the other without a singularity. A curve that comes near to one end only has a fold, too: its
other end is then a number that lies beyond the curve.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import ClassVar, Self

import numpy as np

from brep_slicer.layers import Motion
from brep_slicer.maps import Array

from .base import Curve, CurveKind, frozen_array


@dataclass(frozen=True, slots=True, kw_only=True, eq=False, repr=False)
class QuadricCurve(Curve):
    """The curve a w**2 + 2 b(theta) w + c(theta) = 0, w = v - lift, on the cylinder, theta = kappa / radius.

    `lift` (mm) is the height that the coefficients are about: far from the curve they would lose its digits.

    b(theta) = b[0] + b[1] cos + b[2] sin; c(theta) = c[0] + c[1] cos + c[2] sin + c[3] cos 2theta + c[4] sin 2theta
    (all with the squares of the cutting radius already multiplied in, so the coefficients depend on theta alone).

    Without a fold, kappa itself runs from range[0] to range[1] and `branch` (+1 or -1) chooses the root
    w = (-b + branch sqrt(b**2 - a c)) / a. With `fold` = (middle, half) in mm, kappa = middle - half cos(p), the angle p
    runs from range[0] to range[1], and the root is branch * sign(sin p): p in (0, pi) is one root, (pi, 2 pi) the other.
    The roots meet at that end of the fold that is nearer to the curve's points: cos p > 0, the lower one.
    Where a = 0 the equation is linear: w = -c / (2 b).
    """

    kind: ClassVar[CurveKind] = CurveKind.QUADRIC

    a: float
    b: Array  # (3,)
    c: Array  # (5,)
    radius: float
    branch: int
    range: tuple[float, float]
    fold: tuple[float, float] | None = None
    lift: float = 0.0
    face: int = -1

    def __post_init__(self) -> None:
        object.__setattr__(self, "b", frozen_array(self.b, name="b", shape=(3,)))
        object.__setattr__(self, "c", frozen_array(self.c, name="c", shape=(5,)))

    def _own_parameter(self, s: Array) -> Array:
        s = np.asarray(s, dtype=np.float64)
        return (1.0 - s) * self.range[0] + s * self.range[1]

    def _terms(self, theta: Array) -> tuple[Array, Array]:
        cos, sin = np.cos(theta), np.sin(theta)
        b = self.b[0] + self.b[1] * cos + self.b[2] * sin
        c = self.c[0] + self.c[1] * cos + self.c[2] * sin
        return b, c + self.c[3] * np.cos(2.0 * theta) + self.c[4] * np.sin(2.0 * theta)

    def points(self, s: Array) -> Array:
        p = self._own_parameter(s)
        if self.fold is not None:
            return self._folded(p, slopes=False)[0]
        b, c = self._terms(p / self.radius)
        if self.a == 0.0:
            return np.stack([p, self.lift - 0.5 * c / b], axis=-1)
        root = np.sqrt(np.maximum(b * b - self.a * c, 0.0))
        return np.stack([p, self.lift + (-b + self.branch * root) / self.a], axis=-1)

    def derivatives(self, s: Array) -> Array:
        p = self._own_parameter(s)
        span = self.range[1] - self.range[0]
        if self.fold is not None:
            return span * self._folded(p)[1]
        v = self.points(s)[:, 1] - self.lift
        theta = p / self.radius
        cos, sin = np.cos(theta), np.sin(theta)
        b, _ = self._terms(theta)
        db = -self.b[1] * sin + self.b[2] * cos
        dc = -self.c[1] * sin + self.c[2] * cos
        dc = dc - 2.0 * self.c[3] * np.sin(2.0 * theta) + 2.0 * self.c[4] * np.cos(2.0 * theta)
        # implicit function theorem: 2 (a v + b) dv + (2 v db + dc) dtheta = 0
        across, along = 2.0 * (self.a * v + b), -(2.0 * v * db + dc) / self.radius
        # at the end of the range the curve may be upright: steep beyond measure, but a number
        across = np.where(across == 0.0, 1e-100, across)
        return np.stack([np.full_like(p, span), span * along / across], axis=-1)

    def at(self, s: Array) -> tuple[Array, Array]:
        if self.fold is None:
            return self.points(s), self.derivatives(s)
        points, slopes = self._folded(self._own_parameter(s))
        return points, (self.range[1] - self.range[0]) * slopes

    def _folded(self, p: Array, *, slopes: bool = True) -> tuple[Array, Array]:
        """Points and, unless without `slopes`, derivatives by the angle `p` of the fold, (n, 2) each.

        D = b**2 - a c vanishes at the fold's end. How it grows from there is told by products, so that no digits are lost, and
        the root is |q| K, where q, the sine or cosine of p / 2, vanishes at the end and K does not: its slope is no 0 / 0.
        """
        assert self.fold is not None
        middle, half = self.fold
        ratio = half / self.radius
        sin_half, cos_half = np.sin(0.5 * p), np.cos(0.5 * p)
        lower = np.abs(cos_half) > np.abs(sin_half)
        way = np.where(lower, 1.0, -1.0)
        q, other = np.where(lower, sin_half, cos_half), np.where(lower, cos_half, sin_half)
        # half the angle between the fold's end and the point, and the angle halfway between them
        u = ratio * q * q
        sin_u, cos_u = way * np.sin(u), np.cos(u)
        mean = (middle - way * half) / self.radius + way * u
        cos_mean, sin_mean = np.cos(mean), np.sin(mean)
        cos, sin = cos_mean * cos_u - sin_mean * sin_u, sin_mean * cos_u + cos_mean * sin_u
        d1, e1, d2, e2 = self._discriminant()
        twice = e2 * (cos_mean**2 - sin_mean**2) - 2.0 * d2 * sin_mean * cos_mean
        grows = way * (2.0 * (e1 * cos_mean - d1 * sin_mean) + 4.0 * cos_u * twice)
        sinc = np.where(u > 0.0, way * sin_u / np.where(u > 0.0, u, 1.0), 1.0)
        k = np.sqrt(np.maximum(ratio * sinc * grows, 1e-200))
        upper = self.branch * np.where(sin_half * cos_half >= 0.0, 1.0, -1.0)
        v = (upper * np.abs(q) * k - (self.b[0] + self.b[1] * cos + self.b[2] * sin)) / self.a
        points = np.stack([middle - half * (cos_half**2 - sin_half**2), self.lift + v], axis=-1)
        if not slopes:
            return points, points
        along = 2.0 * ratio * sin_half * cos_half
        slope = e1 * cos - d1 * sin + 2.0 * (e2 * (cos * cos - sin * sin) - 2.0 * d2 * sin * cos)
        db = self.b[2] * cos - self.b[1] * sin
        dv = (self.branch * slope * ratio * np.abs(other) / k - db * along) / self.a
        return points, np.stack([self.radius * along, dv], axis=-1)

    def _discriminant(self) -> tuple[float, float, float, float]:
        """What b**2 - a c holds of cos(theta), sin(theta), cos(2 theta) and sin(2 theta)."""
        b0, b1, b2 = self.b.tolist()
        _, c1, c2, c3, c4 = self.c.tolist()
        once = (2.0 * b0 * b1 - self.a * c1, 2.0 * b0 * b2 - self.a * c2)
        return (*once, 0.5 * (b1 * b1 - b2 * b2) - self.a * c3, b1 * b2 - self.a * c4)

    def reversed(self) -> Self:
        return replace(self, range=(self.range[1], self.range[0]))

    def trimmed(self, s0: float, s1: float) -> QuadricCurve:
        a, b = self._own_parameter(np.array([s0, s1]))
        return replace(self, range=(float(a), float(b)))

    def moved(self, motion: Motion) -> Self:
        dkappa = motion.along_kappa
        if self.fold is None:
            return replace(self, range=(self.range[0] + dkappa, self.range[1] + dkappa))
        return replace(self, fold=(self.fold[0] + dkappa, self.fold[1]))

    def raised(self, dv: float) -> Self:
        return replace(self, lift=self.lift + dv)

    def moment(self, power: int = 1) -> float:
        """By the moments about `lift`, so that a curve far from v = 0 keeps its digits."""
        if self.lift == 0.0:
            return Curve.moment(self, power)
        level = replace(self, lift=0.0)
        own = [float(self.end[0] - self.start[0]), *(Curve.moment(level, i) for i in range(1, power + 1))]
        return sum(math.comb(power, i) * self.lift ** (power - i) * own[i] for i in range(power + 1))

    def on_radius(self, old: float, new: float) -> Self:
        scale = new / old
        if self.fold is None:
            return replace(self, radius=self.radius * scale, range=(self.range[0] * scale, self.range[1] * scale))
        return replace(self, radius=self.radius * scale, fold=(self.fold[0] * scale, self.fold[1] * scale))
