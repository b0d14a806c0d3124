"""What a value prints as: one line with its most useful figures, however large it is."""

from __future__ import annotations

import enum
import inspect
import math

import pytest

import brep_slicer as bs
from brep_slicer.layers import cylinder
from brep_slicer.substrate.axis import AxisCandidate
from brep_slicer.substrate.layers import LayerStack
from brep_slicer.substrate.radius import CylinderCandidate

LONGEST = 200


@pytest.fixture(scope="module")
def plan(request):
    path = request.config.rootpath / "fixtures" / "step" / "spur_gear.step"
    rules = [{"layers": "0:2", "contours": 3}, {"narrower_than": 12.0, "pattern": "skeleton"}]
    process = bs.Process(
        layer_thickness=1.0, step_over=1.0, rules=rules, fill=bs.Fill(pattern=bs.Automatic(angle_deg=tuple(range(0, 180, 3))))
    )
    return bs.plan(bs.read_step(path), process, layers="0:12")


def values(plan):
    """(what it has to say, the value) of every public class that holds figures."""
    layer, region = plan.layers[0], plan.layers[0].region
    piece, fill = region.pieces[0], plan.fills[0]
    loop = piece.loops[0]
    beads = sum(len(f.beads) for f in plan.fills)
    area = bs.FillArea(piece=piece, index=0, inset=2.45, step_over=3.4, width=4.9, chord=0.01)
    failed = bs.FailedLayer(index=3, level=7.5, cut_level=7.5, thickness=1.0, reason="the section does not close; " * 40)
    patterns = (bs.Contours(count=2, skeleton=False), *(bs.Hatch(angle_deg=math.degrees(0.1 * i)) for i in range(40)))
    candidate = bs.axis_candidates(plan.part)[0]
    cylinder = bs.coaxial_cylinders(plan.part, plan.axis)[0]
    return {
        bs.Plan: (plan, ["spur_gear.step", "12 layers", f"{beads} beads", f"R {plan.substrate.radius:.6g} mm"]),
        bs.Part: (plan.part, ["spur_gear.step", "1 solid", "mm"]),
        bs.Solid: (plan.part.solids[0], [plan.part.solids[0].name]),
        bs.Axis: (plan.axis, ["0,0,0:0,0,1"]),
        AxisCandidate: (candidate, [f"{candidate.share:.0%}"]),
        CylinderCandidate: (cylinder, [f"R {cylinder.radius:.6g} mm"]),
        bs.Substrate: (plan.substrate, [f"R {plan.substrate.radius:.6g} mm"]),
        LayerStack: (plan.stack, [f"{len(plan.stack.radii)} layers"]),
        bs.Inspection: (bs.inspect_part(plan.part), ["1 solid", f"R {plan.substrate.radius:.6g} mm"]),
        bs.Layer: (layer, [f"{layer.area:.6g} mm2", f"R {layer.radius:.6g} mm", "analytic"]),
        bs.FailedLayer: (failed, ["R 7.5 mm", "does not close"]),
        bs.Region: (region, [f"{region.area:.6g} mm2", f"{len(region.pieces)} piece"]),
        bs.LayerFamily: (bs.Cylinders(), ["Cylinders()"]),
        bs.Cylinders: (bs.Cylinders(), ["Cylinders()"]),
        bs.Cones: (bs.Cones(20.0), ["half_angle_deg=20.0"]),
        bs.Planes: (bs.Planes(), ["normal=(0.0, 0.0, 1.0)"]),
        bs.Sheet: (region.sheet, ["cylinders", f"R {layer.radius:.6g} mm"]),
        bs.Piece: (piece, [f"{piece.area():.6g} mm2"]),
        bs.Loop: (loop, [f"{len(loop.curves)} curves"]),
        bs.Curve: (loop.curves[0], [f"{loop.curves[0].length():.5g} mm long"]),
        bs.Certificate: (layer.certificate, ["analytic", "residual"]),
        bs.LayerFill: (fill, [f"{len(fill.beads)} beads"]),
        bs.Bead: (fill.beads[0], [fill.beads[0].kind.value, f"{fill.beads[0].length():.5g} mm"]),
        bs.Toolpath: (plan.toolpath, [f"{len(plan.toolpath)} points", f"{beads} beads"]),
        bs.FillArea: (area, ["piece 0 of layer 0", "step-over 3.4", "0 beads"]),
        bs.AreaFill: (bs.Contours().fill(area), ["beads", " mm"]),
        bs.Automatic: (plan.process.fill.pattern, ["angle_deg=(0.0, 3.0"]),
        bs.Layers: (bs.Layers(radii=range(1, 400)), ["radii=(1.0, 2.0"]),
        bs.Fill: (plan.process.fill, ["pattern=Automatic"]),
        bs.Motion: (bs.Motion(chord=0.1), ["chord=0.1"]),
        bs.Laser: (bs.Laser(power_w=900), ["power_w=900.0"]),
        bs.Powder: (bs.Powder(feed_g_s=0.4), ["feed_g_s=0.4"]),
        bs.Process: (plan.process, ["step_over=1.0"]),
        bs.Rule: (plan.process.rules[0], ["0:2", "contours=3"]),
        bs.PatternSequence: (bs.PatternSequence(patterns=patterns), ["Contours, Hatch"]),
        bs.Contours: (bs.Contours(count=1, skeleton=False), ["count=1"]),
        bs.FlankFollowing: (bs.FlankFollowing(both_ways=False), ["both_ways"]),
        bs.Hatch: (bs.Hatch(angle_deg=30), ["angle_deg=(30.0,)"]),
        bs.Helix: (bs.Helix(starts=2), ["starts=2"]),
        bs.Rings: (bs.Rings(), ["Rings"]),
        bs.Skeleton: (bs.Skeleton(), ["Skeleton"]),
        bs.Spiral: (bs.Spiral(skeleton=False), ["skeleton=False"]),
        bs.Zigzag: (bs.Zigzag(angle_deg=30), ["angle_deg=(30.0,)"]),
    }


def test_every_public_class_prints_one_short_line(plan):
    told = values(plan)
    public = {getattr(bs, name) for name in bs.__all__ if inspect.isclass(getattr(bs, name))}
    holding = {kind for kind in public if not issubclass(kind, enum.Enum | Exception) and kind not in (bs.Pattern, bs.Writer)}
    assert holding <= set(told), "a new public class: say here what it has to print"
    for kind, (value, says) in told.items():
        assert isinstance(value, kind)
        text = repr(value)
        assert len(text) < LONGEST, text
        assert "\n" not in text
        assert text.startswith(type(value).__name__)
        for words in says:
            assert words in text, text
        assert str(value) == text


@pytest.mark.parametrize(
    ("kind", "given"),
    [
        ("Part", {"source": "x" * 5000, "unit": "mm", "solids": ()}),
        ("Solid", {"index": 0, "name": "a\nb" * 900, "wrapped": None}),
        ("Substrate", {"radius": 1.0, "solids": tuple(range(3)), "reason": "because " * 300}),
        ("FailedLayer", {"index": 0, "level": 1.0, "cut_level": 1.0, "thickness": None, "reason": "no\n" * 500}),
    ],
)
def test_long_texts_are_shortened(kind, given):
    text = repr(getattr(bs, kind)(**given))
    assert len(text) < LONGEST
    assert "\n" not in text
    assert "..." in text


def test_nothing_is_said_of_what_is_not_there():
    empty = bs.Region(sheet=cylinder(5.0))
    assert repr(empty) == "Region(R 5 mm: 0 pieces, 0 mm2)"
    assert repr(bs.LayerFill(beads=())) == "LayerFill(0 beads (empty), 0 mm, 0 notes)"
