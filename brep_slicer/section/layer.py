"""What cutting a part at one radius gives: a Layer with its certificate, or a FailedLayer that says why not.

In: the region that an engine found and what it checked. Out: frozen results; a failed layer is a type of its own, so
that it can never be taken for an empty one.
"""

from __future__ import annotations

import enum
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from brep_slicer.region import Region


class Engine(enum.Enum):
    """The two ways to cut a solid, DESIGN section 4."""

    ANALYTIC = "analytic"
    BOOLEAN = "boolean"


@dataclass(frozen=True, slots=True, kw_only=True)
class Certificate:
    """What stands behind a layer: the engine, its numerical error, the checks that were made.

    `residual` is the largest distance (mm) of the outline from the exact section, as far as the engine knows; `jog` the
    largest gap (mm) between neighbouring edges of the outline (edges of real parts are tolerant). `checks` maps the name of
    each check to its outcome; `fallback` says why the first engine was not believed, empty if it was.
    """

    engine: Engine
    residual: float
    jog: float = 0.0
    checks: Mapping[str, bool | float | str] = field(default_factory=dict)
    fallback: str = ""
    coincident: bool = False

    def as_dict(self) -> dict[str, Any]:
        """Plain values, for reports."""
        return {
            "engine": self.engine.value,
            "residual_mm": self.residual,
            "jog_mm": self.jog,
            "checks": dict(self.checks),
            "fallback": self.fallback,
            "coincident": self.coincident,
        }


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Layer:
    """One layer: the nominal `radius` that is deposited on, the `cut_radius` where the part was cut, the region.

    The region is drawn on `radius` (kappa = radius * theta); `area` is the area at the cut radius, in mm**2.
    """

    index: int
    radius: float
    cut_radius: float
    thickness: float | None
    region: Region
    area: float
    certificate: Certificate

    @property
    def failed(self) -> bool:
        """False: see `FailedLayer`."""
        return False


@dataclass(frozen=True, slots=True, kw_only=True)
class FailedLayer:
    """A layer that no engine could cut with certainty; it has no area and no region."""

    index: int
    radius: float
    cut_radius: float
    thickness: float | None
    reason: str

    @property
    def failed(self) -> bool:
        """True."""
        return True
