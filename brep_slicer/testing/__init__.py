"""Checks that need no ground truth, for regression tests of parts and of this library.

In: a solid ready for cutting. Out: figures that two independent ways of computing must agree on: the volume identity
`integrate_sections`; the surface integrals `area_by_flux` and `volume_between`; how far a file's faces close, `closure_of`.
"""

from brep_slicer.section.oracle import area_by_flux, areas_by_flux, volume_between
from brep_slicer.section.volume import Closure, closure_of

from .volume import VolumeIntegral, integrate_sections

__all__ = ["Closure", "VolumeIntegral", "area_by_flux", "areas_by_flux", "closure_of", "integrate_sections", "volume_between"]
