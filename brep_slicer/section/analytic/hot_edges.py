"""Edges that lie on a layer: there the section is the edge itself.

In: a face whose boundary touches a layer along level edges. Out: their own curves as arcs.

A face that stands on the cylinder R (a tooth's flank on its root, a cam's flank that leaves it tangentially) has, in the
one-sided limit from outside, its edge on R as its section; tracing it on the face would be ill-posed where they are tangent.

Words: *hot*, an edge of constant rho that a layer coincides with; *run*, hot edges one after the other in a boundary.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from brep_slicer.geometry import Brep, Edge, EdgeUse, Face
from brep_slicer.layers import LayerFamily
from brep_slicer.maps import Array
from brep_slicer.section.unroll import curve_on_sheet

from .closed_forms import FaceArcs
from .face_nodes import FaceNodes

# A layer and an edge of constant rho this near to each other (mm) coincide: the noise of coordinates in real files.
HOT = 1e-7
# Just outside of a level edge that strays from its level (that of a rolling-ball fillet, tangent there), a face that stands
# on it is noise: so many times as far as it strays, and this far (mm) at most.
STRAYS, NOISIEST = 2.0, 1e-4
# Points of an edge that are looked at; how far into the face its rise is, as a share of its size.
SAMPLES, INWARDS = 33, 1e-3
# Numbers of nodes at vertices between two hot edges begin here; crossings are numbered from 0.
VERTEX_NODES = 1 << 40


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class HotEdges:
    """For each level edge of a `brep` the `layers` that it coincides with; their effective radii, `level` (edges,), mm."""

    brep: Brep
    level: Array
    layers: dict[int, list[int]]
    family: LayerFamily

    def on(self, edge: int) -> list[int]:
        """The layers of one edge."""
        return self.layers.get(edge, [])


def hot_edges(brep: Brep, edge_level: Array, radii: Array, family: LayerFamily, *, noisy: bool = False) -> HotEdges:
    """The level edges with their layers; if `noisy`, with those just outside that their own noise reaches, too."""
    out: dict[int, list[int]] = {}
    for edge in np.flatnonzero(np.isfinite(edge_level)).tolist():
        level = float(edge_level[edge])
        begin, end = np.searchsorted(radii, [level - HOT, level + (NOISIEST if noisy else HOT)])
        if noisy and end > begin:
            end = np.searchsorted(radii, level + max(HOT, STRAYS * _strays(brep.edges[edge], level, family)))
        if end > begin:
            out[edge] = list(range(int(begin), int(end)))
    return HotEdges(brep=brep, level=edge_level, layers=out, family=family)


def _strays(edge: Edge, level: float, family: LayerFamily) -> float:
    """How far an edge strays from its level, mm."""
    if edge.curve is None:
        return 0.0
    return float(np.abs(family.value(edge.curve.points(np.linspace(edge.first, edge.last, SAMPLES))) - level).max())


def arcs_on_hot_edges(face: Face, found: FaceNodes, radii: Array, hot: HotEdges) -> tuple[FaceArcs, np.ndarray]:
    """Arcs along runs of hot edges, and a mask of the face's nodes that are not used up by them."""
    arcs, free = FaceArcs(), np.ones(len(found), dtype=bool)
    uses = [use for loop in face.loops for use in loop]
    layers = sorted({layer for use in uses for layer in hot.on(use.edge)})
    for layer in layers:
        rows = np.flatnonzero(found.layer == layer)
        for run in _runs(face, found, rows, layer, hot):
            start, end, inner = run
            if not all((_rise(face, use, hot.family)[0] > float(radii[layer])).all() for use in inner):
                continue
            free[[start, end]] = False
            _add_run(hot, face, arcs, float(radii[layer]), layer, (int(found.node[start]), int(found.node[end])), inner)
    return arcs, free


def arcs_on_hot_loops(face: Face, radii: Array, hot: HotEdges) -> tuple[FaceArcs, set[int]]:
    """Whole boundaries of hot edges from which the face rises (a ball on its shaft), and the layers that they are on."""
    arcs = FaceArcs()
    for loop in face.loops:
        uses = [use for use in loop if hot.brep.edges[use.edge].curve is not None]
        layers = set.intersection(*(set(hot.on(use.edge)) for use in uses)) if uses else set()
        for layer in sorted(layers):
            radius = float(radii[layer])
            if all((_rise(face, use, hot.family)[0] > radius).all() for use in uses):
                corner = VERTEX_NODES + hot.brep.edges[uses[0].edge].vertices[0 if uses[0].forward else 1]
                _add_run(hot, face, arcs, radius, layer, (corner, corner), uses)
    return arcs, set(arcs.layer)


def _runs(face: Face, found: FaceNodes, rows: np.ndarray, layer: int, hot: HotEdges):
    """(start row, end row, edge uses) wherever a start is followed by hot edges alone and then by an end."""
    number = 0
    for loop in face.loops:
        sequence: list[int | EdgeUse | None] = []
        for use in loop:
            mine = rows[found.use[rows] == number]
            if len(mine):
                # along the use: its nodes in the order in which the boundary meets them
                sequence += _in_order(found, mine, use)
            elif layer in hot.on(use.edge):
                sequence.append(use)
            else:
                sequence.append(None)
            number += 1
        yield from _matched(sequence, found)


def _in_order(found: FaceNodes, mine: np.ndarray, use: EdgeUse) -> list[int]:
    """Nodes of one use: rows come in the order of the stretches, which is that of the parameter."""
    ordered = mine[np.argsort(found.node[mine])]
    return (ordered if use.forward else ordered[::-1]).tolist()


def _rise(face: Face, use: EdgeUse, family: LayerFamily, shares: ArrayLike = (0.5,)) -> tuple[Array, Array]:
    """c (n,) of the face a little inside of a hot edge, at shares of its parameters, and how far inside that is (n,), mm.

    A face that leaves the edge outwards has its section there, one that goes on inwards elsewhere. Judged at a thousandth of
    the face's size from the edge, where a face that is tangent there has risen too.
    """
    shares = np.asarray(shares, dtype=np.float64)
    if use.pcurve is None:
        return np.full(len(shares), -np.inf), np.zeros(len(shares))
    t = use.range[0] + shares * (use.range[1] - use.range[0])
    p, d = use.pcurve.derivatives(t, 1)
    _, su, sv = face.surface.derivatives(p)
    scale = np.stack([np.linalg.norm(su, axis=1), np.linalg.norm(sv, axis=1)], axis=1)
    # the face lies on the left of its boundary as seen from outside, that is in (u, v) if S_u x S_v points outwards
    along = (d if use.forward else -d) * scale
    left = face.sign * np.stack([-along[:, 1], along[:, 0]], axis=1) / np.maximum(np.hypot(*along.T), 1e-300)[:, None]
    size = np.hypot(*((face.box[1] - face.box[0]) * scale).T)
    inside = p + INWARDS * size[:, None] * left / np.maximum(scale, 1e-300)
    return family.value(face.surface.points(inside)), INWARDS * size


def _moved(face: Face, use: EdgeUse, family: LayerFamily, level: float, height: float) -> float:
    """How far a face's outline at `height` (mm) above a hot edge's level may lie from the edge, mm.

    A face that rises by some height over a way x rises by less over less of it, as x**2 at the least where it is tangent.
    """
    rho, way = _rise(face, use, family, np.linspace(0.02, 0.98, SAMPLES))
    return float((way * np.sqrt(height / np.maximum(rho - level, 1e-300))).max())


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
    hot: HotEdges, face: Face, arcs: FaceArcs, radius: float, layer: int, ends: tuple[int, int], inner: list[EdgeUse]
) -> None:
    last = ends[0]
    for k, use in enumerate(inner):
        edge, level = hot.brep.edges[use.edge], float(hot.level[use.edge])
        assert edge.curve is not None
        curve = curve_on_sheet(edge.curve, edge.first, edge.last, hot.family.sheet(radius), forward=use.forward)
        off = _strays(edge, radius, hot.family)
        if off > HOT and radius > level + HOT:
            off += _moved(face, use, hot.family, level, off)
        arcs.residual[layer] = max(arcs.residual.get(layer, 0.0), off)
        following = ends[1] if k == len(inner) - 1 else VERTEX_NODES + edge.vertices[1 if use.forward else 0]
        arcs.add(curve, layer, last, following)
        last = following
