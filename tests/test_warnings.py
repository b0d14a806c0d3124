"""What a plan warns of."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

import brep_slicer as bs
from brep_slicer.fill import Contours, FlankFollowing, Hatch, fill_region
from brep_slicer.notices import Notice, NoticeKind
from brep_slicer.planning.warnings import notices_of_fills, notices_of_sections
from brep_slicer.proof import coverage_of
from brep_slicer.region import region_from_loops

from .test_fill import ARGS, R, rectangle

T, D = 1.4, 3.4


def warnings_of(layers, fills, process):
    """The sentences, as a plan's report has them."""
    return [str(n) for n in (*notices_of_sections(layers, (), process), *notices_of_fills(layers, fills, process))]


def note(text, *pieces):
    return Notice(kind=NoticeKind.PATTERN, text=text, pieces=pieces)


@pytest.fixture(scope="module")
def plan():
    part = bs.read_step(Path(__file__).resolve().parent.parent / "fixtures" / "step" / "spur_gear_tooth.step")
    return bs.plan(part, bs.Process(layer_thickness=T, step_over=D), layers=(0, 5))


def test_nothing_where_nothing_is_amiss(plan):
    assert warnings_of(plan.layers, plan.fills, plan.process) == []


def test_a_note_on_several_layers_and_pieces_is_one_line(plan):
    thin, cold = (note("thin", 0), note("thin", 1)), note("cold")
    notes = [thin, (), thin[:1], (note("thin", 4), cold), (cold,)]
    fills = [replace(fill, notes=said) for fill, said in zip(plan.fills, notes, strict=True)]
    assert warnings_of(plan.layers, fills, plan.process) == [
        "layers 0, 2 to 3, pieces 0 to 1, 4: thin",
        "layers 3 to 4: cold",
    ]


def test_pieces_too_narrow_for_a_bead_are_one_line_with_the_range_of_their_areas(plan):
    slits = [region_from_loops(R, [rectangle(0.0, 0.0, 1.5, height)]) for height in (2.0, 1.0, 1.5)]
    notes = [fill_region(slit, Hatch(angle=0.0), **ARGS).notes for slit in slits]
    fills = [replace(fill, notes=said) for fill, said in zip(plan.fills, [*notes, (), ()], strict=True)]
    assert warnings_of(plan.layers, fills, plan.process) == [
        "layers 0 to 2, piece 0 (1.5 to 3 mm2): too narrow for a bead 2.45 mm inside of its outline: left bare"
    ]


def test_beads_that_hold_too_much_or_too_little_metal(plan):
    twice = [replace(fill, beads=fill.beads * 2) if i in (1, 2) else fill for i, fill in enumerate(plan.fills)]
    (said,) = warnings_of(plan.layers, twice, plan.process)
    assert said.startswith("layers 1 to 2: the beads hold 1.")
    few = [replace(fill, beads=fill.beads[:2]) if i == 3 else fill for i, fill in enumerate(plan.fills)]
    piece, layer = warnings_of(plan.layers, few, plan.process)
    assert piece.startswith("layer 3, piece 0: its beads hold less than a tenth of the metal")
    assert layer.startswith("layer 3: the beads hold 0.")


@pytest.mark.parametrize(("pattern", "bare"), [(FlankFollowing(), True), (Hatch(angle=0.0), False), (Contours(), False)])
def test_a_strip_that_gets_too_few_beads_is_told_of(plan, pattern, bare):
    # room for one bead and a third beside each other: one of 2.16 mm leaves a third of 3.3 mm bare
    region = region_from_loops(R, [rectangle(0.0, 0.0, 3.3, 60.0)])
    process = plan.process.updated(step_over=1.5)
    fill = fill_region(region, pattern, step_over=1.5, width=process.width, inset=0.5 * process.width, chord=0.01)
    layer = replace(plan.layers[0], region=region, area=region.area)
    share = coverage_of(region, fill.beads, process.width).bare_share
    assert (share > 0.2) == bare
    said = [w for w in warnings_of([layer], [fill], process) if "more than a fifth of it bare" in w]
    assert [w[:18] for w in said] == (["layer 0, piece 0: "] if bare else [])


@pytest.mark.parametrize("name", ["propeller", "box_on_shaft", "cam"])
def test_no_piece_is_called_bare_that_is_not(name, fixture_step):
    made = bs.plan(bs.read_step(fixture_step(name)), bs.Process(layer_thickness=8.0, step_over=D))
    for layer, fill in zip(made.layers, made.fills, strict=True):
        said = [w for w in warnings_of([layer], [fill], made.process) if "more than a fifth of it bare" in w]
        if said:
            assert coverage_of(layer.region, fill.beads, made.process.width).bare_share > 0.2


def test_slower_beads_hold_more_metal(plan):
    import numpy as np

    slow = [replace(f, beads=tuple(replace(b, speed=np.full(len(b.points), 0.5)) for b in f.beads)) for f in plan.fills]
    (said,) = warnings_of(plan.layers, slow, plan.process)
    assert said.startswith("layers 0 to 4: the beads hold 1.")


def test_beads_narrower_than_their_distance(plan):
    (said,) = warnings_of(plan.layers, plan.fills, plan.process.updated(bead_width=3.0))
    assert "leave bare metal between them" in said
