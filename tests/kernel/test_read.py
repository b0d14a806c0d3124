"""Files and host objects in; what cannot be used is refused in one line. Runs on every supported OCP."""

from __future__ import annotations

import math

import numpy as np
import pytest

import brep_slicer as bs
from brep_slicer.kernel.shapes import bytes_from_shape, volume_of


@pytest.fixture
def cylinder(fixture_step):
    return fixture_step("cylinder")


def test_a_solid_in_millimetres(cylinder):
    part = bs.read_step(cylinder)
    assert len(part.solids) == 1
    assert part.unit == "mm"
    assert volume_of(part.wrapped) == pytest.approx(math.pi * 1000.0, rel=1e-9)


@pytest.mark.parametrize(("unit", "factor"), [("cm", 10.0), ("m", 1000.0), ("inch", 25.4), ("mm", 1.0)])
def test_another_unit_can_be_said(cylinder, unit, factor):
    part = bs.read_step(cylinder, unit=unit)
    assert volume_of(part.wrapped) == pytest.approx(math.pi * 1000.0 * factor**3, rel=1e-9)


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (None, "there is no such file"),
        ("", "the file is empty"),
        ("solid cube\nfacet normal 0 0 1\n", "this is no STEP file"),
        ("ISO-10303-21;\nHEADER;\n", "the file is cut off"),
        ("ISO-10303-21;\nHEADER;\nENDSEC;\nDATA;\nENDSEC;\nEND-ISO-10303-21;\n", "--unit"),
    ],
)
def test_what_is_no_part_is_refused_in_one_line(tmp_path, content, said):
    path = tmp_path / "part.step"
    if content is not None:
        path.write_text(content)
    with pytest.raises(bs.InputError, match=said) as caught:
        bs.read_step(path)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_truncated_file(tmp_path, cylinder):
    text = cylinder.read_text()
    path = tmp_path / "cut.step"
    path.write_text(text[: len(text) // 2])
    with pytest.raises(bs.InputError, match="cut off"):
        bs.read_step(path)


def test_a_file_without_a_unit_asks_for_it(tmp_path, cylinder):
    lines = [line for line in cylinder.read_text().splitlines() if "LENGTH_UNIT" not in line]
    path = tmp_path / "nounit.step"
    path.write_text("\n".join(lines))
    with pytest.raises(bs.InputError, match="states no length unit"):
        bs.read_step(path)


def test_a_folder_and_an_unknown_unit(tmp_path, cylinder):
    with pytest.raises(bs.InputError, match="this is a folder"):
        bs.read_step(tmp_path)
    with pytest.raises(bs.InputError, match="unit 'parsec' is not known"):
        bs.read_step(cylinder, unit="parsec")


def test_solids_by_name_and_index(fixture_step):
    path = fixture_step("propeller")
    part = bs.read_step(path)
    assert len(part.solids) == 4
    assert [s.index for s in bs.read_step(path, solids=[part.solids[2].name]).solids] == [2]
    assert [s.index for s in bs.read_step(path, solids=["0", 3]).solids] == [0, 3]
    with pytest.raises(bs.InputError, match="there is no solid 'rudder'"):
        bs.read_step(path, solids=["rudder"])
    with pytest.raises(bs.InputError, match="no solid was chosen"):
        bs.read_step(path, solids=[])
    with pytest.raises(bs.InputError, match="named by a path, not by Part"):
        bs.read_step(part)


def test_ocp_shapes_and_bytes(cylinder):
    part = bs.read_step(cylinder)
    for shape in (part.wrapped, bytes_from_shape(part.wrapped)):
        again = bs.as_part(shape)
        assert volume_of(again.wrapped) == pytest.approx(volume_of(part.wrapped), rel=1e-12)
    assert bs.as_part(part) is part


@pytest.mark.parametrize("thing", [None, 3, "gear.step", b"nonsense"])
def test_what_is_no_shape(thing):
    with pytest.raises(bs.InputError):
        bs.as_part(thing)


def test_build123d_objects_and_builders():
    bd = pytest.importorskip("build123d")
    with bd.BuildPart() as builder:
        bd.Cylinder(10, 10)
    box = bd.Box(1, 2, 3)
    for thing, volume in ((builder, math.pi * 1000), (builder.part, math.pi * 1000), (box, 6.0), (bd.Pos(5, 5, 5) * box, 6.0)):
        assert volume_of(bs.as_part(thing).wrapped) == pytest.approx(volume, rel=1e-9)
    with pytest.raises(bs.InputError, match="holds no solid"):
        bs.as_part(bd.Face.make_rect(1, 1))


def test_cadquery_workplanes_shapes_and_assemblies():
    cq = pytest.importorskip("cadquery")
    work = cq.Workplane("XY").circle(10).extrude(10)
    assembly = cq.Assembly().add(work, loc=cq.Location((50, 0, 0)), name="disc")
    for thing in (work, work.val(), assembly):
        assert volume_of(bs.as_part(thing).wrapped) == pytest.approx(math.pi * 1000, rel=1e-9)
    (layer,) = bs.slice_part(assembly, [5.0], axis=bs.axis_from_line((50, 0, 0), (0, 0, 1)))
    assert layer.area == pytest.approx(2 * math.pi * 50.0, rel=1e-12)


def test_the_solid_is_never_changed(fixture_step):
    from brep_slicer.kernel.booleans import largest_tolerance

    part = bs.read_step(fixture_step("drilled_tube"))
    before = largest_tolerance(part.wrapped), bytes_from_shape(part.wrapped)
    for engine in ("analytic", "boolean"):
        bs.slice_part(part, [35.0, 40.0], engine=engine)
    assert (largest_tolerance(part.wrapped), bytes_from_shape(part.wrapped)) == before


@pytest.mark.parametrize(
    ("name", "radius"), [("drilled_tube", 40.0), ("cam", 47.0), ("helical_gear_tooth", 170.0), ("oblique_tube", 40.0)]
)
def test_both_engines_agree(name, radius, fixture_step):
    part = bs.read_step(fixture_step(name))
    one, other = (bs.slice_part(part, [radius], axis=bs.axis_from_text("Z"), engine=e)[0] for e in ("analytic", "boolean"))
    assert one.certificate.engine is bs.Engine.ANALYTIC
    assert one.area == pytest.approx(other.area, rel=1e-6)
    assert one.region.length == pytest.approx(other.region.length, rel=1e-6)
    shapes = [layer.region.to_shapely(chord=1e-4) for layer in (one, other)]
    assert shapes[0].hausdorff_distance(shapes[1]) < 1e-3


def test_axis_from_words():
    axis = bs.axis_from_text("0,0,5:0,1,0")
    assert np.allclose(axis.origin, [0, 0, 5])
    assert np.allclose(axis.direction, [0, 1, 0])
    assert np.allclose(axis.x_direction, [1, 0, 0])
    # the largest component points upwards; the origin is the foot of the file's origin; X along the axis gives way to Y
    assert np.allclose(bs.axis_from_line((7, 0, 0), (-2, 0, 0)).direction, [1, 0, 0])
    assert np.allclose(bs.axis_from_line((7, 0, 0), (-2, 0, 0)).origin, [0, 0, 0])
    assert np.allclose(bs.axis_from_text("X").x_direction, [0, 1, 0])
    for text in ("W", "0,0:0,0,1", "0,0,0:0,0,0", "a,b,c:d,e,f"):
        with pytest.raises(bs.InputError):
            bs.axis_from_text(text)


def test_a_part_without_an_axis_and_one_with_several():
    bd = pytest.importorskip("build123d")
    with pytest.raises(bs.PlanningError, match="no face is turned about an axis"):
        bs.find_axis(bs.as_part(bd.Box(1, 2, 3)))
    cross = bd.Cylinder(5, 60) + bd.Cylinder(5, 60, rotation=(90, 0, 0))
    with pytest.raises(bs.PlanningError, match=r"several axes are possible .* choose one with --axis"):
        bs.find_axis(bs.as_part(cross))
