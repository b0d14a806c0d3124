"""Edge curves and face surfaces of a solid as plain numpy values, evaluated over whole arrays; no CAD kernel.

In: the parameters that the kernel read. Out: points and derivatives, in the axis frame (mm).
"""

from .brep import Brep, Edge, EdgeUse, Face
from .edge_curves import BSplineEdge, ConicEdge, EdgeCurve, LineEdge
from .patches import Patches, patches_of
from .surfaces import BSplineSurface, BSplineSurfacePack, ElementarySurface, Extrusion, Revolution, Surface, SurfaceKind

__all__ = [
    "BSplineEdge",
    "BSplineSurface",
    "BSplineSurfacePack",
    "Brep",
    "ConicEdge",
    "Edge",
    "EdgeCurve",
    "EdgeUse",
    "ElementarySurface",
    "Extrusion",
    "Face",
    "LineEdge",
    "Patches",
    "Revolution",
    "Surface",
    "SurfaceKind",
    "patches_of",
]
