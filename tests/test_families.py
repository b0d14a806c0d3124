"""Sections in layers that are cones or planes: closed forms, the volume identity, the surface integral, errors."""

from __future__ import annotations

import math

import numpy as np
import pytest

import brep_slicer as bs
from brep_slicer.curves import CurveKind, with_apex
from brep_slicer.layers import Cones, Cylinders, Planes
from brep_slicer.section import cut_solids
from brep_slicer.section.analytic import sections_by_analysis
from brep_slicer.section.oracle import area_of_level
from brep_slicer.section.volume import closure_of

bd = pytest.importorskip("build123d")

DEG = math.pi / 180.0
FAMILIES = [Planes(), Planes((1.0, 0.0, 0.0)), *(Cones(a) for a in (10.0, -10.0, 30.0, -30.0, 60.0))]
FIXTURES = ["box_on_shaft", "cam", "cylinder", "drilled_tube", "eccentric_disc", "helical_gear_tooth", "keyed_band"]
FIXTURES += ["oblique_tube", "propeller", "spur_gear_tooth", "tube", "wind_blade"]
Z = bs.axis_from_text("Z")


def layer_at(shape, level: float, family) -> bs.Layer:
    (layer,) = bs.slice_part(bs.as_part(shape), [level], axis="Z", family=family)
    assert isinstance(layer, bs.Layer), layer
    assert layer.level == level
    return layer


@pytest.mark.parametrize("alpha", [10.0, -10.0, 30.0, 60.0])
def test_a_ring_of_a_cone_is_a_sector(alpha):
    """A disc from z = -2 to 3 with a bore, cut by the cone: pi (rho0**2 - rho1**2) / sin(alpha), rho = (c - z sin) / cos."""
    a = alpha * DEG
    level = 12.0
    low, high = -2.0, 3.0
    disc = bd.Pos(0, 0, 0.5) * (bd.Cylinder(60, 5) - bd.Cylinder(0.5, 5))
    layer = layer_at(disc, level, Cones(alpha))
    radii = [(level - z * math.sin(a)) / math.cos(a) for z in (low, high)]
    assert layer.area == pytest.approx(math.pi * abs(radii[0] ** 2 - radii[1] ** 2) / abs(math.sin(a)), rel=1e-12)
    assert layer.region.length == pytest.approx(2.0 * math.pi * sum(radii), rel=1e-12)
    assert {c.kind for loop in layer.region.loops for c in loop.curves} == {CurveKind.ARC}
    with pytest.raises(TypeError, match="no radius"):
        _ = layer.radius


@pytest.mark.parametrize("alpha", [20.0, -20.0, 50.0])
def test_an_apex_inside_of_the_part(alpha):
    """A bar R 10 from z = 0 to 30 holds the apex at z = 12: below it (above, if alpha < 0), what is a cone up to R 10."""
    a = alpha * DEG
    bar = bd.Pos(0, 0, 15) * bd.Cylinder(10, 30)
    level = 12.0 * math.sin(a)
    layer = layer_at(bar, level, Cones(alpha))
    # the cone ends at the bar's side, or at its end if that comes first
    rho = min(10.0, (12.0 if alpha > 0 else 18.0) * math.tan(abs(a)))
    assert layer.area == pytest.approx(math.pi * rho**2 / abs(math.sin(a)), rel=1e-12)
    (piece,) = layer.region.pieces
    assert piece.winds


@pytest.mark.parametrize("tilt", [0.0, 20.0, 45.0])
def test_a_plane_through_a_bar_is_a_circle_or_an_ellipse(tilt):
    """The section of a bar R 10 by a plane tilted by t: pi R**2 / cos(t)."""
    n = (math.sin(tilt * DEG), 0.0, math.cos(tilt * DEG))
    layer = layer_at(bd.Cylinder(10, 80), 1.5, Planes(n))
    assert layer.area == pytest.approx(100.0 * math.pi / math.cos(tilt * DEG), rel=1e-10)


@pytest.mark.parametrize(
    ("normal", "level", "area"), [((0.0, 0.0, 1.0), 7.0, 200.0), ((1.0, 0.0, 0.0), -2.0, 600.0), ((0.6, 0.0, 0.8), 3.0, 250.0)]
)
def test_planes_through_a_box(normal, level, area):
    """A box 10 x 20 x 30 about the origin; the third plane meets all four upright sides: 10 * 20 / 0.8."""
    layer = layer_at(bd.Box(10, 20, 30), level, Planes(normal))
    assert layer.area == pytest.approx(area, rel=1e-13)
    assert {c.kind for loop in layer.region.loops for c in loop.curves} == {CurveKind.LINE}


def test_planes_through_a_ball_and_a_torus():
    ball = layer_at(bd.Pos(3, 1, 2) * bd.Sphere(10), 6.0, Planes())
    assert ball.area == pytest.approx(math.pi * (100.0 - 16.0), rel=1e-9)
    torus = layer_at(bd.Torus(20, 5), 3.0, Planes())
    assert torus.area == pytest.approx(math.pi * ((20.0 + 4.0) ** 2 - (20.0 - 4.0) ** 2), rel=1e-9)


def test_flat_cones_give_the_cylinders_sections(fixture_step):
    """alpha = 1e-6: levels differ by z alpha, kappa by a turn's z alpha; areas by the outline's length times that."""
    part = bs.read_step(fixture_step("helical_gear_tooth"))
    axis = bs.find_axis(part)
    (solid,) = cut_solids(part, axis)
    radii = (solid.critical.lowest + np.array([0.1, 0.4, 0.8]) * np.ptp(solid.critical.radii)).tolist()
    plain = bs.slice_part(part, radii, axis=axis)
    flat = bs.slice_part(part, radii, axis=axis, family=Cones(math.degrees(1e-6)))
    for one, other in zip(plain, flat, strict=True):
        assert len(one.region.pieces) == len(other.region.pieces)
        farthest = float(np.abs([p.bounds() for p in one.region.pieces]).max())
        assert abs(one.area - other.area) < 1e-6 * farthest * one.region.length
        assert one.region.length == pytest.approx(other.region.length, rel=1e-4)


def integral(solid) -> float:
    """The integral of A(c) dc, Gauss-Legendre on c = a + (b - a) sin(pi x / 2)**2 between critical levels."""
    levels = solid.critical.radii
    x, w = np.polynomial.legendre.leggauss(40)
    x, w = 0.5 * (x + 1.0), 0.5 * w
    a, b = levels[:-1][np.diff(levels) > 1e-7], levels[1:][np.diff(levels) > 1e-7]
    asked = a[:, None] + (b - a)[:, None] * np.sin(0.5 * np.pi * x) ** 2
    weights = (b - a)[:, None] * np.pi * np.sin(0.5 * np.pi * x) * np.cos(0.5 * np.pi * x) * w
    found = sections_by_analysis(solid, asked.ravel())
    lost = [section for section in found if isinstance(section, bs.LayerError)]
    assert not lost, lost[0]
    sheets = [solid.family.sheet(c) for c in asked.ravel().tolist()]
    areas = [sum(loop.signed_area() for loop in with_apex(s, loops)) for s, (loops, _) in zip(sheets, found, strict=True)]
    return float((np.reshape(areas, asked.shape) * weights).sum())


@pytest.mark.slow
@pytest.mark.parametrize("family", FAMILIES, ids=repr)
@pytest.mark.parametrize("name", FIXTURES)
def test_the_areas_add_up_to_the_volume(name, family, fixture_step):
    part = bs.read_step(fixture_step(name))
    for solid in cut_solids(part, Z if name != "propeller" else bs.find_axis(part), family):
        volume = closure_of(solid.brep)
        assert integral(solid) == pytest.approx(volume.volume, rel=max(1e-9, volume.defect))


@pytest.mark.parametrize("family", [Planes(), Planes((0.6, 0.0, 0.8)), Cones(15.0), Cones(-40.0)], ids=repr)
def test_areas_are_those_of_the_surface_integral(family, fixture_step):
    part = bs.read_step(fixture_step("helical_gear_tooth"))
    (solid,) = cut_solids(part, bs.find_axis(part), family)
    low, high = solid.critical.radii[[0, -1]]
    levels = low + (high - low) * np.array([0.13, 0.42, 0.77])
    for level, (loops, _) in zip(levels.tolist(), sections_by_analysis(solid, levels), strict=True):
        area = sum(loop.signed_area() for loop in with_apex(family.sheet(level), loops))
        assert area == pytest.approx(area_of_level(solid.brep, level, family, panels=16), rel=2e-4)


def test_levels_and_engines_are_checked():
    part = bs.as_part(bd.Cylinder(10, 80))
    with pytest.raises(bs.InputError, match="levels must increase"):
        bs.slice_part(part, [3.0, 1.0], axis="Z", family=Planes())
    with pytest.raises(bs.InputError, match="analytic engine"):
        bs.slice_part(part, [3.0], axis="Z", family=Planes(), engine="boolean")
    (beyond,) = bs.slice_part(part, [50.0], axis="Z", family=Planes())
    assert beyond.region.is_empty
    assert repr(bs.slice_part(part, [5.0], axis="Z", family=Cylinders())[0]).startswith("Layer(0: R 5 mm")
