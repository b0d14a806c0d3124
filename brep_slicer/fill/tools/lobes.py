"""Narrow lobes of a piece: where a bead's full width does not fit, though it does elsewhere in the same piece.

In: a piece, the bead's width. Out: its polygon, its lobes, and how much of it is wide.

Words: *opening*, all places that some disc of a given diameter inside of the piece reaches; *lobe*, a connected part outside of
the opening by a bead's width that sticks out from it; what is left over in corners is none. The width at a place is the
diameter of the largest disc inside of the piece that holds it, so what is a lobe moves steadily with the outline.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from brep_slicer.maps import Array
from brep_slicer.region import Piece, band_between, polygon_from_piece

from .inset import parts_of, three_turns

if TYPE_CHECKING:
    from shapely import Geometry, Polygon

# Segments a quarter circle of the discs: what is left over in corners is judged by its size, not by its shape.
QUARTER_SEGMENTS = 8
# A lobe sticks out of what a bead reaches by more than this share of the width: in a corner of 60 degrees half of it is left.
STICKS_OUT = 0.55
# Copies of a lobe a turn away lie where they should within this share of the turn.
SAME_PLACE = 1e-6
# Discs are smaller by this share of the width, so that a strip of just that width, drawn to a chord, is no lobe.
HAIR = 0.01


class Shape:
    """The polygon of a piece with what its widths say; on a full turn over three turns, and the `window` of one."""

    def __init__(self, piece: Piece, width: float, chord: float) -> None:
        self.piece, self.width, self.chord = piece, width, chord

    @cached_property
    def whole(self) -> Geometry:
        """The piece's polygon; three turns of one that goes all the way round."""
        shape = three_turns(self.piece, self.chord) if self.piece.winds else polygon_from_piece(self.piece, chord=self.chord)
        return shape if shape.is_valid else shape.buffer(0.0)

    @cached_property
    def once(self) -> Geometry:
        """The piece's polygon, of one turn."""
        if not self.piece.winds:
            return self.whole
        return band_between(self.piece, self.piece.cut, self.piece.cut + 1.0, chord=self.chord)

    @cached_property
    def lobes(self) -> tuple[Polygon, ...]:
        """What sticks out of the opening by the bead's width; of a full turn, each once and whole, across the seam too."""
        radius = 0.5 * self.width * (1.0 - HAIR)
        if self._room.is_empty:
            return ()
        near = self._room.buffer(radius + STICKS_OUT * self.width, quad_segs=QUARTER_SEGMENTS)
        found = [part for part in parts_of(self._left, "Polygon") if not near.covers(part)]
        if not self.piece.winds:
            return tuple(found)
        # a lobe on the seam is drawn on either side of it: its copies differ by rounding only
        closure, first = self.piece.closure, self.piece.cut - SAME_PLACE
        return tuple(p for p in found if not closure.copies_of(np.array([p.centroid.x, p.centroid.y]), first))

    @cached_property
    def corners(self) -> float:
        """The area (mm**2) that no bead half its width inside of the outline reaches, lobes apart; of one turn."""
        if self._room.is_empty:
            return 0.0
        turns = 3.0 if self.piece.winds else 1.0
        return max(0.0, self._left.area / turns - sum(lobe.area for lobe in self.lobes))

    @cached_property
    def _room(self) -> Geometry:
        """Where the centres of discs as wide as a bead, but for a hair, may lie."""
        return self.whole.buffer(-0.5 * self.width * (1.0 - HAIR), quad_segs=QUARTER_SEGMENTS)

    @cached_property
    def _left(self) -> Geometry:
        """What those discs do not reach."""
        radius = 0.5 * self.width * (1.0 - HAIR)
        return self.whole.difference(self._room.buffer(radius * (1.0 + HAIR), quad_segs=QUARTER_SEGMENTS))

    def bare_lobes(self, lines: Sequence[Array]) -> tuple[Polygon, ...]:
        """The lobes most of which beads along `lines` leave bare."""
        import shapely

        if not self.lobes:
            return ()
        tracks = shapely.MultiLineString([self.piece.closure.moved(line, k) for line in lines for k in self.piece.beside])
        tracks = tracks.intersection(shapely.MultiPolygon(self.lobes).buffer(self.width))
        laid = tracks.buffer(0.5 * self.width, quad_segs=QUARTER_SEGMENTS)
        return tuple(lobe for lobe in self.lobes if lobe.intersection(laid).area < 0.5 * lobe.area)

    def wide_share(self, width: float) -> float:
        """The share of the piece's area, its lobes apart, that discs of diameter `width` (mm) inside of it reach."""
        room = self.whole.buffer(-0.5 * width, quad_segs=QUARTER_SEGMENTS)
        if room.is_empty:
            return 0.0
        turns = 3.0 if self.piece.winds else 1.0
        rest = self.whole.area - turns * sum(lobe.area for lobe in self.lobes)
        return float(room.buffer(0.5 * width, quad_segs=QUARTER_SEGMENTS).area / rest)
