"""Patterns and slots against dense assembly; the system matrix against finite differences."""

from typing import NamedTuple

import numpy as np
import pytest

from mechanics.assembly import pattern
from mechanics.contact_laws import APPROACH
from mechanics.description import (
    Beam,
    ClearanceRevolute,
    Description,
    Distance,
    Force,
    Friction,
    Moment,
    NormalContact,
    Particle,
    Revolute,
    Site,
    Spherical,
)
from mechanics.march import DEPTH, DISSIPATIVE, FRICTION
from mechanics.system import Factors, System
from meshes.generate import line
from meshes.materials import library_material
from meshes.sections import circle, tube

X, Y, Z = np.eye(3)


# ---------------------------------------------------------------------------- pattern, slots


def random_blocks(rng, size):
    """Pairs of row and column indices, some absent, with a value for each entry."""
    made = []
    for count, rows, columns in ((7, 4, 4), (5, 3, 1), (5, 1, 6), (1, 2, 2), (0, 3, 3)):
        i = rng.integers(-1, size, (count, rows))
        j = rng.integers(-1, size, (count, columns))
        made.append((i, j, rng.standard_normal((count, rows, columns))))
    return made


def dense(size, made):
    """The same by loops."""
    A = np.zeros((size, size))
    for rows, columns, blocks in made:
        for r, c, block in zip(rows, columns, blocks, strict=True):
            for k, i in enumerate(r):
                for m, j in enumerate(c):
                    if i >= 0 and j >= 0:
                        A[i, j] += block[k, m]
    return A


@pytest.mark.parametrize("seed", range(5))
def test_scattered_blocks_equal_dense_assembly(seed):
    rng, size = np.random.default_rng(seed), 11
    made = random_blocks(rng, size)
    shape, slots = pattern(size, [(i, j) for i, j, _ in made])
    data = shape.zeros()
    for (_, _, blocks), where in zip(made, slots, strict=True):
        assert where.shape == blocks.shape
        np.add.at(data, where, blocks)
    np.testing.assert_allclose(shape.matrix(data).toarray(), dense(size, made), rtol=0, atol=1e-14)


def test_a_pattern_holds_the_entries_of_its_blocks_and_no_others():
    rng, size = np.random.default_rng(0), 11
    made = [(i, j, np.ones_like(b)) for i, j, b in random_blocks(rng, size)]
    shape, _ = pattern(size, [(i, j) for i, j, _ in made])
    A = shape.matrix(np.ones(len(shape.indices) + 1))
    assert np.array_equal(A.toarray() != 0, dense(size, made) != 0)
    assert A.nnz == np.count_nonzero(A.toarray())
    A.check_format(full_check=True)
    assert A.has_sorted_indices and shape.size == size


def test_absent_entries_go_to_the_spare_slot():
    rows = np.array([[0, -1]])
    shape, (slots,) = pattern(2, [(rows, rows)])
    data = shape.zeros()
    np.add.at(data, slots, np.array([[[3.0, 5.0], [7.0, 11.0]]]))
    assert data[-1] == 23.0
    assert np.array_equal(shape.matrix(data).toarray(), [[3.0, 0.0], [0.0, 0.0]])


# ------------------------------------------------------------------------- the system matrix

ROOM = 298.15
MATERIAL = library_material("al6061-paper")
CLEARANCE = 1e-3


def line_body(name, start, end, section, **more):
    points, axes = line(np.array(start), np.array(end), 2, np.array([0.2, 1.0, 0.3]))
    return Beam(name, points, axes, section, MATERIAL, ROOM, damping_time=1e-3, **more)


def everything():
    """Two beams, a cable and a ball; contact with friction, a drive, loads, gravity, damping."""
    tip = np.array([1.0, 0.1, 0.2])
    elbow, foot = np.array([1.2, 0.9, 0.3]), np.array([1.9, 1.2, -0.1])
    bodies = [
        line_body("arm", [0.0, 0.0, 0.0], tip, tube(0.02, 0.002)),
        line_body("strut", tip, elbow, circle(0.01)),
        line_body("rope", elbow, foot, circle(0.005), element="cable"),
        Particle("ball", np.array([2.0, 1.4, 0.2]), 2.0),
    ]
    pin = ClearanceRevolute(
        "pin", Site("arm", 0), Site(None), Z, 0.02, CLEARANCE, MATERIAL, MATERIAL, ROOM,
        NormalContact(restitution=0.7), Friction(0.3, -1e-3, ROOM, 0.05),
    )  # fmt: skip
    joints = [
        pin,
        Revolute("elbow", Site("arm", 2), Site("strut", 0), np.array([1.0, -2.0, 0.5]), np.sin),
        Spherical("knot", Site("strut", 2), Site("rope", 0)),
        Distance("rod", Site("rope", 2), Site("ball")),
    ]
    loads = [
        Moment("twist", Site("strut", 1), np.array([0.5, -1.0, 2.0]), lambda t: 40.0 + t),
        Force("pull", Site("ball"), np.array([1.0, 1.0, 0.0]), lambda t: 5.0 * t),
    ]
    return System(Description(bodies, joints, loads, np.array([0.0, 0.0, -9.81])))


class Moving(NamedTuple):
    """A system somewhere on its way; the coefficients know of a running impact."""

    system: System
    q: np.ndarray
    v: np.ndarray
    t: float
    lam: np.ndarray
    coef: tuple

    def all_forces(self, q, v, lam=None):
        """All forces but inertia, those of the constraints included, and the constraints."""
        y = self.system.unknowns(q, self.lam if lam is None else lam)
        return self.system.residual(y, self.padded(v), self.t, self.coef)

    def force(self, q, v):
        """Internal, contact and minus external force."""
        return self.all_forces(q, v, np.zeros(self.system.m))[: self.system.n]

    def constraint_force(self, q):
        y = self.system.unknowns(q, self.lam)
        return self.system.constraint_force(y, self.t, self.coef)

    def padded(self, v):
        return np.concatenate([v, np.zeros(self.system.m)])

    def matrix(self, *factors, lam=None):
        """Dense system matrix."""
        lam = self.lam if lam is None else lam
        y, v = self.system.unknowns(self.q, lam), self.padded(self.v)
        arguments = y, v, self.t, self.coef, Factors(*factors)
        return self.system.pattern.matrix(self.system.matrix(*arguments)).toarray()

    def block(self, *factors, **more):
        """Upper left block, columns times the size of their coordinates."""
        n = self.system.n
        return self.matrix(*factors, **more)[:n, :n] * self.system.scale

    def differences(self, function, x):
        """Differences of fourth order (rows, n) of a vector function, likewise."""
        columns = []
        for step in 1e-6 * np.diag(self.system.scale):
            near = function(x + step) - function(x - step)
            far = function(x + 2.0 * step) - function(x - 2.0 * step)
            columns.append((8.0 * near - far) / 12e-6)
        return np.array(columns).T


@pytest.fixture(scope="module")
def moving():
    """Everything, displaced at random and in contact."""
    system, rng = everything(), np.random.default_rng(4)
    q = system.layout.q0 + 1e-3 * system.scale * rng.standard_normal(system.n)
    v = 0.1 * system.scale * rng.standard_normal(system.n)
    journal = system.layout.node_dofs["arm"][0] + np.arange(3)
    q[journal] = [1.02 * CLEARANCE, 0.3 * CLEARANCE, 1e-6]
    v[journal] = [0.02, 0.05, 0.0]
    T = np.tile([ROOM, 0.0, 0.0], (len(system.layout.x), 1))
    T += rng.uniform(-1.0, 1.0, T.shape) * [40.0, 300.0, 300.0]
    coef, lam = system.coefficients(T), 50.0 * rng.standard_normal(system.m)
    coef[-1][:, APPROACH] = 0.2
    return Moving(system, q, v, 0.4, lam, coef)


def assert_rows_agree(actual, expected, tolerance):
    """Entries agree relative to the largest of their row."""
    largest = np.abs(expected).max(axis=1, keepdims=True)
    assert np.all(np.abs(actual - expected) <= tolerance * largest)


def test_the_contact_is_at_work(moving):
    """All parts of the contact force are there, or the tests below would not see them."""
    system, y = moving.system, moving.system.unknowns(moving.q)
    response = system.respond(y, moving.padded(moving.v), moving.coef)[0]
    assert response[DEPTH] > 0.01 * CLEARANCE
    assert abs(response[DISSIPATIVE]) > 1.0
    assert np.linalg.norm(response[FRICTION : FRICTION + 3]) > 1.0


def test_stiffness_block_is_the_derivative_of_all_forces_by_coordinates(moving):
    def forces(q):
        return moving.force(q, moving.v) + moving.constraint_force(q)

    expected = moving.differences(forces, moving.q)
    assert_rows_agree(moving.block(0.0, 1.0, 0.0), expected, 1e-6)


def test_damping_block_is_the_derivative_of_all_forces_by_velocities(moving):
    expected = moving.differences(lambda v: moving.force(moving.q, v), moving.v)
    damped = np.abs(expected).max(axis=1) > 0.0
    made = moving.block(0.0, 0.0, 1.0)
    assert damped.sum() > 0.8 * len(damped)
    assert not made[~damped].any()
    assert_rows_agree(made[damped], expected[damped], 1e-6)


def test_constraint_rows_are_the_derivative_of_the_constraints(moving):
    system, n = moving.system, moving.system.n
    A = moving.matrix(1.0, 1.0, 1.0)
    expected = moving.differences(
        lambda q: system.constraints(system.unknowns(q), moving.t, moving.coef), moving.q
    )
    assert_rows_agree(A[n:, :n] * system.scale, expected, 1e-7)
    assert np.array_equal(A[:n, n:], A[n:, :n].T)
    assert not A[n:, n:].any()


def test_constraint_force_is_their_transpose_times_the_multipliers(moving):
    n = moving.system.n
    expected = moving.matrix(0.0, 0.0, 0.0)[n:, :n].T @ moving.lam
    error = np.abs(moving.constraint_force(moving.q) - expected).max()
    assert error <= 1e-13 * np.abs(expected).max()


def test_blocks_combine_with_their_factors(moving):
    M, K, C = (moving.block(*row) for row in np.eye(3))
    mass = moving.system.mass.toarray() * moving.system.scale
    np.testing.assert_allclose(M, mass, rtol=0, atol=1e-14 * np.abs(M).max())
    expected = 2.0 * M + 3e-4 * K + 0.05 * C
    mixed = moving.block(2.0, 3e-4, 0.05)
    np.testing.assert_allclose(mixed, expected, rtol=0, atol=1e-13 * np.abs(expected).max())


def test_multipliers_bring_the_curvature_of_the_constraints(moving):
    none = np.zeros(moving.system.m)
    made = moving.block(0.0, 1.0, 0.0) - moving.block(0.0, 1.0, 0.0, lam=none)
    expected = moving.differences(moving.constraint_force, moving.q)
    # the difference of two large matrices is known to the round-off of these
    lost = 1e-15 * np.abs(moving.block(0.0, 1.0, 0.0)).max()
    assert np.abs(made - expected).max() <= 1e-6 * np.abs(expected).max() + lost


def test_forces_at_rest_are_the_gradient_of_the_stored_energies(moving):
    system, rest = moving.system, moving.padded(np.zeros(moving.system.n))
    calm = [c.copy() for c in moving.coef]
    calm[-1][:, APPROACH] = 0.0  # no impact runs: the normal force is elastic
    y, coef = system.unknowns(moving.q), tuple(calm)
    force = system.residual(y, rest, moving.t, coef)[: system.n]
    force += system.external(y, moving.t, coef)

    def stored(q):
        return np.array([system.energies(system.unknowns(q), rest, coef)[:2].sum()])

    expected = moving.differences(stored, moving.q)[0]
    assert np.abs(force * system.scale - expected).max() <= 1e-6 * np.abs(expected).max()


def test_mass_moves_everything_rigidly(moving):
    system = moving.system
    total = sum(
        body.mass if isinstance(body, Particle) else
        MATERIAL.density * body.section.area * np.linalg.norm(body.points[-1] - body.points[0])
        for body in system.layout.bodies.values()
    )  # fmt: skip
    for axis in range(3):
        shift = np.zeros(system.n)
        for nodes in system.layout.node_dofs.values():
            shift[nodes + axis] = 1.0
        assert shift @ (system.mass @ shift) == pytest.approx(total, rel=1e-12)


def test_coordinates_and_rows_are_named(moving):
    system = moving.system
    assert system.name_of(0) == "arm node 0 position x (joint pin)"
    assert system.name_of(12 + 1) == "arm node 1 position y"
    named = {system.name_of(system.n + row) for row in range(system.m)}
    assert named == {f"joint {name}" for name in ("pin", "elbow", "knot", "rod")}
