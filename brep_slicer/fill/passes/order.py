"""Beads of a layer in an order, and run in directions, that make travels short.

In: beads. Out: the same beads, some reversed. Greedy from the first one, then 2-opt and or-opt until nothing gets shorter.

A travel is the geodesic from a bead's end to the next one's start, round the shaft the shorter way. Reversing a stretch of the
order reverses its beads too, so only its two ends change.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from brep_slicer.layers import Closure
from brep_slicer.maps import Array

from ..bead import Bead, BeadKind

# Stretches up to this many beads are moved elsewhere as a whole.
LONGEST_MOVE = 3
# Orders of more stretches than this are not improved any further: the effort grows with the cube of their number.
MOST_IMPROVED = 80
# An improvement smaller than this (mm) is none.
LEAST = 1e-9
# A bead's number, and whether it is run backwards.
Order = list[tuple[int, bool]]


def in_short_order(beads: Sequence[Bead], closure: Closure, *, turned: bool = True) -> tuple[Bead, ...]:
    """The beads reordered for short travels on a sheet with this closure; the first bead stays first.

    Without `turned`, all beads are run the way they are.
    """
    if len(beads) < 3:
        return tuple(beads)
    ends = _ends_of(beads)
    free = np.full(len(beads), turned)
    order = _greedy(ends, closure, free)
    if turned:
        order = _improved(ends, order, closure)
    return tuple(_in_order(beads, order))


def in_short_order_by_pieces(
    beads: Sequence[Bead], closure: Closure, *, reach: float, turned: bool = True, copies: Sequence[int] = ()
) -> tuple[Bead, ...]:
    """A layer's beads reordered: piece by piece, in each one kind after the other as its pattern has them.

    Beads that follow one another within `reach` (mm) in the pattern's own order stay together, as the lines of a hatch do. A
    piece that has one kind of beads only may be laid backwards, if they may be `turned`. Of equal pieces the order is looked
    for once; `copies` holds for each the number of the first one.
    """
    if len(beads) < 3:
        return tuple(beads)
    stages: dict[int, dict[BeadKind, list[Bead]]] = {}
    for bead in beads:
        stages.setdefault(bead.piece, {}).setdefault(bead.kind, []).append(bead)
    chains: list[list[Bead]] = []
    free = []
    found: dict[tuple[int, BeadKind, int], Order] = {}
    for piece, kinds in stages.items():
        chain: list[Bead] = []
        for kind, mine in kinds.items():
            same = (copies[piece] if copies else piece, kind, len(mine))
            if same not in found:
                found[same] = _of_one_kind(mine, chain[-1] if chain else None, closure, reach, turned)
            chain += _in_order(mine, found[same])
        chains.append(chain)
        free.append(turned and len(kinds) == 1)
    ends = np.array([[chain[0].points[0], chain[-1].points[-1]] for chain in chains])
    order = _greedy(ends, closure, np.array(free))
    if all(free) and len(order) <= MOST_IMPROVED:
        order = _improved(ends, order, closure)
    return tuple(b for i, back in order for b in (_backwards(chains[i]) if back else chains[i]))


def _of_one_kind(beads: list[Bead], before: Bead | None, closure: Closure, reach: float, turned: bool) -> Order:
    """The order of beads of one kind in one piece, from the end of the bead `before` on."""
    ends = _ends_of(beads)
    # where the next bead starts beside this one's end, as in a hatch both ways, the two are one
    near = closure.distances(ends[:-1, 1], ends[1:, 0]) <= reach
    runs = np.split(np.arange(len(beads)), np.flatnonzero(~near) + 1)
    if len(runs) == 1 and before is None:
        return [(i, False) for i in range(len(beads))]
    outer = np.array([[ends[run[0], 0], ends[run[-1], 1]] for run in runs])
    if before is not None:
        # the bead before stands first, as a run of no length
        outer = np.concatenate([np.tile(before.points[-1], (1, 2, 1)), outer])
    order = _greedy(outer, closure, np.full(len(outer), turned))
    if turned and 2 < len(order) <= MOST_IMPROVED:
        order = _improved(outer, order, closure)
    skip = 0 if before is None else 1
    out: Order = []
    for i, back in order[skip:]:
        run = runs[i - skip].tolist()
        out += [(k, back) for k in (run[::-1] if back else run)]
    return out


def _in_order(beads: Sequence[Bead], order: Order) -> list[Bead]:
    return [beads[i].reversed() if back else beads[i] for i, back in order]


def _backwards(chain: list[Bead]) -> list[Bead]:
    return [bead.reversed() for bead in reversed(chain)]


def _ends_of(beads: Sequence[Bead]) -> Array:
    return np.array([[bead.points[0], bead.points[-1]] for bead in beads])


def _improved(ends: Array, order: Order, closure: Closure) -> Order:
    """2-opt and or-opt until nothing gets shorter."""
    while True:
        before = travel_of(ends, order, closure)
        order = _moved(ends, _two_opt(ends, order, closure), closure)
        if travel_of(ends, order, closure) > before - LEAST:
            return order


def travel_of(ends: Array, order: Order, closure: Closure) -> float:
    """Length of all travels between beads with the `ends` (n, 2, 2) in an order, mm."""
    starts, stops = _run(ends, order)
    return float(closure.distances(stops[:-1], starts[1:]).sum())


def _run(ends: Array, order: Order) -> tuple[Array, Array]:
    index, back = np.array([i for i, _ in order]), np.array([b for _, b in order], dtype=int)
    return ends[index, back], ends[index, 1 - back]


def _greedy(ends: Array, closure: Closure, free: Array) -> Order:
    """The nearest one next, from the first on; those that are not `free` (n,) run forwards only."""
    left = np.ones(len(ends), dtype=bool)
    left[0] = False
    order, here = [(0, False)], ends[0, 1]
    barred = np.where(free, 0.0, np.inf)
    for _ in range(len(ends) - 1):
        rows = np.flatnonzero(left)
        gaps = closure.distances(here, ends[rows])
        gaps[:, 1] += barred[rows]
        k, side = np.unravel_index(int(gaps.argmin()), gaps.shape)
        chosen = int(rows[k])
        order.append((chosen, bool(side)))
        left[chosen] = False
        here = ends[chosen, 1 - int(side)]
    return order


def _two_opt(ends: Array, order: Order, closure: Closure) -> Order:
    """Reverse the stretch that gains most, until none gains anything; all pairs of cuts at once."""
    while True:
        starts, stops = _run(ends, order)
        n = len(order)
        # reversing order[i + 1 .. j] joins stop i with stop j and start i + 1 with start j + 1 (nothing follows the last one)
        kept = np.append(closure.distances(stops[:-1], starts[1:]), 0.0)
        head = closure.distances(stops[:, None], stops[None, :])
        tail = np.zeros((n, n))
        tail[:-1, :-1] = closure.distances(starts[1:, None], starts[None, 1:])
        gain = kept[:, None] + kept[None, :] - head - tail
        gain[np.tril_indices(n)] = -np.inf
        i, j = np.unravel_index(int(gain.argmax()), gain.shape)
        if gain[i, j] <= LEAST:
            return order
        middle = [(k, not back) for k, back in order[i + 1 : j + 1][::-1]]
        order = [*order[: i + 1], *middle, *order[j + 1 :]]


def _moved(ends: Array, order: Order, closure: Closure) -> Order:
    """Short stretches moved to where they cost less, either way round (or-opt)."""
    for length in range(1, LONGEST_MOVE + 1):
        for begin in range(1, len(order) - length + 1):
            order = _best_place(ends, order, begin, length, closure)
    return order


def _best_place(ends: Array, order: Order, begin: int, length: int, closure: Closure) -> Order:
    part, rest = order[begin : begin + length], order[:begin] + order[begin + length :]
    starts, stops = _run(ends, rest)
    following = np.append(closure.distances(stops[:-1], starts[1:]), 0.0)
    now, out = np.inf, order
    for turned in (part, [(k, not back) for k, back in part[::-1]]):
        a, b = _run(ends, turned)
        own = float(closure.distances(b[:-1], a[1:]).sum())
        after = np.append(closure.distances(b[-1], starts[1:]), 0.0)
        cost = float(following.sum()) + own + closure.distances(stops, a[0]) + after - following
        if turned is part:
            # where it is
            now = float(cost[begin - 1])
        k = int(cost.argmin())
        if cost[k] < now - LEAST:
            now, out = float(cost[k]), [*rest[: k + 1], *turned, *rest[k + 1 :]]
    return out
