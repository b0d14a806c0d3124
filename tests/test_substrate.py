"""The default substrate, and how layers are stacked on it."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

import brep_slicer as bs
from brep_slicer.process import CutAt, LastLayer
from brep_slicer.substrate.layers import stack_layers

Z = bs.axis_from_text("Z")


def stack(substrate, highest, **kwargs):
    return stack_layers(substrate, highest, bs.Process(step_over=1.0, **kwargs))


def test_the_paper_s_layer_counts():
    # Tables 3 and 4: t = 1.4 mm on R = 150 mm, 31 and 24 layers
    assert len(stack(150.0, 150.0 + 43.4, layer_thickness=1.4).radii) == 31
    assert len(stack(150.0, 150.0 + 33.6, layer_thickness=1.4).radii) == 24


@given(st.integers(1, 400), st.floats(0.05, 5.0), st.floats(1.0, 500.0))
def test_a_whole_multiple_is_that_many_layers(n, t, radius):
    made = stack(radius, radius + n * t, layer_thickness=t)
    assert len(made.radii) == n
    assert made.radii[-1] == pytest.approx(radius + (n - 1) * t)


def test_what_becomes_of_the_last_layer():
    kept = stack(10.0, 13.3, layer_thickness=1.0)
    assert (len(kept.radii), kept.overshoot) == (4, pytest.approx(0.7))
    assert "overshoots the part by 0.7 mm" in kept.notes[0]
    dropped = stack(10.0, 13.3, layer_thickness=1.0, last_layer=LastLayer.DROP)
    assert (len(dropped.radii), dropped.overshoot) == (3, 0.0)
    stretched = stack(10.0, 13.3, layer_thickness=1.0, last_layer=LastLayer.STRETCH)
    assert stretched.thicknesses == pytest.approx([1.1] * 3)


def test_lists_of_thicknesses_and_of_radii():
    assert stack(10.0, 13.0, layer_thickness=(0.5, 1.0)).radii == pytest.approx((10.0, 10.5, 11.5, 12.5))
    given_radii = stack(10.0, 13.0, layer_thickness=1.0, radii=(10.5, 11.0, 12.0))
    assert given_radii.thicknesses == pytest.approx((0.5, 1.0, 1.0))
    with pytest.raises(bs.InputError, match="lies outside of the part"):
        stack(10.0, 13.0, layer_thickness=1.0, radii=(12.0, 14.0))
    with pytest.raises(bs.InputError, match="lies inside of the substrate"):
        stack(10.0, 13.0, layer_thickness=1.0, radii=(9.0, 11.0))


def test_cut_at_mid_thickness_is_drawn_on_the_nominal_radius():
    bodies = pytest.importorskip("fixtures.bodies")
    body = bodies.BoxOnShaft()
    process = bs.Process(layer_thickness=2.0, step_over=3.0, cut_at=CutAt.MIDDLE)
    plan = bs.plan(body.solid(), process, axis=Z, layers=(0, 2))
    for layer in plan.layers:
        assert layer.cut_radius == pytest.approx(layer.radius + 1.0)
        assert layer.area == pytest.approx(body.area(layer.cut_radius), rel=1e-12)
        k0, _, k1, _ = layer.region.pieces[0].bounds()
        assert k1 - k0 == pytest.approx(2.0 * layer.radius * math.asin(20.0 / layer.cut_radius), rel=1e-12)


def test_too_thick_and_too_many():
    with pytest.raises(bs.InputError, match="larger than the whole height"):
        stack(10.0, 11.0, layer_thickness=5.0)
    with pytest.raises(bs.InputError, match="check its unit"):
        stack(10.0, 1000.0, layer_thickness=1e-3)


class TestDefaultSubstrate:
    def test_the_largest_shaft_with_metal_beyond(self, fixture_step):
        plan = bs.plan(
            bs.read_step(fixture_step("helical_gear_tooth")), bs.Process(layer_thickness=1.4, step_over=3.4), layers=(0, 1)
        )
        assert plan.substrate.radius == pytest.approx(150.0)
        assert "largest external coaxial cylinder" in plan.substrate.reason

    def test_else_the_largest_bore_with_a_warning(self, fixture_step):
        plan = bs.plan(bs.read_step(fixture_step("keyed_band")), bs.Process(layer_thickness=1.4, step_over=3.4), layers=(0, 1))
        assert plan.substrate.radius == pytest.approx(40.0)
        assert any("fills its bore" in w for w in plan.warnings)

    def test_else_an_error_that_asks(self, fixture_step):
        with pytest.raises(bs.PlanningError, match="give one with --substrate RADIUS"):
            bs.plan(bs.read_step(fixture_step("cylinder")), bs.Process(layer_thickness=1.0, step_over=1.0))

    def test_solids_that_stand_already(self, fixture_step):
        plan = bs.plan(bs.read_step(fixture_step("propeller")), bs.Process(layer_thickness=4.0, step_over=2.0), layers=(0, 2))
        assert plan.substrate.radius == pytest.approx(50.0)
        assert plan.substrate.solids == (0,)
        assert all(len(layer.region.pieces) == 3 for layer in plan.layers)

    def test_outside_of_the_part(self, fixture_step):
        with pytest.raises(bs.InputError, match="leaves nothing to build"):
            bs.plan(bs.read_step(fixture_step("cylinder")), bs.Process(layer_thickness=1.0, step_over=1.0), substrate=10.0)
