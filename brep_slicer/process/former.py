"""What names of the old form without tables are called now.

In: nothing. Out: words to put behind a name that is not where it belongs.
"""

from __future__ import annotations

# Names of the form without tables that are gone: what is written now.
RENAMED = {
    "hatch": 'the pattern says it: [fill] pattern = { name = "contours", count = 2, skeleton = false } for contours alone',
    "fit": "it is outline_position in [fill] now",
    "rest_s": "it is min_interpass_time_s in [fill] now",
    "speed_follows_spacing": "it is adaptive_speed in [fill] now",
    "hatch_angles_deg": 'it is angle_deg of the pattern now: [fill] pattern = { name = "hatch", angle_deg = [0, 90] }',
    "hatch_angle_step_deg": 'it is angle_step_deg of the pattern now: [fill] pattern = { name = "hatch", angle_step_deg = 67 }',
    "both_ways": 'it is a parameter of the pattern now: [fill] pattern = { name = "hatch", both_ways = false }',
    "stretch": 'it is a parameter of the pattern now: [fill] pattern = { name = "hatch", stretch = 0.2 }',
    "starts": 'it is a parameter of the pattern now: [fill] pattern = { name = "helix", starts = 2 }',
    "left_handed": 'it is a parameter of the pattern now: [fill] pattern = { name = "helix", left_handed = true }',
    "closing_rings": 'it is a parameter of the pattern now: [fill] pattern = { name = "helix", closing_rings = true }',
    "start_angle_deg": 'it is a parameter of the pattern now: [fill] pattern = { name = "helix", start_angle_deg = 30 }',
    "powder_feed_g_s": "it is feed_g_s in [powder] now",
    "powder_density_g_cm3": "it is density_g_cm3 in [powder] now",
    "laser_power_w": "it is power_w in [laser] now",
    "laser_on_delay": "it is on_delay in [laser] now",
    "laser_off_delay": "it is off_delay in [laser] now",
}
