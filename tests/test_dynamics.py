"""Substeps: windows, ladder of step sizes, refusals, reuse of factors, reversal, reasons."""

from contextlib import nullcontext
from functools import cache
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import pytest

from coupling.verify.models import clamp, elastic, model, sections, straight
from mechanics.description import (
    Clamp,
    ClearanceRevolute,
    Description,
    Distance,
    Force,
    Guide,
    Particle,
    Prismatic,
    Revolute,
    Site,
    Spherical,
)
from mechanics.dynamics import Control, Window, advance, initial_state
from mechanics.kernels import FACTOR, kernel
from mechanics.march import CALM, pack
from mechanics.redundancy import repetitions
from mechanics.schemes import Scheme
from mechanics.solver import Mechanics
from meshes.sections import rectangle

X, Y, Z = np.eye(3)
GRAVITY = (0.0, -9.81, 0.0)
ALUMINIUM = elastic(70e9, 0.3, 2700.0, 2e-5)
SQUARE = rectangle(0.01, 0.01)


def fixed(h, alpha=-0.1, newton=1e-13):
    return Control(np.inf, h, h, Scheme(alpha=alpha, newton_tolerance=newton))


def swinging_rope():
    """A cable of two elements hung at one end, a ball at the other; stiff and slow at once."""
    rope = straight(1.0, 2, SQUARE, elastic(1e8, 0.0, 1000.0), "cable", X, Y)
    ball = Particle("ball", X, 0.5)
    joints = [
        Spherical("nail", Site("beam", 0), Site(None)),
        Spherical("knot", Site("beam", 2), Site("ball")),
        Guide("plane", Site("ball"), Z[None]),
    ]
    return model([rope, ball], joints, gravity=GRAVITY)


@cache
def rope():
    return swinging_rope()


class Seen(NamedTuple):
    """An accepted step."""

    t: float
    q: np.ndarray
    v: np.ndarray
    approach: np.ndarray
    ledger: np.ndarray


def go(made, control, end, windows=1, observe=None, state=None):
    """State after ``end`` seconds in equal windows, from the start or from ``state``."""
    if state is None:
        state, why = initial_state(made.system, control, made.coef)
        assert why == ""
    full = observe is not None
    for k in range(windows):
        t = end * k / windows
        window = Window(t, end * (k + 1) / windows - t, made.coef, made.coef)
        state, _, why = advance(made.system, control, state, window, observe, full=full)
        assert why == ""
    return state


def path(made, control, end, windows=1):
    """All accepted steps, the start included."""
    state = initial_state(made.system, control, made.coef)[0]
    m = state.motion
    steps = [Seen(m.t, m.q, m.v, m.approach, state.ledger)]
    go(made, control, end, windows, into(steps, made.system.n))
    return steps


def into(steps, n):
    """Observer that keeps the steps."""

    def observe(rows):
        parts = rows.t, rows.y[:, :n], rows.v[:, :n], rows.approach, rows.ledger
        steps.extend(Seen(*step) for step in zip(*parts, strict=True))

    return observe


def times(steps):
    return np.array([s.t for s in steps])


def same(a, b):
    """Bit for bit the same state."""
    flat = [(x, y) for s, o in zip(a, b, strict=True) for x, y in _parts(s, o)]
    return all(np.array_equal(x, y) for x, y in flat)


def _parts(a, b):
    return list(zip(a, b, strict=True)) if isinstance(a, tuple) else [(a, b)]


# ---------------------------------------------------------------------------------- windows


def test_windows_end_exactly():
    made, ends, t = rope(), [0.1 / 3, 0.05, 0.0777, 0.1], 0.0
    control = Control(1e-5, 0.009, 1e-9)
    state, _ = initial_state(made.system, control, made.coef)
    for end in ends:
        window = Window(t, end - t, made.coef, made.coef)
        state, _, why = advance(made.system, control, state, window)
        assert why == "" and state.motion.t == window.t0 + window.h
        t = state.motion.t


def test_no_step_of_rounding_size_is_taken():
    """Fifty windows of odd lengths: each is cut into equal steps, and time is exact at its end."""
    made = model(Particle("ball", np.zeros(3), 1.0, X))
    control = fixed(1e-3 / 7.0)
    state, _ = initial_state(made.system, control, made.coef)
    ends = np.cumsum(np.random.default_rng(0).uniform(5e-4, 2e-3, 50))
    for begin, end in pairwise([0.0, *ends]):
        seen = []
        window = Window(begin, end - begin, made.coef, made.coef)
        watch = into(seen, made.system.n)
        state, _, _ = advance(made.system, control, state, window, watch, full=True)
        assert state.motion.t == window.t0 + window.h
        sizes = np.diff([begin, *times(seen)])
        assert len(sizes) == np.ceil(window.h / control.largest_step)
        np.testing.assert_allclose(sizes, sizes.mean(), rtol=1e-9)


def test_one_window_or_many_with_the_same_steps_give_the_same_motion():
    one, many = (go(rope(), fixed(1e-3), 0.4, windows).motion for windows in (1, 20))
    np.testing.assert_allclose(many.q, one.q, rtol=0, atol=1e-10)
    np.testing.assert_allclose(many.v, one.v, rtol=0, atol=1e-10 / 1e-3)  # v goes with q/h


def test_one_window_or_many_under_step_control_differ_by_the_error_of_the_steps():
    control = Control(1e-6, 0.02, 1e-9)
    one, many = (go(rope(), control, 0.3, windows) for windows in (1, 25))
    exact = go(rope(), Control(2e-8, 0.02, 1e-9), 0.3).motion.q
    for state in (one, many):
        error = np.abs(state.motion.q - exact).max()
        assert 1e-7 < error < 1e-6 * state.counts[0]  # at most the tolerance in each step


def test_the_same_run_gives_the_same_bits():
    control = Control(1e-5, 0.02, 1e-9)
    runs = [go(swinging_rope(), control, 0.3, 3) for _ in range(2)]
    assert same(*runs)


def test_steps_are_seen_in_order_and_the_last_is_the_end_of_the_window():
    control, seen = Control(1e-5, 0.02, 1e-9), []
    end = go(rope(), control, 0.2, 2, into(seen, rope().system.n))
    assert np.all(np.diff(times(seen)) > 0) and len(seen) == end.counts[0]
    assert np.array_equal(seen[-1].q, end.motion.q) and np.array_equal(seen[-1].v, end.motion.v)
    assert np.array_equal(seen[-1].ledger, end.ledger) and seen[-1].t == end.motion.t


def test_a_long_window_is_seen_in_batches_and_goes_on_as_if_it_were_not():
    """More steps than one batch holds; the Jacobian is made anew between batches."""
    seen, batches = [], []
    watch = into(seen, rope().system.n)
    end = go(rope(), fixed(2e-4), 0.3, observe=lambda rows: batches.append(1) or watch(rows))
    assert len(batches) == 3 and len(seen) == 1500 == end.counts[0]
    np.testing.assert_allclose(np.diff(times(seen)), 2e-4, rtol=1e-9)


def test_advancing_leaves_the_state_as_it_was():
    made, control = rope(), Control(1e-5, 0.02, 1e-9)
    state, _ = initial_state(made.system, control, made.coef)
    kept = [np.copy(x) for part in state for x in (part if isinstance(part, tuple) else [part])]
    go(made, control, 0.1, state=state)
    now = [x for part in state for x in (part if isinstance(part, tuple) else [part])]
    assert all(np.array_equal(a, b) for a, b in zip(kept, now, strict=True))


# ------------------------------------------------------------------------------- start of a run


def test_first_accelerations_obey_the_equations_of_motion_and_the_constraints():
    """A ball on a rod, moving: centripetal acceleration v^2/r, and gravity along the arc."""
    ball = Particle("ball", np.array([2.0, 0.0, 0.0]), 3.0, np.array([0.0, 4.0, 0.0]))
    made = model(ball, [Distance("rod", Site("ball"), Site(None))], gravity=GRAVITY)
    state, why = initial_state(made.system, Control(), made.coef)
    assert why == ""
    np.testing.assert_allclose(state.motion.a, [-8.0, -9.81, 0.0], rtol=1e-6, atol=1e-6)
    np.testing.assert_allclose(state.motion.lam, [24.0], rtol=1e-6)  # +lam pulls inwards


def test_velocities_of_the_reference_give_the_first_kinetic_energy():
    ball = Particle("ball", X, 3.0, np.array([0.0, 4.0, 0.0]))
    state, _ = initial_state(*model(ball)[:1], Control(), model(ball).coef)
    assert state.ledger[0] == pytest.approx(24.0, rel=1e-14)


# ------------------------------------------------------------------------- ladder of step sizes

JUMP = 0.5


def pushed():
    """A ball on a soft rope that is pushed suddenly at ``JUMP`` seconds."""
    rope = straight(1.0, 1, SQUARE, elastic(1e6, 0.0, 100.0), "cable", X, Y)
    ball = Particle("ball", X, 2.0)
    joints = [
        Guide("nail", Site("beam", 0), np.eye(3)),
        Spherical("knot", Site("beam", 1), Site("ball")),
        Guide("line", Site("ball"), np.array([Y, Z])),
    ]
    kick = Force("kick", Site("ball"), X, lambda t: 20.0 * float(t > JUMP))
    return model([rope, ball], joints, [kick])


LARGEST = 0.05


@cache
def pushed_path():
    return path(pushed(), Control(1e-4, LARGEST, 1e-9), 1.0)


def test_steps_are_refused_where_the_force_jumps_and_nowhere_before():
    states = pushed_path()
    before = [s.t for s in states if s.t <= JUMP]
    after = [s.t for s in states if s.t > JUMP]
    assert after[0] - before[-1] < LARGEST / 8
    assert go(pushed(), Control(1e-4, LARGEST, 1e-9), before[-1]).counts[1] == 0
    assert go(pushed(), Control(1e-4, LARGEST, 1e-9), 1.0).counts[1] > 2


def test_step_sizes_are_on_the_ladder_of_halvings():
    t = times(pushed_path())
    for start, size in zip(t[:-1], np.diff(t), strict=True):
        rungs = LARGEST / 2.0 ** np.arange(20)
        remaining = 1.0 - start
        allowed = remaining / np.maximum(1, np.ceil(remaining / rungs - 1e-9))
        assert np.abs(size / allowed - 1.0).min() < 1e-9


def test_steps_grow_by_doubling_and_only_after_a_while():
    sizes = np.diff(times(pushed_path()))
    ratios = sizes[1:] / sizes[:-1]
    grown = np.flatnonzero(ratios > 1.2)
    assert len(grown) >= 2, "steps grow again after the jump"
    assert ratios.max() < 2.1
    assert np.diff(grown).min() >= CALM


def test_steps_are_doubled_only_where_the_longer_one_will_do():
    """A swinging rope asks for other steps all the time; few of them are refused."""
    accepted, refused, *_ = go(rope(), Control(1e-5, 0.02, 1e-9), 0.5).counts
    assert accepted > 300 and refused < 0.06 * accepted


def test_the_error_of_each_accepted_step_is_within_the_tolerance():
    """(beta - 1/6) h^2 |da| (Zienkiewicz & Xie 1991), accelerations by Newmark's update of v."""
    made, steps, scheme = pushed(), pushed_path(), Scheme()
    a, errors = initial_state(made.system, Control(), made.coef)[0].motion.a, []
    for before, now in pairwise(steps):
        h = now.t - before.t
        new = ((now.v - before.v) / h - (1.0 - scheme.gamma) * a) / scheme.gamma
        errors.append((scheme.beta - 1 / 6) * h**2 * np.max(np.abs(new - a) / made.system.scale))
        a = new
    assert 1e-5 < max(errors) <= 1.000001e-4


# ------------------------------------------------------------------------------ reuse of factors


def factorisations(made, control, end, windows=1):
    return go(made, control, end, windows).counts[3]


def test_a_slow_motion_needs_one_factorisation_in_a_window():
    assert factorisations(rope(), fixed(1e-4), 50e-4) == 1


def test_factors_are_made_anew_when_corrections_become_many():
    """A rope that swings far: many steps, few factorisations, and few corrections in each."""
    accepted, _, corrections, made_anew = go(rope(), fixed(1e-3), 0.5).counts
    assert 2 < made_anew < accepted / 3
    assert corrections < 5 * accepted


def test_factors_are_made_anew_when_contacts_change():
    """A ball that bounces once between walls: one factorisation for flight, one for the impact."""
    made = flyer()
    control = Control(1e-6, 1e-4, 1e-12, Scheme(newton_tolerance=1e-13))
    assert factorisations(made, control, 0.019) == 1
    assert factorisations(made, control, 0.0202) >= 2


# ----------------------------------------------------------------------- reversal and energy


def reversed_motion(state):
    """The same place, run backwards."""
    m = state.motion
    return state._replace(motion=m._replace(t=0.0, v=-m.v))


def test_without_numerical_damping_the_motion_can_be_run_backwards():
    made, control = rope(), fixed(2e-3, alpha=0.0, newton=1e-15)
    start, _ = initial_state(made.system, control, made.coef)
    there = go(made, control, 0.1)
    assert np.abs(there.motion.q - start.motion.q).max() > 0.02
    back = go(made, control, 0.1, state=reversed_motion(there))
    np.testing.assert_allclose(back.motion.q, start.motion.q, rtol=0, atol=1e-9)


def test_numerical_damping_cannot_be_run_backwards():
    """The test above would notice."""
    made, control = rope(), fixed(2e-3, alpha=-0.2)
    start, _ = initial_state(made.system, control, made.coef)
    back = go(made, control, 0.1, state=reversed_motion(go(made, control, 0.1)))
    assert np.abs(back.motion.q - start.motion.q).max() > 1e-7


def energy(state, made):
    """Kinetic, strain and potential energy [J]."""
    y = made.system.unknowns(state.q)
    return state.ledger[0] + state.ledger[1] - state.q @ made.system.external(y, state.t, made.coef)


def test_energy_error_falls_with_the_square_of_the_step():
    made, errors = rope(), []
    for h in (2e-3, 1e-3, 5e-4):
        energies = np.array([energy(s, made) for s in path(made, fixed(h, alpha=0.0), 0.1)])
        errors.append(np.abs(energies - energies[0]).max())
    assert np.log2(errors[-2] / errors[-1]) == pytest.approx(2.0, abs=0.3)


def test_constraints_hold_after_every_step():
    made = rope()
    for state in path(made, Control(1e-5, 0.02, 1e-9), 0.3):
        values = made.system.constraints(made.system.unknowns(state.q), state.t, made.coef)
        assert np.abs(values).max() < 1e-10


# -------------------------------------------------------------------------------- impact onset


CAREFUL = Control(1e-6, 7e-3, 1e-12)


def flyer(clearance=1e-3, speed=0.05, loads=()):
    """A ball that flies freely in the bore of a fixed bearing, along x."""
    ball = Particle("ball", np.zeros(3), 2.0, np.array([speed, 0.0, 0.0]))
    pin = ClearanceRevolute(
        "pin", Site("ball"), Site(None), Z, 0.02, clearance, ALUMINIUM, ALUMINIUM, 298.15
    )
    made = model(ball, [pin], loads)
    return made._replace(coef=made.system.coefficients(sections(made.system)))


def test_an_impact_begins_where_the_clearance_ends():
    made = flyer()
    states = path(made, CAREFUL, 0.025, windows=2)
    begun = next(s for s in states if s.approach[0] != 0.0)
    assert begun.t == pytest.approx(1e-3 / 0.05, rel=1e-5)
    assert begun.approach[0] == pytest.approx(0.05, rel=1e-9)
    assert begun.q[0] == pytest.approx(1e-3, rel=1e-5)


def test_the_approach_speed_of_a_running_impact_survives_the_window():
    made, control = flyer(), CAREFUL
    whole = path(made, control, 0.025)
    inside = [s for s in whole if s.approach[0] > 0.0]
    assert len(inside) > 20
    middle = inside[len(inside) // 2].t
    cut = go(made, control, middle)
    assert cut.motion.approach[0] == pytest.approx(inside[0].approach[0], rel=1e-12)
    window = Window(middle, 0.025 - middle, made.coef, made.coef)
    end, _, why = advance(made.system, control, cut, window)
    assert why == ""
    assert end.motion.v[0] < 0.0
    assert end.motion.v[0] == pytest.approx(whole[-1].v[0], rel=2e-3)


def test_a_contact_that_is_pushed_anew_counts_the_faster_approach():
    """A ball creeps onto the wall and is struck before it leaves."""
    blow = Force("blow", Site("ball"), X, lambda t: 2e5 * float(0.02005 < t < 0.02015))
    gentle = flyer()
    struck = flyer(loads=[blow])
    slow = [s.approach[0] for s in path(gentle, CAREFUL, 0.0202)]
    fast = [s.approach[0] for s in path(struck, CAREFUL, 0.0202)]
    assert max(slow) == pytest.approx(0.05, rel=1e-9)
    assert fast[-1] > 1.0
    touching = np.flatnonzero(np.array(fast) > 0.0)
    assert np.all(np.diff(np.array(fast)[touching]) >= 0.0)


# --------------------------------------------------------------------------- what cannot be done


def test_a_step_that_would_be_too_small_gives_a_reason_with_its_place_and_leaves_the_state():
    made, control = pushed(), Control(1e-12, 0.01, 0.01)
    state, _ = initial_state(made.system, control, made.coef)
    window = Window(0.0, 1.0, made.coef, made.coef)
    same_state, lost, why = advance(made.system, control, state, window)
    assert same_state is state and lost.shape == (0, 2)
    assert why.startswith("the local error stays above the tolerance at ")
    assert "ball position x" in why or "beam node 1" in why


def test_newton_without_convergence_gives_a_reason_with_its_place():
    made = rope()
    control = Control(np.inf, 0.5, 0.5, Scheme(iterations=1))
    state, _ = initial_state(made.system, control, made.coef)
    window = Window(0.0, 1.0, made.coef, made.coef)
    same_state, _, why = advance(made.system, control, state, window)
    assert same_state is state
    assert why.startswith("Newton did not converge at ")
    assert any(name in why for name in ("beam node ", "ball position"))


@kernel(FACTOR)
def never(ints, data, work):
    return 1


def test_a_singular_matrix_gives_a_reason():
    made = swinging_rope()
    state, _ = initial_state(made.system, fixed(1e-3), made.coef)
    solver = np.array([never, *made.system.program.solver[1:]])
    made.system.packed = pack(made.system.program._replace(solver=solver))
    _, _, why = advance(made.system, fixed(1e-3), state, Window(0.0, 1.0, made.coef, made.coef))
    assert why == "the system matrix is singular, at t = 0 s"


def test_forces_that_are_not_finite_give_a_reason():
    push = Force("push", Site("ball"), X, lambda t: np.inf if t > 0.05 else 0.0)
    made = model(Particle("ball", X, 1.0), [], [push])
    control = Control(1e-5, 0.01, 1e-3)
    state, _ = initial_state(made.system, control, made.coef)
    with np.errstate(invalid="ignore"):
        new, _, why = advance(made.system, control, state, Window(0.0, 0.1, made.coef, made.coef))
    assert new is state and "ball position x" in why


OBLIQUE = np.array([0.48, 0.6, 0.64])


@pytest.mark.parametrize("elements", [2, 30])
@pytest.mark.parametrize(
    "second",
    [
        Clamp("second", Site("beam", 0), Site(None)),
        Spherical("second", Site("beam", 0), Site(None)),
        Revolute("second", Site("beam", 0), Site(None), np.array([1.0, 1.0, 0.3])),
    ],
)
def test_joints_that_repeat_others_are_refused_by_name(second, elements):
    beam = straight(1.0, elements, SQUARE, ALUMINIUM, "beam3243", OBLIQUE, (0.3, -0.2, 1.0))
    made = model(beam, [clamp(), second])
    found = repetitions(made.system.terms, made.system.layout.q0, made.system.scale)
    assert [f.joint for f in found] == ["second"]
    state, why = initial_state(made.system, Control(), made.coef)
    assert state is None and "constraints" in why


def test_joints_that_repeat_none_are_not_refused():
    beam = straight(1.0, 2, SQUARE, ALUMINIUM, "beam3243", OBLIQUE, (0.3, -0.2, 1.0))
    far = Site(None, position=OBLIQUE)
    made = model(beam, [clamp(), Spherical("far", Site("beam", 2), far)])
    assert repetitions(made.system.terms, made.system.layout.q0, made.system.scale) == []
    assert initial_state(made.system, Control(), made.coef)[1] == ""


def description(*joints):
    return Description([straight(1.0, 2, SQUARE, ALUMINIUM)], joints)


def test_a_solver_is_not_built_from_joints_that_cannot_be():
    driven = Revolute("turn", Site("beam", 0), Site(None), Z, lambda t: 0.2 + t)
    with pytest.raises(ValueError, match=r"joint 'turn': .* must be zero at t = 0"):
        Mechanics(description(driven), Control())
    twice = Spherical("twice", Site("beam", 0), Site(None))
    with pytest.raises(ValueError, match=r"joint 'twice': .* repeat 'clamp'"):
        Mechanics(description(clamp(), twice), Control())
    Mechanics(description(clamp()), Control())


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
def test_a_drive_jumps_by_parts_of_the_size_of_the_bodies(size):
    """In units of a thousandth or of a thousand it is the same."""
    for part, refused in ((1e-8, True), (1e-10, False)):
        pushed = Prismatic("push", Site("beam", 0), Site(None), X, lambda t, x=part * size: x + t)
        made = Description([straight(size, 2, SQUARE, ALUMINIUM)], [pushed])
        with pytest.raises(ValueError, match="must be zero") if refused else nullcontext():
            Mechanics(made, Control())


# ------------------------------------------------------------------------------- the solver


def test_the_solver_takes_temperatures_at_both_ends_of_the_window():
    """A free bar that warms evenly: at the end it is as long as its temperature says."""
    solver = Mechanics(description(), Control())
    cold = np.tile([298.15, 0.0, 0.0], (3, 1))
    warm = cold + np.array([100.0, 0.0, 0.0])
    state, heat, why = solver.advance(solver.initial(cold), 0.2, cold, warm)
    assert why == "" and not heat.any() and heat.shape == (3,)
    state, _, _ = solver.advance(state, 0.2, warm, warm)
    r = solver.system.layout.node_dofs["beam"]
    length = np.linalg.norm(state.motion.q[r[-1] : r[-1] + 3] - state.motion.q[r[0] : r[0] + 3])
    assert length - 1.0 == pytest.approx(2e-5 * 100.0, rel=0.02)
