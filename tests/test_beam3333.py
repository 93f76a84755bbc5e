"""The three-node beam against rods and closed forms."""

import numpy as np
import pytest
from element_cases import COLD, PAPER, PLAIN, RECTANGLE, build, make, relax, straight_line
from scipy.integrate import solve_ivp

from mechanics.description import Beam
from meshes.materials import constant_material
from meshes.sections import general, rectangle

FAMILY = "beam3333"


def free_coordinates(q):
    """Position and directions of the first section held, its size free."""
    return np.setdiff1d(np.arange(q.size), [0, 1, 2, 3, 5, 6, 7])


def bent(case, load, steps=1, temperature=COLD, tolerance=1e-11):
    """Displacements of a cantilever with nodal loads on the last node."""
    external = np.zeros(case.q.size)
    external[-9:] = load
    coef = case.coefficients(temperature)
    return relax(case, case.q, coef, external, free_coordinates(case.q), steps, tolerance) - case.q


def force_along(axis, size):
    return size * np.eye(9)[axis]


# -- definition --------------------------------------------------------------------------------


def test_strains_as_defined():
    """Energy of a random state by polynomials through the nodes."""
    rng = np.random.default_rng(8)
    L, z = 0.7, np.array([-1.0, 0.0, 1.0])
    case = make(FAMILY, "straight", 1, PLAIN, length=L)
    q = case.q + 0.1 * rng.standard_normal(27)
    nodal = q.reshape(3, 3, 3)
    fields = [np.polyfit(z, nodal[:, k], 2) for k in range(3)]

    def at(k, place, order=0):
        f = [np.polyval(np.polyder(c, order), place) for c in fields[k].T]
        return np.array(f) * (2.0 / L) ** order

    E, G, s = 70e9, 70e9 / 2.6, RECTANGLE
    U = 0.0
    for place in (-1 / np.sqrt(3), 1 / np.sqrt(3)):
        t, d = at(0, place, 1), [at(1, place), at(2, place)]
        turn = [at(1, place, 1), at(2, place, 1)]
        unit = [v / np.linalg.norm(v) for v in d]
        n = np.cross(*d) / np.linalg.norm(np.cross(*d))
        U += L / 4 * E * s.area * (t @ n - 1.0) ** 2
        for k, (moment, factor) in enumerate(
            [(s.second_moment_2, s.shear_factor_2), (s.second_moment_3, s.shear_factor_3)]
        ):
            U += L / 4 * factor * G * s.area * (t @ unit[k]) ** 2
            U += L / 4 * E * moment * (n @ turn[k] / np.linalg.norm(d[k])) ** 2
        twist = 0.5 * (turn[0] @ d[1] - turn[1] @ d[0])
        twist /= np.linalg.norm(d[0]) * np.linalg.norm(d[1])
        U += L / 4 * G * s.torsion_constant * twist**2
    for node, weight in zip(nodal, (L / 6, 2 * L / 3, L / 6), strict=True):
        d2, d3 = node[1:]
        U += weight / 2 * E * s.area * (((d2 @ d2 - 1) / 2) ** 2 + ((d3 @ d3 - 1) / 2) ** 2)
        U += weight / 2 * G * s.area * (d2 @ d3) ** 2
    assert case.energies(q, 0 * q, case.coefficients())[0] == pytest.approx(U, rel=1e-12)


def test_refuses_a_body_without_middle_nodes():
    points, axes = straight_line("cable", 3)
    beam = Beam("b", points, axes, RECTANGLE, PLAIN, COLD, 0.0, FAMILY)
    with pytest.raises(ValueError, match="2 for each element and 1 more, got 4"):
        build([beam])


# -- small loads -------------------------------------------------------------------------------


def test_one_element_bends_and_shears_like_timoshenko():
    """Exact at the nodes for a tip load, in both directions; E and G at the temperature."""
    warm, s = COLD + 60.0, RECTANGLE
    stretch = 1.0 + PAPER.thermal_strain(warm, COLD)
    E, G = PAPER.youngs_modulus(warm), PAPER.shear_modulus(warm)
    case = make(FAMILY, "straight", 1, PAPER)
    grown, coef = stretch * case.q, case.coefficients(warm)
    for axis, moment, k in (
        (1, s.second_moment_2, s.shear_factor_2),
        (2, s.second_moment_3, s.shear_factor_3),
    ):
        F, external = 1e-6 * E * moment, np.zeros(27)
        external[-9:] = force_along(axis, F)
        expected = (F / (3 * E * moment) + F / (k * G * s.area)) / stretch  # of the expanded body
        moved = relax(case, grown, coef, external, free_coordinates(grown)) - grown
        assert moved[-9 + axis] == pytest.approx(expected, rel=1e-8)


def test_torsion_uses_the_torsion_constant():
    case = make(FAMILY, "straight", 2, PLAIN)
    GJ = PLAIN.shear_modulus(COLD) * RECTANGLE.torsion_constant
    M = 1e-6 * GJ
    moved = bent(case, [0, 0, 0, 0, 0, M / 2, 0, -M / 2, 0])
    assert moved[-9 + 5] == pytest.approx(M / GJ, rel=1e-9)
    found = case.term.resultants(case.q + moved, 0 * moved, case.coefficients())
    assert found[:, 3] == pytest.approx(M, rel=1e-6)


def test_resultants_of_a_cantilever():
    """Tip forces N, F2, F3: constant forces, moments F (L - x) at the middle of elements."""
    case = make(FAMILY, "straight", 4, PLAIN)
    N, F2, F3 = 3.0, 0.2, -0.3
    moved = case.q + bent(case, [N, F2, F3, *np.zeros(6)])
    found = case.term.resultants(moved, 0 * moved, case.coefficients())
    arm = 1.0 - (np.arange(4) + 0.5) / 4
    expected = np.column_stack([np.tile([N, F2, F3, 0.0], (4, 1)), F2 * arm, F3 * arm])
    assert found == pytest.approx(expected, rel=5e-5, abs=1e-6)


# -- large loads -------------------------------------------------------------------------------


def test_thick_beam_is_the_rod_of_reissner():
    """Nachbagauer et al. (2011), 1000 F: h = L/4, bending strain 12 %."""
    nu, h, w, F = 0.3, 0.5, 0.1, 5e8 * 0.5**3
    factor = 10 * (1 + nu) / (12 + 11 * nu)
    steel = constant_material("steel", 7850.0, 2.07e11, nu, 0.0, 1.0, 1.0)
    thick = general(h * w, w * h**3 / 12, h * w**3 / 12, h * w**3 / 3, factor, factor)
    errors = []
    for elements in (4, 8, 16):
        case = make(FAMILY, "straight", elements, steel, length=2.0, section=thick)
        moved = bent(case, force_along(1, F), 4)
        errors.append(np.hypot(moved[-9] + 0.1509711442, moved[-8] - 0.7105685979))
    assert errors[2] < 1e-6
    assert np.log2(errors[0] / errors[1]) > 3.8
    assert np.log2(errors[1] / errors[2]) > 3.8


@pytest.mark.parametrize("gyration", [1e-3, 1e-4])
def test_elastica_does_not_lock_at_any_slenderness(gyration):
    """Dead tip load 10 EI/L^2 (closed form by elliptic integrals)."""
    slender = general(1e-6 / gyration**2, 1e-6, 1e-6, 1e-6)
    soft = constant_material("soft", 1e3, 1e9, 0.3, 0.0, 1.0, 1.0)
    case = make(FAMILY, "straight", 12, soft, section=slender)
    tip = bent(case, force_along(1, 1e4), 20, tolerance=1e-8)[-9:]
    assert tip[1] == pytest.approx(0.81060902, rel=1e-3)
    assert -tip[0] == pytest.approx(0.55499560, rel=1e-3)


def test_bending_and_twist_together():
    """Dead moments about x and y at the tip against the rod equations (adaptive integration)."""
    EI2, EI3, GJ = 55.2e6, 220.8e6, 61.2295e6
    steel = constant_material("steel", 7850.0, 2.07e11, 0.3, 0.0, 1.0, 1.0)
    section = general(0.08, EI2 / 2.07e11, EI3 / 2.07e11, GJ / (2.07e11 / 2.6))
    m = np.array([0.5e6, 2e6, 0.0])

    def rod(s, y):
        R = y[3:].reshape(3, 3)
        return np.concatenate([R[:, 0], np.cross(R, R.T @ m / np.array([GJ, EI3, EI2])).ravel()])

    start = np.concatenate([np.zeros(3), np.eye(3).ravel()])
    tip = solve_ivp(rod, (0.0, 2.0), start, rtol=1e-11, atol=1e-13).y[:3, -1]
    case = make(FAMILY, "straight", 4, steel, length=2.0, section=section)
    found = case.q
    for _ in range(20):  # the moment on the directors as they are, until they stay
        d2, d3 = found[-6:-3], found[-3:]
        J = (d2 @ d2 + d3 @ d3) * np.eye(3) - np.outer(d2, d2) - np.outer(d3, d3)
        w = np.linalg.solve(J, m)
        load = np.zeros(case.q.size)
        load[-6:-3], load[-3:] = np.cross(w, d2), np.cross(w, d3)
        found = relax(case, found, case.coefficients(), load, free_coordinates(found))
    assert found[-9:-6] == pytest.approx(tip, rel=1e-4)


def test_large_free_bow():
    """A quarter of a circle from a thermal gradient, free of stress in bending; chord."""
    expansion = constant_material("e", 1.0, 70e9, 0.3, 1e-4, 1.0, 1.0)
    section, errors = rectangle(0.02, 0.01), []
    for elements in (2, 4):
        case = make(FAMILY, "straight", elements, expansion, section=section)
        k = 0.5 * np.pi
        coef = case.coefficients(COLD, (k / 1e-4, 0.0))
        q = relax(case, case.q, coef, 0 * case.q, np.arange(case.q.size))
        chord = np.linalg.norm(q[-9:-6] - q[:3])
        errors.append(abs(chord / (2.0 * np.sin(k / 2.0) / k) - 1.0))
        assert (q[-9:-6] - q[:3]) @ q[3:6] < 0.0  # the warm side e2 is outside
    assert errors[1] < 1e-4
    assert np.log2(errors[0] / errors[1]) > 3.5
