"""Fillets and chamfers at the radius that they stand on: layer 0 by its edges, its area the limit of those outside."""

from __future__ import annotations

import build123d as bd
import numpy as np
import pytest

import brep_slicer as bs
from brep_slicer.section import Engine

HUB = 25.0
# OCCT's fillet is a B-spline that follows the ball's contact to 2e-3 mm (measured), along an outline of 2 pi (8 + r).
CONTACT = 2e-3


def filleted(outline, height, finish):
    """A feature on a hub of R 25, its root finished by fillet or chamfer."""
    part = bd.Cylinder(HUB, 60) + bd.extrude(bd.Plane.YZ * outline, height)
    root = [
        edge
        for edge in part.edges()
        if all(abs(np.hypot((edge @ t).X, (edge @ t).Y) - HUB) < 1e-3 for t in (0, 0.2, 0.3, 0.5, 0.8, 1))
        and abs((edge @ 0.5).Z) < 25
    ]
    return finish(root)


def boss_area(boss, ball):
    """25 * integral of the height of the circle grown by the ball's radius, at y = (25 + r) sin(theta): the ball's contacts."""
    reach, out = boss + ball, HUB + ball
    x, w = np.polynomial.legendre.leggauss(400)
    # y = reach sin(s), theta = asin(y / out): the ends are smooth in s
    s = 0.5 * np.pi * x
    y = reach * np.sin(s)
    d_theta = reach * np.cos(s) / np.sqrt(out**2 - y**2)
    return float(HUB * np.sum(w * 0.5 * np.pi * 2.0 * reach * np.cos(s) * d_theta))


@pytest.mark.parametrize("ball", [2.5])
def test_a_boss_with_a_rolling_ball_fillet(ball):
    (layer,) = bs.slice_part(filleted(bd.Circle(8), 50, lambda root: bd.fillet(root, ball)), [HUB], axis="Z")
    assert layer.certificate.engine is Engine.ANALYTIC
    assert not layer.certificate.fallback
    assert layer.area == pytest.approx(boss_area(8.0, ball), abs=CONTACT * 2.0 * np.pi * (8.0 + ball))


@pytest.mark.parametrize("ball", [1.0, 3.0, 5.0])
def test_a_collar_with_a_fillet_all_round(ball):
    # a disc 12 high and its two fillets: 2 pi R (12 + 2 r)
    part = bd.Cylinder(HUB, 60) + bd.Cylinder(40, 12)
    root = [edge for edge in part.edges() if edge.geom_type == bd.GeomType.CIRCLE and abs(edge.radius - HUB) < 1e-6]
    root = [edge for edge in root if abs(edge.center().Z) < 25]
    (layer,) = bs.slice_part(bd.fillet(root, ball), [HUB], axis="Z")
    assert layer.certificate.engine is Engine.ANALYTIC
    assert not layer.certificate.fallback
    assert layer.area == pytest.approx(2.0 * np.pi * HUB * (12.0 + 2.0 * ball), abs=1e-6)


@pytest.mark.parametrize(
    ("outline", "height", "finish"),
    [
        pytest.param(bd.RectangleRounded(20, 9, 2), 30, lambda root: bd.fillet(root, 1.5), id="key"),
        pytest.param(bd.Rectangle(6, 40), 45, lambda root: bd.fillet(root, 3.0), id="plate"),
        pytest.param(bd.RectangleRounded(24.8, 12.2, 3.04), 100, lambda root: bd.fillet(root, 2.0), id="arm"),
        pytest.param(bd.Circle(8), 50, lambda root: bd.chamfer(root, 2.0), id="chamfer"),
    ],
)
def test_the_area_goes_on_from_outside(outline, height, finish):
    part = filleted(outline, height, finish)
    layers = bs.slice_part(part, [HUB, HUB + 1e-4, HUB + 4e-4], axis="Z")
    assert [layer.certificate.fallback for layer in layers] == [""] * 3
    area, near, far = (layer.area for layer in layers)
    # A = A0 - c sqrt(step) + O(step) where the fillet is tangent, so A0 = 2 A(1) - A(4); a chamfer moves by the step only
    assert area == pytest.approx(2.0 * near - far, abs=0.02)


@pytest.mark.parametrize("turn", [(33, 21, 5), (-63, 21, 50), (11, 71, 50)])
def test_about_any_axis_from_a_file(turn, tmp_path):
    part = bd.Pos(12, -40, 7) * bd.Rot(*turn) * filleted(bd.Circle(8), 50, lambda root: bd.fillet(root, 2.5))
    bd.export_step(part, str(tmp_path / "boss.step"))
    (layer,) = bs.slice_part(bs.read_step(tmp_path / "boss.step"), [HUB])
    assert layer.certificate.engine is Engine.ANALYTIC
    assert not layer.certificate.fallback
    assert layer.area == pytest.approx(boss_area(8.0, 2.5), abs=CONTACT * 2.0 * np.pi * 10.5)


@pytest.mark.parametrize("outside", [1e-7, 2e-7, 5e-7, 1e-6, 3e-6, 1e-5])
@pytest.mark.parametrize(
    ("outline", "ball"),
    [
        pytest.param(bd.Circle(8), 1.0, id="boss 1"),
        pytest.param(bd.Circle(8), 2.5, id="boss 2.5"),
        pytest.param(bd.RegularPolygon(9, 6), 2.0, id="hexagon"),
        pytest.param(bd.Rot(0, 0, 30) * bd.RectangleRounded(24, 5, 2.4), 2.0, id="tilted blade"),
        pytest.param(bd.RectangleRounded(20, 9, 2), 1.5, id="key"),
    ],
)
def test_just_outside_of_the_contact(outline, ball, outside):
    # within the noise of the fillet's edge (up to 1.5e-5 mm) the outline is the edge's, and says how far it may be off
    layers = bs.slice_part(
        filleted(outline, 50, lambda root: bd.fillet(root, ball)), [HUB, HUB + outside, HUB + 1e-4, HUB + 4e-4], axis="Z"
    )
    assert [layer.certificate.fallback for layer in layers] == [""] * 4
    assert all(layer.certificate.engine is Engine.ANALYTIC for layer in layers)
    at, layer, near, far = layers
    slope = (near.area - far.area) / 1e-2
    wanted = near.area + slope * (1e-2 - np.sqrt(outside))
    assert layer.area == pytest.approx(wanted, abs=0.02 + layer.certificate.bound * layer.region.length)
    assert near.area < layer.area <= at.area + 1e-3
    assert layer.certificate.bound < 0.03


@pytest.mark.parametrize("outside", [1e-8, 2e-7, 1e-6, 1e-5])
@pytest.mark.parametrize("sector", [bd.Box(100, 100, 100), bd.Pos(50, 0, 0) * bd.Box(100, 40, 100)])
def test_a_collar_just_outside_of_its_contact(sector, outside):
    # 2 pi R (12 + 2 (r - sqrt(r**2 - (r - outside)**2))), and of a strip 40 wide the share 2 asin(20 / R) / (2 pi)
    ball = 3.0
    part = bd.Cylinder(HUB, 60) + bd.Cylinder(40, 12)
    root = [edge for edge in part.edges() if edge.geom_type == bd.GeomType.CIRCLE and abs(edge.radius - HUB) < 1e-6]
    part = bd.Cylinder(HUB, 60) + (bd.fillet([edge for edge in root if abs(edge.center().Z) < 25], ball) & sector)
    (layer,) = bs.slice_part(part, [HUB + outside], axis="Z")
    radius = HUB + outside
    turn = 2.0 * np.pi if sector.bounding_box().min.X < 0 else 2.0 * np.arcsin(20.0 / radius)
    wanted = turn * radius * (12.0 + 2.0 * (ball - np.sqrt(ball**2 - (ball - outside) ** 2)))
    assert layer.certificate.engine is Engine.ANALYTIC
    assert layer.certificate.fallback == ""
    assert layer.area == pytest.approx(wanted, abs=1e-6 + layer.certificate.bound * layer.region.length)
