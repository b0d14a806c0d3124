"""Areas and volumes without cutting anything: surface integrals over the faces, with no curve in common with the engines.

In: a solid's numpy geometry. Out: the area of the section at a radius, the volume between two radii.

div(e_rho / rho) = 0 away from the axis, so the flux of e_rho / rho through the section at R equals that through the part of the
solid's boundary that lies outside of R: A(R) = R * integral of (n . e_rho) / rho dS over the faces where rho > R.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from brep_slicer.geometry import Brep
from brep_slicer.layers import LayerFamily
from brep_slicer.maps import Array

from .trimmed import PANELS, level_bounds, surface_cells, surface_nodes


def area_by_flux(brep: Brep, radius: float, *, panels: int = PANELS) -> float:
    """Area (mm**2) of the section at `radius` (mm) by the surface integral; more `panels` for more digits."""
    return area_and_turnover(brep, radius, panels=panels)[0]


def area_and_turnover(brep: Brep, radius: float, *, panels: int = PANELS) -> tuple[float, float]:
    """The area, and what it is the difference of: the integral of the flux's size, which says what its error is a share of."""
    total = size = 0.0
    for p, n in _nodes_beyond(brep, radius, (radius,), panels):
        square = p[:, 0] ** 2 + p[:, 1] ** 2
        outside = square > radius**2
        flux = ((n[:, 0] * p[:, 0] + n[:, 1] * p[:, 1]) / np.where(square > 0.0, square, 1.0))[outside]
        total += float(flux.sum())
        size += float(np.abs(flux).sum())
    return radius * total, radius * size


def area_of_level(brep: Brep, level: float, family: LayerFamily, *, panels: int = PANELS) -> float:
    """Area (mm**2) of the section at a level of any family, by the surface integral.

    (rho0 / rho) grad c is free of divergence, with rho0 = rho - (c - level) cos(alpha) the radius of the nearest point of the
    level's sheet, as far as there is one (rho0 > 0): R / rho on cylinders, 1 on planes.
    """
    total = 0.0
    for face in brep.faces:
        if level_bounds(face, family)[1] > level:
            for p, n in surface_nodes(face, (level,), panels=panels, family=family):
                beyond = family.value(p) > level
                total += float((family.spread(p, level) * family.change(p, n))[beyond].sum())
    return total


def _nodes_beyond(brep: Brep, radius: float, levels: tuple[float, ...], panels: int) -> Iterator[tuple[Array, Array]]:
    """The nodes of all faces, block by block, but for faces that lie inside of a radius (mm) altogether."""
    for face in brep.faces:
        if level_bounds(face)[1] > radius:
            yield from surface_nodes(face, levels, panels=panels)


def areas_by_flux(brep: Brep, radii: Array, *, level: Array | None = None, lines: int = 64, cells: int = 64) -> Array:
    """Areas (mm**2) of the sections at many `radii` (mm) at once, to about four digits of the largest.

    Each face is divided into small cells across which rho is taken to change evenly; what they add to the flux is a broken line
    in R, and the broken lines are summed over sorted breaks. `level` (faces,) is the radius of faces that have one (else NaN).
    """
    return areas_of_ramps(flux_ramps(brep, level=level, lines=lines, cells=cells), radii)


def flux_ramps(brep: Brep, *, level: Array | None = None, lines: int = 64, cells: int = 64) -> tuple[Array, Array, Array]:
    """What `areas_by_flux` sums, whatever the radii: (n,) lowest and highest rho (mm) of each cell, and its flux."""
    middle, width, flux = [], [], []
    for i, face in enumerate(brep.faces):
        p, n, change = surface_cells(face, lines=lines, cells=cells)
        square = p[:, 0] ** 2 + p[:, 1] ** 2
        flat = level is not None and np.isfinite(level[i])
        middle.append(np.full(len(p), level[i]) if flat and level is not None else np.sqrt(square))
        width.append(np.zeros(len(p)) if flat else change)
        flux.append((n[:, 0] * p[:, 0] + n[:, 1] * p[:, 1]) / np.where(square > 0.0, square, 1.0))
    rho, half = np.concatenate(middle), 0.5 * np.concatenate(width)
    return rho - half, rho + half, np.concatenate(flux)


def areas_of_ramps(ramps: tuple[Array, Array, Array], radii: Array) -> Array:
    """Areas (mm**2) at `radii` (mm), from `flux_ramps`."""
    radii = np.asarray(radii, dtype=float)
    low, high, flux = ramps
    return radii * _sum_of_ramps(low, high, flux, radii)


def _sum_of_ramps(low: Array, high: Array, flux: Array, radii: Array) -> Array:
    """Sum of functions that are `flux` below `low`, nil above `high` and straight in between, at every radius."""
    step = high - low < 1e-7 * high
    high = np.where(step, low, high)
    by_low, by_high = np.argsort(low), np.argsort(high)
    before = np.searchsorted(low[by_low], radii, side="right")
    after = np.searchsorted(high[by_high], radii, side="right")
    slope = np.where(step, 0.0, flux / np.where(step, 1.0, high - low))
    offset = np.where(step, 0.0, slope * high)

    def summed(values: Array, order: Array, count: Array) -> Array:
        return np.concatenate([[0.0], np.cumsum(values[order])])[count]

    straight = summed(offset, by_low, before) - summed(offset, by_high, after)
    straight -= radii * (summed(slope, by_low, before) - summed(slope, by_high, after))
    return float(flux.sum()) - summed(flux, by_low, before) + straight


def volume_between(brep: Brep, inner: float, outer: float, *, panels: int = PANELS) -> tuple[float, float]:
    """(volume in mm**3, first moment along z in mm**4) of what lies between two radii (mm).

    The flux of g e_rho / rho with dg/d rho = rho between the radii and 0 elsewhere: its divergence is 1 there; of z times that.
    """
    volume = moment = 0.0
    for p, n in _nodes_beyond(brep, inner, (inner, outer), panels):
        square = p[:, 0] ** 2 + p[:, 1] ** 2
        g = 0.5 * (np.clip(square, inner**2, outer**2) - inner**2)
        flux = g * (n[:, 0] * p[:, 0] + n[:, 1] * p[:, 1]) / np.where(square > 0.0, square, 1.0)
        volume += float(flux.sum())
        moment += float((flux * p[:, 2]).sum())
    return volume, moment
