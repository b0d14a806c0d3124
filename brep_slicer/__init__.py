"""brep_slicer: laser metal deposition on shafts, planned on the exact B-Rep.

In: a solid (STEP, build123d, CadQuery, OCP). Out: coaxial cylindrical layers, beads at an exact step-over, toolpaths.

Names are loaded when they are first used, so that `import brep_slicer` is quick and needs no CAD kernel.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    # `as` marks a name as one of this module's own, for type checkers
    __version__: str

    from .curves import (
        Curve as Curve,
        CurveKind as CurveKind,
        Loop as Loop,
    )
    from .errors import (
        BrepSlicerError as BrepSlicerError,
        InputError as InputError,
        KernelError as KernelError,
        LayerError as LayerError,
        PlanningError as PlanningError,
    )
    from .fill import (
        AreaFill as AreaFill,
        Automatic as Automatic,
        Bead as Bead,
        BeadKind as BeadKind,
        Contours as Contours,
        FillArea as FillArea,
        FlankFollowing as FlankFollowing,
        Hatch as Hatch,
        Helix as Helix,
        LayerFill as LayerFill,
        Pattern as Pattern,
        PatternSequence as PatternSequence,
        Rings as Rings,
        Skeleton as Skeleton,
        Spiral as Spiral,
        Zigzag as Zigzag,
        fill_region as fill_region,
    )
    from .inspection import (
        Inspection as Inspection,
        inspect_part as inspect_part,
    )
    from .layers import (
        Cones as Cones,
        Cylinders as Cylinders,
        LayerFamily as LayerFamily,
        Planes as Planes,
        Sheet as Sheet,
    )
    from .output.tables import (
        read_toolpath as read_toolpath,
    )
    from .output.write import (
        write_plan as write_plan,
    )
    from .output.writer import (
        Writer as Writer,
    )
    from .part import (
        Part as Part,
        Solid as Solid,
        as_part as as_part,
        read_step as read_step,
    )
    from .planning import (
        Plan as Plan,
        plan as plan,
    )
    from .process import (
        CutAt as CutAt,
        Fill as Fill,
        LastLayer as LastLayer,
        Laser as Laser,
        Layers as Layers,
        Motion as Motion,
        Order as Order,
        OutlinePosition as OutlinePosition,
        Powder as Powder,
        Process as Process,
        Rule as Rule,
        parameter as parameter,
        read_process as read_process,
    )
    from .region import (
        FailedLayer as FailedLayer,
        Layer as Layer,
        Piece as Piece,
        Region as Region,
        slice_part as slice_part,
    )
    from .section import (
        Certificate as Certificate,
        Engine as Engine,
    )
    from .substrate.axis import (
        Axis as Axis,
        axis_candidates as axis_candidates,
        axis_from_line as axis_from_line,
        axis_from_text as axis_from_text,
        find_axis as find_axis,
    )
    from .substrate.radius import (
        Substrate as Substrate,
        coaxial_cylinders as coaxial_cylinders,
        find_substrate as find_substrate,
    )
    from .toolpath import (
        Toolpath as Toolpath,
    )


_HOMES = {
    "curves": ("Curve", "CurveKind", "Loop"),
    "errors": ("BrepSlicerError", "InputError", "KernelError", "LayerError", "PlanningError"),
    "fill": (
        "AreaFill",
        "Automatic",
        "Bead",
        "BeadKind",
        "Contours",
        "FillArea",
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
    "layers": ("Cones", "Cylinders", "LayerFamily", "Planes", "Sheet"),
    "output.tables": ("read_toolpath",),
    "output.write": ("write_plan",),
    "output.writer": ("Writer",),
    "part": ("Part", "Solid", "as_part", "read_step"),
    "planning": ("Plan", "plan"),
    "process": (
        "CutAt",
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
        "parameter",
        "read_process",
    ),
    "region": ("FailedLayer", "Layer", "Piece", "Region", "slice_part"),
    "section": ("Certificate", "Engine"),
    "substrate.axis": ("Axis", "axis_candidates", "axis_from_line", "axis_from_text", "find_axis"),
    "substrate.radius": ("Substrate", "coaxial_cylinders", "find_substrate"),
    "toolpath": ("Toolpath",),
}
_HOME_OF = {name: home for home, names in _HOMES.items() for name in names}

__all__ = sorted(_HOME_OF)


if not TYPE_CHECKING:  # to type checkers, a module with this function would have any name at all

    def __getattr__(name: str) -> Any:
        if name == "__version__":
            from .version import version

            return version()
        if name not in _HOME_OF:
            raise AttributeError(f"module 'brep_slicer' has no attribute {name!r}")
        value = getattr(importlib.import_module(f"brep_slicer.{_HOME_OF[name]}"), name)
        globals()[name] = value
        return value


def __dir__() -> list[str]:
    return [*__all__, "__version__"]
