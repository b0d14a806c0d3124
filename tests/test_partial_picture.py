"""toolpath.png of some layers only: no metal that is not there yet hides them."""

from __future__ import annotations

import math

import numpy as np
import pytest

import brep_slicer as bs
from brep_slicer.output.pictures.lowered import cut_lines_at, lowered
from brep_slicer.output.pictures.scene import part_mesh, top_of

Z = bs.axis_from_text("Z")
FINE = 0.02


def plan_of(fixture_step, name, layers):
    return bs.plan(bs.read_step(fixture_step(name)), bs.Process(layer_thickness=1.4, step_over=3.4), axis=Z, layers=layers)


def corners_of(mesh):
    return mesh.points[mesh.triangles]


@pytest.mark.parametrize(
    ("name", "layers"), [("helical_gear", (0, 3)), ("helical_gear_tooth", (2, 7)), ("propeller", (0, 9)), ("cam", (0, 2))]
)
def test_the_part_ends_at_the_last_planned_layer_closed_over_its_section(name, layers, fixture_step):
    plan = plan_of(fixture_step, name, layers)
    top = plan.layers[-1].radius + 1.4
    assert top_of(plan) == pytest.approx(top)
    corners = corners_of(part_mesh(plan, FINE))
    rho = np.hypot(corners[..., 0], corners[..., 1])
    assert rho.max() <= top + 1e-9
    # the lid is the section there, from facets that lie FINE off the part at most
    lid = corners[(rho > top - 1e-9).all(axis=1)]
    kappa = np.arctan2(lid[..., 1], lid[..., 0])
    kappa = top * (kappa - 2.0 * math.pi * np.round((kappa - kappa[:, :1]) / (2.0 * math.pi)))
    flat = np.stack([kappa, lid[..., 2]], axis=-1)
    b, c = flat[:, 1] - flat[:, 0], flat[:, 2] - flat[:, 0]
    area = 0.5 * float((b[:, 0] * c[:, 1] - b[:, 1] * c[:, 0]).sum())
    (section,) = bs.slice_part(plan.part, [top], axis=Z)
    assert area == pytest.approx(section.area, rel=0.02)


@pytest.mark.parametrize("name", ["helical_gear_tooth", "propeller", "cam"])
def test_all_of_a_parts_layers_show_all_of_the_part(name, fixture_step):
    plan = plan_of(fixture_step, name, None)
    corners = corners_of(part_mesh(plan, FINE))
    assert np.hypot(corners[..., 0], corners[..., 1]).max() == pytest.approx(plan.highest, abs=0.1)


def test_a_collar_that_stands_is_not_cut():
    bd = pytest.importorskip("build123d")
    shaft = bd.Solid.make_cylinder(20, 100) + bd.Solid.make_cylinder(40, 10)
    clad = bd.Solid.make_cylinder(30, 30, bd.Plane(origin=(0, 0, 50)))
    part = bs.as_part(shaft + clad)
    plan = bs.plan(part, bs.Process(layer_thickness=1.0, step_over=2.0), axis=Z, substrate=20.0, layers=(0, 3))
    mesh = part_mesh(plan, FINE)
    corners = corners_of(mesh)
    rho, z = np.hypot(corners[..., 0], corners[..., 1]), corners[..., 2]
    assert plan.substrate.zones == ((0.0, 10.0),)
    # what is not built stays as high as it is
    assert rho[(z < 11.0).all(axis=1)].max() == pytest.approx(40.0, abs=0.1)
    assert rho[(z > 40.0).all(axis=1)].max() == pytest.approx(23.0, abs=1e-9)


def test_triangles_are_cut_where_their_edges_go_through_the_radius():
    # a right triangle in the plane y = 0, its corner at x = 10, its legs 6 and 3: at x = 13 half of its height is left
    points = np.array([[10.0, 0, 0], [16.0, 0, 0], [10.0, 0, 3.0]])
    soup = lowered(points, np.tile([0.0, -1.0, 0.0], (3, 1)), np.array([[0, 1, 2]]), axis=Z, top=13.0)
    a, b, c = (soup.points[:, k] for k in range(3))
    # what is inside: the whole, 9, less the triangle beyond, 0.5 * 3 * 1.5; moved in, the rest has no area
    assert 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() == pytest.approx(9.0 - 2.25, rel=1e-12)
    ((p, q),) = soup.lines
    np.testing.assert_allclose(sorted([p.tolist(), q.tolist()]), [[13.0, 0.0, 0.0], [13.0, 0.0, 1.5]], atol=1e-12)
    (line,) = cut_lines_at(points, np.array([[1, 0]]), axis=Z, top=13.0)
    np.testing.assert_allclose(sorted(line.tolist()), [[10.0, 0.0, 0.0], [13.0, 0.0, 0.0]], atol=1e-12)
