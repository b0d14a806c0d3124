"""The beads of a layer as a process asks for them: which pattern, in which order, how fast.

In: a Layer and a Process. Out: a LayerFill.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

from brep_slicer.maps import Array
from brep_slicer.notices import AREA, Notice, NoticeKind
from brep_slicer.process import Order, Process, Rule
from brep_slicer.region import Layer, Piece, band_between, polygon_from_piece

from .bead import LayerFill
from .fill_region import fill_region
from .passes.balance import metal_from_beside, metal_shares
from .passes.interpass import in_cool_order
from .passes.order import in_short_order_by_pieces
from .passes.speeds import at_their_speeds
from .passes.start_points import with_overlap, with_spread_starts
from .pattern import Pattern, PatternSequence
from .patterns.contours import Contours

# Beads that end and start within so many step-overs of each other stay together in any order.
TOGETHER = 2.0
# The metal that beads lay within a piece's outline is what the piece needs within this share, or else that is told of.
METAL_WITHIN = 0.02
# Where beads half a width inside of the outline lay more than this share of a piece's metal beyond it, that is told of: the
# piece is narrower than three quarters of a bead then, which stands out by more than an eighth of its width a side. The report
# says it of all.
MOST_BEYOND = 0.1
BEYOND = "its beads lay {share} times its metal beyond its outline, since it is narrower than they are; a smaller bead fits"
TOO_MUCH = "its beads hold {share} times its metal: it is narrower than a bead can build at these speeds (fastest, balance)"
TOO_LITTLE = (
    "its beads hold {share} times its metal: its pattern does not reach all of it; auto or contours do, or slower beads"
)
BESIDE = "beads of the pieces beside it lay {share} times its metal into it; outline_position in, or a smaller bead, does not"
# What lies in corners that beads half a width inside of the outline do not reach is told of from this share of a piece on.
MOST_IN_CORNERS = 0.02
IN_CORNERS = (
    "{share} of it lies in corners that no bead half its width inside of the outline reaches; outline_position on, or a smaller"
    " bead, does"
)
PatternChoice = Callable[[int, Piece], Pattern]


def pattern_of(process: Process, layer: int, piece: Piece | None = None) -> Pattern:
    """The pattern that a process asks for on layer number `layer`, by its rules that of a piece."""
    asked = process.fill
    for rule in process.rules if piece is not None else ():
        if piece is not None and rule.on_layer(layer) and _holds(rule, piece):
            asked = replace(asked, **rule.changes)
            break
    return _inside_of_contours(process.updated(fill=asked, rules=()), layer, asked.pattern)


def _inside_of_contours(process: Process, layer: int, inside: Pattern) -> Pattern:
    """A pattern inside of the contours that a process asks for on a layer, if it does."""
    asked = process.fill
    if not asked.contours or layer % asked.contours_every:
        return inside
    contours = Contours(count=asked.contours, outwards=asked.contours_outwards, skeleton=False)
    return PatternSequence(patterns=(contours, inside), overlap=process.fill.overlap)


def _holds(rule: Rule, piece: Piece) -> bool:
    """Whether a rule that holds on the layer holds for a piece: the widest place is the largest circle inside."""
    import shapely

    if rule.full_turn is not None and rule.full_turn != piece.winds:
        return False
    if rule.narrower_than is None:
        return True
    chord = 0.01 * rule.narrower_than
    shape = band_between(piece, 0.0, 2.0, chord=chord) if piece.winds else polygon_from_piece(piece, chord=chord)
    circles = shapely.maximum_inscribed_circle(shapely.get_parts(shape), tolerance=1e-3 * rule.narrower_than)
    return 2.0 * float(shapely.length(circles).max()) < rule.narrower_than


def fill_layer(layer: Layer, process: Process, pattern: PatternChoice | None = None) -> LayerFill:
    """The beads of one layer, in the order and at the speeds of a process.

    `pattern` chooses for a layer's number and a piece what goes inside of the process's contours; without it, the process does
    for all pieces.
    """
    if pattern is not None:
        pattern = partial(_chosen, process, pattern)
    elif process.rules:
        pattern = partial(pattern_of, process)
    fill = fill_region(
        layer.region,
        pattern_of(process, layer.index) if pattern is None else partial(pattern, layer.index),
        step_over=process.step_over,
        width=process.width,
        inset=process.inset,
        chord=process.chord,
        shortest_bead=process.fill.shortest_bead,
        layer=layer.index,
    )
    if process.fill.spread_starts:
        # rings of equal pieces start at different places
        fill = replace(fill, beads=with_spread_starts(fill.beads, layer.index), copies=())
    fill = at_their_speeds(layer, fill, process)
    if process.fill.order is Order.SHORTEST:
        closure, reach, copies = layer.region.closure, TOGETHER * process.step_over, fill.copies
        beads = in_short_order_by_pieces(fill.beads, closure, reach=reach, turned=fill.turnable, copies=copies)
        fill = replace(fill, beads=beads)
    if process.fill.min_interpass_time_s:
        fill = _cooled(fill, process)
    if process.fill.alternate and layer.index % 2 == 1:
        fill = replace(fill, beads=tuple(bead.reversed() for bead in fill.beads[::-1]))
    beads = with_overlap(fill.beads, process.fill.closing_overlap)
    shares = metal_shares(beads, fill.shapes, copies=fill.copies, step_over=process.step_over, width=process.width)
    metal, beyond = tuple(zip(*shares, strict=True)) or ((), ())
    beside = metal_from_beside(beads, fill.shapes, step_over=process.step_over, width=process.width)
    metal = tuple(own + more for own, more in zip(metal, beside, strict=True))
    notes = [*fill.notes, *_off_balance(metal), *_bare_lobes(fill)]
    notes += [_of_piece(NoticeKind.PIECE_METAL, i, BESIDE, share) for i, share in enumerate(beside) if share > METAL_WITHIN]
    if process.inset >= 0.499 * process.width:
        said = [(i, share) for i, share in enumerate(beyond) if share > MOST_BEYOND]
        notes += [_of_piece(NoticeKind.PIECE_METAL, i, BEYOND, share) for i, share in said]
        notes += _bare_corners(fill)
    return replace(fill, beads=beads, metal=metal, beyond=beyond, notes=tuple(notes))


def _chosen(process: Process, choose: PatternChoice, layer: int, piece: Piece) -> Pattern:
    """The pattern that a caller chooses for a piece, inside of the process's contours."""
    return _inside_of_contours(process, layer, choose(layer, piece))


def _off_balance(metal: Sequence[float]) -> tuple[Notice, ...]:
    """Notes on pieces whose beads hold more or less than their metal; those without a bead are told of by their pattern."""
    out = []
    for index, share in enumerate(metal):
        if share > 0.0 and abs(share - 1.0) > METAL_WITHIN:
            text = TOO_MUCH if share > 1.0 else TOO_LITTLE
            out.append(_of_piece(NoticeKind.PIECE_METAL, index, text, share))
    return tuple(out)


def _of_piece(kind: NoticeKind, piece: int, text: str, share: float) -> Notice:
    return Notice(kind=kind, text=text, pieces=(piece,), figures={"share": (share, share)})


def _bare_corners(fill: LayerFill) -> list[Notice]:
    """Notes on pieces so small that their corners, where round beads do not reach, count."""
    out = []
    for index, shape in enumerate(fill.shapes):
        leader = fill.copies[index] if fill.copies else index
        share = fill.shapes[leader].corners / shape.piece.area()
        if share > MOST_IN_CORNERS:
            out.append(_of_piece(NoticeKind.BARE, index, IN_CORNERS, share))
    return out


def _bare_lobes(fill: LayerFill) -> tuple[Notice, ...]:
    """Notes on pieces of which parts that are narrower than a bead get none, though the rest of the piece does."""
    text = "{count} parts of it narrower than a bead get none, {area_mm2} mm2 in all; auto or a smaller bead fills them"
    lines: dict[int, list[Array]] = {}
    for bead in fill.beads:
        lines.setdefault(bead.piece, []).append(bead.points)
    found: dict[int, tuple[float, float]] = {}
    for piece, mine in lines.items():
        leader = fill.copies[piece] if fill.copies else piece
        if leader not in found:
            bare = fill.shapes[piece].bare_lobes(mine)
            found[leader] = float(len(bare)), sum(lobe.area for lobe in bare)
    return tuple(
        Notice(kind=NoticeKind.NARROW, text=text, pieces=(piece,), figures={"count": (count, count), AREA: (area, area)})
        for piece in lines
        for count, area in [found[fill.copies[piece] if fill.copies else piece]]
        if count
    )


def _cooled(fill: LayerFill, process: Process) -> LayerFill:
    """The beads in an order that lets neighbours cool, and a note where it cannot."""
    rest = process.fill.min_interpass_time_s
    speeds = {"speed": process.deposition_speed, "travel_speed": process.travel_speed}
    made = in_cool_order(fill.beads, step_over=process.step_over, rest=rest, **speeds)
    count = float(made.too_soon)
    text = f"{{count}} beads start beside one that ended less than {rest:g} s ago"
    note = Notice(kind=NoticeKind.SPEED, text=text, figures={"count": (count, count)})
    return replace(fill, beads=made.beads, notes=(*fill.notes, note) if made.too_soon else fill.notes)
