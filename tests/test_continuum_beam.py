"""Continuum beams against the theory of the solid they are made of, and their known locking."""

import numpy as np
import pytest
from element_cases import COLD, PAPER, PLAIN, RECTANGLE, derivative, make, relax

from mechanics.section_points import section_points
from meshes.materials import constant_material
from meshes.sections import circle, general, rectangle, tube

FAMILIES = ["beam3243-continuum", "beam3243-enhanced"]
families = pytest.mark.parametrize("family", FAMILIES)
SECTIONS = {
    "rectangle": rectangle(0.10, 0.06),
    "circle": circle(0.05),
    "tube": tube(0.05, 0.02),
    "general": general(0.006, 0.006 * 0.01 / 12, 0.006 * 0.0036 / 12, 1e-6),
}
NU = 0.3
LOCKED = (1.0 - NU) / ((1.0 + NU) * (1.0 - 2.0 * NU))
"""(lambda + 2 mu)/E."""


# -- sections ----------------------------------------------------------------------------------


def moments(kind):
    """Integrals of 1, y^2, z^2, y^4, y^2 z^2, z^4 in closed form."""
    h, w = 0.10, 0.06
    if kind in ("rectangle", "general"):
        along = [h, h**3 / 12, h**5 / 80]
        across = [w, w**3 / 12, w**5 / 80]
        orders = [(0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2)]
        return [along[i] * across[j] for i, j in orders]
    outer, inner = (0.05, 0.0) if kind == "circle" else (0.06, 0.04)
    second = np.pi / 4 * (outer**4 - inner**4)
    fourth = np.pi / 24 * (outer**6 - inner**6)
    return [np.pi * (outer**2 - inner**2), second, second, 3 * fourth, fourth, 3 * fourth]


@pytest.mark.parametrize("kind", SECTIONS)
def test_section_points_integrate_up_to_the_fourth_moments(kind):
    points, weights = section_points(SECTIONS[kind])
    y, z = points.T
    found = [np.sum(weights * f) for f in (y**0, y**2, z**2, y**4, y**2 * z**2, z**4)]
    assert found == pytest.approx(moments(kind), rel=1e-13)
    for odd in (y, z, y * z, y**3, y**2 * z, y**3 * z, y * z**3, y**5, y * z**4):
        assert abs(np.sum(weights * odd)) < 1e-15 * weights.sum()


# -- energy as defined -------------------------------------------------------------------------


def positions(q, L, xi, y, z):
    """Position in the element with nodal vectors q (24,), from its shape functions."""
    ra, ax, a2, a3, rb, bx, b2, b3 = q.reshape(8, 3)
    hermite = (1 - 3 * xi**2 + 2 * xi**3) * ra + L * (xi - 2 * xi**2 + xi**3) * ax
    hermite += (3 * xi**2 - 2 * xi**3) * rb + L * (xi**3 - xi**2) * bx
    return hermite + y * ((1 - xi) * a2 + xi * b2) + z * ((1 - xi) * a3 + xi * b3)


def strain(q, reference, L, place):
    """Green's strain in Cartesian axes, and the volume ratio of the reference, by differences."""
    J, J0 = (derivative(lambda p, x=x: positions(x, L, *p), place, 1e-3) for x in (q, reference))
    F = J @ np.linalg.inv(J0)
    return 0.5 * (F.T @ F - np.eye(3)), np.linalg.det(J0), J0


def frame(J0):
    e1 = np.cross(J0[:, 1], J0[:, 2])
    e2 = J0[:, 1] / np.linalg.norm(J0[:, 1])
    e1 /= np.linalg.norm(e1)
    return np.stack([e1, e2, np.cross(e1, e2)])


def energy(family, q, reference, L, order):
    """Of one element of a rectangle, by Gauss quadrature of the densities that define it."""
    E, G = 70e9, 70e9 / 2.6
    lame = E * NU / ((1 + NU) * (1 - 2 * NU))
    x, w = np.polynomial.legendre.leggauss(5)
    s, u = np.polynomial.legendre.leggauss(order)
    total = 0.0
    for xi, wx in zip(0.5 + 0.5 * x, 0.5 * w, strict=True):
        for y, wy in zip(0.05 * s, 0.5 * u, strict=True):
            for z, wz in zip(0.03 * s, 0.5 * u, strict=True):
                e, ratio, J0 = strain(q, reference, L, np.array([xi, y, z]))
                volume = wx * wy * wz * RECTANGLE.area * ratio
                if family == "beam3243-continuum":
                    total += volume * (0.5 * lame * np.trace(e) ** 2 + G * np.sum(e**2))
                    continue
                e = frame(J0) @ e @ frame(J0).T
                k2, k3 = RECTANGLE.shear_factor_2, RECTANGLE.shear_factor_3
                shear = k2 * e[0, 1] ** 2 + k3 * e[0, 2] ** 2 + e[1, 2] ** 2
                total += volume * (0.5 * E * np.sum(np.diag(e) ** 2) + 2.0 * G * shear)
        e, ratio, _ = strain(q, reference, L, np.array([xi, 0.0, 0.0]))
        if family == "beam3243-enhanced":
            a, b, c = np.diag(frame(J0) @ e @ frame(J0).T)
            poisson = NU * (a * a + b * b + c * c) + a * b + a * c + b * c
            total += wx * RECTANGLE.area * ratio * lame * poisson
    return total


@families
@pytest.mark.parametrize(("shape", "order", "error"), [("straight", 3, 1e-9), ("curved", 4, 1e-4)])
def test_energy_of_a_solid(family, shape, order, error):
    """The quadrature is exact for a straight element, and nearly so for a curved one."""
    rng = np.random.default_rng(8)
    case = make(family, shape, 1, PLAIN)
    q = case.q + 0.05 * rng.standard_normal(24)
    expected = energy(family, q, case.q, case.term.length[0], order)
    found = case.energies(q, 0 * q, case.coefficients())[0]
    assert found == pytest.approx(expected, rel=error)


def test_without_poissons_ratio_both_are_the_same():
    rng = np.random.default_rng(9)
    plain = constant_material("n", 1.0, 70e9, 0.0, 0.0, 1.0, 1.0)
    section = general(0.006, 5e-6, 1.8e-6, 1e-6)  # shear factors of 1
    cases = [make(family, "curved", 2, plain, section=section) for family in FAMILIES]
    q = cases[0].q + 0.05 * rng.standard_normal(36)
    f = [case.force(q, 0 * q, case.coefficients()) for case in cases]
    assert f[0] == pytest.approx(f[1], abs=1e-12 * np.abs(f[0]).max())


# -- locking -----------------------------------------------------------------------------------


def free_coordinates(q):
    """Position and directions of the first section held, its size free."""
    return np.setdiff1d(np.arange(q.size), [0, 1, 2, 6, 8, 9, 10])


def deflection(family, elements, slenderness):
    """Small tip deflection over that of Timoshenko with E and the shear factor."""
    h = 1.0 / slenderness
    section, E, G = rectangle(h, h, NU), 70e9, 70e9 / 2.6
    case = make(family, "straight", elements, PLAIN, section=section)
    load = np.zeros(case.q.size)
    load[-11] = F = 1e-6 * E * section.second_moment_2
    K = case.matrix(case.q, 0 * case.q, case.coefficients())
    free = free_coordinates(case.q)
    w = np.linalg.solve(K[np.ix_(free, free)], load[free])[free == case.q.size - 11][0]
    bending, shear = F / (3 * E * section.second_moment_2), F / (G * section.area)
    return w, bending, shear, shear / section.shear_factor_2


def test_naive_beam_never_bends_enough():
    """Bending meets lambda + 2 mu on any mesh: 26 % less deflection at nu = 0.3."""
    for slenderness in (10, 100):
        errors = []
        for elements in (4, 8, 16):
            w, bending, shear, _ = deflection("beam3243-continuum", elements, slenderness)
            errors.append(1.0 - w / (bending / LOCKED + shear))
            assert w < 0.76 * bending
        assert errors[-1] < 3e-3
        assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.05)
        assert errors[1] / errors[2] == pytest.approx(4.0, rel=0.05)


def test_enhanced_beam_converges_with_the_square_of_the_element():
    for slenderness in (10, 100):
        errors = []
        for elements in (4, 8, 16):
            w, bending, _, shear = deflection("beam3243-enhanced", elements, slenderness)
            errors.append(1.0 - w / (bending + shear))
        assert errors[-1] < 3e-3
        assert errors[1] / errors[2] == pytest.approx(4.0, rel=0.05)


@families
def test_torsion_meets_the_polar_moment(family):
    """Angle M L/(G I_p); what shear factors there are reduce it in the enhanced beam."""
    case = make(family, "straight", 4, PLAIN)
    G, s = PLAIN.shear_modulus(COLD), RECTANGLE
    factors = (s.shear_factor_3, s.shear_factor_2) if family == "beam3243-enhanced" else (1.0, 1.0)
    parts = G * np.array([s.second_moment_2, s.second_moment_3]) * factors
    load = np.zeros(case.q.size)  # moment 10, on d2 and d3 as their stiffness asks
    load[[-4, -2]] = 10.0 * parts / parts.sum() * [1.0, -1.0]
    K = case.matrix(case.q, 0 * case.q, case.coefficients())
    free = free_coordinates(case.q)
    moved = np.zeros(case.q.size)
    moved[free] = np.linalg.solve(K[np.ix_(free, free)], load[free])
    assert moved[-4] == pytest.approx(10.0 / parts.sum(), rel=1e-9)
    assert moved[-2] == pytest.approx(-10.0 / parts.sum(), rel=1e-9)
    q = case.q + 1e-3 * moved
    found = case.term.resultants(q, 0 * q, case.coefficients())
    assert found[:, 3] == pytest.approx(1e-2, rel=1e-6)


@families
def test_resultants_of_a_cantilever(family):
    """Tip forces N, F2, F3: constant forces, moments F (L - x) at the middle of elements."""
    case = make(family, "straight", 8, PLAIN)
    coef, load = case.coefficients(), np.zeros(case.q.size)
    load[-12:-9] = N, F2, F3 = 3.0, 0.2, -0.3
    moved = relax(case, case.q, coef, load, free_coordinates(case.q))
    found = case.term.resultants(moved, 0 * moved, coef)
    arm = 1.0 - (np.arange(8) + 0.5) / 8
    expected = np.column_stack([np.tile([N, F2, F3, 0.0], (8, 1)), F2 * arm, F3 * arm])
    assert found[1:] == pytest.approx(expected[1:], abs=2e-3)


@families
def test_properties_follow_the_temperature(family):
    """Small pull on a bar held at a point: F/(E(T) A) per length, contraction nu(T) of it."""
    warm = COLD + 150.0
    case = make(family, "straight", 2, PAPER)
    coef = case.coefficients(warm)
    s = 1.0 + PAPER.thermal_strain(warm, COLD)
    q, load = s * case.q, np.zeros(case.q.size)
    load[-12], load[0] = F, _ = 1e3, -1e3
    pulled = relax(case, q, coef, load, np.arange(3, q.size)) - q
    tension = F / (PAPER.youngs_modulus(warm) * RECTANGLE.area * s**2)
    assert pulled[-12] / s == pytest.approx(tension, rel=1e-4)
    assert pulled[-5] / s == pytest.approx(-PAPER.poissons_ratio(warm) * tension, rel=1e-4)
