"""Heat and motion in one Newton iteration: against closed forms and against each side alone."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from coupled_pairs import pair as small_pair

from coupling.casefile import from_text
from coupling.manager import corrected, initial, isothermal
from coupling.model import build
from coupling.monolithic import Monolithic
from coupling.verify.coupled import RUBBED, RUBBING
from coupling.verify.coupled import held as held_bar
from coupling.verify.thermoelastic_heat import BY_FORCE, PRESSED
from mechanics.schemes import Scheme

SWING = """
[time]
end = "0.4 s"
window = "0.1 s"
[integrator]
tolerance = 1e-9
largest_step = "1 ms"
[material.soft]
density = 2700
youngs_modulus = "69 GPa"
poissons_ratio = 0.0
expansion = "2e-4 1/K"
conductivity = 167
heat_capacity = 896
[section.s]
kind = "rectangle"
height = "10 mm"
width = "10 mm"
[body.bar]
kind = "beam"
start = [0, 0, 0]
end = [0.5, 0, 0]
elements = 2
section = "s"
material = "soft"
reference_temperature = "300 K"
damping = "5 ms"
[joint.hinge]
kind = "revolute"
a = { body = "bar", at = "start" }
axis = [0, 0, 1]
[gravity]
acceleration = [0, "-9.81 m/s^2", 0]
[thermal]
solver = "lumped"
initial = "300 K"
tolerance = 1e-8
[thermal.source.heater]
at = { body = "bar" }
power = "2 kW"
"""


def defect(pair, start, end):
    """Stored heat that nobody brought, over all that was exchanged, where boundaries are closed."""
    solver = pair.heat_solver
    stored = solver.energy(end.T) - solver.energy(start.T)
    return (stored - end.heat) / abs(end.heat)


def test_friction_is_of_second_order():
    pair, exact = RUBBING.build(), RUBBING.exact(RUBBED)
    solver, errors = Monolithic(pair), []
    for count in (8, 16, 32):
        end = solver.run(solver.begin(initial(pair)), RUBBED / count, count)
        errors.append(float(np.abs(end.T - exact).max()))
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.05)
    assert np.log2(errors[1] / errors[2]) == pytest.approx(2.0, abs=0.05)


def test_heat_of_friction_is_stored_where_nothing_leaves():
    pair = replace(RUBBING, outwards=0.0).build()
    solver = Monolithic(pair)
    start = solver.begin(initial(pair))
    end = solver.run(start, 2.0, 10)
    assert end.released > 1.0 and end.heat == end.released
    assert abs(defect(pair, start, end)) < 1e-11


def test_work_of_friction_is_the_heat():
    """mu F v t."""
    pair = replace(RUBBING, slope=0.0).build()
    end = Monolithic(pair).run(Monolithic(pair).begin(initial(pair)), 0.1, 10)
    speed = 0.05 * 0.05
    work = RUBBING.friction * RUBBING.load * speed**2 / (speed + 1e-8)
    assert end.released == pytest.approx(work, rel=1e-5)


def test_heat_of_deformation_feeds_itself():
    """T - T0 - s (T^2 - T0^2)/2 = rise of a bar that expands freely, s = E alpha^2/(rho c)."""
    pair = held_bar()
    solver = Monolithic(pair)
    end = solver.run(solver.begin(initial(pair)), 0.25, 8)
    heat = 60.0 * 20.0 / (2.0 * np.pi) * (1.0 - np.cos(0.2 * np.pi))
    rise = heat / (2700.0 * 896.0 * 0.2 * 1e-4)
    strength = 69e9 * 4e-8 / (2700.0 * 896.0)  # [1/K]
    exact = np.roots([-0.5 * strength, 1.0, -(300.0 - 0.5 * strength * 300.0**2 + rise)]).min()
    assert end.T.mean() - 300.0 == pytest.approx(exact - 300.0, rel=1e-2)
    assert end.heat > 0.3 * heat


def test_motion_alone_is_that_of_the_mechanics():
    """A heated pendulum: gravity, a joint, expansion; heat receives nothing from it."""
    pair = build(from_text(SWING, Path())).pair
    start = initial(pair)
    state, ends = start, {}
    for k in range(40):
        state, why = corrected(pair, state, 0.01 * k, 0.01, None)
        assert why == ""
    solver = Monolithic(pair)
    for h in (4e-3, 2e-3):
        ends[h] = solver.run(solver.begin(start), h, round(0.4 / h))
    q = state.motion.motion.q
    coarse, fine = (np.abs(end.q - q).max() for end in ends.values())
    assert np.abs(q - start.motion.motion.q).max() > 0.3
    assert fine < 2e-4 and coarse / fine == pytest.approx(4.0, rel=0.2)
    np.testing.assert_allclose(ends[2e-3].T, state.T, rtol=1e-9)
    system, coef = solver.system, solver.system.coefficients(pair.transfer.read(state.T))
    held = system.constraints(system.unknowns(ends[2e-3].q), 0.4, coef)
    assert np.abs(held).max() < 1e-11


def test_without_heat_in_it_nothing_gets_warm():
    pair = build(from_text(SWING.replace('"2 kW"', '"0 W"'), Path())).pair
    start = initial(pair)
    end = Monolithic(pair).run(Monolithic(pair).begin(start), 5e-3, 8)
    alone, _ = isothermal(pair, start, 0.0, 0.04, None)
    np.testing.assert_allclose(end.T, 300.0, rtol=1e-14)
    np.testing.assert_allclose(end.q, alone.motion.motion.q, atol=1e-4)


# ------------------------------------------------------------------------------------- refusals


def test_what_it_cannot_do_is_said():
    with pytest.raises(ValueError, match="bdf2: expected hht or generalised-alpha"):
        Monolithic(RUBBING.build(), Scheme("bdf2"))
    with pytest.raises(ValueError, match="conductance of joints"):
        Monolithic(build(from_text(PRESSED + BY_FORCE, Path())).pair)
    sticky = PRESSED.replace(
        "contact = {", 'friction = { coefficient = 0.2, law = "stick" }\ncontact = {'
    )
    with pytest.raises(ValueError, match="friction with memory"):
        Monolithic(build(from_text(sticky, Path())).pair)


def test_all_reasons_are_said_at_once():
    pair = RUBBING.build()
    blind = pair._replace(heat_solver=small_pair().heat_solver)
    with pytest.raises(ValueError) as refusal:
        Monolithic(blind, Scheme("backward-euler", constraints="projected"))
    assert len(str(refusal.value).splitlines()) == 3


def test_a_step_that_does_not_converge_gives_the_reason():
    pair = RUBBING.build()
    solver = Monolithic(pair)
    start = solver.begin(initial(pair))
    new, why = solver.advance(start._replace(v=start.v * np.nan), 1.0)
    assert new is None and why.endswith("at t = 0 s")
