"""A solid's topology over its curves and surfaces: what the section engine works on.

In: what the kernel read, in the axis frame. Out: frozen tables of vertices, edges and faces.

Words: *edge use*, an edge as one face's boundary runs along it, the face's inside on the left as seen from outside of the
solid; *level*, of constant rho; *pcurve*, an edge's curve in a face's parameters.
"""

from __future__ import annotations

from dataclasses import dataclass

from brep_slicer.maps import Array

from .edge_curves import EdgeCurve
from .surfaces import Surface


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Edge:
    """`curve` from parameter `first` to `last`; the vertices at those; `tolerance` in mm; no curve where degenerate."""

    curve: EdgeCurve | None
    first: float
    last: float
    vertices: tuple[int, int]
    tolerance: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class EdgeUse:
    """Edge number `edge` in a face's boundary; `forward` if the boundary runs along rising parameters.

    `range` is the pcurve's first and last parameter (of a degenerate edge, which has no curve in space, too).
    """

    edge: int
    forward: bool
    pcurve: EdgeCurve | None
    range: tuple[float, float]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Face:
    """`surface` with `sign` +1 if S_u x S_v points out of the solid, -1 if into it; boundary `loops` of edge uses.

    `box` (2, 2) bounds the face in (u, v).
    """

    index: int
    surface: Surface
    sign: int
    loops: tuple[tuple[EdgeUse, ...], ...]
    box: Array
    tolerance: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Brep:
    """One solid in the axis frame moved down by `lift`, mm (z there is z + lift in the axis frame).

    `vertices` (n, 3) with their tolerances (n,), `edges`, `faces`.

    A solid far along the axis is brought near first: its coordinates would have too few digits left for its features.
    `residual` (mm) is the largest error of a surface or curve that had to be converted (offsets), 0 if none.
    """

    vertices: Array
    vertex_tolerances: Array
    edges: tuple[Edge, ...]
    faces: tuple[Face, ...]
    residual: float = 0.0
    lift: float = 0.0
