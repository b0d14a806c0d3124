"""Which version this is.

In: nothing. Out: the version as installed.
"""

from __future__ import annotations

from importlib import metadata


def version() -> str:
    """The installed version, or "unknown" from a bare source tree."""
    try:
        return metadata.version("brep-slicer")
    except metadata.PackageNotFoundError:
        return "unknown"
