"""Options of the mechanics: Rayleigh damping, mass that follows the temperature."""

from dataclasses import replace

import numpy as np
import pytest

from coupling.verify.models import clamp, elastic, straight
from mechanics.description import Description, Force, Guide, Particle, Site
from mechanics.dynamics import Control
from mechanics.ledger import TERMS
from mechanics.march import inertia
from mechanics.modes import modes
from mechanics.schemes import Scheme
from mechanics.solver import Mechanics
from mechanics.system import System
from meshes.materials import library_material
from meshes.sections import rectangle

X, Y, Z = np.eye(3)
PAPER = library_material("al6061-paper")


def description(material, **options):
    beam = straight(1.0, 4, rectangle(0.02, 0.02), material)
    return Description([beam], [clamp()], **options)


def row(state):
    return dict(zip(TERMS, state.ledger, strict=True))


@pytest.mark.parametrize(("alpha_m", "alpha_k"), [(3.0, 0.0), (0.0, 4e-5), (2.0, 2e-5)])
def test_rayleigh_damping_has_the_ratio_of_the_textbook(alpha_m, alpha_k):
    """zeta = alpha_m/(2 w) + alpha_k w/2 (Clough & Penzien 1993, eq. 12-38) of a free swing."""
    metal = elastic(70e9, 0.3, 2700.0)
    told = description(metal, rayleigh=(alpha_m, alpha_k))
    system = System(told)
    T = np.tile([298.15, 0.0, 0.0], (5, 1))
    flat = np.zeros(system.m)
    f = modes(system, system.layout.q0, flat, system.coefficients(T), 1).frequencies[0]
    push = Force("push", Site("beam", 4), Y, lambda t: np.sin(np.pi * t * f) ** 2 * (t < 1.0 / f))
    told = Description(told.bodies, told.joints, [push], rayleigh=told.rayleigh)
    h = 1.0 / (200.0 * f)
    control = Control(np.inf, h, h, Scheme(alpha=0.0))
    solver = Mechanics(told, control)
    state = solver.initial(T)
    energies = []
    for _ in range(20):
        state, _, why = solver.advance(state, 1.0 / f, T, T)
        assert why == ""
        energies.append(row(state)["kinetic"] + row(state)["strain"])
    w = 2.0 * np.pi * f
    expected = alpha_m / (2.0 * w) + alpha_k * w / 2.0
    decay = np.polyfit(np.arange(15), np.log(energies[5:]), 1)[0]
    assert -decay / (4.0 * np.pi) == pytest.approx(expected, rel=0.02)
    lost = row(state)
    assert lost["damping"] > 0.0 and abs(lost["defect"]) < 1e-5 * lost["damping"]


def test_mass_follows_the_density_law_where_that_is_asked_for():
    """A warm beam of Hua's aluminium is lighter, and the energy of what vanishes is booked."""
    law = PAPER.density_law
    for asked, factor in ((False, 1.0), (True, law(400.0) / law(300.0))):
        told = description(PAPER, heavy_when_cold=asked)
        solver = Mechanics(Description(told.bodies, (), heavy_when_cold=asked), Control())
        masses = [_mass(solver.system, T) for T in (300.0, 400.0)]
        assert masses[1] / masses[0] == pytest.approx(factor, rel=1e-12)


def _mass(system, T):
    """Mass [kg] of the program at a uniform temperature."""
    packed = system.packed_at(np.tile([T, 0.0, 0.0], (len(system.layout.x), 1)))
    shift = np.zeros(system.n)
    for nodes in system.layout.node_dofs.values():
        shift[nodes] = 1.0
    out = np.empty(system.n)
    inertia(packed, shift, out)
    return shift @ out


def test_energy_of_a_flying_beam_that_gets_lighter_goes_into_the_ledger():
    """Free flight at constant speed: kinetic energy changes with the mass, as work of heating."""
    beam = straight(1.0, 2, rectangle(0.02, 0.02), PAPER)
    told = Description([replace(beam, velocity=3.0 * X)], heavy_when_cold=True)
    solver = Mechanics(told, Control(1e-4, 1e-2, 1e-9))
    T = np.tile([298.15, 0.0, 0.0], (3, 1))
    state = solver.initial(T)
    before = row(state)["kinetic"]
    hot = T + np.array([50.0, 0.0, 0.0])
    state, _, why = solver.advance(state, 0.05, T, hot)
    assert why == ""
    state, _, why = solver.advance(state, 0.05, hot, hot)
    ratio = PAPER.density_factor(348.15) / PAPER.density_factor(298.15)
    now = row(state)
    assert why == "" and now["kinetic"] == pytest.approx(before * ratio, rel=1e-4)
    stored = now["kinetic"] + now["strain"] - before
    assert stored == pytest.approx(now["work_thermal"] - now["numerical"], abs=1e-9 * before)


def test_negative_factors_are_refused():
    with pytest.raises(ValueError, match="Rayleigh"):
        System(description(elastic(70e9), rayleigh=(-1.0, 0.0)))


def test_points_and_guides_have_no_such_damping():
    ball = Description(
        [Particle("ball", X, 1.0)], [Guide("line", Site("ball"), np.array([Y, Z]))],
        rayleigh=(1.0, 0.0),
    )  # fmt: skip
    assert [term.name for term in System(ball).terms] == ["linear joints"]
