"""Layers held against what is below them: the layer before, what stands, the substrate's own metal.

In: the sections of a plan. Out: notices of metal that would hang in the air.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cached_property

from brep_slicer.notices import Notice, NoticeKind
from brep_slicer.region import DrawnRegion, FailedLayer, Layer, Overhang, drawn_region, overhang_of, slice_solids
from brep_slicer.section import CutSolid, Engine, cut_solids
from brep_slicer.substrate.radius import coaxial_cylinders

from .planned import PlanSections

# A bead is carried if its centre line lies on metal: what reaches farther than this share of its width beside it hangs.
REACH_SHARE = 0.5
# The substrate's metal is cut this share of a layer inside of its radius; cylinders that near to it are the substrate.
INSIDE_SHARE = 0.01

CutLayer = Callable[[int], "Layer | FailedLayer"]


def notices_of_support(sections: PlanSections, *, engine: Engine, cut: CutLayer) -> list[Notice]:
    """A notice for each layer with metal over air; `cut` cuts the layer below the first one where that is not planned."""
    text = (
        "{over_air_mm2} mm2 ({per_cent} % of the layer) lie over air, {beyond_mm2} mm2 of that farther than half a bead"
        f" ({REACH_SHARE * sections.process.width:.4g} mm) from all metal below: they need a support, or a part drawn otherwise"
    )
    support = _Support(sections, engine, cut)
    out = []
    for layer in sections.layers:
        hang = support.overhang(layer.index)
        if hang is not None:
            share = 100.0 * min(hang.over_air / layer.region.area, 1.0)
            values = {"over_air_mm2": hang.over_air, "per_cent": share, "beyond_mm2": hang.beyond}
            figures = {name: (value, value) for name, value in values.items()}
            out.append(Notice(kind=NoticeKind.ON_AIR, text=text, layers=(layer.index,), figures=figures))
    return out


class _Support:
    """What carries each layer, cut only where it is asked for."""

    def __init__(self, sections: PlanSections, engine: Engine, cut: CutLayer) -> None:
        self._plan, self._engine, self._cut = sections, engine, cut
        self._reach = REACH_SHARE * sections.process.width
        self._depth = INSIDE_SHARE * sections.stack.thicknesses[0]
        self._unknown = {layer.index for layer in sections.failed}
        self._drawn = {layer.index: self._draw(layer) for layer in sections.layers}

    def overhang(self, index: int) -> Overhang | None:
        """What of a layer hangs in the air; None also where what is below it is not known."""
        above, below = self._drawn[index], self._below(index)
        hang = None if below is None else overhang_of(above, below, reach=self._reach)
        if hang is None or below is None:
            return None
        if index == 0:
            return None if self._sits_on_a_shaft() else hang
        # the stack does not hold it: does anything that stands already?
        standing = self._standing_at(self._plan.stack.cut_radii[index - 1])
        if standing is None or not standing:
            return hang if standing is not None else None
        return overhang_of(above, [*below, *standing], reach=self._reach)

    def _draw(self, layer: Layer) -> DrawnRegion:
        return drawn_region(layer.region, chord=self._plan.process.chord)

    def _below(self, index: int) -> list[DrawnRegion] | None:
        """What the stack holds below a layer; None where that is not known."""
        if index == 0:
            return self._patch
        if index - 1 in self._drawn:
            return [self._drawn[index - 1]]
        layer = None if index - 1 in self._unknown else self._cut(index - 1)
        return [self._draw(layer)] if isinstance(layer, Layer) else None

    @cached_property
    def _patch(self) -> list[DrawnRegion] | None:
        """The metal just inside of the substrate's radius; None if there is none: a shaft that the file has not got."""
        return self._sections([*self._plan.solids, *self._others], self._plan.substrate.radius - self._depth) or None

    def _sits_on_a_shaft(self) -> bool:
        """Whether the substrate is a bore of the part, that a shaft which the file has not got is taken to fill."""
        plan = self._plan
        there = [c for c in coaxial_cylinders(plan.part, plan.axis) if abs(c.radius - plan.substrate.radius) <= self._depth]
        return bool(there) and not any(c.external for c in there)

    def _standing_at(self, radius: float) -> list[DrawnRegion] | None:
        """Sections of what stands already."""
        substrate = self._plan.substrate
        # where collars stand, what is built is cut whole: what the stack holds of it is there anyway
        stand = (*substrate.solids, *(substrate.built if substrate.zones else ()))
        standing = [solid for solid in self._plan.solids if solid.index in stand]
        return self._sections([*standing, *self._others], radius)

    @cached_property
    def _others(self) -> tuple[CutSolid, ...]:
        part = self._plan.part
        return cut_solids(replace(part, solids=part.others), self._plan.axis)

    def _sections(self, solids: Sequence[CutSolid], radius: float) -> list[DrawnRegion] | None:
        """The solids that meet a radius there, each by itself; None if one of them cannot be cut."""
        meeting = [s for s in solids if s.critical.lowest < radius < s.critical.highest]
        cut = [slice_solids([solid], [radius], engine=self._engine)[0] for solid in meeting]
        drawn = [self._draw(layer) for layer in cut if isinstance(layer, Layer)]
        return [one for one in drawn if one.polygons] if len(drawn) == len(cut) else None
