"""What layers lie on: families of developable sheets, and how a sheet's chart closes round the axis.

`LayerFamily` (Cylinders, Cones, Planes) and `Sheet` hold all in which they differ; nothing else spells out rho, or adds a turn
to kappa by hand.
"""

from .closure import Closure, Motion
from .family import Cones, Cylinders, LayerFamily, Planes
from .sheet import Sheet

__all__ = ["Closure", "Cones", "Cylinders", "LayerFamily", "Motion", "Planes", "Sheet"]
