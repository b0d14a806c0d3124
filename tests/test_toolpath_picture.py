"""toolpath.png: what hides what, and that every place that gets metal is in sight."""

from __future__ import annotations

import numpy as np
import pytest

import brep_slicer as bs
from brep_slicer.kernel.display import display_mesh
from brep_slicer.output.pictures import scene, toolpath
from brep_slicer.output.pictures.raster import seen
from brep_slicer.output.pictures.scene import Stretches, blocks_of, part_mesh, stretches_of
from brep_slicer.output.pictures.views import _in_view, _places, ranges_of_deposit, views_of


def test_the_nearer_triangle_hides_the_farther_one_and_what_faces_away_is_not_seen():
    # clockwise with y down faces the eye
    square = np.array([[1.0, 1.0], [1.0, 9.0], [9.0, 9.0], [9.0, 1.0]])
    places = np.concatenate([square, 0.5 * square + 2.5, square])
    depth = np.repeat([0.0, 5.0, 9.0], 4)
    quads = np.array([[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7], [10, 9, 8], [11, 10, 8]])
    page = seen(places, depth, quads, (10, 10))
    triangle, z = page.triangle.reshape(10, 10), page.depth.reshape(10, 10)
    # 8 x 8 pixels of the large square, of which 4 x 4 are hidden by the small one
    assert (triangle >= 0).sum() == 64
    assert np.isin(triangle, [2, 3]).sum() == 16
    np.testing.assert_allclose(z[3:7, 3:7], 5.0, atol=1e-6)
    assert not np.isin(triangle, [4, 5]).any()
    assert np.isin(seen(places, depth, quads, (10, 10), both_sides=True).triangle, [4, 5]).sum() == 64


def test_a_display_mesh_is_closed_and_leaves_the_solid_without_one(fixture_step):
    from OCP.BRepTools import BRepTools

    (solid,) = bs.read_step(fixture_step("eccentric_disc")).solids
    mesh = display_mesh(solid.wrapped, deflection=0.05)
    a, b, c = (mesh.points[mesh.triangles[:, k]] for k in range(3))
    # outwards all round: the area vectors add up to nothing, the tetrahedra to the volume
    assert np.abs(np.cross(b - a, c - a).sum(axis=0)).max() < 1e-6 * np.abs(np.cross(b - a, c - a)).sum()
    assert np.einsum("ij,ij->i", a, np.cross(b, c)).sum() > 0.0
    assert not BRepTools.Triangulation_s(solid.wrapped, 1e9, False)


@pytest.mark.parametrize("name", ["propeller", "helical_gear", "helical_gear_tooth"])
def test_every_place_with_metal_is_in_one_of_the_views(name, fixture_step):
    plan = bs.plan(bs.read_step(fixture_step(name)), bs.Process(layer_thickness=2.8, step_over=6.8), axis="Z")
    mesh = part_mesh(plan, 0.1)
    views = views_of(plan, mesh)
    samples, place = _places(plan)
    shown = np.any([_in_view(view, mesh, samples, place, plan.process.width) for view in views], axis=0)
    assert 1 <= len(views) <= 2
    assert shown.mean() >= 0.9


# one bead of many points a piece; many beads; straight beads in many stretches; full turns that go on from one to the next
BLOCKS = {
    "spiral": ("helical_gear_tooth", "spiral"),
    "hatch": ("spur_gear_tooth", "hatch"),
    "along": ("tube", bs.Hatch(angle_deg=90.0)),
    "helix": ("tube", "helix"),
}


@pytest.mark.parametrize("name", BLOCKS)
@pytest.mark.parametrize("at_once", [37, 400])
def test_blocks_hold_every_stretch_once_and_few_of_them(name, at_once, fixture_step, monkeypatch):
    fixture, pattern = BLOCKS[name]
    process = bs.Process(layer_thickness=4.0, step_over=4.0, fill=bs.Fill(pattern=pattern))
    path = bs.plan(bs.read_step(fixture_step(fixture)), process, axis="Z", layers="0:2").toolpath
    longest, shortest = 3.0, 1e-9
    whole = stretches_of(path, slice(0, len(path)), longest, shortest)
    monkeypatch.setattr(scene, "AT_ONCE", at_once)
    blocks = list(blocks_of(path, longest))
    assert blocks[0].start == 0
    assert blocks[-1].stop == len(path)
    assert [b.stop for b in blocks[:-1]] == [b.start for b in blocks[1:]]
    parts = [stretches_of(path, rows, longest, shortest) for rows in blocks]
    # a single segment is not divided
    longest_one = path.segment_lengths().max() / longest + 1.0
    assert max(len(part) for part in parts) <= at_once + longest_one
    joined = Stretches.together(parts)
    for end in ("a", "b", "normal_a", "normal_b", "layer"):
        np.testing.assert_array_equal(getattr(joined, end), getattr(whole, end))
    # only where a bead had to be cut is it not joined to its own next part
    assert (joined.before != whole.before).sum() <= len(blocks) - 1
    laid = np.linalg.norm(whole.b - whole.a, axis=1).sum()
    chords = np.linalg.norm(np.diff(path.points, axis=0), axis=1)[path.deposits[1:]].sum()
    assert laid == pytest.approx(chords, rel=1e-12)


@pytest.mark.parametrize("name", ["propeller", "helical_gear_tooth", "tube"])
def test_a_picture_in_blocks_is_the_picture_at_once(name, fixture_step, monkeypatch, tmp_path):
    from PIL import Image

    plan = bs.plan(bs.read_step(fixture_step(name)), bs.Process(layer_thickness=2.8, step_over=3.4), axis="Z")
    sizes, made = [], toolpath.bead_mesh

    def counted(plan, of, profile):
        sizes.append(len(of))
        return made(plan, of, profile)

    monkeypatch.setattr(toolpath, "bead_mesh", counted)
    pages = []
    for at_once in (10**7, 200):
        sizes.clear()
        for module in (scene, toolpath):
            monkeypatch.setattr(module, "AT_ONCE", at_once)
        page = Image.open(toolpath.draw_toolpath(plan, tmp_path / f"{at_once}.png")).convert("RGB")
        pages.append(np.asarray(page).astype(int))
    assert len(sizes) > 2
    assert max(sizes) < 2 * 200 + 50
    # but for where a bead had to be cut, and the last digit of depths
    assert (np.abs(pages[0] - pages[1]).max(axis=2) > 30).mean() < 5e-4


def test_ranges_of_what_is_deposited(fixture_step):
    path = bs.plan(bs.read_step(fixture_step("tube")), bs.Process(layer_thickness=4.0, step_over=4.0), axis="Z").toolpath
    ways = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
    laid = path.points[path.deposits] @ ways
    np.testing.assert_allclose(ranges_of_deposit(path, ways), [laid.min(axis=0), laid.max(axis=0)], atol=1e-9)
