"""A layer's region given back to the CAD host, as faces on the exact cylinder.

In: a region, an axis. Out: one TopoDS face, or a compound of several.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from brep_slicer.curves import LineCurve, Loop
from brep_slicer.errors import LayerError
from brep_slicer.substrate.axis import Axis

from .overlay import difference_of_regions
from .pieces import Piece
from .region import Region, region_from_loops

# A full turn comes as two faces, cut at this share of a turn and half a turn on (no round number: away from symmetry planes).
CUT_AT = 0.0734


def shape_of_region(region: Region, axis: Axis | None) -> Any:
    """A face for each piece (two for a full turn), in the axis frame or, with an axis, in the file's frame.

    Raises
    ------
    LayerError
        If there is no piece, if one goes round more than once (a thread), or if OCCT makes no valid face of one.
    """
    from brep_slicer.kernel.section_faces import face_on_cylinder
    from brep_slicer.kernel.shapes import compound, transformed

    if region.is_empty:
        raise LayerError(f"the section at radius {region.radius:g} mm is empty: there is no face")
    pieces = [part for piece in region.pieces for part in (_halves(piece) if piece.winds else [piece])]
    for piece in pieces:
        k0, _, k1, _ = piece.bounds()
        if k1 - k0 > region.period:
            raise LayerError(f"a piece at radius {region.radius:g} mm goes round more than once: OCCT has no face for that")
    faces = [face_on_cylinder(region.radius, piece.outer[0], piece.holes) for piece in pieces]
    shape = faces[0] if len(faces) == 1 else compound(faces)
    return shape if axis is None else transformed(shape, np.linalg.inv(axis.matrix))


def _halves(piece: Piece) -> list[Piece]:
    """A full band in two parts that do not wind."""
    radius, period = piece.radius, piece.outer[0].period
    band = Region(radius=radius, pieces=(piece,))
    _, low, _, high = piece.bounds()
    out: list[Piece] = []
    for k in (0.0, 0.5):
        other = _rectangle(radius, (CUT_AT + k) * period, (CUT_AT + k + 0.5) * period, low - 1.0, high + 1.0)
        out += difference_of_regions(band, other).pieces
    return out


def _rectangle(radius: float, k0: float, k1: float, v0: float, v1: float) -> Region:
    corners = [(k0, v0), (k1, v0), (k1, v1), (k0, v1)]
    lines = tuple(LineCurve.between(a, b) for a, b in zip(corners, corners[1:] + corners[:1], strict=True))
    return region_from_loops(radius, [Loop(curves=lines, radius=radius)])
