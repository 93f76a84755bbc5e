"""Dead forces, moments, torques, gravity."""

import numpy as np
import pytest
from scipy.sparse import csr_array
from scipy.spatial.transform import Rotation
from slopes import expected_jacobian, force, jacobian

from mechanics import loads
from mechanics.description import (
    Beam,
    Description,
    Force,
    Moment,
    Particle,
    RigidBody,
    Site,
    Torque,
)
from mechanics.layout import Layout
from mechanics.system import System
from meshes.materials import constant_material
from meshes.sections import circle

STEEL = constant_material("steel", 7800.0, 210e9, 0.3, 12e-6, 16.0, 500.0)
ROD = circle(0.02)
GRAVITY = np.array([0.0, 1.5, -9.0])
TURNED = Rotation.from_rotvec([0.4, -0.2, 0.9]).as_matrix()


def member(name, element="beam3243", nodes=3, length=2.0):
    points = np.zeros((nodes, 3))
    points[:, 0] = np.linspace(0.0, length, nodes)
    axes = np.tile(np.eye(3), (nodes, 1, 1))
    return Beam(name, points, axes, ROD, STEEL, 293.15, element=element)


BODIES = [
    member("arm"),
    member("rope", "cable"),
    Particle("ball", np.ones(3), 4.0),
    RigidBody("hub", np.ones(3), 2.0, np.diag([1.0, 2.0, 2.5]), TURNED),
]


def build(*given, gravity=(0.0, 0.0, 0.0), mass=None):
    layout = Layout.of(BODIES)
    mass = csr_array((layout.ndof, layout.ndof)) if mass is None else mass
    return loads.build(given, np.array(gravity), layout, mass), layout


def timed(term, t):
    coef = term.coefficients(np.zeros((0, 3)))
    for row, column, history in term.signals:
        coef[row, column] = history(t)
    return coef


def external(terms, q, t=0.0):
    """(n,) generalised load: minus what the terms add."""
    return -sum(force(term, q, np.zeros_like(q), timed(term, t)) for term in terms)


def moved(layout, size=0.3, seed=1):
    return layout.q0 + size * np.random.default_rng(seed).standard_normal(layout.ndof)


def moments():
    return (
        Moment("one", Site("arm", 1), np.array([0.5, -2.0, 1.0]), lambda t: 10.0 * t),
        Moment("two", Site("arm", -1), np.array([0.0, 0.3, 4.0]), lambda t: 5.0 - t),
        Moment("three", Site("hub"), np.array([1.0, 0.3, 0.0]), lambda t: 2.0),
    )


def torques():
    axis = np.array([1.0, 2.0, -0.5])
    return (
        Torque("on the ground", Site("hub"), Site(None), axis, lambda t: 3.0 * t),
        Torque("from the ground", Site(None), Site("arm", 1), axis, lambda t: -t),
        Torque("between", Site("hub"), Site("arm", 1, fraction=0.3), axis, lambda t: 2.0 + t),
    )


def test_forces_act_on_the_position_of_their_node_and_add():
    terms, layout = build(
        Force("a", Site("arm", 1), np.array([1.0, 0.0, 2.0]), lambda t: 3.0 * t),
        Force("b", Site("arm", 1), np.array([0.0, 1.0, 0.0]), lambda t: 4.0),
        Force("c", Site("rope", -1), np.array([0.0, 0.0, 1.0]), lambda t: -t),
        Force("d", Site("ball"), np.array([1.0, 1.0, 0.0]), lambda t: 2.0),
    )
    expected = np.zeros(layout.ndof)
    expected[12:15] = 6.0, 4.0, 12.0
    expected[36 + 12 + 2] = -2.0
    expected[54:57] = 2.0, 2.0, 0.0
    assert external(terms, layout.q0, 2.0) == pytest.approx(expected)
    assert len(terms) == 1 and terms[0].external


@pytest.mark.parametrize(
    "site",
    [Site("hub", offset=np.array([0.3, -1.0, 0.2])), Site("arm", 1, fraction=0.3),
     Site("arm", 2, offset=np.array([0.0, 0.01, -0.02])), Site("rope", 0, fraction=0.7)],
)  # fmt: skip
def test_force_at_a_material_point_works_on_the_path_of_that_point(site):
    terms, layout = build(Force("f", site, np.array([1.0, -2.0, 0.5]), lambda t: 2.0))
    q, dq = moved(layout), moved(layout, seed=2)
    side = layout.site(site)
    step = side.weights[0] @ dq[side.vectors[:, None] + np.arange(3)]
    assert external(terms, q) @ dq == pytest.approx(np.array([2.0, -4.0, 1.0]) @ step, rel=1e-12)


def test_moment_works_on_turns_only():
    """Virtual work m.theta for turns of a stretched and sheared section, none for its stretch."""
    terms, layout = build(*moments())
    q = moved(layout)
    Q, theta = external(terms, q, 0.7), np.array([0.2, -1.0, 0.5])
    hub = layout.node_dofs["hub"][0]
    expected = (
        (18, 7.0 * np.array([0.5, -2.0, 1.0])), (30, 4.3 * np.array([0.0, 0.3, 4.0])),
        (hub + 6, np.array([2.0, 0.6, 0.0])),
    )  # fmt: skip
    for start, m in expected:
        d, f = (x[start : start + 6].reshape(2, 3) for x in (q, Q))
        assert np.sum(f * np.cross(theta, d)) == pytest.approx(m @ theta, rel=1e-12)
        assert np.sum(f * d) == pytest.approx(0.0, abs=1e-12)
        assert np.cross(d, f).sum(axis=0) == pytest.approx(m, rel=1e-12)
    assert np.count_nonzero(Q) == 18


def test_moment_keeps_its_direction_in_space():
    """Its force on a turned section is not the turned force, unless it turns as well."""
    moment = moments()[0]
    terms, layout = build(moment)
    turn = Rotation.from_rotvec([0.3, 1.0, -0.4])
    with_it, _ = build(Moment("m", moment.site, turn.apply(moment.direction), moment.amplitude))
    q = turn.apply(layout.q0.reshape(-1, 3)).ravel()
    followed = turn.apply(external(terms, layout.q0, 1.0).reshape(-1, 3)).ravel()
    assert external(with_it, q, 1.0) == pytest.approx(followed, abs=1e-12)
    assert np.abs(external(terms, q, 1.0) - followed).max() > 1.0


@pytest.mark.parametrize("torque", torques(), ids=lambda torque: torque.name)
def test_torque_follows_its_second_end_and_has_a_reaction(torque):
    """Both ends turned: the torque turns with the second; the work on common turns is zero."""
    terms, layout = build(torque)
    turn = Rotation.from_rotvec([0.3, 1.0, -0.4])
    q = turn.apply(layout.q0.reshape(-1, 3)).ravel()
    Q, t = external(terms, q, 1.5), 1.5
    direction = torque.direction
    if torque.b.body is not None:
        direction = turn.apply(direction)
    for site, sign in ((torque.a, 1.0), (torque.b, -1.0)):
        if site.body is None:
            continue
        side = layout.site(site)
        at = side.vectors[:, None] + np.arange(3)
        delta = np.array([-0.3, 0.2, 1.0])
        work = np.sum(Q[at] * np.cross(delta, q[at]))
        expected = sign * torque.amplitude(t) * direction @ delta
        assert work == pytest.approx(expected, rel=1e-12)


def test_tangents():
    given = (*moments(), *torques(), Force("f", Site("arm"), GRAVITY, lambda t: t))
    terms, layout = build(*given)
    q, zero = moved(layout, 0.2, 2), np.zeros(layout.ndof)
    for term in terms:
        coef = timed(term, 1.3)
        found = jacobian(term, q, zero, coef, -0.8, 0.3)
        expected = expected_jacobian(term, q, zero, coef, -0.8, 0.3, q.size)
        assert found == pytest.approx(expected, abs=1e-9 * max(1.0, np.abs(expected).max()))
        assert not term.symmetric or found == pytest.approx(found.T)


def test_moments_alone_and_torques_do_not_read_what_is_absent():
    """Dead force of a scene without other vectors than its own: nothing else is touched."""
    terms, layout = build(torques()[1])
    Q = external(terms, layout.q0, 2.0)
    assert np.flatnonzero(Q).min() >= 18 and np.flatnonzero(Q).max() < 24


def test_gravity_is_mass_times_acceleration():
    layout = Layout.of(BODIES)
    diagonal = np.arange(1.0, layout.ndof + 1)
    terms, layout = build(gravity=GRAVITY, mass=csr_array(np.diag(diagonal)))
    field = np.zeros(layout.ndof)
    for first in (0, 12, 24, 36, 42, 48, 54, 57):
        field[first : first + 3] = GRAVITY
    assert external(terms, layout.q0) == pytest.approx(diagonal * field)


def test_weight_of_beams_and_bodies():
    """Consistent with a cubic axis: q h/2 and q h^2/12 at each end of an element of length h."""
    terms, layout = build(gravity=GRAVITY, mass=System(Description(BODIES)).mass)
    Q = external(terms, layout.q0)
    line = STEEL.density * ROD.area
    for name, size in (("arm", 12), ("rope", 6)):
        first = layout.node_dofs[name][0]
        f = Q[first : first + 3 * size].reshape(3, size // 3, 3) / line
        ends = [GRAVITY / 2, GRAVITY / 12, GRAVITY, 0 * GRAVITY]
        assert np.array([*f[0, :2], *f[1, :2]]) == pytest.approx(np.array(ends), abs=1e-12)
        assert not f[:, 2:].any()
    assert Q[layout.node_dofs["ball"][0] :][:6] == pytest.approx([*4.0 * GRAVITY, *2.0 * GRAVITY])
    assert not Q[layout.node_dofs["hub"][0] + 3 :].any()


@pytest.mark.parametrize(
    ("load", "message"),
    [
        (Moment("m", Site("rope", 1), GRAVITY, abs), "'m'.*'rope' has none"),
        (Moment("m", Site("ball"), GRAVITY, abs), "'m'.*'ball' has none"),
        (Moment("m", Site(None), GRAVITY, abs), "'m'.*'?ground"),
        (Torque("t", Site("hub"), Site("rope"), GRAVITY, abs), "'t'.*'rope' has none"),
        (Torque("t", Site(None), Site(None), GRAVITY, abs), "'t'.*both ends are on the ground"),
        (Torque("t", Site("hub"), Site(None), 0 * GRAVITY, abs), "'t'.*no length"),
        (Force("f", Site(None), GRAVITY, abs), "'f'.*not on the ground"),
        (Force("f", Site("arm", 3), GRAVITY, abs), "3 nodes"),
        (Force("f", Site("leg"), GRAVITY, abs), "leg"),
    ],
)
def test_loads_that_cannot_act_are_refused(load, message):
    with pytest.raises(ValueError, match=message):
        build(load)
