"""The deposit simulated: bead cross-sections superposed on an unrolled grid.

In: a region, beads, width, layer thickness, step-over. Out: a height map and how even it is.

A bead's cross-section is a parabola of width w whose area is t d, the metal of one step-over: h(s) = h0 (1 - (2 s / w)**2) with
h0 = 3 t d / (2 w). Beads that are a step-over apart then add up to t in the mean.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from brep_slicer.fill import Bead
from brep_slicer.maps import Array
from brep_slicer.region import Region

from .chart import Track, drawn

# Grid cells a bead width.
CELLS_PER_WIDTH = 24
# Heights are averaged over a square of this many step-overs: the ripple from bead to bead is no unevenness of the layer.
WINDOW = 2.0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Deposit:
    """`heights` (n, m) in mm on the grid `kappa` (m,), `v` (n,), nan outside of the region.

    `mean` (mm) and `variation` (standard deviation over mean) of the heights, `even` (n, m) the same heights averaged over a
    square of two step-overs.
    """

    kappa: Array
    v: Array
    heights: Array
    even: Array
    mean: float
    variation: float

    def share_within(self, thickness: float, tolerance: float) -> float:
        """Share of the region whose averaged height is within `tolerance` (a share) of `thickness` (mm)."""
        known = np.isfinite(self.even)
        return float((np.abs(self.even[known] / thickness - 1.0) <= tolerance).mean()) if known.any() else 0.0


def deposit_of(region: Region, beads: Sequence[Bead], *, width: float, thickness: float, step_over: float) -> Deposit:
    """Superpose the cross-sections of all beads of a layer.

    Parameters
    ----------
    width, thickness, step_over : float
        w, t and d in mm; where a bead's speed varies, its metal varies with the inverse of it.
    """
    import shapely

    shape, tracks = drawn(region, beads, reach=width)
    cell = width / CELLS_PER_WIDTH
    k0, v0, k1, v1 = shape.bounds if not shape.is_empty else (0.0, 0.0, 0.0, 0.0)
    kappa = k0 + (np.arange(max(1, int(np.ceil((k1 - k0) / cell)))) + 0.5) * cell
    v = v0 + (np.arange(max(1, int(np.ceil((v1 - v0) / cell)))) + 0.5) * cell
    heights = np.zeros((len(v), len(kappa)))
    top = 1.5 * thickness * step_over / width
    for track in tracks:
        _add(heights, kappa, v, track, width, top)
    inside = shapely.contains_xy(shape, *np.meshgrid(kappa, v)) if not shape.is_empty else np.zeros(heights.shape, dtype=bool)
    even = np.where(inside, _averaged(heights, inside, WINDOW * step_over / cell), np.nan)
    heights = np.where(inside, heights, np.nan)
    mean = float(np.nanmean(heights)) if inside.any() else 0.0
    variation = float(np.nanstd(heights)) / mean if mean else 0.0
    return Deposit(kappa=kappa, v=v, heights=heights, even=even, mean=mean, variation=variation)


def _add(heights: Array, kappa: Array, v: Array, track: Track, width: float, top: float) -> None:
    """One track, segment by segment: each cell takes what the nearest place of the track lays."""
    half, points = 0.5 * width, track.points
    rows = slice(*np.searchsorted(v, [points[:, 1].min() - half, points[:, 1].max() + half]))
    columns = slice(*np.searchsorted(kappa, [points[:, 0].min() - half, points[:, 0].max() + half]))
    near = np.full((rows.stop - rows.start, columns.stop - columns.start), np.inf)
    metal = np.ones_like(near)
    amount, last = 1.0 / track.speed, len(points) - 2
    for i in range(last + 1):
        a, b = points[i], points[i + 1]
        r = slice(*np.searchsorted(v[rows], [min(a[1], b[1]) - half, max(a[1], b[1]) + half]))
        c = slice(*np.searchsorted(kappa[columns], [min(a[0], b[0]) - half, max(a[0], b[0]) + half]))
        x, y = kappa[columns][c][None, :] - a[0], v[rows][r][:, None] - a[1]
        d = b - a
        along = (x * d[0] + y * d[1]) / max(float(d @ d), 1e-300)
        share = np.clip(along, 0.0, 1.0)
        gap = np.hypot(x - share * d[0], y - share * d[1])
        # where the bead goes on, its next track lays what lies beyond
        beyond = ((along < 0.0) & (i == 0) & (not track.ends[0])) | ((along > 1.0) & (i == last) & (not track.ends[1]))
        gap = np.where(beyond, np.inf, gap)
        closer = gap < near[r, c]
        near[r, c] = np.where(closer, gap, near[r, c])
        metal[r, c] = np.where(closer, (1.0 - share) * amount[i] + share * amount[i + 1], metal[r, c])
    heights[rows, columns] += metal * top * np.maximum(0.0, 1.0 - (2.0 * np.minimum(near, width) / width) ** 2)


def _averaged(heights: Array, inside: Array, cells: float) -> Array:
    """Mean over a square of `cells` a side, of the region's cells only."""
    from scipy.ndimage import uniform_filter

    size = max(1, round(cells))
    weight = uniform_filter(inside.astype(float), size, mode="constant")
    return uniform_filter(np.where(inside, heights, 0.0), size, mode="constant") / np.maximum(weight, 1e-12)
