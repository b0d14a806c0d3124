"""layers.png: which pieces are equal, what a page shows of them, and that it is drawn without a plotting library."""

from __future__ import annotations

import json
import math
import subprocess
import sys

import numpy as np
import pytest
from PIL import Image

import brep_slicer as bs
from brep_slicer.curves import LineCurve, Loop
from brep_slicer.fill import Bead, BeadKind, LayerFill
from brep_slicer.layers import cylinder
from brep_slicer.output.pictures import draw_layers
from brep_slicer.output.pictures.canvas import WIDER, Canvas, rgb
from brep_slicer.output.pictures.layers import round_length
from brep_slicer.output.pictures.panels import groups_of_equals, representative, whole
from brep_slicer.output.pictures.unrolled import shown, strips_of
from brep_slicer.region import Layer, region_from_loops
from brep_slicer.section import Certificate, Engine

R = 60.0
SHEET = cylinder(R)


def polygon(corners, kappa=0.0, v=0.0):
    points = [(x + kappa, y + v) for x, y in corners]
    pairs = zip(points, [*points[1:], points[0]], strict=True)
    return Loop(curves=tuple(LineCurve(p0=a, p1=b) for a, b in pairs), sheet=SHEET)


def layer_of(*loops):
    region = region_from_loops(SHEET, list(loops))
    certificate = Certificate(engine=Engine.ANALYTIC, residual=0.0, jog=0.0, checks={})
    return Layer(index=0, level=R, cut_level=R, thickness=1.0, region=region, area=region.area, certificate=certificate)


RIGHT = ((0, 0), (10, 0), (15, 20), (5, 20))
LEFT = ((5, 0), (15, 0), (10, 20), (0, 20))
BOX = ((0, 0), (10, 0), (10, 20), (0, 20))
# 10 by 20 as well, from 40 by 5
FLAT = ((0, 0), (40, 0), (40, 5), (0, 5))


@pytest.mark.parametrize(
    ("loops", "sizes"),
    [
        ([polygon(RIGHT, k, 3.0 * k) for k in (-80, 0, 60)], [3]),
        # symmetric, and sampled from elsewhere
        ([polygon(BOX, -80.3, 1.7), polygon(BOX, 0.1, 55.5), polygon(BOX, 61.7, -31.1)], [3]),
        # mirrored: the same area, outline and box
        ([polygon(RIGHT, -80), polygon(LEFT, 0), polygon(RIGHT, 60)], [1, 2]),
        # the same area
        ([polygon(BOX, -80), polygon(FLAT, 0), polygon(BOX, 60), polygon(BOX, 90)], [1, 3]),
        # one without its hole's metal
        ([polygon(BOX, -80), polygon(BOX, 0), polygon(((3, 3), (3, 5), (5, 5), (5, 3)), 0)], [1, 1]),
    ],
)
def test_pieces_are_equal_by_shape_wherever_they_lie(loops, sizes):
    layer = layer_of(*loops)
    group = groups_of_equals(layer, LayerFill(beads=()))
    assert sorted(np.bincount(group).tolist()) == sizes


def test_pieces_with_other_beads_are_not_equal_and_the_most_metal_is_shown():
    layer = layer_of(*(polygon(BOX, k) for k in (-80, 0, 60)))
    odd = int(np.argmin([abs(piece.bounds()[0] - 60.0) for piece in layer.region.pieces]))
    beads = []
    for number, piece in enumerate(layer.region.pieces):
        k0, _, k1, v1 = piece.bounds()
        high = v1 if number != odd else 0.5 * v1
        beads.append(Bead(points=np.array([[k0 + 5.0, 0.0], [k1 - 5.0, high]]), kind=BeadKind.HATCH, piece=number))
    fill = LayerFill(beads=tuple(beads))
    group = groups_of_equals(layer, fill)
    assert sorted(np.bincount(group).tolist()) == [1, 2]
    one = representative(layer, fill, width=2.0)
    assert one.words == "one of 2 equal pieces of 3"
    (bead,) = one.fill.beads
    assert bead.piece != odd
    # the one nearest to kappa = 0
    assert one.metal == pytest.approx((0.0, 0.0, 10.0, 20.0))


def test_a_panel_has_room_for_beads_that_stand_out():
    layer = layer_of(polygon(BOX))
    fill = LayerFill(beads=(Bead(points=np.array([[0.0, 10.0], [10.0, 10.0]]), kind=BeadKind.HATCH),))
    assert whole(layer, fill, width=4.0).window == pytest.approx((-2.0, 0.0, 12.0, 20.0))


def test_a_closed_bead_covers_no_more_than_its_width():
    square = np.array([[0.0, 0.0], [40.0, 0.0], [40.0, 40.0], [0.0, 40.0], [0.0, 0.0]])
    ((outer, inner),) = strips_of([square], 4.0 - WIDER)
    canvas = Canvas(60, 60)
    canvas.area([outer + 10.0, inner + 10.0], rgb("#c8102e", 0.5))
    page = np.asarray(canvas.page())[..., 1]
    assert page[30, 30] == 255
    assert max(page[30, 10], page[10, 30]) < 200
    # 44**2 - 36**2, less what four round corners do not cover: (4 - pi) * 2**2
    full = 255.0 - float(page.min())
    covered = (255.0 - page).sum() / full
    assert covered == pytest.approx(44.0**2 - 36.0**2 - (4.0 - math.pi) * 4.0, rel=0.03)


def test_beads_round_a_band_end_where_its_chart_does(fixture_step):
    plan = bs.plan(
        bs.read_step(fixture_step("keyed_band")), bs.Process(layer_thickness=1.4, step_over=3.4), axis="Z", layers=(0, 1)
    )
    (layer,), (fill,) = plan.layers, plan.fills
    half = 0.5 * layer.region.closure.length
    strips = strips_of([shown(bead.points, layer) for bead in fill.beads], plan.process.width, within=layer.region.closure)
    assert max(np.abs(ring[:, 0]).max() for rings in strips for ring in rings) == pytest.approx(half)
    shows = whole(layer, fill, width=plan.process.width)
    assert shows.window[::2] == pytest.approx((-half, half))


@pytest.mark.parametrize(("about", "length"), [(140.0, 100.0), (0.051, 0.05), (7.9, 5.0), (2.0, 2.0)])
def test_scale_bars_are_round(about, length):
    assert round_length(about) == pytest.approx(length)


@pytest.mark.parametrize(
    ("name", "layers"), [("helical_gear", (0, 3)), ("propeller", (0, 12)), ("keyed_band", None), ("helical_gear_tooth", (0, 1))]
)
def test_the_page_says_what_it_shows_and_holds_beads_metal_and_words(name, layers, fixture_step, tmp_path):
    process = bs.Process(layer_thickness=1.4, step_over=3.4)
    plan = bs.plan(bs.read_step(fixture_step(name)), process, axis="Z", layers=layers)
    page = Image.open(draw_layers(plan, tmp_path / "layers.png"))
    assert json.loads(page.text["Description"])["process"]["step_over"] == 3.4
    assert page.width == 1400
    pixels = np.asarray(page.convert("RGB")).astype(int)
    red = (pixels[..., 0] > pixels[..., 1] + 40) & (pixels[..., 0] > pixels[..., 2] + 40)
    assert red.mean() > 0.05
    # nothing is cut off at the page's edges
    for edge in (pixels[:4], pixels[-4:], pixels[:, :4], pixels[:, -4:]):
        assert (edge == 255).all()


def test_pictures_are_drawn_without_a_plotting_library(fixture_step, tmp_path):
    script = (
        "import sys, brep_slicer as bs\n"
        "from brep_slicer.output.pictures import draw_layers, draw_toolpath\n"
        f"part = bs.read_step({str(fixture_step('spur_gear_tooth'))!r})\n"
        "plan = bs.plan(part, bs.Process(layer_thickness=2.0, step_over=3.4))\n"
        f"draw_layers(plan, {str(tmp_path / 'a.png')!r}); draw_toolpath(plan, {str(tmp_path / 'b.png')!r})\n"
        "print('matplotlib.figure' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"


def test_a_panel_without_room_for_an_arrow():
    # an uncaught error before: there is no shape of nothing with as many columns as it takes
    canvas = Canvas(40, 30)
    canvas.arrows(np.zeros((0, 2)), np.zeros((0, 2)), rgb("#c0392b"))
    assert len(np.unique(np.asarray(canvas.page()).reshape(-1, 3), axis=0)) == 1


@pytest.mark.parametrize("count", [0, 1, 40])
def test_lines_are_moved_together_as_each_by_itself(count):
    from brep_slicer.layers import cylinder
    from brep_slicer.output.pictures.panels import _all_beside

    closure, random = cylinder(20.0).closure, np.random.default_rng(7)
    lines = [random.uniform(-300.0, 300.0, 2) + random.normal(size=(random.integers(1, 9), 2)) for _ in range(count)]
    if count > 1:
        # a line that is broken
        lines[3] = np.concatenate([lines[3], np.full((1, 2), np.nan), lines[3] + 1.0])
    middle = np.array([5.0, 3.0])
    found = _all_beside(lines, middle, closure)
    assert len(found) == count
    for line, moved in zip(lines, found, strict=True):
        # whole turns of 2 pi R, to within half a turn of the middle
        turns = (moved - line)[:, 0] / (2.0 * np.pi * 20.0)
        np.testing.assert_allclose(turns[np.isfinite(turns)], np.round(np.nanmean(turns)), atol=1e-9)
        at = 0.5 * (np.nanmin(moved, axis=0) + np.nanmax(moved, axis=0))
        assert abs(at[0] - middle[0]) <= np.pi * 20.0 + 1e-9
