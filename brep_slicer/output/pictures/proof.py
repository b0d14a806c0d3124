"""proof.png: height maps of some layers, and the spacings of all.

In: a Plan and its proof. Out: a picture.
"""

from __future__ import annotations

import textwrap
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from brep_slicer.proof import deposit_of, spacings_in_words
from brep_slicer.proof.deposit import CELLS_PER_WIDTH
from brep_slicer.region import Layer, Piece

from ..atomic import write_whole

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from brep_slicer.planning import Plan

# Height maps shown, of layers spread evenly.
MOST_MAPS = 3
# Maps so many times as wide as high are shown one below the other.
WIDE = 3.0
# Pieces are as large as each other within this share.
ALIKE = 1e-3
# Cells along the longer side of a height map.
MOST_CELLS = 900


def draw_proof(plan: Plan, proof: list[dict[str, Any]], path: str | Path) -> Path:
    """Simulated heights over t of up to three layers, and the histogram of the spacings measured on all."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    pairs = [(la, f) for la, f in zip(plan.layers, plan.fills, strict=True) if f.beads]
    chosen = [pairs[int(i)] for i in np.unique(np.linspace(0, len(pairs) - 1, MOST_MAPS).round())] if pairs else []
    boxes = [_window(layer) for layer, _ in chosen]
    figure, maps, last = _page(boxes, histogram=_bars(proof) > 1)
    figure.suptitle(f"{Path(plan.part.source).name}: how even the metal is", fontsize=12, weight="bold")
    FigureCanvasAgg(figure)
    image = None
    for ax, (layer, fill), (k0, v0, k1, v1) in zip(maps, chosen, boxes, strict=True):
        t = layer.thickness or 1.0
        # no finer than the page shows, and no more than it shows
        cell = max(plan.process.width / CELLS_PER_WIDTH, max(k1 - k0, v1 - v0) / MOST_CELLS)
        made = deposit_of(
            layer.region,
            fill.beads,
            width=plan.process.width,
            thickness=t,
            step_over=plan.process.step_over,
            window=(k0 - 2.0, v0 - 2.0, k1 + 2.0, v1 + 2.0),
            cell=cell,
        )
        # the picture ends at the cells' edges, not at their middles
        half = 0.5 * cell
        extent = (made.kappa[0] - half, made.kappa[-1] + half, made.v[0] - half, made.v[-1] + half)
        image = ax.imshow(made.heights / t, origin="lower", extent=extent, cmap="RdBu_r", vmin=0.0, vmax=2.0, aspect="equal")
        ax.set_xlim(k0 - 2.0, k1 + 2.0)
        ax.set_ylim(v0 - 2.0, v1 + 2.0)
        ax.locator_params(axis="x", nbins=4)
        count = len(layer.region.pieces)
        one_of = f" (1 of {count} pieces shown)" if count > 1 else ""
        row = next(r for r in proof if r["layer"] == layer.index)
        mean, bare, duty = row["mean_height_over_t"], 100.0 * row["bare_share"], 100.0 * (row["duty"] or 0.0)
        title = f"layer {layer.index}: height / t, mean {mean:.3f}, peak {row['peak_height_over_t']:.2f}{one_of}"
        ax.set_title(f"{title}\nbare {bare:.2f} %, duty {duty:.0f} %, {row['starts']} starts", fontsize=9)
        ax.set_xlabel("κ, mm")
        ax.set_ylabel("v, mm")
    if image is not None:
        figure.colorbar(image, ax=maps, shrink=0.7, label="simulated height / t")
    if last is not None:
        _histogram(last, proof, plan.process.step_over)
    return write_whole(path, lambda temporary: figure.savefig(temporary))


def _bars(proof: list[dict[str, Any]]) -> int:
    """How many bars the histogram of the spacings has: a single one says no more than the summary does."""
    counts = [row["step_over_measured_mm"]["histogram"]["counts"] for row in proof]
    return int(np.count_nonzero(np.sum(counts, axis=0))) if counts else 0


def _page(boxes: list[tuple[float, float, float, float]], *, histogram: bool) -> tuple[Figure, list[Any], Any]:
    """A figure, its maps' axes and those of its histogram, if any: wide maps one below the other, others side by side."""
    from matplotlib.figure import Figure

    count = len(boxes)
    last = ["last"] if histogram or not count else []
    ratio = max(((k1 - k0) / max(v1 - v0, 1e-9) for k0, v0, k1, v1 in boxes), default=1.0)
    if count and ratio > WIDE:
        figure = Figure(figsize=(13.0, max(1.4 + 8.5 / ratio, 1.6) * count + 0.7), dpi=110, layout="constrained")
        axes = figure.subplot_mosaic([[str(i), *last] for i in range(count)], width_ratios=[3.0, 1.0][: 1 + len(last)])
    else:
        figure = Figure(figsize=(4.2 * (count + len(last)), 4.9), dpi=110, layout="constrained")
        axes = figure.subplot_mosaic([[*map(str, range(count)), *last]])
    return figure, [axes[str(i)] for i in range(count)], axes.get("last")


def _window(layer: Layer) -> tuple[float, float, float, float]:
    """What is shown of a layer, (kappa_min, v_min, kappa_max, v_max): its largest piece; of a full band one turn."""
    piece = _shown_piece(layer)
    k0, v0, k1, v1 = piece.bounds()
    if not piece.winds:
        return k0, v0, k1, v1
    turn = layer.region.closure.window(-0.5, 0.5, v0, v1).bounds
    return turn[0], turn[1], turn[2], turn[3]


def _shown_piece(layer: Layer) -> Piece:
    """The largest piece, and of several as large the one nearest to kappa = 0: the same from layer to layer."""
    pieces = layer.region.pieces
    largest = max(piece.area() for piece in pieces)
    return min(
        (piece for piece in pieces if piece.area() > (1.0 - ALIKE) * largest),
        key=lambda piece: abs(piece.bounds()[0] + piece.bounds()[2]),
    )


def _histogram(ax: Any, proof: list[dict[str, Any]], step_over: float) -> None:
    measured = [row["step_over_measured_mm"] for row in proof]
    counts = np.sum([m["histogram"]["counts"] for m in measured], axis=0) if measured else np.zeros(1)
    edges = np.array(measured[0]["histogram"]["edges_mm"]) if measured else np.array([0.5, 1.5]) * step_over
    ax.stairs(counts, edges, fill=True, color="0.5")
    ax.axvline(step_over, color="#c8102e", lw=1)
    words = textwrap.fill(spacings_in_words(proof), 44)
    ax.set_title(f"spacing of neighbouring beads\n{words}", fontsize=8)
    ax.set_xlim(edges[0], edges[-1])
    beyond = sum(m["spacings"] for m in measured) - int(counts.sum())
    ax.set_xlabel(f"mm ({beyond} places lie beyond these bounds)" if beyond else "mm")
    ax.set_ylabel("places")
