"""Which cylinder is built on: the one that explains the part, of shapes for which the largest one with metal on it is wrong.

Right values are argued from the drawing: what is turned stays, teeth, thread, lobes and spokes are built whole.
"""

from __future__ import annotations

import math

import pytest

import brep_slicer as bs

bd = pytest.importorskip("build123d")

from brep_slicer.inspection import inspect_part  # noqa: E402
from brep_slicer.substrate.radius import coaxial_cylinders  # noqa: E402
from tests.role_shapes import (  # noqa: E402
    bar,
    box,
    cam,
    fan,
    gear,
    ring,
    round_about,
    shouldered_crankshaft,
    splined,
    spoked_gear,
    stepped_collar,
    tube_with_lands,
    united,
    wheel,
    worm,
)


def areas(part) -> dict[float, float]:
    """mm2 of the outside cylinders by radius."""
    return {round(c.radius, 6): c.area for c in coaxial_cylinders(part, "Z") if c.external}


def chosen(part, radius: float):
    found = inspect_part(part, axis="Z")
    assert found.substrate_radius == pytest.approx(radius), found.substrate_reason
    return found


class TestThreadsAndKeys:
    """Collars touch the crest and rise from it, and it has most of the turned area: it was taken, and no thread was built."""

    @pytest.mark.parametrize(
        "make",
        [
            worm,
            lambda: worm(step_deg=-36.0),
            lambda: worm(step_deg=45.0, share=0.72),
            splined,
            lambda: splined(4, share=0.75),
        ],
        ids=["worm", "left-handed", "wide crest", "splines", "four splines"],
    )
    def test_the_root(self, make):
        part = make()
        turned = areas(part)
        # the crest is candidate, larger than the root, and the collars rise from it: no other rule than the thread forbids it
        assert turned[10.0] > turned[6.0]
        chosen(part, 6.0)

    def test_a_plan_builds_the_thread(self):
        # the crest covers 0.66 of the turn, and the collars 2 * 4 mm of height stand on it like the thread
        plan = bs.plan(worm(), bs.Process(layer_thickness=1.0, step_over=1.5), axis="Z")
        thread = [2.0 * math.pi * r * (0.66 * 24.0 + 8.0) for r in (6.0, 7.0, 8.0, 9.0)]
        assert [layer.area for layer in plan.layers][:4] == pytest.approx(thread, rel=1e-9)


class TestLandsAtOppositeEnds:
    """Two lands, each 0.8 of a turn, at opposite ends, closed round together: each by itself does not go round."""

    @pytest.mark.parametrize(
        ("options", "radius"),
        [
            ({}, 20.0),
            ({"share": 0.7}, 20.0),
            ({"radius": 15.0, "land": 22.0, "length": 240.0}, 15.0),
            ({"length": 1280.0, "radius": 46.482, "land": 65.88}, 46.482),
        ],
    )
    def test_the_tube(self, options, radius):
        found = chosen(tube_with_lands(**options), radius)
        # the runner-up is named
        assert f"the next best is R {options.get('land', 30.0):g}" in found.substrate_reason


class TestSpokedWheels:
    """The rim's bore was "the largest coaxial bore": hub and spokes were left out without a word."""

    @pytest.mark.parametrize(
        ("options", "bore"), [({}, 4.0), ({"spokes": 5}, 4.0), ({"spokes": 6, "hub": 12.0, "bore": 5.0, "height": 24.0}, 5.0)]
    )
    def test_the_hub_s_bore(self, options, bore):
        found = chosen(wheel(**options), bore)
        # 40 < R < 45, 12 mm wide, against hub and spokes: about half of the wheel
        assert "the next best is the bore R 40, which leaves 5" in found.substrate_reason
        assert any("fills its bore" in warning for warning in found.warnings)

    def test_a_hub_with_a_land(self):
        hub = united(bar(10.0, -20.0, 20.0), ring(40.0, 45.0, -6.0, 6.0), box((-41.0, -3.0, -3.0), (41.0, 3.0, 3.0)))
        chosen(hub, 10.0)


class TestCams:
    """A boss beside the lobe, between base circle and nose: what of the lobe lies inside of it was left out."""

    @pytest.mark.parametrize("options", [{}, {"lobes": 2}, {"nose": 34.0, "boss": 26.0}])
    def test_the_base_circle(self, options):
        found = chosen(cam(**options), 20.0)
        assert f"the next best is R {options.get('boss', 24.0):g}" in found.substrate_reason

    def test_a_lower_boss_changes_nothing(self):
        chosen(cam(boss=12.0), 20.0)


class TestFans:
    """A frame on a thin ring that hangs on struts: it was built on the ring, hub and blades were left out without a word."""

    @pytest.mark.parametrize(
        ("options", "hub", "ring_at"),
        [
            ({}, 12.0, 39.0),
            ({"hub": 15.0, "inner": 50.0, "wall": 1.5, "blades": 9, "struts": 3, "frame": "ears"}, 15.0, 51.5),
            ({"hub": 10.0, "inner": 30.0, "blades": 5, "struts": 5, "frame": "flat"}, 10.0, 31.0),
            ({"wall": 0.8, "blades": 5, "struts": 3}, 12.0, 38.8),
        ],
        ids=["square frame", "ears", "flange with a flat", "few blades"],
    )
    def test_the_hub_that_blades_and_struts_stand_on(self, options, hub, ring_at):
        found = chosen(fan(**options), hub)
        assert f"the next best is R {ring_at:g}, which leaves" in found.substrate_reason

    @pytest.mark.parametrize(
        "options",
        [{}, {"rim": 30.0, "wall": 3.0, "spokes": 3, "teeth": 24, "hub": 8.0}, {"rim": 60.0, "wall": 8.0, "spokes": 6}],
    )
    def test_but_the_rim_of_a_spoked_gear(self, options):
        # its wall, a tenth of its radius and more, carries the teeth
        found = chosen(spoked_gear(**options), options.get("rim", 40.0))
        assert not any("left out" in w for w in found.warnings)

    @pytest.mark.parametrize(("blades", "length"), [(7, 20.0), (9, 16.0), (6, 24.0)])
    def test_blades_that_end_within_a_rim_that_carries(self, blades, length):
        # spokes carry the rim and are no feature; blades beside them end in the air, and would be lost on the rim
        blade = box((8.0, -1.0, 6.0), (33.0, 1.0, 6.0 + length))
        body = united(spoked_gear(), bar(10.0, 5.0, 30.0), ring(34.0, 40.0, 4.0, 30.0), *round_about(blade, blades))
        chosen(body - bar(4.0, -20.0, 40.0), 10.0)


class TestStepsOfAShaft:
    @pytest.mark.parametrize(
        ("options", "radius"),
        [
            ({}, 1.5),
            ({"radius": 10.0, "steps": (13.0, 16.0, 20.0), "widths": (12.0, 8.0, 6.0), "length": 120.0, "low": 30.0}, 10.0),
            ({"radius": 6.0, "steps": (9.0, 14.0), "widths": (6.0, 3.0), "length": 60.0, "low": 20.0}, 6.0),
        ],
    )
    def test_the_shaft_not_a_collar_that_another_stands_on(self, options, radius):
        chosen(stepped_collar(**options), radius)

    def test_a_gear_s_root_beside_a_long_axle_stays(self):
        # teeth stand amid the root's land: no step of the shaft, however long that is
        long_axle = united(gear(), bar(5.0, -120.0, 120.0))
        assert areas(long_axle)[5.0] > 5.0 * areas(long_axle)[12.0]
        chosen(long_axle, 12.0)

    @pytest.mark.parametrize(("journal", "shoulder", "throw"), [(24.0, 31.0, 33.0), (22.0, 29.0, 31.0), (25.0, 33.0, 34.0)])
    def test_journals_not_the_shoulders_beside_the_webs(self, journal, shoulder, throw):
        # what the shoulder leaves out is told of (2 %), the journal leaves less than half of that, and is several times larger
        shape = shouldered_crankshaft(journal=journal, shoulder=shoulder, width=14.0, throw=throw)
        assert areas(shape)[journal] > 2.0 * areas(shape)[shoulder]
        chosen(shape, journal)


class TestLeftOut:
    """What is not built is always said, in mm3 and per cent, and warned of from 2 % on."""

    def test_said_where_there_is_nothing(self):
        found = chosen(gear(), 12.0)
        assert found.left_out.startswith("0 mm3 outside of R 12 (0.0% of the metal there), ")
        assert not any("not built" in w or "left out" in w for w in found.warnings)

    @pytest.mark.parametrize(("count", "told"), [(1, False), (8, True)])
    def test_teeth_inside_of_a_given_radius(self, count, told):
        # lugs 4 x 10 mm from the shaft of R 20 to R 30, planned from R 26 on: what lies inside of 26 is left out
        lugs = [bd.Rot(0, 0, 45.0 * i) * box((15.0, -2.0, -5.0), (30.0, 2.0, 5.0)) for i in range(count)]
        found = inspect_part(united(bar(20.0, -25.0, 25.0), *lugs), axis="Z", substrate=26.0)
        lost = count * 10.0 * 4.0 * 6.0
        whole = math.pi * 400.0 * 50.0 + count * 10.0 * 4.0 * 10.0
        assert (lost > 0.02 * whole) == told
        assert any(w.startswith("left out below R 26") for w in found.warnings) == told
        volume = float(found.left_out.split("there), ")[1].split(" mm3")[0])
        assert volume == pytest.approx(lost, rel=0.08)  # by rays: good to what a lug's edge takes of a column
