"""Processes from TOML files and from the plain values of the command.

In: a file, or names and values as they stand in one. Out: a Process, or an InputError that names the file.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any

from brep_slicer.errors import InputError

from .parameters import Process
from .values import check_names


def read_process(path: str | Path, **overrides: Any) -> Process:
    """A Process from a TOML file whose keys are the parameters' names (angles as hatch_angles_deg, hatch_angle_step_deg).

    Raises
    ------
    InputError
        If the file is missing, is no TOML, or holds a key or a value that cannot be used.
    """
    return process_from_values(read_process_values(path), source=str(path), **overrides)


def read_process_values(path: str | Path) -> dict[str, Any]:
    """The plain values of a process file, not yet checked against each other."""
    try:
        return tomllib.loads(Path(path).read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise InputError(f"{path}: there is no such file; give a TOML file with process parameters") from None
    except RecursionError:
        raise InputError(
            f"{path}: its lists are nested too deeply to be process parameters; write one `name = value` a line"
        ) from None
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise InputError(f"{path}: not a readable TOML file ({error}); write one `name = value` a line") from None


def process_from_values(values: Mapping[str, Any], *, source: str = "process", **overrides: Any) -> Process:
    """A Process from plain values as they stand in TOML; every error names the `source`."""
    try:
        check_names(values, [f.name for f in fields(Process)], "process parameter")
        given = dict(values) | {name: value for name, value in overrides.items() if value is not None}
        missing = [n for n in ("layer_thickness", "step_over") if n not in given]
        if missing:
            raise InputError(f"{' and '.join(missing)} not given; both are required (-t and -d at the command)")
        return Process(**given)
    except InputError as error:
        raise InputError(f"{source}: {error}") from None
