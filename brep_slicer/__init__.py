"""brep_slicer: laser metal deposition on shafts, planned on the exact B-Rep.

In: a solid (STEP, build123d, CadQuery, OCP). Out: coaxial cylindrical layers, beads at an exact step-over, toolpaths.

Names are loaded when they are first used, so that `import brep_slicer` is quick and needs no CAD kernel.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .curves import Curve, CurveKind, Loop
    from .errors import BrepSlicerError, InputError, KernelError, LayerError, PlanningError
    from .fill import (
        Bead,
        BeadKind,
        Contours,
        FlankFollowing,
        Hatch,
        Helix,
        LayerFill,
        Pattern,
        PatternSequence,
        Rings,
        Skeleton,
        Spiral,
        Zigzag,
        fill_region,
    )
    from .inspection import Inspection, inspect_part
    from .output.tables import read_toolpath
    from .output.write import write_plan
    from .part import Part, Solid, as_part, read_step
    from .planning import Plan, plan
    from .process import CutAt, Fit, InnerPattern, LastLayer, Order, Process, Rule, read_process
    from .region import FailedLayer, Layer, Piece, Region, slice_part
    from .section import Certificate, Engine
    from .substrate.axis import Axis, axis_candidates, axis_from_line, axis_from_text, find_axis
    from .substrate.radius import Substrate, coaxial_cylinders, find_substrate
    from .toolpath import Toolpath

_HOMES = {
    "curves": ("Curve", "CurveKind", "Loop"),
    "errors": ("BrepSlicerError", "InputError", "KernelError", "LayerError", "PlanningError"),
    "fill": (
        "Bead",
        "BeadKind",
        "Contours",
        "FlankFollowing",
        "Hatch",
        "Helix",
        "LayerFill",
        "Pattern",
        "PatternSequence",
        "Rings",
        "Skeleton",
        "Spiral",
        "Zigzag",
        "fill_region",
    ),
    "inspection": ("Inspection", "inspect_part"),
    "output.tables": ("read_toolpath",),
    "output.write": ("write_plan",),
    "part": ("Part", "Solid", "as_part", "read_step"),
    "planning": ("Plan", "plan"),
    "process": ("CutAt", "Fit", "InnerPattern", "LastLayer", "Order", "Process", "Rule", "read_process"),
    "region": ("FailedLayer", "Layer", "Piece", "Region", "slice_part"),
    "section": ("Certificate", "Engine"),
    "substrate.axis": ("Axis", "axis_candidates", "axis_from_line", "axis_from_text", "find_axis"),
    "substrate.radius": ("Substrate", "coaxial_cylinders", "find_substrate"),
    "toolpath": ("Toolpath",),
}
_HOME_OF = {name: home for home, names in _HOMES.items() for name in names}

__all__ = sorted(_HOME_OF)


def __getattr__(name: str) -> Any:
    if name not in _HOME_OF:
        raise AttributeError(f"module 'brep_slicer' has no attribute {name!r}")
    value = getattr(importlib.import_module(f"brep_slicer.{_HOME_OF[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return __all__
