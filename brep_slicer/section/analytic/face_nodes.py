"""The nodes on one face's boundary, as starts and ends of the arcs that cross the face.

In: a face and all nodes. Out: FaceNodes. Along the boundary, with the face on its left as seen from outside, rho falling
through R begins an arc and rho rising through R ends one: the section runs along T = e_rho x n, its metal on the left.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from brep_slicer.geometry import Face
from brep_slicer.maps import Array

from .nodes import Nodes


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FaceNodes:
    """Arrays (n,) over the crossings of one face's boundary: the `node` in Nodes, its `layer`, whether it `begins` an arc,
    `theta` and `z` of the node, the face's parameters `uv` there (n, 2), the number of the edge use in its boundary."""

    node: NDArray[np.int64]
    layer: NDArray[np.int64]
    begins: NDArray[np.bool_]
    theta: Array
    z: Array
    uv: Array
    use: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.node)

    def select(self, mask: NDArray[np.bool_]) -> FaceNodes:
        """Some of them."""
        return FaceNodes(
            node=self.node[mask],
            layer=self.layer[mask],
            begins=self.begins[mask],
            theta=self.theta[mask],
            z=self.z[mask],
            uv=self.uv[mask],
            use=self.use[mask],
        )


def nodes_on_face(face: Face, nodes: Nodes) -> FaceNodes:
    """Gather the crossings of every edge use of a face."""
    index, begins, uv = [np.zeros(0, dtype=np.int64)], [np.zeros(0, dtype=bool)], [np.zeros((0, 2))]
    uses = [np.zeros(0, dtype=np.int64)]
    for number, use in enumerate(use for loop in face.loops for use in loop):
        mine = nodes.of_edge(use.edge)
        if mine.stop == mine.start:
            continue
        index.append(np.arange(mine.start, mine.stop))
        begins.append(nodes.rising[mine] != use.forward)
        uv.append(np.full((mine.stop - mine.start, 2), np.nan) if use.pcurve is None else use.pcurve.points(nodes.t[mine]))
        uses.append(np.full(mine.stop - mine.start, number))
    node = np.concatenate(index)
    points = nodes.points[node]
    return FaceNodes(
        node=node,
        layer=nodes.layer[node],
        begins=np.concatenate(begins),
        theta=np.arctan2(points[:, 1], points[:, 0]),
        z=points[:, 2],
        uv=np.concatenate(uv),
        use=np.concatenate(uses),
    )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Pairs:
    """Arcs as rows of FaceNodes: `start` and `end` (n,), and the layers whose nodes do not pair up, `bad`."""

    start: NDArray[np.int64]
    end: NDArray[np.int64]
    bad: NDArray[np.int64]


def pair_along(found: FaceNodes, component: Array, position: Array, *, cyclic: bool) -> Pairs:
    """Pair every start with the next end along its component, in all layers at once.

    Parameters
    ----------
    component : ndarray, shape (n,)
        Which curve of its layer's level set each node lies on (any numbers).
    position : ndarray, shape (n,)
        Where along it, rising in the direction of the section.
    cyclic : bool
        Whether the curves are closed, so that the last start goes on to the first end.
    """
    # at one place (a seam) the arc that arrives comes before the one that leaves
    order = np.lexsort((found.begins, position, component, found.layer))
    layer, comp, begins = found.layer[order], component[order], found.begins[order]
    fresh = np.ones(len(order), dtype=bool)
    fresh[1:] = (layer[1:] != layer[:-1]) | (comp[1:] != comp[:-1])
    group = np.cumsum(fresh) - 1
    first = np.flatnonzero(fresh)
    last = np.append(first[1:], len(order)) - 1
    following = np.arange(1, len(order) + 1)
    following[last] = first if cyclic else -1
    starts = np.flatnonzero(begins)
    target = following[starts]
    good = target >= 0
    good &= ~begins[np.where(target >= 0, target, 0)]
    sizes = np.bincount(group, minlength=len(first))
    halves = np.bincount(group, weights=begins, minlength=len(first))
    wrong = set(layer[first][2 * halves != sizes].tolist()) | set(layer[starts[~good]].tolist())
    bad = np.array(sorted(wrong), dtype=np.int64)
    keep = good & ~np.isin(layer[starts], bad)
    return Pairs(start=order[starts[keep]], end=order[target[keep]], bad=bad)


def clusters(layer: Array, value: Array, gap: float) -> NDArray[np.int64]:
    """Numbers that tell apart values of one layer which lie more than `gap` from their neighbours."""
    order = np.lexsort((value, layer))
    fresh = np.ones(len(order), dtype=bool)
    fresh[1:] = (layer[order][1:] != layer[order][:-1]) | (np.diff(value[order]) > gap)
    out = np.empty(len(order), dtype=np.int64)
    out[order] = np.cumsum(fresh)
    return out
