"""Spheres cut by cylinders: closed forms, wherever the poles and the seam of the parametrisation lie."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import quad

import brep_slicer as bs
from brep_slicer.section import Engine

bd = pytest.importorskip("build123d")
TURNS = [(0, 0, 0), (90, 0, 0), (90, 0, 90), (0, 90, 0), (20, 30, 0), (45, 45, 45), (0, 180, 12)]


def ball_area(radius: float, d: float, r: float) -> float:
    """R * integral of 2 w, w**2 = r**2 - R**2 - d**2 + 2 R d cos(x), over the angles x where it is positive."""
    cosine = (radius**2 + d**2 - r**2) / (2.0 * radius * d)
    if cosine >= 1.0:
        return 0.0
    h = math.acos(max(cosine, -1.0))
    # x = h sin(s): smooth at both ends
    return quad(
        lambda s: 2.0 * radius * math.sqrt(max(2.0 * radius * d * (math.cos(h * math.sin(s)) - cosine), 0.0)) * h * math.cos(s),
        -0.5 * math.pi,
        0.5 * math.pi,
        epsabs=1e-11,
        epsrel=1e-12,
        limit=400,
    )[0]


def analytic(shape, radii):
    layers = bs.slice_part(shape, radii, axis="Z")
    for layer in layers:
        assert layer.certificate.engine is Engine.ANALYTIC
        assert layer.certificate.fallback == ""
    return [layer.area for layer in layers]


@pytest.mark.parametrize("turn", TURNS)
def test_a_ball_beside_the_axis(turn):
    # at R 30 the poles of the first lie on the layer, at R 35 those of the second; 41.99 is 0.01 mm below its top
    radii = [18.01, 20.0, 25.0, 29.0, 29.999, 30.0, 30.001, 33.0, 35.0, 36.0, 40.0, 41.5, 41.99]
    areas = analytic(bd.Pos(30, 0, 4) * bd.Rot(*turn) * bd.Sphere(12), radii)
    assert areas == pytest.approx([ball_area(r, 30.0, 12.0) for r in radii], rel=1e-9)


@pytest.mark.parametrize("turn", TURNS)
@pytest.mark.parametrize("at", [3.0, 6.0])
def test_a_ball_that_holds_the_axis(at, turn):
    # rings up to R = 14 - d, ovals beyond
    radii = [1.0, 5.0, 7.9, 8.1, 10.9, 11.1, 13.0, 16.0]
    areas = analytic(bd.Pos(at, 0, -2) * bd.Rot(*turn) * bd.Sphere(14), radii)
    assert areas == pytest.approx([ball_area(r, at, 14.0) for r in radii], rel=1e-9)


@pytest.mark.parametrize("turn", TURNS)
def test_a_ball_on_the_axis(turn):
    # two circles, 2 sqrt(r**2 - R**2) apart
    radii = [2.0, 9.0, 13.999]
    areas = analytic(bd.Rot(*turn) * bd.Sphere(14), radii)
    assert areas == pytest.approx([2.0 * math.pi * r * 2.0 * math.sqrt(14.0**2 - r * r) for r in radii], rel=1e-10)


@pytest.mark.parametrize("turn", TURNS)
def test_a_ball_on_its_shaft(turn):
    # at R 20 the section is the edge between both, whether the seam crosses it or not
    radii = [20.0, 20.5, 27.0, 30.0, 35.0, 41.9]
    areas = analytic(bd.Cylinder(20, 60) + bd.Pos(30, 0, 0) * bd.Rot(*turn) * bd.Sphere(12), radii)
    assert areas[1:] == pytest.approx([ball_area(r, 30.0, 12.0) for r in radii[1:]], rel=1e-9)
    # the edge is OCCT's intersection curve, good to 1e-4 mm along some 60 mm
    assert areas[0] == pytest.approx(ball_area(20.0, 30.0, 12.0), abs=6e-3)


@pytest.mark.parametrize("turn", TURNS)
def test_a_hollow_in_a_block(turn):
    # metal outside of the sphere: the same oval, run through the other way, is a hole
    block = bd.Pos(30, 0, 0) * bd.Box(24, 30, 40)
    radii = [22.5, 26.0, 30.0, 33.0, 38.5]
    whole = analytic(block, radii)
    areas = analytic(block - bd.Pos(30, 0, 0) * bd.Rot(*turn) * bd.Sphere(9), radii)
    assert np.subtract(whole, areas) == pytest.approx([ball_area(r, 30.0, 9.0) for r in radii], rel=1e-9)


@pytest.mark.parametrize("turn", TURNS)
@pytest.mark.parametrize("cut", [(0, 0, 90), (0, 90, 0), (30, 20, 0)])
def test_two_halves_make_the_whole(cut, turn):
    ball = bd.Pos(30, 0, 0) * bd.Rot(*turn) * bd.Sphere(12)
    plane = bd.Plane((30, 0, 0)).rotated(cut)
    radii = [20.0, 26.0, 31.0, 35.0, 40.0]
    halves = [analytic(bd.split(ball, plane, keep=keep), radii) for keep in (bd.Keep.TOP, bd.Keep.BOTTOM)]
    assert np.sum(halves, axis=0) == pytest.approx([ball_area(r, 30.0, 12.0) for r in radii], rel=1e-8)
