"""Where the two engines disagree, and who is right (tests/figures/engines.py finds them: 50 radii on every solid)."""

from __future__ import annotations

import build123d as bd
import numpy as np
import pytest

import brep_slicer as bs
from brep_slicer.errors import LayerError
from brep_slicer.section import cut_solids
from brep_slicer.section.analytic import sections_by_analysis
from brep_slicer.section.boolean import COINCIDENCE_STEP, clear_radius, section_by_boolean
from brep_slicer.substrate.axis import axis_from_line
from brep_slicer.testing import area_by_flux


def both(solid, radius):
    """(area by analysis, area by boolean or None where it refuses)."""
    ((loops, _),) = sections_by_analysis(solid, np.array([radius]))
    try:
        other, _ = section_by_boolean(solid.wrapped, radius, critical=solid.critical.radii)
    except LayerError:
        return sum(loop.signed_area() for loop in loops), None
    return tuple(sum(loop.signed_area() for loop in some) for some in (loops, other))


@pytest.mark.slow
@pytest.mark.parametrize("radius", [2.5060474, 2.587159, 2.64992181, 2.65506367, 2.8451993, 2.86932107])
def test_a_thread_whose_half_turns_occt_gets_wrong(radius, real_step):
    # OCP 8.0.1.1: half-turns of 97 to 128 mm2 where the outline has 86 to 136; the boolean engine sees it and refuses
    part = bs.read_step(real_step("screw_m6_thread_build123d.step"))
    (solid,) = cut_solids(part, bs.find_axis(part))
    analytic, boolean = both(solid, radius)
    assert analytic == pytest.approx(area_by_flux(solid.brep, radius), rel=1e-6)
    assert boolean is None or boolean == pytest.approx(analytic, rel=1e-6)


@pytest.mark.slow
def test_just_above_the_lowest_point_of_an_edge(real_step):
    """A loop of 69 mm was lost without a word: its arc was taken for the short cap on the surface beyond the face's edge."""
    part = bs.read_step(real_step("propeller_3blade_hub_openaxis.step"))
    solid = cut_solids(part, bs.find_axis(part))[1]
    lowest = solid.critical.radii[np.abs(solid.critical.radii - 90.9960921).argmin()]
    radii = lowest + np.array([0.0, 1e-9, 1e-7, 1e-5])
    areas = [sum(loop.signed_area() for loop in section[0]) for section in sections_by_analysis(solid, radii)]
    assert areas == pytest.approx([295.67] * 4, abs=1.0)
    assert area_by_flux(solid.brep, float(radii[2])) == pytest.approx(295.67, abs=1.0)


def test_a_sliver_thinner_than_what_its_edges_gape(real_step):
    # OCP 8.0.1.1: 8.79418e-07 and 8.79408e-07 mm2; the file's own faces say 8.786e-07: neither is wrong by more than the gaps
    part = bs.read_step(real_step("impeller_radial_turbo3d.step"))
    solid = cut_solids(part, bs.find_axis(part))[2]
    analytic, boolean = both(solid, 66.0324618)
    assert boolean == pytest.approx(analytic, rel=2e-5)
    assert area_by_flux(solid.brep, 66.0324618) == pytest.approx(analytic, rel=2e-3)


@pytest.mark.parametrize("name", ["box_on_shaft", "cam", "oblique_tube", "drilled_tube", "helical_gear_tooth", "wind_blade"])
def test_they_agree_on_fixtures(name, fixture_step):
    (solid,) = cut_solids(bs.read_step(fixture_step(name)), bs.axis_from_text("Z"))
    low, high = solid.critical.lowest, solid.critical.highest
    for radius in np.random.default_rng(5).uniform(low, high, 4):
        analytic, boolean = both(solid, float(radius))
        assert boolean == pytest.approx(analytic, rel=1e-8)


@pytest.mark.slow
def test_a_lobe_that_the_boolean_leaves_out_is_not_believed(real_step):
    # OCP 8.0.1.1: 40.04 mm2, and its half-turns agree; 57.66 by the surface integral, 57.78 by analysis 1e-4 mm farther in
    part = bs.read_step(real_step("propeller_6land_D_5axisslicer.step"))
    (layer,) = bs.slice_part(part, [35.0045786])
    assert layer.failed or layer.area == pytest.approx(57.6611, rel=5e-3)


@pytest.mark.parametrize("offset", [0.01, 0.3, 5.0])
def test_a_step_outwards_says_how_far_it_moves_the_outline(offset):
    # a disc beside the axis: on the cylinder that touches it from inside the band is whole, a step farther out it is open by
    # 2 R phi, far more than sqrt(2 R step) where the disc is curved nearly like the cylinder
    disc = bd.Pos(offset, 0, 0) * bd.Cylinder(21.0, 10.0)
    (solid,) = cut_solids(bs.as_part(disc), axis_from_line((0, 0, 0), (0, 0, 1)))
    radius = 21.0 - offset
    loops, certificate = section_by_boolean(solid.wrapped, radius, critical=solid.critical.radii)
    used = radius + COINCIDENCE_STEP
    moved = radius * (np.pi - np.arccos((used**2 + offset**2 - 21.0**2) / (2.0 * used * offset)))
    assert certificate.coincident
    assert sum(loop.signed_area() for loop in loops) == pytest.approx(10.0 * (2.0 * np.pi * radius - 2.0 * moved), rel=1e-6)
    assert 0.999 * moved < certificate.residual < 1.1 * moved


def test_the_boolean_steps_aside_within_its_gap_between_critical_radii():
    critical, step = np.array([10.0, 10.00003, 12.0, 12.000003]), COINCIDENCE_STEP
    assert clear_radius(11.0, critical) == 11.0
    assert clear_radius(10.0, critical) == pytest.approx(10.0 + step, abs=1e-12)
    assert clear_radius(10.00002999, critical) == pytest.approx(
        10.00002, abs=1e-12
    )  # inwards: beyond it the section is another
    assert clear_radius(12.0, critical) == pytest.approx(12.000013, abs=1e-12)  # no room in between
    with pytest.raises(LayerError, match="too close together"):
        clear_radius(5.0, np.linspace(4.999, 5.001, 2001))
