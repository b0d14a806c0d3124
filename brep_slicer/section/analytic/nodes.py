"""Where the edges of a solid cross the layers, all edges and all radii.

In: edges cut into monotone stretches, radii. Out: Nodes, one for each stretch and layer that cross.

Words: *node*, such a crossing; its identity is (stretch, layer), so the two faces of the edge share it without any tolerance;
*rising*, rho grows there along the edge's own parameter.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from brep_slicer.field import SNAP, EdgeStretches
from brep_slicer.geometry import Brep
from brep_slicer.geometry.edge_curves import BSplinePack, EdgeCurve, LineEdge
from brep_slicer.layers import CYLINDERS, LayerFamily
from brep_slicer.maps import Array

MOST_STEPS = 60
# Relative rounding of a B-spline's point and of the sum of two squares, a few units in the last place.
ROUNDING = 2e-15
# A B-spline of high degree rounds more coarsely: below this share of R**2, a step that no longer helps is the last.
STALLED = 1e-14
Evaluate = Callable[[Array, int], list[Array]]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Nodes:
    """Arrays (n,) or (n, 3) over all nodes, sorted by edge: `layer`, `edge`, `t` on the edge, `points` in the axis frame.

    `span` (n, 2) are the ends of each node's stretch on its edge; `first` (edges + 1,) says where each edge's nodes begin.
    """

    layer: NDArray[np.int64]
    edge: NDArray[np.int64]
    t: Array
    span: Array
    points: Array
    rising: NDArray[np.bool_]
    first: NDArray[np.int64]

    def of_edge(self, edge: int) -> slice:
        """The nodes of one edge."""
        return slice(int(self.first[edge]), int(self.first[edge + 1]))


def find_nodes(brep: Brep, stretches: EdgeStretches, radii: Array, family: LayerFamily = CYLINDERS) -> Nodes:
    """Cross every stretch with every radius in its range (`radii` increasing, mm).

    A layer at R counts a point as above it if its effective radius is larger than R + SNAP: the one-sided limit from outside.
    """
    low, high = stretches.rho.min(axis=1), stretches.rho.max(axis=1)
    begin = np.searchsorted(radii, low - SNAP, side="left")
    end = np.searchsorted(radii, high - SNAP, side="left")
    count = np.maximum(end - begin, 0)
    stretch = np.repeat(np.arange(len(low)), count)
    layer = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count) + begin[stretch]
    edge = stretches.edge[stretch]
    t, points = np.empty(len(stretch)), np.empty((len(stretch), 3))
    first = np.searchsorted(edge, np.arange(len(brep.edges) + 1))
    for curves, mine, which in _groups(brep, edge, first):
        evaluate = _together(curves, which)
        span, radius = stretches.t[stretch[mine]], radii[layer[mine]]
        line = curves[0] if len(curves) == 1 and isinstance(curves[0], LineEdge) and family == CYLINDERS else None
        t[mine] = crossings(evaluate, span, radius, family) if line is None else _on_line(line, span, radius)
        points[mine] = evaluate(t[mine], 0)[0]
    rising = stretches.rho[stretch, 1] > stretches.rho[stretch, 0]
    return Nodes(layer=layer, edge=edge, t=t, span=stretches.t[stretch], points=points, rising=rising, first=first)


def _groups(brep: Brep, edge: NDArray[np.int64], first: NDArray[np.int64]):
    """(curves, their nodes, which of the curves each node is on): B-splines of one degree together, others one by one."""
    packed: dict[int, list[int]] = {}
    for number in np.unique(edge).tolist():
        curve = brep.edges[number].curve
        assert curve is not None
        if BSplinePack.takes(curve):
            packed.setdefault(curve.degree, []).append(number)  # type: ignore[attr-defined]
        else:
            mine = np.arange(first[number], first[number + 1])
            yield [curve], mine, np.zeros(len(mine), dtype=np.int64)
    for numbers in packed.values():
        mine = np.concatenate([np.arange(first[n], first[n + 1]) for n in numbers])
        which = np.repeat(np.arange(len(numbers)), [first[n + 1] - first[n] for n in numbers])
        yield [brep.edges[n].curve for n in numbers], mine, which


def _together(curves: list[EdgeCurve], which: NDArray[np.int64]) -> Evaluate:
    """A function of (t, order) like `EdgeCurve.derivatives`, for nodes on several curves."""
    if len(curves) == 1:
        return curves[0].derivatives
    pack = BSplinePack(curves)  # type: ignore[arg-type]
    return lambda t, order: pack.derivatives(which, t, order)


def crossings(evaluate: Evaluate, span: Array, radius: Array, family: LayerFamily = CYLINDERS) -> Array:
    """Solve c(t) = radius (rho, on cylinders) on monotone stretches (n, 2), by Newton kept inside of a shrinking bracket.

    Where effective radii say that there is a crossing and the curve itself falls just short of it, the nearer end is taken.
    """
    a, b = span[:, 0].copy(), span[:, 1].copy()
    fa, fb = (family.value(evaluate(t, 0)[0]) - radius for t in (a, b))
    short = fa * fb > 0.0
    nearer = np.where(np.abs(fa) < np.abs(fb), a, b)
    sign = np.where(fa < fb, 1.0, -1.0)
    share = np.clip(fa / np.where(fa == fb, 1.0, fa - fb), 0.0, 1.0)
    t = a + share * (b - a)
    before = np.full(len(t), np.inf)
    for _ in range(MOST_STEPS):
        p, d = evaluate(t, 1)
        f, slope, scale = family.equation(p, radius), family.equation_slope(p, d), family.equation_size(p, radius)
        below = sign * f < 0.0
        a, b = np.where(below, t, a), np.where(below, b, t)
        with np.errstate(divide="ignore", invalid="ignore"):
            new = t - f / slope
        low, high = np.minimum(a, b), np.maximum(a, b)
        outside = ~((new >= low) & (new <= high))
        new = np.where(outside, 0.5 * (a + b), new)
        # what is left is rounding: of the equation, of the parameter, or of the curve's own sums, which no step makes smaller
        size = np.abs(f)
        exact = (size <= ROUNDING * scale) | ((size <= STALLED * scale) & (size >= 0.25 * before))
        done = exact | (np.abs(new - t) <= ROUNDING * np.maximum(np.abs(t), np.abs(span[:, 1] - span[:, 0])))
        t, before = np.where(exact, t, new), size
        if (done | short).all():
            break
    return np.where(short, nearer, t)


def _on_line(curve: LineEdge, span: Array, radius: Array) -> Array:
    """Closed form: |o + t d|**2 = R**2 in the plane across the axis; the root that lies on the stretch."""
    o, d = curve.origin[:2], curve.direction[:2]
    square = float(d @ d)
    middle = -float(o @ d) / square
    off = o + middle * d
    half = np.sqrt(np.maximum((radius**2 - off @ off) / square, 0.0))
    upper = span.mean(axis=1) >= middle
    t = np.where(upper, middle + half, middle - half)
    return np.clip(t, span.min(axis=1), span.max(axis=1))
