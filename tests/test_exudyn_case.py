"""A scene in the words of Exudyn: closed forms, our own elements, refusals."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from coupling import casefile
from coupling.errors import BadCase
from coupling.exudyn_case import Options, opinion
from coupling.model import build
from coupling.simulation import windows

needs_exudyn = pytest.mark.skipif(
    importlib.util.find_spec("exudyn") is None, reason="exudyn is not installed"
)
E, NU, RHO = 69e9, 0.33, 2700.0
AREA, SECOND = 1e-4, 0.01**4 / 12.0
CANTILEVER = f"""
[material.plain]
density = {RHO}
youngs_modulus = {E}
poissons_ratio = {NU}
expansion = 0
conductivity = 167
heat_capacity = 900
[section.bar]
kind = "rectangle"
height = "10 mm"
width = "10 mm"
[body.boom]
kind = "beam"
start = [0, 0, 0]
end = ["1 m", 0, 0]
elements = 8
normal = [0, 1, 0]
section = "bar"
material = "plain"
[probe.tip]
body = "boom"
at = "end"
"""
CLAMP = '[joint.root]\nkind = "clamp"\na = { body = "boom", at = "start" }\n'
GRAVITY = '[gravity]\nacceleration = [0, "-9.81 m/s^2", 0]\n'
PENDULUM = """
[body.bob]
kind = "rigid"
position = ["0.5 m", 0, 0]
mass = "2 kg"
inertia = [0.01, 0.05, 0.05]
axes = [[0, 1, 0], [0, 0, 1], [1, 0, 0]]
[joint.pivot]
kind = "revolute"
a = { body = "bob", position = [0, 0, 0] }
b = { body = "ground", position = [0, 0, 0] }
axis = [0, 0, 1]
[probe.bob]
body = "bob"
"""


def force(amount, direction="[0, -1, 0]", kind="force"):
    return (
        f'[load.{kind}]\nkind = "{kind}"\nat = {{ body = "boom", at = "end" }}\n'
        f'direction = {direction}\namplitude = "{amount}"\n'
    )


def scene(*parts, kind="statics", end="1 s", window="1 s"):
    head = f'[time]\nend = "{end}"\nwindow = "{window}"\n[analysis]\nkind = "{kind}"\ncount = 4\n'
    return casefile.from_text("\n".join([head, *parts]), Path("."))


def own_course(case, probe):
    """Times and displacements of a probe in our own run."""
    model = build(case)
    state = model.initial()
    places = [model.probes(state)[probe]["position"]]
    for window in windows(model, state):
        places.append(model.probes(window.state)[probe]["position"])
    return model.window * np.arange(len(places)), np.array(places) - places[0]


# ------------------------------------------------------------------------------------ rest


@needs_exudyn
def test_a_rod_that_bends_far_is_the_elastica():
    found = opinion(scene(CANTILEVER, CLAMP, force("172.5 N")), "static", Options(128))
    np.testing.assert_allclose(found.displacements["tip"], [0.74557 - 1, -0.6033, 0], atol=5e-5)


@needs_exudyn
def test_moment_weight_and_mass():
    turned = scene(CANTILEVER, CLAMP, force("1 N m", "[0, 0, 1]", "moment"))
    bend = E * SECOND
    expected = (1.0 - np.cos(1.0 / bend)) * bend
    assert opinion(turned, "static").displacements["tip"][1] == pytest.approx(expected, rel=1e-4)
    heavy = opinion(scene(CANTILEVER, CLAMP, GRAVITY), "static")
    sag = RHO * AREA * 9.81 / (8.0 * bend)
    assert heavy.displacements["tip"][1] == pytest.approx(-sag, rel=1e-3)
    assert heavy.mass == pytest.approx(RHO * AREA)


@needs_exudyn
def test_frequencies_of_a_cantilever():
    """Of Euler and Bernoulli; shear and rotatory inertia lower the second by 0.2 %."""
    found = opinion(scene(CANTILEVER, CLAMP, kind="modes"), "frequencies", Options(64)).frequencies
    wave = np.sqrt(E * SECOND / (RHO * AREA)) / (2.0 * np.pi)
    np.testing.assert_allclose(found[:2], 1.87510407**2 * wave, rtol=1e-3)
    np.testing.assert_allclose(found[2:4], 4.69409113**2 * wave, rtol=3e-3)


# ---------------------------------------------------------------------------------- motion


@needs_exudyn
def test_a_rigid_pendulum_swings_as_its_equation_says():
    case = scene(PENDULUM, GRAVITY, kind="dynamics", end="1 s")
    found = opinion(case, "transient", Options(steps=2000))
    # of the axes that were given, z of space is the second
    stiff = 2.0 * 9.81 * 0.5 / (0.05 + 2.0 * 0.5**2)
    exact = solve_ivp(
        lambda t, y: [y[1], -stiff * np.cos(y[0])], (0.0, 1.0), [0.0, 0.0],
        t_eval=found.times, rtol=1e-10, atol=1e-12,
    ).y[0]  # fmt: skip
    expected = 0.5 * np.column_stack([np.cos(exact) - 1.0, np.sin(exact), 0.0 * exact])
    np.testing.assert_allclose(found.courses["bob"], expected, atol=1e-4)


@needs_exudyn
def test_a_cantilever_swings_as_our_own():
    """Under a force that rises within 20 ms; second order in 1 ms, and both converged in space."""
    rise = (
        '[load.push]\nkind = "force"\nat = { body = "boom", at = "end" }\ndirection = [0, -1, 0]\n'
        'amplitude = { ramp = { start = "0 s", end = "20 ms", from = "0 N", to = "5 N" } }\n'
    )
    case = scene(CANTILEVER, CLAMP, rise, kind="dynamics", end="0.1 s", window="5 ms")
    times, own = own_course(case, "tip")
    found = opinion(case, "transient", Options(32, 1000))
    other = np.column_stack([
        np.interp(times, found.times, column) for column in found.courses["tip"].T
    ])  # fmt: skip
    assert np.abs(own - other).max() < 5e-3 * np.abs(own).max()


@needs_exudyn
def test_a_particle_on_the_end_of_a_beam():
    ball = (
        '[body.ball]\nkind = "particle"\nposition = ["1 m", 0, 0]\nmass = "0.1 kg"\n'
        '[joint.hold]\nkind = "spherical"\na = { body = "ball" }\n'
        'b = { body = "boom", at = "end" }\n'
    )
    found = opinion(scene(CANTILEVER, CLAMP, ball, GRAVITY), "static")
    sag = 0.981 / (3.0 * E * SECOND) + RHO * AREA * 9.81 / (8.0 * E * SECOND)
    assert found.displacements["tip"][1] == pytest.approx(-sag, rel=1e-3)


# -------------------------------------------------------------------------------- refusals

REFUSED = {
    "thermal: it knows no heat": '[thermal]\ninitial = "20 degC"\nsolver = "line"\n',
    "damping: Rayleigh's": '[damping]\nmass = "1 1/s"\n',
    "joint 'string': a spring": (
        '[joint.string]\nkind = "spring"\na = { body = "boom", at = "end" }\n'
        'b = { body = "ground", position = [2, 0, 0] }\nstiffness = "1 N/m"\n'
    ),
}


@needs_exudyn
@pytest.mark.parametrize("sentence", REFUSED)
def test_what_it_cannot_say_is_refused_by_name(sentence):
    with pytest.raises(BadCase, match=sentence):
        opinion(scene(CANTILEVER, CLAMP, REFUSED[sentence]), "static")


@needs_exudyn
def test_a_stage_that_it_has_not_is_bad_input():
    with pytest.raises(BadCase, match="no stage 'thermal_load'"):
        opinion(scene(CANTILEVER, CLAMP), "thermal_load")
