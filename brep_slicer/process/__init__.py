"""How to deposit: parameters that are checked once, rules for some layers and pieces, process files.

In: numbers from Python, the command line or a TOML file. Out: a frozen Process.
"""

from .parameters import Process
from .rules import Rule
from .toml import process_from_values, read_process, read_process_values
from .values import CutAt, Fit, InnerPattern, LastLayer, Order, check_radii, choice, layer_range

__all__ = [
    "CutAt",
    "Fit",
    "InnerPattern",
    "LastLayer",
    "Order",
    "Process",
    "Rule",
    "check_radii",
    "choice",
    "layer_range",
    "process_from_values",
    "read_process",
    "read_process_values",
]
