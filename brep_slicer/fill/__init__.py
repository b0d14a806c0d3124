"""Deposition patterns in the plane: regions in, beads out.

In: a region, a pattern, the step-over. Out: beads in (kappa, v), in the order of deposition.
"""

from .bead import Bead, BeadKind, LayerFill
from .fill_layer import PatternChoice, fill_layer, pattern_of
from .fill_region import fill_region
from .passes.adaptive_speed import with_speed_by_spacing
from .passes.interpass import CooledOrder, in_cool_order
from .passes.order import in_short_order
from .passes.start_points import with_overlap, with_spread_starts
from .pattern import AreaFill, FillArea, Pattern, PatternSequence
from .patterns.auto import Automatic
from .patterns.contours import Contours
from .patterns.flank import FlankFollowing, flank_direction
from .patterns.hatch import Hatch
from .patterns.helix import Helix
from .patterns.rings import Rings
from .patterns.skeleton import Skeleton
from .patterns.spiral import Spiral
from .patterns.zigzag import Zigzag
from .tools.metal import metal_of

__all__ = [
    "AreaFill",
    "Automatic",
    "Bead",
    "BeadKind",
    "Contours",
    "CooledOrder",
    "FillArea",
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
