"""Where the edges of a solid cross the layers, all edges and all radii.

In: edges cut into monotone stretches, radii. Out: Nodes, one for each stretch and layer that cross.

Words: *node*, such a crossing; its identity is (stretch, layer), so the two faces of the edge share it without any tolerance;
*rising*, rho grows there along the edge's own parameter.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from brep_slicer.field import SNAP, EdgeStretches, radii_of
from brep_slicer.geometry import Brep
from brep_slicer.geometry.edge_curves import EdgeCurve, LineEdge
from brep_slicer.maps import Array

MOST_STEPS = 60
# Relative rounding of a B-spline's point and of the sum of two squares, a few units in the last place.
ROUNDING = 2e-15


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Nodes:
    """Arrays (n,) or (n, 3) over all nodes, sorted by edge: `layer`, `edge`, `t` on the edge, `points` in the axis frame.

    `first` (edges + 1,) says where each edge's nodes begin.
    """

    layer: NDArray[np.int64]
    edge: NDArray[np.int64]
    t: Array
    points: Array
    rising: NDArray[np.bool_]
    first: NDArray[np.int64]

    def of_edge(self, edge: int) -> slice:
        """The nodes of one edge."""
        return slice(int(self.first[edge]), int(self.first[edge + 1]))


def find_nodes(brep: Brep, stretches: EdgeStretches, radii: Array) -> Nodes:
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
    for number in np.unique(edge):
        mine = slice(first[number], first[number + 1])
        curve = brep.edges[number].curve
        assert curve is not None
        t[mine] = _crossings(curve, stretches.t[stretch[mine]], radii[layer[mine]])
        points[mine] = curve.points(t[mine])
    rising = stretches.rho[stretch, 1] > stretches.rho[stretch, 0]
    return Nodes(layer=layer, edge=edge, t=t, points=points, rising=rising, first=first)


def _crossings(curve: EdgeCurve, span: Array, radius: Array) -> Array:
    """Solve rho(t) = radius on monotone stretches (n, 2), by Newton kept inside of a shrinking bracket.

    Where effective radii say that there is a crossing and the curve itself falls just short of it, the nearer end is taken.
    """
    if isinstance(curve, LineEdge):
        return _on_line(curve, span, radius)
    a, b = span[:, 0].copy(), span[:, 1].copy()
    fa, fb = (_gap(curve, t, radius) for t in (a, b))
    short = fa * fb > 0.0
    nearer = np.where(np.abs(fa) < np.abs(fb), a, b)
    sign = np.where(fa < fb, 1.0, -1.0)
    share = np.clip(fa / np.where(fa == fb, 1.0, fa - fb), 0.0, 1.0)
    t = a + share * (b - a)
    for _ in range(MOST_STEPS):
        p, d = curve.derivatives(t, 1)
        f = (p[:, 0] ** 2 + p[:, 1] ** 2) - radius**2
        slope = 2.0 * (p[:, 0] * d[:, 0] + p[:, 1] * d[:, 1])
        below = sign * f < 0.0
        a, b = np.where(below, t, a), np.where(below, b, t)
        with np.errstate(divide="ignore", invalid="ignore"):
            new = t - f / slope
        low, high = np.minimum(a, b), np.maximum(a, b)
        outside = ~((new >= low) & (new <= high))
        new = np.where(outside, 0.5 * (a + b), new)
        # what is left is rounding: of rho**2, or of the parameter
        exact = np.abs(f) <= ROUNDING * radius**2
        done = exact | (np.abs(new - t) <= ROUNDING * np.maximum(np.abs(t), np.abs(span[:, 1] - span[:, 0])))
        t = np.where(exact, t, new)
        if (done | short).all():
            break
    return np.where(short, nearer, t)


def _gap(curve: EdgeCurve, t: Array, radius: Array) -> Array:
    return radii_of(curve.points(t)) - radius


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
