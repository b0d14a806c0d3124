"""What toolpath.png shows, as triangles: the solids, and the beads as raised tracks of their width.

In: a Plan. Out: meshes in the file's frame, mm, with a colour for every triangle.

Words: *stretch*, a short part of a bead from one point to the next; *profile*, a bead's cross-section, a parabola as in the
simulated deposit.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from brep_slicer.maps import Array

from .lowered import cut_lines_at, in_zones, lowered

if TYPE_CHECKING:
    from brep_slicer.planning import Plan
    from brep_slicer.toolpath import Toolpath

# red, green and blue from 0 to 1: metal that stands, metal to be built, beads of the first and of the last layer, travels
STANDS, PART = np.array([0.72, 0.73, 0.75]), np.array([0.90, 0.87, 0.80])
FIRST_BEAD, LAST_BEAD, TRAVEL = np.array([0.66, 0.10, 0.14]), np.array([0.93, 0.27, 0.24]), np.array([0.12, 0.37, 0.75])
# Every second layer is so much lighter, so that layers can be told from one another.
LIGHTER = 0.12
# What lies farther out than the planned layers by less than this share of a thickness is the part's own surface.
TOO_THIN = 0.5
# A bead's profile: shares of half its width (its height there is 1 - share**2 of its own); a plain one where a bead is small.
FINE_PROFILE, PLAIN_PROFILE = np.array([-1.0, -0.5, 0.0, 0.5, 1.0]), np.array([-1.0, 0.0, 1.0])
# A bead's round end is drawn in so many steps.
ROUND = 2
# Segments that turn by less than this (cosine of 0.2 rad) go on about straight.
STRAIGHT = 0.98
# A bead is no farther to one side at a corner than so many halves of its width.
LONGEST_MITRE = 1.5
# So many stretches are worked on at once, each of a kilobyte or two as triangles: what bounds the memory.
AT_ONCE = 20_000


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Mesh:
    """`points` and unit `normals` (n, 3), `triangles` (m, 3) with their `colors` (m, 3); sharp `edges` (k, 2)."""

    points: Array
    normals: Array
    triangles: Array
    colors: Array
    edges: Array


def joined(meshes: list[Mesh]) -> Mesh:
    """Several meshes as one."""
    none = np.zeros((0, 3))
    shifts = np.cumsum([0, *(len(mesh.points) for mesh in meshes)])
    return Mesh(
        points=np.concatenate([none, *(mesh.points for mesh in meshes)]),
        normals=np.concatenate([none, *(mesh.normals for mesh in meshes)]),
        triangles=np.concatenate([none.astype(int), *(m.triangles + s for m, s in zip(meshes, shifts, strict=False))]),
        colors=np.concatenate([none, *(mesh.colors for mesh in meshes)]),
        edges=np.concatenate([np.zeros((0, 2), dtype=int), *(m.edges + s for m, s in zip(meshes, shifts, strict=False))]),
    )


def part_mesh(plan: Plan, deflection: float) -> Mesh:
    """Every solid of the file: grey what stands, lighter what is to be built, triangulated to `deflection` mm.

    Of what is to be built there is no more than the planned layers reach.
    """
    from brep_slicer.kernel.display import display_mesh

    level = plan.substrate.radius + deflection
    top = top_of(plan)
    out = []
    for solid in (*plan.part.solids, *plan.part.others):
        mesh = display_mesh(solid.wrapped, deflection=deflection, known=solid.known.get("facets"))
        stands = solid.index in plan.substrate.solids or solid in plan.part.others
        rho = np.hypot(*plan.axis.axis_from_file(mesh.points)[:, :2].T)
        built = (rho[mesh.triangles] > level).any(axis=1) & (not stands)
        colors = np.where(built[:, None], PART, STANDS)
        whole = Mesh(points=mesh.points, normals=mesh.normals, triangles=mesh.triangles, colors=colors, edges=mesh.edges)
        out.append(whole if stands or rho.max(initial=0.0) <= top else _lowered(plan, whole, top))
    return joined(out)


def top_of(plan: Plan) -> float:
    """The radius (mm) that the planned layers reach; no bound where they are all of the part's."""
    if not plan.layers:
        return plan.substrate.radius
    last = max(plan.layers, key=lambda layer: layer.radius)
    thickness = last.thickness or 0.0
    top = last.radius + thickness
    return top if top < plan.highest - TOO_THIN * thickness else math.inf


def _lowered(plan: Plan, mesh: Mesh, top: float) -> Mesh:
    """A built solid's mesh with nothing beyond `top` (mm), but for its own collars and flanges that stand."""
    zones = plan.substrate.zones
    stays = in_zones(mesh.points, mesh.triangles, axis=plan.axis, zones=zones)
    rho = np.hypot(*plan.axis.axis_from_file(mesh.points)[:, :2].T)
    cut = (rho[mesh.triangles] > top).any(axis=1) & ~stays
    soup = lowered(mesh.points, mesh.normals, mesh.triangles[cut], axis=plan.axis, top=top)
    count = len(soup.points)
    loose = replace(mesh, triangles=mesh.triangles[~cut], colors=mesh.colors[~cut], edges=np.zeros((0, 2), dtype=int))
    part = Mesh(
        points=soup.points.reshape(-1, 3),
        normals=soup.normals.reshape(-1, 3),
        triangles=np.arange(3 * count).reshape(-1, 3),
        colors=np.broadcast_to(PART, (count, 3)),
        edges=np.zeros((0, 2), dtype=int),
    )
    standing = in_zones(mesh.points, mesh.edges, axis=plan.axis, zones=zones)
    ways = [mesh.points[mesh.edges[standing]], cut_lines_at(mesh.points, mesh.edges[~standing], axis=plan.axis, top=top)]
    lines = np.concatenate([*ways, soup.lines])
    none = np.zeros((0, 3))
    edges = Mesh(
        points=lines.reshape(-1, 3),
        normals=np.zeros((2 * len(lines), 3)),
        triangles=none.astype(int),
        colors=none,
        edges=np.arange(2 * len(lines)).reshape(-1, 2),
    )
    return joined([loose, part, edges])


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Stretches:
    """Beads in short stretches, in order: ends `a` and `b`, their normals (n, 3), layer (n,), and what each is joined to.

    `left_a` and `left_b` (n, 3) go from the middle of the bead to its left side at either end, in halves of its width; `before`
    and `after` (n,) tell whether the bead goes on there.
    """

    a: Array
    b: Array
    normal_a: Array
    normal_b: Array
    left_a: Array
    left_b: Array
    layer: Array
    before: Array
    after: Array

    def __len__(self) -> int:
        return len(self.layer)

    def rows(self, chosen: Array) -> Stretches:
        """Some of them; each stays joined to what it was joined to."""
        return Stretches(**{name: getattr(self, name)[chosen] for name in self.__slots__})

    @classmethod
    def together(cls, parts: list[Stretches]) -> Stretches:
        """One or more, one after the other."""
        return cls(**{name: np.concatenate([getattr(part, name) for part in parts]) for name in cls.__slots__})


def blocks_of(path: Toolpath, longest: float) -> Iterator[slice]:
    """The rows of a toolpath in blocks that make about `AT_ONCE` stretches, cut between beads where they are not longer."""
    first = 0
    while first < len(path):
        rows = slice(first, first + AT_ONCE)
        size = np.linalg.norm(np.diff(path.points[rows], axis=0, prepend=path.points[first : first + 1]), axis=1)
        count = np.cumsum(1.0 + np.where(path.deposits[rows], size, 0.0) / longest)
        last = first + max(1, int(np.searchsorted(count, AT_ONCE)))
        if last < len(path):
            begins = np.flatnonzero(np.diff(path.bead[first : last + 1]) | np.diff(path.layer[first : last + 1]))
            last = first + 1 + int(begins[-1]) if len(begins) else last
        yield slice(first, last)
        first = last


def stretches_of(path: Toolpath, rows: slice, longest: float, shortest: float) -> Stretches:
    """What is deposited in some rows, in stretches of `shortest` to `longest` mm; shorter ones only where it bends or ends."""
    end = rows.start + np.flatnonzero(path.deposits[rows])
    end = end[end > 0]
    start = end - 1
    size = np.linalg.norm(path.points[end] - path.points[start], axis=1)
    end, start, bead = _thinned(path, rows, end[size > 0.0], start[size > 0.0], size[size > 0.0], shortest)
    size = np.linalg.norm(path.points[end] - path.points[start], axis=1)
    cuts = np.maximum(1, np.ceil(size / longest)).astype(int)
    of = np.repeat(np.arange(len(end)), cuts)
    step = np.arange(len(of)) - np.repeat(np.cumsum(cuts) - cuts, cuts)
    low, high = (step / cuts[of])[:, None], ((step + 1) / cuts[of])[:, None]
    p, q = path.points[start][of], path.points[end][of]
    n, m = path.normals[start][of], path.normals[end][of]
    same = np.zeros(len(of) + 1, dtype=bool)
    same[1:-1] = bead[of][1:] == bead[of][:-1]
    before, after = same[:-1], same[1:]
    a, b, normal_a, normal_b = p + low * (q - p), p + high * (q - p), _unit(n + low * (m - n)), _unit(n + high * (m - n))
    side = _unit(np.cross(_unit(normal_a + normal_b), _unit(b - a)))
    # a bead joins the one before at the place where both have the same side
    mitre = np.concatenate([side[:1], _mitre(side[:-1], side[1:])])
    left_a = np.where(before[:, None], mitre, side)
    left_b = np.where(after[:, None], np.concatenate([_mitre(side[1:], side[:-1]), side[-1:]]), side)
    layer = path.layer[end][of]
    return Stretches(
        a=a, b=b, normal_a=normal_a, normal_b=normal_b, left_a=left_a, left_b=left_b, layer=layer, before=before, after=after
    )


def _thinned(path: Toolpath, rows: slice, end: Array, start: Array, size: Array, shortest: float) -> tuple[Array, Array, Array]:
    """Segments of beads (indices of their points), joined to ones of about `shortest` mm where they go on about straight.

    Also which bead of the rows each belongs to.
    """
    way = (path.points[end] - path.points[start]) / size[:, None]
    straight = np.einsum("ij,ij->i", way[1:], way[:-1]) > STRAIGHT
    begins = np.diff(path.bead[rows], prepend=0) | np.diff(path.layer[rows], prepend=0)
    bead = np.cumsum(begins != 0)[end - rows.start]
    # measured from each bead's own beginning, whatever comes before it
    first, total = np.flatnonzero(np.diff(bead, prepend=-1)), np.cumsum(size)
    step = np.floor((total - np.repeat((total - size)[first], np.diff(np.append(first, len(bead))))) / shortest)
    kept = np.ones(len(end), dtype=bool)
    kept[:-1] = (step[1:] != step[:-1]) | (bead[1:] != bead[:-1]) | ~straight
    last = np.flatnonzero(kept)
    return end[last], start[np.concatenate([[0], last[:-1] + 1])[: len(last)]], bead[last]


def bead_mesh(plan: Plan, of: Stretches, profile: Array) -> Mesh:
    """Stretches as raised tracks of a `profile`, mitred where a bead goes on, round where it ends."""
    half = 0.5 * plan.process.width
    way = _unit(of.b - of.a)
    side = _unit(np.cross(_unit(of.normal_a + of.normal_b), way))
    rise = 1.5 * _thickness(plan)[of.layer] * plan.process.step_over / plan.process.width
    colors = _colors(plan)[of.layer]
    first, last = np.flatnonzero(~of.before), np.flatnonzero(~of.after)
    still = np.zeros_like(way)
    parts = [
        _tube(
            [
                _ring(of.a, of.left_a, still, of.normal_a, rise, half, profile),
                _ring(of.b, of.left_b, still, of.normal_b, rise, half, profile),
            ],
            colors,
        ),
        _end(of.a[first], -way[first], -side[first], of.normal_a[first], rise[first], half, colors[first], profile),
        _end(of.b[last], way[last], side[last], of.normal_b[last], rise[last], half, colors[last], profile),
    ]
    return joined(parts)


def _ring(p: Array, left: Array, ahead: Array, normal: Array, rise: Array, half: float, profile: Array) -> tuple[Array, Array]:
    """The profile's points and normals, (n, k, 3), `half` wide along `left`, moved `ahead` (both in halves of the width)."""
    x = profile[:, None] * left[:, None] + ahead[:, None]
    # a parabola along the bead, a paraboloid over its end
    up = (rise * (1.0 - np.einsum("ij,ij->i", ahead, ahead)))[:, None, None] * (1.0 - profile**2)[:, None]
    tilt = 2.0 * rise[:, None, None] / half * x
    return p[:, None] + half * x + up * normal[:, None], _unit(normal[:, None] + tilt)


def _end(p: Array, way: Array, side: Array, normal: Array, rise: Array, half: float, colors: Array, profile: Array) -> Mesh:
    """Half a paraboloid beyond a bead's last point."""
    rings = [
        _ring(p, math.cos(a) * side, math.sin(a) * way, normal, rise, half, profile)
        for a in np.linspace(0.0, 0.5 * math.pi, ROUND + 1)
    ]
    return _tube(rings, colors, pointed=True)


def _tube(rings: list[tuple[Array, Array]], colors: Array, *, pointed: bool = False) -> Mesh:
    """A skin over rings that follow one another; `colors` (n, 3), one a tube."""
    points = np.concatenate([ring[0] for ring in rings], axis=1)
    normals = np.concatenate([ring[1] for ring in rings], axis=1)
    each = rings[0][0].shape[1]
    k = (np.arange(each - 1) + each * np.arange(len(rings) - 1)[:, None]).ravel()
    # a skin that ends in a point has single triangles there
    pairs = k[: len(k) - each + 1] if pointed else k
    corners = np.concatenate(
        [np.stack([k, k + each, k + 1], axis=1), np.stack([pairs + 1, pairs + each, pairs + each + 1], axis=1)]
    )
    base = (np.arange(len(points)) * points.shape[1])[:, None, None]
    return Mesh(
        points=points.reshape(-1, 3),
        normals=normals.reshape(-1, 3),
        triangles=(corners[None] + base).reshape(-1, 3),
        colors=np.repeat(colors, len(corners), axis=0),
        edges=np.zeros((0, 2), dtype=int),
    )


def _unit(vectors: Array) -> Array:
    return vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-300)


def _mitre(other: Array, side: Array) -> Array:
    """Half the bead's width to the side, where two stretches with these sides meet."""
    mean = _unit(other + side)
    slant = np.einsum("ij,ij->i", mean, side)[:, None]
    # where a bead turns back, its two sides are opposite
    return np.where(slant > 1.0 / LONGEST_MITRE, mean / np.maximum(slant, 1e-9), side)


def _thickness(plan: Plan) -> Array:
    """Thickness (mm) by layer number."""
    out = np.ones(1 + max(layer.index for layer in plan.layers))
    for layer in plan.layers:
        out[layer.index] = layer.thickness or 1.0
    return out


def _colors(plan: Plan) -> Array:
    """A colour by layer number: darker inside, every second one lighter."""
    numbers = np.arange(1 + max(layer.index for layer in plan.layers))
    first = min(layer.index for layer in plan.layers)
    share = np.clip((numbers - first) / max(1, numbers[-1] - first), 0.0, 1.0)[:, None]
    color = (1.0 - share) * FIRST_BEAD + share * LAST_BEAD
    return color + LIGHTER * (numbers % 2)[:, None] * (1.0 - color)
