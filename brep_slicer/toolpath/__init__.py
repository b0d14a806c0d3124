"""Beads lifted to the metal, and the travels between them.

In: beads in the plane, layer by layer. Out: a Toolpath of points with normals in the file's frame.
"""

from .lift import DepositLayer, Motion, lift_layers
from .obstacles import Obstacles, obstacles_of
from .toolpath import COLUMNS, KINDS, Toolpath

__all__ = ["COLUMNS", "KINDS", "DepositLayer", "Motion", "Obstacles", "Toolpath", "lift_layers", "obstacles_of"]
