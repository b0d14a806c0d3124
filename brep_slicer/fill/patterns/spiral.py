"""Spirals: one continuous bead from the outline inwards, a step-over a turn.

In: an area. Out: a bead for each nest of contours; where a contour parts in two, each part gets a spiral of its own.

Words: *nest*, contours one inside of the other, each without a hole; *pair*, a point of a contour and the one nearest to it on
the next: a turn of the spiral goes from the one to the other, evenly along the contour.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from brep_slicer.maps import Array, lengths_along
from brep_slicer.process.parameter import parameter

from ..bead import Bead, BeadKind
from ..pattern import AreaFill, FillArea, Pattern
from ..tools.inset import from_the_lowest, inset_piece
from .contours import then_skeleton
from .helix import Helix

if TYPE_CHECKING:
    from shapely import Polygon

# Points along a contour are no farther apart than this share of the step-over: the spiral's own bend between them is small.
SPACING = 0.1


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class Spiral(Pattern):
    """Contours run into one another; the outermost and the innermost are closed first and last. `outwards` starts inside.

    Round a full turn the spiral is a helix with closing rings. A piece with holes gets contours round each hole's nest.
    """

    name: ClassVar[str] = "spiral"
    help: ClassVar[str] = "one bead from the outline inwards, then along the skeleton"
    turns_along: ClassVar[bool] = True

    outwards: bool = parameter(False, help="Laid from the inside outwards")
    skeleton: bool = parameter(True, help="Beads along the skeleton fill what it leaves bare")

    def fill(self, area: FillArea) -> AreaFill:
        return then_skeleton(replace(self, skeleton=False), area) if self.skeleton else self._nests(area)

    def _nests(self, area: FillArea) -> AreaFill:
        if area.piece.winds:
            return Helix(closing_rings=True).fill(area)
        nests: list[list[Polygon]] = []
        growing = [[p] for p in inset_piece(area.piece, area.inset, chord=area.chord).polygons]
        distance = area.inset
        while growing:
            distance += area.step_over
            inner = list(inset_piece(area.piece, distance, chord=area.chord).polygons)
            growing, ended = _grown(growing, inner)
            nests += ended
        beads: list[Bead] = []
        for nest in nests:
            beads += self._beads(nest, area)
        return AreaFill(beads=tuple(beads), inset=distance)

    def _beads(self, nest: list[Polygon], area: FillArea) -> list[Bead]:
        if nest[0].interiors:
            rings = [np.asarray(r.coords) for p in nest for r in (p.exterior, *p.interiors)]
            return [Bead(points=r, kind=BeadKind.CONTOUR, piece=area.index, closed=True) for r in rings]
        points = _spiral([from_the_lowest(np.asarray(p.exterior.coords)) for p in nest], SPACING * area.step_over)
        bead = Bead(points=points, kind=BeadKind.SPIRAL, piece=area.index, closed=len(nest) == 1)
        return [bead.reversed() if self.outwards else bead]


def _grown(growing: list[list[Polygon]], inner: list[Polygon]) -> tuple[list[list[Polygon]], list[list[Polygon]]]:
    """(nests that go on, nests that have ended): a nest goes on while one polygon without holes lies in its last one."""
    going, ended = [], []
    for nest in growing:
        mine = [p for p in inner if nest[-1].contains(p.representative_point())]
        if len(mine) == 1 and not mine[0].interiors and not nest[-1].interiors:
            going.append([*nest, mine[0]])
        else:
            ended.append(nest)
            going += [[p] for p in mine]
    return going, ended


def _spiral(rings: list[Array], spacing: float) -> Array:
    """The outermost ring, a turn from each ring to the next, the innermost ring."""
    import shapely

    start = rings[0][0]
    whole, parts = [], []
    for ring in rings:
        line = shapely.LineString(ring)
        at = line.project(shapely.Point(start))
        whole.append(_from(ring, at))
        start = whole[-1][0]
    for outer, inner in itertools.pairwise(whole):
        parts.append(_turn(outer, inner, spacing))
    chain = np.concatenate([whole[0], *parts, *([whole[-1]] if len(rings) > 1 else [])])
    keep = np.append(True, np.hypot(*np.diff(chain, axis=0).T) > 1e-9)
    return chain[keep]


def _from(ring: Array, at: float) -> Array:
    """A closed ring run from the place at length `at` on."""
    along = lengths_along(ring)
    first = np.array([np.interp(at, along, ring[:, k]) for k in (0, 1)])
    later = int(np.searchsorted(along, at, side="right"))
    return np.concatenate([first[None], ring[later:-1] if later < len(ring) else ring[:0], ring[:later], first[None]])


def _turn(outer: Array, inner: Array, spacing: float) -> Array:
    """One turn from `outer` to `inner`: points of both with the nearest ones on the other, in order along both."""
    import shapely

    lines = [shapely.LineString(r) for r in (outer, inner)]
    dense = [np.asarray(shapely.segmentize(line, spacing).coords)[:-1] for line in lines]
    own = [
        np.array(shapely.line_locate_point(line, shapely.points(p))) / line.length for line, p in zip(lines, dense, strict=True)
    ]
    for k in (0, 1):
        own[k] = np.linspace(0.0, 1.0, len(dense[k]), endpoint=False) if np.any(np.diff(own[k]) < 0.0) else own[k]
    other = [shapely.line_locate_point(lines[1 - k], shapely.points(dense[k])) / lines[1 - k].length for k in (0, 1)]
    # near the seam the nearest place may lie just before the start of the other ring
    other = [o + np.round(s - o) for s, o in zip(own, other, strict=True)]
    a = np.concatenate([own[0], other[1]])
    b = np.concatenate([other[0], own[1]])
    order = np.argsort(a + b, kind="stable")
    share = np.clip(0.5 * (a + b)[order], 0.0, 1.0)
    a, b = (np.maximum.accumulate(np.clip(x[order], 0.0, 1.0)) for x in (a, b))
    points = [
        shapely.get_coordinates(shapely.line_interpolate_point(line, x * line.length))
        for line, x in zip(lines, (a, b), strict=True)
    ]
    turn = (1.0 - share)[:, None] * points[0] + share[:, None] * points[1]
    # at the outline's reflex corners a pair may look past the corner: nothing leaves the outer contour
    lost = ~shapely.intersects(shapely.Polygon(outer), shapely.points(turn))
    at = shapely.line_locate_point(lines[0], shapely.points(turn[lost]))
    turn[lost] = shapely.get_coordinates(shapely.line_interpolate_point(lines[0], at))
    return turn
