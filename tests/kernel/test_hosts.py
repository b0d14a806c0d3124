"""Objects of the CAD hosts: the names of their parts; an environment with two kernels; units as files call them."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

import brep_slicer as bs

ROOT = Path(__file__).resolve().parent.parent.parent


def names(thing):
    return [s.name for s in bs.as_part(thing).solids]


class TestBuild123d:
    @pytest.fixture
    def bd(self):
        return pytest.importorskip("build123d", reason="the hosts' own objects need build123d")

    @pytest.fixture
    def pieces(self, bd):
        shaft = bd.Solid.make_cylinder(20.0, 40.0)
        lug = bd.Solid.make_box(10.0, 10.0, 10.0, bd.Plane((18.0, -5.0, 5.0)))
        shaft.label, lug.label = "shaft", "lug"
        return shaft, lug

    def test_labels_of_children_are_the_solids_names(self, bd, pieces):
        assembly = bd.Compound(label="both", children=list(pieces))
        assert names(assembly) == ["shaft", "lug"]
        assert bs.as_part(assembly).select(["lug"]).solids[0].name == "lug"

    def test_a_moved_assembly_keeps_names_and_places(self, bd, pieces):
        assembly = bd.Compound(label="both", children=list(pieces))
        assembly.location = bd.Location((0.0, 0.0, 100.0))
        part = bs.as_part(assembly)
        assert [s.name for s in part.solids] == ["shaft", "lug"]
        height = bd.Solid(part.solids[1].wrapped).center().Z
        assert height == pytest.approx(110.0)

    def test_children_of_children_and_nameless_ones(self, bd, pieces):
        pin = bd.Solid.make_cylinder(1.0, 5.0, bd.Plane((0.0, 0.0, 60.0)))
        inner = bd.Compound(label="pins", children=[pin])
        assert names(bd.Compound(label="all", children=[*pieces, inner])) == ["shaft", "lug", "pins"]

    def test_equal_labels_are_numbered(self, bd, pieces):
        shaft, lug = pieces
        other = bd.Solid.make_box(10.0, 10.0, 10.0, bd.Plane((-28.0, -5.0, 5.0)))
        other.label = "lug"
        assert names([shaft, lug, other]) == ["shaft", "lug#1", "lug#2"]

    def test_a_solid_by_itself_and_several_without_names(self, bd, pieces):
        assert names(pieces[0]) == ["shaft"]
        plain = bd.Compound([bd.Solid.make_box(1.0, 1.0, 1.0), bd.Solid.make_box(1.0, 1.0, 1.0, bd.Plane((5.0, 0.0, 0.0)))])
        assert names(plain) == ["solid#1", "solid#2"]


class TestCadQuery:
    @pytest.fixture
    def cq(self):
        return pytest.importorskip("cadquery", reason="the hosts' own objects need CadQuery")

    def test_names_of_an_assembly_are_the_solids_names(self, cq):
        whole = cq.Assembly(name="whole")
        whole.add(cq.Workplane().cylinder(40.0, 20.0), name="shaft")
        whole.add(cq.Workplane().box(10.0, 10.0, 20.0), name="lug", loc=cq.Location((25.0, 0.0, 0.0)))
        inner = cq.Assembly(name="inner", loc=cq.Location((0.0, 0.0, 100.0)))
        whole.add(inner.add(cq.Workplane().box(1.0, 1.0, 1.0), name="pin"))
        part = bs.as_part(whole)
        assert [s.name for s in part.solids] == ["shaft", "lug", "pin"]
        assert cq.Solid(part.solids[2].wrapped).Center().z == pytest.approx(100.0)

    def test_its_vectors_and_planes_are_axes(self, cq):
        part = bs.as_part(cq.Workplane().cylinder(40.0, 20.0))
        for axis in (cq.Vector(0, 0, 2), cq.Plane.XY(), cq.Plane((0, 0, 5)), (cq.Vector(0, 0, 3), cq.Vector(0, 0, 1))):
            found = bs.inspect_part(part, axis=axis).axis
            assert found.direction.tolist() == [0.0, 0.0, 1.0]
            assert found.origin.tolist() == [0.0, 0.0, 0.0]


def check_kernels(**installed):
    """What the kernel's check says where these versions are installed, in an interpreter of its own."""
    code = (
        "from importlib import metadata\n"
        f"found = {installed!r}\n"
        "def version(name):\n"
        "    if name.replace('-', '_') not in found: raise metadata.PackageNotFoundError(name)\n"
        "    return found[name.replace('-', '_')]\n"
        "metadata.version = version\n"
        "from brep_slicer.errors import KernelError\n"
        "try:\n    import brep_slicer.kernel.compat\n"
        "except KernelError as error:\n    print(error)\n"
    )
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT).stdout.strip()


@pytest.mark.parametrize(("one", "other"), [("7.9.3.1.1", "8.0.1.1.0"), ("8.0.1.1.0", "7.9.3.1"), ("7.9.2", "7.9.3.1")])
def test_two_kernels_over_each_other_are_one_clear_line(one, other):
    said = check_kernels(cadquery_ocp=one, cadquery_ocp_novtk=other)
    assert f"cadquery-ocp {one} and cadquery-ocp-novtk {other}" in said
    assert 'pip install ".[cadquery]"' in said
    assert "\n" not in said


@pytest.mark.parametrize(
    "installed", [{"cadquery_ocp_novtk": "8.0.1"}, {"cadquery_ocp": "7.9.3.1.1", "cadquery_ocp_novtk": "7.9.3.1"}, {}]
)
def test_one_kernel_is_one(installed):
    assert check_kernels(**installed) == ""


def converted(path, name, metres):
    """The cylinder's file with its unit exchanged for one that is so many metres."""
    text = (ROOT / "fixtures" / "step" / "cylinder.step").read_text()
    number = re.search(r"#(\d+)\s*=\s*\(\s*LENGTH_UNIT", text).group(1)
    unit = (
        f"#{number}=(CONVERSION_BASED_UNIT('{name}',#9001)LENGTH_UNIT()NAMED_UNIT(#9003));\n"
        f"#9001=LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE({metres!r}),#9002);\n"
        "#9002=(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT($,.METRE.));\n"
        "#9003=DIMENSIONAL_EXPONENTS(1.,0.,0.,0.,0.,0.,0.);"
    )
    path.write_text(re.sub(rf"#{number}\s*=\s*\([^;]*;", unit, text))
    return path


@pytest.mark.parametrize(
    ("name", "metres", "called"),
    [
        ("MILE", 1609.344, "mile"),
        ("MICROINCH", 2.54e-8, "microinch"),
        ("MIL", 2.54e-5, "mil"),
        ("FOOT", 0.3048, "ft"),
        ("INCHES", 0.0254, "inch"),
        ("YARD", 0.9144, "yd"),
        ("FURLONG", 201.168, "furlong"),
    ],
)
def test_units_are_said_as_they_are(tmp_path, name, metres, called):
    plain = bs.read_step(ROOT / "fixtures" / "step" / "cylinder.step")
    radius = bs.coaxial_cylinders(plain, "Z")[0].radius
    part = bs.read_step(converted(tmp_path / "unit.step", name, metres))
    assert part.unit == called
    assert bs.coaxial_cylinders(part, "Z")[0].radius == pytest.approx(1000.0 * metres * radius, rel=1e-12)
    # said to be in millimetres after all
    again = bs.read_step(tmp_path / "unit.step", unit="mm")
    assert again.unit == "mm"
    assert bs.coaxial_cylinders(again, "Z")[0].radius == pytest.approx(radius, rel=1e-12)
