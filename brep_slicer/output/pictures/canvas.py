"""A page drawn with Pillow: areas, lines, arrows and words, anti-aliased; importing a plotting library would take longer.

In: places in pixels, x to the right and y down. Out: an image, and the PNG that it becomes.

Words: *fine*, how many times finer than the page shapes are drawn, before the mean over its pixels is taken.
"""

from __future__ import annotations

import functools
import importlib.util
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from brep_slicer.maps import Array

if TYPE_CHECKING:
    from PIL.Image import Image
    from PIL.ImageFont import FreeTypeFont, ImageFont

FINE = 2
# Pillow fills the pixels on an outline, too: an area is so much wider than it is said to be, pixels.
WIDER = 1.0 / FINE
# A dash and the gap after it, an arrow head's length and half its width, pixels.
DASH, GAP = 4.0, 3.0
HEAD, HALF_HEAD = 9.0, 3.6
Color = tuple[int, ...]
# Words on a page: place, text, height in pixels, colour, anchor as Pillow names it.
Words = tuple[tuple[float, float], str, int, str, str]


def rgb(name: str, alpha: float = 1.0) -> Color:
    """`#rrggbb` as red, green, blue and how opaque, 0 to 255."""
    return (*(int(name[k : k + 2], 16) for k in (1, 3, 5)), round(255 * alpha))


class Canvas:
    """A white page of so many pixels, or a given image; shapes are drawn `FINE` times finer, words after them."""

    def __init__(self, width: int, height: int) -> None:
        from PIL import Image, ImageDraw

        self._fine = Image.new("RGB", (FINE * width, FINE * height), "white")
        self._draw = ImageDraw.Draw(self._fine, "RGBA")

    def area(self, rings: Sequence[Array], color: Color) -> None:
        """An area between rings (n, 2): the outer one, then its holes."""
        # one line round all of it: the ways from ring to ring and back enclose nothing
        way = [*rings, *(ring[:1] for ring in reversed(rings[:-1]))]
        points = np.concatenate(way)
        if len(points) > 2:
            self._draw.polygon((FINE * points).ravel().tolist(), fill=color)

    def line(self, points: Array, color: Color, width: float = 1.0) -> None:
        """A line through points (n, 2), broken where they are nan."""
        for part in parts_of(points):
            self._draw.line((FINE * part).ravel().tolist(), fill=color, width=max(1, round(FINE * width)), joint="curve")

    def dashes(self, a: Array, b: Array, color: Color, width: float = 1.0) -> None:
        """Dashed lines from each of `a` (n, 2) to `b`."""
        length = np.hypot(*(b - a).T)
        count = np.maximum(1, np.ceil(length / (DASH + GAP))).astype(int)
        of = np.repeat(np.arange(len(a)), count)
        start = (np.arange(len(of)) - np.repeat(np.cumsum(count) - count, count)) * (DASH + GAP)
        way = (b - a)[of] / np.maximum(length, 1e-9)[of, None]
        first = a[of] + start[:, None] * way
        last = a[of] + np.minimum(start + DASH, length[of])[:, None] * way
        thick = max(1, round(FINE * width))
        for p in (FINE * np.concatenate([first, last], axis=1)).tolist():
            self._draw.line(p, fill=color, width=thick)

    def dots(self, places: Array, radius: float, color: Color) -> None:
        """Filled discs round places (n, 2)."""
        box = np.concatenate([places - radius, places + radius], axis=1)
        for p in (FINE * box).tolist():
            self._draw.ellipse(p, fill=color)

    def arrows(self, tips: Array, ways: Array, color: Color, size: float = 1.0) -> None:
        """Arrow heads with their `tips` (n, 2), pointing along unit vectors `ways`."""
        side = np.stack([-ways[:, 1], ways[:, 0]], axis=1)
        back = tips - size * HEAD * ways
        heads = np.stack([tips, back + size * HALF_HEAD * side, back - size * HALF_HEAD * side], axis=1)
        for p in (FINE * heads).reshape(len(tips), 6).tolist():
            self._draw.polygon(p, fill=color)

    def page(self) -> Image:
        """The page as it is now, in its own pixels."""
        return self._fine.reduce(FINE)


def parts_of(points: Array) -> list[Array]:
    """The stretches of a line (n, 2) between its nans, of two points at least."""
    broken = np.isnan(points[:, 0])
    if not broken.any():
        return [points] if len(points) > 1 else []
    parts = (part[~np.isnan(part[:, 0])] for part in np.split(points, np.flatnonzero(broken)))
    return [part for part in parts if len(part) > 1]


def write_words(page: Image, words: Iterable[Words], *, bold: bool = False) -> None:
    """Write on a page, in its own pixels."""
    from PIL import ImageDraw

    draw = ImageDraw.Draw(page)
    for place, text, size, color, anchor in words:
        draw.text(place, text, font=font(size, bold=bold), fill=color, anchor=anchor)


def width_of(text: str, size: int) -> float:
    """How wide words are, in pixels."""
    return float(font(size).getlength(text))


@functools.cache
def font(size: int, *, bold: bool = False) -> FreeTypeFont | ImageFont:
    """DejaVu Sans of a height in pixels, as matplotlib brings it along; Pillow's own where that is missing."""
    from PIL import ImageFont

    found: Any = importlib.util.find_spec("matplotlib")
    for folder in (found.submodule_search_locations or []) if found else []:
        path = Path(folder) / "mpl-data" / "fonts" / "ttf" / f"DejaVuSans{'-Bold' if bold else ''}.ttf"
        if path.exists():
            return ImageFont.truetype(str(path), size)
    return ImageFont.load_default(size)


__all__ = ["WIDER", "Canvas", "Words", "font", "parts_of", "rgb", "width_of", "write_words"]
