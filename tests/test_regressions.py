"""Sections that were wrong once, each with what was wrong; the formula says what is right."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import quad

import brep_slicer as bs
from brep_slicer.errors import LayerError
from brep_slicer.kernel.shapes import volume_of
from brep_slicer.section import cut_solids
from brep_slicer.section.analytic import sections_by_analysis
from brep_slicer.testing import integrate_sections

bd = pytest.importorskip("build123d")
Z = bs.axis_from_text("Z")


def prepared(shape):
    return cut_solids(bs.as_part(shape.solids()[0]), Z)[0]


def shaft(radius=40.0, height=80.0):
    return bd.Solid.make_cylinder(radius, height, bd.Plane(origin=(0, 0, -0.5 * height)))


class TestASphereOnAShaft:
    """Its sections meet no edge. Just above the shaft, and just below the top, they were missing without a word."""

    def solid(self):
        return prepared(shaft() + bd.Solid.make_sphere(15, bd.Plane(origin=(38, 3, 5))))

    @staticmethod
    def area(r):
        # |v| < sqrt(rho_s**2 - d**2), d**2 = r**2 + e**2 - 2 r e cos(theta)
        e = math.hypot(38, 3)
        most = math.acos(min(1.0, (r * r + e * e - 225.0) / (2.0 * r * e)))
        return (
            4.0
            * r
            * quad(
                lambda t: math.sqrt(max(0.0, 225.0 - r * r - e * e + 2 * r * e * math.cos(t))),
                0.0,
                most,
                epsabs=1e-10,
                limit=200,
            )[0]
        )

    def test_never_silently_empty(self):
        solid = self.solid()
        tip = solid.critical.highest
        radii = np.concatenate([40.0 + np.geomspace(1e-6, 1.0, 13), [45.0, 50.0], tip - np.geomspace(1.0, 1e-7, 15)])
        certified = 0
        for section, radius in zip(sections_by_analysis(solid, radii), radii.tolist(), strict=True):
            if isinstance(section, LayerError):
                continue
            certified += 1
            area = sum(loop.signed_area() for loop in section[0])
            assert area == pytest.approx(self.area(radius), rel=1e-6, abs=1e-8), radius
        assert certified >= 20

    def test_islands_near_the_tip_are_found(self):
        solid = self.solid()
        heights = 10.0 ** -np.arange(8, 0, -1.0)
        areas = [
            sum(loop.signed_area() for loop in s[0])
            for s in sections_by_analysis(solid, solid.critical.highest - heights[::-1])
        ]
        # a paraboloid: the area is proportional to the height above the layer
        assert np.allclose(np.array(areas)[3:] / heights[::-1][3:], areas[-1] / heights[0], rtol=1e-2)


def test_a_torus_thicker_than_its_axis(real_step):
    """A nose stored as a torus that crosses its own axis: the circle was taken from the wrong branch of its profile."""
    part = bs.read_step(real_step("propeller_6land_D_5axisslicer.step"))
    (solid,) = cut_solids(part, bs.find_axis(part))
    (section,) = sections_by_analysis(solid, np.array([3.0114791606014606]))
    assert sum(loop.signed_area() for loop in section[0]) == pytest.approx(614.25349, abs=1e-4)


def test_the_innermost_layer_of_a_gear():
    """At its root circle the plane faces' arcs run across the teeth, not along the root lands."""
    gears = pytest.importorskip("fixtures.gears")
    (layer,) = bs.slice_part(gears.gear(gears.SPUR_GEAR), [87.5], axis=Z)
    assert len(layer.region.pieces) == 20
    assert layer.area == pytest.approx(20 * gears.SPUR_GEAR.area(87.5), rel=1e-12)


def test_a_layer_that_just_touches_a_flat():
    """At R = 80 the flat x = 80 is touched along a line: two nodes fell on each other, and the pairing failed."""
    bodies = pytest.importorskip("fixtures.bodies")
    for turn in (0.0, 0.0625, 2.0):
        (layer,) = bs.slice_part(bodies.BoxOnShaft(turn=turn).solid(), [80.0], axis=Z)
        assert layer.certificate.engine is bs.Engine.ANALYTIC
        assert layer.area == pytest.approx(2 * 80.0 * math.asin(20.0 / 80.0) * 30.0, rel=1e-12)


COS, SIN = math.cos(0.4), math.sin(0.4)
QUADRICS = {
    "oblique hole": lambda: (
        bd.Solid.make_cylinder(50, 80, bd.Plane(origin=(0, 0, -40)))
        - bd.Solid.make_cylinder(
            8, 300, bd.Plane((-150 * math.cos(0.4), 5, -150 * math.sin(0.4)), z_dir=(math.cos(0.4), 0, math.sin(0.4)))
        )
    ),
    "cone pin": lambda: shaft() + bd.Solid.make_cone(12, 5, 60, bd.Plane((5, 2, 0), z_dir=(0.9, 0.2, 0.3))),
    "tilted torus": lambda: shaft() + bd.Solid.make_torus(15, 5, bd.Plane((42, 0, 0), z_dir=(1, 0.2, 0.3))),
}


@pytest.mark.parametrize("make", QUADRICS.values(), ids=QUADRICS)
def test_volume_of_faces_in_any_position(make):
    solid = prepared(make())
    found = integrate_sections(solid)
    assert found.volume == pytest.approx(volume_of(solid.wrapped), rel=1e-8)


def test_quadrics_keep_their_kind():
    solid = prepared(QUADRICS["oblique hole"]())
    kinds = {
        c.kind.value for loops, _ in sections_by_analysis(solid, np.array([31.0, 40.0])) for loop in loops for c in loop.curves
    }
    assert kinds == {"line", "quadric"}


def test_all_lands_of_a_gear_are_above_a_layer_or_none(fixture_step, real_step):
    """Just 1e-9 mm below the tips, the rounding of ten equal radii left two lands of ten standing."""
    part = bs.read_step(real_step("gear_spur_m5z10_f360.step"))
    for radius in (30.0 - 1e-9, 29.999999999, 30.0 - 1.1e-9, 30.0 - 0.9e-9):
        (layer,) = bs.slice_part(part, [radius])
        assert len(layer.region.pieces) in (0, 10)


class TestAFallbackThatWasBelieved:
    """OCCT's common was empty at radii where a fillet's face touches the layer, and its own checks agreed: 0 = 0 = 0."""

    def solid(self):
        return bd.fillet((bd.Pos(8, 0, 0) * bd.Box(10, 8, 6)).edges(), 1.5)

    @pytest.mark.parametrize("near", [5.14781507, 3.905124838, 11.7686023])
    def test_no_layer_is_empty(self, near):
        radii = prepared(self.solid()).critical.radii
        radius = float(radii[np.abs(radii - near).argmin()])
        below, at, above = bs.slice_part(self.solid(), [radius - 1e-4, radius, radius + 1e-4], axis=Z)
        assert abs(radius - near) < 1e-6
        # a layer that failed would say so; an area is between its neighbours'
        if isinstance(at, bs.Layer):
            low, high = sorted((below.area, above.area))
            assert low - 0.05 <= at.area <= high + 0.05


def test_a_layer_that_touches_a_corner_is_no_ring():
    # two nodes at one corner, an angle of -1e-16 apart, were taken for a full turn at the top and at the bottom
    box = bd.Pos(-4.8, -3.2, 4.2) * bd.Rot(0, 0, 12.34) * bd.Box(1.2, 1.9, 7.4)
    low = float(prepared(box).critical.radii[0])
    for layer in bs.slice_part(box, [low - 1e-9, low, low + 1e-9, low + 1e-3], axis=Z):
        # width of the corner's cut: a few tenths of a millimetre at most, 7.4 mm high
        assert layer.area < 0.1 * 2.0 * math.pi * low * 7.4
        assert not any(piece.winds for piece in layer.region.pieces)


class TestABarrelThatTouchesTheAxis:
    """rho is stationary on the axis, its second derivative singular: the lowest radius was taken for 6, and R = 6 was empty."""

    def solid(self):
        return bd.Pos(5, 0, 0) * bd.Rot(90, 0, 0) * bd.Cylinder(5, 12)

    def test_it_begins_on_the_axis(self):
        assert prepared(self.solid()).critical.lowest < 1e-5

    def test_the_layer_through_the_end_planes(self):
        below, at, above = bs.slice_part(self.solid(), [6.0 - 1e-6, 6.0, 6.0 + 1e-6], axis=Z)
        assert above.area < below.area
        # R = 6 is the limit from outside: the boolean steps 1e-5 mm
        assert at.area == pytest.approx(above.area, rel=2e-4)

    @pytest.mark.slow
    def test_volume(self):
        found = integrate_sections(prepared(self.solid()), relative=1e-7)
        assert found.volume == pytest.approx(math.pi * 25.0 * 12.0, rel=1e-5)


def test_a_cam_of_many_facets_is_no_cylinder():
    # each facet's edges are level within the band; joined in a row they were taken for one radius, and higher layers were empty
    t = np.arange(2000) * math.pi / 1000.0
    r = 10.0 + 0.005 * (1.0 - np.cos(t))
    corners = [(float(x), float(y)) for x, y in zip(r * np.cos(t), r * np.sin(t), strict=True)]
    cam = bd.extrude(bd.make_face(bd.Polyline(*corners, close=True)), 2.0)
    assert prepared(cam).critical.highest == pytest.approx(10.01, abs=1e-9)
    for layer in bs.slice_part(cam, [10.0025, 10.0077, 10.0095], axis=Z):
        # a facet's middle lies 1.2e-5 mm below its corners
        share = layer.area / (2.0 * math.pi * layer.radius * 2.0)
        assert np.mean(r - 1.3e-5 > layer.radius) - 0.002 <= share <= np.mean(r > layer.radius) + 0.002


def test_an_empty_result_of_a_host_is_told():
    with pytest.raises(bs.InputError):
        bs.as_part(bd.Part())


class TestABallWhosePoleLiesOnTheRadius:
    """OCCT gave its edges a tolerance of 3 mm, which excused areas that differed by 60 % and an outline that crossed itself."""

    @pytest.mark.parametrize("engine", ["analytic", "boolean"])
    @pytest.mark.parametrize("radius", [8.0, 8.0 - 1e-8, 8.0 + 1e-7, 8.0 - 1e-6, 8.0 - 1e-3, 8.0 + 1e-4])
    def test_right_or_failed(self, radius, engine):
        ball = bd.Solid.make_sphere(5, bd.Plane((8, 0, 10)))
        (layer,) = bs.slice_part(ball, [radius], axis=Z, engine=engine)
        if layer.failed:
            assert 0.0 < abs(radius - 8.0) < 1e-5
            return
        most = math.acos((radius**2 + 64.0 - 25.0) / (16.0 * radius))
        truth = (
            4.0 * radius * quad(lambda t: math.sqrt(max(0.0, 25.0 - radius**2 - 64.0 + 16 * radius * math.cos(t))), 0, most)[0]
        )
        assert layer.area == pytest.approx(truth, abs=1e-9 + layer.certificate.residual * layer.region.length)
        assert layer.certificate.residual < 1e-4
        assert layer.region.to_shapely().is_valid


class TestAHoleThroughACollar:
    """Turns of a helix began inside of the hole (at the curve's turning point Newton left for the far side), and every seventh
    radius went to the boolean, where a level line went through corners of its grid."""

    def solid(self):
        hole = bd.Solid.make_cylinder(4, 200, bd.Plane(origin=(-100, 0, 0), z_dir=(1, 0, 0)))
        return bd.Pos(0, 0, 40) * (shaft(15.0) + shaft(25.0, 40.0) - hole)

    def test_no_bead_begins_in_it(self):
        process = bs.Process(layer_thickness=0.5, step_over=2.0, fill=bs.Fill(pattern="helix"))
        path = bs.plan(self.solid(), process, axis=Z, layers=(14, 18)).toolpath
        laid = path.deposits | np.append(path.deposits[1:], False)
        from_hole = np.hypot(path.points[laid, 1], path.points[laid, 2] - 40.0)
        # an inset of 1.44 mm in the plane, along the arc
        assert from_hole.min() > 4.0 + 1.3

    def test_every_radius_is_vouched_for(self):
        radii = np.linspace(15.01, 24.99, 120)
        for layer in bs.slice_part(self.solid(), radii.tolist(), axis=Z):
            assert layer.certificate.fallback == ""
            holes = (
                2.0
                * quad(lambda y, r=layer.radius: 2.0 * r * math.sqrt(max(0.0, 16.0 - y * y)) / math.sqrt(r * r - y * y), -4, 4)[
                    0
                ]
            )
            assert layer.area == pytest.approx(2.0 * math.pi * layer.radius * 40.0 - holes, rel=1e-8)
