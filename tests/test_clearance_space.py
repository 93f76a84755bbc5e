"""Joints with clearance of every kind: tangents, energy, reactions, frames, power, temperature."""

from dataclasses import replace
from functools import cache
from itertools import product

import numpy as np
import pytest
from clearance_joints import (
    ACROSS,
    ALUMINIUM,
    AMBIENT,
    BODIES,
    CLEARANCE,
    ENDS,
    FRICTIONS,
    HEIGHT,
    HERTZ,
    KINDS,
    LENGTH,
    LINEAR,
    OBLIQUE,
    PLAY,
    RADIUS,
    SLOTS,
    STEEL,
    WIDTH,
    Scene,
    X,
    Y,
    difference,
    moved,
    rotation,
)

from mechanics import contact_laws as laws
from mechanics import kernels
from mechanics.clearance import build
from mechanics.description import Description, Friction, NormalContact
from mechanics.layout import Layout
from mechanics.march import (
    DEPTH,
    DEPTH_RATE,
    DISSIPATIVE,
    ELASTIC,
    FLAT,
    FRICTION,
    GAP,
    PATH,
    PATH_RATE,
    PLACE,
    SLIP,
    STUCK,
)
from mechanics.system import System

PAIRS = [("arm", "base"), ("hub", "block"), ("block", "ground"), ("ground", "arm"), ("wire", "hub"),
         ("ball", "base"), ("ball", "ground")]  # fmt: skip
POINTS_ONLY = {"planar revolute", "spherical"}
"""Kinds whose journal may be a particle."""
CASES = [
    (kind, pair) for kind, pair in product(KINDS, PAIRS)
    if pair[0] != "ball" or kind in POINTS_ONLY
]  # fmt: skip
BRISTLES = ("stick", "lugre", "rising")
HISTORY = np.array([0.01, 0.02, -0.01, 0.1, -0.2, 0.3, 0.1])
REGIMES = {  # approach speed, speed of the motion, size of the step, part of HISTORY
    "no approach": (0.0, 1.0, 0.03, 1.0),
    "impact": (10.0, 1.0, 0.03, 1.0),
    "rebound": (10.0, -1.0, 0.03, 1.0),
    "clipped": (1e-2, -1.0, 0.03, 1.0),
    "sticking": (10.0, 0.05, 0.01, 0.1),
    "sliding": (10.0, 5.0, 0.03, 1.0),
    "start": (0.0, 1.0, 0.0, 1.0),
}


def scene_in(kind, pair, law, regime, contact=HERTZ):
    scene = _scene(kind, pair, law, contact)
    approach, speed, step, part = REGIMES[regime]
    return scene.carry(approach, step, part * HISTORY), *moved(scene, speed=speed)


@cache
def _scene(kind, pair, law, contact):
    return Scene(kind, pair, law, contact)


# -------------------------------------------------------------------------------- derivatives


@pytest.mark.parametrize("law", FRICTIONS)
@pytest.mark.parametrize(("kind", "pair"), CASES, ids=lambda x: x if isinstance(x, str) else
                         " in ".join(x))  # fmt: skip
def test_tangents_against_finite_differences(kind, pair, law):
    """By positions, by velocities, and mixed; in every regime, some contacts touch."""
    for regime in REGIMES:
        scene, q, v = scene_in(kind, pair, law, regime)
        by_q = difference(lambda x, s=scene, v=v: s.force(x, v), q, scene.touched)
        by_v = difference(lambda x, s=scene, q=q: s.force(q, x), v, scene.touched)
        scale = 1.0 + np.abs(by_q).max() + np.abs(by_v).max()
        for cK, cC in ((1.0, 0.0), (0.0, 1.0), (0.3, -1.7)):
            found = scene.tangent(q, v, cK, cC)
            assert np.abs(found - cK * by_q - cC * by_v).max() < 1e-8 * scale, regime
        assert by_q.any() or regime == "clipped"


def test_the_regimes_are_met():
    """Free, compression, restitution, clipped, stick and slip; or the test above would be empty."""
    seen = {law: set() for law in FRICTIONS}
    for (kind, pair), law, regime in product(CASES, FRICTIONS, REGIMES):
        scene, q, v = scene_in(kind, pair, law, regime)
        for r in scene.response(q, v):
            force = r[ELASTIC] + r[DISSIPATIVE]
            seen[law].add("free" if r[DEPTH] <= 0.0 else "pressed")
            if r[ELASTIC] > 0.0:
                seen[law].add("clipped" if force == 0.0 else f"loss {np.sign(r[DISSIPATIVE]):+.0f}")
            if force > 0.0:
                seen[law].add("stuck" if r[STUCK] else "slipping")
    for law, found in seen.items():
        expected = {"free", "pressed", "clipped", "loss +1", "loss -1", "loss +0", "slipping"}
        assert found == expected | ({"stuck"} if law in BRISTLES else set())


def changes(scene, path, count=400):
    """Places in (0, 1) of a path where a contact begins or ends, is clipped, sticks or slides."""

    def state(s):
        r = scene.response(*path(s))
        force = r[:, ELASTIC] + r[:, DISSIPATIVE]
        return np.concatenate([r[:, ELASTIC] > 0, force > 0, r[:, STUCK] * (force > 0)]).astype(int)

    places, found = np.linspace(0.0, 1.0, count), []
    states = [state(s) for s in places]
    for i in range(count - 1):
        for which in np.flatnonzero(states[i] != states[i + 1]):
            low, high = places[i], places[i + 1]
            while high - low > 1e-13:
                middle = 0.5 * (low + high)
                same = state(middle)[which] == states[i][which]
                low, high = (middle, high) if same else (low, middle)
            found.append(low)
    return np.unique(found)


@pytest.mark.parametrize("law", FRICTIONS)
@pytest.mark.parametrize("kind", KINDS)
def test_tangents_on_both_sides_of_a_change_of_regime(kind, law):
    """On a path through many changes the derivatives on either side are those of the tangent."""
    scene = Scene(kind, ("arm", "hub"), law, LINEAR).carry(0.5, 0.03, 0.3 * HISTORY)
    q0, (q1, v1) = scene.layout.q0, moved(scene, 8, 0.07)
    v0 = moved(scene, 2)[1]
    dq, dv = q1 - q0, v1 - v0

    def path(s):
        return q0 + s * dq, v0 + s * dv

    places, bends = changes(scene, path), 0
    h, least = 1e-7, np.diff(places, prepend=0.0, append=1.0)
    for k, place in enumerate(places):
        if min(least[k], least[k + 1]) < 10 * h:
            continue
        slopes = []
        for s in (place - 2 * h, place + 2 * h):
            by_s = (scene.force(*path(s + h)) - scene.force(*path(s - h))) / (2 * h)
            found = scene.tangent(*path(s), 1.0, 0.0) @ dq + scene.tangent(*path(s), 0.0, 1.0) @ dv
            scale = 1.0 + np.abs(scene.force(*path(s))).max() + np.abs(by_s).max()
            assert np.abs(found - by_s).max() < 1e-6 * scale
            slopes.append(found)
        bends += np.abs(slopes[1] - slopes[0]).max() > 1e-3 * (1.0 + np.abs(slopes[0]).max())
    assert bends >= 1


@pytest.mark.parametrize("contact", [LINEAR, HERTZ], ids=lambda law: law.stiffness)
@pytest.mark.parametrize(("kind", "pair"), CASES)
def test_elastic_force_is_the_gradient_of_the_energy(kind, pair, contact):
    scene = Scene(kind, pair, contact=contact)
    q, v = moved(scene)
    gradient = difference(lambda x: np.array([scene.energy(x)]), q, scene.touched)[0]
    found = scene.force(q, v)
    assert np.abs(found).max() > 1.0
    assert np.abs(found - gradient).max() < 1e-8 * np.abs(found).max()


@pytest.mark.parametrize("kind", ["revolute with flanges", "cylindrical"])
def test_elastic_force_of_the_cylinder_law_is_the_gradient_of_the_energy(kind):
    """Up to its range and, at the larger displacements, beyond."""
    beyond = []
    for amount in (0.02, 0.1):
        scene = Scene(kind, ("arm", "hub"), contact=NormalContact("cylinder"))
        q, v = moved(scene, amount=amount)
        gradient = difference(lambda x, s=scene: np.array([s.energy(x)]), q, scene.touched)[0]
        found, r = scene.force(q, v), scene.response(q, v)[:2]
        assert np.abs(found - gradient).max() < 1e-7 * np.abs(found).max()
        beyond.append((r[:, DEPTH] > 0.541 * CLEARANCE).any())
    assert beyond == [False, True]


# ------------------------------------------------------------------------ mechanics of the whole


INNER = [case for case in CASES if "ground" not in case[1]]


@pytest.mark.parametrize("law", ["none", "regularised", "stick", "lugre"])
@pytest.mark.parametrize(("kind", "pair"), INNER)
def test_action_and_reaction_cancel(kind, pair, law):
    """Sum of forces, and of moments about the origin, over both bodies."""
    scene = Scene(kind, pair, law).carry(10.0, 0.03, HISTORY)
    q, v = moved(scene)
    f = scene.force(q, v)
    vectors, forces = scene.vectors(q), scene.vectors(f)
    scale = np.abs(f).max()
    assert scale > 1.0
    assert np.abs(forces[scene.positions].sum(axis=0)).max() < 1e-12 * scale
    assert np.abs(np.cross(vectors, forces).sum(axis=0)).max() < 1e-11 * scale


@pytest.mark.parametrize("law", ["regularised", "stick", "lugre"])
@pytest.mark.parametrize(("kind", "pair"), INNER)
def test_a_scene_that_is_turned_and_moved_as_a_whole_responds_alike(kind, pair, law):
    """While it turns and moves, too; forces turn with it."""
    scene = Scene(kind, pair, law).carry(10.0, 0.03, HISTORY)
    q, v = moved(scene)
    here, history, force = scene.response(q, v), scene.history(q, v), scene.force(q, v)
    turn = rotation(np.array([2.0, -1.0, 2.0]) / 3.0, 2.2)
    step, speed, spin = np.array([5.0, -3.0, 1.0]), np.array([2.0, 7.0, -4.0]), 3.0 * X - Y
    at = scene.positions[:, None]
    vectors = scene.vectors(q) @ turn.T + step * at
    rates = scene.vectors(v) @ turn.T + np.cross(spin, vectors) + speed * at
    there = scene.response(vectors.ravel(), rates.ravel())
    assert np.abs(here[:, ELASTIC]).max() > 1.0
    np.testing.assert_allclose(there, here, rtol=0, atol=1e-11 * np.abs(here).max())
    np.testing.assert_allclose(
        scene.history(vectors.ravel(), rates.ravel()), history, rtol=0, atol=1e-12
    )
    turned = scene.vectors(scene.force(vectors.ravel(), rates.ravel()))
    expected = scene.vectors(force) @ turn.T
    assert np.abs(turned - expected).max() < 1e-11 * np.abs(expected).max()


@pytest.mark.parametrize("law", FRICTIONS)
@pytest.mark.parametrize(("kind", "pair"), CASES)
def test_power_of_the_contacts(kind, pair, law):
    """f·v = Σ N δ̇ − T·V; the friction of laws without bristles takes power."""
    scene = Scene(kind, pair, law).carry(10.0, 0.03, HISTORY)
    q, v = moved(scene)
    r = scene.response(q, v)
    T, V = r[:, FRICTION : FRICTION + 3], r[:, SLIP : SLIP + 3]
    pressed = (r[:, ELASTIC] + r[:, DISSIPATIVE]) * r[:, DEPTH_RATE]
    rubbed = np.sum(T * V, axis=1)
    scale = np.abs(pressed).sum() + np.abs(rubbed).sum()
    assert scene.force(q, v) @ v == pytest.approx(pressed.sum() - rubbed.sum(), abs=1e-11 * scale)
    if law not in BRISTLES:
        assert np.all(rubbed <= 0.0)
    assert T.any() == (law != "none")


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("pair", [("arm", "base"), ("hub", "block")])
def test_rates_are_time_derivatives(kind, pair):
    scene = Scene(kind, pair)
    q, v = moved(scene)
    h = 1e-6
    back, here, ahead = (scene.response(q + s * h * v, v) for s in (-1, 0, 1))
    for column, rate, size in ((PATH, PATH_RATE, 3), (DEPTH, DEPTH_RATE, 1)):
        by_time = (ahead - back)[:, column : column + size] / (2 * h)
        assert np.abs(by_time - here[:, rate : rate + size]).max() < 1e-8


@pytest.mark.parametrize("kind", KINDS)
def test_contacts_are_where_the_path_leaves_the_gap(kind):
    scene = Scene(kind, ("hub", "block"))
    r = scene.response(*moved(scene))
    assert len(r) == SLOTS[kind] == len(scene.term.labels)
    assert set(r[:, GAP]) <= {CLEARANCE, PLAY}
    e = np.linalg.norm(r[:, PATH : PATH + 3], axis=1)
    reach = np.where(r[:, FLAT] != 0.0, r[:, PATH], e)
    np.testing.assert_allclose(r[:, DEPTH], reach - r[:, GAP], atol=1e-12)
    assert np.array_equal(r[:, ELASTIC] > 0.0, r[:, DEPTH] > 0.0)
    assert len(set(scene.term.contact_names)) == SLOTS[kind]


def test_friction_opposes_the_slip_of_the_surfaces():
    """A ball that spins in its socket while pressed: the slip is ω × R n at its surface."""
    scene = Scene("spherical", ("hub", "ground"), "regularised").carry(1.0)
    q, v = scene.layout.q0.copy(), np.zeros(scene.n)
    at = scene.layout.node_dofs["hub"][0]
    n, spin = np.array([2.0, -1.0, 2.0]) / 3.0, np.array([0.3, -0.5, 0.8])
    q[at : at + 3] += 1.1 * CLEARANCE * n
    v[at + 3 : at + 12] = np.cross(spin, scene.vectors(q)[at // 3 + 1 : at // 3 + 4]).ravel()
    r = scene.response(q, v)[0]
    # components are along the axes of the ground: b1, b2, b3 = y, z, x
    axes = np.array([[0, 1, 0], [0, 0, 1], [1, 0, 0]], float)
    np.testing.assert_allclose(r[SLIP : SLIP + 3] @ axes, RADIUS * np.cross(spin, n), atol=1e-12)
    speed = np.linalg.norm(r[SLIP : SLIP + 3])
    friction = FRICTIONS["regularised"]
    mu = friction.coefficient / (speed + friction.regularisation_speed) + friction.viscous
    expected = -mu * r[ELASTIC]
    np.testing.assert_allclose(
        r[FRICTION : FRICTION + 3], expected * r[SLIP : SLIP + 3], rtol=1e-12, atol=1e-12
    )


def test_a_tilted_pin_touches_at_both_ends_on_opposite_sides():
    """Tilted by more than 2 c/L about its middle, within the gap there: depth L/2 tan − c each."""
    scene = Scene("revolute with flanges", ("hub", "ground"))
    q = scene.layout.q0.copy()
    side = np.cross(OBLIQUE, X) / np.linalg.norm(np.cross(OBLIQUE, X))
    tilt = 0.3
    at = scene.layout.node_dofs["hub"][0]
    vectors = scene.vectors(q)[at // 3 + 1 : at // 3 + 4]
    q[at + 3 : at + 12] = (vectors @ rotation(side, tilt).T).ravel()
    r = scene.response(q, np.zeros(scene.n))
    depth = 0.5 * LENGTH * np.tan(tilt) - CLEARANCE
    assert depth > 0.0
    np.testing.assert_allclose(r[:2, DEPTH], depth, rtol=1e-9)
    np.testing.assert_allclose(r[0, PATH : PATH + 3], -r[1, PATH : PATH + 3], atol=1e-14)
    np.testing.assert_allclose(r[:2, PLACE], [-0.5 * LENGTH, 0.5 * LENGTH])
    f = scene.force(q, np.zeros(scene.n))[at : at + 3]
    flanges = r[2:, ELASTIC]
    assert flanges.any()  # and their edges touch the faces
    reach = 0.5 * LENGTH * (1.0 - np.cos(tilt)) - PLAY * np.cos(tilt) + 1.5 * RADIUS * np.sin(tilt)
    assert 0.0 < r[2:, DEPTH].max() < reach
    assert np.abs(f @ side) < 1e-9 * np.abs(r[:2, ELASTIC]).max()


# ----------------------------------------------------------------------------------- temperature


@pytest.mark.parametrize("kind", KINDS)
def test_thermal_clearance_against_free_expansion(kind):
    """Every length of the journal grows with its strain, every one of the bearing with its own."""
    scene = Scene(kind, ("hub", "block"))
    Tj, Tb = AMBIENT + 60.0, AMBIENT - 40.0
    rows = scene.term.coefficients(scene.temperatures(Tj, Tb)).reshape(-1, laws.SLOT)
    journal, bearing = 1.0 + 17e-6 * 60.0, 1.0 - 23.1e-6 * 40.0
    round_ = (RADIUS + CLEARANCE) * bearing - RADIUS * journal
    flange = (0.5 * LENGTH + PLAY) * journal - 0.5 * LENGTH * bearing
    high = (0.5 * HEIGHT + PLAY) * bearing - 0.5 * HEIGHT * journal
    wide = (0.5 * WIDTH + PLAY) * bearing - 0.5 * WIDTH * journal
    expected = {
        "planar revolute": [round_], "spherical": [round_], "cylindrical": 2 * [round_],
        "revolute with flanges": [round_, round_, *6 * [flange]],
        "planar translational": 4 * [high], "translational": 8 * [high, wide],
    }[kind]  # fmt: skip
    np.testing.assert_allclose(rows[:, laws.CLEARANCE], expected, rtol=1e-9)
    if kind in POINTS_ONLY:
        np.testing.assert_allclose(rows[:, laws.RADIUS], RADIUS * journal, rtol=1e-12)


def test_points_that_share_the_load_share_the_stiffness():
    whole = {"planar revolute": 1.0, "spherical": 1.0, "cylindrical": 0.5,
             "planar translational": 1.0, "translational": 1.0}  # fmt: skip
    for kind, part in whole.items():
        assert np.all(Scene(kind, ("hub", "block")).rows[:, laws.K] == part * HERTZ.value)
    rows = Scene("revolute with flanges", ("hub", "block")).rows[:, laws.K]
    np.testing.assert_allclose(rows, HERTZ.value * np.array([1 / 2] * 2 + [1 / 3] * 6))


@pytest.mark.parametrize("contact", [HERTZ, LINEAR], ids=lambda law: law.stiffness)
@pytest.mark.parametrize("kind", KINDS)
def test_a_seized_joint_is_pressed_all_round(kind, contact):
    """Negative clearance: at the centre forces and tangents are finite, energy is least there."""
    scene = Scene(kind, ("hub", "block"), contact=contact)
    scene.rows[:, laws.CLEARANCE] = -1e-3
    rest, still = scene.layout.q0, np.zeros(scene.n)
    force, r = scene.force(rest, still), scene.response(rest, still)
    press = contact.value * 1e-3 ** (1.5 if contact is HERTZ else 1.0)
    assert np.all(r[:, ELASTIC] > 0.3 * press)
    assert np.abs(force).max() < 1e-6 * press
    K = scene.tangent(rest, still, 1.0, 0.0)
    assert np.isfinite(K).all()
    np.testing.assert_allclose(K, K.T, atol=1e-9 * np.abs(K).max())
    at = scene.layout.node_dofs["hub"][0] + np.arange(3)
    for aside in (1e-5, 1e-3, -1e-3):
        q = rest.copy()
        q[at] += aside * ACROSS
        assert scene.energy(q) > scene.energy(rest) > 0.0
        assert scene.force(q, still)[at] @ ACROSS * aside > 0.0


@pytest.mark.parametrize("kind", KINDS)
def test_heat_deposit_is_the_work_of_friction(kind):
    scene = Scene(kind, ("hub", "block"), Friction(0.2))
    T = scene.temperatures()
    work = np.random.default_rng(0).uniform(0.0, 3.0, SLOTS[kind])
    heat = scene.term.deposit(T, work, scene.response(*moved(scene)))
    assert heat.shape == (len(T),) and np.all(heat >= 0.0)
    assert heat.sum() == pytest.approx(work.sum(), rel=1e-14)
    effusivity = [np.sqrt(m.conductivity(AMBIENT) * m.density * m.heat_capacity(AMBIENT))
                  for m in (STEEL, ALUMINIUM)]  # fmt: skip
    journal = heat[scene.layout.point_index["j.journal"]].sum()
    assert journal == pytest.approx(work.sum() * effusivity[0] / sum(effusivity), rel=1e-12)


# ---------------------------------------------------------------------------------- in all places


@pytest.mark.parametrize(
    ("journal", "bearing", "expected"), [("ball", "ground", 2.0), ("ball", "hub", 1.0)]
)
def test_mass_that_meets_in_an_impact(journal, bearing, expected):
    """Reduced mass of the ends; the ground does not give way."""
    bodies = [body for body in BODIES if body.name in (journal, bearing)]
    joint = KINDS["spherical"](ENDS[journal], ENDS[bearing], contact=HERTZ)
    system = System(Description(bodies, [joint]))
    assert system.contacts[0].masses(system.mass) == pytest.approx([expected])


@pytest.mark.parametrize("kind", KINDS)
def test_nothing_touches_in_the_reference(kind):
    for pair in PAIRS[:4]:
        scene = Scene(kind, pair)
        r = scene.response(scene.layout.q0, np.zeros(scene.n))
        np.testing.assert_allclose(r[:, DEPTH], -r[:, GAP], rtol=2e-6)
        assert not scene.force(scene.layout.q0, np.zeros(scene.n)).any()


def test_joints_of_all_kinds_in_one_system_are_independent():
    """The force of all is the sum of the forces of each."""
    pair = ENDS["hub"], ENDS["block"]
    joints = [replace(make(*pair, contact=HERTZ), name=f"j{i}") for i, make in
              enumerate(KINDS.values())]  # fmt: skip
    layout = Layout.of(BODIES, joints)
    terms = build(joints, layout)
    names = [name for term in terms for name in term.contact_names]
    assert len(names) == len(set(names)) == sum(SLOTS.values())
    assert "j1.end_1" in names and "j1.flange_2_3" in names and "j0" in names
    q, v = moved(Scene("spherical", ("hub", "block")))
    T = np.full((len(layout.x), 3), AMBIENT)
    total = np.zeros(layout.ndof)
    for term in terms:
        kernels.add_force(term, q, v, term.coefficients(T), total)
    apart = sum(Scene(kind, ("hub", "block")).force(q, v) for kind in KINDS)
    np.testing.assert_allclose(total, apart, rtol=1e-12, atol=1e-9)
