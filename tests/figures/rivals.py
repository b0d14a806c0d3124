"""Error against time: the analytic engine, OCCT's boolean, and the method of the paper (a mesh, warped, cut by planes).

The mesh is `warped_mesh`'s, as coarse as an error allows that is measured on its outlines; it is cut by planes rho = const in
trimesh. Its segments are timed, no polygons; 1000 layers are ten times 100.

python -m tests.figures.rivals [picture.png]
"""

from __future__ import annotations

import sys
import time
import tracemalloc
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import shapely

import brep_slicer as bs
from brep_slicer.maps import Array
from brep_slicer.region import Layer, slice_solids
from brep_slicer.section import CutSolid, Engine, cut_solids
from brep_slicer.section.boolean import section_by_boolean

from .warped_mesh import TooManyTriangles, warped_mesh

ROOT = Path(__file__).resolve().parent.parent.parent
COUNTS = (16, 100, 1000)
BOOLEAN_LAYERS, JUDGED_LAYERS = 4, 5
# measured errors of the mesh's outlines that are asked for, mm; more triangles than this are not made
ERRORS = (1e-2, 1e-3, 1e-4)
MOST_TRIANGLES, TRIALS = 20_000_000, 3


@dataclass(frozen=True)
class Case:
    """A solid and the radii between which it is cut: from `low` to `margin` below its highest point, mm."""

    name: str
    path: Path
    solid: int
    low: float | None = None
    margin: float = 0.1

    def radii(self, solid: CutSolid, count: int) -> Array:
        """So many radii, evenly spaced."""
        low = self.low if self.low is not None else solid.critical.lowest + 0.1
        return np.linspace(low, solid.critical.highest - self.margin, count)


CASES = (
    Case("helical gear, 20 teeth", ROOT / "fixtures/step/helical_gear.step", 0, 87.6),
    Case("propeller blade", ROOT / "fixtures/step/propeller.step", 1),
    Case("gear_spur_m5z10_f360", ROOT.parent / "shared/step/gear_spur_m5z10_f360.step", 0, 19.0),
    Case("propeller_6land_D", ROOT.parent / "shared/step/propeller_6land_D_5axisslicer.step", 0, 8.5, 1.0),
)


def cut_mesh(mesh, radii: Array) -> list[Array]:
    """Segments (n, 2, 2) in (theta, z) at every radius."""
    import trimesh

    lines, to_3d, _ = trimesh.intersections.mesh_multiplane(mesh, [0.0, 0.0, 0.0], [0.0, 0.0, 1.0], radii)
    return [_in_plane(a, m) for a, m in zip(lines, to_3d, strict=True)]


def _in_plane(flat: Array, matrix: Array) -> Array:
    return flat @ matrix[:2, :2].T + matrix[:2, 3] if len(flat) else np.zeros((0, 2, 2))


def outline_error(segments: list[Array], layers: list[Layer], radii: Array) -> float:
    """The farthest that ends and middles of a mesh outline's segments lie from the exact outline, mm, on some layers."""
    worst = 0.0
    for i in np.linspace(0, len(radii) - 1, JUDGED_LAYERS).astype(int):
        region = layers[i].region
        rings = [loop.moved(k).sample(1e-7) for loop in region.loops for k in (-1, 0, 1)]
        outline = shapely.MultiLineString(rings)
        shapely.prepare(outline)
        flat = segments[i] * np.array([radii[i], 1.0])
        middle = 0.5 * (flat[:, 0] + flat[:, 1])
        points = np.concatenate([flat.reshape(-1, 2), middle])
        points[:, 0] = (
            np.remainder(points[:, 0] + 0.5 * region.closure.length, region.closure.length) - 0.5 * region.closure.length
        )
        some = points[:: max(1, len(points) // 4000)]
        worst = max(worst, float(shapely.distance(outline, shapely.points(some)).max(initial=0.0)))
    return worst


def seconds(function, *args, **kwargs):
    """(seconds, what the function gave)."""
    start = time.perf_counter()
    made = function(*args, **kwargs)
    return time.perf_counter() - start, made


def measure(case: Case) -> list[tuple[str, float, float, list[float]]]:
    """Rows (method, measured error in mm, seconds to prepare, seconds a layer count) for one part."""
    part = bs.read_step(case.path)
    axis = bs.find_axis(part)
    prepare, solids = seconds(lambda: cut_solids(part, axis)[case.solid : case.solid + 1])
    (solid,) = solids
    spans = {n: case.radii(solid, n) for n in COUNTS}
    slice_solids(solids, spans[16][:2])
    taken, layers = {}, {}
    for n in COUNTS:
        taken[n], layers[n] = seconds(slice_solids, solids, spans[n])
    residual = max(layer.certificate.residual for layer in layers[100] if isinstance(layer, Layer))
    fallen = sum(layer.failed or layer.certificate.engine is Engine.BOOLEAN for layer in layers[1000])
    rows = [(f"analytic ({fallen} of 1000 fell back)", residual, prepare, [taken[n] for n in COUNTS])]
    some = spans[100][10 :: 100 // BOOLEAN_LAYERS]
    boolean, _ = seconds(lambda: [section_by_boolean(solid.wrapped, r, critical=solid.critical.radii) for r in some.tolist()])
    rows.append(("boolean (4 layers, scaled)", 1e-7, prepare, [boolean / len(some) * n for n in COUNTS]))
    for error in ERRORS:
        rows.append(_mesh_row(solid, error, spans, layers[100]))
    return rows


def _mesh_row(solid: CutSolid, wanted: float, spans: dict[int, Array], layers: list[Layer]) -> tuple:
    """The row of the coarsest mesh whose outlines are as near as wanted."""
    deviation = 0.9 * wanted
    for _ in range(TRIALS):
        try:
            ready, mesh = seconds(warped_mesh, solid, deviation, spans[100][0], spans[100][-1], MOST_TRIANGLES)
        except TooManyTriangles:
            return f"mesh to {wanted:g} mm: more than {MOST_TRIANGLES} triangles", float("nan"), float("nan"), []
        few, _ = seconds(cut_mesh, mesh, spans[16])
        hundred, segments = seconds(cut_mesh, mesh, spans[100])
        error = outline_error(segments, layers, spans[100])
        if error <= wanted:
            break
        deviation *= 0.9 * wanted / error
    label = f"mesh to {wanted:g} mm, {len(mesh.faces)} triangles"
    return label, error, ready, [few, hundred, 10.0 * hundred]


def memory(case: Case) -> float:
    """MB that 1000 layers take."""
    part = bs.read_step(case.path)
    solids = cut_solids(part, bs.find_axis(part))[case.solid : case.solid + 1]
    radii = case.radii(solids[0], 1000)
    tracemalloc.start()
    layers = slice_solids(solids, radii)
    size = tracemalloc.get_traced_memory()[0] / 1e6
    tracemalloc.stop()
    return size if layers else 0.0


def draw(found: dict[str, list], path: Path) -> None:
    """Seconds for 100 layers against the measured error, a panel a part."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(12, 3.4), layout="constrained")
    axes = figure.subplots(1, len(found), sharey=True)
    colours = {"analytic": "tab:green", "boolean": "tab:purple", "mesh": "tab:orange"}
    for ax, (name, rows) in zip(axes, found.items(), strict=True):
        for method, colour in colours.items():
            mine = [(error, cuts[1]) for label, error, _, cuts in rows if label.startswith(method) and cuts]
            if mine:
                ax.loglog(*zip(*mine, strict=True), "o-", color=colour, label={"mesh": "warped mesh"}.get(method, method))
        ax.set_title(name, fontsize=9)
        ax.set_xlabel("outline error, mm")
        ax.set_xlim(1e-14, 1.0)
        ax.grid(alpha=0.3)
    axes[0].set_ylabel("seconds for 100 layers")
    axes[0].legend(fontsize=8)
    figure.savefig(path, dpi=110)


def main(arguments: list[str]) -> None:
    found = {}
    for case in CASES:
        if not case.path.exists():
            print(f"{case.name}: {case.path} is not here")
            continue
        print(case.name, flush=True)
        found[case.name] = measure(case)
        for label, error, prepare, cuts in found[case.name]:
            figures = "  ".join(f"{n}: {t:.3g} s" for n, t in zip(COUNTS, cuts, strict=False))
            print(f"  {label}: error {error:.1e} mm, prepared in {prepare:.2f} s, {figures}", flush=True)
    print(f"1000 layers of the {CASES[0].name} take {memory(CASES[0]):.0f} MB")
    if arguments:
        draw(found, Path(arguments[0]))


if __name__ == "__main__":
    main(sys.argv[1:])
