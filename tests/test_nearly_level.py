"""Faces that are nearly tangent to the cylinder, on solids whose edges lie off their faces."""

from __future__ import annotations

import build123d as bd
import numpy as np
import pytest

import brep_slicer as bs
from brep_slicer.errors import LayerError
from brep_slicer.section import cut_solids
from brep_slicer.section.analytic import sections_by_analysis
from brep_slicer.substrate.axis import axis_from_text

from .gaping import with_edges_off
from .nearly_level import Graph

Z = axis_from_text("Z")
R = 100.0
# the cylinder R to 1e-5 mm; what is added to it is how far a top is from level
ROUND = {(0, 0): R, (2, 0): -1.0 / (2.0 * R), (4, 0): -1.0 / (8.0 * R**3)}
# edges lie so far off their faces, mm
OFF = 1e-3


def top(more, *, level=ROUND, wide=10.0, high=20.0):
    """A graph of the level's coefficients and `more`, by their exponents of y and z."""
    power = np.zeros((5, 3))
    for terms in (level, more):
        for exponents, value in terms.items():
            power[exponents] += value
    return Graph(power=tuple(map(tuple, power.tolist())), wide=wide, high=high)


# rho at the four corners and along the sides differs by 0.04 to 0.4 mm: with edges 1e-3 mm off, a level line ends up to some
# mm from where the edge meets the layer
TOPS = {
    "tilted": top({(0, 1): 2e-3, (1, 0): 1e-3}),
    "saddle": top({(0, 0): -0.02, (1, 1): 1e-3, (0, 1): 2e-3, (0, 2): -1e-4}),
    "ridge": top({(0, 1): 8e-3, (0, 2): -2.2e-4, (1, 0): 3e-3, (1, 1): -1e-4}),
    "dome": top({(2, 0): -2e-4, (0, 1): 4e-3, (0, 2): -2e-4}),
    "plane": top({(0, 1): 1e-4}, level={(0, 0): R}, wide=3.0),
}


def cut(solid):
    (one,) = cut_solids(bs.as_part(solid), Z)
    return one


@pytest.mark.parametrize("off", [0.0, OFF])
@pytest.mark.parametrize("name", TOPS)
def test_a_nearly_level_top_is_cut_as_its_formula_says(name, off):
    graph = TOPS[name]
    solid = cut(with_edges_off(graph.solid(), off, straight=True) if off else graph.solid())
    assert not off or solid.gaps.max() > 0.3 * off
    y, z = np.meshgrid(np.linspace(-graph.wide, graph.wide, 41), np.linspace(0.0, graph.high, 41))
    rho = np.hypot(graph.height(y, z), y)
    # a plane's outline near its top is a lobe of less than 0.4 mm: not asked here
    low, high = max(float(rho.min()), R + 2e-3 if name == "plane" else 0.0), float(rho.max())
    radii = np.sort(np.random.default_rng(3).uniform(low, high, 24))
    for radius, found in zip(radii.tolist(), sections_by_analysis(solid, radii), strict=True):
        assert not isinstance(found, LayerError), f"R {radius}: {found}"
        loops, certificate = found
        length = sum(loop.length() for loop in loops)
        # the formula's sum is good to 1e-5 mm2 where an outline turns round
        assert sum(loop.signed_area() for loop in loops) == pytest.approx(graph.area(radius), abs=1e-7 * length + 1e-5)
        # the outline does not gape by more than the file
        assert certificate.bound <= 2.0 * off + 1e-9


def lump(outline):
    return bd.extrude(bd.Pos(30, 0, 0) * outline, 10).solid()


TURNING = {
    "hole": lambda: (bd.Pos(30, 0, 5) * bd.Box(20, 20, 10) - bd.Pos(30, 0, 5) * bd.Cylinder(5, 10)).solid(),
    "cylinder": lambda: lump(bd.Circle(5)),
    "ellipse": lambda: lump(bd.Ellipse(6, 3)),
    "cone": lambda: (bd.Pos(30, 0, 5) * bd.Cone(5, 3, 10)).solid(),
}


@pytest.mark.parametrize("name", TURNING)
def test_an_edge_turns_back_where_its_flatter_face_does(name):
    """A wheel's spoke hole: the edge between hole and fillet turns back 8e-4 mm beside the hole's own lowest line."""
    exact, moved = cut(TURNING[name]()), cut(with_edges_off(TURNING[name](), OFF))
    offsets = np.linspace(-2.0 * OFF, 2.0 * OFF, 20)
    radii = np.unique(np.add.outer(exact.critical.radii, offsets))
    assert moved.gaps.max() > 0.3 * OFF
    for radius, found, wanted in zip(
        radii.tolist(), sections_by_analysis(moved, radii), sections_by_analysis(exact, radii), strict=True
    ):
        assert not isinstance(found, LayerError), f"R {radius}: {found}"
        area, right = (sum(loop.signed_area() for loop in section[0]) for section in (found, wanted))
        assert area == pytest.approx(right, abs=1e-9)
        assert found[1].bound <= 1e-8
