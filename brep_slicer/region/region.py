"""The unrolled area of a layer: pieces in the plane (kappa, v) of its sheet, each with its copies, turns away.

In: the closed loops of a section. Out: a Region: pieces with their holes, exact areas, polygons to a chord.

Words: *chart*, one drawing of the region on a stretch of the plane; *seam*, where a full band's chart is cut (no
boundary: no contour follows it); *copy*, the same thing a whole number of turns away, by the sheet's closure.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from brep_slicer.curves import Loop, with_apex
from brep_slicer.errors import LayerError
from brep_slicer.layers import Closure, Sheet
from brep_slicer.wording import counted

from .chart import crossings_below, polygon_from_piece
from .pieces import Piece

if TYPE_CHECKING:
    from shapely import MultiPolygon

# Loops are nested by samples this fine (a share of the loop's extent): it decides only who lies inside of whom.
NESTING_SHARE = 1e-4


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Region:
    """The unrolled section of one layer, in the plane of its `sheet`; empty without `pieces`.

    `touch` is how near two outlines had to come to be joined (mm), 0 where none were held against each other.
    """

    sheet: Sheet
    pieces: tuple[Piece, ...] = ()
    touch: float = 0.0

    def __repr__(self) -> str:
        return f"Region({self.sheet.label}: {counted(len(self.pieces), 'piece')}, {self.area:.6g} mm2)"

    @property
    def closure(self) -> Closure:
        """The motion from a thing on the sheet to its next copy."""
        return self.sheet.closure

    @property
    def radius(self) -> float:
        """Radius of the cylinder, mm."""
        return self.sheet.radius

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
        """Whether there is no metal on this sheet."""
        return not self.pieces

    @property
    def loops(self) -> tuple[Loop, ...]:
        """Every loop of every piece."""
        return tuple(loop for piece in self.pieces for loop in piece.loops)

    def on_sheet(self, sheet: Sheet) -> Region:
        """The same angles drawn on another cylinder: kappa is rescaled by the ratio of the radii."""
        if sheet == self.sheet:
            return self
        return Region(sheet=sheet, pieces=tuple(piece.on_sheet(sheet) for piece in self.pieces), touch=self.touch)

    def to_shapely(self, *, chord: float = 0.01, seam_deg: float = -180.0) -> MultiPolygon:
        """Polygons in (kappa, v), mm, sampled in the plane to `chord` (mm), in the order of the pieces.

        A piece that does not wind is drawn whole, where its middle lies within half a turn of kappa = 0. A full band is cut
        `seam_deg` degrees round the axis and its two cut sides are no boundary of the region; if an edge folds
        back over the seam, it comes in several polygons.
        """
        import shapely

        drawn = [polygon_from_piece(piece, chord=chord, seam=seam_deg / 360.0) for piece in self.pieces]
        return shapely.MultiPolygon([part for shape in drawn for part in shapely.get_parts(shape)])


def region_from_loops(sheet: Sheet, loops: Iterable[Loop]) -> Region:
    """Nest closed loops on a sheet, material on their left, into pieces.

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
    bands = _paired_bands(with_apex(sheet, [loop for loop in loops if loop.winding != 0]))
    shapes = [_nesting_polygon(loop) for loop in outers] if holes else []
    # a sliver that its samples do not show holds none
    order = sorted((i for i, shape in enumerate(shapes) if not shape.is_empty), key=lambda i: shapes[i].area)
    found: dict[int, list[Loop]] = {}
    for hole in holes:
        probe = shapely.Point(hole.curves[0].points(np.array([0.5]))[0])
        home = _home_of(hole, probe, order, shapes, bands)
        if home is None:
            raise LayerError(f"a hole at {sheet.label} lies in no piece: the section does not close")
        index, turns = home
        found.setdefault(index, []).append(hole.moved(turns))
    pieces = [Piece(outer=(outer,), holes=tuple(found.get(i, ()))) for i, outer in enumerate(outers)]
    pieces += [Piece(outer=band, holes=tuple(found.get(-1 - j, ()))) for j, band in enumerate(bands)]
    return Region(sheet=sheet, pieces=tuple(sorted(pieces, key=lambda p: p.bounds()[:2])))


def _centred(loop: Loop) -> Loop:
    """The copy whose middle lies in [-half a turn, half a turn)."""
    k0, v0, k1, v1 = loop.bounds()
    return loop.moved(-int(loop.closure.copies_of(np.array([0.5 * (k0 + k1), 0.5 * (v0 + v1)]))))


def _nesting_polygon(loop: Loop):
    import shapely

    k0, v0, k1, v1 = loop.bounds()
    polygon = shapely.Polygon(loop.sample(NESTING_SHARE * max(k1 - k0, v1 - v0)))
    return polygon if polygon.is_valid else polygon.buffer(0.0)


def _home_of(hole: Loop, probe, order, shapes, bands) -> tuple[int, int] | None:
    """Index of the smallest piece round a hole's point, and by how many turns the hole has to be moved to lie in it."""
    import shapely

    closure, point = hole.closure, np.array([probe.x, probe.y])
    place = float(closure.turns_of(point))
    for index in order:
        low, high = closure.span_of(shapes[index].bounds)
        for turns in range(math.ceil(low - place), math.floor(high - place) + 1):
            if shapes[index].contains(shapely.Point(closure.moved(point, turns))):
                return index, turns
    for j, (lower, upper) in enumerate(bands):
        if _lies_in_band(hole, lower, upper):
            return -1 - j, -int(closure.copies_of(point, float(closure.turns_of(lower.curves[0].start))))
    return None


def _lies_in_band(hole: Loop, lower: Loop, upper: Loop) -> bool:
    """Whether most of a hole's corners lie above the lower edge and not above the upper one, though these fold back."""
    corners = np.array([curve.points(np.array([0.0, 0.5])) for curve in hole.curves]).reshape(-1, 2)
    chains = [loop.sample(NESTING_SHARE * loop.length()) for loop in (lower, upper)]
    inside = crossings_below(chains[0], corners, hole.closure) + crossings_below(chains[1], corners, hole.closure) > 0
    return bool(np.mean(inside) > 0.5)


def _paired_bands(loops: list[Loop]) -> list[tuple[Loop, Loop]]:
    """Lower edges (winding +1) with the next upper edge (winding -1) above them, in the order of v."""
    if any(abs(loop.winding) != 1 for loop in loops):
        raise LayerError("a loop winds more than once round the axis: the section crosses itself")
    keyed = sorted(loops, key=lambda loop: _mean_height(loop))
    if len(keyed) % 2 or any(loop.winding != (1 if i % 2 == 0 else -1) for i, loop in enumerate(keyed)):
        raise LayerError("the edges of the full bands do not pair up: the section does not close")
    return list(zip(keyed[0::2], keyed[1::2], strict=True))


def _mean_height(loop: Loop) -> float:
    """What orders the edges of bands: the area under one, a turn long, is the larger the higher it lies."""
    return -loop.signed_area() / loop.winding
