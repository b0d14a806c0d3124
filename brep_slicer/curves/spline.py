"""Everything without a closed form: a chain of Bezier spans through points that lie on face and cylinder.

In: Bernstein coefficients and breaks, or nodes at Chebyshev parameters of each span. Out: a Curve.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from brep_slicer.layers import Motion
from brep_slicer.maps import Array

from .base import Curve, CurveKind, frozen_array
from .line import LineCurve


@dataclass(frozen=True, slots=True, kw_only=True, eq=False, repr=False)
class SplineCurve(Curve):
    """Bezier spans of one degree: `coefficients` (m, n + 1, 2) in mm, `breaks` (m + 1,) from 0 to 1.

    `residual` (mm) is the largest distance of the curve from the geometry it stands for, as measured when it was made.
    """

    kind: ClassVar[CurveKind] = CurveKind.SPLINE

    coefficients: Array
    breaks: Array
    residual: float = 0.0
    face: int = -1

    def __post_init__(self) -> None:
        coefficients = frozen_array(self.coefficients, name="coefficients")
        if coefficients.ndim != 3 or coefficients.shape[2] != 2:
            raise ValueError(f"coefficients must have shape (spans, degree + 1, 2), got {coefficients.shape}")
        object.__setattr__(self, "coefficients", coefficients)
        breaks = frozen_array(self.breaks, name="breaks", shape=(len(coefficients) + 1,))
        object.__setattr__(self, "breaks", breaks)

    @property
    def joints(self) -> Array:
        return self.breaks

    @property
    def start(self) -> Array:
        return self.coefficients[0, 0]

    @property
    def end(self) -> Array:
        return self.coefficients[-1, -1]

    def _spans(self, s: Array) -> tuple[Array, Array, Array]:
        s = np.asarray(s, dtype=np.float64)
        span = np.clip(np.searchsorted(self.breaks, s, side="right") - 1, 0, len(self.coefficients) - 1)
        width = self.breaks[span + 1] - self.breaks[span]
        return span, (s - self.breaks[span]) / width, width

    def points(self, s: Array) -> Array:
        span, x, _ = self._spans(s)
        basis = bernstein_basis(self.coefficients.shape[1] - 1, x)
        return np.einsum("ij,ijk->ik", basis, self.coefficients[span])

    def derivatives(self, s: Array) -> Array:
        span, x, width = self._spans(s)
        degree = self.coefficients.shape[1] - 1
        slope = degree * np.diff(self.coefficients[span], axis=1)
        return np.einsum("ij,ijk->ik", bernstein_basis(degree - 1, x), slope) / width[:, None]

    def reversed(self) -> Self:
        return type(self)(
            coefficients=self.coefficients[::-1, ::-1],
            breaks=1.0 - self.breaks[::-1],
            residual=self.residual,
            face=self.face,
        )

    def trimmed(self, s0: float, s1: float) -> SplineCurve:
        inner = self.breaks[(self.breaks > s0) & (self.breaks < s1)]
        breaks = np.concatenate([[s0], inner, [s1]])
        span, _, _ = self._spans(0.5 * (breaks[:-1] + breaks[1:]))
        low, width = self.breaks[span], np.diff(self.breaks)[span]
        a, b = (breaks[:-1] - low) / width, (breaks[1:] - low) / width
        degree = self.coefficients.shape[1] - 1
        x = a[:, None] + (b - a)[:, None] * np.linspace(0.0, 1.0, degree + 1)[None, :]
        basis = bernstein_basis(degree, x.ravel()).reshape(len(span), degree + 1, degree + 1)
        nodes = np.einsum("mij,mjk->mik", basis, self.coefficients[span])
        to_bernstein = np.linalg.inv(bernstein_basis(degree, np.linspace(0.0, 1.0, degree + 1)))
        coefficients = np.einsum("ij,mjk->mik", to_bernstein, nodes)
        coefficients[:, 0], coefficients[:, -1] = nodes[:, 0], nodes[:, -1]
        return SplineCurve(coefficients=coefficients, breaks=(breaks - s0) / (s1 - s0), residual=self.residual, face=self.face)

    def moved(self, motion: Motion) -> Self:
        return self._of(motion.points(self.coefficients))

    def raised(self, dv: float) -> Self:
        return self._of(self.coefficients + np.array([0.0, dv]))

    def on_radius(self, old: float, new: float) -> Self:
        return self._of(self.coefficients * np.array([new / old, 1.0]))

    def _of(self, coefficients: Array) -> Self:
        return type(self)(coefficients=coefficients, breaks=self.breaks, residual=self.residual, face=self.face)

    def moment(self, power: int = 1) -> float:
        """Exact for the polynomial spans: Gauss-Legendre with enough nodes for the product's degree."""
        degree = self.coefficients.shape[1] - 1
        basis, slope, weights = _gauss_basis(degree, ((power + 1) * degree) // 2 + 1)
        v = self.coefficients[:, :, 1] @ basis.T
        dkappa = np.diff(self.coefficients[:, :, 0], axis=1) @ slope.T
        return float(np.sum(v**power * dkappa * weights))

    def length(self) -> float:
        """Gauss-Legendre with 20 nodes a span: spans are short and smooth, the error is rounding."""
        degree = self.coefficients.shape[1] - 1
        _, slope, weights = _gauss_basis(degree, 20)
        d = np.einsum("gk,mkd->mgd", slope, np.diff(self.coefficients, axis=1))
        return float(np.sum(np.hypot(d[..., 0], d[..., 1]) * weights))

    def bounds(self) -> tuple[float, float, float, float]:
        """Of the control points: they enclose the curve, and touch it closely on short spans."""
        flat = self.coefficients.reshape(-1, 2)
        low, high = flat.min(axis=0), flat.max(axis=0)
        return float(low[0]), float(low[1]), float(high[0]), float(high[1])

    def parameters(self, chord: float) -> Array:
        """Every span is cut evenly so that the second differences of its control points prove the chord.

        A Bezier span of degree n with |second derivative| <= n (n - 1) D, D the largest second difference of its control
        points, cut into k equal parts lies within n (n - 1) D / (8 k**2) of its chords.
        """
        degree = self.coefficients.shape[1] - 1
        if degree < 2:
            return np.array(self.breaks)
        second = np.diff(self.coefficients, n=2, axis=1)
        bound = degree * (degree - 1) * np.hypot(second[..., 0], second[..., 1]).max(axis=1)
        cuts = np.maximum(1, np.ceil(np.sqrt(bound / (8.0 * chord)))).astype(int)
        first = np.repeat(self.breaks[:-1], cuts)
        width = np.repeat(np.diff(self.breaks) / cuts, cuts)
        index = np.arange(cuts.sum()) - np.repeat(np.cumsum(cuts) - cuts, cuts)
        return np.append(first + index * width, 1.0)


def spline_through_nodes(nodes: Array, breaks: Array, *, residual: float = 0.0, face: int = -1) -> SplineCurve:
    """Interpolate each span's nodes, (m, n + 1, 2), given at the parameters `span_nodes(n)` of the span.

    The first and last node of a span are its ends; the spans are joined exactly there.
    """
    degree = nodes.shape[1] - 1
    coefficients = np.einsum("ij,mjk->mik", _bernstein_from_nodes(degree), nodes)
    coefficients[:, 0], coefficients[:, -1] = nodes[:, 0], nodes[:, -1]
    return SplineCurve(coefficients=coefficients, breaks=breaks, residual=residual, face=face)


def curves_through_nodes(nodes: Array, residual: Array, face: Array, tolerance: float) -> list[Curve]:
    """One curve of a single span through each set of nodes (n, degree + 1, 2): a straight line where it is one.

    As `spline_through_nodes` and `straightened` make them one by one; `residual` and `face` (n,).
    """
    coefficients = np.einsum("ij,mjk->mik", _bernstein_from_nodes(nodes.shape[1] - 1), nodes)
    coefficients[:, 0], coefficients[:, -1] = nodes[:, 0], nodes[:, -1]
    straight = _are_straight(coefficients, tolerance)
    breaks = np.array([0.0, 1.0])
    return [
        LineCurve(p0=p[0], p1=p[-1], face=number)
        if line
        else SplineCurve(coefficients=p[None], breaks=breaks, residual=error, face=number)
        for p, line, error, number in zip(coefficients, straight.tolist(), residual.tolist(), face.tolist(), strict=True)
    ]


def _are_straight(p: Array, tolerance: float) -> Array:
    """Whether control points (n, m, 2) lie on their chord within `tolerance` (mm) and run forwards along it."""
    along = p[:, -1] - p[:, 0]
    size = np.hypot(along[:, 0], along[:, 1])
    from_start = p - p[:, :1]
    cross = along[:, None, 0] * from_start[..., 1] - along[:, None, 1] * from_start[..., 0]
    off = np.abs(cross).max(axis=1) / np.maximum(size, 1e-300)
    forwards = (np.diff(np.einsum("nmk,nk->nm", p, along), axis=1) >= -tolerance * size[:, None]).all(axis=1)
    return (size > tolerance) & (off <= tolerance) & forwards


def straightened(curve: SplineCurve, tolerance: float) -> Curve:
    """The straight line that a spline is, if its control points lie on one within `tolerance` (mm) and run forwards."""
    p = curve.coefficients.reshape(1, -1, 2)
    return LineCurve(p0=p[0, 0], p1=p[0, -1], face=curve.face) if _are_straight(p, tolerance)[0] else curve


def span_nodes(degree: int) -> Array:
    """Chebyshev-Lobatto parameters in [0, 1], both ends included, shape (degree + 1,)."""
    return 0.5 * (1.0 - np.cos(np.pi * np.arange(degree + 1) / degree))


def bernstein_basis(degree: int, x: Array) -> Array:
    """Bernstein polynomials of `degree` at `x`, shape (len(x), degree + 1)."""
    x = np.asarray(x, dtype=np.float64)[:, None]
    k = np.arange(degree + 1)[None, :]
    return _binomials(degree)[None, :] * x**k * (1.0 - x) ** (degree - k)


@functools.cache
def _binomials(degree: int) -> Array:
    row = [1.0]
    for k in range(degree):
        row.append(row[-1] * (degree - k) / (k + 1))
    return np.array(row)


@functools.cache
def _bernstein_from_nodes(degree: int) -> Array:
    return np.linalg.inv(bernstein_basis(degree, span_nodes(degree)))


@functools.cache
def _gauss_basis(degree: int, count: int) -> tuple[Array, Array, Array]:
    x, weights = np.polynomial.legendre.leggauss(count)
    x, weights = 0.5 * (x + 1.0), 0.5 * weights
    return bernstein_basis(degree, x), degree * bernstein_basis(degree - 1, x), weights
