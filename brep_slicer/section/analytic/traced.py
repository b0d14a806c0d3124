"""Level curves without a closed form, traced as Bezier spans: all arcs of all layers on a face at once.

In: a ground, pairs of parameters (u, v) that a level curve joins, radii. Out: spans through points that lie on the surface
and on the sheet to 1e-10 mm, halved until the curve between them does too.

Words: *span*, a stretch of a level curve, one Bezier curve in the plane; *chord line*, the straight line in (u, v) between a
span's ends: points of the level curve are sought across it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from brep_slicer.curves.spline import bernstein_basis, span_nodes
from brep_slicer.geometry import Surface
from brep_slicer.layers import LayerFamily
from brep_slicer.maps import Array
from brep_slicer.section.certificate import LARGEST_ERROR

from .ground import Ground, Which, level_gap

DEGREE = 7
# Points of a level curve satisfy rho = R to this (mm), a hundred times the rounding of coordinates of a metre.
ON_LEVEL = 1e-11
# A span is accepted when the curve passes the checked points between its nodes this near, mm.
BETWEEN = 5e-10
# A span is halved this often at most: 2**-16 of the arc.
MOST_HALVINGS = 16
NEWTON_STEPS = 14
# An end is brought onto the level from no farther than this, mm: an outline that is off by more is none. What is more than the
# edges' gaps explain fails the layer (engine.py).
OFF_EDGE = LARGEST_ERROR


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Spans:
    """Bezier spans: `arc` (n,) they belong to, `share` (n, 2) of the arc they cover, `nodes` (n, DEGREE + 1, 2) in (kappa, v);
    `residual` (n,) in mm, `uv` (n, 2, 2) their ends; arcs that could not be traced, `failed`."""

    arc: NDArray[np.int64]
    share: Array
    nodes: Array
    residual: Array
    uv: Array
    failed: NDArray[np.int64]


def trace_spans(ground: Ground, which: Which, arc: NDArray[np.int64], share: Array, uv: Array, radius: Array) -> Spans:
    """Trace spans given by their ends `uv` (n, 2, 2) on the faces `which` (n,) of a ground and the levels `radius` (n,).

    `arc` and `share` say whose they are; spans that do not hold are halved.
    """
    uv = uv.copy()
    for k in (0, 1):
        uv[:, k] = _onto_level(ground, which, uv[:, k], radius)
    done: list[tuple] = []
    failed: set[int] = set()
    x, check = span_nodes(DEGREE), _between(span_nodes(DEGREE))
    inner = np.concatenate([x[1:-1], check])
    to_check = bernstein_basis(DEGREE, check) @ np.linalg.inv(bernstein_basis(DEGREE, x))
    for halving in range(MOST_HALVINGS + 1):
        if not len(arc):
            break
        found, good = _across_chords(ground, which, uv, radius, inner)
        flat = _unrolled(ground, which, uv, found, radius, inner)
        nodes = flat[:, np.concatenate([[0], 2 + np.arange(DEGREE - 1), [1]])]
        checked = flat[:, 2 + DEGREE - 1 :]
        error = np.hypot(*np.moveaxis(to_check @ nodes - checked, -1, 0)).max(axis=1)
        good &= error <= np.maximum(BETWEEN, 1e-13 * radius)
        done.append((arc[good], share[good], nodes[good], error[good], uv[good]))
        which, arc, share, uv, radius = which[~good], arc[~good], share[~good], uv[~good], radius[~good]
        if halving == MOST_HALVINGS:
            failed |= set(arc.tolist())
            break
        which, arc, share, uv, radius, lost = _halved(ground, which, arc, share, uv, radius)
        failed |= lost
    columns = [np.concatenate(c) for c in zip(*done, strict=True)] if done else [np.zeros(0, dtype=np.int64)] * 5
    return Spans(
        arc=columns[0],
        share=columns[1],
        nodes=columns[2],
        residual=columns[3],
        uv=columns[4],
        failed=np.array(sorted(failed), dtype=np.int64),
    )


def _between(x: Array) -> Array:
    return 0.5 * (x[:-1] + x[1:])


def _onto_level(ground: Ground, which: Which, uv: Array, radius: Array) -> Array:
    """Ends brought onto the level along its gradient; those that cannot be (the level only touches there) stay."""
    start, best = uv, uv.copy()
    scale = ground.scale[which]
    for _ in range(6):
        gap, gu, gv = ground.gap(which, uv, radius)
        gu, gv = gu / scale[:, 0] ** 2, gv / scale[:, 1] ** 2
        size = gu * gu * scale[:, 0] ** 2 + gv * gv * scale[:, 1] ** 2
        step = np.stack([gu, gv], axis=1) * (gap / np.maximum(size, 1e-30))[:, None]
        near = (np.abs((uv - step - start) * scale) <= OFF_EDGE).all(axis=1)
        uv = np.where(near[:, None], uv - step, uv)
        if (np.abs(gap) <= ON_LEVEL).all():
            break
    gap, _, _ = ground.gap(which, uv, radius)
    good = np.abs(gap) <= 1e-9
    best[good] = uv[good]
    # this may overstep the face's box by the gap between edge and face: polynomials go on smoothly there
    return best


def _across_chords(ground: Ground, which: Which, uv: Array, radius: Array, share: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Points of the level curve across each span's chord line at the given shares, (n, k, 2), and which spans were found."""
    a, b = uv[:, 0], uv[:, 1]
    scale, box = ground.scale[which], ground.box[which]
    along = (b - a) * scale
    size = np.hypot(along[:, 0], along[:, 1])
    across = np.stack([-along[:, 1], along[:, 0]], axis=1) / np.maximum(size, 1e-300)[:, None] / scale
    base = a[:, None] + share[None, :, None] * (b - a)[:, None]
    n, k = base.shape[:2]
    flat, way = base.reshape(-1, 2), np.repeat(across, k, axis=0)
    level, face = np.repeat(radius, k), np.repeat(which, k)
    # the offset may not exceed the span's own length: else the chord line has nothing to do with the curve
    limit = np.repeat(size, k) * 0.75 + 1e-9
    offset = np.zeros(len(flat))
    active = np.ones(len(flat), dtype=bool)
    converged = np.zeros(len(flat), dtype=bool)
    for _ in range(NEWTON_STEPS):
        index = np.flatnonzero(active)
        if not len(index):
            break
        gap, gu, gv = ground.gap(face[index], flat[index] + offset[index, None] * way[index], level[index])
        slope = gu * way[index, 0] + gv * way[index, 1]
        done = np.abs(gap) <= ON_LEVEL + 4e-15 * level[index]
        with np.errstate(divide="ignore", invalid="ignore"):
            step = np.where(np.abs(slope) > 1e-9, gap / slope, np.nan)
        new = offset[index] - np.where(done, 0.0, step)
        lost = ~np.isfinite(new) | (np.abs(new) > limit[index])
        converged[index] |= done
        offset[index] = np.where(lost, offset[index], new)
        active[index] = ~(done | lost)
    found = (flat + offset[:, None] * way).reshape(n, k, 2)
    slack = 1e-3 * (box[:, 1] - box[:, 0]) + 2e-2 / scale
    inside = ((found >= (box[:, 0] - slack)[:, None]) & (found <= (box[:, 1] + slack)[:, None])).all(axis=(1, 2))
    return found, converged.reshape(n, k).all(axis=1) & inside & (size > 0.0)


def _unrolled(ground: Ground, which: Which, uv: Array, found: Array, radius: Array, share: Array) -> Array:
    """(kappa, v) of both ends and of the found points, (n, 2 + k, 2), continuous along the span."""
    n, k = found.shape[:2]
    flat = np.concatenate([uv, found], axis=1).reshape(-1, 2)
    points = ground.derivatives(np.repeat(which, 2 + k), flat)[0].reshape(n, 2 + k, 3)
    order = np.argsort(np.concatenate([[0.0, 1.0], share]), kind="stable")
    out = np.empty((n, 2 + k, 2))
    out[:, order] = ground.family.unrolled(points[:, order], radius)
    return out


def _halved(ground: Ground, which: Which, arc, share: Array, uv: Array, radius: Array):
    """Every span cut in two: where it crosses a line between two patches of the surface, else in the middle."""
    middle, good = _across_chords(ground, which, uv, radius, np.array([0.5]))
    cut, at = middle[:, 0].copy(), np.full(len(arc), 0.5)
    for number in np.unique(which).tolist():
        face, rows = ground.faces[number], np.flatnonzero(which == number)
        mine = (cut[rows], at[rows], good[rows])
        for axis, breaks in enumerate(face.surface.breaks(face.box)):
            _cut_at_breaks(face.surface, ground.family, uv[rows], radius[rows], axis, breaks, *mine)
        cut[rows], at[rows], good[rows] = mine
    lost = set(arc[~good].tolist())
    keep = good & ~np.isin(arc, list(lost))
    which, arc, share, uv, radius, cut, at = (x[keep] for x in (which, arc, share, uv, radius, cut, at))
    half = share[:, 0] + at * (share[:, 1] - share[:, 0])
    first = np.stack([uv[:, 0], cut], axis=1)
    second = np.stack([cut, uv[:, 1]], axis=1)
    shares = np.concatenate([np.stack([share[:, 0], half], axis=1), np.stack([half, share[:, 1]], axis=1)])
    twice = (np.concatenate([x, x]) for x in (which, arc))
    return *twice, shares, np.concatenate([first, second]), np.concatenate([radius, radius]), lost


def _cut_at_breaks(
    surface: Surface, family: LayerFamily, uv: Array, radius: Array, axis: int, breaks: Array, cut: Array, at: Array, good
) -> None:
    """Move the cuts of spans that cross a break in u (axis 0) or v (1) to the level curve's point on it.

    A span that ran across would join two polynomials in one, and converge only as fast as the surface is smooth there.
    """
    inner = breaks[1:-1]
    if not len(inner):
        return
    a, b = uv[:, 0, axis], uv[:, 1, axis]
    slack = 1e-9 * (breaks[-1] - breaks[0])
    low, high = np.minimum(a, b) + slack, np.maximum(a, b) - slack
    index = np.searchsorted(inner, 0.5 * (a + b))
    for candidate in (np.clip(index, 0, len(inner) - 1), np.clip(index - 1, 0, len(inner) - 1)):
        rows = np.flatnonzero((inner[candidate] > low) & (inner[candidate] < high) & (at == 0.5))
        if not len(rows):
            continue
        value = inner[candidate[rows]]
        fraction = (value - a[rows]) / (b[rows] - a[rows])
        point = uv[rows, 0] + fraction[:, None] * (uv[rows, 1] - uv[rows, 0])
        point[:, axis] = value
        start = point.copy()
        for _ in range(NEWTON_STEPS):
            gap, gu, gv = level_gap(surface, point, radius[rows], family)
            slope = gv if axis == 0 else gu
            with np.errstate(divide="ignore", invalid="ignore"):
                point[:, 1 - axis] -= np.where(np.abs(gap) <= ON_LEVEL, 0.0, gap / slope)
            point = np.where(np.isfinite(point), point, start)
        gap, _, _ = level_gap(surface, point, radius[rows], family)
        size = np.abs(uv[rows, 1, 1 - axis] - uv[rows, 0, 1 - axis]) + 1e-6
        held = (np.abs(gap) <= 1e-10) & (np.abs(point[:, 1 - axis] - start[:, 1 - axis]) <= 2.0 * size)
        cut[rows[held]], at[rows[held]], good[rows[held]] = point[held], fraction[held], True


def arcs_of_spans(spans: Spans, radius: Array, family: LayerFamily) -> dict[int, tuple[Array, Array, float]]:
    """For each arc: its spans' nodes (m, DEGREE + 1, 2) with kappa continuous, breaks (m + 1,) from 0 to 1, residual."""
    order = np.lexsort((spans.share[:, 0], spans.arc))
    arc, nodes, share = spans.arc[order], spans.nodes[order].copy(), spans.share[order]
    if not len(arc):
        return {}
    fresh = np.ones(len(arc), dtype=bool)
    fresh[1:] = arc[1:] != arc[:-1]
    closure = family.closure(radius[arc])
    jump = np.zeros(len(arc))
    jump[1:] = closure.nearest_turns(nodes[:, 0], np.roll(nodes[:, -1], 1, axis=0))[1:]
    jump[fresh] = 0.0
    total = np.cumsum(jump)
    total -= total[fresh][np.cumsum(fresh) - 1]
    nodes = family.closure(radius[arc][:, None]).moved(nodes, total[:, None])
    # neighbouring spans meet in one point
    joined = np.flatnonzero(~fresh)
    nodes[joined, 0] = nodes[joined - 1, -1]
    begin = np.flatnonzero(fresh)
    end = np.append(begin[1:], len(arc))
    residual = spans.residual[order]
    failed = set(spans.failed.tolist())
    return {
        int(arc[a]): (nodes[a:b], np.append(share[a:b, 0], share[b - 1, 1]), float(residual[a:b].max()))
        for a, b in zip(begin.tolist(), end.tolist(), strict=True)
        if int(arc[a]) not in failed
    }
