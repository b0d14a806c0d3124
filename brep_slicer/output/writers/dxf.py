"""layers.dxf: the unrolled layers as DXF: outlines and beads, a DXF layer for each.

In: a Plan. Out: a drawing in (kappa, v), mm; straight outlines stay lines, others are polylines to the chord of the process.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

from brep_slicer.curves import LineCurve
from brep_slicer.errors import InputError
from brep_slicer.planning.report import header_of_plan
from brep_slicer.region import Layer

from ..atomic import write_whole
from ..writer import Writer

if TYPE_CHECKING:
    from brep_slicer.planning import Plan


class DxfWriter(Writer):
    """Outlines and beads of every layer in the plane."""

    name = "dxf"
    suffix = ".dxf"
    help = "layers.dxf: the unrolled layers; needs ezdxf (pip install ezdxf)"

    def write(self, plan: Plan, folder: Path) -> Path:
        return write_dxf(plan, folder / "layers.dxf")


def write_dxf(plan: Plan, path: str | Path) -> Path:
    """Write layers.dxf.

    Raises
    ------
    InputError
        If ezdxf is not installed.
    """
    try:
        import ezdxf
    except ImportError:
        raise InputError("writing DXF needs ezdxf; pip install 'brep-slicer[dxf]'") from None
    drawing = ezdxf.new("R2010", units=4)
    drawing.header.custom_vars.append("brep_slicer", json.dumps(header_of_plan(plan)))
    space = drawing.modelspace()
    chord = plan.process.chord
    for layer, fill in zip(plan.layers, plan.fills, strict=True):
        if not isinstance(layer, Layer):
            continue
        outline, beads = (f"{kind}-{layer.index:04d}" for kind in ("OUTLINE", "BEADS"))
        drawing.layers.add(outline, color=7)
        drawing.layers.add(beads, color=1)
        for loop in layer.region.loops:
            for curve in loop.curves:
                if isinstance(curve, LineCurve):
                    space.add_line(tuple(curve.p0), tuple(curve.p1), dxfattribs={"layer": outline})
                else:
                    space.add_lwpolyline(curve.sample(chord).tolist(), dxfattribs={"layer": outline})
        for bead in fill.beads:
            space.add_lwpolyline(bead.points.tolist(), dxfattribs={"layer": beads})
    return write_whole(path, lambda temporary: drawing.saveas(temporary))
