"""layers.png and toolpath.png: the unrolled layers with their beads, and the toolpath in space.

In: a Plan. Out: pictures. Deposition is red and repositioning blue, as in the paper's Fig. 10.
"""

from __future__ import annotations

import itertools
import json
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from brep_slicer.fill import LayerFill
from brep_slicer.maps import Array
from brep_slicer.region import Layer
from brep_slicer.toolpath import Toolpath

from ..atomic import write_whole
from ..report import header_of_plan

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from brep_slicer.planning import Plan

DEPOSIT, TRAVEL, METAL, OUTLINE = "#c8102e", "#1f5fbf", "#e9e4da", "#3c3c3c"
# A page of layers shows at most this many; more are sampled evenly, first and last among them.
MOST_PANELS = 12

# Moves longer than this share of a turn would only cross the picture, and go the other way round as often as not.
SHOWN_MOVES = 0.25


def draw_layers(plan: Plan, path: str | Path) -> Path:
    """The unrolled layers, one panel each."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    pairs = [(la, f) for la, f in zip(plan.layers, plan.fills, strict=True) if isinstance(la, Layer) and not la.region.is_empty]
    chosen = [pairs[i] for i in _spread(len(pairs), MOST_PANELS)]
    columns, width, height = _page([layer for layer, _ in chosen])
    rows = math.ceil(len(chosen) / columns)
    figure = Figure(figsize=(width * columns, height * rows + 0.6), dpi=110, layout="constrained")
    FigureCanvasAgg(figure)
    for k, (layer, fill) in enumerate(chosen):
        draw_layer(figure.add_subplot(rows, columns, k + 1), layer, fill)
    shown = "" if len(chosen) == len(plan.layers) else f" ({len(chosen)} of {len(plan.layers)} shown)"
    title = f"{Path(plan.part.source).name}: unrolled layers{shown} · deposition red, repositioning within a quarter turn blue"
    figure.suptitle(title, fontsize=11)
    return write_whole(path, lambda temporary: figure.savefig(temporary, metadata=_metadata(plan)))


def draw_layer(axes: Axes, layer: Layer, fill: LayerFill) -> None:
    """One unrolled layer with its beads on given axes: kappa across, v up, mm, equal scales."""
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
    axes.set_aspect("equal")
    axes.autoscale_view()
    axes.set_title(f"layer {layer.index} · R {layer.radius:.6g} mm · {layer.area:.5g} mm²", fontsize=8)
    axes.set_xlabel("κ = Rθ, mm", fontsize=7)
    axes.set_ylabel("v, mm", fontsize=7)
    axes.tick_params(labelsize=6)


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


def _metadata(plan: Plan) -> dict[str, str]:
    """Text that a PNG carries along: version, part, parameters."""
    return {"Software": "brep_slicer", "Description": json.dumps(header_of_plan(plan))}


def _spread(count: int, most: int) -> list[int]:
    if count <= most:
        return list(range(count))
    return sorted({round(i * (count - 1) / (most - 1)) for i in range(most)})


def _page(layers: list[Layer]) -> tuple[int, float, float]:
    """Columns, and the size of a panel in inches, from the widest and highest layer."""
    boxes = np.array([piece.bounds() for layer in layers for piece in layer.region.pieces])
    wide = max(boxes[:, 2].max() - boxes[:, 0].min(), 1e-6)
    if any(_is_band(layer) for layer in layers):
        wide = max(layer.region.period for layer in layers)
    ratio = (boxes[:, 3].max() - boxes[:, 1].min()) / wide
    columns = 1 if ratio < 0.25 else 2 if ratio < 0.6 else 3 if ratio < 1.0 else 4
    columns = min(columns, len(layers))
    width = 11.0 / columns
    return columns, width, min(max(width * ratio + 0.7, 1.6), 8.0)


def draw_toolpath(plan: Plan, path: str | Path) -> Path:
    """The toolpath in space, on the part of the substrate that it covers."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from mpl_toolkits.mplot3d.art3d import Line3DCollection

    figure = Figure(figsize=(10, 8), dpi=110)
    FigureCanvasAgg(figure)
    axes: Any = figure.add_axes((0.02, 0.02, 0.94, 0.9), projection="3d", computed_zorder=False)
    toolpath = plan.toolpath
    shaft = _substrate_patch(plan)
    axes.plot_surface(
        *np.moveaxis(shaft, -1, 0), color=METAL, edgecolor=OUTLINE, linewidth=0.15, alpha=0.9, rstride=1, cstride=1
    )
    view = _viewpoint(plan)
    laid, moved = _segments(toolpath, view)
    for segments, color, width in ((moved, TRAVEL, 0.35), (laid, DEPOSIT, 0.7)):
        if len(segments):
            axes.add_collection3d(Line3DCollection(segments, colors=color, linewidths=width))
    everything = np.concatenate([toolpath.points, shaft.reshape(-1, 3)])
    low, high = everything.min(axis=0), everything.max(axis=0)
    for setter, a, b in zip((axes.set_xlim, axes.set_ylim, axes.set_zlim), low, high, strict=True):
        setter(a, b)
    axes.set_box_aspect(np.maximum(high - low, 1e-3 * (high - low).max()), zoom=0.92)
    for name, setter in zip("xyz", (axes.set_xlabel, axes.set_ylabel, axes.set_zlabel), strict=True):
        setter(f"{name}, mm", fontsize=8)
    axes.tick_params(labelsize=7)
    axes.view_init(elev=math.degrees(math.asin(view[2])), azim=math.degrees(math.atan2(view[1], view[0])))
    title = f"{Path(plan.part.source).name}: {len(plan.layers)} layers on R {plan.substrate.radius:.6g} mm"
    figure.suptitle(f"{title} · deposition red, repositioning blue", fontsize=12)
    return write_whole(path, lambda temporary: figure.savefig(temporary, metadata=_metadata(plan)))


def _segments(toolpath: Toolpath, view: Array) -> tuple[Array, Array]:
    """Deposited and travel segments that the shaft does not hide from someone who looks along -view, (n, 2, 3) each."""
    pairs = np.stack([toolpath.points[:-1], toolpath.points[1:]], axis=1)
    seen = toolpath.normals[1:] @ view > -0.05
    return pairs[seen & toolpath.deposits[1:]], pairs[seen & ~toolpath.deposits[1:]]


def _covered(plan: Plan) -> tuple[float, float]:
    """First and last angle (rad) of the arc that holds every deposited point: a turn less the widest gap."""
    path = plan.toolpath
    theta = np.sort(np.mod(path.kappa[path.deposits] / path.radius[path.deposits], 2.0 * np.pi))
    gaps = np.diff(np.append(theta, theta[0] + 2.0 * np.pi))
    widest = int(gaps.argmax())
    if gaps[widest] < 1.0:
        return 0.0, 2.0 * np.pi
    start = theta[(widest + 1) % len(theta)]
    return float(start), float(start + 2.0 * np.pi - gaps[widest])


def _substrate_patch(plan: Plan) -> Array:
    """Points (n, m, 3) of the substrate below the deposit and a little beyond it."""
    start, end = _covered(plan)
    v = plan.toolpath.v[plan.toolpath.deposits]
    margin = 0.15 * (v.max() - v.min()) + 1.0
    if end - start < 2.0 * np.pi - 1e-6:
        wide = margin / plan.substrate.radius + 0.1 * (end - start)
        start, end = start - wide, end + wide
    theta = np.linspace(start, end, max(3, math.ceil((end - start) / 0.06)))
    z = np.linspace(v.min() - margin, v.max() + margin, 9)
    angle, height = np.meshgrid(theta, z, indexing="ij")
    radius = plan.substrate.radius
    return plan.axis.file_from_axis(np.stack([radius * np.cos(angle), radius * np.sin(angle), height], axis=-1))


def _viewpoint(plan: Plan) -> Array:
    """Unit vector to where the picture is taken from: outside, a little to the side and above, (3,)."""
    start, end = _covered(plan)
    middle = 0.5 * (start + end)
    outwards = plan.axis.file_from_axis_vectors(np.array([math.cos(middle), math.sin(middle), 0.0]))
    view = outwards + 0.55 * plan.axis.direction + 0.45 * np.cross(plan.axis.direction, outwards)
    return view / np.linalg.norm(view)
