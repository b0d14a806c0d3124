"""The part with a machining allowance: every section of the solid grown by a distance a along its normals.

In: solids, radii, the allowance. Out: Layers whose regions are outlined by polylines, at least a outside of the part and at
most a chord more.

A point of the grown solid lies within a of a point of the solid. Of points delta higher or lower, what is left of a sideways
is sqrt(a**2 - delta**2), so the grown section at rho is the union of the solid's sections at rho + a sin(psi), each grown in
the plane by a cos(psi). (To first order in a / rho: kappa is scaled from one radius to the other.) On a face whose normal makes
the angle psi with the layer this gives a / cos(psi) = a / sqrt(1 - (n . e_rho)**2) sideways; on a land, layers on top.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from brep_slicer.curves import LineCurve
from brep_slicer.errors import LayerError
from brep_slicer.maps import TURN, Array
from brep_slicer.section import CutSolid, Engine
from brep_slicer.section.chain import Arc, loops_from_arcs

from .chart import polygon_from_piece
from .layer import FailedLayer, Layer
from .region import Region, region_from_loops
from .slicing import slice_solids

if TYPE_CHECKING:
    from shapely import Geometry

# Sampling (outwards and inwards), round corners, thinning (likewise) and the steps of psi each err by this share of the chord.
SHARE = 1.0 / 6.0
# A section this far below a land (mm) still has it: more than the noise of lands in real files.
BELOW = 5e-5
# Ends of the outline on the two sides of the chart belong together within this, mm.
SAME_PLACE = 1e-6


def slice_with_allowance(
    solids: Sequence[CutSolid],
    radii: Sequence[float],
    *,
    allowance: float,
    lowest: float,
    chord: float,
    engine: Engine = Engine.ANALYTIC,
    substrate_solids: Sequence[int] = (),
    progress: Callable[[int], None] | None = None,
) -> list[Layer | FailedLayer]:
    """`slice_solids` for the part grown by `allowance` (mm), outlines to `chord`; nothing below `lowest` (mm) is grown."""
    heights, reach = _steps(allowance, chord)
    edges = _edges([s for s in solids if s.index not in substrate_solids], SHARE * chord)
    wanted = [np.concatenate([r + heights, edges[np.abs(edges - r) < reach]]) for r in radii]
    wanted = [some[(some >= lowest) & (some > 0.0)].tolist() for some in wanted]
    every = np.unique([r for some in wanted for r in some]).tolist()
    cut = dict(zip(every, slice_solids(solids, every, engine=engine, substrate_solids=substrate_solids), strict=True))
    standing = [s for s in solids if s.index in substrate_solids]
    ground = slice_solids(standing, radii, engine=engine) if standing else [None] * len(radii)
    out: list[Layer | FailedLayer] = []
    for i, radius in enumerate(radii):
        some = [cut[r] for r in wanted[i]]
        out.append(_grown_layer(i, radius, some, ground[i], reach, chord))
        if progress is not None:
            progress(i)
    return out


def _steps(allowance: float, chord: float) -> tuple[Array, float]:
    """Heights above a layer whose sections are grown into it, and the distance grown by: a polygon round the circle of a."""
    reach = allowance + SHARE * chord
    count = math.ceil(math.pi / (2.0 * math.acos(allowance / reach)))
    count += count % 2
    return reach * np.sin(np.linspace(-0.5 * math.pi, 0.5 * math.pi, count + 1)), reach


def _edges(solids: Sequence[CutSolid], apart: float) -> Array:
    """Radii where edges, lands and corners are, and just below them: what ends there must be grown from its very end."""
    found = np.sort(np.concatenate([np.zeros(0), *[np.append(s.critical.radii, s.critical.highest) for s in solids]]))
    far = np.append(np.diff(found) > apart, True)
    return np.sort(np.concatenate([found[far], found[far] - BELOW]))


def _grown_layer(
    index: int,
    radius: float,
    some: Sequence[Layer | FailedLayer],
    ground: Layer | FailedLayer | None,
    reach: float,
    chord: float,
) -> Layer | FailedLayer:
    whole = [layer for layer in some if isinstance(layer, Layer)]
    failed = [layer for layer in (*some, ground) if isinstance(layer, FailedLayer)]
    reason = "; ".join(f"at R {layer.radius:.6g} mm: {layer.reason}" for layer in failed)
    if not failed:
        try:
            parts = [(layer.region, math.sqrt(max(reach**2 - (layer.radius - radius) ** 2, 0.0))) for layer in whole]
            region = grown_region(radius, parts, chord=chord, standing=ground.region if isinstance(ground, Layer) else None)
            nearest = min(whole, key=lambda layer: abs(layer.radius - radius))
            checks: dict[str, bool | float | str] = {
                "grown_from_sections": len(whole),
                "outline": "polylines outside of the exact one",
            }
            # grown to the chord, and to first order in a / rho
            worst = max(layer.certificate.residual for layer in whole) + chord + reach**2 / radius
            certificate = replace(nearest.certificate, residual=worst, checks=checks)
            return replace(
                nearest, index=index, radius=radius, cut_radius=radius, region=region, area=region.area, certificate=certificate
            )
        except LayerError as error:
            reason = str(error)
    return FailedLayer(index=index, radius=radius, cut_radius=radius, thickness=None, reason=reason)


def grown_region(
    radius: float, parts: Sequence[tuple[Region, float]], *, chord: float, standing: Region | None = None
) -> Region:
    """The union of regions, each grown by its distance (mm) at least and a chord more at most, without what stands already.

    The regions may be drawn on other cylinders; kappa is scaled to `radius`.

    Raises
    ------
    LayerError
        If the outline does not close.
    """
    import shapely

    share = SHARE * chord
    shapes = []
    for region, distance in parts:
        grown = distance + 3.0 * share
        corners = max(8, math.ceil(0.25 * math.pi / math.acos(1.0 - min(share / grown, 0.5))))
        flat = shapely.union_all(_copies(region.on_radius(radius), share, grown))
        shapes.append(flat.buffer(grown, quad_segs=corners))
    whole = shapely.union_all(shapes)
    if standing is not None and not standing.is_empty:
        # a hair more than it is, or slivers would be left along it
        whole = whole.difference(shapely.union_all(_copies(standing, share, 0.0)).buffer(2.0 * share))
    return _region_of(whole, radius, share)


def _copies(region: Region, chord: float, margin: float) -> list[Geometry]:
    """The region's polygons over the middle turn and half a turn on either side of it."""
    import shapely.affinity

    period, out = region.period, []
    for piece in region.pieces:
        polygon = polygon_from_piece(piece, chord=chord, seam=-0.5 * period).buffer(0.0)
        low, _, high, _ = polygon.bounds
        turns = range(math.ceil((-period - margin - high) / period), math.floor((period + margin - low) / period) + 1)
        out += [shapely.affinity.translate(polygon, k * period) for k in turns]
    return out


def _region_of(shape: Geometry, radius: float, thin: float) -> Region:
    """A region of what is drawn on at least one turn, cut where no corner lies and joined again over the seam."""
    import shapely

    if shape.is_empty:
        return Region(radius=radius)
    period = TURN * radius
    seam = _free_place(shape, period)
    low, high = shape.bounds[1::2]
    flat = shape.intersection(shapely.box(seam, low - 1.0, seam + period, high + 1.0))
    polygons = [p for p in shapely.get_parts(flat) if p.geom_type == "Polygon" and p.area > thin**2]
    rings = [ring for p in polygons for q in [shapely.orient_polygons(p)] for ring in (q.exterior, *q.interiors)]
    runs = [run for ring in rings for run in _runs(np.asarray(ring.coords)[:-1], seam, period)]
    chains = [np.asarray(shapely.LineString(run).simplify(thin).coords) for run in runs]
    return region_from_loops(radius, loops_from_arcs(radius, _arcs(chains, seam, radius)))


def _free_place(shape: Geometry, period: float) -> float:
    """A kappa in [-period, 0) as far from all corners as can be."""
    import shapely

    corners = np.sort(np.remainder(shapely.get_coordinates(shape)[:, 0], period))
    gaps = np.diff(np.append(corners, corners[0] + period))
    place = float(corners[gaps.argmax()] + 0.5 * gaps.max())
    return place - period * math.floor(place / period) - period


def _arcs(chains: Sequence[Array], seam: float, radius: float) -> list[Arc]:
    """Lines from corner to corner, each corner a node; ends on the right side of the chart are joined to those on the left."""
    arcs: list[Arc] = []
    left: list[tuple[float, int]] = []
    right: list[tuple[float, int]] = []
    node = 0
    for points in chains:
        closed = bool((points[0] == points[-1]).all())
        if closed and len(points) < 4:
            continue
        nodes = list(range(node, node + len(points)))
        node += len(points)
        if closed:
            nodes[-1] = nodes[0]
        else:
            for k in (0, -1):
                side = left if abs(points[k, 0] - seam) < 0.25 * TURN * radius else right
                side.append((float(points[k, 1]), nodes[k]))
        pairs = zip(points[:-1], points[1:], nodes[:-1], nodes[1:], strict=True)
        arcs += [Arc(curve=LineCurve(p0=p, p1=q), start=i, end=j) for p, q, i, j in pairs]
    left, right = sorted(left), sorted(right)
    if len(left) != len(right) or any(abs(a - b) > SAME_PLACE for (a, _), (b, _) in zip(left, right, strict=True)):
        raise LayerError(f"the grown outline at radius {radius:g} mm does not close over the seam")
    same = {j: i for (_, i), (_, j) in zip(left, right, strict=True)}
    return [replace(arc, start=same.get(arc.start, arc.start), end=same.get(arc.end, arc.end)) for arc in arcs]


def _runs(ring: Array, seam: float, period: float) -> list[Array]:
    """Stretches (n, 2) of a closed ring that do not run along a side of the chart; a closed one repeats its first point."""
    following = np.roll(ring, -1, axis=0)
    on = np.abs(np.abs(ring[:, 0] - seam - 0.5 * period) - 0.5 * period) < 1e-9
    after = np.abs(np.abs(following[:, 0] - seam - 0.5 * period) - 0.5 * period) < 1e-9
    along = on & after & (np.abs(following[:, 0] - ring[:, 0]) < 1e-9)
    if not along.any():
        return [np.concatenate([ring, ring[:1]])]
    # begin behind a segment along a side, then cut at every other one
    first = int(np.flatnonzero(along)[0]) + 1
    ring, along = np.roll(ring, -first, axis=0), np.roll(along, -first)
    cuts = np.flatnonzero(along)
    return [part for part in np.split(ring, cuts + 1) if len(part) > 1]
