"""A case with its beams as solids in 3D: against the same case by beams, and closed forms."""

import csv
import shutil
import sys
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from coupling import casefile, simulation
from coupling.cli import app
from coupling.continuum import solids
from coupling.continuum_transfer import from_mesh
from coupling.errors import BadCase
from coupling.model import build
from coupling.reading import Results
from meshes.solids import box

CASES = Path(__file__).parents[1] / "cases"
LENGTH, RADIUS, WALL = 2.0, 0.04, 0.004
MODULUS, EXPANSION, DENSITY = 70e9, 23e-6, 2700.0
HOT, COLD = 333.15, 293.15
CASE = f"""
[time]
end = "20 ms"
window = "10 ms"
[material.metal]
density = {DENSITY}
youngs_modulus = {MODULUS}
poissons_ratio = 0.33
expansion = {EXPANSION}
conductivity = 160.0
heat_capacity = 900.0
[section.pipe]
kind = "tube"
mean_radius = {RADIUS}
thickness = {WALL}
[body.boom]
kind = "beam"
start = [0, 0, 0]
end = [{LENGTH}, 0, 0]
elements = 4
normal = [0, 1, 0]
section = "pipe"
material = "metal"
damping = "1 ms"
[joint.root]
kind = "clamp"
a = {{ body = "boom", at = "start" }}
[probe.tip]
body = "boom"
at = "end"
"""
HEAT = f"""
[thermal]
solver = "line"
initial = {COLD}
[thermal.wall.sun]
body = "boom"
side = [0, 1, 0]
hot = {{ start = {HOT}, end = {HOT} }}
cold = {{ start = {COLD}, end = {COLD} }}
"""
COARSE = ("mechanics.solver=continuum", "mechanics.round=8")


def scene_of(text, tmp_path, *settings):
    file = tmp_path / "case.toml"
    file.write_text(text)
    return casefile.read(file, settings)


def final_tip(text, tmp_path, *settings):
    """Path of the tip of an analysis or run."""
    from coupling import analyses

    scene = scene_of(text, tmp_path, *settings)
    run = simulation.run if scene.analysis.kind == "dynamics" else analyses.run
    outcome = run(scene, tmp_path / "out")
    assert outcome.code == 0, outcome.reason
    with Results.open(outcome.folder) as results:
        return results["probes/tip/position"], outcome.folder


# ------------------------------------------------------------------------------- against beams


@pytest.mark.parametrize("heat", ["line", "wall", "solid"])
def test_heated_boom_bows_and_grows_as_the_closed_form_says(heat, tmp_path):
    settings = ("analysis.kind=statics", "analysis.steps=2", *COARSE)
    text = HEAT.replace('"line"', f'"{heat}"')
    path, _ = final_tip(CASE + text, tmp_path, *settings)
    curvature = EXPANSION * (HOT - COLD) / (2.0 * RADIUS)
    bow = 0.5 * curvature * LENGTH**2
    growth = EXPANSION * 0.5 * (HOT - COLD) * LENGTH
    chord = bow**2 * 2.0 / 3.0 / LENGTH  # by which the bow shortens the projection
    assert -path[-1, 1] == pytest.approx(bow, rel=0.01)
    assert path[-1, 0] - LENGTH + chord == pytest.approx(growth, rel=0.01)


def test_beam_and_solid_bow_alike(tmp_path):
    settings = ("analysis.kind=statics", "analysis.steps=2")
    solid, _ = final_tip(CASE + HEAT, tmp_path, *settings, *COARSE)
    beam, _ = final_tip(CASE + HEAT, tmp_path, *settings)
    assert solid[-1] - solid[0] == pytest.approx(beam[-1] - beam[0], rel=0.01, abs=1e-9)


def test_frequencies_are_those_of_the_clamped_tube(tmp_path):
    from coupling import analyses

    settings = ("analysis.kind=modes", "analysis.count=2", *COARSE)
    scene = scene_of(CASE, tmp_path, *settings)
    with Results.open(analyses.run(scene, tmp_path / "out").folder) as results:
        found = results["modes/frequency"]
    area = 2.0 * np.pi * RADIUS * WALL
    second = np.pi * RADIUS**3 * WALL * (1.0 + 0.25 * (WALL / RADIUS) ** 2)
    exact = 1.8751**2 / (2.0 * np.pi * LENGTH**2) * np.sqrt(MODULUS * second / DENSITY / area)
    assert found == pytest.approx([exact, exact], rel=0.01)


def test_motion_follows_that_of_the_beam(tmp_path):
    solid, folder = final_tip(CASE + HEAT, tmp_path, *COARSE)
    beam, _ = final_tip(CASE + HEAT, tmp_path)
    assert solid[:, 1] - solid[0, 1] == pytest.approx(beam[:, 1] - beam[0, 1], rel=0.02, abs=1e-6)
    with Results.open(folder) as results:
        ledger = results.table("ledger")
    assert abs(ledger["defect"][-1]) < 1e-4 * ledger["strain"][-1]


# -------------------------------------------------------------------------------- temperatures


@pytest.mark.parametrize(
    ("heat", "settings"),
    [
        ("line", ()),
        ("wall", ("thermal.wall_points=8",)),
        ("solid", ()),
        ("solid", ("thermal.order=2", "thermal.refine=2")),
    ],
)
def test_nodes_read_a_linear_field_as_it_is_and_give_back_all_heat(heat, settings, tmp_path):
    text = HEAT.replace('"line"', f'"{heat}"')
    scene = scene_of(CASE + text, tmp_path, *COARSE, *settings)
    model = build(scene)
    rows, x = model.layout.point_index["boom"], model.pair.heat_solver.x
    own = model.pair.heat_solver.regions["boom"]
    field = np.array([3.0, 40.0, -70.0])
    read = model.pair.transfer.read(300.0 + x @ field)[rows, 0]
    # a polygon of 24 sides has its walls a little off the circle
    slack = 1e-9 if "thermal.order=2" in settings or heat != "solid" else 0.03 * WALL * 2e3
    assert read == pytest.approx(300.0 + model.layout.x[rows] @ field, abs=slack)
    assert model.pair.transfer.read(np.full(len(x), 250.0))[rows, 0] == pytest.approx(250.0)
    heat_there = np.zeros(len(model.layout.x))
    heat_there[rows] = np.arange(len(rows))
    given = model.pair.transfer.deposit(heat_there)
    assert given[own].sum() == pytest.approx(heat_there.sum())


def test_coinciding_nodes_read_their_own_temperature(tmp_path):
    text = HEAT.replace('"line"', '"solid"')
    scene = scene_of(CASE + text, tmp_path, "mechanics.solver=continuum", "thermal.order=2")
    model = build(scene)
    T = 300.0 + np.random.default_rng(1).random(len(model.pair.heat_solver.x))
    rows = model.layout.point_index["boom"]
    assert len(rows) == len(T)
    assert np.array_equal(model.pair.transfer.read(T)[rows, 0], T)


def test_cells_of_another_mesh_interpolate_quadratics_exactly():
    fine, coarse = box((1, 1, 1), (3, 2, 4), 1), box((1, 1, 1), (2, 2, 1), 2, "hexahedron27")
    cells = coarse.cells["hexahedron27"]
    block = from_mesh(fine.points, fine.points, coarse.points, coarse.points, "hexahedron27", cells)

    def field(x):
        return 1.0 + x[:, 0] ** 2 - 2.0 * x[:, 1] * x[:, 2] + x[:, 2] ** 2

    assert block @ field(coarse.points) == pytest.approx(field(fine.points), abs=1e-12)


def test_cross_sections_have_the_area_and_moments_of_the_tube(tmp_path):
    solid = solids(scene_of(CASE, tmp_path, *COARSE))["boom"]
    y, z = solid.local[solid.planes[0], 1:].T
    second = np.pi * RADIUS**3 * WALL * (1.0 + 0.25 * (WALL / RADIUS) ** 2)
    assert solid.areas.sum() == pytest.approx(2.0 * np.pi * RADIUS * WALL, rel=2e-3)
    assert solid.areas @ y**2 == pytest.approx(second, rel=0.01)
    assert abs(solid.areas @ (y * z)) < 1e-9 * second


# ------------------------------------------------------------------------------------ results


def test_cells_are_recorded_and_exported(tmp_path):
    import meshio

    from coupling.export import export

    settings = ("analysis.kind=statics", "analysis.steps=2", *COARSE)
    _, folder = final_tip(CASE + HEAT, tmp_path, *settings)
    files = export(folder)
    (last,) = [f for f in files if f.name == "solids_00002.vtu"]
    mesh = meshio.read(last)
    assert {c.type for c in mesh.cells} == {"hexahedron20"}
    T = mesh.point_data["temperature"]
    outer = 0.5 * (HOT - COLD) * (1.0 + 0.5 * WALL / RADIUS)  # at the outside of the wall
    assert np.ptp(T) == pytest.approx(2.0 * outer, rel=1e-3)
    assert np.isfinite(mesh.cell_data["von_mises_stress"][0]).all()


def test_resumed_run_ends_as_an_uninterrupted_one(tmp_path):
    short = scene_of(CASE + HEAT, tmp_path, *COARSE, "time.end=10 ms")
    simulation.run(short, tmp_path / "a")
    whole = scene_of(CASE + HEAT, tmp_path, *COARSE)
    simulation.run(whole, tmp_path / "a", resume=True)
    simulation.run(whole, tmp_path / "b")
    ends = []
    for name in "ab":
        with Results.open(tmp_path / name / "001") as results:
            ends.append(results["probes/tip/position"][-1])
    assert np.array_equal(*ends)


@pytest.mark.slow
@pytest.mark.parametrize(("case", "end"), [("sunlit_boom", "2 s"), ("arm_rotation", "0.2 s")])
def test_shipped_cases_run_as_a_continuum_from_the_command_line(case, end, tmp_path):
    folder = shutil.copytree(CASES / case, tmp_path / case)
    chosen = [*COARSE, f"time.end={end}", "output.export=[]"]
    arguments = [a for setting in chosen for a in ("--set", setting)]
    command = ["run", str(folder), "--output", str(tmp_path / "out"), *arguments]
    done = CliRunner().invoke(app, command)
    assert done.exit_code == 0, done.output
    with (tmp_path / "out" / "001" / "probes.csv").open() as file:
        last = list(csv.DictReader(file))[-1]
    assert float(last["tip.x [m]"]) == pytest.approx(63.5, abs=0.01)


# -------------------------------------------------------------------------------------- errors


def problems(text, tmp_path, *settings):
    with pytest.raises(BadCase) as caught:
        scene_of(text, tmp_path, *settings)
    return {p.path: p.text for p in caught.value.problems}


def test_beams_take_no_keys_of_the_continuum(tmp_path):
    found = problems(CASE + "[mechanics]\nround = 8\n[mechanics.mesh.boom]\nalong = 2\n", tmp_path)
    assert set(found) == {"mechanics.round", "mechanics.mesh"}
    assert "belongs to solver = 'continuum'" in found["mechanics.round"]
    found = problems(CASE + "[mechanics]\nsolver = 'ancf'\nlayers = 2\n", tmp_path)
    assert set(found) == {"mechanics.layers"}


def test_what_has_no_shape_is_refused_by_name(tmp_path):
    extra = """
[section.blob]
kind = "general"
area = "1 cm^2"
second_moment_2 = "1 cm^4"
second_moment_3 = "1 cm^4"
torsion_constant = "1 cm^4"
[body.rope]
kind = "cable"
start = [0, 1, 0]
end = [1, 1, 0]
elements = 2
section = "pipe"
material = "metal"
[body.bar]
kind = "beam"
start = [0, 2, 0]
end = [1, 2, 0]
elements = 2
section = "blob"
material = "metal"
[probe.middle]
body = "boom"
at = 0.3
[mechanics.mesh.bom]
along = 2
"""
    found = problems(CASE + extra, tmp_path, "mechanics.solver=continuum")
    assert "cable" in found["body.rope"]
    assert "general section" in found["body.bar.section"]
    assert "0 m and 0.5 m" in found["probe.middle.at"]
    assert "did you mean 'boom'" in found["mechanics.mesh.bom"]


def test_a_place_between_nodes_is_taken_where_cells_meet(tmp_path):
    extra = '[probe.quarter]\nbody = "boom"\nat = 0.25\n'
    scene = scene_of(CASE + extra, tmp_path, *COARSE, "mechanics.along=2")
    probe = build(scene).probes(build(scene).initial())["quarter"]
    assert probe["position"] == pytest.approx([0.25, 0.0, 0.0], abs=1e-12)


def test_a_scene_of_beams_imports_nothing_of_the_continuum(tmp_path):
    import subprocess

    (tmp_path / "case.toml").write_text(CASE)
    code = (
        "import sys; from coupling import casefile; from coupling.model import build;"
        f"build(casefile.read({str(tmp_path / 'case.toml')!r}));"
        "print(sorted({'coupling.continuum', 'mechanics.continuum'} & set(sys.modules)))"
    )
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert out.stdout.strip() == "[]"


LUG = """
[time]
end = "2 ms"
window = "2 ms"
[mechanics]
solver = "continuum"
round = 8
[mechanics.lug.hinge]
outer_radius = "20 mm"
length = "10 mm"
round = 16
layers = 2
[section.s]
kind = "rectangle"
height = "20 mm"
width = "20 mm"
[body.arm]
kind = "beam"
start = [0, 0, 0]
end = ["0.3 m", 0, 0]
elements = 2
normal = [0, 1, 0]
section = "s"
material = "al6061"
[gravity]
acceleration = [0, "-9.81 m/s^2", 0]
[joint.hinge]
kind = "clearance_revolute"
journal = { body = "arm", at = "start" }
axis = [0, 0, 1]
radius = "10 mm"
clearance = "0.02 mm"
journal_material = "steel-304"
bearing_material = "al6061"
[joint.hinge.friction]
coefficient = 0.1
[probe.tip]
body = "arm"
at = "end"
"""


@pytest.mark.slow
def test_pin_falls_freely_until_it_meets_the_elastic_bore(tmp_path):
    _, folder = final_tip(LUG, tmp_path)
    with Results.open(folder) as results:
        history = results.table("joints/hinge")
        ledger = results.table("ledger")
    contact = history["penetration"] > 0.0
    first = history["time"][np.argmax(contact)]
    # the arm falls as a whole: nothing turns it before the pin touches
    assert first == pytest.approx(np.sqrt(2.0 * 0.02e-3 / 9.81), rel=0.02)
    assert history["normal_force"].max() > 10.0
    assert abs(ledger["defect"][-1]) < 1e-3 * abs(ledger["work_loads"][-1])


def test_lugs_are_refused_where_they_cannot_be(tmp_path):
    driven = LUG.replace("[joint.hinge.friction]", "angle = 0.1\n[joint.hinge.friction]")
    assert "driven" in problems(driven, tmp_path)["mechanics.lug.hinge"]
    thin = LUG.replace('outer_radius = "20 mm"', 'outer_radius = "10 mm"')
    assert "exceed" in problems(thin, tmp_path)["mechanics.lug.hinge.outer_radius"]
