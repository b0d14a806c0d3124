"""Regions of several solids joined, or taken from one another, on their exact curves.

In: regions on one cylinder. Out: their union or difference, with the curves' kinds kept.

Words: *crossing*, where a curve of one region meets one of the other; *shared*, run along both.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from brep_slicer.curves import Curve
from brep_slicer.errors import LayerError
from brep_slicer.maps import Array
from brep_slicer.section.chain import Arc, loops_from_arcs

from .region import Region, region_from_loops

# Polylines that find crossings and tell inside from outside, mm; crossings are then polished on the curves themselves.
SEARCH_CHORD = 1e-3
# Two outlines that run this near to each other at the middle of a curve run along each other, mm.
SHARED = 5e-6
# Overlaps smaller than this share of the smaller region are two outlines that touch.
TOUCHING = 1e-9


def union_of_regions(radius: float, regions: Sequence[Region]) -> Region:
    """The union of regions on the cylinder of `radius`.

    Raises
    ------
    LayerError
        If the outlines cross in a way that does not close.
    """
    out = Region(radius=radius)
    for region in regions:
        if region.is_empty:
            continue
        out = region if out.is_empty else _overlay(out, region, union=True)
    return out


def difference_of_regions(region: Region, other: Region) -> Region:
    """What of `region` lies outside of `other`."""
    if region.is_empty or other.is_empty:
        return region
    return _overlay(region, other, union=False)


def _overlay(a: Region, b: Region, *, union: bool) -> Region:
    apart = Region(radius=a.radius, pieces=a.pieces + b.pieces) if union else a
    boxes = [np.array([piece.bounds() for piece in region.pieces]) for region in (a, b)]
    if not any(_lifts(p, q, a.period) for p in boxes[0] for q in boxes[1]):
        return apart
    shapes = (_cover(a), _cover(b))
    if not _overlap(*shapes, a, b):
        return apart
    arcs_a, arcs_b = _split(a, b)
    kept = [arc for arc in arcs_a if _keeps(arc, shapes[1], first=True, union=union)]
    for arc in arcs_b:
        if _keeps(arc, shapes[0], first=False, union=union):
            kept.append(arc if union else Arc(curve=arc.curve.reversed(), start=arc.end, end=arc.start))
    result = region_from_loops(a.radius, loops_from_arcs(a.radius, kept))
    bound = a.area + b.area if union else a.area
    if result.area > bound + 1e-6 * bound or (union and result.area < max(a.area, b.area) * (1.0 - 1e-6)):
        raise LayerError(f"the sections of two solids at radius {a.radius:g} mm overlap in a way that cannot be resolved")
    return result


class _Cover:
    """A region as polygons over three turns, to ask which points lie inside (kappa is reduced to the middle turn)."""

    def __init__(self, region: Region) -> None:
        import shapely

        self.period = region.period
        polygons = region.to_shapely(chord=SEARCH_CHORD, seam=-0.5 * region.period).geoms
        copies = [shapely.affinity.translate(p, k * self.period) for p in polygons for k in (-2, -1, 0, 1, 2)]
        window = shapely.box(-0.75 * self.period, -1e9, 0.75 * self.period, 1e9)
        self.shape = shapely.union_all([p.buffer(0.0) for p in copies]).intersection(window)
        lines = [shapely.LineString(loop.sample(SHARED / 2.0)) for loop in region.loops]
        self.outline = shapely.MultiLineString(
            [shapely.affinity.translate(line, k * self.period) for line in lines for k in (-2, -1, 0, 1, 2)]
        )
        shapely.prepare(self.shape)

    def reduced(self, point: Array) -> Array:
        turns = np.floor(point[0] / self.period + 0.5)
        return np.array([point[0] - turns * self.period, point[1]])


def _cover(region: Region) -> _Cover:
    import shapely.affinity

    assert shapely.affinity is not None
    return _Cover(region)


def _overlap(a: _Cover, b: _Cover, first: Region, second: Region) -> bool:
    common = a.shape.intersection(b.shape).area
    return common > TOUCHING * min(first.area, second.area) + SEARCH_CHORD * min(first.length, second.length)


def _keeps(arc: Arc, other: _Cover, *, first: bool, union: bool) -> bool:
    """Whether a piece of outline bounds the result."""
    import shapely

    middle = other.reduced(arc.curve.points(np.array([0.5]))[0])
    point = shapely.Point(middle)
    if other.outline.distance(point) <= SHARED:
        if not first:
            return False
        # shared: the metal of the other lies on the same side if a step to the left is inside of it
        along = arc.curve.derivatives(np.array([0.5]))[0]
        left = np.array([-along[1], along[0]]) / np.hypot(*along)
        same = shapely.contains_xy(other.shape, *(middle + 20.0 * SEARCH_CHORD * left))
        return bool(same) == union
    inside = bool(shapely.contains_xy(other.shape, *middle))
    return inside if not (union or first) else not inside


def _split(a: Region, b: Region) -> tuple[list[Arc], list[Arc]]:
    """Both regions' curves, cut where they cross; nodes are shared between the two."""
    curves_a, curves_b = ([c for loop in r.loops for c in loop.curves] for r in (a, b))
    cuts_a: list[list[tuple[float, int]]] = [[] for _ in curves_a]
    cuts_b: list[list[tuple[float, int]]] = [[] for _ in curves_b]
    boxes_a, boxes_b = (np.array([c.bounds() for c in cs]) for cs in (curves_a, curves_b))
    node = 0
    for i, ca in enumerate(curves_a):
        for j, cb in enumerate(curves_b):
            for k in _lifts(boxes_a[i], boxes_b[j], a.period):
                for s, t in _crossings(ca, cb.shifted(k * a.period) if k else cb):
                    cuts_a[i].append((s, node))
                    cuts_b[j].append((t, node))
                    node += 1
    arcs_a, node = _cut_loops(a, cuts_a, node)
    arcs_b, _ = _cut_loops(b, cuts_b, node)
    return arcs_a, arcs_b


def _lifts(p: Array, q: Array, period: float) -> range:
    if p[3] < q[1] or q[3] < p[1]:
        return range(0)
    return range(int(np.ceil((p[0] - q[2]) / period - 1e-9)), int(np.floor((p[2] - q[0]) / period + 1e-9)) + 1)


def _cut_loops(region: Region, cuts: list[list[tuple[float, int]]], node: int) -> tuple[list[Arc], int]:
    arcs: list[Arc] = []
    number = 0
    for loop in region.loops:
        first = node
        for i, curve in enumerate(loop.curves):
            last = first if i == len(loop.curves) - 1 else node + 1
            marks = [(0.0, node), *sorted(cuts[number]), (1.0, last)]
            for (s0, n0), (s1, n1) in itertools.pairwise(marks):
                if s1 - s0 > 1e-12:
                    arcs.append(Arc(curve=curve.trimmed(s0, s1), start=n0, end=n1))
            node += 1
            number += 1
    return arcs, node


def _crossings(a: Curve, b: Curve) -> list[tuple[float, float]]:
    """Parameters (s, t) where two curves cross, from their polylines, polished by Newton."""
    sa, sb = a.parameters(SEARCH_CHORD), b.parameters(SEARCH_CHORD)
    pa, pb = a.points(sa), b.points(sb)
    da, db = np.diff(pa, axis=0), np.diff(pb, axis=0)
    cross = da[:, None, 0] * db[None, :, 1] - da[:, None, 1] * db[None, :, 0]
    gap = pb[None, :-1] - pa[:-1, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        u = (gap[..., 0] * db[None, :, 1] - gap[..., 1] * db[None, :, 0]) / cross
        w = (gap[..., 0] * da[:, None, 1] - gap[..., 1] * da[:, None, 0]) / cross
    hit = (u >= 0.0) & (u < 1.0) & (w >= 0.0) & (w < 1.0)
    found = []
    for i, j in zip(*np.nonzero(hit), strict=True):
        s = sa[i] + u[i, j] * (sa[i + 1] - sa[i])
        t = sb[j] + w[i, j] * (sb[j + 1] - sb[j])
        found.append(_polished(a, b, float(s), float(t)))
    return found


def _polished(a: Curve, b: Curve, s: float, t: float) -> tuple[float, float]:
    for _ in range(8):
        gap = b.points(np.array([t]))[0] - a.points(np.array([s]))[0]
        da, db = a.derivatives(np.array([s]))[0], b.derivatives(np.array([t]))[0]
        det = da[0] * -db[1] + da[1] * db[0]
        if det == 0.0:
            break
        s = min(max(s + (gap[0] * -db[1] + gap[1] * db[0]) / det, 0.0), 1.0)
        t = min(max(t + (da[0] * gap[1] - da[1] * gap[0]) / det, 0.0), 1.0)
    return s, t
