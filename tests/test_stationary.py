"""Where rho is stationary inside of faces: nothing is missed, so no island of a section is lost."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.ndimage import maximum_filter

import brep_slicer as bs
from brep_slicer.field.stationary import stationary_places
from brep_slicer.geometry import (
    BSplineEdge,
    BSplineSurface,
    ConicEdge,
    ElementarySurface,
    Extrusion,
    Face,
    LineEdge,
    Revolution,
    SurfaceKind,
    patches_of,
)
from brep_slicer.geometry.polynomials import bernstein, bernstein_product
from brep_slicer.kernel.shapes import volume_of
from brep_slicer.section import cut_solids
from brep_slicer.testing import integrate_sections

Z = bs.axis_from_text("Z")
RNG = np.random.default_rng(5)
FRAME = np.linalg.qr(RNG.normal(size=(3, 3)))[0]
ORIGIN = np.array([3.0, -2.0, 7.0])


def clamped(count, degree):
    """Knots of so many poles, 0 to 1."""
    return np.concatenate([np.zeros(degree), np.linspace(0.0, 1.0, count - degree + 1), np.ones(degree)])


SPLINE = BSplineEdge(degree=3, knots=clamped(6, 3), poles=RNG.normal(size=(6, 3)), weights=RNG.uniform(0.5, 2.0, 6))
CIRCLE = ConicEdge(centre=ORIGIN, x=4.0 * FRAME[0], y=2.5 * FRAME[1])
LINE = LineEdge(origin=ORIGIN, direction=FRAME[2])


def elementary(kind, **sizes):
    return ElementarySurface(kind=kind, origin=ORIGIN, frame=FRAME, **sizes)


SURFACES = {
    "cylinder": elementary(SurfaceKind.CYLINDER, radius=5.0),
    "cone": elementary(SurfaceKind.CONE, radius=5.0, half_angle=0.4),
    "sphere": elementary(SurfaceKind.SPHERE, radius=5.0),
    "torus": elementary(SurfaceKind.TORUS, radius=5.0, minor=2.0),
    "B-spline": BSplineSurface(
        degrees=(3, 2), knots_u=clamped(6, 3), knots_v=clamped(5, 2), poles=RNG.normal(size=(6, 5, 3)), weights=None
    ),
    "rational B-spline": BSplineSurface(
        degrees=(2, 3),
        knots_u=clamped(5, 2),
        knots_v=clamped(6, 3),
        poles=RNG.normal(size=(5, 6, 3)),
        weights=RNG.uniform(0.5, 2.0, (5, 6)),
    ),
    **{f"extruded {k}": Extrusion(curve=c, direction=FRAME[1]) for k, c in {"spline": SPLINE, "ellipse": CIRCLE}.items()},
    **{
        f"turned {k}": Revolution(curve=c, origin=np.ones(3), axis=FRAME[0])
        for k, c in {"spline": SPLINE, "ellipse": CIRCLE, "line": LINE}.items()
    },
}


@pytest.mark.parametrize("surface", SURFACES.values(), ids=SURFACES)
def test_patches_are_the_surface(surface):
    box = np.array([[0.1, 0.2], [0.9, 0.7]]) * [4.0 if period else 1.0 for period in surface.periods()]
    patches = patches_of(surface, box)
    count = len(patches.control)
    which, local = RNG.integers(0, count, 200), RNG.uniform(size=(200, 2))
    p, q = (n - 1 for n in patches.control.shape[1:3])
    h = np.einsum("nijk,ni,nj->nk", patches.control[which], bernstein(local[:, 0], p, 0), bernstein(local[:, 1], q, 0))
    assert h[:, :3] / h[:, 3:] == pytest.approx(surface.points(patches.parameters(which, local)), abs=1e-12)
    low, high = patches.ranges[:, :, 0].min(axis=0), patches.ranges[:, :, 1].max(axis=0)
    assert (low <= box[0] + 1e-12).all()
    assert (high >= box[1] - 1e-12).all()


def test_products_of_polynomials():
    a, b = RNG.normal(size=(3, 4, 2)), RNG.normal(size=(3, 3, 6))
    c = bernstein_product(a, b)
    x, y = RNG.uniform(size=(2, 20))

    def values(z):
        return np.einsum("nij,mi,mj->nm", z, bernstein(x, z.shape[1] - 1, 0), bernstein(y, z.shape[2] - 1, 0))

    assert values(c) == pytest.approx(values(a) * values(b), abs=1e-13)


def face_of(surface, box):
    return Face(index=0, surface=surface, sign=1, loops=(), box=np.asarray(box, dtype=float), tolerance=1e-7)


def knurled(count, raised, height):
    """y = 40 over 10 < x < 50, -20 < z < 20, with single poles of a cubic B-spline raised."""
    x, z = np.meshgrid(np.linspace(10.0, 50.0, count), np.linspace(-20.0, 20.0, count), indexing="ij")
    y = np.full_like(x, 40.0)
    y[tuple(np.array(raised).T)] += height
    knots = clamped(count, 3)
    return BSplineSurface(degrees=(3, 3), knots_u=knots, knots_v=knots, poles=np.stack([x, y, z], axis=-1), weights=None)


def test_bumps_narrower_than_any_grid_are_all_found():
    # 80 x 80 patches, 40 bumps of four patches each; a grid of 1601 x 1601 says where rho is highest
    raised = [(i, j) for i in range(6, 78, 9) for j in range(5, 77, 17)]
    surface = knurled(83, raised, 4.0)
    places = stationary_places(face_of(surface, [[0.0, 0.0], [1.0, 1.0]])).single
    line = np.linspace(0.0, 1.0, 1601)
    uv = np.stack(np.meshgrid(line, line, indexing="ij"), axis=-1)
    rho = np.hypot(*surface.points(uv.reshape(-1, 2))[:, :2].T).reshape(1601, 1601)
    peak = (rho == maximum_filter(rho, 9)) & (surface.points(uv.reshape(-1, 2))[:, 1].reshape(1601, 1601) > 40.5)
    peaks = uv[peak]
    assert len(peaks) == len(raised)
    off = np.linalg.norm(peaks[:, None] - places[None], axis=2).min(axis=1)
    assert off.max() < 2.0 / 1600
    # a hill on a slope: a peak and a saddle each
    assert len(places) == 2 * len(raised)
    _, su, sv = surface.derivatives(places)
    p = surface.points(places)
    assert np.abs((p[:, :2] * su[:, :2]).sum(axis=1)).max() < 1e-8
    assert np.abs((p[:, :2] * sv[:, :2]).sum(axis=1)).max() < 1e-8


def test_a_crest_along_a_curve_is_a_doubt():
    # a ring about the axis, stored as a B-spline: rho has its largest value all along v = 1/2
    s = math.sqrt(0.5)
    profile = np.array([[10.0, 0.0], [12.0, 1.0], [10.0, 2.0]])
    corners = np.array([[1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    poles = np.stack(
        [
            corners[:, None, 0] * profile[None, :, 0],
            corners[:, None, 1] * profile[None, :, 0],
            np.broadcast_to(profile[:, 1], (3, 3)),
        ],
        axis=-1,
    )
    knots = np.repeat([0.0, 1.0], 3)
    weights = np.array([1.0, s, 1.0])[:, None] * np.ones(3)
    surface = BSplineSurface(degrees=(2, 2), knots_u=knots, knots_v=knots, poles=poles, weights=weights)
    found = stationary_places(face_of(surface, [[0.0, 0.0], [1.0, 1.0]]))
    assert len(found.single) == 0
    assert len(found.doubts) > 3
    assert found.doubts[:, 1] == pytest.approx(0.5, abs=1.0 / 32.0)


def accuracy(height):
    """Relative error of the area of an island so high (mm), which grows evenly with its height; rho is traced to 1e-11 mm."""
    return 1e-9 + 1e-11 / height


def solid_of(shape):
    return cut_solids(bs.as_part(shape.solids()[0]), Z)[0]


class TestAFaceThatBulgesTowardsTheAxis:
    """y = 30 + z**2 / 20, extruded along x: below R = 30 nothing, then an island that meets no edge. It was lost."""

    def shape(self):
        bd = pytest.importorskip("build123d")
        plane = bd.Plane.YZ.offset(-8.3)
        corners = [(35.0, 10.0), (60.0, 10.0), (60.0, -10.0), (35.0, -10.0)]
        edges = [bd.Edge.make_bezier((35.0, -10.0), (25.0, 0.0), (35.0, 10.0))]
        edges += [bd.Edge.make_line(a, b) for a, b in itertools.pairwise(corners)]
        face = plane * bd.Face(bd.Wire(edges))
        return bd.extrude(face, 17.0, (1, 0, 0))

    def test_islands(self):
        radii = [30.0 + h for h in (1e-6, 1e-3, 0.01, 0.1, 0.5, 0.9)]
        layers = bs.slice_part(self.shape(), radii, axis=Z)
        for layer in layers:
            r = layer.radius
            reach = math.sqrt(20.0 * (r - 30.0))

            def width(s, r=r, reach=reach):
                # z = reach sin(s): smooth at the ends of the island
                return 2.0 * r * math.acos((30.0 + (reach * math.sin(s)) ** 2 / 20.0) / r) * reach * math.cos(s)

            truth = quad(width, -0.5 * math.pi, 0.5 * math.pi, epsabs=1e-13, epsrel=1e-12)[0]
            assert layer.area == pytest.approx(truth, rel=accuracy(r - 30.0))
            assert len(layer.region.pieces) == 1

    def test_volume(self):
        solid = solid_of(self.shape())
        assert integrate_sections(solid).volume == pytest.approx(volume_of(solid.wrapped), rel=1e-8)


def test_a_level_line_round_a_small_hole_is_found():
    # the peak of rho lies in the hole; the layer meets the hole's wall, but not its rim
    bd = pytest.importorskip("build123d")
    tip, ball, hole = 50.0, 15.0, 0.05
    e = tip - ball
    shaft = bd.Solid.make_cylinder(40.0, 80.0, bd.Plane(origin=(0, 0, -40.0)))
    bump = bd.Solid.make_sphere(ball, bd.Plane(origin=(e, 0, 5)))
    drill = bd.Solid.make_cylinder(hole, 20.0, bd.Plane(origin=(tip - 10.0, 0, 5), z_dir=(1, 0, 0)))

    def area(half_height, most, r):
        return (
            4.0 * r * quad(lambda s: half_height(most * math.sin(s)) * most * math.cos(s), 0.0, 0.5 * math.pi, epsabs=1e-13)[0]
        )

    rim = math.sqrt(ball**2 - hole**2) + e
    for layer in bs.slice_part(shaft + bump - drill, [rim - h for h in (1e-2, 1e-3, 1e-4)], axis=Z):
        r = layer.radius
        # |v| < sqrt(ball**2 - r**2 - e**2 + 2 r e cos(theta)), without |v| < sqrt(hole**2 - (r sin(theta))**2)
        island = area(
            lambda t, r=r: math.sqrt(max(0.0, ball**2 - r * r - e * e + 2.0 * r * e * math.cos(t))),
            math.acos((r * r + e * e - ball**2) / (2.0 * r * e)),
            r,
        )
        wall = area(lambda t, r=r: math.sqrt(max(0.0, hole**2 - (r * math.sin(t)) ** 2)), math.asin(hole / r), r)
        assert layer.area == pytest.approx(island - wall, rel=accuracy(tip - r))
        assert len(layer.region.pieces[0].holes) == 1
