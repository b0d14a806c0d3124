"""Volumes from the faces' boundaries alone, on shapes whose volume has a formula."""

from __future__ import annotations

import numpy as np
import pytest

import brep_slicer as bs
from brep_slicer.section import cut_solids
from brep_slicer.substrate.axis import axis_from_text
from brep_slicer.testing import closure_of

bd = pytest.importorskip("build123d")

Z = axis_from_text("Z")

# exact volumes, mm**3; each has faces of a kind of its own
CLOSED = {
    "cone": (lambda: bd.Cone(20.0, 8.0, 30.0), np.pi * 30.0 * (20.0**2 + 20.0 * 8.0 + 8.0**2) / 3.0),
    "ball": (lambda: bd.Sphere(12.0), 4.0 / 3.0 * np.pi * 12.0**3),
    "ring": (lambda: bd.Torus(30.0, 7.0), 2.0 * np.pi**2 * 30.0 * 7.0**2),
    "two crossing cylinders": (
        lambda: bd.Cylinder(10.0, 60.0) & bd.Rotation(0, 90, 0) * bd.Cylinder(10.0, 60.0),
        16.0 / 3.0 * 10.0**3,
    ),
    "ball cap": (
        lambda: bd.Sphere(12.0) - bd.Pos(0, 0, -7.0) * bd.Box(30.0, 30.0, 24.0),
        np.pi * 7.0**2 * (3 * 12.0 - 7.0) / 3.0,
    ),
    "bored bar": (lambda: bd.Box(40.0, 30.0, 20.0) - bd.Cylinder(8.0, 40.0), 40.0 * 30.0 * 20.0 - np.pi * 8.0**2 * 20.0),
}


@pytest.mark.parametrize("name", CLOSED)
@pytest.mark.parametrize("splines", [False, True])
def test_volumes_by_the_faces_boundaries(name, splines):
    # as B-splines the same faces are rational, half a turn a span: their pieces have to be halved
    from OCP.BRepBuilderAPI import BRepBuilderAPI_NurbsConvert

    make, truth = CLOSED[name]
    wrapped = make().solids()[0].wrapped
    if splines:
        wrapped = BRepBuilderAPI_NurbsConvert(wrapped, True).Shape()
    # tilted and off the axis, nothing cancels
    shape = bd.Location((31.0, -12.0, 57.0), (20.0, 35.0, 50.0)) * bd.Solid(wrapped)
    (solid,) = cut_solids(bs.as_part(shape), Z)
    closure = closure_of(solid.brep)
    assert closure.volume == pytest.approx(truth, rel=1e-9 + closure.defect)
    assert closure.defect < 2e-7
    assert closure.quadrature < 1e-7 * truth
    assert closure.moment == pytest.approx(57.0 * truth, rel=1e-6) or name in ("cone", "ball cap")


def vase(hole=0.0):
    """A wavy profile turned about z, as B-splines: a hundred spans along v, a few round it; bored across through its wall."""
    z = np.linspace(0.0, 100.0, 101)
    wave = bd.Spline([(30.0 + 2.0 * np.sin(0.3 * x), 0.0, x) for x in z])
    inner = bd.Polyline(wave @ 1, (20.0, 0.0, 100.0), (20.0, 0.0, 0.0), wave @ 0)
    shape = bd.revolve(bd.make_face(bd.Wire([wave, *inner.edges()])), bd.Axis.Z)
    return shape - bd.Pos(30, 0, 50) * bd.Rotation(0, 90, 0) * bd.Cylinder(hole, 40) if hole else shape


def plate():
    """A wavy outline extruded, as B-splines: the spans go along u."""
    wave = bd.Spline([(x, 3.0 * np.sin(0.3 * x)) for x in np.linspace(0.0, 100.0, 101)])
    rest = bd.Polyline(wave @ 1, (100.0, 20.0), (0.0, 20.0), wave @ 0)
    return bd.extrude(bd.make_face(bd.Wire([wave, *rest.edges()])), 12.0)


@pytest.mark.parametrize(
    ("make", "share"),
    [(vase, 0.1), (lambda: vase(6.0), 0.1), (plate, 1.0), (CLOSED["ring"][0], 1.0), (CLOSED["two crossing cylinders"][0], 1.0)],
    ids=["vase", "bored vase", "plate", "ring", "two crossing cylinders"],
)
def test_lines_either_way_give_the_same_and_the_cheaper_way_is_taken(make, share, monkeypatch):
    from OCP.BRepBuilderAPI import BRepBuilderAPI_NurbsConvert

    from brep_slicer.section import volume

    shape = bd.Location((31.0, -12.0, 57.0), (20.0, 35.0, 50.0)) * bd.Solid(
        BRepBuilderAPI_NurbsConvert(make().solids()[0].wrapped, True).Shape()
    )
    (solid,) = cut_solids(bs.as_part(shape), Z)

    def places():
        return sum(len(uv) for face in solid.brep.faces for uv, _ in volume._nodes(face, 1))

    taken, count = closure_of(solid.brep), places()
    for constant in (0, 1):
        monkeypatch.setattr(volume, "_constant_along_lines", lambda u, v, constant=constant: constant)
        other = closure_of(solid.brep)
        assert other.volume == pytest.approx(taken.volume, rel=1e-9 + taken.defect)
        assert other.area == pytest.approx(taken.area, rel=1e-7)
        assert np.allclose(other.vector, taken.vector, atol=1e-8 * taken.area)
        if constant == 0:
            # u = const, as for every surface before
            assert count <= share * places()
