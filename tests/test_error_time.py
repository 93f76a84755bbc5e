"""Error against run time: a mass on a spring against its closed form, tables, pictures."""

import csv
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console
from typer.testing import CliRunner

from coupling.casefile import from_text
from coupling.cli import app
from coupling.errors import BadCase
from coupling.report_tables import Sought
from coupling.reports.error_time import _front, cheapest, report, same_times, value
from coupling.reports.timed_runs import DONE, GIVEN_UP, REFUSED, STOPPED, Ran, timed

STRETCHED, LENGTH, RATE, END = 0.1, 0.9, 2.0, 2.0  # [m], [m], [rad/s], [s]
EXACT = LENGTH + STRETCHED * np.cos(RATE * END)
CASE = """
title = "a mass on a spring"
[time]
end = 2.0
window = 0.5
[integrator]
tolerance = 0.1
[body.ball]
kind = "particle"
position = [1.0, 0.0, 0.0]
mass = 2.0
[joint.wire]
kind = "spring"
a = { body = "ball" }
b = { body = "ground", position = [0.0, 0.0, 0.0] }
stiffness = 8.0
length = 0.9
[probe.ball]
body = "ball"
"""
REPORT = f"""
[report.accuracy]
reference = {{ "integrator.largest_step" = 1e-4 }}
check = {{ "integrator.largest_step" = 2e-4 }}
vary."integrator.largest_step" = [4e-2, 2e-2, 1e-2]
repeat = 2
wanted = 2e-3
[[report.accuracy.setting]]
label = "hht"
[[report.accuracy.setting]]
label = "undamped"
set = {{ "integrator.alpha" = 0.0 }}
[report.accuracy.quantity.known]
of = "probe.ball.x"
exact = {EXACT}
scale = 0.1
[report.accuracy.quantity.place]
of = "probe.ball.x"
scale = 0.1
[report.accuracy.quantity.course]
of = "probe.ball.position"
measure = "course"
"""


def read(text):
    return from_text(CASE + text, Path("."))


@pytest.fixture(scope="module")
def result():
    (result,) = report(read(REPORT), "accuracy")
    return result


def column(result, name):
    return [row[result.columns.index(name)] for row in result.rows]


def test_each_setting_is_a_row_and_both_references_are(result):
    assert [row[0] for row in result.rows] == [
        "hht, largest_step 0.04", "hht, largest_step 0.02", "hht, largest_step 0.01",
        "undamped, largest_step 0.04", "undamped, largest_step 0.02", "undamped, largest_step 0.01",
        "reference", "check",
    ]  # fmt: skip
    assert set(column(result, "outcome")) == {DONE}


def test_errors_are_those_of_the_trapezoidal_rule(result):
    """Its period is longer by (w h)^2 / 12 (Hughes 1987, table 9.3.2)."""
    for row, steps in zip(result.rows[3:6], column(result, "steps")[3:6], strict=True):
        h = END / steps
        late = RATE * END * (RATE * h) ** 2 / 12.0
        shift = abs(np.cos(RATE * END) - np.cos(RATE * END - late))
        assert row[result.columns.index("known [-]")] == pytest.approx(shift, rel=0.01)


def test_the_reference_agrees_with_what_is_exact(result):
    known, place = column(result, "known [-]")[:6], column(result, "place [-]")[:6]
    assert known == pytest.approx(place, rel=1e-3)


def test_errors_fall_with_the_square_of_the_step(result):
    course = np.array(column(result, "course [-]")[:6]).reshape(2, 3)
    assert np.log2(course[:, :-1] / course[:, 1:]) == pytest.approx(2.0, abs=0.2)


def test_work_is_counted(result):
    assert column(result, "steps")[:3] == [52, 100, 200]
    assert column(result, "windows") == [4] * 8
    assert all(t > 0.0 for name in ("time [s]", "median [s]", "processor [s]", "start [s]")
               for t in column(result, name))  # fmt: skip


def test_the_cheapest_and_the_trust_are_said(result):
    text = "\n".join(result.notes)
    assert "known: the cheapest under 0.002 is" in text
    assert "place: the two references differ by" in text
    assert "known: the two references" not in text


def test_pictures_have_a_curve_for_each_setting(result):
    assert len(result.pictures) == 3
    first = result.pictures[0]
    labels = [curve.label for curve in first.curves]
    assert labels[:2] == ["hht, by largest_step", "undamped, by largest_step"]
    assert list(first.curves[0].names) == ["0.04", "0.02", "0.01"]


def test_a_setting_that_fails_is_a_row():
    text = """
[report.accuracy]
vary."integrator.tolerance" = [1e-1, 1e-9]
common."integrator.smallest_step" = 0.05
common."integrator.largest_step" = 0.1
common."coupling.smallest_window" = 0.5
[report.accuracy.quantity.place]
of = "probe.ball.x"
exact = 0.8
"""
    (result,) = report(read(text), "accuracy")
    assert column(result, "outcome") == [DONE, STOPPED]
    assert np.isnan(column(result, "place [-]")[1])
    assert any("the local error stays above the tolerance" in note for note in result.notes)


def test_an_entry_that_cannot_be_is_said_before_anything_runs():
    bad = REPORT.replace("4e-2, 2e-2", '-1.0, "two steps"')
    with pytest.raises(BadCase) as error:
        list(report(read(bad), "accuracy"))
    assert len(error.value.problems) == 4
    assert "hht, largest_step -1: integrator.largest_step" in error.value.problems[0].path


def test_times_that_are_the_same():
    own, its = same_times(np.array([0.0, 0.5, 0.75, 1.0]), np.array([0.0, 0.25, 0.5, 1.0]))
    assert own.tolist() == [1, 3]
    assert its.tolist() == [2, 3]


@pytest.mark.parametrize(
    ("measure", "expected"),
    [("final", 1.0), ("max", 1.0), ("min", 0.0), ("mean", 0.5), ("rms", 1.0 / 3.0**0.5)],
)
def test_measures(measure, expected):
    """Of x(t) = t on [0, 1]."""
    t = np.linspace(0.0, 1.0, 2001)
    ran = Ran(DONE, "", times=t, values={"x": t[:, None]})
    found = value("x", Sought(of="probe.a.x", measure=measure), ran)
    assert found == pytest.approx([expected], abs=1e-6)


def test_the_front_has_what_no_other_beats():
    points = [(1.0, 0.1), (2.0, 0.2), (3.0, 0.01)]
    assert _front(points) == [(1.0, 0.1), (3.0, 0.1), (3.0, 0.01)]


def test_the_cheapest_is_none_where_all_errors_are_too_large():
    assert cheapest([], "place", 1.0, lambda point: 0.0) is None


def test_the_command_writes_table_text_and_picture(tmp_path):
    (tmp_path / "case.toml").write_text(CASE + REPORT)
    given = ["report", str(tmp_path), "accuracy", "--output", str(tmp_path / "out")]
    shown = CliRunner().invoke(app, [*given, "--error", "0.5"])
    assert shown.exit_code == 0, shown.output
    assert "the cheapest under 0.5" in shown.output
    assert "8 of 8, 0:00 left" in shown.output
    with (tmp_path / "out/accuracy.csv").open() as file:
        rows = list(csv.reader(file))
    assert len(rows) == 9
    for name in ("accuracy.md", "accuracy.png"):
        assert (tmp_path / "out" / name).stat().st_size > 500


def test_a_report_that_is_not_there_has_a_suggestion(tmp_path):
    (tmp_path / "case.toml").write_text(CASE + REPORT)
    shown = CliRunner().invoke(app, ["report", str(tmp_path), "acuracy"])
    assert shown.exit_code == 2
    assert "did you mean 'accuracy'?" in shown.output


def test_progress_tells_what_is_left(capsys):
    console = Console(width=200)
    list(report(read(REPORT.replace("4e-2, 2e-2, 1e-2", "4e-2")), "accuracy", console))
    assert "1 of 4" in capsys.readouterr().out


MEASURED = """
vary."integrator.tolerance" = [0.1]
[report.accuracy.quantity.place]
of = "probe.ball.x"
exact = 1.0
"""
STATICS = """
[time]
end = 1.0
window = 1.0
[analysis]
kind = "{kind}"
steps = 2
count = 2
[section.bar]
kind = "rectangle"
width = 0.01
height = 0.01
[body.bar]
kind = "beam"
start = [0.0, 0.0, 0.0]
end = [1.0, 0.0, 0.0]
elements = 2
section = "bar"
material = "al6061"
[joint.root]
kind = "clamp"
a = {{ body = "bar", at = "start" }}
[load.tip]
kind = "force"
at = {{ body = "bar", at = "end" }}
direction = [0.0, 0.0, 1.0]
amplitude = 1e-3
[probe.tip]
body = "bar"
at = "end"
[report.mesh]
vary."body.bar.elements" = [2, 4, 8]
repeat = 1
[report.mesh.quantity.answer]
of = "{of}"
exact = {exact}
"""


BOX = """
[body.box]
kind = "rigid"
position = [0.0, 1.0, 0.0]
mass = 1.0
inertia = [1.0, 1.0, 1.0]
[joint.one]
kind = "clamp"
a = { body = "box" }
[joint.again]
kind = "clamp"
a = { body = "box", position = [1.0, 1.0, 0.0] }
"""


def test_a_model_that_is_refused_is_a_row():
    """A rigid body that is clamped twice."""
    (result,) = report(read(BOX + REPORT.split("reference")[0] + MEASURED), "accuracy")
    assert column(result, "outcome") == [REFUSED]
    assert any("joint 'again'" in note for note in result.notes)


def test_a_setting_that_takes_too_long_is_given_up():
    ran = timed(read(""), {}, limit=1e-9)
    assert ran.outcome == GIVEN_UP
    assert ran.counts["windows"] == 1


@pytest.mark.parametrize("kind", ["statics", "modes"])
def test_statics_and_modes(kind):
    """Of a cantilever: F L^3 / (3 E I); lambda_1^2 / (2 pi) sqrt(E I / (rho A)) / L^2."""
    from meshes.materials import library_material

    metal, T, side = library_material("al6061"), np.array(293.15), 0.01
    bending = float(metal.youngs_modulus(T)) * side**4 / 12.0
    line = metal.density * side**2
    of, exact = {
        "statics": ("probe.tip.z", 1e-3 / (3.0 * bending)),
        "modes": ("mode.1.frequency", 1.875104**2 / (2.0 * np.pi) * np.sqrt(bending / line)),
    }[kind]
    text = STATICS.format(kind=kind, of=of, exact=exact)
    (result,) = report(from_text(text, Path(".")), "mesh")
    errors = column(result, "answer [-]")
    assert errors[2] < 2e-3
    assert column(result, "outcome") == [DONE] * 3
