"""Traced curves on cylinders, cones and spheres in any position, put into their closed form.

In: a traced spline on such a face. Out: the QuadricCurve through the same points, or the spline if they do not agree.

On p = (R cos theta, R sin theta, v) the surface |d|**2 - k (d . w)**2 = r**2, d = p - o, is a quadratic in v:
k = 1 for a cylinder, 0 for a sphere, 1 / cos(half angle)**2 for a cone about its apex.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from brep_slicer.curves import Curve, QuadricCurve, SplineCurve
from brep_slicer.geometry import ElementarySurface, Face, SurfaceKind
from brep_slicer.maps import TURN, Array

# The closed form has to pass through the traced points this near, mm.
AGREEMENT = 1e-9
SAMPLES = 65
# A curve at whose end the discriminant is less than this share of its most is steep there, and told by the angle of a fold:
# v by kappa grows without bounds where the roots meet, and no quadrature follows it.
STEEP_SHARE = 0.05
# Where the discriminant is less than this share of the terms that it is the difference of, both roots have met: rounding.
ROUNDING = 1e-14
# A fold with one end only goes so many times the curve's width on: no point of the curve is then nearer to its other end.
BEYOND = 4.0


def closed_form_on_quadric(face: Face, curve: Curve, radius: float) -> Curve:
    """The quadric that a traced curve is, or the curve as it is."""
    surface = face.surface
    if not isinstance(curve, SplineCurve) or not isinstance(surface, ElementarySurface):
        return curve
    if surface.kind not in (SurfaceKind.CYLINDER, SurfaceKind.CONE, SurfaceKind.SPHERE):
        return curve
    a, b, c = _coefficients(surface, radius)
    if abs(a) < 1e-9:
        return curve
    points = curve.points(np.linspace(0.0, 1.0, SAMPLES))
    side = np.sign(a * points[:, 1] + _trigonometric(b, points[:, 0] / radius))
    step = np.diff(points[:, 0])
    made = None
    if (step > 0.0).all() or (step < 0.0).all():
        branch = int(side[SAMPLES // 2])
        ends = (float(points[0, 0]), float(points[-1, 0]))
        plain = QuadricCurve(a=a, b=b, c=c, radius=radius, branch=branch, range=ends, face=face.index)
        made = _steep_at_an_end(plain)
    else:
        made = _folded(a, b, c, radius, points, side, face.index)
    return made if made is not None and _agrees(made, curve) else curve


def _coefficients(surface: ElementarySurface, radius: float) -> tuple[float, Array, Array]:
    """a, b(theta), c(theta) of the quadratic a v**2 + 2 b v + c, as QuadricCurve takes them."""
    o, w, r, k = surface.origin, surface.frame[2], surface.radius, 1.0
    if surface.kind is SurfaceKind.SPHERE:
        k = 0.0
    elif surface.kind is SurfaceKind.CONE:
        tan = np.tan(surface.half_angle)
        o, r, k = o - w * surface.radius / tan, 0.0, 1.0 + tan * tan
    # d = m + v e_z, m = R e_rho - o; m . w = alpha + R (w_x cos + w_y sin)
    alpha = -float(o @ w)
    mw = np.array([alpha, radius * w[0], radius * w[1]])
    b = -k * w[2] * mw
    b[0] -= o[2]
    c = np.zeros(5)
    c[0] = radius**2 + float(o @ o) - r * r - k * (alpha**2 + 0.5 * radius**2 * (w[0] ** 2 + w[1] ** 2))
    c[1:3] = -2.0 * radius * o[:2] - 2.0 * k * alpha * radius * w[:2]
    c[3] = -0.5 * k * radius**2 * (w[0] ** 2 - w[1] ** 2)
    c[4] = -k * radius**2 * w[0] * w[1]
    return float(1.0 - k * w[2] ** 2), b, c


def _trigonometric(coefficients: Array, theta: Array) -> Array:
    terms = [np.ones_like(theta), np.cos(theta), np.sin(theta), np.cos(2.0 * theta), np.sin(2.0 * theta)]
    return sum(x * t for x, t in zip(coefficients, terms, strict=False))


def _discriminant(a: float, b: Array, c: Array, radius: float) -> Callable[[Array], Array]:
    """b**2 - a c by kappa: the two roots meet where it vanishes."""
    return lambda kappa: _trigonometric(b, kappa / radius) ** 2 - a * _trigonometric(c, kappa / radius)


def _steep_at_an_end(plain: QuadricCurve) -> QuadricCurve:
    """The same curve, by the angle of a fold if both roots meet at one of its ends, or not far beyond it."""
    discriminant = _discriminant(plain.a, plain.b, plain.c, plain.radius)
    low, high = sorted(plain.range)
    value = discriminant(np.linspace(low, high, SAMPLES))
    steep = value[[0, -1]] < STEEP_SHARE * value.max()
    noise = ROUNDING * (np.abs(plain.b).sum() ** 2 + abs(plain.a) * np.abs(plain.c).sum())
    ends = [
        _meeting_beyond(discriminant, end, way * (high - low), noise) if flag else None
        for end, way, flag in zip((low, high), (-1.0, 1.0), steep, strict=True)
    ]
    if ends[0] is None and ends[1] is None:
        return plain
    first = ends[0] if ends[0] is not None else low - BEYOND * (high - low)
    last = ends[1] if ends[1] is not None else high + BEYOND * (high - low)
    middle, half = 0.5 * (first + last), 0.5 * (last - first)
    # by the way from the end that is there: the cosine of a small angle loses half of the digits
    kappa = np.array(plain.range)
    from_first, from_last = (
        2.0 * np.arcsin(np.sqrt(np.clip(way / (last - first), 0.0, 1.0))) for way in (kappa - first, last - kappa)
    )
    p, q = np.where(kappa < middle, from_first, np.pi - from_last).tolist()
    return replace(plain, range=(p, q), fold=(middle, half))


def _meeting_beyond(discriminant: Callable[[Array], Array], end: float, reach: float, noise: float) -> float | None:
    """Where both roots meet between `end` and `reach` mm beyond; the end itself where they have met within `noise`."""
    from scipy.optimize import brentq

    at, beyond = (float(discriminant(np.array([k]))[0]) for k in (end, end + reach))
    if at <= noise:
        return end
    if beyond >= 0.0:
        return None
    return float(brentq(lambda k: float(discriminant(np.array([k]))[0]), end, end + reach, xtol=1e-15, rtol=1e-15))


def _folded(a: float, b: Array, c: Array, radius: float, points: Array, side: Array, face: int) -> QuadricCurve | None:
    """A curve that turns back in kappa: between the two angles where both roots meet."""
    discriminant = _discriminant(a, b, c, radius)
    inside = float(points[np.abs(side).argmax() if side.any() else SAMPLES // 2, 0])
    inside = float(points[SAMPLES // 2, 0]) if discriminant(np.array([inside]))[0] <= 0.0 else inside
    ends = [_fold_end(discriminant, inside, way, 0.5 * TURN * radius) for way in (-1.0, 1.0)]
    if ends[0] is None or ends[1] is None:
        return None
    middle, half = 0.5 * (ends[0] + ends[1]), 0.5 * (ends[1] - ends[0])
    angle = np.arccos(np.clip((middle - points[:, 0]) / half, -1.0, 1.0))
    # the branch +1 takes the angles from 0 to pi, the other one those from pi to 2 pi
    angle = np.unwrap(np.where(side >= 0.0, angle, TURN - angle))
    return QuadricCurve(
        a=a, b=b, c=c, radius=radius, branch=1, range=(float(angle[0]), float(angle[-1])), fold=(middle, half), face=face
    )


def _fold_end(discriminant: Callable[[Array], Array], start: float, way: float, reach: float) -> float | None:
    """Where the discriminant first vanishes from `start` on, within half a turn."""
    from scipy.optimize import brentq

    kappa = start + way * np.linspace(0.0, reach, 513)
    value = discriminant(kappa)
    below = np.flatnonzero(value < 0.0)
    if value[0] <= 0.0 or not len(below):
        return None
    i = int(below[0])
    return float(brentq(lambda k: float(discriminant(np.array([k]))[0]), kappa[i - 1], kappa[i], xtol=1e-15, rtol=1e-15))


def _agrees(made: QuadricCurve, curve: SplineCurve) -> bool:
    """Whether the ends are the same, every sampled point of the closed form lies on the traced curve, and both bound the same.

    Two ovals that are about to meet look like one curve to points alone; the integral of v along them tells them apart.
    """
    if abs(made.moment(1) - curve.moment(1)) > 4.0 * AGREEMENT * curve.length():
        return False
    if np.abs(made.start - curve.start).max() > AGREEMENT or np.abs(made.end - curve.end).max() > AGREEMENT:
        return False
    p = made.points(np.linspace(0.0, 1.0, 33))
    from brep_slicer.curves.base import distance_to_curve

    return bool(distance_to_curve(curve, p).max() <= AGREEMENT)
