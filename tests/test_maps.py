"""The maps, there and back."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from brep_slicer import maps

radius = st.floats(1e-3, 1e4)
angle = st.floats(-3.14, 3.14)
height = st.floats(-1e4, 1e4)


@given(angle, radius, height)
def test_unrolling_there_and_back(theta, rho, u):
    points = maps.cartesian_from_cylindrical([theta, rho, u])
    back = maps.cartesian_from_unrolled(maps.unrolled_from_cartesian(points))
    assert np.allclose(back, points, rtol=0.0, atol=1e-12 * max(rho, abs(u), 1.0))


@given(angle, angle, radius, height, height)
def test_the_unrolled_plane_is_isometric(a, b, rho, u0, u1):
    # the length of a helix: sqrt((rho dtheta)**2 + du**2), the paper's Eq. 16
    theta, u = np.linspace(a, b, 2001), np.linspace(u0, u1, 2001)
    p = maps.cartesian_from_flat(np.stack([rho * theta, u], axis=1), rho)
    chords = np.linalg.norm(np.diff(p, axis=0), axis=1).sum()
    assert chords == pytest.approx(np.hypot(rho * (b - a), u1 - u0), rel=1e-6, abs=1e-6)


def test_wrong_shapes_are_named():
    with pytest.raises(ValueError, match=r"points must have shape \(..., 3\), got \(2,\)"):
        maps.cylindrical_from_cartesian([1.0, 2.0])
