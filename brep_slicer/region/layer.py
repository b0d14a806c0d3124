"""What cutting a part at one level gives: a Layer, or a FailedLayer that says why not.

In: the region and what an engine checked. Out: frozen results; a failed layer is a type of its own, so that it can never be
taken for an empty one.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from brep_slicer.layers import CYLINDERS, LayerFamily
from brep_slicer.section import Certificate
from brep_slicer.substrate.axis import Axis
from brep_slicer.wording import counted, shortened

from .region import Region


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Layer:
    """One layer: the nominal `level` c that is deposited on (mm), the `cut_level` where the part was cut, the region.

    Where layers are cylinders, levels are radii: `radius`, `cut_radius`. The region is drawn on the sheet at `level` (there
    kappa = radius * theta); `area` is the area at the cut level, in mm**2.
    """

    index: int
    level: float
    cut_level: float
    thickness: float | None
    region: Region
    area: float
    certificate: Certificate

    def __repr__(self) -> str:
        pieces, engine = counted(len(self.region.pieces), "piece"), self.certificate.engine.value
        return f"Layer({self.index}: {self.region.sheet.label}, {pieces}, {self.area:.6g} mm2, {engine})"

    @property
    def radius(self) -> float:
        """The level of a cylinder, mm.

        Raises
        ------
        TypeError
            If the layer is none: ask for its level.
        """
        return self.region.sheet.family.radius(self.level)

    @property
    def cut_radius(self) -> float:
        """The radius where the part was cut, mm; as `radius`."""
        return self.region.sheet.family.radius(self.cut_level)

    @property
    def failed(self) -> bool:
        """False: see `FailedLayer`."""
        return False

    def face(self, axis: Axis | None = None) -> Any:
        """The section at the cut radius as an OCCT face on its exact cylinder, a compound if there are several.

        In the axis frame, or in the file's frame if its `axis` is given. A full turn comes as two faces.

        Raises
        ------
        LayerError
            If the layer is empty, or OCCT has no valid face for a piece of it.
        """
        from .faces import shape_of_region

        return shape_of_region(self.region.on_sheet(self.region.sheet.family.sheet(self.cut_level)), axis)


@dataclass(frozen=True, slots=True, kw_only=True)
class FailedLayer:
    """A layer that no engine could cut with certainty; it has no area and no region."""

    index: int
    level: float
    cut_level: float
    thickness: float | None
    reason: str
    family: LayerFamily = CYLINDERS

    def __repr__(self) -> str:
        return f"FailedLayer({self.index}: {self.family.label(self.level)}, {shortened(self.reason, 100)})"

    @property
    def radius(self) -> float:
        """The level of a cylinder, mm; as that of a `Layer`."""
        return self.family.radius(self.level)

    @property
    def cut_radius(self) -> float:
        """The radius where the part was cut, mm; as that of a `Layer`."""
        return self.family.radius(self.cut_level)

    @property
    def failed(self) -> bool:
        """True."""
        return True
