"""Draw the steps of docs/sections.md: python docs/section_pictures.py (from the project's root)."""

from __future__ import annotations

from dataclasses import fields, replace
from pathlib import Path

import build123d as bd
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import brep_slicer as bs
from brep_slicer.field import radii_of
from brep_slicer.geometry import SurfaceKind
from brep_slicer.output.pictures.scene import part_mesh, top_of
from brep_slicer.output.pictures.toolpath import rendered
from brep_slicer.output.pictures.views import View
from brep_slicer.section import CutSolid, cut_solids
from brep_slicer.section.analytic import sections_by_analysis
from brep_slicer.section.analytic.guides import grid_of_face
from brep_slicer.section.analytic.nodes import find_nodes
from brep_slicer.toolpath import Toolpath

HERE = Path(__file__).parent
Z = bs.axis_from_text("Z")
RADIUS = 171.0


def ready(part) -> CutSolid:
    """The first solid of a file or of a build123d shape."""
    return cut_solids(bs.read_step(part) if isinstance(part, str) else bs.as_part(part), Z)[0]


def unrolled_edges(solid: CutSolid):
    """(number, points, kappa at RADIUS, v) of every edge that stands beyond the shaft."""
    for number, edge in enumerate(solid.brep.edges):
        if edge.curve is not None:
            p = edge.curve.points(np.linspace(edge.first, edge.last, 120))
            if radii_of(p).max() > 150.5:
                yield number, p, RADIUS * np.arctan2(p[:, 1], p[:, 0]), p[:, 2]


def legend(ax: Axes, place: str) -> None:
    """Each label once, however many lines have it."""
    handles, labels = ax.get_legend_handles_labels()
    unique = dict(zip(labels, handles, strict=True))
    ax.legend(unique.values(), unique.keys(), fontsize=10, loc=place)


def effective_radii(ax: Axes, tooth: CutSolid) -> None:
    """Step 1: rho of every vertex, level faces as lines."""
    for radius in tooth.critical.level:
        ax.axhline(radius, color="tab:orange", lw=3, alpha=0.5)
    ax.plot(np.sort(tooth.stretches.vertex_rho), "k.", ms=7)
    ax.set(title="1  effective radii: vertices on level faces\nhave exactly their radius", xlabel="vertex", ylabel="ρ, mm")


def stretches(ax: Axes, box: CutSolid) -> None:
    """Step 2: rho along an edge of a box on a shaft, cut where it turns."""
    number = int(np.flatnonzero(np.bincount(box.stretches.edge) == 2)[0])
    edge = box.brep.edges[number]
    for k in np.flatnonzero(box.stretches.edge == number):
        t = np.linspace(*box.stretches.t[k], 100)
        ax.plot(t, radii_of(edge.curve.points(t)), lw=3)
    ax.axhline(81.0, color="k", ls="--", lw=1)
    ax.set(
        title="2  stretches: along each, ρ rises or falls,\nso a layer crosses it once or not at all",
        xlabel="t",
        ylabel="ρ, mm",
    )


def nodes(ax: Axes, tooth: CutSolid) -> None:
    """Step 3: where the edges of a tooth meet a layer."""
    for _, _, kappa, v in unrolled_edges(tooth):
        ax.plot(kappa, v, color="0.7", lw=1.5)
    found = find_nodes(tooth.brep, tooth.stretches, np.array([RADIUS]))
    p = found.points
    ax.plot(RADIUS * np.arctan2(p[:, 1], p[:, 0]), p[:, 2], "ko")
    ax.margins(0.28, 0.14)
    for x, y, edge in zip(RADIUS * np.arctan2(p[:, 1], p[:, 0]), p[:, 2], found.edge, strict=True):
        ax.annotate(f"edge {edge}", (x, y), textcoords="offset points", xytext=(6, 6), fontsize=11)
    ax.set(
        title=f"3  nodes: (stretch, layer), here R = {RADIUS:g};\nthe two faces of an edge share it",
        xlabel="κ, mm",
        ylabel="v, mm",
    )


def arcs(ax: Axes, tooth: CutSolid) -> None:
    """Step 4: one arc a face from node to node."""
    ((loops, _),) = sections_by_analysis(tooth, np.array([RADIUS]))
    for curve in loops[0].curves:
        p = curve.sample(1e-3)
        (line,) = ax.plot(*p.T, lw=3)
        ax.annotate(
            f"{curve.kind.value}",
            p[len(p) // 2],
            color=line.get_color(),
            fontsize=11,
            xytext=(5, 4),
            textcoords="offset points",
        )
        ax.plot(*p[[0, -1]].T, "ko", ms=4)
    ax.margins(0.18, 0.12)
    ax.set(
        title="4  arcs: on every face from the node where ρ\nfalls through R to the one where it rises",
        xlabel="κ, mm",
        ylabel="v, mm",
    )


def closed_curves(ax: Axes, island: CutSolid) -> None:
    """Step 5: level lines on a sphere's grid, closed round its peak."""
    face = next(f for f in island.brep.faces if f.surface.kind is SurfaceKind.SPHERE)
    peak = island.critical.inside[face.index]
    grid = grid_of_face(face, peak)
    high = float(radii_of(face.surface.points(peak)).max())
    for drop in (0.02, 0.5, 2.0, 4.0):
        for line in grid.level_lines(high - drop):
            ax.plot(*np.degrees(line).T, label=f"{drop:g} mm below the top")
    ax.plot(*np.degrees(peak).T, "k^")
    ax.set_ylim(-92.0, 50.0)
    legend(ax, "lower left")
    ax.set(
        title="5  closed curves without a node: found round\nthe stationary points of ρ (here of a sphere)",
        xlabel="u, °",
        ylabel="v, °",
    )


def hot_edges(ax: Axes, cam: CutSolid) -> None:
    """Step 6: a cam's flank leaves the base circle as a tangent."""
    for radius, colour in ((40.0, "tab:red"), (40.001, "tab:blue"), (40.01, "tab:green")):
        ((loops, _),) = sections_by_analysis(cam, np.array([radius]))
        for loop in loops:
            ax.plot(*loop.sample(1e-3).T, color=colour, label=f"R = {radius:g}")
    legend(ax, "center right")
    ax.set(
        title="6  hot edges: at R = 40 the section ends at the\nedges of tangency; 1 µm above, 0.3 mm inside",
        xlabel="κ, mm",
        ylabel="v, mm",
    )
    low = min(float(loop.sample(1e-3)[:, 0].min()) for loop in sections_by_analysis(cam, np.array([40.0]))[0][0])
    ax.set_xlim(low - 0.3, low + 2.5)


def loops_closed(ax: Axes, tooth: CutSolid) -> None:
    """Step 7: the loop with the metal on its left."""
    ((loops, certificate),) = sections_by_analysis(tooth, np.array([RADIUS]))
    for loop in loops:
        p = loop.sample(1e-3)
        ax.fill(*p.T, color="0.85")
        ax.plot(*p.T, "k-", lw=1)
        for curve in loop.curves:
            a, b = curve.points(np.array([0.45, 0.55]))
            ax.annotate("", b, a, arrowprops={"arrowstyle": "->", "lw": 2})
    ax.set(
        title="7  loops by the nodes' numbers, metal left;\n"
        f"residual {certificate.residual:.0e} mm, jog {certificate.jog:.0e} mm",
        xlabel="κ, mm",
        ylabel="v, mm",
    )


def cut_solid(ax: Axes) -> None:
    """The tooth without what lies beyond the layer, the section on its cylinder."""
    part = bs.read_step("fixtures/step/helical_gear_tooth.step")
    plan = bs.plan(part, bs.Process(layer_thickness=1.4, step_over=3.4), axis=Z, layers=(14, 15))
    path = plan.toolpath
    plan = replace(plan, toolpath=Toolpath(**{field.name: getattr(path, field.name)[:0] for field in fields(path)}))
    mesh = part_mesh(plan, 0.05)
    rho = np.hypot(mesh.points[:, 0], mesh.points[:, 1])[mesh.triangles]
    lid = (rho > top_of(plan) - 1e-6).all(axis=1)
    mesh = replace(mesh, colors=np.where(lid[:, None], np.array([1.0, 0.62, 0.25]), mesh.colors))
    middle = mesh.points[mesh.triangles[lid]].mean(axis=(0, 1))
    towards = np.array([0.88, -0.22, 0.42])
    right = np.cross([0.0, 0.0, 1.0], towards)
    towards, right = towards / np.linalg.norm(towards), right / np.linalg.norm(right)
    view = View(right=right, up=np.cross(towards, right), towards=towards, box=(0.0, 0.0, 1.0, 1.0))
    x, y = view.flat(middle[None])[0]
    image = rendered(plan, mesh, replace(view, box=(x - 50, y - 46, x + 50, y + 46)), (920, 1000))
    ax.imshow(image, interpolation="antialiased")
    ax.axis("off")
    ax.set_title(f"the solid cut by the cylinder R = {RADIUS:g};\nunrolled, the orange section is what is filled")


def main() -> None:
    """docs/sections.png: the solid cut, and the seven steps."""
    tooth, box, cam = (ready(f"fixtures/step/{n}.step") for n in ("helical_gear_tooth", "box_on_shaft", "cam"))
    shaft = bd.Solid.make_cylinder(40, 60, bd.Plane(origin=(0, 0, -30)))
    island = ready(shaft + bd.Solid.make_sphere(15, bd.Plane(origin=(38, 3, 5))))
    figure = Figure(figsize=(16, 8), layout="constrained")
    axes = figure.subplots(2, 4).ravel()
    cut_solid(axes[0])
    effective_radii(axes[1], tooth)
    stretches(axes[2], box)
    nodes(axes[3], tooth)
    arcs(axes[4], tooth)
    closed_curves(axes[5], island)
    hot_edges(axes[6], cam)
    loops_closed(axes[7], tooth)
    for ax in axes:
        ax.title.set_fontsize(11)
        ax.xaxis.label.set_fontsize(11)
        ax.yaxis.label.set_fontsize(11)
    figure.savefig(HERE / "sections.png", dpi=80)


if __name__ == "__main__":
    main()
