"""Rational B-splines as local polynomials, evaluated over whole arrays.

In: knots, poles, weights. Out: breaks and local power coefficients, and their values and derivatives at many parameters.

Words: *span*, an interval between two different knots; *local coordinate*, 0 to 1 over a span; *homogeneous*, poles
multiplied by their weights with the weight as last component.
"""

from __future__ import annotations

import numpy as np
from scipy.interpolate import BSpline

from brep_slicer.maps import Array


def local_coefficients(knots: Array, poles: Array, degree: int) -> tuple[Array, Array]:
    """Breaks (m + 1,) and power coefficients (m, degree + 1, ...) in the local coordinate of each span, constant first.

    `knots` is the full clamped vector (poles + degree + 1), `poles` (n, ...).
    """
    spline = BSpline(knots, np.ascontiguousarray(poles, dtype=np.float64), degree)
    breaks = np.unique(knots[degree : len(knots) - degree])
    width = np.diff(breaks).reshape((-1,) + (1,) * (poles.ndim - 1))
    rows, factor = [], 1.0
    for k in range(degree + 1):
        # Taylor coefficients at the left end of each span, in the local coordinate
        rows.append(spline(breaks[:-1], nu=k) * width**k / factor)
        factor *= k + 1
    return breaks, np.ascontiguousarray(np.stack(rows, axis=1))


def spans_of(breaks: Array, x: Array) -> tuple[Array, Array, Array]:
    """Span index, local coordinate and span width of each parameter (clamped to the first or last span)."""
    span = np.clip(np.searchsorted(breaks, x, side="right") - 1, 0, len(breaks) - 2)
    width = breaks[span + 1] - breaks[span]
    return span, (x - breaks[span]) / width, width


def powers(x: Array, degree: int, derivative: int) -> Array:
    """d^k/dx^k of x**0 ... x**degree, shape (len(x), degree + 1)."""
    out = np.zeros((len(x), degree + 1))
    value = np.ones_like(x)
    for exponent in range(derivative, degree + 1):
        factor = 1.0
        for k in range(derivative):
            factor *= exponent - k
        out[:, exponent] = factor * value
        value = value * x
    return out


def projected(values: list[Array]) -> list[Array]:
    """Cartesian value and derivatives from homogeneous ones [H, H', H''], each (n, d + 1) (quotient rule)."""
    w = [v[:, -1:] for v in values]
    out = [values[0][:, :-1] / w[0]]
    if len(values) > 1:
        out.append((values[1][:, :-1] - w[1] * out[0]) / w[0])
    if len(values) > 2:
        out.append((values[2][:, :-1] - 2.0 * w[1] * out[1] - w[2] * out[0]) / w[0])
    return out


def wrapped(x: Array, breaks: Array, period: float) -> Array:
    """Parameters brought into the range of `breaks` where a period is given; left alone otherwise."""
    if not period:
        return x
    inside = (x >= breaks[0]) & (x <= breaks[-1])
    return np.where(inside, x, breaks[0] + np.mod(x - breaks[0], period))


def breaks_between(breaks: Array, period: float, first: float, last: float) -> Array:
    """first, every break (and its periodic copies) strictly between, last."""
    if period:
        turns = np.arange(np.floor((first - breaks[-1]) / period), np.ceil((last - breaks[0]) / period) + 1)
        breaks = np.unique((breaks[None, :-1] + period * turns[:, None]).ravel())
    slack = 1e-12 * max(1.0, abs(first), abs(last))
    inner = breaks[(breaks > first + slack) & (breaks < last - slack)]
    return np.concatenate([[first], inner, [last]])
