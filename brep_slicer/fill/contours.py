"""Contours: beads that follow the outline, one step-over apart.

In: a cell. Out: closed beads, polygons that err inwards by no more than the chord.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from brep_slicer.layers import Closure
from brep_slicer.maps import Array
from brep_slicer.region import stitched_outlines

from .bead import Bead, BeadKind
from .inset import from_the_lowest, inset_piece, three_turns_moved
from .pattern import Cell, CellFill, Pattern


@dataclass(frozen=True, slots=True, kw_only=True)
class Contours(Pattern):
    """`count` contours from the outline inwards (None: as many as fit); `outwards` deposits the innermost first."""

    turns_along = True
    count: int | None = 1
    outwards: bool = False

    def fill(self, cell: Cell) -> CellFill:
        rounds: list[list[Bead]] = []
        inset = cell.inset
        while self.count is None or len(rounds) < self.count:
            rings = rings_at(cell, inset)
            if not rings:
                break
            rounds.append([Bead(points=r, kind=BeadKind.CONTOUR, piece=cell.index, closed=True) for r in rings])
            inset += cell.step_over
        notes: tuple[str, ...] = ()
        if self.count is not None and rounds and len(rounds) < self.count:
            notes = (f"only {len(rounds)} of {self.count} contours fit",)
        if self.outwards:
            rounds.reverse()
        return CellFill(beads=tuple(b for ring in rounds for b in ring), inset=inset, notes=notes)


def rings_at(cell: Cell, distance: float) -> list[Array]:
    """Closed lines (n, 2) at `distance` inside of the outline; on a full turn also those that go all the way round."""
    if not cell.piece.winds:
        inset = inset_piece(cell.piece, distance, chord=cell.chord)
        return [from_the_lowest(np.asarray(ring.coords)) for p in inset.polygons for ring in (p.exterior, *p.interiors)]
    closure, cut = cell.piece.closure, cell.piece.cut
    shape = three_turns_moved(cell.piece, distance, chord=cell.chord)
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
