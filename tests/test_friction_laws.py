"""Compiled friction laws against motions with closed forms and integrated equations."""

import numpy as np
import pytest
from numba import njit
from scipy.integrate import solve_ivp

from mechanics import contact_laws as laws
from mechanics.contact import FRICTION, friction_columns
from mechanics.contact_laws import friction
from mechanics.description import Friction

N = np.array([0.0, 0.0, 1.0])
HISTORY = slice(laws.HISTORY, laws.HISTORY + laws.HISTORIES)


def slot(law, kinetic, static=None, h=0.0, **more):
    c = np.zeros(laws.SLOT)
    described = Friction(kinetic, law=law, static_coefficient=static, **more)
    c[laws.FRICTION : laws.CORE] = friction_columns(described, 298.15)
    c[laws.STEP] = h
    return c


def rub(c, V, n=N, force=10.0):
    """Friction, history at the end of the step, whether it sticks."""
    dtype = np.result_type(np.asarray(V), np.asarray(n), force)
    T, new = np.zeros(3, dtype), np.zeros(laws.HISTORIES, dtype)
    stuck = friction(np.asarray(V, dtype), np.asarray(n, dtype), force, c, T, new)
    return T, new, stuck


@njit
def _step(c, n, force, m, k, load, anchor, belt, x, v, T, new):
    """Velocity at the end of a step, by bisection; the friction is that at the end."""
    V, h = np.zeros(3), c[laws.STEP]
    low, high = v - 100.0, v + 100.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        V[0] = middle - belt
        stuck = friction(V, n, force, c, T, new)
        spring = k * (anchor - x - 0.25 * h * (v + middle))
        if m * (middle - v) > h * (load + spring + T[0]):
            high = middle
        else:
            low = middle
    return middle, stuck


@njit
def _slide(c, n, force, m, k, load, pull, belt, v, out):
    """A mass on a spring whose end is pulled, and on a belt: rows x, v, T, stuck."""
    T, new, x, h = np.zeros(3), np.zeros(laws.HISTORIES), 0.0, c[laws.STEP]
    for i in range(len(out)):
        end, stuck = _step(c, n, force, m, k, load, pull * h * (i + 0.5), belt, x, v, T, new)
        x, v = x + 0.5 * h * (v + end), end
        c[laws.HISTORY : laws.HISTORY + laws.HISTORIES] = new
        out[i, 0], out[i, 1], out[i, 2], out[i, 3] = x, v, T[0], stuck


def slide(c, steps, force, m=1.0, k=0.0, load=0.0, pull=0.0, belt=0.0, v=0.0):
    out = np.zeros((steps, 4))
    _slide(c, N, force, m, k, load, pull, belt, v, out)
    return out.T


# ------------------------------------------------------------------------------- motions


def test_mass_on_a_belt_sticks_and_slips():
    """μ_s N/k = 0.04, μ_k N/k = 0.03: sticks 0.02/0.1 s, slips for (2 π - π/2)/ω."""
    h = 1e-4
    c = slot("stick", 0.3, 0.4, h)
    x, v, _, stuck = slide(c, 20000, 10.0, k=100.0, belt=0.1)
    changes = np.flatnonzero(np.diff(stuck)) * h
    lengths = np.diff(changes)[1:]
    first = int(stuck[int(changes[1] / h) + 1])  # what follows the second change
    assert lengths[1 - first :: 2] == pytest.approx(0.2, abs=4 * h)
    assert lengths[first::2] == pytest.approx(1.5 * np.pi / 10, abs=4 * h)
    assert x[10000:].min() == pytest.approx(0.015858, abs=2e-5)
    assert x[10000:].max() == pytest.approx(0.044142, abs=2e-5)
    assert np.abs(v[stuck == 1.0] - 0.1)[5:].max() < 0.01


@pytest.mark.parametrize("law", ["stick", "rising", "regularised"])
def test_sliding_block_stops(law):
    h, g = 1e-4, 9.81
    c = slot(law, 0.25, h=h, regularisation_speed=1e-6)
    x, v, T, stuck = slide(c, 20000, g, v=3.0)
    stop = (np.flatnonzero(v > 1e-3)[-1] + 1) * h
    assert stop == pytest.approx(1.223242, abs=1e-3)
    assert x[-1] == pytest.approx(1.834862, abs=2e-4)
    assert -np.sum(T * h * (v + np.append(3.0, v[:-1])) / 2) == pytest.approx(4.5, rel=1e-6)
    assert (stuck[-1] == 1.0) == (law != "regularised")


def test_block_on_an_incline():
    g, slope = 9.81, np.radians(20)
    normal, load = g * np.cos(slope), g * np.sin(slope)
    _, v, _, stuck = slide(slot("stick", 0.3, h=1e-3), 1000, normal, load=load)
    assert v[-1] - v[-501] == pytest.approx(0.5 * 0.589702, rel=1e-6)
    assert not stuck[10:].any()
    x, v, _, stuck = slide(slot("stick", 0.3, 0.4, 1e-3), 1000, normal, load=load * 0.8)
    assert stuck[-1] == 1.0 and abs(v[-1]) < 1e-9 and x[-1] < 1e-6


@pytest.mark.parametrize("law", ["stick", "rising"])
@pytest.mark.parametrize("damping", [0.0, 30.0])
def test_what_sticks_does_not_creep(law, damping):
    """Below half of the bound: it ends at load/limit of the presliding deflection and stays."""
    c = slot(law, 0.2, h=1e-4, presliding=1e-6, bristle_damping=damping)
    x, _, _, stuck = slide(c, 10000, 10.0, load=0.45 * 2.0)
    assert stuck.all()
    assert np.abs(x).max() < 1e-6
    assert np.abs(x[5000:] - 0.45e-6).max() < 1e-15


def test_without_bristles_it_creeps():
    """v = ε r/(1 - r) under the part r of the bound."""
    c = slot("regularised", 0.2, h=1e-3, regularisation_speed=1e-4)
    v = slide(c, 2000, 10.0, load=0.5 * 2.0)[1]
    assert v[-1] == pytest.approx(1e-4, rel=1e-6)


def lugre(h=0.0):
    """Canudas de Wit et al. (1995): σ0 = 1e5, F_C = 1, F_S = 1.5 for N = 1."""
    more = {"stribeck_speed": 1e-3, "viscous": 0.4}
    more |= {"presliding": 1.5e-5, "bristle_damping": np.sqrt(1e5)}
    return slot("lugre", 1.0, 1.5, h, **more)


def test_lugre_stick_slip():
    """A spring of 2 N/m pulls 1 kg at 0.1 m/s, which moves faster than 0.01 m/s for a while."""

    def motion(t, state):
        x, v, z = state
        rate = v - 1e5 * abs(v) * z / (1.0 + 0.5 * np.exp(-((v / 1e-3) ** 2)))
        return [v, 2.0 * (0.1 * t - x) - 1e5 * z - np.sqrt(1e5) * rate - 0.4 * v, rate]

    times = np.arange(1, 12001) * 1e-3
    run = solve_ivp(
        motion, (0, 12), np.zeros(3), method="LSODA", t_eval=times, rtol=1e-9, atol=1e-12
    )
    x, v, _, stuck = slide(lugre(1e-3), 12000, 1.0, k=2.0, pull=0.1)
    moving = times[v > 0.01]
    assert moving[[0, -1]] == pytest.approx([7.458, 10.2235], abs=2e-3)
    assert np.abs(x - run.y[0]).max() < 1e-3
    assert stuck[times < 7.0].all() and not stuck[(times > 7.46) & (times < 10.2)].any()


# ------------------------------------------------------------------------------- the laws


def test_regularised_and_stribeck():
    V = np.array([-3e-4, 4e-4, 0.0])
    T, new, stuck = rub(slot("regularised", 0.2, regularisation_speed=1e-4), V)
    assert np.allclose(T, -0.2 * 10 * V / 6e-4, rtol=1e-14)
    assert stuck == 0.0 and not new.any()
    more = {"regularisation_speed": 1e-4, "stribeck_speed": 1e-3, "viscous": 3.0}
    T = rub(slot("stribeck", 0.2, 0.5, **more), V)[0]
    mu = 0.2 + 0.3 * np.exp(-0.25)
    assert np.allclose(T, -10 * (mu / 6e-4 + 3.0) * V, rtol=1e-14)


def test_static_friction_rises_while_it_sticks():
    """Hua et al. 2026: halfway after 1.365 s, 90 % after 9.20 s, 99 % after 27.7 s."""
    for time, part in ((1.365, 0.5), (9.20, 0.9), (27.7, 0.99)):
        bound = 0.0623 + part * (0.0859 - 0.0623)
        c = slot("rising", 0.0623, 0.0859, h=1e-3)
        c[laws.HISTORY + 6] = time - 1e-3
        for load, stuck in ((bound - 1e-4, 1.0), (bound + 1e-4, 0.0)):
            c[laws.HISTORY] = load / c[laws.BRISTLE]
            T, new, holds = rub(c, np.zeros(3))
            assert holds == stuck
            assert new[6] == pytest.approx(time if holds else 0.0)
            assert T[0] == pytest.approx(-10 * (load if holds else 0.0623))


def test_time_of_sticking_is_counted():
    c = slot("stick", 0.2, 0.3, h=1e-3)
    for i in range(5):
        c[HISTORY] = rub(c, np.zeros(3))[1]
        assert c[laws.HISTORY + 6] == pytest.approx((i + 1) * 1e-3)
    c[HISTORY] = rub(c, np.array([0.1, 0.0, 0.0]))[1]
    assert c[laws.HISTORY + 6] == 0.0
    c[HISTORY] = rub(c, np.zeros(3), force=0.0)[1]
    assert not c[HISTORY].any()


def test_static_bound_holds_only_after_sticking():
    V = np.array([1e-4, 0.0, 0.0])
    for timer, expected in ((0.0, 0.2), (1.0, 0.26)):
        c = slot("stick", 0.2, 0.3, h=1e-3)
        c[laws.HISTORY : laws.HISTORY + 4] = (0.21e-7 / 0.3, 0.0, 0.0, 0.0)
        c[laws.HISTORY + 6] = timer
        V[0] = 2 * 0.05e-7 / 0.3 / 1e-3
        T, _, stuck = rub(c, V)
        assert T[0] == pytest.approx(-10 * expected, rel=1e-12)
        assert stuck == (timer > 0.0)


def test_friction_of_the_end_of_a_step_without_a_step():
    rng = np.random.default_rng(2)
    for law in ("stick", "rising", "lugre"):
        for speed in (1e-6, 1e-4, 3e-2):
            V = np.append(speed * rng.standard_normal(2), 0.0)
            c = slot(law, 0.2, 0.3, h=1e-4, viscous=2.0)
            T, new, stuck = rub(c, V)
            c[HISTORY], c[laws.STEP] = new, 0.0
            again, later, still = rub(c, V)
            assert stuck == still == (speed < 1e-3)
            assert np.allclose(again, T, rtol=1e-12)
            assert np.allclose(later, new, rtol=1e-12, atol=1e-29)


@pytest.mark.parametrize("damping", [0.0, 40.0])
@pytest.mark.parametrize("law", FRICTION)
def test_bristles_bear_no_more_than_the_coefficient(law, damping):
    """But for the LuGre law, whose damping is beside the spring."""
    rng = np.random.default_rng(3)
    c = slot(law, 0.2, 0.3, h=1e-5, bristle_damping=0.0 if law == "lugre" else damping)
    for speed in 10.0 ** rng.uniform(-6, 1, 200):
        V = np.append(speed * rng.standard_normal(2), 0.0)
        T, c[HISTORY], stuck = rub(c, V)
        assert np.linalg.norm(T) <= 3.0 * (1 + 1e-12)
        if law == "stick" and not stuck:
            assert np.linalg.norm(T) == pytest.approx(2.0)


@pytest.mark.parametrize("law", ["stick", "lugre"])
def test_friction_follows_a_turning_slip(law):
    """In steps far longer than the bristles need, friction is opposite to the slip at their end."""
    c = slot(law, 0.2, h=1e-2)
    for i in range(20):
        V = np.array([np.cos(0.1 * i), np.sin(0.1 * i), 0.0])
        T, c[HISTORY], _ = rub(c, V)
    assert pytest.approx(-2.0 * V, abs=1e-4) == T


# -------------------------------------------------------------------------------- order


def advanced(law, steps, velocity, end=1.0, **more):
    """Deflection at the end of a motion given by its slip velocity."""
    c = slot(law, h=end / steps, **more)
    c[laws.HISTORY + 3 : laws.HISTORY + 6] = velocity(0.0)
    c[laws.HISTORY + 6] = 1.0
    for i in range(steps):
        c[HISTORY] = rub(c, velocity((i + 1) * end / steps))[1]
    return c[laws.HISTORY : laws.HISTORY + 3]


def wandering(t):
    return np.array([np.cos(3 * t), 1.3 * np.sin(2 * t) + 0.2, 0.0])


@pytest.mark.parametrize("kinetic", [0.3, 0.45])
def test_lugre_deflection_is_of_second_order(kinetic):
    more = {"kinetic": kinetic, "static": 0.5, "presliding": 0.3, "stribeck_speed": 0.9}

    def grow(t, z):
        V = wandering(t)
        g = kinetic + (0.5 - kinetic) * np.exp(-(V @ V) / 0.81)
        return V - 0.5 / 0.3 * np.linalg.norm(V) * z / g

    exact = solve_ivp(grow, (0, 1), np.zeros(3), rtol=1e-11, atol=1e-13).y[:, -1]
    errors = [np.linalg.norm(advanced("lugre", k, wandering, **more) - exact) for k in (20, 40, 80)]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.2)
    assert np.log2(errors[1] / errors[2]) == pytest.approx(2.0, abs=0.1)


def test_deflection_of_what_sticks_is_the_displacement():
    exact = np.array([np.sin(3) / 3, 0.65 * (1 - np.cos(2)) + 0.2, 0.0])
    more = {"kinetic": 0.3, "presliding": 10.0}
    errors = [np.linalg.norm(advanced("stick", k, wandering, **more) - exact) for k in (20, 40)]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.02)


def test_direction_of_sliding():
    """On the circle |z| = r: z' = V - (V·z) z/r²; in long steps and in those that resolve r."""
    r, start = 0.005, 0.2

    def turn(t, z):
        V = wandering(t)
        return V - (V @ z) * z / r**2

    more = {"kinetic": 0.3, "presliding": r}
    first = advanced("stick", 4000, wandering, end=start, **more)
    assert np.linalg.norm(first) == pytest.approx(r)
    exact = solve_ivp(turn, (start, 1), first, "LSODA", rtol=1e-9, atol=1e-12).y[:, -1]
    errors = [
        np.linalg.norm(advanced("stick", k, wandering, **more) - exact) / r
        for k in (10, 20, 40, 80, 160, 640, 1280)
    ]
    assert max(errors) < 2e-3  # half a step behind, the first would be 0.1
    assert max(errors[:3]) < 5e-4
    assert errors[-1] / errors[-2] == pytest.approx(0.5, abs=0.02)


# ------------------------------------------------------------------------- thermodynamics


@pytest.mark.parametrize("damping", [0.0, 2e-5, 2e-3])
@pytest.mark.parametrize("law", FRICTION)
def test_closed_loops_never_give_energy(law, damping):
    """Random periodic motions about the size of the presliding deflection, the second period."""
    rng = np.random.default_rng(5)
    steps = 2000
    t = 2 * np.pi * np.arange(1, 2 * steps + 1) / steps
    for size in (0.2, 0.6, 1.0, 3.0, 30.0):
        c = slot(law, 0.2, h=2 * np.pi / steps, bristle_damping=damping * 1e7 * 0.2)
        V = np.zeros((2 * steps, 3))
        for k in range(1, 5):
            a, b = size * 1e-7 * rng.standard_normal((2, 2)) / k
            V[:, :2] += np.outer(np.cos(k * t), a) + np.outer(np.sin(k * t), b)
        work, before = 0.0, np.zeros(3)
        for i in range(2 * steps):
            T, c[HISTORY], _ = rub(c, V[i])
            if i >= steps:
                work -= c[laws.STEP] * 0.25 * (T + before) @ (V[i] + V[i - 1])
            before = T
        assert work >= -1e-6 * 2.0 * size * 1e-7


# --------------------------------------------------------------------------- frame, numbers


@pytest.mark.parametrize("law", ["stick", "rising", "lugre"])
def test_deflection_turns_with_the_tangent_plane(law):
    """Once round a bore while it sticks: the bristle stays along the tangent, as long as it was."""
    c = slot(law, 0.3, h=1e-3)
    c[laws.HISTORY + 1], c[laws.HISTORY + 6] = 4e-8, 1.0
    for angle in np.linspace(0, 2 * np.pi, 101)[1:]:
        n = np.array([np.cos(angle), np.sin(angle), 0.0])
        T, c[HISTORY], stuck = rub(c, np.zeros(3), n)
        assert stuck == 1.0
        assert pytest.approx(-1.2 * np.array([-n[1], n[0], 0.0]), rel=1e-12) == T


@pytest.mark.parametrize("law", FRICTION)
def test_friction_is_in_the_tangent_plane_in_any_frame(law):
    rng = np.random.default_rng(7)
    frame = np.linalg.qr(rng.standard_normal((3, 3)))[0]
    c, d = (slot(law, 0.2, 0.3, h=1e-5, bristle_damping=5.0) for _ in range(2))
    n = N
    for speed in 10.0 ** rng.uniform(-4, 0, 50):
        n = n + 0.05 * rng.standard_normal(3)
        n /= np.linalg.norm(n)
        V = speed * np.cross(n, rng.standard_normal(3))
        T, c[HISTORY], _ = rub(c, V, n)
        turned, d[HISTORY], _ = rub(d, frame @ V, frame @ n)
        assert abs(T @ n) < 1e-12
        assert turned == pytest.approx(frame @ T, abs=1e-9)


@pytest.mark.parametrize("damping", [0.0, 20.0])
@pytest.mark.parametrize("law", FRICTION)
def test_derivatives_by_an_imaginary_step(law, damping):
    rng = np.random.default_rng(11)
    n = np.array([0.0, 0.6, 0.8])
    across = np.eye(3) - np.outer(n, n)
    for scale in (0.1, 1.0, 100.0):
        for timer in (0.0, 1.0):
            c = slot(law, 0.2, 0.3, h=1e-4, viscous=1.0, bristle_damping=damping,
                     presliding=1e-6, stribeck_speed=1e-2)  # fmt: skip
            V0, V = 1e-3 * scale * (across @ rng.standard_normal((2, 3)).T).T
            c[laws.HISTORY : laws.HISTORY + 3] = across @ rng.standard_normal(3) * 3e-7
            c[laws.HISTORY + 3 : laws.HISTORY + 6], c[laws.HISTORY + 6] = V0, timer
            for _ in range(3):
                dV, dn, df = rng.standard_normal(3), rng.standard_normal(3), rng.standard_normal()

                def along(s, dV=dV, dn=dn, df=df, c=c, V=V):
                    found = rub(c, V + s * np.abs(V).max() * dV, n + s * dn, 10.0 + s * df)
                    return np.append(found[0], 1e7 * found[1][:3])

                exact = along(1e-25j).imag / 1e-25
                h = 1e-5
                about = (along(h) - along(-h)) / (2 * h)
                assert about == pytest.approx(exact, rel=1e-6, abs=1e-6 * np.abs(exact).max())


def test_derivative_at_rest():
    """T = -μ N V/ε for slow slip."""
    c = slot("regularised", 0.2, regularisation_speed=1e-4)
    T = rub(c, np.array([1e-25j, 0.0, 0.0]))[0]
    assert T[0].imag / 1e-25 == pytest.approx(-2.0 / 1e-4)
    c = slot("stick", 0.2, h=1e-5)
    T = rub(c, np.array([1e-25j, 0.0, 0.0]))[0]
    assert T[0].imag / 1e-25 == pytest.approx(-10 * c[laws.BRISTLE] * 0.5e-5)


@pytest.mark.parametrize("law", FRICTION)
def test_friction_is_a_number(law):
    more = {"regularisation_speed": 0.0, "stribeck_speed": 0.0}
    for kinetic, static in ((0.0, 0.0), (0.0, 0.3), (0.2, 0.3)):
        for h in (0.0, 1e-12, 1e-3):
            c = slot(law, kinetic, static, h, **more)
            for speed in (0.0, 1e-200, 1e-10, 1.0, 1e10):
                for step in (0.0, 1e-30j):
                    T, new, _ = rub(c, np.array([speed + step, 0.0, 0.0]))
                    assert np.all(np.isfinite(T)) and np.all(np.isfinite(new))
    assert not rub(np.zeros(laws.SLOT), np.ones(3))[0].any()
