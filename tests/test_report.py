"""Reports of speed: they measure the same motion, and write what they say."""

import csv

import numpy as np
import pytest
from typer.testing import CliRunner

from coupling.cli import app
from coupling.report import report
from coupling.reports import elements, exudyn_models, integrators, newton, work
from coupling.reports.measure import exponent, fixed, march
from coupling.reports.registry import OF_A_CASE, OF_MANY_SIZES, OWN, load, reports_of
from coupling.rings import ring_description
from mechanics.system import System
from meshes.materials import library_material
from meshes.sections import tube
from meshes.truss import ring_truss

CASE = """
[time]
end = 1
window = 0.01
[section.bar]
kind = "circle"
radius = 0.01
[body.bar]
kind = "beam"
start = [0.0, 0.0, 0.0]
end = [1.0, 0.0, 0.0]
elements = 3
section = "bar"
material = "al6061"
[joint.root]
kind = "clamp"
a = { body = "bar", at = "start" }
[gravity]
acceleration = [0.0, 0.0, -9.81]
"""


@pytest.fixture(scope="module")
def small_ring():
    truss = ring_truss(4, 10.0, 2.0, 2, 0.2)
    return System(ring_description(truss, tube(0.02, 0.001), library_material("al6061"), 1e-3))


def test_every_report_can_be_loaded():
    for what in (*OWN, "a case"):
        for name in reports_of(what):
            assert callable(load(what, name))
    assert set(OF_A_CASE) <= set(OWN["ring_truss"])
    assert all(name in OWN[what] for what, name in OF_MANY_SIZES)


def test_growth_of_a_power():
    sizes = [10.0, 20.0, 40.0]
    assert exponent(sizes, [3.0 * x**1.3 for x in sizes]) == pytest.approx(1.3)


def test_full_newton_makes_the_same_motion(small_ring):
    (result,) = newton.report(small_ring, 1e-3)
    assert [row[0] for row in result.rows] == ["frozen", "full"]
    apart = float(result.notes[1].split()[2])
    assert apart < 1e-10
    assert all(row[3] > 0.0 for row in result.rows)


def test_the_parts_of_a_step_are_measured(small_ring):
    (result,) = work.report(small_ring, 1e-3)
    times = {row[0]: row[1] for row in result.rows}
    assert min(times.values()) > 0.0
    floor = times["floor: residual + solve"]
    assert floor == pytest.approx(times["residual"] + times["solve"])


def test_a_step_that_is_impossible_is_said(small_ring):
    with pytest.raises(RuntimeError, match="at t = 0 s"):
        march(small_ring, fixed(50.0), 50.0, 1)


def test_a_report_of_a_case_is_printed_and_written(tmp_path):
    (tmp_path / "case.toml").write_text(CASE)
    folder = tmp_path / "report"
    made = CliRunner().invoke(app, ["report", str(tmp_path), "work", "--output", str(folder)])
    assert made.exit_code == 0, made.output
    assert "residual" in made.output
    with (folder / "work.csv").open() as file:
        rows = list(csv.reader(file))
    assert rows[0][0] == "part" and rows[1][0] == "residual"
    assert (folder / "work.md").read_text().startswith("# Work of a step of 0.01 s: 48 coord")


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["ring_truss", "work2"], "there is no report 'work2'; did you mean 'work'?"),
        (["nowhere", "levels"], "'levels' measures models of its own"),
        (["ring_truss", "extremes"], "of its own: thermobody report contact extremes"),
        (["contact", "levels"], "of its own: thermobody report ring_truss levels"),
        (["nowhere"], "there is no such file"),
    ],
)
def test_bad_input_to_a_report(arguments, said, tmp_path):
    made = CliRunner().invoke(app, ["report", *arguments, "--output", str(tmp_path)])
    assert made.exit_code == 2
    assert said in made.output


def test_reference_of_the_elements_is_the_elastica_without_shear():
    """Bisshopp & Drucker (1945) for P L^2 = 2 E I, inextensible: within the small stretch."""
    x, z = elements.reference(shears=False)
    assert (1.0 - x, z) == (
        pytest.approx(0.16064172, abs=2e-5),
        pytest.approx(0.49345748, abs=2e-5),
    )


@pytest.mark.slow
def test_errors_fall_with_elements_and_with_steps():
    (result,) = elements.report()
    errors = {row[:2]: row[2] for row in result.rows}
    for kind in elements.TYPES:
        assert errors[kind, 32] < 0.05 * errors[kind, 8]
    (result,) = integrators.report()
    orders = {row[:2]: row[6] for row in result.rows}
    for scheme, order in (("hht -0.1", 2), ("generalised-alpha 0.8", 2), ("bdf2", 2),
                          ("backward-euler", 1)):  # fmt: skip
        assert orders[scheme, "0.0005 s"] == pytest.approx(order, abs=0.1)


def test_a_log_log_picture_is_drawn(tmp_path, monkeypatch):
    from rich.console import Console

    monkeypatch.setattr(elements, "COUNTS", (1, 2))
    monkeypatch.setattr(elements, "TYPES", ("beam3243", "cable"))
    files = report("ring_truss", "elements", tmp_path, Console(quiet=True))
    assert [file.name for file in files] == ["elements.csv", "elements.md", "elements.png"]
    assert files[2].stat().st_size > 20_000


@pytest.mark.skipif(exudyn_models.version() is None, reason="exudyn is not installed")
def test_exudyn_makes_the_same_motion_of_a_slider_crank():
    from coupling.reports.exudyn import _slider_crank

    race = _slider_crank()
    steps = 1200
    ours, _ = race.own(race.end / steps, steps)
    others, _ = race.other(race.end / steps, steps)
    assert np.linalg.norm(ours - others) < 2e-4 * race.size


def test_without_exudyn_it_says_so(monkeypatch):
    from coupling.reports import exudyn

    monkeypatch.setattr(exudyn_models, "version", lambda: None)
    (result,) = exudyn.report()
    assert "pip install" in result.rows[0][0]
