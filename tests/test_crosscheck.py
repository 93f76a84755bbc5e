"""thermobody crosscheck: closed forms, exit codes, refusals, convergence, pairing of vibrations."""

import csv
import math
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from coupling import casefile
from coupling.cli import app
from coupling.crosscheck.comparison import ANCF, CONTINUUM, compare
from coupling.crosscheck.pairing import paired
from coupling.crosscheck.quantities import Quantity, deviation, remaining
from coupling.crosscheck.samples import samples
from coupling.crosscheck.solved import Solved, Vibrations
from coupling.crosscheck.stages import measured
from coupling.errors import BadCase

ROOT = Path(__file__).parent.parent
CASES = (
    "heated_boom", "heated_tube", "bent_cantilever", "boley_cantilever", "elastica",
    "pressed_hinge", "single_hinge",
)  # fmt: skip
L, H, ALPHA, RHO, E = 0.5, 0.02, 2e-5, 2700.0, 7e10
RISE, DIFFERENCE = 50.0, 40.0
BAR = f"""
[time]
end = 1.0
window = 0.5
[analysis]
kind = "statics"
steps = 1
[material.plain]
density = {RHO}
youngs_modulus = {E}
poissons_ratio = 0.3
expansion = {ALPHA}
conductivity = 100.0
heat_capacity = 900.0
[section.bar]
kind = "rectangle"
height = {H}
width = {H}
[body.bar]
kind = "beam"
start = [0, 0, 0]
end = [{L}, 0, 0]
elements = 4
normal = [0, 0, 1]
section = "bar"
material = "plain"
[joint.root]
kind = "clamp"
a = {{ body = "bar", at = "start" }}
[thermal]
solver = "prescribed"
full_sections = "gradients"
initial = 300.0
[thermal.wall.lamp]
body = "bar"
side = [0, 0, 1]
hot = {{ ramp = {{ end = 1.0, from = 300.0, to = {300.0 + RISE + DIFFERENCE / 2} }} }}
cold = {{ ramp = {{ end = 1.0, from = 300.0, to = {300.0 + RISE - DIFFERENCE / 2} }} }}
[probe.tip]
body = "bar"
at = "end"
"""
ASKED = """
[crosscheck]
stages = ["mass", "rigid_modes", "thermal_load", "static", "frequencies", "pointing"]
modes = 3
continuum = [{ "mechanics.round" = 8 }, { "mechanics.round" = 8, "mechanics.along" = 2 }]
"""


def scene(text=BAR + ASKED, *settings):
    from coupling.overrides import parse

    return casefile.from_text(text, ROOT, parse(settings))


def silent(text):
    """Nobody listens."""


@pytest.fixture(scope="module")
def result():
    return compare(scene(), [CONTINUUM], silent)


def row(result, stage, quantity):
    (found,) = [r for r in result.rows if (r.stage, r.quantity) == (stage, quantity)]
    return found


# --------------------------------------------------------------------------- closed forms


def test_mass_and_inertia_are_those_of_a_box(result):
    mass = RHO * L * H * H
    for who in (ANCF, CONTINUUM):
        assert row(result, "mass", "mass").values[who] == pytest.approx(mass, rel=1e-10)
        assert row(result, "mass", "centre of mass").values[who] == pytest.approx(L / 2, rel=1e-9)
        least = row(result, "mass", "least moment of inertia").values[who]
        assert least == pytest.approx(mass * H * H / 6.0, rel=1e-9)
        most = row(result, "mass", "greatest moment of inertia").values[who]
        assert most == pytest.approx(mass * (L * L + H * H) / 12.0, rel=1e-9)


def test_a_free_body_has_six_motions_without_frequency_or_strain(result):
    for who in (ANCF, CONTINUUM):
        assert row(result, "rigid_modes", "bar: six rigid frequencies / elastic").values[who] < 1e-3
        strain = row(result, "rigid_modes", "bar: strain energy of a turn / vibration")
        assert strain.values[who] < 1e-15


def test_the_continuum_expands_as_free_strain_that_is_linear_over_the_section_says(result):
    """A circle: fibres stretch by 1 + e + k y, sections swell by 1 + e."""
    e = ALPHA * RISE
    k = ALPHA * DIFFERENCE / H / (1.0 + e)
    radius = (1.0 + e) / k
    along = row(result, "thermal_load", "tip: along").values[CONTINUUM]
    across = row(result, "thermal_load", "tip: across").values[CONTINUUM]
    assert along == pytest.approx(radius * math.sin(k * L) - L, rel=1e-5)
    assert across == pytest.approx(radius * (1.0 - math.cos(k * L)), rel=1e-5)
    assert row(result, "pointing", "tip: rotation").values[CONTINUUM] == pytest.approx(
        1e3 * k * L, rel=1e-5
    )


def test_beams_are_close_to_the_converged_continuum(result):
    assert not result.failures
    compared = [r for r in result.rows if r.reference == CONTINUUM]
    assert len(compared) > 8
    assert all(abs(r.deviations[ANCF]) < 0.005 for r in compared)
    assert all(r.error < 0.002 for r in compared)


# ------------------------------------------------------------------------ numbers by hand


def test_deviations_are_relative_to_the_size_of_the_reference():
    def q(value, **more):
        return Quantity("a", "m", np.asarray(value, float), **more)

    assert deviation(q(1.1), q(1.0)) == pytest.approx(0.1)
    assert deviation(q(0.9), q(1.0)) == pytest.approx(-0.1)
    assert deviation(q([3.0, 5.0]), q([3.0, 4.0])) == pytest.approx(0.2)
    assert deviation(q(1.1), q(1.0, scale=10.0)) == pytest.approx(0.01)
    course = [[0.0, 0.0], [3.0, 4.0]]
    other = [[0.0, 1.0], [3.0, 4.0]]
    assert deviation(q(other, measure="most"), q(course)) == pytest.approx(0.2)
    assert deviation(q(other, measure="rms"), q(course)) == pytest.approx(0.2 / math.sqrt(2.0))
    assert deviation(q(1e-7, measure="nothing"), q(0.0)) == 1e-7


def test_meshes_show_what_error_is_left():
    """Values 1 + 0.08 h^2 of h = 1, 1/2, 1/4: the last is wrong by 0.005."""
    values = [Quantity("a", "m", np.array(1.0 + 0.08 * h * h)) for h in (1.0, 0.5, 0.25)]
    assert remaining(values) == pytest.approx(0.005, rel=0.02)
    assert remaining(values[1:]) == pytest.approx(0.005, rel=0.02)
    stuck = [Quantity("a", "m", np.array(x)) for x in (1.0, 2.0, 1.0)]
    assert remaining(stuck) == pytest.approx(1.0)
    assert math.isnan(remaining(values[:1]))


def test_vibrations_are_paired_by_their_shapes_also_in_another_order():
    shapes = np.eye(6)
    reference = Vibrations(np.array([1.0, 2.0, 3.0]), shapes[:3])
    other = Vibrations(np.array([1.1, 2.9, 3.3]), shapes[[0, 2, 1]])
    assert [f for f, _ in paired(other, reference, 3)] == [1.1, 3.3, 2.9]
    strange = Vibrations(np.array([1.0, 2.0]), shapes[[0, 5]])
    assert math.isnan(paired(strange, reference, 2)[1][0])


def test_double_frequencies_are_paired_whatever_the_directions_of_their_shapes():
    c, s = math.cos(0.7), math.sin(0.7)
    turned = np.array([[c, s, 0, 0], [-s, c, 0, 0], [0, 0, 1, 0]])
    reference = Vibrations(np.array([1.0, 1.0, 4.0]), np.eye(4)[:3])
    pairs = paired(Vibrations(np.array([1.01, 1.01, 4.2]), turned), reference, 3)
    assert [f for f, _ in pairs] == [1.01, 1.01, 4.2]
    assert all(likeness == pytest.approx(1.0) for _, likeness in pairs)


def test_material_points_of_a_beam_follow_a_rigid_turn():
    from scipy.spatial.transform import Rotation

    solved = Solved("ancf", scene())
    rng = np.random.default_rng(1)
    points = rng.uniform([0.0, -H / 2, -H / 2], [L, H / 2, H / 2], (20, 3))
    made = samples(solved.model, {"bar": points})
    q0 = solved.model.layout.q0
    turn = Rotation.from_rotvec([0.3, -0.8, 0.5])
    q = turn.apply(q0.reshape(-1, 3)).ravel()
    np.testing.assert_allclose(made.places(q0), points, atol=1e-12)
    np.testing.assert_allclose(made.places(q), turn.apply(points), atol=1e-12)
    rotation = solved.sections["tip"].rotation(q)
    np.testing.assert_allclose(rotation, turn.as_rotvec(), atol=1e-9)


# ------------------------------------------------------------------------------ command


def run(folder, *more, text=BAR + ASKED):
    (folder / "case.toml").write_text(text)
    command = ["crosscheck", str(folder), "--output", str(folder / "there"), *more]
    return CliRunner().invoke(app, command)


def test_the_command_writes_tables_and_a_picture(tmp_path):
    done = run(tmp_path, "--with", "continuum")
    assert done.exit_code == 0, done.output
    assert "continuum / ancf" in done.output
    with (tmp_path / "there" / "crosscheck.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert {r["stage"] for r in rows} == set(scene().crosscheck.stages)
    for name in ("times.csv", "crosscheck.md", "crosscheck.png"):
        assert (tmp_path / "there" / name).stat().st_size > 100


def test_beyond_the_tolerance_the_exit_code_is_1(tmp_path):
    strict = "[crosscheck.tolerance]\nthermal_load = 1e-7\n"
    done = run(tmp_path, "--with", "continuum", text=BAR + ASKED + strict)
    assert done.exit_code == 1
    assert "ancf deviates by" in done.output


def test_a_value_known_otherwise_is_compared(tmp_path):
    known = """
[crosscheck.exact.wrong]
stage = "thermal_load"
quantity = "tip: along"
value = 1.0
source = "nowhere"
"""
    done = run(tmp_path, "--with", "", text=BAR + ASKED + known)
    assert done.exit_code == 1 and "exact" in done.output
    other = run(tmp_path, "--with", "", "--set", "body.bar.elements=5", text=BAR + ASKED + known)
    assert other.exit_code == 0 and "hold for the case as it is written" in other.output


def test_an_unconverged_continuum_is_a_failure():
    coarse = ASKED.replace(
        '"mechanics.round" = 8 }, {', '"body.bar.elements" = 1, "mechanics.round" = 8 }, {'
    )
    text = BAR + coarse + "[crosscheck.tolerance]\nfrequencies = 1e-6\n"
    found = compare(scene(text), [CONTINUUM], silent).failures
    assert any("not converged" in text for text in found)


def test_a_case_without_the_table_is_refused(tmp_path):
    done = run(tmp_path, text=BAR)
    assert done.exit_code == 2 and "crosscheck: missing" in done.output


def test_unknown_participants_are_refused(tmp_path):
    done = run(tmp_path, "--with", "abaqus,continum")
    assert done.exit_code == 2
    assert "no participant 'abaqus'" in done.output and "did you mean 'continuum'" in done.output


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('"mass"', '"mas"', "did you mean 'mass'"),
        ('"mass"', '"transient"', "'transient': needs motion in time"),
        ('"mass"', '"contact"', "'contact': needs motion in time"),
        ('"mass"', '"static"', "names a stage twice"),
        ('"mechanics.round" = 8 }, {', '"mechanic.round" = 8 }, {', "did you mean 'mechanics'"),
        ("modes = 3", "modes = 0", "expected a positive integer"),
        ("modes = 3", "mode = 3", "did you mean 'modes'"),
        ("[probe.tip]\nbody", "[probes.tip]\nbody", "'static': needs a [probe.NAME]"),
        ("[body.bar]", "[gravity]\nacceleration = [0, 0, -9.81]\n[body.bar]", ""),
    ],
)
def test_what_cannot_be_compared_is_refused_at_reading(old, new, said):
    text = (BAR + ASKED).replace(old, new)
    if not said:
        assert casefile.from_text(text, ROOT)
        return
    with pytest.raises(BadCase) as refused:
        casefile.from_text(text, ROOT)
    assert said in str(refused.value)


def test_expansion_is_free_only_of_a_body_on_one_clamp():
    second = '[joint.other]\nkind = "spherical"\na = { body = "bar", at = "end" }\n'
    with pytest.raises(BadCase, match="expansion is free only of one body that one clamp holds"):
        casefile.from_text(BAR + second + ASKED, ROOT)


def test_stages_of_a_motion():
    text = BAR.replace('kind = "statics"\nsteps = 1', 'kind = "dynamics"')
    text += ASKED.replace('"static", "frequencies", ', '"transient", ')
    solved = Solved("ancf", casefile.from_text(text, ROOT))
    found = {q.name: q for q in measured(solved, "transient")}
    assert found["tip: farthest"].shown > 0.0
    assert found["tip: displacement, rms"].value.shape == (3, 3)
    turned = {q.name: q for q in measured(solved, "pointing")}
    assert turned["tip: rotation, most"].value.shape == (3, 3)


# -------------------------------------------------------------------------------- cases


@pytest.mark.parametrize("name", CASES)
def test_the_cases_say_what_they_compare(name):
    case = casefile.read(ROOT / "cases" / name)
    assert case.crosscheck is not None and len(case.crosscheck.continuum) >= 2


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES[:-1])
def test_beams_are_within_the_tolerance_of_a_converged_continuum(name, tmp_path):
    command = ["crosscheck", str(ROOT / "cases" / name), "--with", "continuum"]
    done = CliRunner().invoke(app, [*command, "--output", str(tmp_path)])
    assert done.exit_code == 0, done.output


@pytest.mark.slow
def test_of_the_hinge_only_the_force_of_an_impact_is_beyond_its_tolerance():
    found = compare(casefile.read(ROOT / "cases" / "single_hinge"), [CONTINUUM], silent)
    beyond = [r.quantity for r in found.rows if r.beyond or r.unconverged]
    assert set(beyond) <= {"normal force, greatest"}
    force = row(found, "contact", "normal force, greatest")
    assert abs(force.deviations[ANCF]) < 0.05  # 2.65 % was measured, and 2.5 % is allowed
