"""Metal that beads of one piece lay into the piece beside it: told of, and right by its formula."""

from __future__ import annotations

import numpy as np
import pytest

import brep_slicer as bs
from brep_slicer.curves import LineCurve, Loop
from brep_slicer.fill import fill_layer
from brep_slicer.layers import cylinder
from brep_slicer.notices import NoticeKind
from brep_slicer.region import Layer, region_from_loops
from brep_slicer.section import Certificate, Engine

R, T, D, W = 60.0, 1.4, 3.4, 4.9
SHEET = cylinder(R)
TURN = SHEET.closure.length
WIDE, HIGH = 20.0, 30.0


def row_of(starts, wide=WIDE):
    """Rectangles `wide` x HIGH that begin at `starts` along kappa."""
    loops = []
    for k in starts:
        corners = np.array([(k, 0.0), (k + wide, 0.0), (k + wide, HIGH), (k, HIGH)])
        lines = tuple(LineCurve(p0=corners[i], p1=corners[(i + 1) % 4]) for i in range(4))
        loops.append(Loop(curves=lines, sheet=SHEET))
    region = region_from_loops(SHEET, loops)
    certificate = Certificate(engine=Engine.ANALYTIC, residual=0.0, jog=0.0, checks={})
    return Layer(index=0, level=R, cut_level=R, thickness=T, region=region, area=region.area, certificate=certificate)


def filled(layer, position):
    pattern = bs.Contours(count=1, skeleton=False)
    fill = bs.Fill(bead_width=W, outline_position=position, pattern=pattern, balance=False)
    return fill_layer(layer, bs.Process(layer_thickness=T, step_over=D, fill=fill))


def told(fill):
    return {n.pieces[0]: n.figures["share"][0] for n in fill.notes if n.kind is NoticeKind.PIECE_METAL and "beside" in n.text}


def laid_over(gap):
    """The share of a straight bead beyond a line: its centre lies half its width outside of its own piece, `gap` from the next.

    Its section is a parabola over the width: beyond a line at s half widths from the middle lies (2 - 3 s + s**3) / 4 of it.
    """
    s = (gap - 0.5 * W) / (0.5 * W)
    return 0.25 * (2.0 - 3.0 * s + s**3) * D * HIGH / (WIDE * HIGH)


@pytest.mark.parametrize("gap", [0.5, 1.0, 2.0])
def test_a_bead_outside_of_one_piece_reaches_into_the_next(gap):
    share = told(filled(row_of([0.0, WIDE + gap]), "out"))
    assert set(share) == {0, 1}
    for value in share.values():
        # the contour lies a chord or two farther out, and turns round its corners
        assert value == pytest.approx(laid_over(gap), rel=0.02)


def test_the_piece_in_the_middle_gets_it_from_both_sides():
    gap = 1.0
    share = told(filled(row_of([0.0, WIDE + gap, 2.0 * (WIDE + gap)]), "out"))
    ends, middle = (share[0], share[2]), share[1]
    assert ends[0] == pytest.approx(ends[1], rel=1e-9)
    assert middle == pytest.approx(2.0 * ends[0], rel=1e-9)


def test_over_the_seam_too():
    gap = 1.0
    beside = told(filled(row_of([0.0, WIDE + gap]), "out"))
    across = told(filled(row_of([0.5 * TURN - WIDE - gap, 0.5 * TURN]), "out"))
    assert sorted(across.values()) == pytest.approx(sorted(beside.values()), rel=1e-9)


@pytest.mark.parametrize(("gap", "position"), [(W + 0.1, "out"), (1.0, "in"), (0.6 * W, "on")])
def test_nothing_is_told_where_none_reaches(gap, position):
    assert told(filled(row_of([0.0, WIDE + gap]), position)) == {}
