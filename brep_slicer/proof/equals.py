"""Equal pieces of a layer are proven once: one stands for all that differ from it by a turn about the axis, or a way along it.

In: a layer's region, its fill. Out: parts of the region with their beads, and how many times each counts.

Words: *leader*, the piece that stands for its copies; *alone*, so far from all other pieces that no bead reaches into two.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from brep_slicer.fill import Bead, LayerFill
from brep_slicer.layers import Closure
from brep_slicer.maps import Array
from brep_slicer.region import Piece, Region, polygon_from_piece

# Equal pieces, moved onto one another, and the points and speeds of their beads agree to this, mm or a share.
SAME = 1e-6
# Pieces are drawn to this for asking how far apart they are, mm; what they come too near by is added to the bead's width.
CHORD = 0.05


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Share:
    """Some pieces of a layer as a `region` with their `beads`; what is found on them counts `times`."""

    region: Region
    beads: tuple[Bead, ...]
    times: int


def shares_of(region: Region, fill: LayerFill, *, width: float) -> list[Share]:
    """The leaders of a layer, grouped by how many pieces each stands for; all of the layer where beads reach into other pieces.

    `width` (mm) is how broad a bead is.
    """
    count = len(region.pieces)
    leader = leaders_of(region, fill)
    if len(np.unique(leader)) == count or not _alone(region, fill, width):
        return [Share(region=region, beads=fill.beads, times=1)]
    times = np.bincount(leader, minlength=count)
    out = []
    for number in np.unique(times[times > 0]).tolist():
        chosen = np.flatnonzero(times == number)
        pieces = tuple(region.pieces[i] for i in chosen)
        mine = set(chosen.tolist())
        beads = tuple(bead for bead in fill.beads if bead.piece in mine)
        out.append(Share(region=replace(region, pieces=pieces), beads=beads, times=int(number)))
    return out


def leaders_of(region: Region, fill: LayerFill) -> NDArray[np.int64]:
    """For each piece the first one that it equals, moved in the plane, beads and all; its own number if there is none."""
    beads: list[list[Bead]] = [[] for _ in region.pieces]
    for bead in fill.beads:
        beads[bead.piece].append(bead)
    leader = np.arange(len(region.pieces))
    known: dict[tuple[int, ...], list[tuple[int, Array]]] = {}
    for number, piece in enumerate(region.pieces):
        if piece.winds and piece.holes:
            continue
        counts, figures = _figures(piece, beads[number])
        alike = known.setdefault(counts, [])
        for first, others in alike:
            if np.allclose(figures, others, rtol=SAME, atol=SAME):
                leader[number] = first
                break
        else:
            alike.append((number, figures))
    return leader


def _figures(piece: Piece, beads: Sequence[Bead]) -> tuple[tuple[int, ...], Array]:
    """What equal pieces have in common: (how many loops, and points of each bead), (sizes, and the beads seen from a corner).

    It does not matter which way a bead runs and which comes first.
    """
    k0, v0, k1, v1 = piece.bounds()
    lines = [_one_way(bead) for bead in beads]
    if piece.winds and lines:
        # a band has no corner round the shaft; its beads' first start is as good
        k0, k1 = (end - k0 + min(line[0, 0] for line in lines) for end in (k0, k1))
    origin = np.array([k0, v0, 0.0])
    lines = sorted((line - origin for line in lines), key=lambda line: tuple(np.round(line[[0, -1], :2], 4).ravel().tolist()))
    area = piece.area()
    sizes = np.array([area, piece.length(), k1 - k0, v1 - v0, piece.first_moment() - v0 * area])
    counts = (len(piece.outer), len(piece.holes), *(len(line) for line in lines))
    return counts, np.concatenate([sizes, *(line.ravel() for line in lines)])


def _one_way(bead: Bead) -> Array:
    """Points and speed of a bead (n, 3), from its lower left end on."""
    speed = np.ones(len(bead.points)) if bead.speed is None else bead.speed
    line = np.column_stack([bead.points, speed])
    # a closed bead's ends are the same, so that its second point tells which way it runs
    ends = np.round(bead.points[[0, 1, -1, -2]], 4).reshape(2, 4).tolist()
    return line if ends[0] <= ends[1] else line[::-1]


def _alone(region: Region, fill: LayerFill, width: float) -> bool:
    """Whether no bead comes within half its width of another piece, or within its width of another piece's bead."""
    import shapely

    if not fill.beads:
        return True
    piece = np.array([bead.piece for bead in fill.beads])
    winds = np.array([piece.winds for piece in region.pieces])
    if winds.any() and not _apart_in_height(region, fill, winds, width):
        return False
    open_pieces = np.flatnonzero(~winds)
    if not len(open_pieces):
        return True
    shapes = np.array([polygon_from_piece(region.pieces[i], chord=CHORD) for i in open_pieces])
    closure, middles = region.closure, np.zeros(len(winds))
    boxes = shapely.bounds(shapes)
    middles[open_pieces] = closure.turns_of(0.5 * (boxes[:, :2] + boxes[:, 2:]))
    own = np.flatnonzero(~winds[piece])
    lines = np.array([shapely.LineString(_moved(fill.beads[i], middles, closure)) for i in own])
    if max(np.ptp(closure.turns_along(shapely.get_coordinates(shape))) for shape in (*shapes, *lines)) > 1.0:
        return False
    piece = piece[own]
    moved = np.concatenate([shapely.transform(lines, lambda points, k=k: closure.moved(points, k)) for k in closure.beside])
    owner = np.tile(piece, len(closure.beside))
    for others, of, reach in ((shapes, open_pieces, 0.5 * width + CHORD), (lines, piece, width + CHORD)):
        near, met = shapely.STRtree(others).query(moved, predicate="dwithin", distance=reach)
        if (owner[near] != of[met]).any():
            return False
    return True


def _apart_in_height(region: Region, fill: LayerFill, winds: NDArray[np.bool_], width: float) -> bool:
    """Whether pieces that go all the way round lie, with their beads, more than `width` (mm) above or below all others."""
    spans = np.array([piece.bounds() for piece in region.pieces])[:, 1::2]
    for bead in fill.beads:
        v = bead.points[:, 1]
        spans[bead.piece] = min(spans[bead.piece, 0], v.min()), max(spans[bead.piece, 1], v.max())
    low, high = spans.T
    near = (low[:, None] - width - CHORD < high) & (low < high[:, None] + width + CHORD)
    np.fill_diagonal(near, False)
    return not near[winds].any()


def _moved(bead: Bead, middles: Array, closure: Closure) -> Array:
    """A bead's points whole turns away, beside the middle (turns) of the piece that it lies in."""
    turns = closure.turns_along(bead.points)
    return closure.moved(bead.points, -np.round(0.5 * (turns.min() + turns.max()) - middles[bead.piece]))
