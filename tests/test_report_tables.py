"""[report.NAME]: what is read of it, and what is refused with a path and a suggestion."""

from pathlib import Path

import pytest

from coupling.casefile import from_text, read
from coupling.errors import BadCase
from coupling.report_quantities import unit_of
from coupling.report_tables import Varied, said

CASES = Path(__file__).parent.parent / "cases"
NAMES = ("arm_rotation", "folding_array", "ring_clearance", "ring_truss", "slider_crank",
         "slider_crank_guide", "sunlit_boom", "sunlit_tube")  # fmt: skip

CASE = """
[time]
end = 1.0
window = 0.1
[body.ball]
kind = "particle"
position = [1.0, 0.0, 0.0]
mass = 2.0
[joint.wire]
kind = "spring"
a = { body = "ball" }
b = { body = "ground", position = [0.0, 0.0, 0.0] }
stiffness = 8.0
length = 1.0
[probe.ball]
body = "ball"
"""
REPORT = """
[report.accuracy]
common = { "time.end" = 2.0 }
reference = { "integrator.tolerance" = 1e-9 }
vary."integrator.tolerance" = [1e-3, 1e-4]
[report.accuracy.quantity.place]
of = "probe.ball.x"
"""


def scene(text=REPORT):
    return from_text(CASE + text, Path("."))


def refused(old, new):
    assert old in CASE + REPORT
    with pytest.raises(BadCase) as error:
        from_text((CASE + REPORT).replace(old, new, 1), Path("."))
    return {p.path: p.text for p in error.value.problems}


def test_one_entry_makes_one_curve():
    first, second = scene().report["accuracy"].variants()
    assert first.overrides == {"integrator.tolerance": 1e-3}
    assert (first.curve, second.name) == ("", "tolerance 0.0001")


def test_a_grid_has_all_combinations_and_the_last_entry_along_the_curves():
    varied = Varied(vary={"a.b": [1, 2], "c.d": [3.0, 4.0, 5.0]})
    curves = [of_curve for of_curve, _ in varied.points()]
    assert curves == [{"a.b": 1}] * 3 + [{"a.b": 2}] * 3
    assert [of_point["c.d"] for _, of_point in varied.points()] == [3.0, 4.0, 5.0] * 2


def test_together_takes_values_side_by_side():
    varied = Varied(vary={"a.b": [1, 2], "c.d": [3.0, 4.0]}, combine="together")
    assert [point for _, point in varied.points()] == [
        {"a.b": 1, "c.d": 3.0},
        {"a.b": 2, "c.d": 4.0},
    ]


def test_settings_are_curves_or_points():
    text = (
        REPORT
        + """
[[report.accuracy.setting]]
label = "bdf2"
set = { "integrator.scheme" = "bdf2" }
[[report.accuracy.setting]]
label = "in windows"
vary."time.window" = [0.5]
"""
    )
    found = scene(text).report["accuracy"].variants()
    assert [v.label for v in found] == [
        "bdf2, tolerance 0.001", "bdf2, tolerance 0.0001", "in windows, window 0.5"
    ]  # fmt: skip
    assert found[0].overrides == {"integrator.scheme": "bdf2", "integrator.tolerance": 1e-3}
    assert found[2].overrides == {"time.window": 0.5}


def test_values_in_words():
    assert said({"a.tolerance": 1e-5, "b.solver": "line", "c.n": [1, 2]}) == (
        "tolerance 1e-5, solver line, n [1, 2]"
    )


@pytest.mark.parametrize(
    ("of", "unit"),
    [("probe.a.vx", "m/s"), ("probe.a.temperature", "K"), ("body.b.gradient", "K/m"),
     ("contact.c.end_1.peak_force", "N"), ("contact.c.impacts", ""), ("ledger.friction", "J"),
     ("mode.2.frequency", "Hz"), ("load_factor", "")],
)  # fmt: skip
def test_units(of, unit):
    assert unit_of(of) == unit


@pytest.mark.parametrize(
    ("old", "new", "path", "text"),
    [
        ('vary."integrator.tolerance"', 'vary."integrator.tolerence"', "vary",
         "did you mean 'tolerance'?"),
        ('{ "time.end"', '{ "tim.end"', "common", "did you mean 'time'?"),
        ('{ "integrator.tolerance" = 1e-9', '{ "body.bal.mass" = 1.0', "reference",
         "there is no body 'bal'; did you mean 'ball'?"),
        ('{ "integrator.tolerance" = 1e-9', '{ "body.ball.mas" = 1.0', "reference",
         "did you mean 'mass'?"),
        ('{ "time.end"', '{ "report.a.common"', "common", "a report cannot change reports"),
        ('{ "time.end"', '{ "time end"', "common", "expected a path"),
        ('"probe.ball.x"', '"probe.bal.x"', "quantity.place.of", "did you mean 'ball'?"),
        ('"probe.ball.x"', '"probe.ball.velocty"', "quantity.place.of", "did you mean 'velocity'?"),
        ('"probe.ball.x"', '"probe.ball.temperature"', "quantity.place.of", "has no heat"),
        ('"probe.ball.x"', '"probe.ball"', "quantity.place.of", "says too little"),
        ('"probe.ball.x"', '"tip.x"', "quantity.place.of", "known here: probe.NAME.z"),
        ('"probe.ball.x"', '"body.ball.mean"', "quantity.place.of", "has no temperature"),
        ('"probe.ball.x"', '"contact.pin.impacts"', "quantity.place.of", "joint with clearance"),
        ('"probe.ball.x"', '"mode.1.frequency"', "quantity.place.of", "belongs to modes"),
        ('"probe.ball.x"', '"ledger.frction"', "quantity.place.of", "did you mean 'friction'?"),
        ('"probe.ball.x"', '"probe.ball.x"\nmeasure = "finally"', "quantity.place.measure",
         "did you mean 'final'?"),
        ('"probe.ball.x"', '"probe.ball.x"\nexact = 1.0\nmeasure = "course"',
         "quantity.place.exact", "compares a whole course"),
        ("reference = {", "chek = {", "chek", "did you mean 'check'?"),
        ("[1e-3, 1e-4]", "[]", "vary", "has no values"),
        ("[1e-3, 1e-4]", "[1e-3, 1e-4]\nrepeat = 0", "repeat", "expected a positive integer"),
        ("report.accuracy", "report.work", "report.work", "the name is taken"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_said_with_its_place(old, new, path, text):
    if path == "report.work":
        with pytest.raises(BadCase) as error:
            from_text(CASE + REPORT.replace(old, new), Path("."))
        problems = {p.path: p.text for p in error.value.problems}
    else:
        problems = refused(old, new)
        path = f"report.accuracy.{path}"
    assert text in problems[path]


def test_a_reference_is_needed_where_nothing_is_exact():
    problems = refused('reference = { "integrator.tolerance" = 1e-9 }\n', "")
    assert "quantity 'place' has no exact value" in problems["report.accuracy.reference"]
    scene(REPORT.replace('reference = { "integrator.tolerance" = 1e-9 }\n', "") + "exact = 1.0\n")


def test_values_together_are_as_many():
    text = 'vary."integrator.tolerance" = [1e-3, 1e-4]'
    more = text + '\nvary."time.window" = [0.1]\ncombine = "together"'
    assert "as many values" in refused(text, more)["report.accuracy.combine"]


def test_a_run_takes_no_notice():
    assert scene("").report == {}


@pytest.mark.parametrize("name", NAMES)
def test_each_case_that_is_shipped_has_a_report(name):
    assert read(CASES / name).report
