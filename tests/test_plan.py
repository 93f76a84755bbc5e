"""The plan of every case is the one that was reviewed, and follows what the scene has."""

from pathlib import Path

import pytest
from typer.testing import CliRunner

from coupling import casefile
from coupling.cli import app
from coupling.model import build

ROOT = Path(__file__).parent.parent
REVIEWED = sorted((ROOT / "cases").glob("*/plan.txt"))


@pytest.mark.parametrize("file", REVIEWED, ids=[f.parent.name for f in REVIEWED])
def test_the_plan_is_the_reviewed_one(file):
    """When a change to it is meant: thermobody plan CASE > CASE/plan.txt"""
    shown = CliRunner().invoke(app, ["plan", str(file.parent)])
    assert shown.exit_code == 0
    assert shown.output.splitlines() == file.read_text(encoding="utf-8").splitlines()


def test_the_main_case_has_a_reviewed_plan():
    assert "arm_rotation" in [file.parent.name for file in REVIEWED]


BAR = """
[time]
end = 1.0
window = 0.1

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
"""

GRAVITY = "[gravity]\nacceleration = [0.0, 0.0, -9.81]\n"
HEAT = "[thermal]\ninitial = 300.0\nwall_points = 1\n"
LAMP = '[thermal.source.lamp]\nat = { body = "bar", at = "end" }\npower = 3.0\n'
PIN = """
[joint.pin]
kind = "clearance_revolute"
journal = { body = "bar", at = "end" }
axis = [0.0, 0.0, 1.0]
radius = 0.02
clearance = 1e-4
journal_material = "al6061"
bearing_material = "al6061"
"""
RUBBING = "[joint.pin.friction]\ncoefficient = 0.2\n"


def planned(text):
    """Name -> text of what runs, and the lines of what is left out."""
    plan = str(build(casefile.from_text(text, ROOT)))
    runs, _, left_out = plan.partition("left out")
    rows = [line[10:].split(maxsplit=1) for line in runs.splitlines() if line]
    return dict(rows), [line.strip() for line in left_out.splitlines()]


def test_a_bare_bar_leaves_out_heat_contact_and_loads():
    runs, left_out = planned(BAR)
    assert list(runs) == ["mechanics.beam3243", "mechanics.joints", "mechanics.hht",
                          "coupling.isothermal"]  # fmt: skip
    assert runs["mechanics.beam3243"] == "3 elements"
    assert runs["mechanics.joints"] == "6 constraints on 48 coordinates"
    assert runs["coupling.isothermal"] == "10 windows of 0.1 s"
    for what in ("heat:", "contact:", "loads:", "gravity:", "structural damping:"):
        assert any(line.startswith(what) for line in left_out), what


@pytest.mark.parametrize(
    ("added", "runs_now", "was_left_out"),
    [
        (GRAVITY, "mechanics.loads", "gravity:"),
        (HEAT, "thermal.line", "heat:"),
        (PIN, "mechanics.clearance", "contact:"),
    ],
)
def test_what_a_scene_has_moves_from_left_out_to_runs(added, runs_now, was_left_out):
    before, after = planned(BAR), planned(BAR + added)
    assert runs_now not in before[0] and runs_now in after[0]
    assert any(line.startswith(was_left_out) for line in before[1])
    assert not any(line.startswith(was_left_out) for line in after[1])


def test_conditions_of_heat_are_counted_or_left_out():
    bare, lit = planned(BAR + HEAT), planned(BAR + HEAT + LAMP)
    assert "source" in lit[0]["thermal.line"] and "4 temperatures" in lit[0]["thermal.line"]
    assert any(line.startswith("heat sources:") for line in bare[1])
    assert not any(line.startswith("heat sources:") for line in lit[1])


def test_frictional_heat_that_nobody_takes_is_said():
    _, left_out = planned(BAR + PIN + RUBBING + HEAT)
    assert any(line.startswith("frictional heat of pin.journal:") for line in left_out)
    assert any(line.startswith("frictional heat of pin.bearing:") for line in left_out)


def test_kinds_of_joints_with_clearance_are_named_with_their_laws():
    spatial = PIN.replace("joint.pin", "joint.wide").replace("axis", "length = 0.1\naxis", 1)
    spatial = spatial.replace("radius", "axial_clearance = 1e-4\nradius", 1)
    sticky = spatial + "[joint.wide.friction]\nlaw = 'stick'\ncoefficient = 0.2\n"
    sticky = sticky.replace('at = "end"', 'at = "start"')
    text = str(build(casefile.from_text(BAR + PIN + sticky + HEAT, ROOT)))
    law = "hertz-external, exact hysteresis"
    assert f"1 × planar revolute clearance, {law}, onsets located, thermal clearance" in text
    wide = f"1 × revolute clearance of 8 contacts, {law}, stick friction"
    assert f"{wide}, onsets located, thermal clearance" in text


def test_a_telescope_says_its_stations():
    sleeve = BAR.partition("[body.bar]")[2].partition("[joint")[0]
    sleeve = "[body.sleeve]" + sleeve.replace("[0.0, 0.0, 0.0]", "[-1.0, 0.0, 0.0]")
    joint = "[joint.tubes]\nkind = 'telescope'\ninner = 'bar'\nouter = 'sleeve'\nstations = 2\n"
    runs, _ = planned(BAR + sleeve + joint + "radius = 0.01\nclearance = 1e-3\n")
    # four nodes, two stations in each of three elements, the mouth
    said = "1 × telescope of 11 contacts, hertz-external, exact hysteresis, onsets located"
    assert runs["mechanics.telescope"] == said
    pads = "preload = { force = '20 N', stiffness = '1 kN/m' }\n"
    runs, _ = planned(BAR + sleeve + joint + "radius = 0.01\nclearance = 1e-3\n" + pads)
    assert runs["mechanics.telescope"] == said.replace("11", "13") + ", preloaded pads"


def test_list_says_what_every_contact_law_is():
    from coupling.catalogue import FRICTION, NORMAL
    from mechanics import contact

    assert NORMAL.keys() == contact.STIFFNESS.keys()
    assert FRICTION.keys() == contact.FRICTION.keys()


@pytest.mark.parametrize("scheme", ["serial", "corrected"])
def test_the_scheme_is_named(scheme):
    runs, _ = planned(BAR + HEAT + f'[coupling]\nscheme = "{scheme}"\n')
    assert f"coupling.{scheme}" in runs


def test_plan_of_statics_and_modes_says_load_factors_not_windows(tmp_path):
    from test_analyses import CASE

    (tmp_path / "case.toml").write_text(CASE)
    shown = {
        kind: CliRunner().invoke(app, ["plan", str(tmp_path), *settings]).output
        for kind, settings in {
            "statics": ["--set", "analysis.kind=statics"],
            "path": ["--set", "analysis.kind=statics", "--set", "analysis.arc_length=true"],
            "modes": ["--set", "analysis.kind=modes", "--set", "analysis.count=3"],
        }.items()
    }
    assert "load factor from 0 to 1, first load step 1/10" in shown["statics"]
    assert "path by arc length to load factor 1, at most 200 points" in shown["path"]
    assert "3 modes about the equilibrium" in shown["modes"]
    assert not any("windows" in text or "hht" in text for text in shown.values())


def test_list_says_what_every_thermal_solver_does():
    from coupling.catalogue import HEAT
    from thermal.solvers import SOLVERS

    assert HEAT.keys() == SOLVERS.keys()
