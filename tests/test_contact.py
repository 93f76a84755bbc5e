"""Contact laws against integration of the equation of motion and against published numbers."""

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq

from mechanics import contact
from mechanics.contact import DISSIPATION
from mechanics.contact_laws import CYLINDER as CYLINDER_LAW
from mechanics.contact_laws import LAW, POWER, SLOT, normal
from mechanics.description import Friction, NormalContact

MASS, STIFFNESS = 0.032673, 1.53846e10


def rebound(factor, speed, reference, exponent=1.5):
    """Restitution of m δ̈ = -F(δ, δ̇) integrated from contact to separation."""

    def motion(t, state):
        force = contact.normal_force(STIFFNESS, exponent, state[0], state[1], factor, reference)
        return [state[1], -force / MASS]

    def apart(t, state):
        return state[0] if t > 0.0 else 1.0

    apart.terminal, apart.direction = True, -1
    span = 20 * contact.elastic_impact(MASS, STIFFNESS, speed, exponent).duration
    scale = [speed * span, speed]
    run = solve_ivp(
        motion, (0, span), [0.0, speed], events=apart, rtol=1e-10, atol=1e-13 * np.array(scale),
        max_step=span / 200,
    )  # fmt: skip
    return -run.y_events[0][0, 1] / speed


@pytest.mark.parametrize("restitution", [0.05, 0.3, 0.85, 0.99])
@pytest.mark.parametrize(("speed", "exponent"), [(0.001, 1.5), (10.0, 1.5), (0.1, 1.0)])
def test_exact_factor_delivers_its_restitution(restitution, speed, exponent):
    factor = contact.exact_factor(restitution)
    assert rebound(factor, speed, speed, exponent) == pytest.approx(restitution, rel=1e-5)


def test_exact_factor_balances_the_impact():
    """∫ u/(1 + D u) du from -e to 1 vanishes; in s = ln(1 + D u) it is ∫ (exp(s) - 1) ds / D²."""
    e = np.array([0.1, 0.3, 0.5, 0.85, 0.93, 0.94, 0.99, 0.999, 1.0 - 1e-6])
    for restitution, D in zip(e, contact.exact_factor(e), strict=True):
        gained = quad(np.expm1, 0.0, np.log1p(D), epsabs=0, epsrel=1e-13)[0]
        lost = quad(np.expm1, np.log1p(-D * restitution), 0.0, epsabs=0, epsrel=1e-13)[0]
        assert gained == pytest.approx(-lost, rel=1e-10)


def test_exact_factor_at_the_ends_of_its_range():
    e = np.array([0.01, 0.02, 0.05, 0.1, 0.5, 0.9, 0.999])
    D = contact.exact_factor(e)
    assert np.all(np.diff(D) < 0)
    assert np.all(D * e <= 1.0)
    assert contact.exact_factor(0.01) == pytest.approx(100.0, rel=1e-12)  # 1 - D e = 101 exp(-101)
    assert contact.exact_factor(1.0 - 1e-9) == pytest.approx(1.5e-9, rel=1e-6)
    assert contact.exact_factor(1.0) == 0.0
    with pytest.raises(ValueError, match=r"0\.01 to 1"):
        contact.exact_factor(0.0)


def test_exact_factor_is_another_solvers_root():
    for e in (0.1, 0.5, 0.85):
        root = brentq(
            lambda D, e=e: D * (1 + e) - np.log((1 + D) / (1 - D * e)), 0.1, 0.9999999 / e
        )
        assert contact.exact_factor(e) == pytest.approx(root, rel=1e-9)


@pytest.mark.parametrize("law", DISSIPATION)
def test_delivered_restitution_is_what_integration_gives(law):
    for e in (0.1, 0.5, 0.85):
        factor = DISSIPATION[law](e)
        expected = rebound(factor, 0.3, 0.3)
        assert contact.delivered_restitution(factor) == pytest.approx(expected, rel=2e-5)


def test_delivered_restitution_inverts_the_exact_factor():
    e = np.array([0.05, 0.2, 0.5, 0.85, 0.9999, 1.0])
    assert np.allclose(contact.delivered_restitution(contact.exact_factor(e)), e, atol=1e-10)


def test_delivered_restitution_of_the_laws_at_085():
    """Values of an independent study of the printed laws."""
    found = {law: contact.delivered_restitution(DISSIPATION[law](0.85)) for law in DISSIPATION}
    expected = {"hua2026": 0.752, "lankarani-nikravesh": 0.878, "flores": 0.841, "hu-guo": 0.850}
    for law, value in expected.items():
        assert found[law] == pytest.approx(value, abs=6e-4)


def test_fixed_reference_speed_makes_restitution_depend_on_speed():
    factor = DISSIPATION["hua2026"](0.85)
    for speed, value in ((0.01, 0.968), (0.1, 0.752), (0.5, 0.358)):
        assert rebound(factor, speed, 0.1) == pytest.approx(value, abs=6e-4)
        assert contact.delivered_restitution(factor * speed / 0.1) == pytest.approx(value, abs=6e-4)


def test_force_never_pulls_and_is_elastic_without_an_approach_speed():
    assert contact.normal_force(1e9, 1.5, 1e-5, -1.0, 2.0, 0.1) == 0.0
    assert contact.normal_force(1e9, 1.5, -1e-5, 1.0, 2.0, 0.1) == 0.0
    for approach in (0.0, -1.0):
        force = contact.normal_force(1e9, 1.5, 1e-5, 1.0, 2.0, approach)
        assert force == pytest.approx(1e9 * 1e-5**1.5, rel=1e-14)


def test_hertz_impact_of_a_steel_ball():
    stiffness = contact.hertz_stiffness(10e-3, 210e9, 0.3, 210e9, 0.3)
    impact = contact.elastic_impact(7800 * 4 / 3 * np.pi * 10e-3**3, stiffness, 1.0)
    assert impact.penetration == pytest.approx(2.342085e-5, rel=1e-6)
    assert impact.force == pytest.approx(1743.776, rel=1e-6)
    assert impact.duration == pytest.approx(6.8934e-5, rel=1e-5)
    assert impact.duration / impact.penetration == pytest.approx(2.94328, abs=5e-6)


def test_linear_impact_lasts_half_a_period():
    impact = contact.elastic_impact(2.0, 3e6, 0.1, 1.0)
    assert impact.duration == pytest.approx(np.pi * np.sqrt(2.0 / 3e6), rel=1e-12)
    assert impact.force == pytest.approx(0.1 * np.sqrt(2.0 * 3e6), rel=1e-12)


def test_hertz_stiffness_of_a_published_journal_bearing():
    """Flores' slider-crank: bearing 10 mm, journal 9.5 mm, steel."""
    radius = contact.hertz_radius("hertz-internal", 9.5e-3, 10e-3)
    assert contact.hertz_stiffness(radius, 207e9, 0.3, 207e9, 0.3) == pytest.approx(
        6.6102e10, rel=1e-4
    )


def test_external_radius_is_much_softer_than_internal():
    pair = [
        contact.hertz_radius(f"hertz-{side}", 9.9e-3, 10e-3) for side in ("internal", "external")
    ]
    assert np.sqrt(pair[0] / pair[1]) == pytest.approx(14.1, abs=0.1)


def test_static_hertz_contact():
    """Aluminium, R = 10 mm against a rigid plane of the same material, 100 N."""
    stiffness = contact.hertz_stiffness(10e-3, 69e9, 0.33, 69e9, 0.33)
    assert (100 / stiffness) ** (2 / 3) == pytest.approx(7.212941e-6, rel=1e-6)


def test_clearance_closes_by_seizure_and_opens_with_the_bearing():
    hot = 50e-6 / (23.1e-6 * 25e-3)
    assert hot == pytest.approx(86.5801, rel=1e-6)
    assert contact.thermal_clearance(50e-6, 25e-3, 23.1e-6 * hot, 0.0) == pytest.approx(
        0, abs=1e-12
    )
    even = contact.thermal_clearance(50e-6, 25e-3, 1e-3, 1e-3)
    assert even == pytest.approx(50e-6 * 1.001, rel=1e-12)


def test_partition_of_aluminium_and_steel():
    aluminium, steel = (167.0, 2700.0, 896.0), (16.2, 8000.0, 500.0)
    for law, share in (("effusivity", 0.714035), ("product", 0.862)):
        weights = [contact.PARTITION[law](*body) for body in (aluminium, steel)]
        assert weights[0] / sum(weights) == pytest.approx(
            share, abs=5e-4 if law == "product" else 1e-6
        )


def test_effusivity_gives_both_faces_one_temperature():
    """Explicit heat conduction in two half-spaces with a source at their interface."""
    k, capacity = np.array([167.0, 16.2]), np.array([2700.0 * 896.0, 8000.0 * 500.0])
    cells, dx, q = 120, 1e-4, 1e4
    T = np.zeros((2, cells))
    dt = 0.4 * dx**2 * (capacity / k).min()
    weight = contact.PARTITION["effusivity"](k, capacity, 1.0)
    share = weight / weight.sum()
    for _ in range(1600):
        flow = np.zeros((2, cells + 1))
        flow[:, 1:-1] = -k[:, None] * np.diff(T, axis=1) / dx
        flow[:, 0] = share * q
        T -= dt * np.diff(flow, axis=1) / (dx * capacity[:, None])
    surface = T[:, 0] + share * q * dx / (2 * k)
    assert surface[0] == pytest.approx(surface[1], rel=5e-3)


def test_friction_coefficient_and_force():
    assert contact.friction_coefficient(398.15, 0.1, -1e-3, 298.15) == pytest.approx(0.09)
    assert contact.friction_coefficient(5000.0, 0.1, -1e-3, 298.15) == 0.0
    force = contact.friction_force(0.2, 10.0, np.array([-1.0, 0.0, 1e-4, 1.0]), 1e-4)
    assert np.allclose(force, [2.0 / 1.0001, 0.0, -1.0, -2.0 / 1.0001], rtol=1e-12)


def test_regimes():
    cases = [
        (-1e-6, 0.1, 0.0, 1.0, contact.FREE_FLIGHT),
        (1e-6, 0.05, 0.1, 1.0, contact.IMPACT),
        (1e-6, -0.05, 0.1, 1.0, contact.IMPACT),
        (1e-6, 0.001, 0.1, 1.0, contact.SLIP),
        (1e-6, 0.001, 0.1, 1e-5, contact.STICK),
        (1e-6, 0.001, -1.0, 1e-5, contact.STICK),
    ]
    depth, rate, approach, slip, expected = np.array(cases).T
    found = contact.classify(depth, rate, approach, slip, 1e-4)
    assert found.dtype == np.int8
    assert found.tolist() == expected.tolist()


def test_regimes_of_friction_with_bristles():
    """The bristles tell, not the speed; an impact stays one."""
    for law in ("stick", "lugre", "rising"):
        code = contact.FRICTION[law]
        for stuck, slip in ((1.0, 1.0), (0.0, 1e-9)):
            expected = contact.STICK if stuck else contact.SLIP
            assert contact.classify(1e-6, 0.001, 0.1, slip, 1e-4, stuck, code) == expected
            assert contact.classify(1e-6, 0.05, 0.1, slip, 1e-4, stuck, code) == contact.IMPACT
            assert contact.classify(-1e-6, 0.05, 0.1, slip, 1e-4, stuck, code) == 0
    for law in ("regularised", "stribeck"):
        code = contact.FRICTION[law]
        assert contact.classify(1e-6, 0.0, 0.1, 1e-5, 1e-4, 0.0, code) == contact.STICK


def test_static_hertz_contact_of_an_aluminium_ball():
    """Ball of 10 mm on a plane, both 69 GPa and 0.33, 100 N: a² = R δ, p0 = 3 F/(2 π a²)."""
    R = contact.hertz_radius("hertz-internal", 10e-3, np.inf)
    K = contact.hertz_stiffness(R, 69e9, 0.33, 69e9, 0.33)
    depth = brentq(lambda d: contact.normal_force(K, 1.5, d, 0.0, 0.0, 0.0) - 100.0, 0, 1e-3)
    assert depth == pytest.approx(7.212941e-6, rel=1e-6)
    a = np.sqrt(R * depth)
    assert a == pytest.approx(2.685692e-4, rel=1e-6)
    assert 150.0 / (np.pi * a**2) == pytest.approx(6.619558e8, rel=1e-6)


def test_rigid_impact():
    """Hua et al. 2026: 2 and 1 kg, 3 and -1 m/s, e = 0.6."""
    found = contact.rigid_impact(2.0, 1.0, 3.0, -1.0, 0.6)
    assert found == pytest.approx((0.866667, 3.266667, 3.413333), rel=1e-6)
    before = 0.5 * (2.0 * 3.0**2 + 1.0)
    after = 0.5 * (2.0 * found.first**2 + found.second**2)
    assert before - after == pytest.approx(found.loss)
    wall = contact.rigid_impact(1.0, 1e300, 2.0, 0.0, 0.85)
    assert wall.first == pytest.approx(-1.7)


def test_rising_static_friction():
    numbers = (0.0623, 0.0859, 0.570, 0.629)
    times = np.array([0.0, 1.365, 9.20, 27.7, 1e9])
    part = (contact.rising_coefficient(times, *numbers) - 0.0623) / 0.0236
    assert part == pytest.approx([0.0, 0.5, 0.9, 0.99, 1.0], abs=1e-3)


CYLINDER = NormalContact("cylinder")
ALLOY = (69e9, 0.33, 207e9, 0.3)


def test_cylinder_law():
    """Pin 9.5 mm in a bore of 10 mm, 15 mm long: δ = F/(π E* L) (ln(4 π E* L ΔR/F) - 1)."""
    modulus = 1.0 / ((1 - 0.33**2) / 69e9 + (1 - 0.3**2) / 207e9)
    columns = contact.law_columns(CYLINDER, 9.5e-3, 0.5e-3, 15e-3, 1.0, *ALLOY)
    law, K, P = columns
    assert law == CYLINDER_LAW
    assert pytest.approx(np.pi * modulus * 15e-3, rel=1e-14) == K
    assert pytest.approx(4 * np.pi * modulus * 15e-3 * 0.5e-3, rel=1e-14) == P
    for force in (1e-6, 1.0, 27.0, 1e4, 0.89 * P / np.e**2):
        depth = force / (np.pi * modulus * 15e-3) * (np.log(P / force) - 1)
        assert contact.cylinder_indentation(force, K, P) == pytest.approx(depth, rel=1e-13)
        assert contact.cylinder_force(depth, K, P) == pytest.approx(force, rel=1e-9)


def test_cylinder_law_against_its_compiled_twin():
    _, K, P = contact.law_columns(CYLINDER, 9.5e-3, 0.5e-3, 15e-3, 1.0, *ALLOY)
    c = np.zeros(SLOT)
    c[0], c[LAW : LAW + 3] = 1.0, (CYLINDER_LAW, K, P)
    depths = np.array([-1e-6, 0.0, 1e-9, 1e-6, 1e-4, 2.6e-4, 2.7e-4, 1e-3])
    expected = [normal(depth, 0.0, c)[0] for depth in depths]
    assert contact.cylinder_force(depths, K, P) == pytest.approx(expected, rel=1e-9)


def test_columns_of_normal_laws():
    def columns(stiffness, value=None, share=1.0, clearance=0.5e-3, length=15e-3):
        law = NormalContact(stiffness, value)
        return contact.law_columns(law, 9.5e-3, clearance, length, share, *ALLOY)

    assert columns("linear", 3e6, 0.5) == (POWER, 1.5e6, 1.0)
    for name in ("hertz-external", "hertz-internal"):
        K = contact.hertz_stiffness(contact.hertz_radius(name, 9.5e-3, 10e-3), *ALLOY)
        assert columns(name, share=1 / 3) == pytest.approx((POWER, K / 3, 1.5))
        assert columns(name, 2e9) == (POWER, 2e9, 1.5)
    half, whole = columns("cylinder", share=0.5), columns("cylinder", length=7.5e-3)
    assert half == pytest.approx(whole)
    assert columns("cylinder", 1e9) == pytest.approx((CYLINDER_LAW, 1e9, 4e9 * 0.5e-3))
    assert columns("cylinder", clearance=-1e-5)[2] < 0.0  # the compiled law is linear then
    for wrong in ({"stiffness": "linear"}, {"stiffness": "cylinder", "length": None},
                  {"stiffness": "hertz-internal", "clearance": 0.0}):  # fmt: skip
        with pytest.raises(ValueError, match="needs"):
            columns(**wrong)


def test_columns_of_friction_laws():
    assert not contact.friction_columns(None, 300.0).any()
    slope = Friction(0.1, temperature_slope=-1e-3, static_coefficient=0.15, law="stick")
    found = contact.friction_columns(slope, 398.15)
    assert found[:3] == pytest.approx([contact.FRICTION["stick"], 0.09, 0.135])
    assert found[6] == pytest.approx(0.135 / 1e-7)
    table = ((200.0, 2.0), (300.0, 1.0))
    law = Friction(0.1, law="rising", table=table, bristle_damping=3.0, viscous=0.2)
    for T, factor in ((100.0, 2.0), (250.0, 1.5), (400.0, 1.0)):
        found = contact.friction_columns(law, T)
        expected = [5, 0.1 * factor, 0.1 * factor, 1e-4, 1e-3, 0.2, 1e6 * factor, 3.0, 0.57, 0.629]
        assert found == pytest.approx(expected)
