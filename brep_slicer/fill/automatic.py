"""The automatic pattern: hatch where it covers, contours and skeletons where it does not.

In: the cells of a layer. Out: beads; for each piece, in words, what was chosen and why.

What decides is how wide a piece is. Across a strip of width b a hatch leaves 0.09 w / b bare at its ends, and triangles
where it meets the edge at an angle; contours with a skeleton leave less than 2 % bare at any width, and have few ends. So a
piece nearly all of which has room for three lines side by side is hatched, the others get contours, one inside of the other,
and a skeleton where these leave something bare. Lobes too narrow for a bead do not count in that: they get one along their
skeleton, whatever the rest of their piece gets; it begins where the piece is as wide as a bead and grows with the lobe from
layer to layer.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from .contours import Contours
from .hatch import Hatch
from .lobes import Shape
from .pattern import Cell, CellFill, Pattern, PatternSequence
from .skeleton import Skeleton, beads_in_lobes

# A piece is wide where it has room for lines side by side over so many step-overs, half a bead inside of its outline.
ROOM = 2.0
# A piece is hatched if so much of it, narrow lobes apart, is wide: teeth and cams then show less than 2 % bare; with 0.9 of it
# wide a hatch leaves 4 % bare, where contours leave 1.7 %.
MOSTLY = 0.975
# By how much spacings may differ from d (a share of it) so that the outermost lines lie at the inset: less than w / d - 1, so
# that no gap opens between beads.
STRETCH = 0.25


@dataclass(frozen=True, slots=True, kw_only=True)
class Automatic(Pattern):
    """Hatch at `angle` (rad), `both_ways` or not, or contours (`outwards`: the innermost first) and skeletons, by the width.

    The hatch is stretched so that its outermost lines lie at the inset on both sides, by `stretch` (a share of d) at most.
    """

    turns_along = True
    angle: float = 0.0
    both_ways: bool = True
    outwards: bool = False
    stretch: float = STRETCH

    def fill(self, cell: Cell) -> CellFill:
        return self.fill_all([cell])[0]

    def fill_all(self, cells: Sequence[Cell]) -> list[CellFill]:
        """All hatched pieces of a layer at once."""
        shapes = [Shape(cell.piece, cell.width, cell.chord) for cell in cells]
        shares = [shape.wide_share(_wide(cell)) for shape, cell in zip(shapes, cells, strict=True)]
        hatched = [i for i, share in enumerate(shares) if share >= MOSTLY]
        hatch = Hatch(angle=self.angle, both_ways=self.both_ways, stretch=self.stretch)
        made = dict(
            zip(hatched, hatch.fill_all([replace(cells[i], lobed=bool(shapes[i].lobes)) for i in hatched]), strict=True)
        )
        out = []
        for i, (cell, shape, share) in enumerate(zip(cells, shapes, shares, strict=True)):
            fill = made.get(i)
            fill = self._followed(cell) if fill is None or not fill.beads else _with_lobes(cell, shape, fill)
            words = f"{fill.used}: {share:.2f} of it is wider than {_wide(cell):.4g} mm"
            out.append(replace(fill, used=words, shape=shape))
        return out

    def _followed(self, cell: Cell) -> CellFill:
        """Contours as many as fit, and beads along the skeleton of what they leave bare."""
        inner = replace(cell, inset=cell.border + 0.5 * cell.step_over) if cell.border > 0.0 else cell
        made = PatternSequence(patterns=(Contours(count=None, outwards=self.outwards), Skeleton())).fill(inner)
        kinds = [bead.kind.value for bead in made.beads]
        used = " and ".join(name for name, kind in (("contours", "contour"), ("skeleton", "skeleton")) if kind in kinds)
        return replace(made, used=used or "nothing", border=cell.border)


def _wide(cell: Cell) -> float:
    return cell.width + ROOM * cell.step_over


def _with_lobes(cell: Cell, shape: Shape, fill: CellFill) -> CellFill:
    """A hatched piece with a bead along the skeleton of each lobe; hatch lines that lie in lobes are left out."""
    import shapely

    lobes = beads_in_lobes(cell, shape)
    if not lobes:
        return replace(fill, used="hatch")
    kept = fill.beads
    if cell.inset < 0.499 * cell.width:
        narrow = shapely.union_all(list(shape.lobes))
        lines = [shapely.LineString(bead.points) for bead in kept]
        inside = [line.intersection(narrow).length > 0.5 * line.length for line in lines]
        kept = tuple(bead for bead, within in zip(kept, inside, strict=True) if not within)
    count = len(shape.lobes)
    return replace(fill, beads=(*kept, *lobes), used=f"hatch, skeletons in {count} narrow lobe{'s' if count > 1 else ''}")
