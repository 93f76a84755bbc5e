"""Solid bodies in motion: momentum, energy, gravity, vibration, heating."""

import numpy as np
import pytest
from continuum_cases import ALUMINIUM, COLD, bar, point

from mechanics.description import Clamp, Continuum, Description, Site
from mechanics.dynamics import Control
from mechanics.ledger import TERMS
from mechanics.schemes import Scheme
from mechanics.solver import Mechanics
from meshes.materials import constant_material

SOFT = constant_material("soft", 1000.0, 1e7, 0.3, 1e-4, 0.2, 1500.0)


def control(h, alpha=0.0):
    return Control(np.inf, h, h, Scheme(alpha=alpha, newton_tolerance=1e-11))


def block(**options):
    mesh = bar((0.2, 0.1, 0.05), (3, 2, 1))
    return Continuum("body", mesh.points, mesh.cells["hexahedron20"], SOFT, COLD, **options)


def temperatures(solver, T=COLD):
    return np.tile([T, 0.0, 0.0], (len(solver.x), 1))


def test_a_free_spinning_block_keeps_momentum_and_energy():
    spin, velocity = np.array([5.0, -3.0, 20.0]), np.array([1.0, 2.0, -0.5])
    solver = Mechanics(Description([block(spin=spin, velocity=velocity)]), control(2e-4))
    T, system = temperatures(solver), solver.system
    state = solver.initial(T)

    def momenta(motion):
        p, x = (system.mass @ motion.v).reshape(-1, 3), motion.q.reshape(-1, 3)
        return np.concatenate([p.sum(axis=0), np.cross(x, p).sum(axis=0)])

    def energy(motion):
        stored = system.energies(motion.q, motion.v, system.coefficients(T))[0]
        return 0.5 * motion.v @ (system.mass @ motion.v) + stored

    before = momenta(state.motion), energy(state.motion)
    after, _, why = solver.advance(state, 0.02, T, T)
    assert why == ""
    # the scheme keeps linear momentum exactly, angular momentum and energy to its order
    change = momenta(after.motion) - before[0]
    assert np.abs(change[:3]).max() < 1e-10 * np.abs(before[0][:3]).max()
    assert np.abs(change[3:]).max() < 1e-4 * np.abs(before[0][3:]).max()
    assert energy(after.motion) == pytest.approx(before[1], rel=1e-4)


def test_free_fall():
    solver = Mechanics(Description([block()], gravity=np.array([0.0, 0.0, -9.81])), control(1e-3))
    T = temperatures(solver)
    after, _, why = solver.advance(solver.initial(T), 0.05, T, T)
    assert why == ""
    fall = (after.motion.q - solver.system.layout.q0).reshape(-1, 3)
    assert fall == pytest.approx(
        np.tile([0.0, 0.0, -0.5 * 9.81 * 0.05**2], (len(fall), 1)), abs=1e-9
    )


STORED, WORKS = ("kinetic", "strain"), ("work_loads", "work_drive", "work_thermal")
LOSSES = ("friction", "hysteresis", "damping", "numerical")


def heated(h):
    """A damped bar, clamped, heated evenly by 100 K within 20 ms, then left alone."""
    mesh = bar((0.2, 0.02, 0.02), (6, 2, 1))
    cells = mesh.cells["hexahedron20"]
    body = Continuum("body", mesh.points, cells, ALUMINIUM, COLD, damping_time=2e-5)
    places = [point(mesh, "x0", "body@0"), point(mesh, "x1", "body@1")]
    joints = [Clamp("wall", Site("body@0"), Site(None, position=np.zeros(3)))]
    scheme = Scheme(alpha=-0.05, newton_tolerance=1e-13)
    solver = Mechanics(Description([body, *places], joints), Control(np.inf, h, h, scheme))
    cold, hot = temperatures(solver), temperatures(solver, COLD + 100.0)
    states = [solver.initial(cold)]
    for start, end in ((cold, hot), (hot, hot)):
        state, _, why = solver.advance(states[-1], 0.02, start, end)
        assert why == ""
        states.append(state)
    return solver, states


def test_the_ledger_closes_while_a_clamped_bar_is_heated():
    """Stored = works - losses, to round-off; what the scheme loses is apart, and falls with h."""
    numerical = []
    for h in (2e-4, 5e-5):
        _, states = heated(h)
        rows = [dict(zip(TERMS, state.ledger, strict=True)) for state in states]
        largest = max(abs(value) for row in rows for value in row.values())
        for row in rows[1:]:
            gained = sum(row[k] - rows[0][k] for k in STORED)
            known = sum(row[k] for k in WORKS) - sum(row[k] for k in LOSSES)
            assert gained - known == pytest.approx(row["defect"], abs=1e-13 * largest)
            assert abs(row["defect"]) < 1e-7 * largest
        assert rows[1]["work_thermal"] > 0.0 and rows[1]["damping"] > 0.0
        numerical.append(abs(rows[1]["numerical"]))
    assert numerical[1] < 0.1 * numerical[0]


def test_a_heated_bar_comes_to_rest_at_its_free_length():
    solver, (*_, state) = heated(2e-4)
    tip = solver.system.layout.node_dofs["body@1"][0]
    stretch = 1.0 + 23.1e-6 * 100.0
    r, r_y, r_z = state.motion.q[tip : tip + 9].reshape(3, 3)
    assert r == pytest.approx([0.2 * stretch, 0.0, 0.0], abs=1e-7)
    assert [r_y[1], r_z[2]] == pytest.approx([stretch, stretch], abs=1e-7)
