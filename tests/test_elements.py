"""Contract of every element family, and closed forms for each."""

from dataclasses import replace
from importlib import import_module

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import eigh
from scipy.spatial.transform import Rotation

from mechanics.description import Beam
from mechanics.elements import FAMILIES
from mechanics.line_elements import MEMBRANE
from meshes.materials import constant_material, library_material
from meshes.sections import circle, general, rectangle

NODE = {"beam3243": 12, "cable": 6}
COLD = 293.15
PAPER = library_material("al6061-paper")
PLAIN = constant_material("plain", 2700.0, 70e9, 0.3, 23e-6, 160.0, 900.0)
NO_EXPANSION = constant_material("none", 1.0, 1.0, 0.0, 0.0, 1.0, 1.0).expansion
INERT = replace(PAPER, expansion=NO_EXPANSION)
RECTANGLE, ROD = rectangle(0.10, 0.06), circle(0.05)
SECTION = {"beam3243": RECTANGLE, "cable": ROD}
families = pytest.mark.parametrize("family", FAMILIES)


def straight(n, length=1.0):
    """n elements along x."""
    points = np.zeros((n + 1, 3))
    points[:, 0] = np.linspace(0.0, length, n + 1)
    return points, np.tile(np.eye(3), (n + 1, 1, 1))


def helix(n, twist=0.3):
    """n elements on a helix whose section turns about the axis as well."""
    s = np.linspace(0.0, 1.5, n + 1)
    points = np.column_stack([np.cos(s), np.sin(s), 0.4 * s])
    e1 = np.column_stack([-np.sin(s), np.cos(s), 0.4 + 0 * s]) / np.hypot(1.0, 0.4)
    e2 = np.column_stack([-np.cos(s), -np.sin(s), 0 * s])
    axes = np.stack([e1, e2, np.cross(e1, e2)], axis=1)
    turn = Rotation.from_rotvec(twist * s[:, None] * e1)
    return points, np.stack([turn.apply(axes[:, i]) for i in range(3)], axis=1)


def make(family, shape, section=None, material=PAPER, damping=0.0):
    """Term of one beam, its reference coordinates and node count."""
    points, axes = shape
    section = SECTION[family] if section is None else section
    beam = Beam("b", points, axes, section, material, COLD, damping, family)
    module = import_module(FAMILIES[family].split(":")[0])
    n = len(points)
    term = module.build([beam], {"b": NODE[family] * np.arange(n)}, {"b": np.arange(n)})
    return term, module.coordinates(beam).ravel(), n


def temperatures(n, mean=COLD, gradient=(0.0, 0.0)):
    return np.tile([mean, *gradient], (n, 1)).astype(float)


def uneven(n, rng):
    return np.column_stack([COLD + 80 * rng.random(n), 300 * rng.standard_normal((n, 2))])


def force(term, q, v, coef):
    out = np.zeros_like(q)
    term.force(q, v, coef, out)
    return out


def matrix(term, q, v, coef, cK, cC):
    k = term.dofs.shape[1]
    blocks = np.full((len(term.names), k, k), np.nan)
    term.tangent(q, v, coef, cK, cC, blocks)
    return assembled(term, blocks, q.size)


def assembled(term, blocks, n):
    K = np.zeros((n, n))
    for dofs, block in zip(term.dofs, blocks, strict=True):
        K[np.ix_(dofs, dofs)] += block
    return K


def derivative(f, x, h=2e-3):
    """Jacobian by central differences, extrapolated twice (error h^6)."""

    def central(i, step):
        d = np.zeros_like(x)
        d[i] = step
        return (f(x + d) - f(x - d)) / (2.0 * step)

    columns = []
    for i in range(x.size):
        a, b, c = (central(i, h / 2**k) for k in range(3))
        columns.append((16.0 * (4 * c - b) / 3 - (4 * b - a) / 3) / 15.0)
    return np.stack(columns, axis=-1)


def vectors(q):
    return q.reshape(-1, 3)


def turned(q, rotation, shift=(0.0, 0.0, 0.0), node=12):
    """All vectors rotated, positions shifted as well."""
    x = rotation.apply(vectors(q)).reshape(-1, node // 3, 3)
    x[:, 0] += shift
    return x.ravel()


def spun(q, omega):
    return np.cross(omega, vectors(q)).ravel()


def scale(coef, q):
    """Size of a force that strains of 1 would make."""
    return np.abs(coef[:, : coef.shape[1] // 2]).max()


def relax(term, q, coef, external, free, steps=1, tolerance=1e-12):
    """Dense Newton with load steps; singular directions (rigid motions) are left alone."""
    q = q.copy()
    rest = np.zeros_like(q)
    for step in range(1, steps + 1):
        for _ in range(60):
            residual = (force(term, q, rest, coef) - step / steps * external)[free]
            K = matrix(term, q, rest, coef, 1.0, 0.0)[np.ix_(free, free)]
            dq = np.linalg.lstsq(K, -residual, rcond=1e-13)[0]
            q[free] += dq * min(1.0, 0.3 / max(np.abs(dq).max(), 1e-300))
            if np.abs(dq).max() < tolerance:
                break
        else:
            raise AssertionError("Newton did not converge")
    return q


def clamped(n, node=12):
    """Coordinates left free when the first node's position and section are held.

    For a cable along x: position and direction, so that it may still be stretched there.
    """
    held = [0, 1, 2, *range(6, 12)] if node == 12 else [0, 1, 2, 4, 5]
    return np.setdiff1d(np.arange(node * n), held)


# -- contract ----------------------------------------------------------------------------------


@families
def test_curved_reference_is_free_of_stress_and_rigid_motion_keeps_it(family):
    term, q, n = make(family, helix(3))
    coef = term.coefficients(temperatures(n))
    rotation = Rotation.from_rotvec([1.1, -2.0, 0.7])
    for state in (q, turned(q, rotation, (3.0, -40.0, 65.0), NODE[family])):
        assert np.abs(force(term, state, 0 * q, coef)).max() < 1e-12 * scale(coef, q)
        assert term.energy(state, coef) < 1e-24 * scale(coef, q)


@families
def test_forces_turn_with_the_body(family):
    rng = np.random.default_rng(2)
    term, q, n = make(family, helix(3), damping=1e-3)
    coef = term.coefficients(uneven(n, rng))
    q = q + 0.05 * rng.standard_normal(q.size)
    v = rng.standard_normal(q.size)
    rotation = Rotation.from_rotvec([0.4, 2.0, -1.3])
    there = turned(q, rotation, node=NODE[family])
    f = rotation.apply(vectors(force(term, q, v, coef))).ravel()
    spin = spun(there, [2.0, -1.0, 0.5])
    v_there = rotation.apply(vectors(v)).ravel() + spin
    assert force(term, there, v_there, coef) == pytest.approx(f, abs=1e-11 * np.abs(f).max())
    assert term.energy(there, coef) == pytest.approx(term.energy(q, coef), rel=1e-11)


@families
@pytest.mark.parametrize("damping", [0.0, 2e-3])
def test_tangent_is_the_derivative_of_the_force(family, damping):
    rng = np.random.default_rng(3)
    term, q, n = make(family, helix(2), damping=damping)
    coef = term.coefficients(uneven(n, rng))
    q = q + 0.04 * rng.standard_normal(q.size)
    v = rng.standard_normal(q.size)
    K = derivative(lambda x: force(term, x, v, coef), q)
    C = derivative(lambda x: force(term, q, x, coef), v)
    expected = 0.7 * K - 0.3 * C
    found = matrix(term, q, v, coef, 0.7, -0.3)
    assert np.abs(found - expected).max() < 1e-9 * np.abs(expected).max()


@families
def test_force_is_the_gradient_of_the_energy(family):
    rng = np.random.default_rng(4)
    term, q, n = make(family, helix(2))
    coef = term.coefficients(uneven(n, rng))
    q = q + 0.04 * rng.standard_normal(q.size)
    gradient = derivative(lambda x: np.array(term.energy(x, coef)), q)
    f = force(term, q, 0 * q, coef)
    assert f == pytest.approx(gradient, abs=1e-9 * np.abs(f).max())


@families
def test_uniform_expansion_of_a_curved_body_is_free_of_stress(family):
    term, q, n = make(family, helix(3))
    hot = COLD + 120.0
    coef = term.coefficients(temperatures(n, hot))
    grown = q * (1.0 + PAPER.thermal_strain(hot, COLD))
    assert np.abs(force(term, grown, 0 * q, coef)).max() < 1e-12 * scale(coef, q)
    assert np.abs(force(term, q, 0 * q, coef)).max() > 1e-3 * scale(coef, q)


@families
def test_damping_takes_energy_but_not_from_rigid_motion(family):
    rng = np.random.default_rng(5)
    term, q, n = make(family, helix(3), damping=1e-2)
    coef = term.coefficients(temperatures(n))
    q = q + 0.03 * rng.standard_normal(q.size)
    v = rng.standard_normal(q.size)
    damping = force(term, q, v, coef) - force(term, q, 0 * q, coef)
    power, heating = term.damping(q, v, coef)
    assert heating == 0.0
    assert power > 0.0
    assert v @ damping == pytest.approx(power, rel=1e-10)
    spin = spun(q, [1.0, -2.0, 0.5])
    assert term.damping(q, spin, coef)[0] < 1e-24 * power
    rigid = force(term, q, spin, coef) - force(term, q, 0 * q, coef)
    assert np.abs(rigid).max() < 1e-11 * np.abs(damping).max()


@families
def test_a_body_that_expands_freely_is_not_damped(family):
    term, q, n = make(family, helix(3), damping=1e-2)
    warm, hot, h = COLD + 60.0, COLD + 61.0, 0.5
    c0, c1 = term.with_rates(
        term.coefficients(temperatures(n, warm)), term.coefficients(temperatures(n, hot)), h
    )
    growth = [1.0 + PAPER.thermal_strain(T, COLD) for T in (warm, hot)]
    middle, v = 0.5 * sum(growth) * q, (growth[1] - growth[0]) / h * q
    coef = 0.5 * (c0 + c1)
    still = 0.5 * (
        term.coefficients(temperatures(n, warm)) + term.coefficients(temperatures(n, hot))
    )
    elastic = force(term, middle, 0 * v, still)
    resisted = force(term, middle, v, still) - elastic
    damping = force(term, middle, v, coef) - elastic
    assert np.abs(damping).max() < 1e-6 * np.abs(resisted).max()
    assert term.damping(middle, v, coef)[0] < 1e-8 * term.damping(middle, v, still)[0]


@families
def test_power_of_damping_is_lost_or_works_on_free_strains(family):
    rng = np.random.default_rng(15)
    term, q, n = make(family, helix(3), damping=1e-2)
    cold, hot = term.coefficients(temperatures(n)), term.coefficients(uneven(n, rng))
    coef = term.with_rates(cold, hot, 2.0)[1]
    q, v = q + 0.03 * rng.standard_normal(q.size), rng.standard_normal(q.size)
    damping = (
        force(term, q, v, coef)
        - force(term, q, v, hot)
        + (force(term, q, v, hot) - force(term, q, 0 * v, hot))
    )
    assert v @ damping == pytest.approx(sum(term.damping(q, v, coef)), rel=1e-9)


@families
def test_internal_forces_keep_momentum_and_angular_momentum(family):
    rng = np.random.default_rng(6)
    term, q, n = make(family, helix(3), damping=1e-2)
    coef = term.coefficients(uneven(n, rng))
    q = q + 0.05 * rng.standard_normal(q.size)
    f = force(term, q, rng.standard_normal(q.size), coef)
    size = np.abs(f).max()
    assert np.abs(vectors(f)[:: NODE[family] // 3].sum(axis=0)).max() < 1e-12 * size
    assert np.abs(np.cross(vectors(q), vectors(f)).sum(axis=0)).max() < 1e-11 * size


@families
def test_mass_of_translation_and_of_rotation(family):
    length, omega = 2.0, np.array([0.3, -1.1, 0.7])
    term, q, n = make(family, straight(3, length), material=PLAIN)
    M = assembled(term, term.mass_blocks(), q.size)
    assert np.array_equal(M, M.T)
    s, rho = SECTION[family], PLAIN.density
    velocity = np.array([1.0, -2.0, 0.5])
    v = np.zeros((n, NODE[family]))
    v[:, :3] = velocity
    assert v.ravel() @ M @ v.ravel() == pytest.approx(
        rho * s.area * length * velocity @ velocity, rel=1e-13
    )
    line = rho * s.area * length**3 / 3.0
    rotary = np.zeros(3)
    if family == "beam3243":
        moments = [s.polar_moment, s.second_moment_3, s.second_moment_2]
        rotary = rho * length * np.array(moments)
    inertia = np.array([0.0, line, line]) + rotary
    spin = spun(q, omega)
    assert spin @ M @ spin == pytest.approx(omega**2 @ inertia, rel=1e-13)


@families
def test_bodies_of_one_term_do_not_mix(family):
    module = import_module(FAMILIES[family].split(":")[0])
    node, rng = NODE[family], np.random.default_rng(7)
    shapes, materials = [helix(2), straight(3)], [PAPER, PLAIN]
    beams = [
        Beam(name, *shape, SECTION[family], material, COLD, damping, family)
        for name, shape, material, damping in zip("ab", shapes, materials, (0.0, 1e-2), strict=True)
    ]
    nodes = {"a": 12 + node * np.arange(3), "b": 12 + node * np.arange(3, 7)}
    points = {"a": np.array([6, 0, 1]), "b": np.array([2, 5, 3, 4])}
    both = module.build(beams, nodes, points)
    T = uneven(7, rng)
    q, v = rng.standard_normal((2, 12 + 7 * node))
    found = force(both, q, v, both.coefficients(T))
    expected = np.zeros_like(q)
    for beam in beams:
        alone = module.build([beam], nodes, points)
        alone.force(q, v, alone.coefficients(T), expected)
    assert both.names == ["a", "a", "b", "b", "b"]
    assert found == pytest.approx(expected, rel=1e-12)


def test_frequency_of_a_heated_cantilever_grows_with_its_section():
    """f^2 ~ E I/(m l^3), I and l of the expanded body, its mass m constant: E (1 + e)."""
    hot, squares = COLD + 150.0, []
    for material, T in ((PAPER, COLD), (PAPER, hot)):
        term, q, n = make("beam3243", straight(6), material=material)
        coef = term.coefficients(temperatures(n, T))
        q = q * (1.0 + material.thermal_strain(T, COLD))
        free = clamped_and_breathing(n)
        K = matrix(term, q, 0 * q, coef, 1.0, 0.0)[np.ix_(free, free)]
        M = assembled(term, term.mass_blocks(), q.size)[np.ix_(free, free)]
        squares.append(eigh(K, M, eigvals_only=True, subset_by_index=[0, 0])[0])
    strain = PAPER.thermal_strain(hot, COLD)
    ratio = PAPER.youngs_modulus(hot) / PAPER.youngs_modulus(COLD) * (1.0 + strain)
    assert squares[1] / squares[0] == pytest.approx(ratio, rel=2e-5)


@families
def test_elongation_follows_the_modulus_along_the_bar(family):
    """Small pull F on a straight bar of uneven temperature: int F/(E(T) A) dx."""
    term, q, n = make(family, straight(8), material=INERT)
    T = temperatures(n)
    T[:, 0] = np.linspace(150.0, 440.0, n)
    pull = np.zeros_like(q)
    pull[-NODE[family]] = F = 1e-7 * 69e9 * SECTION[family].area
    found = relax(term, q, term.coefficients(T), pull, clamped(n, NODE[family]))
    x = np.linspace(0.0, 1.0, 20001)
    compliance = np.trapezoid(1.0 / INERT.youngs_modulus(150.0 + 290.0 * x), x)
    elongation = F / SECTION[family].area * compliance
    assert found[-NODE[family]] - 1.0 == pytest.approx(elongation, rel=1e-5)


@families
def test_held_bar_presses_as_it_warms(family):
    """Both ends held: W = s^3 EA e^2/2 with Green's strain e = (l^2/s^2 - 1)/2 of the body
    expanded by s gives dW/dl = EA s (1/s^2 - 1)/2 at l = 1."""
    term, q, n = make(family, straight(2))
    coef = term.coefficients(temperatures(n, COLD + 10.0))
    N = term.resultants(q, 0 * q, coef)[:, 0]
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
    term, q, n = make(family, straight(8), slender, soft)
    load = np.zeros_like(q)
    load[1 - NODE[family]] = 10.0 * EI
    coef = term.coefficients(temperatures(n))
    found = relax(term, q, coef, load, clamped(n, NODE[family]), 20, tolerance=1e-7)
    tip = found[-NODE[family] :]
    assert tip[1] == pytest.approx(0.81060902, rel=1e-3)
    assert 1.0 - tip[0] == pytest.approx(0.55499560, rel=1e-3)


@families
def test_first_frequency_of_a_slender_cantilever(family):
    """omega = lambda^2 sqrt(EI/(rho A L^4)) with the modulus at the temperature."""
    warm, slender = COLD + 100.0, circle(0.004)
    term, q, n = make(family, straight(6), slender, INERT)
    K = matrix(term, q, 0 * q, term.coefficients(temperatures(n, warm)), 1.0, 0.0)
    M = assembled(term, term.mass_blocks(), q.size)
    free = np.ix_(*[clamped(n, NODE[family])] * 2)
    omega = np.sqrt(eigh(K[free], M[free], eigvals_only=True)[:2])
    EI = INERT.youngs_modulus(warm) * slender.second_moment_2
    expected = 1.8751041**2 * np.sqrt(EI / (INERT.density * slender.area))
    assert omega == pytest.approx(expected, rel=1e-4)


# -- beam3243 ----------------------------------------------------------------------------------


def tip_load(term, q, n, load, coef):
    external = np.zeros_like(q)
    external[-12:] = load
    return relax(term, q, coef, external, clamped(n)) - q


def test_one_beam_element_bends_and_shears_like_timoshenko():
    """w = F L^3/(3 EI) + F L/(k_s GA), in both directions, E and G at the temperature."""
    warm = COLD + 60.0
    term, q, n = make("beam3243", straight(1), material=INERT)
    coef = term.coefficients(temperatures(n, warm))
    E, G, s = INERT.youngs_modulus(warm), INERT.shear_modulus(warm), RECTANGLE
    for axis, moment, k in (
        (1, s.second_moment_2, s.shear_factor_2),
        (2, s.second_moment_3, s.shear_factor_3),
    ):
        load = np.zeros(12)
        load[axis] = F = 1e-5 * E * moment
        w = tip_load(term, q, n, load, coef)[12 + axis]
        assert w == pytest.approx(F / (3 * E * moment) + F / (k * G * s.area), rel=1e-7)


def test_torsion_of_a_beam_uses_the_torsion_constant():
    """Moment on d2, d3 at the tip: angle M L/(G J)."""
    term, q, n = make("beam3243", straight(3), material=INERT)
    coef = term.coefficients(temperatures(n))
    G, J = INERT.shear_modulus(COLD), RECTANGLE.torsion_constant
    M = 1e-6 * G * J
    load = np.zeros(12)
    load[[8, 10]] = M / 2, -M / 2
    moved = tip_load(term, q, n, load, coef)
    assert moved[-12 + 8] == pytest.approx(M / (G * J), rel=1e-9)
    resultants = term.resultants(q + moved, 0 * q, coef)
    assert resultants[:, 3] == pytest.approx(M, rel=1e-6)


def test_first_torsional_frequency_of_a_cantilever():
    """omega = pi/2 sqrt(G J/(rho (I2 + I3))) / L: torsion constant against polar moment."""
    term, q, n = make("beam3243", straight(16), material=INERT)
    K = matrix(term, q, 0 * q, term.coefficients(temperatures(n)), 1.0, 0.0)
    M = assembled(term, term.mass_blocks(), q.size)
    d2_d3 = [[12 * i + 8, 12 * i + 10] for i in range(1, n)]
    turn = np.zeros((q.size, n - 1))
    for i, (up, down) in enumerate(d2_d3):
        turn[up, i], turn[down, i] = 1.0, -1.0
    omega = np.sqrt(eigh(turn.T @ K @ turn, turn.T @ M @ turn, eigvals_only=True)[0])
    GJ = INERT.shear_modulus(COLD) * RECTANGLE.torsion_constant
    expected = np.pi / 2 * np.sqrt(GJ / (INERT.density * RECTANGLE.polar_moment))
    assert omega == pytest.approx(expected, rel=5e-4)


def test_resultants_of_a_cantilever():
    """Tip forces F2, F3 and N: constant forces, moments F (L - x) at the middle of elements."""
    term, q, n = make("beam3243", straight(4), material=INERT)
    coef = term.coefficients(temperatures(n))
    load = np.zeros(12)
    load[:3] = N, F2, F3 = 3.0, 0.2, -0.3
    found = term.resultants(q + tip_load(term, q, n, load, coef), 0 * q, coef)
    arm = 1.0 - (np.arange(4) + 0.5) / 4
    expected = np.column_stack([np.tile([N, F2, F3, 0.0], (4, 1)), F2 * arm, F3 * arm])
    assert found == pytest.approx(expected, rel=5e-5, abs=1e-6)


@pytest.mark.parametrize(("gradient", "tip_error"), [(50.0, 1e-9), (2000.0, 1e-6)])
def test_one_element_bows_freely_under_a_gradient(gradient, tip_error):
    """Free of stress with curvature alpha G; the warm side is outside."""
    term, q, n = make("beam3243", straight(1), material=PAPER)
    hot = COLD + 40.0
    coef = term.coefficients(temperatures(n, hot, (gradient, -0.5 * gradient)))
    bent = relax(term, q, coef, 0 * q, np.arange(q.size), 1)
    kappa = PAPER.expansion(hot) * gradient * np.array([-1.0, 0.5])
    k, growth = np.hypot(*kappa), 1.0 + PAPER.thermal_strain(hot, COLD)
    assert term.energy(bent, coef) < 1e-20 * coef[:, 3:7].sum() * k**2
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
    term, q, n = make("beam3243", straight(1, L), material=PLAIN)
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
    slack = min(1.0, MEMBRANE * radius2 / L**2)
    U = E * s.area * L / 2 * (c[0] ** 2 + 3 * c[1] ** 2 + 5 * slack * c[2] ** 2)
    points = 0.5 - 0.5 / np.sqrt(3), 0.5 + 0.5 / np.sqrt(3)
    b = np.array([[bending(k, xi) for xi in points] for k in range(2)])
    U += E * L / 4 * (np.array([s.second_moment_2, s.second_moment_3]) @ b**2).sum()
    for k, factor in enumerate((s.shear_factor_2, s.shear_factor_3)):
        U += factor * G * s.area * L / 4 * (shear(k, 0.0) ** 2 + shear(k, 1.0) ** 2)
    for d in (a2, b2, a3, b3):
        U += E * s.area * L / 4 * ((d @ d - 1) / 2) ** 2
    U += G * s.area * L / 4 * ((a2 @ a3) ** 2 + (b2 @ b3) ** 2)
    magnus = np.sqrt(3) / 12 * L * (b[0, 0] * b[1, 1] - b[1, 0] * b[0, 1])
    U += G * s.torsion_constant * L / 2 * ((a3 @ b2 - a2 @ b3) / (2 * L) - magnus) ** 2
    assert term.energy(q, term.coefficients(temperatures(n))) == pytest.approx(U, rel=1e-12)


def test_thick_beam_converges_to_the_rod_of_reissner_on_any_mesh():
    """Nachbagauer et al. (2011): h = L/4, bending strain 12 %; 1e-4 is left to Green's strain."""
    nu, h, w, F = 0.3, 0.5, 0.1, 5e8 * 0.5**3
    factor = 10 * (1 + nu) / (12 + 11 * nu)
    steel = constant_material("steel", 7850.0, 2.07e11, nu, 0.0, 1.0, 1.0)
    thick = general(h * w, w * h**3 / 12, h * w**3 / 12, h * w**3 / 3, factor, factor)
    for elements, error in ((8, 3e-4), (32, 1e-4)):
        term, q, n = make("beam3243", straight(elements, 2.0), thick, steel)
        load = np.zeros_like(q)
        load[-11] = F
        coef = term.coefficients(temperatures(n))
        moved = relax(term, q, coef, load, clamped_and_breathing(n), 4, 1e-9) - q
        assert -moved[-12] == pytest.approx(0.1509711442, rel=error)
        assert moved[-11] == pytest.approx(0.7105685979, rel=error)


def clamped_and_breathing(n):
    """Free coordinates when position and section of the first node are held but for its size."""
    return np.setdiff1d(np.arange(12 * n), [0, 1, 2, 6, 8, 9, 10])


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
        term, q, n = make("beam3243", straight(elements, 2.0), section, steel)
        coef = term.coefficients(temperatures(n))
        found = q
        for _ in range(20):  # the moment on the directors as they are, until they stay
            d2, d3 = found[-6:-3], found[-3:]
            J = (d2 @ d2 + d3 @ d3) * np.eye(3) - np.outer(d2, d2) - np.outer(d3, d3)
            load, w = np.zeros_like(q), np.linalg.solve(J, m)
            load[-6:-3], load[-3:] = np.cross(w, d2), np.cross(w, d3)
            found = relax(term, q, coef, load, clamped_and_breathing(n))
        moved = found[-12:-9] - [2.0, 0.0, 0.0]
        assert moved == pytest.approx(tip - [2.0, 0.0, 0.0], rel=error)


# -- cable -------------------------------------------------------------------------------------


def test_strains_of_the_cable_as_defined():
    """Tension and bending energy of a random state of a straight cable, by its definitions."""
    rng = np.random.default_rng(9)
    L = 0.7
    term, q, n = make("cable", straight(1, L), material=PLAIN)
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
    assert term.energy(q, term.coefficients(temperatures(n))) == pytest.approx(U, rel=1e-12)


def test_naturally_curved_cable_resists_bending_from_its_own_curvature():
    """One that is bent to half its curvature carries the moment EI (kappa - kappa_ref)."""

    def arc(radius, angle, n=8):
        s = np.linspace(0.0, angle, n + 1)
        e1 = np.column_stack([np.cos(s), np.sin(s), 0 * s])
        e2 = np.column_stack([-np.sin(s), np.cos(s), 0 * s])
        points = radius * np.column_stack([np.sin(s), 1 - np.cos(s), 0 * s])
        return points, np.stack([e1, e2, np.tile([0.0, 0.0, 1.0], (n + 1, 1))], axis=1)

    term, q, n = make("cable", arc(1.0, 1.0), material=PLAIN)
    _, bent, _ = make("cable", arc(2.0, 0.5), material=PLAIN)
    coef = term.coefficients(temperatures(n))
    M = term.resultants(bent, 0 * q, coef)[:, 4]
    assert pytest.approx(70e9 * ROD.second_moment_2 * 0.5, rel=1e-3) == M
    EI = 70e9 * ROD.second_moment_2
    assert term.energy(bent, coef) == pytest.approx(EI / 8.0, rel=1e-3)


def test_cable_refuses_a_section_that_bends_unalike():
    with pytest.raises(ValueError, match="cable 'b' bends alike"):
        make("cable", straight(1), RECTANGLE)
