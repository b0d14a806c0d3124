"""Layers given back as OCCT faces: valid, of the same area, on the cylinder, in the part's own place."""

from __future__ import annotations

import numpy as np
import pytest
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.BRepGProp import BRepGProp
from OCP.GProp import GProp_GProps

import brep_slicer as bs
from brep_slicer.errors import LayerError

RADII = {
    "helical_gear_tooth": 165.0,
    "spur_gear_tooth": 160.0,
    "box_on_shaft": 60.0,
    "eccentric_disc": 30.0,
    "cam": 45.0,
    "tube": 30.0,
    "keyed_band": 50.0,
    "oblique_tube": 40.0,
    "drilled_tube": 45.0,
    "propeller": 100.0,
    "wind_blade": 100.0,
    "helical_gear": 100.0,
}


def area_of(shape) -> float:
    found = GProp_GProps()
    BRepGProp.SurfaceProperties_s(shape, found, 1e-9)
    return found.Mass()


@pytest.mark.parametrize(("name", "radius"), RADII.items())
def test_a_layer_as_a_face(name, radius, fixture_step):
    (layer,) = bs.slice_part(bs.read_step(fixture_step(name)), [radius], axis=bs.axis_from_text("Z"))
    face = layer.face()
    assert BRepCheck_Analyzer(face).IsValid()
    assert area_of(face) == pytest.approx(layer.area, rel=1e-7)


def test_in_the_frame_of_the_file(fixture_step):
    from brep_slicer.kernel.shapes import transformed

    part = bs.read_step(fixture_step("box_on_shaft"))
    axis = bs.axis_from_text("Z")
    place = np.array([[0.0, 0.0, 1.0, 7.0], [1.0, 0.0, 0.0, -3.0], [0.0, 1.0, 0.0, 5.0], [0.0, 0.0, 0.0, 1.0]])
    moved = bs.as_part(transformed(part.solids[0].wrapped, place))
    there = bs.axis_from_text("7,-3,5:1,0,0")
    faces = [bs.slice_part(p, [60.0], axis=a)[0].face(a) for p, a in ((part, axis), (moved, there))]
    found = [GProp_GProps() for _ in faces]
    for face, into in zip(faces, found, strict=True):
        BRepGProp.SurfaceProperties_s(face, into, 1e-9)
    centres = [np.array([c.X(), c.Y(), c.Z(), 1.0]) for c in (f.CentreOfMass() for f in found)]
    assert place @ centres[0] == pytest.approx(centres[1], abs=1e-6)


def test_an_empty_layer_has_no_face(fixture_step):
    (layer,) = bs.slice_part(bs.read_step(fixture_step("tube")), [500.0], axis=bs.axis_from_text("Z"))
    with pytest.raises(LayerError, match="is empty"):
        layer.face()
