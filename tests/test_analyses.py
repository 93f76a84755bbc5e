"""Statics and modes of cases, from text to results."""

import numpy as np
import pytest
from typer.testing import CliRunner

from coupling import clocks
from coupling.cli import app
from coupling.reading import Results

CASE = """
[time]
end = 1
window = 1
[section.bar]
kind = "rectangle"
height = "1 cm"
width = "1 cm"
[material.m]
density = 2700
youngs_modulus = "69 GPa"
poissons_ratio = 0.0
expansion = "23.1e-6 1/K"
conductivity = 1
heat_capacity = 1
[body.bar]
kind = "beam"
start = [0.0, 0.0, 0.0]
end = [1.0, 0.0, 0.0]
elements = 8
normal = [0, 1, 0]
section = "bar"
material = "m"
[joint.root]
kind = "clamp"
a = { body = "bar", at = "start" }
[probe.tip]
body = "bar"
at = "end"
"""
PUSH = """
[load.push]
kind = "force"
at = { body = "bar", at = "end" }
direction = [0, 0, 1]
amplitude = { ramp = { end = 2, from = 0, to = 230 } }
"""
HEAT = """
[thermal]
solver = "prescribed"
initial = "20 degC"
[thermal.wall.w]
body = "bar"
side = [0, 1, 0]
hot = { ramp = { end = 1, from = "20 degC", to = "120 degC" } }
cold = { ramp = { end = 1, from = "20 degC", to = "120 degC" } }
"""


def ran(tmp_path, text, code=0):
    (tmp_path / "case.toml").write_text(text)
    result = CliRunner().invoke(app, ["run", str(tmp_path)])
    assert result.exit_code == code, result.output
    return result.output, Results.open(tmp_path / "results" / "001")


@pytest.mark.parametrize("more", ["", "arc_length = true\n"])
def test_equilibrium_of_a_bent_cantilever(tmp_path, more):
    """Elastica at P L^2 / (E I) = 2 (Bisshopp & Drucker 1945), within its stretch and shear."""
    _, results = ran(tmp_path, CASE + PUSH + f'[analysis]\nkind = "statics"\n{more}')
    with results:
        load = results["probes/tip/time"][-1]
        tip = results["probes/tip/position"][-1]
    if not more:
        assert load == 1.0
        assert np.allclose(tip, [1 - 0.16064172, 0, 0.49345748], atol=1e-4)
    assert load >= 1.0 and tip[2] > 0.49


def test_temperature_of_the_prescribed_solver_is_taken(tmp_path):
    _, results = ran(tmp_path, CASE + HEAT + '[analysis]\nkind = "statics"\n')
    with results:
        grown = results["probes/tip/position"][-1] - results["probes/tip/position"][0]
    assert grown[0] == pytest.approx(23.1e-6 * 100.0, rel=2e-3)  # its expansion is that of length


def test_modes_of_a_cantilever(tmp_path):
    """(1.8751, 4.6941 / L)^2 sqrt(E I / (rho A)) / (2 pi), each twice: the section is square."""
    output, results = ran(tmp_path, CASE + '[analysis]\nkind = "modes"\ncount = 4\n')
    with results:
        found = results["modes/frequency"]
        frames = results["frames/time"]
    factor = np.sqrt(69e9 * 1e-4**2 / 12 / (2700 * 1e-4)) / (2 * np.pi)
    exact = factor * np.array([1.8751041, 1.8751041, 4.6940911, 4.6940911]) ** 2
    assert np.allclose(found, exact, rtol=2e-3)
    assert len(frames) == 5
    assert "mode 1: " in output


def test_what_nothing_holds_is_said(tmp_path):
    free = CASE.replace('[joint.root]\nkind = "clamp"\na = { body = "bar", at = "start" }\n', "")
    output, _ = ran(tmp_path, free + PUSH + '[analysis]\nkind = "statics"\n', code=3)
    assert "nothing holds" in output


HEATED = """
[thermal]
initial = 300
full_sections = "gradients"
[thermal.fixed.cold]
at = { body = "bar", at = "start" }
temperature = 300
[thermal.fixed.hot]
at = { body = "bar", at = "end" }
temperature = 400
"""


def test_statics_take_steady_temperatures(tmp_path):
    """Linear from 300 to 400 K: the bar grows by half of what it would at 400 K."""
    _, results = ran(tmp_path, CASE + HEATED + '[analysis]\nkind = "statics"\n')
    with results:
        T = results["bodies/bar/temperature"][-1][:, 0]
        x = results["bodies/bar/position"][-1][:, 0]
    assert np.allclose(T, np.linspace(300.0, 400.0, len(T)), rtol=0, atol=1e-8)
    assert x[-1] - 1.0 == pytest.approx(23.1e-6 * 50.0, rel=2e-3)


def test_heat_that_cannot_leave_is_said(tmp_path):
    source = "[thermal]\ninitial = 300\n[thermal.source.s]\nat = {body='bar'}\npower = 5\n"
    (tmp_path / "case.toml").write_text(CASE + source + '[analysis]\nkind = "statics"\n')
    result = CliRunner().invoke(app, ["run", str(tmp_path)])
    assert result.exit_code == 2
    assert "thermal: there is no steady state" in result.output


ARCH = (
    CASE.split("[body.bar]")[0]
    + """
[body.arch]
kind = "beam"
start = [-0.5, 0.0, 0.0]
arc = { center = [0.0, 0.0, -2.0], axis = [0, 1, 0], angle = "28 deg" }
elements = 8
section = "bar"
material = "m"
[joint.left]
kind = "clamp"
a = { body = "arch", at = "start" }
[joint.right]
kind = "clamp"
a = { body = "arch", at = "end" }
[probe.top]
body = "arch"
at = 0.5
[load.push]
kind = "force"
at = { body = "arch", at = 0.5 }
direction = [0, 0, -1]
amplitude = { ramp = { end = 10, from = 0, to = 40000 } }
[output]
export = ["vtk", "pictures"]
"""
)


def names(folder):
    return sorted(file.stem for file in (folder / "pictures").iterdir())


def header(folder):
    return (folder / "probes.csv").read_text().splitlines()[0]


def test_a_path_through_limit_points_is_kept_in_its_order(tmp_path):
    output, results = ran(tmp_path, ARCH + '[analysis]\nkind = "statics"\narc_length = true\n')
    assert "limit point at load factor" in output
    with results:
        load, top = results["probes/top/time"], results["probes/top/position"][:, 2]
        strain = results["ledger/strain"]
        assert results.column("probes/top/time").description == "load factor"
    assert (np.diff(load) < 0.0).any() and (np.diff(top) < 0.0).all()
    assert len(strain) == len(load) and strain[0] < 1e-12 * strain[-1]
    folder = tmp_path / "results" / "001"
    assert names(folder) == ["energy", "overview", "path"]
    assert header(folder).startswith("load factor [-],top.x [m]")
    rows = np.genfromtxt(folder / "probes.csv", delimiter=",", skip_header=1)
    assert np.array_equal(rows[:, 0], load)


def test_every_load_step_is_kept(tmp_path):
    """Each of them is an equilibrium: the tip follows the load, linear as long as it is small."""
    _, results = ran(tmp_path, CASE + PUSH + '[analysis]\nkind = "statics"\nsteps = 20\n')
    with results:
        load, tip = results["frames/time"], results["probes/tip/position"][:, 2]
        assert len(results["ledger/strain"]) == len(load)
    assert load[0] == 0.0 and load[1] == 0.05 and load[-1] == 1.0 and len(load) >= 6
    assert (np.diff(load) > 0.0).all() and (np.diff(tip) > 0.0).all()
    exact = 0.05 * 115.0 / (3.0 * 69e9 * 1e-8 / 12.0)
    assert tip[1] == pytest.approx(exact, rel=2e-3)


def test_modes_are_drawn_by_their_frequency(tmp_path):
    text = CASE + '[analysis]\nkind = "modes"\ncount = 2\n[output]\nexport = ["pictures"]\n'
    _, results = ran(tmp_path, text)
    with results:
        assert clocks.named(results, [0, 1]) == ["equilibrium", "mode 1"]
        said = clocks.said(results, [0, 1])
        frequency = results["modes/frequency"][0]
    assert said == f"equilibrium, mode 1: {frequency:.4g} Hz"
    folder = tmp_path / "results" / "001"
    assert names(folder) == ["overview"]
    assert header(folder).startswith("mode [-],tip.x [m]")


def test_what_a_stopped_analysis_has_is_readable(tmp_path):
    """A material that shrinks to nothing while it warms up: no equilibrium is left on the way."""
    law = "expansion = { table = [[293, 0], [300, 0], [301, -0.9], [400, -0.9]] }"
    shrinking = CASE.replace('expansion = "23.1e-6 1/K"', law)
    output, results = ran(tmp_path, shrinking + HEAT + '[analysis]\nkind = "statics"\n', code=3)
    with results:
        assert results.attributes()["outcome"] == "stopped"
        assert results.attributes()["reason"] in output
        load, tip = results["frames/time"], results["probes/tip/position"]
    assert load[0] == 0.0 and 0.01 < load[-1] < 0.1
    assert len(tip) == len(load) and np.isfinite(tip).all()
    assert CliRunner().invoke(app, ["plot", str(tmp_path)]).exit_code == 0


def test_motion_begins_in_equilibrium(tmp_path):
    """A bar whose upper side is hot stays bowed; from the reference it swings by twice as much."""
    bow = CASE.replace("end = 1\nwindow = 1", "end = 0.2\nwindow = 0.005") + (
        "[thermal]\ninitial = 300\nfull_sections = 'gradients'\nstart = 'steady'\n"
        "[thermal.wall.w]\nbody = 'bar'\nside = [0, 1, 0]\nhot = 310\ncold = 290\n"
        "[output]\nframes = 40\n"
    )
    swing = {}
    for start in ("reference", "equilibrium"):
        text = bow + f"[analysis]\nstart = '{start}'\n"
        (tmp_path / start).mkdir()
        _, results = ran(tmp_path / start, text)
        with results:
            swing[start] = results["bodies/bar/position"][:, -1, 1]
    rest = swing["equilibrium"]
    assert rest[0] == pytest.approx(-0.5 * 23.1e-6 * 20.0 / 0.01, rel=1e-3)
    assert np.ptp(rest) < 1e-6 * abs(rest[0])
    assert swing["reference"][0] == 0.0
    assert np.ptp(swing["reference"]) > 1.5 * abs(rest[0])


def test_what_floats_has_no_equilibrium_to_begin_with(tmp_path):
    free = CASE.replace('[joint.root]\nkind = "clamp"\na = { body = "bar", at = "start" }\n', "")
    (tmp_path / "case.toml").write_text(free + PUSH + "[analysis]\nstart = 'equilibrium'\n")
    result = CliRunner().invoke(app, ["run", str(tmp_path)])
    assert result.exit_code == 2
    assert "there is no equilibrium to begin with" in result.output
