"""The references for contact themselves: closed forms against integration, balances, limits."""

from math import atan, log, pi

import numpy as np
import pytest
from scipy.optimize import minimize

from coupling.verify import contact_references as ref
from coupling.verify.contact_references import Law, SliderCrank

HERTZ = Law(1.53846e10)


def shot(law, mass, speed, gap, t_end, samples=2001):
    """A mass that starts at one of two walls, ``gap`` apart, towards the other; rows x, v."""

    def gaps(t, y):
        return [y[0] - gap, -y[0]], [y[1], -y[1]]

    def rate(t, y, approach):
        push = [law.normal(*at)[1] for at in zip(*gaps(t, y), approach, strict=True)]
        return [y[1], (push[1] - push[0]) / mass]

    times = np.linspace(0.0, t_end, samples)
    return ref.march(rate, gaps, [1e-12, speed], times, 0.1 * gap / speed)


# ---------------------------------------------------------------------------- closed forms


@pytest.mark.parametrize(("e", "total"), [(0.9, 8.578949), (0.5, 1.354571)])
def test_bounces_of_a_ball_add_up(e, total):
    assert ref.bouncing_time(1.0, e) == pytest.approx(total, rel=1e-6)
    assert ref.bounces(1.0, e, 400)[-1] == pytest.approx(total, rel=1e-6)
    times = ref.bounces(1.0, e, 3)
    v = 9.81 * times[0]
    assert np.diff(times) == pytest.approx([2 * e * v / 9.81, 2 * e**2 * v / 9.81])


def test_a_mass_between_walls():
    found = 1e3 * ref.between_walls(0.2e-3, 0.1, 0.85, 5)
    assert found == pytest.approx([2.0, 4.35294, 7.12111, 10.37777, 14.20915], abs=5e-6)


@pytest.mark.parametrize("e", [0.05, 0.3, 0.85, 0.99, 1.0])
def test_the_factor_solves_its_equation(e):
    D = ref.exact_factor(e)
    assert D * (1.0 + e) == pytest.approx(log((1.0 + D) / (1.0 - D * e)), rel=1e-6, abs=1e-14)
    assert (D > 0.0) == (e < 1.0)


def test_stiffness_of_a_pin_in_a_bore():
    K = ref.hertz_in_a_bore(9.5e-3, 0.5e-3, 207e9, 0.3)
    assert pytest.approx(6.6102e10, rel=1e-5) == K


def test_the_ideal_slider_crank():
    m = SliderCrank()
    turn = 2.0 * pi / m.speed
    assert m.ideal([0.0, 0.5 * turn])[2] == pytest.approx([-19419.36, 7996.21], abs=5e-3)
    t = np.linspace(0.0, turn, 20001)
    x, v, a = m.ideal(t)
    assert a.max() == pytest.approx(9695.90, rel=1e-5)
    assert np.gradient(x, t)[1:-1] == pytest.approx(v[1:-1], abs=1e-5)
    assert np.gradient(v, t)[1:-1] == pytest.approx(a[1:-1], abs=5e-3)
    angles = np.array([m.rod_angle(at) for at in t])
    ends = np.array([m.pin(at) for at in t]).T + m.rod * np.array(
        [np.cos(angles[:, 0]), np.sin(angles[:, 0])]
    )
    assert np.abs(ends - [x, 0.0 * x]).max() < 1e-15
    assert np.gradient(angles[:, 0], t)[1:-1] == pytest.approx(angles[1:-1, 1], abs=1e-3)


# ------------------------------------------------------------------------ march and its law


def test_an_elastic_hertz_impact():
    """Johnson 1985, sec. 11.4."""
    path = shot(HERTZ, 0.032673, 1.0, 1e-3, 1.2e-3, 20001)
    depth = path.y[0] - 1e-3
    assert depth.max() == pytest.approx(2.342085e-5, rel=1e-5)
    assert HERTZ.normal(depth.max(), 0.0, 1.0)[0] == pytest.approx(1743.776, rel=1e-5)
    assert np.ptp(path.t[depth > 0.0]) == pytest.approx(6.8934e-5, rel=3e-3)
    assert path.y[1, -1] == pytest.approx(-1.0, rel=1e-9)


@pytest.mark.parametrize("exponent", [1.0, 1.5])
@pytest.mark.parametrize("e", [0.3, 0.85])
def test_each_impact_delivers_the_restitution(e, exponent):
    law = Law(1e10, exponent, ref.exact_factor(e))
    path = shot(law, 0.01, 0.1, 0.2e-3, 1.1 * ref.between_walls(0.2e-3, 0.1, e, 4)[-1])
    speeds = [impact.speed for impact in path.impacts]
    assert len(speeds) == 4
    assert speeds == pytest.approx(0.1 * e ** np.arange(len(speeds)), rel=1e-7)


def test_between_stiff_walls_the_impacts_come_when_the_closed_form_says():
    expected = ref.between_walls(0.2e-3, 0.1, 0.85, 5)
    late = []
    for K in (1e12, 1e14, 1e16):
        law = Law(K, factor=ref.exact_factor(0.85))
        found = shot(law, 0.01, 0.1, 0.2e-3, 0.0145, 11).impacts
        late.append(np.array([impact.t for impact in found]) - expected)
    # every impact lasts a time ~ K^-0.4
    assert np.all(late[0][1:] > 0.0)
    assert late[0][1:] / late[1][1:] == pytest.approx(100**0.4, rel=1e-3)
    assert late[1][1:] / late[2][1:] == pytest.approx(100**0.4, rel=1e-3)


# -------------------------------------------------------------------------- ball and wall

BALL = {"mass": 0.1, "radius": 0.02}


@pytest.mark.parametrize(("mu", "slides"), [(0.05, True), (0.5, False)])
def test_impulses_move_the_ball_and_take_energy(mu, slides):
    v, w, n = np.array([1.0, -0.3, 0.8]), np.array([3.0, 7.0, 20.0]), np.array([0.0, 0.0, 1.0])
    found = ref.ball_on_wall(**BALL, velocity=v, spin=w, normal=n, restitution=0.9, friction=mu)
    inertia = 0.4 * 0.1 * 0.02**2
    assert found.slides is slides
    assert found.velocity[2] == pytest.approx(-0.9 * 0.8)
    # nothing acts about the point of contact
    about = [0.1 * np.cross(-0.02 * n, u) + inertia * s for u, s in ((v, w), found[:2])]
    assert about[0] == pytest.approx(about[1], rel=1e-12)
    slip = [u + np.cross(s, 0.02 * n) for u, s in ((v, w), found[:2])]
    if slides:
        assert np.linalg.norm(found.tangential) == pytest.approx(mu * found.normal)
        assert slip[0][:2] @ slip[1][:2] > 0.0
    else:
        assert np.abs(slip[1][:2]).max() < 1e-12
    energy = [0.05 * u @ u + 0.5 * inertia * s @ s for u, s in ((v, w), found[:2])]
    assert energy[1] < energy[0]


@pytest.mark.parametrize("mu", [0.1, 0.2])
def test_a_yielding_wall_gives_the_same_where_the_ball_slides(mu):
    law = Law(1e9, factor=ref.exact_factor(0.8), friction=mu, slow=1e-7)
    mass, radius, start = 0.1, 0.02, [-1e-4, 0.5, 1.0, 10.0]  # depth, its rate, along, spin
    inertia = 0.4 * mass * radius**2

    def rate(t, y, approach):
        force = law.normal(y[0], y[1], approach[0])[1]
        T = law.tangential(force, y[2] + radius * y[3])
        return [y[1], -force / mass, T / mass, radius * T / inertia]

    times = np.linspace(0.0, 2e-3, 3)
    path = ref.march(rate, lambda t, y: ([y[0]], [y[1]]), start, times, 1e-5)
    # the wall is at z, the ball runs along x: the spin about y moves the contact by +R spin
    found = ref.ball_on_wall(mass, radius, [1, 0, 0.5], [0, 10, 0], [0, 0, 1], 0.8, mu)
    assert found.slides and len(path.impacts) == 1
    expected = found.velocity[2], found.velocity[0], found.spin[1]
    assert path.y[1:, -1] == pytest.approx(expected, rel=1e-6)


# ---------------------------------------------------------------------------- a tilted pin


@pytest.mark.parametrize("arm", [0.0, 0.01, 0.05])
def test_a_tilted_pin_is_in_equilibrium(arm):
    found = ref.tilted_pin(100.0, arm, 0.04, 50e-6, 1e9)
    assert found.forces.sum() == pytest.approx(-100.0)
    assert found.forces @ [0.02, -0.02] == pytest.approx(-100.0 * arm, abs=1e-12)
    assert np.prod(np.sign(found.forces)) == (-1.0 if arm > 0.02 else 1.0)


def test_a_pin_that_leans_on_stiff_edges_turns_by_twice_the_clearance_over_the_length():
    for K in (None, 1e20):
        found = ref.tilted_pin(100.0, 0.05, 0.04, 50e-6, K)
        assert found.angle == pytest.approx(atan(2.0 * 50e-6 / 0.04), rel=1e-6)
    assert ref.tilted_pin(100.0, 0.05, 0.04, 50e-6, 1e9).angle > 1.05 * found.angle


@pytest.mark.parametrize("arm", [0.01, 0.05])
def test_a_tilted_pin_has_the_least_potential(arm):
    c, length, K, load = 50e-6, 0.04, 1e9, 100.0
    found = ref.tilted_pin(load, arm, length, c, K)

    def potential(y):
        y = 1e-4 * y
        at = 0.5 * (y[0] + y[1]) + arm * (y[0] - y[1]) / length
        return 1e3 * (Law(K).stored(np.abs(y) - c).sum() - load * at)

    least = minimize(potential, [1.0, 0.5], method="Nelder-Mead", options={
        "xatol": 1e-10, "fatol": 1e-16, "maxiter": 4000,
    }).x  # fmt: skip
    assert 1e-4 * least == pytest.approx(found.displacement, rel=1e-5)


# ---------------------------------------------------------------------------- slider-cranks

LOOSE = [ref.slider_crank, ref.slider_in_guide]
TURN = 2.0 * pi / SliderCrank().speed


@pytest.mark.parametrize("made", LOOSE)
@pytest.mark.parametrize("mu", [0.0, 0.1])
def test_energy_balances(made, mu):
    found = made(friction=mu, t_end=0.5 * TURN)
    assert len(found.impacts) > 5
    assert np.abs(found.defect).max() < 1e-7 * found.energy[0, 0]
    hysteresis, friction = found.energy[:, 3], found.energy[:, 4]
    assert np.diff(friction).min() >= 0.0 and (friction[-1] > 0.0) == (mu > 0.0)
    assert hysteresis[-1] > 1e-2


@pytest.mark.parametrize("made", LOOSE)
def test_velocity_and_acceleration_belong_to_the_motion(made):
    found = made(friction=0.1, t_end=2e-3, samples=20001)
    inside = slice(1, -1)
    v = np.gradient(found.position, found.t)[inside]
    assert v == pytest.approx(found.velocity[inside], abs=1e-3)
    a = np.gradient(found.velocity, found.t)[inside]
    assert np.quantile(np.abs(a - found.acceleration[inside]), 0.99) < 1e-3 * np.abs(a).max()


@pytest.mark.parametrize("made", LOOSE)
def test_the_smaller_the_clearance_the_nearer_the_ideal_motion(made):
    away = []
    for clearance in (2e-4, 1e-4, 5e-5):
        found = made(clearance, 0.5, t_end=0.5 * TURN)
        away.append(np.abs(found.position - SliderCrank().ideal(found.t)[0]).max() / clearance)
    assert max(away) < 2.0


def test_the_pin_stays_in_its_bore_and_pushes_only_at_its_edge():
    found = ref.slider_crank(2e-4, t_end=0.5 * TURN)
    distance = np.hypot(*found.orbit.T)
    assert distance.max() < 1.3 * 2e-4
    assert np.all(found.force[distance < 2e-4] == 0.0)
    assert found.force.max() > 1e3


def test_until_the_first_contact_the_slider_stays():
    found = ref.slider_crank(t_end=5e-4)
    flight = found.t < found.impacts[0].t
    assert np.all(found.acceleration[flight] == 0.0)
    assert np.ptp(found.velocity[flight]) == 0.0
    # meanwhile the end of the rod falls behind with what would be the slider's acceleration
    assert found.impacts[0].t == pytest.approx((2.0 * 0.5e-3 / 19419.36) ** 0.5, rel=0.01)


def test_a_slider_that_rises_straight_meets_the_wall_with_both_corners():
    found = ref.slider_in_guide(t_end=1e-3)
    first, second = found.impacts[:2]
    assert {first.contact, second.contact} in ({0, 2}, {1, 3})
    assert (first.t, first.speed) == pytest.approx((second.t, second.speed), rel=1e-9)
    assert np.abs(found.orbit[found.t < first.t, 1]).max() < 1e-15


def test_tighter_tolerances_give_the_same_first_impacts():
    two = [ref.slider_crank(friction=0.1, t_end=1.5e-3, samples=n).impacts for n in (3, 301)]
    m, law = SliderCrank(), Law(6.6102e10, 1.5, ref.exact_factor(0.9), 0.1)
    loose = ref._Pin(m, law, 5e-4, 9.5e-3)
    x, v, _ = m.ideal(0.0)
    start = [*m.rod_angle(0.0)[:1], float(x), m.rod_angle(0.0)[1], float(v), 0.0, 0.0, 0.0]
    finer = ref.march(loose.rate, loose.gaps, start, np.linspace(0, 1.5e-3, 3), 3e-6, 1e-12)
    for other in (two[1], finer.impacts):
        assert len(two[0]) == len(other) > 2
        assert [i.t for i in two[0]] == pytest.approx([i.t for i in other], rel=1e-6)
