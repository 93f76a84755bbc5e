"""Fully parametrised shell: what the cure changes against the continuum taken literally."""

import numpy as np
import pytest
from shell_cases import case, force, relax, stiffness
from test_thick_shells import flat

from mechanics import kernels, shell3443, traction
from mechanics.description import Shell, Traction
from mechanics.layout import Layout
from meshes.materials import constant_material
from meshes.surfaces import annulus, patch, plate

E, NU, H = 70e9, 0.3, 0.05
D = E * H**3 / 12 / (1 - NU**2)
SOFT = constant_material("m", 1.0, 1e9, 0.0, 0.0, 1.0, 1.0)
both = pytest.mark.parametrize("family", ["shell3443", "naive"])


def skewed():
    """Parallelograms of uneven sizes: x = u + 0.3 v, y = 0.9 v."""

    def shape(u, v):
        o = np.zeros_like(u)
        r_u, r_v = np.stack([o + 1, o, o], axis=1), np.stack([o + 0.3, o + 0.9, o], axis=1)
        return u[:, None] * r_u + v[:, None] * r_v, r_u, r_v, 0.0 * r_u

    return patch(shape, np.array([0.0, 0.3, 0.8, 1.2]), np.array([0.0, 0.35, 0.6, 1.0]))


AREA = 1.2 * 0.9


def inner(c):
    return np.concatenate([c.at([5, 6, 9, 10], vector) for vector in range(4)])


@both
def test_energy_of_constant_green_strains_of_any_size(family):
    """On parallelograms; all of r_u, r_v, r_n follow."""
    c = case(family, skewed(), H)
    F = np.array([[1.1, 0.2, 0.0], [-0.1, 0.9, 0.1], [0.3, 0.1, 1.05]])
    q = (c.vectors(c.q) @ F.T).ravel()
    strain = 0.5 * (F.T @ F - np.eye(3))
    lam, mu = E * NU / (1 + NU) / (1 - 2 * NU), E / 2 / (1 + NU)
    weights = mu * np.array([[1.0, 1.0, 5 / 6], [1.0, 1.0, 5 / 6], [5 / 6, 5 / 6, 1.0]])
    density = 0.5 * lam * np.trace(strain) ** 2 + np.sum(weights * strain**2)
    energy = kernels.energies(c.term, q, 0 * q, c.coef)[0]
    assert energy == pytest.approx(density * AREA * H, rel=1e-12)


@both
def test_constant_plane_stress_of_any_size(family):
    """Inner nodes stay in equilibrium where r_n lets the thickness shrink."""
    c = case(family, skewed(), H)
    F = np.array([[1.1, 0.2, 0.0], [-0.1, 0.9, 0.0], [0.3, 0.1, 0.0]])
    normal = np.cross(F[:, 0], F[:, 1])
    across = -NU / (1 - NU) * 0.5 * (np.sum(F**2) - 2.0)
    F[:, 2] = np.sqrt(1.0 + 2.0 * across) * normal / np.linalg.norm(normal)
    f = force(c, (c.vectors(c.q) @ F.T).ravel(), c.coef)
    assert np.abs(f[inner(c)]).max() < 1e-12 * np.abs(f).max()


@pytest.mark.parametrize("kappa", [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)])
def test_constant_bending_and_twist_on_parallelograms(kappa):
    c = case("shell3443", skewed(), H)
    a, b, t = kappa
    x, y = c.vectors(c.q)[:, 0, :2].T
    w = 0.5 * (a * x**2 + b * y**2) + t * x * y
    w_x, w_y = a * x + t * y, b * y + t * x
    u = flat(c, w, w_x, w_y, -np.stack([w_x, w_y], axis=1))
    f = stiffness(c, c.q, c.coef) @ u
    assert np.abs(f[inner(c)]).max() < 1e-11 * np.abs(f).max()
    expected = 0.5 * D * (a**2 + b**2 + 2 * (1 - NU) * t**2) * AREA
    assert 0.5 * u @ f == pytest.approx(expected, rel=1e-9)


def test_the_continuum_is_stiffened_by_poissons_effect():
    """Bending without swelling: lambda + 2 mu in place of E/(1 - nu^2)."""
    c = case("naive", skewed(), H)
    x = c.vectors(c.q)[:, 0, 0]
    u = flat(c, 0.5 * x**2, x, 0 * x, -np.stack([x, 0 * x], axis=1))
    energy = 0.5 * u @ (stiffness(c, c.q, c.coef) @ u)
    stiffer = (1 - NU) / (1 + NU) / (1 - 2 * NU) * (1 - NU**2)
    assert energy == pytest.approx(0.5 * stiffer * D * AREA, rel=1e-9)


def test_only_rigid_motions_are_free_of_energy():
    """The slopes r_u, r_v of the nodes are not loose, in a single element either."""
    c = case("shell3443", plate(1.0, 0.8, 1, 1), 0.1)
    values = np.linalg.eigvalsh(stiffness(c, c.q, c.coef).toarray())
    assert np.abs(values[:6]).max() < 1e-13 * values[-1] and values[6] > 1e-9 * values[-1]


def test_shapes_carry_position_and_slopes():
    """At each node one of the cubics, or its slope, is 1 and all others 0."""
    for node, (xi, eta) in enumerate(shell3443.CORNERS):
        expected = np.zeros((3, 16))
        expected[[0, 1, 2], [4 * node, 4 * node + 1, 4 * node + 2]] = 1.0
        assert shell3443.shape(xi, eta) == pytest.approx(expected, abs=1e-14)


def test_thin_cantilever():
    """Tip load against F l^3/(3 EI) (1 - 1/(4 n^2)) for h = l/1000, n = 6 elements."""
    h = 1e-3
    c = case("shell3443", plate(1.0, 0.2, 6, 1), h, SOFT)
    free = np.arange(24, c.q.size)
    f, u = np.zeros_like(c.q), np.zeros_like(c.q)
    f[c.at([12, 13], 0, 2)] = 0.5 * 1e9 * 0.2 * h**3 / 12
    u[free] = np.linalg.solve(stiffness(c, c.q, c.coef).toarray()[np.ix_(free, free)], f[free])
    assert 3.0 * u[c.at([12], 0, 2)][0] == pytest.approx(1.0, rel=1e-2)


@pytest.mark.parametrize(
    ("family", "lower", "upper"), [("shell3443", -3e-3, 3e-2), ("naive", -1, -0.1)]
)
def test_large_bending_of_a_cantilever(family, lower, upper):
    """Sze, Liu & Lo (2004): end shear P = 4, W 6.698, -U 3.286; 8 elements."""
    c = case(family, plate(10.0, 1.0, 8, 1), 0.1, constant_material("m", 1, 1.2e6, 0.0, 0, 1, 1))
    load = np.zeros_like(c.q)
    load[c.at([16, 17], 0, 2)] = 2.0
    moved = relax(c, c.coef, load, np.arange(24), steps=8) - c.q
    errors = np.array([moved[c.at(16, 0, 2)][0] / 6.698, -moved[c.at(16, 0, 0)][0] / 3.286]) - 1.0
    assert lower < errors.min() and errors.max() < upper


@pytest.mark.parametrize(
    ("family", "lower", "upper"), [("shell3443", 0.98, 1.005), ("naive", 0, 0.7)]
)
def test_slit_annulus(family, lower, upper):
    """Sze, Liu & Lo (2004): half the load, W_A 10.468, W_B 13.768; 2 x 16 elements."""
    material = constant_material("m", 1.0, 21e6, 0.0, 0.0, 1.0, 1.0)
    c = case(family, annulus(6.0, 10.0, 2, 16), 0.03, material)
    nodes = np.arange(3 * 17).reshape(3, 17)
    load = np.zeros_like(c.q)
    np.add.at(load, c.at([nodes[:-1, -1], nodes[1:, -1]], 0, 2), 0.4)
    fixed = np.concatenate([c.at(nodes[:, 0], vector) for vector in range(4)])
    q = relax(c, c.coef, load, fixed, steps=10)
    for found, known in zip(q[c.at(nodes[[0, -1], -1], 0, 2)], (10.468, 13.768), strict=True):
        assert lower < found / known < upper


def test_consistent_loads_of_a_surface_and_an_edge():
    """The work of a uniform load on a rigid motion is its resultant and its moment."""
    surface = plate(1.0, 0.6, 3, 2)
    metal = constant_material("m", 1.0, 1.0, 0.3, 0.0, 1.0, 1.0)
    body = Shell("s", surface, 0.01, metal, 298.15, element="shell3443")
    layout = Layout.of([body])
    nodes = np.flatnonzero(np.abs(surface.points[:, 0] - 1.0) < 1e-12)
    edge = tuple(int(n) for n in nodes[np.argsort(surface.points[nodes, 1])])
    for place, size, arm in ((None, 0.6, 0.5), (edge, 0.6, 1.0)):
        more = {} if place is None else {"edge": place}
        load = Traction("t", "s", np.array([0.0, 0.0, 2.0]), lambda t: 1.0, **more)
        term = traction.build([load], layout)
        out = np.zeros(layout.ndof)
        coef = term.coefficients(np.full((len(layout.x), 3), 298.15))
        coef[:, 0] = 1.0
        kernels.add_force(term, layout.q0, np.zeros(layout.ndof), coef, out)
        forces = -out.reshape(-1, 4, 3)
        assert forces[:, 0, 2].sum() == pytest.approx(2.0 * size, rel=1e-12)
        # a turn about y moves r by (0, 0, -x), r_u by (0, 0, -1)
        moment = (surface.points[:, 0] * forces[:, 0, 2]).sum() + forces[:, 1, 2].sum()
        assert moment == pytest.approx(2.0 * size * arm, rel=1e-12)
