"""Nodes moved along their edges to where the flatter of an edge's two faces meets the layer (field/flatness.py says why).

In: Nodes on the edges' own curves. Out: the same nodes, by the same numbers, where edge and faces lie apart.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from brep_slicer.field import FAINT, flatness_of, uses_of_edges
from brep_slicer.geometry import Brep, EdgeUse, Face
from brep_slicer.layers import LayerFamily
from brep_slicer.maps import Array

from .nodes import Nodes, crossings

# Where a face's own curve meets the layer the edge is off it by no more than so many gaps, which are measured at a few places.
GAPS = 2.0
# A node is on the layer to this, mm; where the face's curve falls short of the layer, the edge's own crossing stays.
ON_LEVEL = 1e-10


def nodes_on_flatter_faces(brep: Brep, nodes: Nodes, gaps: Array, radii: Array, family: LayerFamily) -> Nodes:
    """The nodes of every edge that lies off its faces by more than FAINT (`gaps` (edges,), mm), moved along it."""
    loose = np.flatnonzero((gaps > FAINT) & (np.diff(nodes.first) > 0))
    t, points = nodes.t.copy(), nodes.points.copy()
    for number, uses in uses_of_edges(brep, loose).items():
        mine = nodes.of_edge(number)
        radius, curve = radii[nodes.layer[mine]], brep.edges[number].curve
        assert curve is not None
        if not uses:
            continue
        flat = [flatness_of(face, use.pcurve.points(nodes.t[mine]), family) for face, use in uses if use.pcurve is not None]
        flatter = np.argmax(flat, axis=0)
        for k, (face, use) in enumerate(uses):
            rows = np.flatnonzero(flatter == k)
            if not len(rows):
                continue
            at, there = _crossings_on_face(face, use, nodes.span[mine][rows], radius[rows], family)
            met = np.abs(family.value(there) - radius[rows]) <= ON_LEVEL
            met &= np.abs(family.value(curve.points(at)) - radius[rows]) <= GAPS * gaps[number]
            t[mine.start + rows[met]], points[mine.start + rows[met]] = at[met], there[met]
    return replace(nodes, t=t, points=points)


def _crossings_on_face(face: Face, use: EdgeUse, span: Array, radius: Array, family: LayerFamily) -> tuple[Array, Array]:
    """Where, within stretches (n, 2), the edge as the face has it meets the layers: parameters (n,) and points (n, 3)."""
    assert use.pcurve is not None
    pcurve, surface = use.pcurve, face.surface

    def evaluate(t: Array, order: int) -> list[Array]:
        if not order:
            return [surface.points(pcurve.points(t))]
        uv, along = pcurve.derivatives(t, 1)
        p, su, sv = surface.derivatives(uv)
        return [p, along[:, :1] * su + along[:, 1:] * sv]

    t = crossings(evaluate, span, radius, family)
    return t, evaluate(t, 0)[0]
