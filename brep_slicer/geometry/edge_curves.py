"""Curves of edges, in space (d = 3) or in a face's parameters (d = 2), evaluated over whole arrays.

In: what the kernel stores. Out: points (n, d) and derivatives with respect to the edge's own parameter.
"""

from __future__ import annotations

import abc
from dataclasses import dataclass, field

import numpy as np

from brep_slicer.maps import Array

from .polynomials import SpanTable, bernstein, bernstein_with_slope, bezier_spans, breaks_between, projected, spans_of, wrapped


class EdgeCurve(abc.ABC):
    """A curve with its own parameter t."""

    __slots__ = ()

    @abc.abstractmethod
    def derivatives(self, t: Array, order: int) -> list[Array]:
        """[P, P', ..., up to `order` <= 2] at t, each (n, d)."""

    def points(self, t: Array) -> Array:
        """Points (n, d) at t (n,)."""
        return self.derivatives(np.asarray(t, dtype=np.float64), 0)[0]

    @abc.abstractmethod
    def breaks(self, first: float, last: float) -> Array:
        """Parameters from first to last between which the curve is smooth and turns by no more than a quarter."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LineEdge(EdgeCurve):
    """origin + t * direction, each (d,)."""

    origin: Array
    direction: Array

    def derivatives(self, t: Array, order: int) -> list[Array]:
        flat = np.zeros((len(t), len(self.origin)))
        out = [self.origin + np.asarray(t)[:, None] * self.direction, flat + self.direction, flat]
        return out[: order + 1]

    def breaks(self, first: float, last: float) -> Array:
        return np.array([first, last])


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ConicEdge(EdgeCurve):
    """Circles and ellipses: centre + x cos t + y sin t, with the radii multiplied into x and y, each (d,)."""

    centre: Array
    x: Array
    y: Array

    def derivatives(self, t: Array, order: int) -> list[Array]:
        cos, sin = np.cos(t)[:, None], np.sin(t)[:, None]
        turned = cos * self.x + sin * self.y
        return [self.centre + turned, cos * self.y - sin * self.x, -turned][: order + 1]

    def breaks(self, first: float, last: float) -> Array:
        return np.linspace(first, last, max(1, int(np.ceil((last - first) / (0.5 * np.pi) - 1e-9))) + 1)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BSplineEdge(EdgeCurve):
    """A B-spline: full clamped `knots`, `poles` (n, d), `weights` (n,) or None; `period` 0 unless it goes on periodically."""

    degree: int
    knots: Array
    poles: Array
    weights: Array | None
    period: float = 0.0
    _breaks: Array = field(init=False)
    _coefficients: Array = field(init=False)

    def __post_init__(self) -> None:
        poles = self.poles
        if self.weights is not None:
            poles = np.concatenate([poles * self.weights[:, None], self.weights[:, None]], axis=1)
        breaks, coefficients = bezier_spans(self.knots, poles, self.degree)
        object.__setattr__(self, "_breaks", breaks)
        object.__setattr__(self, "_coefficients", coefficients)

    def derivatives(self, t: Array, order: int) -> list[Array]:
        t = wrapped(np.asarray(t, dtype=np.float64), self._breaks, self.period)
        span, x, width = spans_of(self._breaks, t)
        local = self._coefficients[span]
        if order == 1 and self.weights is None:
            both = np.matmul(np.stack(bernstein_with_slope(x, self.degree), axis=1), local)
            return [both[:, 0], both[:, 1] / width[:, None]]
        values = []
        for k in range(order + 1):
            value = np.einsum("ni,nid->nd", bernstein(x, self.degree, k), local)
            values.append(value / (width**k)[:, None])
        return projected(values) if self.weights is not None else values

    def breaks(self, first: float, last: float) -> Array:
        return breaks_between(self._breaks, self.period, first, last)


class ConicPack:
    """Several circles and ellipses, evaluated together: a point's curve is said by its number `which`."""

    def __init__(self, curves: list[ConicEdge]) -> None:
        self.centre, self.x, self.y = (np.stack([getattr(c, name) for c in curves]) for name in ("centre", "x", "y"))

    def derivatives(self, which: Array, t: Array, order: int) -> list[Array]:
        """[P, P', P''] as `EdgeCurve.derivatives` has them, to an `order`."""
        curves = ConicEdge(centre=self.centre[which], x=self.x[which], y=self.y[which])
        return curves.derivatives(t, order)


class BSplinePack:
    """Several polynomial B-splines of one degree, evaluated together: a point's curve is said by its number `which`."""

    def __init__(self, curves: list[BSplineEdge]) -> None:
        self.degree = curves[0].degree
        self.spans = SpanTable([c._breaks for c in curves])
        self.coefficients = np.concatenate([c._coefficients for c in curves])

    @staticmethod
    def takes(curve: EdgeCurve) -> bool:
        """Whether a curve may be packed."""
        return isinstance(curve, BSplineEdge) and curve.weights is None and not curve.period

    def derivatives(self, which: Array, t: Array, order: int) -> list[Array]:
        """[P, P'] as `EdgeCurve.derivatives` has them, `order` 0 or 1."""
        span, x, width = self.spans.find(which, t)
        local = self.coefficients[span]
        if order == 0:
            return [np.einsum("ni,nid->nd", bernstein(x, self.degree, 0), local)]
        values, slopes = bernstein_with_slope(x, self.degree)
        both = np.matmul(np.stack([values, slopes], axis=1), local)
        return [both[:, 0], both[:, 1] / width[:, None]]
