"""How much of a bead's metal lies within the outline of its piece.

In: a piece's shape, places on its beads. Out: the share of the metal laid there that the piece gets.

A bead half its width inside of the outline keeps within it; one along the skeleton of what is narrower than a bead does not,
and what lies beyond is no metal of the piece: its height would be missing.

Words: *drop*, the metal laid at one place, half an ellipsoid as wide as the bead (`proof.deposit`); *section*, the same where
the bead runs straight on, so that what it lays ahead others lay back: spread across the bead as its parabola; *round end*, what
lies beyond a bead's end.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from brep_slicer.maps import Array

from .lobes import Shape

# Points of equal metal that stand for a round end, spread by the golden ratio.
IN_END, GOLDEN = 96, 0.5 * (5.0**0.5 - 1.0)
# Of a bead along a skeleton at least this share is taken to lie within its piece: at a tip it would be next to none.
LEAST_WITHIN = 0.2
# A bead that comes nearer to the outline than half its width by this share of it lies beyond it by nothing that counts.
HAIR = 0.01


def _below(s: Array) -> Array:
    """The share of a section, or of a drop, on one side of a straight line at `s` half widths from its middle."""
    s = np.clip(s, -1.0, 1.0)
    return 0.25 * (2.0 + 3.0 * s - s**3)


def _round_end() -> Array:
    """Points (n, 2) of equal metal beyond a bead's end, in half widths: within r lies 2 r**2 - r**4 of it."""
    q = (np.arange(IN_END) + 0.5) / IN_END
    r, angle = np.sqrt(1.0 - np.sqrt(1.0 - q)), np.pi * (np.remainder(GOLDEN * np.arange(IN_END), 1.0) - 0.5)
    return np.stack([r * np.cos(angle), r * np.sin(angle)], axis=1)


class Within:
    """A piece's `shape`, asked how much of the metal of beads of some `width` (mm) it gets."""

    def __init__(self, shape: Shape, width: float) -> None:
        self.shape, self.half = shape, 0.5 * width

    @cached_property
    def _polygon(self):
        import shapely

        shapely.prepare(self.shape.whole)
        return self.shape.whole

    @cached_property
    def _outline(self):
        import shapely

        outline = self.shape.whole.boundary
        shapely.prepare(outline)
        return outline

    def clears(self, lines: Sequence[Array]) -> NDArray[np.bool_]:
        """Which of some lines, (n, 2) each, lie so far within the outline that no bead along them reaches beyond it.

        Those of a full turn that go on beyond what is drawn of it are said not to.
        """
        import shapely

        drawn = shapely.linestrings(np.concatenate(lines), indices=np.repeat(np.arange(len(lines)), [len(p) for p in lines]))
        far = ~shapely.dwithin(self._outline, drawn, self.half * (1.0 - HAIR))
        starts = np.array([line[0] for line in lines])
        far[far] = shapely.contains_xy(self._polygon, starts[far])
        return far

    def shares(self, places: Array, ways: Array, turns: NDArray[np.bool_] | None = None) -> Array:
        """Shares (n,) of the metal at `places` (n, 2) of beads that run along the unit vectors `ways` (n, 2).

        It lies in sections; where the bead `turns` in drops, of which the part beyond the nearest edge, taken for straight, is
        lost, too, whichever way that runs.
        """
        import shapely

        places, ways = self._one_turn(places, ways)
        near, out = self._near(places)
        if not len(near):
            return out
        side = self.half * np.stack([-ways[near, 1], ways[near, 0]], axis=1)
        across = shapely.linestrings(np.stack([places[near] - side, places[near] + side], axis=1))
        parts, of = shapely.get_parts(shapely.intersection(across, self._polygon), return_index=True)
        lines = (shapely.get_type_id(parts) == 1) & ~shapely.is_empty(parts)
        ends = shapely.get_coordinates(shapely.get_point(parts[lines], [[0], [-1]])).reshape(2, -1, 2) - places[near][of[lines]]
        s = np.einsum("ijk,jk->ij", ends, side[of[lines]]) / self.half**2
        section = np.bincount(of[lines], weights=np.abs(_below(s[1]) - _below(s[0])), minlength=len(near))
        if turns is not None and turns[near].any():
            some = turns[near]
            points = shapely.points(places[near][some])
            inside = np.where(shapely.contains(self._polygon, points), 1.0, -1.0)
            nearest = _below(inside * shapely.distance(self._outline, points) / self.half)
            section[some] = np.minimum(section[some], nearest)
        out[near] = section
        return out

    def ends(self, tips: Array, out: Array) -> Array:
        """Shares (n,) of round ends at `tips` (n, 2), beyond which beads would go on along the unit vectors `out` (n, 2)."""
        import shapely

        tips, out = self._one_turn(tips, out)
        near, shares = self._near(tips)
        side = np.stack([-out[near, 1], out[near, 0]], axis=1)
        x, y = self.half * _round_end().T[:, :, None]
        points = tips[near, None] + out[near, None] * x + side[:, None] * y
        if len(near):
            shares[near] = shapely.contains_xy(self._polygon, points[..., 0], points[..., 1]).mean(axis=1)
        return shares

    def _near(self, places: Array) -> tuple[NDArray[np.intp], Array]:
        """Numbers of the places that the outline is near to, and for all 1 inside and 0 outside, as where none is near."""
        import shapely

        near = shapely.dwithin(self._outline, shapely.points(places), self.half * (1.0 - HAIR))
        out = np.ones(len(places))
        if not near.all():
            out[~near] = shapely.contains_xy(self._polygon, places[~near])
        return np.flatnonzero(near), out

    def _one_turn(self, places: Array, ways: Array) -> tuple[Array, Array]:
        """Places and ways where the shape of a full turn is drawn."""
        piece = self.shape.piece
        if not piece.winds:
            return places, ways
        copies = piece.closure.copies_of(places, piece.cut)
        return piece.closure.moved(places, -copies), piece.closure.turned(ways, -copies)
