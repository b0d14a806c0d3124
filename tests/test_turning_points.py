"""Where edges turn back: circles and ellipses against their formulas, all of a solid's at once."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from brep_slicer.field import turning_points as module
from brep_slicer.field.turning_points import turning_points
from brep_slicer.geometry import Edge
from brep_slicer.geometry.edge_curves import ConicEdge

TURN = 2.0 * np.pi


def edge(centre, x, y, first=-0.3, last=TURN - 0.3):
    curve = ConicEdge(centre=np.array(centre, dtype=float), x=np.array(x, dtype=float), y=np.array(y, dtype=float))
    return Edge(curve=curve, first=first, last=last, vertices=(0, 0), tolerance=1e-7)


def eccentric(at, first=-0.3, last=TURN - 0.3):
    """A circle of radius 3 across the axis, its centre 10 mm from it at the angle `at`."""
    return edge((10.0 * np.cos(at), 10.0 * np.sin(at), 4.0), (3.0, 0, 0), (0, 3.0, 0), first, last)


# rho is farthest and nearest where the circle meets the line from the axis to its centre; where an ellipse, or a circle that is
# tilted, about the axis meets its own two
KNOWN = {
    "eccentric": (eccentric(1.0), [1.0, 1.0 + np.pi]),
    "arc with the far point": (eccentric(1.0, 0.5, 2.0), [1.0]),
    "arc with neither": (eccentric(1.0, 1.2, 4.0), []),
    "round the axis": (edge((0, 0, 5.0), (7.0, 0, 0), (0, 7.0, 0)), []),
    "ellipse about the axis": (edge((0, 0, 0), (9.0, 0, 0), (0, 4.0, 0)), [0.0, 0.5 * np.pi, np.pi, 1.5 * np.pi]),
    "tilted by 60 deg": (edge((0, 0, 0), (6.0, 0, 0), (0, 3.0, 3.0 * np.sqrt(3.0))), [0.0, 0.5 * np.pi, np.pi, 1.5 * np.pi]),
    # 9 cos**2 t + (1 + 2 sin t)**2: -10 sin t cos t + 4 cos t = 0
    "ellipse beside it": (
        edge((0, 1.0, 0), (3.0, 0, 0), (0, 2.0, 0)),
        [np.arcsin(0.4), 0.5 * np.pi, np.pi - np.arcsin(0.4), 1.5 * np.pi],
    ),
}


def test_conics_turn_where_their_formulas_do_all_at_once():
    edges = [known for known, _ in KNOWN.values()]
    for name, found, (_, right) in zip(KNOWN, turning_points(edges), KNOWN.values(), strict=True):
        np.testing.assert_allclose(found, right, atol=1e-12, err_msg=name)


def test_each_conic_turns_with_others_as_by_itself():
    random = np.random.default_rng(11)
    edges = []
    for _ in range(60):
        first = random.uniform(-3.0, 3.0)
        edges.append(edge(*random.normal(scale=5.0, size=(3, 3)), first, first + random.uniform(0.1, TURN)))
    together = turning_points(edges)
    assert sum(len(found) for found in together) > 60
    for each, found in zip(edges, together, strict=True):
        np.testing.assert_array_equal(found, turning_points([each])[0])
        # between two neighbours rho**2 goes one way only
        marks = np.concatenate([[each.first], found, [each.last]])
        for a, b in itertools.pairwise(marks):
            p = each.curve.points(np.linspace(a, b, 40))
            steps = np.diff(np.hypot(*p[:, :2].T))
            assert (steps > -1e-12).all() or (steps < 1e-12).all()


@pytest.mark.parametrize("count", [1, 50])
def test_a_solids_conics_are_looked_at_together(count, monkeypatch):
    calls, made = [], module._turning_points

    def counted(evaluate, breaks):
        calls.append(len(breaks))
        return made(evaluate, breaks)

    monkeypatch.setattr(module, "_turning_points", counted)
    turning_points([eccentric(0.1 * k) for k in range(count)])
    assert calls == [count]
