"""How much there will be: beads, points, seconds, megabytes, from sections alone, before anything is filled.

In: PlanSections. Out: an Estimate, right to a factor of about two on hatched parts: enough to ask before hours pass.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from brep_slicer.errors import InputError
from brep_slicer.wording import counted, in_words_of_length, in_words_of_time

from .planned import PlanSections

# Points that a travel to a bead takes: up, over and down again.
TRAVEL_POINTS = 4
# Microseconds a point: to fill (0.6 to 18 measured on a tube, gears, a cam and propellers, 2 cores), and to write it with its
# pictures (7 to 11 from 150,000 points on).
FILL_US, WRITE_US = 12.0, 10.0
# What is computed for however small a plan, s; what the libraries and a part of moderate size hold, MB.
LEAST_S, LEAST_MB = 2.0, 450.0
# Bytes a point in toolpath.csv and toolpath.json together (300 to 430 measured), and in memory at most: the plan itself (240
# measured at 1,100,000 points, 235 at 3,600,000), since files and toolpath.png are made in blocks.
FILE_BYTES, MEMORY_BYTES = 400.0, 250.0
# A person is asked before more than this: half an hour of computing, or the memory of a small machine.
MOST_SECONDS, MOST_MEMORY_MB = 1800.0, 2000.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Estimate:
    """What a plan will take: `layers`, `beads`, `points`, bead `length` (mm), `seconds` to compute, `file_mb`, `memory_mb`."""

    layers: int
    beads: int
    points: int
    length: float
    seconds: float
    file_mb: float
    memory_mb: float

    @property
    def is_large(self) -> bool:
        """Whether it is more than a person would wait for unasked."""
        return self.seconds > MOST_SECONDS or self.memory_mb > MOST_MEMORY_MB

    def __str__(self) -> str:
        laid = f"{counted(self.layers, 'layer')}, about {counted(_rounded(self.beads), 'bead')}"
        points = f"{in_words_of_length(_rounded(self.length))}, {_rounded(self.points)} points"
        size = f"{_rounded(self.file_mb)} MB of files, {_rounded(self.memory_mb)} MB of memory"
        return f"{laid}, {points}, {in_words_of_time(_rounded(self.seconds))} to compute, {size}"


def estimate_of(sections: PlanSections) -> Estimate:
    """From each layer's area A and outline P: beads are A / d long in all, and cross it P / (pi d) times.

    The latter is Crofton's formula: lines of random direction, d apart, cross an outline of length P on average 2 P / (pi d)
    times, and there is a bead between every two crossings. Contours lie along P. A bead has a point every sqrt(8 R chord), the
    chord of an arc with that sagitta.
    """
    process = sections.process
    d, chord = process.step_over, process.chord
    areas, outlines, radii, pieces = (
        np.array([(x.area, x.region.length, x.radius, len(x.region.pieces)) for x in sections.layers], dtype=float)
        .reshape(-1, 4)
        .T
    )
    length = areas / d
    beads = outlines / (math.pi * d) + process.fill.contours * pieces
    points = length / np.sqrt(8.0 * radii * chord) + TRAVEL_POINTS * beads
    total = float(points.sum())
    return Estimate(
        layers=len(sections.layers),
        beads=round(float(beads.sum())),
        points=round(total),
        length=float(length.sum()),
        seconds=LEAST_S + (FILL_US + WRITE_US) * 1e-6 * total,
        file_mb=FILE_BYTES * 1e-6 * total,
        memory_mb=LEAST_MB + MEMORY_BYTES * 1e-6 * total,
    )


def check_size(estimate: Estimate, source: str) -> None:
    """Refuse what is larger than a person would wait for.

    Raises
    ------
    InputError
        If it is, with the figures and what makes it smaller.
    """
    if estimate.is_large:
        raise InputError(
            f"{source}: {estimate}: more than {in_words_of_time(MOST_SECONDS)} or {MOST_MEMORY_MB:g} MB; --yes plans it all the"
            " same, a larger step-over (-d) or fewer layers at once (--layers) make it smaller"
        )


def _rounded(value: float) -> int:
    """To two figures: it is no more exact than that."""
    return round(value) if value < 100.0 else int(float(f"{value:.2g}"))
