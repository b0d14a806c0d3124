"""Pictures of a plan, a module each: layers.png, toolpath.png, proof.png.

In: a Plan. Out: PNG files. Deposition is red and repositioning blue, as in the paper's Fig. 10.
"""

from .axes import draw_layer
from .layers import draw_layers
from .toolpath import draw_toolpath

__all__ = ["draw_layer", "draw_layers", "draw_toolpath"]
