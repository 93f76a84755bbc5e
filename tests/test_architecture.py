"""Who imports whom, what a scene does not need is not loaded, functions stay short."""

import ast
import json
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).parent.parent
MAY_IMPORT = {
    "meshes": {"meshes"},
    "thermal": {"thermal", "meshes"},
    "mechanics": {"mechanics", "meshes"},
    "coupling": {"coupling", "thermal", "mechanics", "meshes"},
}
HEAVY = {"pyvista", "matplotlib", "skfem", "pint", "pyamg"}
NAMED = re.compile(r"(meshes|thermal|mechanics|coupling)(\.\w+)+(:\w+)?")


def files(package):
    return sorted((ROOT / package).rglob("*.py"))


def tree(file):
    return ast.parse(file.read_text(encoding="utf-8"))


def imported(node):
    """Top-level packages that an import statement, or a text such as "a.b:C", names."""
    if isinstance(node, ast.Import):
        return [alias.name.split(".")[0] for alias in node.names]
    if isinstance(node, ast.ImportFrom) and not node.level:
        return [(node.module or "").split(".")[0]]
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return [node.value.split(".")[0]] if NAMED.fullmatch(node.value) else []
    return []


def at_module_level(node):
    """Statements that run when the module is imported, except those for type checkers."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda):
            continue
        if isinstance(child, ast.If) and "TYPE_CHECKING" in ast.unparse(child.test):
            continue
        yield child
        yield from at_module_level(child)


# ------------------------------------------------------------------------------- the arrows


@pytest.mark.parametrize("package", MAY_IMPORT)
def test_packages_import_only_what_is_below_them(package):
    assert files(package)
    others = set(MAY_IMPORT) - MAY_IMPORT[package]
    found = [
        f"{file.relative_to(ROOT)}:{node.lineno} imports {name}"
        for file in files(package)
        for node in ast.walk(tree(file))
        for name in imported(node)
        if name in others
    ]
    assert found == []


def test_no_package_has_a_file_that_setuptools_leaves_out():
    text = (ROOT / "pyproject.toml").read_text()
    installed = set(re.findall(r'"([\w.]+)"', re.search(r"packages = \[(.*?)\]", text)[1]))
    folders = {".".join(f.parent.relative_to(ROOT).parts) for p in MAY_IMPORT for f in files(p)}
    assert folders == installed


@pytest.mark.parametrize("package", MAY_IMPORT)
def test_heavy_libraries_are_imported_inside_functions_only(package):
    found = [
        f"{file.relative_to(ROOT)}:{node.lineno} imports {name}"
        for file in files(package)
        for node in at_module_level(tree(file))
        for name in imported(node)
        if name in HEAVY
    ]
    assert found == []


def test_imports_at_module_level_are_seen():
    """The walk above finds what it must find, and nothing inside functions."""
    text = "import pint.x\nif 1:\n    from skfem import a\ndef f():\n    import pyvista\n"
    found = [name for node in at_module_level(ast.parse(text)) for name in imported(node)]
    assert found == ["pint", "skfem"]


# ------------------------------------------------------------------------ length of functions


def body_lines(function):
    """Lines of the body without its docstring."""
    body = function.body[1:] if ast.get_docstring(function) is not None else function.body
    return body[-1].end_lineno - body[0].lineno + 1 if body else 0


def test_functions_are_short():
    lengths = {
        f"{file.relative_to(ROOT)}:{node.name}": body_lines(node)
        for package in MAY_IMPORT
        for file in files(package)
        for node in ast.walk(tree(file))
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)
    }
    counts = np.array(list(lengths.values()))
    assert len(counts) > 500
    assert np.median(counts) < 10
    assert np.quantile(counts, 0.9) < 40
    assert [name for name, lines in lengths.items() if lines > 100] == []


# --------------------------------------------------------------------- what a scene does not need

HEATING = {"thermal.line", "thermal.lumped", "thermal.prescribed", "skfem"}
TOUCHING = {"mechanics.clearance", "mechanics.contact"}
OTHER_TERMS = {"mechanics.loads", "mechanics.cable", "mechanics.beam3243"}
DRAWING = {"pyvista", "vtkmodules", "matplotlib", "meshio"}
COMPUTING = {"numpy", "scipy", "numba", "h5py"}
WATCHED = HEATING | TOUCHING | OTHER_TERMS | DRAWING | COMPUTING | {"pint"}

RUN = """
import json, sys
from pathlib import Path
from coupling import casefile, simulation
scene = casefile.from_text(sys.stdin.read(), Path(sys.argv[1]))
outcome = simulation.run(scene)
assert outcome.code == 0, outcome
print(json.dumps(sorted(sys.modules)))
"""

HELP = """
import io, json, sys
from contextlib import redirect_stdout
sys.argv = ["thermobody", *sys.argv[1:]]
from coupling.cli import main
with redirect_stdout(io.StringIO()) as said:
    try:
        main()
    except SystemExit as end:
        assert not end.code, end.code
assert "Usage" in said.getvalue()
print(json.dumps(sorted(sys.modules)))
"""

BAR = """
[time]
end = 0.02
window = 0.01

[section.bar]
kind = "rectangle"
height = 0.01
width = 0.01

[body.bar]
kind = "beam"
start = [0.0, 0.0, 0.0]
end = [1.0, 0.0, 0.0]
elements = 2
section = "bar"
material = "al6061"

[probe.tip]
body = "bar"
at = "end"
"""

CLAMPED = """
[joint.root]
kind = "clamp"
a = { body = "bar", at = "start" }
"""

WARM = """
[thermal]
solver = "line"
initial = 300.0
wall_points = 1

[thermal.source.lamp]
at = { body = "bar", at = "end" }
power = 1.0
"""

HINGED = """
[joint.hinge]
kind = "clearance_revolute"
journal = { body = "bar", at = "start" }
axis = [0, 0, 1]
radius = "25 mm"
clearance = "0.05 mm"
journal_material = "al6061"
bearing_material = "al6061"
angle = 0.0
"""

FALLING = """
[gravity]
acceleration = [0.0, -9.81, 0.0]
"""


def fresh(program, *arguments, text=""):
    """Watched modules that a new process has loaded at its end."""
    ended = subprocess.run(
        [sys.executable, "-c", program, *arguments],
        input=text, capture_output=True, text=True, cwd=ROOT, timeout=120,
    )  # fmt: skip
    assert ended.returncode == 0, ended.stderr
    return set(json.loads(ended.stdout.splitlines()[-1])) & WATCHED


def after_running(tmp_path, text):
    return fresh(RUN, str(tmp_path), text=text)


def test_a_clamped_bar_loads_neither_heat_nor_contact_nor_units(tmp_path):
    loaded = after_running(tmp_path, BAR + CLAMPED)
    assert {"mechanics.beam3243", "h5py", "numba"} <= loaded
    assert loaded & (HEATING | TOUCHING | DRAWING) == set()
    assert loaded & {"mechanics.loads", "mechanics.cable", "pint"} == set()


def test_heat_without_contact_loads_no_contact(tmp_path):
    loaded = after_running(tmp_path, BAR + CLAMPED + WARM)
    assert {"thermal.line", "skfem"} <= loaded
    assert loaded & (TOUCHING | DRAWING | {"thermal.lumped", "pint"}) == set()


def test_heat_by_lumps_does_not_load_finite_elements(tmp_path):
    loaded = after_running(tmp_path, BAR + CLAMPED + WARM.replace('"line"', '"lumped"'))
    assert loaded & HEATING == {"thermal.lumped"}


def test_contact_without_heat_loads_no_heat(tmp_path):
    loaded = after_running(tmp_path, BAR + HINGED + FALLING)
    assert TOUCHING | {"mechanics.loads", "pint"} <= loaded
    assert loaded & (HEATING | DRAWING) == set()


@pytest.mark.parametrize("arguments", [["--help"], ["run", "--help"]])
def test_help_loads_nothing_heavy(arguments):
    loaded = fresh(HELP, *arguments)
    assert loaded == set()
