"""layers.png: the unrolled layers with their beads at their width, one of them large.

In: a Plan. Out: a picture. Deposition is red and repositioning blue, as in the paper's Fig. 10.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from brep_slicer.region import Layer
from brep_slicer.wording import counted

from .canvas import Canvas, Words, rgb, write_words
from .page import DARK, PALE, name_of, saved
from .panels import Shown, draw_overview, draw_panel, framed, representative, whole

if TYPE_CHECKING:
    from brep_slicer.planning import Plan

# Beside the large one so many layers are shown in small, spread evenly, first and last among them.
MOST_SMALL = 6
# The page, its margin, what the title takes; the words above a panel; pixels.
PAGE, MARGIN, TITLE, WORDS = 1400, 20, 62, 36
# A large panel that is higher than this share of its width stands beside the small ones, not above them.
TALL = 0.42
# Height of a tall panel, a flat one's at most, the overview's at most and at least; pixels.
HIGH, FLAT, OVERVIEW, LOW = 640, 420, 190, 24
# Share of the page's width that a tall panel takes at most, and the pixels that its words take.
SHARE, WORDED = 0.5, 430.0
KEY = "beads red at their width, a dot where each starts, arrows as they run · repositioning blue · metal beige"


@dataclass(frozen=True, slots=True, kw_only=True)
class Panel:
    """A layer's number in the list, the `box` (left, top, width, height) that it is drawn in, `scale` in pixels a mm."""

    of: int
    box: tuple[float, float, float, float]
    scale: float


def draw_layers(plan: Plan, path: str | Path) -> Path:
    """The middle one of the unrolled layers large, others small; of several pieces one, and all of them in an overview."""
    pairs = [(la, f) for la, f in zip(plan.layers, plan.fills, strict=True) if not la.region.is_empty]
    words: list[Words] = [((MARGIN, 38), KEY, 12, PALE, "la")]
    if not pairs:
        words.append(((MARGIN, 76), "no layer holds metal", 14, DARK, "la"))
        return _written(plan, Canvas(PAGE // 2, 120), words, path)
    main = len(pairs) // 2
    small = [i for i in _spread(len(pairs), MOST_SMALL + 1) if i != main][:MOST_SMALL]
    shown = {i: representative(*pairs[i], width=plan.process.width) for i in (main, *small)}
    every = (
        whole(*pairs[main], width=plan.process.width) if len(pairs[main][0].region.pieces) > 1 and shown[main].words else None
    )
    large, others, overview, height = _laid_out(shown, main, small, every)
    canvas = Canvas(PAGE, height)
    for panel in (large, *others):
        what, layer = shown[panel.of], pairs[panel.of][0]
        frame = framed(what.window, panel.box, panel.scale)
        draw_panel(canvas, what, frame, width=plan.process.width, large=panel is large)
        words += _words_of(layer, len(pairs[panel.of][1].beads), what, panel, large=panel is large)
        if panel is large:
            words += _scale_bar(canvas, panel)
    if every is not None and overview is not None:
        draw_overview(canvas, every, shown[main], framed(every.window, overview.box, overview.scale))
        text = (
            f"all of layer {pairs[main][0].index}, {counted(len(every.layer.region.pieces), 'piece')}; the one above is darker"
        )
        words.append(((overview.box[0], overview.box[1] - 16), text, 12, PALE, "la"))
    return _written(plan, canvas, words, path)


def _written(plan: Plan, canvas: Canvas, words: list[Words], path: str | Path) -> Path:
    page = canvas.page()
    write_words(
        page, [((MARGIN, 12), f"{name_of(plan)}: {counted(len(plan.layers), 'layer')}, unrolled", 18, DARK, "la")], bold=True
    )
    write_words(page, words)
    return saved(page, plan, path)


def _laid_out(
    shown: dict[int, Shown], main: int, small: list[int], every: Shown | None
) -> tuple[Panel, list[Panel], Panel | None, int]:
    """The large panel, the small ones, the overview if there is one, and the page's height."""
    wide, high = _size(shown[main])
    room = PAGE - 2 * MARGIN
    top = TITLE + WORDS
    if high > TALL * wide:
        scale = min(HIGH / high, (SHARE * room if small else room) / wide)
        # the words above it need room, too
        width = max(scale * wide, WORDED)
        large = Panel(of=main, box=(MARGIN, top, width, HIGH), scale=scale)
        # the small ones use what the large one leaves
        left = MARGIN + width + 2 * MARGIN
        others, _ = _small_ones(shown, small, (left, TITLE, PAGE - MARGIN - left, top + HIGH - TITLE))
        bottom: float = top + HIGH
    else:
        scale = min(room / wide, FLAT / high)
        large = Panel(of=main, box=(MARGIN, top, room, scale * high), scale=scale)
        low = top + scale * high + MARGIN + 26
        others, bottom = _small_ones(shown, small, (MARGIN, low, room, math.inf))
    if every is None:
        return large, others, None, round(bottom + 36)
    w, h = _size(every)
    scale = min(room / w, OVERVIEW / h)
    box = (MARGIN, bottom + 56.0, room, max(scale * h, LOW))
    return large, others, Panel(of=main, box=box, scale=scale), round(box[1] + box[3] + MARGIN)


def _small_ones(shown: dict[int, Shown], small: list[int], box: tuple[float, float, float, float]) -> tuple[list[Panel], float]:
    """Panels of one scale in the columns that make them largest, and where they end; a box may be endless downwards."""
    left, top, width, height = box
    if not small:
        return [], top - WORDS if math.isinf(height) else top + height
    sizes = np.array([_size(shown[i]) for i in small])
    wide, high = sizes.max(axis=0)
    best = (0.0, 1)
    for columns in range(1, len(small) + 1):
        rows = math.ceil(len(small) / columns)
        # words need room, however narrow a piece is
        cell = (width - (columns - 1) * MARGIN) / columns
        tall = height / rows - WORDS - MARGIN if math.isfinite(height) else FLAT / rows
        if cell >= 150.0 and tall > 0.0:
            # an uneven last row is so much page that shows nothing
            best = max(best, (min(cell / wide, tall / high) * len(small) / (rows * columns), columns))
    columns = best[1]
    rows = math.ceil(len(small) / columns)
    cell = (width - (columns - 1) * MARGIN) / columns
    scale = best[0] * rows * columns / len(small) if best[0] else min(cell / wide, FLAT / high)
    tall = height / rows if math.isfinite(height) else scale * high + WORDS + MARGIN
    panels = []
    for k, i in enumerate(small):
        x, y = left + k % columns * (cell + MARGIN), top + k // columns * tall
        panels.append(Panel(of=i, box=(x, y + WORDS, cell, tall - WORDS - MARGIN), scale=scale))
    return panels, top + rows * tall - MARGIN


def _size(what: Shown) -> tuple[float, float]:
    left, low, right, top = what.window
    return max(right - left, 1e-6), max(top - low, 1e-6)


def _words_of(layer: Layer, beads: int, what: Shown, panel: Panel, *, large: bool) -> list[Words]:
    """Two lines above a panel."""
    x, y = panel.box[0], panel.box[1] - WORDS
    first = f"layer {layer.index} · R {layer.radius:.6g} mm"
    second = f"{layer.area:.5g} mm² · {counted(beads, 'bead')}"
    if not large:
        return [((x, y), first, 13, DARK, "la"), ((x, y + 16), second, 11, PALE, "la")]
    k0, v0, k1, v1 = what.metal
    chosen = f" · {what.words} shown" if what.words else ""
    size = f"{k1 - k0:.4g} mm round (κ) by {v1 - v0:.4g} mm along (v)"
    return [((x, y - 4), f"{first} · {second}", 14, DARK, "la"), ((x, y + 15), f"{size}{chosen}", 12, PALE, "la")]


def _scale_bar(canvas: Canvas, panel: Panel) -> list[Words]:
    length = round_length(140.0 / panel.scale)
    x, y = panel.box[0], panel.box[1] + panel.box[3] + 12.0
    canvas.line(np.array([[x, y], [x + length * panel.scale, y]]), rgb(DARK), 2.0)
    return [((x + length * panel.scale + 8, y), f"{length:g} mm", 12, DARK, "lm")]


def round_length(about: float) -> float:
    """The largest of 1, 2, 5, 10, ... that is no longer than `about`, mm."""
    decade = 10.0 ** math.floor(math.log10(about))
    return max(step * decade for step in (1.0, 2.0, 5.0) if step * decade <= about)


def _spread(count: int, most: int) -> list[int]:
    if count <= most:
        return list(range(count))
    return sorted({round(i * (count - 1) / (most - 1)) for i in range(most)})


__all__ = ["draw_layers", "round_length"]
