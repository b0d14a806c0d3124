"""An unrolled layer as it is drawn: its metal as polygons, its lines in one chart.

In: a layer, chains of points. Out: polygons, and chains that are broken where a full band's chart ends.
"""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np

from brep_slicer.fill import LayerFill
from brep_slicer.layers import NO_CLOSURE, Closure
from brep_slicer.maps import Array
from brep_slicer.region import Layer

# Lines are drawn to this, mm.
CHORD = 0.02
# Moves longer than this share of a turn would only cross the picture, and go the other way round as often as not.
SHOWN_MOVES = 0.25


def shown(points: Array, layer: Layer) -> Array:
    """Points of a full band drawn in the chart of -half a turn to +half a turn; a line that crosses the seam is broken."""
    if not is_band(layer):
        return points
    closure = layer.region.closure
    turns = closure.turns_along(points)
    copies = np.floor(turns + 0.5)
    if copies.min() == copies.max():
        return closure.moved(points, -copies[0])
    return _broken(points, turns, closure)


def is_band(layer: Layer) -> bool:
    """Whether some of the layer goes all the way round."""
    return any(piece.winds for piece in layer.region.pieces)


def metal_of(layer: Layer) -> list[Any]:
    """The region's polygons, in the chart of one turn where `shown` draws its outline in it."""
    import shapely

    polygons = list(layer.region.to_shapely(chord=CHORD).geoms)
    if not is_band(layer):
        return polygons
    closure, out = layer.region.closure, []
    for polygon in polygons:
        heights = closure.heights_of(shapely.get_coordinates(polygon))
        window = closure.window(-0.5, 0.5, float(heights.min()) - 1.0, float(heights.max()) + 1.0)
        for turns in closure.copies_between(polygon.bounds, -0.5, 0.5):
            # a ring that a sample's error makes cross itself cannot be cut
            moved = shapely.make_valid(closure.motion(turns).shape(polygon)).intersection(window)
            out += [part for part in shapely.get_parts(moved) if part.geom_type == "Polygon" and part.area > 0.0]
    return out


def moves_of(layer: Layer, fill: LayerFill) -> list[Array]:
    """The ways from the end of a bead to the start of the next, (2, 2) each, but for those that would only cross it."""
    pairs = zip(fill.beads, fill.beads[1:], strict=False)
    ends = [np.array([a.points[-1], b.points[0]]) for a, b in pairs]
    closure = layer.region.closure
    near = [way for way in ends if abs(float(np.diff(closure.turns_along(way))[0])) < SHOWN_MOVES]
    return [shown(way, layer) for way in near]


def strips_of(lines: list[Array], width: float, *, within: Closure = NO_CLOSURE) -> list[list[Array]]:
    """The beads as broad as they are: the rings (n, 2) of each, its outer one first; cut where the chart of a turn ends."""
    import shapely

    from .canvas import parts_of

    parts = [shapely.LineString(part) for line in lines for part in parts_of(line)]
    drawn = within.clipped(shapely.buffer(parts, 0.5 * width, quad_segs=6))
    strips = [part for part in shapely.get_parts(drawn) if part.geom_type == "Polygon"]
    return [[np.asarray(ring.coords) for ring in (strip.exterior, *strip.interiors)] for strip in strips]


def _broken(points: Array, turns: Array, closure: Closure) -> Array:
    """The chain, its points at `turns` (n,), cut at every seam it crosses, also in one of its points, NaN between the parts."""
    out: list[Array] = []
    last = None
    for (a, b), (t0, t1) in zip(itertools.pairwise(points), itertools.pairwise(turns.tolist()), strict=True):
        low, high = sorted((t0, t1))
        seams = np.arange(np.floor(low + 0.5), np.ceil(high - 0.5) + 1) + 0.5
        seams = seams[(seams > low) & (seams < high)]
        share = np.sort((seams - t0) / (t1 - t0)) if len(seams) else np.zeros(0)
        knots = np.concatenate([[0.0], share, [1.0]])
        for s0, s1 in itertools.pairwise(knots):
            ends = np.array([a + s * (b - a) for s in (s0, s1)])
            copy = np.floor(t0 + 0.5 * (s0 + s1) * (t1 - t0) + 0.5)
            if copy != last:
                out += [np.full((1, 2), np.nan)] if out else []
                out.append(closure.moved(ends[:1], -copy))
            out.append(closure.moved(ends[1:], -copy))
            last = copy
    return np.concatenate(out)


__all__ = ["CHORD", "is_band", "metal_of", "moves_of", "shown", "strips_of"]
