"""The groups of a process, a table each in its file: layers, fill, motion, laser, powder.

In: numbers from Python, the command line or a TOML file. Out: frozen values, checked one by one; what goes together is the
process's to check.

Words: *layer thickness* t, *step-over* d (bead centre to bead centre), *bead width* w, *inset* (how far inside of the
outline a bead's centre stays), *clearance* (nozzle above what stands in its way), *hop* (a short travel that stays low).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Literal

from brep_slicer.errors import InputError

from .former import RENAMED
from .parameter import Declared, declarations_of, parameter
from .patterns import as_pattern
from .taken import Taken
from .values import CutAt, LastLayer, Order, OutlinePosition, check_radii

if TYPE_CHECKING:
    from brep_slicer.fill import Pattern

# Sampled finer than this (mm) a toolpath would only grow: machines resolve a thousandth.
FINEST_CHORD = 1e-6
# No bead is laid more times slower or faster than the deposition speed than this: a slip of the unit.
MOST_TIMES = 1e3


class Group(Declared):
    """Base of the groups; each has a `title` that the command's help shows its options under."""

    __slots__ = ()

    table: ClassVar[str] = ""
    title: ClassVar[str] = ""

    @classmethod
    def _in_words(cls) -> str:
        return f"{cls.table} (the table [{cls.table}] of a process file)"

    @classmethod
    def _elsewhere(cls, given: Iterable[str]) -> Mapping[str, str]:
        return where_it_stands(without=cls.table)


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class Layers(Group):
    """Where the layers lie."""

    table: ClassVar[str] = "layers"
    title: ClassVar[str] = "Layers"

    radii: Taken[tuple[float, ...] | None, Sequence[float] | None] = parameter(
        None,
        unit="mm",
        many=True,
        above=0.0,
        help="Radii of the layers, increasing",
        example=[50.0, 51.4, 52.8],
        assumed="by the layer thickness",
        options=("--radii",),
        check=lambda _, radii: check_radii(radii),
    )
    allowance: float = parameter(
        0.0,
        unit="mm",
        least=0.0,
        help="Machining allowance: the part is grown by so much all over, sideways in a layer and by layers on top",
    )
    last_layer: Taken[LastLayer, LastLayer | Literal["auto", "keep", "drop", "stretch"]] = parameter(
        LastLayer.AUTO,
        help="What becomes of a last layer that the height does not fill: kept unless a sliver, kept, dropped, or all"
        " layers stretched",
    )
    cut_at: Taken[CutAt, CutAt | Literal["bottom", "middle"]] = parameter(
        CutAt.BOTTOM, help="Where in its thickness a layer is cut"
    )


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class Fill(Group):
    """How layers are filled with beads."""

    table: ClassVar[str] = "fill"
    title: ClassVar[str] = "Beads"

    pattern: Taken[Pattern, Pattern | str | Mapping[str, Any]] = parameter(
        "auto", kind="pattern", by_piece=True, check=as_pattern, help="What fills a layer inside of its contours"
    )
    contours: int = parameter(0, least=0, by_piece=True, help="Beads along the outline, before the pattern")
    contours_every: int = parameter(1, least=1, help="Contours on every so many layers only, against slumping edges")
    contours_outwards: bool = parameter(False, by_piece=True, help="The innermost contour is laid first")
    overlap: float | None = parameter(
        None,
        unit="mm",
        least=0.0,
        by_piece=True,
        example=1.9,
        assumed="by the angle at which each line meets the contour",
        help="How much farther than a step-over from the last contour's centre the pattern's beads reach",
    )
    bead_width: float | None = parameter(
        None, unit="mm", above=0.0, assumed="1.44 d", options=("-w", "--bead-width"), help="Bead width w"
    )
    outline_position: Taken[OutlinePosition, OutlinePosition | Literal["in", "on", "out"]] = parameter(
        OutlinePosition.IN, help="Outermost bead centres half a bead inside of the outline, on it, or half a bead outside"
    )
    inset: float | None = parameter(
        None,
        unit="mm",
        assumed="by the outline position",
        help="Distance of the outermost bead centres from the outline, outwards if negative",
    )
    shortest_bead: float = parameter(0.0, unit="mm", least=0.0, help="Shorter beads are left out")
    order: Taken[Order, Order | Literal["pattern", "shortest"]] = parameter(
        Order.SHORTEST,
        help="Beads in an order that shortens travels (piece by piece, one kind of beads after the other), or in the pattern's",
    )
    alternate: bool = parameter(False, help="Every second layer is laid backwards, last bead first")
    by_feature: bool = parameter(
        False, help="Each feature (a tooth: pieces that stay connected from layer to layer) is built whole before the next one"
    )
    min_interpass_time_s: float = parameter(
        0.0,
        unit="s",
        least=0.0,
        help="No bead starts beside one that ended less than so long ago, as far as an order can do it; notes say where not",
    )
    spread_starts: bool = parameter(False, help="Closed beads start at other places from ring to ring and layer to layer")
    closing_overlap: float = parameter(0.0, unit="mm", least=0.0, help="How far closed beads go on over their own start")
    balance: bool = parameter(
        True, help="Beads are laid slower or faster so that those of each piece hold the metal that it has"
    )
    adaptive_speed: bool = parameter(
        False, help="Beads that come nearer to their neighbours are laid faster, so that the height stays t"
    )
    slowest: float = parameter(
        0.5, least=1.0 / MOST_TIMES, most=1.0, help="Balance and adaptive speed: so many times the deposition speed at least"
    )
    fastest: float = parameter(
        2.0, least=1.0, most=MOST_TIMES, help="Balance and adaptive speed: so many times the deposition speed at most"
    )


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class Motion(Group):
    """How the nozzle moves."""

    table: ClassVar[str] = "motion"
    title: ClassVar[str] = "Motion"

    deposition_speed_mm_s: float | None = parameter(
        None, unit="mm/s", assumed="9", options=("--speed", "--deposition-speed"), help="Deposition speed"
    )
    contour_speed_mm_s: float | None = parameter(
        None, unit="mm/s", example=7.0, assumed="the deposition speed", help="Speed of contours"
    )
    travel_speed_mm_s: float | None = parameter(None, unit="mm/s", assumed="50", help="Speed of travels, laser off")
    clearance: float | None = parameter(
        None, unit="mm", above=0.0, assumed="5, two layers at least", help="Nozzle above what stands in a travel's way"
    )
    hop_length: float | None = parameter(None, unit="mm", least=0.0, assumed="3 d", help="Longest travel that stays low")
    lead_in: float = parameter(
        0.0, unit="mm", least=0.0, help="The nozzle runs so far straight towards a bead's start at deposition speed, laser off"
    )
    lead_out: float = parameter(
        0.0, unit="mm", least=0.0, help="The nozzle runs so far straight on from a bead's end at deposition speed, laser off"
    )
    chord: float | None = parameter(
        None, unit="mm", least=FINEST_CHORD, assumed="0.01, or d / 100 for d below 1", help="Tolerance of sampled curves"
    )


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class Laser(Group):
    """The laser."""

    table: ClassVar[str] = "laser"
    title: ClassVar[str] = "Laser"

    power_w: float | None = parameter(
        None,
        unit="W",
        above=0.0,
        example=1500.0,
        assumed="not known",
        options=("--laser-power",),
        help="Laser power, as the report has it",
    )
    on_delay: float = parameter(
        0.0,
        unit="mm",
        least=0.0,
        options=("--laser-on-delay",),
        help="The laser is switched on so long before a bead's start: metal comes late",
    )
    off_delay: float = parameter(
        0.0, unit="mm", least=0.0, options=("--laser-off-delay",), help="The laser is switched off so long before a bead's end"
    )


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class Powder(Group):
    """The powder."""

    table: ClassVar[str] = "powder"
    title: ClassVar[str] = "Powder"

    feed_g_s: float | None = parameter(
        None, unit="g/s", above=0.0, example=0.4, assumed="not known", options=("--powder-feed",), help="Powder that is fed"
    )
    density_g_cm3: float | None = parameter(
        None,
        unit="g/cm3",
        above=0.0,
        example=7.99,
        assumed="not known",
        options=("--powder-density",),
        help="Density of the metal",
    )


GROUPS: dict[str, type[Group]] = {group.table: group for group in (Layers, Fill, Motion, Laser, Powder)}


def where_it_stands(*, without: str = "") -> Mapping[str, str]:
    """For every parameter of a group but one, and every former name, where it stands now."""
    out = dict(RENAMED)
    for table, group in GROUPS.items():
        for name in declarations_of(group) if table != without else ():
            out[name] = f"it stands in the table [{table}] (in Python {table}={group.__name__}({name}=...))"
    for name in ("layer_thickness", "step_over") if without else ():
        out[name] = "it stands at the top of the file, above all tables (in Python in Process itself)"
    return out


def as_group(name: str, value: Any) -> Any:
    """A group from itself or from a table; None is one with nothing given.

    Raises
    ------
    InputError
        If it is neither, or holds what the group does not have.
    """
    kind = GROUPS[name]
    if isinstance(value, kind):
        return value
    if value is not None and not isinstance(value, Mapping):
        raise InputError(f"{name} is {value!r}; give a table, [{name}] in a file (in Python a {kind.__name__} or a dict)")
    return kind(**{key: given for key, given in (value or {}).items() if given is not None})
