"""Draw the pictures of the README: python docs/pictures.py (from the project's root)."""

from __future__ import annotations

from pathlib import Path

from PIL import Image

import brep_slicer as bs
from brep_slicer.output.pictures import draw_layers, draw_toolpath

HERE = Path(__file__).parent


def main() -> None:
    """The toolpath of the helical tooth beside two of its unrolled layers."""
    part = bs.read_step("fixtures/step/helical_gear_tooth.step")
    process = bs.Process(layer_thickness=1.4, step_over=3.4, contours=1, hatch_angles_deg=(75.0, 15.0))
    whole, two = bs.plan(part, process), bs.plan(part, process, layers=(7, 9))
    space = Image.open(draw_toolpath(whole, HERE / "toolpath.png"))
    flat = Image.open(draw_layers(two, HERE / "layers.png"))
    height = 640
    shown = [im.convert("RGB").resize((round(im.width * height / im.height), height)) for im in (space, flat)]
    page = Image.new("RGB", (sum(im.width for im in shown), height), "white")
    page.paste(shown[0], (0, 0))
    page.paste(shown[1], (shown[0].width, 0))
    page.save(HERE / "helical_tooth.png")
    for name in ("toolpath.png", "layers.png"):
        (HERE / name).unlink()


if __name__ == "__main__":
    main()
