"""How the level changes over a face, as polynomials that bounds and proofs are made on.

In: a face's rational Bezier patches, a family of layers. Out: Boxes: parts of patches with the Bernstein coefficients of G, two
polynomials that have the signs of dc/du and dc/dv.

On a patch with homogeneous coordinates (X, Y, Z, W) and N = X**2 + Y**2, rho = sqrt(N) / W:

- cylinders, c = rho: G = W grad N - 2 N grad W = 2 rho W**3 grad rho;
- planes, c = n p: G = W grad L - L grad W with L = n (X, Y, Z): W**2 grad c;
- cones, c = rho cos(alpha) + z sin(alpha): 2 rho W**3 grad c = G, which is
  cos(alpha) (W grad N - 2 N grad W) + 2 sin(alpha) sqrt(N) (W grad Z - Z grad W) with a polynomial for sqrt(N). What that is
  off by counts as noise; where it is too much, the patch is halved.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from brep_slicer.geometry import Patches
from brep_slicer.geometry.polynomials import bernstein_product, bernstein_with_slope
from brep_slicer.layers import Cones, Cylinders, LayerFamily
from brep_slicer.maps import Array

# What an island inside of a box may rise at most where the bounds call the box empty, mm.
LOWEST_ISLAND = 1e-10
# Degree of the polynomial for rho along a patch, how far it may be off (a share of the largest rho), how often a patch is
# halved for it, and by how much the error between its nodes may exceed what is seen there.
RHO_DEGREE, RHO_WITHIN, RHO_HALVINGS, RHO_SAFETY = 8, 1e-12, 4, 4.0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Boxes:
    """Parts of patches: number of the patch, local corner (n, 2) and size, G there (n, 2, p + 1, q + 1), its noise (n,)."""

    which: NDArray[np.int64]
    corner: Array
    size: Array
    g: Array
    noise: Array

    def __len__(self) -> int:
        return len(self.which)

    def select(self, rows: NDArray[np.bool_] | NDArray[np.int64]) -> Boxes:
        return Boxes(
            which=self.which[rows], corner=self.corner[rows], size=self.size[rows], g=self.g[rows], noise=self.noise[rows]
        )


def boxes_of(patches: Patches, family: LayerFamily) -> Boxes:
    """Every patch as a box, or as several, with its G."""
    control = patches.control
    if isinstance(family, Cones) and not isinstance(family, Cylinders):
        return _of_cones(control, family.half_angle)
    g, noise = _of_cylinders(control) if isinstance(family, Cylinders) else _of_planes(control, family.gradient(np.zeros(3)))
    count = len(control)
    return Boxes(which=np.arange(count), corner=np.zeros((count, 2)), size=np.ones((count, 1)), g=g, noise=noise)


def _of_cylinders(control: Array) -> tuple[Array, Array]:
    """G (n, 2, ...) and its noise (n,) for rho, by the product rule on Bernstein coefficients."""
    x, y, w = (control[..., k] for k in (0, 1, 3))
    n = bernstein_product(x, x) + bernstein_product(y, y)
    size = np.abs(n).max(axis=(1, 2))
    if float(np.ptp(w)) == 0.0:
        parts = [raised(slope(n, axis), axis) for axis in (0, 1)]
        lightest = np.ones(len(n))
    else:
        parts = [
            raised(bernstein_product(slope(n, axis), w) - 2.0 * bernstein_product(n, slope(w, axis)), axis) for axis in (0, 1)
        ]
        lightest = w.min(axis=(1, 2)) ** 3
    # an island in a box rises by |G| / (2 rho W**3) at most
    noise = np.maximum(2.0 * np.sqrt(size) * LOWEST_ISLAND * lightest, 1e-14 * size * np.abs(w).max(axis=(1, 2)))
    return np.stack(parts, axis=1), noise


def _of_planes(control: Array, normal: Array) -> tuple[Array, Array]:
    """The same for n p."""
    w = control[..., 3]
    level = control[..., :3] @ normal
    # about a level of the patch itself, so that no digits go to where the part lies
    level = level - (level[:, :1, :1] / w[:, :1, :1]) * w
    size = np.abs(level).max(axis=(1, 2)) + 1e-300
    parts = [raised(_rational_slope(level, w, axis), axis) for axis in (0, 1)]
    noise = np.maximum(LOWEST_ISLAND * w.min(axis=(1, 2)) ** 2, 1e-14 * size * np.abs(w).max(axis=(1, 2)))
    return np.stack(parts, axis=1), noise


def _rational_slope(a: Array, w: Array, axis: int) -> Array:
    """W grad A - A grad W along an axis."""
    return bernstein_product(slope(a, axis), w) - bernstein_product(a, slope(w, axis))


def _of_cones(control: Array, half_angle: float) -> Boxes:
    """G for cones on patches that are halved until a polynomial is near enough to sqrt(N)."""
    count = len(control)
    which, corner, size = np.arange(count), np.zeros((count, 2)), np.ones((count, 1))
    done: list[Boxes] = []
    for depth in range(RHO_HALVINGS + 1):
        x, y = control[..., 0], control[..., 1]
        n = bernstein_product(x, x) + bernstein_product(y, y)
        root, off = _root(n)
        good = (off <= RHO_WITHIN * np.abs(root).max(axis=(1, 2))) | (depth == RHO_HALVINGS)
        if good.any():
            g, noise = _cone_slopes(control[good], n[good], root[good], off[good], half_angle)
            done.append(Boxes(which=which[good], corner=corner[good], size=size[good], g=g, noise=noise))
        control, which, corner, size = control[~good], which[~good], corner[~good], size[~good]
        if not len(control):
            break
        control, corner = _quartered(control, corner, size)
        which, size = np.tile(which, 4), np.tile(0.5 * size, (4, 1))
    columns = (np.concatenate([getattr(boxes, name) for boxes in done]) for name in ("which", "corner", "size", "g", "noise"))
    which, corner, size, g, noise = columns
    return Boxes(which=which, corner=corner, size=size, g=g, noise=noise)


def _cone_slopes(control: Array, n: Array, root: Array, off: Array, half_angle: float) -> tuple[Array, Array]:
    cos, sin = math.cos(half_angle), math.sin(half_angle)
    z, w = control[..., 2], control[..., 3]
    # about a height of the patch itself
    z = z - (z[:, :1, :1] / w[:, :1, :1]) * w
    parts, steep = [], np.zeros(len(n))
    for axis in (0, 1):
        upward = _rational_slope(z, w, axis)
        steep = np.maximum(steep, np.abs(upward).max(axis=(1, 2)))
        across = bernstein_product(slope(n, axis), w) - 2.0 * bernstein_product(n, slope(w, axis))
        up = bernstein_product(root, upward)
        both = [cos * across, 2.0 * sin * up]
        shape = np.maximum(*(part.shape[1:] for part in both))
        parts.append(raised(_elevated(both[0], *shape) + _elevated(both[1], *shape), axis))
    size = np.abs(n).max(axis=(1, 2))
    lightest = w.min(axis=(1, 2)) ** 3
    rounding = 1e-14 * (size * np.abs(w).max(axis=(1, 2)) + np.sqrt(size) * steep)
    noise = np.maximum(2.0 * np.sqrt(size) * LOWEST_ISLAND * lightest, rounding) + 2.0 * abs(sin) * off * steep
    return np.stack(parts, axis=1), noise


def _root(n: Array) -> tuple[Array, Array]:
    """Bernstein coefficients (m, ...) of polynomials near to the root of others, and how far they may be off (m,)."""
    nodes = 0.5 - 0.5 * np.cos(np.pi * np.linspace(0.0, 1.0, RHO_DEGREE + 1))
    basis = bernstein_with_slope(nodes, RHO_DEGREE)[0]
    inverse = np.linalg.inv(basis)
    root = np.einsum("ai,mij,bj->mab", inverse, np.sqrt(np.maximum(_values(n, nodes), 0.0)), inverse)
    between = 0.5 * (nodes[1:] + nodes[:-1])
    off = np.abs(_values(root, between) - np.sqrt(np.maximum(_values(n, between), 0.0))).max(axis=(1, 2))
    return root, RHO_SAFETY * off


def _values(a: Array, at: Array) -> Array:
    """Polynomials (m, p + 1, q + 1) at a grid of local coordinates (k,), (m, k, k)."""
    left, right = (bernstein_with_slope(at, a.shape[k] - 1)[0] for k in (1, 2))
    return np.einsum("ai,mij,bj->mab", left, a, right)


def _quartered(control: Array, corner: Array, size: Array) -> tuple[Array, Array]:
    """Patches in four, by de Casteljau, and the corners of the parts."""
    parts, corners = [control], [corner]
    for axis in (0, 1):
        low, high = halving(control.shape[1 + axis] - 1)
        formula = "ai,nijk->najk" if axis == 0 else "aj,nijk->niak"
        parts = [np.einsum(formula, m, part, optimize=True) for part in parts for m in (low, high)]
        move = 0.5 * size * np.eye(2)[axis]
        corners = [c + s for c in corners for s in (0.0 * move, move)]
    return np.concatenate(parts), np.concatenate(corners)


def _elevated(a: Array, p: int, q: int) -> Array:
    """The same polynomials with (p, q) coefficients along their axes."""
    return bernstein_product(a, np.ones((1, p - a.shape[1] + 1, q - a.shape[2] + 1)))


def slope(a: Array, axis: int) -> Array:
    return a.shape[1 + axis] * np.diff(a, axis=1 + axis) - np.diff(a, axis=1 + axis)


def raised(a: Array, axis: int) -> Array:
    """The same polynomials one degree higher along an axis."""
    return bernstein_product(a, np.ones((1, 2, 1) if axis == 0 else (1, 1, 2)))


def halving(degree: int) -> tuple[Array, Array]:
    """Matrices that give the Bernstein coefficients of a polynomial's first and second half."""
    low = np.zeros((degree + 1, degree + 1))
    low[0, 0] = 1.0
    for i in range(1, degree + 1):
        low[i, 0] = 0.5 * low[i - 1, 0]
        low[i, 1:] = 0.5 * (low[i - 1, 1:] + low[i - 1, :-1])
    return low, low[::-1, ::-1]
