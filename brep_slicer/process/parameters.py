"""The process of a plan: what is required at the top, the rest in groups, what was assumed apart from what was given.

In: numbers from Python, the command line or a TOML file. Out: a frozen Process.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from brep_slicer.errors import InputError
from brep_slicer.wording import shortened

from .groups import FINEST_CHORD, GROUPS, Fill, Laser, Layers, Motion, Powder, as_group, where_it_stands
from .parameter import Declared, as_written, check_names, declarations_of, declared
from .rules import Rule, as_rule
from .taken import Taken, default
from .values import OutlinePosition

# The paper's Table 3: laser spot 4.9 mm at a step-over of 3.4 mm, and a tool-head speed of 9 mm/s.
WIDTH_PER_STEP_OVER = 1.44
DEPOSITION_SPEED_MM_S = 9.0
# What a machine's axes do with the laser off, mm/s.
TRAVEL_SPEED_MM_S = 50.0
# What the machine's nozzle keeps clear of, mm, however small the part.
CLEARANCE = 5.0
# Travels up to so many step-overs stay low.
HOP_STEP_OVERS = 3.0
# The chord (mm) that is assumed for step-overs of so many mm and more. Finer beads build smaller parts, which may be no larger
# than a chord of ordinary ones.
CHORD, ORDINARY_STEP_OVER = 0.01, 1.0
# No outermost bead runs farther outside of the outline than so many bead widths: a slip of the sign, or of the unit.
MOST_OUTSIDE = 5.0
# How many bead widths inside of the outline the outermost centres run.
INSET_WIDTHS = {OutlinePosition.IN: 0.5, OutlinePosition.ON: 0.0, OutlinePosition.OUT: -0.5}


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class Process(Declared):
    """How to deposit. Lengths in mm, angles in degrees, speeds in mm/s; `layer_thickness` and `step_over` are required.

    Every other parameter stands in a group; each group is a class, and a table in a process file. docs/process.md lists them
    all with their units and ranges.

    Parameters
    ----------
    layer_thickness : float or sequence of float
        t, one for all layers or one for each.
    step_over : float
        d, between the centres of neighbouring beads.
    layers : Layers or dict
        Where the layers lie: radii, machining allowance, the last layer, where they are cut.
    fill : Fill or dict
        How they are filled: the pattern, contours, bead width, inset, order, and speeds that follow the metal.
    motion : Motion or dict
        Speeds, clearance, leads, the chord of sampled curves.
    laser : Laser or dict
        Power and delays.
    powder : Powder or dict
        Feed and density: with both, the report has the catchment.
    rules : sequence of Rule or dict
        Other fill parameters for some layers and pieces; of several that hold, the first. A dict is as a table of a process
        file, dict(layers="0:3", contours=2).

    Raises
    ------
    InputError
        If a value is missing, not finite or out of its range; the message names it.
    """

    layer_thickness: float | Sequence[float] = field(
        metadata=declared(
            unit="mm",
            many=True,
            above=0.0,
            options=("-t", "--layer-thickness"),
            example=1.4,
            help="Layer thickness t, one for all layers or one for each (the last holds on)",
        )
    )
    step_over: float = field(
        metadata=declared(
            unit="mm",
            above=0.0,
            options=("-d", "--step-over"),
            example=3.4,
            help="Step-over d, between the centres of neighbouring beads",
        )
    )
    layers: Taken[Layers, Layers | Mapping[str, Any]] = default(None)
    fill: Taken[Fill, Fill | Mapping[str, Any]] = default(None)
    motion: Taken[Motion, Motion | Mapping[str, Any]] = default(None)
    laser: Taken[Laser, Laser | Mapping[str, Any]] = default(None)
    powder: Taken[Powder, Powder | Mapping[str, Any]] = default(None)
    rules: Taken[tuple[Rule, ...], Sequence[Rule | Mapping[str, Any]] | Rule | Mapping[str, Any]] = default(())

    def __new__(cls, *args: Any, **given: Any) -> Process:
        """Names that no parameter has are told of with where they stand, or with the nearest that one has."""
        check_names(given, TOP, "process parameter", where_it_stands())
        return object.__new__(cls)

    def __post_init__(self) -> None:
        several = isinstance(self.layer_thickness, Iterable)
        Declared.__post_init__(self)
        if not several:
            (thickness,) = self.layer_thickness  # type: ignore[misc]
            object.__setattr__(self, "layer_thickness", thickness)
        for name in GROUPS:
            try:
                object.__setattr__(self, name, as_group(name, getattr(self, name)))
            except InputError as error:
                raise InputError(f"{name}: {error}") from None
        given: Any = self.rules
        alone = isinstance(given, Rule | Mapping | str) or not isinstance(given, Iterable)
        object.__setattr__(self, "rules", tuple(map(as_rule, (given,) if alone else given)))
        self._check_together()

    def _check_together(self) -> None:
        """What one parameter says of another."""
        inset = self.fill.inset
        if inset is not None and inset < -MOST_OUTSIDE * self.width:
            raise InputError(
                f"fill: inset is {inset:g} mm; the outermost beads would run {-inset / self.width:.3g} bead widths"
                f" outside of the part ({MOST_OUTSIDE:g} at most)"
            )
        if self.catchment is not None and self.catchment > 1.0:
            raise InputError(
                f"the beads need {self.catchment:.4g} times the powder that is fed (t d speed density / feed may be 1 at most);"
                " feed more, or deposit slower or thinner"
            )

    def __repr__(self) -> str:
        given = [f"layer_thickness={self.layer_thickness!r}", f"step_over={self.step_over!r}"]
        given += [f"{name}={getattr(self, name)!r}" for name, kind in GROUPS.items() if getattr(self, name) != kind()]
        given += [f"rules={self.rules!r}"] if self.rules else []
        return f"Process({shortened(', '.join(given), 180)})"

    @property
    def catchment(self) -> float | None:
        """eta = t d speed density / powder feed: the share of the powder that becomes metal; None without feed and density.

        The metal balance of the paper (its Table 3 gives 0.86 with 7.99 g/cm**3); of the thickest layer if they differ.
        """
        feed, density = self.powder.feed_g_s, self.powder.density_g_cm3
        if feed is None or density is None:
            return None
        t = max(self.layer_thickness) if isinstance(self.layer_thickness, Sequence) else self.layer_thickness
        return t * self.step_over * self.deposition_speed * 1e-3 * density / feed

    @property
    def width(self) -> float:
        """Bead width w in mm, given or assumed."""
        return WIDTH_PER_STEP_OVER * self.step_over if self.fill.bead_width is None else self.fill.bead_width

    @property
    def inset(self) -> float:
        """How far inside of the outline the outermost bead centres stay, mm, given or by the outline position."""
        return INSET_WIDTHS[self.fill.outline_position] * self.width if self.fill.inset is None else self.fill.inset

    @property
    def deposition_speed(self) -> float:
        """Deposition speed, mm/s."""
        return _or(self.motion.deposition_speed_mm_s, DEPOSITION_SPEED_MM_S)

    @property
    def travel_speed(self) -> float:
        """Speed of travels, mm/s."""
        return _or(self.motion.travel_speed_mm_s, TRAVEL_SPEED_MM_S)

    @property
    def clearance(self) -> float:
        """How far the nozzle of a travel stays above what stands in its way, mm: the machine's, two layers at least."""
        return _or(self.motion.clearance, max(CLEARANCE, 2.0 * self.thickness(0)))

    @property
    def hop_length(self) -> float:
        """The longest travel that stays low, mm."""
        return _or(self.motion.hop_length, HOP_STEP_OVERS * self.step_over)

    @property
    def chord(self) -> float:
        """Tolerance of sampled curves, mm: that of ordinary step-overs, 1 mm and more, and in proportion to a finer one."""
        fine = min(1.0, self.step_over / ORDINARY_STEP_OVER)
        return _or(self.motion.chord, max(CHORD * fine, FINEST_CHORD))

    def assumed(self) -> dict[str, dict[str, float]]:
        """What is assumed where nothing is given, by group and name: reports name it so."""
        used = {
            "fill": {"bead_width": self.width, "inset": self.inset},
            "motion": {
                "deposition_speed_mm_s": self.deposition_speed,
                "travel_speed_mm_s": self.travel_speed,
                "clearance": self.clearance,
                "hop_length": self.hop_length,
                "chord": self.chord,
            },
        }
        return {
            group: {name: value for name, value in values.items() if getattr(getattr(self, group), name) is None}
            for group, values in used.items()
        }

    def thickness(self, layer: int) -> float:
        """Thickness asked for layer `layer`, mm; the last of a list holds on."""
        t = self.layer_thickness
        return t[min(layer, len(t) - 1)] if isinstance(t, Sequence) else t

    def as_dict(self) -> dict[str, Any]:
        """Plain values as used, in the form of a process file, for echoing in outputs."""
        out = {name: as_written(getattr(self, name)) for name in TOP}
        for group, values in self.assumed().items():
            out[group] |= values
        out["rules"] = [rule.as_dict() for rule in self.rules]
        return out

    def updated(self, **changes: Any) -> Process:
        """A copy with some parameters changed; of a group, those that a dict names: updated(fill={"contours": 2})."""
        for name, value in changes.items():
            if name in GROUPS and isinstance(value, Mapping):
                group = getattr(self, name)
                changes[name] = GROUPS[name](**{key: getattr(group, key) for key in declarations_of(group)} | dict(value))
        return replace(self, **changes)


TOP = ("layer_thickness", "step_over", *GROUPS, "rules")


def _or(given: float | None, otherwise: float) -> float:
    return otherwise if given is None else given
