"""The speeds of the beads of a layer, all decided here, one on top of the other.

In: beads, what a process asks for. Out: the same beads with factors on the deposition speed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from brep_slicer.notices import Notice, NoticeKind
from brep_slicer.process import Process
from brep_slicer.region import Layer

from ..bead import Bead, BeadKind, LayerFill
from .adaptive_speed import with_speed_by_spacing
from .balance import with_balanced_metal

# Beads held at a limit of their speed along more than this share of their length are told of.
MUCH = 0.1


def at_their_speeds(layer: Layer, fill: LayerFill, process: Process) -> LayerFill:
    """The beads of a layer with their speeds.

    First what the spacing of the beads asks for, then what the metal of the pieces does, then contours at a speed of their own.
    """
    asked = process.fill
    limits = (asked.slowest, asked.fastest)
    if asked.adaptive_speed and fill.beads:
        beads = with_speed_by_spacing(fill.beads, step_over=process.step_over, limits=limits, closure=layer.region.closure)
        fill = replace(fill, beads=beads, notes=(*fill.notes, *_at_the_limit(beads, limits)))
    if asked.balance:
        sizes = {"step_over": process.step_over, "width": process.width, "inset": process.inset}
        fill = replace(fill, beads=with_balanced_metal(fill, **sizes, limits=limits, even=asked.adaptive_speed))
    return replace(fill, beads=tuple(_at_contour_speed(bead, process) for bead in fill.beads))


def _at_the_limit(beads: Sequence[Bead], limits: tuple[float, float]) -> tuple[Notice, ...]:
    """A note where the speeds that the spacing asks for are mostly beyond what is allowed."""
    steps = [np.hypot(*np.diff(bead.points, axis=0).T) for bead in beads]
    out = []
    for limit, word in zip(limits, ("lower", "higher"), strict=True):
        held = sum(float(s[b.speed[1:] == limit].sum()) for s, b in zip(steps, beads, strict=True) if b.speed is not None)
        if limit != 1.0 and held > MUCH * sum(float(s.sum()) for s in steps):
            text = f"the speed is held at {limit:g} times the usual along much of the beads: the height is {word} than t"
            out.append(Notice(kind=NoticeKind.SPEED, text=text))
    return tuple(out)


def _at_contour_speed(bead: Bead, process: Process) -> Bead:
    if process.motion.contour_speed_mm_s is None or bead.kind is not BeadKind.CONTOUR:
        return bead
    share = process.motion.contour_speed_mm_s / process.deposition_speed
    return replace(bead, speed=share * (np.ones(len(bead.points)) if bead.speed is None else bead.speed))
