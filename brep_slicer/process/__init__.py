"""How to deposit: parameters that are declared and checked in one place, rules for some layers and pieces, process files.

In: numbers from Python, the command line or a TOML file. Out: a frozen Process.
"""

from .groups import GROUPS, Fill, Laser, Layers, Motion, Powder
from .parameter import Declared, parameter
from .parameters import Process
from .patterns import PATTERNS
from .rules import Rule
from .toml import process_from_values, read_process, read_process_values
from .values import CutAt, LastLayer, Order, OutlinePosition, check_levels, check_radii, choice, layer_range

__all__ = [
    "GROUPS",
    "PATTERNS",
    "CutAt",
    "Declared",
    "Fill",
    "LastLayer",
    "Laser",
    "Layers",
    "Motion",
    "Order",
    "OutlinePosition",
    "Powder",
    "Process",
    "Rule",
    "check_levels",
    "check_radii",
    "choice",
    "layer_range",
    "parameter",
    "process_from_values",
    "read_process",
    "read_process_values",
]
