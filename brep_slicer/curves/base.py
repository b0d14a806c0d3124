"""What every curve of an unrolled section can do.

In: a subclass that knows its points and derivatives. Out: ends, integrals, length, bounds, samples.

A curve runs over s in [0, 1], with the material on its left. kappa and v are millimetres in the plane of a layer of
radius R; a curve lives in the universal cover (kappa is continuous and not reduced modulo 2 * pi * R).
"""

from __future__ import annotations

import abc
import enum
import functools
import math
from collections.abc import Callable
from typing import ClassVar, Self

import numpy as np

from brep_slicer.layers import Motion
from brep_slicer.maps import Array

# Gauss-Legendre panels are doubled until two results agree to this (relative to the curve's extent): quadrature noise.
QUADRATURE_AGREEMENT = 1e-14
PANEL_NODES = 20
# Sampling gives up refining after this many halvings: 2**20 spans would be a chord below float resolution.
MAXIMUM_HALVINGS = 20


class CurveKind(enum.Enum):
    """The kinds of an unrolled edge."""

    LINE = "line"
    ARC = "arc"
    SINUSOID = "sinusoid"
    QUADRIC = "quadric"
    SPLINE = "spline"


class Curve(abc.ABC):
    """A frozen curve (kappa(s), v(s)), s in [0, 1]; `face` is the index of the part's face that it comes from, or -1."""

    __slots__ = ()

    kind: ClassVar[CurveKind]
    face: int

    def __repr__(self) -> str:
        (k0, v0), (k1, v1) = self.start, self.end
        return (
            f"{type(self).__name__}({k0:.6g}, {v0:.6g} to {k1:.6g}, {v1:.6g} mm, {self.length():.5g} mm long, face {self.face})"
        )

    @abc.abstractmethod
    def points(self, s: Array) -> Array:
        """Points (kappa, v) in mm at parameters `s`, shape (n,); returns (n, 2)."""

    @abc.abstractmethod
    def derivatives(self, s: Array) -> Array:
        """d(kappa, v)/ds in mm at parameters `s`, shape (n,); returns (n, 2)."""

    def at(self, s: Array) -> tuple[Array, Array]:
        """Points and derivatives at parameters `s` (n,), (n, 2) each: what they have in common is computed once."""
        return self.points(s), self.derivatives(s)

    @abc.abstractmethod
    def reversed(self) -> Self:
        """The same points, run through the other way."""

    @abc.abstractmethod
    def trimmed(self, s0: float, s1: float) -> Curve:
        """The part from s0 to s1 (0 <= s0 < s1 <= 1), of the same kind."""

    @abc.abstractmethod
    def moved(self, motion: Motion) -> Self:
        """The copy that a closure's motion gives; of a curve whose kind is a cylinder's, by whole turns along kappa only."""

    @abc.abstractmethod
    def raised(self, dv: float) -> Self:
        """Moved by `dv` mm along v."""

    @abc.abstractmethod
    def on_radius(self, old: float, new: float) -> Self:
        """The curve of the same angles theta on a cylinder of radius `new`, drawn now on `old`: kappa *= new / old."""

    @property
    def joints(self) -> Array:
        """Parameters (n,) from 0 to 1 between which the curve and its pace are smooth."""
        return np.array([0.0, 1.0])

    @property
    def start(self) -> Array:
        """First point (kappa, v), shape (2,)."""
        return self.points(np.zeros(1))[0]

    @property
    def end(self) -> Array:
        """Last point (kappa, v), shape (2,)."""
        return self.points(np.ones(1))[0]

    def moment(self, power: int = 1) -> float:
        """Integral of v**power dkappa along the curve, in mm**(power + 1).

        The area of a region is minus the sum of moment(1) over its boundary with the material on the left (Green);
        its first moment along v is minus half the sum of moment(2).
        """
        return integrated(lambda p, d: p[:, 1] ** power * d[:, 0], self)

    def length(self) -> float:
        """Length in mm."""
        return integrated(lambda p, d: np.hypot(d[:, 0], d[:, 1]), self)

    def bounds(self) -> tuple[float, float, float, float]:
        """(kappa_min, v_min, kappa_max, v_max) in mm, by samples and one parabola step at each turning point."""
        s = np.linspace(0.0, 1.0, 65)
        p = self.points(s)
        low, high = p.min(axis=0), p.max(axis=0)
        for axis in (0, 1):
            for index in (int(p[:, axis].argmin()), int(p[:, axis].argmax())):
                root = _turning_point(self, axis, s[max(index - 1, 0)], s[min(index + 1, 64)])
                value = self.points(np.array([root]))[0, axis]
                low[axis], high[axis] = min(low[axis], value), max(high[axis], value)
        return float(low[0]), float(low[1]), float(high[0]), float(high[1])

    def parameters(self, chord: float) -> Array:
        """Increasing parameters from 0 to 1 whose polyline lies within `chord` (mm) of the curve, shape (n,)."""
        s = np.linspace(0.0, 1.0, 9)
        for _ in range(MAXIMUM_HALVINGS):
            coarse = far_spans(self, s[:-1], s[1:], chord)
            if not coarse.any():
                break
            s = np.sort(np.concatenate([s, 0.5 * (s[:-1] + s[1:])[coarse]]))
        return s

    def sample(self, chord: float) -> Array:
        """Points (n, 2) on the curve, both ends included, whose polyline lies within `chord` (mm) of it."""
        return self.points(self.parameters(chord))


def distance_to_curve(curve: Curve, points: Array) -> Array:
    """Distance (n,) in mm of points (n, 2) near a curve from it: Newton from the nearest of many samples."""
    s = np.linspace(0.0, 1.0, 513)
    samples = curve.points(s)
    nearest = np.hypot(*np.moveaxis(points[:, None] - samples[None], -1, 0)).argmin(axis=1)
    t, h = s[nearest], 1e-5
    for _ in range(20):
        p, d = curve.points(t), curve.derivatives(t)
        inner = np.clip(t, h, 1.0 - h)
        bend = (curve.derivatives(inner + h) - curve.derivatives(inner - h)) / (2.0 * h)
        square = np.maximum(np.einsum("ij,ij->i", d, d), 1e-300)
        slope = square - np.einsum("ij,ij->i", points - p, bend)
        step = np.einsum("ij,ij->i", points - p, d) / np.where(slope > 0.1 * square, slope, square)
        t = np.clip(t + step, 0.0, 1.0)
        if np.abs(step).max(initial=0.0) < 1e-12:
            break
    return np.hypot(*(points - curve.points(t)).T)


def far_spans(curve: Curve, a: Array, b: Array, chord: float) -> Array:
    """Which chords from parameters `a` to `b` (n,) lie farther than `chord` from the curve, at three places of each."""
    p, ends = curve.points(a), curve.points(b)
    along = ends - p
    norm = np.hypot(along[:, 0], along[:, 1])
    far = np.zeros(len(a), dtype=bool)
    for fraction in (0.25, 0.5, 0.75):
        q = curve.points(a + fraction * (b - a)) - p
        cross = np.abs(along[:, 0] * q[:, 1] - along[:, 1] * q[:, 0])
        # a degenerate span (both ends alike) is judged by the distance to its end
        off = np.where(norm > 0.0, cross / np.where(norm > 0.0, norm, 1.0), np.hypot(q[:, 0], q[:, 1]))
        far |= off > 0.9 * chord
    return far


@functools.cache
def _panel() -> tuple[Array, Array]:
    """Nodes on (-1, 1) and weights of one Gauss-Legendre panel."""
    return np.polynomial.legendre.leggauss(PANEL_NODES)


def integrated(integrand: Callable[[Array, Array], Array], curve: Curve) -> float:
    """The integral over s in [0, 1] of a function of points and derivatives (n, 2), by panels until two results agree."""
    nodes, weights = _panel()
    # a curve of several spans may change its pace from one to the next
    joints = curve.joints
    previous, panels = np.inf, 1
    total, scale = 0.0, 1.0
    while panels <= 1024:
        half = np.repeat(0.5 * np.diff(joints) / panels, panels)
        edges = np.repeat(joints[:-1], panels) + 2.0 * half * np.tile(np.arange(panels), len(joints) - 1)
        s = (edges[:, None] + half[:, None] * (1.0 + nodes[None, :])).ravel()
        values = integrand(*curve.at(s)) * (half[:, None] * weights[None, :]).ravel()
        total, scale = float(values.sum()), float(np.abs(values).sum())
        if abs(total - previous) <= QUADRATURE_AGREEMENT * max(scale, 1e-300) * 10.0:
            break
        previous, panels = total, 2 * panels
    return total


def _turning_point(curve: Curve, axis: int, a: float, b: float) -> float:
    """Root of the derivative along `axis` in [a, b] where it changes sign; the midpoint where it does not."""
    ends = curve.derivatives(np.array([a, b]))[:, axis]
    if ends[0] * ends[1] >= 0.0:
        return 0.5 * (a + b)
    from scipy.optimize import brentq

    return float(brentq(lambda s: curve.derivatives(np.array([s]))[0, axis], a, b, xtol=1e-14))


def frozen_array(values, *, name: str, shape: tuple[int, ...] | None = None) -> Array:
    """A read-only float copy of `values`, checked for finiteness and, if given, for its shape."""
    array = np.array(values, dtype=np.float64)
    if shape is not None and array.shape != shape:
        raise ValueError(f"{name} must have shape {shape}, got {array.shape}")
    # a sum is finite only if every term is (or the curve reaches to 1e308 mm): one pass, and this is called for every curve
    if not math.isfinite(float(array.sum())):
        raise ValueError(f"{name} holds a value that is not finite")
    array.flags.writeable = False
    return array
