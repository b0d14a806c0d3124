"""The deposit simulated: bead cross-sections superposed on an unrolled grid.

In: a region, beads, width, layer thickness, step-over. Out: a height map and how even it is.

A bead's cross-section is a parabola of width w whose area is t d, the metal of one step-over: h(s) = h0 (1 - (2 s / w)**2) with
h0 = 3 t d / (2 w). Beads that are a step-over apart then add up to t in the mean. The metal is laid by a round drop that moves
along the bead: half an ellipsoid, the one drop that leaves this parabola. So a bead lays t d times its length whatever its
corners, and it does not matter into which segments its line is cut. Only at its own ends it is as high as elsewhere, and round:
3 pi w / 32 of its length are laid beyond each.
"""

from __future__ import annotations

import itertools
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
    """One track: the drop's heights integrated along each segment, in closed form, and the bead's own ends made round."""
    half, new = 0.5 * width, np.append(True, np.hypot(*np.diff(track.points, axis=0).T) > 0.0)
    points, amount = track.points[new], 1.0 / track.speed[new]
    if len(points) < 2:
        return
    for i, (a, b) in enumerate(itertools.pairwise(points)):
        r, c, along, across = _near(kappa, v, a, b, half)
        length = float(np.hypot(*(b - a)))
        slope = float(amount[i + 1] - amount[i]) / length
        heights[r, c] += top * _laid(along, across, (0.0, length), half, (float(amount[i]), slope))
    for mine, tip, before, metal in zip(track.ends, points[[0, -1]], points[[1, -2]], amount[[0, -1]], strict=True):
        if mine:
            outwards = half / np.hypot(*(tip - before)) * (tip - before)
            r, c, along, across = _near(kappa, v, tip, tip + outwards, half)
            straight = _laid(along, across, (-width, 0.0), half, (1.0, 0.0))
            round_end = np.maximum(0.0, 1.0 - (across**2 + np.maximum(along, 0.0) ** 2) / half**2)
            # behind the end the bead goes on; farther back than its drop reaches there is nothing to add
            heights[r, c] += float(metal) * top * np.where(along > -half, round_end - straight, 0.0)


def _near(kappa: Array, v: Array, a: Array, b: Array, half: float) -> tuple[slice, slice, Array, Array]:
    """The rows and columns within `half` of a segment's box, and where their cells lie along and across it, seen from `a`."""
    r = slice(*np.searchsorted(v, [min(a[1], b[1]) - half, max(a[1], b[1]) + half]))
    c = slice(*np.searchsorted(kappa, [min(a[0], b[0]) - half, max(a[0], b[0]) + half]))
    x, y = kappa[c][None, :] - a[0], v[r][:, None] - a[1]
    ahead, beside = (b - a) / np.hypot(*(b - a))
    return r, c, x * ahead + y * beside, y * ahead - x * beside


def _laid(along: Array, across: Array, span: tuple[float, float], half: float, amount: tuple[float, float]) -> Array:
    """Heights over h0 that the drop 2 / pi sqrt(half**2 - r**2) / half**2 leaves on its way from span[0] to span[1].

    `amount` is the metal per length at 0, and how it changes along the way.
    """
    reach = np.sqrt(np.maximum(half**2 - across**2, 1e-300))
    start, end = np.clip(span[0] - along, -reach, reach), np.clip(span[1] - along, -reach, reach)
    out = (amount[0] + amount[1] * along) * (_area(end, reach) - _area(start, reach))
    if amount[1]:
        out += amount[1] * (_moment(end, reach) - _moment(start, reach))
    return 2.0 / (np.pi * half**2) * out


def _area(u: Array, reach: Array) -> Array:
    """Integral of sqrt(reach**2 - u**2)."""
    return 0.5 * (u * np.sqrt(np.maximum(reach**2 - u**2, 0.0)) + reach**2 * np.arcsin(u / reach))


def _moment(u: Array, reach: Array) -> Array:
    """Integral of u sqrt(reach**2 - u**2)."""
    return -(np.maximum(reach**2 - u**2, 0.0) ** 1.5) / 3.0


def _averaged(heights: Array, inside: Array, cells: float) -> Array:
    """Mean over a square of `cells` a side, of the region's cells only."""
    from scipy.ndimage import uniform_filter

    size = max(1, round(cells))
    weight = uniform_filter(inside.astype(float), size, mode="constant")
    return uniform_filter(np.where(inside, heights, 0.0), size, mode="constant") / np.maximum(weight, 1e-12)
