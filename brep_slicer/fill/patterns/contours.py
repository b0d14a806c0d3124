"""Contours: beads that follow the outline, one step-over apart.

In: an area. Out: closed beads, polygons that err inwards by no more than the chord.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from brep_slicer.layers import Closure
from brep_slicer.maps import Array
from brep_slicer.process.parameter import parameter
from brep_slicer.region import stitched_outlines

from ..bead import Bead, BeadKind
from ..pattern import AreaFill, FillArea, Pattern, PatternSequence
from ..tools.inset import from_the_lowest, inset_piece, three_turns_moved
from .skeleton import Skeleton


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class Contours(Pattern):
    """`count` contours from the outline inwards (None: as many as fit); `outwards` deposits the innermost first.

    With `skeleton`, beads along the skeleton of what they leave bare follow.
    """

    name: ClassVar[str] = "contours"
    help: ClassVar[str] = "along the outline, as many as fit, then along the skeleton"
    turns_along: ClassVar[bool] = True

    count: int | None = parameter(
        None, kind=int, least=1, example=2, assumed="as many as fit", help="Contours from the outline inwards"
    )
    outwards: bool = parameter(False, help="Laid from the inside outwards")
    skeleton: bool = parameter(True, help="Beads along the skeleton fill what it leaves bare")

    def fill(self, area: FillArea) -> AreaFill:
        return then_skeleton(replace(self, skeleton=False), area) if self.skeleton else self._rings(area)

    def _rings(self, area: FillArea) -> AreaFill:
        rounds: list[list[Bead]] = []
        inset = area.inset
        while self.count is None or len(rounds) < self.count:
            rings = rings_at(area, inset)
            if not rings:
                break
            rounds.append([Bead(points=r, kind=BeadKind.CONTOUR, piece=area.index, closed=True) for r in rings])
            inset += area.step_over
        notes: tuple[str, ...] = ()
        if self.count is not None and rounds and len(rounds) < self.count:
            notes = (f"only {len(rounds)} of {self.count} contours fit",)
        if self.outwards:
            rounds.reverse()
        return AreaFill(beads=tuple(b for ring in rounds for b in ring), inset=inset, notes=notes)


def then_skeleton(pattern: Pattern, area: FillArea) -> AreaFill:
    """An area filled by a pattern, and what that leaves bare by beads along its skeleton."""
    return PatternSequence(patterns=(pattern, Skeleton())).fill(area)


def rings_at(area: FillArea, distance: float) -> list[Array]:
    """Closed lines (n, 2) at `distance` inside of the outline; on a full turn also those that go all the way round."""
    if not area.piece.winds:
        inset = inset_piece(area.piece, distance, chord=area.chord)
        return [from_the_lowest(np.asarray(ring.coords)) for p in inset.polygons for ring in (p.exterior, *p.interiors)]
    closure, cut = area.piece.closure, area.piece.cut
    shape = three_turns_moved(area.piece, distance, chord=area.chord)
    # what is drawn there ends an inset before a turn on either side of the window
    found = stitched_outlines(shape, closure, first=cut - 0.5)
    round_lines = [_from_the_cut(points, cut, winding, closure) for points, winding in found if winding]
    rings = [_in_the_window(from_the_lowest(points), cut, closure) for points, winding in found if not winding]
    return sorted(round_lines, key=lambda points: float(closure.heights_of(points).mean())) + rings


def _in_the_window(ring: Array, cut: float, closure: Closure) -> Array:
    return closure.moved(ring, -math.floor(float(closure.turns_along(ring).min()) - cut))


def _from_the_cut(points: Array, cut: float, winding: int, closure: Closure) -> Array:
    """A line that goes round (by +1 or -1 turns), run from `cut` or a turn on, where it is lowest there."""
    turns = closure.turns_along(points)
    steps = np.floor(winding * (turns - cut))
    crossing = np.flatnonzero(np.diff(steps) > 0.0)
    level = cut + winding * steps[crossing + 1]
    share = (level - turns[crossing]) / (turns[crossing + 1] - turns[crossing])
    places = points[crossing] + share[:, None] * (points[crossing + 1] - points[crossing])
    lowest = int(closure.heights_of(places).argmin())
    i, start = int(crossing[lowest]), places[lowest][None]
    # exactly on the cut
    start = closure.at(level[[lowest]], closure.heights_of(start))
    chain = np.concatenate([start, points[i + 1 : -1], closure.moved(points[: i + 1], winding), closure.moved(start, winding)])
    chain = closure.moved(chain, round((cut if winding > 0 else cut + 1.0) - float(level[lowest])))
    return chain[np.append(True, np.hypot(*np.diff(chain, axis=0).T) > 1e-12)]
