"""One unrolled layer on given matplotlib axes, for notebooks and papers.

In: axes, a layer, its beads. Out: nothing; the axes are drawn on.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from brep_slicer.fill import LayerFill
from brep_slicer.layers import NO_CLOSURE
from brep_slicer.region import Layer

from .page import DEPOSIT, METAL, OUTLINE, TRAVEL
from .unrolled import CHORD, is_band, metal_of, moves_of, shown, strips_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def draw_layer(axes: Axes, layer: Layer, fill: LayerFill, *, width: float | None = None) -> None:
    """One unrolled layer with its beads on given axes: kappa across, v up, mm, equal scales.

    With their `width` (mm) the beads are drawn as broad as they are, with a dot where each starts.
    """
    from matplotlib.collections import LineCollection, PathCollection
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path

    for polygon in metal_of(layer):
        rings = [np.asarray(ring.coords) for ring in (polygon.exterior, *polygon.interiors)]
        outline = Path.make_compound_path(*[Path(ring, closed=True) for ring in rings])
        axes.add_patch(PathPatch(outline, facecolor=METAL, edgecolor="none", zorder=0))
    for loop in layer.region.loops:
        axes.plot(*shown(loop.sample(CHORD), layer).T, color=OUTLINE, linewidth=0.8, zorder=3)
    lines = [shown(bead.points, layer) for bead in fill.beads]
    axes.add_collection(LineCollection(lines, colors=DEPOSIT, linewidths=0.9, zorder=2))
    axes.add_collection(LineCollection(moves_of(layer, fill), colors=TRAVEL, linewidths=0.6, linestyles=(0, (3, 2)), zorder=1))
    if width is not None:
        turn = layer.region.closure if is_band(layer) else NO_CLOSURE
        strips = [Path.make_compound_path(*map(Path, rings)) for rings in strips_of(lines, width, within=turn)]
        broad = PathCollection(strips, facecolors=DEPOSIT, edgecolors=DEPOSIT, linewidths=0.3, alpha=0.22, zorder=1.5)
        axes.add_collection(broad)
        if lines:
            starts = np.array([line[0] for line in lines])
            axes.scatter(starts[:, 0], starts[:, 1], s=7.0, color=DEPOSIT, linewidths=0.0, zorder=4)
    axes.set_aspect("equal")
    axes.autoscale_view()
    axes.set_title(f"layer {layer.index} · R {layer.radius:.6g} mm · {layer.area:.5g} mm²", fontsize=8)
    axes.set_xlabel("κ = Rθ, mm", fontsize=7)
    axes.set_ylabel("v, mm", fontsize=7)
    axes.tick_params(labelsize=6)


__all__ = ["draw_layer"]
