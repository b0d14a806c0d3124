"""Process parameters: what is refused, what is assumed, what a file may say."""

from __future__ import annotations

import math

import pytest

import brep_slicer as bs
from brep_slicer import InputError, Process, read_process
from brep_slicer.process import LastLayer


@pytest.mark.parametrize("name", ["layer_thickness", "step_over", "bead_width", "chord", "deposition_speed_mm_s"])
@pytest.mark.parametrize("value", [0.0, -1.0, math.nan, math.inf])
def test_values_out_of_range_are_named(name, value):
    given = {"layer_thickness": 1.0, "step_over": 1.0, name: value}
    with pytest.raises(InputError, match=name):
        Process(**given)


def test_assumed_values_are_named_and_given_ones_are_not():
    process = Process(layer_thickness=1.4, step_over=3.4, deposition_speed_mm_s=12.0)
    assert process.assumed()["bead_width"] == pytest.approx(1.44 * 3.4)
    assert "deposition_speed_mm_s" not in process.assumed()
    assert process.as_dict()["inset"] == pytest.approx(0.72 * 3.4)
    assert process.as_dict()["laser_power_w"] is None


def test_angles_by_layer():
    process = Process(layer_thickness=1, step_over=1, hatch_angles=(0.0, 1.0), hatch_angle_step=0.1)
    assert [process.hatch_angle(i) for i in range(3)] == pytest.approx([0.0, 1.1, 0.2])


def test_radii_must_increase():
    with pytest.raises(InputError, match="the radii must increase"):
        Process(layer_thickness=1, step_over=1, radii=(10.0, 10.0))


def test_toml(tmp_path):
    path = tmp_path / "process.toml"
    path.write_text('layer_thickness = 1.4\nstep_over = 3.4\nhatch_angles_deg = [0, 90]\nlast_layer = "drop"\n')
    process = read_process(path, step_over=3.0)
    assert process.step_over == 3.0
    assert process.last_layer is LastLayer.DROP
    assert process.hatch_angles == pytest.approx((0.0, math.pi / 2))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("layer_thickness = 1\nstep_over = 1\nspeed = 3", "speed is no process parameter"),
        ("layer_thickness = 1", "step_over not given"),
        ('layer_thickness = 1\nstep_over = 1\nlast_layer = "x"', "must be one of keep, drop, stretch"),
        ("layer_thickness = ", "not a readable TOML file"),
        ("layer_thickness = 1\nstep_over = 1\ncontours = 1.5", "must be a whole number"),
    ],
)
def test_bad_toml_is_one_clear_line(tmp_path, text, said):
    path = tmp_path / "process.toml"
    path.write_text(text)
    with pytest.raises(InputError, match=said) as caught:
        read_process(path)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_the_metal_balance_of_the_paper():
    # Table 3: t = 1.4 mm, d = 3.4 mm, 9 mm/s; with 7.99 g/cm**3 and 0.4 g/s of powder the catchment is 0.86
    process = bs.Process(layer_thickness=1.4, step_over=3.4, powder_density_g_cm3=7.99, powder_feed_g_s=0.4)
    assert process.catchment == pytest.approx(1.4 * 3.4 * 9.0 * 7.99e-3 / 0.4)
    assert process.catchment == pytest.approx(0.86, abs=0.005)
    with pytest.raises(bs.InputError, match="times the powder that is fed"):
        bs.Process(layer_thickness=1.4, step_over=3.4, powder_density_g_cm3=7.99, powder_feed_g_s=0.1)
    assert bs.Process(layer_thickness=1.4, step_over=3.4).catchment is None


def test_fit_says_where_the_outermost_bead_runs():
    for fit, inset in ((bs.Fit.IN, 2.45), (bs.Fit.ON, 0.0), (bs.Fit.OUT, -2.45)):
        assert bs.Process(layer_thickness=1.4, step_over=3.4, bead_width=4.9, fit=fit).value("inset") == pytest.approx(inset)
