"""The unrolled area of a layer: pieces in the plane (kappa, v), periodic in kappa.

In: the closed loops of a section. Out: a Region: pieces with their holes, exact areas, polygons to a chord.

Words: *chart*, one drawing of the region on a stretch of the plane; *seam*, where a full band's chart is cut (no
boundary: no contour follows it); *lift*, a copy a whole number of turns away.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from brep_slicer.curves import Loop
from brep_slicer.errors import LayerError
from brep_slicer.maps import TURN, Array

from .pieces import Piece

if TYPE_CHECKING:
    from shapely import MultiPolygon, Polygon

# Loops are nested by samples this fine (a share of the loop's extent): it decides only who lies inside of whom.
NESTING_SHARE = 1e-4


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Region:
    """The unrolled section of one layer on the cylinder of `radius` (mm); empty without `pieces`.

    `touch` is how near two outlines had to come to be joined (mm), 0 where none were held against each other.
    """

    radius: float
    pieces: tuple[Piece, ...] = ()
    touch: float = 0.0

    @property
    def period(self) -> float:
        """Length of one turn, 2 * pi * radius, in mm."""
        return TURN * self.radius

    @property
    def area(self) -> float:
        """Exact area from the curves, mm**2."""
        return sum(piece.area() for piece in self.pieces)

    @property
    def first_moment(self) -> float:
        """Integral of v over the region, mm**3."""
        return sum(piece.first_moment() for piece in self.pieces)

    @property
    def length(self) -> float:
        """Length of the whole boundary, mm."""
        return sum(piece.length() for piece in self.pieces)

    @property
    def is_empty(self) -> bool:
        """Whether there is no metal on this cylinder."""
        return not self.pieces

    @property
    def loops(self) -> tuple[Loop, ...]:
        """Every loop of every piece."""
        return tuple(loop for piece in self.pieces for loop in piece.loops)

    def on_radius(self, radius: float) -> Region:
        """The same angles drawn on another cylinder: kappa is rescaled by radius / self.radius."""
        if radius == self.radius:
            return self
        return Region(radius=radius, pieces=tuple(piece.on_radius(radius) for piece in self.pieces), touch=self.touch)

    def to_shapely(self, *, chord: float = 0.01, seam: float | None = None) -> MultiPolygon:
        """Polygons in (kappa, v), mm, sampled in the plane to `chord` (mm), one a piece.

        A piece that does not wind is drawn whole, where its middle lies within half a turn of kappa = 0. A full band is cut
        at kappa = `seam` (default: half a turn before 0) and its two cut sides are no boundary of the region.
        """
        import shapely

        return shapely.MultiPolygon([polygon_from_piece(piece, chord=chord, seam=seam) for piece in self.pieces])


def polygon_from_piece(piece: Piece, *, chord: float, seam: float | None = None) -> Polygon:
    """One piece as a polygon in its chart (see `Region.to_shapely`)."""
    import shapely

    if not piece.winds:
        return shapely.Polygon(piece.outer[0].sample(chord), [hole.sample(chord) for hole in piece.holes])
    cut = -0.5 * piece.outer[0].period if seam is None else seam
    lower, upper = (_between(loop, cut, chord) for loop in piece.outer)
    shell = shapely.Polygon(np.concatenate([lower, upper]))
    holes = [
        shapely.Polygon(hole.shifted(turns).sample(chord))
        for hole in piece.holes
        for turns in _lifts_between(hole, cut, cut + hole.period)
    ]
    return shell.difference(shapely.union_all(holes)) if holes else shell


def _between(loop: Loop, cut: float, chord: float):
    """A winding loop's samples from kappa = cut to a turn further (in its own direction), ends interpolated."""
    points = loop.sample(chord)
    period = loop.period
    low, high = points[:, 0].min(), points[:, 0].max()
    first, last = int(np.floor((cut - high) / period)), int(np.ceil((cut + period - low) / period))
    turns = np.arange(first, last + 1) if loop.winding > 0 else np.arange(last, first - 1, -1)
    chain = np.concatenate([points[:-1] + np.array([k * period, 0.0]) for k in turns])
    start, end = (cut, cut + period) if loop.winding > 0 else (cut + period, cut)
    return _cut_chain(chain, start, end)


def _cut_chain(chain, start: float, end: float):
    """The part of a chain from its last crossing of kappa = start before its first one of kappa = end after it."""
    side = np.sign(end - start)
    before = side * (chain[:, 0] - start)
    crossing = np.flatnonzero((before[:-1] < 0.0) & (before[1:] >= 0.0))
    i = int(crossing[0])
    f = before[i] / (before[i] - before[i + 1])
    first = np.array([start, chain[i, 1] + f * (chain[i + 1, 1] - chain[i, 1])])
    after = side * (chain[:, 0] - end)
    # the same place one turn on: the chain repeats itself, so the crossing found there has the same index in its turn
    later = np.flatnonzero((after[:-1] < 0.0) & (after[1:] >= 0.0))
    j = int(later[later >= i][0])
    last = np.array([end, first[1]])
    inner = chain[i + 1 : j + 1]
    inner = inner[np.any(inner != first, axis=1) & np.any(inner != last, axis=1)] if len(inner) else inner
    return np.concatenate([first[None, :], inner, last[None, :]])


def _lifts_between(loop: Loop, low: float, high: float) -> range:
    """The turns by which a loop can be moved so that it overlaps [low, high] in kappa."""
    k0, _, k1, _ = loop.bounds()
    period = loop.period
    return range(int(np.ceil((low - k1) / period)), int(np.floor((high - k0) / period)) + 1)


def region_from_loops(radius: float, loops: Iterable[Loop]) -> Region:
    """Nest closed loops, material on their left, into pieces.

    Raises
    ------
    LayerError
        If the loops do not bound an area: a hole without a piece round it, or bands whose edges do not pair up.
    """
    import shapely

    flat = [loop for loop in loops if loop.winding == 0]
    areas = [loop.signed_area() for loop in flat]
    outers = [_centred(loop) for loop, area in zip(flat, areas, strict=True) if area > 0.0]
    holes = [loop for loop, area in zip(flat, areas, strict=True) if area <= 0.0]
    bands = _paired_bands([loop for loop in loops if loop.winding != 0])
    shapes = [_nesting_polygon(loop) for loop in outers] if holes else []
    order = sorted(range(len(shapes)), key=lambda i: shapes[i].area)
    found: dict[int, list[Loop]] = {}
    for hole in holes:
        probe = shapely.Point(hole.curves[0].points(np.array([0.5]))[0])
        home = _home_of(hole, probe, order, shapes, bands)
        if home is None:
            raise LayerError(f"a hole at radius {radius:g} mm lies in no piece: the section does not close")
        index, turns = home
        found.setdefault(index, []).append(hole.shifted(turns))
    pieces = [Piece(outer=(outer,), holes=tuple(found.get(i, ()))) for i, outer in enumerate(outers)]
    pieces += [Piece(outer=band, holes=tuple(found.get(-1 - j, ()))) for j, band in enumerate(bands)]
    return Region(radius=radius, pieces=tuple(sorted(pieces, key=lambda p: p.bounds()[:2])))


def _centred(loop: Loop) -> Loop:
    """The lift whose middle lies in [-half a turn, half a turn)."""
    k0, _, k1, _ = loop.bounds()
    return loop.shifted(-int(np.floor(0.5 * (k0 + k1) / loop.period + 0.5)))


def _nesting_polygon(loop: Loop):
    import shapely

    k0, v0, k1, v1 = loop.bounds()
    polygon = shapely.Polygon(loop.sample(NESTING_SHARE * max(k1 - k0, v1 - v0)))
    return polygon if polygon.is_valid else polygon.buffer(0.0)


def _home_of(hole: Loop, probe, order, shapes, bands) -> tuple[int, int] | None:
    """Index of the smallest piece round a hole's point, and the lift of the hole that lies in it."""
    import shapely

    k, v = probe.x, probe.y
    for index in order:
        k0, _, k1, _ = shapes[index].bounds
        for turns in range(int(np.ceil((k0 - k) / hole.period)), int(np.floor((k1 - k) / hole.period)) + 1):
            if shapes[index].contains(shapely.Point(k + turns * hole.period, v)):
                return index, turns
    for j, (lower, upper) in enumerate(bands):
        if _lies_in_band(hole, lower, upper):
            start = float(lower.curves[0].start[0])
            return -1 - j, int(-np.floor((k - start) / hole.period))
    return None


def _lies_in_band(hole: Loop, lower: Loop, upper: Loop) -> bool:
    """Whether most of a hole's corners lie above the lower edge and not above the upper one, though these fold back."""
    corners = np.array([curve.points(np.array([0.0, 0.5])) for curve in hole.curves]).reshape(-1, 2)
    chains = [loop.sample(NESTING_SHARE * loop.period) for loop in (lower, upper)]
    inside = crossings_below(chains[0], corners, hole.period) + crossings_below(chains[1], corners, hole.period) > 0
    return bool(np.mean(inside) > 0.5)


def crossings_below(chain: Array, points: Array, period: float) -> Array:
    """How often a chain (m, 2) passes below each of `points` (n, 2) towards greater kappa, less how often towards smaller.

    The chain ends where it starts, or whole turns of `period` (mm) on.
    """
    start = chain[0, 0]
    # within one turn from the chain's start: the vertex at either end of a winding chain is then left or right of both copies
    base = points[:, 0] - np.floor((points[:, 0] - start) / period) * period
    base = np.where(base >= start + period, start, base)
    count = np.zeros(len(points), dtype=int)
    turns = (chain[:, 0] - start) / period
    for lift in range(int(np.floor(turns.min())) - 1, int(np.ceil(turns.max())) + 1):
        kappa = base + lift * period
        right = chain[None, :, 0] > kappa[:, None]
        rows, at = np.nonzero(right[:, 1:] != right[:, :-1])
        (ka, va), (kb, vb) = chain[at].T, chain[at + 1].T
        height = va + (vb - va) * (kappa[rows] - ka) / (kb - ka)
        np.add.at(count, rows, np.where(height < points[rows, 1], np.where(right[rows, at + 1], 1, -1), 0))
    return count


def _paired_bands(loops: list[Loop]) -> list[tuple[Loop, Loop]]:
    """Lower edges (winding +1) with the next upper edge (winding -1) above them, in the order of v."""
    if any(abs(loop.winding) != 1 for loop in loops):
        raise LayerError("a loop winds more than once round the axis: the section crosses itself")
    keyed = sorted(loops, key=lambda loop: _mean_height(loop))
    if len(keyed) % 2 or any(loop.winding != (1 if i % 2 == 0 else -1) for i, loop in enumerate(keyed)):
        raise LayerError("the edges of the full bands do not pair up: the section does not close")
    return list(zip(keyed[0::2], keyed[1::2], strict=True))


def _mean_height(loop: Loop) -> float:
    return loop.moment(1) / (loop.winding * loop.period)
