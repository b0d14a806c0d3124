"""Edges that lie on a layer: there the section is the edge itself.

In: a face whose boundary touches a layer along level edges. Out: their own curves as arcs.

A face that stands on the cylinder R (a tooth's flank on its root, a cam's flank that leaves it tangentially) has, in the
one-sided limit from outside, its edge on R as its section; tracing it on the face would be ill-posed where they are tangent.

Words: *hot*, an edge of constant rho that a layer coincides with; *run*, hot edges one after the other in a boundary.
"""

from __future__ import annotations

import numpy as np

from brep_slicer.field import radii_of
from brep_slicer.geometry import Brep, EdgeUse, Face
from brep_slicer.maps import Array
from brep_slicer.section.unroll import curve_on_cylinder

from .closed_forms import FaceArcs
from .face_nodes import FaceNodes

# A layer and an edge of constant rho this near to each other (mm) coincide: the noise of coordinates in real files.
HOT = 1e-7
# Numbers of nodes at vertices between two hot edges begin here; crossings are numbered from 0.
VERTEX_NODES = 1 << 40


def hot_layers(edge_level: Array, radii: Array) -> dict[int, list[int]]:
    """For each level edge the layers that it coincides with."""
    out: dict[int, list[int]] = {}
    for edge in np.flatnonzero(np.isfinite(edge_level)).tolist():
        begin, end = np.searchsorted(radii, [edge_level[edge] - HOT, edge_level[edge] + HOT])
        if end > begin:
            out[edge] = list(range(int(begin), int(end)))
    return out


def arcs_on_hot_edges(
    brep: Brep, face: Face, found: FaceNodes, radii: Array, hot: dict[int, list[int]]
) -> tuple[FaceArcs, np.ndarray]:
    """Arcs along runs of hot edges, and a mask of the face's nodes that are not used up by them."""
    arcs, free = FaceArcs(), np.ones(len(found), dtype=bool)
    uses = [use for loop in face.loops for use in loop]
    layers = sorted({layer for use in uses for layer in hot.get(use.edge, ())})
    for layer in layers:
        rows = np.flatnonzero(found.layer == layer)
        for run in _runs(face, found, rows, layer, hot):
            start, end, inner = run
            if not all(_rises_inwards(face, use, float(radii[layer])) for use in inner):
                continue
            free[[start, end]] = False
            _add_run(brep, face, arcs, float(radii[layer]), layer, (int(found.node[start]), int(found.node[end])), inner)
    return arcs, free


def arcs_on_hot_loops(brep: Brep, face: Face, radii: Array, hot: dict[int, list[int]]) -> tuple[FaceArcs, set[int]]:
    """Whole boundaries of hot edges from which the face rises (a ball on its shaft), and the layers that they are on."""
    arcs = FaceArcs()
    for loop in face.loops:
        uses = [use for use in loop if brep.edges[use.edge].curve is not None]
        layers = set.intersection(*(set(hot.get(use.edge, ())) for use in uses)) if uses else set()
        for layer in sorted(layers):
            radius = float(radii[layer])
            if all(_rises_inwards(face, use, radius) for use in uses):
                corner = VERTEX_NODES + brep.edges[uses[0].edge].vertices[0 if uses[0].forward else 1]
                _add_run(brep, face, arcs, radius, layer, (corner, corner), uses)
    return arcs, set(arcs.layer)


def _runs(face: Face, found: FaceNodes, rows: np.ndarray, layer: int, hot: dict[int, list[int]]):
    """(start row, end row, edge uses) wherever a start is followed by hot edges alone and then by an end."""
    number = 0
    for loop in face.loops:
        sequence: list[int | EdgeUse | None] = []
        for use in loop:
            mine = rows[found.use[rows] == number]
            if len(mine):
                # along the use: its nodes in the order in which the boundary meets them
                sequence += _in_order(found, mine, use)
            elif layer in hot.get(use.edge, ()):
                sequence.append(use)
            else:
                sequence.append(None)
            number += 1
        yield from _matched(sequence, found)


def _in_order(found: FaceNodes, mine: np.ndarray, use: EdgeUse) -> list[int]:
    """Nodes of one use: rows come in the order of the stretches, which is that of the parameter."""
    ordered = mine[np.argsort(found.node[mine])]
    return (ordered if use.forward else ordered[::-1]).tolist()


def _rises_inwards(face: Face, use: EdgeUse, radius: float) -> bool:
    """Whether the face leaves the hot edge outwards; a face that goes on inwards has its section elsewhere.

    Judged at a thousandth of the face's size from the middle of the edge, where a face that is tangent there has risen too.
    """
    if use.pcurve is None:
        return False
    t = np.array([0.5 * (use.range[0] + use.range[1])])
    p, d = use.pcurve.derivatives(t, 1)
    _, su, sv = face.surface.derivatives(p)
    scale = np.array([np.linalg.norm(su), np.linalg.norm(sv)])
    # the face lies on the left of its boundary as seen from outside, that is in (u, v) if S_u x S_v points outwards
    along = (d[0] if use.forward else -d[0]) * scale
    left = face.sign * np.array([-along[1], along[0]]) / max(float(np.hypot(*along)), 1e-300)
    size = float(np.hypot(*((face.box[1] - face.box[0]) * scale)))
    inside = p[0] + 1e-3 * size * left / np.maximum(scale, 1e-300)
    return bool(radii_of(face.surface.points(inside[None]))[0] > radius)


def _matched(sequence: list, found: FaceNodes):
    n = len(sequence)
    for i, item in enumerate(sequence):
        if not isinstance(item, int) or not found.begins[item]:
            continue
        inner: list[EdgeUse] = []
        for step in range(1, n + 1):
            other = sequence[(i + step) % n]
            if isinstance(other, EdgeUse):
                inner.append(other)
                continue
            if isinstance(other, int) and inner and not found.begins[other]:
                yield item, other, inner
            break


def _add_run(
    brep: Brep, face: Face, arcs: FaceArcs, radius: float, layer: int, ends: tuple[int, int], inner: list[EdgeUse]
) -> None:
    last = ends[0]
    for k, use in enumerate(inner):
        edge = brep.edges[use.edge]
        assert edge.curve is not None
        curve = curve_on_cylinder(edge.curve, edge.first, edge.last, radius, forward=use.forward)
        off = np.abs(radii_of(edge.curve.points(np.linspace(edge.first, edge.last, 33))) - radius).max()
        arcs.residual[layer] = max(arcs.residual.get(layer, 0.0), float(off))
        following = ends[1] if k == len(inner) - 1 else VERTEX_NODES + edge.vertices[1 if use.forward else 0]
        arcs.add(curve, layer, last, following)
        last = following
