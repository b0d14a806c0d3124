"""One bound on an outline's error, what it is held to, and who is cut again beside an outline that was moved."""

from __future__ import annotations

from dataclasses import replace

import build123d as bd
import numpy as np
import pytest

import brep_slicer as bs
from brep_slicer.errors import LayerError
from brep_slicer.layers import Motion, cylinder
from brep_slicer.notices import NoticeKind
from brep_slicer.planning.warnings import notices_of_sections
from brep_slicer.region import Layer, region_from_loops, slicing
from brep_slicer.section import Certificate, Engine, boolean, cut_solids, engines
from brep_slicer.section.boolean import section_by_boolean
from brep_slicer.section.certificate import check_error
from brep_slicer.substrate.axis import axis_from_line

from .test_fill import R, rectangle

Z = axis_from_line((0, 0, 0), (0, 0, 1))


@pytest.mark.parametrize(("residual", "gap"), [(1e-12, 0.038), (0.215, 0.157), (5e-6, 0.0), (0.0, 1e-3)])
def test_a_gap_does_not_hide_behind_a_small_residual(residual, gap):
    certificate = Certificate(engine=Engine.ANALYTIC, residual=residual, jog=gap)
    assert certificate.bound == pytest.approx(residual + gap, rel=1e-15)
    assert certificate.as_dict()["outline_error_mm"] == certificate.bound


def loops_of_shaft(radius):
    """A box on a shaft, its section at `radius`, and the solid."""
    shape = bd.Box(80.0, 20.0, 30.0)
    (solid,) = cut_solids(bs.as_part(shape), Z)
    return solid, section_by_boolean(solid.wrapped, radius, critical=solid.critical.radii)


@pytest.mark.parametrize(
    ("residual", "gap", "strip"), [(15.0, 0.0, 0.0), (177.0, 0.0, 0.0), (0.06, 0.05, 0.0), (0.0, 0.0, 0.2)]
)
class TestTheLimit:
    def test_an_outline_of_which_too_little_is_known_is_none(self, residual, gap, strip):
        certificate = Certificate(engine=Engine.BOOLEAN, residual=residual, jog=gap, contradiction=strip)
        assert certificate.bound == pytest.approx(residual + gap + strip, rel=1e-15)
        with pytest.raises(LayerError, match="may be off by"):
            check_error(certificate, 20.0)
        check_error(replace(certificate, residual=0.05, jog=0.02, contradiction=0.02), 20.0)

    def test_it_fails_the_layer_if_nobody_knows_better(self, residual, gap, strip, monkeypatch):
        solid, (loops, certificate) = loops_of_shaft(20.0)
        worse = replace(certificate, residual=residual, jog=gap, contradiction=strip)
        monkeypatch.setattr(engines, "sections_by_analysis", lambda s, radii: [LayerError("made to fail")] * np.size(radii))
        monkeypatch.setattr(engines, "section_by_boolean", lambda *args, **kwargs: (loops, worse))
        found = engines.SolidSections(solid, [20.0], Engine.ANALYTIC).section(0)
        assert isinstance(found, LayerError)
        assert "may be off by" in str(found)
        assert "made to fail" in str(found)

    def test_it_holds_for_the_analytic_engine_too(self, residual, gap, strip, monkeypatch):
        solid, (loops, certificate) = loops_of_shaft(20.0)
        worse = replace(certificate, engine=Engine.ANALYTIC, residual=residual, jog=gap, contradiction=strip)
        monkeypatch.setattr(engines, "sections_by_analysis", lambda s, radii: [(loops, worse)] * np.size(radii))
        _, found = engines.SolidSections(solid, [20.0], Engine.ANALYTIC).section(0)
        assert found.engine is Engine.BOOLEAN
        assert "may be off by" in found.fallback


@pytest.mark.parametrize("gap", [0.002, 0.024, 0.075, 0.157])
def test_a_gap_that_is_not_in_the_file_is_no_excuse(gap, monkeypatch):
    solid, _ = loops_of_shaft(20.0)
    chained = boolean.loops_from_arcs

    aside = Motion(1.0, 0.0, gap, 0.0)

    def gaping(sheet, arcs):
        return [replace(loop, curves=(loop.curves[0].moved(aside), *loop.curves[1:])) for loop in chained(sheet, arcs)]

    monkeypatch.setattr(boolean, "loops_from_arcs", gaping)
    with pytest.raises(LayerError, match="gapes by"):
        section_by_boolean(solid.wrapped, 20.0, critical=solid.critical.radii)
    # in a file whose edges gape that much it is known, and said
    _, certificate = section_by_boolean(solid.wrapped, 20.0, critical=solid.critical.radii, gap=gap)
    assert certificate.bound >= certificate.jog >= 0.99 * gap


@pytest.mark.parametrize("share", [0.1, 0.5, 0.9])
def test_areas_that_contradict_one_another_are_a_strip_along_the_outline(share, monkeypatch):
    from brep_slicer.kernel import booleans

    solid, (loops, before) = loops_of_shaft(20.0)
    length = sum(loop.length() for loop in loops)
    more = share * before.residual * length
    common = booleans.common_with_cylinder

    def larger(*args, turn, **kwargs):
        found = common(*args, turn=turn, **kwargs)
        return replace(found, area=found.area + 0.5 * more) if turn < 4.0 else found

    monkeypatch.setattr(booleans, "common_with_cylinder", larger)
    _, certificate = section_by_boolean(solid.wrapped, 20.0, critical=solid.critical.radii)
    assert certificate.contradiction == pytest.approx(more / length, rel=1e-3)
    assert certificate.bound == pytest.approx(certificate.residual + certificate.jog + more / length, rel=1e-6)


@pytest.mark.parametrize("offset", [0.01, 0.3, 5.0])
def test_another_critical_radius_beyond_the_step_leaves_a_bound(offset):
    # a disc beside the axis, cut 1e-5 mm outside of where it touches the cylinder, opens by 2 moved; the outline's extent, 10
    # mm and more, was stated
    disc = bd.Pos(offset, 0, 0) * bd.Cylinder(21.0, 10.0)
    (solid,) = cut_solids(bs.as_part(disc), Z)
    radius = 21.0 - offset
    loops, certificate = section_by_boolean(solid.wrapped, radius, critical=np.array([radius, radius + 2e-5]))
    used = radius + 1e-5
    moved = radius * (np.pi - np.arccos((used**2 + offset**2 - 21.0**2) / (2.0 * used * offset)))
    assert sum(loop.signed_area() for loop in loops) == pytest.approx(10.0 * (2.0 * np.pi * radius - 2.0 * moved), rel=1e-6)
    assert 0.999 * moved < certificate.residual < 1.1 * moved
    with pytest.raises(LayerError, match="cannot be told"):  # no room for a second cut
        section_by_boolean(solid.wrapped, radius, critical=np.array([radius, radius + 1.2e-5]))


def section(x, width, residual=0.0, reason=""):
    certificate = Certificate(engine=Engine.BOOLEAN, residual=residual, fallback=reason)
    return region_from_loops(cylinder(R), [rectangle(x, 0.0, x + width, 10.0)]), certificate


class TestNeighboursOfAStep:
    """Who is cut again where a solid was cut beside its radius: those whose outlines meet its own, and so on."""

    @pytest.mark.parametrize(
        ("others", "again"),
        [
            ({1: (20.0, 5.0), 2: (40.0, 5.0)}, []),
            ({1: (5.0, 5.0), 2: (40.0, 5.0)}, [0, 1]),
            ({1: (5.0, 5.0), 2: (10.0, 5.0), 3: (20.0, 5.0)}, [0, 1, 2]),
            ({1: (2.0 * np.pi * R - 5.0, 5.0), 2: (40.0, 5.0)}, [0, 1]),
        ],
    )
    def test_it_is_those_that_it_meets(self, others, again):
        sections = {0: section(0.0, 5.0, 1e-3, "stepped")} | {n: section(*place) for n, place in others.items()}
        assert slicing._meeting_stepped(sections) == again

    def test_nobody_where_none_was_moved(self):
        assert slicing._meeting_stepped({0: section(0.0, 5.0), 1: section(5.0, 5.0)}, [0, 1]) == []

    def test_and_those_that_begin_there(self):
        # of two halves of a ring one may be empty at the radius, and fill what the other one opens by a step farther out
        sections = {0: section(0.0, 5.0, 1e-3, "stepped"), 1: section(20.0, 5.0), 2: section(40.0, 5.0)}
        assert slicing._meeting_stepped(sections, [2]) == [0, 2]

    def test_a_surface_integral_is_computed_once(self, monkeypatch):
        calls = []
        exact, ramps = engines.area_and_turnover, engines.flux_ramps
        monkeypatch.setattr(engines, "area_and_turnover", lambda *args, **more: calls.append("exact") or exact(*args, **more))
        monkeypatch.setattr(engines, "flux_ramps", lambda *args, **more: calls.append("quick") or ramps(*args, **more))
        monkeypatch.setattr(engines, "sections_by_analysis", lambda s, radii: [LayerError("made to fail")] * np.size(radii))
        solid, _ = loops_of_shaft(20.0)
        sections = engines.SolidSections(solid, [20.0, 21.0], Engine.ANALYTIC)
        areas = [sum(loop.signed_area() for loop in found.section(0)[0]) for found in (sections, sections.beside(20.0))]
        assert areas[0] == pytest.approx(areas[1], rel=1e-12)
        assert calls == ["quick", "exact"]


@pytest.mark.parametrize(
    ("chord", "bound", "warned"), [(None, 9e-4, 0), (None, 1.1e-3, 1), (0.05, 1.1e-3, 0), (0.05, 0.0051, 1)]
)
def test_what_exceeds_a_tenth_of_the_chord_is_warned_of(chord, bound, warned):
    region, certificate = section(0.0, 5.0, bound)
    layer = Layer(index=3, level=R, cut_level=R, thickness=1.4, region=region, area=region.area, certificate=certificate)
    process = bs.Process(layer_thickness=1.4, step_over=3.4, motion=bs.Motion(chord=chord))
    found = [n for n in notices_of_sections([layer], [], process) if n.kind is NoticeKind.OUTLINE]
    assert len(found) == warned
    for notice in found:
        assert notice.layers == (3,)
        assert notice.figures["error_mm"] == (certificate.bound, certificate.bound)
