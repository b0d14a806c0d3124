"""The volume identity: the section areas add up to the volume, for any solid."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import brep_slicer as bs
from brep_slicer.kernel.shapes import volume_of
from brep_slicer.section import Engine, cut_solids
from brep_slicer.substrate.axis import axis_from_text
from brep_slicer.testing import closure_of, integrate_sections

NAMES = [
    "box_on_shaft",
    "cam",
    "cylinder",
    "drilled_tube",
    "eccentric_disc",
    "helical_gear_tooth",
    "keyed_band",
    "oblique_tube",
    "propeller",
    "spur_gear_tooth",
    "tube",
    "wind_blade",
]
Z = axis_from_text("Z")


@pytest.mark.parametrize("name", NAMES)
def test_fixtures(name, fixture_step):
    for solid in cut_solids(bs.read_step(fixture_step(name)), Z):
        found = integrate_sections(solid)
        assert found.volume == pytest.approx(volume_of(solid.wrapped), rel=1e-9)
        assert found.by_boolean == 0
        assert found.volume_error <= 1e-9 * found.volume


@pytest.mark.slow
@pytest.mark.parametrize("name", ["spur_gear", "helical_gear"])
def test_whole_gears(name, fixture_step):
    (solid,) = cut_solids(bs.read_step(fixture_step(name)), Z)
    found = integrate_sections(solid)
    assert found.volume == pytest.approx(volume_of(solid.wrapped), rel=1e-9)
    assert found.by_boolean == 0


@pytest.mark.parametrize("name", ["tube", "eccentric_disc"])
def test_first_moment_along_z(name, fixture_step):
    (solid,) = cut_solids(bs.read_step(fixture_step(name)), Z)
    found = integrate_sections(solid)
    heights = {"tube": 40.0, "eccentric_disc": 20.0}
    assert found.moment == pytest.approx(0.5 * heights[name] * found.volume, rel=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["tube", "eccentric_disc", "keyed_band"])
def test_the_boolean_engine_too(name, fixture_step):
    (solid,) = cut_solids(bs.read_step(fixture_step(name)), Z)
    found = integrate_sections(solid, engine=Engine.BOOLEAN, relative=1e-7)
    assert found.volume == pytest.approx(volume_of(solid.wrapped), rel=1e-6)


# every solid of these keeps the identity to 1e-7, or to what its file's own faces fail to close by (figures/identity.py)
REAL = [
    "assembly_as1_bspline_cyl_caxif.stp",
    "auger_corkscrew_bspline_sse.step",
    "cone_cyl_inch_occtimport.step",
    "cyl_single_face_sse.step",
    "gear_helical_z9_asu.step",
    "gear_spur_m5z10_f360.step",
    "impeller_radial_turbo3d.step",
    "propeller_6land_D_5axisslicer.step",
    "pulley_72t_open5x.step",
    "rotor_16t_shaft_brepnet.stp",
    "screw_m6_thread_build123d.step",
    "shaft_stepped_jack.stp",
]


@pytest.mark.slow
@pytest.mark.parametrize("name", REAL)
def test_real_parts(name, real_step):
    keeps_the_identity(bs.read_step(real_step(name)))


@pytest.mark.long
def test_blades_that_gape(real_step):
    # minutes a blade: a quarter of the sections near its noisy root and tip goes to the boolean engine
    keeps_the_identity(bs.read_step(real_step("propeller_3blade_hub_openaxis.step")))


def keeps_the_identity(part):
    for solid in cut_solids(part, bs.find_axis(part)):
        found, closure = integrate_sections(solid, relative=1e-8), closure_of(solid.brep)
        bound = max(1e-7, closure.defect)
        assert found.volume == pytest.approx(closure.volume, rel=bound)
        assert found.volume_error <= bound * found.volume
        farthest = float(np.abs(solid.brep.vertices[:, 2]).max()) * closure.volume
        assert found.moment == pytest.approx(closure.moment, abs=bound * farthest)


@pytest.mark.parametrize("name", NAMES)
def test_fixtures_close(name, fixture_step):
    for solid in cut_solids(bs.read_step(fixture_step(name)), Z):
        closure = closure_of(solid.brep)
        assert closure.defect <= 1e-7
        assert closure.volume == pytest.approx(volume_of(solid.wrapped), rel=max(1e-9, closure.defect))


def test_a_missing_face_shows_in_the_closure(fixture_step):
    (solid,) = cut_solids(bs.read_step(fixture_step("tube")), Z)
    whole = closure_of(solid.brep)
    open_brep = dataclasses.replace(solid.brep, faces=solid.brep.faces[:-1])
    assert whole.defect < 1e-8
    assert closure_of(open_brep).defect > 0.1


def test_critical_radii_of_a_cam(fixture_step):
    (solid,) = cut_solids(bs.read_step(fixture_step("cam")), Z)
    # bore, base circle, where the flanks meet the nose, tip
    corner = np.hypot(45.0 + 12.0 * (28.0 / 45.0), 12.0 * np.sqrt(1 - (28.0 / 45.0) ** 2))
    assert np.allclose(solid.critical.radii, [20.0, 40.0, corner, 57.0], atol=1e-9)
