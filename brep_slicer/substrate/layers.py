"""The radii of the layers: R + i t, or a list of thicknesses, or a list of radii.

In: the substrate's radius, the part's outermost one, the process. Out: a LayerStack.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, replace

from brep_slicer.errors import InputError, PlanningError
from brep_slicer.process import CutAt, LastLayer, Process
from brep_slicer.wording import counted

# A height that is a multiple of t to this (mm) is one: 43.4 / 1.4 is 31, whatever its binary digits say; lands swept as
# B-splines deviate from their cylinder by as much.
HEIGHT_BAND = 2e-5
# So is one that misses by this share of t: a last layer thinner than a thousandth of the others is noise of the file.
HEIGHT_SHARE = 1e-3
# A last layer that the part fills to less than this share of t is none, unless it is asked for: without it the part is lower by
# a twentieth of a layer at most, which is less than the heights of beads vary by; with it, higher by nineteen. What is cut
# so near to the part's end is what roundings and tolerances have left of its outermost face.
LEAST_SHARE = 0.05
# Nor is one within the noise of the outermost face, up to this share of t: a file's tolerance takes no more than half a layer.
MOST_NOISE_SHARE = 0.5
# A file with more layers than this is a slip of the unit or of t.
MOST_LAYERS = 100_000


@dataclass(frozen=True, slots=True, kw_only=True)
class LayerStack:
    """`radii`, `thicknesses` and `cut_radii` of the layers (mm, one each).

    `overshoot` is by how much the last one is higher than the part, `undershoot` by how much the part stays lower, mm.
    """

    radii: tuple[float, ...]
    thicknesses: tuple[float, ...]
    cut_radii: tuple[float, ...]
    overshoot: float
    undershoot: float = 0.0
    notes: tuple[str, ...] = ()

    def __repr__(self) -> str:
        return (
            f"LayerStack({counted(len(self.radii), 'layer')}, R {self.radii[0]:.6g} to {self.radii[-1]:.6g} mm,"
            f" overshoot {self.overshoot:.4g} mm)"
            if self.radii
            else "LayerStack(no layers)"
        )


def stack_layers(substrate: float, highest: float, process: Process, *, noise: float = 0.0) -> LayerStack:
    """The layers from the substrate's radius to the part's outermost one, which is known to `noise` (mm).

    Raises
    ------
    InputError
        If the thickness does not suit the height, or a given radius lies outside of the part.
    PlanningError
        If no layer is left.
    """
    height = highest - substrate
    given = process.layers.radii is not None
    stack = _given_radii(substrate, highest, process) if given else _stacked(substrate, height, process, noise)
    if not stack.radii:
        raise PlanningError("no layer is left to build; make the layers thinner or keep the last one")
    if process.layers.cut_at is CutAt.MIDDLE:
        cut = tuple(r + 0.5 * t for r, t in zip(stack.radii, stack.thicknesses, strict=True))
        stack = replace(stack, cut_radii=cut)
    return stack


def _stacked(substrate: float, height: float, process: Process, noise: float) -> LayerStack:
    first = process.thickness(0)
    if first > height + HEIGHT_BAND:
        raise InputError(
            f"layer thickness {first:g} mm is larger than the whole height to build, {height:.6g} mm; make it smaller"
        )
    if height / first > MOST_LAYERS:
        raise InputError(f"layer thickness {first:g} mm gives {height / first:.0f} layers; check its unit")
    thicknesses: list[float] = []
    total = 0.0
    while total < height - max(HEIGHT_BAND, HEIGHT_SHARE * process.thickness(len(thicknesses))):
        thicknesses.append(process.thickness(len(thicknesses)))
        # one product where t is constant: no sum of rounding errors
        total = len(thicknesses) * first if not isinstance(process.layer_thickness, tuple) else math.fsum(thicknesses)
    notes: tuple[str, ...] = ()
    if total - height > HEIGHT_BAND:
        thicknesses, notes = _last_layer(thicknesses, height, total, process.layers.last_layer, noise)
    constant = len(set(thicknesses)) <= 1
    radii = tuple(substrate + (i * thicknesses[0] if constant else math.fsum(thicknesses[:i])) for i in range(len(thicknesses)))
    over = math.fsum(thicknesses) - height
    return LayerStack(
        radii=radii,
        thicknesses=tuple(thicknesses),
        cut_radii=radii,
        overshoot=over if over > HEIGHT_BAND else 0.0,
        undershoot=-over if over < -HEIGHT_BAND else 0.0,
        notes=notes,
    )


def _last_layer(
    thicknesses: list[float], height: float, total: float, choice: LastLayer, noise: float
) -> tuple[list[float], tuple[str, ...]]:
    """The thicknesses of the layers where they overshoot the height, and what was done about it, in words."""
    last = thicknesses[-1]
    filled = height - (total - last)
    others = thicknesses[:-1]
    if choice is LastLayer.DROP:
        return others, (f"the last layer is dropped: the part stays {filled:.4g} mm lower (thickness {last:g} mm)",)
    if choice is LastLayer.STRETCH:
        stretched = others if others and filled < total - height else thicknesses
        scale = height / math.fsum(stretched)
        note = f"layers are stretched by {scale:.6g} so that {len(stretched)} of them fill {height:.6g} mm"
        return [t * scale for t in stretched], (note,)
    uncertain = min(noise, MOST_NOISE_SHARE * last)
    if choice is LastLayer.AUTO and others and filled < max(LEAST_SHARE * last, uncertain):
        share = f"less than {LEAST_SHARE:.0%} of the thickness {last:g} mm" if filled < LEAST_SHARE * last else ""
        known = f"no more than is known of its outermost face ({noise:.2g} mm)" if filled < uncertain else ""
        reason = " and ".join(text for text in (share, known) if text)
        return others, (f"the part's last {filled:.3g} mm are no layer: {reason}; --last-layer keep builds it",)
    note = f"the last layer overshoots the part by {total - height:.4g} mm; --last-layer drop or stretch changes that"
    return thicknesses, (note,)


def _given_radii(substrate: float, highest: float, process: Process) -> LayerStack:
    radii = process.layers.radii
    assert radii is not None
    outside = [r for r in radii if r >= highest - HEIGHT_BAND]
    if outside:
        raise InputError(f"radius {outside[0]:g} mm lies outside of the part, which ends at {highest:.6g} mm; leave it out")
    inside = [r for r in radii if r < substrate - HEIGHT_BAND]
    if inside:
        raise InputError(
            f"radius {inside[0]:g} mm lies inside of the substrate, R {substrate:.6g} mm; leave it out or give --substrate"
        )
    thicknesses = [b - a for a, b in itertools.pairwise(radii)]
    thicknesses.append(process.thickness(len(radii) - 1))
    return LayerStack(
        radii=radii, thicknesses=tuple(thicknesses), cut_radii=radii, overshoot=max(radii[-1] + thicknesses[-1] - highest, 0.0)
    )
