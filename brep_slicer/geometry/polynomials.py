"""Rational B-splines as Bezier spans, evaluated over whole arrays.

In: knots, poles, weights. Out: breaks and control points of each span, values and derivatives at many parameters.

Words: *span*, an interval between two different knots; *local coordinate*, 0 to 1 over a span; *homogeneous*, poles
multiplied by their weights with the weight as last component.
"""

from __future__ import annotations

import functools

import numpy as np

from brep_slicer.maps import Array


def bezier_spans(knots: Array, poles: Array, degree: int) -> tuple[Array, Array]:
    """Breaks (m + 1,) and the Bezier control points (m, degree + 1, ...) of each span of a B-spline.

    `knots` is the full clamped vector (poles + degree + 1), `poles` (n, ...). Control point i of the span [a, b] is the
    blossom at (a repeated degree - i times, b repeated i times), by de Boor's recurrence on all spans at once; unlike power
    coefficients, it is a convex combination and loses no digits at any degree.
    """
    poles = np.asarray(poles, dtype=np.float64)
    breaks = np.unique(knots[degree : len(knots) - degree])
    if len(poles) == degree * (len(breaks) - 1) + 1:
        # every knot is as multiple as it can be: the poles are the control points
        return breaks, poles[degree * np.arange(len(breaks) - 1)[:, None] + np.arange(degree + 1)]
    last = np.searchsorted(knots, breaks[:-1], side="right") - 1
    # d: (span, control point, local pole, ...)
    local = poles[last[:, None] - degree + np.arange(degree + 1)]
    d = np.repeat(local[:, None], degree + 1, axis=1)
    number = np.arange(degree + 1)
    extra = (1,) * (poles.ndim - 1)
    for r in range(1, degree + 1):
        # the r-th argument of control point i is b for the first i arguments, then a
        argument = np.where(number[None, :] >= r, breaks[1:, None], breaks[:-1, None])
        i = last[:, None] - degree + np.arange(r, degree + 1)
        low, high = knots[i], knots[i + degree + 1 - r]
        share = (argument[:, :, None] - low[:, None]) / (high - low)[:, None]
        share = share.reshape(*share.shape, *extra)
        d = (1.0 - share) * d[:, :, :-1] + share * d[:, :, 1:]
    return breaks, np.ascontiguousarray(d[:, :, 0])


def spans_of(breaks: Array, x: Array) -> tuple[Array, Array, Array]:
    """Span index, local coordinate and span width of each parameter (clamped to the first or last span)."""
    span = np.clip(np.searchsorted(breaks, x, side="right") - 1, 0, len(breaks) - 2)
    width = breaks[span + 1] - breaks[span]
    return span, (x - breaks[span]) / width, width


class SpanTable:
    """Spans of several B-splines together: for numbers `which` of splines and parameters x, the spans that hold them."""

    def __init__(self, breaks: list[Array]) -> None:
        self.count = np.array([len(b) - 1 for b in breaks])
        self.last = np.cumsum(self.count) - 1
        self.first = self.last - self.count + 1
        self.begin = np.concatenate([b[:-1] for b in breaks])
        self.width = np.concatenate([np.diff(b) for b in breaks])
        self.low = np.array([b[0] for b in breaks])
        self.range = np.array([b[-1] - b[0] for b in breaks])
        # increasing over all splines: 2 for each spline before, and how far along its own the span begins
        owner = np.repeat(np.arange(len(breaks)), self.count)
        self.keys = 2.0 * owner + (self.begin - self.low[owner]) / self.range[owner]

    def find(self, which: Array, x: Array) -> tuple[Array, Array, Array]:
        """Number of the span among all, local coordinate, width."""
        key = 2.0 * which + np.clip((x - self.low[which]) / self.range[which], 0.0, 1.0)
        span = np.clip(np.searchsorted(self.keys, key, side="right") - 1, self.first[which], self.last[which])
        width = self.width[span]
        return span, (x - self.begin[span]) / width, width


def bernstein(x: Array, degree: int, derivative: int) -> Array:
    """d^k/dx^k of the Bernstein polynomials of `degree` at x (n,), shape (n, degree + 1), k <= 2."""
    if derivative > degree:
        return np.zeros((len(x), degree + 1))
    lower = degree - derivative
    values = _powers(x, lower) * _powers(1.0 - x, lower)[:, ::-1] * _binomials(lower)
    for k in range(derivative):
        wide = np.zeros((len(x), values.shape[1] + 1))
        wide[:, 1:] = values
        wide[:, :-1] -= values
        values = wide * (lower + 1 + k)
    return values


def _powers(x: Array, highest: int) -> Array:
    """1, x, x**2, ... of each x (n,), shape (n, highest + 1), by products: faster than powers, and as exact."""
    factors = np.ones((len(x), highest + 1))
    factors[:, 1:] = x[:, None]
    return np.multiply.accumulate(factors, axis=1)


def bernstein_with_slope(x: Array, degree: int) -> tuple[Array, Array]:
    """The Bernstein polynomials of `degree` at x (n,) and their derivatives, each (n, degree + 1), for the price of one."""
    if degree == 0:
        return np.ones((len(x), 1)), np.zeros((len(x), 1))
    lower = bernstein(x, degree - 1, 0)
    slope, values = np.zeros((len(x), degree + 1)), np.zeros((len(x), degree + 1))
    slope[:, 1:] = lower
    slope[:, :-1] -= lower
    slope *= degree
    rising = x[:, None] * lower
    values[:, 1:] = rising
    values[:, :-1] += lower - rising
    return values, slope


def bernstein_product(a: Array, b: Array) -> Array:
    """Bernstein coefficients (n, p + r + 1, q + s + 1) of the products of a (n, p + 1, q + 1) and b (n, r + 1, s + 1).

    C(p + r, k) c_k = sum over i + j = k of C(p, i) a_i C(r, j) b_j, along both parameters.
    """
    if a.shape[1] * a.shape[2] > b.shape[1] * b.shape[2]:
        a, b = b, a
    (p, q), (r, s) = ((x.shape[1] - 1, x.shape[2] - 1) for x in (a, b))
    a, b = (x * np.outer(_binomials(x.shape[1] - 1), _binomials(x.shape[2] - 1)) for x in (a, b))
    out = np.zeros((*np.broadcast_shapes(a.shape[:1], b.shape[:1]), p + r + 1, q + s + 1))
    for i in range(p + 1):
        for j in range(q + 1):
            out[:, i : i + r + 1, j : j + s + 1] += a[:, i, j, None, None] * b
    return out / np.outer(_binomials(p + r), _binomials(q + s))


@functools.cache
def _binomials(degree: int) -> Array:
    row = [1.0]
    for k in range(degree):
        row.append(row[-1] * (degree - k) / (k + 1))
    return np.array(row)


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
