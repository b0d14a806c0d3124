"""report.json: what was planned, from what, with which checks.

In: a Plan, or sections of which some failed. Out: one JSON object.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

from ..atomic import write_text
from ..writer import Writer

if TYPE_CHECKING:
    from brep_slicer.planning import Plan, PlanSections


class ReportWriter(Writer):
    """Everything that a plan says of itself; with how even the metal is, where that was proved."""

    name = "report"
    suffix = ".json"
    help = "report.json: what was planned and assumed, layer by layer; always written"
    usual = True

    def write(self, plan: Plan, folder: Path) -> Path:
        return write_report(plan, folder)


def write_report(plan: PlanSections, folder: Path) -> Path:
    """Write report.json of a plan, or of sections of which some failed."""
    return write_text(folder / "report.json", json.dumps(plan.report(), indent=1, allow_nan=False) + "\n")
