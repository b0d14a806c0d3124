"""Which cylinder is built on, of those that a part has.

In: a Survey and the part's lands. Out: the Ground chosen, the rule in words, what is doubtful, the runner-up.

A cylinder explains a part well when what lies inside of it is a turned body, when what lies beyond it stands on it, and when
there is enough of it at one place. In this order:

1. Lands that another solid lies on come first: there somebody has drawn what is to be built as a solid of its own. What is laid
   so on a smaller land, and lies wholly inside of a larger one, would be lost on that: it goes after those that lose less so.
2. What building on it would leave out (teeth, thread and lobes inside of it, what beyond it is carried by something else) may
   be at most LEFT_OUT of the part more than with the land that leaves out least.
3. Outside lands come before bores: a shaft that fills a bore is not in the file.
4. A land that does not go round at one place, together with what stands on it, and has not even a tenth of the area of the
   largest, is the top of a lug or of a flange.
5. A land that leaves something out gives way to one that leaves less out, if that has twice its area (collars and oil slingers
   stand on the shaft that webs stand on), or if what it saves is a good share of the turned metal that has to be built for it
   (a cam's base circle, for the boss beside it; a fan's hub, for the ring that hangs on its struts; not the thin end of a
   shaft, for a finger on it).
6. A land that carries turned metal only, as a collar another collar, gives way to one inside of it with twice its area.
7. Of what is left, the largest: the less is built the better.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from brep_slicer.groups import groups_of_pairs

from .ground import Ground
from .lands import Land, beyond
from .survey import Survey

# Of the part's metal: less than this is within what facets and rays know, and what a keyway or a hole takes.
LEFT_OUT = 0.06
# Metal left out is told of from this share of the part on; an area is much larger from so many times on.
TOLD, MUCH_LARGER = 0.02, 2.0
# A land leaves less out than another when it saves what is told of, or this share of what the other leaves out.
LESS = 0.5
# Metal that another land saves is worth building on it when it is this share of what has to be built besides.
WORTH = 0.2
# A land that does not go round at one place and has less than this share of the largest one's area there is a detail.
SMALL_PLACE = 0.1
# Another solid lies on a land when the metal beyond is at least this share of all, and bores count likewise.
LEAST_METAL = 1e-4


@dataclass(frozen=True, slots=True, kw_only=True)
class Choice:
    """The `ground` to build on, the `rule` that it was chosen by, the `runner_up` if there is one; whether any metal is
    `carried` by it, or only lies beyond it."""

    ground: Ground
    rule: str
    runner_up: Ground | None
    carried: bool


def chosen_ground(survey: Survey, lands: Sequence[Land], highest: float) -> Choice | None:
    """The land that explains the part best; None if none has metal beyond it."""
    grounds = [ground_of(survey, land) for land in lands if highest > land.candidate.radius + beyond(land.candidate.radius)]
    carrying = [g for g in grounds if g.volume(g.carried) >= LEAST_METAL * survey.volume]
    outside = [g for g in grounds if g.external]
    if not carrying:
        # nothing that faces show stands on anything: the largest with metal beyond, and a doubt
        fallback = outside or grounds
        if not fallback:
            return None
        rule = f"largest {'external coaxial cylinder' if outside else 'coaxial bore'} with metal beyond it"
        return Choice(ground=fallback[0], rule=rule, runner_up=fallback[1] if len(fallback) > 1 else None, carried=False)
    covered = [g for g in carrying if g.external and g.volume(g.covers) >= LEAST_METAL * survey.volume]
    laid = [_laid_inside(g, covered) for g in covered]
    pool = [g for g, lost in zip(covered, laid, strict=True) if lost <= min(laid) + LEAST_METAL * survey.volume] or carrying
    least = min(g.left_out for g in pool)
    good = [g for g in pool if g.left_out <= least + LEFT_OUT * survey.volume]
    kind = [g for g in good if g.external] or good
    most = max(_best_place(g)[0] for g in kind)
    sound = [g for g in kind if _best_place(g)[1] or _best_place(g)[0] >= SMALL_PLACE * most]
    best = max((g for g in sound if not _gives_way(g, sound, survey.volume)), key=lambda g: g.radius)
    others = [g for g in carrying if g is not best]
    second = max((g for g in others if g in sound), key=lambda g: g.radius, default=None)
    second = second or min(others, key=lambda g: (not g.external, g.left_out), default=None)
    return Choice(ground=best, rule=_rule(best, carrying, covered), runner_up=second, carried=True)


def ground_of(survey: Survey, land: Land) -> Ground:
    """What building on a land would mean."""
    return Ground(survey=survey, radius=land.candidate.radius, faces=land.faces, external=land.candidate.external)


def _laid_inside(ground: Ground, covered: Sequence[Ground]) -> float:
    """mm**3 of solids that are laid on a smaller land, and with what touches them lie inside of this one."""
    survey, s = ground.survey, ground.survey.stretches
    count = len(survey.touching)
    out = np.zeros(len(s.ray), dtype=bool)
    for other in covered:
        if other.radius >= ground.radius:
            continue
        # without the owners of the smaller land, so that what hangs together does so by itself
        loose = survey.touching.copy()
        loose[[place for place, _ in other.faces]] = False
        loose &= loose.T
        group = groups_of_pairs(count, np.argwhere(loose))
        beyond_it = np.isin(s.solid, [place for place, _ in ground.faces]) | (s.end > ground.radius + beyond(ground.radius))
        far = np.isin(group, group[np.unique(s.solid[beyond_it])])
        laid = np.isin(group, group[np.unique(s.solid[other.covers])])
        out |= (laid & ~far)[s.solid]
    metal = s.chosen(out)
    return float(metal.volumes(survey.weights).sum())


def _gives_way(ground: Ground, others: list[Ground], volume: float) -> bool:
    """Whether another land is to be preferred to one that is larger or leaves more out."""
    if not ground.external:
        return False
    for other in others:
        much_larger = _best_place(other)[0] >= MUCH_LARGER * _best_place(ground)[0]
        saved = ground.left_out - other.left_out
        less = ground.left_out >= TOLD * volume and saved >= min(TOLD * volume, LESS * ground.left_out)
        if less and (much_larger or saved >= WORTH * other.stock(ground.radius)):
            return True
        shaft = other.radius < ground.radius and saved >= 0.0 and _area(other) >= MUCH_LARGER * _area(ground)
        if shaft and ground.turned_only and not ground.covers.any():
            return True
    return False


def _area(ground: Ground) -> float:
    """mm**2 of land, and feet beside it, at all places: of a shaft on both sides of a collar."""
    return sum(area for area, _ in ground.places)


def _best_place(ground: Ground) -> tuple[float, bool]:
    """The largest area (mm**2) of land and feet at one place, and whether the land goes round at any."""
    return max(area for area, _ in ground.places), any(goes_round for _, goes_round in ground.places)


def _rule(best: Ground, carrying: list[Ground], covered: list[Ground]) -> str:
    same = [g for g in carrying if g.external == best.external]
    largest = best is max(same, key=lambda g: g.radius)
    if not best.external:
        return "largest coaxial bore" if largest else "the coaxial bore that leaves the least of the part out"
    if largest:
        return "largest external coaxial cylinder that metal stands on"
    if best in covered:
        return "largest external coaxial cylinder that another solid lies on"
    return "external coaxial cylinder that explains the part best"
