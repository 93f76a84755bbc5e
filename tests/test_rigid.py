"""Rigid bodies: exact mass, orthonormal directors, and what cannot be a body."""

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation
from slopes import expected_jacobian, force, jacobian

from mechanics import rigid
from mechanics.description import (
    Beam,
    Clamp,
    Description,
    Particle,
    Revolute,
    RigidBody,
    Site,
)
from mechanics.dynamics import Control, initial_state
from mechanics.layout import Layout
from mechanics.modes import modes
from mechanics.system import System
from meshes.materials import constant_material
from meshes.sections import rectangle

TURN = Rotation.from_rotvec([0.4, -1.2, 0.9]).as_matrix()
INERTIA = np.array([[3.0, 0.4, -0.2], [0.4, 2.5, 0.3], [-0.2, 0.3, 4.0]])


def body(inertia=INERTIA, mass=2.0, axes=TURN, name="top", **motion):
    return RigidBody(name, np.array([1.0, 2.0, 3.0]), mass, inertia, axes, **motion)


def build(*bodies):
    layout = Layout.of([Particle("first", np.zeros(3), 1.0), *bodies])
    return rigid.build(bodies, layout, layout.ndof), layout


def unknowns(layout, rows, seed=0):
    random = np.random.default_rng(seed)
    return np.concatenate([layout.q0 + 0.3 * random.standard_normal(layout.ndof),
                           random.standard_normal(rows)])  # fmt: skip


def test_kinetic_energy_is_that_of_translation_and_spin():
    velocity, spin = np.array([0.3, -2.0, 1.0]), np.array([1.0, -0.5, 2.0])
    term, layout = build(body(velocity=velocity, spin=spin))
    v = layout.v0[term.dofs[0, :12]]
    block = term.mass_blocks()[0]
    expected = 0.5 * (2.0 * velocity @ velocity + spin @ INERTIA @ spin)
    assert 0.5 * v @ block @ v == pytest.approx(expected, rel=1e-14)
    assert block.shape == (12, 12) and np.array_equal(block, block.T)


def test_euler_tensor_is_that_of_a_cloud_of_points():
    """The integral of x_i x_j over the mass, in body axes."""
    random = np.random.default_rng(3)
    points, masses = random.standard_normal((30, 3)), random.uniform(0.1, 1.0, 30)
    inertia = sum(
        m * (x @ x * np.eye(3) - np.outer(x, x)) for m, x in zip(masses, points, strict=True)
    )
    local = points @ TURN.T
    expected = np.einsum("p,pi,pj->ij", masses, local, local)
    assert rigid.euler_tensor(body(inertia)) == pytest.approx(expected, abs=1e-12)


def test_constraints_vanish_for_every_rotation_and_for_nothing_else():
    term, layout = build(body(), body(name="other"))
    assert term.rows == 12 and term.dofs.shape == (2, 18)
    y = np.concatenate([layout.q0, np.zeros(12)])
    v = np.zeros_like(y)
    y[6:15] = Rotation.from_rotvec([1.0, 2.0, -0.3]).as_matrix().ravel()
    assert force(term, y, v, term.coefficients(None)) == pytest.approx(0.0, abs=1e-15)
    stretched = y.copy()
    stretched[6:9] *= 1.1
    found = force(term, stretched, v, term.coefficients(None))[layout.ndof :]
    assert found == pytest.approx([0.105] + [0.0] * 11, abs=1e-14)


def test_tangent():
    term, layout = build(body(), body(name="other"))
    y = unknowns(layout, 12)
    coef = term.coefficients(None)
    found = jacobian(term, y, 0.0 * y, coef, -0.7, 0.4)
    expected = expected_jacobian(term, y, 0.0 * y, coef, -0.7, 0.4, layout.ndof)
    assert found == pytest.approx(expected, abs=1e-10)
    assert np.linalg.matrix_rank(found[layout.ndof :, : layout.ndof]) == 12


def test_constraint_forces_do_no_work_on_rigid_motions():
    term, layout = build(body())
    y = np.concatenate([layout.q0, np.arange(1.0, 7.0)])
    f = force(term, y, 0.0 * y, term.coefficients(None))[3:15].reshape(4, 3)
    directors = y[3:15].reshape(4, 3)[1:]
    for turn in np.eye(3):
        assert np.sum(f[1:] * np.cross(turn, directors)) == pytest.approx(0.0, abs=1e-14)
    assert not f[0].any()


@pytest.mark.parametrize("inertia", [np.diag([1.0, 2.0, 3.0]), np.diag([0.0, 2.0, 2.0])])
def test_flat_plates_and_thin_rods_have_directors_without_mass(inertia):
    moments = np.linalg.eigvalsh(rigid.euler_tensor(body(inertia, axes=np.eye(3))))
    assert moments[0] == 0.0
    found = moments.sum() * np.eye(3) - rigid.euler_tensor(body(TURN.T @ inertia @ TURN))
    assert found == pytest.approx(inertia, abs=1e-12)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        (body(np.diag([1.0, 1.0, 2.1])), "'top'.*principal moments.*2.1"),
        (body(np.diag([1.0, -1.0, 1.0])), "'top'.*principal moments"),
        (body(np.zeros((3, 3))), "'top'.*inertia"),
        (body(np.array([[1.0, 0.2, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])), "'top'.*symmetric"),
        (body(np.diag([1.0, np.nan, 1.0])), "'top'.*inertia"),
        (body(mass=0.0), "'top'.*mass must be positive"),
        (body(mass=-1.0), "'top'.*mass must be positive"),
        (body(axes=np.diag([1.0, 1.0, 1.1])), "'top'.*axes"),
    ],
)
@pytest.mark.filterwarnings("ignore:.*scalar divide", "ignore:.*in sqrt")
def test_what_is_no_body_is_refused_by_name(wrong, message):
    with pytest.raises(ValueError, match=message):
        build(wrong)


def assembled(*parts, gravity=(0.0, 0.0, 0.0)):
    bodies = [part for part in parts if isinstance(part, RigidBody | Beam)]
    joints = [part for part in parts if part not in bodies]
    system = System(Description(bodies, joints, (), np.array(gravity)))
    return system, system.coefficients(np.tile([293.15, 0.0, 0.0], (len(system.layout.x), 1)))


def started(system, coef):
    state, why = initial_state(system, Control(), coef)
    assert why == ""
    return state.motion


@pytest.mark.parametrize(
    "moments", [[1.0, 2.0, 2.5], [1.0, 2.0, 3.0]], ids=["solid body", "flat plate"]
)
def test_free_body_accelerates_as_euler_says(moments):
    """A plate has no inertia in one director; nothing else changes."""
    spin = np.array([1.0, -0.5, 2.0])
    inertia = TURN.T @ np.diag(moments) @ TURN
    motion = started(*assembled(body(inertia, spin=spin, velocity=np.array([1.0, 0.0, 0.0]))))
    directors, a = motion.q[3:].reshape(3, 3), motion.a[3:].reshape(3, 3)
    expected = np.linalg.solve(inertia, -np.cross(spin, inertia @ spin))
    assert 0.5 * np.cross(directors, a).sum(axis=0) == pytest.approx(expected, abs=1e-6)
    assert motion.a[:3] == pytest.approx(0.0, abs=1e-9)


def test_thin_rod_swings_on_a_hinge():
    """It has inertia in one director only; the hinge holds its spin."""
    rod = RigidBody("rod", np.array([0.5, 0.0, 0.0]), 3.0, np.diag([0.0, 0.25, 0.25]))
    pin = Revolute("pin", Site("rod", offset=np.array([-0.5, 0, 0])), Site(None), np.eye(3)[2])
    motion = started(*assembled(rod, pin, gravity=(0.0, -9.81, 0.0)))
    assert motion.a[1] == pytest.approx(-9.81 * 3.0 * 0.25 / (0.25 + 3.0 * 0.25), rel=1e-6)


def test_hub_with_two_flexible_appendages():
    """Frequencies against the characteristic equation of two bars on a turning hub."""
    E, side, L, R, J, density = 70e9, 2e-3, 1.0, 0.1, 1e-3, 2700.0
    material = constant_material("bar", density, E, 0.3, 0.0, 1.0, 1.0)
    hub = RigidBody("hub", np.zeros(3), 1.0, J * np.eye(3))
    parts = [hub, Revolute("pin", Site("hub"), Site(None), np.eye(3)[2])]
    for name, sign in (("left", -1.0), ("right", 1.0)):
        points = np.zeros((17, 3))
        points[:, 0] = sign * np.linspace(R, R + L, 17)
        axes = np.tile(np.diag([sign, sign, 1.0]), (17, 1, 1))
        parts.append(Beam(name, points, axes, rectangle(side, side), material, 293.15))
        root = Site("hub", offset=np.array([sign * R, 0.0, 0.0]))
        parts.append(Clamp(f"root {name}", Site(name), root))
    system, coef = assembled(*parts)
    found = modes(system, system.layout.q0, np.zeros(system.m), coef, 14)
    hub_turns = np.abs(found.shapes[4]) > 1e-3 * np.abs(found.shapes).max(axis=0)
    rates = 2.0 * np.pi * found.frequencies[hub_turns]
    EI, line = E * side**4 / 12.0, density * side**2

    def determinant(rate):
        """w = A cosh + B sinh + C cos + D sin of b x, and the turn of the hub."""
        b = (line * rate**2 / EI) ** 0.25
        ch, sh, c, s = np.cosh(b * L), np.sinh(b * L), np.cos(b * L), np.sin(b * L)
        pull = 2.0 * EI / (J * rate**2)
        return np.linalg.det([
            [1.0, 0.0, 1.0, 0.0, -R],
            [0.0, b, 0.0, b, -1.0],
            [ch, sh, -c, -s, 0.0],
            [sh, ch, s, -c, 0.0],
            [pull * b**2, -pull * R * b**3, -pull * b**2, pull * R * b**3, 1.0],
        ])  # fmt: skip

    grid = np.linspace(5.0, 1.1 * rates[3], 4000)
    values = [determinant(rate) for rate in grid]
    crossings = np.flatnonzero(np.sign(values[1:]) != np.sign(values[:-1]))
    exact = [brentq(determinant, grid[i], grid[i + 1]) for i in crossings]
    assert rates[0] == pytest.approx(0.0, abs=1e-2)
    assert len(exact) >= 3
    assert rates[1:4] == pytest.approx(exact[:3], rel=1e-4)
