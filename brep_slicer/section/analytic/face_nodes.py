"""The nodes on one face's boundary, as starts and ends of the arcs that cross the face.

In: a face and all nodes. Out: FaceNodes. Along the boundary, with the face on its left as seen from outside, rho falling
through R begins an arc and rho rising through R ends one: the section runs along T = e_rho x n, its metal on the left.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from brep_slicer.field import FAINT
from brep_slicer.geometry import Face, Surface
from brep_slicer.layers import CYLINDERS, LayerFamily
from brep_slicer.maps import Array

from .nodes import Nodes

# Steps to the nearest place of a face, and what each must gain at least; where S_u and S_v are parallel to this share of their
# lengths' product squared (a pole), none is made.
FOOT_STEPS, FEW, FLAT = 6, 1e-3, 1e-12


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FaceNodes:
    """Arrays (n,) over the crossings of one face's boundary: the `node` in Nodes, its `layer`, whether it `begins` an arc,
    `theta` and `height` (z, on cylinders) of the node, the face's parameters `uv` there (n, 2), the number of the edge use in
    its boundary."""

    node: NDArray[np.int64]
    layer: NDArray[np.int64]
    begins: NDArray[np.bool_]
    theta: Array
    height: Array
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
            height=self.height[mask],
            uv=self.uv[mask],
            use=self.use[mask],
        )


def nodes_on_face(face: Face, nodes: Nodes, family: LayerFamily = CYLINDERS) -> FaceNodes:
    """Gather the crossings of every edge use of a face."""
    index, begins, uv = [np.zeros(0, dtype=np.int64)], [np.zeros(0, dtype=bool)], [np.zeros((0, 2))]
    uses = [np.zeros(0, dtype=np.int64)]
    for number, use in enumerate(use for loop in face.loops for use in loop):
        mine = nodes.of_edge(use.edge)
        if mine.stop == mine.start:
            continue
        index.append(np.arange(mine.start, mine.stop))
        begins.append(nodes.rising[mine] != use.forward)
        if use.pcurve is None:
            uv.append(np.full((mine.stop - mine.start, 2), np.nan))
        else:
            uv.append(_nearest(face.surface, use.pcurve.points(nodes.t[mine]), nodes.points[mine]))
        uses.append(np.full(mine.stop - mine.start, number))
    node = np.concatenate(index)
    points = nodes.points[node]
    return FaceNodes(
        node=node,
        layer=nodes.layer[node],
        begins=np.concatenate(begins),
        theta=np.arctan2(points[:, 1], points[:, 0]),
        height=family.heights(points),
        uv=np.concatenate(uv),
        use=np.concatenate(uses),
    )


def _nearest(surface: Surface, uv: Array, points: Array) -> Array:
    """The parameters (n, 2) of the surface's places nearest to the points (n, 3), sought from `uv`.

    A file's pcurves run along their edges at another pace: at one parameter they may lie a tenth of a mm apart that are a
    thousandth apart as curves.
    """
    found = uv.copy()
    rows, off = np.arange(len(uv)), np.linalg.norm(surface.points(uv) - points, axis=1)
    for _ in range(FOOT_STEPS):
        rows = rows[off[rows] > FAINT]
        if not len(rows):
            break
        p, su, sv = surface.derivatives(found[rows])
        gap = points[rows] - p
        uu, vv, cross = (np.einsum("ij,ij->i", a, b) for a, b in ((su, su), (sv, sv), (su, sv)))
        u, v = (np.einsum("ij,ij->i", gap, a) for a in (su, sv))
        size = uu * vv - cross * cross
        with np.errstate(divide="ignore", invalid="ignore"):
            step = np.stack([vv * u - cross * v, uu * v - cross * u], axis=1) / size[:, None]
        new = found[rows] + np.where((size > FLAT * uu * vv)[:, None], step, 0.0)
        distance = np.linalg.norm(surface.points(new) - points[rows], axis=1)
        nearer = distance < (1.0 - FEW) * off[rows]
        rows, new, distance = rows[nearer], new[nearer], distance[nearer]
        found[rows], off[rows] = new, distance
    return found


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
