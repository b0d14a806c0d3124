"""Where rho is stationary inside of a face, and the proof that it is so nowhere else.

In: a face. Out: Stationary: parameters, and places where the proof was not had.

An island of a section, a closed level curve that meets no edge, lies round a place where rho is stationary along the face. On a
rational Bezier patch with homogeneous coordinates (X, Y, W), rho**2 = N / W**2, N = X**2 + Y**2, and its gradient has the
direction of G = W grad N - 2 N grad W, polynomials. Their Bernstein coefficients bound them, and halving a patch brings the
bounds near. A box is done with

- if a direction g has g . G > 0 all over it, but for a side that is one of the box of the face: there is nothing (a fillet
  leaves a coaxial cylinder so, along an edge);
- if G is one-to-one on it (its Jacobian, made nearly the identity, is dominated by its diagonal everywhere): there is one place
  at most, and Newton finds it;
- if it is small and g . G >= 0 all over it: G vanishes on its border at most, and Newton looks from all round.

What remains when the boxes have become small or many are *doubts*: rho is level there along a curve, as at the crest of a ring.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from brep_slicer.geometry import ElementarySurface, Face, Patches, Revolution, SurfaceKind, patches_of
from brep_slicer.geometry.polynomials import bernstein_with_slope
from brep_slicer.layers import CYLINDERS, LayerFamily
from brep_slicer.maps import Array

from .slopes import Boxes, boxes_of, halving, raised, slope

# What an island inside of a box may rise at most where the bounds call the box empty, mm.
LOWEST_ISLAND = 1e-10
# Boxes are halved so often at most, and no more than so many are kept, with so many coefficients in all.
MOST_HALVINGS, MOST_BOXES, MOST_NUMBERS = 14, 2000, 4_000_000
# From here on a box is small enough that Newton from nine places of it finds what lies on its border.
SMALL = 4
# A place whose Jacobian's determinant is less than this share of its largest entry squared is one of a whole curve of them.
SINGULAR = 1e-7
# As many doubts are kept of a face, spread evenly.
MOST_DOUBTS = 12
# Steps of Newton towards a multiple root, each of which takes a third of the way at least.
CREEPS = 60
# Moves of this share of the face's box are rounding.
STILL = 1e-13


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Stationary:
    """Parameters (n, 2) of a face's box where rho is stationary: `single` ones, and `doubts` (m, 2), see the module's head.

    `level` (k, 2) are places near the doubts where rho is stationary and its second derivatives are singular.
    """

    single: Array
    doubts: Array
    level: Array


def stationary_places(face: Face, family: LayerFamily = CYLINDERS) -> Stationary:
    """All of a face's box, whether inside of its outline or not."""
    none = np.zeros((0, 2))
    surface = face.surface
    if not (face.box[1] > face.box[0]).all():
        return Stationary(single=none, doubts=none, level=none)
    if surface.kind is SurfaceKind.PLANE:
        return Stationary(single=_on_plane(face, family), doubts=none, level=none)
    if family.is_revolved and _same_along(face):
        return Stationary(single=none, doubts=none, level=none)
    patches = patches_of(surface, face.box)
    boxes = boxes_of(patches, family)
    found, doubts = [none], [none]
    for depth in range(MOST_HALVINGS + 1):
        if not len(boxes):
            break
        boxes = boxes.select(~_empty(boxes, *_sides(face, patches, boxes)))
        places, done = _single_places(patches, boxes)
        found.append(places)
        boxes = boxes.select(~done)
        if depth >= SMALL:
            touched = _touched(boxes)
            _settle(patches, boxes.select(touched), found, doubts)
            boxes = boxes.select(~touched)
        most = min(MOST_BOXES, MOST_NUMBERS // max(1, boxes.g[:1].size))
        if depth == MOST_HALVINGS or len(boxes) > most:
            _settle(patches, boxes, found, doubts)
            break
        boxes = _halved(boxes)
    single, doubtful = (_within(face, np.concatenate(some)) for some in (found, doubts))
    some = doubtful[:: max(1, len(doubtful) // MOST_DOUBTS)]
    return Stationary(single=single, doubts=some, level=_within(face, _crept(face, some, family)))


def _on_plane(face: Face, family: LayerFamily) -> Array:
    """Where the axis meets a plane, (1, 2) or (0, 2): elsewhere the level has a slope all over it."""
    surface = face.surface
    if not family.is_revolved:
        return np.zeros((0, 2))
    assert isinstance(surface, ElementarySurface)
    normal = surface.frame[2]
    if abs(normal[2]) < 1e-12:
        return np.zeros((0, 2))
    return _within(face, surface.parameters(np.array([[0.0, 0.0, float(normal @ surface.origin) / normal[2]]])))


def _same_along(face: Face) -> bool:
    """Whether rho is the same all along one of the two parameters: lines of extremes, which cross the face's edges."""
    surface = face.surface
    if isinstance(surface, Revolution):
        return bool(np.hypot(*surface.axis[:2]) < 1e-12 and np.hypot(*surface.origin[:2]) < 1e-9)
    if isinstance(surface, ElementarySurface):
        if surface.kind is SurfaceKind.CYLINDER and np.hypot(*surface.frame[2, :2]) < 1e-12:
            return True
        return bool(np.hypot(*surface.frame[2, :2]) < 1e-12 and np.hypot(*surface.origin[:2]) < 1e-9)
    return surface.kind is SurfaceKind.EXTRUSION and bool(np.hypot(*surface.direction[:2]) < 1e-12)  # type: ignore[attr-defined]


def _sides(face: Face, patches: Patches, boxes: Boxes) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Whether boxes lie outside of the face's box (n,), and which coefficients of theirs are of its sides (n, p + 1, q + 1)."""
    slack = 1e-9 * (face.box[1] - face.box[0])
    low = patches.parameters(boxes.which, boxes.corner)
    high = patches.parameters(boxes.which, boxes.corner + boxes.size)
    outside = ((high <= face.box[0] + slack) | (low >= face.box[1] - slack)).any(axis=1)
    border = np.zeros((len(boxes), *boxes.g.shape[2:]), dtype=bool)
    border[:, 0, :] |= (low[:, 0] <= face.box[0, 0] + slack[0])[:, None]
    border[:, -1, :] |= (high[:, 0] >= face.box[1, 0] - slack[0])[:, None]
    border[:, :, 0] |= (low[:, 1] <= face.box[0, 1] + slack[1])[:, None]
    border[:, :, -1] |= (high[:, 1] >= face.box[1, 1] - slack[1])[:, None]
    return outside, border


def _along(boxes: Boxes) -> Array:
    """g . G (n, 5, p + 1, q + 1) for five directions g: the mean of G, and both ways along u and v."""
    mean = boxes.g.mean(axis=(2, 3))
    mean /= np.maximum(np.abs(mean).max(axis=1), 1e-300)[:, None]
    middle = (mean[:, :, None, None] * boxes.g).sum(axis=1)
    return np.concatenate([middle[:, None], boxes.g, -boxes.g], axis=1)


def _empty(boxes: Boxes, outside: NDArray[np.bool_], border: NDArray[np.bool_]) -> NDArray[np.bool_]:
    noise = boxes.noise[:, None, None]
    lowest = (_along(boxes) + np.where(border, 2.0 * noise, 0.0)[:, None]).min(axis=(2, 3))
    return outside | (lowest.max(axis=1) > boxes.noise)


def _touched(boxes: Boxes) -> NDArray[np.bool_]:
    return _along(boxes).min(axis=(2, 3)).max(axis=1) >= -boxes.noise


def _single_places(patches: Patches, boxes: Boxes) -> tuple[Array, NDArray[np.bool_]]:
    """The places of boxes that have one at most and where Newton ended inside, (k, 2), and which boxes those are."""
    g = boxes.g
    jacobian = np.stack([_slope_of_g(g, axis) for axis in (0, 1)], axis=2)  # (n, component, derivative, ...)
    mean = jacobian.mean(axis=(3, 4))
    det = np.linalg.det(mean)
    some = np.abs(det) > SINGULAR * np.abs(mean).max(axis=(1, 2)) ** 2
    inverse = np.zeros_like(mean)
    inverse[some] = np.linalg.inv(mean[some])
    near = np.einsum("nab,nbcij->nacij", inverse, jacobian)
    off = np.abs(near).max(axis=(3, 4))
    one = some & (near[:, 0, 0].min(axis=(1, 2)) > off[:, 0, 1]) & (near[:, 1, 1].min(axis=(1, 2)) > off[:, 1, 0])
    rows = np.flatnonzero(one)
    local, good = _newton(boxes.g[rows], np.full((len(rows), 2), 0.5))
    done = np.zeros(len(boxes), dtype=bool)
    done[rows[good]] = True
    return _places(patches, boxes.select(rows[good]), local[good]), done


def _slope_of_g(g: Array, axis: int) -> Array:
    """dG / d local coordinate, raised to G's own degree."""
    n, two, p, q = g.shape
    flat = g.reshape(n * two, p, q)
    return raised(slope(flat, axis), axis).reshape(g.shape)


def _settle(patches: Patches, boxes: Boxes, found: list[Array], doubts: list[Array]) -> None:
    """Add what Newton finds from nine points of each box, and the middles of those boxes where it finds nothing."""
    seeds = np.stack(np.meshgrid([0.0, 0.5, 1.0], [0.0, 0.5, 1.0], indexing="ij"), axis=-1).reshape(-1, 2)
    rows = np.repeat(np.arange(len(boxes)), len(seeds))
    local, good = _newton(boxes.g[rows], np.tile(seeds, (len(boxes), 1)))
    found.append(_places(patches, boxes.select(rows[good]), local[good]))
    lost = boxes.select(np.setdiff1d(np.arange(len(boxes)), rows[good]))
    doubts.append(_places(patches, lost, np.full((len(lost), 2), 0.5)))


def _newton(g: Array, local: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Zeros of G (n, 2, ...) in local coordinates of its boxes from (n, 2), and which have come to one that is single."""
    local, move = local.copy(), np.ones_like(local)
    single = np.zeros(len(g), dtype=bool)
    p, q = g.shape[2] - 1, g.shape[3] - 1
    for _ in range(16):
        if np.abs(move).max(initial=0.0) < 1e-12:
            break
        (bu, du), (bv, dv) = (bernstein_with_slope(local[:, k], degree) for k, degree in ((0, p), (1, q)))
        rows = np.matmul(g, np.stack([bv, dv], axis=2)[:, None])  # (n, 2, p + 1, value and slope along v)
        found = np.matmul(np.stack([bu, du], axis=1)[:, None], rows)  # (n, 2, value and slope along u, the same along v)
        value, j = found[:, :, 0, 0], np.stack([found[:, :, 1, 0], found[:, :, 0, 1]], axis=2)
        det = j[:, 0, 0] * j[:, 1, 1] - j[:, 0, 1] * j[:, 1, 0]
        single = np.abs(det) > SINGULAR * np.abs(j).max(axis=(1, 2)) ** 2
        safe = np.where(single, det, 1.0)
        move = np.stack(
            [j[:, 0, 1] * value[:, 1] - j[:, 1, 1] * value[:, 0], j[:, 1, 0] * value[:, 0] - j[:, 0, 0] * value[:, 1]], axis=1
        )
        move = np.clip(np.where(single[:, None], move / safe[:, None], 0.0), -0.5, 0.5)
        local = np.clip(local + move, -0.25, 1.25)
    inside = ((local >= -1e-6) & (local <= 1.0 + 1e-6)).all(axis=1)
    return local, single & inside & (np.abs(move).max(axis=1, initial=0.0) < 1e-7)


def _places(patches: Patches, boxes: Boxes, local: Array) -> Array:
    return patches.parameters(boxes.which, boxes.corner + local * boxes.size)


def _halved(boxes: Boxes) -> Boxes:
    """Each box in four, by de Casteljau."""
    g, corner = [boxes.g], [boxes.corner]
    for axis in (0, 1):
        low, high = halving(boxes.g.shape[2 + axis] - 1)
        moved = np.zeros(2)
        moved[axis] = 0.5
        shift = boxes.size * moved
        formula = "ai,nkij->nkaj" if axis == 0 else "aj,nkij->nkia"
        g = [np.einsum(formula, m, part, optimize=True) for part in g for m in (low, high)]
        corner = [c + s for c in corner for s in (0.0 * shift, shift)]
    # along a box of half the size, G per local coordinate of the patch stays what it is; only its sign counts, not its size
    return Boxes(
        which=np.tile(boxes.which, 4),
        corner=np.concatenate(corner),
        size=np.tile(0.5 * boxes.size, (4, 1)),
        g=np.concatenate(g),
        noise=np.tile(boxes.noise, 4),
    )


def _crept(face: Face, uv: Array, family: LayerFamily) -> Array:
    """Where rho is stationary near places (n, 2), by Newton with a pseudo-inverse, which creeps where a root is multiple."""
    if not len(uv):
        return uv
    size = face.box[1] - face.box[0]

    def slope(at: Array) -> Array:
        p, su, sv = face.surface.derivatives(at)
        return np.stack([family.rise(p, su) * size[0], family.rise(p, sv) * size[1]], axis=1)

    at, h = uv.copy(), 1e-5
    beside = h * size * np.array([[0.0, 0.0], [1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]])
    for _ in range(CREEPS):
        here, east, west, north, south = slope((at + beside[:, None]).reshape(-1, 2)).reshape(5, -1, 2)
        j = np.stack([east - west, north - south], axis=2) / (2.0 * h)
        move = -np.einsum("nij,nj->ni", np.linalg.pinv(j, rcond=1e-8), here)
        at = np.clip(at + np.clip(move, -0.05, 0.05) * size, face.box[0], face.box[1])
        if np.abs(move).max() <= STILL:
            break
    _, su, sv = face.surface.derivatives(at)
    reach = np.linalg.norm(su, axis=1) * size[0] + np.linalg.norm(sv, axis=1) * size[1]
    return at[np.linalg.norm(slope(at), axis=1) <= 1e-9 * reach**2]


def _within(face: Face, uv: Array) -> Array:
    """Those of uv (n, 2) that lie in the face's box, away from its sides, each once."""
    size = face.box[1] - face.box[0]
    share = (uv - face.box[0]) / size
    inside = ((share > 1e-7) & (share < 1.0 - 1e-7)).all(axis=1)
    _, first = np.unique(np.round(share[inside], 6), axis=0, return_index=True)
    return uv[inside][first]
