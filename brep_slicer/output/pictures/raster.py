"""Triangles and lines seen from one side, drawn into a pixel grid with a depth for every pixel.

In: corners on the page and their depths, as arrays. Out: for every pixel the triangle that is seen there, and its depth.

Words: *depth*, mm towards the eye: the larger one hides the smaller; *span*, the pixels of one row in one triangle; *fragment*,
one pixel of one triangle; *plane*, a value at the page's origin and by how much it grows a pixel to the right and down. Pixels
are numbered row by row, the first at the top left.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from brep_slicer.maps import Array

# Fragments that are worked on at once: some megabytes, which a processor keeps at hand.
AT_ONCE = 100_000
# Depths are held as whole numbers of so many steps, beside the number of the triangle in the lower half of 64 bits.
DEPTH_STEPS, NUMBER_BITS = 1 << 30, 32
# Triangles of less than this, in pixels, are lines: they have no plane.
FLAT = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Seen:
    """What every pixel shows: `triangle` (h w,), -1 where there is none, and `depth` (h w,), -inf there."""

    triangle: NDArray[np.int64]
    depth: Array


def seen(places: Array, depth: Array, triangles: Array, size: tuple[int, int], *, both_sides: bool = False) -> Seen:
    """The nearest triangle at every pixel, of those that face the eye (their corners go round clockwise with y down).

    Parameters
    ----------
    places : ndarray, shape (n, 2)
        In pixels, x to the right and y down.
    depth : ndarray, shape (n,)
        mm towards the eye.
    triangles : ndarray of int, shape (m, 3)
        Counter-clockwise from outside with y up, which is clockwise with y down.
    size : (int, int)
        Height and width of the page in pixels.
    both_sides : bool
        Whether triangles that face away are seen, too.
    """
    keys = np.zeros(size[0] * size[1], dtype=np.int64)
    low, high = (float(depth.min()), float(depth.max())) if len(depth) else (0.0, 0.0)
    scale = (DEPTH_STEPS - 4) / max(high - low, 1e-300)
    numbers = _met(places, triangles, size)
    if not both_sides:
        numbers = numbers[_facing(places, triangles[numbers])]
    planes = planes_of(places, (depth - low) * scale + 1.0, triangles[numbers]).T.copy()
    for of, row, begin, count in _spans(places, triangles[numbers], size):
        before = np.cumsum(count) - count
        span = np.repeat(np.arange(len(count)), count)
        step = np.arange(len(span)) - before[span]
        base, right, down = (column[of] for column in planes)
        z = (base + right * (begin + 0.5) + down * (row + 0.5))[span] + right[span] * step
        key = np.clip(z, 1.0, DEPTH_STEPS - 1, out=z).astype(np.int64) << NUMBER_BITS
        np.maximum.at(keys, (row * size[1] + begin)[span] + step, key | numbers[of][span])
    hit = keys > 0
    return Seen(
        triangle=np.where(hit, keys & ((1 << NUMBER_BITS) - 1), -1),
        depth=np.where(hit, ((keys >> NUMBER_BITS) - 1.0) / scale + low, -np.inf),
    )


def along(points: Array, way: Array) -> Array:
    """How far points (n, 3) lie along a vector (3,); a library's threads would take longer to wake than this takes."""
    return points[:, 0] * way[0] + points[:, 1] * way[1] + points[:, 2] * way[2]


def planes_of(places: Array, values: Array, triangles: Array) -> Array:
    """The plane (m, 3) of `values` (n,) at the corners of each triangle."""
    a, b, c = (places[triangles[:, k]] for k in range(3))
    va, vb, vc = (values[triangles[:, k]] for k in range(3))
    area = _cross(b - a, c - a)
    area = np.where(np.abs(area) < FLAT, np.inf, area)
    right = ((vb - va) * (c - a)[:, 1] - (vc - va) * (b - a)[:, 1]) / area
    down = ((vc - va) * (b - a)[:, 0] - (vb - va) * (c - a)[:, 0]) / area
    return np.stack([va - right * a[:, 0] - down * a[:, 1], right, down], axis=1)


def values_at(planes: Array, owner: Array, pixel: Array, width: int) -> Array:
    """The value of plane `owner` (n,) at each `pixel` (n,) of a page that is `width` pixels wide."""
    row, column = np.divmod(pixel, width)
    base, right, down = planes.T
    return base[owner] + right[owner] * (column + 0.5) + down[owner] * (row + 0.5)


def _cross(a: Array, b: Array) -> Array:
    return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]


def _facing(places: Array, triangles: Array) -> Array:
    a, b, c = (places[triangles[:, k]] for k in range(3))
    return _cross(b - a, c - a) < 0.0


def _met(places: Array, triangles: Array, size: tuple[int, int]) -> NDArray[np.int64]:
    """The triangles that may have a pixel's middle in them: small ones lie between, others beside the page."""
    met = np.ones(len(triangles), dtype=bool)
    for values, end in ((places[:, 0], size[1]), (places[:, 1], size[0])):
        # as whole pixels, which is less to move about
        pixels = np.clip(np.ceil(values - 0.5), 0, end).astype(np.int32)
        a, b, c = (pixels[triangles[:, k]] for k in range(3))
        met &= (a != b) | (b != c)
    return np.flatnonzero(met)


def _spans(places: Array, triangles: Array, size: tuple[int, int]) -> list[tuple[Array, Array, Array, Array]]:
    """(triangle, row, first column, number of columns) of every row in every triangle, in lists that are soon done."""
    height, width = size
    x, y = places.T
    rank = np.stack([y[triangles[:, k]] for k in range(3)])
    low, high = rank.argmin(axis=0), rank.argmax(axis=0)
    # those whose corners are level have no rows
    low, middle, high = (triangles[np.arange(len(triangles)), k] for k in (low, np.minimum(3 - low - high, 2), high))
    first, last = (np.clip(np.ceil(y[k] - 0.5), 0, height).astype(int) for k in (low, high))
    rows = last - first
    of = np.repeat(np.arange(len(triangles)), rows)
    row = np.arange(len(of)) - (np.cumsum(rows) - rows - first)[of]
    # each row meets the side from the lowest to the highest corner, and one of the two others
    at, k = row + 0.5, len(triangles)
    start = np.concatenate([low, middle, low])
    way_x, way_y = x[np.concatenate([middle, high, high])] - x[start], y[np.concatenate([middle, high, high])] - y[start]
    lean = way_x / np.where(way_y == 0.0, np.inf, way_y)
    a, b = (x[start][s] + (at - y[start][s]) * lean[s] for s in (of + k * (at >= y[middle][of]), of + 2 * k))
    begin = np.clip(np.ceil(np.minimum(a, b) - 0.5), 0, width).astype(int)
    count = np.clip(np.ceil(np.maximum(a, b) - 0.5), 0, width).astype(int) - begin
    some = count > 0
    of, row, begin, count = of[some], row[some], begin[some], count[some]
    total = np.cumsum(count)
    cuts = np.searchsorted(total, np.arange(AT_ONCE, total[-1] if len(total) else 0, AT_ONCE))
    return list(zip(*(np.split(column, cuts) for column in (of, row, begin, count)), strict=True))


def dots_on_lines(places: Array, depth: Array, pairs: Array, size: tuple[int, int]) -> tuple[Array, Array]:
    """(pixels, depths) of lines between `pairs` (k, 2) of points, a dot a pixel; pixels may come several times."""
    height, width = size
    a, b = places[pairs[:, 0]], places[pairs[:, 1]]
    page = np.array([width, height], dtype=float)
    # lines that lie off the page on one side need no dots
    on = ((np.maximum(a, b) > 0.0) & (np.minimum(a, b) < page)).all(axis=1)
    a, b, za, zb = a[on], b[on], depth[pairs[on, 0]], depth[pairs[on, 1]]
    # no line that matters is longer than a few pages
    count = np.clip(np.ceil(np.abs(b - a).max(axis=1, initial=0.0)), 1, 8 * (height + width)).astype(int) + 1
    line = np.repeat(np.arange(len(a)), count)
    share = (np.arange(len(line)) - np.repeat(np.cumsum(count) - count, count)) / (count[line] - 1)
    x = np.floor(a[line, 0] + share * (b - a)[line, 0]).astype(int)
    y = np.floor(a[line, 1] + share * (b - a)[line, 1]).astype(int)
    inside = (x >= 0) & (x < width) & (y >= 0) & (y < height)
    return (y * width + x)[inside], (za[line] + share * (zb - za)[line])[inside]
