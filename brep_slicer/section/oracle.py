"""The area of a layer without cutting anything: a surface integral over the faces outside of it.

In: a solid's numpy geometry and a radius. Out: the area of the section, with no nodes and no curves in common with the engines.

div(e_rho / rho) = 0 away from the axis, so the flux of e_rho / rho through the section at R equals that through the part of the
solid's boundary that lies outside of R: A(R) = R * integral of (n . e_rho) / rho dS over the faces where rho > R.

Words: *line*, a line u = const in a face's parameters; *stretch*, a part of it that lies inside of the trimming and outside
of R.
"""

from __future__ import annotations

import itertools

import numpy as np

from brep_slicer.field import radii_of
from brep_slicer.geometry import Brep, EdgeUse, Face
from brep_slicer.maps import Array

# Lines a smooth piece of a face's range in u, and how finely pcurves are sampled for their crossings with the lines.
PANEL_NODES, PANELS, PCURVE_SAMPLES = 8, 12, 1500
# Points along a line between which rho - R is searched for sign changes.
SEARCH = 96
NODES_ALONG = 8


def area_by_flux(brep: Brep, radius: float, *, panels: int = PANELS) -> float:
    """Area (mm**2) of the section at `radius` (mm) by the surface integral; more `panels` for more digits.

    Where no kink falls inside of a panel the result has twelve digits; elsewhere about six.
    """
    return radius * sum(_flux(face, radius, panels) for face in brep.faces)


def _flux(face: Face, radius: float, panels: int) -> float:
    """Integral of sign * (S_u x S_v) . e_rho / rho over the face where rho > R."""
    u, weights = _lines(face, radius, panels)
    line, low, high = _inside(face, u)
    line, low, high = _beyond(face, u, line, low, high, radius)
    if not len(line):
        return 0.0
    x, w = np.polynomial.legendre.leggauss(NODES_ALONG)
    # every stretch is cut at the surface's breaks, so that the integrand is smooth along it
    line, low, high = _at_breaks(face, line, low, high)
    v = 0.5 * (low + high)[:, None] + 0.5 * (high - low)[:, None] * x
    uv = np.stack([np.repeat(u[line], NODES_ALONG), v.ravel()], axis=1)
    p, su, sv = face.surface.derivatives(uv)
    cross = np.cross(su, sv)
    flux = (cross[:, 0] * p[:, 0] + cross[:, 1] * p[:, 1]) / (p[:, 0] ** 2 + p[:, 1] ** 2)
    inner = (flux.reshape(-1, NODES_ALONG) * w).sum(axis=1) * 0.5 * (high - low)
    return face.sign * float(np.sum(inner * weights[line]))


def _lines(face: Face, radius: float, panels: int) -> tuple[Array, Array]:
    """Gauss nodes in u and their weights, on panels between everything that makes the integrand kink."""
    marks = [face.surface.breaks(face.box)[0]]
    for loop in face.loops:
        for use in loop:
            if use.pcurve is None:
                continue
            p = use.pcurve.points(np.linspace(*use.range, 129))
            marks.append(p[[0, -1], 0])
            turns = np.flatnonzero(np.diff(np.sign(np.diff(p[:, 0]))) != 0)
            marks.append(p[turns + 1, 0])
            marks.append(_crossings(face, use, radius))
    knots = np.clip(np.concatenate(marks), face.box[0, 0], face.box[1, 0])
    knots = np.unique(np.round((knots - face.box[0, 0]) / max(face.box[1, 0] - face.box[0, 0], 1e-300), 9))
    knots = face.box[0, 0] + knots * (face.box[1, 0] - face.box[0, 0])
    edges = np.unique(np.concatenate([np.linspace(a, b, panels + 1) for a, b in itertools.pairwise(knots)]))
    x, w = np.polynomial.legendre.leggauss(PANEL_NODES)
    half = 0.5 * np.diff(edges)
    u = (edges[:-1] + half)[:, None] + half[:, None] * x
    return u.ravel(), (half[:, None] * w).ravel()


def _crossings(face: Face, use: EdgeUse, radius: float) -> Array:
    """u where a pcurve meets the level: there the stretches along the lines begin or end."""
    assert use.pcurve is not None
    t = np.linspace(*use.range, 129)

    def gap(x: Array) -> Array:
        assert use.pcurve is not None
        return radii_of(face.surface.points(use.pcurve.points(x))) - radius

    f = gap(t)
    change = np.flatnonzero(np.diff(np.sign(f)) != 0)
    a, b, fa = t[change], t[change + 1], f[change]
    for _ in range(50):
        middle = 0.5 * (a + b)
        same = (gap(middle) > 0.0) == (fa > 0.0)
        a, b = np.where(same, middle, a), np.where(same, b, middle)
    return use.pcurve.points(0.5 * (a + b))[:, 0]


def _inside(face: Face, u: Array) -> tuple[Array, Array, Array]:
    """Stretches (line, low, high) of the lines inside of the trimming, by even-odd crossings with the sampled pcurves."""
    lines, heights = [np.zeros(0, dtype=int)], [np.zeros(0)]
    for loop in face.loops:
        chain = []
        for use in loop:
            if use.pcurve is not None:
                p = use.pcurve.points(np.linspace(*use.range, PCURVE_SAMPLES))
                chain.append(p if use.forward else p[::-1])
        if not chain:
            continue
        ring = np.concatenate(chain)
        a, b = ring, np.roll(ring, -1, axis=0)
        order = np.argsort(u)
        first = np.searchsorted(u[order], np.minimum(a[:, 0], b[:, 0]), side="left")
        last = np.searchsorted(u[order], np.maximum(a[:, 0], b[:, 0]), side="left")
        count = last - first
        edge = np.repeat(np.arange(len(a)), count)
        number = order[np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count) + first[edge]]
        share = (u[number] - a[edge, 0]) / (b[edge, 0] - a[edge, 0])
        lines.append(number)
        heights.append(a[edge, 1] + share * (b[edge, 1] - a[edge, 1]))
    line, height = np.concatenate(lines), np.concatenate(heights)
    order = np.lexsort((height, line))
    line, height = line[order], height[order]
    return line[0::2], height[0::2], height[1::2]


def _beyond(face: Face, u: Array, line: Array, low: Array, high: Array, radius: float) -> tuple[Array, Array, Array]:
    """The parts of stretches where rho > R; their ends by bisection and secants."""
    if not len(line):
        return line, low, high
    share = np.linspace(0.0, 1.0, SEARCH)
    v = low[:, None] + (high - low)[:, None] * share
    gap = _gap(face, np.repeat(u[line], SEARCH), v.ravel(), radius).reshape(v.shape)
    above = gap > 0.0
    stretch, cell = np.nonzero(above[:, 1:] != above[:, :-1])
    a, b = v[stretch, cell], v[stretch, cell + 1]
    fa = gap[stretch, cell]
    for _ in range(50):
        middle = 0.5 * (a + b)
        f = _gap(face, u[line[stretch]], middle, radius)
        same = (f > 0.0) == (fa > 0.0)
        a, b = np.where(same, middle, a), np.where(same, b, middle)
    root = 0.5 * (a + b)
    # ends of the parts: the stretch's own ends where it begins or ends above, and the roots
    starts, finishes = above[:, 0], above[:, -1]
    number = np.concatenate([np.flatnonzero(starts), stretch, np.flatnonzero(finishes)])
    value = np.concatenate([low[starts], root, high[finishes]])
    order = np.lexsort((value, number))
    number, value = number[order], value[order]
    return line[number[0::2]], value[0::2], value[1::2]


def _gap(face: Face, u: Array, v: Array, radius: float) -> Array:
    return radii_of(face.surface.points(np.stack([u, v], axis=1))) - radius


def _at_breaks(face: Face, line: Array, low: Array, high: Array) -> tuple[Array, Array, Array]:
    breaks = face.surface.breaks(face.box)[1][1:-1]
    for value in breaks:
        cut = (low < value) & (high > value)
        line = np.concatenate([line, line[cut]])
        low, high = (
            np.concatenate([low, np.full(int(cut.sum()), value)]),
            np.concatenate([np.where(cut, value, high), high[cut]]),
        )
    return line, low, high
