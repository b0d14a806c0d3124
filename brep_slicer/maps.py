"""The maps between the axis frame, cylindrical coordinates and the unrolled plane, each in one place.

In and out: arrays of coordinates, shape (..., 3), millimetres and radians.

Words (the paper's): g takes Cartesian (x, y, z) to cylindrical (theta, rho, u); w takes (theta, rho, u) to the
unrolled (kappa, gamma, v) with kappa = rho * theta, gamma = rho, v = u; h is the inverse of w after g.
"""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

# float64 throughout; not spelled out, since numpy widens its own results to "some floating type"
Array: TypeAlias = NDArray[Any]

TURN = 2.0 * np.pi


def check_points(points: ArrayLike, *, columns: int, name: str) -> Array:
    """Coerce to a float array of shape (..., columns), or say which shape arrived.

    Raises
    ------
    ValueError
        If the last dimension is not `columns`.
    """
    array = np.asarray(points, dtype=np.float64)
    if array.ndim == 0 or array.shape[-1] != columns:
        raise ValueError(f"{name} must have shape (..., {columns}), got {array.shape}")
    return array


def lengths_along(points: Array) -> Array:
    """Length (n,) of a polyline (n, d) from its first point to each of its points, mm."""
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])


def cylindrical_from_cartesian(points: ArrayLike) -> Array:
    """Map g of the paper (Eq. 1): (x, y, z) in mm to (theta, rho, u) in rad, mm, mm; theta in (-pi, pi].

    Parameters
    ----------
    points : array_like, shape (..., 3)
        Points in the axis frame.

    Returns
    -------
    ndarray, shape (..., 3)
    """
    p = check_points(points, columns=3, name="points")
    return np.stack([np.arctan2(p[..., 1], p[..., 0]), np.hypot(p[..., 0], p[..., 1]), p[..., 2]], axis=-1)


def cartesian_from_cylindrical(points: ArrayLike) -> Array:
    """Inverse of g (Eq. 3): (theta, rho, u) to (x, y, z), shape (..., 3)."""
    p = check_points(points, columns=3, name="points")
    return np.stack([p[..., 1] * np.cos(p[..., 0]), p[..., 1] * np.sin(p[..., 0]), p[..., 2]], axis=-1)


def unrolled_from_cylindrical(points: ArrayLike) -> Array:
    """Map w of the paper (Eq. 8): (theta, rho, u) to (kappa, gamma, v) = (rho * theta, rho, u), shape (..., 3)."""
    p = check_points(points, columns=3, name="points")
    return np.stack([p[..., 0] * p[..., 1], p[..., 1], p[..., 2]], axis=-1)


def cylindrical_from_unrolled(points: ArrayLike) -> Array:
    """Inverse of w (Eq. 8): (kappa, gamma, v) to (theta, rho, u), shape (..., 3)."""
    p = check_points(points, columns=3, name="points")
    return np.stack([p[..., 0] / p[..., 1], p[..., 1], p[..., 2]], axis=-1)


def unrolled_from_cartesian(points: ArrayLike) -> Array:
    """The composite w after g: (x, y, z) to (kappa, gamma, v), shape (..., 3)."""
    return unrolled_from_cylindrical(cylindrical_from_cartesian(points))


def cartesian_from_unrolled(points: ArrayLike) -> Array:
    """Map h of the paper: (kappa, gamma, v) to (x, y, z), shape (..., 3); an isometry on each gamma = R (Eq. 16)."""
    return cartesian_from_cylindrical(cylindrical_from_unrolled(points))


def cartesian_from_flat(points: ArrayLike, radius: ArrayLike) -> Array:
    """Lift (kappa, v), shape (..., 2), from the plane of a layer of `radius` (scalar or (...)) to (x, y, z), (..., 3)."""
    p = check_points(points, columns=2, name="points")
    theta = p[..., 0] / np.asarray(radius, dtype=np.float64)
    return np.stack([radius * np.cos(theta), radius * np.sin(theta), p[..., 1]], axis=-1)


def normals_from_flat(points: ArrayLike, radius: ArrayLike) -> Array:
    """Outward unit normals e_rho at (kappa, v) on the cylinder of `radius`, shape (..., 3)."""
    p = check_points(points, columns=2, name="points")
    theta = p[..., 0] / np.asarray(radius, dtype=np.float64)
    return np.stack([np.cos(theta), np.sin(theta), np.zeros_like(theta)], axis=-1)
