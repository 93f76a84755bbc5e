"""The heat of a scene under all solvers: what they agree on, what they refuse, what is written."""

import csv
import shutil

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from typer.testing import CliRunner

from coupling.casefile import read
from coupling.cli import app
from coupling.compare_heat import compare
from coupling.errors import BadCase
from thermal.solvers import SOLVERS

CASE = """
title = "A tube in space"
[time]
end = "40 s"
window = "10 s"
[section.tube]
kind = "tube"
mean_radius = "50 mm"
thickness = "1 mm"
[body.boom]
kind = "beam"
start = [0, 0, 0]
end = ["2 m", 0, 0]
elements = 4
normal = [0, 1, 0]
section = "tube"
material = "plain"
[material.plain]
density = 2700
youngs_modulus = 69e9
poissons_ratio = 0.33
expansion = 23e-6
conductivity = 167
heat_capacity = 900
[joint.root]
kind = "clamp"
a = { body = "boom", at = "start" }
"""
SPACE = """
[thermal]
initial = "350 K"
wall_points = 8
[thermal.radiation.space]
body = "boom"
emissivity = 0.8
sink = "3 K"
"""
SUN = """
[thermal.flux.sun]
body = "boom"
density = "1361 W/m^2"
absorptivity = 0.3
direction = [0, -1, 0]
"""


@pytest.fixture
def case(tmp_path):
    """Writes a case and reads it."""

    def make(text, *settings):
        (tmp_path / "case.toml").write_text(text, encoding="utf-8")
        return read(tmp_path, settings)

    return make


def by_name(rows):
    return {row.run.solver: row for row in rows}


def test_all_solvers_cool_as_a_lump_does(case):
    """d(rho c t T)/dt = -eps sigma (R + t/2)/R T^4; in 3D the ends radiate too."""
    rows = by_name(compare(case(CASE + SPACE, "thermal.tolerance='1 mK'")))
    rate = 0.8 * 5.670374419e-8 * (0.0505 / 0.05) / (2700.0 * 900.0 * 1e-3)
    exact = solve_ivp(lambda t, T: -rate * (T**4 - 3.0**4), (0, 40.0), [350.0], rtol=1e-10).y[0, -1]
    fell = 350.0 - exact
    assert fell > 10.0
    assert "must cover" in rows.pop("prescribed").run.why
    for name in ("line", "wall", "lumped", "wall, finer"):
        np.testing.assert_allclose(rows[name].run.sections[-1, :, 0], exact, atol=2e-3 * fell)
    for name in {"solid", "calculix"} & {n for n, row in rows.items() if not row.run.why}:
        middle = rows[name].run.sections[-1, 2, 0]
        assert middle == pytest.approx(exact, abs=0.03 * fell)


def test_sections_of_a_sunlit_tube_agree(case):
    rows = by_name(compare(case(CASE + SPACE + SUN), ["line", "lumped", "solid"]))
    assert list(rows) == ["line", "lumped", "solid", "wall, finer"]
    steep = np.abs(rows["wall, finer"].run.sections[..., 1]).max()
    assert steep > 20.0
    assert rows["wall, finer"].difference is None
    assert rows["line"].difference.gradient < 0.01 * steep
    for name in ("lumped", "solid"):
        assert rows[name].difference.gradient < 0.15 * steep
    for row in rows.values():
        assert row.run.times.tolist() == [0.0, 10.0, 20.0, 30.0, 40.0]
        assert row.run.steps >= 4
        assert row.run.seconds > 0.0


@pytest.mark.skipif(shutil.which("ccx") is None, reason="ccx is not installed")
def test_calculix_comes_to_the_same_sunlit_tube(case):
    """With 24 cells round, whose chords stand off by 0.3 % of the radius."""
    rows = by_name(compare(case(CASE + SPACE + SUN, "thermal.tolerance=1e-4"), ["calculix"]))
    steepest = max(float(np.abs(r.run.sections[..., 1:]).max()) for r in rows.values())
    assert rows["calculix"].difference.gradient < 0.01 * steepest
    assert rows["calculix"].difference.gradient > 0.0


def test_the_reference_can_be_named(case):
    rows = by_name(compare(case(CASE + SPACE + SUN), ["line"], "lumped"))
    assert list(rows) == ["line", "lumped"]
    assert rows["lumped"].difference is None
    assert rows["line"].difference.mean > 0.0


def test_a_solver_that_stops_says_when(case):
    law = 'heat_capacity = { table = [["345 K", 900], ["400 K", 900]] }'
    text = CASE.replace("heat_capacity = 900", law) + SPACE
    with pytest.raises(BadCase, match=r"line: stopped in the window from 10 s on: .*'boom' left"):
        compare(case(text), ["line"])


@pytest.mark.parametrize(
    ("text", "solvers", "reference", "said"),
    [
        (CASE, None, None, "no heat to compare"),
        (CASE + SPACE, ["lines"], None, "did you mean 'line'"),
        (CASE + SPACE, ["line"], "wal", "did you mean 'wall'"),
        (CASE + SPACE, ["line"], "prescribed", "'prescribed' did not run"),
    ],
)
def test_what_cannot_be_compared(case, text, solvers, reference, said):
    with pytest.raises(BadCase, match=said):
        compare(case(text), solvers, reference)


def test_the_command_prints_and_writes(case, tmp_path):
    case(CASE + SPACE + SUN)
    asked = ["compare-thermal", str(tmp_path), "--solvers", "line, prescribed"]
    done = CliRunner().invoke(app, asked)
    assert done.exit_code == 0, done.output
    assert "friction gives no heat" in done.output
    assert "prescribed: prescribed temperatures must cover" in done.output
    folder = tmp_path / "results"
    with (folder / "compare_thermal.csv").open() as file:
        table = list(csv.reader(file))
    assert [row[0] for row in table] == ["solver", "line", "wall, finer"]
    assert (folder / "compare_thermal.png").stat().st_size > 10_000
    assert (folder / "compare_thermal.md").read_text().startswith("# Heat by several solvers")


def test_a_wrong_solver_ends_in_code_2(case, tmp_path):
    case(CASE + SPACE)
    done = CliRunner().invoke(app, ["compare-thermal", str(tmp_path), "--solvers", "none"])
    assert done.exit_code == 2
    assert "there is no solver 'none'" in done.output
    assert all(f"'{name}'" in done.output for name in SOLVERS)
