"""Sections against the surface integral A(R) = R * integral of (n . e_rho) / rho dS, which cuts nothing."""

from __future__ import annotations

import build123d as bd
import numpy as np
import pytest

import brep_slicer as bs
from brep_slicer.errors import LayerError
from brep_slicer.section import cut_solids, trimmed
from brep_slicer.section.analytic import sections_by_analysis
from brep_slicer.substrate.axis import axis_from_line
from brep_slicer.testing import area_by_flux, areas_by_flux

Z = bs.axis_from_text("Z")
# relative: what the oracle's own quadrature is good for on each fixture (kinks that its panels do not know of)
FIXTURES = {
    "tube": 1e-12,
    "eccentric_disc": 1e-8,
    "cam": 1e-8,
    "keyed_band": 1e-7,
    "box_on_shaft": 1e-7,
    "oblique_tube": 1e-7,
    "drilled_tube": 1e-6,
    "spur_gear_tooth": 1e-8,
    "helical_gear_tooth": 1e-8,
    "wind_blade": 1e-5,
    "propeller": 1e-6,
}
# the closure defect of the files (gaps of up to 0.01 mm between faces) where it is larger
REAL = {
    "gear_spur_m5z10_f360.step": 1e-5,
    "gear_helical_z9_asu.step": 1e-3,
    "screw_m6_thread_build123d.step": 2e-5,
    "shaft_stepped_jack.stp": 1e-6,
    "auger_corkscrew_bspline_sse.step": 1e-4,
    "rotor_16t_shaft_brepnet.stp": 1e-6,
    "propeller_6land_D_5axisslicer.step": 2e-3,
}


def compare(solid, relative, count):
    radii = np.sort(np.random.default_rng(3).uniform(solid.critical.lowest, solid.critical.highest, count))
    tried = 0
    for section, radius in zip(sections_by_analysis(solid, radii), radii, strict=True):
        if isinstance(section, LayerError):
            continue
        area = sum(loop.signed_area() for loop in section[0])
        scale = max(area, 1e-3 * 2.0 * np.pi * radius * np.ptp(solid.brep.vertices[:, 2]))
        assert area == pytest.approx(area_by_flux(solid.brep, radius), abs=relative * scale)
        tried += 1
    assert tried >= count - 1


@pytest.mark.parametrize(("name", "relative"), FIXTURES.items())
def test_fixtures(name, relative, fixture_step):
    for solid in cut_solids(bs.read_step(fixture_step(name)), Z):
        compare(solid, relative, 4)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "relative"), REAL.items())
def test_real_parts(name, relative, real_step):
    part = bs.read_step(real_step(name))
    (solid,) = cut_solids(part, bs.find_axis(part))
    compare(solid, relative, 3)


@pytest.mark.parametrize("length", [30.0, 100.0, 300.0])
def test_the_surface_integral_on_slender_faces(length):
    # a bar square to the axis: below half its width the section is a whole band, and 1 / rho peaks in the middle of long faces
    (solid,) = cut_solids(bs.as_part(bd.Box(length, 8.0, 8.0)), axis_from_line((0, 0, 0), (0, 0, 1)))
    for radius, truth in ((3.9, 2.0 * np.pi * 3.9 * 8.0), (10.0, 8.0 * 10.0 * 4.0 * np.arcsin(0.4))):
        for panels in (6, 9, 12):
            assert area_by_flux(solid.brep, radius, panels=panels) == pytest.approx(truth, rel=1e-4)


@pytest.mark.parametrize("name", ["helical_gear_tooth", "propeller", "drilled_tube", "wind_blade"])
def test_the_quick_integral_takes_bounded_memory(name, fixture_step, monkeypatch):
    most = 4000
    monkeypatch.setattr(trimmed, "MOST_CELLS", most)
    monkeypatch.setattr(trimmed, "MOST_LINES", 60)
    for solid in cut_solids(bs.read_step(fixture_step(name)), Z):
        for face in solid.brep.faces:
            stretches = len(trimmed.surface_cells(face, lines=64, cells=1)[0]) // trimmed.LEAST_CELLS
            assert len(trimmed.surface_cells(face, lines=64, cells=64)[0]) <= max(most, trimmed.LEAST_CELLS * stretches)
        radii = np.random.default_rng(5).uniform(solid.critical.lowest, solid.critical.highest, 3)
        exact = np.array([area_by_flux(solid.brep, radius) for radius in radii])
        assert areas_by_flux(solid.brep, radii, level=solid.stretches.face_level) == pytest.approx(
            exact, abs=0.02 * exact.max()
        )
