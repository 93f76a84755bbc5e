"""Equilibrium paths: limit points, bifurcations, branches; loads of linear buckling."""

import numpy as np
import pytest
from scipy.linalg import eigvalsh, null_space
from scipy.sparse import csc_array, diags_array

from coupling.verify.models import ROOM, clamp, elastic, model, sections, straight
from mechanics.arclength import BIFURCATION, LIMIT, branch, follow
from mechanics.buckling import buckling
from mechanics.description import Force, Guide, Particle, RigidBody, Site, Spherical, Spring
from mechanics.eigen import lowest, negatives
from mechanics.modes import modes, stiffness
from mechanics.statics import at_rest, equilibrium
from meshes.sections import general, rectangle

X, Y, Z = np.eye(3)
HEIGHT, K = 0.2, 1e3


def bars(plane, side=0.0):
    """A roof of two springs, 2 m wide, free in ``plane``; loaded downward and, a little, aside."""
    held = [e for e in np.eye(3) if not np.any(np.all(np.atleast_2d(plane) == e, axis=1))]
    joints = [
        Guide("plane", Site("top"), np.array(held)),
        Spring("left", Site("top"), Site(None, position=-X), K),
        Spring("right", Site("top"), Site(None, position=X), K),
    ]
    push = Force("push", Site("top"), -Y + side * X, lambda s: s)
    return model(Particle("top", HEIGHT * Y, 1.0), joints, [push])


def carried(w):
    """Load in equilibrium with the height w."""
    return 2.0 * K * w * (np.hypot(1.0, HEIGHT) / np.hypot(1.0, w) - 1.0)


def path_of(made, **more):
    found = follow(made.system, made.coef, made.coef, **more)
    assert found.why == ""
    return found


def column(load=1.0, elements=8):
    """Weak in the plane x, y; loaded by ``load`` times its Euler load."""
    section = general(1e-6, 1e-13, 4e-13, 1e-13, shear_factor_2=10.0, shear_factor_3=10.0)
    unit = load * 0.25 * np.pi**2 * 1e9 * 1e-13
    press = Force("press", Site("beam", elements), -X, lambda s: s * unit)
    return model(straight(1.0, elements, section, elastic(1e9)), [clamp()], [press])


# ---------------------------------------------------------------------------------------- paths


def test_every_point_of_the_path_is_in_equilibrium():
    path = path_of(bars([Y]), arc=1e-2, largest=2e-2, until=lambda p: p.y[1] < -1.2 * HEIGHT)
    heights = np.array([p.y[1] for p in path.points])
    np.testing.assert_allclose(path.loads, carried(heights), atol=1e-9)
    assert np.all(np.diff(heights) < 0.0)


def test_snap_through_has_two_limit_points_and_is_unstable_between():
    made = bars([Y])
    path = path_of(made, arc=5e-3, largest=1e-2, until=lambda p: p.y[1] < -1.2 * HEIGHT)
    assert [e.kind for e in path.events] == [LIMIT, LIMIT]
    w = np.sqrt(np.hypot(1.0, HEIGHT) ** (2 / 3) - 1.0)
    for event, sign in zip(path.events, (1.0, -1.0), strict=True):
        assert event.point.load == pytest.approx(sign * carried(w), rel=1e-9)
        assert np.abs(event.shape[1]) == pytest.approx(made.system.scale[1])
    for point in path.points:
        assert point.unstable == int(abs(point.y[1]) < w)
        assert (point.slope < 0.0) == bool(point.unstable)


def test_load_stepping_does_not_pass_the_limit_unseen():
    """It ends beyond the snap, on the far side, or says why not; never on the unstable part."""
    made = bars([Y])
    top = Force("push", Site("top"), -Y, lambda s: 3.5 * s)
    made = model(Particle("top", HEIGHT * Y, 1.0), [
        Guide("plane", Site("top"), np.array([X, Z])),
        Spring("left", Site("top"), Site(None, position=-X), K),
        Spring("right", Site("top"), Site(None, position=X), K)], [top])  # fmt: skip
    found = equilibrium(made.system, made.coef, made.coef)
    if found.why:
        assert found.fraction == pytest.approx(3.0191474 / 3.5, abs=1e-3)
    else:
        assert found.q[1] < -HEIGHT
        assert carried(found.q[1]) == pytest.approx(3.5, rel=1e-8)


def test_a_path_may_end_at_full_load():
    path = path_of(bars([Y]), arc=1e-3, largest=1e-2)
    assert path.points[-1].load >= 1.0
    assert all(p.load < 1.0 for p in path.points[:-1])
    assert path.events == []


def test_a_high_roof_sways_before_it_snaps():
    """Across the roof's plane the pressed springs push with 2 k (L0/L - 1), two weak ones hold."""
    weak = 20.0
    joints = [
        Guide("plane", Site("top"), X[None]),
        Spring("left", Site("top"), Site(None, position=-X), K),
        Spring("right", Site("top"), Site(None, position=X), K),
        Spring("front", Site("top"), Site(None, position=HEIGHT * Y + 1e3 * Z), 0.5 * weak),
        Spring("back", Site("top"), Site(None, position=HEIGHT * Y - 1e3 * Z), 0.5 * weak),
    ]
    push = Force("push", Site("top"), -Y, lambda s: s)
    made = model(Particle("top", HEIGHT * Y, 1.0), joints, [push])
    size = made.system.scale[0]  # that of the springs in front and behind
    path = path_of(made, arc=2e-3 / size, largest=4e-3 / size, until=lambda p: p.slope < 0.0)
    L0 = np.hypot(1.0, HEIGHT)
    L = L0 / (1.0 + weak / (2.0 * K))  # 2 k (L0/L - 1) = weak
    w = np.sqrt(L * L - 1.0)
    event = path.events[0]
    assert event.kind == BIFURCATION
    assert event.point.load == pytest.approx(carried(w), rel=1e-3)
    assert np.abs(event.shape[2]) == pytest.approx(size)


def test_a_column_buckles_and_bends_either_way():
    made = column(2.0)
    path = path_of(made, arc=1e-8, largest=5e-8, until=lambda p: p.load > 0.55)
    (event,) = path.events
    assert event.kind == BIFURCATION
    assert event.point.load == pytest.approx(0.5, rel=1e-3)
    assert [p.unstable for p in path.points] == [int(p.load > 0.5) for p in path.points]
    tips = []
    for size in (0.05, -0.05):
        point, way = branch(made.system, made.coef, made.coef, event, size)
        assert point.load > event.point.load
        assert point.unstable == 0
        bent = path_of(made, arc=2e-2, largest=0.2, start=point, direction=way,
                       until=lambda p: p.load > 0.6)  # fmt: skip
        tips.append(made.position(bent.points[-1].y, "beam", 8)[1])
        assert abs(tips[-1]) > 0.4
    assert tips[0] * tips[1] < 0.0


def test_a_drive_and_a_temperature_may_be_followed_too():
    """A bar between walls: thrust E A alpha dT at each load factor."""
    bar = rectangle(0.02, 0.02)
    material = elastic(70e9, 0.3, 2700.0, 2e-5)
    ends = [clamp(), Guide("wall", Site("beam", 4), X[None])]
    made = model(straight(1.0, 4, bar, material), ends)
    hot = made.system.coefficients(sections(made.system, ROOM + 10.0))
    path = follow(made.system, made.coef, hot, arc=1e-6, largest=1e-4)
    assert path.why == ""
    last = path.points[-1]
    thrust = -70e9 * bar.area * 2e-5 * 10.0 * last.load
    wall = last.y[made.system.n :][made.system.row_names.index("wall")]
    assert abs(wall) == pytest.approx(abs(thrust), rel=1e-3)


def test_a_path_that_cannot_begin_says_so():
    made = model(Particle("top", Y, 1.0), [], [Force("push", Site("top"), Y, lambda s: s)])
    path = follow(made.system, made.coef, made.coef)
    assert "singular where the path begins" in path.why


# ---------------------------------------------------------------------------------- eigenvalues


def matrices(made):
    return stiffness(made.system, at_rest(made.system), 0.0, made.coef)


def test_lowest_eigenvalues_are_those_of_a_dense_solution():
    made = column()
    K, B = matrices(made)
    M = csc_array(diags_array(1.0 / made.system.scale**2))
    free = null_space(B.toarray())
    dense = eigvalsh(free.T @ (K @ free), free.T @ (M @ free))
    values, shapes = lowest(K, M, B, 5, made.system.scale)
    np.testing.assert_allclose(values, dense[:5], rtol=1e-5)
    np.testing.assert_allclose(shapes.T @ (M @ shapes), np.eye(5), atol=1e-8)
    many = lowest(K, M, B, 60, made.system.scale)[0]
    np.testing.assert_allclose(many, dense[:60], rtol=1e-5)


@pytest.mark.parametrize("load", [0.5, 2.0, 10.0, 60.0])
def test_signs_are_counted_as_by_a_dense_solution(load):
    """Compressed beyond the first, second, ... Euler load."""
    made = column(load, 12)
    system = made.system
    found = equilibrium(system, made.coef, made.coef, 1)
    K, B = stiffness(system, system.unknowns(found.q, found.lam), 1.0, made.coef)
    free = null_space(B.toarray())
    dense = np.count_nonzero(eigvalsh(free.T @ (K @ free)) < 0.0)
    euler = np.pi**2 / 4 * np.array([w * (2 * k + 1) ** 2 for k in range(6) for w in (1, 4)])
    assert dense == np.count_nonzero(euler < load * np.pi**2 / 4)
    assert negatives(K, B) == dense
    squares = modes(system, found.q, found.lam, made.coef, 3)
    assert squares.unstable == dense
    assert np.count_nonzero(squares.frequencies < 0.0) == min(dense, 3)


def test_joints_of_two_bodies_are_counted_too():
    """A rigid body hung on a column's end has constraints of its own."""
    ball = RigidBody("ball", X, 1e-3, 1e-3 * np.eye(3))
    beam = column().system.layout.bodies["beam"]
    joints = [clamp(), Spherical("hang", Site("beam", 8), Site("ball"))]
    made = model([beam, ball], joints)
    K, B = matrices(made)
    assert negatives(csc_array(K + 1e-6 * diags_array(np.ones(K.shape[0]))), B) == 0
    f = modes(made.system, made.system.layout.q0, np.zeros(made.system.m), made.coef, 4)
    assert np.all(f.frequencies[:3] < 1e-3 * f.frequencies[3])  # it spins freely
    assert f.unstable == 0


# ------------------------------------------------------------------------------ linear buckling


@pytest.mark.parametrize("count", [1, 3])
def test_euler_loads(count):
    """In the weak plane, in the strong one, the second in the weak."""
    made = column(1.0, 16)
    factors = buckling(made.system, made.coef, made.coef, count).factors
    np.testing.assert_allclose(factors, [1.0, 4.0, 9.0][:count], rtol=1e-4)


def test_lanczos_and_dense_solutions_agree():
    made = column(1.0, 24)
    few = buckling(made.system, made.coef, made.coef, 2)
    many = buckling(made.system, made.coef, made.coef, 80)
    np.testing.assert_allclose(few.factors, many.factors[:2], rtol=1e-5)
    for a, b in zip(few.shapes.T, many.shapes[:, :2].T, strict=True):
        assert abs(a @ b) == pytest.approx(np.linalg.norm(a) * np.linalg.norm(b), rel=1e-4)


def test_buckling_about_a_loaded_state_is_the_same():
    made = column(1.0, 8)
    half = equilibrium(made.system, made.coef, made.coef, 2)
    system = made.system
    push = column(0.6, 8)
    state = equilibrium(push.system, push.coef, push.coef, 2)
    assert half.why == state.why == ""
    # at p = 0.6 of the full load the state is that of the column loaded by 0.6
    found = buckling(system, made.coef, made.coef, 1, state.q, state.lam, 0.6)
    assert found.factors[0] == pytest.approx(1.0, rel=1e-4)


def test_from_an_unstable_state_no_buckling_is_sought():
    made = column(2.0, 8)
    state = equilibrium(made.system, made.coef, made.coef, 1)
    with pytest.raises(ValueError, match="stable"):
        buckling(made.system, made.coef, made.coef, 1, state.q, state.lam, 1.0)
