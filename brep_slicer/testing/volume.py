"""The volume identity: the section areas add up to the volume, since |grad rho| = 1.

In: a solid ready for cutting. Out: the integral of A(rho) over rho, with its own error estimate, and the first moment along z.

integral of A(rho) d rho = V holds for every solid about any axis. It needs no ground truth: it tests every section of a part.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from brep_slicer.errors import InputError, LayerError
from brep_slicer.maps import Array
from brep_slicer.part import as_part
from brep_slicer.section import CutSolid, Engine, cut_solids
from brep_slicer.section.analytic import sections_by_analysis
from brep_slicer.section.boolean import section_by_boolean
from brep_slicer.section.oracle import volume_between
from brep_slicer.substrate.axis import find_axis

# Gauss-Legendre nodes an interval, doubled until two results agree.
FIRST_NODES, MOST_NODES = 8, 128
# Intervals shorter than this (mm) hold less volume than rounding of the rest.
SHORTEST = 1e-9
# Intervals narrower than this (mm), or than the file's own gaps between faces up to WIDEST_GAP, are not cut: land faces
# that are noisy by micrometres make hundreds of them. What lies in them is had from the surface integral, and stated.
NARROW, WIDEST_GAP = 1e-4, 0.01
# Panels of the surface integral there; the two results give the error.
SLIVER_PANELS = (8, 12)


@dataclass(frozen=True, slots=True, kw_only=True)
class VolumeIntegral:
    """`volume` (mm**3) and `moment` along z (mm**4) with estimated errors; how many sections, by which engine.

    `in_slivers` is the part of the volume (mm**3) that lies in slivers between critical radii and was not cut.
    """

    volume: float
    volume_error: float
    moment: float
    moment_error: float
    sections: int
    by_boolean: int
    in_slivers: float


def integrate_sections(solid: Any, *, engine: Engine = Engine.ANALYTIC, relative: float = 1e-10) -> VolumeIntegral:
    """Integrate the section area of one solid over the radius.

    Broken at the critical radii, where the area has square-root branches; in between rho = a + (b - a) sin(pi x / 2)**2 takes
    them away at both ends of an interval.

    Parameters
    ----------
    solid
        A CutSolid (`cut_solids`), or a Part of one solid, or anything that `as_part` makes one of; its axis is found.
    relative : float
        Intervals are refined until the estimated error is this share of the whole.

    Raises
    ------
    InputError
        If a part has several solids.
    LayerError
        If a section can be had from neither engine.
    """
    if not isinstance(solid, CutSolid):
        solid = _only_solid(solid)
    breaks = np.concatenate([[solid.critical.lowest], solid.critical.radii[solid.critical.radii > solid.critical.lowest]])
    wide = np.diff(breaks) > SHORTEST
    a, b = breaks[:-1][wide], breaks[1:][wide]
    farthest = float(np.abs(solid.brep.vertices[:, 2]).max())
    slivers = b - a <= max(NARROW, min(WIDEST_GAP, float(solid.gaps.max())))
    done, errors = _slivers(solid, a[slivers], b[slivers])
    in_slivers, count = float(done[:, 0].sum()), 0
    fallen, nodes = 0, FIRST_NODES
    a, b = a[~slivers], b[~slivers]
    previous, n, f = _panel(solid, a, b, nodes, engine)
    count, fallen = count + n, fallen + f
    while len(a):
        nodes *= 2
        current, n, f = _panel(solid, a, b, nodes, engine)
        count, fallen = count + n, fallen + f
        change = np.abs(current - previous)
        # the moment is measured against the volume at the part's farthest height: it may be nil itself
        volume = float(np.abs(np.concatenate([done, current])[:, 0]).sum())
        whole = volume * np.array([1.0, farthest])
        settled = (change <= relative * whole / max(len(a), 1)).all(axis=1) | (nodes >= MOST_NODES)
        done, errors = np.concatenate([done, current[settled]]), np.concatenate([errors, change[settled]])
        a, b, previous = a[~settled], b[~settled], current[~settled]
    return VolumeIntegral(
        volume=float(done[:, 0].sum()),
        volume_error=float(errors[:, 0].sum()),
        moment=float(done[:, 1].sum()) + solid.brep.lift * float(done[:, 0].sum()),
        moment_error=float(errors[:, 1].sum()),
        sections=count,
        by_boolean=fallen,
        in_slivers=in_slivers,
    )


def _only_solid(part: Any) -> CutSolid:
    part = as_part(part)
    solids = cut_solids(part, find_axis(part))
    if len(solids) != 1:
        raise InputError(f"{part.source}: {len(solids)} solids; give one of those that cut_solids(part, axis) makes")
    return solids[0]


def _slivers(solid: CutSolid, a: Array, b: Array) -> tuple[Array, Array]:
    """(volume, moment) (n, 2) of narrow intervals by the surface integral, neighbours together, and their errors (n, 2)."""
    if not len(a):
        return np.zeros((0, 2)), np.zeros((0, 2))
    apart = a[1:] - b[:-1] > SHORTEST
    inner, outer = a[np.concatenate([[True], apart])], b[np.concatenate([apart, [True]])]
    coarse, fine = (
        np.array([volume_between(solid.brep, p, q, panels=n) for p, q in zip(inner.tolist(), outer.tolist(), strict=True)])
        for n in SLIVER_PANELS
    )
    return fine, np.abs(fine - coarse)


def _panel(solid: CutSolid, a: Array, b: Array, nodes: int, engine: Engine) -> tuple[Array, int, int]:
    """Integrals of area and first moment over each interval, (n, 2), the number of sections, and of those by boolean."""
    x, w = np.polynomial.legendre.leggauss(nodes)
    x, w = 0.5 * (x + 1.0), 0.5 * w
    sin, cos = np.sin(0.5 * np.pi * x), np.cos(0.5 * np.pi * x)
    radii = a[:, None] + (b - a)[:, None] * sin**2
    weights = (b - a)[:, None] * np.pi * sin * cos * w
    flat = radii.ravel()
    values, fallen = _areas(solid, flat, engine)
    return np.einsum("ij,ijk->ik", weights, values.reshape(*radii.shape, 2)), len(flat), fallen


def _areas(solid: CutSolid, radii: Array, engine: Engine) -> tuple[Array, int]:
    """(area, first moment along z) at increasing radii, (n, 2)."""
    # the engines as they are: the surface integral, which judges fallbacks elsewhere, has no part in what it is held against
    out, fallen = np.zeros((len(radii), 2)), 0
    found = sections_by_analysis(solid, radii) if engine is Engine.ANALYTIC else [LayerError("")] * len(radii)
    for i, section in enumerate(found):
        if isinstance(section, LayerError):
            loops, _ = section_by_boolean(solid.wrapped, float(radii[i]), critical=solid.critical.radii)
            fallen += 1
        else:
            loops = section[0]
        out[i] = sum(loop.signed_area() for loop in loops), -0.5 * sum(loop.moment(2) for loop in loops)
    return out, fallen
