"""A layer's region given back to the CAD host, as faces on the exact cylinder.

In: a region, an axis. Out: one TopoDS face, or a compound of several.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from brep_slicer.curves import LineCurve, Loop
from brep_slicer.errors import LayerError
from brep_slicer.layers import Sheet
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
        if k1 - k0 > region.closure.length:
            raise LayerError(f"a piece at radius {region.radius:g} mm goes round more than once: OCCT has no face for that")
    faces = [face_on_cylinder(region.radius, piece.outer[0], piece.holes) for piece in pieces]
    shape = faces[0] if len(faces) == 1 else compound(faces)
    return shape if axis is None else transformed(shape, np.linalg.inv(axis.matrix))


def _halves(piece: Piece) -> list[Piece]:
    """A full band in two parts that do not wind."""
    band = Region(sheet=piece.sheet, pieces=(piece,))
    _, low, _, high = piece.bounds()
    out: list[Piece] = []
    for k in (0.0, 0.5):
        out += difference_of_regions(band, _window(piece.sheet, CUT_AT + k, low - 1.0, high + 1.0)).pieces
    return out


def _window(sheet: Sheet, start: float, low: float, high: float) -> Region:
    """Half a turn from `start` (turns) between two heights."""
    turns = start + np.array([0.0, 0.5, 0.5, 0.0])
    corners = sheet.closure.at(turns, np.array([low, low, high, high]))
    lines = tuple(LineCurve(p0=corners[i], p1=corners[(i + 1) % 4]) for i in range(4))
    return region_from_loops(sheet, [Loop(curves=lines, sheet=sheet)])
