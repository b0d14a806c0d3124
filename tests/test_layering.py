"""The layout is the data flow: no module imports from a later stage, and only kernel/ imports OCP."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import pytest

PACKAGE = Path(__file__).resolve().parent.parent / "brep_slicer"
# in the order of the flow; what stands in one row may not import from a later row
FLOW = [
    {"errors", "extensions", "groups", "maps", "notices", "version", "wording"},
    {"layers"},
    {"curves", "geometry"},
    {"kernel"},
    {"field", "part"},
    {"process"},
    {"substrate"},
    {"section"},
    {"region"},
    {"fill"},
    {"toolpath"},
    {"proof"},
    {"inspection", "planning"},
    {"output"},
    {"testing"},
    {"cli"},
    {"__main__"},
]
RANK = {name: i for i, names in enumerate(FLOW) for name in names}
MODULES = sorted(p for p in PACKAGE.rglob("*.py") if p != PACKAGE / "__init__.py")


def _stage(path: Path) -> str:
    return path.relative_to(PACKAGE).parts[0].removesuffix(".py")


def _imports(path: Path) -> list[tuple[str, bool]]:
    """(top-level stage or outside package, whether it is only for type checking) of every import in a module."""
    tree = ast.parse(path.read_text())
    typing_only = {
        id(inner)
        for node in ast.walk(tree)
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test)
        for inner in ast.walk(node)
    }
    package = ("brep_slicer", *path.relative_to(PACKAGE).parts[:-1])
    found = []
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            found += [(alias.name, id(node) in typing_only) for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            base = ".".join(package[: len(package) - node.level + 1]) if node.level else ""
            found.append((".".join(x for x in (base, node.module or "") if x), id(node) in typing_only))
    return found


@pytest.mark.parametrize("path", MODULES, ids=lambda p: str(p.relative_to(PACKAGE)))
def test_no_module_reaches_back_up_the_flow(path):
    stage = _stage(path)
    for name, typing_only in _imports(path):
        parts = name.split(".")
        if parts[0] == "OCP":
            assert stage == "kernel", f"{path} imports {name}"
        if parts[0] == "brep_slicer" and len(parts) > 1 and not typing_only:
            assert RANK[parts[1]] <= RANK[stage], f"{stage} imports {name}, which comes later in the flow"


@pytest.mark.parametrize("path", MODULES, ids=lambda p: str(p.relative_to(PACKAGE)))
def test_modules_and_functions_are_short_and_described(path):
    text = path.read_text()
    assert len(text.splitlines()) <= 500
    tree = ast.parse(text)
    assert ast.get_docstring(tree), f"{path} has no docstring"
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef) and _stage(path) != "cli":
            doc = node.body[0] if isinstance(node.body[0], ast.Expr) and isinstance(node.body[0].value, ast.Constant) else None
            length = (node.end_lineno or 0) - node.lineno + 1 - ((doc.end_lineno - doc.lineno + 1) if doc else 0)
            assert length <= 50, f"{path}: {node.name} has {length} lines"


def _modules_imported(path: Path) -> set[Path]:
    """The package's modules that a module imports, at its top or within a function, but for what type checkers alone see."""
    tree = ast.parse(path.read_text())
    typing_only = {
        id(inner)
        for node in ast.walk(tree)
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test)
        for inner in ast.walk(node)
    }
    names = []
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and id(node) not in typing_only:
            base = path.parents[node.level - 1] if node.level else PACKAGE.parent
            stem = base.joinpath(*(node.module or "").split(".")) if node.module else base
            names += [stem, *(stem / alias.name for alias in node.names)]
    found = {p for stem in names for p in (stem.with_suffix(".py"), stem / "__init__.py") if p.exists()}
    return {p for p in found if PACKAGE in p.parents and p.name != "__init__.py"}


def test_no_import_goes_round_in_a_circle():
    imports = {path: _modules_imported(path) for path in MODULES if path.name != "__init__.py"}
    left = dict(imports)
    assert sum(map(len, imports.values())) > 300, "the imports are not found any more"
    while True:
        # modules that import none of those left are in no circle
        ends = [path for path, others in left.items() if not others & left.keys()]
        if not ends:
            break
        for path in ends:
            del left[path]
    assert not left, f"these import one another: {sorted(str(p.relative_to(PACKAGE)) for p in left)}"


def _loaded_by(statement: str) -> set[str]:
    code = f"import sys; {statement}; print(' '.join(sorted(m for m in sys.modules if '.' not in m)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=PACKAGE.parent)
    return set(done.stdout.split())


def test_import_is_light():
    assert not _loaded_by("import brep_slicer") & {"OCP", "numpy", "scipy", "matplotlib", "shapely"}


def test_region_and_fill_do_not_need_a_kernel():
    assert "OCP" not in _loaded_by("import brep_slicer.region, brep_slicer.fill, brep_slicer.toolpath, brep_slicer.planning")
