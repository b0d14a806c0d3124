"""Solids whose edges lie off their faces, as CAD systems export them whose edges are fits of their own.

In: a build123d solid. Out: one whose edges' curves in space wander about the faces by up to a given distance; the faces stay.
"""

from __future__ import annotations

import numpy as np


def with_edges_off(shape, off: float, *, seed: int = 1, straight: bool = False):
    """A copy of a solid, its edges' curves B-splines whose inner poles lie `off` mm away from where they were, at random.

    The ends stay at the vertices; the tolerances are made as wide as that. `straight` edges are moved, too, if asked for.
    """
    import build123d as bd
    from OCP.BRep import BRep_Builder, BRep_Tool
    from OCP.BRepBuilderAPI import BRepBuilderAPI_Copy
    from OCP.Geom import Geom_TrimmedCurve
    from OCP.GeomConvert import GeomConvert
    from OCP.gp import gp_Pnt

    made = bd.Solid(BRepBuilderAPI_Copy(shape.solid().wrapped).Shape())
    rng, builder = np.random.default_rng(seed), BRep_Builder()
    for edge in made.edges():
        if edge.geom_type == bd.GeomType.LINE and not straight:
            continue
        if BRep_Tool.Degenerated_s(edge.wrapped):
            continue
        first, last = BRep_Tool.Range_s(edge.wrapped)
        curve = BRep_Tool.Curve_s(edge.wrapped, first, last)
        curve = GeomConvert.CurveToBSplineCurve_s(Geom_TrimmedCurve(curve, first, last))
        knots = np.linspace(curve.FirstParameter(), curve.LastParameter(), 8)[1:-1]
        curve.IncreaseDegree(max(3, curve.Degree()))
        for knot in knots:
            curve.InsertKnot(float(knot), 1, 1e-9, True)
        count = curve.NbPoles()
        for i in range(2, count):
            way = rng.normal(size=3)
            pole = curve.Pole(i)
            moved = np.array([pole.X(), pole.Y(), pole.Z()]) + off * way / np.linalg.norm(way)
            curve.SetPole(i, gp_Pnt(*moved.tolist()))
        builder.UpdateEdge(edge.wrapped, curve, 1.5 * off)
        builder.Range(edge.wrapped, first, last)
        builder.SameParameter(edge.wrapped, True)
        for vertex in edge.vertices():
            builder.UpdateVertex(vertex.wrapped, 1.5 * off)
    return made
