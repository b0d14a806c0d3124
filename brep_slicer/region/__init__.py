"""The unrolled area of a layer in the plane (kappa, v), periodic in kappa; no CAD kernel from here on.

In: the loops of every solid's section. Out: regions (nested pieces with exact areas) and layers.
"""

from .allowance import grown_region, slice_with_allowance
from .chart import band_between, copies_between, polygon_from_piece
from .features import features_of, overlapping_pieces
from .layer import FailedLayer, Layer
from .overhang import DrawnRegion, Overhang, drawn_region, overhang_of
from .overlaps import overlapping_area
from .overlay import difference_of_regions, union_of_regions
from .pieces import Piece
from .region import Region, region_from_loops
from .slicing import slice_part, slice_solids
from .stitched import stitched_outlines
from .zones import outside_of_zones

__all__ = [
    "DrawnRegion",
    "Overhang",
    "drawn_region",
    "overhang_of",
    "overlapping_pieces",
    "FailedLayer",
    "Layer",
    "Piece",
    "Region",
    "band_between",
    "difference_of_regions",
    "features_of",
    "grown_region",
    "copies_between",
    "outside_of_zones",
    "overlapping_area",
    "polygon_from_piece",
    "region_from_loops",
    "slice_part",
    "slice_solids",
    "slice_with_allowance",
    "stitched_outlines",
    "union_of_regions",
]
