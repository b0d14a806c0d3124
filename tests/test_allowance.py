"""A part grown by its machining allowance: analytic outlines of the grown solid, layers on top, what stands already."""

from __future__ import annotations

import math

import build123d as bd
import pytest
import shapely

import brep_slicer as bs
from brep_slicer.fill import fill_layer
from brep_slicer.substrate.axis import axis_from_text
from fixtures import bodies, gears

CHORD = 0.01


def planned(part, allowance, **more):
    process = bs.Process(
        layer_thickness=1.0, step_over=3.0, motion=bs.Motion(chord=CHORD), layers=bs.Layers(allowance=allowance)
    )
    return bs.plan(part, process, **more)


def turned(*profile):
    wire = bd.Polyline(*[(x, 0.0, z) for x, z in profile], close=True)
    return bd.revolve(bd.make_face(wire), axis=bd.Axis.Z).solid()


@pytest.mark.parametrize("slope", [0.0, 0.5, 1.0, 3.0])
def test_a_cone_grows_along_its_normal(slope):
    # a collar whose end faces lean by dz = -slope * drho: a * sqrt(1 + slope**2) further out along z
    tip = 35.0 - 10.0 * slope
    collar = turned((0, -80), (30, -80), (30, -35), (40, -tip), (40, tip), (30, 35), (30, 80), (0, 80))
    a = 1.5
    made = planned(collar, a, substrate=30.0)
    assert len(made.layers) == 12  # ten of the part, and one and a half millimetres on top
    for layer in made.layers:
        (piece,) = layer.region.pieces
        _, low, _, high = piece.bounds()
        exact = 35.0 - slope * (layer.radius - 30.0) + a * math.hypot(1.0, slope)
        # below the substrate there is nothing to grow from; above the part, only its tip is left, with a round edge
        if layer.radius - 30.0 >= a and layer.radius <= 40.0 - a:
            assert exact <= high <= exact + CHORD
            assert exact <= -low <= exact + CHORD


def test_a_land_is_covered_to_the_allowance():
    collar = turned((0, -80), (30, -80), (30, -20), (40, -20), (40, 20), (30, 20), (30, 80), (0, 80))
    top = planned(collar, 2.0, substrate=30.0).layers[-1]
    assert top.radius == 41.0
    _, low, _, high = top.region.pieces[0].bounds()
    # at 1 mm above the land's edge, the ball of 2 mm round it reaches sqrt(3) further
    assert 20.0 + math.sqrt(3.0) <= high <= 20.0 + math.sqrt(3.0) + 2.0 * CHORD
    assert low == pytest.approx(-high, abs=CHORD)


def test_a_keyway_shrinks_and_the_seam_stays_closed():
    shape = bodies.KeyedBand()
    a = 1.0
    for layer in planned(shape.solid(), a, substrate=shape.inner).layers[2:-2]:
        (piece,) = layer.region.pieces
        (hole,) = piece.holes
        k0, v0, k1, v1 = hole.bounds()
        middle = 0.5 * shape.height
        assert piece.winds
        assert v1 - v0 == pytest.approx(shape.key_length - 2.0 * a, abs=2.0 * CHORD)
        assert abs(0.5 * (v0 + v1) - middle) <= CHORD
        exact = 2.0 * layer.radius * math.asin((0.5 * shape.key_width - a) / layer.radius)
        # kappa is scaled from radius to radius: right to first order in a / rho
        assert k1 - k0 == pytest.approx(exact, abs=2.0 * CHORD + a * a / layer.radius)


def test_the_exact_outline_lies_inside_by_the_allowance():
    solid = gears.tooth_on_shaft(gears.HELICAL_TOOTH)
    a = 0.8
    plain, grown = planned(solid, 0.0, substrate=150.0), planned(solid, a, substrate=150.0)
    for inner, outer in list(zip(plain.layers, grown.layers, strict=False))[3:-3:7]:
        flat = outer.region.to_shapely(chord=1e-3)
        for loop in inner.region.loops:
            line = shapely.LineString(loop.sample(1e-3))
            assert shapely.within(line, flat)
            gap = shapely.distance(shapely.points(loop.sample(0.5)), flat.boundary)
            assert gap.min() >= a - 2e-3
        assert outer.certificate.checks["grown_from_sections"] > 10


def test_beads_of_a_grown_layer_stay_inside_of_it():
    made = planned(bodies.BoxOnShaft().solid(), 1.0, substrate=50.0)
    layer = made.layers[5]
    flat = layer.region.to_shapely(chord=1e-4).buffer(1e-6)
    fill = fill_layer(layer, made.process)
    assert fill.beads
    assert all(shapely.within(shapely.LineString(bead.points), flat) for bead in fill.beads)


def test_nothing_grows_into_what_stands():
    # a block against the flange of a shaft that stands already
    shaft = bodies.flanged_shaft()
    box = bd.Solid.make_box(60.0, 20.0, 20.0, bd.Plane((20.0, -10.0, _flange_top(shaft))))
    block = (box - bd.Solid.make_cylinder(40.0, 200.0, bd.Plane((0.0, 0.0, -50.0)))).solids()[-1]
    both = bd.Compound([shaft, block])
    made = planned(both, 2.0, substrate=40.0, stands=(0,), axis=axis_from_text("Z"))
    for layer in made.layers[1:41:3]:
        v0 = min(piece.bounds()[1] for piece in layer.region.pieces)
        # against the flange as far as it reaches; beyond it, grown all round
        floor = _flange_top(shaft) - (0.0 if layer.radius < 70.0 else 2.0)
        assert v0 == pytest.approx(floor, abs=CHORD)


def _flange_top(shaft):
    flange = max(shaft.faces().filter_by(bd.GeomType.CYLINDER), key=lambda f: f.radius)
    return flange.bounding_box().max.Z


def test_a_negative_allowance_is_refused():
    with pytest.raises(bs.InputError, match="allowance"):
        bs.Process(layer_thickness=1.0, step_over=3.0, layers=bs.Layers(allowance=-1.0))
