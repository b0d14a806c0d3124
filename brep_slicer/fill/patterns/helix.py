"""Helices: a full turn clad with beads that go round the shaft without an end.

In: an area that winds. Out: helices of one start or several, cut where the band has holes.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from brep_slicer.process.parameter import parameter

from ..bead import Bead, BeadKind
from ..pattern import AreaFill, FillArea, Pattern
from ..tools.parallel import ParallelLines
from .contours import rings_at
from .rings import Rings


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class Helix(Pattern):
    """`starts` helices side by side, right-handed unless `left_handed`; neighbouring turns are one step-over apart.

    The lines obey L sin(phi) = starts * d, so each goes round without a seam. With `closing_rings`, a bead follows
    both edges of the band, where a helix alone leaves wedges. The first helix begins at `start_angle_deg` round the shaft
    (theta of the axis frame), or where the part's own shape says.
    """

    name: ClassVar[str] = "helix"
    help: ClassVar[str] = "one continuous bead round the shaft, on full bands"

    starts: int = parameter(1, least=1, help="How many helices run side by side")
    left_handed: bool = parameter(False, help="Helices are left-handed")
    closing_rings: bool = parameter(False, help="A ring along either edge of a band")
    start_angle_deg: float | None = parameter(
        None,
        unit="deg",
        example=90.0,
        assumed="by the part's shape",
        help="Where on its lower edge it begins, theta in the axis frame",
    )

    def fill(self, area: FillArea) -> AreaFill:
        if not area.piece.winds:
            note = "it does not go all the way round: hatched along the circumference instead of clad by a helix"
            made = ParallelLines(angle=0.0).fill(area)
            return replace(made, notes=(*made.notes, note))
        length = area.piece.closure.length
        sine = self.starts * area.step_over / length
        if sine >= 1.0:
            note = f"{self.starts} starts of {area.step_over:g} mm do not fit round {length:g} mm: rings instead"
            made = Rings().fill(area)
            return replace(made, notes=(*made.notes, note))
        angle = -math.asin(sine) if self.left_handed else math.asin(sine)
        start = None if self.start_angle_deg is None else math.radians(self.start_angle_deg)
        made = ParallelLines(angle=angle, both_ways=False, start=start).fill(area)
        beads = [replace(b, kind=BeadKind.HELIX) for b in made.beads]
        if self.closing_rings:
            rings = _edges_of_band(area)
            beads = [*rings[:1], *beads, *rings[1:]]
        return replace(made, beads=tuple(beads))


def _edges_of_band(area: FillArea) -> list[Bead]:
    """The beads that follow the lower and the upper edge of a band all the way round, from below.

    Where the inset does not go round, for a hole that leaves no room beside it, those that bound what is left of it.
    """
    closure = area.piece.closure
    every = rings_at(area, area.inset)
    lines = [p for p in every if round(abs(float(np.diff(closure.turns_along(p)[[0, -1]])[0]))) == 1] or every
    lines.sort(key=lambda p: float(closure.heights_of(p).mean()))
    return [Bead(points=p, kind=BeadKind.RING, piece=area.index, closed=True) for p in lines]
