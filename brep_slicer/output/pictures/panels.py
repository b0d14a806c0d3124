"""One unrolled layer, or a piece of it, drawn into a box of a page, with the beads at their width.

In: a layer with its beads, a box in pixels. Out: nothing; a canvas is drawn on.

Words: *panel*, a box of the page and the part of the plane that it shows; *representative*, the piece that stands for all that
are equal to it but for where they lie.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from brep_slicer.fill import LayerFill
from brep_slicer.layers import NO_CLOSURE, Closure
from brep_slicer.maps import Array, lengths_along
from brep_slicer.region import Layer

from .canvas import WIDER, Canvas, parts_of, rgb
from .page import DEPOSIT, METAL, OUTLINE, TRAVEL
from .unrolled import is_band, metal_of, moves_of, shown, strips_of

# Pieces are equal where size, second moments and length of bead differ by no more than this share.
ALIKE = 1e-3
# How opaque a bead's width is: where two overlap is seen.
BROAD = 0.26
# Pixels from arrow to arrow along a bead, and the least length of a bead that gets one.
ARROWS, ARROWED = 260.0, 34.0
# Where the mixed second moment stands among a piece's marks, after the other two.
MIXED = 6
PICKED = "#f3c9c4"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Shown:
    """What a panel shows: the `layer` with only the pieces in it, their beads, the polygons; `words` on how it was chosen.

    `metal` and `window`, which has room for the beads, too, are (left, low, right, top) in mm.
    """

    layer: Layer
    fill: LayerFill
    polygons: list[Any]
    words: str
    metal: tuple[float, float, float, float]
    window: tuple[float, float, float, float]


def whole(layer: Layer, fill: LayerFill, *, width: float) -> Shown:
    """All of a layer, with room for beads of `width` (mm)."""
    polygons = metal_of(layer)
    boxes = np.array([polygon.bounds for polygon in polygons])
    low, high = boxes[:, :2].min(axis=0), boxes[:, 2:].max(axis=0)
    middle, closure, half = 0.5 * (low + high), layer.region.closure, 0.5 * width
    lines = _all_beside([shown(bead.points, layer) for bead in fill.beads], middle, closure)
    laid = np.concatenate([np.stack([low + half, high - half]), *lines])
    least, most = np.minimum(low, np.nanmin(laid, axis=0) - half), np.maximum(high, np.nanmax(laid, axis=0) + half)
    if is_band(layer):
        # a full turn's chart ends where it is cut
        least[0], most[0] = low[0], high[0]
    window = (*least.tolist(), *most.tolist())
    metal = (*low.tolist(), *high.tolist())
    return Shown(layer=layer, fill=fill, polygons=polygons, words="", metal=metal, window=window)


def representative(layer: Layer, fill: LayerFill, *, width: float) -> Shown:
    """The piece that stands for most of a layer's metal with its beads; all of a layer with a full turn or of one piece."""
    pieces = layer.region.pieces
    if len(pieces) < 2 or is_band(layer):
        return whole(layer, fill, width=width)
    group = groups_of_equals(layer, fill)
    areas = np.bincount(group, [piece.area() for piece in pieces])
    members = np.flatnonzero(group == areas.argmax())
    chosen = int(min(members, key=lambda i: abs(sum(pieces[i].bounds()[::2]))))
    region = replace(layer.region, pieces=(pieces[chosen],))
    beads = tuple(bead for bead in fill.beads if bead.piece == chosen)
    words = f"one of {len(pieces)} equal pieces"
    if len(members) < len(pieces):
        words = f"one of {len(members)} equal pieces of {len(pieces)}" if len(members) > 1 else f"one of {len(pieces)} pieces"
    shown_fill = replace(fill, beads=beads)
    return replace(whole(replace(layer, region=region), shown_fill, width=width), words=words)


def groups_of_equals(layer: Layer, fill: LayerFill) -> Array:
    """A number for every piece (n,), the same for those that are equal but for where they lie on the cylinder."""
    pieces = layer.region.pieces
    laid = np.zeros((len(pieces), 2))
    for bead in fill.beads:
        laid[bead.piece] += 1.0, bead.length()
    marks = np.array([_marks(layer, number) for number in range(len(pieces))])
    marks = np.concatenate([marks, laid], axis=1)
    # each figure against the largest of its kind; a mixed moment of nothing is nothing beside the other two
    scale = np.abs(marks).max(axis=0)
    scale[MIXED] = math.sqrt(scale[MIXED - 1] * scale[MIXED - 2])
    marks /= np.maximum(scale, 1e-300)
    group = np.full(len(pieces), -1)
    for number in range(len(pieces)):
        if group[number] < 0:
            group[(group < 0) & (np.abs(marks - marks[number]).max(axis=1) <= ALIKE)] = number
    return np.unique(group, return_inverse=True)[1].ravel()


def _marks(layer: Layer, number: int) -> list[float]:
    """Area, outline, box and central second moments of a piece, mm to their powers."""
    piece = layer.region.pieces[number]
    k0, v0, k1, v1 = piece.bounds()
    xx = yy = xy = area = mx = my = 0.0
    for loop in piece.loops:
        x, y = (loop.sample(0.1) - [k0, v0]).T
        cross = x[:-1] * y[1:] - x[1:] * y[:-1]
        a, b, c, d = x[:-1], x[1:], y[:-1], y[1:]
        area += 0.5 * cross.sum()
        mx += (cross * (a + b)).sum() / 6.0
        my += (cross * (c + d)).sum() / 6.0
        xx += (cross * (a * a + a * b + b * b)).sum() / 12.0
        yy += (cross * (c * c + c * d + d * d)).sum() / 12.0
        xy += (cross * (a * d + 2.0 * a * c + 2.0 * b * d + b * c)).sum() / 24.0
    area = max(area, 1e-300)
    moments = [xx - mx * mx / area, yy - my * my / area, xy - mx * my / area]
    return [piece.area(), piece.length(), k1 - k0, v1 - v0, *moments]


@dataclass(frozen=True, slots=True, kw_only=True)
class Frame:
    """How a panel's plane lies on the page: `scale` pixels a mm, the pixel of (kappa, v) = (`kappa`, `v`) is (`x`, `y`)."""

    scale: float
    kappa: float
    v: float
    x: float
    y: float

    def places(self, points: Array) -> Array:
        """Pixels of points (n, 2) in mm."""
        return np.stack(
            [self.x + (points[:, 0] - self.kappa) * self.scale, self.y - (points[:, 1] - self.v) * self.scale], axis=1
        )


def framed(window: tuple[float, float, float, float], box: tuple[float, float, float, float], scale: float) -> Frame:
    """The window's middle in the middle of a box (left, top, width, height) of the page."""
    left, low, right, top = window
    x, y = box[0] + 0.5 * box[2], box[1] + 0.5 * box[3]
    return Frame(scale=scale, kappa=0.5 * (left + right), v=0.5 * (low + top), x=x, y=y)


def draw_panel(canvas: Canvas, what: Shown, frame: Frame, *, width: float, large: bool) -> None:
    """Metal, beads at their `width` (mm), their starts; `large` with directions and the ways between."""
    layer, closure = what.layer, what.layer.region.closure
    middle = _middle(what)
    _draw_metal(canvas, what, frame, rgb(METAL))
    lines = _all_beside([shown(bead.points, layer) for bead in what.fill.beads], middle, closure)
    turn = closure if is_band(layer) else NO_CLOSURE
    for rings in strips_of(lines, max(width - WIDER / frame.scale, 0.1 * width), within=turn):
        canvas.area([frame.places(ring) for ring in rings], rgb(DEPOSIT, BROAD))
    for loop in layer.region.loops:
        for part in parts_of(_beside(shown(loop.sample(0.02), layer), middle, closure)):
            canvas.line(frame.places(part), rgb(OUTLINE), 1.2 if large else 1.0)
    ways = _all_beside(moves_of(layer, what.fill), middle, closure) if large else []
    ends = [frame.places(part[[0, -1]]) for way in ways for part in parts_of(way)]
    if ends:
        both = np.array(ends)
        canvas.dashes(both[:, 0], both[:, 1], rgb(TRAVEL))
    for line in lines:
        for part in parts_of(line):
            canvas.line(frame.places(part), rgb(DEPOSIT), 1.6 if large else 1.0)
    if lines:
        canvas.dots(frame.places(np.array([line[0] for line in lines])), 3.6 if large else 2.0, rgb(DEPOSIT))
    if large:
        _draw_arrows(canvas, [frame.places(part) for line in lines for part in parts_of(line)])


def draw_overview(canvas: Canvas, what: Shown, picked: Shown, frame: Frame) -> None:
    """A whole layer in small: its pieces, the one that is shown large, the beads as lines."""
    _draw_metal(canvas, what, frame, rgb(METAL))
    _draw_metal(canvas, picked, frame, rgb(PICKED))
    for loop in what.layer.region.loops:
        canvas.line(frame.places(_onto(shown(loop.sample(0.05), what.layer), what)), rgb(OUTLINE), 0.5)
    for bead in what.fill.beads:
        canvas.line(frame.places(_onto(shown(bead.points, what.layer), what)), rgb(DEPOSIT, 0.8), 0.5)


def _draw_metal(canvas: Canvas, what: Shown, frame: Frame, color: tuple[int, ...]) -> None:
    for polygon in what.polygons:
        rings = [np.asarray(ring.coords) for ring in (polygon.exterior, *polygon.interiors)]
        canvas.area([frame.places(ring) for ring in rings], color)


def _beside(points: Array, middle: Array, closure: Closure) -> Array:
    """Points whole turns away, as near to `middle` (kappa, v; mm) as may be."""
    return _all_beside([points], middle, closure)[0]


def _all_beside(lines: list[Array], middle: Array, closure: Closure) -> list[Array]:
    """The same of each of several lines by itself."""
    if not lines:
        return []
    points, lengths = np.concatenate(lines), [len(line) for line in lines]
    first = np.cumsum([0, *lengths[:-1]])
    # a line may be broken, with NaN in between
    at = 0.5 * (np.fmin.reduceat(points, first) + np.fmax.reduceat(points, first))
    turns = np.repeat(closure.nearest_turns(at, middle), lengths)
    return np.split(closure.moved(points, turns), first[1:])


def _middle(what: Shown) -> Array:
    """The middle (kappa, v) of what a panel shows, mm."""
    return 0.5 * np.array([what.window[0] + what.window[2], what.window[1] + what.window[3]])


def _onto(points: Array, what: Shown) -> Array:
    """Points whole turns away, inside of what a panel shows."""
    left, _, right, _ = what.window
    slack = 1e-3 * (right - left)
    if np.nanmin(points[:, 0]) >= left - slack and np.nanmax(points[:, 0]) <= right + slack:
        return points
    return _beside(points, _middle(what), what.layer.region.closure)


def _draw_arrows(canvas: Canvas, lines: list[Array]) -> None:
    """Heads along lines in pixels, evenly spaced, where there is room for them."""
    tips, ways = [], []
    for line in lines:
        along = lengths_along(line)
        count = max(1, math.floor(along[-1] / ARROWS)) if along[-1] > ARROWED else 0
        at = (np.arange(count) + 0.5) / max(count, 1) * along[-1] + 4.0
        k = np.clip(np.searchsorted(along, at, side="right") - 1, 0, len(line) - 2)
        step = line[k + 1] - line[k]
        way = step / np.maximum(np.hypot(*step.T), 1e-9)[:, None]
        tips.append(line[k] + (at - along[k])[:, None] * way)
        ways.append(way)
    if tips:
        canvas.arrows(np.concatenate(tips), np.concatenate(ways), rgb(DEPOSIT))


__all__ = ["Frame", "Shown", "draw_overview", "draw_panel", "framed", "groups_of_equals", "representative", "whole"]
