"""What level curves are traced on: one face's surface, or several of one kind together.

In: faces. Out: Grounds, which evaluate points on any of their faces at once; a point's face is said by its number `which`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from brep_slicer.geometry import BSplineSurface, BSplineSurfacePack, Face, Surface
from brep_slicer.layers import CYLINDERS, LayerFamily
from brep_slicer.maps import Array

Which = NDArray[np.int64]


class Ground:
    """`faces` that are traced on together; `scale` (faces, 2) is what a step in u or v is in mm, `box` (faces, 2, 2)."""

    def __init__(self, faces: Sequence[Face], family: LayerFamily = CYLINDERS) -> None:
        self.faces, self.family = tuple(faces), family
        self.box = np.array([face.box for face in faces])
        self.derivatives: Callable[[Which, Array], tuple[Array, Array, Array]]
        if len(faces) == 1:
            self.derivatives = lambda which, uv: faces[0].surface.derivatives(uv)
        else:
            self.derivatives = BSplineSurfacePack([f.surface for f in faces]).derivatives  # type: ignore[misc]
        self.scale = self._lengths()

    def _lengths(self) -> Array:
        """Mean lengths (faces, 2) of S_u and S_v over the boxes."""
        steps = np.linspace(0.0, 1.0, 5)
        share = np.stack(np.meshgrid(steps, steps, indexing="ij"), axis=-1).reshape(-1, 2)
        uv = self.box[:, None, 0] + share * (self.box[:, None, 1] - self.box[:, None, 0])
        count = len(self.faces)
        _, su, sv = self.derivatives(np.repeat(np.arange(count), len(share)), uv.reshape(-1, 2))
        sizes = [np.linalg.norm(along, axis=1).reshape(count, -1).mean(axis=1) for along in (su, sv)]
        return np.maximum(np.stack(sizes, axis=1), 1e-12)

    def gap(self, which: Which, uv: Array, radius: Array) -> tuple[Array, Array, Array]:
        """(c - level, dc / du, dc / dv) at uv (n, 2); rho - R on cylinders."""
        return _gap(self.derivatives(which, uv), radius, self.family)


def level_gap(surface: Surface, uv: Array, radius: Array, family: LayerFamily) -> tuple[Array, Array, Array]:
    """(c - level, dc / du, dc / dv) at uv (n, 2) of one surface."""
    return _gap(surface.derivatives(uv), radius, family)


def _gap(found: tuple[Array, Array, Array], radius: Array, family: LayerFamily) -> tuple[Array, Array, Array]:
    p, su, sv = found
    return family.value(p) - radius, family.change(p, su), family.change(p, sv)


def grouped(faces: Sequence[Face]) -> list[list[int]]:
    """Numbers of the faces that can be traced on together, by groups."""
    alone: list[list[int]] = []
    together: dict[tuple[int, int], list[int]] = {}
    for number, face in enumerate(faces):
        surface = face.surface
        if isinstance(surface, BSplineSurface) and BSplineSurfacePack.takes(surface):
            together.setdefault(surface.degrees, []).append(number)
        else:
            alone.append([number])
    return [*together.values(), *alone]
