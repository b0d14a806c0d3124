"""What stands behind a section: the engine that made it, its numerical error, its checks.

In: an engine's own figures. Out: a Certificate.
"""

from __future__ import annotations

import enum
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from brep_slicer.errors import LayerError
from brep_slicer.wording import counted, shortened

# Outlines that may be off by more than this (mm) are none: a third of the narrowest bead that the process lays (0.3 mm),
# beyond which a bead along it misses the metal it is there for. What matters below that is the plan's to judge, by its process.
LARGEST_ERROR = 0.1


class Engine(enum.Enum):
    """The two ways to cut a solid."""

    ANALYTIC = "analytic"
    BOOLEAN = "boolean"


@dataclass(frozen=True, slots=True, kw_only=True)
class Certificate:
    """What stands behind a layer: the engine, its numerical error, the checks that were made.

    `residual` is the largest distance (mm) of the outline from the exact section, as far as the engine knows; `jog` the
    largest gap (mm) between neighbouring edges of the outline (edges of real parts are tolerant). `checks` maps the name of
    each check to its outcome; `fallback` says why the first engine was not believed, empty if it was. `contradiction` (mm) is
    what the checks' areas differ by beyond what they are good for, as an even strip along the outline.
    """

    engine: Engine
    residual: float
    jog: float = 0.0
    checks: Mapping[str, bool | float | str] = field(default_factory=dict)
    fallback: str = ""
    coincident: bool = False
    contradiction: float = 0.0

    def __repr__(self) -> str:
        checks = f", {counted(len(self.checks), 'check')}" if self.checks else ""
        fallback = f", fallback: {shortened(self.fallback)}" if self.fallback else ""
        return f"Certificate({self.engine.value}, residual {self.residual:.1e} mm, jog {self.jog:.1e} mm{checks}{fallback})"

    @property
    def bound(self) -> float:
        """What the outline is off by at most, as far as is known, mm: residual, jog and contradiction together."""
        return self.residual + self.jog + self.contradiction

    def as_dict(self) -> dict[str, Any]:
        """Plain values, for reports."""
        return {
            "engine": self.engine.value,
            "outline_error_mm": self.bound,
            "residual_mm": self.residual,
            "jog_mm": self.jog,
            "contradiction_mm": self.contradiction,
            "checks": dict(self.checks),
            "fallback": self.fallback,
            "coincident": self.coincident,
        }


def check_error(certificate: Certificate, radius: float) -> None:
    """Refuse an outline of which too little is known.

    Raises
    ------
    LayerError
        If it may be off by more than LARGEST_ERROR.
    """
    if not certificate.bound <= LARGEST_ERROR:
        raise LayerError(
            f"the {certificate.engine.value} outline at radius {radius:.9g} mm may be off by {certificate.bound:.3g} mm, more"
            f" than {LARGEST_ERROR:g} mm (residual {certificate.residual:.3g} mm, gaps {certificate.jog:.3g} mm, areas that"
            f" contradict one another {certificate.contradiction:.3g} mm)"
        )
