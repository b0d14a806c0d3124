"""Quadrature over trimmed faces, split where c (rho, on cylinders) passes given levels.

In: a face's numpy geometry. Out: points on it and the vectors n dS there, n out of the solid. Nothing in common with the
section engines: no nodes, no curves; the trimming is that of the pcurves.

Words: *line*, a line u = const in a face's parameters; *stretch*, a part of it inside of the trimming, between two levels.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import numpy as np

from brep_slicer.field import radii_of
from brep_slicer.geometry import EdgeUse, Face, SurfaceKind, patches_of
from brep_slicer.geometry.roots import bracketed_roots
from brep_slicer.layers import CYLINDERS, LayerFamily
from brep_slicer.maps import Array

# Gauss nodes on a panel in u, panels between two kinks, and how finely pcurves are sampled for their crossings with the lines.
PANEL_NODES, PANELS, PCURVE_SAMPLES = 8, 12, 1500
# Points along a line between which rho - R is searched for sign changes.
SEARCH = 96
NODES_ALONG = 8
# A stretch is no longer than this many times its smallest rho (or the first level), over the panels in u: 1 / rho peaks there.
SLENDER, MAXIMUM_SPLITS = 12.0, 12
# A face whose lines have more kinks than this needs fewer panels between two of them, two at least.
KINKS, LEAST_PANELS = 8, 2
# Points at a time (before stretches are halved): what bounds the memory.
MOST_NODES = 1_000_000
# Lines and cells of a face that is divided into cells: beyond these there are fewer between two kinks and along a stretch, four
# at least. A helical face whose pcurves wander has a hundred kinks and crosses every line a hundred times.
MOST_LINES, MOST_CELLS, LEAST_CELLS = 2048, 2_000_000, 4


def surface_nodes(
    face: Face, levels: tuple[float, ...] = (), *, panels: int = PANELS, family: LayerFamily = CYLINDERS
) -> Iterator[tuple[Array, Array]]:
    """(points (n, 3), n dS (n, 3)) over the whole face, block by block; the nodes keep to one side of each radius in `levels`
    (mm).

    Where no kink falls inside of a panel, sums over the nodes have twelve digits; elsewhere about six.
    """
    low, high = level_bounds(face, family)
    levels = tuple(radius for radius in levels if low < radius < high)
    u, weights = _lines(face, levels, panels, family)
    stretches = _at_breaks(face, *_inside(face, u))
    size = MOST_NODES // (SEARCH if levels else NODES_ALONG)
    for first in range(0, len(stretches[0]), size):
        line, low_v, high_v = (column[first : first + size] for column in stretches)
        for radius in levels:
            line, low_v, high_v = _split(face, u, line, low_v, high_v, radius, family)
        if family.is_revolved:
            least = min(levels, default=0.0) if family == CYLINDERS else 0.0
            line, low_v, high_v = _stout(face, u, line, low_v, high_v, SLENDER / panels, least)
        if len(line):
            yield _nodes_on(face, u, weights, line, low_v, high_v)


def _nodes_on(face: Face, u: Array, weights: Array, line: Array, low: Array, high: Array) -> tuple[Array, Array]:
    """Gauss nodes and n dS on stretches from `low` to `high` of lines with their weights."""
    x, w = np.polynomial.legendre.leggauss(NODES_ALONG)
    v = 0.5 * (low + high)[:, None] + 0.5 * (high - low)[:, None] * x
    p, su, sv = face.surface.derivatives(np.stack([np.repeat(u[line], NODES_ALONG), v.ravel()], axis=1))
    share = 0.5 * (high - low)[:, None] * w * weights[line][:, None]
    return p, face.sign * share.reshape(-1, 1) * np.cross(su, sv)


def level_bounds(face: Face, family: LayerFamily = CYLINDERS) -> tuple[float, float]:
    """Levels (mm) between which the face lies for certain: those of the boxes and hulls of its patches' control points.

    No more than bounds: the face reaches neither where its surface goes on beyond its outline.
    """
    if face.surface.kind is SurfaceKind.PLANE:
        uv = np.stack(np.meshgrid(*face.box.T, indexing="ij"), axis=-1).reshape(-1, 2)
        corners = face.surface.points(uv)[None]
    else:
        control = patches_of(face.surface, face.box).control
        corners = (control[..., :3] / control[..., 3:]).reshape(len(control), -1, 3)
    # c is convex in space (a plane's is linear, a cone's is that of the boxes round the axis and of the heights together)
    if not family.is_revolved:
        levels = family.value(corners)
        return float(levels.min()), float(levels.max())
    low, high = corners.min(axis=1), corners.max(axis=1)
    nearest = np.hypot(*np.maximum(np.maximum(low[:, :2], -high[:, :2]), 0.0).T)
    lowest = [family.value(np.stack([nearest, 0.0 * nearest, z[:, 2]], axis=1)) for z in (low, high)]
    return float(np.min(lowest)), float(family.value(corners).max())


def _stout(
    face: Face, u: Array, line: Array, low: Array, high: Array, ratio: float, least: float
) -> tuple[Array, Array, Array]:
    """The stretches halved until none is longer than `ratio` times the smallest rho on it (`least` at least), mm."""
    done: list[tuple[Array, Array, Array]] = []
    for _ in range(MAXIMUM_SPLITS):
        v = np.stack([low, 0.5 * (low + high), high], axis=1)
        p = face.surface.points(np.stack([np.repeat(u[line], 3), v.ravel()], axis=1)).reshape(-1, 3, 3)
        length = np.linalg.norm(np.diff(p, axis=1), axis=2).sum(axis=1)
        rho = np.hypot(p[..., 0], p[..., 1]).min(axis=1)
        long = length > ratio * np.maximum(rho, least)
        done.append((line[~long], low[~long], high[~long]))
        line, low, middle, high = line[long], low[long], v[long, 1], high[long]
        line, low, high = np.concatenate([line, line]), np.concatenate([low, middle]), np.concatenate([middle, high])
        if not len(line):
            break
    done.append((line, low, high))
    return tuple(np.concatenate(column) for column in zip(*done, strict=True))  # type: ignore[return-value]


def surface_cells(face: Face, *, lines: int, cells: int) -> tuple[Array, Array, Array]:
    """The face as small cells: (n, 3) their middles, (n, 3) n dS, (n,) by how much rho changes across each.

    `lines` along u = const between two kinks, `cells` along each, fewer of both where they would be more than memory is for.
    The change is that of two even slopes together.
    """
    knots = _knots(face, (), CYLINDERS)
    lines = max(LEAST_CELLS, min(lines, MOST_LINES // max(1, len(knots) - 1)))
    sides = np.sin(0.5 * np.pi * np.linspace(0.0, 1.0, lines + 1)) ** 2
    u = (knots[:-1, None] + np.diff(knots)[:, None] * 0.5 * (sides[:-1] + sides[1:])).ravel()
    wide = (np.diff(knots)[:, None] * np.diff(sides)).ravel()
    line, low, high = _at_breaks(face, *_inside(face, u))
    if not len(line):
        return np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0)
    cells = max(LEAST_CELLS, min(cells, MOST_CELLS // len(line)))
    v = low[:, None] + (high - low)[:, None] * (np.arange(cells) + 0.5) / cells
    p, su, sv = face.surface.derivatives(np.stack([np.repeat(u[line], cells), v.ravel()], axis=1))
    du, dv = np.repeat(wide[line], cells), np.repeat((high - low) / cells, cells)
    out = p[:, :2] / np.maximum(radii_of(p), 1e-300)[:, None]
    change = np.hypot((out * su[:, :2]).sum(axis=1) * du, (out * sv[:, :2]).sum(axis=1) * dv)
    return p, face.sign * (du * dv)[:, None] * np.cross(su, sv), change


def _lines(face: Face, levels: tuple[float, ...], panels: int, family: LayerFamily) -> tuple[Array, Array]:
    """Gauss nodes in u and their weights, on panels between everything that makes the integrand kink.

    u = a + (b - a) sin(pi x / 2)**2 between two kinks takes away the square roots where a boundary turns back in u.
    """
    knots = _knots(face, levels, family)
    shares = np.diff(knots) / max(float(np.ptp(knots)), 1e-300)
    counts = np.clip(np.ceil(panels * KINKS * shares), min(LEAST_PANELS, panels), panels).astype(int)
    found = [_graded(knots[:-1][counts == n], knots[1:][counts == n], n) for n in np.unique(counts).tolist()]
    u, weights = (np.concatenate(column) for column in zip((np.zeros(0), np.zeros(0)), *found, strict=True))
    return u, weights


def _graded(a: Array, b: Array, panels: int) -> tuple[Array, Array]:
    """Nodes and weights of so many panels in each interval from `a` to `b` (n,)."""
    steps = np.linspace(0.0, 1.0, panels + 1)
    x, w = np.polynomial.legendre.leggauss(PANEL_NODES)
    x = (steps[:-1, None] + 0.5 / panels * (x + 1.0)).ravel()
    w = np.tile(0.5 / panels * w, panels)
    wide = (b - a)[:, None]
    u = a[:, None] + wide * np.sin(0.5 * np.pi * x) ** 2
    return u.ravel(), (wide * 0.5 * np.pi * np.sin(np.pi * x) * w).ravel()


def _knots(face: Face, levels: tuple[float, ...], family: LayerFamily) -> Array:
    """u of everything that makes an integral along u kink: breaks, ends and turns of pcurves, where they meet a level."""
    low, high = face.box[:, 0]
    marks = [face.surface.breaks(face.box)[0]]
    for use in _uses(face):
        assert use.pcurve is not None
        p = use.pcurve.points(np.linspace(*use.range, 129))
        marks += [p[[0, -1], 0], _turns(use)]
        marks += [_crossings(face, use, radius, family) for radius in levels]
    knots = np.clip(np.concatenate(marks), low, high)
    return low + np.unique(np.round((knots - low) / max(high - low, 1e-300), 9)) * (high - low)


def _uses(face: Face) -> list[EdgeUse]:
    return [use for use in itertools.chain(*face.loops) if use.pcurve is not None]


def _turns(use: EdgeUse) -> Array:
    """u where a pcurve turns back in u: extremes of the parabolas through three samples, once refined."""
    assert use.pcurve is not None
    low, high = sorted(use.range)
    t = np.linspace(*use.range, 129)
    h = t[1] - t[0]
    u = use.pcurve.points(t)[:, 0]
    k = np.flatnonzero(np.diff(np.sign(np.diff(u))) != 0) + 1
    t = t[k]
    for _ in range(4):
        before, here, after = (use.pcurve.points(np.clip(t + d, low, high))[:, 0] for d in (-h, 0.0, h))
        bend = before - 2.0 * here + after
        t = t + np.where(bend != 0.0, 0.5 * h * (before - after) / np.where(bend != 0.0, bend, 1.0), 0.0)
        t = np.clip(t, low, high)
        h *= 0.1
    return use.pcurve.points(t)[:, 0]


def _crossings(face: Face, use: EdgeUse, radius: float, family: LayerFamily) -> Array:
    """u where a pcurve meets the level: there the stretches along the lines begin or end."""
    assert use.pcurve is not None
    t = np.linspace(*use.range, 129)

    def gap(x: Array) -> Array:
        assert use.pcurve is not None
        return family.value(face.surface.points(use.pcurve.points(x))) - radius

    f = gap(t)
    change = np.flatnonzero(np.diff(np.sign(f)) != 0)
    met = bracketed_roots(lambda _, x: gap(x), t[change], t[change + 1], f[change], f[change + 1])
    return use.pcurve.points(met)[:, 0]


def _inside(face: Face, u: Array) -> tuple[Array, Array, Array]:
    """Stretches (line, low, high) of the lines inside of the trimming, by even-odd crossings with the pcurves."""
    lines, heights = [np.zeros(0, dtype=int)], [np.zeros(0)]
    order = np.argsort(u)
    for loop in face.loops:
        ends = []
        for use in loop:
            if use.pcurve is None:
                continue
            t = np.linspace(*use.range, PCURVE_SAMPLES)
            p = use.pcurve.points(t)
            number, height = _where_met(use, u, order, t, p)
            lines.append(number)
            heights.append(height)
            ends.append((p[0], p[-1]) if use.forward else (p[-1], p[0]))
        # pcurves that do not quite meet: the step from one's end to the next one's beginning is boundary too
        for (_, a), (b, _) in zip(ends, ends[1:] + ends[:1], strict=True):
            between = np.flatnonzero((u >= min(a[0], b[0])) & (u < max(a[0], b[0])))
            lines.append(between)
            heights.append(a[1] + (u[between] - a[0]) / ((b[0] - a[0]) or 1.0) * (b[1] - a[1]))
    line, height = np.concatenate(lines), np.concatenate(heights)
    order = np.lexsort((height, line))
    line, height = line[order], height[order]
    return line[0::2], height[0::2], height[1::2]


def _where_met(use: EdgeUse, u: Array, order: Array, t: Array, p: Array) -> tuple[Array, Array]:
    """(line numbers, v) where the lines u = const meet a pcurve sampled at t; the chords' crossings refined by secants."""
    assert use.pcurve is not None
    a, b = p[:-1, 0], p[1:, 0]
    first = np.searchsorted(u[order], np.minimum(a, b), side="left")
    count = np.searchsorted(u[order], np.maximum(a, b), side="left") - first
    piece = np.repeat(np.arange(len(a)), count)
    number = order[np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count) + first[piece]]
    ta, tb, ua, ub = t[piece], t[piece + 1], a[piece], b[piece]
    met = ta + (u[number] - ua) / (ub - ua) * (tb - ta)
    if not len(number):
        return number, met
    for _ in range(2):
        um = use.pcurve.points(met)[:, 0]
        left = (um > u[number]) == (ua > u[number])
        ta, ua = np.where(left, met, ta), np.where(left, um, ua)
        tb, ub = np.where(left, tb, met), np.where(left, ub, um)
        width = ub - ua
        met = ta + np.where(width != 0.0, (u[number] - ua) / np.where(width != 0.0, width, 1.0), 0.0) * (tb - ta)
    return number, use.pcurve.points(met)[:, 1]


def _split(
    face: Face, u: Array, line: Array, low: Array, high: Array, radius: float, family: LayerFamily
) -> tuple[Array, Array, Array]:
    """Stretches cut in two wherever rho passes the radius along them."""
    if not len(line):
        return line, low, high
    share = np.linspace(0.0, 1.0, SEARCH)
    v = low[:, None] + (high - low)[:, None] * share
    gap = _levels(family, face, np.repeat(u[line], SEARCH), v.ravel()).reshape(v.shape) - radius
    stretch, cell = np.nonzero((gap[:, 1:] > 0.0) != (gap[:, :-1] > 0.0))
    a, b, fa, fb = v[stretch, cell], v[stretch, cell + 1], gap[stretch, cell], gap[stretch, cell + 1]
    more, peak, reached = _grazed(face, u[line], v, gap, radius, family)
    # a peak that reaches through the level between two samples is met twice
    stretch = np.concatenate([stretch, more, more])
    h = (high - low)[more] / (SEARCH - 1)
    a, b = np.concatenate([a, peak - h, peak]), np.concatenate([b, peak, peak + h])
    beside = [_levels(family, face, u[line[more]], at) - radius for at in (peak - h, peak + h)]
    fa, fb = np.concatenate([fa, beside[0], reached]), np.concatenate([fb, reached, beside[1]])
    whose = u[line[stretch]]
    root = bracketed_roots(lambda rows, at: _levels(family, face, whose[rows], at) - radius, a, b, fa, fb)
    number = np.concatenate([np.arange(len(line)), stretch])
    begin, end = np.concatenate([low, root]), np.concatenate([root, high])
    order = np.lexsort((begin, number))
    number, begin = number[order], begin[order]
    end = np.concatenate([high, root])
    end = end[np.lexsort((end, np.concatenate([np.arange(len(line)), stretch])))]
    return line[number], begin, end


def _grazed(face: Face, u: Array, v: Array, gap: Array, radius: float, family: LayerFamily) -> tuple[Array, Array, Array]:
    """(stretch, v, how far rho is above the level there) of extremes of rho that reach through the level unseen."""
    middle = gap[:, 1:-1]
    toward = np.where(middle > 0.0, 1.0, -1.0)
    nearest = (toward * middle <= toward * gap[:, :-2]) & (toward * middle <= toward * gap[:, 2:])
    stretch, k = np.nonzero(nearest & (toward * gap[:, :-2] > 0.0) & (toward * gap[:, 2:] > 0.0))
    side, at, h = middle[stretch, k] > 0.0, v[stretch, k + 1], v[stretch, 1] - v[stretch, 0]
    for _ in range(3):
        before, here, after = (_levels(family, face, u[stretch], at + d) for d in (-h, 0.0 * h, h))
        bend = before - 2.0 * here + after
        move = np.where(bend != 0.0, 0.5 * (before - after) / np.where(bend != 0.0, bend, 1.0), 0.0)
        at, h = at + h * np.clip(move, -1.0, 1.0), 0.1 * h
    reached = _levels(family, face, u[stretch], at) - radius
    through = (reached > 0.0) != side
    return stretch[through], at[through], reached[through]


def _levels(family: LayerFamily, face: Face, u: Array, v: Array) -> Array:
    return family.value(face.surface.points(np.stack([u, v], axis=1)))


def _at_breaks(face: Face, line: Array, low: Array, high: Array) -> tuple[Array, Array, Array]:
    """Stretches cut at the surface's breaks, so that the integrand is smooth along each."""
    for value in face.surface.breaks(face.box)[1][1:-1]:
        cut = (low < value) & (high > value)
        line = np.concatenate([line, line[cut]])
        low, high = (
            np.concatenate([low, np.full(int(cut.sum()), value)]),
            np.concatenate([np.where(cut, value, high), high[cut]]),
        )
    return line, low, high
