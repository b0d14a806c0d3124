"""toolpath.csv and toolpath.json: every row, floats that read back exactly.

In: a Toolpath and what was planned. Out: files; the JSON reads back to the same Toolpath.
"""

from __future__ import annotations

import json
import os
import shutil
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO

import numpy as np

from brep_slicer.errors import InputError
from brep_slicer.maps import Array
from brep_slicer.planning.report import header_of_plan
from brep_slicer.toolpath import COLUMNS, KINDS, Toolpath

from .atomic import write_whole

if TYPE_CHECKING:
    from brep_slicer.planning import Plan

# What a plan keeps its tables under, between their two writers.
TABLES = "toolpath tables"
FORMAT = "brep_slicer toolpath 1"
# Rows in words at a time: a kilobyte each for as long, however long the toolpath is.
ROWS_AT_ONCE = 50_000
# Characters of a column that are copied at a time.
COPIED_AT_ONCE = 1_000_000

UNITS = {"x": "mm", "y": "mm", "z": "mm", "kappa": "mm", "v": "mm", "radius": "mm", "speed": "mm/s"}


class Tables:
    """A toolpath as toolpath.csv and as toolpath.json, put into words once if both are written, the table first.

    To find the shortest text of a number takes most of the time: while the table is written, some rows at a time, the columns
    in words go into files without a name, and wait there for toolpath.json, or for `close`.
    """

    def __init__(self, toolpath: Toolpath, header: dict[str, Any]) -> None:
        self.toolpath, self.header = toolpath, header
        self._columns: dict[str, TextIO] = {}

    def write_csv(self, folder: Path) -> Path:
        """Write toolpath.csv, one line of names and one line a point."""
        return write_whole(folder / "toolpath.csv", lambda path: self._put_into_words(path, folder))

    def write_json(self, folder: Path) -> Path:
        """Write toolpath.json, the same as columns."""
        try:
            if not self._columns:
                self._put_into_words(Path(os.devnull), folder)
            return write_whole(folder / "toolpath.json", lambda path: _write_columns(self.header, path, self._columns))
        finally:
            self.close()

    def close(self) -> None:
        """Let go of what waits."""
        for column in self._columns.values():
            column.close()
        self._columns = {}

    def _put_into_words(self, path: Path, folder: Path) -> None:
        self.close()
        self._columns = {name: _spool(folder) for name in COLUMNS}
        try:
            _write_rows(self.toolpath, path, self._columns)
        except BaseException:
            self.close()
            raise


def tables_of_plan(plan: Plan) -> Tables:
    """The tables of a plan, the same for both of their writers."""
    return plan.once(TABLES, lambda: Tables(plan.toolpath, header_of_plan(plan)))  # type: ignore[no-any-return]


def close_tables(plan: Plan) -> None:
    """Let go of what waits for a second writer that is not asked for."""
    tables_of_plan(plan).close()


def _spool(folder: Path) -> TextIO:
    """A file without a name, on the disk that has to take the text anyway."""
    return tempfile.TemporaryFile("w+", encoding="utf-8", newline="", dir=folder)


def _write_rows(toolpath: Toolpath, path: Path, columns: dict[str, TextIO]) -> None:
    """The lines of the table, and each column's words into its own file."""
    with path.open("w", encoding="utf-8") as table:
        table.write(",".join(COLUMNS) + "\n")
        for first in range(0, len(toolpath), ROWS_AT_ONCE):
            texts = _texts(toolpath, slice(first, first + ROWS_AT_ONCE))
            table.write("\n".join(map(",".join, zip(*texts.values(), strict=True))) + "\n")
            texts["kind"] = [f'"{kind}"' for kind in texts["kind"]]
            for name, column in columns.items():
                column.write((", " if first else "") + ", ".join(texts[name]))


def _write_columns(header: dict[str, Any], path: Path, columns: dict[str, TextIO]) -> None:
    """What was planned, and the columns one after the other."""
    described = json.dumps({"format": FORMAT, **header}, allow_nan=False).removesuffix("}")
    with path.open("w", encoding="utf-8") as out:
        before = f'{described}, "columns": {{'
        for name, column in columns.items():
            out.write(f'{before}"{name}": [')
            column.seek(0)
            shutil.copyfileobj(column, out, COPIED_AT_ONCE)
            before = "], "
        out.write("]}}\n")


def _texts(toolpath: Toolpath, rows: slice) -> dict[str, list[str]]:
    """Some rows in words, column by column in their order."""
    arrays = {name: getattr(toolpath, name) for name in ("layer", "bead", "kappa", "v", "radius", "speed")}
    arrays |= {name: toolpath.points[:, k] for k, name in enumerate("xyz")}
    arrays |= {"n" + name: toolpath.normals[:, k] for k, name in enumerate("xyz")}
    texts = {name: _shortest(array[rows]) for name, array in arrays.items()}
    texts["kind"] = np.where(toolpath.deposits[rows], *KINDS).tolist()
    return {name: texts[name] for name in COLUMNS}


def _shortest(values: Array) -> list[str]:
    """The shortest text of each number that reads back to it; of equal numbers it is found once."""
    if not np.isfinite(values).all():
        raise ValueError("a toolpath holds a value that is not finite")
    # compared by their bits: 0.0 and -0.0 are two texts
    _, first, which = np.unique(values.view(np.int64), return_index=True, return_inverse=True)
    return np.array([repr(value) for value in values[first].tolist()], dtype=object)[which].tolist()


def csv_metadata(header: dict[str, Any]) -> str:
    """What stands beside the table, by the W3C's "CSV on the Web": its columns and units, and what was planned."""
    columns = [{"name": name, "titles": name, **({"unit": UNITS[name]} if name in UNITS else {})} for name in COLUMNS]
    described = {
        "@context": "http://www.w3.org/ns/csvw",
        "url": "toolpath.csv",
        "tableSchema": {"columns": columns},
        "notes": [header],
    }
    return json.dumps(described, indent=1, allow_nan=False) + "\n"


def read_toolpath(path: str | Path) -> Toolpath:
    """The Toolpath of a toolpath.json.

    Raises
    ------
    InputError
        If the file is missing or holds no toolpath.
    """
    try:
        data = json.loads(Path(path).read_text(encoding="utf-8"))
        columns = data["columns"]
        if data.get("format") != FORMAT:
            raise InputError(f"{path}: format {data.get('format')!r} is not {FORMAT!r}; plan the part again")
        points, normals = (np.array([columns[p + k] for k in "xyz"], dtype=float).T.reshape(-1, 3) for p in ("", "n"))
        return Toolpath(
            layer=np.array(columns["layer"], dtype=np.int64),
            bead=np.array(columns["bead"], dtype=np.int64),
            deposits=np.array([kind == KINDS[0] for kind in columns["kind"]], dtype=bool),
            points=points,
            normals=normals,
            **{name: np.array(columns[name], dtype=float) for name in ("kappa", "v", "radius", "speed")},
        )
    except FileNotFoundError:
        raise InputError(f"{path}: there is no such file; give a toolpath.json") from None
    except (OSError, ValueError, KeyError, TypeError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"{path}: this is no toolpath.json ({error}); plan the part again") from None
