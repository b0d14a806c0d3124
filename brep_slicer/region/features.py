"""Features: pieces that stay connected from layer to layer, as the teeth of a gear.

In: the regions of layers that follow one another. Out: the number of the feature that each piece belongs to.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from brep_slicer.groups import groups_of_pairs

from .chart import polygon_from_piece
from .region import Region

# Outlines are compared by polygons this fine, mm.
CHORD = 0.05


def features_of(regions: Sequence[Region]) -> list[list[int]]:
    """For each region, the feature of each of its pieces: pieces of neighbouring layers that overlap are one feature.

    Features are numbered in the order in which they are met. Pieces are compared at the same angles, across the seam too.
    """
    counts = [len(region.pieces) for region in regions]
    first = np.concatenate([[0], np.cumsum(counts, dtype=int)])
    pairs = [
        (first[i - 1] + j, first[i] + k)
        for i in range(1, len(regions))
        for j, k in overlapping_pieces(regions[i - 1], regions[i])
    ]
    group = groups_of_pairs(int(first[-1]), np.array(pairs, dtype=int))
    return [group[a:b].tolist() for a, b in itertools.pairwise(first)]


def overlapping_pieces(first: Region, second: Region) -> list[tuple[int, int]]:
    """Numbers of pieces of two regions that overlap when drawn on the same sheet."""
    import shapely

    if first.is_empty or second.is_empty:
        return []
    ours = [polygon_from_piece(piece, chord=CHORD) for piece in first.pieces]
    theirs = [polygon_from_piece(piece, chord=CHORD) for piece in second.on_sheet(first.sheet).pieces]
    tree = shapely.STRtree(theirs)
    found: set[tuple[int, int]] = set()
    for turns in first.closure.beside:
        moved = [first.closure.motion(turns).shape(polygon) for polygon in ours]
        found |= {(int(j), int(k)) for j, k in np.transpose(tree.query(moved, predicate="intersects"))}
    return sorted(found)
