"""A grid of square cells over the plane, cut into tiles: only those that hold metal are ever in memory.

In: a cell's size, where the grid begins, a box. Out: tiles; the cells of a polygon, of many boxes at any angle.

Words: *tile*, a block of cells; *halo*, cells round it that are worked out with it, so that means over neighbours are right at
its border; *span*, the cells of one row in one box.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from brep_slicer.maps import Array


@dataclass(frozen=True, slots=True, kw_only=True)
class Tile:
    """Cells of `cell` mm from (`row`, `column`) on, `shape` of them, of a grid whose lower left corner is `origin` (mm)."""

    cell: float
    origin: tuple[float, float]
    row: int
    column: int
    shape: tuple[int, int]

    @property
    def kappa(self) -> Array:
        """Middles of the columns, mm."""
        return self.origin[0] + (self.column + np.arange(self.shape[1]) + 0.5) * self.cell

    @property
    def v(self) -> Array:
        """Middles of the rows, mm."""
        return self.origin[1] + (self.row + np.arange(self.shape[0]) + 0.5) * self.cell

    @property
    def box(self) -> tuple[float, float, float, float]:
        """Left, low, right, top of its cells, mm."""
        left, low = self.origin[0] + self.column * self.cell, self.origin[1] + self.row * self.cell
        return left, low, left + self.shape[1] * self.cell, low + self.shape[0] * self.cell

    def with_halo(self, cells: int) -> Tile:
        """The tile and so many cells more on every side."""
        rows, columns = self.shape
        return Tile(
            cell=self.cell,
            origin=self.origin,
            row=self.row - cells,
            column=self.column - cells,
            shape=(rows + 2 * cells, columns + 2 * cells),
        )


def tiles_of(shape, cell: float, size: int, shift: tuple[float, float] = (0.0, 0.0)) -> Iterator[Tile]:
    """The tiles of at most `size` cells a side that a polygon reaches into.

    The grid begins at its lower left corner, or `shift` of a cell to the left and below.
    """
    import shapely

    if shape.is_empty:
        return
    k0, v0, k1, v1 = shape.bounds
    k0, v0 = k0 - shift[0] * cell, v0 - shift[1] * cell
    columns, rows = max(1, int(np.ceil((k1 - k0) / cell))), max(1, int(np.ceil((v1 - v0) / cell)))
    corners = [(i, j) for i in range(0, rows, size) for j in range(0, columns, size)]
    tiles = [
        Tile(cell=cell, origin=(k0, v0), row=i, column=j, shape=(min(size, rows - i), min(size, columns - j)))
        for i, j in corners
    ]
    shapely.prepare(shape)
    met = shapely.intersects(shape, shapely.box(*np.array([tile.box for tile in tiles]).T))
    yield from (tile for tile, some in zip(tiles, met, strict=True) if some)


def edges_of_polygons(shape) -> Array:
    """Every edge of every ring of a polygon or several, (n, 2, 2), mm."""
    import shapely

    rings = shapely.get_rings(shapely.get_parts(shape))
    points, of = shapely.get_coordinates(rings, return_index=True)
    joins = of[1:] == of[:-1]
    return np.stack([points[:-1][joins], points[1:][joins]], axis=1)


def cells_inside(edges: Array, tile: Tile) -> NDArray[np.bool_]:
    """Which cells have their middle inside of rings with these `edges` (n, 2, 2): an odd number of edges to the left."""
    left, low, _, _ = tile.box
    a, b = edges[:, 0], edges[:, 1]
    # in cells, so that middles lie at whole numbers
    ya, yb = ((p[:, 1] - low) / tile.cell - 0.5 for p in (a, b))
    first = np.clip(np.ceil(np.minimum(ya, yb)), 0, tile.shape[0]).astype(int)
    count = np.clip(np.ceil(np.maximum(ya, yb)), 0, tile.shape[0]).astype(int) - first
    of = np.repeat(np.arange(len(edges)), count)
    row = np.arange(len(of)) - np.repeat(np.cumsum(count) - count, count) + first[of]
    share = (row - ya[of]) / (yb - ya)[of]
    x = (a[of, 0] + share * (b - a)[of, 0] - left) / tile.cell - 0.5
    column = np.clip(np.ceil(x), 0, tile.shape[1]).astype(int)
    wide = tile.shape[1] + 1
    crossed = (np.bincount(row * wide + column, minlength=tile.shape[0] * wide) & 1).astype(bool).reshape(-1, wide)
    inside: NDArray[np.bool_] = np.logical_xor.accumulate(crossed, axis=1)[:, :-1]
    return inside


def cells_of_boxes(corners: Array, tile: Tile) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """(box, cell of the tile, row by row) of every middle of a cell in one of the convex boxes (n, 4, 2)."""
    left, low, _, _ = tile.box
    places = (corners - np.array([left, low])) / tile.cell - 0.5
    y = places[..., 1]
    first = np.clip(np.ceil(y.min(axis=1, initial=np.inf)), 0, tile.shape[0]).astype(int)
    rows = np.maximum(np.clip(np.ceil(y.max(axis=1, initial=-np.inf)), 0, tile.shape[0]).astype(int) - first, 0)
    of = np.repeat(np.arange(len(corners)), rows)
    row = np.arange(len(of)) - np.repeat(np.cumsum(rows) - rows, rows) + first[of]
    begin, end = np.full(len(of), np.inf), np.full(len(of), -np.inf)
    for k in range(4):
        p, q = places[of, k], places[of, (k + 1) % 4]
        crosses = (p[:, 1] <= row) != (q[:, 1] <= row)
        rise = np.where(crosses, q[:, 1] - p[:, 1], 1.0)
        x = p[:, 0] + (row - p[:, 1]) / rise * (q[:, 0] - p[:, 0])
        begin = np.minimum(begin, np.where(crosses, x, np.inf))
        end = np.maximum(end, np.where(crosses, x, -np.inf))
    begin, end = (np.clip(np.ceil(np.where(begin <= end, x, 0.0)), 0, tile.shape[1]).astype(int) for x in (begin, end))
    count = np.maximum(end - begin, 0)
    cell = np.repeat(row * tile.shape[1] + begin - (np.cumsum(count) - count), count) + np.arange(count.sum())
    return np.repeat(of, count), cell
