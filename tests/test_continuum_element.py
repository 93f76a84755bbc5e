"""Solid elements against scikit-fem's own assembly, closed forms, and their own invariances."""

from dataclasses import replace

import numpy as np
import pytest
from continuum_cases import ALUMINIUM, COLD, distorted, free, scikit_fem
from scipy.sparse.linalg import spsolve
from scipy.spatial.transform import Rotation

from mechanics import kernels
from mechanics.continuum import von_mises
from mechanics.continuum_shapes import STIFFNESS
from mechanics.description import Continuum, Description
from mechanics.system import Factors, System
from meshes.solids import box

ELEMENTS = list(STIFFNESS)
elements = pytest.mark.parametrize("element", ELEMENTS)
E_MODULUS, NU, RHO, ALPHA = 69e9, 0.33, 2700.0, 23.1e-6


def term(made):
    return made.system.elements[0]


def stiffness(made, q=None):
    system = made.system
    y = system.unknowns(system.layout.q0 if q is None else q)
    data = system.matrix(y, 0.0 * y, 0.0, made.rest(), Factors(0.0, 1.0, 0.0))
    return system.pattern.matrix(data)


def family(element):
    return STIFFNESS[element][0]


def hot_field(x):
    return COLD + 100.0 + 200.0 * x[:, 0] - 300.0 * x[:, 1]


@pytest.mark.parametrize(("element", "order"), [("hexahedron20", 3), ("hexahedron20-full", 5)])
def test_stiffness_and_mass_are_scikit_fems(element, order):
    from skfem import BilinearForm, asm
    from skfem.helpers import dot
    from skfem.models.elasticity import lame_parameters, linear_elasticity

    mesh = distorted()
    made = free(mesh, element=element)
    basis, ours = scikit_fem(mesh, order)
    K = asm(linear_elasticity(*lame_parameters(E_MODULUS, NU)), basis)
    found = stiffness(made)[ours][:, ours]
    assert abs(found - K).max() < 1e-12 * abs(K).max()
    full, ours = scikit_fem(mesh, 5)
    M = asm(BilinearForm(lambda u, v, w: RHO * dot(u, v)), full)
    assert abs(made.system.mass[ours][:, ours] - M).max() < 1e-12 * abs(M).max()


@elements
def test_patch(element):
    """A linear displacement of the boundary gives the same stress at every point inside."""
    mesh = distorted(family=family(element))
    made = free(mesh, element=element)
    slope = 1e-6 * np.array([[1.0, 2.0, -0.5], [0.3, -1.0, 0.7], [0.2, 0.4, 1.5]])
    K, u = stiffness(made), (mesh.points @ slope.T).ravel()
    size = np.array([0.3, 0.2, 0.2])
    inside = np.all((mesh.points > 1e-9) & (mesh.points < size - 1e-9), axis=1)
    kept = np.repeat(inside, 3)
    solved = u.copy()
    solved[kept] = spsolve(K[kept][:, kept].tocsc(), -(K[kept][:, ~kept] @ u[~kept]))
    assert np.abs(solved - u).max() < 1e-11 * np.abs(u).max()
    strain = 0.5 * (slope + slope.T)
    lame = E_MODULUS * NU / ((1 + NU) * (1 - 2 * NU))
    expected = E_MODULUS / (1 + NU) * strain + lame * np.trace(strain) * np.eye(3)
    found = term(made).stresses(mesh.points.ravel() + solved, made.rest()[0])
    assert np.abs(found - expected).max() < 1e-5 * np.abs(expected).max()  # squares of strain


@pytest.mark.parametrize("counts", [(2, 2, 1), (3, 2, 1), (2, 2, 2), (4, 2, 1)])
def test_reduced_quadrature_has_rigid_motions_only(counts):
    K = stiffness(free(box(np.array(counts) * 0.01, counts, 2))).toarray()
    values = np.linalg.eigvalsh(K)
    assert np.count_nonzero(values < 1e-12 * values[-1]) == 6
    assert values[6] > 1e-5 * values[-1]


def test_a_row_of_cells_with_reduced_quadrature_is_refused():
    """It has more: 3 beside the rigid ones, which the same row with full quadrature has not."""
    mesh = box((0.04, 0.01, 0.01), (4, 1, 1), 2)
    with pytest.raises(ValueError, match="single row of cells"):
        free(mesh)
    values = np.linalg.eigvalsh(stiffness(free(mesh, element="hexahedron20-full")).toarray())
    assert np.count_nonzero(values < 1e-12 * values[-1]) == 6


@elements
def test_a_heated_body_grows_and_turns_without_stress(element):
    """Uniform, and with a linear field, of which small thermal strains are compatible."""
    made = free(distorted(family=family(element)), element=element)
    coef = made.rest(lambda x: COLD + 180.0 + 0.0 * x[:, 0])
    turn = Rotation.from_rotvec([0.1, 0.5, -0.2]).as_matrix()
    x = made.system.layout.q0.reshape(-1, 3) * (1.0 + ALPHA * 180.0) @ turn.T + [0.3, 0.1, -2.0]
    y = made.system.unknowns(x.ravel())
    force = made.system.residual(y, 0.0 * y, 0.0, coef)
    assert np.abs(force).max() < 1e-12 * E_MODULUS * 0.01
    stress = term(made).stresses(y, coef[0])
    assert von_mises(stress).max() < 1e-12 * E_MODULUS


@elements
def test_forces_turn_with_the_body(element):
    made = free(distorted(family=family(element)), element=element, damping_time=0.01)
    rng = np.random.default_rng(0)
    coef = made.rest(hot_field)
    q = made.system.layout.q0 + 1e-3 * rng.standard_normal(made.system.n)
    v = rng.standard_normal(made.system.n)
    R, spin = Rotation.from_rotvec([1.0, -2.0, 0.5]).as_matrix(), np.array([3.0, -1.0, 2.0])
    force = made.system.residual(q, v, 0.0, coef).reshape(-1, 3)
    x, w = q.reshape(-1, 3) @ R.T, v.reshape(-1, 3) @ R.T
    w = w + np.cross(spin, x) + [1.0, 2.0, 3.0]
    turned = made.system.residual(x.ravel(), w.ravel(), 0.0, coef).reshape(-1, 3)
    assert np.abs(turned - force @ R.T).max() < 1e-12 * np.abs(force).max()
    assert np.abs(force.sum(axis=0)).max() < 1e-12 * np.abs(force).max()
    assert np.abs(np.cross(q.reshape(-1, 3), force).sum(axis=0)).max() < 1e-12 * np.abs(force).max()


@elements
def test_tangent_is_the_derivative_of_the_force(element):
    made = free(box((0.02, 0.02, 0.01), (2, 2, 1), 2, family(element)), element=element,
                damping_time=1e-3)  # fmt: skip
    rng, one = np.random.default_rng(2), term(made)
    coef = made.rest(hot_field)[0]
    q = made.system.layout.q0 + 1e-4 * rng.standard_normal(made.system.n)
    v, step = rng.standard_normal((2, made.system.n))

    def force(q, v):
        out = np.zeros_like(q)
        kernels.add_force(one, q, v, coef, out)
        return out

    for cK, cC in ((1.0, 0.0), (0.0, 1.0)):
        blocks = kernels.tangent_blocks(one, q, v, coef, cK, cC)
        found = np.zeros_like(q)
        np.add.at(found, one.dofs, np.einsum("eij,ej->ei", blocks, step[one.dofs]))
        h = 1e-6 * (cK * 1e-2 + cC)
        ahead, behind = (force(q + s * h * cK * step, v + s * h * cC * step) for s in (1, -1))
        expected = (ahead - behind) / (2.0 * h)
        assert np.abs(found - expected).max() < 1e-7 * np.abs(expected).max()


@elements
def test_work_of_the_forces_is_the_change_of_energy(element):
    """f.v = dU/dt + losses - power on free strains, free strains changing and the body damped."""
    made = free(distorted(family=family(element)), element=element, damping_time=1e-3)
    rng, one, h = np.random.default_rng(3), term(made), 1e-5
    cold, hot = made.rest()[0], made.rest(hot_field)[0]
    p = one.volumes.shape[1]
    hot[:, : 2 * p] = cold[:, : 2 * p]  # moduli held, or their change would do work too
    q = made.system.layout.q0 + 1e-4 * rng.standard_normal(made.system.n)
    v = rng.standard_normal(made.system.n)

    def coefficients(t):
        return one.with_rates(cold, hot, 1.0)[0] + t * (hot - cold)

    energy = [kernels.energies(one, q + t * v, v, coefficients(0.3 + t))[0] for t in (-h, h)]
    force = np.zeros_like(q)
    kernels.add_force(one, q, v, coefficients(0.3), force)
    _, lost, on_free = kernels.energies(one, q, v, coefficients(0.3))
    # elastic power on free strains: sum of trace(elastic stress) rates
    frozen = [kernels.energies(one, q, v, coefficients(0.3 + t))[0] for t in (-h, h)]
    elastic = -(frozen[1] - frozen[0]) / (2 * h)
    change = (energy[1] - energy[0]) / (2 * h)
    assert force @ v == pytest.approx(change + elastic + lost + on_free, rel=1e-6)


def test_predicted_stress_is_that_of_the_linear_step():
    made = free(distorted())
    rng, one = np.random.default_rng(4), term(made)
    coef, q = made.rest()[0], made.system.layout.q0
    step = 1e-3 * rng.standard_normal(q.size)
    shifted = one.predicted(coef, q, step, q + step)
    p = one.volumes.shape[1]
    after, _ = one._strains(q + step, step)
    _, change = one._strains(q, step)
    assert np.allclose(after - shifted[:, 3 * p :] + coef[:, 3 * p :], after * 0 + (
        one._strains(q, step)[0] + change), atol=1e-15)  # fmt: skip


def test_equivalent_stress_of_tension_and_shear():
    tension, shear = np.diag([5.0, 0.0, 0.0]), np.zeros((3, 3))
    shear[0, 1] = shear[1, 0] = 2.0
    assert von_mises(np.stack([tension, shear])) == pytest.approx([5.0, 2.0 * np.sqrt(3.0)])


def test_inverted_cells_and_wrong_cells_are_refused():
    mesh = box((0.1, 0.1, 0.1), (2, 2, 1), 2)
    flipped = mesh.points * np.array([1.0, 1.0, -1.0])
    with pytest.raises(ValueError, match="4 cells are inverted"):
        free(replace(mesh, points=flipped))
    body = Continuum("body", mesh.points, mesh.cells["hexahedron20"], ALUMINIUM, COLD)
    with pytest.raises(ValueError, match="have 27 nodes"):
        System(Description([replace(body, element="hexahedron27")]))


@elements
def test_order_of_convergence(element):
    """The gradient of a harmonic potential needs no body force; errors fall with h^3 or faster."""
    errors = [_error(element, n) for n in (2, 4)]
    assert np.log2(errors[0] / errors[1]) > 2.7


def _error(element, n):
    """Root mean square error at the nodes inside, boundary values being exact."""
    mesh = box((1.0, 1.0, 1.0), (n, n, n), 2, family(element))
    (x, y, z), k = mesh.points.T, np.sqrt(0.5) * 3.0
    a, sy, sz = np.exp(3.0 * x), np.sin(k * y), np.sin(k * z)
    parts = 3.0 * a * sy * sz, k * a * np.cos(k * y) * sz, k * a * sy * np.cos(k * z)
    exact = 1e-3 * np.stack(parts, axis=1)
    inside = np.repeat(np.all((mesh.points > 1e-9) & (mesh.points < 1.0 - 1e-9), axis=1), 3)
    K, u = stiffness(free(mesh, element=element)), exact.ravel()
    found = spsolve(K[inside][:, inside].tocsc(), -(K[inside][:, ~inside] @ u[~inside]))
    return np.sqrt(np.mean((found - u[inside]) ** 2))
