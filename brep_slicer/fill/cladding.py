"""Rings and helices: a full turn clad with beads that go round the shaft.

In: a cell that winds. Out: closed rings, or helices of one start or several, cut where the band has holes.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from .bead import Bead, BeadKind
from .contours import rings_at
from .hatch import Hatch
from .pattern import Cell, CellFill, Pattern


@dataclass(frozen=True, slots=True, kw_only=True)
class Rings(Pattern):
    """Closed beads v = const, one step-over apart."""

    def fill(self, cell: Cell) -> CellFill:
        made = Hatch(angle=0.0, both_ways=False).fill(cell)
        return replace(made, beads=tuple(_of_kind(b, BeadKind.RING) for b in made.beads))


@dataclass(frozen=True, slots=True, kw_only=True)
class Helix(Pattern):
    """`starts` helices side by side, right-handed unless `left_handed`; neighbouring turns are one step-over apart.

    The lines obey L sin(phi) = starts * d, so each goes round without a seam. With `closing_rings`, a bead follows
    both edges of the band, where a helix alone leaves wedges. The first helix begins at the angle `start` round the shaft (rad,
    theta of the axis frame), or where the part's own shape says.

    Raises
    ------
    ValueError
        If `starts` is less than 1.
    """

    starts: int = 1
    left_handed: bool = False
    closing_rings: bool = False
    start: float | None = None

    def __post_init__(self) -> None:
        if self.starts < 1:
            raise ValueError(f"a helix needs one start at least, not {self.starts}")

    def fill(self, cell: Cell) -> CellFill:
        if not cell.piece.winds:
            note = "it does not go all the way round: hatched along the circumference instead of clad by a helix"
            made = Hatch(angle=0.0).fill(cell)
            return replace(made, notes=(*made.notes, note))
        length = cell.piece.closure.length
        sine = self.starts * cell.step_over / length
        if sine >= 1.0:
            note = f"{self.starts} starts of {cell.step_over:g} mm do not fit round {length:g} mm: rings instead"
            made = Rings().fill(cell)
            return replace(made, notes=(*made.notes, note))
        angle = -math.asin(sine) if self.left_handed else math.asin(sine)
        made = Hatch(angle=angle, both_ways=False, start=self.start).fill(cell)
        beads = [_of_kind(b, BeadKind.HELIX) for b in made.beads]
        if self.closing_rings:
            rings = _edges_of_band(cell)
            beads = [*rings[:1], *beads, *rings[1:]]
        return replace(made, beads=tuple(beads))


def _edges_of_band(cell: Cell) -> list[Bead]:
    """The beads that follow the lower and the upper edge of a band all the way round, from below.

    Where the inset does not go round, for a hole that leaves no room beside it, those that bound what is left of it.
    """
    closure = cell.piece.closure
    every = rings_at(cell, cell.inset)
    lines = [p for p in every if round(abs(float(np.diff(closure.turns_along(p)[[0, -1]])[0]))) == 1] or every
    lines.sort(key=lambda p: float(closure.heights_of(p).mean()))
    return [Bead(points=p, kind=BeadKind.RING, piece=cell.index, closed=True) for p in lines]


def _of_kind(bead: Bead, kind: BeadKind) -> Bead:
    return Bead(points=bead.points, kind=kind, piece=bead.piece, closed=bead.closed)
