"""What a plan warns of."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

import brep_slicer as bs
from brep_slicer.fill import Bead, BeadKind, Contours, FlankFollowing, Hatch, LayerFill, fill_region
from brep_slicer.layers import cylinder
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
    return bs.plan(part, bs.Process(layer_thickness=T, step_over=D, fill=bs.Fill(pattern="hatch")), layers=(0, 5))


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
    slits = [region_from_loops(cylinder(R), [rectangle(0.0, 0.0, 1.5, height)]) for height in (2.0, 1.0, 1.5)]
    notes = [fill_region(slit, Hatch(angle_deg=0.0), **ARGS).notes for slit in slits]
    fills = [replace(fill, notes=said) for fill, said in zip(plan.fills, [*notes, (), ()], strict=True)]
    assert warnings_of(plan.layers, fills, plan.process) == [
        "layers 0 to 2, piece 0 (1.5 to 3 mm2): too narrow for a bead 2.45 mm inside of its outline: left bare"
    ]


def test_beads_that_hold_too_much_or_too_little_metal(plan):
    twice = [replace(fill, beads=fill.beads * 2) if i in (1, 2) else fill for i, fill in enumerate(plan.fills)]
    (said,) = warnings_of(plan.layers, twice, plan.process)
    assert said.startswith("layers 1 to 2: the beads hold 1.")
    few = [replace(fill, beads=fill.beads[:1]) if i == 3 else fill for i, fill in enumerate(plan.fills)]
    piece, above, layer = warnings_of(plan.layers, few, plan.process)
    assert above.startswith("layer 4, piece 0: built on beads that hold 0.")
    assert piece.startswith("layer 3, piece 0: its beads hold less than a tenth of the metal")
    assert layer.startswith("layer 3: the beads hold 0.")


class TestBuiltOnTooLittle:
    """No layer is built on one that holds less than half of what is above it without a warning."""

    # strips 20 mm long, side by side; a mm of bead holds 3.4 mm2 of metal at the height t
    @staticmethod
    def layer(template, number, widths):
        loops = [rectangle(40.0 * i, 0.0, 40.0 * i + 20.0, width) for i, width in enumerate(widths)]
        region = region_from_loops(cylinder(R), loops)
        return replace(template, index=number, level=R, cut_level=R, region=region, area=region.area)

    @staticmethod
    def fill(*lengths):
        """A straight bead for each piece, of so many mm; none for 0."""
        return LayerFill(
            beads=tuple(
                Bead(points=[(40.0 * i, 1.0), (40.0 * i + length, 1.0)], kind=BeadKind.HATCH, piece=i)
                for i, length in enumerate(lengths)
                if length
            )
        )

    @pytest.mark.parametrize(
        ("below", "above", "said"),
        [
            # mm of bead in the pieces of either layer; shares of what is above
            ((60.0, 30.0), (60.0, 30.0), None),
            ((31.0, 30.0), (60.0, 30.0), None),
            ((29.0, 30.0), (60.0, 30.0), "layer 8, piece 0: built on beads that hold 0.4833 times"),
            # 1.8 % of its metal, as on a thin gear whose next layers get skeletons
            ((1.3, 0.6), (60.0, 30.0), "layer 8, pieces 0 to 1: built on beads that hold 0.02 to 0.02167 times"),
            # the other piece does not make up for it
            ((60.0, 0.0), (60.0, 30.0), "layer 8, piece 1: built on beads that hold 0 times"),
            # nothing is laid above
            ((60.0, 0.0), (60.0, 0.0), None),
        ],
    )
    def test_share_of_what_is_above(self, plan, below, above, said):
        layers = [self.layer(plan.layers[0], 7 + i, (12.0, 6.0)) for i in range(2)]
        lines = warnings_of(layers, [self.fill(*below), self.fill(*above)], plan.process)
        weak = [line for line in lines if "built on beads" in line]
        assert len(weak) == (said is not None)
        assert said is None or weak[0].startswith(said)

    def test_a_small_piece_below_that_is_full_is_another_matter(self, plan):
        # 6 mm2 below 240 mm2: that hangs in the air, and is told of by itself
        layers = [self.layer(plan.layers[0], 7, (0.3,)), self.layer(plan.layers[0], 8, (12.0,))]
        lines = warnings_of(layers, [self.fill(1.8), self.fill(60.0)], plan.process)
        assert not [line for line in lines if "built on beads" in line]

    def test_layers_that_do_not_follow_one_another_are_not_compared(self, plan):
        layers = [self.layer(plan.layers[0], number, (12.0, 6.0)) for number in (7, 9)]
        lines = warnings_of(layers, [self.fill(0.0, 30.0), self.fill(60.0, 30.0)], plan.process)
        assert not [line for line in lines if "built on beads" in line]


def test_empty_layers_are_one_line_and_no_kind_hides_another(plan, capsys):
    from brep_slicer.cli.summary import MOST_OF_A_KIND, warn

    empty = [replace(layer, region=replace(layer.region, pieces=()), area=0.0) for layer in plan.layers]
    (said,) = notices_of_sections([empty[0], plan.layers[1], *empty[2:]], (), plan.process)
    assert (said.kind, said.layers) == (NoticeKind.EMPTY, (0, 2, 3, 4))
    assert str(said) == "layers 0, 2 to 4: no metal (R 150 to 155.6 mm)"
    # forty notes of one kind are cut short, and the others are all there
    notes = [note(f"only {n} of 40 contours fit", 0) for n in range(40)]
    warn([*notes, said, Notice(kind=NoticeKind.ON_AIR, text="a rim hangs"), Notice(kind=NoticeKind.STACK, text="too high")])
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == MOST_OF_A_KIND + 4
    assert lines[MOST_OF_A_KIND] == f"warning: {40 - MOST_OF_A_KIND} more of this kind (pattern) in report.json"
    assert lines[-3:] == [f"warning: {said}", "warning: a rim hangs", "warning: too high"]


def test_figures_are_values_and_worded_once(plan):
    from brep_slicer.notices import grouped

    def of(layer, area):
        return Notice(kind=NoticeKind.ON_AIR, text="{area} mm2 hang", layers=(layer,), figures={"area": (area, area)})

    (said,) = grouped([of(3, 20.0), of(4, 1234.5), of(9, 7.0)])
    assert said.figures["area"] == (7.0, 1234.5)
    assert str(said) == "layers 3 to 4, 9: 7 to 1234 mm2 hang"
    assert said.as_dict()["figures"] == {"area": [7.0, 1234.5]}
    # a figure's name in a sentence that has none of it is text
    assert str(Notice(kind=NoticeKind.PART, text="solid '{area}'")) == "solid '{area}'"


@pytest.mark.parametrize(
    ("pattern", "bare"), [(FlankFollowing(), True), (Hatch(angle_deg=0.0), False), (Contours(count=1, skeleton=False), False)]
)
def test_a_strip_that_gets_too_few_beads_is_told_of(plan, pattern, bare):
    # room for one bead and a third beside each other: one of 2.16 mm leaves a third of 3.3 mm bare
    region = region_from_loops(cylinder(R), [rectangle(0.0, 0.0, 3.3, 60.0)])
    process = plan.process.updated(step_over=1.5)
    fill = fill_region(region, pattern, step_over=1.5, width=process.width, inset=0.5 * process.width, chord=0.01)
    layer = replace(plan.layers[0], region=region, area=region.area)
    share = coverage_of(region, fill.beads, process.width).bare_share
    assert (share > 0.2) == bare
    said = [w for w in warnings_of([layer], [fill], process) if "more than a fifth of it bare" in w]
    assert [w[:18] for w in said] == (["layer 0, piece 0: "] if bare else [])


@pytest.mark.parametrize("name", ["propeller", "box_on_shaft", "cam"])
def test_no_piece_is_called_bare_that_is_not(name, fixture_step):
    made = bs.plan(
        bs.read_step(fixture_step(name)), bs.Process(layer_thickness=8.0, step_over=D, fill=bs.Fill(pattern="hatch"))
    )
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
    (said,) = warnings_of(plan.layers, plan.fills, plan.process.updated(fill={"bead_width": 3.0}))
    assert "leave bare metal between them" in said
