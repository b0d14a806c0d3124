"""toolpath.csv and toolpath.json: every row, floats that read back exactly.

In: a Toolpath and what was planned. Out: text; the JSON reads back to the same Toolpath.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from brep_slicer.errors import InputError
from brep_slicer.maps import Array
from brep_slicer.toolpath import COLUMNS, KINDS, Toolpath

FORMAT = "brep_slicer toolpath 1"
# Rows in words at a time: some hundred bytes each for as long.
ROWS_AT_ONCE = 50_000

UNITS = {"x": "mm", "y": "mm", "z": "mm", "kappa": "mm", "v": "mm", "radius": "mm", "speed": "mm/s"}


def tables_from_toolpath(toolpath: Toolpath, header: dict[str, Any]) -> tuple[str, str]:
    """The text of toolpath.csv, one line of names and one line a point, and of toolpath.json, the same as columns.

    Both are made at once, since to find the shortest text of a number takes most of the time.
    """
    lines = [",".join(COLUMNS)]
    columns: dict[str, list[str]] = {name: [] for name in COLUMNS}
    for first in range(0, len(toolpath), ROWS_AT_ONCE):
        texts = _texts(toolpath, slice(first, first + ROWS_AT_ONCE))
        lines += map(",".join, zip(*texts.values(), strict=True))
        texts["kind"] = [f'"{kind}"' for kind in texts["kind"]]
        for name in COLUMNS:
            columns[name].append(", ".join(texts[name]))
    described = json.dumps({"format": FORMAT, **header}, allow_nan=False).removesuffix("}")
    listed = ", ".join(f'"{name}": [{", ".join(parts)}]' for name, parts in columns.items())
    return "\n".join(lines) + "\n", f'{described}, "columns": {{{listed}}}}}\n'


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
