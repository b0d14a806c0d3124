"""What belongs together: things that are connected by pairs, directly or by way of others.

In: how many things there are, and pairs of their numbers. Out: the number of each thing's group.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from .maps import Array


def groups_of_pairs(count: int, pairs: ArrayLike) -> Array:
    """Groups (count,) of things 0 to count - 1, numbered from 0 in the order of their first members.

    Parameters
    ----------
    count : int
        How many things there are; one that is in no pair is a group of its own.
    pairs : array_like, shape (n, 2)
        Numbers of things that belong to one group.
    """
    a, b = np.asarray(pairs, dtype=np.int64).reshape(-1, 2).T
    # each thing points to a member of its group with a smaller number, and in the end to the first one
    first = np.arange(count)
    while (first[a] != first[b]).any():
        low, high = np.minimum(first[a], first[b]), np.maximum(first[a], first[b])
        np.minimum.at(first, high, low)
        while (first[first] != first).any():
            first = first[first]
    return np.unique(first, return_inverse=True)[1]
