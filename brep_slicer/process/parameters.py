"""The process parameters of a plan, checked once, with what was assumed kept apart from what was given.

In: numbers from Python, the command line or a TOML file. Out: a frozen Process.

Words: *layer thickness* t, *step-over* d (bead centre to bead centre), *bead width* w, *inset* (how far inside of the
outline a bead's centre stays), *clearance* (nozzle above what stands in its way), *hop* (a short travel that stays low).
"""

from __future__ import annotations

import enum
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, Literal

from brep_slicer.errors import InputError
from brep_slicer.wording import shortened

from .rules import Rule, as_rule
from .taken import Taken, default
from .values import (
    CutAt,
    Fit,
    InnerPattern,
    LastLayer,
    Order,
    PatternName,
    as_written,
    check_names,
    check_radii,
    choice,
    finite,
    listed,
    positive,
    speed,
    switch,
    whole,
)

# The paper's Table 3: laser spot 4.9 mm at a step-over of 3.4 mm, and a tool-head speed of 9 mm/s.
WIDTH_PER_STEP_OVER = 1.44
DEPOSITION_SPEED_MM_S = 9.0
# Sampled finer than this (mm) a toolpath would only grow: machines resolve a thousandth.
FINEST_CHORD = 1e-6
# What the machine's nozzle keeps clear of, mm, however small the part.
CLEARANCE = 5.0
# The chord (mm) that is assumed for step-overs of so many mm and more. Finer beads build smaller parts, which may be no larger
# than a chord of ordinary ones.
CHORD, ORDINARY_STEP_OVER = 0.01, 1.0
# No outermost bead runs farther outside of the outline than so many bead widths: a slip of the sign, or of the unit.
MOST_OUTSIDE = 5.0

# No bead is laid more times slower or faster than the deposition speed than this: a slip of the unit.
MOST_TIMES = 1e3


@dataclass(frozen=True, slots=True, kw_only=True)
class Process:
    """How to deposit. Lengths in mm, angles in degrees, speeds in mm/s; `layer_thickness` and `step_over` are required.

    Parameters
    ----------
    layer_thickness : float or sequence of float
        t, one for all layers or one for each.
    step_over : float
        d, between the centres of neighbouring beads.
    bead_width : float, optional
        w; 1.44 d if not given (the paper's 4.9 / 3.4).
    pattern : InnerPattern
        What fills the inside: auto (hatch where a piece has room for three lines side by side, stretched by a quarter of d at
        most; contours and skeletons where it has not), hatch, zigzag (continuous), flank (along the piece's long edges),
        contours (as many as fit), spiral, skeleton (one bead along the middle), rings or helix (full turns). Contours and
        spirals are followed by skeleton beads where they leave the metal bare.
    contours_outwards : bool
        The innermost contour is laid first.
    starts : int
        How many helices run side by side (pattern helix).
    left_handed : bool
        Helices are left-handed.
    closing_rings : bool
        A ring along either edge of a band that a helix clads.
    start_angle_deg : float, optional
        Where on its lower edge a helix begins, theta in the axis frame, degrees; where the part's shape says if not given.
    hatch_angles_deg : float or sequence of float
        Angle of layer i is hatch_angles_deg[i modulo their number], plus i * hatch_angle_step_deg; degrees, counter-clockwise
        from +kappa.
    inset : float, optional
        Distance of the outermost bead centres from the outline (outwards if negative); by `fit` if not given.
    fit : Fit
        Outermost bead centres half a bead inside of the outline, on it, or half a bead outside.
    allowance : float
        Machining allowance a, mm: the part is grown by a along its normals, a / sqrt(1 - (n . e_rho)**2) sideways in a layer
        and by layers on top.
    overlap : float, optional
        How much farther than a step-over from the last contour's centre hatch lines reach; if not given, each line ends where
        it neither piles up on the contour nor leaves anything bare, by the angle at which it meets it.
    balance : bool
        The beads of each piece are laid slower or faster, between `slowest` and `fastest` times the deposition speed, so that
        they hold the metal that the piece has; else all at the deposition speed.
    speed_follows_spacing : bool
        Beads that come nearer to their neighbours are laid faster, so that the height stays t; between `slowest` and `fastest`
        times the deposition speed.
    stretch : float
        By what share of d hatch spacings may differ from it so that a piece's width is filled exactly; 0: not at all.
    contours_every : int
        Contours on every so many layers only, against slumping edges: 1 on all of them.
    alternate : bool
        Every second layer is laid backwards, last bead first.
    by_feature : bool
        Each feature (a tooth: pieces that stay connected from layer to layer) is built whole before the next one.
    rest_s : float
        No bead starts beside one that ended less than this many seconds ago, as far as an order can do it; the notes say where
        it cannot.
    spread_starts : bool
        Closed beads start at other places from ring to ring and layer to layer.
    closing_overlap : float
        How far closed beads go on over their own start, mm.
    lead_in, lead_out : float
        The nozzle runs this far straight towards a bead's start and on from its end at deposition speed, laser off, mm.
    laser_on_delay, laser_off_delay : float
        The laser is switched on this long before a bead's start, and off this long before its end, mm: metal comes late.
    contour_speed_mm_s : float, optional
        Speed of contours; the deposition speed if not given.
    clearance : float, optional
        The nozzle's, mm; 5 mm if not given, two layers at least.
    hop_length : float, optional
        Longest travel that stays low, mm; 3 d if not given.
    chord : float, optional
        Tolerance of sampled curves, mm; 0.01 mm if not given (d / 100 for step-overs below 1 mm).
    order : Order
        Beads in one that shortens travels (piece by piece, in each one kind of beads after the other), or in the pattern's.
    last_layer : LastLayer
        What becomes of a last layer that the height does not fill: auto keeps it if the part fills a twentieth of it at least
        (and its end is known so well); keep, drop, or stretch all layers to fit.
    cut_at : CutAt
        Cut at the layer's lower radius R_i, or at mid-thickness.
    rules : sequence of Rule or dict
        Other fill parameters for some layers and pieces; of several that hold, the first. A dict is as a table of a process
        file, dict(layers="0:3", contours=2).

    Raises
    ------
    InputError
        If a value is missing, not finite or out of its range; the message names it.
    """

    layer_thickness: float | Sequence[float]
    step_over: float
    radii: Taken[tuple[float, ...] | None, Sequence[float] | None] = default(None)
    bead_width: float | None = None
    inset: float | None = None
    fit: Taken[Fit, Fit | Literal["in", "on", "out"]] = default(Fit.IN)
    allowance: float = 0.0
    overlap: float | None = None
    stretch: float = 0.0
    contours_every: int = 1
    alternate: bool = False
    by_feature: bool = False
    rest_s: float = 0.0
    spread_starts: bool = False
    closing_overlap: float = 0.0
    lead_in: float = 0.0
    lead_out: float = 0.0
    laser_on_delay: float = 0.0
    laser_off_delay: float = 0.0
    contour_speed_mm_s: float | None = None
    order: Taken[Order, Order | Literal["pattern", "shortest"]] = default(Order.SHORTEST)
    contours: int = 0
    hatch: bool = True
    pattern: Taken[InnerPattern, InnerPattern | PatternName] = default(InnerPattern.AUTO)
    hatch_angles_deg: Taken[tuple[float, ...], float | Sequence[float]] = default((0.0,))
    hatch_angle_step_deg: float = 0.0
    both_ways: bool = True
    contours_outwards: bool = False
    starts: int = 1
    left_handed: bool = False
    closing_rings: bool = False
    start_angle_deg: float | None = None
    balance: bool = True
    speed_follows_spacing: bool = False
    slowest: float = 0.5
    fastest: float = 2.0
    shortest_bead: float | None = None
    deposition_speed_mm_s: float | None = None
    travel_speed_mm_s: float | None = None
    clearance: float | None = None
    hop_length: float | None = None
    chord: float | None = None
    powder_feed_g_s: float | None = None
    powder_density_g_cm3: float | None = None
    laser_power_w: float | None = None
    last_layer: Taken[LastLayer, LastLayer | Literal["auto", "keep", "drop", "stretch"]] = default(LastLayer.AUTO)
    cut_at: Taken[CutAt, CutAt | Literal["bottom", "middle"]] = default(CutAt.BOTTOM)
    rules: Taken[tuple[Rule, ...], Sequence[Rule | Mapping[str, Any]] | Rule | Mapping[str, Any]] = default(())

    def __new__(cls, *args: Any, **given: Any) -> Process:
        """Names that no parameter has are told of with the nearest that one has."""
        check_names(given, [f.name for f in fields(cls)], "process parameter")
        return object.__new__(cls)

    def __repr__(self) -> str:
        usual = {f.name: f.default for f in fields(self)}
        given = [f"{n}={as_written(n, getattr(self, n))!r}" for n in usual if getattr(self, n) != usual[n]]
        return f"Process({shortened(', '.join(given), 180)})"

    def __post_init__(self) -> None:
        for name, kind in CHOICES.items():
            object.__setattr__(self, name, choice(name, getattr(self, name), kind))
        for name in WHOLE:
            object.__setattr__(self, name, whole(name, getattr(self, name)))
        for name in SWITCHES:
            switch(name, getattr(self, name))
        finite("hatch_angle_step_deg", self.hatch_angle_step_deg)
        thicknesses = tuple(positive("layer_thickness", t) for t in listed("layer_thickness", self.layer_thickness))
        several = isinstance(self.layer_thickness, Iterable)
        object.__setattr__(self, "layer_thickness", thicknesses if several else thicknesses[0])
        object.__setattr__(self, "step_over", positive("step_over", self.step_over))
        for name in POSITIVE_OPTIONS:
            value = getattr(self, name)
            if value is not None:
                object.__setattr__(self, name, (speed if name in SPEEDS else positive)(name, value))
        self._check_lengths()
        for name in NOT_NEGATIVE:
            value = getattr(self, name)
            if value is not None and not (finite(name, value) >= 0.0):
                raise InputError(f"{name} is {value:g}; it must be zero or more")
        if not 0.0 < finite("slowest", self.slowest) <= 1.0 <= finite("fastest", self.fastest):
            raise InputError(f"slowest and fastest are {self.slowest:g} and {self.fastest:g}; 1 must lie between them")
        if self.slowest < 1.0 / MOST_TIMES or self.fastest > MOST_TIMES:
            raise InputError(
                f"slowest and fastest are {self.slowest:g} and {self.fastest:g}; a bead may be {MOST_TIMES:g} times slower or"
                " faster than the deposition speed at most"
            )
        if not 0.0 <= finite("stretch", self.stretch) < 0.5:
            raise InputError(f"stretch is {self.stretch:g}; it must be at least 0 and less than 0.5 (a share of the step-over)")
        self._check_counts()
        if self.radii is not None:
            object.__setattr__(self, "radii", check_radii(self.radii))
        angles = listed("hatch_angles_deg", self.hatch_angles_deg)
        object.__setattr__(self, "hatch_angles_deg", tuple(finite("hatch_angles_deg", a) for a in angles))
        object.__setattr__(self, "rules", self._checked_rules())
        if self.catchment is not None and self.catchment > 1.0:
            raise InputError(
                f"the beads need {self.catchment:.4g} times the powder that is fed (t d speed density / feed may be 1 at most);"
                " feed more, or deposit slower or thinner"
            )

    def _checked_rules(self) -> tuple[Rule, ...]:
        """The rules with their changes checked as the process's own parameters are."""
        given: Any = self.rules
        alone = isinstance(given, Rule | Mapping | str) or not isinstance(given, Iterable)
        out = []
        for rule in map(as_rule, (given,) if alone else given):
            try:
                changed = replace(self, rules=(), **rule.changes)
            except InputError as error:
                raise InputError(f"in a rule: {error}") from None
            out.append(replace(rule, changes={name: getattr(changed, name) for name in rule.changes}))
        return tuple(out)

    def _check_lengths(self) -> None:
        if self.inset is not None:
            object.__setattr__(self, "inset", finite("inset", self.inset))
            if self.inset < -MOST_OUTSIDE * self.width:
                raise InputError(
                    f"inset is {self.inset:g} mm; the outermost beads would run {-self.inset / self.width:.3g} bead widths"
                    f" outside of the part ({MOST_OUTSIDE:g} at most)"
                )
        if self.chord is not None and self.chord < FINEST_CHORD:
            raise InputError(f"chord is {self.chord:g} mm; the finest is {FINEST_CHORD:g} mm")

    def _check_counts(self) -> None:
        for name in ("contours_every", "starts"):
            if getattr(self, name) < 1:
                raise InputError(f"{name} is {getattr(self, name)}; it must be 1 or more")
        if self.start_angle_deg is not None:
            finite("start_angle_deg", self.start_angle_deg)
        if self.contours < 0:
            raise InputError(f"contours is {self.contours}; it must be zero or more")
        if self.contours == 0 and not self.hatch:
            raise InputError("neither contours nor hatch is asked for; nothing would be deposited")

    @property
    def catchment(self) -> float | None:
        """eta = t d speed density / powder feed: the share of the powder that becomes metal; None without feed and density.

        The metal balance of the paper (its Table 3 gives 0.86 with 7.99 g/cm**3); of the thickest layer if they differ.
        """
        if self.powder_feed_g_s is None or self.powder_density_g_cm3 is None:
            return None
        t = max(self.layer_thickness) if isinstance(self.layer_thickness, Sequence) else self.layer_thickness
        mm3_per_s = t * self.step_over * float(self.value("deposition_speed_mm_s"))
        return mm3_per_s * 1e-3 * self.powder_density_g_cm3 / self.powder_feed_g_s

    @property
    def width(self) -> float:
        """Bead width w in mm, given or assumed."""
        return WIDTH_PER_STEP_OVER * self.step_over if self.bead_width is None else self.bead_width

    def value(self, name: str) -> Any:
        """A parameter as it is used: given, or its default (see `assumed`)."""
        given = getattr(self, name)
        return self.defaults()[name] if given is None and name in self.defaults() else given

    def defaults(self) -> dict[str, Any]:
        """What is assumed where nothing is given.

        The chord is that of ordinary step-overs, 1 mm and more, and in proportion to a finer one; the hop length is three
        step-overs throughout, the clearance the machine's.
        """
        fine = min(1.0, self.step_over / ORDINARY_STEP_OVER)
        first = self.thickness(0)
        return {
            "bead_width": WIDTH_PER_STEP_OVER * self.step_over,
            "inset": {Fit.IN: 0.5, Fit.ON: 0.0, Fit.OUT: -0.5}[self.fit] * self.width,
            "shortest_bead": 0.0,
            "deposition_speed_mm_s": DEPOSITION_SPEED_MM_S,
            "travel_speed_mm_s": 50.0,
            "clearance": max(CLEARANCE, 2.0 * first),
            "hop_length": 3.0 * self.step_over,
            "chord": max(CHORD * fine, FINEST_CHORD),
        }

    def assumed(self) -> dict[str, Any]:
        """The defaults in force, by name: reports name them as assumed."""
        return {name: value for name, value in self.defaults().items() if getattr(self, name) is None}

    def hatch_angle(self, layer: int) -> float:
        """Angle asked for layer `layer`, rad."""
        angles = self.hatch_angles_deg
        return math.radians(angles[layer % len(angles)] + layer * self.hatch_angle_step_deg)

    @property
    def start_angle(self) -> float | None:
        """Where a helix begins, rad; None if it is not given."""
        return None if self.start_angle_deg is None else math.radians(self.start_angle_deg)

    def thickness(self, layer: int) -> float:
        """Thickness asked for layer `layer`, mm; the last of a list holds on."""
        t = self.layer_thickness
        return t[min(layer, len(t) - 1)] if isinstance(t, Sequence) else t

    def as_dict(self) -> dict[str, Any]:
        """Plain values as used, for echoing in outputs."""
        return {f.name: as_written(f.name, self.value(f.name)) for f in fields(self)}

    def updated(self, **changes: Any) -> Process:
        """A copy with some parameters changed."""
        return replace(self, **changes)


CHOICES: dict[str, type[enum.Enum]] = {
    "last_layer": LastLayer,
    "cut_at": CutAt,
    "pattern": InnerPattern,
    "fit": Fit,
    "order": Order,
}
SWITCHES = tuple(f.name for f in fields(Process) if f.type == "bool")
SPEEDS = ("contour_speed_mm_s", "deposition_speed_mm_s", "travel_speed_mm_s")
WHOLE = ("contours", "contours_every", "starts")
NOT_NEGATIVE = (
    "overlap",
    "shortest_bead",
    "hop_length",
    "closing_overlap",
    "allowance",
    "lead_in",
    "lead_out",
    "rest_s",
    "laser_on_delay",
    "laser_off_delay",
)
POSITIVE_OPTIONS = (
    "contour_speed_mm_s",
    "bead_width",
    "deposition_speed_mm_s",
    "travel_speed_mm_s",
    "clearance",
    "chord",
    "powder_feed_g_s",
    "powder_density_g_cm3",
    "laser_power_w",
)
