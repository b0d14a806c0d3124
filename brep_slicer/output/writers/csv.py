"""toolpath.csv: a row a point, and beside it what the columns are.

In: a Plan. Out: two files.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from brep_slicer.planning.report import header_of_plan

from ..atomic import write_text
from ..tables import csv_metadata, tables_of_plan
from ..writer import Writer

if TYPE_CHECKING:
    from brep_slicer.planning import Plan


class CsvWriter(Writer):
    """The toolpath as a table."""

    name = "csv"
    suffix = ".csv"
    help = "toolpath.csv: a row a point; toolpath.csv-metadata.json: its columns"
    usual = True

    def write(self, plan: Plan, folder: Path) -> list[Path]:
        return [
            tables_of_plan(plan).write_csv(folder),
            write_text(folder / "toolpath.csv-metadata.json", csv_metadata(header_of_plan(plan))),
        ]
