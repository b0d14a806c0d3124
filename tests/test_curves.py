"""Unrolled curves: ends, derivatives, exact integrals, samples, for every kind."""

from __future__ import annotations

import numpy as np
import pytest

from brep_slicer.curves import CurveBatch, LineCurve, QuadricCurve, SinusoidCurve
from brep_slicer.curves.spline import span_nodes, spline_through_nodes, straightened

R = 40.0


def _cross_hole(a: float = 8.0) -> QuadricCurve:
    # z**2 + (R sin theta)**2 = a**2: the hole of radius a along x
    half = R * np.arcsin(a / R)
    c = np.array([0.5 * R * R - a * a, 0.0, 0.0, -0.5 * R * R, 0.0])
    return QuadricCurve(a=1.0, b=np.zeros(3), c=c, radius=R, branch=1, range=(0.0, 2.0 * np.pi), fold=(0.0, half))


def _spline():
    x = span_nodes(7)
    s = np.concatenate([0.5 * x, 0.5 + 0.5 * x]).reshape(2, 8)
    nodes = np.stack([10.0 * s, 3.0 * np.sin(2.0 * s)], axis=-1)
    return spline_through_nodes(nodes, np.array([0.0, 0.5, 1.0]))


CURVES = {
    "line": LineCurve(p0=(1.0, 2.0), p1=(7.0, -3.0)),
    "sinusoid": SinusoidCurve(coefficients=np.array([5.0, 2.0, -1.0]), radius=R, range=(-30.0, 50.0)),
    "quadric": _cross_hole(),
    "spline": _spline(),
}


@pytest.mark.parametrize("curve", CURVES.values(), ids=CURVES)
class TestEveryKind:
    def test_derivatives_are_those_of_the_points(self, curve):
        s = np.linspace(0.05, 0.95, 19)
        h = 1e-6
        slope = (curve.points(s + h) - curve.points(s - h)) / (2.0 * h)
        assert np.allclose(curve.derivatives(s), slope, atol=1e-5 * np.abs(slope).max())

    def test_reversed_runs_back(self, curve):
        s = np.linspace(0.0, 1.0, 11)
        assert np.allclose(curve.reversed().points(s), curve.points(1.0 - s), atol=1e-12)
        assert curve.reversed().moment(1) == pytest.approx(-curve.moment(1), abs=1e-9)

    def test_trimmed_is_a_part(self, curve):
        part = curve.trimmed(0.2, 0.7)
        assert np.allclose(part.start, curve.points(np.array([0.2]))[0], atol=1e-11)
        assert np.allclose(part.end, curve.points(np.array([0.7]))[0], atol=1e-11)
        whole = curve.trimmed(1e-300, 0.2).moment(1) + part.moment(1) + curve.trimmed(0.7, 1.0).moment(1)
        assert whole == pytest.approx(curve.moment(1), rel=1e-10, abs=1e-10)

    def test_integrals_agree_with_a_fine_polyline(self, curve):
        p = curve.points(np.linspace(0.0, 1.0, 200_001))
        v = 0.5 * (p[1:, 1] + p[:-1, 1])
        assert curve.moment(1) == pytest.approx(float(np.sum(v * np.diff(p[:, 0]))), rel=1e-7, abs=1e-7)
        assert curve.moment(2) == pytest.approx(float(np.sum(v**2 * np.diff(p[:, 0]))), rel=1e-7, abs=1e-7)
        assert curve.length() == pytest.approx(np.hypot(*np.diff(p, axis=0).T).sum(), rel=1e-7)

    def test_samples_stay_within_the_chord(self, curve):
        from shapely import LineString, points

        polyline = LineString(curve.sample(1e-3))
        off = polyline.distance(points(curve.points(np.linspace(0.0, 1.0, 2001))))
        assert off.max() <= 1e-3

    def test_bounds_hold_the_curve(self, curve):
        k0, v0, k1, v1 = curve.bounds()
        p = curve.points(np.linspace(0.0, 1.0, 1001))
        assert (p >= np.array([k0, v0]) - 1e-9).all()
        assert (p <= np.array([k1, v1]) + 1e-9).all()

    def test_another_radius_keeps_the_angles(self, curve):
        s = np.linspace(0.0, 1.0, 9)
        moved = curve.on_radius(R, 50.0).points(s)
        assert np.allclose(moved, curve.points(s) * [50.0 / R, 1.0], atol=1e-10)


def test_a_fold_is_as_exact_at_its_ends():
    hole = _cross_hole(8.0)
    p = np.array([0.0, 1e-9, 1e-6, 1e-4, 0.3, np.pi - 1e-6, np.pi, 2.0 * np.pi - 1e-5])
    points, slopes = hole.points(p / (2.0 * np.pi)), hole.derivatives(p / (2.0 * np.pi))
    # with sin(theta) = 8 / R sin(x), cos(p) = theta / max theta: near the ends v = +-8 sin(q sqrt(...)), v / sin p is bounded
    top = np.arcsin(8.0 / R)
    theta = -top * np.cos(p)
    # 8**2 - R**2 sin(theta)**2 = R**2 sin(top - |theta|) sin(top + |theta|), and top - |theta| = 2 top sin(q / 2)**2
    q = np.minimum(np.minimum(p, np.abs(np.pi - p)), 2.0 * np.pi - p)
    nearer = 2.0 * top * np.sin(0.5 * q) ** 2
    v = R * np.sqrt(np.sin(nearer) * np.sin(2.0 * top - nearer)) * np.where(p <= np.pi, 1.0, -1.0)
    np.testing.assert_allclose(points[:, 1], v, rtol=1e-14, atol=1e-14)
    np.testing.assert_allclose(points[:, 0], R * theta, rtol=1e-14, atol=1e-13)
    # at the ends of the fold |dv / dp| = R sqrt(top / 2 sin(2 top))
    steep = 2.0 * np.pi * R * np.sqrt(0.5 * top * np.sin(2.0 * top))
    np.testing.assert_allclose(slopes[[0, 6], 1], [steep, -steep], rtol=1e-13)


def test_area_of_a_cross_hole():
    # 4 r**2 [E(k) - (1 - k**2) K(k)], k = a / r
    from scipy.special import ellipe, ellipk

    m = (8.0 / R) ** 2
    assert abs(_cross_hole().moment(1)) == pytest.approx(4 * R * R * (ellipe(m) - (1 - m) * ellipk(m)), rel=1e-12)


def test_a_straight_spline_is_a_line_and_a_bent_one_is_not():
    x = span_nodes(7)
    straight = spline_through_nodes(np.stack([5.0 * x, 2.0 * x], axis=-1)[None], np.array([0.0, 1.0]))
    assert isinstance(straightened(straight, 1e-9), LineCurve)
    assert straightened(_spline(), 1e-9).kind.value == "spline"


def test_values_that_are_not_finite_are_refused():
    with pytest.raises(ValueError, match="p1 holds a value that is not finite"):
        LineCurve(p0=(0.0, 0.0), p1=(np.nan, 1.0))


def test_a_batch_gives_what_its_curves_give():
    """Every kind several times over, asked for in any order; a quadric without a fold and a linear one as well."""
    plain = QuadricCurve(a=1.0, b=(1.0, 0.5, 0.2), c=(-9.0, 1.0, 0.5, 0.2, 0.1), radius=R, branch=-1, range=(-40.0, 60.0))
    linear = QuadricCurve(a=0.0, b=(4.0, 0.5, 0.2), c=(-9.0, 1.0, 0.5, 0.2, 0.1), radius=R, branch=1, range=(60.0, -40.0))
    curves = [curve for c in (*CURVES.values(), plain, linear) for curve in (c, c.reversed(), c.trimmed(0.2, 0.7))]
    batch = CurveBatch(curves)
    rng = np.random.default_rng(5)
    numbers, s = rng.integers(len(curves), size=4000), rng.uniform(size=4000)
    points, derivatives = batch.at(numbers, s)
    for i, curve in enumerate(curves):
        rows = numbers == i
        np.testing.assert_allclose(points[rows], curve.points(s[rows]), rtol=0.0, atol=1e-12)
        np.testing.assert_allclose(derivatives[rows], curve.derivatives(s[rows]), rtol=1e-10, atol=1e-10)
