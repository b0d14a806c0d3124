"""Sign changes of functions, each inside of a bracket, many at once.

In: a function of (which brackets, places), brackets with the values at their ends. Out: the places.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from brep_slicer.maps import Array

# Steps at most: bisections alone would take a bracket to rounding in as many.
ROOT_STEPS = 60
# Every so many steps, a bracket that has not been halved meanwhile is bisected.
BISECT_EVERY = 3


def bracketed_roots(function: Callable[[Array, Array], Array], a: Array, b: Array, fa: Array, fb: Array) -> Array:
    """The places (n,) between `a` and `b` (n,) where the function changes sign, to rounding.

    By the Illinois rule of false position, with bisections where it is slow.

    Parameters
    ----------
    function
        Its values (m,) for the brackets with the numbers (m,) at the places (m,).
    a, b, fa, fb : ndarray, shape (n,)
        Ends of the brackets and the values there, of different signs (or nil at one of them).
    """
    a, b, fa, fb = (np.array(x, dtype=float) for x in (a, b, fa, fb))
    least = 2.0 * np.spacing(np.maximum(np.abs(a), np.abs(b)))
    root = np.where(np.abs(fa) < np.abs(fb), a, b)
    open_ = np.flatnonzero((fa != 0.0) & (fb != 0.0))
    a, b, fa, fb, least = (x[open_] for x in (a, b, fa, fb, least))
    width, kept = np.abs(b - a), np.zeros(len(a), dtype=int)
    for step in range(ROOT_STEPS):
        if not len(open_):
            break
        with np.errstate(divide="ignore", invalid="ignore"):
            t = b - fb * (b - a) / (fb - fa)
        if step % BISECT_EVERY == BISECT_EVERY - 1:
            t = np.where(np.abs(b - a) > 0.5 * width, 0.5 * (a + b), t)
            width = np.abs(b - a)
        t = np.where((t > np.minimum(a, b)) & (t < np.maximum(a, b)), t, 0.5 * (a + b))
        ft = function(open_, t)
        more = (ft != 0.0) & (np.abs(t - root[open_]) > least)
        root[open_] = t
        left = (ft > 0.0) == (fa > 0.0)
        # the end that stays twice over counts half: the next place falls beyond the root
        fa, fb = (
            np.where(left, ft, np.where(kept == 1, 0.5 * fa, fa)),
            np.where(left, np.where(kept == -1, 0.5 * fb, fb), ft),
        )
        a, b, kept = np.where(left, t, a), np.where(left, b, t), np.where(left, -1, 1)
        open_, a, b, fa, fb, least, width, kept = (x[more] for x in (open_, a, b, fa, fb, least, width, kept))
    return root
