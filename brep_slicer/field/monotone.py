"""Edges cut into stretches along which the level c (rho, on cylinders) rises or falls: each crosses a layer at most once.

In: a geometry.Brep, a family of layers. Out: EdgeStretches, arrays over all stretches of all edges.

Words: *stretch*, a part of an edge between two neighbouring extremes of rho (or its ends); *level*, a face or an edge whose
radii differ by less than the coincidence band; *effective radius*, what a point counts as: everything that a level face or
edge touches has that one's radius, so that no layer can fall between them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from brep_slicer.geometry import Brep, Edge, ElementarySurface, SurfaceKind
from brep_slicer.layers import CYLINDERS, LayerFamily
from brep_slicer.maps import Array

from .flatness import levels_on_flatter_face, uses_of_edges
from .radial import COINCIDENCE_BAND, SNAP
from .turning_points import turning_points


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class EdgeStretches:
    """Every stretch of every edge that is not level: `edge` (n,) its number, `t` (n, 2) its parameters, `rho` (n, 2) its
    effective radii at those, mm. `vertex_rho` (vertices,) are the effective radii of the vertices, `edge_level` (edges,)
    the effective radius of each level edge and nan for the others, `face_level` (faces,) the same for faces;
    `extremes` the radii (mm) where an edge turns back."""

    edge: Array
    t: Array
    rho: Array
    vertex_rho: Array
    edge_level: Array
    face_level: Array
    extremes: Array


def edge_stretches(brep: Brep, family: LayerFamily = CYLINDERS) -> EdgeStretches:
    """Cut all edges of a solid, and settle the effective radii."""
    cuts = turning_points(brep.edges, family)
    ranges = np.array([_edge_range(edge, cut, family) for edge, cut in zip(brep.edges, cuts, strict=True)]).reshape(-1, 2)
    level_edges = ranges[:, 1] - ranges[:, 0] <= COINCIDENCE_BAND
    level_faces, exact = _level_faces(brep, level_edges, family)
    level_edges, level_faces = _without_chains(brep, ranges, level_edges, level_faces, exact)
    vertex_rho, edge_level, face_level = _effective(brep, ranges, level_edges, level_faces, exact, family)
    uses = uses_of_edges(brep, np.flatnonzero([len(cut) > 0 for cut in cuts]))
    edges, params, radii, extremes = [], [], [], []
    for number, (edge, cut) in enumerate(zip(brep.edges, cuts, strict=True)):
        if edge.curve is None or level_edges[number]:
            continue
        t = np.concatenate([[edge.first], cut, [edge.last]])
        points = edge.curve.points(t)
        rho = family.value(points)
        if len(cut):
            rho[1:-1] = levels_on_flatter_face(uses[number], cut, points[1:-1], family)
        extremes.append(rho[1:-1].copy())
        # a layer that just touches the lowest point of an edge does not cross it: nothing is cut off, and no two nodes coincide
        turns_up = (rho[1:-1] < rho[:-2]) & (rho[1:-1] < rho[2:])
        rho[1:-1] += np.where(turns_up, 2.0 * SNAP, 0.0)
        rho[0], rho[-1] = vertex_rho[edge.vertices[0]], vertex_rho[edge.vertices[1]]
        edges.append(np.full(len(t) - 1, number))
        params.append(np.stack([t[:-1], t[1:]], axis=1))
        radii.append(np.stack([rho[:-1], rho[1:]], axis=1))
    return EdgeStretches(
        edge=np.concatenate([np.zeros(0, dtype=int), *edges]),
        t=np.concatenate([np.zeros((0, 2)), *params]),
        rho=np.concatenate([np.zeros((0, 2)), *radii]),
        vertex_rho=vertex_rho,
        edge_level=edge_level,
        face_level=face_level,
        extremes=np.concatenate([np.zeros(0), *extremes]),
    )


def _edge_range(edge: Edge, cut: Array, family: LayerFamily) -> tuple[float, float]:
    if edge.curve is None:
        return (np.nan, np.nan)
    between = np.linspace(edge.first, edge.last, 9)
    rho = family.value(edge.curve.points(np.concatenate([between, cut])))
    return float(rho.min()), float(rho.max())


def _level_faces(brep: Brep, level_edges: Array, family: LayerFamily) -> tuple[Array, Array]:
    """Which faces are coaxial cylinders within the band, and the radius (nan if it is not) of those that are so exactly.

    A face stored as a coaxial cylinder is level whatever its edges say, and makes them level: edges between it and a free-form
    face are approximations that wander off by their tolerance.
    """
    level, exact = np.zeros(len(brep.faces), dtype=bool), np.full(len(brep.faces), np.nan)
    for i, face in enumerate(brep.faces):
        if face.surface.kind is SurfaceKind.PLANE and not family.owns("plane"):
            continue
        lines = [np.linspace(face.box[0, k], face.box[1, k], 7) for k in (0, 1)]
        uv = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1).reshape(-1, 2)
        rho = family.value(face.surface.points(uv))
        if rho.max() - rho.min() > COINCIDENCE_BAND:
            continue
        uses = [use.edge for loop in face.loops for use in loop]
        if isinstance(face.surface, ElementarySurface) and family.owns(face.surface.kind.value):
            level[i], exact[i] = True, face.surface.radius if family.owns("cylinder") else float(np.median(rho))
            level_edges[[e for e in uses if brep.edges[e].curve is not None]] = True
        else:
            level[i] = all(level_edges[e] or brep.edges[e].curve is None for e in uses)
    return level, exact


def _groups(brep: Brep, level_edges: Array, level_faces: Array) -> Array:
    """For each vertex the vertex that stands for all those joined to it by level edges and faces."""
    parent = np.arange(len(brep.vertices))

    def root(i: int) -> int:
        while parent[i] != i:
            parent[i] = parent[parent[i]]
            i = int(parent[i])
        return i

    for number in np.flatnonzero(level_edges):
        a, b = brep.edges[number].vertices
        parent[root(a)] = root(b)
    for number in np.flatnonzero(level_faces):
        corners = _corners(brep, int(number))
        for corner in corners[1:]:
            parent[root(corner)] = root(corners[0])
    return np.array([root(i) for i in range(len(parent))], dtype=int)


def _without_chains(
    brep: Brep, ranges: Array, level_edges: Array, level_faces: Array, exact: Array
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Level edges and faces without those of groups that are wider than the band.

    A row of edges, each level within the band, climbs as a cam made of facets does: together they are not one radius. Only what
    is a coaxial cylinder exactly keeps its edges.
    """
    roots = _groups(brep, level_edges, level_faces)
    low, high = np.full(len(roots), np.inf), np.full(len(roots), -np.inf)
    for number in np.flatnonzero(level_edges).tolist():
        group = roots[brep.edges[number].vertices[0]]
        low[group], high[group] = min(low[group], ranges[number, 0]), max(high[group], ranges[number, 1])
    wide = high - low > 2.0 * COINCIDENCE_BAND
    if not wide.any():
        return level_edges, level_faces
    kept = {use.edge for i in np.flatnonzero(np.isfinite(exact)).tolist() for loop in brep.faces[i].loops for use in loop}
    edges, faces = level_edges.copy(), level_faces.copy()
    for number in np.flatnonzero(level_edges).tolist():
        if wide[roots[brep.edges[number].vertices[0]]] and number not in kept and np.ptp(ranges[number]) > SNAP:
            edges[number] = False
    for number in np.flatnonzero(level_faces & ~np.isfinite(exact)).tolist():
        uses = [use.edge for loop in brep.faces[number].loops for use in loop]
        faces[number] = all(edges[e] or brep.edges[e].curve is None for e in uses)
    return edges, faces


def _corners(brep: Brep, face: int) -> list[int]:
    return [v for loop in brep.faces[face].loops for use in loop for v in brep.edges[use.edge].vertices]


def _effective(
    brep: Brep, ranges: Array, level_edges: Array, level_faces: Array, exact: Array, family: LayerFamily
) -> tuple[Array, Array, Array]:
    """Effective radii of vertices, edges and faces.

    A group that holds a coaxial cylinder counts as its radius; any other as its lowest point (a layer inside of the band then
    has all of it below, which is the one-sided rule).
    """
    roots = _groups(brep, level_edges, level_faces)
    count = len(brep.vertices)
    lowest, cylinder = np.full(count, np.inf), np.full(count, np.inf)
    np.minimum.at(lowest, roots, family.value(brep.vertices))
    for number in np.flatnonzero(level_edges):
        group = roots[brep.edges[number].vertices[0]]
        lowest[group] = min(lowest[group], ranges[number, 0])
    for number in np.flatnonzero(np.isfinite(exact)):
        group = roots[_corners(brep, int(number))[0]]
        cylinder[group] = min(cylinder[group], exact[number])
    vertex = np.where(np.isfinite(cylinder), cylinder, lowest)[roots]
    edge_level = np.array(
        [vertex[e.vertices[0]] if level else np.nan for e, level in zip(brep.edges, level_edges, strict=True)]
    )
    face_level = np.array(
        [
            vertex[_corners(brep, i)[0]] if level and f.loops else np.nan
            for i, (f, level) in enumerate(zip(brep.faces, level_faces, strict=True))
        ]
    )
    return vertex, edge_level, face_level
