"""The lifted toolpath: points on their cylinders, normals outwards, travels clear of everything that stands."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import brep_slicer as bs
from brep_slicer.substrate.axis import axis_from_line, axis_from_text
from brep_slicer.toolpath import Obstacles

Z = axis_from_text("Z")


@pytest.fixture(scope="module")
def tooth_plan():
    fixtures = Path(__file__).resolve().parent.parent / "fixtures" / "step"

    part = bs.read_step(fixtures / "helical_gear_tooth.step")
    return bs.plan(
        part,
        bs.Process(layer_thickness=1.4, step_over=3.4, fill=bs.Fill(balance=False, pattern=bs.Hatch(angle_deg=(0.0, 67.0)))),
    )


def test_every_point_lies_on_its_cylinder_with_its_normal(tooth_plan):
    path = tooth_plan.toolpath
    p = tooth_plan.axis.axis_from_file(path.points)
    rho = np.hypot(p[:, 0], p[:, 1])
    assert np.allclose(rho, path.radius, rtol=1e-13)
    theta = path.kappa / path.radius
    assert np.allclose(p, np.stack([rho * np.cos(theta), rho * np.sin(theta), path.v], axis=1), atol=1e-9)
    assert np.allclose(path.normals, np.stack([np.cos(theta), np.sin(theta), 0 * theta], axis=1), atol=1e-12)


def test_deposited_points_lie_on_the_nominal_radius(tooth_plan):
    path = tooth_plan.toolpath
    assert len(tooth_plan.layers) == 24
    assert np.allclose(path.radius[path.deposits], 150.0 + 1.4 * path.layer[path.deposits], rtol=1e-14)


def test_beads_are_sampled_to_the_chord(tooth_plan):
    path = tooth_plan.toolpath
    step = np.abs(np.diff(path.kappa / path.radius))[path.deposits[1:]]
    sagitta = path.radius[1:][path.deposits[1:]] * (1.0 - np.cos(0.5 * step))
    assert sagitta.max() <= 0.01 * (1.0 + 1e-6)


def test_step_over_measured_on_the_emitted_points(tooth_plan):
    """|geodesic spacing - d| <= 1e-6 between neighbouring hatch beads, from the 3D points alone."""
    path, spacings = tooth_plan.toolpath, 0
    p = tooth_plan.axis.axis_from_file(path.points)
    for layer in tooth_plan.layers:
        on = np.flatnonzero((path.layer == layer.index) & (path.radius == layer.radius))
        theta, z = np.arctan2(p[on, 1], p[on, 0]), p[on, 2]
        flat = np.stack([layer.radius * theta, z], axis=1)
        ids = path.bead[on]
        beads = [flat[ids == b] for b in np.unique(ids)]
        longest = max(beads, key=lambda b: np.hypot(*(b[-1] - b[0])))
        along = (longest[-1] - longest[0]) / np.hypot(*(longest[-1] - longest[0]))
        across = np.sort([float(b.mean(axis=0) @ [-along[1], along[0]]) for b in beads])
        gaps = np.diff(across)
        gaps = gaps[gaps > 0.5]
        assert np.abs(gaps - 3.4).max() <= 1e-6
        spacings += len(gaps)
    assert spacings > 250


def test_travels_stay_outside_of_what_stands(tooth_plan):
    """Finely along every travel segment as the machine runs it (a chord): never below the layers built so far."""
    path = tooth_plan.toolpath
    p = tooth_plan.axis.axis_from_file(path.points)
    share = np.linspace(0.0, 1.0, 33)[None, :, None]
    moves = np.flatnonzero(~path.deposits[1:]) + 1
    chords = p[moves - 1][:, None] * (1.0 - share) + p[moves][:, None] * share
    rho = np.hypot(chords[..., 0], chords[..., 1])
    floor = 150.0 + 1.4 * path.layer[moves]
    # a retract starts on the layer it leaves, at most one below the one it goes to
    assert (rho.min(axis=1) >= floor - 1.4 - 1e-9).all()
    sideways = np.abs(path.radius[moves] - path.radius[moves - 1]) < 1e-12
    # between beads the nozzle moves above the metal of its own layer
    assert (rho[sideways].min(axis=1) >= floor[sideways] + 1.4).all()


def test_travels_never_cut_through_the_part(tooth_plan):
    """Against the solid itself: inside of a layer's region at its own radius, nothing that moves sideways is found."""
    import shapely

    path = tooth_plan.toolpath
    part_layers = {la.index: la for la in tooth_plan.layers}
    moves = np.flatnonzero(~path.deposits[1:]) + 1
    sideways = moves[np.abs(path.radius[moves] - path.radius[moves - 1]) < 1e-12]
    checked = 0
    for layer in (0, 5, 12, 23):
        built = part_layers[layer]
        polygon = built.region.to_shapely(chord=0.01)
        for m in sideways[path.layer[sideways] == layer]:
            theta = np.linspace(path.kappa[m - 1], path.kappa[m], 9) / path.radius[m]
            inside = shapely.contains_xy(polygon, theta * built.radius, np.linspace(path.v[m - 1], path.v[m], 9))
            # above the region it may pass, but only outside of the metal of this layer
            assert not (inside & (path.radius[m] < built.radius + 1.4)).any()
            checked += 1
    assert checked > 50


def test_travels_clear_a_flange():
    pytest.importorskip("build123d")
    import build123d as bd

    shaft = bd.Solid.make_cylinder(40.0, 120.0) + bd.Solid.make_cylinder(70.0, 15.0)
    ring = bd.Solid.make_cylinder(46.0, 30.0, bd.Plane(origin=(0, 0, 15.0))) - bd.Solid.make_cylinder(
        40.0, 30.0, bd.Plane(origin=(0, 0, 15.0))
    )
    key = bd.Solid.make_box(200.0, 60.0, 10.0, bd.Plane((-100.0, -30.0, 20.0)))
    feature = (ring - key).solids()[0]
    part = bs.as_part([shaft.solids()[0], feature])
    plan = bs.plan(
        part,
        bs.Process(layer_thickness=2.0, step_over=3.0, fill=bs.Fill(pattern=bs.Automatic(angle_deg=90.0))),
        axis=Z,
        substrate=40.0,
    )
    assert plan.substrate.solids == (0,)
    path = plan.toolpath
    # near the flange (z < 15 plus the margin of half a bead) a travel has to be above its 70 mm
    near = (path.v < 15.0) & ~path.deposits
    assert not near.any() or path.radius[near].min() >= 70.0
    low = path.radius[~path.deposits & (path.v <= 17.0)]
    assert low.max(initial=0.0) >= 70.0 or not len(low)


def test_travels_clear_the_solids_that_were_not_chosen():
    bd = pytest.importorskip("build123d")
    shaft = bd.Solid.make_cylinder(40.0, 120.0) + bd.Solid.make_cylinder(70.0, 10.0, bd.Plane(origin=(0, 0, 50.0)))
    bar = bd.Solid.make_box(50.0, 20.0, 120.0, bd.Plane((0.0, -10.0, 0.0)))
    ends = bar - bd.Solid.make_box(200.0, 200.0, 30.0, bd.Plane((-100.0, -100.0, 40.0)))
    keys = [s - bd.Solid.make_cylinder(40.0, 120.0) for s in ends.solids()]
    whole = bs.as_part([shaft.solids()[0], *(k.solids()[0] for k in keys)])
    plan = bs.plan(
        whole.select([1, 2]),
        bs.Process(layer_thickness=2.0, step_over=3.0, fill=bs.Fill(pattern="hatch")),
        axis=Z,
        substrate=40.0,
    )
    path = plan.toolpath
    between = ~path.deposits & (np.roll(path.v, 1) < 50.0) & (path.v > 60.0) & (np.roll(path.radius, 1) == path.radius)
    assert between.any()
    assert path.radius[between].min() >= 70.0
    assert any("0 (" in warning and "obstacles to travels" in warning for warning in plan.warnings)


def test_the_frame_of_the_file_is_kept():
    pytest.importorskip("build123d")
    import build123d as bd

    from fixtures import bodies

    process = bs.Process(layer_thickness=4.0, step_over=3.0)
    straight = bs.plan(bodies.KeyedBand().solid(), process, axis=Z, substrate=44.0)
    place = bd.Location((30.0, -20.0, 7.0), (25.0, 40.0, 0.0))
    moved = bodies.KeyedBand().solid().moved(place)
    tilted = bs.plan(moved, process, axis=axis_from_line((30.0, -20.0, 7.0), tuple(bd.Plane(place).z_dir)), substrate=44.0)
    assert len(straight.toolpath) == len(tilted.toolpath)
    lengths = [p.toolpath.segment_lengths()[1:] for p in (straight, tilted)]
    assert np.sort(lengths[0]) == pytest.approx(np.sort(lengths[1]), abs=1e-6)
    # normals are perpendicular to the axis and point away from it
    p = tilted.axis.axis_from_file(tilted.toolpath.points)
    n = tilted.toolpath.normals @ tilted.axis.rotation.T
    assert np.abs(n[:, 2]).max() < 1e-12
    assert np.einsum("ij,ij->i", n[:, :2], p[:, :2]).min() > 0.0


def test_beads_and_layers_are_numbered(tooth_plan):
    path = tooth_plan.toolpath
    assert (np.diff(path.layer) >= 0).all()
    assert set(np.unique(path.layer)) == set(range(24))
    for layer, fill in zip(tooth_plan.layers, tooth_plan.fills, strict=True):
        mine = path.layer == layer.index
        assert np.array_equal(np.unique(path.bead[mine]), np.arange(len(fill.beads)))
        assert (np.diff(path.bead[mine]) >= 0).all()
    assert np.array_equal(np.unique(path.runs()), np.arange(sum(len(fill.beads) for fill in tooth_plan.fills)))


def same_beads(whole, part):
    """Whether each bead of a plan of some layers has the points, number and speeds that it has in the whole one."""
    assert len(part.layers) < len(whole.layers)
    for path in (whole.toolpath, part.toolpath):
        assert len(np.unique(path.runs())) == len(np.unique(np.stack([path.layer, path.bead])[:, path.deposits], axis=1).T)
    numbers = [layer.index for layer in part.layers]
    mine = np.isin(whole.toolpath.layer, numbers) & whole.toolpath.deposits
    own = part.toolpath.deposits
    order = [np.lexsort((path.bead[on], path.layer[on])) for path, on in ((whole.toolpath, mine), (part.toolpath, own))]
    for name in ("layer", "bead", "points", "kappa", "v", "radius", "speed"):
        ours, theirs = getattr(part.toolpath, name)[own][order[1]], getattr(whole.toolpath, name)[mine][order[0]]
        assert np.array_equal(ours, theirs), name


@pytest.mark.parametrize("layers", ["12:", "3:5", ":1"])
def test_beads_keep_their_numbers_in_a_plan_of_some_layers(tooth_plan, layers):
    same_beads(tooth_plan, bs.plan(tooth_plan.part, tooth_plan.process, layers=layers))


@pytest.mark.parametrize(
    "more",
    [
        {"by_feature": True},
        {"by_feature": True, "contours": 1, "order": "pattern"},
        {"contours": 1, "pattern": {"name": "auto", "angle_deg": (0.0, 45.0)}},
        {"pattern": "zigzag"},
    ],
)
def test_beads_keep_their_numbers_however_they_are_ordered(more, fixture_step):
    # from layer to layer the blades are features of their own; above their middle, others
    part = bs.read_step(fixture_step("propeller"))
    process = bs.Process(layer_thickness=8.0, step_over=3.4, fill=more)
    whole = bs.plan(part, process)
    for layers in ("4:", "1:3"):
        same_beads(whole, bs.plan(part, process, layers=layers))


def test_lengths_and_times_add_up(tooth_plan):
    report = tooth_plan.report()
    beads = [b.length() for fill in tooth_plan.fills for b in fill.beads]
    assert report["totals"]["deposition_length_mm"] == pytest.approx(sum(beads), rel=1e-9)
    assert report["totals"]["deposition_time_s"] == pytest.approx(sum(beads) / 9.0, rel=1e-9)


def test_leads_run_straight_on_with_the_laser_off(tooth_plan):
    process = tooth_plan.process.updated(motion={"lead_in": 3.0, "lead_out": 2.0})
    led = bs.plan(tooth_plan.part, process)
    plain, path = tooth_plan.toolpath, led.toolpath
    assert path.segment_lengths()[path.deposits].sum() == pytest.approx(
        plain.segment_lengths()[plain.deposits].sum(), rel=1e-12
    )
    # laser off, at deposition speed: 5 mm a bead
    beads = len(np.unique(path.runs()))
    runs = ~path.deposits & (path.speed == process.deposition_speed)
    flat = np.concatenate([[0.0], np.hypot(np.diff(path.kappa), np.diff(path.v))])
    assert flat[runs].sum() == pytest.approx(5.0 * beads, rel=1e-9)
    assert not (runs & (np.abs(path.radius - np.round(path.radius, 6)) > 1e-6)).any()


def test_the_laser_is_switched_early(tooth_plan):
    long = tooth_plan.process.updated(fill={"shortest_bead": 3.0})
    early = long.updated(laser={"on_delay": 0.5, "off_delay": 0.8}, motion={"lead_in": 2.0})
    plain, path = (bs.plan(tooth_plan.part, process).toolpath for process in (long, early))
    beads = len(np.unique(path.runs()))
    laid = [p.segment_lengths()[p.deposits].sum() for p in (plain, path)]
    # 0.5 mm more before each start, 0.8 mm less before each end
    assert laid[1] == pytest.approx(laid[0] + beads * (0.5 - 0.8), rel=1e-9)


def test_contours_at_a_speed_of_their_own(tooth_plan):
    # leads and what is laid before the start too: the laser is on with the contour's own speed
    motion = {"contour_speed_mm_s": 6.0, "lead_in": 2.0, "lead_out": 1.0}
    process = tooth_plan.process.updated(fill={"contours": 1}, motion=motion, laser={"on_delay": 0.5})
    plan = bs.plan(tooth_plan.part, process, layers=(0, 2))
    path = plan.toolpath
    kinds = np.array([b.kind.value for fill in plan.fills for b in fill.beads])[path.runs()]
    speeds = path.speed[path.deposits]
    assert np.allclose(speeds[kinds[path.deposits] == "contour"], 6.0)
    assert np.allclose(speeds[kinds[path.deposits] != "contour"], 9.0)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("count", [1, 255, 900])
def test_what_stands_in_a_sweep_by_its_definition(seed, count):
    # box by box: those whose arc and heights meet the sweep's, margin and all, over the angle's jump too
    random = np.random.default_rng(seed)
    n, margin, radius = 60, 1.5, 40.0
    boxes = Obstacles(
        theta=random.uniform(-np.pi, np.pi, n),
        half=random.uniform(0.0, 0.2, n),
        z_low=(z := random.uniform(-50.0, 50.0, n)),
        z_high=z + random.uniform(0.0, 5.0, n),
        radius=random.uniform(40.0, 60.0, n),
    )
    start = np.stack([random.uniform(-9.0, 9.0, count), np.sort(random.uniform(-60.0, 60.0, count))], axis=1)
    end = start + random.normal(size=(count, 2)) * [0.5, 4.0]
    found = boxes.highest(start, end, margin, radius)
    for a, b, value in zip(start, end, found, strict=True):
        reach = 0.5 * abs(b[0] - a[0]) + margin / radius + boxes.half
        turn = 0.5 * (a[0] + b[0]) - boxes.theta
        meets = np.arccos(np.clip(np.cos(turn), -1.0, 1.0)) <= reach
        low, high = min(a[1], b[1]) - margin, max(a[1], b[1]) + margin
        meets &= (boxes.z_high >= low) & (boxes.z_low <= high)
        assert value == boxes.radius[meets].max(initial=0.0)
    assert (found > 0.0).mean() > 0.2 or count == 1
