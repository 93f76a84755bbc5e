"""Temperatures of shells: prescribed on both faces, read at the nodes, and what they do."""

from dataclasses import replace

import meshio
import numpy as np
import pytest
from heat_cases import member, plain, ramp, still
from typer.testing import CliRunner

from coupling.cli import app
from coupling.reading import Results
from coupling.transfer import transfer
from meshes import surfaces
from thermal.description import Description, Faces, Sheet, Wall
from thermal.layout import face_positions, node_areas
from thermal.solvers import build

RADIUS, LENGTH, THICKNESS = 0.5, 2.0, 0.01
HOT, COLD = ramp(300.0, 340.0, 8.0), ramp(300.0, 320.0, 8.0)


def tube(elements=(8, 3)):
    return surfaces.tube(RADIUS, LENGTH, *elements)


def sheet(surface=None):
    return Sheet("skin", surface or tube(), THICKNESS, plain(), 300.0)


def of_sheet(*conditions):
    return Description((), conditions=conditions, sheets=(sheet(),))


def triads(surface):
    e1 = surface.d_u / np.linalg.norm(surface.d_u, axis=1, keepdims=True)
    e3 = np.cross(e1, surface.d_v)
    e3 /= np.linalg.norm(e3, axis=1, keepdims=True)
    return np.stack([e1, np.cross(e3, e1), e3], axis=1)


def reading(surface):
    """Transfer from a sheet to the shell of the same surface."""
    x = face_positions(sheet(surface))
    own = {"skin": np.arange(len(surface.points))}
    rest = np.full(len(surface.points), 250.0)
    axes = triads(surface)
    return transfer(x, {"skin": np.arange(len(x))}, surface.points, axes, own, rest, {"skin"})


SHAPES = pytest.mark.parametrize(
    "surface",
    [
        surfaces.plate(2.0, 1.0, 3, 2),
        tube(),
        surfaces.annulus(0.5, 1.0, 2, 5),  # slit: two edges in one place
        surfaces.sphere(1.0, 6, 2, (-0.5, 0.9)),
    ],
    ids=["plate", "tube", "annulus", "sphere"],
)


# ----------------------------------------------------------------------------- prescribed faces


@pytest.mark.parametrize(
    ("surface", "exact"),
    [
        (surfaces.plate(2.0, 1.0, 3, 2), 2.0),
        (tube(), 2.0 * np.pi * RADIUS * LENGTH),
        (surfaces.annulus(0.5, 1.0, 2, 5), 0.75 * np.pi),
    ],
)
def test_areas_of_the_nodes_sum_to_that_of_the_surface(surface, exact):
    areas = node_areas(sheet(surface))
    assert areas.min() > 0.0
    assert areas.sum() == pytest.approx(exact, rel=1e-12)


@pytest.mark.parametrize("name", ["prescribed", "line", "lumped"])
def test_faces_follow_their_histories_beside_any_solver(name):
    bar = member("bar", 1.0, 4)
    warm = (still(310.0),) * 2
    wall = Wall("wall", "bar", 0.0, 1.0, None, warm, warm)
    d = replace(of_sheet(Faces("faces", "skin", HOT, COLD), wall), members=(bar,))
    solver = build(name, d)
    n = len(tube().points)
    assert {k: len(v) for k, v in solver.regions.items()} == {"bar": 5, "skin": 2 * n}
    T, flows, why = solver.advance(solver.initial(), 0.0, 4.0, np.zeros(len(solver.x)))
    assert why == ""
    assert np.allclose(T[solver.regions["skin"]].reshape(n, 2), [320.0, 310.0], rtol=1e-14)
    assert np.allclose(T[solver.regions["bar"]], 310.0)
    assert sum(flows.values()) == pytest.approx(solver.energy(T) - solver.energy(solver.initial()))


@pytest.mark.parametrize("name", ["prescribed", "line", "lumped"])
def test_heat_of_a_shell_is_that_of_its_mass(name):
    solver = build(name, of_sheet(Faces("faces", "skin", HOT, COLD)))
    _, flows, _ = solver.advance(solver.initial(), 0.0, 8.0, np.zeros(len(solver.x)))
    mass = 2700.0 * 2.0 * np.pi * RADIUS * LENGTH * THICKNESS
    source = "reservoir" if name == "prescribed" else "faces"
    assert flows[source] == pytest.approx(mass * 896.0 * 30.0, rel=1e-12)


def test_the_first_face_is_that_of_the_normal():
    solver = build("prescribed", of_sheet(Faces("faces", "skin", HOT, COLD)))
    radii = np.linalg.norm(solver.x[:, :2], axis=1).reshape(-1, 2)
    assert np.allclose(radii, [RADIUS + THICKNESS / 2, RADIUS - THICKNESS / 2])


@pytest.mark.parametrize("name", ["prescribed", "line", "lumped"])
@pytest.mark.parametrize(
    ("description", "said"),
    [
        (of_sheet(Faces("f", "skim", HOT, COLD)), "faces 'f': there is no sheet 'skim'"),
        (
            of_sheet(Faces("f", "skin", HOT, COLD), Faces("g", "skin", HOT, COLD)),
            "'f' and 'g' both prescribe temperatures of 'skin'",
        ),
        (
            Description((), sheets=(replace(sheet(), thickness=0.0),)),
            "sheet 'skin': its thickness must be positive, got 0",
        ),
        (
            replace(
                of_sheet(Wall("w", "bar", 0, 1, None, (HOT, HOT), (COLD, COLD))),
                members=(member("bar"),),
            ),
            "wall 'w': hot and cold differ, so it needs a side",
        ),
    ],
)
def test_senseless_sheets_are_refused(name, description, said):
    with pytest.raises(ValueError) as error:
        build(name, description)
    assert said in str(error.value)


def test_prescribed_temperatures_must_cover_a_sheet():
    said = "sheet 'skin': no condition gives the temperatures of its faces"
    with pytest.raises(ValueError, match=said):
        build("prescribed", of_sheet())


# ------------------------------------------------------------------------------------- transfer


@SHAPES
def test_a_field_linear_through_the_thickness_is_read_exactly(surface):
    rng = np.random.default_rng(0)
    mean, slope = 300.0 + rng.random(len(surface.points)), rng.standard_normal(len(surface.points))
    z = np.array([0.5, -0.5]) * THICKNESS
    T = (mean[:, None] + slope[:, None] * z).ravel()
    expected = np.column_stack([mean, np.zeros_like(mean), slope])
    np.testing.assert_allclose(reading(surface).read(T), expected, rtol=1e-9, atol=1e-9)


@SHAPES
def test_no_heat_is_lost_on_the_way_to_a_shell(surface):
    read = reading(surface)
    heat = np.random.default_rng(1).standard_normal(len(surface.points))
    nodal = read.deposit(heat)
    np.testing.assert_allclose(nodal.reshape(-1, 2), 0.5 * heat[:, None] * [1.0, 1.0], rtol=1e-11)


def test_a_shell_with_temperatures_for_others_is_refused():
    surface = tube()
    own, rest = {"skin": np.arange(len(surface.points))}, np.zeros(len(surface.points))
    with pytest.raises(ValueError, match="a shell of 32 nodes cannot have 63 temperatures"):
        x = face_positions(sheet(surface))[1:]
        here = {"skin": np.arange(len(x))}
        transfer(x, here, surface.points, triads(surface), own, rest, {"skin"})


# ---------------------------------------------------------------------------------------- cases

HEAD = """
[time]
end = 1
window = 1
[analysis]
kind = "statics"
[output]
export = ["vtk"]
[material.m]
density = 2700
youngs_modulus = "69 GPa"
poissons_ratio = 0.3
expansion = "23.1e-6 1/K"
conductivity = 1
heat_capacity = 1
[thermal]
solver = "SOLVER"
initial = "20 degC"
[body.skin]
kind = "shell"
thickness = "5 mm"
material = "m"
element = "ELEMENT"
"""
PLATE = (
    HEAD
    + """
surface = { kind = "plate", length = 1, width = 0.5, elements = [8, 4] }
[joint.foot]
kind = "clamp"
a = { body = "skin", position = [0.5, 0.25, 0] }
[probe.corner]
body = "skin"
position = [1, 0.5, 0]
[thermal.wall.w]
body = "skin"
hot = { ramp = { end = 1, from = 293.15, to = 293.175 } }
cold = { ramp = { end = 1, from = 293.15, to = 293.125 } }
"""
)
TUBE = (
    HEAD
    + """
surface = { kind = "tube", radius = 0.5, length = 1, elements = [8, 2] }
[joint.foot]
kind = "clamp"
a = { body = "skin", position = [0.5, 0, 0] }
[probe.far]
body = "skin"
position = [-0.5, 0, 1]
[thermal.wall.w]
body = "skin"
temperature = { ramp = { end = 1, from = "20 degC", to = "70 degC" } }
"""
)


def ran(tmp_path, text, element="shell48", solver="prescribed"):
    (tmp_path / "case.toml").write_text(text.replace("ELEMENT", element).replace("SOLVER", solver))
    result = CliRunner().invoke(app, ["run", str(tmp_path)])
    assert result.exit_code == 0, result.output
    return tmp_path / "results" / "001"


@pytest.mark.parametrize("element", ["shell48", "shell24"])
def test_a_free_plate_bows_to_a_sphere_away_from_its_hot_face(tmp_path, element):
    """w = -alpha (dT/dz) (x^2 + y^2) / 2 about a fixed point (Boley & Weiner 1960, sec. 12.6).

    The bow is 1/70 of the thickness, so that the middle surface stays as long as it is.
    """
    folder = ran(tmp_path, PLATE, element)
    with Results.open(folder) as results:
        probe = results["probes/corner/position"]
        assert np.allclose(results["bodies/skin/temperature"][-1], [293.15, 0.0, 10.0], atol=1e-9)
    exact = -0.5 * 23.1e-6 * 10.0 * (0.5**2 + 0.25**2)
    assert probe[-1, 2] - probe[0, 2] == pytest.approx(exact, rel=2e-3)


@pytest.mark.parametrize("solver", ["prescribed", "line", "lumped"])
@pytest.mark.parametrize("element", ["shell48", "shell24", "shell3443"])
def test_a_tube_expands_freely(tmp_path, element, solver):
    """Every length grows by alpha dT, and nothing is stressed."""
    text = TUBE if solver == "prescribed" else TUBE.replace('kind = "statics"', 'kind = "dynamics"')
    folder = ran(tmp_path, text.replace("window = 1\n", "window = 0.5\n"), element, solver)
    with Results.open(folder) as results:
        position = results["bodies/skin/position"]
        forces = results["bodies/skin/resultants"][-1]
        temperatures = results["bodies/skin/temperature"][-1]
    assert np.allclose(temperatures, [343.15, 0.0, 0.0])
    if solver == "prescribed":
        grown = (position[-1] - position[-1, 0]) - (position[0] - position[0, 0])
        expected = 23.1e-6 * 50.0 * (position[0] - position[0, 0])
        rounding = 1e-3 * np.abs(expected).max()
        assert np.allclose(grown, expected, atol=rounding)
        assert np.abs(forces[:, :3]).max() < 1e-4 * 69e9 * 0.005 * 23.1e-6 * 50.0


def test_temperature_and_gradient_are_written_for_paraview(tmp_path):
    folder = ran(tmp_path, PLATE)
    last = sorted((folder / "vtk").glob("bodies_*.vtu"))[-1]
    fields = meshio.read(last).point_data
    assert np.allclose(fields["temperature"], 293.15)
    assert np.allclose(fields["temperature_gradient"], 10.0)


def test_plan_says_which_shells_carry_temperatures(tmp_path):
    (tmp_path / "case.toml").write_text(
        TUBE.replace("ELEMENT", "shell48").replace("SOLVER", "line")
    )
    result = CliRunner().invoke(app, ["plan", str(tmp_path)])
    assert "48 temperatures, 2 at each node of a shell, 1 × wall" in result.output
