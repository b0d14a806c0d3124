"""Pieces drawn in the plane: polygons in (kappa, v), and what lies below a point.

In: a piece, a chord. Out: shapely geometry in one chart.

Words: *chart*, one drawing on a stretch of the plane; *seam*, where a full band's chart is cut (no boundary: no contour follows
it); *lift*, a copy a whole number of turns away. An edge may fold back over the seam: the chart is then several polygons.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from brep_slicer.curves import Loop
from brep_slicer.maps import Array

from .pieces import Piece

if TYPE_CHECKING:
    from shapely import Geometry, MultiPolygon, Polygon


def polygon_from_piece(piece: Piece, *, chord: float, seam: float | None = None) -> Polygon | MultiPolygon:
    """One piece in its chart, sampled to `chord` (mm): see `Region.to_shapely`."""
    import shapely

    if piece.winds:
        cut = -0.5 * piece.outer[0].period if seam is None else seam
        return band_between(piece, cut, cut + piece.outer[0].period, chord=chord)
    return shapely.Polygon(piece.outer[0].sample(chord), [hole.sample(chord) for hole in piece.holes])


def band_between(piece: Piece, low: float, high: float, *, chord: float) -> Polygon | MultiPolygon:
    """What of a winding piece and its lifts lies between two kappas (mm), cut exactly there."""
    import shapely

    lower, upper = (_lifts_of_edge(loop, low, high, chord) for loop in piece.outer)
    heights = np.concatenate([lower[:, 1], upper[:, 1]])
    window = shapely.box(low, float(heights.min()) - 1.0, high, float(heights.max()) + 1.0)
    shell = shapely.Polygon(np.concatenate([lower, upper]))
    flat = shell.intersection(window) if shell.is_valid else _folded_band(lower, upper, window)
    holes = [
        shapely.Polygon(hole.shifted(turns).sample(chord)) for hole in piece.holes for turns in lifts_between(hole, low, high)
    ]
    return _polygonal(flat.difference(shapely.union_all(holes)) if holes else flat)


def _lifts_of_edge(loop: Loop, low: float, high: float, chord: float) -> Array:
    """A winding loop's points, in its own direction, over so many turns that all its lifts between `low` and `high` are there.

    Both ends lie outside of that, whatever folds back.
    """
    points, period = loop.sample(chord), loop.period
    first = int(np.floor((low - points[:, 0].max()) / period)) - 1
    last = int(np.ceil((high - points[:, 0].min()) / period)) + 1
    turns = np.arange(first, last + 1) if loop.winding > 0 else np.arange(last, first - 1, -1)
    return np.concatenate([points[:-1] + np.array([k * period, 0.0]) for k in turns])


def _folded_band(lower: Array, upper: Array, window: Geometry) -> Geometry:
    """The faces between two edges that fold back beyond the ends of what is drawn: those with more below them than above."""
    import shapely

    lines = [shapely.LineString(chain).intersection(window) for chain in (lower, upper)]
    faces = shapely.get_parts(shapely.polygonize(shapely.get_parts(shapely.node(shapely.union_all([*lines, window.boundary])))))
    points = shapely.get_coordinates(shapely.point_on_surface(faces))
    inside = _crossed_below(lower, points) + _crossed_below(upper, points) > 0
    return shapely.union_all(faces[inside])


def _polygonal(shape: Geometry) -> Polygon | MultiPolygon:
    """Only what has an area: an edge that runs along the seam is none."""
    import shapely

    parts = [part for part in shapely.get_parts(shape) if part.geom_type == "Polygon" and part.area > 0.0]
    return parts[0] if len(parts) == 1 else shapely.MultiPolygon(parts)


def lifts_between(loop: Loop, low: float, high: float) -> range:
    """The turns by which a loop can be moved so that it overlaps [low, high] in kappa."""
    k0, _, k1, _ = loop.bounds()
    period = loop.period
    return range(int(np.ceil((low - k1) / period)), int(np.floor((high - k0) / period)) + 1)


def crossings_below(chain: Array, points: Array, period: float) -> Array:
    """How often a chain (m, 2) passes below each of `points` (n, 2) towards greater kappa, less how often towards smaller.

    The chain ends where it starts, or whole turns of `period` (mm) on; all its lifts count.
    """
    start = chain[0, 0]
    # within one turn from the chain's start: the vertex at either end of a winding chain is then left or right of both copies
    base = points[:, 0] - np.floor((points[:, 0] - start) / period) * period
    base = np.where(base >= start + period, start, base)
    count = np.zeros(len(points), dtype=int)
    turns = (chain[:, 0] - start) / period
    for lift in range(int(np.floor(turns.min())) - 1, int(np.ceil(turns.max())) + 1):
        count += _crossed_below(chain, np.stack([base + lift * period, points[:, 1]], axis=-1))
    return count


def _crossed_below(chain: Array, points: Array) -> Array:
    """The same for a chain as it stands."""
    right = chain[None, :, 0] > points[:, 0, None]
    rows, at = np.nonzero(right[:, 1:] != right[:, :-1])
    (ka, va), (kb, vb) = chain[at].T, chain[at + 1].T
    height = va + (vb - va) * (points[rows, 0] - ka) / (kb - ka)
    count = np.zeros(len(points), dtype=int)
    np.add.at(count, rows, np.where(height < points[rows, 1], np.where(right[rows, at + 1], 1, -1), 0))
    return count
