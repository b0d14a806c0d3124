"""The proof of a whole plan, layer by layer, as plain values.

In: a plan's layers, fills and toolpath. Out: for each layer coverage, deposit, measured step-over, duty.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from brep_slicer.fill import LayerFill
from brep_slicer.region import Layer
from brep_slicer.substrate.axis import Axis
from brep_slicer.toolpath import Toolpath

from .coverage import coverage_of
from .deposit import deposit_of
from .step_over import step_over_of

# Bins of the histogram of spacings.
BINS = 13
# Spacings within this of what their layer's fill asks for are as planned, mm.
AS_PLANNED = 1e-3


def proof_of_layers(
    layers: Sequence[tuple[Layer, LayerFill]],
    toolpath: Toolpath,
    axis: Axis,
    *,
    width: float,
    step_over: float,
    progress: Callable[[int, int], None] | None = None,
) -> list[dict[str, Any]]:
    """A row a layer: shares of area, mean height over t, variation, spacings in mm with their histogram, duty, starts."""
    summaries = {row["layer"]: row for row in toolpath.summary_by_layer()}
    whole = [(layer, fill) for layer, fill in layers if not layer.region.is_empty]
    rows = []
    for done, (layer, fill) in enumerate(whole, start=1):
        row = _row(layer, fill, toolpath, axis, width, step_over)
        rows.append({"layer": layer.index, **row, **_duty(summaries.get(layer.index))})
        if progress is not None:
            progress(done, len(whole))
    return rows


def summary_of_proof(rows: Sequence[dict[str, Any]]) -> str:
    """One line on the worst of all layers."""
    if not rows:
        return "no layer holds metal"
    bare = max(rows, key=lambda row: row["bare_share"])
    heights = [row["mean_height_over_t"] for row in rows]
    return (
        f"{spacings_in_words(rows)}; at most {100.0 * bare['bare_share']:.3g} % left bare (layer {bare['layer']});"
        f" mean height {min(heights):.3f} to {max(heights):.3f} t"
    )


def spacings_in_words(rows: Sequence[dict[str, Any]]) -> str:
    """At how many places neighbouring beads are as far apart as planned, and how far they are at the others."""
    measured = [row["step_over_measured_mm"] for row in rows if row["step_over_measured_mm"]["spacings"]]
    if not measured:
        return "no two beads beside each other"
    places, planned = (sum(m[key] for m in measured) for key in ("spacings", "as_planned"))
    apart = f"beads {_span([step for m in measured for step in m['planned']], '.4g')} mm apart as planned"
    others = [m[key] for m in measured for key in ("others_lowest", "others_highest") if m[key] is not None]
    if not others:
        return f"{apart} (within {AS_PLANNED:g} mm) at all {places} places measured"
    share = math.floor(1000.0 * planned / places) / 10.0
    return (
        f"{apart} (within {AS_PLANNED:g} mm) at {share:.3g} % of {places} places measured,"
        f" {_span(others, '.3f')} mm at the others (where beads are not parallel, as a hatch at its contour)"
    )


def _span(values: Sequence[float], form: str) -> str:
    low, high = f"{min(values):{form}}", f"{max(values):{form}}"
    return low if low == high else f"{low} to {high}"


def _row(layer: Layer, fill: LayerFill, toolpath: Toolpath, axis: Axis, width: float, step_over: float) -> dict[str, Any]:
    thickness = layer.thickness or 1.0
    coverage = coverage_of(layer.region, fill.beads, width)
    deposit = deposit_of(layer.region, fill.beads, width=width, thickness=thickness, step_over=step_over)
    spacings = step_over_of(toolpath, axis, layer.index).spacings
    near = spacings[spacings < 2.0 * step_over]
    planned = np.unique(np.round([step_over, *fill.step_over], 9))
    off = np.abs(near[:, None] - planned).min(axis=1) > AS_PLANNED
    others = near[off]
    counts, edges = np.histogram(near, bins=BINS, range=(0.5 * step_over, 1.5 * step_over))
    return {
        "bare_share": coverage.bare_share,
        "once_share": coverage.once / coverage.area,
        "more_share": coverage.more / coverage.area,
        "outside_mm2": coverage.outside,
        "mean_height_over_t": deposit.mean / thickness,
        "height_variation": deposit.variation,
        "height_within_2_percent": deposit.share_within(thickness, 0.02),
        "step_over_measured_mm": {
            "spacings": len(near),
            "lowest": float(near.min()) if len(near) else None,
            "highest": float(near.max()) if len(near) else None,
            "planned": planned.tolist(),
            "as_planned": int((~off).sum()),
            "others_lowest": float(others.min()) if len(others) else None,
            "others_highest": float(others.max()) if len(others) else None,
            "histogram": {"edges_mm": edges.tolist(), "counts": counts.tolist()},
        },
    }


def _duty(summary: dict[str, Any] | None) -> dict[str, Any]:
    """Share of the way with the laser on, and how often it starts."""
    if summary is None:
        return {"duty": None, "starts": 0}
    laid, moved = summary["deposition_length_mm"], summary["travel_length_mm"]
    return {"duty": laid / math.fsum([laid, moved]) if laid else 0.0, "starts": summary["beads"]}
