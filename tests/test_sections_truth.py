"""Sections against closed forms, by both engines; the formulas stand beside the parts in fixtures/."""

from __future__ import annotations

import math

import numpy as np
import pytest

import brep_slicer as bs
from brep_slicer.curves import CurveKind
from brep_slicer.substrate.axis import axis_from_text

bodies = pytest.importorskip("fixtures.bodies", reason="the parametric fixtures need build123d")
blades = pytest.importorskip("fixtures.blades")
gears = pytest.importorskip("fixtures.gears")

Z = axis_from_text("Z")


def cut(solid, radii, engine="analytic"):
    layers = bs.slice_part(solid, list(radii), axis=Z, engine=engine)
    assert not any(layer.failed for layer in layers), [layer.reason for layer in layers if layer.failed]
    return layers


def kinds(layer) -> set[str]:
    return {curve.kind.value for loop in layer.region.loops for curve in loop.curves}


CASES = {
    "tube, ring 2 pi R h": (bodies.tube, lambda r: 2 * math.pi * r * 40.0, (30.0, 33.0, 41.7, 49.999)),
    "cylinder": (bodies.cylinder, lambda r: 2 * math.pi * r * 10.0, (1e-3, 5.0, 9.9)),
    "eccentric disc": (bodies.EccentricDisc().solid, bodies.EccentricDisc().area, (18.001, 25.0, 41.99)),
    "radial hole": (bodies.DrilledTube().solid, bodies.DrilledTube().area, (30.0, 37.0, 49.9)),
    "box on a shaft, 2R asin(w/2R)": (bodies.BoxOnShaft().solid, bodies.BoxOnShaft().area, (50.0, 61.0, 79.9)),
    "keyway": (bodies.KeyedBand().solid, bodies.KeyedBand().area, (40.0, 47.0, 59.9)),
    "cam": (bodies.Cam().solid, bodies.Cam().area, (40.0, 40.001, 45.0, 56.9)),
    "oblique plane": (bodies.ObliqueTube().solid, bodies.ObliqueTube().area, (30.0, 44.0)),
    "propeller blade": (blades.Blade().solid, blades.Blade().area, (45.0, 80.0, 149.9)),
    "wind blade": (blades.WIND_BLADE.solid, blades.WIND_BLADE.area, (100.0, 250.0, 399.0)),
    "spur tooth": (lambda: gears.tooth_on_shaft(gears.SPUR_TOOTH), gears.SPUR_TOOTH.area, (150.0, 160.0, 193.0)),
    "helical tooth": (lambda: gears.tooth_on_shaft(gears.HELICAL_TOOTH), gears.HELICAL_TOOTH.area, (150.0, 160.0, 183.0)),
    "helical tooth alone": (lambda: gears.tooth_alone(gears.HELICAL_TOOTH), gears.HELICAL_TOOTH.area, (150.0, 170.0)),
    "spur gear": (lambda: gears.gear(gears.SPUR_GEAR), lambda r: 20 * gears.SPUR_GEAR.area(r), (87.5, 93.0, 109.0)),
    "helical gear": (lambda: gears.gear(gears.HELICAL_GEAR), lambda r: 20 * gears.HELICAL_GEAR.area(r), (87.5, 100.0, 109.9)),
}


@pytest.mark.parametrize(("make", "area", "radii"), CASES.values(), ids=CASES)
def test_area_is_the_closed_form(make, area, radii):
    for layer in cut(make(), radii):
        assert layer.certificate.engine is bs.Engine.ANALYTIC, layer.certificate.fallback
        # the drilled tube's innermost edge is OCCT's own intersection curve, 5e-8 mm off; all else is exact
        assert layer.area == pytest.approx(area(layer.radius), rel=1e-10 + 4.0 * layer.certificate.residual)


@pytest.mark.parametrize(
    ("make", "area", "radii"),
    [CASES[k] for k in ("tube, ring 2 pi R h", "eccentric disc", "radial hole", "keyway", "helical tooth")],
)
def test_the_boolean_engine_agrees_away_from_coincidence(make, area, radii):
    radius = 0.5 * (radii[0] + radii[-1])
    (layer,) = cut(make(), [radius], engine="boolean")
    assert layer.certificate.engine is bs.Engine.BOOLEAN
    assert layer.area == pytest.approx(area(radius), rel=1e-6)


def test_a_radius_outside_of_the_part_is_an_empty_layer():
    (layer,) = cut(bodies.tube(), [60.0])
    assert layer.region.is_empty
    assert layer.area == 0.0


def test_the_tip_land_is_no_layer_and_the_foot_is():
    # the one-sided limit from outside: at R the footprint, at R_max nothing
    layers = cut(gears.tooth_alone(gears.SPUR_TOOTH), [150.0, gears.SPUR_TOOTH.tip_radius])
    assert layers[0].area == pytest.approx(gears.SPUR_TOOTH.area(150.0), rel=1e-12)
    assert layers[0].certificate.coincident
    assert layers[1].area == 0.0


def test_involute_tooth_thickness():
    # s(r) = 2 r [(pi/2 + 2 x tan alpha)/z + inv alpha - inv alpha_r]
    tooth = gears.SPUR_TOOTH
    for layer in cut(gears.tooth_on_shaft(tooth), [165.0, 170.0, 190.0]):
        k0, _, k1, _ = layer.region.pieces[0].bounds()
        alpha_r = math.acos(tooth.base_radius / layer.radius)
        inv = [math.tan(a) - a for a in (tooth.alpha, alpha_r)]
        assert k1 - k0 == pytest.approx(2 * layer.radius * (math.pi / 2 / tooth.teeth + inv[0] - inv[1]), abs=1e-9)


def test_spur_flanks_are_rulings():
    (layer,) = cut(gears.tooth_on_shaft(gears.SPUR_TOOTH), [170.0])
    assert kinds(layer) == {"line"}


def test_helical_flanks_are_straight_with_the_lead_of_the_helix():
    # dkappa/dv = 2 pi r / p_z
    tooth = gears.HELICAL_TOOTH
    for layer in cut(gears.tooth_on_shaft(tooth), [155.0, 170.0, 183.0]):
        slopes = []
        for curve in layer.region.loops[0].curves:
            along = curve.end - curve.start
            assert curve.kind is CurveKind.LINE
            if abs(along[1]) > 1.0:
                slopes.append(along[0] / along[1])
        assert slopes == pytest.approx([2 * math.pi * layer.radius / tooth.lead] * 2, abs=1e-11)


def test_an_oblique_plane_gives_a_sinusoid():
    # v = (c - a R cos(kappa/R) - b R sin(kappa/R)) / n; here z = height + slope x
    body = bodies.ObliqueTube()
    (layer,) = cut(body.solid(), [44.0])
    (curve,) = [c for loop in layer.region.loops for c in loop.curves if c.kind is CurveKind.SINUSOID]
    assert curve.coefficients == pytest.approx([body.height, body.slope * 44.0, 0.0], abs=1e-10)


def test_the_outline_of_a_box_is_at_its_angle():
    (layer,) = cut(bodies.BoxOnShaft().solid(), [60.0])
    k0, v0, k1, v1 = layer.region.pieces[0].bounds()
    half = 60.0 * math.asin(20.0 / 60.0)
    assert [k0, v0, k1, v1] == pytest.approx([-half, 0.0, half, 30.0], abs=1e-10)


def test_a_propeller_is_cut_solid_by_solid():
    part = bs.as_part(blades.propeller())
    blade = blades.Blade()
    layers = bs.slice_part(part, [47.0, 60.0, 120.0], axis=Z, substrate_solids=[0])
    # inside of the hub nothing of the blades is left, outside of it three whole sections are
    assert layers[0].area == 0.0
    assert [layer.area for layer in layers[1:]] == pytest.approx([3 * blade.area(60.0), 3 * blade.area(120.0)], rel=1e-11)
    together = bs.slice_part(part, [47.0], axis=Z)
    assert together[0].area == pytest.approx(2 * math.pi * 47.0 * 80.0, rel=1e-9)


def test_real_spur_gear_thickness(real_step):
    # manifest: tooth thickness of gear_spur_m5z10_f360 at r = 29 and r = 27, DIN 3960
    part = bs.read_step(real_step("gear_spur_m5z10_f360.step"))
    for layer, expected in zip(bs.slice_part(part, [27.0, 29.0]), (6.5290, 4.3333), strict=True):
        widths = [p.bounds()[2] - p.bounds()[0] for p in layer.region.pieces]
        assert len(widths) == 10
        assert np.allclose(widths, expected, atol=1e-4)
