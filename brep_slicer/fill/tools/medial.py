"""The medial axis of a polygon: where the nearest two places of its outline are equally far (segment Voronoi, pyvoronoi).

In: a polygon. Out: MedialAxis, short straight pieces of it.

Words: *object angle*, the angle at a point of the axis between the directions to its two nearest places of the outline: 180
degrees between parallel sides, the corner's turn on a branch that runs into a corner.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from brep_slicer.maps import Array

if TYPE_CHECKING:
    from shapely import Polygon

# pyvoronoi works on whole numbers of 31 bits.
LARGEST = float(1 << 29)
# What Boost.Polygon calls the end of a segment that a cell belongs to.
END_POINT = 2


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MedialAxis:
    """Pieces from `starts` to `ends`, (n, 2), mm; the `distance` (n,) of their middles from the outline, mm; their object
    `angle` (n,), rad."""

    starts: Array
    ends: Array
    distance: Array
    angle: Array


def medial_axis(polygon: Polygon, *, chord: float) -> MedialAxis:
    """The medial axis inside of a polygon; its curved pieces are divided to `chord` (mm)."""
    import pyvoronoi
    import shapely

    rings = [np.asarray(ring.coords) for ring in (polygon.exterior, *polygon.interiors)]
    a, b = np.concatenate([r[:-1] for r in rings]), np.concatenate([r[1:] for r in rings])
    origin = 0.5 * (a.min(axis=0) + a.max(axis=0))
    size = max(float(np.ptp(a, axis=0).max()), 1e-6)
    found = pyvoronoi.Pyvoronoi(LARGEST)
    for p, q in zip(((a - origin) / size).tolist(), ((b - origin) / size).tolist(), strict=True):
        found.AddSegment([p, q])
    found.Construct()
    vertices = size * np.array([(v.X, v.Y) for v in found.GetVertices()]).reshape(-1, 2)
    cells, edges = found.GetCells(), found.GetEdges()
    whole = [i for i, e in enumerate(edges) if i < e.twin and e.is_primary and e.start >= 0 and e.end >= 0]
    ends = np.array([(edges[i].start, edges[i].end) for i in whole], dtype=int).reshape(-1, 2)
    # an edge lies inside or outside as a whole, though it may end in a corner
    inside = shapely.contains_xy(polygon, *(vertices[ends].mean(axis=1) + origin).T)
    kept = [i for i, within in zip(whole, inside.tolist(), strict=True) if within]
    chains = [_chain(found, i, vertices[[edges[i].start, edges[i].end]], edges[i].is_linear, chord, size) for i in kept]
    if not chains:
        return MedialAxis(starts=np.zeros((0, 2)), ends=np.zeros((0, 2)), distance=np.zeros(0), angle=np.zeros(0))
    count = [len(c) - 1 for c in chains]
    middle = np.concatenate([0.5 * (c[:-1] + c[1:]) for c in chains]) + origin
    both = [[cells[edges[i].cell] for i in kept], [cells[edges[edges[i].twin].cell] for i in kept]]
    ways = [_to_sites(middle, side, np.array(count), a, b) for side in both]
    lengths = [np.maximum(np.hypot(w[:, 0], w[:, 1]), 1e-300) for w in ways]
    cosine = np.einsum("ij,ij->i", ways[0], ways[1]) / (lengths[0] * lengths[1])
    return MedialAxis(
        starts=np.concatenate([c[:-1] for c in chains]) + origin,
        ends=np.concatenate([c[1:] for c in chains]) + origin,
        distance=np.minimum(*lengths),
        angle=np.arccos(np.clip(cosine, -1.0, 1.0)),
    )


def _chain(found: Any, edge: int, ends: Array, linear: bool, chord: float, size: float) -> Array:
    """Points (n, 2) along an edge of the diagram; a parabola too flat for pyvoronoi's formula is its chord."""
    import pyvoronoi

    if linear:
        return ends
    try:
        points = size * np.array(list(found.DiscretizeCurvedEdge(edge, chord / size))).reshape(-1, 2)
    except (pyvoronoi.UnsolvableParabolaEquation, pyvoronoi.FocusOnDirectixException):
        return ends
    return points if len(points) > 1 else ends


def _to_sites(points: Array, cells: list[Any], count: Array, a: Array, b: Array) -> Array:
    """From each point to the nearest place of its cell's site, a segment or one end of it, (n, 2); `count` points a cell."""
    site = np.repeat([cell.site for cell in cells], count)
    segment = np.repeat([cell.contains_segment for cell in cells], count)
    at_end = np.repeat([cell.source_category == END_POINT for cell in cells], count)
    along = b[site] - a[site]
    square = np.maximum(np.einsum("ij,ij->i", along, along), 1e-300)
    share = np.clip(np.einsum("ij,ij->i", points - a[site], along) / square, 0.0, 1.0)
    share = np.where(segment, share, at_end)
    return a[site] + share[:, None] * along - points
