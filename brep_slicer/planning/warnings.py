"""What a plan warns of, in as few lines as tell it.

In: layers, their fills, the process. Out: sentences; the same note on several layers and pieces is one.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence

import numpy as np

from brep_slicer.fill import LayerFill
from brep_slicer.process import Process
from brep_slicer.region import FailedLayer, Layer, overlapping_area

# Beads that hold more metal than this share of a layer's, or less, are warned of. Half a bead of room on all sides leaves a
# third of a small piece; a bead wider than its piece is told of by itself.
MOST_METAL, LEAST_METAL = 1.5, 1.0 / 3.0
# Pieces that get less than this share of their metal are named, and pieces of which more than this share is bare for certain.
NEXT_TO_NONE, SURELY_BARE = 0.1, 0.2
_PIECE = re.compile(r"^piece (\d+)(?: \(([\d.e+-]+) mm2\))?: ")


def warnings_of(layers: Sequence[Layer | FailedLayer], fills: Sequence[LayerFill], process: Process) -> list[str]:
    """Failed and empty layers, sections that lie over themselves, what patterns had to say, beads too full or too empty."""
    out, notes = [], []
    for layer, fill in zip(layers, fills, strict=True):
        if isinstance(layer, FailedLayer):
            out.append(f"layer {layer.index} (R {layer.radius:.6g} mm) failed: {layer.reason}")
        elif layer.region.is_empty:
            out.append(f"layer {layer.index} (R {layer.radius:.6g} mm) meets no metal")
        notes += [(layer.index, note) for note in fill.notes]
    out += _lying_over_themselves(layers, process)
    if process.width < process.step_over:
        out.append(f"beads {process.width:.4g} mm wide and {process.step_over:.4g} mm apart leave bare metal between them")
    return [*out, *_grouped([*notes, *_almost_bare(layers, fills, process)]), *_metal(layers, fills, process)]


def _grouped(notes: Iterable[tuple[int, str]]) -> list[str]:
    """One sentence for each thing that is said, with the layers and the pieces it is said of, and how large those are."""
    said: dict[str, tuple[set[int], set[int], set[float]]] = {}
    for layer, note in notes:
        found = _PIECE.match(note)
        layers, pieces, areas = said.setdefault(_PIECE.sub("", note), (set(), set(), set()))
        layers.add(layer)
        if found:
            pieces.add(int(found[1]))
            areas.update([float(found[2])] if found[2] else [])
    return [
        f"{_numbers('layer', layers)}{', ' + _numbers('piece', pieces) if pieces else ''}{_sizes(areas)}: {note}"
        for note, (layers, pieces, areas) in said.items()
    ]


def _sizes(areas: set[float]) -> str:
    """' (1.2 mm2)', ' (1.2 to 3.4 mm2)', or nothing."""
    if not areas:
        return ""
    low, high = f"{min(areas):.4g}", f"{max(areas):.4g}"
    return f" ({low} mm2)" if low == high else f" ({low} to {high} mm2)"


def _numbers(word: str, numbers: set[int]) -> str:
    """'layer 3', 'layers 3 to 8, 12'."""
    runs: list[list[int]] = []
    for n in sorted(numbers):
        if runs and n == runs[-1][1] + 1:
            runs[-1][1] = n
        else:
            runs.append([n, n])
    text = ", ".join(f"{a}" if a == b else f"{a} to {b}" for a, b in runs)
    return f"{word}{'s' if len(numbers) > 1 else ''} {text}"


def _lying_over_themselves(layers: Sequence[Layer | FailedLayer], process: Process) -> list[str]:
    """Layers on which the solid's faces run through one another."""
    chord = process.value("chord")
    whole = [layer for layer in layers if isinstance(layer, Layer)]
    over = {layer.index: area for layer in whole if (area := overlapping_area(layer.region, chord=chord)) > 0.0}
    if not over:
        return []
    return [
        f"{_numbers('layer', set(over))}: the section lies over itself, {max(over.values()):.4g} mm2 at most, which get metal"
        " twice; the solid's faces run through one another (a thread wider than its pitch?), mend it"
    ]


def _almost_bare(layers: Sequence[Layer | FailedLayer], fills: Sequence[LayerFill], process: Process) -> list[tuple[int, str]]:
    """Notes on pieces whose beads, if they have any, hold next to none of the metal they need, or cannot cover them."""
    out = []
    for layer, fill in zip(layers, fills, strict=True):
        if not isinstance(layer, Layer):
            continue
        laid: dict[int, float] = {}
        covered: dict[int, float] = {}
        for bead in fill.beads:
            laid[bead.piece] = laid.get(bead.piece, 0.0) + _equal_length(bead) * process.step_over
            # no line of this length covers more, whatever its way
            most = bead.length() * process.width + 0.25 * math.pi * process.width**2
            covered[bead.piece] = covered.get(bead.piece, 0.0) + most
        for number, metal in laid.items():
            area = layer.region.pieces[number].area()
            if metal < NEXT_TO_NONE * area:
                share = f"piece {number}: its beads hold less than a tenth of the metal that it needs"
                out.append((layer.index, f"{share}; a smaller step-over or inset, contours or a skeleton fill it"))
            elif covered[number] < (1.0 - SURELY_BARE) * area and process.width >= process.step_over:
                share = f"piece {number}: its beads leave more than a fifth of it bare"
                out.append((layer.index, f"{share}; a smaller step-over or inset, contours or another pattern cover it"))
    return out


def _metal(layers: Sequence[Layer | FailedLayer], fills: Sequence[LayerFill], process: Process) -> list[str]:
    """t d times the beads' length (slower where their speed is less) against t times the area, layer by layer."""
    off = {}
    for layer, fill in zip(layers, fills, strict=True):
        if isinstance(layer, Layer) and fill.beads and layer.area > 0.0:
            laid = math.fsum(_equal_length(bead) for bead in fill.beads) * process.step_over / layer.area
            if not LEAST_METAL <= laid <= MOST_METAL:
                off[layer.index] = laid
    if not off:
        return []
    low, high = min(off.values()), max(off.values())
    share = f"{low:.2g}" if high < 1.05 * low else f"{low:.2g} to {high:.2g}"
    return [f"{_numbers('layer', set(off))}: the beads hold {share} times the metal that the layer needs; --proof shows where"]


def _equal_length(bead) -> float:
    """The length (mm) at the common speed that holds as much metal as a bead."""
    steps = np.hypot(*np.diff(bead.points, axis=0).T)
    if bead.speed is None:
        return float(steps.sum())
    return float((steps / (0.5 * (bead.speed[1:] + bead.speed[:-1]))).sum())
