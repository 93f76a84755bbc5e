"""Director shell: constant states on any quadrilaterals, and no locking."""

import numpy as np
import pytest
from shell_cases import case, distorted, force, relax, stiffness

from mechanics import kernels
from meshes.materials import constant_material
from meshes.surfaces import annulus, plate

E, NU, H, AREA = 70e9, 0.3, 0.05, 0.72
D = E * H**3 / 12 / (1 - NU**2)
INNER = np.arange(24, 48)


def field(c, r, n):
    """Displacements r(x, y) and changes of the director n(x, y), both (3, nodes)."""
    x, y = c.vectors(c.q)[:, 0, :2].T
    parts = [np.stack([0.0 * x + part for part in f(x, y)], axis=1) for f in (r, n)]
    return np.stack(parts, axis=1).ravel()


def test_constant_plane_stress_of_any_size_on_a_distorted_mesh():
    """Directors that let the thickness shrink: inner nodes in equilibrium, energy of the sheet."""
    c = case("shell24", distorted(), H)
    F = np.array([[1.1, 0.2, 0.0], [-0.1, 0.9, 0.0], [0.3, 0.1, 0.0]])
    normal = np.cross(F[:, 0], F[:, 1])
    strain = 0.5 * (F.T @ F - np.eye(3))[:2, :2]
    across = -NU / (1 - NU) * np.trace(strain)
    F[:, 2] = np.sqrt(1.0 + 2.0 * across) * normal / np.linalg.norm(normal)
    q = (c.vectors(c.q) @ F.T).ravel()
    f = force(c, q, c.coef)
    assert np.abs(f[INNER]).max() < 1e-13 * np.abs(f).max()
    density = NU * np.trace(strain) ** 2 + (1 - NU) * np.sum(strain**2)
    energy = kernels.energies(c.term, q, 0 * q, c.coef)[0]
    assert energy == pytest.approx(E / 2 / (1 - NU**2) * density * AREA * H, rel=1e-12)


@pytest.mark.parametrize("kappa", [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)])
def test_constant_bending_and_twist_on_a_distorted_mesh(kappa):
    """Kirchhoff's energy of constant curvatures: Poisson's effect does not stiffen it."""
    c = case("shell24", distorted(), H)
    a, b, t = kappa
    u = field(
        c,
        lambda x, y: (0, 0, 0.5 * (a * x**2 + b * y**2) + t * x * y),
        lambda x, y: (-(a * x + t * y), -(b * y + t * x), 0),
    )
    f = stiffness(c, c.q, c.coef) @ u
    assert np.abs(f[INNER]).max() < 1e-11 * np.abs(f).max()
    expected = 0.5 * D * (a**2 + b**2 + 2 * (1 - NU) * t**2) * AREA
    assert 0.5 * u @ f == pytest.approx(expected, rel=1e-10)


def test_constant_transverse_shear_on_a_distorted_mesh():
    c = case("shell24", distorted(), H)
    u = field(c, lambda x, y: (0, 0, 0.3 * x - 0.7 * y), lambda x, y: (0, 0, 0))
    f = stiffness(c, c.q, c.coef) @ u  # directors are held by couples
    assert np.abs(f[c.at([4, 5, 6, 7], 0)]).max() < 1e-12 * np.abs(f).max()
    kGh = 5 / 6 * E / 2 / (1 + NU) * H
    assert 0.5 * u @ f == pytest.approx(0.5 * kGh * (0.3**2 + 0.7**2) * AREA, rel=1e-10)


def test_only_rigid_motions_are_free_of_energy():
    c = case("shell24", distorted(), H)
    values = np.linalg.eigvalsh(stiffness(c, c.q, c.coef).toarray())
    assert np.abs(values[:6]).max() < 1e-13 * values[-1] and values[6] > 1e-9 * values[-1]


def small_tip_load(c, nodes, component, load):
    """Mean displacement of the end nodes of a cantilever; its clamp lets the thickness breathe."""
    free = np.setdiff1d(np.arange(c.q.size), [*c.at([0, 1], 0), *c.at([0, 1], 1, 0, 1)])
    f, u = np.zeros_like(c.q), np.zeros_like(c.q)
    f[c.at(nodes, 0, component)] = load / len(nodes)
    u[free] = np.linalg.solve(stiffness(c, c.q, c.coef).toarray()[np.ix_(free, free)], f[free])
    return u[c.at(nodes, 0, component)].mean()


@pytest.mark.parametrize("thickness", [1e-2, 1e-4])
def test_thin_cantilever_does_not_lock(thickness):
    """w = F l^3/(3 EI) (1 - 1/(4 n^2)) + F l/(k G A) at any thickness, n elements: as beams do."""
    material = constant_material("m", 1.0, 1e9, 0.0, 0.0, 1.0, 1.0)
    c = case("shell24", plate(1.0, 0.1, 8, 1), thickness, material)
    EI, kGA = 1e9 * 0.1 * thickness**3 / 12, 5 / 6 * 0.5e9 * 0.1 * thickness
    expected = 1 / 3 * (1 - 1 / 256) + EI / kGA
    assert small_tip_load(c, [16, 17], 2, EI) == pytest.approx(expected, rel=1e-5)


@pytest.mark.parametrize(("nu", "missing", "error"), [(0.0, 1 / 144, 1e-3), (0.3, 0.0, 2e-2)])
def test_bending_in_the_plane_does_not_lock(nu, missing, error):
    """MacNeal & Harder (1985): six rectangles 1 x 0.2, tip load in the plane, 0.1081.

    n elements lack 1/(4 n^2); with Poisson's effect they lack as much again, for the thickness
    is continuous and in-plane strain is not.
    """
    material = constant_material("m", 1.0, 1e7, nu, 0.0, 1.0, 1.0)
    c = case("shell24", plate(6.0, 0.2, 6, 1), 0.1, material)
    assert small_tip_load(c, [12, 13], 1, 1.0) == pytest.approx(0.1081 * (1 - missing), rel=error)


def test_slit_annulus():
    """Sze, Liu & Lo (2004): half the load, W_A 10.468, W_B 13.768; 4 x 24 elements."""
    material = constant_material("m", 1.0, 21e6, 0.0, 0.0, 1.0, 1.0)
    c = case("shell24", annulus(6.0, 10.0, 4, 24), 0.03, material)
    nodes = np.arange(5 * 25).reshape(5, 25)
    load = np.zeros_like(c.q)
    np.add.at(load, c.at([nodes[:-1, -1], nodes[1:, -1]], 0, 2), 0.2)
    fixed = [*c.at(nodes[:, 0], 0), *c.at(nodes[:, 0], 1)]
    q = relax(c, c.coef, load, fixed, steps=20)
    inner, outer = q[c.at(nodes[[0, -1], -1], 0, 2)]
    assert inner == pytest.approx(10.468, rel=4e-2)
    assert outer == pytest.approx(13.768, rel=4e-2)
