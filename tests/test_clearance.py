"""Planar clearance joint: regimes, agreement with the plain laws, rebound, coefficients."""

from itertools import product

import numpy as np
import pytest
from clearance_joints import (
    AMBIENT,
    BODIES,
    CLEARANCE,
    ENDS,
    FRICTIONS,
    HALVES,
    HERTZ,
    OBLIQUE,
    POINT,
    RADIUS,
    Scene,
    difference,
    moved,
    rotation,
)
from scipy.integrate import solve_ivp

from mechanics import contact, kernels
from mechanics import contact_laws as laws
from mechanics.clearance import build
from mechanics.description import ClearanceRevolute, Friction, NormalContact, Site
from mechanics.layout import Layout
from mechanics.march import (
    COLUMNS,
    DEPTH,
    DEPTH_RATE,
    DISSIPATIVE,
    ELASTIC,
    FRICTION,
    PATH,
    PATH_RATE,
    SLIP,
)
from meshes.materials import library_material

PAIRS = [("arm", "ground"), ("arm", "base"), ("wire", "base"), ("ball", "base"), ("ball", "ground"),
         ("ground", "base"), ("hub", "block")]  # fmt: skip
SPEED = 0.6  # approach speed [m/s]
REGIMES = {  # offset of the centre, normal and tangential speed of the centre
    "free": (0.03, 0.3, 0.2),
    "compression": (0.07, 0.4, 0.5),
    "restitution": (0.07, -0.3, 0.5),
    "creep": (0.07, 0.1, 0.01),
    "slip": (0.07, 0.1, -2.0),
    "no pull": (0.07, -5.0, 0.5),
}
OUT = np.cross(OBLIQUE, [0.2, 0.5, 1.0]) / np.linalg.norm(np.cross(OBLIQUE, [0.2, 0.5, 1.0]))


def make(pair, law="regularised", **contact):
    named = {"stiffness": "hertz-external", "value": 2e3, "dissipation": "exact"} | contact
    return Scene("planar revolute", pair, law, NormalContact(**named)).carry(SPEED)


def placed(scene, regime, seed=3):
    """Strained bodies whose journal stands and moves as the regime says, up to the strains."""
    offset, normal, tangential = REGIMES[regime]
    rng, layout = np.random.default_rng(seed), scene.layout
    q = layout.q0 + 0.02 * rng.standard_normal(layout.ndof)
    v = 0.1 * rng.standard_normal(layout.ndof)
    journal, bearing = scene.joint.journal, scene.joint.bearing
    sign, site, other = (1, journal, bearing) if journal.body else (-1, bearing, journal)
    nodes = layout.node_dofs
    own = nodes[site.body][site.node] + np.arange(3)
    away, drift = arm(scene, q, site), arm(scene, v, site)
    at, speed = POINT, np.zeros(3)
    if other.body:
        base = nodes[other.body][other.node] + np.arange(3)
        at, speed = q[base] + arm(scene, q, other), v[base] + arm(scene, v, other)
    q[own] = at - away + sign * offset * OUT
    v[own] = speed - drift + sign * (normal * OUT + tangential * np.cross(OBLIQUE, OUT))
    return q, v


def arm(scene, values, site):
    """What the offset of a site from its node is, or how fast it changes."""
    first = scene.layout.node_dofs[site.body][site.node]
    if not np.any(site.offset):
        return np.zeros(3)
    return site.offset @ values[first + 3 : first + 12].reshape(3, 3)


@pytest.mark.parametrize("pair", PAIRS)
def test_tangents_against_finite_differences(pair):
    scene = make(pair)
    for regime in REGIMES:
        q, v = placed(scene, regime)
        by_q = difference(lambda x, v=v: scene.force(x, v), q, scene.touched)
        by_v = difference(lambda x, q=q: scene.force(q, x), v, scene.touched)
        scale = 1.0 + np.abs(by_q).max() + np.abs(by_v).max()
        for cK, cC in ((1.0, 0.0), (0.0, 1.0), (0.3, -1.7)):
            found = scene.tangent(q, v, cK, cC)
            assert np.abs(found - cK * by_q - cC * by_v).max() < 1e-8 * scale
        assert (by_q.any() or by_v.any()) == (regime not in ("free", "no pull"))


@pytest.mark.parametrize(
    ("pair", "regime"), [*product(PAIRS, ["compression", "restitution", "creep", "slip"])]
)
def test_regimes_are_what_they_are_called(pair, regime):
    scene = make(pair)
    r = scene.response(*placed(scene, regime))[0]
    assert r[DEPTH] > 0
    assert r[ELASTIC] + r[DISSIPATIVE] > 0
    assert (r[DISSIPATIVE] > 0) == (r[DEPTH_RATE] > 0)
    if regime == "restitution":
        assert r[DEPTH_RATE] < 0


def test_planar_coordinates_of_a_rigid_motion():
    """Bearing and journal turned together change nothing; nor does the journal turned alone."""
    scene = make(("arm", "base"))
    layout, still = scene.layout, np.zeros(scene.n)
    at, own = layout.node_dofs["arm"], slice(0, 8)
    assert at[0] == 0 and layout.node_dofs["base"][0] == 24

    def planar(bearing, journal, step):
        q = layout.q0.reshape(-1, 3) - POINT * scene.positions[:, None]
        q = q @ rotation(OBLIQUE, bearing).T
        q[own] = q[own] @ rotation(OBLIQUE, journal).T
        q[own][::4] += step
        return scene.response(q.ravel(), still)[0, PATH : PATH + 3]

    y = planar(0.0, 0.0, 0.03 * OUT)
    assert np.hypot(*y[:2]) == pytest.approx(0.03, rel=1e-12) and y[2] == 0.0
    planes = scene.term.planes[0]
    np.testing.assert_allclose(y[:2], 0.03 * planes @ OUT, atol=1e-15)
    for journal in (0.0, 0.4, -2.5, 3.0):
        turned = planar(0.8, journal, rotation(OBLIQUE, 0.8) @ (0.03 * OUT))
        np.testing.assert_allclose(turned, y, atol=1e-14)


@pytest.mark.parametrize("regime", REGIMES)
def test_response_agrees_with_the_plain_laws(regime):
    """A rigid journal that stands upright: slip is that of its rim, in the plane and along it."""
    scene = make(("hub", "ground"), Friction(0.3, regularisation_speed=0.05), restitution=0.6)
    offset, normal_speed, tangential = REGIMES[regime]
    q, v = scene.layout.q0.copy(), np.zeros(scene.n)
    at, spin = scene.layout.node_dofs["hub"][0], 0.7
    planes = scene.term.planes[0]
    n, along = OUT, np.cross(OBLIQUE, OUT)
    q[at : at + 3] += offset * OUT
    v[at : at + 3] = normal_speed * n + tangential * along
    v[at + 3 : at + 12] = np.cross(spin * OBLIQUE, scene.vectors(q)[at // 3 + 1 : at // 3 + 4]
                                   ).ravel()  # fmt: skip
    r = scene.response(q, v)[0]
    force = contact.normal_force(
        2e3, 1.5, offset - CLEARANCE, normal_speed, contact.exact_factor(0.6), SPEED
    )
    slip = tangential + RADIUS * spin
    np.testing.assert_allclose(r[PATH : PATH + 2], offset * planes @ n, rtol=1e-9)
    np.testing.assert_allclose(
        r[PATH_RATE : PATH_RATE + 2], planes @ v[at : at + 3], rtol=1e-9, atol=1e-12
    )
    assert r[DEPTH] == pytest.approx(offset - CLEARANCE, rel=1e-9)
    assert r[DEPTH_RATE] == pytest.approx(normal_speed, rel=1e-9)
    assert r[ELASTIC] + r[DISSIPATIVE] == pytest.approx(force, rel=1e-9)
    axes = np.array([*planes, OBLIQUE])
    np.testing.assert_allclose(r[SLIP : SLIP + 3] @ axes, slip * along, rtol=1e-9, atol=1e-12)
    rubbed = contact.friction_force(0.3, force, slip, 0.05)
    np.testing.assert_allclose(
        r[FRICTION : FRICTION + 3] @ axes, rubbed * along, rtol=1e-9, atol=1e-12
    )
    found = -scene.force(q, v)[at : at + 3]
    np.testing.assert_allclose(found, rubbed * along - force * n, rtol=1e-8, atol=1e-9)
    power = -scene.force(q, v) @ v
    assert power == pytest.approx(rubbed * slip - force * normal_speed, rel=1e-9, abs=1e-9)


def test_no_approach_speed_no_dissipation_and_a_given_one_overrides():
    found = {}
    for name, given, running in (
        ("none", None, 0.0), ("unmeasured", None, -1.0), ("running", None, 0.2), ("given", 0.2, 0.9)
    ):  # fmt: skip
        scene = make(("arm", "ground"), reference_speed=given).carry(running)
        found[name] = scene.response(*placed(scene, "compression"))[0, DISSIPATIVE]
    assert found["none"] == found["unmeasured"] == 0.0
    assert found["running"] == found["given"] > 0.0


def test_a_contact_that_does_not_act_tells_where_it_is_and_makes_no_force():
    scene = make(("arm", "base"))
    q, v = placed(scene, "compression")
    acting = scene.response(q, v)[0]
    scene.rows[:, laws.ACTIVE] = 0.0
    flying = scene.response(q, v)[0]
    assert not scene.force(q, v).any() and not scene.tangent(q, v, 1.0, 1.0).any()
    assert acting[ELASTIC] > 0.0 and not flying[ELASTIC:SLIP].any()
    np.testing.assert_array_equal(flying[: DEPTH_RATE + 1], acting[: DEPTH_RATE + 1])
    assert scene.energy(q) == 0.0


@pytest.mark.parametrize("pair", PAIRS)
@pytest.mark.parametrize("clearance", [0.1, -0.02])
def test_centred_journal_is_harmless(pair, clearance):
    """At the centre, and with interference, forces and tangents are finite and consistent."""
    scene = make(pair)
    scene.rows[:, laws.CLEARANCE] = clearance
    q, v = scene.layout.q0, scene.layout.v0
    spinning = moved(scene, speed=1e-3)[1]
    for velocity in (v, spinning):
        assert np.isfinite(scene.tangent(q, velocity, 1.0, 1.0)).all()
        assert np.isfinite(scene.force(q, velocity)).all()
    assert np.abs(scene.force(q, v)).max() < 1e-6
    by_q = difference(lambda x: scene.force(x, v), q, scene.touched, 1e-10)
    assert np.abs(scene.tangent(q, v, 1.0, 0.0) - by_q).max() <= 1e-4 * np.abs(by_q).max()


def test_interference_holds_with_consistent_tangents():
    scene = make(("arm", "base"))
    q, v = placed(scene, "free")
    scene.rows[:, laws.CLEARANCE] = -0.02
    by_q = difference(lambda x: scene.force(x, v), q, scene.touched)
    found = scene.tangent(q, v, 1.0, 0.0)
    assert np.abs(by_q).max() > 1.0
    assert np.abs(found - by_q).max() < 1e-8 * np.abs(by_q).max()


@pytest.mark.parametrize("clearance", [-1e-3, -0.02])
def test_a_seized_pin_resists_rotation_and_sideways_motion(clearance):
    """Moment mu K |c|^1.5 R against a pin that turns in its middle; 3 K |c|^1/2 sideways."""
    scene = make(("hub", "block"))
    scene.rows[:, laws.CLEARANCE] = clearance
    scene.rows[:, laws.CORE] = -clearance / 3.0
    scene.rows[:, laws.APPROACH] = 0.0
    q, rate, K = scene.layout.q0, 50.0, scene.rows[0, laws.K]
    own = scene.layout.node_dofs["hub"][0] + np.arange(12)
    vectors = q[own].reshape(4, 3) - np.outer([1.0, 0.0, 0.0, 0.0], POINT)
    v = np.zeros(scene.n)
    v[own] = np.cross(rate * OBLIQUE, vectors).ravel()
    moment = -scene.force(q, v) @ v / rate
    slip = rate * scene.rows[0, laws.RADIUS]
    mu = scene.rows[0, laws.KINETIC] * slip / (slip + scene.rows[0, laws.EPS])
    mu += scene.rows[0, laws.VISCOUS] * slip
    press = K * abs(clearance) ** 1.5
    assert moment == pytest.approx(-mu * press * scene.rows[0, laws.RADIUS], rel=1e-9)
    aside, part = q.copy(), 1e-6 * abs(clearance)
    aside[own[:3]] += part * OUT
    push = scene.force(aside, 0.0 * v)[own[:3]] @ OUT / part
    assert push == pytest.approx(3.0 * K * np.sqrt(abs(clearance)), rel=1e-4)


@pytest.mark.parametrize("law", ["exact", "lankarani-nikravesh", "hua2026"])
@pytest.mark.parametrize("stiffness", ["hertz-external", "linear"])
def test_a_ball_rebounds_from_the_bearing_as_its_law_delivers(law, stiffness):
    scene = make(("ball", "ground"), value=2e5, dissipation=law, stiffness=stiffness).carry(0.4)
    own = scene.layout.node_dofs["ball"][0] + np.arange(3)

    def motion(t, state):
        q, v = scene.layout.q0.copy(), np.zeros(scene.n)
        q[own] += state[:3]
        v[own] = state[3:]
        return np.concatenate([state[3:], -scene.force(q, v)[own] / 2.0])

    def apart(t, state):
        return np.linalg.norm(state[:3]) - CLEARANCE if t > 0 else 1.0

    apart.terminal = True
    start = np.concatenate([(CLEARANCE + 1e-12) * OUT, 0.4 * OUT])
    run = solve_ivp(motion, (0, 1), start, events=apart, rtol=1e-9, atol=1e-12, max_step=1e-3)
    rebound = -run.y[3:, -1] @ OUT / 0.4
    expected = contact.delivered_restitution(contact.DISSIPATION[law](0.85))
    assert rebound == pytest.approx(expected, rel=1e-4)


def test_coefficients_follow_both_temperatures():
    """Against the plain laws with a material whose modulus changes."""
    metal = library_material("al6061-paper")
    hinge = ClearanceRevolute(
        "j", Site("arm"), ENDS["ground"], OBLIQUE, 25e-3, 5e-5, metal, metal, AMBIENT,
        contact=NormalContact("hertz-internal", None, "hua2026", 0.7, 0.1),
        friction=Friction(0.2, -1e-3, 300.0, 1e-6),
    )  # fmt: skip
    layout = Layout.of(BODIES, [hinge])
    Tj, Tb = 340.0, 280.0
    c = build([hinge], layout)[0].coefficients(make(("arm", "ground")).temperatures(Tj, Tb))[0]
    radius = contact.hertz_radius("hertz-internal", 25e-3, 25.05e-3)
    E, nu = metal.youngs_modulus, metal.poissons_ratio
    strain = metal.expansion.integral(AMBIENT, np.array([Tj, Tb]))
    assert c[laws.K] == pytest.approx(
        contact.hertz_stiffness(radius, E(Tj), nu(Tj), E(Tb), nu(Tb)), rel=1e-13
    )
    assert c[laws.CLEARANCE] == pytest.approx(
        5e-5 + 25.05e-3 * strain[1] - 25e-3 * strain[0], rel=1e-12
    )
    assert c[laws.CLEARANCE] < 2e-5
    assert c[laws.RADIUS] == pytest.approx(25e-3 * (1 + strain[0]), rel=1e-13)
    assert c[laws.KINETIC] == pytest.approx(0.2 * (1 - 1e-3 * 10.0), rel=1e-13)
    assert c[laws.STATIC] == c[laws.KINETIC]
    assert c[laws.FACTOR] == pytest.approx(1.5 * (1 - 0.49) / 0.7, rel=1e-13)
    assert (c[laws.P], c[laws.REFERENCE], c[laws.EPS]) == (1.5, 0.1, 1e-6)
    assert (c[laws.LAW], c[laws.FRICTION]) == (laws.POWER, laws.REGULARISED)


@pytest.mark.parametrize(("law", "share"), [("effusivity", 1 - 0.714035), ("product", 0.138)])
def test_partition_of_a_steel_journal_in_aluminium(law, share):
    scene = make(("arm", "ground"), Friction(0.1, partition=law))
    found = scene.term.partition(scene.temperatures())
    assert found.shape == (1, 2)
    assert found[0, 0] == pytest.approx(share, abs=5e-4)
    assert found.sum() == pytest.approx(1.0, rel=1e-15)


def test_joints_are_independent_of_one_another():
    joints = [
        ClearanceRevolute(
            name, ENDS[journal], ENDS[bearing], OBLIQUE, RADIUS, CLEARANCE, *HALVES,
            contact=HERTZ, friction=FRICTIONS["regularised"],
        )
        for name, journal, bearing in (("j", "arm", "ground"), ("other", "wire", "base"))
    ]  # fmt: skip
    scene, other = (make(p, restitution=0.8) for p in (("arm", "ground"), ("wire", "base")))
    q, v = placed(scene, "compression")
    q[scene.layout.node_dofs["wire"][0] + np.arange(3)] += 0.15 * OUT
    layout = Layout.of(BODIES, joints)
    (both,) = build(joints, layout)
    assert both.names == ["j", "other"] == both.contact_names
    coef = both.coefficients(np.full((len(layout.x), 3), AMBIENT))
    coef[:, laws.APPROACH] = 0.5, 0.7
    total = np.zeros(layout.ndof)
    kernels.add_force(both, q, v, coef, total)
    parts = [s.carry(a).force(q, v) for s, a in ((scene, 0.5), (other, 0.7))]
    assert all(part.any() for part in parts)
    np.testing.assert_allclose(total, sum(parts), rtol=1e-13, atol=1e-12)
    r = kernels.responses(both, q, v, coef, COLUMNS)
    np.testing.assert_allclose(r, np.concatenate([s.response(q, v) for s in (scene, other)]))
    whole = kernels.tangent_blocks(both, q, v, coef, 1.0, 1.0)
    for block, s in zip(whole, (scene, other), strict=True):
        alone = kernels.tangent_blocks(s.term, q, v, s.coef, 1.0, 1.0)[0]
        assert np.abs(block).sum() == pytest.approx(np.abs(alone).sum(), rel=1e-12)


@pytest.mark.parametrize(
    ("law", "message"),
    [
        ({"stiffness": "rubber"}, "rubber"),
        ({"dissipation": "none"}, "none"),
        ({"stiffness": "linear", "value": None}, "needs its stiffness"),
        ({"stiffness": "cylinder", "value": None}, "needs the length"),
    ],
)
def test_joints_that_cannot_be_made_name_themselves(law, message):
    with pytest.raises(ValueError, match=rf"joint 'j'.*{message}"):
        make(("arm", "ground"), **law)


def test_an_unknown_friction_law_names_its_joint():
    with pytest.raises(ValueError, match=r"joint 'j'.*glue"):
        make(("arm", "ground"), Friction(0.1, law="glue"))
