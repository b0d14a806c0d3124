"""toolpath.png: the part, shaded, with the beads that can be seen on it, and the ways between them.

In: a Plan. Out: a picture of one or two views. Nothing of it is measured on: the solids are triangulated coarsely.

Words: *stretch*, a short part of a bead; *buried*, under metal of later layers, so that it cannot be seen.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from brep_slicer.maps import Array
from brep_slicer.wording import counted

from .canvas import write_words
from .layers import round_length
from .page import DARK, PALE, name_of, saved
from .raster import Seen, along, dots_on_lines, planes_of, seen, values_at
from .scene import (
    AT_ONCE,
    FINE_PROFILE,
    PLAIN_PROFILE,
    TRAVEL,
    Mesh,
    Stretches,
    bead_mesh,
    blocks_of,
    part_mesh,
    stretches_of,
)
from .views import View, ranges_of_deposit, slant_of, views_of

if TYPE_CHECKING:
    from PIL.Image import Image

    from brep_slicer.planning import Plan

# Pixels that a page's views have in all, their height over width at most and at least, and what is kept free around them.
PIXELS, TALLEST, WIDEST, MARGIN, TITLE = 500_000, 1.25, 0.4, 14, 46
KEY = (
    "beads red, dark to light from first to last layer · repositioning on the last layer blue · part beige, standing metal grey"
)
# The solids are triangulated to this share of what is shown.
DEFLECTION = 1.2e-3
# Light from the upper left in front, over what comes from everywhere; both in shares of full brightness.
LIGHT, AMBIENT, GLOSS = np.array([-0.42, 0.34, 0.842]), 0.48, 0.16
EDGE, EDGE_STRENGTH, TRAVEL_STRENGTH = np.array([0.22, 0.22, 0.24]), 0.75, 0.8
# Lines lie on surfaces: they count as in front of what hides them by less than this share of the page's width.
LINE_SLACK = 4e-3
# Bends of a bead within so many pixels are not seen.
FINEST = 4.0
# In the middle of a bead and beside it, in widths.
BESIDE = ((0.0, 0.0), (0.4, 0.4), (0.4, -0.4), (-0.4, 0.4), (-0.4, -0.4))
# A bead narrower than this is too small for a fine profile to be seen, pixels.
SMALL_BEAD = 24.0
# Half a side of the square that holds the three directions, pixels.
TRIAD = 36
# Neighbouring pixels whose brightness differs by more than this have an edge between them, which is made smooth.
STEP = 0.10


def draw_toolpath(plan: Plan, path: str | Path) -> Path:
    """The toolpath on the part, from where every place that gets metal is in sight."""
    from PIL import Image

    some = plan.toolpath.deposits.any()
    extent = float(np.linalg.norm(np.ptp(ranges_of_deposit(plan.toolpath, np.eye(3)), axis=0))) if some else 1.0
    mesh = part_mesh(plan, max(DEFLECTION * extent, 1e-6))
    views = views_of(plan, mesh)
    sizes, places, page = _layout(views)
    image = np.full((page[1], page[0], 3), 255, dtype=np.uint8)
    for view, (height, width), (left, top) in zip(views, sizes, places, strict=True):
        image[top : top + height, left : left + width] = rendered(plan, mesh, view, (height, width))
    picture = Image.fromarray(image)
    for view, size, corner in zip(views, sizes, places, strict=True):
        _write_scale(picture, view, size, corner)
        _draw_directions(picture, view, size, corner)
    count = len({layer.index for layer in plan.layers})
    title = f"{name_of(plan)}: {counted(count, 'layer')} on R {plan.substrate.radius:.6g} mm"
    write_words(picture, [((MARGIN, 7), title, 17, DARK, "la")], bold=True)
    write_words(picture, [((MARGIN, 29), KEY, 12, PALE, "la")])
    return saved(picture, plan, path)


def _layout(views: list[View]) -> tuple[list[tuple[int, int]], list[tuple[int, int]], tuple[int, int]]:
    """(height, width) of each view and its (left, top) on the page, in pixels, and the page's (width, height)."""
    ratios = [min(max((v.box[3] - v.box[1]) / (v.box[2] - v.box[0]), WIDEST), TALLEST) for v in views]
    sizes = []
    for ratio in ratios:
        width = math.sqrt(PIXELS / len(views) / ratio)
        sizes.append((round(width * ratio), round(width)))
    side_by_side = len(views) == 1 or ratios[0] > 0.62
    places, at = [], [MARGIN, TITLE]
    for height, width in sizes:
        places.append((at[0], at[1]))
        at[0 if side_by_side else 1] += (width if side_by_side else height) + MARGIN
    wide = max(left + width for (left, _), (_, width) in zip(places, sizes, strict=True)) + MARGIN
    high = max(top + height for (_, top), (height, _) in zip(places, sizes, strict=True)) + MARGIN
    return sizes, places, (max(wide, 640), high)


def rendered(plan: Plan, mesh: Mesh, view: View, size: tuple[int, int]) -> Array:
    """One view as an image (height, width, 3) of bytes."""
    scale, view = _fitted(view, size)
    page = seen(*_placed(view, mesh, scale), mesh.triangles, size)
    slant = slant_of(mesh, view)[page.triangle]
    # beads lie below the part's own surface by what their outline stays inside of it, and the facets outside
    slack = 0.5 * (plan.process.width + plan.process.step_over) + max((la.thickness or 0.0) for la in plan.layers)
    surface = page.depth - slack * slant
    colors = np.ones((size[0] * size[1], 3))
    top = surface.copy()
    for beads in _beads(plan, view, scale, surface, size):
        # a bead has no underside of its own
        tracks = seen(*_placed(view, beads, scale), beads.triangles, size, both_sides=True)
        nearer = (tracks.triangle >= 0) & (tracks.depth > top)
        _shade(colors, view, beads, tracks, nearer, scale, size)
        top[nearer] = tracks.depth[nearer]
    on_top = top > surface
    _shade(colors, view, mesh, page, (page.triangle >= 0) & ~on_top, scale, size)
    reach = LINE_SLACK * size[1] / scale
    edges = _lines(view, mesh.points, mesh.edges, page.depth - reach, scale, size)
    edges = edges[~on_top[edges]]
    colors[edges] += EDGE_STRENGTH * (EDGE - colors[edges])
    colors = _smoothed(colors.reshape(*size, 3)).reshape(-1, 3)
    path = plan.toolpath
    depth = np.where(on_top, top, page.depth)
    last = path.layer == path.layer.max(initial=0)
    moves = np.flatnonzero(~path.deposits[1:] & last[1:] & last[:-1])
    points, pairs = np.concatenate([path.points[moves], path.points[moves + 1]]), np.arange(2 * len(moves)).reshape(2, -1).T
    ways = _lines(view, points, pairs, depth - 0.25 * reach, scale, size)
    colors[ways] += TRAVEL_STRENGTH * (TRAVEL - colors[ways])
    return np.clip(255.0 * colors + 0.5, 0, 255).astype(np.uint8).reshape(*size, 3)


def _fitted(view: View, size: tuple[int, int]) -> tuple[float, View]:
    """Pixels a mm, and the view with its box in the middle of the page."""
    left, low, right, top = view.box
    scale = min(size[1] / (right - left), size[0] / (top - low))
    wide, high = 0.5 * size[1] / scale, 0.5 * size[0] / scale
    x, y = 0.5 * (left + right), 0.5 * (low + top)
    return scale, replace(view, box=(x - wide, y - high, x + wide, y + high))


def _placed(view: View, mesh: Mesh, scale: float) -> tuple[Array, Array]:
    return view.places(mesh.points, scale), along(mesh.points, view.towards)


def _beads(plan: Plan, view: View, scale: float, surface: Array, size: tuple[int, int]) -> Iterator[Mesh]:
    """The beads that are not buried, some at a time: with some of their length above a `surface` of depths, or near it."""
    width, (high, wide) = plan.process.width, size
    longest = max(1.5 * width, 12.0 / scale)
    profile = FINE_PROFILE if width * scale > SMALL_BEAD else PLAIN_PROFILE
    room = 2.0 * width * scale
    waiting: list[Stretches] = []
    for rows in blocks_of(plan.toolpath, longest):
        tracks = stretches_of(plan.toolpath, rows, longest, FINEST / scale)
        middle = 0.5 * (tracks.a + tracks.b)
        place = view.places(middle, scale)
        on_page = ((place > -room) & (place < np.array([wide, high]) + room)).all(axis=1)
        # the surface there, or as far beside it as a bead reaches
        at = [np.clip(place + width * scale * np.array(way), 0, [wide - 1, high - 1]).astype(int) for way in BESIDE]
        lowest = np.min([surface[y * wide + x] for x, y in (each.T for each in at)], axis=0)
        near = along(middle, view.towards) > lowest - 0.5 * (longest + width)
        waiting.append(tracks.rows(on_page & near))
        if sum(len(some) for some in waiting) >= AT_ONCE:
            yield bead_mesh(plan, Stretches.together(waiting), profile)
            waiting = []
    if waiting:
        yield bead_mesh(plan, Stretches.together(waiting), profile)


def _shade(colors: Array, view: View, mesh: Mesh, page: Seen, where: Array, scale: float, size: tuple[int, int]) -> None:
    """Colour the pixels `where` a mesh is seen, by how its surface lies to the light."""
    pixel = np.flatnonzero(where)
    owner = page.triangle[pixel]
    used, owner = np.unique(owner, return_inverse=True)
    corners = mesh.triangles[used]
    light = np.stack([view.right, view.up, view.towards], axis=1) @ LIGHT
    places, halfway = view.places(mesh.points, scale), light + view.towards
    lit, gloss = (
        np.clip(values_at(planes_of(places, along(mesh.normals, way), corners), owner, pixel, size[1]), 0.0, 1.0)
        for way in (light, halfway / np.linalg.norm(halfway))
    )
    bright = AMBIENT + (1.0 - AMBIENT) * lit
    # the 24th power, by squares
    gloss = (gloss * gloss) ** 2
    gloss = gloss**2 * gloss**2 * gloss**2
    colors[pixel] = mesh.colors[used[owner]] * bright[:, None] + (GLOSS * gloss)[:, None]


def _smoothed(image: Array) -> Array:
    """The image with its edges softened: the mean of a pixel and its four neighbours where they differ."""
    gray = image[..., 1]
    edge = np.zeros(gray.shape, dtype=bool)
    for axis in (0, 1):
        step = np.abs(np.diff(gray, axis=axis)) > STEP
        low, high = (slice(None, -1), slice(1, None))
        edge[(low, slice(None)) if axis == 0 else (slice(None), low)] |= step
        edge[(high, slice(None)) if axis == 0 else (slice(None), high)] |= step
    edge[[0, -1], :] = False
    edge[:, [0, -1]] = False
    y, x = np.nonzero(edge)
    around = image[y - 1, x] + image[y + 1, x] + image[y, x - 1] + image[y, x + 1]
    out = image.copy()
    out[y, x] = 0.4 * image[y, x] + 0.15 * around
    return out


def _lines(view: View, points: Array, pairs: Array, depth: Array, scale: float, size: tuple[int, int]) -> Array:
    """Pixels of the lines between `pairs` of points that nothing at `depth` hides, each once."""
    if not len(pairs):
        return np.zeros(0, dtype=int)
    pixel, z = dots_on_lines(view.places(points, scale), along(points, view.towards), pairs, size)
    flags = np.zeros(size[0] * size[1], dtype=bool)
    flags[pixel[z > depth[pixel]]] = True
    return np.flatnonzero(flags)


def _write_scale(picture: Image, view: View, size: tuple[int, int], corner: tuple[int, int]) -> None:
    """A bar of a round length in the view's lower left corner."""
    from PIL import ImageDraw

    scale, _ = _fitted(view, size)
    length = round_length(0.18 * size[1] / scale)
    x, y = corner[0] + 6, corner[1] + size[0] - 8
    ImageDraw.Draw(picture).rectangle((x, y, x + length * scale, y + 1), fill=DARK)
    write_words(picture, [((x, y - 4), f"{length:g} mm", 12, DARK, "ld")])


def _draw_directions(picture: Image, view: View, size: tuple[int, int], corner: tuple[int, int]) -> None:
    """The file's x, y and z in a corner of the view."""
    from PIL import Image, ImageDraw

    # drawn finer than the page and made smaller, so that slanting lines are smooth
    fine, room = 3, 2 * TRIAD
    end, low = corner[0] + size[1] - room, corner[1] + size[0] - room
    # where the page is emptiest
    left, top = max(
        ((end, low), (end, corner[1]), corner),
        key=lambda at: float(np.asarray(picture.crop((*at, at[0] + room, at[1] + room)).convert("L")).mean().round(1)),
    )
    patch = picture.crop((left, top, left + room, top + room)).resize((fine * room, fine * room), Image.Resampling.NEAREST)
    draw, words = ImageDraw.Draw(patch), []
    for name, right, up in zip("xyz", view.right.tolist(), view.up.tolist(), strict=True):
        dx, dy = 0.66 * TRIAD * right, -0.66 * TRIAD * up
        if math.hypot(dx, dy) < 4.0:
            continue
        draw.line([fine * TRIAD, fine * TRIAD, fine * (TRIAD + dx), fine * (TRIAD + dy)], fill=PALE, width=4)
        words.append(((left + TRIAD + 1.32 * dx, top + TRIAD + 1.32 * dy), name, 12, PALE, "mm"))
    picture.paste(patch.reduce(fine), (left, top))
    write_words(picture, words)
