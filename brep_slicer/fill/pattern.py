"""The one interface of all deposition patterns.

In: a piece of a region, how far inside of its outline the first bead's centre stays, the step-over. Out: beads.

Words: *area*, a piece with all that a pattern needs to know to fill it; *sequence*, patterns one after the other, each in
what the one before left.
"""

from __future__ import annotations

import abc
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar

from brep_slicer.process.parameter import Declared
from brep_slicer.region import Piece
from brep_slicer.wording import counted, shortened

from .bead import Bead
from .tools.inset import inset_piece
from .tools.lobes import Shape

if TYPE_CHECKING:
    from shapely import Polygon


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FillArea:
    """What a pattern fills: `piece` number `index` of layer number `layer`, and the beads `laid` in it before.

    Lengths are in mm: the centres of the outermost beads stay `inset` inside of the outline, neighbours are `step_over` apart,
    a bead is `width` wide, curves are sampled to `chord`.

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
    layer: int = 0

    def __repr__(self) -> str:
        sizes = f"inset {self.inset:.4g}, step-over {self.step_over:.4g}, width {self.width:.4g} mm"
        return f"FillArea(piece {self.index} of layer {self.layer}, {sizes}, {counted(len(self.laid), 'bead')} laid)"

    def polygons(self, inset: float | None = None) -> tuple[Polygon, ...]:
        """Where beads' centres may be: shapely polygons in (kappa, v), `inset` (mm) inside of the outline, its own by default.

        For a piece that goes all the way round they are drawn over one turn.
        """
        return inset_piece(self.piece, self.inset if inset is None else inset, chord=self.chord).polygons


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class AreaFill:
    """An area's beads in order; the angle (rad) and step-over used; the `inset` that is left for a pattern that follows (None:
    the area's own).

    `used` says in words what was chosen and why, where a pattern chooses; `shape` is what it learned about the piece's widths;
    what the last pattern's beads have to fill begins `border` mm inside of the outline.
    """

    beads: tuple[Bead, ...] = ()
    inset: float | None = None
    angle: float | None = None
    step_over: float | None = None
    notes: tuple[str, ...] = ()
    used: str = ""
    shape: Shape | None = None
    border: float = 0.0

    def __repr__(self) -> str:
        length = sum(bead.length() for bead in self.beads)
        return f"AreaFill({counted(len(self.beads), 'bead')}, {length:.5g} mm, {counted(len(self.notes), 'note')})"


class Pattern(Declared, abc.ABC):
    """A way to fill a piece: a frozen dataclass whose fields are its parameters (`parameter`).

    It has a `name`, by which process files and the command know it, and a line of `help`. Patterns in
    fill/patterns/ are found by their module's name, those of other packages by an entry point in `brep_slicer.patterns`.
    """

    __slots__ = ()

    name: ClassVar[str] = ""
    help: ClassVar[str] = ""
    # Whether pieces that equal each other but for a turn about the axis get beads that do: such are then filled once only.
    turns_along: ClassVar[bool] = False

    @classmethod
    def _in_words(cls) -> str:
        return f"pattern {cls.name or cls.__name__}"

    def as_dict(self) -> dict[str, Any]:
        """Its name and its parameters, as they stand in a process file."""
        return {"name": self.name or type(self).__name__, **Declared.as_dict(self)}

    @property
    def turnable(self) -> bool:
        """Whether its beads may be laid the other way round for shorter travels: not if it says `both_ways` = False."""
        return bool(getattr(self, "both_ways", True))

    @abc.abstractmethod
    def fill(self, area: FillArea) -> AreaFill:
        """The beads of one area, in the order of deposition."""

    def fill_all(self, areas: Sequence[FillArea]) -> list[AreaFill]:
        """The beads of every area of a layer; one after the other unless a pattern can do better."""
        return [self.fill(area) for area in areas]


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
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

    @property
    def turnable(self) -> bool:
        """Whether the beads of all of them may be laid the other way round."""
        return all(pattern.turnable for pattern in self.patterns)

    def __repr__(self) -> str:
        names = ", ".join(type(pattern).__name__ for pattern in self.patterns)
        overlap = "" if self.overlap is None else f", overlap {self.overlap:.4g} mm"
        return f"PatternSequence({shortened(names, 120)}{overlap})"

    def fill(self, area: FillArea) -> AreaFill:
        return self.fill_all([area])[0]

    def fill_all(self, areas: Sequence[FillArea]) -> list[AreaFill]:
        """Each pattern on all areas before the next one."""
        areas, out = list(areas), [AreaFill(beads=(), inset=area.inset) for area in areas]
        for pattern in self.patterns:
            for i, made in enumerate(pattern.fill_all(areas)):
                before, area = out[i], areas[i]
                inset = area.inset if made.inset is None else made.inset
                out[i] = AreaFill(
                    beads=before.beads + made.beads,
                    inset=inset,
                    angle=before.angle if made.angle is None else made.angle,
                    step_over=before.step_over if made.step_over is None else made.step_over,
                    notes=before.notes + made.notes,
                    used=made.used or before.used,
                    shape=made.shape or before.shape,
                    border=area.border,
                )
                filled = inset > area.inset
                areas[i] = replace(
                    area,
                    inset=inset - ((self.overlap or 0.0) if filled else 0.0),
                    meets_contour=filled and self.overlap is None,
                    laid=out[i].beads,
                    border=max(0.0, inset - 0.5 * area.step_over) if filled else area.border,
                )
        return out
