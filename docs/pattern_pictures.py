"""Draw docs/patterns.png, every pattern on one page: python docs/pattern_pictures.py (from the project's root)."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from PIL import Image

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
from brep_slicer.output.pictures.canvas import Canvas, write_words
from brep_slicer.output.pictures.page import DARK, PALE
from brep_slicer.output.pictures.panels import draw_panel, framed, representative
from brep_slicer.proof import coverage_of

HERE = Path(__file__).parent
D, W = 3.4, 4.9
Z = bs.axis_from_text("Z")
# The page and its rows, and the words on it: to be read where the page is shown 900 pixels wide.
WIDTH, HEAD, TALL, LOW, MARGIN, SIZE = 1500, 48, 430, 270, 18, 22
KEY = "w 4.9 mm, d 3.4 mm: beads red at their width, what is beige stays bare; overlaps darker"


def layer_of(name: str, radius: float):
    """One layer of a fixture."""
    (layer,) = bs.slice_part(bs.read_step(f"fixtures/step/{name}.step"), [radius], axis=Z)
    return layer


def main() -> None:
    """Patterns on a tooth, blades and a full turn with a keyway, with the share that they leave bare."""
    tooth, blade, band = layer_of("helical_gear_tooth", 165.0), layer_of("propeller", 80.0), layer_of("keyed_band", 50.0)
    overlap = 2.0 * D - W
    slanted = Hatch(angle_deg=math.degrees(np.radians(30.0)))
    pieces = [
        ("hatch, both ways", tooth, slanted),
        ("zigzag", tooth, Zigzag(angle_deg=math.degrees(np.radians(30.0)))),
        ("along the flanks", tooth, FlankFollowing()),
        ("contour and hatch", tooth, PatternSequence(patterns=(Contours(count=1, skeleton=False), slanted), overlap=overlap)),
        ("contours", tooth, Contours(skeleton=False)),
        ("spiral", tooth, PatternSequence(patterns=(Spiral(skeleton=False), Skeleton()))),
        ("contours and skeleton", tooth, PatternSequence(patterns=(Contours(skeleton=False), Skeleton()))),
        ("hatch", blade, slanted),
        ("skeleton", blade, Skeleton()),
        ("contours", blade, Contours(skeleton=False)),
        ("contours and skeleton", blade, PatternSequence(patterns=(Contours(skeleton=False), Skeleton()))),
        ("from flank to flank", blade, FlankFollowing()),
    ]
    turns = [
        ("rings", Rings()),
        ("helix with closing beads", Helix(closing_rings=True)),
        ("three left-handed helices", Helix(starts=3, left_handed=True)),
        ("hatch round a full turn", Hatch(angle_deg=60.0)),
    ]
    page = Image.new("RGB", (WIDTH, HEAD + 3 * TALL + len(turns) * LOW), "white")
    words = [((MARGIN, 12), KEY, SIZE, DARK, "la")]
    for k, (name, layer, pattern) in enumerate(pieces):
        words += _panel(page, (k % 4 * WIDTH // 4, HEAD + k // 4 * TALL, WIDTH // 4, TALL), name, layer, pattern, 0.0)
    for k, (name, pattern) in enumerate(turns):
        words += _panel(page, (0, HEAD + 3 * TALL + k * LOW, WIDTH, LOW), name, band, pattern, 0.5 * W)
    write_words(page, words)
    page.save(HERE / "patterns.png", optimize=True)


def _panel(page: Image.Image, box: tuple[int, int, int, int], name: str, layer, pattern, inset: float) -> list:
    """One pattern on one layer; the words above it: beads, and what it leaves bare."""
    fill = fill_region(layer.region, pattern, step_over=D, width=W, inset=inset, chord=0.01)
    bare = 100.0 * coverage_of(layer.region, fill.beads, W).bare_share
    what = representative(layer, fill, width=W)
    left, top, width, height = box
    room = (float(MARGIN), 2.4 * SIZE, width - 2.0 * MARGIN, height - 2.4 * SIZE - MARGIN)
    wide, high = what.window[2] - what.window[0], what.window[3] - what.window[1]
    canvas = Canvas(width, height)
    scale = min(room[2] / wide, room[3] / high)
    draw_panel(canvas, what, framed(what.window, room, scale), width=W, large=True)
    page.paste(canvas.page(), (left, top))
    own = len(what.fill.beads)
    text = f"{own} {'bead' if own == 1 else 'beads'}, {bare:.2f} % bare"
    place = (left + MARGIN, top + 4)
    if width == WIDTH:
        return [(place, f"{name}: {text}", SIZE, DARK, "la")]
    return [(place, name, SIZE, DARK, "la"), ((place[0], place[1] + SIZE + 3), text, SIZE - 3, PALE, "la")]


if __name__ == "__main__":
    main()
