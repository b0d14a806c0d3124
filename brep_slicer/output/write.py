"""A plan into a folder, by the writers that are asked for.

In: a Plan, a folder, names of writers. Out: the paths that were written.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from brep_slicer.errors import InputError
from brep_slicer.planning import check_complete

from .atomic import ensure_folder
from .tables import close_tables
from .writer import Writer
from .writers import WRITERS
from .writers.report import ReportWriter, write_report

if TYPE_CHECKING:
    from brep_slicer.planning import Plan, PlanSections

Writers = str | Writer | Sequence[str | Writer]


def report_alone(plan: PlanSections, folder: str | Path) -> Path:
    """Write report.json and nothing else: of sections of which some failed."""
    return write_report(plan, ensure_folder(folder))


def write_plan(
    plan: Plan, folder: str | Path, *, write: Writers | None = None, allow_failed: bool = False, proof: bool = False
) -> list[Path]:
    """Write a plan: report.json, and by default toolpath.csv, toolpath.json, layers.png, toolpath.png.

    Parameters
    ----------
    plan : Plan
        What is written.
    folder : str or Path
        Where; it is made if need be.
    write : str, Writer, or a sequence of them, optional
        Names as "csv,dxf" or ["csv", "dxf"], and writers of one's own; what begins with "+" comes beside the usual ones.
    allow_failed : bool
        Write a plan of which some layers failed, too.
    proof : bool
        Prove how even the metal is, if that has not been done: it is in report.json and proof.png.

    Raises
    ------
    InputError
        If there is no such writer, or the folder cannot be written to.
    LayerError
        If layers failed, unless `allow_failed`: only report.json is written then.
    """
    writers = writers_of(write)
    place = ensure_folder(folder)
    if not allow_failed and plan.failed:
        write_report(plan, place)
        check_complete(plan)
    if proof:
        plan.proof()
    written: list[Path] = []
    try:
        for writer in writers:
            done = writer.write(plan, place)
            written += [done] if isinstance(done, Path) else done
    finally:
        close_tables(plan)
    return written


def writers_of(write: Writers | None) -> list[Writer]:
    """The writers of some names, the report's first and whatever is named; the usual ones for None.

    Raises
    ------
    InputError
        If there is none of a name; the message has the nearest one.
    """
    words = write.split(",") if isinstance(write, str) else write
    asked: list[Any] = [words] if isinstance(words, Writer) else list(words or ())
    names = [name.strip() if isinstance(name, str) else name for name in asked]
    beside = write is None or any(isinstance(name, str) and name.startswith("+") for name in names)
    out: list[Writer] = [ReportWriter()]
    if beside:
        usual = [WRITERS.load(name) for name in WRITERS.own()]
        out += [kind() for kind in usual if kind.usual]
    for name in names:
        if isinstance(name, Writer):
            out.append(name)
        elif isinstance(name, str):
            out.append(WRITERS.load(name.removeprefix("+").strip())())
        else:
            raise InputError(f"write is {name!r}; give writers' names, as 'csv,json', or a Writer")
    # each once
    return list({type(writer): writer for writer in out}.values())
