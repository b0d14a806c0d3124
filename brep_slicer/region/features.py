"""Features: pieces that stay connected from layer to layer, as the teeth of a gear.

In: the regions of layers that follow one another. Out: the number of the feature that each piece belongs to.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .chart import polygon_from_piece
from .region import Region

# Outlines are compared by polygons this fine, mm.
CHORD = 0.05


def features_of(regions: Sequence[Region]) -> list[list[int]]:
    """For each region, the feature of each of its pieces: pieces of neighbouring layers that overlap are one feature.

    Features are numbered in the order in which they are met. Pieces are compared at the same angles, across the seam too.
    """
    from scipy.cluster.hierarchy import DisjointSet

    sets = DisjointSet([(i, j) for i, region in enumerate(regions) for j in range(len(region.pieces))])
    for i in range(1, len(regions)):
        for j, k in overlapping_pieces(regions[i - 1], regions[i]):
            sets.merge((i - 1, j), (i, k))
    number: dict[tuple[int, int], int] = {}
    return [[number.setdefault(sets[i, j], len(number)) for j in range(len(region.pieces))] for i, region in enumerate(regions)]


def overlapping_pieces(first: Region, second: Region) -> list[tuple[int, int]]:
    """Numbers of pieces of two regions that overlap when drawn on the same cylinder."""
    import shapely.affinity

    if first.is_empty or second.is_empty:
        return []
    ours = [polygon_from_piece(piece, chord=CHORD) for piece in first.pieces]
    theirs = [polygon_from_piece(piece, chord=CHORD) for piece in second.on_radius(first.radius).pieces]
    tree = shapely.STRtree(theirs)
    found: set[tuple[int, int]] = set()
    for turn in (-1, 0, 1):
        moved = [shapely.affinity.translate(p, turn * first.period) for p in ours]
        found |= {(int(j), int(k)) for j, k in np.transpose(tree.query(moved, predicate="intersects"))}
    return sorted(found)
