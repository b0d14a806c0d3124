"""Draw the picture at the head of the README: python docs/pictures.py (from the project's root)."""

from __future__ import annotations

import math
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
from PIL import Image

import brep_slicer as bs
from brep_slicer.output.pictures.canvas import Canvas, write_words
from brep_slicer.output.pictures.page import DARK, PALE
from brep_slicer.output.pictures.panels import draw_panel, framed, whole
from brep_slicer.output.pictures.scene import Mesh, joined, part_mesh
from brep_slicer.output.pictures.toolpath import rendered
from brep_slicer.output.pictures.views import View
from brep_slicer.toolpath import Toolpath

HERE = Path(__file__).parent
LAYER = 9
# The picture in space and the one in the plane, pixels; drawn so many times finer and made smaller, so that edges are smooth.
SPACE, FLAT, FINE = (620, 760), 640, 2
# What is seen of the part, mm: to the right and up from the middle of the bead that is being laid.
WIDE, HIGH = 84.0, 68.5
# A powder nozzle of the usual kind: its stand-off, the cone's length and radii at tip and top, the barrel above; mm, colour.
STAND_OFF, CONE, TIP, TOP, BARREL, STEEL = 11.0, 17.0, 2.8, 8.0, 5.0, np.array([0.42, 0.46, 0.52])
BEAM = np.array([1.0, 0.72, 0.2])


def main() -> None:
    """The tooth up to a layer, that layer half laid under a nozzle; beside it the whole layer unrolled."""
    part = bs.read_step("fixtures/step/helical_gear_tooth.step")
    process = bs.Process(
        layer_thickness=1.4, step_over=3.4, fill=bs.Fill(contours=1, pattern=bs.Automatic(angle_deg=(75.0, 15.0)))
    )
    plan = bs.plan(part, process, layers=(LAYER, LAYER + 1))
    count = len(bs.plan(part, process).layers)
    half = replace(plan, toolpath=_until(plan.toolpath, 0.62))
    page = Image.new("RGB", (SPACE[1] + FLAT, SPACE[0]), "white")
    page.paste(Image.fromarray(_space(half)).reduce(FINE), (0, 0))
    page.paste(_flat(plan), (SPACE[1], 0))
    layer = plan.layers[0]
    text = f"layer {layer.index} of {count} on R {layer.radius:.6g} mm"
    write_words(page, [((14, 10), text, 24, DARK, "la"), ((SPACE[1] + 14, 10), "the same layer, unrolled", 24, DARK, "la")])
    page.save(HERE / "helical_tooth.png", optimize=True)


def _until(path: Toolpath, share: float) -> Toolpath:
    """A toolpath up to the bead that is being laid when a share of its points is done, and half of that bead."""
    run = path.runs()
    mine = np.flatnonzero((run == run[int(share * len(path))]) & path.deposits)
    end = mine[len(mine) // 2] + 1
    return Toolpath(**{field.name: getattr(path, field.name)[:end] for field in fields(path)})


def _space(plan: bs.Plan) -> np.ndarray:
    tip, normal = plan.toolpath.points[-1], plan.toolpath.normals[-1]
    mesh = joined([part_mesh(plan, 0.05), _nozzle(tip, normal)])
    along = plan.axis.direction
    round_about = np.cross(along, normal)
    # from the side that the tooth leans to, and from above
    towards = 0.62 * normal + 0.5 * along - 0.60 * round_about
    towards /= np.linalg.norm(towards)
    right = np.cross(normal, towards)
    right /= np.linalg.norm(right)
    view = View(right=right, up=np.cross(towards, right), towards=towards, box=(0.0, 0.0, 1.0, 1.0))
    x, y = view.flat(tip[None] + 4.0 * normal)[0]
    view = replace(view, box=(x - 0.5 * WIDE, y - 0.5 * HIGH, x + 0.5 * WIDE, y + 0.5 * HIGH))
    return rendered(plan, mesh, view, (FINE * SPACE[0], FINE * SPACE[1]))


def _nozzle(tip: np.ndarray, normal: np.ndarray) -> Mesh:
    """Beam, cone and barrel over the place where the bead is laid."""
    heights = [0.8, STAND_OFF, STAND_OFF, STAND_OFF + CONE, STAND_OFF + CONE + BARREL]
    beam = _turned(tip, normal, heights[:2], [0.5, 1.1], BEAM)
    head = _turned(tip, normal, [heights[2], *heights[2:], heights[-1]], [0.01, TIP, TOP, TOP, 0.01], STEEL)
    return joined([beam, head])


def _turned(tip: np.ndarray, normal: np.ndarray, heights: list[float], radii: list[float], color: np.ndarray) -> Mesh:
    """A skin of revolution about a normal, from rings at heights over a place (mm)."""
    count = 48
    side = np.cross(normal, [0.0, 0.0, 1.0])
    side /= np.linalg.norm(side)
    other = np.cross(normal, side)
    parts = []
    for low, high, r0, r1 in zip(heights, heights[1:], radii, radii[1:], strict=False):
        angle = 2.0 * math.pi * np.arange(count) / count
        out = np.cos(angle)[:, None] * side + np.sin(angle)[:, None] * other
        rings = [tip + h * normal + r * out for h, r in ((low, r0), (high, r1))]
        slope = np.array([high - low, r0 - r1]) / math.hypot(high - low, r1 - r0)
        facing = slope[0] * out + slope[1] * normal
        k, following = np.arange(count), (np.arange(count) + 1) % count
        triangles = np.concatenate(
            [np.stack([k, following, k + count], axis=1), np.stack([following, following + count, k + count], axis=1)]
        )
        points, normals = np.concatenate(rings), np.concatenate([facing, facing])
        a, b, c = (points[triangles[:, i]] for i in range(3))
        inwards = (np.cross(b - a, c - a) * normals[triangles[:, 0]]).sum(axis=1) < 0.0
        triangles[inwards] = triangles[inwards][:, ::-1]
        colors = np.broadcast_to(color, (len(triangles), 3))
        parts.append(
            Mesh(points=points, normals=normals, triangles=triangles, colors=colors, edges=np.zeros((0, 2), dtype=int))
        )
    return joined(parts)


def _flat(plan: bs.Plan) -> Image.Image:
    what = whole(plan.layers[0], plan.fills[0], width=plan.process.width)
    left, low, right, top = what.window
    box = (14.0, 50.0, FLAT - 28.0, SPACE[0] - 104.0)
    scale = min(box[2] / (right - left), box[3] / (top - low))
    canvas = Canvas(FLAT, SPACE[0])
    draw_panel(canvas, what, framed(what.window, box, scale), width=plan.process.width, large=True)
    page = canvas.page()
    words = "beads at their width, overlaps darker · dots: starts · dashes: laser off"
    write_words(page, [((14, SPACE[0] - 40), words, 17, PALE, "la")])
    return page


if __name__ == "__main__":
    main()
