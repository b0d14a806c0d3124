"""Deposition patterns in the plane: regions in, beads out.

In: a region, a pattern, the step-over. Out: beads in (kappa, v), in the order of deposition.
"""

from .automatic import Automatic
from .bead import Bead, BeadKind, LayerFill
from .by_process import PatternChoice, fill_layer, pattern_of
from .cladding import Helix, Rings
from .closing import with_overlap, with_spread_starts
from .contours import Contours
from .cooling import CooledOrder, in_cool_order
from .fill_region import fill_region
from .flank import FlankFollowing, flank_direction
from .hatch import Hatch
from .metal import metal_of
from .order import in_short_order
from .pattern import Cell, CellFill, Pattern, PatternSequence
from .skeleton import Skeleton
from .spacing import with_speed_by_spacing
from .spiral import Spiral
from .zigzag import Zigzag

__all__ = [
    "Automatic",
    "Bead",
    "BeadKind",
    "Cell",
    "CellFill",
    "Contours",
    "CooledOrder",
    "FlankFollowing",
    "Hatch",
    "Helix",
    "LayerFill",
    "Pattern",
    "PatternChoice",
    "PatternSequence",
    "Rings",
    "Skeleton",
    "Spiral",
    "Zigzag",
    "fill_layer",
    "fill_region",
    "flank_direction",
    "in_cool_order",
    "in_short_order",
    "metal_of",
    "pattern_of",
    "with_overlap",
    "with_speed_by_spacing",
    "with_spread_starts",
]
