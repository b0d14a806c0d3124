"""What all pictures share: their colours, and a file that says what it shows.

In: a Plan, an image. Out: a PNG under its final name.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

from brep_slicer.output.atomic import write_whole
from brep_slicer.planning.report import header_of_plan

if TYPE_CHECKING:
    from PIL.Image import Image

    from brep_slicer.planning import Plan

DEPOSIT, TRAVEL, METAL, OUTLINE = "#c8102e", "#1f5fbf", "#e9e4da", "#3c3c3c"
# Words: a title, what stands below it.
DARK, PALE = "#111111", "#555555"
# Pixels an inch of every page, and how hard a file is packed (0 to 9): harder takes longer than it saves.
DPI, PACKED = 100, 1


def saved(page: Image, plan: Plan, path: str | Path) -> Path:
    """The page as a PNG that carries version, part and parameters as text."""
    from PIL.PngImagePlugin import PngInfo

    text = PngInfo()
    text.add_text("Software", "brep_slicer")
    text.add_text("Description", json.dumps(header_of_plan(plan)))
    return write_whole(
        path, lambda temporary: page.save(temporary, format="png", pnginfo=text, dpi=(DPI, DPI), compress_level=PACKED)
    )


def name_of(plan: Plan) -> str:
    """The part's file name, for titles."""
    return Path(plan.part.source).name
