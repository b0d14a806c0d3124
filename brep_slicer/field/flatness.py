"""How flat faces lie to the layers along their edges: which of an edge's two faces knows best where it is level.

In: a geometry.Brep. Out: the uses of its edges, and the flatness of a face at places on it.

Edges of real files lie a gap g off their faces. Along a face that is inclined to the layer by an angle a, that moves the end
of its level curve by g / sin(a): at a propeller's tip, 0.1 mm for a gap of 1e-4 mm. The steeper of the two faces goes on past
there no farther than about g from the edge. So where an edge meets a layer, and where it turns back, is what the flatter
face says of it.

Words: *flatness*, cos(a) of a face at a place: 1 where it is tangent to the layer; *loose*, of an edge: off its faces.
"""

from __future__ import annotations

import numpy as np

from brep_slicer.geometry import Brep, EdgeUse, Face
from brep_slicer.layers import LayerFamily
from brep_slicer.maps import Array

# Edges nearer to their faces than this (mm) are not loose: however flat a face is, nothing moves that would be seen.
FAINT = 1e-7

Uses = list[tuple[Face, EdgeUse]]


def uses_of_edges(brep: Brep, edges: Array) -> dict[int, Uses]:
    """The faces (with a pcurve) on both sides of each of the edges numbered."""
    out: dict[int, Uses] = {number: [] for number in np.asarray(edges).tolist()}
    for face in brep.faces:
        for use in (use for loop in face.loops for use in loop):
            if use.edge in out and use.pcurve is not None:
                out[use.edge].append((face, use))
    return out


def flatness_of(face: Face, uv: Array, family: LayerFamily) -> Array:
    """The flatness (n,) of a face at uv (n, 2)."""
    p, su, sv = face.surface.derivatives(uv)
    n = np.cross(su, sv)
    return np.abs(family.change(p, n)) / np.maximum(np.linalg.norm(n, axis=1), 1e-300)


def levels_on_flatter_face(uses: Uses, t: Array, points: Array, family: LayerFamily) -> Array:
    """c (n,) at parameters t (n,) of an edge whose own `points` (n, 3) are there: its flatter face's, where they differ."""
    own = family.value(points)
    rho = own
    flattest = np.full(len(t), -np.inf)
    for face, use in uses:
        assert use.pcurve is not None
        uv = use.pcurve.points(t)
        there, flat = face.surface.points(uv), flatness_of(face, uv, family)
        loose = np.linalg.norm(there - points, axis=1) > FAINT
        rho = np.where(flat > flattest, np.where(loose, family.value(there), own), rho)
        flattest = np.maximum(flattest, flat)
    return rho
