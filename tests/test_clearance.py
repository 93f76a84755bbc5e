"""Clearance joints: tangents, virtual work, agreement with the plain laws, impacts."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from mechanics import contact, kernels
from mechanics.clearance import COEFFICIENTS, COLUMNS, build
from mechanics.description import (
    Beam,
    ClearanceRevolute,
    Friction,
    NormalContact,
    Particle,
    Site,
)
from mechanics.layout import Layout
from mechanics.march import impact_duration
from meshes.materials import constant_material, library_material

Z = np.array([0.0, 0.0, 1.0])
OBLIQUE = np.array([1.0, 2.0, -1.0]) / np.sqrt(6.0)
STEEL = constant_material("steel", 8000.0, 193e9, 0.29, 17e-6, 16.2, 500.0)
ALUMINIUM = constant_material("aluminium", 2700.0, 69e9, 0.33, 23.1e-6, 167.0, 896.0)
AMBIENT = 298.15


def beam(name, start, end, element="beam3243"):
    start, end = np.array(start, float), np.array(end, float)
    e1 = (end - start) / np.linalg.norm(end - start)
    e2 = np.cross([0.3, 1.0, 0.2], e1)
    e2 /= np.linalg.norm(e2)
    axes = np.tile([e1, e2, np.cross(e1, e2)], (2, 1, 1))
    points = np.array([start, end])
    return Beam(name, points, axes, None, None, AMBIENT, element=element)


def joint(journal, bearing, axis=OBLIQUE, radius=0.3, clearance=0.1, name="hinge", **law):
    law = {"stiffness": "hertz-external", "value": 2e3, "dissipation": "exact"} | law
    friction = law.pop("friction", Friction(0.3, regularisation_speed=0.05))
    return ClearanceRevolute(
        name, journal, bearing, axis, radius, clearance, STEEL, ALUMINIUM, AMBIENT,
        contact=NormalContact(**law), friction=friction,
    )  # fmt: skip


ARM = beam("arm", (1, 2, 3), (3, 2.5, 3.2))
BASE = beam("base", (1, 2, 3), (-1.4, 1.0, 4.0))
WIRE = beam("wire", (1, 2, 3), (1 + 2, 2 - 1, 3), element="cable")  # normal to the oblique axis
BALL = Particle("ball", np.array([1.0, 2.0, 3.0]), 2.0)
BODIES = (ARM, BASE, WIRE, BALL)
HERE = Site(None, position=np.array([1.0, 2.0, 3.0]))
PAIRS = {
    "beam in ground": (Site("arm"), HERE),
    "beam in beam": (Site("arm"), Site("base")),
    "cable in beam": (Site("wire"), Site("base")),
    "particle in beam": (Site("ball"), Site("base")),
    "particle in ground": (Site("ball"), HERE),
    "ground in beam": (HERE, Site("base")),
}
SPEED = 0.6  # approach speed [m/s]
REGIMES = {  # offset of the centre, normal and tangential speed of the centre
    "free": (0.05, 0.3, 0.2),
    "compression": (0.12, 0.4, 0.5),
    "restitution": (0.12, -0.3, 0.5),
    "creep": (0.12, 0.1, 0.01),
    "slip": (0.12, 0.1, -2.0),
    "no pull": (0.12, -5.0, 0.5),
}


def make(pair, **law):
    layout = Layout.of(BODIES, [joint(*PAIRS[pair], **law)])
    return build([joint(*PAIRS[pair], **law)], layout), layout


def temperatures(layout, journal=AMBIENT, bearing=AMBIENT):
    T = np.zeros((len(layout.x), 3))
    T[:, 0] = 250.0
    T[layout.point_index["hinge.journal"], 0] = journal
    T[layout.point_index["hinge.bearing"], 0] = bearing
    return T


def placed(pair, layout, regime, seed=3):
    """Strained bodies whose journal stands and moves as the regime says, up to the strains."""
    offset, normal, tangential = REGIMES[regime]
    rng = np.random.default_rng(seed)
    q = layout.q0 + 0.05 * rng.standard_normal(layout.ndof)
    v = 0.1 * rng.standard_normal(layout.ndof)
    out = np.cross(OBLIQUE, [0.2, 0.5, 1.0])
    out /= np.linalg.norm(out)
    along = np.cross(OBLIQUE, out)
    journal, bearing = PAIRS[pair]
    sign, site, other = (1, journal, bearing) if journal.body else (-1, bearing, journal)
    own = layout.node_dofs[site.body][site.node] + np.arange(3)
    at, speed = HERE.position, np.zeros(3)
    if other.body:
        base = layout.node_dofs[other.body][other.node] + np.arange(3)
        at, speed = q[base], v[base]
    q[own] = at + sign * offset * out
    v[own] = speed + sign * (normal * out + tangential * along)
    return q, v


def running(coef, approach):
    """Coefficients with the approach speeds of running impacts."""
    return np.column_stack([coef[:, :-1], approach])


def force(term, layout, q, v, coef, approach):
    out = np.zeros(layout.ndof)
    kernels.add_force(term, q, v, running(coef, approach), out)
    return out


def response(term, q, v, coef, approach):
    return kernels.responses(term, q, v, running(coef, approach))[0]


def tangent(term, layout, q, v, coef, approach, cK, cC):
    blocks = kernels.tangent_blocks(term, q, v, running(coef, approach), cK, cC)
    total = np.zeros((layout.ndof + 1, layout.ndof + 1))
    for dofs, block in zip(term.dofs, blocks, strict=True):
        np.add.at(total, (dofs[:, None], dofs[None]), block)
    return total[:-1, :-1]


def difference(function, x, step=1e-6):
    columns = [
        (function(x + step * e) - function(x - step * e)) / (2 * step) for e in np.eye(x.size)
    ]
    return np.stack(columns, axis=-1)


@pytest.mark.parametrize("regime", REGIMES)
@pytest.mark.parametrize("pair", PAIRS)
def test_tangents_against_finite_differences(pair, regime):
    term, layout = make(pair)
    q, v = placed(pair, layout, regime)
    coef, approach = term.coefficients(temperatures(layout)), np.array([SPEED])
    by_q = difference(lambda x: force(term, layout, x, v, coef, approach), q)
    by_v = difference(lambda x: force(term, layout, q, x, coef, approach), v)
    scale = 1.0 + np.abs(by_q).max() + np.abs(by_v).max()
    for cK, cC in ((1.0, 0.0), (0.0, 1.0), (0.3, -1.7)):
        found = tangent(term, layout, q, v, coef, approach, cK, cC)
        assert np.abs(found - cK * by_q - cC * by_v).max() < 1e-8 * scale
    touching = by_q.any() or by_v.any()
    assert touching == (regime not in ("free", "no pull"))


@pytest.mark.parametrize("regime", ["compression", "restitution", "creep", "slip"])
@pytest.mark.parametrize("pair", PAIRS)
def test_regimes_are_what_they_are_called(pair, regime):
    term, layout = make(pair)
    q, v = placed(pair, layout, regime)
    coef = term.coefficients(temperatures(layout))
    r = dict(zip(COLUMNS, response(term, q, v, coef, np.array([SPEED]))[0], strict=True))
    assert r["penetration"] > 0
    assert r["elastic_force"] + r["dissipative_force"] > 0
    assert (r["dissipative_force"] > 0) == (r["rate"] > 0)
    if regime == "restitution":
        assert r["rate"] < 0


@pytest.mark.parametrize("stiffness", ["hertz-external", "linear"])
def test_elastic_force_is_the_gradient_of_the_energy(stiffness):
    term, layout = make("beam in beam", stiffness=stiffness, friction=None)
    q, _ = placed("beam in beam", layout, "compression")
    coef, none = term.coefficients(temperatures(layout)), np.zeros(1)
    gradient = difference(lambda x: np.array(kernels.energies(term, x, 0.0 * x, coef)[0]), q)
    found = force(term, layout, q, np.zeros_like(q), coef, none)
    assert np.abs(found - gradient).max() < 1e-8 * np.abs(found).max()


@pytest.mark.parametrize("pair", ["beam in beam", "cable in beam", "particle in beam"])
def test_action_and_reaction_cancel(pair):
    """Sum of forces and of moments about the origin over both bodies."""
    term, layout = make(pair)
    q, v = placed(pair, layout, "compression")
    f = force(term, layout, q, v, term.coefficients(temperatures(layout)), np.array([SPEED]))
    vectors, forces = q.reshape(-1, 3), f.reshape(-1, 3)
    positions = np.zeros(len(vectors), dtype=bool)
    for nodes in layout.node_dofs.values():
        positions[nodes // 3] = True
    scale = np.abs(f).max()
    assert scale > 1.0
    assert np.abs(forces[positions].sum(axis=0)).max() < 1e-13 * scale
    assert np.abs(np.cross(vectors, forces).sum(axis=0)).max() < 1e-12 * scale


def test_rates_are_time_derivatives_of_the_planar_coordinates():
    term, layout = make("beam in beam")
    q, v = placed("beam in beam", layout, "slip")
    coef, none = term.coefficients(temperatures(layout)), np.zeros(1)
    h = 1e-6
    ends = [response(term, q + s * h * v, v, coef, none)[0] for s in (-1, 1)]
    here = response(term, q, v, coef, none)[0]
    assert np.allclose((ends[1] - ends[0])[:3] / (2 * h), here[3:6], atol=1e-8)
    assert (ends[1] - ends[0])[7] / (2 * h) == pytest.approx(here[8], abs=1e-8)


def test_planar_coordinates_of_a_rigid_motion():
    """Bearing and journal turned together change nothing; the journal alone turns by θ."""
    layout = Layout.of(BODIES, [joint(*PAIRS["beam in beam"])])
    term = build([joint(*PAIRS["beam in beam"])], layout)
    coef = term.coefficients(temperatures(layout))
    still = np.zeros(layout.ndof)

    def rotation(angle):
        k = np.cross(np.eye(3), OBLIQUE)
        return np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * k @ k

    def planar(bearing, journal, step):
        q = layout.q0.reshape(-1, 3) - HERE.position * (layout.scale.reshape(-1, 3) != 1.0)
        q = q @ rotation(bearing).T
        q[:8] = q[:8] @ rotation(journal).T
        q[:8:4] += step
        return response(term, q.ravel(), still, coef, np.zeros(1))[0, :3]

    out = np.cross(OBLIQUE, Z)
    y = planar(0.0, 0.0, 0.03 * out)
    assert np.hypot(*y[:2]) == pytest.approx(0.03 * np.linalg.norm(out), rel=1e-12)
    assert y[2] == pytest.approx(0.0, abs=1e-14)
    assert np.allclose(planar(0.8, 0.0, rotation(0.8) @ (0.03 * out)), y, atol=1e-14)
    for angle in (0.4, -2.5, 3.0):
        assert planar(0.7, angle, 0 * out)[2] == pytest.approx(angle, rel=1e-12)


@pytest.mark.parametrize("regime", REGIMES)
def test_response_agrees_with_the_plain_laws(regime):
    term, layout = make("beam in beam", restitution=0.6)
    q, v = placed("beam in beam", layout, regime)
    coef, approach = term.coefficients(temperatures(layout)), np.array([SPEED])
    r = dict(zip(COLUMNS, response(term, q, v, coef, approach)[0], strict=True))
    c = dict(zip(COEFFICIENTS, coef[0], strict=True))
    normal = contact.normal_force(
        c["stiffness"], 1.5, r["penetration"], r["rate"], contact.exact_factor(0.6), SPEED
    )
    n = np.array([r["y1"], r["y2"]]) / np.hypot(r["y1"], r["y2"])
    slip = n[0] * r["y2_rate"] - n[1] * r["y1_rate"] + 0.3 * r["theta_rate"]
    assert r["penetration"] == pytest.approx(np.hypot(r["y1"], r["y2"]) - 0.1, rel=1e-9)
    assert r["elastic_force"] + r["dissipative_force"] == pytest.approx(normal, rel=1e-9)
    assert r["slip_speed"] == pytest.approx(slip, rel=1e-9)
    assert r["friction_force"] == pytest.approx(
        contact.friction_force(0.3, normal, slip, 0.05), rel=1e-9
    )
    split = kernels.responses(term, q, v, running(coef, approach))[1].reshape(2, 3)
    assert np.allclose(split[0], -r["dissipative_force"] * np.append(n, 0), atol=1e-9)
    assert np.allclose(
        split[1], r["friction_force"] * np.array([-n[1], n[0], 0.3]), rtol=1e-9, atol=1e-12
    )
    rates = np.array([r["y1_rate"], r["y2_rate"], r["theta_rate"]])
    assert split[1] @ rates <= 0.0
    whole = split.sum(axis=0) - np.append(r["elastic_force"] * n, 0)
    power = -force(term, layout, q, v, coef, approach) @ v
    assert power == pytest.approx(whole @ rates, rel=1e-9, abs=1e-9)


def test_no_approach_speed_no_dissipation_and_a_given_one_overrides():
    found = {}
    for name, given, running in (
        ("none", None, 0.0), ("unmeasured", None, -1.0), ("running", None, 0.2), ("given", 0.2, 0.9)
    ):  # fmt: skip
        term, layout = make("beam in ground", reference_speed=given)
        q, v = placed("beam in ground", layout, "compression")
        coef = term.coefficients(temperatures(layout))
        found[name] = response(term, q, v, coef, np.array([running]))[0, 10]
    assert found["none"] == found["unmeasured"] == 0.0
    assert found["running"] == found["given"] > 0.0


@pytest.mark.parametrize("pair", PAIRS)
@pytest.mark.parametrize("clearance", [0.1, -0.02])
def test_centred_journal_is_harmless(pair, clearance):
    """At the centre, and with interference, forces and tangents are finite and consistent."""
    term, layout = make(pair)
    coef = term.coefficients(temperatures(layout))
    coef[0, 1] = clearance
    assert np.isfinite(
        tangent(term, layout, layout.q0, layout.v0, coef, np.ones(1), 1.0, 1.0)
    ).all()
    assert not force(term, layout, layout.q0, layout.v0, coef, np.ones(1))[:3].any()


def test_interference_holds_with_consistent_tangents():
    term, layout = make("beam in beam")
    q, v = placed("beam in beam", layout, "free")
    coef, approach = term.coefficients(temperatures(layout)), np.array([SPEED])
    coef[0, 1] = -0.02
    by_q = difference(lambda x: force(term, layout, x, v, coef, approach), q)
    found = tangent(term, layout, q, v, coef, approach, 1.0, 0.0)
    assert np.abs(by_q).max() > 1.0
    assert np.abs(found - by_q).max() < 1e-8 * np.abs(by_q).max()


@pytest.mark.parametrize("law", ["exact", "lankarani-nikravesh", "hua2026"])
@pytest.mark.parametrize("stiffness", ["hertz-external", "linear"])
def test_a_ball_rebounds_from_the_bearing_as_its_law_delivers(law, stiffness):
    term, layout = make("particle in ground", value=2e5, dissipation=law, stiffness=stiffness)
    coef, approach = term.coefficients(temperatures(layout)), np.array([0.4])
    own = layout.node_dofs["ball"][0] + np.arange(3)
    out = np.cross(OBLIQUE, Z) / np.linalg.norm(np.cross(OBLIQUE, Z))

    def motion(t, state):
        q, v = layout.q0.copy(), np.zeros(layout.ndof)
        q[own] += state[:3]
        v[own] = state[3:]
        return np.concatenate([state[3:], -force(term, layout, q, v, coef, approach)[own] / 2.0])

    def apart(t, state):
        return np.linalg.norm(state[:3]) - 0.1 if t > 0 else 1.0

    apart.terminal = True
    start = np.concatenate([(0.1 + 1e-12) * out, 0.4 * out])
    run = solve_ivp(motion, (0, 1), start, events=apart, rtol=1e-9, atol=1e-12, max_step=1e-3)
    rebound = -run.y[3:, -1] @ out / 0.4
    expected = contact.delivered_restitution(contact.DISSIPATION[law](0.85))
    assert rebound == pytest.approx(expected, rel=1e-4)


def test_coefficients_follow_both_temperatures():
    """Against the plain laws with a material whose modulus changes."""
    metal = library_material("al6061-paper")
    hinge = ClearanceRevolute(
        "hinge", Site("arm"), HERE, OBLIQUE, 25e-3, 5e-5, metal, metal, AMBIENT,
        contact=NormalContact("hertz-internal", None, "hua2026", 0.7, 0.1),
        friction=Friction(0.2, -1e-3, 300.0, 1e-6),
    )  # fmt: skip
    layout = Layout.of(BODIES, [hinge])
    term = build([hinge], layout)
    Tj, Tb = 340.0, 280.0
    c = dict(zip(COEFFICIENTS, term.coefficients(temperatures(layout, Tj, Tb))[0], strict=True))
    radius = contact.hertz_radius("hertz-internal", 25e-3, 25.05e-3)
    E, nu = metal.youngs_modulus, metal.poissons_ratio
    strain = metal.expansion.integral(AMBIENT, np.array([Tj, Tb]))
    assert c["stiffness"] == pytest.approx(
        contact.hertz_stiffness(radius, E(Tj), nu(Tj), E(Tb), nu(Tb)), rel=1e-13
    )
    assert c["clearance"] == pytest.approx(
        5e-5 + 25.05e-3 * strain[1] - 25e-3 * strain[0], rel=1e-12
    )
    assert c["clearance"] < 2e-5
    assert c["radius"] == pytest.approx(25e-3 * (1 + strain[0]), rel=1e-13)
    assert c["friction"] == pytest.approx(0.2 * (1 - 1e-3 * 10.0), rel=1e-13)
    assert c["factor"] == pytest.approx(1.5 * (1 - 0.49) / 0.7, rel=1e-13)
    assert (c["exponent"], c["reference_speed"], c["regularisation_speed"]) == (1.5, 0.1, 1e-6)


@pytest.mark.parametrize(("law", "share"), [("effusivity", 1 - 0.714035), ("product", 0.138)])
def test_partition_of_a_steel_journal_in_aluminium(law, share):
    term, layout = make("beam in ground", friction=Friction(0.1, partition=law))
    found = term.partition(temperatures(layout))
    assert found.shape == (1, 2)
    assert found[0, 0] == pytest.approx(share, abs=5e-4)
    assert found.sum() == pytest.approx(1.0, rel=1e-15)


def test_joints_are_independent_of_one_another():
    first = joint(*PAIRS["beam in ground"])
    second = joint(*PAIRS["cable in beam"], name="other", value=5e3)
    layout = Layout.of(BODIES, [first, second])
    both = build([first, second], layout)
    q, v = placed("beam in ground", layout, "compression")
    q[layout.node_dofs["wire"][0] + np.arange(3)] += 0.15 * np.cross(OBLIQUE, Z)
    T, approach = np.full((len(layout.x), 3), AMBIENT), np.array([0.5, 0.7])
    coef = both.coefficients(T)
    total = force(both, layout, q, v, coef, approach)
    whole = tangent(both, layout, q, v, coef, approach, 1.0, 1.0)
    apart, parts = np.zeros_like(total), np.zeros_like(whole)
    for j, one in enumerate((first, second)):
        term = build([one], layout)
        own = term.coefficients(T), approach[j : j + 1]
        single = tangent(term, layout, q, v, *own, 1.0, 1.0)
        assert single.any()
        apart, parts = apart + force(term, layout, q, v, *own), parts + single
    assert np.allclose(total, apart, rtol=1e-13, atol=1e-12)
    assert np.allclose(whole, parts, rtol=1e-12, atol=1e-9)
    assert both.names == ["hinge", "other"]


def test_impact_duration_is_the_closed_form():
    """Half a period of the spring; Hertz: 2.94328 d/v (Johnson 1985, eq. 11.24)."""
    assert impact_duration(2.0, 3e6, 0.1, 1.0) == pytest.approx(np.pi * np.sqrt(2.0 / 3e6))
    d = (1.25 * 0.032673 / 1.53846e10) ** 0.4
    found = impact_duration(0.032673, 1.53846e10, 1.0, 1.5)
    assert found == pytest.approx(2.94328 * d, rel=1e-5)


@pytest.mark.parametrize(
    ("law", "message"),
    [
        ({"stiffness": "rubber"}, "rubber"),
        ({"dissipation": "none"}, "none"),
        ({"stiffness": "linear", "value": None}, "needs its stiffness"),
    ],
)
def test_joints_that_cannot_be_made_name_themselves(law, message):
    with pytest.raises(ValueError, match=rf"joint 'hinge'.*{message}"):
        make("beam in ground", **law)
