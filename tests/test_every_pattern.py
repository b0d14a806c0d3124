"""Every pattern on fixtures and real parts: beads inside of the exact outline by their inset, travels clear, nothing lost."""

from __future__ import annotations

import functools
import itertools
from pathlib import Path

import numpy as np
import pytest

import brep_slicer as bs
from brep_slicer.fill import BeadKind, fill_layer
from brep_slicer.fill.tools.distance import Outline
from brep_slicer.planning import motion_of
from brep_slicer.process import PATTERNS
from brep_slicer.toolpath import DepositLayer, lift_layers, obstacles_of

from .conftest import FIXTURES, REAL

CHORD = 0.005
PARTS = {
    "helical_gear_tooth": (FIXTURES / "helical_gear_tooth.step", None, 1.4, 3.4, (3, 20)),
    "spur_gear_tooth": (FIXTURES / "spur_gear_tooth.step", None, 1.4, 3.4, (3, 20)),
    "propeller": (FIXTURES / "propeller.step", None, 6.0, 3.4, (1, 12)),
    "keyed_band": (FIXTURES / "keyed_band.step", 45.0, 2.0, 3.0, (0, 3)),
    "cam": (FIXTURES / "cam.step", 40.0, 2.0, 2.0, (0, 5)),
    "box_on_shaft": (FIXTURES / "box_on_shaft.step", 50.0, 4.0, 3.0, (1, 7)),
    "wind_blade": (FIXTURES / "wind_blade.step", 40.0, 4.0, 1.5, (1, 8)),
    "tube": (FIXTURES / "tube.step", 20.0, 4.0, 3.0, (0, 2)),
    "cylinder": (FIXTURES / "cylinder.step", 5.0, 1.0, 1.0, (0, 3)),
    "eccentric_disc": (FIXTURES / "eccentric_disc.step", 15.0, 4.0, 2.0, (1, 4)),
    "drilled_tube": (FIXTURES / "drilled_tube.step", 30.0, 4.0, 3.0, (0, 3)),
    "oblique_tube": (FIXTURES / "oblique_tube.step", 30.0, 4.0, 3.0, (0, 3)),
    "spur_gear": (FIXTURES / "spur_gear.step", 87.5, 2.0, 1.0, (1, 9)),
    "helical_gear": (FIXTURES / "helical_gear.step", 87.5, 2.0, 1.0, (1, 9)),
    "gear_helical_z9": (REAL / "gear_helical_z9_asu.step", None, 0.5, 0.8, (2, 9)),
    "pulley_72t": (REAL / "pulley_72t_open5x.step", None, 0.6, 1.5, (2, 12)),
    "screw_m6": (REAL / "screw_m6_thread_build123d.step", None, 0.2, 0.2, (1, 6)),
    "propeller_6land": (REAL / "propeller_6land_D_5axisslicer.step", None, 2.0, 0.8, (1, 8)),
}


@functools.cache
def layers_of(name: str):
    """(process, axis, layers) of a part, cut once for all patterns."""
    path, substrate, t, d, numbers = PARTS[name]
    if not Path(path).exists():
        pytest.skip(f"{path} is not here")
    process = bs.Process(
        layer_thickness=t, step_over=d, motion=bs.Motion(chord=CHORD), fill=bs.Fill(pattern=bs.Automatic(angle_deg=28.0))
    )
    part = bs.read_step(path)
    axis = bs.find_axis(part) if REAL in Path(path).parents else bs.axis_from_text("Z")
    plan = bs.plan(part, process, axis=axis, substrate=substrate)
    assert not plan.failed
    return process, axis, [plan.layers[n] for n in numbers]


@pytest.mark.slow
@pytest.mark.parametrize("pattern", PATTERNS.own())
@pytest.mark.parametrize("name", PARTS)
def test_every_pattern(name, pattern):
    _check(name, pattern={"name": pattern, **({"angle_deg": 28.0} if pattern in ("auto", "hatch", "zigzag") else {})})


@pytest.mark.slow
@pytest.mark.parametrize("name", PARTS)
def test_contours_and_hatch(name):
    _check(name, contours=1)


def _check(name, **changes):
    process, axis, layers = layers_of(name)
    process = process.updated(fill=changes)
    for layer in layers:
        fill = fill_layer(layer, process)
        inset, said = process.inset, " ".join(map(str, fill.notes))
        for index, piece in enumerate(layer.region.pieces):
            mine = [bead for bead in fill.beads if bead.piece == index]
            # no piece is missing without a word
            assert mine or f"piece {index} (" in said
            outline = Outline([piece], inset)
            for bead in mine:
                gaps, _ = outline.distances(_along(bead.points))
                # along a skeleton a bead may be wider than the piece: its centre line is inside
                least = 0.0 if bead.kind is BeadKind.SKELETON else inset
                assert gaps.min() >= least - (1e-9 if bead.kind is BeadKind.HATCH else CHORD), (layer.index, index, bead.kind)
        deposit = DepositLayer(index=0, radius=layer.radius, thickness=layer.thickness, beads=fill.beads)
        path = lift_layers([deposit], motion_of(process), axis, obstacles_of([], layer.radius))
        _check_travels(path, axis, layer.radius)


def _along(points: np.ndarray) -> np.ndarray:
    step = max(0.05, float(np.hypot(*np.diff(points, axis=0).T).sum()) / 400.0)
    parts = [np.linspace(a, b, max(2, int(np.hypot(*(b - a)) / step))) for a, b in itertools.pairwise(points)]
    return np.concatenate(parts)


def _check_travels(path, axis, radius: float) -> None:
    """No travel comes nearer to the axis than the layer's surface, chords included."""
    p = axis.axis_from_file(path.points)
    moves = np.flatnonzero(~path.deposits[1:]) + 1
    for share in (0.0, 0.25, 0.5, 0.75, 1.0):
        rho = np.hypot(*((1.0 - share) * p[moves - 1] + share * p[moves])[:, :2].T)
        assert rho.min(initial=np.inf) >= radius - 1e-9
