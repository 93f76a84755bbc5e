"""A long stroke of tube in tube: the matrix follows the contacts, drives, cost in elements."""

from time import perf_counter

import numpy as np
import pytest

from mechanics import telescope
from mechanics.description import (
    AxialDrive,
    Beam,
    Clamp,
    Description,
    Friction,
    NormalContact,
    Site,
    Telescope,
)
from mechanics.dynamics import Control
from mechanics.march import ELASTIC, PLACE
from mechanics.solver import Mechanics
from mechanics.system import Factors
from meshes.materials import constant_material
from meshes.sections import tube as ring

AMBIENT = 298.15
ALUMINIUM = constant_material("aluminium", 2700.0, 69e9, 0.33, 23.1e-6, 167.0, 896.0)
X = np.array([1.0, 0.0, 0.0])


def tube(name, start, end, elements, radius):
    points = np.zeros((elements + 1, 3))
    points[:, 0] = np.linspace(start, end, elements + 1)
    axes = np.tile(np.eye(3), (elements + 1, 1, 1))
    section = ring(radius, 2e-3)
    return Beam(name, points, axes, section, ALUMINIUM, AMBIENT, damping_time=2e-3)


def slide(elements=12, speed=2.0, gravity=9.81, joints=(), **options):
    """An arm in a clamped boom of 12 m, pushed along it with a soft start."""
    boom = tube("boom", 0.0, 12.0, elements, 0.05)
    arm = tube("arm", 0.4, 11.4, elements, 0.047)
    laws = {"contact": NormalContact("linear", 1e6), "friction": Friction(0.15, law="stick")}
    sleeve = Telescope("sleeve", "arm", "boom", 0.048, 1e-3, AMBIENT, **laws | options)
    joints = [Clamp("root", Site("boom", 0), Site(None)), *joints, sleeve]
    if speed:
        drive = AxialDrive(
            "screw", Site("arm", 0), Site("boom", 0), X, lambda t: speed * t * t / (0.2 + t)
        )
        joints.append(drive)
    gravity = np.array([0.0, -gravity, 0.0])
    return Description([boom, arm], joints, gravity=gravity)


def solver(description, **control):
    settings = {"tolerance": 1e-5, "largest_step": 2e-3} | control
    return Mechanics(description, Control(**settings))


def temperatures(mechanics):
    return np.tile([AMBIENT, 0.0, 0.0], (len(mechanics.x), 1))


def moved(mechanics, state, windows, h=0.1):
    T, found = temperatures(mechanics), []
    for _ in range(windows):
        state, _, why = mechanics.advance(state, h, T, T, found.append)
        assert not why, why
    return state, np.concatenate([rows.response for rows in found])


def shifted(system, way):
    """Coordinates with the arm pushed out."""
    q = system.layout.q0.copy()
    q[system.layout.node_dofs["arm"]] += way
    return q


@pytest.mark.parametrize("stations", [0, 2])
def test_every_foot_is_in_its_band(stations):
    """Wherever the arm is, and a quarter of an element farther."""
    system = solver(slide(stations=stations)).system
    seen = set()
    for way in np.linspace(0.0, 11.0, 111):
        term = system.following(shifted(system, way)).contacts[0]
        seen.add(term.band)
        for more in (-0.2, 0.0, 0.2):
            q = shifted(system, way + more)
            feet = telescope.kernels.feet(q, term.ints, term.floats)[:, 0]
            for station, row, foot in zip(term.stations, term.ints, feet, strict=True):
                length = station.other.lengths[-1]
                if -0.1 < foot < length + 0.1:
                    element, _ = station.other.weights(foot)
                    first = row[telescope.BAND]
                    assert first <= element < first + row[telescope.WIDE]
    assert len(seen) <= 2 * 11.0 / (telescope.GRAIN * 11.0 / 12.0) + 2  # of both tubes


def test_a_pattern_follows_from_the_state_alone():
    system = solver(slide()).system
    far, near = shifted(system, 7.3), system.layout.q0
    one = system.following(far)
    assert system.following(near) is system and one is not system
    assert one.following(far) is one and one.following(near) is system
    for way in (1.0, 2.0, 3.0, 4.0, 5.0, 6.0):  # until those of before are forgotten
        one.following(shifted(system, way))
    again = system.following(far)
    assert again is not one and np.array_equal(again.pattern.indices, one.pattern.indices)
    assert np.array_equal(again.solver.ints[4:], one.solver.ints[4:])  # but for addresses


def test_the_matrix_is_that_of_a_pattern_with_everything(monkeypatch):
    """Of tubes that bend and touch, after three metres."""
    rng = np.random.default_rng(0)
    found = []
    for few in (telescope.FEW, 100):
        monkeypatch.setattr(telescope, "FEW", few)
        system = solver(slide(stations=1)).system
        q = shifted(system, 3.1)
        q[system.layout.node_dofs["arm"] + 1] -= 2e-3
        q += 1e-4 * np.random.default_rng(1).standard_normal(q.size)
        system = system.following(q)
        coef = system.coefficients(np.tile([AMBIENT, 0.0, 0.0], (len(system.layout.x), 1)))
        y, v = system.unknowns(q), np.zeros(system.n + system.m)
        assert np.sum(system.respond(y, v, coef)[:, ELASTIC] > 0.0) > 10
        found.append(system.matrix(y, v, 0.0, coef, Factors(1.0, 1e-3, 1e-2)))
        found[-1] = system.pattern.matrix(found[-1])
    x = rng.standard_normal(found[0].shape[0])
    assert found[0].nnz < 0.5 * found[1].nnz
    assert found[0] @ x == pytest.approx(found[1] @ x, rel=1e-12)


def test_a_stroke_over_many_elements_resumes_bit_for_bit(monkeypatch):
    """Also where the pattern changed meanwhile; and the pattern does not matter to the result."""
    whole = solver(slide())
    state, rows = moved(whole, whole.initial(temperatures(whole)), 12)
    places = rows[:, 0, PLACE]
    assert places[-1] - places[0] > 1.5 and len(whole.system._followers) > 1
    other = solver(slide())
    half, _ = moved(other, other.initial(temperatures(other)), 7)
    fresh = solver(slide())
    resumed, _ = moved(fresh, half, 5)
    assert np.array_equal(resumed.motion.q, state.motion.q)
    assert np.array_equal(resumed.motion.v, state.motion.v)
    monkeypatch.setattr(telescope, "FEW", 100)
    full = solver(slide())
    same, _ = moved(full, full.initial(temperatures(full)), 12)
    assert same.motion.q == pytest.approx(state.motion.q, abs=1e-5)


def test_cost_of_a_long_telescope():
    """A factorisation costs little more than that of both beams apart, and grows with elements."""

    def seconds(elements, **joints):
        system = solver(slide(elements, **joints)).system
        coef = system.coefficients(np.tile([AMBIENT, 0.0, 0.0], (len(system.layout.x), 1)))
        y = system.unknowns(system.layout.q0)
        data = system.matrix(y, 0.0 * y, 0.0, coef, Factors(1.0, 1e-4, 1e-2))
        times = []
        for _ in range(15):
            start = perf_counter()
            system.factorise(data)
            times.append(perf_counter() - start)
        return min(times), system.solver.work_size

    (fast, small), (slow, large) = seconds(30), seconds(60)
    assert large < 2.3 * small and slow < 3.5 * fast
