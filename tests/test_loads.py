"""Dead forces, moments fixed in space, gravity."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mechanics import loads
from mechanics.description import Beam, Description, Force, Moment, Particle, Site
from mechanics.layout import Layout
from mechanics.system import System
from meshes.materials import constant_material
from meshes.sections import circle

STEEL = constant_material("steel", 7800.0, 210e9, 0.3, 12e-6, 16.0, 500.0)
ROD = circle(0.02)
GRAVITY = np.array([0.0, 1.5, -9.0])


def member(name, element="beam3243", nodes=3, length=2.0):
    points = np.zeros((nodes, 3))
    points[:, 0] = np.linspace(0.0, length, nodes)
    axes = np.tile(np.eye(3), (nodes, 1, 1))
    return Beam(name, points, axes, ROD, STEEL, 293.15, element=element)


BODIES = [member("arm"), member("rope", "cable"), Particle("ball", np.ones(3), 4.0)]


def build(*given, gravity=(0.0, 0.0, 0.0), bodies=BODIES):
    layout = Layout.of(bodies)
    mass = System(Description(bodies)).mass
    return loads.build(given, np.array(gravity), layout, mass), layout


def external(term, q, t=0.0):
    out = np.zeros_like(q)
    term.external(q, t, out)
    return out


def moments():
    return (
        Moment("one", Site("arm", 1), np.array([0.5, -2.0, 1.0]), lambda t: 10.0 * t),
        Moment("two", Site("arm", -1), np.array([0.0, 0.3, 4.0]), lambda t: 5.0 - t),
    )


def test_forces_act_on_the_position_of_their_node_and_add():
    term, layout = build(
        Force("a", Site("arm", 1), np.array([1.0, 0.0, 2.0]), lambda t: 3.0 * t),
        Force("b", Site("arm", 1), np.array([0.0, 1.0, 0.0]), lambda t: 4.0),
        Force("c", Site("rope", -1), np.array([0.0, 0.0, 1.0]), lambda t: -t),
        Force("d", Site("ball"), np.array([1.0, 1.0, 0.0]), lambda t: 2.0),
    )
    expected = np.zeros(layout.ndof)
    expected[12:15] = 6.0, 4.0, 12.0
    expected[36 + 12 + 2] = -2.0
    expected[-3:] = 2.0, 2.0, 0.0
    assert external(term, layout.q0, 2.0) == pytest.approx(expected)
    assert term.dofs.shape == (0, 6)


def test_moment_works_on_turns_only():
    """Virtual work m.theta for turns of a stretched and sheared section, none for its stretch."""
    term, layout = build(*moments())
    q = layout.q0 + 0.3 * np.random.default_rng(1).standard_normal(layout.ndof)
    Q, theta = external(term, q, 0.7), np.array([0.2, -1.0, 0.5])
    for node, m in ((1, 7.0 * np.array([0.5, -2.0, 1.0])), (2, 4.3 * np.array([0.0, 0.3, 4.0]))):
        at = slice(12 * node + 6, 12 * node + 12)
        d, f = q[at].reshape(2, 3), Q[at].reshape(2, 3)
        assert np.sum(f * np.cross(theta, d)) == pytest.approx(m @ theta, rel=1e-12)
        assert np.sum(f * d) == pytest.approx(0.0, abs=1e-12)
        assert np.cross(d, f).sum(axis=0) == pytest.approx(m, rel=1e-12)
    assert np.count_nonzero(Q) == 12


def test_moment_keeps_its_direction_in_space():
    """Its force on a turned section is not the turned force, unless it turns as well."""
    moment = moments()[0]
    term, layout = build(moment)
    turn = Rotation.from_rotvec([0.3, 1.0, -0.4])
    with_it, _ = build(Moment("m", moment.site, turn.apply(moment.direction), moment.amplitude))
    q = turn.apply(layout.q0.reshape(-1, 3)).ravel()
    followed = turn.apply(external(term, layout.q0, 1.0).reshape(-1, 3)).ravel()
    assert external(with_it, q, 1.0) == pytest.approx(followed, abs=1e-12)
    assert np.abs(external(term, q, 1.0) - followed).max() > 1.0


def test_tangent_of_moments():
    term, layout = build(*moments(), Force("f", Site("arm"), GRAVITY, lambda t: t))
    q = layout.q0 + 0.2 * np.random.default_rng(2).standard_normal(layout.ndof)
    blocks = np.full((2, 6, 6), np.nan)
    term.tangent(q, 1.3, -0.8, blocks)
    found = np.zeros((q.size, q.size))
    for dofs, block in zip(term.dofs, blocks, strict=True):
        found[np.ix_(dofs, dofs)] += block
    step = 1e-3 * np.eye(q.size)

    def slope(scale):
        ends = [external(term, q + s * d, 1.3) for d in scale * step for s in (1, -1)]
        return (np.array(ends[::2]) - np.array(ends[1::2])).T / (2e-3 * scale)

    expected = -0.8 * (4.0 * slope(0.5) - slope(1.0)) / 3.0
    assert found == pytest.approx(expected, abs=1e-9 * np.abs(expected).max())


def test_gravity_is_the_weight_of_everything():
    term, layout = build(gravity=GRAVITY)
    Q = external(term, layout.q0)
    line = STEEL.density * ROD.area
    h = 1.0  # length of an element
    for name, node in (("arm", 12), ("rope", 6)):
        first = layout.node_dofs[name][0]
        f = Q[first : first + 3 * node].reshape(3, node // 3, 3)
        assert f[:, 0].sum(axis=0) == pytest.approx(line * 2.0 * GRAVITY, rel=1e-13)
        # consistent with a cubic axis: q h/2 and q h^2/12 at each end of an element
        ends = [GRAVITY * h / 2, GRAVITY * h**2 / 12, GRAVITY * h, 0 * GRAVITY]
        expected = line * np.array(ends)
        assert np.array([*f[0, :2], *f[1, :2]]) == pytest.approx(expected, abs=1e-12)
        assert not f[:, 2:].any()
    assert Q[-3:] == pytest.approx(4.0 * GRAVITY)


@pytest.mark.parametrize(
    ("load", "message"),
    [
        (Moment("m", Site("rope", 1), GRAVITY, abs), "'m'.*'rope' has none"),
        (Moment("m", Site("ball"), GRAVITY, abs), "'m'.*'ball' has none"),
        (Moment("m", Site(None), GRAVITY, abs), "'m'.*'ground' has none"),
        (Force("f", Site(None), GRAVITY, abs), "'f'.*not on the ground"),
        (Force("f", Site("arm", 3), GRAVITY, abs), "3 nodes"),
        (Force("f", Site("leg"), GRAVITY, abs), "leg"),
    ],
)
def test_loads_that_cannot_act_are_refused(load, message):
    with pytest.raises(ValueError, match=message):
        build(load)
