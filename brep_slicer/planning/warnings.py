"""What a plan warns of, each kind of thing once.

In: layers, their fills, the process. Out: notices; the same thing said of several layers and pieces is one.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from brep_slicer.fill import LayerFill
from brep_slicer.maps import Array
from brep_slicer.notices import Notice, NoticeKind, grouped
from brep_slicer.process import Process
from brep_slicer.region import FailedLayer, Layer, overlapping_area, overlapping_pieces

# Beads that hold more metal than this share of a layer's, or less, are warned of. Half a bead of room on all sides leaves a
# third of a small piece; a bead wider than its piece is told of by itself.
MOST_METAL, LEAST_METAL = 1.5, 1.0 / 3.0
# Pieces that get less than this share of their metal are named, and pieces of which more than this share is bare for certain.
NEXT_TO_NONE, SURELY_BARE = 0.1, 0.2
# A piece is built on too little where what is below it holds less than this share of its metal, and of its own: on half its
# width, that is, at most.
LEAST_BELOW = 0.5
# Beads are laid to within a chord of where they belong; an outline that may be off by more than this share of it is warned of.
OUTLINES_SHARE = 0.1

OUTLINE_TEXT = (
    "the outline may be off by {error_mm} mm (its residual, gaps in the file and contradicting areas together), more than a"
    " tenth of the chord; the report says why"
)


def notices_of_sections(layers: Sequence[Layer], failed: Sequence[FailedLayer], process: Process) -> tuple[Notice, ...]:
    """What there is to say before anything is filled: layers that failed, that are empty, that lie over themselves."""
    notices = [
        _of_layer(NoticeKind.FAILED, layer, f"failed (R {{radius_mm}} mm): {layer.reason}", radius_mm=layer.radius)
        for layer in failed
    ]
    notices += [
        _of_layer(NoticeKind.EMPTY, layer, "no metal (R {radius_mm} mm)", radius_mm=layer.radius)
        for layer in layers
        if layer.region.is_empty
    ]
    notices += [
        _of_layer(NoticeKind.OUTLINE, layer, OUTLINE_TEXT, error_mm=layer.certificate.bound)
        for layer in layers
        if layer.certificate.bound > OUTLINES_SHARE * process.chord
    ]
    notices += _lying_over_themselves(layers, process)
    if process.width < process.step_over:
        text = f"beads {process.width:.4g} mm wide and {process.step_over:.4g} mm apart leave bare metal between them"
        notices.append(Notice(kind=NoticeKind.BARE, text=text))
    return grouped(notices)


def notices_of_fills(layers: Sequence[Layer], fills: Sequence[LayerFill], process: Process) -> tuple[Notice, ...]:
    """What patterns had to say, and beads that hold too much metal or too little."""
    said = [note.on_layer(layer.index) for layer, fill in zip(layers, fills, strict=True) for note in fill.notes]
    laid = [laid_by_piece(fill, process) for fill in fills]
    return grouped(
        [*said, *_almost_bare(layers, fills, laid, process), *_built_on_too_little(layers, laid), *_metal(layers, laid)]
    )


def _of_layer(kind: NoticeKind, layer: Layer | FailedLayer, text: str, **figures: float) -> Notice:
    return Notice(kind=kind, text=text, layers=(layer.index,), figures={name: (x, x) for name, x in figures.items()})


def _lying_over_themselves(layers: Sequence[Layer], process: Process) -> list[Notice]:
    """Layers on which the solid's faces run through one another."""
    text = (
        "the section lies over itself, {overlap_mm2} mm2, which get metal twice; the solid's faces run through one another"
        " (a thread wider than its pitch?), mend it"
    )
    out = []
    for layer in layers:
        area = overlapping_area(layer.region, chord=process.chord)
        if area > 0.0:
            out.append(_of_layer(NoticeKind.OVER_ITSELF, layer, text, overlap_mm2=area))
    return out


def _almost_bare(
    layers: Sequence[Layer], fills: Sequence[LayerFill], laid: Sequence[dict[int, float]], process: Process
) -> list[Notice]:
    """Pieces whose beads, if they have any, hold next to none of the metal they need, or cannot cover them."""
    scarce = "its beads hold less than a tenth of the metal that it needs"
    scarce += "; a smaller step-over or inset, contours or a skeleton fill it"
    bare = "its beads leave more than a fifth of it bare; a smaller step-over or inset, contours or another pattern cover it"
    out = []
    for layer, fill, held in zip(layers, fills, laid, strict=True):
        # no line of this length covers more, whatever its way
        covered = _by_piece(fill, _lengths(fill)[0] * process.width + 0.25 * math.pi * process.width**2)
        for number, metal in held.items():
            area = layer.region.pieces[number].area()
            too_little = metal < NEXT_TO_NONE * area
            uncovered = covered[number] < (1.0 - SURELY_BARE) * area and process.width >= process.step_over
            if too_little or uncovered:
                text = scarce if too_little else bare
                out.append(Notice(kind=NoticeKind.BARE, text=text, layers=(layer.index,), pieces=(number,)))
    return out


def _built_on_too_little(layers: Sequence[Layer], laid: Sequence[dict[int, float]]) -> list[Notice]:
    """Pieces that get their metal on pieces that did not: those hold less than a share of it."""
    text = "built on beads that hold {share} times the metal that is laid on them; fill the layer below with another pattern"
    out = []
    for i in range(1, len(layers)):
        below, above = layers[i - 1], layers[i]
        areas = [piece.area() for piece in below.region.pieces]
        scarce = any(laid[i - 1].get(k, 0.0) < LEAST_BELOW * area for k, area in enumerate(areas))
        if above.index != below.index + 1 or not laid[i] or not scarce:
            continue
        carriers: dict[int, list[int]] = {}
        for k, piece in overlapping_pieces(below.region, above.region):
            carriers.setdefault(piece, []).append(k)
        for piece, numbers in carriers.items():
            metal, held = laid[i].get(piece, 0.0), math.fsum(laid[i - 1].get(k, 0.0) for k in numbers)
            if held < LEAST_BELOW * min(metal, math.fsum(areas[k] for k in numbers)):
                share = held / metal
                figures = {"share": (share, share)}
                out.append(
                    Notice(kind=NoticeKind.WEAK_BELOW, text=text, layers=(above.index,), pieces=(piece,), figures=figures)
                )
    return out


def laid_by_piece(fill: LayerFill, process: Process) -> dict[int, float]:
    """The area (mm**2) that the beads of each piece that has any fill at the height t: their lengths times d."""
    return _by_piece(fill, _lengths(fill)[1] * process.step_over)


def _by_piece(fill: LayerFill, shares: Array) -> dict[int, float]:
    """What the beads of each piece that has any have together, of a number for each bead."""
    if not fill.beads:
        return {}
    pieces, at = np.unique([bead.piece for bead in fill.beads], return_inverse=True)
    return dict(zip(pieces.tolist(), np.bincount(at, weights=shares).tolist(), strict=True))


def _metal(layers: Sequence[Layer], laid: Sequence[dict[int, float]]) -> list[Notice]:
    """t d times the beads' length (slower where their speed is less) against t times the area, layer by layer."""
    text = "the beads hold {share} times the metal that the layer needs; --proof shows where"
    out = []
    for layer, held in zip(layers, laid, strict=True):
        if held and layer.area > 0.0:
            share = math.fsum(held.values()) / layer.area
            if not LEAST_METAL <= share <= MOST_METAL:
                out.append(_of_layer(NoticeKind.METAL, layer, text, share=share))
    return out


def _lengths(fill: LayerFill) -> tuple[Array, Array]:
    """The lengths (mm) of the beads, and those at the common speed that hold as much metal."""
    if not fill.beads:
        return np.zeros(0), np.zeros(0)
    counts = np.array([len(bead.points) for bead in fill.beads])
    speeds = np.concatenate([np.ones(len(bead.points)) if bead.speed is None else bead.speed for bead in fill.beads])
    steps = np.hypot(*np.diff(np.concatenate([bead.points for bead in fill.beads]), axis=0).T)
    mean, bead = 0.5 * (speeds[1:] + speeds[:-1]), np.repeat(np.arange(len(counts)), counts)
    # not the steps from one bead to the next
    own = bead[1:] == bead[:-1]
    of, steps = bead[1:][own], steps[own]
    return tuple(np.bincount(of, weights=w, minlength=len(counts)) for w in (steps, steps / mean[own]))  # type: ignore[return-value]
