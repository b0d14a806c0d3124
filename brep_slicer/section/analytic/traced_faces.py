"""Faces without a closed form: nodes paired along their level curves, the curves traced.

In: a face, its nodes, the radii. Out: FaceArcs, splines (or straight lines where they are straight).

One start and one end on a layer belong together, and the curve between them is sought across the straight line that joins
them in (u, v). Where there are more, or that fails, coarse level lines on a grid say who belongs to whom and lead the way.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from brep_slicer.curves import Curve
from brep_slicer.curves.spline import curves_through_nodes, spline_through_nodes, straightened
from brep_slicer.field import SNAP
from brep_slicer.geometry import Face
from brep_slicer.geometry.trimming import trimming_of
from brep_slicer.layers import CYLINDERS, LayerFamily
from brep_slicer.maps import Array

from .closed_forms import FaceArcs
from .face_nodes import FaceNodes, pair_along
from .ground import Ground, grouped, level_gap
from .guides import FaceGrid, between, grid_of_face, place_on_lines
from .quadrics import closed_form_on_quadric
from .traced import arcs_of_spans, trace_spans

# A traced curve is a straight line when its control points lie on one to this (mm), the accuracy of the tracing.
STRAIGHT = 1e-9
# Along a guide, one vertex in this many begins a new span.
VERTICES_PER_SPAN = 6
# A node farther than this many cells from every guide lies on none of them.
CELLS_AWAY = 2.0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TracedFace:
    """A `face` to be traced, the nodes `found` on it; `closed` if level curves may close on it without meeting an edge.

    `around` (n, 2) are the parameters where rho is stationary, or may be; `marks` (m,) the effective radii of one vertex of
    each of its loops and of its stationary points.
    """

    face: Face
    found: FaceNodes
    around: Array
    marks: Array
    closed: bool
    family: LayerFamily


def arcs_on_traced_faces(traced: Sequence[TracedFace], radii: Array) -> list[FaceArcs]:
    """All arcs of all layers on each face; single arcs are traced on all faces of one kind at once."""
    out = [FaceArcs() for _ in traced]
    guided: list[set[int]] = []
    for one, arcs in zip(traced, out, strict=True):
        starts, ends = _counts(one.found, len(radii))
        for layer in np.flatnonzero(starts != ends).tolist():
            arcs.failed[layer] = f"{starts[layer]} arcs begin and {ends[layer]} end on face {one.face.index}"
        guided.append(set(np.flatnonzero((starts == ends) & (starts > 1)).tolist()))
    for group in grouped([one.face for one in traced]):
        lost = _direct([traced[i] for i in group], radii, [out[i] for i in group])
        for i, layers in zip(group, lost, strict=True):
            guided[i] |= layers
    for one, arcs, layers in zip(traced, out, guided, strict=True):
        if layers or one.closed:
            grid = grid_of_face(one.face, one.around, one.family)
            _guided(one, radii, sorted(layers), arcs, grid)
        if one.closed:
            _check_islands(one.face, one.found, radii, one.marks, arcs)
    return out


def _counts(found: FaceNodes, layers: int) -> tuple[Array, Array]:
    """How many arcs begin and end on a face, on each layer."""
    return (
        np.bincount(found.layer[found.begins], minlength=layers),
        np.bincount(found.layer[~found.begins], minlength=layers),
    )


def _check_islands(face: Face, found: FaceNodes, radii: Array, marks: Array, arcs: FaceArcs) -> None:
    """On a layer that crosses none of the face's edges, places of the face on both sides of R must have a curve between them.

    `marks` (n,) are the effective radii of the face's loops and of its stationary points.
    """
    crossed = set(found.layer.tolist()) | set(arcs.layer) | set(arcs.failed)
    above = marks[None, :] > radii[:, None] + SNAP
    for layer in np.flatnonzero(above.any(axis=1) & ~above.all(axis=1)).tolist():
        if layer not in crossed:
            arcs.failed[layer] = f"face {face.index} lies on both sides of the layer, and no curve between them was found"


def _direct(traced: Sequence[TracedFace], radii: Array, arcs: Sequence[FaceArcs]) -> list[set[int]]:
    """Trace from start to end where a layer has one arc on a face; returns the layers where that fails, by faces."""
    starts, ends, which = [], [], []
    for number, one in enumerate(traced):
        first, last = _single(one.found, len(radii))
        starts.append(first)
        ends.append(last)
        which.append(np.full(len(first), number))
    face = np.concatenate(which)
    if not len(face):
        return [set() for _ in traced]

    def gathered(name: str, rows: list[Array]) -> Array:
        return np.concatenate([getattr(one.found, name)[r] for one, r in zip(traced, rows, strict=True)])

    uv = np.stack([gathered("uv", starts), gathered("uv", ends)], axis=1)
    layer, node = gathered("layer", starts), (gathered("node", starts), gathered("node", ends))
    good = np.isfinite(uv).all(axis=(1, 2))
    arc, radius = np.arange(len(face)), radii[layer]
    ground = Ground([one.face for one in traced], traced[0].family)
    whole = np.tile([0.0, 1.0], (int(good.sum()), 1))
    made = arcs_of_spans(trace_spans(ground, face[good], arc[good], whole, uv[good], radius[good]), radius, ground.family)
    made = _into_the_face(ground, face, uv, radius, made)
    curves = _curves(made, np.array([one.face.index for one in traced])[face])
    for k, curve in curves.items():
        one, mine = traced[face[k]], arcs[face[k]]
        known = _of_its_kind(one.face, curve, float(radius[k]), ground.family)
        mine.add(known, int(layer[k]), int(node[0][k]), int(node[1][k]))
        mine.residual[int(layer[k])] = max(mine.residual.get(int(layer[k]), 0.0), made[k][2])
    missed = np.setdiff1d(arc, np.array(list(curves), dtype=np.int64))
    return [set(layer[missed[face[missed] == number]].tolist()) for number in range(len(traced))]


def _into_the_face(
    ground: Ground, which: NDArray[np.int64], uv: Array, radius: Array, made: dict[int, tuple[Array, Array, float]]
) -> dict[int, tuple[Array, Array, float]]:
    """Those traced arcs that run along the section at both ends: T = e_rho x n, the metal on its left.

    Just above the lowest point of an edge, the level curve of one of its faces goes a long way round, while that of the surface
    beyond the edge joins the two nodes by a short cap outside of the face, which runs the other way.
    """
    keys = np.array(list(made), dtype=np.int64)
    if not len(keys):
        return made
    good = np.ones(len(keys), dtype=bool)
    sign = np.array([face.sign for face in ground.faces])[which[keys]]
    for end in (0, 1):
        p, su, sv = ground.derivatives(which[keys], uv[keys, end])
        n = sign[:, None] * np.cross(su, sv)
        along = ground.family.flat_vectors(p, np.cross(ground.family.gradient(p), n))
        nodes = np.array([made[k][0][0, :2] if end == 0 else made[k][0][-1, -2:] for k in keys.tolist()])
        along = ground.family.closure(1.0).turned(along, ground.family.closure(radius[keys]).copies_of(nodes[:, end]))
        good &= np.einsum("ij,ij->i", nodes[:, 1] - nodes[:, 0], along) >= 0.0
    return {k: made[k] for k in keys[good].tolist()}


def _single(found: FaceNodes, layers: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Rows of the start and of the end on each layer that has one of each."""
    starts, ends = _counts(found, layers)
    mine = np.flatnonzero(np.isin(found.layer, np.flatnonzero((starts == 1) & (ends == 1))))
    rows = mine[np.argsort(found.layer[mine], kind="stable")]
    return rows[found.begins[rows]], rows[~found.begins[rows]]


def _curves(made: dict[int, tuple[Array, Array, float]], face: NDArray[np.int64]) -> dict[int, Curve]:
    """A curve for each traced arc; arcs of a single span, most of them, all at once."""
    single = [k for k, (nodes, _, _) in made.items() if len(nodes) == 1]
    out: dict[int, Curve] = {}
    if single:
        nodes = np.stack([made[k][0][0] for k in single])
        residuals = np.array([made[k][2] for k in single])
        out = dict(zip(single, curves_through_nodes(nodes, residuals, face[single], STRAIGHT), strict=True))
    for k, (nodes, breaks, residual) in made.items():
        if len(nodes) > 1:
            spline = spline_through_nodes(nodes, breaks, residual=residual, face=int(face[k]))
            out[k] = straightened(spline, STRAIGHT)
    return out


def _add(
    face: Face,
    arcs: FaceArcs,
    traced: tuple[Array, Array, float],
    family: LayerFamily,
    radius: float,
    layer: int,
    start: int,
    end: int,
) -> None:
    nodes, breaks, residual = traced
    curve = straightened(spline_through_nodes(nodes, breaks, residual=residual, face=face.index), STRAIGHT)
    arcs.add(_of_its_kind(face, curve, radius, family), layer, start, end)
    arcs.residual[layer] = max(arcs.residual.get(layer, 0.0), residual)


def _of_its_kind(face: Face, curve: Curve, radius: float, family: LayerFamily) -> Curve:
    """A traced curve in closed form where it has one."""
    return closed_form_on_quadric(face, curve, radius) if family == CYLINDERS else curve


def _guided(one: TracedFace, radii: Array, layers: list[int], arcs: FaceArcs, grid: FaceGrid) -> None:
    """Trace along coarse level lines, layer by layer."""
    face, found, around, closed = one.face, one.found, one.around, one.closed
    trimming = trimming_of(face) if closed else None
    if closed:
        near = 1e-9 * max(1.0, float(grid.rho.max()))
        reach = (radii > grid.rho.min() - near) & (radii < grid.rho.max() + near)
        layers = sorted(set(layers) | set(np.flatnonzero(reach).tolist()))
    for layer in layers:
        if layer in arcs.failed:
            continue
        radius = float(radii[layer])
        lines = grid.level_lines(radius)
        mine = np.flatnonzero(found.layer == layer)
        have = {i for i, made in enumerate(arcs.layer) if made == layer}
        if not have and len(mine):
            used = _trace_guided(face, found, grid, lines, mine, radius, layer, arcs)
            if used is None:
                # where a face is nearly level, a coarse grid's lines pass by its nodes; one that closes in on them leads there
                finer = grid_of_face(face, np.concatenate([found.uv[mine], around]), grid.family)
                lines = finer.level_lines(radius)
                used = _trace_guided(face, found, finer, lines, mine, radius, layer, arcs)
            if used is None:
                arcs.failed[layer] = f"the crossings on face {face.index} could not be followed"
                continue
        else:
            used = set(place_on_lines(found.uv[mine], lines, grid.scale).line.tolist()) if len(mine) and lines else set()
        if trimming is not None:
            for number, line in enumerate(lines):
                if number not in used and np.array_equal(line[0], line[-1]) and trimming.surely_contains(line[:-1], grid.scale):
                    _trace_closed(face, grid, line, radius, layer, arcs)


def _trace_guided(
    face: Face, found: FaceNodes, grid: FaceGrid, lines: list[Array], mine, radius: float, layer: int, arcs
) -> set[int] | None:
    """Trace the arcs of one layer along guides; which of them were used, or None where they do not lead to the nodes."""
    if not lines:
        return None
    placed = place_on_lines(found.uv[mine], lines, grid.scale)
    cell = np.array([np.diff(grid.u).max(), np.diff(grid.v).max()]) * grid.scale
    if (placed.distance > CELLS_AWAY * np.hypot(*cell)).any():
        return None
    way = np.array([_way(face, line, radius, grid.family) for line in lines])
    round_ones = np.array([np.array_equal(line[0], line[-1]) for line in lines])
    here = found.select(np.isin(np.arange(len(found)), mine))
    position = placed.position * way[placed.line]
    plans: list[tuple[int, int, Array]] = []
    for cyclic in (False, True):
        some = round_ones[placed.line] == cyclic
        if not some.any():
            continue
        part = here.select(some)
        pairs = pair_along(part, placed.line[some], position[some], cyclic=cyclic)
        if len(pairs.bad):
            return None
        rows = np.flatnonzero(some)
        for i, j in zip(rows[pairs.start].tolist(), rows[pairs.end].tolist(), strict=True):
            number = int(placed.line[i])
            line = lines[number] if way[number] > 0 else lines[number][::-1]
            a, b = position[i], position[j]
            if way[number] < 0:
                total = float(np.linalg.norm(np.diff(line * grid.scale, axis=0), axis=1).sum())
                a, b = total + a, total + b
            inner = between(line, grid.scale, a, b)
            plans.append((i, j, np.concatenate([here.uv[i][None], _thinned(inner), here.uv[j][None]])))
    traced = _trace_plans(face, grid, plans, radius, layer, here, arcs)
    return set(placed.line.tolist()) if traced else None


def _way(face: Face, line: Array, radius: float, family: LayerFamily) -> float:
    """+1 where a guide runs along the section, -1 where against it: T in (u, v) is sign * (d rho/dv, -d rho/du).

    Its longest step is asked.
    """
    steps = np.diff(line, axis=0)
    k = int(np.hypot(*(steps / np.maximum(np.ptp(line, axis=0), 1e-300)).T).argmax())
    middle = 0.5 * (line[k] + line[k + 1])
    _, gu, gv = level_gap(face.surface, middle[None], np.array([radius]), family)
    along = steps[k]
    return 1.0 if face.sign * (gv[0] * along[0] - gu[0] * along[1]) > 0.0 else -1.0


def _thinned(points: Array) -> Array:
    """Every so many vertices of a guide, none too near to its ends."""
    return points[VERTICES_PER_SPAN // 2 :: VERTICES_PER_SPAN]


def _onto_level(face: Face, points: Array, radius: float, grid: FaceGrid) -> Array:
    """Vertices of a guide brought onto the level along the gradient (in mm, not in u and v)."""
    uv = points.copy()
    square = grid.scale**2
    for _ in range(24):
        gap, gu, gv = level_gap(face.surface, uv, np.full(len(uv), radius), grid.family)
        size = gu * gu / square[0] + gv * gv / square[1]
        uv = uv - np.stack([gu / square[0], gv / square[1]], axis=1) * (gap / np.maximum(size, 1e-12))[:, None]
        uv = np.clip(uv, face.box[0], face.box[1])
    gap, _, _ = level_gap(face.surface, uv, np.full(len(uv), radius), grid.family)
    return uv[np.abs(gap) <= 1e-8]


def _trace_plans(face: Face, grid: FaceGrid, plans, radius: float, layer: int, here: FaceNodes, arcs: FaceArcs) -> bool:
    """Trace several guided arcs of one layer; all of them, or none is kept."""
    arc, share, uv = [], [], []
    for number, (_, _, guide) in enumerate(plans):
        inner = _onto_level(face, guide[1:-1], radius, grid)
        chain = np.concatenate([guide[:1], inner, guide[-1:]])
        steps = np.linspace(0.0, 1.0, len(chain))
        arc += [number] * (len(chain) - 1)
        share.append(np.stack([steps[:-1], steps[1:]], axis=1))
        uv.append(np.stack([chain[:-1], chain[1:]], axis=1))
    if not arc:
        return True
    radius_of = np.full(len(plans), radius)
    one = np.zeros(len(arc), dtype=np.int64)
    spans = trace_spans(
        Ground([face], grid.family), one, np.array(arc), np.concatenate(share), np.concatenate(uv), np.full(len(arc), radius)
    )
    made = arcs_of_spans(spans, radius_of, grid.family)
    if len(made) != len(plans):
        return False
    for number, (i, j, _) in enumerate(plans):
        _add(face, arcs, made[number], grid.family, radius, layer, int(here.node[i]), int(here.node[j]))
    return True


def _trace_closed(face: Face, grid: FaceGrid, line: Array, radius: float, layer: int, arcs: FaceArcs) -> None:
    """A level curve that meets no edge, from a closed guide."""
    if _way(face, line, radius, grid.family) < 0.0:
        line = line[::-1]
    inner = _onto_level(face, line[:-1][:: max(1, min(VERTICES_PER_SPAN, (len(line) - 1) // 4))], radius, grid)
    reason = f"an island on face {face.index} could not be followed"
    if len(inner) < 3:
        arcs.failed[layer] = reason
        return
    chain = np.concatenate([inner, inner[:1]])
    steps = np.linspace(0.0, 1.0, len(chain))
    share, uv = np.stack([steps[:-1], steps[1:]], axis=1), np.stack([chain[:-1], chain[1:]], axis=1)
    count = len(chain) - 1
    one = np.zeros(count, dtype=np.int64)
    spans = trace_spans(Ground([face], grid.family), one, one, share, uv, np.full(count, radius))
    made = arcs_of_spans(spans, np.array([radius]), grid.family)
    if 0 not in made:
        arcs.failed[layer] = reason
        return
    _add(face, arcs, made[0], grid.family, radius, layer, -1, -1)
