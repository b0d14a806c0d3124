"""A face's surface as rational Bezier patches: what bounds and proofs are made on.

In: a Surface and the box of a face in (u, v). Out: Patches that cover the box (they may reach beyond it).

Words: *homogeneous*, coordinates multiplied by a weight, which comes last; *local*, 0 to 1 over a patch.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from brep_slicer.maps import Array

from .edge_curves import BSplineEdge, ConicEdge, EdgeCurve, LineEdge
from .polynomials import breaks_between, spans_of, wrapped
from .surfaces import BSplineSurface, ElementarySurface, Extrusion, Revolution, Surface, SurfaceKind


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Spans:
    """Rational Bezier spans of a curve: `control` (m, p + 1, d + 1), homogeneous, over the parameters `range` (m, 2).

    Where `round`, the local coordinate is no linear function of the parameter, but that of a circle's arc.
    """

    control: Array
    range: Array
    round: bool = False


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Patches:
    """Rational Bezier patches: `control` (m, p + 1, q + 1, 4), homogeneous, over `ranges` (m, 2, 2) = [[u0, u1], [v0, v1]]."""

    control: Array
    ranges: Array
    round: tuple[bool, bool]

    def parameters(self, which: Array, local: Array) -> Array:
        """(u, v) (n, 2) at local coordinates (n, 2) of the patches `which` (n,)."""
        out = np.empty_like(local)
        for k in (0, 1):
            first, last = self.ranges[which, k].T
            share = local[:, k]
            if self.round[k]:
                # a circle's rational quadratic arc: tan of a quarter of the angle is linear in the local coordinate
                half = 0.5 * (last - first)
                share = 0.5 + np.arctan((2.0 * share - 1.0) * np.tan(0.5 * half)) / half
            out[:, k] = first + share * (last - first)
        return out


def patches_of(surface: Surface, box: Array) -> Patches:
    """The patches of a surface over box (2, 2) = [[u0, v0], [u1, v1]].

    Raises
    ------
    TypeError
        For a plane, which needs none.
    """
    if isinstance(surface, BSplineSurface):
        return _of_bspline(surface, box)
    if isinstance(surface, Extrusion):
        return _of_extrusion(surface, box)
    if isinstance(surface, Revolution):
        profile = curve_spans(surface.curve, float(box[0, 1]), float(box[1, 1]))
        weight = profile.control[..., 3:]
        arm = profile.control[..., :3] - weight * surface.origin
        along = arm @ surface.axis
        out = arm - along[..., None] * surface.axis
        return _turned(profile, (out, np.cross(surface.axis, out), along[..., None] * surface.axis), surface.origin, box)
    if isinstance(surface, ElementarySurface) and surface.kind is not SurfaceKind.PLANE:
        profile = curve_spans(_profile(surface), float(box[0, 1]), float(box[1, 1]))
        x, y, z = surface.frame
        rho, height = profile.control[..., :1], profile.control[..., 1:2]
        return _turned(profile, (rho * x, rho * y, height * z), surface.origin, box)
    raise TypeError(f"no patches for a surface of kind {surface.kind.value}")


def curve_spans(curve: EdgeCurve, first: float, last: float) -> Spans:
    """The spans of a curve that cover its parameters from first to last."""
    if isinstance(curve, BSplineEdge):
        number, ranges = _pieces(curve._breaks, curve.period, first, last)
        control = curve._coefficients[number]
        if curve.weights is None:
            control = np.concatenate([control, np.ones((*control.shape[:-1], 1))], axis=-1)
        return Spans(control=control, range=ranges)
    if isinstance(curve, ConicEdge):
        breaks = curve.breaks(first, last)
        middle, weight = 0.5 * (breaks[1:] + breaks[:-1]), np.cos(0.5 * np.diff(breaks))[:, None]
        out = np.cos(middle)[:, None] * curve.x + np.sin(middle)[:, None] * curve.y
        inner = np.concatenate([weight * curve.centre + out, weight], axis=1)
        ends = np.concatenate([curve.points(breaks), np.ones((len(breaks), 1))], axis=1)
        return Spans(
            control=np.stack([ends[:-1], inner, ends[1:]], axis=1),
            range=np.stack([breaks[:-1], breaks[1:]], axis=1),
            round=True,
        )
    assert isinstance(curve, LineEdge)
    ends = np.concatenate([curve.points(np.array([first, last])), np.ones((2, 1))], axis=1)
    return Spans(control=ends[None], range=np.array([[first, last]]))


def _pieces(breaks: Array, period: float, first: float, last: float) -> tuple[Array, Array]:
    """Numbers (m,) of the spans that cover the parameters from first to last, and their ranges (m, 2) there."""
    inner = breaks_between(breaks, period, first, last)
    middle = 0.5 * (inner[:-1] + inner[1:])
    number, local, width = spans_of(breaks, wrapped(middle, breaks, period))
    begin = middle - local * width
    return number, np.stack([begin, begin + width], axis=1)


def _of_bspline(surface: BSplineSurface, box: Array) -> Patches:
    (nu, ru), (nv, rv) = (_pieces(surface._breaks[k], surface.period[k], *box[:, k].tolist()) for k in (0, 1))
    control = surface._coefficients[nu[:, None], nv[None, :]]
    if surface.weights is None:
        control = np.concatenate([control, np.ones((*control.shape[:-1], 1))], axis=-1)
    return _grid(control, ru, rv, (False, False))


def _of_extrusion(surface: Extrusion, box: Array) -> Patches:
    spans = curve_spans(surface.curve, float(box[0, 0]), float(box[1, 0]))
    weight = spans.control[..., 3:]
    moved = [
        spans.control + np.concatenate([weight * v * surface.direction, 0.0 * weight], axis=-1) for v in box[:, 1].tolist()
    ]
    return _grid(np.stack(moved, axis=2)[:, None], spans.range, box[None, :, 1], (spans.round, False))


def _profile(surface: ElementarySurface) -> EdgeCurve:
    """(distance from the surface's own axis, height along it) as a curve of v."""
    zero, one = np.zeros(2), np.array([surface.radius, 0.0])
    if surface.kind is SurfaceKind.CYLINDER:
        return LineEdge(origin=one, direction=np.array([0.0, 1.0]))
    if surface.kind is SurfaceKind.CONE:
        return LineEdge(origin=one, direction=np.array([math.sin(surface.half_angle), math.cos(surface.half_angle)]))
    centre, size = (zero, surface.radius) if surface.kind is SurfaceKind.SPHERE else (one, surface.minor)
    return ConicEdge(centre=centre, x=np.array([size, 0.0]), y=np.array([0.0, size]))


def _turned(profile: Spans, parts: tuple[Array, Array, Array], origin: Array, box: Array) -> Patches:
    """origin + cos(u) a(v) + sin(u) b(v) + c(v), the parts (a, b, c) (m, q + 1, 3) homogeneous like the profile."""
    circle = ConicEdge(centre=np.zeros(2), x=np.array([1.0, 0.0]), y=np.array([0.0, 1.0]))
    arcs = curve_spans(circle, float(box[0, 0]), float(box[1, 0]))
    cos, sin, one = (arcs.control[:, None, :, None, k, None] for k in range(3))
    weight = profile.control[..., -1:]
    a, b, c, w = (part[None, :, None] for part in (*parts, weight))
    control = np.concatenate([cos * a + sin * b + one * (c + w * origin), one * w], axis=-1)
    return _grid(control, arcs.range, profile.range, (True, profile.round))


def _grid(control: Array, ru: Array, rv: Array, round_: tuple[bool, bool]) -> Patches:
    """Patches from control points (m, n, p + 1, q + 1, 4) on a grid of spans."""
    ranges = np.stack(np.broadcast_arrays(ru[:, None], rv[None, :]), axis=2)
    return Patches(control=control.reshape(-1, *control.shape[2:]), ranges=ranges.reshape(-1, 2, 2), round=round_)
