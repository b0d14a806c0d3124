"""rho and its gradient at points of the axis frame, and the bands within which two radii are one.

In: points (n, 3), mm. Out: radii (n,), gradients. Everything that traces level sets asks here and nowhere else.
"""

from __future__ import annotations

import numpy as np

from brep_slicer.maps import Array

# A face (or edge) whose radii differ by less is a coaxial cylinder's as far as layers go, mm: lands swept as B-splines by CAD
# systems deviate from their cylinder by about 1e-5.
COINCIDENCE_BAND = 2e-5
# Radii nearer than this (mm) are equal: rounding of coordinates of some metres, and ten times the accuracy of the root finding.
SNAP = 1e-9


def radii_of(points: Array) -> Array:
    """rho (n,) of points (n, 3)."""
    return np.hypot(points[..., 0], points[..., 1])


def radial_gradient(points: Array) -> Array:
    """e_rho (n, 3), the gradient of rho (of unit length; zero on the axis itself)."""
    rho = radii_of(points)
    safe = np.where(rho > 0.0, rho, 1.0)
    return np.stack([points[..., 0] / safe, points[..., 1] / safe, np.zeros_like(rho)], axis=-1)
