"""The one interface of all deposition patterns.

In: a piece of a region, how far inside of its outline the first bead's centre stays, the step-over. Out: beads.

Words: *cell*, a piece with all that a pattern needs to know to fill it; *sequence*, patterns one after the other, each in
what the one before left.
"""

from __future__ import annotations

import abc
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

from brep_slicer.region import Piece
from brep_slicer.wording import shortened

from .bead import Bead
from .lobes import Shape


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Cell:
    """What a pattern fills: `piece` number `index`; `inset`, `step_over`, `width`, `chord` in mm; the beads `laid` before.

    What those have to fill ends `border` mm inside of the outline; where the pattern `meets_contour`, one lies a step-over
    outside of its inset, and lines end beside it by the rules of `meeting`. A piece is `lobed` if lobes too narrow for a bead
    stick out of it, which are not for its lines to fill.
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
    meets_contour: bool = False


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

    With an `overlap` (mm), each reaches that much farther out than a step-over from what is there already. Without (None),
    lines end beside a contour each by its slant, so that the two do not pile up (`meeting`).
    """

    patterns: tuple[Pattern, ...]
    overlap: float | None = 0.0

    @property
    def turns_along(self) -> bool:  # type: ignore[override]
        """Whether all of them do."""
        return all(pattern.turns_along for pattern in self.patterns)

    def __repr__(self) -> str:
        names = ", ".join(type(pattern).__name__ for pattern in self.patterns)
        overlap = "" if self.overlap is None else f", overlap {self.overlap:.4g} mm"
        return f"PatternSequence({shortened(names, 120)}{overlap})"

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
                    inset=made.inset - ((self.overlap or 0.0) if filled else 0.0),
                    meets_contour=filled and self.overlap is None,
                    laid=out[i].beads,
                    border=max(0.0, made.inset - 0.5 * cell.step_over) if filled else cell.border,
                )
        return out
