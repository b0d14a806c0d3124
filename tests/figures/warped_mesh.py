"""The rival's mesh, as good as we can make it: the source paper's method (mesh, warp, cut by planes), following the faces.

Each face is triangulated in (u, v) from its sampled boundary; an edge of a triangle is halved while, *after* the warp to
(theta, z, rho), Eq. 1 of the paper, the surface lies so far from it that the outline moves by more than the deviation. So a
helical flank, straight along the helix once warped, is divided across it: far fewer triangles than a mesher that knows nothing
of the warp needs for the same error.
"""

from __future__ import annotations

import numpy as np
import shapely

from brep_slicer.geometry import ElementarySurface, Face, SurfaceKind
from brep_slicer.maps import TURN, Array
from brep_slicer.section import CutSolid

# Where along an edge of a triangle the surface is compared with it.
SHARES = (0.25, 0.5, 0.75)
MOST_ROUNDS = 80
# An error along the normal moves the outline by 1 / steep of it, steep the sine of the angle between normal and radius.
LEAST_STEEP = 0.02


class TooManyTriangles(Exception):
    """The mesh would be larger than allowed."""


def warped_mesh(solid: CutSolid, deviation: float, low: float, high: float, most: int):
    """A soup of triangles in (theta, z, rho), as trimesh has it, of the part of the solid between two radii.

    Raises
    ------
    TooManyTriangles
        Beyond `most`.
    """
    import trimesh

    soup, count = [np.zeros((0, 3, 3))], 0
    for face in solid.brep.faces:
        rings = _rings(solid, face, deviation)
        triangles = (
            _flat_ring(solid, face, rings, low) if _across(face) else _on_face(face, rings, deviation, low, high, most - count)
        )
        soup.append(triangles)
        count += len(triangles)
        if count > most:
            raise TooManyTriangles
    corners = np.concatenate(soup)
    theta = corners[..., 0]
    corners[..., 0] = theta[:, :1] + _wrapped(theta - theta[:, :1])
    return trimesh.Trimesh(corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3), process=False)


def _wrapped(angle: Array) -> Array:
    return np.remainder(angle + 0.5 * TURN, TURN) - 0.5 * TURN


def _warped(p: Array) -> Array:
    return np.stack([np.arctan2(p[..., 1], p[..., 0]), p[..., 2], np.hypot(p[..., 0], p[..., 1])], axis=-1)


def _across(face: Face) -> bool:
    """Whether a face lies in a plane across the axis: its section is v = const whatever its triangles are."""
    surface = face.surface
    if not isinstance(surface, ElementarySurface) or surface.kind is not SurfaceKind.PLANE:
        return False
    return bool(np.abs(surface.frame[2, :2]).max() < 1e-12)


def _rings(solid: CutSolid, face: Face, deviation: float) -> list[Array]:
    """The face's boundary in (u, v), sampled until the warped edges' chords are as near as the deviation."""
    out = []
    for loop in face.loops:
        chain = []
        for use in loop:
            edge = solid.brep.edges[use.edge]
            if use.pcurve is None:
                continue
            shares = np.array([0.0, 0.5, 1.0])
            if edge.curve is not None:
                # a circle about the axis is straight once warped, but the face across the axis is cut in the plane
                shares = _shares(edge.curve, np.linspace(edge.first, edge.last, 65 if _across(face) else 3), deviation)
            p = use.pcurve.points(use.range[0] + shares * (use.range[1] - use.range[0]))
            chain.append((p if use.forward else p[::-1])[:-1])
        out.append(np.concatenate(chain))
    return out


def _shares(curve, t: Array, deviation: float) -> Array:
    """Shares of an edge's parameter range where it is sampled, beginning with the parameters t."""
    first, last = t[0], t[-1]
    for _ in range(MOST_ROUNDS):
        ends, far = _warped(curve.points(t)), np.zeros(len(t) - 1, dtype=bool)
        for share in SHARES:
            inner = _warped(curve.points(t[:-1] + share * np.diff(t)))
            a, b = (_apart(ends[k], inner) for k in (slice(None, -1), slice(1, None)))
            along = b - a
            foot = np.clip(-(a * along).sum(axis=1) / np.maximum((along**2).sum(axis=1), 1e-300), 0.0, 1.0)
            far |= np.linalg.norm(a + foot[:, None] * along, axis=1) > deviation
        if not far.any():
            break
        t = np.sort(np.concatenate([t, 0.5 * (t[:-1] + t[1:])[far]]))
    return (t - first) / (last - first)


def _apart(warped: Array, centre: Array) -> Array:
    """Differences of warped points in mm, along theta, z and rho."""
    d = warped - centre
    return np.stack([centre[..., 2] * _wrapped(d[..., 0]), d[..., 1], d[..., 2]], axis=-1)


def _triangles(rings: list[Array], scale: Array) -> Array:
    """Delaunay triangles (n, 3, 2) of a polygon given by its rings; scaled for good shapes."""
    rings = sorted((r * scale for r in rings), key=lambda r: -shapely.Polygon(r).area)
    polygon = shapely.Polygon(rings[0], rings[1:])
    if not polygon.is_valid:
        polygon = shapely.make_valid(polygon)
    made = shapely.get_parts(shapely.constrained_delaunay_triangles(polygon))
    return shapely.get_coordinates(made).reshape(-1, 4, 2)[:, :3] / scale


def _flat_ring(solid: CutSolid, face: Face, rings: list[Array], low: float) -> Array:
    """Warped triangles of a face across the axis, outside of a radius: triangulated after the warp, quarter by quarter."""
    surface = face.surface
    points = [surface.points(ring) for ring in rings]
    rings = sorted((p[:, :2] for p in points), key=lambda r: -shapely.Polygon(r).area)
    whole = shapely.make_valid(shapely.Polygon(rings[0], rings[1:]))
    reach, quarters = 2.0 * solid.critical.highest, []
    whole = whole.difference(shapely.Point(0.0, 0.0).buffer(0.999 * low, quad_segs=512))
    for k in range(4):
        middle = 0.25 * TURN * (k + 0.5)
        a, b = middle - 0.125 * TURN, middle + 0.125 * TURN
        wedge = shapely.Polygon([(0.0, 0.0), (reach * np.cos(a), reach * np.sin(a)), (reach * np.cos(b), reach * np.sin(b))])
        for part in shapely.get_parts(whole.intersection(wedge)):
            if part.geom_type != "Polygon" or part.area < 1e-9:
                continue
            flat = [np.asarray(r.coords)[:-1] for r in (part.exterior, *part.interiors)]
            polar = [np.stack([_wrapped(np.arctan2(r[:, 1], r[:, 0]) - middle), np.hypot(*r.T)], axis=1) for r in flat]
            made = _triangles(polar, np.array([low, 1.0]))
            z = np.full(made.shape[:2], points[0][0, 2])
            quarters.append(np.stack([made[..., 0] + middle, z, made[..., 1]], axis=-1))
    return np.concatenate([np.zeros((0, 3, 3)), *quarters])


def _on_face(face: Face, rings: list[Array], deviation: float, low: float, high: float, most: int) -> Array:
    """Warped triangles of a face between two radii, each edge within the deviation of the surface."""
    lines = [np.linspace(face.box[0, k], face.box[1, k], 5) for k in (0, 1)]
    grid = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1).reshape(-1, 2)
    _, su, sv = face.surface.derivatives(grid)
    scale = np.maximum([np.linalg.norm(su, axis=1).mean(), np.linalg.norm(sv, axis=1).mean()], 1e-9)
    active, done = _triangles(rings, scale), [np.zeros((0, 3, 3))]
    for _ in range(MOST_ROUNDS):
        warped = _warped(face.surface.points(active.reshape(-1, 2))).reshape(-1, 3, 3)
        side = np.linalg.norm(_apart(warped, np.roll(warped, 1, axis=1)), axis=2).max(axis=1)
        slack = side**2 / np.maximum(8.0 * warped[..., 2].min(axis=1), 1e-3) + deviation
        near = (warped[..., 2].max(axis=1) + slack > low) & (warped[..., 2].min(axis=1) - slack < high)
        active, warped = active[near], warped[near]
        far = _far(face, active, warped)
        done.append(warped[far.max(axis=1) <= deviation])
        active = _halved(active[far.max(axis=1) > deviation], far[far.max(axis=1) > deviation])
        if not len(active):
            break
        if sum(map(len, done)) + len(active) > most:
            raise TooManyTriangles
    return np.concatenate(done)


def _far(face: Face, uv: Array, warped: Array) -> Array:
    """How far the outline is moved where the surface leaves each edge (n, 3), from corner i to i + 1, mm."""
    far = np.zeros((len(uv), 3))
    for i in range(3):
        j = (i + 1) % 3
        # both triangles at an edge must find the same: it is taken from its lesser end
        swap = (uv[:, i, 0] > uv[:, j, 0]) | ((uv[:, i, 0] == uv[:, j, 0]) & (uv[:, i, 1] > uv[:, j, 1]))
        a, b = (np.where(swap[:, None], uv[:, m], uv[:, n]) for m, n in ((j, i), (i, j)))
        wa, wb = (np.where(swap[:, None], warped[:, m], warped[:, n]) for m, n in ((j, i), (i, j)))
        for share in SHARES:
            p, su, sv = face.surface.derivatives(a + share * (b - a))
            normal, rho = np.cross(su, sv), np.maximum(np.hypot(p[:, 0], p[:, 1]), 1e-12)
            cos, sin = p[:, 0] / rho, p[:, 1] / rho
            across, outwards = normal[:, 1] * cos - normal[:, 0] * sin, normal[:, 0] * cos + normal[:, 1] * sin
            local = np.stack([across, normal[:, 2], outwards], axis=1)
            local /= np.maximum(np.linalg.norm(local, axis=1), 1e-300)[:, None]
            centre = _warped(p)
            off = (1.0 - share) * _apart(wa, centre) + share * _apart(wb, centre)
            steep = np.maximum(np.hypot(local[:, 0], local[:, 1]), LEAST_STEEP)
            far[:, i] = np.maximum(far[:, i], np.abs((off * local).sum(axis=1)) / steep)
    return far


def _halved(uv: Array, far: Array) -> Array:
    """Triangles cut in two across the edge that the surface leaves farthest.

    An edge that is too far stays so until it is cut, in both of its triangles: the mesh has no cracks in the end.
    """
    turn = (np.arange(3) + far.argmax(axis=1)[:, None]) % 3
    a, b, c = np.moveaxis(np.take_along_axis(uv, turn[:, :, None], axis=1), 1, 0)
    middle = 0.5 * (a + b)
    return np.concatenate([np.stack([a, middle, c], axis=1), np.stack([middle, b, c], axis=1)])
