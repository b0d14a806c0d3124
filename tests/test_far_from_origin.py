"""Parts far from their file's origin: cut in a frame of their own, to what the file's coordinates are good for."""

from __future__ import annotations

import numpy as np
import pytest

import brep_slicer as bs
from brep_slicer.section import Engine
from brep_slicer.substrate.axis import as_axis
from fixtures import gears
from tests.test_root_fillets import filleted

bd = pytest.importorskip("build123d")
TURN = (33, 21, 5)
WAY = np.array([0.6, -0.7, 0.4])
# A coordinate x in a file is rounded to x * 1.1e-16; what is read, moved and turned holds a few of these.
ROUNDING = 2e-15


def nurbs(shape):
    from OCP.BRepBuilderAPI import BRepBuilderAPI_NurbsConvert

    return bd.Solid(BRepBuilderAPI_NurbsConvert(shape.solid().wrapped).Shape())


def key():
    return bd.Cylinder(25, 60) + bd.Pos(30, 0, 0) * bd.Box(30, 8, 12)


def boss():
    return filleted(bd.Circle(8), 50, lambda root: bd.fillet(root, 2.5))


def oblique():
    """Faces of every closed form: a tilted cylinder, a tilted cone and a ball, none of them coaxial."""
    parts = [
        bd.Pos(30, 0, 8) * bd.Rot(0, 70, 0) * bd.Cylinder(6, 30),
        bd.Pos(-28, 3, -8) * bd.Rot(0, -80, 0) * bd.Cone(9, 4, 24),
        bd.Pos(2, 24, 3) * bd.Sphere(9),
    ]
    return bd.Cylinder(25, 60) + parts


SHAPES = {
    "key": key,
    "boss": boss,
    "boss as B-splines": lambda: nurbs(boss()),
    "oblique": oblique,
    "gear": lambda: gears.gear(gears.HELICAL_GEAR),
}


def placed(shape, distance):
    where = bd.Pos(*(WAY * distance)) * bd.Rot(*TURN)
    return where * shape, bd.Plane(where)


@pytest.mark.parametrize("distance", [1e4, 1e6, 1e7])
@pytest.mark.parametrize("name", SHAPES)
def test_the_same_sections_as_at_the_origin(name, distance):
    shape = SHAPES[name]()
    radii = [25.0, 25.3, 27.1, 29.0, 31.5]
    if name == "boss as B-splines":
        del radii[0]  # where it fails at the origin, too
    if name == "gear":
        radii = [gears.HELICAL_GEAR.root_radius, 93.0, 109.0]
    here = bs.slice_part(shape, radii, axis="Z")
    far, line = placed(shape, distance)
    for axis in (line, None):
        for one, other in zip(here, bs.slice_part(far, radii, axis=axis), strict=True):
            assert other.certificate.engine is Engine.ANALYTIC
            assert other.certificate.fallback == ""
            # at the hub's own radius the fillet is tangent: the outline moves by the root of what the edge moves by
            apart = ROUNDING * distance if one.radius > 25.0 else np.sqrt(2.0 * one.radius * ROUNDING * distance)
            assert other.area == pytest.approx(one.area, abs=apart * one.region.length + 1e-9)
            assert len(other.region.pieces) == len(one.region.pieces)


@pytest.mark.parametrize("distance", [1e4, 1e6])
def test_a_layer_lies_where_it_belongs(distance):
    shape = oblique()
    far, line = placed(shape, distance)
    axis = as_axis(line, bs.as_part(far))
    (layer,) = bs.slice_part(far, [29.0], axis=line)
    (here,) = bs.slice_part(shape, [29.0], axis="Z")
    flip = float(np.sign(axis.direction @ np.array([*line.z_dir])))
    height = float(axis.axis_from_file(np.array([*line.origin]))[2])
    # the axis frame is turned about the axis, and may look the other way
    heights = np.sort([flip * v for b in (p.bounds() for p in here.region.pieces) for v in (b[1], b[3])])
    found = np.sort([v - height for b in (p.bounds() for p in layer.region.pieces) for v in (b[1], b[3])])
    assert found == pytest.approx(heights, abs=1e-7)
    assert layer.region.first_moment == pytest.approx(
        flip * here.region.first_moment + height * layer.area, rel=1e-12, abs=1e-3
    )


def test_planned_far_away():
    shape = key()
    process = bs.Process(layer_thickness=2.0, step_over=3.0)
    here = bs.plan(shape, process, substrate=25.0, axis="Z")
    far, line = placed(shape, 1e6)
    there = bs.plan(far, process, substrate=25.0, axis=line)
    assert [layer.area for layer in there.layers] == pytest.approx([layer.area for layer in here.layers], abs=1e-6)
    assert len(there.fills) == len(here.fills)
    volume = bs.inspect_part(far, axis=line).solids[0]["volume_mm3"]
    assert volume == pytest.approx(bs.inspect_part(shape, axis="Z").solids[0]["volume_mm3"], rel=1e-9)


def test_two_axes_side_by_side():
    # two boss pairs 2 mm apart are two lines, 1e6 mm away, too: what is one line goes by the part's size
    shape = bd.Box(60, 60, 10) + bd.Pos(-1, 0, 10) * bd.Cylinder(12, 10) + bd.Pos(1, 0, -10) * bd.Cylinder(6, 10)
    far, _ = placed(shape, 1e6)
    shares = [candidate.share for candidate in bs.axis_candidates(far)]
    assert shares == pytest.approx([2.0 / 3.0, 1.0 / 3.0], rel=1e-6)
