"""The one interface of all deposition patterns.

In: a piece of a region, how far inside of its outline the first bead's centre stays, the step-over. Out: beads.

Words: *cell*, a piece with all that a pattern needs to know to fill it; *sequence*, patterns one after the other, each in
what the one before left.
"""

from __future__ import annotations

import abc
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from brep_slicer.notices import AREA, Notice, NoticeKind
from brep_slicer.region import Piece, Region
from brep_slicer.wording import shortened

from .bead import Bead, LayerFill
from .copies import Copies, copies_of
from .lobes import Shape


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Cell:
    """What a pattern fills: `piece` number `index`; `inset`, `step_over`, `width`, `chord` in mm; the beads `laid` before.

    What those have to fill ends `border` mm inside of the outline. A piece is `lobed` if lobes too narrow for a bead stick out
    of it, which are not for its lines to fill.
    """

    piece: Piece
    index: int
    inset: float
    step_over: float
    width: float
    chord: float
    laid: tuple[Bead, ...] = ()
    border: float = 0.0
    lobed: bool = False


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CellFill:
    """A cell's beads in order; the `inset` that is left for a pattern that follows; the angle and step-over used.

    `used` says in words what was chosen and why, where a pattern chooses; `shape` is what it learned about the piece's widths;
    what the last pattern's beads have to fill begins `border` mm inside of the outline.
    """

    beads: tuple[Bead, ...]
    inset: float
    angle: float | None = None
    step_over: float | None = None
    notes: tuple[str, ...] = ()
    used: str = ""
    shape: Shape | None = None
    border: float = 0.0


class Pattern(abc.ABC):
    """A way to fill a piece; a frozen value with its parameters."""

    __slots__ = ()

    # Whether pieces that equal each other but for a turn about the axis get beads that do: such are then filled once only.
    turns_along: ClassVar[bool] = False

    @abc.abstractmethod
    def fill(self, cell: Cell) -> CellFill:
        """The beads of one cell, in the order of deposition."""

    def fill_all(self, cells: Sequence[Cell]) -> list[CellFill]:
        """The beads of every cell of a layer; one after the other unless a pattern can do better."""
        return [self.fill(cell) for cell in cells]


@dataclass(frozen=True, slots=True, kw_only=True)
class PatternSequence(Pattern):
    """Patterns one after the other in the same piece, each inside of what the one before left.

    With an `overlap` (mm), each reaches that much farther out. Lines that meet a contour at a small angle leave no wedge bare
    between them if the overlap is 2 d - w at least: their ends are then no farther than w - d from the contour's centre line.
    """

    patterns: tuple[Pattern, ...]
    overlap: float = 0.0

    @property
    def turns_along(self) -> bool:  # type: ignore[override]
        """Whether all of them do."""
        return all(pattern.turns_along for pattern in self.patterns)

    def __repr__(self) -> str:
        names = ", ".join(type(pattern).__name__ for pattern in self.patterns)
        return f"PatternSequence({shortened(names, 120)}, overlap {self.overlap:.4g} mm)"

    def fill(self, cell: Cell) -> CellFill:
        return self.fill_all([cell])[0]

    def fill_all(self, cells: Sequence[Cell]) -> list[CellFill]:
        """Each pattern on all cells before the next one."""
        cells, out = list(cells), [CellFill(beads=(), inset=cell.inset) for cell in cells]
        for pattern in self.patterns:
            for i, made in enumerate(pattern.fill_all(cells)):
                before, cell = out[i], cells[i]
                out[i] = CellFill(
                    beads=before.beads + made.beads,
                    inset=made.inset,
                    angle=before.angle if made.angle is None else made.angle,
                    step_over=before.step_over if made.step_over is None else made.step_over,
                    notes=before.notes + made.notes,
                    used=made.used or before.used,
                    shape=made.shape or before.shape,
                    border=cell.border,
                )
                filled = made.inset > cell.inset
                cells[i] = replace(
                    cell,
                    inset=made.inset - (self.overlap if filled else 0.0),
                    laid=out[i].beads,
                    border=max(0.0, made.inset - 0.5 * cell.step_over) if filled else cell.border,
                )
        return out


def _narrow(cell: Cell, shortest_bead: float) -> tuple[list[Bead], str]:
    """What becomes of a piece that its pattern cannot fill: a bead along its skeleton, or nothing, and in words."""
    from .skeleton import Skeleton

    beads = [bead for bead in Skeleton().fill(replace(cell, laid=())).beads if bead.length() >= max(shortest_bead, cell.width)]
    return beads, "one bead along its skeleton instead, wider than the piece" if beads else "left bare"


def _fills(cells: Sequence[Cell], patterns: Sequence[Pattern]) -> tuple[list[CellFill], Copies]:
    """Each cell's fill; cells with equal patterns are filled together, of equal ones the first only. And which are equal."""
    copies = copies_of([cell.piece for cell in cells])
    first = [
        k if p.turns_along and (patterns[k] is p or patterns[k] == p) else i
        for i, (p, k) in enumerate(zip(patterns, copies.first, strict=True))
    ]
    copies = replace(copies, first=tuple(first))
    found: dict[int, CellFill] = {}
    leaders = copies.leaders
    for k, leader in enumerate(leaders):
        if leader not in found:
            pattern = patterns[leader]
            alike = [i for i in leaders[k:] if patterns[i] is pattern or patterns[i] == pattern]
            found.update(zip(alike, pattern.fill_all([cells[i] for i in alike]), strict=True))
    out = [
        found[i] if i == k else _turned(found[k], cells[i], shift)
        for i, (k, shift) in enumerate(zip(copies.first, copies.shift, strict=True))
    ]
    return out, copies


def _turned(made: CellFill, cell: Cell, shift: float) -> CellFill:
    """The fill of an equal piece, `shift` (mm) further round."""
    way = np.array([shift, 0.0])
    beads = tuple(replace(bead, points=bead.points + way, piece=cell.index) for bead in made.beads)
    return replace(made, beads=beads, shape=None)


def fill_region(
    region: Region,
    pattern: Pattern | Callable[[Piece], Pattern],
    *,
    step_over: float,
    width: float,
    inset: float,
    chord: float,
    shortest_bead: float = 0.0,
) -> LayerFill:
    """Fill every piece of a region.

    Parameters
    ----------
    region : Region
        In the plane of its layer.
    pattern : Pattern or callable
        One for all pieces, or a function that chooses one for each.
    step_over, width, inset, chord : float
        d, w, the inset of the outermost bead centres, the tolerance of sampled outlines, mm.
    shortest_bead : float
        Beads shorter than this (mm) are left out, and counted in the notes.

    Returns
    -------
    LayerFill
        Beads piece by piece; a piece without any is named in the notes.
    """
    beads: list[Bead] = []
    notes: list[Notice] = []
    angles, steps = [], []
    cells = [
        Cell(piece=piece, index=index, inset=inset, step_over=step_over, width=width, chord=chord)
        for index, piece in enumerate(region.pieces)
    ]
    fills, copies = _fills(cells, [pattern if isinstance(pattern, Pattern) else pattern(cell.piece) for cell in cells])
    for index, (cell, made) in enumerate(zip(cells, fills, strict=True)):
        long = [bead for bead in made.beads if not shortest_bead or bead.length() >= shortest_bead]
        notes += [Notice(kind=NoticeKind.PATTERN, text=note, pieces=(index,)) for note in made.notes]
        if len(long) < len(made.beads):
            count = float(len(made.beads) - len(long))
            text = f"{{count}} beads shorter than {shortest_bead:g} mm left out"
            notes.append(Notice(kind=NoticeKind.SHORT_BEADS, text=text, pieces=(index,), figures={"count": (count, count)}))
        if not long:
            long, note = _narrow(cell, shortest_bead)
            area = cell.piece.area()
            text = f"too narrow for a bead {inset:g} mm inside of its outline: {note}"
            notes.append(Notice(kind=NoticeKind.NARROW, text=text, pieces=(index,), figures={AREA: (area, area)}))
        beads += long
        angles.append(float("nan") if made.angle is None else made.angle)
        steps.append(step_over if made.step_over is None else made.step_over)
    return LayerFill(
        beads=tuple(beads),
        angle=tuple(angles),
        step_over=tuple(steps),
        notes=tuple(notes),
        patterns=tuple(made.used for made in fills),
        border=tuple(made.border for made in fills),
        shapes=tuple(made.shape or Shape(c.piece, width, chord) for c, made in zip(cells, fills, strict=True)),
        copies=copies.first,
    )
