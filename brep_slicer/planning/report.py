"""What a plan says of itself: what was planned, from what, with which checks; report.json has it as it is.

In: the sections of a plan, with their fills and the toolpath where there are any. Out: plain values.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from brep_slicer.region import FailedLayer, Layer
from brep_slicer.version import version

if TYPE_CHECKING:
    from brep_slicer.fill import LayerFill
    from brep_slicer.toolpath import Toolpath

    from .planned import PlanSections


def header_of_plan(plan: PlanSections) -> dict[str, Any]:
    """What every output echoes: version, part, parameters and which of them were assumed."""
    return {
        "brep_slicer": version(),
        "part": plan.part.source,
        "unit_in_file": plan.part.unit,
        "process": plan.process.as_dict(),
        "assumed": plan.process.assumed(),
        "axis": plan.axis.as_dict(),
        "substrate_radius_mm": plan.substrate.radius,
    }


def report_of_plan(plan: PlanSections, fills: Sequence[LayerFill] = (), toolpath: Toolpath | None = None) -> dict[str, Any]:
    """The report as plain values (no NaN: what is not known is null); `fills` are those of the layers, if they are filled."""
    layers = _layers(plan, fills, toolpath)
    total = {
        key: math.fsum(layer[key] for layer in layers if layer.get(key) is not None)
        for key in ("deposition_length_mm", "travel_length_mm", "deposition_time_s", "travel_time_s")
    }
    total["beads"] = sum(layer.get("beads") or 0 for layer in layers)
    total["area_mm2"] = math.fsum(layer.area for layer in plan.layers)
    total["volume_mm3"] = math.fsum(layer.area * (layer.thickness or 0.0) for layer in plan.layers)
    return {
        **header_of_plan(plan),
        "solids": [
            {
                "index": s.index,
                "name": s.name,
                "stands_already": s.index in plan.substrate.solids,
                "built": s.index in plan.substrate.built,
            }
            for s in plan.part.solids
        ],
        "axis_was_given": plan.axis_was_given,
        "substrate": {
            "radius_mm": plan.substrate.radius,
            "reason": plan.substrate.reason,
            "solids": list(plan.substrate.solids),
            "roles": plan.substrate.roles,
            "built": list(plan.substrate.built),
            "left_alone": list(plan.substrate.alone),
            "collars_that_stand_mm": [list(zone) for zone in plan.substrate.zones],
            "left_out": plan.substrate.left_out,
        },
        "outermost_radius_mm": plan.highest,
        "overshoot_mm": plan.stack.overshoot,
        "undershoot_mm": plan.stack.undershoot,
        "layer_count": len(plan.layers) + len(plan.failed),
        "failed_layers": len(plan.failed),
        "sections": summary_of_sections(plan),
        "totals": {**total, "powder_mass_g": powder_mass(plan, total["deposition_time_s"])},
        "catchment": plan.process.catchment,
        "layers": layers,
        "warnings": list(plan.warnings),
        "notices": [notice.as_dict() for notice in plan.notices],
    }


def summary_of_sections(plan: PlanSections) -> str:
    """One line on how the layers were cut."""
    engines = [layer.certificate.engine.value for layer in plan.layers]
    counts = ", ".join(f"{engines.count(name)} by {name}" for name in sorted(set(engines)))
    bound = max((layer.certificate.bound for layer in plan.layers), default=0.0)
    failed = f", {len(plan.failed)} failed" if plan.failed else ""
    return f"{counts or 'none'}{failed}; outlines within {bound:.1e} mm"


def powder_mass(plan: PlanSections, seconds: float) -> float | None:
    """Powder fed while depositing, g; None without a feed rate."""
    feed = plan.process.powder.feed_g_s
    return None if feed is None else feed * seconds


def _layers(plan: PlanSections, fills: Sequence[LayerFill], toolpath: Toolpath | None) -> list[dict[str, Any]]:
    """A row a layer, in their order, those that failed too; without beads where nothing has been filled."""
    paths = {row["layer"]: row for row in toolpath.summary_by_layer()} if toolpath is not None else {}
    fill_of = dict(zip((layer.index for layer in plan.layers), fills, strict=bool(fills)))
    every: list[Layer | FailedLayer] = [*plan.layers, *plan.failed]
    out = []
    for layer in sorted(every, key=lambda layer: layer.index):
        row: dict[str, Any] = {
            "layer": layer.index,
            "radius_mm": layer.radius,
            "cut_radius_mm": layer.cut_radius,
            "thickness_mm": layer.thickness,
            "failed": layer.failed,
        }
        row |= {"reason": layer.reason} if isinstance(layer, FailedLayer) else _row(layer)
        if layer.index in fill_of:
            row |= _fill_row(fill_of[layer.index], paths.get(layer.index, {}))
        out.append(row)
    return out


def _row(layer: Layer) -> dict[str, Any]:
    return {
        "area_mm2": layer.area,
        "outline_length_mm": layer.region.length,
        "pieces": len(layer.region.pieces),
        "full_turns": sum(piece.winds for piece in layer.region.pieces),
        **layer.certificate.as_dict(),
    }


def _fill_row(fill: LayerFill, path: dict[str, Any]) -> dict[str, Any]:
    return {
        "hatch_angle_deg": [None if math.isnan(a) else math.degrees(a) for a in fill.angle],
        "step_over_mm": list(fill.step_over),
        "patterns": list(fill.patterns),
        "metal_share": list(fill.metal),
        "metal_beyond_outline_share": list(fill.beyond),
        "notes": [str(note) for note in fill.notes],
        **{
            key: path.get(key, 0)
            for key in ("beads", "deposition_length_mm", "travel_length_mm", "deposition_time_s", "travel_time_s")
        },
    }
