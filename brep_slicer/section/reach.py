"""How far out some faces of a solid reach.

In: a CutSolid and numbers of its faces. Out: a radius.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from brep_slicer.field import radii_of

from .cut_solid import CutSolid


def reach_of_faces(solid: CutSolid, faces: Iterable[int]) -> float:
    """The outermost radius (mm) of faces: their own if they are coaxial, else of their edges, and stationary points inside."""
    highest = 0.0
    stretches = solid.stretches
    for number in faces:
        face = solid.brep.faces[number]
        if np.isfinite(stretches.face_level[number]):
            highest = max(highest, float(stretches.face_level[number]))
            continue
        edges = sorted({use.edge for loop in face.loops for use in loop})
        ends = [v for e in edges for v in solid.brep.edges[e].vertices]
        radii = [stretches.vertex_rho[ends], stretches.rho[np.isin(stretches.edge, edges)].ravel(), stretches.edge_level[edges]]
        inside = solid.critical.inside[number]
        if len(inside):
            radii.append(radii_of(face.surface.points(inside)))
        highest = max(highest, float(np.nanmax(np.concatenate(radii))))
    return highest
