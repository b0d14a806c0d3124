"""Outlines moved inwards: what a bead's centre may reach, as polygons that never lie outside of the exact offset.

In: a piece of a region and a distance. Out: an Inset, polygons in one chart, erring inwards by a stated amount.

Words: *window*, the one turn of a full band that is drawn, from its `cut` on; *slack*, by how much the polygons
may lie farther in than asked (chord of the samples and of the round corners together).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from brep_slicer.layers import NO_CLOSURE, Closure
from brep_slicer.maps import Array
from brep_slicer.region import Piece, band_between, polygon_from_piece

if TYPE_CHECKING:
    from shapely import Polygon

# Segments a quarter circle at round corners: sagitta 3e-4 of the offset.
QUARTER_SEGMENTS = 32
# Corners are as low as each other within this, mm: more than the rounding of an offset.
SAME_HEIGHT = 1e-6


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Inset:
    """`polygons` inside of a piece by `distance` at least and `distance + slack` at most (mm).

    For a piece that winds, they are drawn in the window of one turn from `cut` (turns) on, and reach both of its sides where
    the band goes on.
    """

    polygons: tuple[Polygon, ...]
    distance: float
    slack: float
    cut: float = 0.0
    closure: Closure = NO_CLOSURE

    @property
    def is_empty(self) -> bool:
        """Whether nothing is left."""
        return not self.polygons


def inset_piece(piece: Piece, distance: float, *, chord: float) -> Inset:
    """Move a piece's outline inwards by `distance` (mm; negative: outwards), samples to `chord` (mm)."""

    corner = abs(distance) * (1.0 - math.cos(0.25 * math.pi / QUARTER_SEGMENTS))
    slack = 2.0 * chord + corner
    move = distance + (chord + corner if distance > 0.0 else chord)
    if not piece.winds:
        shape = _moved(polygon_from_piece(piece, chord=chord), move)
        return Inset(polygons=_polygons(shape), distance=distance, slack=slack)
    shape = _moved(three_turns(piece, chord), move)
    drawn = _polygons(shape.intersection(window_of(piece, shape)))
    return Inset(polygons=drawn, distance=distance, slack=slack, cut=piece.cut, closure=piece.closure)


def three_turns_moved(piece: Piece, distance: float, *, chord: float):
    """The inset of a winding piece over the window and a turn on either side of it (shapely geometry)."""
    corner = abs(distance) * (1.0 - math.cos(0.25 * math.pi / QUARTER_SEGMENTS))
    return _moved(three_turns(piece, chord), distance + chord + corner)


def window_of(piece: Piece, shape):
    """The window of a winding piece's one turn, as high as a geometry."""
    import shapely

    heights = piece.closure.heights_of(shapely.get_coordinates(shape)) if not shape.is_empty else np.zeros(1)
    return piece.closure.window(piece.cut, piece.cut + 1.0, float(heights.min()) - 1.0, float(heights.max()) + 1.0)


def three_turns(piece: Piece, chord: float):
    """A winding piece's polygon from one turn before the window to one turn after it, cut exactly at its ends."""
    return band_between(piece, piece.cut - 1.0, piece.cut + 2.0, chord=chord)


def _moved(polygon, distance: float):
    shape = polygon if polygon.is_valid else polygon.buffer(0.0)
    if distance == 0.0:
        return shape
    # inwards, convex corners stay sharp whatever the join; round where the outline turns in, and at all corners outwards
    return shape.buffer(-distance, quad_segs=QUARTER_SEGMENTS, join_style="round")


def parts_of(shape, kind: str) -> list:
    """The parts of one geometry type ("Polygon", "LineString") in a geometry, none of them empty."""
    import shapely

    return [g for g in shapely.get_parts(shape) if g.geom_type == kind and not g.is_empty]


def _polygons(shape) -> tuple[Polygon, ...]:
    return tuple(g for g in parts_of(shape, "Polygon") if g.area > 0.0)


def from_the_lowest(ring: Array) -> Array:
    """A closed ring (n, 2) run from its lowest corner on (of several as low, the one of the least kappa).

    Where a ring starts must not depend on how its piece was drawn: equal pieces get equal beads.
    """
    corners = ring[:-1]
    lowest = np.flatnonzero(corners[:, 1] < corners[:, 1].min() + SAME_HEIGHT)
    rolled = np.roll(corners, -int(lowest[corners[lowest, 0].argmin()]), axis=0)
    return np.concatenate([rolled, rolled[:1]])


def edges_of(polygons) -> tuple[Array, Array]:
    """Start and end points (n, 2) of every edge of the polygons' rings."""
    starts, ends = [np.zeros((0, 2))], [np.zeros((0, 2))]
    for polygon in polygons:
        for ring in (polygon.exterior, *polygon.interiors):
            points = np.asarray(ring.coords)
            starts.append(points[:-1])
            ends.append(points[1:])
    return np.concatenate(starts), np.concatenate(ends)
