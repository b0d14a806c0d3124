"""toolpath.png: what hides what, and that every place that gets metal is in sight."""

from __future__ import annotations

import numpy as np
import pytest

import brep_slicer as bs
from brep_slicer.kernel.display import display_mesh
from brep_slicer.output.pictures.raster import seen
from brep_slicer.output.pictures.scene import part_mesh
from brep_slicer.output.pictures.views import _in_view, _places, views_of


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
