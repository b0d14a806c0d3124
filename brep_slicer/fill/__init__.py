"""Deposition patterns in the plane: regions in, beads out.

In: a region, a pattern, the step-over. Out: beads in (kappa, v), in the order of deposition.
"""

from .bead import Bead, BeadKind, LayerFill
from .contours import Contours
from .hatch import Hatch
from .pattern import Cell, CellFill, Pattern, PatternSequence, fill_region

__all__ = [
    "Bead",
    "BeadKind",
    "Cell",
    "CellFill",
    "Contours",
    "Hatch",
    "LayerFill",
    "Pattern",
    "PatternSequence",
    "fill_region",
]
