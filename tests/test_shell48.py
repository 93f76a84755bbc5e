"""Thin shell: what is its own; ``test_element_contract`` has what it shares with others."""

import numpy as np
import pytest
from element_cases import COLD, PAPER, PLAIN, POISSONLESS, build, derivative
from scipy.linalg import eigh
from scipy.spatial.transform import Rotation

from coupling.verify import shells
from mechanics import kernels, traction
from mechanics.description import Shell, Traction
from mechanics.shell48_kernels import BENT, FULL, POINTS, TABLE, WEIGHTS, XI, shapes
from meshes.surfaces import annulus, patch, plate, sphere, tube

QUARTER = (0.0, 0.5 * np.pi)
PIECES = {
    "plate": plate(1.0, 0.7, 2, 1),
    "tube": tube(0.3, 0.8, 8, 1),
    "sphere": sphere(0.5, 2, 2, (0.1, 0.9), QUARTER),
    "annulus": annulus(0.4, 0.9, 1, 3, QUARTER),
}
pieces = pytest.mark.parametrize("name", PIECES)


def shell(surface, thickness=0.01, material=PLAIN, damping=0.0):
    return build([Shell("s", surface, thickness, material, COLD, damping)])


def numbers(case, lines):
    return np.arange(case.q.size // 12).reshape(-1, lines)


def solved(case, free, force):
    """Linear displacements (n, 4, 3) of the nodes."""
    K = case.matrix(case.q, 0 * case.q, case.coefficients())
    x = np.zeros(case.q.size)
    x[free] = np.linalg.solve(K[np.ix_(free, free)], force[free])
    return x.reshape(-1, 4, 3)


# -- shapes and curved references --------------------------------------------------------------


def test_tables_reproduce_bicubic_polynomials():
    """Nodal values and slopes of x^i y^j give it back, with all derivatives, at all points."""
    x, y = np.array([0.0, 1.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0, 1.0])
    X, Y = np.array([0.3, 0.9]), np.array([0.6, 0.2])

    def power(z, i, order):
        return np.polynomial.Polynomial.basis(i).deriv(order)(z) if order else z**i

    for i in range(4):
        for j in range(4):
            nodal = [power(x, i, a) * power(y, j, b) for b in (0, 1) for a in (0, 1)]
            for a, b in ((0, 0), (1, 0), (0, 1), (2, 0), (0, 2), (1, 1)):
                found = shapes(X, Y, a, b) @ np.stack(nodal, axis=1).ravel()
                assert found == pytest.approx(power(X, i, a) * power(Y, j, b), abs=1e-14)


def test_points_are_those_of_gauss():
    assert WEIGHTS[:BENT].sum() == pytest.approx(1.0)
    assert WEIGHTS[BENT:].sum() == pytest.approx(1.0)
    assert WEIGHTS[:BENT] @ XI[:BENT] ** (2 * FULL - 1) == pytest.approx(0.5 / FULL)
    assert TABLE.shape == (POINTS, 5, 16)


@pieces
@pytest.mark.parametrize("hot", [COLD, COLD + 150.0])
def test_curved_shells_are_free_of_stress_when_they_expand_and_turn(name, hot):
    case = shell(PIECES[name], material=PAPER)
    coef = case.coefficients(hot)
    growth = 1.0 + PAPER.thermal_strain(hot, COLD)
    q = case.turned(growth * case.q, Rotation.from_rotvec([2.0, -1.0, 0.7]), [3.0, -2.0, 1.0])
    size = case.stiff(coef)
    assert np.abs(case.force(q, 0 * q, coef)).max() < 1e-13 * size
    assert case.energies(q, 0 * q, coef)[0] < 1e-26 * size
    assert abs(case.term.resultants(q, 0 * q, coef)).max() < 1e-12 * size


@pieces
def test_tangent_of_heated_damped_curved_shells(name):
    case = shell(PIECES[name], material=PAPER, damping=0.02)
    rng = np.random.default_rng(4)
    c1 = case.term.coefficients(case.uneven(rng))
    coef = case.term.with_rates(case.coefficients(), c1, 0.1)[1]
    q = case.q + 0.02 * rng.standard_normal(case.q.size)
    v, d = rng.standard_normal((2, q.size))
    K = derivative(lambda s: case.force(q + s[0] * d, v, coef), np.zeros(1), 1e-3)[:, 0]
    C = derivative(lambda s: case.force(q, v + s[0] * d, coef), np.zeros(1), 1e-3)[:, 0]
    assert case.matrix(q, v, coef) @ d == pytest.approx(K, abs=1e-8 * np.abs(K).max())
    assert case.matrix(q, v, coef, 0.0, 1.0) @ d == pytest.approx(C, abs=1e-9 * np.abs(C).max())


@pieces
def test_one_element_has_six_free_motions(name):
    """At any thickness: reduced points alone would leave more."""
    s = PIECES[name]
    quad = s.quads[:1]
    one = type(s)(
        s.points[quad[0]], np.arange(4)[None], s.sizes[:1],
        s.d_u[quad[0]], s.d_v[quad[0]], s.d_uv[quad[0]],
    )  # fmt: skip
    for thickness in (0.1, 0.002):
        case = shell(one, thickness)
        K = case.matrix(case.q, 0 * case.q, case.coefficients())
        squares = np.linalg.eigvalsh(K / np.sqrt(np.outer(K.diagonal(), K.diagonal())))
        assert np.abs(squares[:6]).max() < 1e-11
        assert squares[6] > 1e-9


# -- energies of known states ------------------------------------------------------------------


def cylinder(R):
    """Plane parameters rolled onto a cylinder about y; the normal points away from its axis."""

    def shape(u, v):
        o, a = np.zeros_like(u), u / R
        r = np.stack([R * np.sin(a), v, R * np.cos(a) - R], 1)
        return (
            r,
            np.stack([np.cos(a), o, -np.sin(a)], 1),
            np.stack([o, o + 1, o], 1),
            np.zeros((u.size, 3)),
        )

    return shape


def test_energy_and_moments_of_a_plate_rolled_up():
    """D/(2 R^2) per area; M11 = -D/R, M22 = nu M11 where the normal points outward."""
    R, h, nu, n = 0.8, 0.02, 0.3, 8
    case = shell(plate(1.0, 0.5, n, 1), h)
    bent = shell(patch(cylinder(R), np.linspace(0.0, 1.0, n + 1), [0.0, 0.5]), h)
    coef, D = case.coefficients(), 70e9 * h**3 / 12.0 / (1.0 - nu**2)
    energy = case.energies(bent.q, 0 * case.q, coef)[0]
    assert energy == pytest.approx(0.5 * D / R**2 * 0.5, rel=1e-4)
    found = case.term.resultants(bent.q, 0 * case.q, coef)
    expected = [-D / R, -nu * D / R, 0.0]
    assert found[:, 3:6] == pytest.approx(np.tile(expected, (n, 1)), rel=1e-3, abs=1e-4 * D / R)
    assert np.abs(found[:, 6:]).max() < 0.02 * D / R  # no shear force where M is constant


def test_energy_and_forces_of_a_plate_stretched_and_sheared():
    h, E, nu = 0.02, 70e9, 0.3
    case = shell(plate(1.0, 0.5, 2, 2), h)
    F = np.array([[1.02, 0.01, 0.0], [0.0, 0.99, 0.0], [0.0, 0.0, 1.0]])
    q = (case.q.reshape(-1, 3) @ F.T).ravel()
    strain = 0.5 * (F.T @ F - np.eye(3))[:2, :2]
    stress = E * h / (1 - nu**2) * ((1 - nu) * strain + nu * np.trace(strain) * np.eye(2))
    found = case.term.resultants(q, 0 * q, case.coefficients())
    assert found[:, :3] == pytest.approx(
        np.tile([stress[0, 0], stress[1, 1], stress[0, 1]], (4, 1))
    )
    energy = case.energies(q, 0 * q, case.coefficients())[0]
    assert energy == pytest.approx(0.25 * np.sum(strain * stress), rel=1e-12)


def test_directions_do_not_depend_on_the_parameters():
    """The same plate in skew, uneven parameters has the same energy in the same affine state."""

    def skew(u, v):
        o = np.zeros_like(u)
        d_u, d_v = np.stack([o + 0.8, o, o], 1), np.stack([o + 0.3, o + 1.1, o], 1)
        return u[:, None] * d_u + v[:, None] * d_v, d_u, d_v, np.zeros((u.size, 3))

    F = np.array([[1.02, 0.03, 0.0], [-0.01, 0.99, 0.0], [0.0, 0.0, 1.0]])
    densities = []
    for surface, area in ((plate(1.0, 0.5, 1, 1), 0.5), (patch(skew, [0, 0.4, 1], [0, 1]), 0.88)):
        case = shell(surface)
        q = (case.q.reshape(-1, 3) @ F.T).ravel()
        densities.append(case.energies(q, 0 * q, case.coefficients())[0] / area)
    assert densities[0] == pytest.approx(densities[1], rel=1e-12)


# -- plates against closed forms ---------------------------------------------------------------


def supported(case, n_u, n_v):
    """Free coordinates of a simply supported plate; only what bends."""
    grid = numbers(case, n_v + 1)
    bending = np.zeros((grid.size, 4, 3), bool)
    bending[:, :, 2] = True
    for edge, along in ((grid[0], 2), (grid[-1], 2), (grid[:, 0], 1), (grid[:, -1], 1)):
        bending[edge, 0, 2] = bending[edge, along, 2] = False
    return np.flatnonzero(bending.ravel())


def test_deflection_of_a_supported_plate_under_pressure():
    """Navier's series, all aspects; fourth order."""
    a, b, h, p = 1.0, 0.6, 0.01, 100.0
    D = 70e9 * h**3 / 12.0 / (1.0 - 0.3**2)
    m, n = np.meshgrid(np.arange(1, 400, 2), np.arange(1, 400, 2))
    signs = np.sin(0.5 * np.pi * m) * np.sin(0.5 * np.pi * n)
    series = signs / (m * n * ((m / a) ** 2 + (n / b) ** 2) ** 2)
    exact = 16.0 * p / (np.pi**6 * D) * series.sum()
    errors = []
    for k in (2, 4, 8):
        case = shell(plate(a, b, k, k), h)
        force = pressed(case, p)
        w = solved(case, supported(case, k, k), force)[numbers(case, k + 1)[k // 2, k // 2], 0, 2]
        errors.append(abs(w / exact - 1.0))
    assert errors[0] < 0.03
    assert errors[2] < 5e-5
    assert np.log2(errors[1] / errors[2]) > 3.5


def pressed(case, pressure):
    load = Traction("p", "s", np.array([0.0, 0.0, 1.0]), lambda t: pressure)
    term = traction.build([load], case.layout)
    coef = term.coefficients(case.temperatures())
    for row, column, history in term.signals:
        coef[row, column] = history(0.0)
    out = np.zeros(case.q.size)
    kernels.add_force(term, case.q, 0 * case.q, coef, out)
    return -out


def test_frequencies_of_a_supported_plate():
    """omega = pi^2 (m^2/a^2 + n^2/b^2) (D/rho h)^1/2."""
    a, b, h, k = 1.0, 0.6, 0.01, 8
    case = shell(plate(a, b, k, k), h)
    free = supported(case, k, k)
    K, M = case.matrix(case.q, 0 * case.q, case.coefficients()), case.mass()
    squares = eigh(K[np.ix_(free, free)], M[np.ix_(free, free)], eigvals_only=True)[:5]
    m, n = np.meshgrid(np.arange(1, 6), np.arange(1, 6))
    D = 70e9 * h**2 / 12.0 / (1.0 - 0.3**2) / PLAIN.density
    exact = np.sort((np.pi**2 * ((m / a) ** 2 + (n / b) ** 2) * np.sqrt(D)).ravel())[:5]
    assert np.sqrt(squares) == pytest.approx(exact, rel=2e-3)
    assert np.sqrt(squares[0]) == pytest.approx(exact[0], rel=5e-5)


def test_a_plate_heated_on_one_side_becomes_a_sphere():
    """Free curvature alpha G both ways; the warm side, where the normal points, is outside."""
    k, G = 4, 50.0
    case = shell(plate(1.0, 0.8, k, k))
    coef = case.term.coefficients(case.temperatures(COLD, [0.0, G]))
    middle = numbers(case, k + 1)[k // 2, k // 2]
    held = 12 * middle + np.array([0, 1, 2, 4, 5, 8])  # r, and three turns
    free = np.setdiff1d(np.arange(case.q.size), held)
    force = -case.force(case.q, 0 * case.q, coef)
    moved = solved(case, free, force)[:, 0]
    x, y, _ = (case.q.reshape(-1, 4, 3)[:, 0] - case.q.reshape(-1, 4, 3)[middle, 0]).T
    curvature = 23e-6 * G
    assert moved[:, 2] == pytest.approx(-0.5 * curvature * (x**2 + y**2), rel=1e-9, abs=1e-14)
    assert np.abs(moved[:, :2]).max() < 1e-11


def test_heated_plate_held_all_around_is_stressed_as_the_closed_form_says():
    """N = -E h alpha dT/(1 - nu), M = E h^3 alpha G/(12 (1 - nu)), to the first order."""
    case, hot, G = shell(plate(1.0, 0.8, 2, 2)), COLD + 1e-3, 1e-3
    coef = case.term.coefficients(case.temperatures(hot, [0.0, G]))
    found = case.term.resultants(case.q, 0 * case.q, coef)
    N = -70e9 * 0.01 * 23e-6 * 1e-3 / 0.7
    M = 70e9 * 0.01**3 / 12.0 * 23e-6 * G / 0.7
    forces, moments = np.tile([N, N, 0.0], (4, 1)), np.tile([M, M, 0.0, 0.0, 0.0], (4, 1))
    assert found[:, :3] == pytest.approx(forces, rel=1e-6, abs=1e-8 * abs(N))
    assert found[:, 3:] == pytest.approx(moments, rel=1e-6, abs=1e-8 * abs(M))


def test_shear_force_is_that_of_equilibrium():
    """A cantilever strip under an end load: Q = P/b everywhere."""
    k, P = 4, 3.0
    case = shell(plate(1.0, 0.2, k, 1), material=POISSONLESS)
    free = np.setdiff1d(np.arange(case.q.size), np.arange(24))
    force = np.zeros((case.q.size // 12, 4, 3))
    force[-2:, 0, 2] = 0.5 * P
    x = solved(case, free, force.ravel()).ravel()
    found = case.term.resultants(case.q + 1e-6 * x, 0 * x, case.coefficients()) / 1e-6
    assert found[1:-1, 6] == pytest.approx(P / 0.2, rel=0.02)


# -- tubes -------------------------------------------------------------------------------------


def test_inextensional_vibration_of_a_ring():
    """Free ring, n waves: omega = n (n^2 - 1)/(n^2 + 1)^1/2 (E I/(rho A R^4))^1/2, Love (1927).

    A short tube that bends freely; without Poisson's ratio it is the ring.
    """
    R, h = 0.3, 0.003
    unit = np.sqrt(70e9 * h**2 / 12.0 / POISSONLESS.density) / R**2
    for n in (2, 3):
        exact, errors = n * (n**2 - 1) / np.sqrt(n**2 + 1) * unit, []
        for elements in (16, 32):
            case = shell(tube(R, 0.02, elements, 1), h, POISSONLESS)
            K, M = case.matrix(case.q, 0 * case.q, case.coefficients()), case.mass()
            found = np.sqrt(np.maximum(eigh(K, M, eigvals_only=True, subset_by_index=[6, 30]), 0.0))
            deviation = np.sort(np.abs(found / exact - 1.0))
            assert deviation[1] == pytest.approx(deviation[0], abs=1e-6)  # both phases
            errors.append(deviation[0])
        assert errors[1] < 2e-3
        assert errors[0] / errors[1] > 4.0


def test_membrane_of_a_tube_under_internal_pressure():
    """Hoop force p R, linear: small pressure, ends free."""
    R, h, p = 0.3, 0.003, 1.0
    case = shell(tube(R, 0.4, 16, 2), h)
    x = case.q.reshape(-1, 4, 3)
    grown = x.copy()
    strain = p * R / (70e9 * h)
    grown[..., :2] *= 1.0 + strain
    grown[..., 2] *= 1.0 - 0.3 * strain
    found = case.term.resultants(grown.ravel(), 0 * case.q, case.coefficients())
    assert found[:, 0] == pytest.approx(np.full(32, p * R), rel=1e-5)
    assert np.abs(found[:, 1]).max() < 1e-5 * p * R


# -- loads and bad input -----------------------------------------------------------------------


def edge_load(case, edge, direction=(0.0, 0.0, 1.0)):
    term = traction.build(
        [Traction("t", "s", np.array(direction), lambda t: 1.0, edge)], case.layout
    )
    total = np.zeros(case.q.size)
    np.add.at(total, term.dofs.ravel(), term.floats.ravel())
    return total


def test_surface_loads_are_consistent():
    """Virtual work of a pressure on any bicubic motion is its integral; the total is p A."""
    case = shell(plate(1.0, 0.6, 3, 2))
    load = edge_load(case, None).reshape(-1, 4, 3)
    assert load[:, 0, 2].sum() == pytest.approx(0.6)
    x, y, _ = case.q.reshape(-1, 4, 3)[:, 0].T
    motion = np.stack([x**3 * y**2, 3 * x**2 * y**2, 2 * x**3 * y, 6 * x**2 * y], axis=1)
    assert np.sum(load[:, :, 2] * motion) == pytest.approx(0.25 * 0.6**3 / 3.0, rel=1e-12)


@pytest.mark.parametrize("name", ["tube", "annulus"])
def test_edge_loads_are_consistent(name):
    surface = tube(0.3, 0.8, 16, 1) if name == "tube" else annulus(0.4, 0.9, 1, 6, QUARTER)
    case = shell(surface)
    grid = numbers(case, 2 if name == "tube" else 7)
    edge = (*grid[:, -1], grid[0, -1]) if name == "tube" else tuple(grid[-1])
    length = 2 * np.pi * 0.3 if name == "tube" else 0.5 * np.pi * 0.9
    load = edge_load(case, edge, (1.0, 0.0, 0.0)).reshape(-1, 4, 3)
    assert load[:, 0, 0].sum() == pytest.approx(length, rel=1e-4)
    work = np.sum(load * case.q.reshape(-1, 4, 3))  # of x on itself
    exact = 0.0 if name == "tube" else 0.9**2
    assert work == pytest.approx(exact, rel=1e-4, abs=1e-12)
    assert not load[np.setdiff1d(np.arange(len(load)), edge)].any()


def test_loads_that_cannot_be():
    case = shell(plate(1.0, 0.6, 3, 2))
    with pytest.raises(ValueError, match="nodes 0 and 4 have no common edge"):
        edge_load(case, (0, 4))
    with pytest.raises(ValueError, match="'x' is no shell"):
        traction.build([Traction("t", "x", np.ones(3), lambda t: 1.0)], case.layout)


@pytest.mark.parametrize("thickness", [0.0, -1.0, np.nan])
def test_no_thickness(thickness):
    with pytest.raises(ValueError, match="'s': its thickness must be positive"):
        shell(PIECES["plate"], thickness)


def test_no_area():
    s = PIECES["plate"]
    collapsed = s.quads[:, [0, 1, 1, 0]]
    with pytest.raises(ValueError, match="'s': an element has no area"):
        shell(type(s)(s.points, collapsed, s.sizes, s.d_u, s.d_v, s.d_uv))


# -- fine meshes -------------------------------------------------------------------------------


@pytest.mark.slow
def test_large_deflections_on_fine_meshes():
    """Sze, Liu & Lo (2004); the slit ring has converged."""
    assert shells.hemisphere(16) == pytest.approx((4.07, -8.15), rel=3e-3)
    assert shells.pulled(16) == pytest.approx((2.768, 4.551, 3.269), rel=0.0135)
    coarse, fine = shells.annulus(6, 40), shells.annulus(8, 60)
    assert fine == pytest.approx((13.891, 17.528), rel=4e-3)
    assert fine == pytest.approx(coarse, rel=1e-3)


@pytest.mark.slow
def test_pinched_cylinder_on_a_fine_mesh():
    exact = (4.0 * shells.pinched_theory(400) - shells.pinched_theory(200)) / 3.0
    assert shells.pinched(48) == pytest.approx(exact, rel=1.5e-3)
