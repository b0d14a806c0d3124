"""A solid's volume and how far its faces are from closing, from the faces and their boundaries alone.

In: a solid's numpy geometry. Out: its Closure: volume, moment, area, and what they are good for.

By Green's theorem in a face's parameters the integral of f du dv over the face is that of -F du along its boundary, where F is
the integral of f along the line u = const from the lowest v of the face's box: nothing is cut and nothing is searched for. Or
that of G dv, G along the lines v = const: the lines go the way on which the surface has fewer breaks (a worm's flank has 3
across and 132 along).

Words: *piece*, a part of a boundary along which both the pcurve and the surface are smooth; *line*, of one constant parameter.
"""

from __future__ import annotations

import functools
import itertools
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from brep_slicer.geometry import Brep, EdgeUse, ElementarySurface, Face, SurfaceKind
from brep_slicer.geometry.edge_curves import LineEdge
from brep_slicer.geometry.roots import bracketed_roots
from brep_slicer.maps import Array

# Gauss nodes along a piece, and up to it: two quadratures, whose difference says what the better one is good for. Both take
# polynomial faces of degree 3 exactly.
COARSE, FINE = 6, 8
# Pieces of a face are halved, so many times at most, until its volume by the two agrees to this share of its area times the
# part's diagonal; the better one is some digits better than that.
AGREEMENT, MOST_HALVINGS = 1e-9, 4
# On a plane all integrands are of the second degree in v: so many nodes take them exactly.
PLANE_NODES = 2
# Places along each smooth part of a pcurve between which it is looked for where it meets a break of the surface.
CUT_SAMPLES = 16
# Places on a surface that are evaluated at a time: what bounds the memory.
MOST_NODES = 500_000


@dataclass(frozen=True, slots=True, kw_only=True)
class Closure:
    """How far a solid's faces are from closing: `vector`, the integral of n dS (mm**2; nil for a closed solid).

    `volumes`, the volume (mm**3) as the integrals of x, y and z times n dS, which agree for a closed solid; `volume`, their
    mean, and the first `moment` along z (mm**4); `area` (mm**2) of the faces. `defect`, by how much the volume depends on where
    it is measured from: |vector| times the part's diagonal, or the spread of the volumes if that is larger, over the volume.
    `quadrature`, by how much the volumes (mm**3) of two quadratures differ.
    """

    vector: Array
    volumes: Array
    volume: float
    moment: float
    area: float
    defect: float
    quadrature: float


def closure_of(brep: Brep) -> Closure:
    """The closure defect of a solid, and its volume and moment measured from its middle, from its own faces and pcurves."""
    middle = 0.5 * (brep.vertices.min(axis=0) + brep.vertices.max(axis=0))
    diagonal = float(np.linalg.norm(np.ptp(brep.vertices, axis=0)))
    total = np.zeros((2, 8))
    planes = [face for face in brep.faces if face.surface.kind is SurfaceKind.PLANE]
    rest = [face for face in brep.faces if face.surface.kind is not SurfaceKind.PLANE]
    if planes:
        sums = _over_planes(planes, middle)
        good = [_agree(found, diagonal) for found in sums]
        total += sums[good].sum(axis=0)
        rest += itertools.compress(planes, ~np.array(good))
    for face in rest:
        total += _over_face(face, middle, diagonal)
    coarse, (*vector, x, y, z, moment, area) = float(total[0, 3:6].mean()), total[1].tolist()
    volume = (x + y + z) / 3.0
    worst = max(float(np.linalg.norm(vector)) * diagonal, max(x, y, z) - min(x, y, z))
    return Closure(
        vector=np.array(vector),
        volumes=np.array([x, y, z]),
        volume=volume,
        moment=moment + (float(middle[2]) + brep.lift) * volume,
        area=area,
        defect=worst / abs(volume),
        quadrature=abs(volume - coarse),
    )


def _agree(sums: Array, diagonal: float) -> bool:
    """Whether two quadratures (2, 8) over a face agree."""
    difference = abs(float((sums[1, 3:6] - sums[0, 3:6]).mean()))
    return difference <= AGREEMENT * diagonal * abs(float(sums[1, 7]))


def _terms(p: Array, n: Array, sign: int | Array) -> Array:
    """(m, 8) what is summed: n (3), p times n (3), z**2 n_z / 2 and |n|, with the boundary's sense of a face's sign."""
    size = sign * np.linalg.norm(n, axis=1)
    return np.column_stack([n, p * n, 0.5 * p[:, 2] ** 2 * n[:, 2], size])


def _over_planes(faces: list[Face], middle: Array) -> Array:
    """The sums (faces, 2, 8) by two quadratures over all plane faces at once."""
    found = [_boundary(face) for face in faces]
    which = np.repeat(np.arange(len(faces)), [len(uv) for uv, _ in found])
    uv, weights = (np.concatenate(column) for column in zip(*found, strict=True))
    surfaces = [face.surface for face in faces]
    assert all(isinstance(surface, ElementarySurface) for surface in surfaces)
    origin = np.stack([surface.origin for surface in surfaces])[which]  # type: ignore[attr-defined]
    frame = np.stack([surface.frame for surface in surfaces])[which]  # type: ignore[attr-defined]
    sign = np.array([face.sign for face in faces])[which]
    lowest = np.array([face.box[0, 1] for face in faces])[which]
    normal = np.cross(frame[:, 0], frame[:, 1])
    up = uv[:, 1] - lowest
    total = np.zeros((len(faces), 2, 8))
    for node, weight in zip(*_gauss(PLANE_NODES), strict=True):
        p = origin + uv[:, :1] * frame[:, 0] + (lowest + node * up)[:, None] * frame[:, 1] - middle
        terms = (weight * up)[:, None] * _terms(p, normal, sign)
        np.add.at(total, which, weights[:, :, None] * terms[:, None])
    return total


def _over_face(face: Face, middle: Array, diagonal: float) -> Array:
    """The sums (2, 8) by two quadratures over a face, its pieces halved until both agree."""
    for halvings in range(MOST_HALVINGS + 1):
        sums = np.zeros((2, 8))
        for uv, weights in _nodes(face, 2**halvings):
            p, su, sv = face.surface.derivatives(uv)
            sums += weights.T @ _terms(p - middle, np.cross(su, sv), face.sign)
        if _agree(sums, diagonal):
            break
    return sums


def _nodes(face: Face, parts: int) -> Iterator[tuple[Array, Array]]:
    """Places (n, 2) in a face's parameters and their weights (n, 2) in the two quadratures, block by block."""
    u, v = face.surface.breaks(face.box)
    constant = _constant_along_lines(u, v)
    boundary, weights = _boundary(face, parts, constant)
    breaks = _divided(u if constant else v, parts)
    size = max(1, MOST_NODES // (FINE * (len(breaks) - 1)))
    for first in range(0, len(boundary), size):
        rows = slice(first, first + size)
        places, shares = _below(boundary[rows, constant], boundary[rows, 1 - constant], weights[rows], breaks)
        yield places[:, ::-1] if constant else places, shares


def _constant_along_lines(u: Array, v: Array) -> int:
    """Which parameter is: the one with more breaks, since each line is evaluated between all breaks that it crosses."""
    return 0 if len(v) <= len(u) else 1


def _divided(breaks: Array, parts: int) -> Array:
    """Breaks with every interval divided into so many equal parts."""
    share = np.arange(parts) / parts
    return np.append((breaks[:-1, None] + np.diff(breaks)[:, None] * share).ravel(), breaks[-1])


def _below(constant: Array, to: Array, weights: Array, breaks: Array) -> tuple[Array, Array]:
    """Places (n, 2) on lines from the lowest break `to` where they meet a boundary, their constant first, and their weights."""
    low, high = breaks[:-1], np.append(breaks[1:-1], np.inf)
    end = np.minimum(to[:, None], high)
    # below the first break a line goes down, by what the boundary leaves its box by
    end[:, 1:] = np.maximum(end[:, 1:], low[1:])
    places, shares = [], []
    for k, count in enumerate((COARSE, FINE)):
        rows, spans = np.nonzero((end != low) & (weights[:, k] != 0.0)[:, None])
        x, w = _gauss(count)
        wide = end[rows, spans] - low[spans]
        v = low[spans, None] + wide[:, None] * x
        places.append(np.stack([np.repeat(constant[rows], count), v.ravel()], axis=1))
        share = np.zeros((v.size, 2))
        share[:, k] = ((wide * weights[rows, k])[:, None] * w).ravel()
        shares.append(share)
    return np.concatenate(places), np.concatenate(shares)


def _boundary(face: Face, parts: int = 1, constant: int = 0) -> tuple[Array, Array]:
    """Gauss nodes (n, 2) of both quadratures along a face's boundary, and their weights (n, 2): -du, or dv for lines v = const.

    The boundary is cut where it meets a break of the surface, or a line that divides what lies between two into `parts`.
    """
    u, v = face.surface.breaks(face.box)
    breaks = _divided(u, parts), _divided(v, parts)
    straight, places, weights = [np.zeros((0, 2, 2))], [], []
    for loop in face.loops:
        uses = [use for use in loop if use.pcurve is not None]
        if not uses:
            continue
        ends = np.stack([_ends(use) for use in uses])
        lines = np.array([isinstance(use.pcurve, LineEdge) for use in uses])
        # pcurves that do not quite meet: the step from one's end to the next one's beginning is boundary too
        straight += [ends[lines], np.stack([ends[:, 1], np.roll(ends[:, 0], -1, axis=0)], axis=1)]
        for use in itertools.compress(uses, ~lines):
            uv, step = _along(use, breaks, constant)
            places.append(uv)
            weights.append(step)
    uv, step = _along_straight(np.concatenate(straight), breaks, constant)
    return np.concatenate([uv, *places]), (1.0 if constant else -1.0) * np.concatenate([step, *weights])


def _ends(use: EdgeUse) -> Array:
    """(2, 2) where the boundary comes to an edge and where it leaves it."""
    assert use.pcurve is not None
    ends = use.pcurve.points(np.array(use.range))
    return ends if use.forward else ends[::-1]


@functools.cache
def _gauss(count: int) -> tuple[Array, Array]:
    """Gauss nodes (count,) on [0, 1] and their weights."""
    x, w = np.polynomial.legendre.leggauss(count)
    return 0.5 * (1.0 + x), 0.5 * w


@functools.cache
def _both() -> tuple[Array, Array]:
    """Nodes (n,) of both quadratures on [0, 1] and their weights (n, 2)."""
    (x, w), (y, z) = _gauss(COARSE), _gauss(FINE)
    return np.append(x, y), np.column_stack([np.append(w, 0.0 * z), np.append(0.0 * w, z)])


def _along_straight(ends: Array, breaks: tuple[Array, Array], constant: int) -> tuple[Array, Array]:
    """Nodes and steps in one parameter along straight pcurves (n, 2, 2), cut where they meet a break of the surface."""
    ends = ends[ends[:, 0, constant] != ends[:, 1, constant]]
    way = ends[:, 1] - ends[:, 0]
    cuts = [np.zeros((len(ends), 1)), np.ones((len(ends), 1))]
    for k, at in enumerate(breaks):
        with np.errstate(divide="ignore", invalid="ignore"):
            share = (at[1:-1] - ends[:, 0, k, None]) / way[:, k, None]
        cuts.append(np.where((share > 0.0) & (share < 1.0), share, 0.0))
    cut = np.sort(np.concatenate(cuts, axis=1), axis=1)
    line, piece = np.nonzero(np.diff(cut, axis=1) > 0.0)
    a, wide = cut[line, piece], np.diff(cut, axis=1)[line, piece]
    x, w = _both()
    share = a[:, None] + wide[:, None] * x
    uv = ends[line, 0][:, None] + share[..., None] * way[line][:, None]
    return uv.reshape(-1, 2), ((wide * way[line, constant])[:, None, None] * w).reshape(-1, 2)


def _along(use: EdgeUse, breaks: tuple[Array, Array], constant: int) -> tuple[Array, Array]:
    """Nodes and steps in one parameter along a curved pcurve, between its own breaks and those of the surface."""
    assert use.pcurve is not None
    marks = _cut(use, use.pcurve.breaks(*use.range), breaks)
    x, w = _both()
    wide = np.diff(marks)
    uv, slope = use.pcurve.derivatives((marks[:-1, None] + wide[:, None] * x).ravel(), 1)
    weights = (wide[:, None, None] * w).reshape(-1, 2) * slope[:, constant, None]
    return uv, weights if use.forward else -weights


def _cut(use: EdgeUse, marks: Array, breaks: tuple[Array, Array]) -> Array:
    """The parameters `marks`, and those where a pcurve meets a break of the surface."""
    axis = np.repeat([0, 1], [len(at[1:-1]) for at in breaks])
    value = np.concatenate([at[1:-1] for at in breaks])
    if not len(axis):
        return marks
    assert use.pcurve is not None
    pcurve = use.pcurve
    share = np.arange(CUT_SAMPLES) / CUT_SAMPLES
    t = np.append((marks[:-1, None] + np.diff(marks)[:, None] * share).ravel(), marks[-1])
    gap = pcurve.points(t)[:, axis] - value
    k, which = np.nonzero((gap[1:] > 0.0) != (gap[:-1] > 0.0))

    def off(rows: Array, at: Array) -> Array:
        return pcurve.points(at)[np.arange(len(at)), axis[which[rows]]] - value[which[rows]]

    met = bracketed_roots(off, t[k], t[k + 1], gap[k, which], gap[k + 1, which])
    both = np.unique(np.concatenate([marks, met]))
    return both if marks[0] < marks[-1] else both[::-1]
