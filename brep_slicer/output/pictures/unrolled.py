"""An unrolled layer as it is drawn: its metal as polygons, its lines in one chart.

In: a layer, chains of points. Out: polygons, and chains that are broken where a full band's chart ends.
"""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np

from brep_slicer.fill import LayerFill
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
    period = layer.region.period
    turns = np.floor(points[:, 0] / period + 0.5)
    if turns.min() == turns.max():
        return points - np.array([turns[0] * period, 0.0])
    return _broken(points, period)


def is_band(layer: Layer) -> bool:
    """Whether some of the layer goes all the way round."""
    return any(piece.winds for piece in layer.region.pieces)


def metal_of(layer: Layer) -> list[Any]:
    """The region's polygons, in the chart of one turn where `shown` draws its outline in it."""
    import shapely
    from shapely.affinity import translate

    polygons = list(layer.region.to_shapely(chord=CHORD).geoms)
    if not is_band(layer):
        return polygons
    period, out = layer.region.period, []
    for polygon in polygons:
        low, bottom, high, top = polygon.bounds
        window = shapely.box(-0.5 * period, bottom - 1.0, 0.5 * period, top + 1.0)
        for turn in range(math.floor(low / period + 0.5), math.ceil(high / period - 0.5) + 1):
            # a ring that a sample's error makes cross itself cannot be cut
            moved = shapely.make_valid(translate(polygon, -turn * period)).intersection(window)
            out += [part for part in shapely.get_parts(moved) if part.geom_type == "Polygon" and part.area > 0.0]
    return out


def moves_of(layer: Layer, fill: LayerFill) -> list[Array]:
    """The ways from the end of a bead to the start of the next, (2, 2) each, but for those that would only cross it."""
    pairs = zip(fill.beads, fill.beads[1:], strict=False)
    ends = [np.array([a.points[-1], b.points[0]]) for a, b in pairs]
    near = [way for way in ends if math.hypot(*(way[1] - way[0])) < SHOWN_MOVES * layer.region.period]
    return [shown(way, layer) for way in near]


def strips_of(lines: list[Array], width: float, *, within: float = math.inf) -> list[list[Array]]:
    """The beads as broad as they are: the rings (n, 2) of each, its outer one first; cut at kappa = -`within` and `within`."""
    import shapely

    from .canvas import parts_of

    parts = [shapely.LineString(part) for line in lines for part in parts_of(line)]
    strips = shapely.buffer(parts, 0.5 * width, quad_segs=6)
    if math.isfinite(within) and len(strips):
        _, low, _, high = shapely.total_bounds(strips)
        strips = shapely.clip_by_rect(strips, -within, low, within, high)
    strips = [part for part in shapely.get_parts(strips) if part.geom_type == "Polygon"]
    return [[np.asarray(ring.coords) for ring in (strip.exterior, *strip.interiors)] for strip in strips]


def _broken(points: Array, period: float) -> Array:
    """The chain cut at every seam it crosses, also in one of its points, with NaN between the parts."""
    out: list[Array] = []
    last = None
    for a, b in itertools.pairwise(points):
        low, high = sorted((a[0], b[0]))
        seams = np.arange(np.floor(low / period + 0.5), np.ceil(high / period - 0.5) + 1) * period + 0.5 * period
        seams = seams[(seams > low) & (seams < high)]
        share = np.sort((seams - a[0]) / (b[0] - a[0])) if len(seams) else np.zeros(0)
        knots = np.concatenate([[0.0], share, [1.0]])
        for s0, s1 in itertools.pairwise(knots):
            ends = np.array([a + s * (b - a) for s in (s0, s1)])
            turn = np.floor((0.5 * (ends[0, 0] + ends[1, 0])) / period + 0.5)
            if turn != last:
                out += [np.full((1, 2), np.nan)] if out else []
                out.append(ends[:1] - [turn * period, 0.0])
            out.append(ends[1:] - [turn * period, 0.0])
            last = turn
    return np.concatenate(out)


__all__ = ["CHORD", "is_band", "metal_of", "moves_of", "shown", "strips_of"]
