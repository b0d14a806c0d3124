"""Beads along the medial axis: where a piece is too narrow for a hatch or another contour.

In: an area, with the beads that were laid in it before. Out: beads along the skeleton of what those leave bare.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from brep_slicer.maps import Array

from ..bead import Bead, BeadKind
from ..pattern import AreaFill, FillArea, Pattern
from ..tools.inset import parts_of, three_turns, window_of
from ..tools.lobes import Shape
from ..tools.medial import medial_axis

if TYPE_CHECKING:
    from shapely import Geometry

# Branches of the medial axis that run into corners are left out when the corner turns by less than this.
CORNER = math.radians(95.0)
# Bare spots smaller than a square of this share of the bead width are left to the neighbouring beads.
SPOT = 0.1
# A bead along the skeleton reaches this share of its width into what is covered already, and is at least so long.
REACH = 0.25
# Ends of branches within this are one, mm: the Voronoi diagram's whole numbers are about as fine.
SAME_PLACE = 1e-7


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class Skeleton(Pattern):
    """One bead along each branch of the skeleton of what is bare: of the whole piece, or of what other beads left."""

    name: ClassVar[str] = "skeleton"
    help: ClassVar[str] = "one bead along the middle, for thin tips"
    turns_along: ClassVar[bool] = True

    def fill(self, area: FillArea) -> AreaFill:
        import shapely

        from brep_slicer.region import polygon_from_piece

        shape = three_turns(area.piece, area.chord) if area.piece.winds else polygon_from_piece(area.piece, chord=area.chord)
        if not shape.is_valid:
            # chords on either side of an edge gap may cross; what they enclose is the piece nevertheless
            shape = shapely.union_all(parts_of(shapely.make_valid(shape), "Polygon"))
        bare = shape
        if area.laid:
            lines = [shapely.LineString(points) for points in _copies(area, shape)]
            bare = shape.difference(shapely.union_all([line.buffer(0.5 * area.width) for line in lines]))
            bare = shapely.MultiPolygon([p for p in parts_of(bare, "Polygon") if p.area > (SPOT * area.width) ** 2])
        if bare.is_empty:
            return AreaFill(beads=(), inset=area.inset)
        window = window_of(area.piece, shape) if area.piece.winds else None
        return AreaFill(beads=_along(area, shape, bare if area.laid else None, window), inset=area.inset)


def beads_in_lobes(area: FillArea, shape: Shape) -> tuple[Bead, ...]:
    """One bead along each branch of the skeleton in the lobes of a piece, from where other beads reach to their tips."""
    import shapely

    if not shape.lobes:
        return ()
    lobes = shapely.MultiPolygon(list(shape.lobes))
    return _along(area, shape.whole.intersection(lobes.buffer(area.width)), lobes, None)


def _along(area: FillArea, part: Geometry, bare: Geometry | None, window: Geometry | None) -> tuple[Bead, ...]:
    """Beads along the skeleton of a `part` of the piece, where it is bare (None: all along), and within a window."""
    import shapely

    found = shapely.MultiLineString([line for polygon in parts_of(part, "Polygon") for line in _branches(polygon, area)])
    if bare is not None:
        found = found.intersection(bare.buffer(REACH * area.width))
    if window is not None:
        found = found.intersection(window)
    long = [line for line in _merged(found) if line.length >= REACH * area.width]
    # again: where a short branch left, two long ones are now one
    chains = [np.asarray(line.coords) for line in _merged(shapely.MultiLineString(long))]
    return tuple(_bead(_thinned(c, area.chord), area.index) for c in chains)


def _merged(lines) -> list:
    import shapely

    lines = shapely.set_precision(lines, SAME_PLACE, mode="pointwise")
    return parts_of(lines if lines.is_empty else shapely.line_merge(lines), "LineString")


def _branches(polygon, area: FillArea) -> list:
    import shapely

    axis = medial_axis(polygon, chord=area.chord)
    keep = axis.angle > CORNER
    pieces = np.stack([axis.starts[keep], axis.ends[keep]], axis=1)
    lines = shapely.multilinestrings(shapely.linestrings(pieces))
    # into a sharp corner a bead runs until its round end reaches it
    ends = shapely.points(pieces.reshape(-1, 2))
    corners = ends[shapely.distance(polygon.boundary, ends) < 10.0 * SAME_PLACE] if len(pieces) else ends
    return _merged(lines.difference(shapely.MultiPoint(corners).buffer(0.5 * area.width)))


def _copies(area: FillArea, shape) -> list[Array]:
    """The beads that were laid; on a full turn with all their copies, whole turns away, that reach the shape."""
    if not area.piece.winds:
        return [bead.points for bead in area.laid]
    import shapely

    closure, out = area.piece.closure, []
    low, high = closure.span_of(shapely.box(*shape.bounds).buffer(area.width).bounds)
    for bead in area.laid:
        turns = closure.turns_along(bead.points)
        first, last = math.ceil(low - float(turns.max())), math.floor(high - float(turns.min()))
        out += [closure.moved(bead.points, k) for k in range(first, last + 1)]
    return out


def _bead(points: Array, piece: int) -> Bead:
    closed = bool(np.array_equal(points[0], points[-1]))
    return Bead(points=points, kind=BeadKind.SKELETON, piece=piece, closed=closed)


def _thinned(points: Array, chord: float) -> Array:
    import shapely

    return np.asarray(shapely.LineString(points).simplify(chord).coords)
