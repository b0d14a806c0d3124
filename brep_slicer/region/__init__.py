"""The unrolled area of a layer in the plane (kappa, v), periodic in kappa; no CAD kernel from here on."""

from .loops import Loop, Piece
from .region import Region, polygon_from_piece, region_from_loops

__all__ = ["Loop", "Piece", "Region", "polygon_from_piece", "region_from_loops"]
