"""toolpath.json: the columns of toolpath.csv, with what was planned; `read_toolpath` reads it back.

In: a Plan. Out: one JSON object.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from ..tables import tables_of_plan
from ..writer import Writer

if TYPE_CHECKING:
    from brep_slicer.planning import Plan


class JsonWriter(Writer):
    """The toolpath as columns."""

    name = "json"
    suffix = ".json"
    help = "toolpath.json: the same as columns; reads back exactly"
    usual = True

    def write(self, plan: Plan, folder: Path) -> Path:
        return tables_of_plan(plan).write_json(folder)
