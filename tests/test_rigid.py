"""Rigid bodies: exact mass, orthonormal directors, and what cannot be a body."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from slopes import expected_jacobian, force, jacobian

from mechanics import rigid
from mechanics.description import Particle, RigidBody
from mechanics.layout import Layout

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
