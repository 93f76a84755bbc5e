"""Conductance of joints by what their contacts do, and heat that deformation releases."""

import numpy as np
import pytest
from typer.testing import CliRunner

from coupling.casefile import read
from coupling.joint_conductance import Joint, JointConductance, Pressed, Tabled
from coupling.model import build
from coupling.reading import Results
from coupling.simulation import run
from meshes.materials import constant_material

MATERIAL = constant_material("m", 2700.0, 69e9, 0.33, 23.1e-6, 167.0, 896.0)
OTHER = constant_material("o", 7900.0, 200e9, 0.3, 16e-6, 15.0, 500.0)


def test_cooper_mikic_yovanovich():
    """h = 1.25 k m/sigma (p/H)^0.95 by hand."""
    law = Pressed(1e-6, 0.1, 1.1e9, 5e-4, MATERIAL, OTHER)
    k = 2.0 * 167.0 * 15.0 / 182.0
    h = 1.25 * k * 0.1 / 1e-6 * (100.0 / 5e-4 / 1.1e9) ** 0.95
    found = law(np.array([0.0, 100.0]), np.zeros(2), 300.0)
    np.testing.assert_allclose(found, [0.0, h * 5e-4], rtol=1e-12)


def test_tables_by_force_and_by_gap():
    law = Tabled((0.0, 10.0), (1.0, 3.0), (0.0, 1e-4), (0.5, 0.1))
    force, gap = np.array([0.0, 0.0, 5.0, 20.0]), np.array([5e-5, 1.0, 0.0, 0.0])
    np.testing.assert_allclose(law(force, gap, 300.0), [0.3, 0.1, 2.0, 3.0])


def test_the_mean_is_straight_within_steps_and_weighs_them_by_their_length():
    law = Tabled((0.0, 10.0), (0.0, 1.0), (0.0,), (0.0,))
    joints = JointConductance([Joint("contact.c", np.array([1]), np.array([0, 1]), law)])
    force = np.array([[9.0, 0.0], [9.0, 10.0], [9.0, 5.0]])
    T, durations = np.full(4, 300.0), np.array([1.0, 2.0, 1.0])
    found = joints.mean(joints.start(T), durations, force, np.zeros((3, 2)), T)
    np.testing.assert_allclose(found["contact.c"], [(2.0 * 0.5 + 1.0 * 0.75) / 4.0, 0.5])
    assert joints.contacts == 2


PRESSED = """
[time]
end = "20 s"
window = "0.5 s"
[integrator]
largest_step = "50 ms"
[body.bar]
kind = "rigid"
position = [0, 0, 0]
mass = "2 kg"
inertia = [1, 1, 1]
[joint.pin]
kind = "clearance_revolute"
journal = { body = "bar" }
axis = [0, 0, 1]
radius = "10 mm"
clearance = "50 um"
journal_material = "al6061"
bearing_material = "al6061"
reference_temperature = "300 K"
contact = { restitution = 0.5, stiffness = "linear", value = "1e6 N/m" }
[load.down]
kind = "force"
at = { body = "bar" }
direction = [0, -1, 0]
amplitude = "20 N"
[thermal]
initial = "300 K"
[thermal.part.pin]
of = "pin.journal"
material = "al6061"
mass = "0.1 kg"
initial = "350 K"
[thermal.part.bush]
of = "pin.bearing"
material = "al6061"
mass = "0.1 kg"
[thermal.contact.touch]
joint = "pin"
by_force = [["0 N", "0 W/K"], ["20 N", "2 W/K"], ["1000 N", "2 W/K"]]
"""


def test_a_pressed_pin_gives_its_heat_to_the_bearing(tmp_path):
    """At rest under 20 N the difference falls with the time m c / (2 G)."""
    (tmp_path / "case.toml").write_text(PRESSED)
    outcome = run(read(tmp_path))
    assert outcome.code == 0, outcome.reason
    with Results.open(outcome.folder) as results:
        state = results.read_state()["coupled"]
        T = np.array(state["T"])
    assert float(state["outside"]["contact.touch"][0]) == pytest.approx(2.0, rel=1e-3)
    c = float(build(read(tmp_path)).pair.heat_solver.energy(np.array([325.5, 325.0]))) - float(
        build(read(tmp_path)).pair.heat_solver.energy(np.array([324.5, 325.0]))
    )
    expected = 50.0 * np.exp(-2.0 * 2.0 * 20.0 / c)
    # the heat capacity is that of the mean; while the pin bounces it conducts less
    assert T[0] - T[1] == pytest.approx(expected, rel=5e-3)


ROD = """
[time]
end = "1 s"
window = "50 ms"
[integrator]
tolerance = 1e-5
[section.s]
kind = "circle"
radius = "10 mm"
[material.al]
density = 2700
youngs_modulus = "69 GPa"
poissons_ratio = 0.0
expansion = "23.1e-6 1/K"
conductivity = 167
heat_capacity = 896
[body.rod]
kind = "beam"
start = [0, 0, 0]
end = [1, 0, 0]
elements = 4
section = "s"
material = "al"
damping = "1 ms"
[joint.root]
kind = "clamp"
a = { body = "rod", at = "start" }
[load.pull]
kind = "force"
at = { body = "rod", at = "end" }
direction = [1, 0, 0]
amplitude = { ramp = { end = "0.8 s", from = 0, to = "31415.926535 N" } }
[thermal]
initial = "298.15 K"
[thermal.elastic]
bodies = ["rod"]
[probe.tip]
body = "rod"
at = "end"
"""


@pytest.mark.parametrize("scheme", ["corrected", "serial"])
@pytest.mark.parametrize("solver", ["line", "lumped"])
def test_stretched_metal_cools(tmp_path, solver, scheme):
    """-0.284692 K per 100 MPa (Joule 1859; T alpha sigma/(rho c)); it falls with T by 0.05 %."""
    text = ROD.replace("[thermal]\n", f'[thermal]\nsolver = "{solver}"\n')
    (tmp_path / "case.toml").write_text(text + f'[coupling]\nscheme = "{scheme}"\n')
    outcome = run(read(tmp_path))
    with Results.open(outcome.folder) as results:
        T, ledger = results["probes/tip/temperature"], results.table("ledger")
    # the stress of the undeformed section is 0.1 % lower than force over area
    assert T[-1] - T[0] == pytest.approx(-0.284692, rel=3e-3)
    assert abs(ledger["heat_defect"][-1]) < 1e-9 * abs(ledger["heat_of_deformation"][-1])


def test_prescribed_heat_does_not_take_heat_of_deformation(tmp_path):
    from coupling.cli import app

    text = ROD.replace("[thermal]\n", '[thermal]\nsolver = "prescribed"\n')
    (tmp_path / "case.toml").write_text(
        text + "[thermal.wall.w]\nbody = 'rod'\ntemperature = 298.15\n"
    )
    result = CliRunner().invoke(app, ["check", str(tmp_path)])
    assert result.exit_code == 2
    assert "thermal.elastic" in result.output


def test_quadratic_cells_do_not_take_heat_of_deformation(tmp_path):
    from coupling.cli import app

    text = ROD.replace("[thermal]\n", '[thermal]\nsolver = "solid"\norder = 2\n')
    (tmp_path / "case.toml").write_text(text)
    result = CliRunner().invoke(app, ["check", str(tmp_path)])
    assert result.exit_code == 2
    assert "thermal.elastic: corners of quadratic cells" in result.output
