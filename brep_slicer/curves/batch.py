"""Many curves asked at once: points and derivatives of any of them, a numpy pass a kind instead of a call a curve.

In: curves; numbers of curves and parameters on them. Out: points (kappa, v) and d(kappa, v)/ds.

The formulas are those of the curves' own modules; here each parameter of a kind is a column, a row a curve.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from brep_slicer.maps import Array

from .base import Curve
from .line import LineCurve
from .quadric import QuadricCurve
from .sinusoid import SinusoidCurve
from .spline import SplineCurve, bernstein_basis

# Places on curves: which curve of a kind (n,) and where on it (n,) in, points and derivatives (n, 2) out.
Evaluate = Callable[[Array, Array], tuple[Array, Array]]


class CurveBatch:
    """`curves` by number, of whatever kinds."""

    def __init__(self, curves: Sequence[Curve]) -> None:
        self.curves = list(curves)
        groups: dict[object, list[int]] = {}
        for number, curve in enumerate(self.curves):
            groups.setdefault(_group_of(curve), []).append(number)
        self._group = np.empty(len(self.curves), dtype=int)
        self._row = np.empty(len(self.curves), dtype=int)
        self._evaluate: list[Evaluate] = []
        for index, numbers in enumerate(groups.values()):
            self._group[numbers] = index
            self._row[numbers] = np.arange(len(numbers))
            self._evaluate.append(_evaluator([self.curves[i] for i in numbers]))

    def __len__(self) -> int:
        return len(self.curves)

    def at(self, numbers: Array, s: Array) -> tuple[Array, Array]:
        """Points and derivatives by s, (n, 2) each, of the curves `numbers` (n,) at their parameters `s` (n,)."""
        group, row = self._group[numbers], self._row[numbers]
        if len(self._evaluate) == 1:
            return self._evaluate[0](row, s)
        points, derivatives = np.empty((len(s), 2)), np.empty((len(s), 2))
        for index, evaluate in enumerate(self._evaluate):
            rows = np.flatnonzero(group == index)
            if len(rows):
                points[rows], derivatives[rows] = evaluate(row[rows], s[rows])
        return points, derivatives


def _group_of(curve: Curve) -> object:
    """Curves that one evaluator serves; a kind that has none is evaluated curve by curve."""
    if isinstance(curve, SplineCurve):
        return SplineCurve, curve.coefficients.shape[1]
    if isinstance(curve, QuadricCurve):
        return QuadricCurve, curve.fold is None
    return type(curve)


def _evaluator(curves: list[Curve]) -> Evaluate:
    if all(isinstance(c, LineCurve) for c in curves):
        return _lines([c for c in curves if isinstance(c, LineCurve)])
    if all(isinstance(c, SinusoidCurve) for c in curves):
        return _sinusoids([c for c in curves if isinstance(c, SinusoidCurve)])
    if all(isinstance(c, SplineCurve) for c in curves):
        return _splines([c for c in curves if isinstance(c, SplineCurve)])
    if all(isinstance(c, QuadricCurve) and c.fold is None for c in curves):
        return _quadrics([c for c in curves if isinstance(c, QuadricCurve)])
    return _one_by_one(curves)


def _lines(curves: list[LineCurve]) -> Evaluate:
    p0 = np.array([c.p0 for c in curves])
    along = np.array([c.p1 for c in curves]) - p0
    return lambda row, s: (p0[row] + s[:, None] * along[row], along[row])


def _sinusoids(curves: list[SinusoidCurve]) -> Evaluate:
    a0, a1, a2 = np.array([c.coefficients for c in curves]).T
    low, high = np.array([c.range for c in curves]).T
    radius = np.array([c.radius for c in curves])

    def evaluate(row: Array, s: Array) -> tuple[Array, Array]:
        kappa = (1.0 - s) * low[row] + s * high[row]
        theta = kappa / radius[row]
        cos, sin, span = np.cos(theta), np.sin(theta), high[row] - low[row]
        slope = (a2[row] * cos - a1[row] * sin) / radius[row]
        points = np.stack([kappa, a0[row] + a1[row] * cos + a2[row] * sin], axis=-1)
        return points, np.stack([span, span * slope], axis=-1)

    return evaluate


def _splines(curves: list[SplineCurve]) -> Evaluate:
    """All spans in one table; curve i has its parameters from 2 i to 2 i + 1 there."""
    coefficients = np.concatenate([c.coefficients for c in curves])
    degree = coefficients.shape[1] - 1
    slopes = degree * np.diff(coefficients, axis=1)
    counts = np.array([len(c.coefficients) for c in curves])
    first = np.cumsum(counts) - counts
    starts = np.concatenate([c.breaks[:-1] + 2.0 * i for i, c in enumerate(curves)])
    low = np.concatenate([c.breaks[:-1] for c in curves])
    width = np.concatenate([np.diff(c.breaks) for c in curves])

    def evaluate(row: Array, s: Array) -> tuple[Array, Array]:
        span = np.searchsorted(starts, s + 2.0 * row, side="right") - 1
        span = np.clip(span, first[row], first[row] + counts[row] - 1)
        x = (s - low[span]) / width[span]
        points = np.einsum("ij,ijk->ik", bernstein_basis(degree, x), coefficients[span])
        along = np.einsum("ij,ijk->ik", bernstein_basis(degree - 1, x), slopes[span])
        return points, along / width[span][:, None]

    return evaluate


def _quadrics(curves: list[QuadricCurve]) -> Evaluate:
    """Roots v of a v**2 + 2 b v + c = 0 without a fold, linear ones (a = 0) among them."""
    a, radius, branch = (np.array(x, dtype=float) for x in zip(*((c.a, c.radius, c.branch) for c in curves), strict=True))
    low, high = np.array([c.range for c in curves]).T
    bs, cs = np.array([c.b for c in curves]), np.array([c.c for c in curves])
    lift = np.array([c.lift for c in curves])

    def evaluate(row: Array, s: Array) -> tuple[Array, Array]:
        kappa = (1.0 - s) * low[row] + s * high[row]
        theta = kappa / radius[row]
        once, twice = np.stack([np.cos(theta), np.sin(theta)]), np.stack([np.cos(2.0 * theta), np.sin(2.0 * theta)])
        (b0, b1, b2), (c0, c1, c2, c3, c4) = bs[row].T, cs[row].T
        b = b0 + b1 * once[0] + b2 * once[1]
        c = c0 + c1 * once[0] + c2 * once[1] + c3 * twice[0] + c4 * twice[1]
        linear = a[row] == 0.0
        root = np.sqrt(np.maximum(b * b - a[row] * c, 0.0))
        v = np.where(linear, -0.5 * c / np.where(linear, b, 1.0), (branch[row] * root - b) / np.where(linear, 1.0, a[row]))
        db = -b1 * once[1] + b2 * once[0]
        dc = -c1 * once[1] + c2 * once[0] - 2.0 * c3 * twice[1] + 2.0 * c4 * twice[0]
        across, along = 2.0 * (a[row] * v + b), -(2.0 * v * db + dc) / radius[row]
        # at the end of its range a curve may be upright: steep beyond measure, but a number
        slope = along / np.where(across == 0.0, 1e-100, across)
        span = high[row] - low[row]
        return np.stack([kappa, v + lift[row]], axis=-1), np.stack([span, span * slope], axis=-1)

    return evaluate


def _one_by_one(curves: list[Curve]) -> Evaluate:
    def evaluate(row: Array, s: Array) -> tuple[Array, Array]:
        points, derivatives = np.empty((len(s), 2)), np.empty((len(s), 2))
        for i in np.unique(row).tolist():
            rows = np.flatnonzero(row == i)
            points[rows], derivatives[rows] = curves[i].points(s[rows]), curves[i].derivatives(s[rows])
        return points, derivatives

    return evaluate
