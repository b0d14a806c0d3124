"""Rings and helices: a full turn clad with beads that go round the shaft.

In: a cell that winds. Out: closed rings, or helices of one start or several, cut where the band has holes.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from .bead import Bead, BeadKind
from .hatch import Hatch
from .inset import edges_of, inset_piece
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

    The lines obey L sin(phi) = starts * d, so each goes round without a seam. With `closing_rings`, a ring lies at both ends
    of the band, where a helix alone leaves wedges.
    """

    starts: int = 1
    left_handed: bool = False
    closing_rings: bool = False

    def fill(self, cell: Cell) -> CellFill:
        if not cell.piece.winds:
            note = "it does not go all the way round: hatched along the circumference instead of clad by a helix"
            made = Hatch(angle=0.0).fill(cell)
            return replace(made, notes=(*made.notes, note))
        period = cell.piece.outer[0].period
        sine = self.starts * cell.step_over / period
        if sine >= 1.0:
            note = f"{self.starts} starts of {cell.step_over:g} mm do not fit round {period:g} mm: rings instead"
            made = Rings().fill(cell)
            return replace(made, notes=(*made.notes, note))
        angle = -math.asin(sine) if self.left_handed else math.asin(sine)
        made = Hatch(angle=angle, both_ways=False).fill(cell)
        beads = [_of_kind(b, BeadKind.HELIX) for b in made.beads]
        if self.closing_rings:
            beads = [*self._rings(cell, lowest=True), *beads, *self._rings(cell, lowest=False)]
        return replace(made, beads=tuple(beads))

    def _rings(self, cell: Cell, *, lowest: bool) -> list[Bead]:
        """One ring at the lower or the upper end of what a bead's centre may reach."""
        inset = inset_piece(cell.piece, cell.inset, chord=cell.chord)
        points, _ = edges_of(inset.polygons)
        if not len(points):
            return []
        v = float(points[:, 1].min() if lowest else points[:, 1].max())
        ring = np.array([[inset.cut, v], [inset.cut + inset.period, v]])
        return [Bead(points=ring, kind=BeadKind.RING, piece=cell.index, closed=True)]


def _of_kind(bead: Bead, kind: BeadKind) -> Bead:
    return Bead(points=bead.points, kind=kind, piece=bead.piece, closed=bead.closed)
