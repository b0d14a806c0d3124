"""All files of a plan, into one folder.

In: a Plan and a folder. Out: the paths that were written.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from brep_slicer.planning import check_complete
from brep_slicer.planning.report import header_of_plan

from .atomic import ensure_folder, write_text
from .pictures import draw_layers, draw_toolpath
from .tables import csv_metadata, write_tables

if TYPE_CHECKING:
    from brep_slicer.planning import Plan, PlanSections


def write_report(plan: PlanSections, folder: str | Path, **more: Any) -> Path:
    """Write report.json alone: of a plan, or of sections of which some failed; `more` is added to it."""
    report = plan.report() | more
    return write_text(ensure_folder(folder) / "report.json", json.dumps(report, indent=1, allow_nan=False) + "\n")


def write_plan(
    plan: Plan,
    folder: str | Path,
    *,
    allow_failed: bool = False,
    step: bool = False,
    dxf: bool = False,
    pictures: bool = True,
    proof: bool = False,
) -> list[Path]:
    """Write report.json, toolpath.csv, toolpath.json, layers.png, toolpath.png; beads.step and layers.dxf on request.

    With `proof`, report.json also says how even the metal is, and proof.png shows it.

    Raises
    ------
    InputError
        If the folder cannot be written to.
    LayerError
        If layers failed, unless `allow_failed`: only report.json is written then.
    """
    place = ensure_folder(folder)
    if not allow_failed and plan.failed:
        write_report(plan, place)
        check_complete(plan)
    proven = plan.proof() if proof else []
    written = [write_report(plan, place, **({"proof": proven} if proof else {}))]
    header = header_of_plan(plan)
    table, columns = write_tables(plan.toolpath, header, place)
    written += [table, write_text(place / "toolpath.csv-metadata.json", csv_metadata(header)), columns]
    if pictures:
        written.append(draw_layers(plan, place / "layers.png"))
        written.append(draw_toolpath(plan, place / "toolpath.png"))
        if proof:
            from .pictures.proof import draw_proof

            written.append(draw_proof(plan, proven, place / "proof.png"))
    if step:
        from .wires import write_bead_wires

        written.append(write_bead_wires(plan, place / "beads.step"))
    if dxf:
        from .dxf import write_dxf

        written.append(write_dxf(plan, place / "layers.dxf"))
    return written
