"""Groups of things that pairs connect, against a search by hand."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from brep_slicer.groups import groups_of_pairs


def searched(count, pairs):
    """Groups by walking from neighbour to neighbour, in the order of their first members."""
    beside = {i: {b for a, b in pairs if a == i} | {a for a, b in pairs if b == i} for i in range(count)}
    number: dict[int, int] = {}
    found = 0
    for i in range(count):
        if i in number:
            continue
        todo = [i]
        while todo:
            k = todo.pop()
            if k not in number:
                number[k] = found
                todo += beside[k]
        found += 1
    return [number[i] for i in range(count)]


@given(st.integers(1, 12).flatmap(lambda n: st.tuples(st.just(n), st.lists(st.tuples(*[st.integers(0, n - 1)] * 2)))))
def test_groups_are_those_of_a_search(case):
    count, pairs = case
    assert groups_of_pairs(count, pairs).tolist() == searched(count, pairs)


@pytest.mark.parametrize("seed", range(3))
def test_a_long_chain_in_any_order_is_one_group(seed):
    names = np.random.default_rng(seed).permutation(1000)
    assert not groups_of_pairs(1000, np.stack([names[:-1], names[1:]], axis=1)).any()
    assert groups_of_pairs(1001, np.stack([names[:-1], names[1:]], axis=1)).tolist() == [0] * 1000 + [1]


def test_things_without_pairs_are_groups_of_their_own():
    assert groups_of_pairs(3, []).tolist() == [0, 1, 2]
    assert groups_of_pairs(0, []).tolist() == []
