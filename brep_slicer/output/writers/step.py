"""beads.step: beads as STEP wires, for CAD systems.

In: a Plan. Out: one wire a bead, in the file's frame, points to the chord of the process.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from brep_slicer.planning.report import header_of_plan

from ..atomic import write_whole
from ..writer import Writer

if TYPE_CHECKING:
    from brep_slicer.planning import Plan


class StepWriter(Writer):
    """The beads as wires."""

    name = "step"
    suffix = ".step"
    help = "beads.step: a wire a bead, for CAD systems"

    def write(self, plan: Plan, folder: Path) -> Path:
        return write_bead_wires(plan, folder / "beads.step")


def write_bead_wires(plan: Plan, path: str | Path) -> Path:
    """Write beads.step."""
    from brep_slicer.kernel.wires import write_step_wires

    toolpath = plan.toolpath
    # a bead's rows are its first point (which ends the travel to it) and the deposited ones that follow
    first = np.flatnonzero(~toolpath.deposits[:-1] & toolpath.deposits[1:])
    last = np.flatnonzero(toolpath.deposits & np.append(~toolpath.deposits[1:], True))
    lines = [toolpath.points[a : b + 1] for a, b in zip(first, last, strict=True)]
    said = json.dumps(header_of_plan(plan), ensure_ascii=True)
    return write_whole(path, lambda temporary: write_step_wires(lines, str(temporary), description=said))
