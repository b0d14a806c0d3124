"""The part with a machining allowance: every section of the solid grown by a distance a along its normals.

In: solids, radii, the allowance. Out: Layers whose regions are outlined by polylines, at least a outside of the part and at
most a chord more.

A point of the grown solid lies within a of a point of the solid. Of points delta higher or lower, what is left of a sideways
is sqrt(a**2 - delta**2), so the grown section at rho is the union of the solid's sections at rho + a sin(psi), each grown in
the plane by a cos(psi). (To first order in a / rho: kappa is scaled from one radius to the other.) On a face whose normal makes
the angle psi with the layer this gives a / cos(psi) = a / sqrt(1 - (n . e_rho)**2) sideways; on a land, layers on top.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from brep_slicer.curves import LineCurve, Loop
from brep_slicer.errors import LayerError
from brep_slicer.layers import Sheet, cylinder
from brep_slicer.maps import Array
from brep_slicer.section import CutSolid, Engine

from .chart import polygon_from_piece
from .layer import FailedLayer, Layer
from .region import Region, region_from_loops
from .slicing import slice_solids
from .stitched import stitched_outlines

if TYPE_CHECKING:
    from shapely import Geometry

# Sampling (outwards and inwards), round corners, thinning (likewise) and the steps of psi each err by this share of the chord.
SHARE = 1.0 / 6.0
# A section this far below a land (mm) still has it: more than the noise of lands in real files.
BELOW = 5e-5


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
            region = grown_region(
                cylinder(radius), parts, chord=chord, standing=ground.region if isinstance(ground, Layer) else None
            )
            nearest = min(whole, key=lambda layer: abs(layer.radius - radius))
            checks: dict[str, bool | float | str] = {
                "grown_from_sections": len(whole),
                "outline": "polylines outside of the exact one",
            }
            # grown to the chord, and to first order in a / rho
            worst = max(layer.certificate.residual for layer in whole) + chord + reach**2 / radius
            certificate = replace(nearest.certificate, residual=worst, checks=checks)
            return replace(
                nearest, index=index, level=radius, cut_level=radius, region=region, area=region.area, certificate=certificate
            )
        except LayerError as error:
            reason = str(error)
    return FailedLayer(index=index, level=radius, cut_level=radius, thickness=None, reason=reason)


def grown_region(
    sheet: Sheet, parts: Sequence[tuple[Region, float]], *, chord: float, standing: Region | None = None
) -> Region:
    """The union of regions, each grown by its distance (mm) at least and a chord more at most, without what stands already.

    The regions may be drawn on other cylinders; kappa is scaled to that of `sheet`.

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
        flat = shapely.union_all(_copies(region.on_sheet(sheet), share, grown))
        shapes.append(flat.buffer(grown, quad_segs=corners))
    whole = shapely.union_all(shapes)
    if standing is not None and not standing.is_empty:
        # a hair more than it is, or slivers would be left along it
        whole = whole.difference(shapely.union_all(_copies(standing, share, 0.0)).buffer(2.0 * share))
    return _region_of(whole, sheet, share)


def _copies(region: Region, chord: float, margin: float) -> list[Geometry]:
    """The region's polygons over the middle turn and half a turn on either side of it."""
    import shapely

    closure, out = region.closure, []
    for piece in region.pieces:
        polygon = polygon_from_piece(piece, chord=chord).buffer(0.0)
        reach = shapely.box(*polygon.bounds).buffer(margin).bounds
        out += [closure.motion(k).shape(polygon) for k in closure.copies_between(reach, -1.0, 1.0)]
    return out


def _region_of(shape: Geometry, sheet: Sheet, thin: float) -> Region:
    """A region of what is drawn on the middle turn and on half a turn beside it."""
    loops = []
    for points, winding in stitched_outlines(shape, sheet.closure, first=-1.0, thin=thin, spot=thin**2):
        lines = tuple(LineCurve(p0=p, p1=q) for p, q in itertools.pairwise(points))
        loops.append(Loop(curves=lines, sheet=sheet, winding=winding))
    return region_from_loops(sheet, loops)
