"""How much there will be, said before anything is filled; asked for on a terminal, refused in a pipe."""

from __future__ import annotations

import math
import sys
from pathlib import Path

import pytest
import typer

import brep_slicer as bs
from brep_slicer.cli import commands
from brep_slicer.planning import cut_layers, fill_layers
from brep_slicer.planning.estimate import MOST_SECONDS, Estimate, check_size, estimate_of

FIXTURES = Path(__file__).resolve().parent.parent / "fixtures" / "step"
SMALL = Estimate(layers=3, beads=51, points=577, length=1407.0, seconds=4.0, file_mb=0.2, memory_mb=451.0)
LARGE = Estimate(layers=900, beads=10**7, points=10**8, length=1e9, seconds=6000.0, file_mb=4e4, memory_mb=1e5)


def sections(name, t, d, layers=None, **fill):
    return cut_layers(FIXTURES / f"{name}.step", bs.Process(layer_thickness=t, step_over=d, fill=fill), axis="Z", layers=layers)


@pytest.mark.parametrize(
    ("name", "t", "d", "layers"),
    [
        ("helical_gear_tooth", 1.4, 3.4, None),
        ("spur_gear_tooth", 1.4, 1.0, "0:8"),
        ("spur_gear", 1.0, 1.0, "0:3"),
        ("cam", 1.0, 1.0, None),
        ("box_on_shaft", 1.0, 1.0, "0:4"),
    ],
)
def test_a_hatched_part_takes_about_what_is_said(name, t, d, layers):
    cut = sections(name, t, d, layers, pattern=bs.Hatch(angle_deg=30))
    said, made = estimate_of(cut), fill_layers(cut)
    assert said.layers == len(made.layers)
    laid = made.toolpath.segment_lengths()[made.toolpath.deposits].sum()
    for guess, right in (
        (said.beads, sum(len(f.beads) for f in made.fills)),
        (said.points, len(made.toolpath)),
        (said.length, laid),
    ):
        assert 0.5 < guess / right < 2.0


def test_the_figures_are_those_of_the_formulas():
    cut = sections("spur_gear_tooth", 1.4, 2.0, "0:1", contours=2)
    (layer,) = cut.layers
    said = estimate_of(cut)
    assert said.length == pytest.approx(layer.area / 2.0)
    assert said.beads == round(layer.region.length / (math.pi * 2.0) + 2)
    # half the step-over: twice the length
    assert estimate_of(sections("spur_gear_tooth", 1.4, 1.0, "0:1")).length == pytest.approx(layer.area)


def test_a_step_over_in_the_wrong_unit_is_large_and_an_ordinary_plan_is_not():
    assert not estimate_of(sections("spur_gear_tooth", 1.4, 3.4)).is_large
    assert estimate_of(sections("spur_gear_tooth", 1.4, 3.4e-3)).is_large


def test_what_is_large_is_refused_in_words():
    check_size(SMALL, "part.step")
    with pytest.raises(bs.InputError, match=r"part\.step: 900 layers, about 10000000 beads, 1000 km, .*--yes") as caught:
        check_size(LARGE, "part.step")
    assert "\n" not in str(caught.value)
    assert LARGE.seconds > MOST_SECONDS


class TestAsking:
    @pytest.fixture
    def terminal(self, monkeypatch):
        for stream in (sys.stdin, sys.stderr):
            monkeypatch.setattr(stream, "isatty", lambda: True, raising=False)

    def test_small_plans_go_on_and_say_how_much(self, capsys):
        commands._ask(SMALL, "part.step", yes=False)
        assert capsys.readouterr().out.startswith("estimate: 3 layers, about 51 beads, 1.4 m, 580 points")

    def test_large_ones_are_refused_in_a_pipe(self, monkeypatch):
        monkeypatch.setattr(sys.stdin, "isatty", lambda: False, raising=False)
        with pytest.raises(bs.InputError) as caught:
            commands._ask(LARGE, "part.step", yes=False)
        assert caught.value.exit_code == 2

    def test_yes_is_yes(self):
        commands._ask(LARGE, "part.step", yes=True)

    @pytest.mark.usefixtures("terminal")
    def test_on_a_terminal_a_person_decides(self, monkeypatch):
        asked = []
        monkeypatch.setattr(typer, "confirm", lambda text, **given: asked.append(given))
        commands._ask(LARGE, "part.step", yes=False)
        assert asked == [{"abort": True, "err": True}]
