"""What all pictures share: their colours, a page without a window, and a file that says what it shows.

In: a Plan, a figure. Out: a PNG under its final name.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from brep_slicer.maps import Array
from brep_slicer.output.atomic import write_whole
from brep_slicer.output.report import header_of_plan

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from brep_slicer.planning import Plan

DEPOSIT, TRAVEL, METAL, OUTLINE = "#c8102e", "#1f5fbf", "#e9e4da", "#3c3c3c"
# Pixels an inch of every page, and how hard a file is packed (0 to 9): harder takes longer than it saves.
DPI, PACKED = 100, 3


def new_page(width: float, height: float) -> Figure:
    """An empty figure of so many inches that draws without a window."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), dpi=DPI)
    FigureCanvasAgg(figure)
    return figure


def saved(figure: Figure, plan: Plan, path: str | Path, *, under: Array | None = None) -> Path:
    """The figure as a PNG that carries version, part and parameters as text, drawn over an image `under` it.

    Parameters
    ----------
    under : ndarray of bytes, shape (height, width, 3), optional
        What shines through the white of the figure.
    """
    from PIL import Image
    from PIL.PngImagePlugin import PngInfo

    canvas: Any = figure.canvas
    canvas.draw()
    page = np.asarray(canvas.buffer_rgba())[..., :3]
    if under is not None:
        page = (page.astype(np.uint16) * under // 255).astype(np.uint8)
    text = PngInfo()
    text.add_text("Software", "brep_slicer")
    text.add_text("Description", json.dumps(header_of_plan(plan)))
    image = Image.fromarray(np.ascontiguousarray(page))
    return write_whole(
        path, lambda temporary: image.save(temporary, format="png", pnginfo=text, dpi=(DPI, DPI), compress_level=PACKED)
    )


def name_of(plan: Plan) -> str:
    """The part's file name, for titles."""
    return Path(plan.part.source).name
