"""The automatic pattern: hatch where it covers, contours and skeletons where it does not.

In: the areas of a layer. Out: beads; for each piece, in words, what was chosen and why.

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
from typing import ClassVar

from brep_slicer.process.parameter import parameter
from brep_slicer.process.taken import Taken

from ..pattern import AreaFill, FillArea, Pattern
from ..tools.lobes import Shape
from ..tools.parallel import ParallelLines, angle_on_layer
from .contours import Contours
from .skeleton import beads_in_lobes

# A piece is wide where it has room for lines side by side over so many step-overs, half a bead inside of its outline.
ROOM = 2.0
# A piece is hatched if so much of it, narrow lobes apart, is wide: teeth and cams then show less than 2 % bare; with 0.9 of it
# wide a hatch leaves 4 % bare, where contours leave 1.7 %.
MOSTLY = 0.975
# By how much spacings may differ from d (a share of it) so that the outermost lines lie at the inset: less than w / d - 1, so
# that no gap opens between beads.
STRETCH = 0.25


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class Automatic(Pattern):
    """A hatch (`angle_deg`, `both_ways`), or contours (`outwards`: the innermost first) and skeletons, by the width.

    The hatch is stretched so that its outermost lines lie at the inset on both sides, by `stretch` (a share of d) at most.
    """

    name: ClassVar[str] = "auto"
    help: ClassVar[str] = "for each piece what covers it: hatch, or contours and skeleton where it is narrow"
    turns_along: ClassVar[bool] = True

    angle_deg: Taken[tuple[float, ...], float | Sequence[float]] = parameter(
        (0.0,),
        unit="deg",
        many=True,
        options=("--angle",),
        help="Angle of the lines, counter-clockwise from the circumference; of several, layer by layer in turn",
    )
    angle_step_deg: float = parameter(0.0, unit="deg", help="The lines turn by so much from layer to layer")
    both_ways: bool = parameter(True, options=("--both-ways/--one-way",), help="Every second line is laid backwards")
    outwards: bool = parameter(False, help="Laid from the inside outwards")
    stretch: float = parameter(
        STRETCH,
        least=0.0,
        below=0.5,
        help="By what share of d spacings may differ from it so that a piece's width is filled exactly",
    )

    def fill(self, area: FillArea) -> AreaFill:
        return self.fill_all([area])[0]

    def fill_all(self, areas: Sequence[FillArea]) -> list[AreaFill]:
        """All hatched pieces of a layer at once."""
        shapes = [Shape(area.piece, area.width, area.chord) for area in areas]
        shares = [shape.wide_share(_wide(area)) for shape, area in zip(shapes, areas, strict=True)]
        hatched = [i for i, share in enumerate(shares) if share >= MOSTLY]
        angle = angle_on_layer(self.angle_deg, self.angle_step_deg, areas[0].layer if areas else 0)
        hatch = ParallelLines(angle=angle, both_ways=self.both_ways, stretch=self.stretch)
        made = dict(
            zip(hatched, hatch.fill_all([replace(areas[i], lobed=bool(shapes[i].lobes)) for i in hatched]), strict=True)
        )
        out = []
        for i, (area, shape, share) in enumerate(zip(areas, shapes, shares, strict=True)):
            fill = made.get(i)
            fill = self._followed(area) if fill is None or not fill.beads else _with_lobes(area, shape, fill)
            words = f"{fill.used}: {share:.2f} of it is wider than {_wide(area):.4g} mm"
            out.append(replace(fill, used=words, shape=shape))
        return out

    def _followed(self, area: FillArea) -> AreaFill:
        """Contours as many as fit, and beads along the skeleton of what they leave bare."""
        inner = replace(area, inset=area.border + 0.5 * area.step_over) if area.border > 0.0 else area
        made = Contours(outwards=self.outwards).fill(inner)
        kinds = [bead.kind.value for bead in made.beads]
        used = " and ".join(name for name, kind in (("contours", "contour"), ("skeleton", "skeleton")) if kind in kinds)
        return replace(made, used=used or "nothing", border=area.border)


def _wide(area: FillArea) -> float:
    return area.width + ROOM * area.step_over


def _with_lobes(area: FillArea, shape: Shape, fill: AreaFill) -> AreaFill:
    """A hatched piece with a bead along the skeleton of each lobe; hatch lines that lie in lobes are left out."""
    import shapely

    lobes = beads_in_lobes(area, shape)
    if not lobes:
        return replace(fill, used="hatch")
    kept = fill.beads
    if area.inset < 0.499 * area.width:
        narrow = shapely.union_all(list(shape.lobes))
        lines = [shapely.LineString(bead.points) for bead in kept]
        inside = [line.intersection(narrow).length > 0.5 * line.length for line in lines]
        kept = tuple(bead for bead, within in zip(kept, inside, strict=True) if not within)
    count = len(shape.lobes)
    return replace(fill, beads=(*kept, *lobes), used=f"hatch, skeletons in {count} narrow lobe{'s' if count > 1 else ''}")
