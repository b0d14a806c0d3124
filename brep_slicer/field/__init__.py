"""The scalar field whose level sets are the layers (rho, the distance from the axis), on edges and faces of a solid.

In: a geometry.Brep in the axis frame. Out: monotone stretches of its edges, critical radii, the radial range.
"""

from .critical import Critical, critical_radii
from .flatness import FAINT, flatness_of, uses_of_edges
from .monotone import EdgeStretches, edge_stretches
from .radial import COINCIDENCE_BAND, SNAP, radial_gradient, radii_of

__all__ = [
    "COINCIDENCE_BAND",
    "FAINT",
    "SNAP",
    "Critical",
    "EdgeStretches",
    "critical_radii",
    "edge_stretches",
    "flatness_of",
    "radial_gradient",
    "radii_of",
    "uses_of_edges",
]
