"""What may not change a section: where the part is turned to, shifted to, mirrored, scaled; the order of its faces."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

import brep_slicer as bs
from brep_slicer.substrate.axis import axis_from_line, axis_from_text

bd = pytest.importorskip("build123d", reason="the parametric fixtures need build123d")
from fixtures import blades, bodies, gears  # noqa: E402

Z = axis_from_text("Z")
angle = st.floats(-math.pi, math.pi)
FEW = settings(max_examples=12, deadline=None)


def areas(shape, radii, axis=Z):
    layers = bs.slice_part(shape, list(radii), axis=axis)
    assert all(layer.certificate.engine is bs.Engine.ANALYTIC for layer in layers), [
        layer.certificate.fallback for layer in layers
    ]
    return [layer.area for layer in layers]


PARTS = {
    "cylinder": (bodies.cylinder(), (5.0, 9.0)),
    "keyed band": (bodies.KeyedBand().solid(), (40.0, 50.0)),
    "box": (bodies.BoxOnShaft().solid(), (50.0, 60.0)),
    "cam": (bodies.Cam().solid(), (40.0, 47.0)),
    "drilled": (bodies.DrilledTube().solid(), (31.0, 45.0)),
    "helical tooth": (gears.tooth_on_shaft(gears.HELICAL_TOOTH), (150.0, 171.0)),
    "blade": (blades.Blade().solid(), (50.0, 100.0)),
}


@pytest.mark.parametrize(("solid", "radii"), PARTS.values(), ids=PARTS)
@given(turn=angle)
@FEW
def test_turning_the_part(solid, radii, turn):
    assert areas(solid.rotate(bd.Axis.Z, math.degrees(turn)), radii) == pytest.approx(areas(solid, radii), rel=1e-9)


@pytest.mark.parametrize(("solid", "radii"), PARTS.values(), ids=PARTS)
@given(x=st.floats(-200, 200), y=st.floats(-200, 200), z=st.floats(-200, 200), tilt=angle, turn=angle)
@FEW
def test_moving_part_and_axis_together(solid, radii, x, y, z, tilt, turn):
    place = bd.Location((x, y, z), (math.degrees(tilt), 0.0, math.degrees(turn)))
    moved = solid.moved(place)
    direction = tuple(bd.Plane(place).z_dir)
    axis = axis_from_line((x, y, z), direction)
    assert areas(moved, radii, axis) == pytest.approx(areas(solid, radii), rel=1e-8)


@pytest.mark.parametrize(("solid", "radii"), PARTS.values(), ids=PARTS)
def test_mirroring(solid, radii):
    for plane in (bd.Plane.XY, bd.Plane.XZ):
        assert areas(solid.mirror(plane), radii) == pytest.approx(areas(solid, radii), rel=1e-9)


@pytest.mark.parametrize("factor", [1e-3, 1e-2, 0.5, 10.0, 1e3])
@pytest.mark.parametrize(("solid", "radii"), PARTS.values(), ids=PARTS)
def test_scaling(solid, radii, factor):
    scaled = [a / factor**2 for a in areas(solid.scale(factor), [r * factor for r in radii])]
    assert scaled == pytest.approx(areas(solid, radii), rel=1e-7)


@pytest.mark.parametrize(("solid", "radii"), PARTS.values(), ids=PARTS)
@given(z=st.floats(-500, 500))
@FEW
def test_shifting_along_the_axis(solid, radii, z):
    straight, moved = (bs.slice_part(s, list(radii), axis=Z) for s in (solid, solid.moved(bd.Location((0.0, 0.0, z)))))
    for a, b in zip(straight, moved, strict=True):
        assert b.area == pytest.approx(a.area, rel=1e-9)
        assert b.region.first_moment == pytest.approx(a.region.first_moment + z * a.area, rel=1e-8, abs=1e-8 * a.area)


@pytest.mark.parametrize(("solid", "radii"), PARTS.values(), ids=PARTS)
@given(data=st.data())
@FEW
def test_the_order_of_the_faces(solid, radii, data):
    shuffled = solid_of_faces(data.draw(st.permutations(list(solid.faces()))))
    assert areas(shuffled, radii) == pytest.approx(areas(solid, radii), rel=1e-12)


@pytest.mark.parametrize(("solid", "radii"), PARTS.values(), ids=PARTS)
@given(tilt=st.floats(-0.4, 0.4), share=st.floats(0.1, 0.9))
@example(tilt=-0.03125, share=0.3125)
@settings(max_examples=5, deadline=None)
def test_splitting_faces_in_two(solid, radii, tilt, share):
    """A knife through the whole part cuts faces in two; the halves are joined again with all their faces kept."""
    box = solid.bounding_box()
    at = box.min + (box.max - box.min) * share
    knife = bd.Plane(origin=(0.0, 0.0, at.Z), z_dir=(math.sin(tilt), 0.0, math.cos(tilt)))
    both = [solid.split(knife, keep=keep) for keep in (bd.Keep.TOP, bd.Keep.BOTTOM)]
    assume(all(half is not None for half in both))  # OCCT's own knife may give up on a B-spline
    joined = fused_with_faces_kept(*both)
    assert len(joined.faces()) > len(solid.faces())
    assert areas(joined, radii) == pytest.approx(areas(solid, radii), rel=1e-8)


def solid_of_faces(faces):
    from OCP.BRep import BRep_Builder
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeSolid
    from OCP.TopoDS import TopoDS_Shell

    shell, builder = TopoDS_Shell(), BRep_Builder()
    builder.MakeShell(shell)
    for face in faces:
        builder.Add(shell, face.wrapped)
    shell.Closed(True)
    return bd.Solid(BRepBuilderAPI_MakeSolid(shell).Solid())


def fused_with_faces_kept(first, second):
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Fuse

    # a knife may leave several pieces on one side
    pieces = [x if isinstance(x, list) else x.solids() for x in (first, second)]
    made = BRepAlgoAPI_Fuse(*[x[0].wrapped if len(x) == 1 else bd.Compound(list(x)).wrapped for x in pieces])
    (solid,) = bd.Compound(made.Shape()).solids()
    return solid


@pytest.mark.parametrize("name", ["keyed_band", "box_on_shaft", "cam", "helical_gear_tooth", "oblique_tube", "eccentric_disc"])
def test_a_part_read_back_from_its_own_step(name, fixture_step, tmp_path):
    part = bs.read_step(fixture_step(name))
    radii = {
        "keyed_band": 50.0,
        "box_on_shaft": 60.0,
        "cam": 45.0,
        "helical_gear_tooth": 170.0,
        "oblique_tube": 40.0,
        "eccentric_disc": 30.0,
    }
    bd.export_step(bd.Solid(part.solids[0].wrapped), str(tmp_path / "again.step"))
    again = bs.read_step(tmp_path / "again.step")
    r = [radii[name]]
    assert areas(again, r) == pytest.approx(areas(part, r), rel=1e-9)


@given(cut=st.floats(1.0, 29.0))
@FEW
def test_splitting_the_part_in_two_changes_nothing(cut):
    # two halves, each a solid of its own: their sections touch along a line and add up
    whole = bodies.BoxOnShaft().solid()
    knife = bd.Plane(origin=(0.0, 0.0, cut))
    halves = [whole.split(knife, keep=keep) for keep in (bd.Keep.TOP, bd.Keep.BOTTOM)]
    assert sum(areas(h, [60.0])[0] for h in halves) == pytest.approx(areas(whole, [60.0])[0], rel=1e-10)


class TestTheBeadsTurnWithThePart:
    """Issue 2: the single-face cylinder, a full band with keyway, a feature across the seam."""

    process = bs.Process(layer_thickness=5.0, step_over=3.0, fill=bs.Fill(pattern=bs.Automatic(angle_deg=30.0)))

    def beads(self, solid, substrate):
        plan = bs.plan(solid, self.process, axis=Z, substrate=substrate)
        assert not plan.failed
        return plan

    @given(turn=angle)
    @FEW
    def test_a_band_with_a_keyway(self, turn):
        straight, turned = (self.beads(bodies.KeyedBand(turn=t).solid(), 45.0) for t in (0.0, turn))
        self.compare(straight, turned, turn)

    @given(turn=angle)
    @FEW
    def test_a_feature_that_may_lie_across_the_seam(self, turn):
        straight, turned = (self.beads(bodies.BoxOnShaft(turn=t).solid(), 50.0) for t in (0.0, turn))
        self.compare(straight, turned, turn)

    @given(turn=angle)
    @FEW
    def test_a_single_face_cylinder(self, turn):
        solid = bodies.cylinder(20.0, 30.0)
        straight, turned = self.beads(solid, 10.0), self.beads(solid.rotate(bd.Axis.Z, math.degrees(turn)), 10.0)
        # nothing marks an angle on it: the beads are the same ones
        self.compare(straight, turned, 0.0)

    def compare(self, straight, turned, turn):
        for a, b in zip(straight.layers, turned.layers, strict=True):
            assert a.area == pytest.approx(b.area, rel=1e-9)
        for a, b in zip(straight.fills, turned.fills, strict=True):
            assert len(a.beads) == len(b.beads)
        for layer in range(len(straight.fills)):
            # every point on the layer, the beads' first ones too (a bead may be run through the other way)
            p, q = (x.toolpath.points[x.toolpath.radius == x.layers[layer].radius] for x in (straight, turned))
            rotation = np.array([[math.cos(turn), math.sin(turn), 0], [-math.sin(turn), math.cos(turn), 0], [0, 0, 1]])
            from scipy.spatial import cKDTree

            gap, _ = cKDTree(p @ rotation).query(q)
            assert gap.max() < 1e-6
