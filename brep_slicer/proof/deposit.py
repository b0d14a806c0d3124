"""The deposit simulated: bead cross-sections superposed on an unrolled grid.

In: a region, beads, width, layer thickness, step-over. Out: a height map and how even it is.

A bead's cross-section is a parabola of width w whose area is t d, the metal of one step-over: h(s) = h0 (1 - (2 s / w)**2) with
h0 = 3 t d / (2 w). Beads that are a step-over apart then add up to t in the mean. The metal is laid by a round drop that moves
along the bead: half an ellipsoid, the one drop that leaves this parabola. So a bead lays t d times its length whatever its
corners, and it does not matter into which segments its line is cut. Only at its own ends it is as high as elsewhere, and round:
3 pi w / 32 of its length are laid beyond each.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from brep_slicer.fill import Bead
from brep_slicer.maps import Array
from brep_slicer.region import Region

from .chart import Track, drawn
from .equals import Share
from .grid import Tile, cells_inside, cells_of_boxes, edges_of_polygons, tiles_of

# Grid cells a bead width.
CELLS_PER_WIDTH = 24
# Heights are averaged over a square of this many step-overs: the ripple from bead to bead is no unevenness of the layer.
WINDOW = 2.0
# A peak is the highest mean over a square of this many bead widths: about what is molten at once, and levels out. The highest
# single cell would be that of one bead's ridge, whatever lies beside it.
PEAK_WINDOW = 0.5
# Cells a side of what is worked out at once, and cells of beads: what bounds the memory, not what comes out.
TILE, AT_ONCE = 768, 1_000_000
# A piece that stands for others is looked at on so many grids, each a part of a cell beside the one before.
PHASES = 4


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


@dataclass(frozen=True, slots=True, kw_only=True)
class Evenness:
    """`mean` (mm) of a layer's heights, their `variation` (standard deviation over mean), and the share of the region whose
    averaged height is `within` a tolerance of the layer's thickness.

    `peak` (mm) is the highest mean over a square of half a bead's width, and `peak_at` its middle, (kappa, v) in mm.
    """

    mean: float
    variation: float
    within: float
    peak: float = 0.0
    peak_at: tuple[float, float] | None = None


def deposit_of(
    region: Region,
    beads: Sequence[Bead],
    *,
    width: float,
    thickness: float,
    step_over: float,
    window: tuple[float, float, float, float] | None = None,
    cell: float | None = None,
) -> Deposit:
    """Superpose the cross-sections of all beads of a layer.

    Parameters
    ----------
    width, thickness, step_over : float
        w, t and d in mm; where a bead's speed varies, its metal varies with the inverse of it.
    window : (left, low, right, top), optional
        Only what of the region lies in this box (mm).
    cell : float, optional
        Size of a cell, mm; by default a 24th of the width.
    """
    import shapely

    shape, tracks = drawn(region, beads, reach=width)
    if window is not None:
        shape = shapely.intersection(shape, shapely.box(*window))
    cell = cell or width / CELLS_PER_WIDTH
    k0, v0, k1, v1 = shape.bounds if not shape.is_empty else (0.0, 0.0, 0.0, 0.0)
    rows, columns = (max(1, int(np.ceil(extent / cell))) for extent in (v1 - v0, k1 - k0))
    tile = Tile(cell=cell, origin=(k0, v0), row=0, column=0, shape=(rows, columns))
    laid = _Laid(tracks, width, 1.5 * thickness * step_over / width)
    heights, inside = laid.heights(tile), cells_inside(edges_of_polygons(shape), tile)
    chosen = np.flatnonzero(inside)
    even = np.full(heights.shape, np.nan)
    even.ravel()[chosen] = _averaged(heights, inside, _window(step_over, cell), chosen)
    heights = np.where(inside, heights, np.nan)
    mean = float(np.nanmean(heights)) if inside.any() else 0.0
    variation = float(np.nanstd(heights)) / mean if mean else 0.0
    return Deposit(kappa=tile.kappa, v=tile.v, heights=heights, even=even, mean=mean, variation=variation)


def evenness_of(
    region: Region,
    beads: Sequence[Bead],
    *,
    width: float,
    thickness: float,
    step_over: float,
    tolerance: float,
    shares: Sequence[Share] | None = None,
) -> Evenness:
    """What `deposit_of` says of a layer as figures, worked out tile by tile: no more of the plane than holds metal.

    `tolerance` is a share of `thickness`. Of `shares`, if given, each counts as many times as it says, instead of the region.
    """
    parts = [Share(region=region, beads=tuple(beads), times=1)] if shares is None else shares
    sizes = {"width": width, "thickness": thickness, "step_over": step_over, "tolerance": tolerance}
    sums: list[Array] = []
    peaks: list[tuple[float, tuple[float, float]]] = []
    for part in parts:
        # pieces of a whole layer lie on the grid in as many ways as there are pieces
        phases = min(part.times, PHASES)
        # not the corner itself, where cells' middles would lie on the border
        shifts = (
            [((k + 0.5) / phases, ((k * k + k) / 2 % phases + 0.5) / phases) for k in range(phases)]
            if phases > 1
            else [(0.0, 0.0)]
        )
        cell = _fitting_cell(part.region, width / CELLS_PER_WIDTH, phases)
        for shift in shifts:
            made, highest = _sums(part.region, part.beads, cell, shift, **sizes)
            sums.append(np.multiply(part.times / phases, made))
            peaks += highest
    count, total, square, good = np.sum(sums, axis=0).tolist()
    if not count:
        return Evenness(mean=0.0, variation=0.0, within=0.0)
    mean = thickness + total / count
    deviation = np.sqrt(max(square / count - (total / count) ** 2, 0.0))
    peak, peak_at = max(peaks)
    variation = float(deviation) / mean if mean else 0.0
    return Evenness(mean=mean, variation=variation, within=good / count, peak=peak, peak_at=peak_at)


def _fitting_cell(region: Region, cell: float, phases: int) -> float:
    """A cell hardly smaller, of which all `phases` together fit the first piece's length round the shaft."""
    if phases == 1:
        return cell
    k0, _, k1, _ = region.pieces[0].bounds()
    return phases * (k1 - k0) / float(np.ceil(phases * (k1 - k0) / cell))


def _sums(
    region: Region,
    beads: Sequence[Bead],
    cell: float,
    shift: tuple[float, float],
    *,
    width: float,
    thickness: float,
    step_over: float,
    tolerance: float,
) -> tuple[tuple[float, float, float, float], list[tuple[float, tuple[float, float]]]]:
    """Over a region's cells: how many, their heights over the thickness added up (mm), squared, and how many are even.

    And the peak of each tile (mm) with its place, if it holds any of the region.

    The grid begins so many cells to the left of the region and below it as `shift` says.
    """
    shape, tracks = drawn(region, beads, reach=width)
    laid, edges = _Laid(tracks, width, 1.5 * thickness * step_over / width), edges_of_polygons(shape)
    size, small = _window(step_over, cell), max(1, round(PEAK_WINDOW * width / cell))
    count, total, square, good = 0, 0.0, 0.0, 0
    peaks = []
    for tile in tiles_of(shape, cell, TILE, shift):
        wide = tile.with_halo(size)
        inside = cells_inside(edges, wide)
        own = np.zeros_like(inside)
        own[size:-size, size:-size] = inside[size:-size, size:-size]
        chosen = np.flatnonzero(own)
        heights = laid.heights(wide)
        # about t, so that the squares do not drown what they differ by
        off = heights.ravel()[chosen] - thickness
        count += len(off)
        total += float(off.sum())
        square += float(off @ off)
        even = _averaged(heights, inside, size, chosen)
        good += int((np.abs(even / thickness - 1.0) <= tolerance).sum())
        if len(chosen):
            ridges = _box_sums(heights, small).ravel()[chosen]
            row, column = divmod(int(chosen[ridges.argmax()]), wide.shape[1])
            peaks.append((float(ridges.max()) / small**2, (float(wide.kappa[column]), float(wide.v[row]))))
    return (count, total, square, good), peaks


def _window(step_over: float, cell: float) -> int:
    """Cells a side of the square that heights are averaged over."""
    return max(1, round(WINDOW * step_over / cell))


class _Laid:
    """The metal of all tracks, segment by segment: the drop's heights integrated along each, and the beads' own ends round.

    Segments run from `a` along the unit vector `way` for `length`; `amount` (n,) is their metal per length over t d. Ends lie
    at `tip`, and `out` is where the bead would go on; their metal is that of the segment that they end.
    """

    def __init__(self, tracks: Sequence[Track], width: float, top: float) -> None:
        self.half, self.top = 0.5 * width, top
        a, along, amounts = [np.zeros((0, 2))], [np.zeros((0, 2))], [np.zeros(0)]
        tips: list[tuple[Array, Array, float]] = []
        for track in tracks:
            steps = np.diff(track.points, axis=0)
            new = np.hypot(*steps.T) > 0.0
            # as in the toolpath: a segment is laid at the mean of the speeds at its ends
            amount = (2.0 / (track.speed[1:] + track.speed[:-1]))[new]
            if not new.any():
                continue
            a.append(track.points[:-1][new])
            along.append(steps[new])
            amounts.append(amount)
            ends = zip(
                track.ends, track.points[[0, -1]], (-steps[new][0], steps[new][-1]), amount[[0, -1]].tolist(), strict=True
            )
            tips += [(tip, out, metal) for mine, tip, out, metal in ends if mine]
        self.a, way = np.concatenate(a), np.concatenate(along)
        self.length = np.hypot(*way.T)
        self.way = way / self.length[:, None]
        self.amount = np.concatenate(amounts)
        self.tip = np.array([tip for tip, _, _ in tips]).reshape(-1, 2)
        out = np.array([out for _, out, _ in tips]).reshape(-1, 2)
        self.out = out / np.hypot(*out.T)[:, None]
        self.metal = np.array([metal for _, _, metal in tips])

    def heights(self, tile: Tile) -> Array:
        """Heights (mm) in the middles of a tile's cells."""
        out = np.zeros(tile.shape[0] * tile.shape[1])
        for of, cell, along, across in self._near(self.a, self.way, self.length, tile):
            np.add.at(out, cell, self.top * self._of_segments(of, along, across))
        for of, cell, along, across in self._near(self.tip, self.out, np.zeros(len(self.tip)), tile):
            np.add.at(out, cell, self.top * self._of_ends(of, along, across))
        return out.reshape(tile.shape)

    def _near(self, start: Array, way: Array, length: Array, tile: Tile) -> Iterator[tuple[Array, Array, Array, Array]]:
        """(number, cell, along, across) of the cells that a drop reaches from each way, where they lie seen from its start."""
        left, low, right, top = tile.box
        end = start + length[:, None] * way
        near = np.flatnonzero(
            (np.maximum(start, end) > np.array([left, low]) - self.half).all(axis=1)
            & (np.minimum(start, end) < np.array([right, top]) + self.half).all(axis=1)
        )
        ahead, beside = self.half * way, self.half * np.stack([-way[:, 1], way[:, 0]], axis=1)
        corners = np.stack([start - ahead - beside, end + ahead - beside, end + ahead + beside, start - ahead + beside], axis=1)
        size = (length[near] / tile.cell + CELLS_PER_WIDTH) * CELLS_PER_WIDTH
        kappa, v = tile.kappa, tile.v
        for part in np.split(near, np.flatnonzero(np.diff((np.cumsum(size) // AT_ONCE).astype(int))) + 1):
            of, cell = cells_of_boxes(corners[part], tile)
            of = part[of]
            row, column = np.divmod(cell, tile.shape[1])
            x, y = kappa[column] - start[of, 0], v[row] - start[of, 1]
            ahead_x, ahead_y = way[of].T
            yield of, cell, x * ahead_x + y * ahead_y, y * ahead_x - x * ahead_y

    def _of_segments(self, of: Array, along: Array, across: Array) -> Array:
        square = np.maximum(self.half**2 - across**2, 1e-300)
        # the drop passes over the whole cell, but for the ends of its way
        out = (0.5 * np.pi) * square
        length = self.length[of]
        some = np.flatnonzero((along < self.half) | (along > length - self.half))
        reach = np.sqrt(square[some])
        begin, end = np.clip(-along[some], -reach, reach), np.clip(length[some] - along[some], -reach, reach)
        out[some] = _area(end, reach) - _area(begin, reach)
        return 2.0 / (np.pi * self.half**2) * self.amount[of] * out

    def _of_ends(self, of: Array, along: Array, across: Array) -> Array:
        """What makes an end round and as high as elsewhere, less what the drop has laid there when it stops."""
        reach = np.sqrt(np.maximum(self.half**2 - across**2, 1e-300))
        begin, end = np.clip(-2.0 * self.half - along, -reach, reach), np.clip(-along, -reach, reach)
        straight = 2.0 / (np.pi * self.half**2) * (_area(end, reach) - _area(begin, reach))
        round_end = np.maximum(0.0, 1.0 - (across**2 + np.maximum(along, 0.0) ** 2) / self.half**2)
        # behind the end the bead goes on; farther back than its drop reaches there is nothing to add
        return self.metal[of] * np.where(along > -self.half, round_end - straight, 0.0)


def _area(u: Array, reach: Array) -> Array:
    """Integral of sqrt(reach**2 - u**2)."""
    return 0.5 * (u * np.sqrt(np.maximum(reach**2 - u**2, 0.0)) + reach**2 * np.arcsin(u / reach))


def _averaged(heights: Array, inside: Array, size: int, chosen: Array) -> Array:
    """Means over squares of `size` cells a side round the `chosen` cells (n,), of the region's cells only.

    A square of an even size has one cell more before its middle than behind it. Where it reaches beyond the arrays there is no
    metal.
    """
    metal = _box_sums(np.where(inside, heights, 0.0), size).ravel()[chosen]
    if inside.all():
        return metal / _box_sums(np.ones(inside.shape), size).ravel()[chosen]
    return metal / _box_sums(inside.astype(np.float64), size).ravel()[chosen]


def _box_sums(values: Array, size: int) -> Array:
    """Sums over squares of cells, one direction after the other."""
    for axis in (0, 1):
        count = values.shape[axis]
        total = np.cumsum(values, axis=axis)
        low, high = np.arange(count) - size // 2 - 1, np.minimum(np.arange(count) + size - size // 2, count) - 1
        sums = total.take(high, axis=axis)
        some = np.flatnonzero(low >= 0)
        if len(some):
            at = (slice(some[0], None), slice(None)) if axis == 0 else (slice(None), slice(some[0], None))
            sums[at] -= total.take(low[some], axis=axis)
        values = sums
    return values
