"""Sheets: isometries between space and plane, closures by their formulas, cones that become cylinders."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely

from brep_slicer.layers import Closure, Cones, Cylinders, Planes

DEG = math.pi / 180.0


@pytest.fixture
def rng():
    return np.random.default_rng(15)


FAMILIES = [
    Cylinders(),
    *(Cones(a) for a in (10.0, -10.0, 30.0, -30.0, 60.0, -60.0, 1e-4, 85.0)),
    Planes(),
    Planes((1.0, 0.0, 0.0)),
    Planes((0.6, 0.0, 0.8)),
    Planes((-2 / 3, 1 / 3, 2 / 3)),
]
TURNING = [family for family in FAMILIES if not family.closure(20.0).is_open]


def named(family) -> str:
    return repr(family)


def flat_points(family, level: float, rng, count: int = 200) -> np.ndarray:
    """Random (kappa, v) of the sheet's own copy: rho > 1 mm."""
    closure = family.closure(level)
    if closure.is_open:
        return rng.uniform(-30.0, 30.0, (count, 2))
    heights = rng.uniform(-10.0, 10.0, count)
    rho = (closure.length + closure.angle * heights) / (2.0 * math.pi)
    return closure.at(rng.uniform(-0.49, 0.49, count), heights)[rho > 1.0]


@pytest.mark.parametrize("family", FAMILIES, ids=named)
def test_a_sheet_lies_on_its_level_and_comes_back(family, rng):
    sheet = family.sheet(20.0)
    flat = flat_points(family, 20.0, rng)
    space = sheet.space_from_flat(flat)
    assert np.abs(family.value(space) - 20.0).max() < 1e-12
    assert np.abs(sheet.flat_from_space(space) - flat).max() < 1e-12
    one = np.concatenate([space, np.ones((len(space), 1))], axis=1)
    assert np.abs(np.einsum("ni,ij,nj->n", one, family.quadric(20.0), one)).max() < 1e-10 * 20.0**2


@pytest.mark.parametrize("family", FAMILIES, ids=named)
def test_the_plane_is_an_isometry_seen_from_outside(family, rng):
    """Tangents by differences: unit, upright on each other, kappa x v along the gradient of c, itself of unit length."""
    sheet, h = family.sheet(20.0), 1e-5
    flat = flat_points(family, 20.0, rng)
    moves = [
        (sheet.space_from_flat(flat + h * np.eye(2)[i]) - sheet.space_from_flat(flat - h * np.eye(2)[i])) / (2 * h)
        for i in (0, 1)
    ]
    assert np.abs(np.linalg.norm(moves, axis=-1) - 1.0).max() < 1e-8
    assert np.abs(np.einsum("ij,ij->i", *moves)).max() < 1e-8
    normals = sheet.normals_from_flat(flat)
    assert np.abs(np.cross(*moves) - normals).max() < 1e-8
    assert np.abs(normals - family.gradient(sheet.space_from_flat(flat))).max() < 1e-12


@pytest.mark.parametrize("family", TURNING, ids=named)
def test_copies_lie_at_the_same_place_in_space(family, rng):
    sheet, closure = family.sheet(20.0), family.closure(20.0)
    flat = flat_points(family, 20.0, rng)
    # on a cone the plane round the apex is used up after 2 pi / angle turns: farther copies look like nearer ones
    for turns in [t for t in (-2, -1, 1, 3) if (abs(t) + 0.5) * abs(closure.angle) < math.pi]:
        moved = closure.moved(flat, turns)
        assert np.abs(sheet.space_from_flat(moved) - sheet.space_from_flat(flat)).max() < 1e-10
        assert np.abs(closure.motion(turns).points(flat) - moved).max() < 1e-12
    once = closure.moved(flat, 1)
    if 1.5 * abs(closure.angle) < math.pi:
        assert np.array_equal(closure.copies_of(once), np.ones(len(flat)))
        assert np.abs(closure.canonical(once) - flat).max() < 1e-11
        assert np.array_equal(closure.nearest_turns(once, flat), -np.ones(len(flat)))
        assert np.abs(closure.distances(flat, once)).max() < 1e-11
    assert np.abs(closure.at(closure.turns_of(flat), closure.heights_of(flat)) - flat).max() < 1e-12


def test_a_cone_develops_into_a_sector():
    """alpha = 30 degrees: once round is a sector of 360 sin(30) = 180 degrees; level c has its apex at v = c cot(alpha)."""
    alpha, c = 30.0 * DEG, 12.0
    closure, apex = Cones(math.degrees(alpha)).closure(c), c / math.tan(alpha)
    ring = closure.at(np.linspace(-0.5, 0.5, 9), np.full(9, 3.0))
    assert np.abs(np.hypot(ring[:, 0], ring[:, 1] - apex) - (apex - 3.0)).max() < 1e-12
    assert ring[-1] @ [1, 0] == pytest.approx(apex - 3.0)
    assert ring[0] @ [1, 0] == pytest.approx(3.0 - apex)
    assert abs(closure.angle) == pytest.approx(math.pi)


def test_a_cylinder_closes_by_two_pi_r():
    closure = Cylinders().closure(7.0)
    assert closure.length == pytest.approx(14.0 * math.pi)
    assert closure.is_translation
    assert closure.moved(np.array([[1.0, 2.0]]), 2) == pytest.approx(np.array([[1.0 + 28.0 * math.pi, 2.0]]))


@pytest.mark.parametrize("alpha", [1e-6, -1e-6, 1e-9])
def test_flat_cones_become_cylinders(alpha, rng):
    """To first order in alpha: rho = c - h alpha, so that places differ by less than alpha times the extent squared over c."""
    flat = rng.uniform(-30.0, 30.0, (100, 2))
    cone, cylinder = Cones(math.degrees(alpha)).sheet(20.0), Cylinders().sheet(20.0)
    bound = 5.0 * abs(alpha) * 30.0**2 / 20.0
    assert np.abs(cone.space_from_flat(flat) - cylinder.space_from_flat(flat)).max() < bound
    assert np.abs(cone.closure.moved(flat, 3) - cylinder.closure.moved(flat, 3)).max() < 1e3 * abs(alpha) * 400.0
    # and without loss of digits: an isometry as good as any
    assert (
        np.abs(cone.flat_from_space(cone.space_from_flat(flat)) - flat).max() < 1e-12 or abs(flat[:, 0]).max() > 20.0 * math.pi
    )


@pytest.mark.parametrize("family", TURNING, ids=named)
def test_a_window_holds_its_turns_and_no_others(family, rng):
    closure = family.closure(20.0)
    if abs(closure.angle) > 0.9 * 2.0 * math.pi:
        pytest.skip("once round is nearly the whole plane about the apex")
    bottom, top = -5.0, 4.0
    if family.half_angle > 80.0 * DEG:
        bottom, top = -5.0, 0.5
    window = closure.window(-0.4, 0.4, bottom, top)
    assert window.is_valid
    turns, heights = rng.uniform(-0.49, 0.49, 500), rng.uniform(bottom + 1e-9, top - 1e-9, 500)
    inside = shapely.contains_xy(window, closure.at(turns, heights))
    assert np.array_equal(inside, np.abs(turns) < 0.4)


def test_a_plane_has_no_copies():
    closure = Planes().closure(3.0)
    points = np.array([[1.0, 2.0], [-30.0, 4.0]])
    assert closure.is_open
    assert np.array_equal(closure.moved(points, 0), points)
    assert np.array_equal(closure.copies_of(points), np.zeros(2))
    assert list(closure.copies_between((0, 0, 1, 1), -9.0, 9.0)) == [0]
    assert closure.distances(points[:1], points[1:]) == pytest.approx(math.hypot(31.0, 2.0))


@pytest.mark.parametrize("bad", [90.0, -180.0, math.nan])
def test_cones_that_are_planes_are_refused(bad):
    with pytest.raises(ValueError, match="planes"):
        Cones(bad)


def test_normals_have_unit_length():
    with pytest.raises(ValueError, match="unit vector"):
        Planes((1.0, 1.0, 0.0))


def test_copies_between_are_those_that_reach():
    closure = Closure(10.0)
    assert list(closure.copies_between((1.0, 0.0, 2.0, 1.0), 0.0, 2.0)) == [0, 1]
    assert list(closure.copies_between((-12.0, 0.0, -9.0, 1.0), 0.0, 1.0)) == [1, 2]
