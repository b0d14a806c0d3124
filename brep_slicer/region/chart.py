"""Pieces drawn in the plane: polygons in (kappa, v), and what lies below a point.

In: a piece, a chord. Out: shapely geometry in one chart.

Words: *chart*, one drawing on a stretch of the plane; *seam*, where a full band's chart is cut (no boundary: no contour follows
it); *turns*, where round the axis, in the sheet's own measure: copies lie whole turns apart. An edge may fold back over the
seam: the chart is then several polygons.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from brep_slicer.curves import Loop
from brep_slicer.layers import Closure
from brep_slicer.maps import Array

from .pieces import Piece

if TYPE_CHECKING:
    from shapely import Geometry, MultiPolygon, Polygon


def polygon_from_piece(piece: Piece, *, chord: float, seam: float = -0.5) -> Polygon | MultiPolygon:
    """One piece in its chart, sampled to `chord` (mm); one that winds is cut at `seam` (turns): see `Region.to_shapely`."""
    import shapely

    if piece.winds:
        return band_between(piece, seam, seam + 1.0, chord=chord)
    return shapely.Polygon(piece.outer[0].sample(chord), [hole.sample(chord) for hole in piece.holes])


def band_between(piece: Piece, low: float, high: float, *, chord: float) -> Polygon | MultiPolygon:
    """What of a winding piece and its copies lies from `low` to `high` (turns), cut exactly there."""
    import shapely

    closure = piece.closure
    lower, upper = (_copies_of_edge(loop, low, high, chord) for loop in piece.outer)
    heights = closure.heights_of(np.concatenate([lower, upper]))
    window = closure.window(low, high, float(heights.min()) - 1.0, float(heights.max()) + 1.0)
    shell = shapely.Polygon(np.concatenate([lower, upper]))
    flat = shell.intersection(window) if shell.is_valid else _folded_band(lower, upper, window, closure)
    holes = [
        shapely.Polygon(hole.moved(turns).sample(chord)) for hole in piece.holes for turns in copies_between(hole, low, high)
    ]
    return _polygonal(flat.difference(shapely.union_all(holes)) if holes else flat)


def _copies_of_edge(loop: Loop, low: float, high: float, chord: float) -> Array:
    """A winding loop's points, in its own direction, over so many turns that all its copies from `low` to `high` are there.

    Both ends lie outside of that, whatever folds back.
    """
    points, closure = loop.sample(chord), loop.closure
    places = closure.turns_along(points)
    first = int(np.floor(low - places.max())) - 1
    last = int(np.ceil(high - places.min())) + 1
    turns = np.arange(first, last + 1) if loop.winding > 0 else np.arange(last, first - 1, -1)
    return np.concatenate([closure.moved(points[:-1], float(k)) for k in turns])


def _folded_band(lower: Array, upper: Array, window: Geometry, closure: Closure) -> Geometry:
    """The faces between two edges that fold back beyond the ends of what is drawn: those with more below them than above."""
    import shapely

    lines = [shapely.LineString(chain).intersection(window) for chain in (lower, upper)]
    faces = shapely.get_parts(shapely.polygonize(shapely.get_parts(shapely.node(shapely.union_all([*lines, window.boundary])))))
    points = shapely.get_coordinates(shapely.point_on_surface(faces))
    places = closure.turns_of(points)
    count = sum(_crossed_below(chain, closure.turns_along(chain), points, places) for chain in (lower, upper))
    return shapely.union_all(faces[count > 0])


def _polygonal(shape: Geometry) -> Polygon | MultiPolygon:
    """Only what has an area: an edge that runs along the seam is none."""
    import shapely

    parts = [part for part in shapely.get_parts(shape) if part.geom_type == "Polygon" and part.area > 0.0]
    return parts[0] if len(parts) == 1 else shapely.MultiPolygon(parts)


def copies_between(loop: Loop, low: float, high: float) -> range:
    """The turns by which a loop can be moved so that it overlaps what lies from `low` to `high` (turns)."""
    return loop.closure.copies_between(loop.bounds(), low, high)


def crossings_below(chain: Array, points: Array, closure: Closure) -> Array:
    """How often a chain (m, 2) passes below each of `points` (n, 2) towards greater turns, less how often towards smaller.

    The chain ends where it starts, or at a copy of that; all its copies count.
    """
    turns = closure.turns_along(chain)
    turns[-1] = turns[0] + np.round(turns[-1] - turns[0])
    # within one turn from the chain's start: the vertex at either end of a winding chain is then left or right of both copies
    places = closure.turns_of(points)
    copies = np.floor(places - turns[0])
    copies = np.where(places - copies >= turns[0] + 1.0, copies + 1.0, copies)
    places = np.maximum(places - copies, turns[0])
    base = closure.moved(points, -copies)
    count = np.zeros(len(points), dtype=int)
    for k in range(int(np.floor((turns - turns[0]).min())) - 1, int(np.ceil((turns - turns[0]).max())) + 1):
        count += _crossed_below(chain, turns, closure.moved(base, float(k)), places + k)
    return count


def _crossed_below(chain: Array, turns: Array, points: Array, places: Array) -> Array:
    """The same for a chain as it stands, its points at `turns` (m,), the points at `places` (n,)."""
    right = turns[None, :] > places[:, None]
    rows, at = np.nonzero(right[:, 1:] != right[:, :-1])
    (ka, va), (kb, vb) = chain[at].T, chain[at + 1].T
    onwards = right[rows, at + 1]
    # a point above a segment lies to the left of it where it runs onwards
    left = (kb - ka) * (points[rows, 1] - va) - (vb - va) * (points[rows, 0] - ka)
    count = np.zeros(len(points), dtype=int)
    np.add.at(count, rows, np.where(np.where(onwards, left, -left) > 0.0, np.where(onwards, 1, -1), 0))
    return count
