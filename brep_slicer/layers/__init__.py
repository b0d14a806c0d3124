"""What layers lie on: families of developable sheets, and how a sheet's chart closes round the axis.

`LayerFamily` (Cylinders, Cones, Planes) and `Sheet` hold all in which they differ; nothing else spells out rho, or adds a turn
to kappa by hand.
"""

from .closure import NO_CLOSURE, Closure, Motion
from .family import CYLINDERS, Cones, Cylinders, LayerFamily, Planes, cylinder
from .sheet import Sheet

__all__ = ["CYLINDERS", "NO_CLOSURE", "Closure", "Cones", "Cylinders", "LayerFamily", "Motion", "Planes", "Sheet", "cylinder"]
