"""Every piece of a region filled by its pattern.

In: a region, a pattern for all pieces or one for each. Out: a LayerFill.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from brep_slicer.notices import AREA, Notice, NoticeKind
from brep_slicer.region import Piece, Region

from .bead import Bead, LayerFill
from .pattern import AreaFill, FillArea, Pattern
from .patterns.skeleton import Skeleton
from .tools.copies import Copies, copies_of
from .tools.lobes import Shape


def _narrow(area: FillArea, shortest_bead: float) -> tuple[list[Bead], str]:
    """What becomes of a piece that its pattern cannot fill: a bead along its skeleton, or nothing, and in words."""
    beads = [bead for bead in Skeleton().fill(replace(area, laid=())).beads if bead.length() >= max(shortest_bead, area.width)]
    return beads, "one bead along its skeleton instead, wider than the piece" if beads else "left bare"


def _fills(areas: Sequence[FillArea], patterns: Sequence[Pattern]) -> tuple[list[AreaFill], Copies]:
    """Each area's fill; areas with equal patterns are filled together, of equal ones the first only. And which are equal."""
    copies = copies_of([area.piece for area in areas])
    first = [
        k if p.turns_along and (patterns[k] is p or patterns[k] == p) else i
        for i, (p, k) in enumerate(zip(patterns, copies.first, strict=True))
    ]
    copies = replace(copies, first=tuple(first))
    found: dict[int, AreaFill] = {}
    leaders = copies.leaders
    for k, leader in enumerate(leaders):
        if leader not in found:
            pattern = patterns[leader]
            alike = [i for i in leaders[k:] if patterns[i] is pattern or patterns[i] == pattern]
            found.update(zip(alike, pattern.fill_all([areas[i] for i in alike]), strict=True))
    out = [
        found[i] if i == k else _turned(found[k], areas[i], shift)
        for i, (k, shift) in enumerate(zip(copies.first, copies.shift, strict=True))
    ]
    return out, copies


def _turned(made: AreaFill, area: FillArea, shift: float) -> AreaFill:
    """The fill of an equal piece, `shift` (mm) further round."""
    way = np.array([shift, 0.0])
    beads = tuple(replace(bead, points=bead.points + way, piece=area.index) for bead in made.beads)
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
    layer: int = 0,
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
    layer : int
        The layer's number, for patterns that differ from layer to layer.

    Returns
    -------
    LayerFill
        Beads piece by piece; a piece without any is named in the notes.
    """
    beads: list[Bead] = []
    notes: list[Notice] = []
    angles, steps = [], []
    areas = [
        FillArea(piece=piece, index=index, inset=inset, step_over=step_over, width=width, chord=chord, layer=layer)
        for index, piece in enumerate(region.pieces)
    ]
    patterns = [pattern if isinstance(pattern, Pattern) else pattern(area.piece) for area in areas]
    fills, copies = _fills(areas, patterns)
    for index, (area, made) in enumerate(zip(areas, fills, strict=True)):
        long = [bead for bead in made.beads if not shortest_bead or bead.length() >= shortest_bead]
        notes += [Notice(kind=NoticeKind.PATTERN, text=note, pieces=(index,)) for note in made.notes]
        if len(long) < len(made.beads):
            count = float(len(made.beads) - len(long))
            text = f"{{count}} beads shorter than {shortest_bead:g} mm left out"
            notes.append(Notice(kind=NoticeKind.SHORT_BEADS, text=text, pieces=(index,), figures={"count": (count, count)}))
        if not long:
            long, note = _narrow(area, shortest_bead)
            bare = area.piece.area()
            text = f"too narrow for a bead {inset:g} mm inside of its outline: {note}"
            notes.append(Notice(kind=NoticeKind.NARROW, text=text, pieces=(index,), figures={AREA: (bare, bare)}))
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
        shapes=tuple(made.shape or Shape(c.piece, width, chord) for c, made in zip(areas, fills, strict=True)),
        copies=copies.first,
        turnable=all(one.turnable for one in patterns),
    )
