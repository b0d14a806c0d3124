"""Draw docs/patterns.png, every pattern on one page: python docs/pattern_pictures.py (from the project's root)."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import brep_slicer as bs
from brep_slicer.fill import (
    Contours,
    FlankFollowing,
    Hatch,
    Helix,
    PatternSequence,
    Rings,
    Skeleton,
    Spiral,
    Zigzag,
    fill_region,
)
from brep_slicer.output.pictures import draw_layer
from brep_slicer.proof import coverage_of

HERE = Path(__file__).parent
D, W = 3.4, 4.9
Z = bs.axis_from_text("Z")


def layer_of(name: str, radius: float):
    """One layer of a fixture."""
    (layer,) = bs.slice_part(bs.read_step(f"fixtures/step/{name}.step"), [radius], axis=Z)
    return layer


def main() -> None:
    """Patterns on a tooth, blades and a full turn with a keyway, with the share that they leave bare."""
    tooth, blade, band = layer_of("helical_gear_tooth", 165.0), layer_of("propeller", 80.0), layer_of("keyed_band", 50.0)
    overlap = 2.0 * D - W
    slanted = Hatch(angle=np.radians(30.0))
    pieces = [
        ("hatch, both ways", tooth, slanted),
        ("zigzag", tooth, Zigzag(angle=np.radians(30.0))),
        ("along the flanks", tooth, FlankFollowing()),
        ("contour and hatch", tooth, PatternSequence(patterns=(Contours(count=1), slanted), overlap=overlap)),
        ("contours", tooth, Contours(count=None)),
        ("spiral", tooth, PatternSequence(patterns=(Spiral(), Skeleton()))),
        ("contours and skeleton", tooth, PatternSequence(patterns=(Contours(count=None), Skeleton()))),
        ("hatch", blade, slanted),
        ("skeleton", blade, Skeleton()),
        ("contours", blade, Contours(count=None)),
        ("contours and skeleton", blade, PatternSequence(patterns=(Contours(count=None), Skeleton()))),
        ("from flank to flank", blade, FlankFollowing()),
    ]
    turns = [
        ("rings", Rings()),
        ("helix with closing beads", Helix(closing_rings=True)),
        ("three left-handed helices", Helix(starts=3, left_handed=True)),
        ("hatch round a full turn", Hatch(angle=np.radians(60.0))),
    ]
    figure = Figure(figsize=(15, 20), layout="constrained")
    grid = figure.add_gridspec(7, 4, height_ratios=[1.0, 1.0, 1.0, 0.55, 0.55, 0.55, 0.55])
    for k, (name, layer, pattern) in enumerate(pieces):
        ax = figure.add_subplot(grid[k // 4, k % 4])
        _panel(ax, name, layer, pattern, 0.0)
        if layer is blade:
            k0, v0, k1, v1 = layer.region.pieces[0].bounds()
            ax.set_xlim(k0 - 2.0, k1 + 2.0)
            ax.set_ylim(v0 - 2.0, v1 + 2.0)
    for k, (name, pattern) in enumerate(turns):
        _panel(figure.add_subplot(grid[3 + k, :]), name, band, pattern, 0.5 * W)
    figure.savefig(HERE / "patterns.png", dpi=80)


def _panel(ax, name: str, layer, pattern, inset: float) -> None:
    """One pattern on one layer, titled with its beads and what it leaves bare."""
    fill = fill_region(layer.region, pattern, step_over=D, width=W, inset=inset, chord=0.01)
    draw_layer(ax, layer, fill)
    bare = 100.0 * coverage_of(layer.region, fill.beads, W).bare_share
    ax.set_title(f"{name}: {len(fill.beads)} beads, {bare:.2f} % bare", fontsize=10)


if __name__ == "__main__":
    main()
