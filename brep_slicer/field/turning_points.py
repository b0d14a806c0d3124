"""Where the level c (rho, on cylinders) turns round along edges.

In: edges, a family of layers. Out: the parameters of each edge at which c has an extreme.

Words: *slope*, what has the sign of dc/dt (`LayerFamily.rise`); *piece*, a part of an edge's parameters on which its curve is
smooth. B-splines of one degree are looked at together, all their pieces at once, and so are conics.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from brep_slicer.geometry import Edge
from brep_slicer.geometry.edge_curves import BSplinePack, ConicEdge, ConicPack, EdgeCurve, LineEdge
from brep_slicer.geometry.roots import bracketed_roots
from brep_slicer.layers import CYLINDERS, LayerFamily
from brep_slicer.maps import Array

from .radial import COINCIDENCE_BAND

# Chebyshev nodes a smooth piece: the derivative of rho**2 on a B-spline of degree 9 has degree 17, on a quarter ellipse its
# coefficients fall below 1e-16 after 20.
NODES = 24
# Interior extremes nearer than this to the end of a piece (share of its parameters) are the end itself.
END_SHARE = 1e-9
# A corner of a curve is asked this share of its shortest piece to either side.
CORNER_SHARE = 1e-7
# Points a piece at which rho is compared to tell whether the edge is level.
LEVEL_POINTS = 9
# Halvings of a piece in doubt, and the most pieces in doubt that a curve may have.
HALVINGS, MOST_PIECES = 12, 4096

Whose = NDArray[np.int64]
# [P] or [P, P'] of the curves with the numbers `whose` (n,) at t (n,), to the order asked for
Evaluate = Callable[[Whose, Array, int], list[Array]]


def turning_points(edges: Sequence[Edge], family: LayerFamily = CYLINDERS) -> list[Array]:
    """For each edge the parameters strictly inside of it where c has an extreme, increasing; none on level edges."""
    out = [np.zeros(0)] * len(edges)
    packs: dict[tuple[type[BSplinePack | ConicPack], int], list[int]] = {}
    for number, edge in enumerate(edges):
        curve = edge.curve
        if curve is None:
            continue
        if isinstance(curve, LineEdge) and family == CYLINDERS:
            out[number] = _inside(edge, _foot_of_axis(curve))
        elif BSplinePack.takes(curve):
            packs.setdefault((BSplinePack, curve.degree), []).append(number)  # type: ignore[attr-defined]
        elif isinstance(curve, ConicEdge):
            packs.setdefault((ConicPack, 2), []).append(number)
        else:
            (found,) = _turning_points(_Slope(_alone(curve), family), [curve.breaks(edge.first, edge.last)])
            out[number] = _inside(edge, found)
    for (kind, _), numbers in packs.items():
        pack = kind([edges[i].curve for i in numbers])  # type: ignore[misc]
        breaks = [edges[i].curve.breaks(edges[i].first, edges[i].last) for i in numbers]  # type: ignore[union-attr]
        for i, found in zip(numbers, _turning_points(_Slope(pack.derivatives, family), breaks), strict=True):
            out[i] = _inside(edges[i], found)
    return out


def _alone(curve: EdgeCurve) -> Evaluate:
    return lambda whose, t, order: curve.derivatives(t, order)


def _foot_of_axis(curve: LineEdge) -> Array:
    flat = curve.direction[:2]
    square = float(flat @ flat)
    return np.array([-(curve.origin[:2] @ flat) / square]) if square else np.zeros(0)


def _inside(edge: Edge, roots: Array) -> Array:
    """Those that lie inside of the edge, in order, each once."""
    slack = END_SHARE * (edge.last - edge.first)
    roots = np.sort(roots[(roots > edge.first + slack) & (roots < edge.last - slack)])
    return roots[np.diff(roots, prepend=-np.inf) > slack]


@dataclass(frozen=True, slots=True)
class _Slope:
    """How c changes along several curves at once."""

    evaluate: Evaluate
    family: LayerFamily

    def __call__(self, whose: Whose, t: Array) -> Array:
        p, d = self.evaluate(whose, t, 1)
        return self.family.rise(p, d)

    def levels(self, whose: Whose, t: Array) -> Array:
        """c itself, mm."""
        return self.family.value(self.evaluate(whose, t, 0)[0])


def _turning_points(slope: _Slope, breaks: Sequence[Array]) -> list[Array]:
    """The roots of the slope on several curves, each cut at its own `breaks`, in no order."""
    counts = [len(b) - 1 for b in breaks]
    whose = np.repeat(np.arange(len(breaks)), counts)
    a, b = np.concatenate([x[:-1] for x in breaks]), np.concatenate([x[1:] for x in breaks])
    level = _are_level(slope, whose, a, b, len(breaks))
    uneven = ~level[whose]
    owners, roots = _roots_of_slope(slope, whose[uneven], a[uneven], b[uneven])
    corners = np.flatnonzero((whose[1:] == whose[:-1]) & uneven[1:])
    if len(corners):
        # an extreme at a corner of the curve: the slope changes sign across a break
        step = CORNER_SHARE * np.array([np.diff(x).min() for x in breaks])[whose[corners]]
        sides = [slope(whose[corners], b[corners] + k * step) for k in (-1.0, 1.0)]
        change = sides[0] * sides[1] < 0.0
        owners = np.concatenate([owners, whose[corners][change]])
        roots = np.concatenate([roots, b[corners][change]])
    order = np.argsort(owners, kind="stable")
    return np.split(roots[order], np.searchsorted(owners[order], np.arange(1, len(breaks))))


def _are_level(slope: _Slope, whose: Whose, a: Array, b: Array, count: int) -> NDArray[np.bool_]:
    """Along which curves c varies by less than the band (count,); its extremes would be rounding noise."""
    t = a[:, None] + (b - a)[:, None] * np.linspace(0.0, 1.0, LEVEL_POINTS)
    rho = slope.levels(np.repeat(whose, LEVEL_POINTS), t.ravel()).reshape(t.shape)
    low, high = np.full(count, np.inf), np.full(count, -np.inf)
    np.minimum.at(low, whose, rho.min(axis=1))
    np.maximum.at(high, whose, rho.max(axis=1))
    return high - low <= COINCIDENCE_BAND


def _roots_of_slope(slope: _Slope, whose: Whose, a: Array, b: Array) -> tuple[Whose, Array]:
    """Sign changes of the slope in the pieces [a, b] (n,), by Chebyshev series; bisected where in doubt: whose, and where."""
    found = [(np.zeros(0, dtype=np.int64), np.zeros(0))]
    angles = np.pi * (np.arange(NODES) + 0.5) / NODES
    nodes = np.cos(angles)
    # values at the Chebyshev nodes to the coefficients of the series through them
    to_series = np.cos(np.outer(angles, np.arange(NODES))) * (np.where(np.arange(NODES) > 0, 2.0, 1.0) / NODES)
    for _ in range(HALVINGS):
        few = np.bincount(whose, minlength=1)[whose] <= MOST_PIECES
        whose, a, b = whose[few], a[few], b[few]
        if not len(a):
            break
        t = 0.5 * (a + b)[:, None] + 0.5 * (b - a)[:, None] * nodes[None, :]
        values = slope(np.repeat(whose, NODES), t.ravel()).reshape(t.shape)
        coefficients = values @ to_series
        rest = np.abs(coefficients[:, 1:]).sum(axis=1)
        doubtful = rest >= np.abs(coefficients[:, 0])
        monotone = np.abs(coefficients[:, 1]) > sum(k * k * np.abs(coefficients[:, k]) for k in range(2, NODES))
        single = doubtful & monotone
        if single.any():
            found.append(_single_roots(slope, whose[single], a[single], b[single]))
        halved = doubtful & ~monotone
        middle = 0.5 * (a + b)[halved]
        a, b = np.concatenate([a[halved], middle]), np.concatenate([middle, b[halved]])
        whose = np.concatenate([whose[halved], whose[halved]])
    # what is still in doubt is level to rounding there, or has a double root: no sign change that could be missed for long
    if len(a):
        found.append(_single_roots(slope, whose, a, b, strictly=True))
    owners, roots = zip(*found, strict=True)
    return np.concatenate(owners), np.concatenate(roots)


def _single_roots(slope: _Slope, whose: Whose, a: Array, b: Array, *, strictly: bool = False) -> tuple[Whose, Array]:
    """(whose, where) the slope changes sign, in every piece whose ends differ in sign: to rounding."""
    fa, fb = slope(whose, a), slope(whose, b)
    some = fa * fb < 0.0 if strictly else fa * fb <= 0.0
    owner = whose[some]
    return owner, bracketed_roots(lambda rows, t: slope(owner[rows], t), a[some], b[some], fa[some], fb[some])
