"""Critical radii: where the topology of a section can change, and nowhere else.

In: a geometry.Brep and its edges' stretches. Out: sorted radii, the radial range, the radii of coaxial faces.

Between two neighbouring critical radii the section keeps its topology (Morse): vertices, extremes of rho along edges,
extremes and saddles of rho inside of faces, and level faces are all there is.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from brep_slicer.geometry import Brep, Face, SurfaceKind
from brep_slicer.geometry.trimming import trimming_of
from brep_slicer.maps import Array

from .monotone import EdgeStretches
from .radial import radii_of

# Seeds for the search inside of a face: this many a side on each smooth patch.
SEEDS = 5
# A search has converged when the gradient of rho along the face is this small (a slope, no unit).
FLAT = 1e-10
# Radii that differ by less are one, mm.
MERGE = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Critical:
    """`radii` (n,), increasing, mm; `level` (m,) those of coaxial cylinder faces; `lowest` and `highest` of the solid.

    `inside` holds for each face the (u, v) (n, 2) of its stationary points away from its edges: only there, and on faces with
    several loops, can a section close on itself without meeting an edge.
    """

    radii: Array
    level: Array
    inside: tuple[Array, ...]
    lowest: float
    highest: float


def critical_radii(brep: Brep, stretches: EdgeStretches) -> Critical:
    """Every critical radius of a solid."""
    inside = [_inside(face, _face_extremes(face)) for face in brep.faces]
    level = stretches.face_level[np.isfinite(stretches.face_level)]
    rings = stretches.edge_level[np.isfinite(stretches.edge_level)]
    peaks = [radii_of(face.surface.points(uv)) for face, uv in zip(brep.faces, inside, strict=True) if len(uv)]
    everything = np.concatenate([stretches.vertex_rho, stretches.extremes, rings, level, *peaks])
    radii = np.unique(everything)
    radii = radii[np.diff(radii, prepend=-np.inf) > MERGE]
    lowest = 0.0 if radii[0] < MERGE else float(radii[0])
    return Critical(radii=radii, level=np.unique(level), inside=tuple(inside), lowest=lowest, highest=float(radii.max()))


def _inside(face: Face, uv: Array) -> Array:
    """Those stationary points that lie inside of the face's outline, each once."""
    if not len(uv):
        return uv
    uv = uv[trimming_of(face).contains(uv)]
    size = np.maximum(face.box[1] - face.box[0], 1e-300)
    _, first = np.unique(np.round((uv - face.box[0]) / size, 7), axis=0, return_index=True)
    return uv[first]


def _face_extremes(face: Face) -> Array:
    """Parameters (n, 2) inside of a face's box where rho is stationary along the face (found by Newton from a grid)."""
    surface = face.surface
    if surface.kind in (SurfaceKind.PLANE, SurfaceKind.EXTRUSION) and not _pierced(face):
        return np.zeros((0, 2))
    bu, bv = surface.breaks(face.box)
    seeds = [_spread(b) for b in (bu, bv)]
    uv = np.stack(np.meshgrid(*seeds, indexing="ij"), axis=-1).reshape(-1, 2)
    size = face.box[1] - face.box[0]
    step = 1e-5 * np.array([np.diff(bu).min(), np.diff(bv).min()])
    if not (size > 0.0).all():
        return np.zeros((0, 2))
    for _ in range(12):
        g = _gradient(face, uv)
        h = np.empty((len(uv), 2, 2))
        for k in (0, 1):
            e = np.zeros(2)
            e[k] = step[k]
            h[:, :, k] = (_gradient(face, uv + e) - _gradient(face, uv - e)) / (2.0 * step[k])
        det = h[:, 0, 0] * h[:, 1, 1] - h[:, 0, 1] * h[:, 1, 0]
        good = np.abs(det) > 1e-12 * (np.abs(h).max(axis=(1, 2)) ** 2 + 1e-300)
        uv, g, h, det = uv[good], g[good], h[good], det[good]
        if len(uv) == 0:
            return uv
        move = np.stack([h[:, 1, 1] * g[:, 0] - h[:, 0, 1] * g[:, 1], h[:, 0, 0] * g[:, 1] - h[:, 1, 0] * g[:, 0]], axis=1)
        move = -move / det[:, None]
        move *= np.minimum(1.0, 0.2 / np.maximum(np.abs(move / size).max(axis=1), 1e-300))[:, None]
        uv = uv + move
        inside = ((uv >= face.box[0] - 0.05 * size) & (uv <= face.box[1] + 0.05 * size)).all(axis=1)
        uv = uv[inside]
    inside = ((uv >= face.box[0]) & (uv <= face.box[1])).all(axis=1)
    uv = uv[inside]
    if len(uv) == 0:
        return uv
    p, su, sv = surface.derivatives(uv)
    rho = radii_of(p)
    g = np.stack([(p[:, :2] * su[:, :2]).sum(axis=1), (p[:, :2] * sv[:, :2]).sum(axis=1)], axis=1)
    sizes = np.stack([np.linalg.norm(su, axis=1), np.linalg.norm(sv, axis=1)], axis=1)
    flat = (np.abs(g) <= max(FLAT, 1e-9) * np.maximum(rho, 1e-6)[:, None] * np.maximum(sizes, 1e-300) * 100.0).all(axis=1)
    return uv[flat]


def _gradient(face: Face, uv: Array) -> Array:
    """Half the gradient of rho**2 in (u, v), (n, 2)."""
    p, su, sv = face.surface.derivatives(uv)
    return np.stack([(p[:, :2] * su[:, :2]).sum(axis=1), (p[:, :2] * sv[:, :2]).sum(axis=1)], axis=1)


def _spread(breaks: Array) -> Array:
    share = (np.arange(SEEDS) + 0.5) / SEEDS
    # a face of very many patches is seeded a few times a patch, at most 60 along each side
    if len(breaks) > 13:
        breaks = np.linspace(breaks[0], breaks[-1], 13)
    return np.unique((breaks[:-1, None] + np.diff(breaks)[:, None] * share[None, :]).ravel())


def _pierced(face: Face) -> bool:
    """Whether the axis can meet a plane's box (rho = 0 inside of the face); extrusions turn back at their edges only."""
    return face.surface.kind is SurfaceKind.PLANE
