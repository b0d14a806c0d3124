"""All layers of one solid at once: nodes, arcs on faces, loops, certificates.

In: a CutSolid and radii. Out: for each radius its loops and a certificate, or the reason why this engine does not vouch for it.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from brep_slicer.curves import Loop
from brep_slicer.errors import LayerError
from brep_slicer.field import SNAP, EdgeStretches
from brep_slicer.geometry import ElementarySurface, Face, SurfaceKind
from brep_slicer.layers import CYLINDERS, Cones, LayerFamily
from brep_slicer.maps import Array
from brep_slicer.section.certificate import Certificate, Engine
from brep_slicer.section.chain import Arc, loops_from_arcs
from brep_slicer.section.cut_solid import CutSolid

from .closed_forms import FaceArcs, closed_form_of, loops_on_planes
from .face_nodes import FaceNodes, nodes_on_face
from .flatter import nodes_on_flatter_faces
from .hot_edges import NOISIEST, VERTEX_NODES, HotEdges, arcs_on_hot_edges, arcs_on_hot_loops, hot_edges
from .nodes import Nodes, find_nodes
from .spheres import arcs_on_sphere
from .traced_faces import TracedFace, arcs_on_traced_faces

# The check that says that a section is an edge's own curve, since the layer lies within that edge's noise.
IN_NOISE = "in_the_noise_of_an_edge"
Section = tuple[list[Loop], Certificate] | LayerError
# Points of closed forms and of nodes are exact but for rounding, mm.
ROUNDING = 1e-12
# Two faces and the edge between them can add up to a jog of this many gaps.
GAPS = 4.0
# However grazing the crossing, a jog that exceeds the gaps by more than this (mm) is not explained by them.
MOST_JOG = 0.005


def sections_by_analysis(solid: CutSolid, radii: Array) -> list[Section]:
    """Cut one solid at increasing levels (n,), mm: radii, where the layers are cylinders.

    What fails in the noise of an edge that strays from its level is cut again, by that edge.
    """
    radii = np.asarray(radii, dtype=np.float64)
    found = _sections(solid, radii, noisy=False)
    failed = [i for i, section in enumerate(found) if isinstance(section, LayerError)]
    levels = solid.stretches.edge_level[np.isfinite(solid.stretches.edge_level)]
    near = [i for i in failed if np.any((radii[i] > levels) & (radii[i] < levels + NOISIEST))]
    if near:
        for i, section in zip(near, _sections(solid, radii[near], noisy=True), strict=True):
            if not isinstance(section, LayerError):
                checks = {**section[1].checks, IN_NOISE: True}
                found[i] = section[0], replace(section[1], checks=checks, coincident=True)
    return found


def _sections(solid: CutSolid, asked: Array, *, noisy: bool) -> list[Section]:
    """Cut one solid at increasing levels (n,); `noisy` as of `hot_edges`."""
    brep, stretches, family = solid.brep, solid.stretches, solid.family
    radii = _off_the_edge(asked, stretches)
    nodes = nodes_on_flatter_faces(brep, find_nodes(brep, stretches, radii, family), solid.gaps, radii, family)
    hot = hot_edges(brep, stretches.edge_level, radii, family, noisy=noisy)
    made: list[FaceArcs] = []
    traced: list[TracedFace] = []
    for face in brep.faces:
        if np.isfinite(stretches.face_level[face.index]):
            continue
        known, rest = _arcs_on_face(solid, face, nodes_on_face(face, nodes, family), radii, hot)
        made += known
        traced += rest
    found = _assembled(solid, radii, nodes, [*made, *arcs_on_traced_faces(traced, radii)])
    for i in np.flatnonzero(radii != asked).tolist():
        section = found[i]
        if not isinstance(section, LayerError):
            found[i] = [loop.on_sheet(family.sheet(float(asked[i]))) for loop in section[0]], section[1]
    return found


def _off_the_edge(radii: Array, stretches: EdgeStretches) -> Array:
    """Radii moved by less than SNAP where R + SNAP falls on an effective radius.

    There the rounding of equal radii (the lands of a gear's teeth) would decide which of them count as above the layer.
    """
    marks = np.concatenate([stretches.vertex_rho, stretches.face_level, stretches.edge_level])
    marks = np.unique(marks[np.isfinite(marks)])
    out = radii.copy()
    for _ in range(6):
        after = np.clip(np.searchsorted(marks, out + SNAP), 0, len(marks) - 1)
        gap = np.minimum(np.abs(marks[after] - out - SNAP), np.abs(marks[np.maximum(after - 1, 0)] - out - SNAP))
        out = np.where(gap < 0.05 * SNAP, out + 0.15 * SNAP, out)
    return np.maximum.accumulate(out)


def _arcs_on_face(
    solid: CutSolid, face: Face, found: FaceNodes, radii: Array, hot: HotEdges
) -> tuple[list[FaceArcs], list[TracedFace]]:
    """The arcs that are known in closed form, and the face with what is left to be traced, if anything is."""
    brep, stretches = solid.brep, solid.stretches
    out: list[FaceArcs] = []
    busy = set(found.layer.tolist())
    if hot.layers and len(found):
        arcs, free = arcs_on_hot_edges(face, found, radii, hot)
        if not free.all():
            out.append(arcs)
            found = found.select(free)
    surface = face.surface
    if isinstance(surface, ElementarySurface) and surface.kind is SurfaceKind.SPHERE and solid.family == CYLINDERS:
        sides = np.array([stretches.vertex_rho[brep.edges[loop[0].edge].vertices[0]] for loop in face.loops])
        whole, edged = arcs_on_hot_loops(face, radii, hot)
        return [*out, whole, arcs_on_sphere(face, found, radii, edged | (busy - set(found.layer.tolist())), sides)], []
    solve = closed_form_of(face, solid.family)
    if solve is not None:
        if len(found):
            out.append(solve(face, found, radii))
        out.append(loops_on_planes(brep, face, radii, busy, stretches.edge_level, stretches.vertex_rho, solid.family))
        return out, []
    around = solid.critical.around[face.index]
    closed = len(face.loops) > 1 or len(around) > 0
    if not len(found) and not closed:
        return out, []
    sides = np.array([stretches.vertex_rho[brep.edges[loop[0].edge].vertices[0]] for loop in face.loops])
    peaks = solid.family.value(face.surface.points(solid.critical.inside[face.index]))
    marks = np.concatenate([sides, peaks])
    return out, [TracedFace(face=face, found=found, around=around, marks=marks, closed=closed, family=solid.family)]


def _assembled(solid: CutSolid, radii: Array, nodes: Nodes, made: list[FaceArcs]) -> list[Section]:
    arcs: list[list[Arc]] = [[] for _ in radii]
    failed: dict[int, str] = {}
    residual = np.full(len(radii), ROUNDING)
    for face_arcs in made:
        for curve, layer, start, end in zip(face_arcs.curves, face_arcs.layer, face_arcs.start, face_arcs.end, strict=True):
            arcs[layer].append(Arc(curve=curve, start=start, end=end))
        failed.update({layer: reason for layer, reason in face_arcs.failed.items() if layer not in failed})
        for layer, value in face_arcs.residual.items():
            residual[layer] = max(residual[layer], value)
    off = _off_nodes(solid.family, made, nodes, radii)
    counts = np.bincount(nodes.layer, minlength=len(radii))
    allowed = _allowed_jogs(solid, nodes, radii)
    level = solid.critical.level
    out: list[Section] = []
    for layer, radius in enumerate(radii.tolist()):
        if layer in failed:
            out.append(LayerError(failed[layer]))
            continue
        coincident = bool(len(level)) and float(np.abs(level - radius).min()) <= 1e-6
        try:
            out.append(
                _certified(
                    solid,
                    radius,
                    arcs[layer],
                    int(counts[layer]),
                    float(residual[layer]),
                    coincident,
                    (float(allowed[layer]), float(off[layer])),
                )
            )
        except LayerError as error:
            out.append(error)
    return out


def _off_nodes(family: LayerFamily, made: list[FaceArcs], nodes: Nodes, radii: Array) -> Array:
    """Largest distance (mm) of an arc's end from its node, in each layer: a formula that took the wrong branch shows here."""
    out = np.zeros(len(radii))
    ends = [
        (node, layer, point)
        for arcs in made
        for curve, layer, start, end in zip(arcs.curves, arcs.layer, arcs.start, arcs.end, strict=True)
        for node, point in ((start, curve.start), (end, curve.end))
        if 0 <= node < VERTEX_NODES
    ]
    if not ends:
        return out
    node, layer = np.array([e[0] for e in ends]), np.array([e[1] for e in ends])
    flat = np.array([e[2] for e in ends])
    there = family.unrolled(nodes.points[node][:, None], radii[layer])[:, 0]
    np.maximum.at(out, layer, family.closure(radii[layer]).distances(flat, there))
    return out


def _allowed_jogs(solid: CutSolid, nodes: Nodes, radii: Array) -> Array:
    """The largest jog that the edges' gaps explain, in each layer, mm.

    Where an edge meets the cylinder at a grazing angle, a gap g of the faces moves their crossing by g / sin(angle).
    """
    brep = solid.brep
    tolerance = np.maximum(solid.gaps, [edge.tolerance for edge in brep.edges])
    slope = np.ones(len(nodes.edge))
    for number in np.unique(nodes.edge).tolist():
        mine = nodes.of_edge(number)
        curve = brep.edges[number].curve
        assert curve is not None
        p, d = curve.derivatives(nodes.t[mine], 1)
        slope[mine] = np.abs(solid.family.change(p, d)) / np.maximum(np.linalg.norm(d, axis=1), 1e-300)
    gap = tolerance[nodes.edge]
    # at a tangent the crossing moves by sqrt(2 R g) at most
    bend = np.array([solid.family.reach(brep.vertices, level) for level in radii.tolist()])[nodes.layer]
    reach = np.minimum(gap / np.maximum(slope, 1e-12), np.sqrt(2.0 * bend * gap))
    out = np.full(len(radii), 1e-9)
    np.maximum.at(out, nodes.layer, GAPS * np.minimum(gap + reach, np.maximum(gap, MOST_JOG)) + 1e-9)
    return out


def _check_windings(solid: CutSolid, level: float, loops: list[Loop]) -> None:
    """The loops round the axis come in pairs, but for one where a cone's apex lies inside of the solid.

    Raises
    ------
    LayerError
        If they do not.
    """
    winding, around = sum(loop.winding for loop in loops), 0
    if isinstance(solid.family, Cones) and solid.family.half_angle:
        from brep_slicer.kernel.shapes import holds_point

        low, high = solid.brep.vertices[:, 2].min(), solid.brep.vertices[:, 2].max()
        apex = np.array([0.0, 0.0, level / math.sin(solid.family.half_angle)])
        if winding or low <= apex[2] <= high:
            around = int(math.copysign(holds_point(solid.wrapped, apex), solid.family.half_angle))
    if winding != around:
        raise LayerError("the loops round the axis do not add up")


def _certified(
    solid: CutSolid, radius: float, arcs: list[Arc], nodes: int, residual: float, coincident: bool, jogs: tuple[float, float]
) -> tuple[list[Loop], Certificate]:
    """Chain one layer and check it.

    Raises
    ------
    LayerError
        If a node is not met exactly twice, a loop does not close, or a jog is larger than the gaps of the edges explain.
    """
    crossings = [arc.start for arc in arcs if 0 <= arc.start < VERTEX_NODES]
    if len(crossings) != nodes or len(set(crossings)) != nodes:
        raise LayerError(f"{nodes} edge crossings, but {len(crossings)} arcs begin at one")
    loops = loops_from_arcs(solid.family.sheet(radius), arcs)
    allowed, off = jogs
    jog = max(off, max((loop.jog() for loop in loops), default=0.0))
    if jog > allowed:
        raise LayerError(f"a jog of {jog:.3g} mm is larger than the gaps of the edges allow ({allowed:.3g} mm)")
    _check_windings(solid, radius, loops)
    area, length = sum(loop.signed_area() for loop in loops), sum(loop.length() for loop in loops)
    # where an apex is held, its own share of the area is not among these
    if solid.family == CYLINDERS and area < -residual * length:
        raise LayerError("the outline holds less than nothing: an arc went the wrong way round")
    checks: dict[str, bool | float | str] = {
        "nodes": nodes,
        "every_node_met_twice": True,
        "jog_allowed_mm": allowed,
        "windings_add_up": True,
    }
    certificate = Certificate(
        engine=Engine.ANALYTIC, residual=max(residual, solid.brep.residual), jog=jog, checks=checks, coincident=coincident
    )
    return loops, certificate
