"""Where hatch lines end beside a contour, so that the two neither pile up nor leave anything bare between them.

In: the ends of lines, the contour's distance. Out: the ends where they belong.

What the lines have to fill begins half a step-over from the contour's centre, the *border*. A line that runs into the border
ends so far before it that its round end holds what is left; at small angles nearer, since a wedge would stay bare between the
contour and the lines that end there one after the other. Where a line runs beside the contour it is a step-over from it.

Words: *slant*, the angle between a line and the outline at its end, through its sine.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from brep_slicer.maps import Array

from ..pattern import FillArea
from .distance import Outline
from .metal import ROUND_END

# A line is left this much of its length (in widths) at least, however near the borders that it ends at.
LEAST_LEFT = 0.25
# A bead that short is left out unless more than this square (a side in widths) stays bare without it.
BARE_SPOT = 0.1
# Ends that slant less than this (sine) are taken to slant as much.
LEAST_SLANT = 1e-3


def nearest_end(step_over: float, width: float) -> float:
    """How near to the contour's centre (mm) a line ends that hardly slants: so near that no wedge stays bare."""
    return max(0.0, min(0.5 * step_over, width - step_over))


def beside(step_over: float, width: float) -> float:
    """How far from the contour's centre (mm) the outermost lines lie: a step-over, or less so that no gap opens if centred."""
    return min(step_over, width - 0.5 * step_over) if width >= step_over else step_over


def ends_from_contour(slant: Array, step_over: float, width: float) -> Array:
    """How far from the contour's centre (mm) lines end, by the sine of their slant.

    A step-over d apart, their round ends w wide, they leave nothing bare up to w / 2 from the contour's centre: neither where
    two round ends meet, nor where one meets the side of the line before it.
    """
    half, cosine = 0.5 * width, np.sqrt(np.maximum(1.0 - slant**2, 0.0))
    filled = 0.5 * step_over + ROUND_END * width * slant
    gap = 0.5 * step_over / slant
    behind = np.sqrt(np.maximum(half**2 - gap**2, 0.0))
    by_sides = half + np.sqrt(max(step_over * (width - step_over), 0.0)) * slant - (step_over - half) * cosine
    by_ends = half + behind
    covered = np.where((gap < half) & (behind * slant >= gap * cosine), by_ends, by_sides)
    return np.maximum(np.minimum(filled, covered), nearest_end(step_over, width))


def drawn_back(areas: Sequence[FillArea], points: Array, along: Array) -> Array:
    """Lines (n, 2, 2) that end as near to the contour as any may, along the unit vector, drawn back by their slants."""
    area = areas[0]
    if not len(points):
        return points
    flat = np.concatenate([points[:, 0], points[:, 1]])
    _, away = Outline([c.piece for c in areas], abs(area.inset) + area.step_over).distances(flat)
    slant = np.clip(np.abs(away @ along), LEAST_SLANT, 1.0)
    back = (ends_from_contour(slant, area.step_over, area.width) - nearest_end(area.step_over, area.width)) / slant
    back = back.reshape(2, -1)
    length = (points[:, 1] - points[:, 0]) @ along
    most = np.maximum(length - LEAST_LEFT * area.width, 0.0)
    back *= np.minimum(1.0, most / np.maximum(back.sum(axis=0), 1e-300))
    return points + np.stack([back[0], -back[1]], axis=1)[:, :, None] * along


def with_room(area: FillArea, points: Array) -> NDArray[np.bool_]:
    """Which lines (n, 2, 2) to keep: not those left without room between their borders, if contours and neighbours cover it."""
    import shapely

    kept = np.ones(len(points), dtype=bool)
    tight = np.flatnonzero(np.hypot(*(points[:, 1] - points[:, 0]).T) <= (1.0 + LEAST_SLANT) * LEAST_LEFT * area.width)
    if not len(tight):
        return kept
    closure = area.piece.closure
    contours = [shapely.LineString(closure.moved(bead.points, k)) for bead in area.laid for k in area.piece.beside]
    lines = np.array([*shapely.linestrings(points), *contours])
    tree, half, present = shapely.STRtree(lines), 0.5 * area.width, np.ones(len(lines), dtype=bool)
    for i in tight.tolist():
        near = tree.query(lines[i], predicate="dwithin", distance=area.width)
        near = near[present[near] & (near != i)]
        bare = lines[i].buffer(half).difference(shapely.union_all(shapely.buffer(lines[near], half)))
        if bare.area <= (BARE_SPOT * area.width) ** 2:
            kept[i] = present[i] = False
    return kept
