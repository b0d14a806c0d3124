"""A script as a user of the README writes it, for type checkers: every line of it has to pass at their strictest.

It is checked by `mypy --strict` and pyright against the installed package (tests/test_typing.py), and run there, too.
"""

from __future__ import annotations

import sys
from pathlib import Path

import brep_slicer as bs


def planned(path: Path) -> bs.Plan:
    part = bs.read_step(path)
    process = bs.Process(
        layer_thickness=1.4,
        step_over=3.4,
        rules=[{"layers": "0:2", "contours": 2}, bs.Rule(layers="2:", changes={"pattern": "zigzag"})],
        fill=bs.Fill(contours=1, outline_position="in", order="shortest", pattern=bs.Hatch(angle_deg=(0, 45.0))),
        motion={"chord": 0.01},
        layers=bs.Layers(last_layer=bs.LastLayer.KEEP),
    )
    return bs.plan(part, process, axis="Z", layers="0:2")


def main(path: Path) -> None:
    plan = planned(path)
    pattern: bs.Pattern = plan.process.fill.pattern
    angles: tuple[float, ...] = pattern.angle_deg if isinstance(pattern, bs.Hatch) else ()
    for layer in plan.layers:
        area: float = layer.area
        certificate: bs.Certificate = layer.certificate
        print(layer.radius, area, certificate.engine.value, layer.region.pieces[0].area())
    print(bs.__version__, pattern.name, angles, plan.toolpath.points.shape, sorted(plan.report()))
    axis: bs.Axis = bs.find_axis(plan.part)
    sections = bs.slice_part(plan.part, [160.0, 170.0], axis=axis, engine="analytic")
    radii: list[float] = [section.radius for section in sections]
    cylinders = [cylinder.radius for cylinder in bs.coaxial_cylinders(plan.part)]
    print(radii, cylinders, bs.inspect_part(plan.part).substrate_radius)
    try:
        bs.read_step("there is no such file.step")
    except bs.InputError as error:
        print(error)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
