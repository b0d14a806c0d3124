"""What of a layer hangs in the air: its area that no metal below carries.

In: a layer's region and what lies below it, at equal angles. Out: an Overhang with its areas.

Words: *reach*, how far beside the metal below a bead is still carried; *copy*, the same thing a whole number of turns away.

What is below is first widened by the reach. What of the layer lies *beyond* that hangs for certain. The area *over air* is all
of it round about, up to the metal below: what lies within a reach of what is beyond, and not on metal. So an overhang of less
than the reach counts nowhere, a wider one in full, and a gap below that is narrower than twice the reach is bridged.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from brep_slicer.layers import Closure, Sheet

from .region import Region

if TYPE_CHECKING:
    from shapely import Geometry

# Round corners of what is widened are drawn with so many segments a quarter turn: within 0.12 % of the reach.
SEGMENTS = 16
# What lies beyond is widened by this share more than the reach, so that it comes back to the metal's edge in spite of that.
MORE = 1.01
# A spot beyond the reach of less than this share of a circle of that radius is a corner, and nothing that hangs: where an
# outline grows by the reach on both sides of a right angle, 1 / pi - 1 / 4 = 0.068 of it lies beyond.
SPECK_SHARE = 0.1


@dataclass(frozen=True, slots=True, kw_only=True)
class Overhang:
    """Of a layer, mm**2: the area `over_air`, and what of it lies `beyond` the reach of the metal below."""

    over_air: float
    beyond: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class DrawnRegion:
    """A region as `polygons` (shapely, valid) in the plane of its `sheet`, to compare it with others at equal angles."""

    sheet: Sheet
    polygons: tuple[Any, ...]

    def on_sheet(self, sheet: Sheet) -> DrawnRegion:
        """The same angles and heights on another sheet of the family."""
        import shapely

        if sheet == self.sheet:
            return self
        old, new = self.sheet.closure, sheet.closure
        if old.is_open:
            return DrawnRegion(sheet=sheet, polygons=self.polygons)
        moved = shapely.transform(
            np.array(self.polygons, dtype=object), lambda points: new.at(old.turns_of(points), old.heights_of(points))
        )
        return DrawnRegion(sheet=sheet, polygons=tuple(moved))


def drawn_region(region: Region, *, chord: float) -> DrawnRegion:
    """A region's polygons, sampled to `chord` (mm)."""
    import shapely

    drawn = shapely.get_parts(region.to_shapely(chord=chord))
    whole = [shape if shape.is_valid else shapely.make_valid(shape) for shape in drawn]
    return DrawnRegion(sheet=region.sheet, polygons=tuple(shape for shape in whole if not shape.is_empty))


def overhang_of(above: DrawnRegion, below: Sequence[DrawnRegion], *, reach: float) -> Overhang | None:
    """What of a layer lies over air, if more of it than a speck lies farther than `reach` (mm) from all metal below."""
    import shapely

    if not above.polygons:
        return None
    speck = SPECK_SHARE * np.pi * reach**2
    shapes = np.array(above.polygons, dtype=object)
    metal = [polygon for region in below for polygon in region.on_sheet(above.sheet).polygons]
    closure = above.sheet.closure
    around = closure.span_of(shapely.box(*shapely.total_bounds(shapes)).buffer(reach).bounds)
    near = _copies(metal, closure, *around)
    bare = _outside(shapes, near)
    if _area(bare) <= speck:
        return None
    beyond = _spots(_outside(bare, shapely.buffer(near, reach, quad_segs=SEGMENTS)), closure, speck)
    if not len(beyond):
        return None
    round_about = _copies(list(shapely.buffer(beyond, MORE * reach, quad_segs=SEGMENTS)), closure, *around)
    over_air = shapely.intersection(shapely.union_all(bare), shapely.union_all(round_about))
    return Overhang(over_air=float(over_air.area), beyond=_area(beyond))


def _spots(shapes: np.ndarray, closure: Closure, least: float) -> np.ndarray:
    """The connected parts of shapes that are larger than `least` (mm**2), whether or not a chart's seam divides them."""
    import shapely

    parts = shapely.get_parts(shapes)
    if not len(parts):
        return parts
    low, high = closure.span_of(shapely.total_bounds(parts))
    joined = shapely.get_parts(shapely.union_all(_copies(parts, closure, low - 1.0, high + 1.0)))
    large = joined[shapely.area(joined) > least]
    one, _ = shapely.STRtree(large).query(parts, predicate="intersects")
    return parts[np.unique(one)]


def _area(shapes: np.ndarray) -> float:
    import shapely

    return float(shapely.area(shapes).sum())


def _copies(shapes: Sequence[Geometry], closure: Closure, low: float, high: float) -> np.ndarray:
    """All copies of shapes that lie from `low` to `high` (turns), at least in part."""
    out = []
    for shape in shapes:
        for turns in closure.copies_between(shape.bounds, low, high):
            out.append(closure.motion(turns).shape(shape) if turns else shape)
    return np.array(out, dtype=object)


def _outside(shapes: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Of each shape what lies outside of all others; those of which nothing is left are left out."""
    import shapely

    rest = list(shapes)
    one, other = shapely.STRtree(others).query(shapes, predicate="intersects") if len(others) else (np.zeros(0, int),) * 2
    for i in np.unique(one):
        rest[i] = shapely.difference(shapes[i], shapely.union_all(others[other[one == i]]))
    return np.array([shape for shape in rest if not shape.is_empty], dtype=object)
