"""A solid cut with a cylinder: closed loops of exact unrolled curves, by two engines.

In: a solid about its axis and a radius. Out: loops with the material on their left, and the certificate of the engine.
"""

from .certificate import Certificate, Engine
from .cut_solid import CutSolid, cut_solid, cut_solids, noise_of_outermost
from .reach import reach_of_faces

__all__ = ["Certificate", "CutSolid", "Engine", "cut_solid", "cut_solids", "noise_of_outermost", "reach_of_faces"]
