"""How far edges and faces of a solid lie apart, measured.

In: a Brep. Out: the gap of every edge, mm.
"""

from __future__ import annotations

import numpy as np

from brep_slicer.maps import Array

from .brep import Brep

SAMPLES = 9


def edge_gaps(brep: Brep) -> Array:
    """Largest distance (edges,) between an edge's own curve and its pcurves on its faces, at a few parameters, mm.

    The vertices at its ends count too, as far as they lie off the curve.
    """
    out = np.zeros(len(brep.edges))
    curves: dict[int, Array] = {}
    for face in brep.faces:
        uses = [use for loop in face.loops for use in loop if use.pcurve is not None and brep.edges[use.edge].curve is not None]
        if not uses:
            continue
        uv, points = [], []
        for use in uses:
            edge = brep.edges[use.edge]
            if use.edge not in curves:
                assert edge.curve is not None
                curves[use.edge] = edge.curve.points(np.linspace(edge.first, edge.last, SAMPLES))
                ends = brep.vertices[list(edge.vertices)]
                out[use.edge] = np.linalg.norm(curves[use.edge][[0, -1]] - ends, axis=1).max()
            points.append(curves[use.edge])
            assert use.pcurve is not None
            uv.append(use.pcurve.points(np.linspace(edge.first, edge.last, SAMPLES)))
        gap = np.linalg.norm(face.surface.points(np.concatenate(uv)) - np.concatenate(points), axis=1).reshape(-1, SAMPLES)
        for use, value in zip(uses, gap.max(axis=1).tolist(), strict=True):
            out[use.edge] = max(out[use.edge], value)
    return out
