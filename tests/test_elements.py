"""Closed forms for the default beam and the cable, and for what they share."""

from dataclasses import replace

import numpy as np
import pytest
from element_cases import (
    COLD,
    PAPER,
    PLAIN,
    RECTANGLE,
    ROD,
    build,
    make,
    relax,
)
from scipy.integrate import solve_ivp
from scipy.linalg import eigh
from scipy.optimize import minimize_scalar

from mechanics import beam3243
from mechanics.description import Beam
from mechanics.line_elements import MEMBRANE
from meshes.materials import constant_material
from meshes.sections import general

NODE = {"beam3243": 12, "cable": 6}
NO_EXPANSION = constant_material("none", 1.0, 1.0, 0.0, 0.0, 1.0, 1.0).expansion
INERT = replace(PAPER, expansion=NO_EXPANSION)
SECTION = {"beam3243": RECTANGLE, "cable": ROD}
families = pytest.mark.parametrize("family", NODE)


def clamped(q, node=12):
    """Coordinates left free when the first node's position and section are held.

    For a cable along x: position and direction, so that it may still be stretched there.
    """
    held = [0, 1, 2, *range(6, 12)] if node == 12 else [0, 1, 2, 4, 5]
    return np.setdiff1d(np.arange(q.size), held)


@families
def test_elongation_follows_the_modulus_along_the_bar(family):
    """Small pull F on a straight bar of uneven temperature: int F/(E(T) A) dx."""
    case = make(family, "straight", 8, material=INERT)
    q = case.q
    T = case.temperatures()
    T[:, 0] = np.linspace(150.0, 440.0, 9)
    pull = np.zeros_like(q)
    pull[-NODE[family]] = F = 1e-7 * 69e9 * SECTION[family].area
    found = relax(case, q, case.term.coefficients(T), pull, clamped(q, NODE[family]))
    x = np.linspace(0.0, 1.0, 20001)
    compliance = np.trapezoid(1.0 / INERT.youngs_modulus(150.0 + 290.0 * x), x)
    elongation = F / SECTION[family].area * compliance
    assert found[-NODE[family]] - 1.0 == pytest.approx(elongation, rel=1e-5)


@families
def test_held_bar_presses_as_it_warms(family):
    """Both ends held: W = s^3 EA e^2/2 with Green's strain e = (l^2/s^2 - 1)/2 of the body
    expanded by s gives dW/dl = EA s (1/s^2 - 1)/2 at l = 1."""
    case = make(family, "straight", 2)
    q = case.q
    coef = case.coefficients(COLD + 10.0)
    N = case.term.resultants(q, 0 * q, coef)[:, 0]
    s = 1.0 + PAPER.thermal_strain(COLD + 10.0, COLD)
    EA = PAPER.youngs_modulus(COLD + 10.0) * SECTION[family].area
    expected = EA * s * (s**-2 - 1.0) / 2.0
    assert pytest.approx(expected, rel=1e-12) == N


@families
@pytest.mark.parametrize("gyration", [1e-3, 1e-4])
def test_elastica_does_not_lock_at_any_slenderness(family, gyration):
    """Dead tip load 10 EI/L^2 (closed form by elliptic integrals), 8 elements."""
    EI, area = 1e3, 1e-6 / gyration**2
    slender = general(area, 1e-6, 1e-6, 1e-6)
    soft = constant_material("soft", 1e3, 1e9, 0.3, 0.0, 1.0, 1.0)
    case = make(family, "straight", 8, section=slender, material=soft)
    q = case.q
    load = np.zeros_like(q)
    load[1 - NODE[family]] = 10.0 * EI
    coef = case.coefficients()
    found = relax(case, q, coef, load, clamped(q, NODE[family]), 20, tolerance=1e-7)
    tip = found[-NODE[family] :]
    assert tip[1] == pytest.approx(0.81060902, rel=1e-3)
    assert 1.0 - tip[0] == pytest.approx(0.55499560, rel=1e-3)


# -- beam3243 ----------------------------------------------------------------------------------


def tip_load(case, q, load, coef):
    external = np.zeros_like(q)
    external[-12:] = load
    return relax(case, q, coef, external, clamped(q)) - q


def test_one_beam_element_bends_and_shears_like_timoshenko():
    """w = F L^3/(3 EI) + F L/(k_s GA), in both directions, E and G at the temperature."""
    warm = COLD + 60.0
    case = make("beam3243", "straight", 1, material=INERT)
    q = case.q
    coef = case.coefficients(warm)
    E, G, s = INERT.youngs_modulus(warm), INERT.shear_modulus(warm), RECTANGLE
    for axis, moment, k in (
        (1, s.second_moment_2, s.shear_factor_2),
        (2, s.second_moment_3, s.shear_factor_3),
    ):
        load = np.zeros(12)
        load[axis] = F = 1e-5 * E * moment
        w = tip_load(case, q, load, coef)[12 + axis]
        assert w == pytest.approx(F / (3 * E * moment) + F / (k * G * s.area), rel=1e-7)


def test_torsion_of_a_beam_uses_the_torsion_constant():
    """Moment on d2, d3 at the tip: angle M L/(G J)."""
    case = make("beam3243", "straight", 3, material=INERT)
    q = case.q
    coef = case.coefficients()
    G, J = INERT.shear_modulus(COLD), RECTANGLE.torsion_constant
    M = 1e-6 * G * J
    load = np.zeros(12)
    load[[8, 10]] = M / 2, -M / 2
    moved = tip_load(case, q, load, coef)
    assert moved[-12 + 8] == pytest.approx(M / (G * J), rel=1e-9)
    resultants = case.term.resultants(q + moved, 0 * q, coef)
    assert resultants[:, 3] == pytest.approx(M, rel=1e-6)


def test_first_torsional_frequency_of_a_cantilever():
    """omega = pi/2 sqrt(G J/(rho (I2 + I3))) / L: torsion constant against polar moment."""
    case = make("beam3243", "straight", 16, material=INERT)
    q = case.q
    K = case.matrix(q, 0 * q, case.coefficients())
    M = case.mass()
    d2_d3 = [[12 * i + 8, 12 * i + 10] for i in range(1, 17)]
    turn = np.zeros((q.size, 16))
    for i, (up, down) in enumerate(d2_d3):
        turn[up, i], turn[down, i] = 1.0, -1.0
    omega = np.sqrt(eigh(turn.T @ K @ turn, turn.T @ M @ turn, eigvals_only=True)[0])
    GJ = INERT.shear_modulus(COLD) * RECTANGLE.torsion_constant
    expected = np.pi / 2 * np.sqrt(GJ / (INERT.density * RECTANGLE.polar_moment))
    assert omega == pytest.approx(expected, rel=5e-4)


def test_resultants_of_a_cantilever():
    """Tip forces F2, F3 and N: constant forces, moments F (L - x) at the middle of elements."""
    case = make("beam3243", "straight", 4, material=INERT)
    q = case.q
    coef = case.coefficients()
    load = np.zeros(12)
    load[:3] = N, F2, F3 = 3.0, 0.2, -0.3
    found = case.term.resultants(q + tip_load(case, q, load, coef), 0 * q, coef)
    arm = 1.0 - (np.arange(4) + 0.5) / 4
    expected = np.column_stack([np.tile([N, F2, F3, 0.0], (4, 1)), F2 * arm, F3 * arm])
    assert found == pytest.approx(expected, rel=5e-5, abs=1e-6)


@pytest.mark.parametrize(("gradient", "tip_error"), [(50.0, 1e-9), (2000.0, 1e-6)])
def test_one_element_bows_freely_under_a_gradient(gradient, tip_error):
    """Free of stress with curvature alpha G; the warm side is outside."""
    case = make("beam3243", "straight", 1, material=PAPER)
    q = case.q
    hot = COLD + 40.0
    coef = case.coefficients(hot, (gradient, -0.5 * gradient))
    bent = relax(case, q, coef, 0 * q, np.arange(q.size), 1)
    kappa = PAPER.expansion(hot) * gradient * np.array([-1.0, 0.5])
    k, growth = np.hypot(*kappa), 1.0 + PAPER.thermal_strain(hot, COLD)
    assert case.energies(bent, 0 * bent, coef)[0] < 1e-20 * coef[:, 3:7].sum() * k**2
    x = bent.reshape(2, 4, 3)
    chord = growth * 2.0 * np.sin(k / 2.0) / k
    assert np.linalg.norm(x[1, 0] - x[0, 0]) == pytest.approx(chord, rel=tip_error)
    e1 = np.cross(x[:, 2], x[:, 3]) / growth**2
    assert e1[0] @ x[1, 2] / growth == pytest.approx(-np.sin(k) * kappa[0] / k, rel=1e-3)
    assert e1[0] @ x[1, 3] / growth == pytest.approx(-np.sin(k) * kappa[1] / k, rel=1e-3)


def test_strains_of_the_beam_as_defined():
    """Energy of a random state from the definitions, by polynomials, with uniform properties."""
    rng = np.random.default_rng(8)
    L = 0.7
    case = make("beam3243", "straight", 1, length=L, material=PLAIN)
    q = case.q
    q = q + 0.1 * rng.standard_normal(q.size)
    (ra, ax, a2, a3), (rb, bx, b2, b3) = q.reshape(2, 4, 3)
    cubic = np.array([ra, L * ax, 3 * (rb - ra) - L * (2 * ax + bx), 2 * (ra - rb) + L * (ax + bx)])

    def axis(xi, order):
        p = np.polynomial.Polynomial
        return np.array([p(c).deriv(order)(xi) for c in cubic.T]) / L**order

    def unit(d):
        return d / np.linalg.norm(d)

    def shear(k, xi):
        ends = ax @ unit((a2, a3)[k]), bx @ unit((b2, b3)[k])
        return (1 - xi) * ends[0] + xi * ends[1]

    def normal_square(xi):
        t = axis(xi, 1)
        return t @ t - shear(0, xi) ** 2 - shear(1, xi) ** 2

    def bending(k, xi):
        n = unit((1 - xi) * (a2, a3)[k] + xi * (b2, b3)[k])
        turning = axis(xi, 2) @ n - (shear(k, 1.0) - shear(k, 0.0)) / L
        turning += (1 - 2 * k) * (a3 @ b2 - a2 @ b3) / (2 * L) * shear(1 - k, xi)
        return turning / np.sqrt(normal_square(xi))

    E, G, s = 70e9, 70e9 / 2.6, RECTANGLE
    x, w = np.polynomial.legendre.leggauss(3)
    e = [(normal_square((1 + z) / 2) - 1) / 2 for z in x]
    c = [np.sum(w / 2 * np.polynomial.Legendre.basis(k)(x) * e) for k in range(3)]
    radius2 = np.sqrt(s.second_moment_2 * s.second_moment_3) / s.area
    slack = min(1.0, beam3243.MEMBRANE * radius2 / L**2)
    points = 0.5 - 0.5 / np.sqrt(3), 0.5 + 0.5 / np.sqrt(3)
    b = L * np.array([[bending(k, xi) for xi in points] for k in range(2)])
    c[1] += np.sqrt(3) / 240 * np.sum(b[:, 1] ** 2 - b[:, 0] ** 2)
    U = E * s.area * L / 2 * (c[0] ** 2 + 3 * c[1] ** 2 + 5 * slack * c[2] ** 2)
    mean = b.mean(axis=1)
    B = b + mean[0] * mean[1] / 12 * b[::-1]
    moments, GJ = np.array([[s.second_moment_2], [s.second_moment_3]]), G * s.torsion_constant

    def turned(phi):
        """Energy of bending where the section turns by phi between the nodes."""
        found = B + phi * np.array([[1.0], [-1.0]]) * B[::-1]
        return E / (4 * L) * np.sum(moments * found**2) + 6 * GJ / L * phi**2

    U += minimize_scalar(turned, (-0.1, 0.1), tol=1e-9).fun
    for k, factor in enumerate((s.shear_factor_2, s.shear_factor_3)):
        U += factor * G * s.area * L / 4 * (shear(k, 0.0) ** 2 + shear(k, 1.0) ** 2)
    for d in (a2, b2, a3, b3):
        U += E * s.area * L / 4 * ((d @ d - 1) / 2) ** 2
    U += G * s.area * L / 4 * ((a2 @ a3) ** 2 + (b2 @ b3) ** 2)
    turn = (a3 @ b2 - a2 @ b3) / 2
    turn *= 1 + (turn**2 + mean @ mean) / 6
    turn -= np.sqrt(3) / 12 * (B[0, 0] * B[1, 1] - B[1, 0] * B[0, 1])
    U += GJ / (2 * L) * turn**2
    assert case.energies(q, 0 * q, case.coefficients())[0] == pytest.approx(U, rel=1e-12)


def test_thick_beam_converges_to_the_rod_of_reissner_on_any_mesh():
    """Nachbagauer et al. (2011): h = L/4, bending strain 12 %; 1e-4 is left to Green's strain."""
    nu, h, w, F = 0.3, 0.5, 0.1, 5e8 * 0.5**3
    factor = 10 * (1 + nu) / (12 + 11 * nu)
    steel = constant_material("steel", 7850.0, 2.07e11, nu, 0.0, 1.0, 1.0)
    thick = general(h * w, w * h**3 / 12, h * w**3 / 12, h * w**3 / 3, factor, factor)
    for elements, error in ((8, 3e-4), (32, 1e-4)):
        case = make("beam3243", "straight", elements, length=2.0, section=thick, material=steel)
        q = case.q
        load = np.zeros_like(q)
        load[-11] = F
        coef = case.coefficients()
        moved = relax(case, q, coef, load, clamped_and_breathing(q), 4, 1e-9) - q
        assert -moved[-12] == pytest.approx(0.1509711442, rel=error)
        assert moved[-11] == pytest.approx(0.7105685979, rel=error)


def clamped_and_breathing(q):
    """Free coordinates when position and section of the first node are held but for its size."""
    return np.setdiff1d(np.arange(q.size), [0, 1, 2, 6, 8, 9, 10])


def test_bending_and_twist_together():
    """Dead moments about x and y at the tip against the rod equations (adaptive integration)."""
    EI2, EI3, GJ = 55.2e6, 220.8e6, 61.2295e6
    steel = constant_material("steel", 7850.0, 2.07e11, 0.3, 0.0, 1.0, 1.0)
    G = 2.07e11 / 2.6
    section = general(0.08, EI2 / 2.07e11, EI3 / 2.07e11, GJ / G)
    m = np.array([0.5e6, 2e6, 0.0])

    def rod(s, y):
        R = y[3:].reshape(3, 3)
        turning = R.T @ m / np.array([GJ, EI3, EI2])
        return np.concatenate([R[:, 0], np.cross(R, turning).ravel()])

    start = np.concatenate([np.zeros(3), np.eye(3).ravel()])
    tip = solve_ivp(rod, (0.0, 2.0), start, rtol=1e-11, atol=1e-13).y[:3, -1]
    for elements, error in ((1, 2e-3), (4, 1e-4)):
        case = make("beam3243", "straight", elements, length=2.0, section=section, material=steel)
        q = case.q
        coef = case.coefficients()
        found = q
        for _ in range(20):  # the moment on the directors as they are, until they stay
            d2, d3 = found[-6:-3], found[-3:]
            J = (d2 @ d2 + d3 @ d3) * np.eye(3) - np.outer(d2, d2) - np.outer(d3, d3)
            load, w = np.zeros_like(q), np.linalg.solve(J, m)
            load[-6:-3], load[-3:] = np.cross(w, d2), np.cross(w, d3)
            found = relax(case, q, coef, load, clamped_and_breathing(q))
        moved = found[-12:-9] - [2.0, 0.0, 0.0]
        assert moved == pytest.approx(tip - [2.0, 0.0, 0.0], rel=error)


# -- cable -------------------------------------------------------------------------------------


def test_strains_of_the_cable_as_defined():
    """Tension and bending energy of a random state of a straight cable, by its definitions."""
    rng = np.random.default_rng(9)
    L = 0.7
    case = make("cable", "straight", 1, length=L, material=PLAIN)
    q = case.q
    q = q + 0.1 * rng.standard_normal(q.size)
    (ra, ax), (rb, bx) = q.reshape(2, 2, 3)

    def axis(xi):
        c = (rb - ra) / L
        first = 6 * xi * (1 - xi) * c + (1 - xi) * (1 - 3 * xi) * ax + xi * (3 * xi - 2) * bx
        return first, ((6 - 12 * xi) * c + (6 * xi - 4) * ax + (6 * xi - 2) * bx) / L

    EA, EI = 70e9 * ROD.area, 70e9 * ROD.second_moment_2
    x, w = np.polynomial.legendre.leggauss(3)
    e = [(np.sum(axis((1 + z) / 2)[0] ** 2) - 1) / 2 for z in x]
    c = [np.sum(w / 2 * np.polynomial.Legendre.basis(k)(x) * e) for k in range(3)]
    slack = min(1.0, MEMBRANE * EI / (EA * L**2))
    U = EA * L / 2 * (c[0] ** 2 + 3 * c[1] ** 2 + 5 * slack * c[2] ** 2)
    for z in (-1 / np.sqrt(3), 1 / np.sqrt(3)):
        t, u = axis((1 + z) / 2)
        U += EI * L / 4 * np.sum(np.cross(t, u) ** 2) / (t @ t) ** 2
    assert case.energies(q, 0 * q, case.coefficients())[0] == pytest.approx(U, rel=1e-12)


def test_naturally_curved_cable_resists_bending_from_its_own_curvature():
    """One that is bent to half its curvature carries the moment EI (kappa - kappa_ref)."""

    def arc(radius, angle, n=8):
        s = np.linspace(0.0, angle, n + 1)
        e1 = np.column_stack([np.cos(s), np.sin(s), 0 * s])
        e2 = np.column_stack([-np.sin(s), np.cos(s), 0 * s])
        points = radius * np.column_stack([np.sin(s), 1 - np.cos(s), 0 * s])
        return points, np.stack([e1, e2, np.tile([0.0, 0.0, 1.0], (n + 1, 1))], axis=1)

    case, other = (
        build([Beam("b", *shape, ROD, PLAIN, COLD, 0.0, "cable")])
        for shape in (arc(1.0, 1.0), arc(2.0, 0.5))
    )
    q, bent = case.q, other.q
    coef = case.coefficients()
    M = case.term.resultants(bent, 0 * q, coef)[:, 4]
    assert pytest.approx(70e9 * ROD.second_moment_2 * 0.5, rel=1e-3) == M
    EI = 70e9 * ROD.second_moment_2
    assert case.energies(bent, 0 * bent, coef)[0] == pytest.approx(EI / 8.0, rel=1e-3)


def test_cable_refuses_a_section_that_bends_unalike():
    with pytest.raises(ValueError, match="cable 'b' bends alike"):
        make("cable", "straight", 1, section=RECTANGLE)
