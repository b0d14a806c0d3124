"""layers.png: the unrolled layers with their beads at their width.

In: a Plan. Out: a picture. Deposition is red and repositioning blue, as in the paper's Fig. 10.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from brep_slicer.fill import LayerFill
from brep_slicer.maps import Array
from brep_slicer.region import Layer

from .page import DEPOSIT, METAL, OUTLINE, TRAVEL, new_page, saved

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from brep_slicer.planning import Plan

# A page of layers shows at most this many; more are sampled evenly, first and last among them.
MOST_PANELS = 8

# Moves longer than this share of a turn would only cross the picture, and go the other way round as often as not.
SHOWN_MOVES = 0.25
# Pieces are as large as each other within this share.
ALIKE = 1e-3


def draw_layers(plan: Plan, path: str | Path) -> Path:
    """The unrolled layers, one panel each."""
    pairs = [(la, f) for la, f in zip(plan.layers, plan.fills, strict=True) if isinstance(la, Layer) and not la.region.is_empty]
    chosen = [pairs[i] for i in _spread(len(pairs), MOST_PANELS)]
    columns, width, height = _page([layer for layer, _ in chosen])
    rows = math.ceil(len(chosen) / columns)
    high = height * rows + 0.6
    figure = new_page(width * columns, high)
    for k, (layer, fill) in enumerate(chosen):
        # room for the labels of every panel, in inches
        left, low = (k % columns) * width + 0.6, high - 0.4 - (k // columns + 1) * height + 0.45
        box = (left / (width * columns), low / high, (width - 0.75) / (width * columns), (height - 0.95) / high)
        axes = figure.add_axes(box)
        draw_layer(axes, *_one_of_equals(layer, fill), width=plan.process.width)
        count = len(layer.region.pieces)
        equal = f"{count} pieces" if count > 1 else ""
        equal = f"1 of {count} equal pieces" if count > 1 and _equal_pieces([layer]) else equal
        axes.set_title(
            f"layer {layer.index} · R {layer.radius:.6g} mm\n{layer.area:.5g} mm² · {equal}".rstrip(" ·"), fontsize=8
        )
    shown = "" if len(chosen) == len(plan.layers) else f" ({len(chosen)} of {len(plan.layers)} shown)"
    title = f"{Path(plan.part.source).name}: unrolled layers{shown} · beads red, a dot at their starts; repositioning blue"
    figure.suptitle(title, fontsize=11)
    return saved(figure, plan, path)


def draw_layer(axes: Axes, layer: Layer, fill: LayerFill, *, width: float | None = None) -> None:
    """One unrolled layer with its beads on given axes: kappa across, v up, mm, equal scales.

    With their `width` (mm) the beads are drawn as broad as they are, with a dot where each starts.
    """
    from matplotlib.collections import LineCollection
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path as Outline

    for polygon in _metal(layer):
        rings = [np.asarray(ring.coords) for ring in (polygon.exterior, *polygon.interiors)]
        outline = Outline.make_compound_path(*[Outline(ring, closed=True) for ring in rings])
        axes.add_patch(PathPatch(outline, facecolor=METAL, edgecolor="none", zorder=0))
    for loop in layer.region.loops:
        axes.plot(*_shown(loop.sample(0.02), layer).T, color=OUTLINE, linewidth=0.8, zorder=3)
    lines = [_shown(bead.points, layer) for bead in fill.beads]
    axes.add_collection(LineCollection(lines, colors=DEPOSIT, linewidths=0.9, zorder=2))
    moves = [
        _shown(np.array([a.points[-1], b.points[0]]), layer)
        for a, b in zip(fill.beads, fill.beads[1:], strict=False)
        if np.hypot(*(b.points[0] - a.points[-1])) < SHOWN_MOVES * layer.region.period
    ]
    axes.add_collection(LineCollection(moves, colors=TRAVEL, linewidths=0.6, linestyles=(0, (3, 2)), zorder=1))
    if width is not None:
        _draw_widths(axes, lines, width)
    axes.set_aspect("equal")
    axes.autoscale_view()
    axes.set_title(f"layer {layer.index} · R {layer.radius:.6g} mm · {layer.area:.5g} mm²", fontsize=8)
    axes.set_xlabel("κ = Rθ, mm", fontsize=7)
    axes.set_ylabel("v, mm", fontsize=7)
    axes.tick_params(labelsize=6)


def _draw_widths(axes: Axes, lines: list[Array], width: float) -> None:
    """Beads as broad as they are, and their starts."""
    import shapely
    from matplotlib.collections import PolyCollection

    parts = [part for line in lines for part in np.split(line, np.flatnonzero(np.isnan(line[:, 0]))) if len(part) > 1]
    parts = [part[~np.isnan(part[:, 0])] for part in parts]
    strips = shapely.buffer([shapely.LineString(part) for part in parts if len(part) > 1], 0.5 * width, quad_segs=6)
    shells = [np.asarray(strip.exterior.coords) for strip in strips]
    axes.add_collection(PolyCollection(shells, facecolors=DEPOSIT, edgecolors=DEPOSIT, linewidths=0.3, alpha=0.22, zorder=1.5))
    if lines:
        starts = np.array([line[0] for line in lines])
        axes.scatter(starts[:, 0], starts[:, 1], s=7.0, color=DEPOSIT, linewidths=0.0, zorder=4)


def _one_of_equals(layer: Layer, fill: LayerFill) -> tuple[Layer, LayerFill]:
    """Of equal pieces the one nearest to kappa = 0 with its beads, large enough to be seen; any other layer as it is."""
    if len(layer.region.pieces) < 2 or not _equal_pieces([layer]):
        return layer, fill
    pieces = layer.region.pieces
    chosen = min(range(len(pieces)), key=lambda i: abs(sum(pieces[i].bounds()[::2])))
    region = replace(layer.region, pieces=(pieces[chosen],))
    return replace(layer, region=region), replace(fill, beads=tuple(bead for bead in fill.beads if bead.piece == chosen))


def _shown(points: Array, layer: Layer) -> Array:
    """Points of a full band drawn in the chart of -half a turn to +half a turn; a line that crosses the seam is broken."""
    if not _is_band(layer):
        return points
    period = layer.region.period
    turns = np.floor(points[:, 0] / period + 0.5)
    if turns.min() == turns.max():
        return points - np.array([turns[0] * period, 0.0])
    return _broken(points, period)


def _is_band(layer: Layer) -> bool:
    return any(piece.winds for piece in layer.region.pieces)


def _metal(layer: Layer) -> list[Any]:
    """The region's polygons, in the chart of one turn where `_shown` draws its outline in it."""
    import shapely
    from shapely.affinity import translate

    polygons = list(layer.region.to_shapely(chord=0.02).geoms)
    if not _is_band(layer):
        return polygons
    period, out = layer.region.period, []
    for polygon in polygons:
        low, bottom, high, top = polygon.bounds
        window = shapely.box(-0.5 * period, bottom - 1.0, 0.5 * period, top + 1.0)
        for turn in range(math.floor(low / period + 0.5), math.ceil(high / period - 0.5) + 1):
            # a ring that a sample's error makes cross itself cannot be cut
            moved = shapely.make_valid(translate(polygon, -turn * period)).intersection(window)
            out += [part for part in shapely.get_parts(moved) if part.geom_type == "Polygon" and part.area > 0.0]
    return out


def _broken(points: Array, period: float) -> Array:
    """The chain cut at every seam it crosses, also in one of its points, with NaN between the parts."""
    out: list[Array] = []
    last = None
    for a, b in itertools.pairwise(points):
        low, high = sorted((a[0], b[0]))
        seams = np.arange(np.floor(low / period + 0.5), np.ceil(high / period - 0.5) + 1) * period + 0.5 * period
        seams = seams[(seams > low) & (seams < high)]
        share = np.sort((seams - a[0]) / (b[0] - a[0])) if len(seams) else np.zeros(0)
        knots = np.concatenate([[0.0], share, [1.0]])
        for s0, s1 in itertools.pairwise(knots):
            ends = np.array([a + s * (b - a) for s in (s0, s1)])
            turn = np.floor((0.5 * (ends[0, 0] + ends[1, 0])) / period + 0.5)
            if turn != last:
                out += [np.full((1, 2), np.nan)] if out else []
                out.append(ends[:1] - [turn * period, 0.0])
            out.append(ends[1:] - [turn * period, 0.0])
            last = turn
    return np.concatenate(out)


def _spread(count: int, most: int) -> list[int]:
    if count <= most:
        return list(range(count))
    return sorted({round(i * (count - 1) / (most - 1)) for i in range(most)})


def _page(layers: list[Layer]) -> tuple[int, float, float]:
    """Columns, and the size of a panel in inches, from the widest and highest layer."""
    boxes = np.array([piece.bounds() for layer in layers for piece in layer.region.pieces])
    wide = max((boxes[:, 2] - boxes[:, 0]).max() if _equal_pieces(layers) else np.ptp(boxes[:, ::2]), 1e-6)
    if any(_is_band(layer) for layer in layers):
        wide = max(layer.region.period for layer in layers)
    ratio = (boxes[:, 3].max() - boxes[:, 1].min()) / wide
    columns = 1 if ratio < 0.25 else 2 if ratio < 0.6 else 3 if ratio < 1.0 else 4
    columns = min(columns, len(layers))
    width = 11.0 / columns
    return columns, width, min(max((width - 0.75) * ratio + 1.0, 1.8), 4.6)


def _equal_pieces(layers: list[Layer]) -> bool:
    """Whether every layer is shown by one of its pieces."""
    for layer in layers:
        areas = [piece.area() for piece in layer.region.pieces]
        if _is_band(layer) or min(areas) <= (1.0 - ALIKE) * max(areas):
            return False
    return True
