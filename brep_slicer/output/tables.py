"""toolpath.csv and toolpath.json: every row, floats that read back exactly.

In: a Toolpath and what was planned. Out: text; the JSON reads back to the same Toolpath.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from brep_slicer.errors import InputError
from brep_slicer.toolpath import COLUMNS, KINDS, Toolpath

FORMAT = "brep_slicer toolpath 1"


UNITS = {"x": "mm", "y": "mm", "z": "mm", "kappa": "mm", "v": "mm", "radius": "mm", "speed": "mm/s"}


def csv_from_toolpath(toolpath: Toolpath) -> str:
    """The table: one line of names, one line a point."""
    lines = [",".join(COLUMNS)]
    numbers = np.column_stack([toolpath.points, toolpath.normals, toolpath.kappa, toolpath.v, toolpath.radius, toolpath.speed])
    kinds = np.where(toolpath.deposits, KINDS[0], KINDS[1]).tolist()
    rows = zip(toolpath.layer.tolist(), toolpath.bead.tolist(), kinds, numbers.tolist(), strict=True)
    # repr of a float is the shortest text that reads back to it
    lines += [f"{layer},{bead},{kind},{','.join(map(repr, row))}" for layer, bead, kind, row in rows]
    return "\n".join(lines) + "\n"


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


def json_from_toolpath(toolpath: Toolpath, header: dict[str, Any]) -> str:
    """The same as columns."""
    columns: dict[str, Any] = {
        "layer": toolpath.layer.tolist(),
        "bead": toolpath.bead.tolist(),
        "kind": np.where(toolpath.deposits, KINDS[0], KINDS[1]).tolist(),
    }
    for k, name in enumerate("xyz"):
        columns[name] = toolpath.points[:, k].tolist()
        columns["n" + name] = toolpath.normals[:, k].tolist()
    for name in ("kappa", "v", "radius", "speed"):
        columns[name] = getattr(toolpath, name).tolist()
    ordered = {name: columns[name] for name in COLUMNS}
    return json.dumps({"format": FORMAT, **header, "columns": ordered}, allow_nan=False) + "\n"


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
