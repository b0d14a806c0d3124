"""Files that appear whole or not at all.

In: a path and what writes the content. Out: the file under its final name, or an error and nothing.
"""

from __future__ import annotations

import contextlib
import os
import tempfile
from collections.abc import Callable
from pathlib import Path

from brep_slicer.errors import InputError


def ensure_folder(folder: str | Path) -> Path:
    """The output folder, made if need be and checked for writing.

    Raises
    ------
    InputError
        If it is a file, or cannot be made or written to.
    """
    path = Path(folder)
    try:
        path.mkdir(parents=True, exist_ok=True)
    except (FileExistsError, NotADirectoryError):
        raise InputError(f"{path}: this is a file; give a folder to write to") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be made ({error.strerror}); give another folder with -o") from None
    if not os.access(path, os.W_OK | os.X_OK):
        raise InputError(f"{path}: cannot be written to; give another folder with -o")
    return path


def write_whole(path: str | Path, write: Callable[[Path], None]) -> Path:
    """Call `write` with a temporary name in the same folder, then rename it to `path`."""
    path = Path(path)
    # the suffix is kept: writers choose the format by it
    handle, name = tempfile.mkstemp(prefix=f".{path.stem}.", suffix=path.suffix, dir=path.parent)
    os.close(handle)
    temporary = Path(name)
    try:
        write(temporary)
        mask = os.umask(0)
        os.umask(mask)
        temporary.chmod(0o666 & ~mask)
        temporary.replace(path)
    except OSError as error:
        raise InputError(f"{path}: cannot be written ({error.strerror or error}); check space and permissions") from None
    finally:
        with contextlib.suppress(FileNotFoundError):
            temporary.unlink()
    return path


def write_text(path: str | Path, text: str) -> Path:
    """Write text in UTF-8, whole or not at all."""

    def write(temporary: Path) -> None:
        temporary.write_text(text, encoding="utf-8")

    return write_whole(path, write)
