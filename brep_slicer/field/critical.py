"""Critical radii: where the topology of a section can change, and nowhere else.

In: a geometry.Brep and its edges' stretches. Out: sorted radii, the radial range, the radii of coaxial faces.

Between two neighbouring critical radii the section keeps its topology (Morse): vertices, extremes of rho along edges,
extremes and saddles of rho inside of faces, and level faces are all there is.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from brep_slicer.geometry import Brep, Face
from brep_slicer.geometry.trimming import trimming_of
from brep_slicer.layers import CYLINDERS, LayerFamily
from brep_slicer.maps import Array

from .monotone import EdgeStretches
from .radial import COINCIDENCE_BAND
from .stationary import Stationary, stationary_places

# Radii that differ by less are one, mm.
MERGE = 1e-9
# A face that stands on a level edge is noise near it: within so many times what the edge strays from its level, and the band.
STRAYS = 2.0
# How far that goes from the edge, in units of sqrt(2 R noise): the way on which a flat that is tangent there rises out of it; a
# face curved nearly like the cylinder takes longer.
FOOT = 4.0
# Segments of a level edge from which distances are measured.
SEGMENTS = 64
NOWHERE = Stationary(single=np.zeros((0, 2)), doubts=np.zeros((0, 2)), level=np.zeros((0, 2)))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Critical:
    """`radii` (n,), increasing, mm; `level` (m,) those of coaxial cylinder faces; `lowest` and `highest` of the solid.

    `inside` holds for each face the (u, v) (n, 2) of its stationary points away from its edges: only round those, and on faces
    with several loops, can a section close on itself without meeting an edge. `around` (n, 2) are the places where it is to be
    looked for: those, others on the face's surface (in its holes), and where rho may be stationary along a curve.
    """

    radii: Array
    level: Array
    inside: tuple[Array, ...]
    around: tuple[Array, ...]
    lowest: float
    highest: float


def critical_radii(brep: Brep, stretches: EdgeStretches, family: LayerFamily = CYLINDERS) -> Critical:
    """Every critical level of a solid."""
    found = [
        _off_level_edges(brep, face, stationary_places(face, family), stretches, family) if np.isnan(level) else NOWHERE
        for face, level in zip(brep.faces, stretches.face_level, strict=True)
    ]
    inside = [
        _inside(face, np.concatenate([places.single, places.level])) for face, places in zip(brep.faces, found, strict=True)
    ]
    around = [_around(face, places) for face, places in zip(brep.faces, found, strict=True)]
    level = stretches.face_level[np.isfinite(stretches.face_level)]
    rings = stretches.edge_level[np.isfinite(stretches.edge_level)]
    peaks = [family.value(face.surface.points(uv)) for face, uv in zip(brep.faces, inside, strict=True) if len(uv)]
    everything = np.concatenate([stretches.vertex_rho, stretches.extremes, rings, level, *peaks])
    radii = np.unique(everything)
    radii = radii[np.diff(radii, prepend=-np.inf) > MERGE]
    # rho ends at the axis, whatever rounding says
    lowest = 0.0 if family == CYLINDERS and radii[0] < MERGE else float(radii[0])
    return Critical(
        radii=radii,
        level=np.unique(level),
        inside=tuple(inside),
        around=tuple(around),
        lowest=lowest,
        highest=float(radii.max()),
    )


def _off_level_edges(brep: Brep, face: Face, places: Stationary, stretches: EdgeStretches, family: LayerFamily) -> Stationary:
    """The places without those in the noise of a level edge that the face stands on.

    A rolling-ball fillet is tangent to its hub all along their edge; stored as a B-spline it wanders about the hub's radius
    there as the edge does, and is stationary at places that are no more than this: what touches the edge counts as its radius.
    """
    levels = {use.edge for loop in face.loops for use in loop if np.isfinite(stretches.edge_level[use.edge])}
    for number in sorted(levels):
        edge, level = brep.edges[number], float(stretches.edge_level[number])
        if edge.curve is None or not sum(len(some) for some in (places.single, places.doubts, places.level)):
            continue
        chain = edge.curve.points(np.linspace(edge.first, edge.last, SEGMENTS + 1))
        noise = STRAYS * float(np.abs(family.value(chain) - level).max()) + COINCIDENCE_BAND
        near = FOOT * float(np.sqrt(2.0 * family.reach(chain, level) * noise))
        single, doubts, flat = (
            some[~_at_foot(family, face.surface.points(some), chain, level, noise, near)] if len(some) else some
            for some in (places.single, places.doubts, places.level)
        )
        places = Stationary(single=single, doubts=doubts, level=flat)
    return places


def _at_foot(family: LayerFamily, points: Array, chain: Array, level: float, noise: float, near: float) -> NDArray[np.bool_]:
    """Which of the points (n, 3) lie within `noise` of the level and within `near` of the chain (m, 3), mm."""
    a, d = chain[:-1], np.diff(chain, axis=0)
    along = np.einsum("nmk,mk->nm", points[:, None] - a, d) / np.maximum(np.einsum("mk,mk->m", d, d), 1e-300)
    feet = a + np.clip(along, 0.0, 1.0)[..., None] * d
    distance = np.linalg.norm(points[:, None] - feet, axis=2).min(axis=1)
    return (np.abs(family.value(points) - level) <= noise) & (distance <= near)


def _inside(face: Face, uv: Array) -> Array:
    """Those places that lie inside of the face's outline."""
    return uv[trimming_of(face).contains(uv)] if len(uv) else uv


def _around(face: Face, places: Stationary) -> Array:
    """Where closed level curves may lie; on a face without holes only where it is itself stationary."""
    every = np.concatenate([places.single, places.doubts, places.level])
    return every if len(face.loops) > 1 else _inside(face, every)
