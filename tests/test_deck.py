"""A scene as a CalculiX deck: closed forms, refusals, text."""

import os
import re
import shutil
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from coupling import casefile
from coupling.cli import app
from coupling.deck import Options, deck, secant
from coupling.deck_bodies import Fineness
from coupling.deck_export import heat_deck
from coupling.deck_heat import history
from coupling.deck_results import read
from coupling.deck_run import opinion
from coupling.errors import BadCase
from coupling.model import build
from meshes.materials import library_material

needs_ccx = pytest.mark.skipif(
    shutil.which(os.environ.get("THERMOBODY_CCX", "ccx")) is None, reason="ccx is not installed"
)
GOLDEN = Path(__file__).parent / "small_deck.inp"
E, NU, ALPHA, RHO = 69e9, 0.33, 23e-6, 2700.0
MATERIAL = f"""
[material.plain]
density = {RHO}
youngs_modulus = {E}
poissons_ratio = {NU}
expansion = {ALPHA}
conductivity = 167
heat_capacity = 900
"""
SECTIONS = """
[section.bar]
kind = "rectangle"
height = "10 mm"
width = "10 mm"
[section.tube]
kind = "tube"
mean_radius = "12.5 mm"
thickness = "1 mm"
"""
TIP = """
[probe.tip]
body = "boom"
at = "end"
"""
STIFF = E * 0.01**4 / 12.0
COARSE = Fineness(8, 2)
SMALL = Options(COARSE, large=False)


def beam(name="boom", start="[0, 0, 0]", end='["1 m", 0, 0]', section="bar", **more):
    """A [body.NAME]; ``more`` are further lines of it."""
    own = {"elements": 8, "material": '"plain"', "reference_temperature": '"25 degC"'} | more
    lines = "\n".join(f"{key} = {value}" for key, value in own.items())
    return (
        f'[body.{name}]\nkind = "beam"\nstart = {start}\nend = {end}\nnormal = [0, 1, 0]\n'
        f'section = "{section}"\n{lines}\n'
    )


def clamp(body="boom", at="start", kind="clamp", more=""):
    return f'[joint.{body}_{at}]\nkind = "{kind}"\na = {{ body = "{body}", at = "{at}" }}\n{more}\n'


def force(amount, direction="[0, -1, 0]", kind="force"):
    return (
        f'[load.{kind}]\nkind = "{kind}"\nat = {{ body = "boom", at = "end" }}\n'
        f'direction = {direction}\namplitude = "{amount}"\n'
    )


def wall(hot, cold, body="boom"):
    return (
        '[thermal]\nsolver = "prescribed"\ninitial = "25 degC"\nfull_sections = "gradients"\n'
        f'wall_points = 8\n[thermal.wall.sun]\nbody = "{body}"\nside = [0, 1, 0]\n'
        f"hot = {hot}\ncold = {cold}\n"
    )


def scene(*parts, kind="statics", end="1 s", window="1 s"):
    head = f'[time]\nend = "{end}"\nwindow = "{window}"\n[analysis]\nkind = "{kind}"\ncount = 3\n'
    return casefile.from_text("\n".join([head, MATERIAL, SECTIONS, *parts]), Path("."))


def tip(case, options=SMALL, stage="static", probe="tip"):
    return opinion(case, stage, options).displacements[probe]


# ------------------------------------------------------------------------------------ rest


@needs_ccx
def test_a_heated_tube_bows_and_lengthens_as_an_arc():
    case = scene(beam(section="tube", elements=4), clamp(), TIP, wall('"100 degC"', '"50 degC"'))
    moved = tip(case, Options(Fineness(12), large=True), "thermal_load")
    strain, bend = ALPHA * 50.0, ALPHA * 50.0 / 0.025
    np.testing.assert_allclose(moved[1], -(1.0 - np.cos(bend)) / bend, rtol=2e-3)
    assert moved[0] == pytest.approx((1.0 + strain) * np.sin(bend) / bend - 1.0, rel=1e-2)
    assert abs(moved[2]) < 1e-9


@needs_ccx
@pytest.mark.parametrize("T", [-100.0, 100.0])
def test_length_follows_the_integral_of_the_expansion(T):
    case = scene(
        beam(section="tube", material='"al6061-paper"'), clamp(), TIP,
        wall(f'"{T:g} degC"', f'"{T:g} degC"'),
    )  # fmt: skip
    strain = library_material("al6061-paper").thermal_strain(T + 273.15, 298.15)
    assert tip(case)[0] == pytest.approx(strain, rel=1e-4)


def test_the_secant_expansion_is_the_mean_from_its_zero():
    p = library_material("al6061-paper").expansion
    table = secant(p, 298.15, (150.0, 450.0))
    for T in (151.0, 297.9, 298.15, 298.4, 400.0):
        expected = p(T) if T == 298.15 else p.integral(298.15, T) / (T - 298.15)
        assert np.interp(T, table.temperatures, table.values) == pytest.approx(expected, rel=1e-5)


@needs_ccx
def test_a_rod_that_bends_far_is_the_elastica():
    """Tip of the geometrically exact rod, by independent integration of its equations."""
    case = scene(beam(), clamp(), TIP, force("172.5 N"))
    moved = tip(case, Options(COARSE, large=True))
    np.testing.assert_allclose(moved, [0.74557 - 1.0, -0.60330, 0.0], atol=1e-4)


@needs_ccx
def test_tip_force_moment_and_weight():
    bend = STIFF
    assert tip(scene(beam(), clamp(), TIP, force("1 N")))[1] == pytest.approx(
        -1.0 / (3 * bend), rel=1e-3
    )
    turned = scene(beam(), clamp(), TIP, force("1 N m", "[0, 0, 1]", "moment"))
    assert tip(turned)[1] == pytest.approx(1.0 / (2 * bend), rel=1e-3)
    heavy = scene(beam(), clamp(), TIP, '[gravity]\nacceleration = [0, 0, "-9.81 m/s^2"]\n')
    found = opinion(heavy, "static", SMALL)
    line = RHO * 1e-4 * 9.81
    assert found.displacements["tip"][2] == pytest.approx(-line / (8 * bend), rel=1e-3)
    np.testing.assert_allclose(found.reaction, [0.0, 0.0, line], atol=1e-5 * line)


@needs_ccx
def test_a_tube_twists_as_saint_venants():
    rim = '[probe.rim]\nbody = "boom"\nat = "end"\noffset = [0, "10 mm", 0]\n'
    twisted = scene(beam(section="tube"), clamp(), rim, force("1 N m", "[1, 0, 0]", "moment"))
    polar = 0.5 * np.pi * (0.013**4 - 0.012**4)
    turn = 1.0 / (E / (2.0 * (1.0 + NU)) * polar)
    moved = tip(twisted, Options(Fineness(16), large=False), probe="rim")
    assert moved[2] == pytest.approx(0.01 * turn, rel=2e-3)


@needs_ccx
def test_two_beams_clamped_together_are_one():
    together = (
        '[joint.weld]\nkind = "clamp"\na = { body = "boom", at = "start" }\n'
        'b = { body = "root", at = "end" }\n'
    )
    case = scene(
        beam("root", end='["0.5 m", 0, 0]', elements=4),
        beam("boom", start='["0.5 m", 0, 0]', elements=4),
        clamp("root"), together, TIP, force("1 N"),
    )  # fmt: skip
    assert tip(case)[1] == pytest.approx(-1.0 / (3 * STIFF), rel=1e-3)


@needs_ccx
@pytest.mark.parametrize(
    ("ends", "factor"),
    [
        ((clamp(), clamp(at="end", kind="guide", more="directions = [[0, 1, 0]]")), 7 / 768),
        ((clamp(), clamp(at="end", kind="revolute", more="axis = [0, 0, 1]")), 7 / 768),
        ((clamp(kind="spherical"), clamp(at="end", kind="revolute", more="axis = [0, 0, 1]")),
         1 / 48),
        ((clamp(), clamp(at="end")), 1 / 192),
    ],
)  # fmt: skip
def test_beams_held_at_both_ends(ends, factor):
    """Deflection under a force in the middle, F L^3 / (E I) times a factor (Young 1989, Tab. 3)."""
    middle = '[probe.tip]\nbody = "boom"\nat = "0.5 m"\n'
    push = (
        '[load.push]\nkind = "force"\nat = { body = "boom", at = "0.5 m" }\n'
        'direction = [0, -1, 0]\namplitude = "1 N"\n'
    )
    case = scene(beam(), *ends, middle, push)
    assert tip(case)[1] == pytest.approx(-factor / (STIFF), rel=3e-3)


@needs_ccx
def test_an_arc_under_a_force_across_its_end():
    """Castigliano: pi F R^3 / (4 E I) along the force, for a quarter of a slender circle."""
    arc = (
        '[body.boom]\nkind = "beam"\nstart = ["1 m", 0, 0]\nelements = 12\nsection = "bar"\n'
        'arc = { center = [0, 0, 0], axis = [0, 0, 1], angle = "90 deg" }\nmaterial = "plain"\n'
    )
    case = scene(arc, clamp(), TIP, force("1 N", "[0, -1, 0]"))
    assert tip(case)[1] == pytest.approx(-np.pi / 4 / (STIFF), rel=5e-3)


@needs_ccx
def test_a_strip_of_shell_bends_as_a_beam():
    strip = (
        '[material.slack]\ndensity = 2700\nyoungs_modulus = 69e9\npoissons_ratio = 0\n'
        'expansion = 23e-6\nconductivity = 167\nheat_capacity = 900\n'
        '[body.sail]\nkind = "shell"\nthickness = "5 mm"\nmaterial = "slack"\n'
        'surface = { kind = "plate", length = "1 m", width = "0.2 m", elements = [8, 2] }\n'
        '[joint.mast]\nkind = "clamp"\na = { body = "sail", edge = "u-start" }\n'
        '[load.light]\nkind = "traction"\nbody = "sail"\ndirection = [0, 0, 1]\n'
        'pressure = "20 Pa"\n[probe.tip]\nbody = "sail"\nposition = ["1 m", 0, 0]\n'
    )  # fmt: skip
    assert tip(scene(strip))[2] == pytest.approx(20.0 / (8 * E * 0.005**3 / 12), rel=1e-3)


# ---------------------------------------------------------------------------------- motion


@needs_ccx
def test_frequencies_of_a_tube_follow_its_modulus():
    """25.01 Hz of a rod; with temperature as the root of E(T), where thermal strain is left out."""
    found, mass = {}, {}
    for T in (25, 100, -100):
        case = scene(
            beam(section="tube", material='"al6061-paper"'), clamp(), TIP,
            wall(f'"{T} degC"', f'"{T} degC"'), kind="modes",
        )  # fmt: skip
        options = Options(Fineness(16), preload=False)
        own = opinion(case, "frequencies", options)
        found[T], mass[T] = own.frequencies[0], own.mass
    assert found[25] == pytest.approx(25.01, rel=1e-3)
    assert found[100] / found[25] == pytest.approx(0.99295, rel=2e-5)
    assert found[-100] / found[25] == pytest.approx(1.00545, rel=2e-5)
    area = 2.0 * np.pi * 0.0125 * 0.001
    density = library_material("al6061-paper").density
    assert mass[25] == pytest.approx(density * area, rel=1e-4)


@needs_ccx
def test_tension_raises_frequencies():
    """Of a string-like strut: f^2 rises as with the tension (Euler-Bernoulli, one-term, 1 %)."""
    slack, tight = (
        opinion(
            scene(
                beam(), clamp(kind="spherical"), clamp(at="end", kind="guide",
                more="directions = [[0, 1, 0], [0, 0, 1]]"),
                '[joint.twist]\nkind = "fixing"\na = { body = "boom", at = "start" }\n'
                'vector = "r_y"\ndirections = [[0, 0, 1]]\n',
                TIP, force(f"{pull} N", "[1, 0, 0]"), kind="modes",
            ),
            "frequencies",
            SMALL,
        ).frequencies[0]
        for pull in (0, 2000)
    )  # fmt: skip
    expected = 1.0 + 2000.0 / (np.pi**2 * STIFF)
    assert (tight / slack) ** 2 == pytest.approx(expected, rel=1e-2)


def boley(t, rise, bend):
    """Tip of a cantilever whose thermal curvature rises to ``bend`` within ``rise`` [s].

    Euler and Bernoulli's beam, by its modes (Boley 1956).
    """
    moved = np.zeros_like(t)
    wave = np.sqrt(STIFF / (RHO * 1e-4))
    for beta in (1.87510407, 4.69409113, 7.85475744, 10.9955407, 14.1371684):
        s = (np.cosh(beta) + np.cos(beta)) / (np.sinh(beta) + np.sin(beta))
        shape = np.cosh(beta) - np.cos(beta) - s * (np.sinh(beta) - np.sin(beta))
        slope = beta * (np.sinh(beta) + np.sin(beta) - s * (np.cosh(beta) - np.cos(beta)))
        omega = beta**2 * wave
        late = np.maximum(t - rise, 0.0)
        swing = (t - late - (np.sin(omega * t) - np.sin(omega * late)) / omega) / rise
        moved += bend * shape * slope / beta**4 * swing
    return moved


@needs_ccx
def test_a_cantilever_heated_fast_swings_as_boleys():
    rise = 'ramp = {{ start = "0 s", end = "30 ms", from = "25 degC", to = "{}" }}'
    case = scene(
        beam(), clamp(), TIP,
        wall(f"{{ {rise.format('35 degC')} }}", f"{{ {rise.format('15 degC')} }}"),
        kind="dynamics", end="0.1 s", window="10 ms",
    )  # fmt: skip
    found = opinion(case, "transient", SMALL._replace(steps=100))
    moved = -found.courses["tip"][:, 1]
    expected = boley(found.times, 0.03, ALPHA * 20.0 / 0.01)
    still = -tip(case)[1]
    assert still == pytest.approx(0.5 * ALPHA * 20.0 / 0.01, rel=1e-3)
    assert moved.max() / still == pytest.approx(expected.max() / still, rel=0.02)
    assert np.abs(moved - expected).max() < 0.03 * expected.max()


@needs_ccx
def test_kelvin_voigt_damping_is_calculixs():
    """First overshoot of an oscillator whose damping ratio is half its Kelvin-Voigt time x w."""
    case = scene(
        beam(damping='"12 ms"', elements=4), clamp(), TIP, force("1 N"),
        kind="dynamics", end="0.1 s", window="0.1 s",
    )  # fmt: skip
    found = opinion(case, "transient", SMALL._replace(steps=40))
    ratio = 0.5 * 0.012 * 1.87510407**2 * np.sqrt(STIFF / (RHO * 1e-4))
    over = 1.0 + np.exp(-np.pi * ratio / np.sqrt(1.0 - ratio**2))
    peak = -found.courses["tip"][:, 1].min() * 3.0 * STIFF
    assert peak == pytest.approx(over, rel=0.01)


@needs_ccx
def test_a_free_beam_flies_on():
    case = scene(
        beam(velocity='["2 m/s", 0, "1 m/s"]'), TIP, kind="dynamics", end="0.1 s", window="0.1 s"
    )
    found = opinion(case, "transient", SMALL._replace(steps=5))
    expected = found.times[:, None] * np.array([2.0, 0.0, 1.0])
    np.testing.assert_allclose(found.courses["tip"], expected, atol=1e-7)


@needs_ccx
def test_motion_from_equilibrium_stays_there():
    case = scene(beam(), clamp(), TIP, force("1 N"), kind="dynamics", end="50 ms", window="50 ms")
    analysis = case.analysis.model_copy(update={"start": "equilibrium"})
    case = case.model_copy(update={"analysis": analysis})
    found = opinion(case, "transient", SMALL._replace(steps=10))
    np.testing.assert_allclose(found.courses["tip"][:, 1], -1.0 / (3 * STIFF), rtol=2e-3)
    assert found.times[-1] == pytest.approx(0.05)


# ------------------------------------------------------------------------------------ heat

ENDS = """
[thermal]
solver = "{solver}"
initial = "25 degC"
order = 2
[thermal.fixed.cold]
at = {{ body = "boom", at = "start" }}
temperature = "25 degC"
[thermal.fixed.hot]
at = {{ body = "boom", at = "end" }}
temperature = "75 degC"
"""
MIDDLE = '[probe.middle]\nbody = "boom"\nat = "0.5 m"\n'


@needs_ccx
def test_steady_heat_of_a_bar(tmp_path):
    from thermal.calculix_program import executed, program

    case = scene(beam(elements=4), clamp(), TIP, ENDS.format(solver="line"))
    text = heat_deck(case, build(case))
    (tmp_path / "heat.inp").write_text(text)
    executed(program(), tmp_path / "heat", 100.0)
    printed = (tmp_path / "heat.dat").read_text().split("time")[-1].splitlines()[2:]
    rows = np.array([line.split() for line in printed if line.strip()], dtype=float)
    nodes = [line.split(",") for line in text.splitlines()[1 : 1 + len(rows)]]
    x = np.array(nodes, dtype=float)[:, 1]
    np.testing.assert_allclose(rows[:, 1], 298.15 + 50.0 * x, atol=1e-3)


@needs_ccx
def test_temperatures_that_calculix_computed_are_given_at_its_nodes():
    case = scene(
        beam(section="tube", elements=4), clamp(), TIP, MIDDLE, ENDS.format(solver="calculix")
    )
    found = opinion(case, "static", Options(Fineness(24), large=False))
    assert found.temperatures["middle"] == pytest.approx(323.15, abs=1e-3)
    assert found.displacements["tip"][0] == pytest.approx(25.0 * ALPHA, rel=1e-3)


# ------------------------------------------------------------------------------------ text


def small():
    fine = Options(Fineness(4, 1, 1, "hexahedron"), large=False)
    case = scene(beam(elements=1), clamp(), TIP, wall('"35 degC"', '"15 degC"'))
    return deck(case, history(build(case)), fine)


def test_the_text_of_a_small_deck():
    words = [re.split(r"[,=]", line) for line in small().text.splitlines()]
    expected = [re.split(r"[,=]", line) for line in GOLDEN.read_text().splitlines()]
    assert len(words) == len(expected)
    for one, other in zip(words, expected, strict=True):
        assert len(one) == len(other)
        for a, b in zip(one, other, strict=True):
            assert a == b or float(a) == pytest.approx(float(b), rel=1e-9, abs=1e-9)


def test_heat_with_large_rotations_carries_a_warning():
    case = scene(beam(), clamp(), wall('"35 degC"', '"15 degC"'))
    made = deck(case, history(build(case)))
    assert "not objective" in made.warnings[0]
    assert "** Warning: CalculiX 2.20" in made.text
    assert deck(case, history(build(case)), SMALL).warnings == []


REFUSED = {
    "joint 'boom_end': a universal": (
        beam(), clamp(at="end", kind="universal", more="axis_a = [0, 1, 0]\naxis_b = [0, 0, 1]")),
    "joint 'boom_end': it is driven": (
        beam(), clamp(at="end", kind="revolute",
                      more='axis = [0, 0, 1]\nangle = { ramp = { start = "0 s", end = "1 s", '
                                                'from = "0 deg", to = "9 deg" } }')),
    "load 'moment': a moment": (beam(), clamp(), force("1 N m", kind="moment")),
    "body 'ball': a particle": (
        beam(), '[body.ball]\nkind = "particle"\nposition = [0, 0, 0]\nmass = "1 kg"\n'),
    "body 'rope': a cable": (
        beam().replace("boom", "rope").replace('"beam"', '"cable"').replace(
            "normal = [0, 1, 0]", ""),),
    "its axis lies askew": (
        beam(), clamp(at="end", kind="revolute", more="axis = [1, 1, 0]")),
    "damping: Rayleigh's": (beam(), '[damping]\nmass = "1 1/s"\n'),
}  # fmt: skip


@pytest.mark.parametrize("sentence", REFUSED)
def test_what_a_deck_cannot_say_is_refused_by_name(sentence):
    case = scene(*REFUSED[sentence])
    with pytest.raises(BadCase, match=sentence):
        deck(case, history(build(case)))


def test_without_the_program_it_says_so(monkeypatch):
    monkeypatch.setenv("THERMOBODY_CCX", "/nowhere/ccx")
    with pytest.raises(BadCase, match="ccx is not installed"):
        opinion(scene(beam(), clamp(), TIP), "static", SMALL)


def test_a_stage_that_it_has_not_is_bad_input():
    with pytest.raises(BadCase, match="no stage 'contact'"):
        opinion(scene(beam(), clamp(), TIP), "contact", SMALL)


def test_an_empty_file_has_no_results(tmp_path):
    found = read(tmp_path / "nothing.dat")
    assert found.displacements.shape == (0, 0, 3)
    assert not len(found.frequencies)


def test_export_writes_it(tmp_path):
    case = tmp_path / "case.toml"
    case.write_text(
        '[time]\nend = "1 s"\nwindow = "1 s"\n[analysis]\nkind = "modes"\n'
        + MATERIAL + SECTIONS + beam() + clamp()
    )  # fmt: skip
    file = tmp_path / "out" / "boom.inp"
    done = CliRunner().invoke(app, ["export", str(tmp_path), "--deck", "--output", str(file)])
    assert done.exit_code == 0, done.output
    assert "*FREQUENCY" in file.read_text()
    assert "wrote" in done.output


def test_export_refuses_with_code_2(tmp_path):
    case = tmp_path / "case.toml"
    case.write_text(
        '[time]\nend = "1 s"\nwindow = "1 s"\n' + MATERIAL + SECTIONS + beam()
        + '[damping]\nmass = "1 1/s"\n'
    )  # fmt: skip
    done = CliRunner().invoke(app, ["export", str(tmp_path), "--deck"])
    assert done.exit_code == 2
    assert "Rayleigh" in done.output + done.stderr
