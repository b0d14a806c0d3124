"""Rings: closed beads round the shaft, one step-over apart.

In: an area that winds. Out: rings, cut where the band has holes; lines along the circumference elsewhere.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

from ..bead import BeadKind
from ..pattern import AreaFill, FillArea, Pattern
from ..tools.parallel import ParallelLines


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class Rings(Pattern):
    """Closed beads v = const, one step-over apart."""

    name: ClassVar[str] = "rings"
    help: ClassVar[str] = "closed rings round the shaft, on full bands"

    def fill(self, area: FillArea) -> AreaFill:
        made = ParallelLines(angle=0.0, both_ways=False).fill(area)
        return replace(made, beads=tuple(replace(bead, kind=BeadKind.RING) for bead in made.beads))
