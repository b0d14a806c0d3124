"""How much of a piece each of its parallel beads has to fill.

In: a polygon, the places of parallel lines across their way. Out: the polygon's area from half-way to the one neighbour to
half-way to the other, line by line; the outermost ones fill up to the outline.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from brep_slicer.maps import Array

from .inset import edges_of, parts_of
from .scanlines import directions

if TYPE_CHECKING:
    from shapely import Geometry


def strip_areas(shape: Geometry, angle: float, lines: Array) -> Array:
    """Areas (n,) in mm**2 of the strips about lines at `angle` (rad) and the rising across-coordinates `lines` (n,)."""
    starts, ends = edges_of(parts_of(shape, "Polygon"))
    along, across = directions(angle)
    borders = 0.5 * (lines[1:] + lines[:-1])
    ya, yb = starts @ across, ends @ across
    xa, xb = starts @ along, ends @ along
    first = np.searchsorted(borders, np.minimum(ya, yb), side="right")
    last = np.searchsorted(borders, np.maximum(ya, yb), side="left")
    count = last - first + 1
    edge = np.repeat(np.arange(len(ya)), count)
    strip = np.arange(len(edge)) - np.repeat(np.cumsum(count) - count - first, count)
    fence = np.concatenate([[-np.inf], borders, [np.inf]])
    # the part of each edge within its strip
    low, high = np.minimum(ya, yb)[edge], np.maximum(ya, yb)[edge]
    low, high = np.maximum(low, fence[strip]), np.minimum(high, fence[strip + 1])
    slope = (xb - xa)[edge] / np.where(yb == ya, np.inf, yb - ya)[edge]
    middle = xa[edge] + (0.5 * (low + high) - ya[edge]) * slope
    # the integral of x dy round each strip; along its borders dy is nil. Outer rings as shapely has them may run either way
    part = np.where(yb > ya, 1.0, -1.0)[edge] * (high - low) * middle
    rings = _ring_signs(shape)
    return np.bincount(strip, weights=part * rings[edge], minlength=len(lines))


def _ring_signs(shape: Geometry) -> Array:
    """For each edge of `edges_of`, 1 where its ring runs with the area on its left, else -1."""
    import shapely

    signs, counts = [1.0], [0]
    for polygon in parts_of(shape, "Polygon"):
        for ring, way in ((polygon.exterior, 1.0), *((hole, -1.0) for hole in polygon.interiors)):
            signs.append(way if shapely.is_ccw(ring) else -way)
            counts.append(shapely.get_num_points(ring) - 1)
    return np.repeat(signs, counts)
