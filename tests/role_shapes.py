"""Shafts, wheels and what is built on them, drawn for the tests of the substrate and of the solids' roles (mm, about z)."""

from __future__ import annotations

import math

import build123d as bd


def bar(radius: float, low: float, high: float):
    """A cylinder about z from `low` to `high`."""
    return bd.Pos(0, 0, 0.5 * (low + high)) * bd.Cylinder(radius, high - low)


def ring(inner: float, outer: float, low: float, high: float):
    return bar(outer, low, high) - bar(inner, low - 1.0, high + 1.0)


def box(low, high):
    size = [b - a for a, b in zip(low, high, strict=True)]
    return bd.Pos(*(0.5 * (a + b) for a, b in zip(low, high, strict=True))) * bd.Box(*size)


def round_about(shape, count: int, first: float = 0.0):
    """`count` copies evenly about z."""
    return [bd.Rot(0, 0, first + 360.0 * i / count) * shape for i in range(count)]


def united(first, *others):
    for other in others:
        first = first + other
    return first


def file_of(*solids, names=()):
    """Several solids of one file, by name."""
    children = [shape.solid() for shape in solids]
    for child, name in zip(children, names, strict=False):
        child.label = name
    return bd.Compound(children=children)


def worm(*, step_deg: float = 60.0, share: float = 0.66, gap: float = 0.0, slices: int = 12):
    """A thread of R 10 on a root of R 6, in slices 2 mm high, each turned by `step_deg` against the one below; its crest is
    this share of the turn, most of the turned area. Collars R 11 beside, `gap` away, land of R 6 beyond them; ends of R 4."""
    sector = bd.Cylinder(10.0, 2.0, arc_size=360.0 * share, align=bd.Align.NONE)
    half = float(slices)
    thread = [bd.Pos(0, 0, 2.0 * i - half) * bd.Rot(0, 0, step_deg * i) * sector for i in range(slices)]
    out = united(bar(6.0, -half - 8.0 - gap, half + 8.0 + gap), bar(4.0, -half - 25.0, half + 25.0))
    return united(out, *thread, *_collars(half + gap))


def splined(keys: int = 6, *, share: float = 0.8, gap: float = 0.0):
    """Keys from R 6 to R 10 that cover this share of the turn: most of the turned area is their tops. Collars as worm's."""
    key = bd.Cylinder(10.0, 24.0, arc_size=360.0 * share / keys, align=bd.Align.NONE)
    keys_at = round_about(bd.Pos(0, 0, -12.0) * key, keys)
    return united(bar(6.0, -20.0 - gap, 20.0 + gap), bar(4.0, -40.0, 40.0), *keys_at, *_collars(12.0 + gap))


def _collars(z: float):
    return bar(11.0, z, z + 4.0), bar(11.0, -z - 4.0, -z)


def tube_with_lands(*, radius: float = 20.0, land: float = 30.0, length: float = 300.0, share: float = 0.8):
    """A tube with an end ring at either end, turned for `share` of the round; a lug fills the rest of each, farther out."""
    half = math.pi * (1.0 - share) * land
    out = ring(radius - 5.0, radius, -0.5 * length, 0.5 * length)
    for z, turn in ((-0.5 * length, 0.0), (0.5 * length - 12.0, 180.0)):
        lug = bd.Rot(0, 0, turn) * box((0.7 * radius, -half, z), (land + 8.0, half, z + 12.0))
        out = united(out, ring(radius - 1.0, land, z, z + 12.0), lug - bar(radius - 1.0, z - 1.0, z + 13.0))
    return out


def wheel(*, spokes: int = 3, hub: float = 10.0, bore: float = 4.0, height: float = 40.0):
    """A tapered hub with a bore, spokes, a rim R 40 to 45: the only outside cylinder is the tread, where nothing stands."""
    body = bd.Cone(hub + 3.0, hub - 1.0, height)
    arm = box((0.8 * hub, -3.0, -3.0), (41.0, 3.0, 3.0))
    out = united(body, ring(40.0, 45.0, -6.0, 6.0), *round_about(arm, spokes))
    return out - bar(bore, -height, height)


def cam(*, base: float = 20.0, nose: float = 30.0, boss: float = 24.0, lobes: int = 1):
    """A disc of R `base` with a nose (or several), and a boss of R `boss` at one end: lower than the nose, above the base."""
    lobe = box((0.0, -6.0, -8.0), (nose - 6.0, 6.0, 8.0)) + bd.Pos(nose - 6.0, 0, 0) * bd.Cylinder(6.0, 16.0)
    return united(bar(base, -12.0, 8.0), ring(0.5 * base, boss, 8.0, 14.0), *round_about(lobe, lobes))


def gear(*, root: float = 12.0, tip: float = 16.0, teeth: int = 10, axle: float = 5.0, width: float = 10.0):
    tooth = box((root - 2.0, -1.2, -0.5 * width), (tip, 1.2, 0.5 * width))
    return united(bar(axle, -30.0, 30.0), bar(root, -0.5 * width, 0.5 * width), *round_about(tooth, teeth))


def pin(x: float = 30.0, radius: float = 3.0):
    """A loose one beside the axis, as high as `gear`."""
    return bd.Pos(x, 0, 0) * bd.Cylinder(radius, 10.0)


JOURNAL, COLLAR, FLANGE, BAND = 23.0, 30.0, 45.0, 25.0


def worn_shaft(*, collar: float | None = 40.0, flange: bool = True):
    """A journal of R 23, 100 long, between a flange R 45 and a collar R 30 that begins at this z."""
    out = bar(JOURNAL, -50.0, 50.0)
    if collar is not None:
        out = united(out, ring(10.0, COLLAR, collar, collar + 10.0))
    return united(out, ring(10.0, FLANGE, -50.0, -38.0)) if flange else out


def clad(low: float = -20.0, high: float = 20.0):
    """The metal to be laid on the journal: R 23 to 25."""
    return ring(JOURNAL, BAND, low, high)


def crankshaft(*, throw: float = 15.0):
    """Journals of R 10, two webs, a pin of R 8; and a band R 8 to 10 on the pin."""
    web = box((-12.0, -12.0, 0.0), (throw + 10.0, 12.0, 6.0))
    shaft = united(bar(10.0, -60.0, -14.0), bar(10.0, 14.0, 60.0), bd.Pos(0, 0, -20) * web, bd.Pos(0, 0, 14) * web)
    shaft = united(shaft, bd.Pos(throw, 0, 0) * bar(8.0, -14.0, 14.0))
    return shaft, bd.Pos(throw, 0, 0) * ring(8.0, 10.0, -10.0, 10.0)


def fan(*, hub: float = 12.0, inner: float = 38.0, wall: float = 1.0, blades: int = 7, struts: int = 4, frame: str = "square"):
    """A fan in one solid, 24 high: a hub with free blades, a thin-walled ring that hangs on struts, and on the ring a square
    frame's corners, ears, or a flange with a flat."""
    outer = inner + wall
    blade = box((0.8 * hub, -0.8, -9.0), (inner - 1.5, 0.8, 6.0))
    strut = box((0.8 * hub, -1.5, 8.0), (inner + 0.5 * wall, 1.5, 12.0))
    out = united(
        bar(hub, -12.0, 12.0), *round_about(blade, blades), ring(inner, outer, -12.0, 12.0), *round_about(strut, struts)
    )
    edge = 2.0 * outer + 2.0
    for low, high in ((-12.0, -9.0), (9.0, 12.0)):
        plates = {
            "square": lambda: bd.Box(edge, edge, 3.0),
            "ears": lambda: united(*round_about(box((0.0, -5.0, -1.5), (outer + 14.0, 5.0, 1.5)), 3)),
            "flat": lambda: bd.Cylinder(outer + 10.0, 3.0) - box((outer + 2.0, -99.0, -9.0), (99.0, 99.0, 9.0)),
        }
        plate = bd.Pos(0, 0, 0.5 * (low + high)) * plates[frame]()
        out = out + (plate - bar(0.5 * (inner + outer), low - 1.0, high + 1.0))
    return out


def spoked_gear(*, rim: float = 40.0, wall: float = 6.0, spokes: int = 5, teeth: int = 30, hub: float = 10.0):
    """Teeth 5 high on a rim (R `rim` outside) that spokes carry from a hub."""
    tooth, arm = box((rim - 2.0, -1.5, -5.0), (rim + 5.0, 1.5, 5.0)), box((0.8 * hub, -2.5, -3.0), (rim - 0.5 * wall, 2.5, 3.0))
    out = united(ring(4.0, hub, -12.0, 12.0), ring(rim - wall, rim, -5.0, 5.0))
    return united(out, *round_about(arm, spokes), *round_about(tooth, teeth))


def stepped_collar(*, radius: float = 1.5, steps=(2.0, 2.5), widths=(4.5, 2.4), length: float = 20.0, low: float = 3.0):
    """A shaft with a collar turned in steps, each narrower than the one below it."""
    out, z = bar(radius, 0.0, length), low
    for step, width in zip(steps, widths, strict=True):
        out, z = united(out, ring(0.5 * radius, step, z, z + width)), z + width
    return out


def shouldered_crankshaft(*, journal: float = 25.0, shoulder: float = 30.0, width: float = 12.0, throw: float = 38.0):
    """Journals with a narrow shoulder on either side of the two webs, and a pin between them."""
    web = box((-35.0, -35.0, 0.0), (throw + 30.0, 35.0, 14.0))
    out = united(bar(journal, -120.0, -24.0), bar(journal, 24.0, 120.0), bd.Pos(0, 0, -34) * web, bd.Pos(0, 0, 20) * web)
    out = united(out, ring(5.0, shoulder, -34.0 - width, -33.0), ring(5.0, shoulder, 33.0, 34.0 + width))
    return united(out, bd.Pos(throw, 0, 0) * bar(16.0, -21.0, 21.0))
