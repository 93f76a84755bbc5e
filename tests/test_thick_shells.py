"""Contract of both thick shell families, and closed forms that both must meet."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.spatial.transform import Rotation
from shell_cases import COLD, PLAIN, case, curved, force, mass, relax, stiffness
from slopes import jacobian, slopes

from mechanics import kernels
from meshes.materials import constant_material, library_material
from meshes.surfaces import plate, tube

E, NU, ALPHA = 70e9, 0.3, 23e-6
families = pytest.mark.parametrize("family", ["shell24", "shell3443"])
all_families = pytest.mark.parametrize("family", ["shell24", "shell3443", "naive"])
TURN = Rotation.from_rotvec([1.9, -1.2, 2.1])


def uneven(c, rng):
    """Section temperatures that differ from node to node."""
    T = c.T.copy()
    T[:, 0] += 80.0 * rng.random(len(T))
    T[:, 2] += 300.0 * rng.standard_normal(len(T))
    return T


def turned(c, q, shift=(0.0, 0.0, 0.0)):
    x = TURN.apply(q.reshape(-1, 3)).reshape(len(c.T), -1, 3)
    x[:, 0] += shift
    return x.ravel()


def heating(c, rng):
    """Coefficients in the middle of heating up, with their rates."""
    before, after = c.term.coefficients(uneven(c, rng)), c.term.coefficients(uneven(c, rng))
    return c.term.with_rates(before, after, 0.5)[1]


@all_families
def test_any_reference_is_free_of_stress_wherever_it_is(family):
    c = case(family, curved())
    for q in (c.q, turned(c, c.q, (3.0, -1.0, 2.0))):
        assert np.abs(force(c, q, c.coef)).max() < 1e-14 * E
        assert abs(kernels.energies(c.term, q, 0 * q, c.coef)[0]) < 1e-20 * E


@all_families
def test_forces_turn_with_the_shell(family):
    rng = np.random.default_rng(1)
    c = case(family, curved(), damping=0.1)
    coef = heating(c, rng)
    q, v = c.q + 0.1 * rng.standard_normal(c.q.size), rng.standard_normal(c.q.size)
    here = turned(c, force(c, q, coef, v))
    there = force(c, turned(c, q, (0.3, 1.0, -2.0)), coef, turned(c, v))
    assert there == pytest.approx(here, abs=1e-13 * np.abs(here).max())


@families
def test_spin_makes_no_damping_force(family):
    c = case(family, curved(), damping=0.1)
    q = c.q + 0.05 * np.random.default_rng(2).standard_normal(c.q.size)
    v = np.cross([0.3, -2.0, 1.0], q.reshape(-1, 3)).ravel()
    still = force(c, q, c.coef)
    assert force(c, q, c.coef, v) == pytest.approx(still, abs=1e-13 * np.abs(still).max())


@all_families
def test_forces_and_moments_vanish_in_sum(family):
    rng = np.random.default_rng(3)
    c = case(family, curved(), damping=0.1)
    q, v = c.q + 0.1 * rng.standard_normal(c.q.size), rng.standard_normal(c.q.size)
    f = force(c, q, heating(c, rng), v)
    size = np.abs(f).max()
    assert np.abs(c.vectors(f)[:, 0].sum(axis=0)).max() < 1e-13 * size
    moments = np.cross(q.reshape(-1, 3), f.reshape(-1, 3)).sum(axis=0)
    assert np.abs(moments).max() < 1e-13 * size


@all_families
@pytest.mark.parametrize("damping", [0.0, 0.2])
def test_tangent_is_the_derivative_of_the_force(family, damping):
    rng = np.random.default_rng(4)
    c = case(family, curved(1, 1), damping=damping)
    q, v = c.q + 0.1 * rng.standard_normal(c.q.size), rng.standard_normal(c.q.size)
    coef = heating(c, rng)
    expected = 0.7 * slopes(lambda x: force(c, x, coef, v), q)
    expected += 0.3 * slopes(lambda x: force(c, q, coef, x), v)
    found = jacobian(c.term, q, v, coef, 0.7, 0.3)
    assert found == pytest.approx(expected, abs=1e-9 * np.abs(expected).max())
    assert c.term.symmetric is (damping == 0.0)


@all_families
def test_force_is_the_gradient_of_the_energy(family):
    rng = np.random.default_rng(5)
    c = case(family, curved(1, 1))
    q, coef = c.q + 0.1 * rng.standard_normal(c.q.size), c.term.coefficients(uneven(c, rng))
    found = force(c, q, coef)
    energy = slopes(lambda x: kernels.energies(c.term, x, 0 * x, coef)[:1], q)[0]
    assert found == pytest.approx(energy, abs=1e-8 * np.abs(energy).max())


@families
def test_predicted_stress_is_that_of_the_linear_step(family):
    """Force at the new place with the stress S + D B dq, by differences of the stress."""
    rng = np.random.default_rng(8)
    c = case(family, curved(1, 1))
    q, step = c.q + 0.05 * rng.standard_normal(c.q.size), 0.1 * rng.standard_normal(c.q.size)
    new, rest = q + 0.5 * step, 0.0 * q
    found = c.term.predicted(c.coef, q, step, new)
    N = [c.term.resultants(q + h * step, rest, c.coef) for h in (-0.5, 0.0, 0.5)]
    linear = N[1] + N[2] - N[0]
    assert c.term.resultants(new, rest, found) == pytest.approx(linear, rel=1e-9)
    assert c.term.resultants(new, rest, c.coef) != pytest.approx(linear, rel=1e-2)


@families
def test_power_of_damping_is_lost_or_done_on_free_strains(family):
    rng = np.random.default_rng(6)
    c = case(family, curved(), damping=0.1)
    q, v = c.q + 0.1 * rng.standard_normal(c.q.size), 1e-2 * rng.standard_normal(c.q.size)
    coef = heating(c, rng)
    still = c.term.with_rates(coef, coef, 1.0)[0]
    _, lost, done = kernels.energies(c.term, q, v, coef)
    viscous = force(c, q, coef, v) - force(c, q, still)
    assert lost > 0.0 and abs(done) > 1e-3 * lost
    assert v @ viscous == pytest.approx(lost + done, rel=1e-12)


@families
def test_free_expansion_meets_no_damping(family):
    """It grows at the rate of its thermal stretch: no stress, nothing lost."""
    c = case(family, curved(), material=PLAIN, damping=0.5)
    warmer, step = np.array([1.0, 0.0, 0.0]), 1e-3
    T = c.T + 10.0 * warmer
    ends = [c.term.coefficients(T + side * step / 2 * warmer) for side in (-1.0, 1.0)]
    before, after = c.term.with_rates(*ends, step)
    coef = 0.5 * (before + after)
    grown = (1.0 + 10.0 * ALPHA) * c.q
    f, held = (force(c, grown, coef, rate * c.q) for rate in (ALPHA, 0.0))
    assert np.abs(f).max() < 1e-6 * np.abs(held).max()
    lost, done = kernels.energies(c.term, grown, ALPHA * c.q, coef)[1:]
    assert max(abs(lost), abs(done)) < 1e-6 * kernels.energies(c.term, grown, 0 * c.q, coef)[1]


@all_families
def test_tube_expands_freely(family):
    """Uniformly heated: free of stress to round-off though a tube is no set of flat elements."""
    c = case(family, tube(0.4, 1.0, 8, 2), 0.02, library_material("al6061-paper"))
    T = c.T.copy()
    T[:, 0] = COLD + 90.0
    coef = c.term.coefficients(T)
    stretch = 1.0 + library_material("al6061-paper").thermal_strain(COLD + 90.0, COLD)
    pressed = force(c, c.q, coef)
    assert np.abs(force(c, stretch * c.q, coef)).max() < 1e-12 * np.abs(pressed).max()
    assert np.abs(c.term.resultants(stretch * c.q, 0 * c.q, coef)).max() < 1e-12 * E * 0.02 * 0.002


@families
def test_plate_bows_freely_under_a_gradient(family):
    """Curvature alpha G in both directions, the warm side outside, free of stress."""
    c = case(family, plate(1.0, 0.8, 3, 2), 0.05)
    T, G = c.T.copy(), 0.01
    T[:, 2] = G
    coef = c.term.coefficients(T)
    fixed = [*c.at(0, 0), *c.at(2, 0, 0, 2), *c.at(9, 0, 2)]
    q = relax(c, coef, 0 * c.q, fixed, tolerance=1e-13)
    start, end = c.vectors(q)[0, -1], c.vectors(q)[-1, -1]
    turn = end - start
    assert turn[:2] == pytest.approx([ALPHA * G, 0.8 * ALPHA * G], rel=1e-5)
    held = np.abs(c.term.resultants(c.q, 0 * c.q, coef)).max()
    left = np.abs(c.term.resultants(q, 0 * q, coef))
    assert left[:, 3:].max() < 1e-9 * held  # bent into a dome, it must stretch a little
    assert left[:, :3].max() < E * 0.05 * (ALPHA * G) ** 2


@families
def test_moduli_follow_the_mean_temperature(family):
    """E(T) and nu(T) of the paper against constants of the same values."""
    paper = library_material("al6061-paper")
    paper = replace(paper, expansion=constant_material("0", 1, 1, 0, 0.0, 1, 1).expansion)
    warm = COLD + 75.0
    twin = constant_material(
        "twin", 1.0, paper.youngs_modulus(warm), paper.poissons_ratio(warm), 0.0, 1.0, 1.0
    )
    a, b = (case(family, curved(), material=m) for m in (paper, twin))
    T = a.T.copy()
    T[:, 0] = warm
    q = a.q + 0.05 * np.random.default_rng(7).standard_normal(a.q.size)
    hot, same = force(a, q, a.term.coefficients(T)), force(b, q, b.coef)
    assert hot == pytest.approx(same, abs=1e-12 * np.abs(same).max())
    assert np.abs(hot - force(a, q, a.coef)).max() > 1e-2 * np.abs(hot).max()


@families
def test_kinetic_energy_of_a_moving_plate(family):
    """Mass and moments of inertia of a box."""
    a, b, h = 1.0, 0.8, 0.2
    c = case(family, plate(a, b, 3, 2), h)
    m = 2700.0 * a * b * h
    M = mass(c).toarray()
    blocks = c.term.mass_blocks()
    assert np.array_equal(blocks, blocks.transpose(0, 2, 1))
    v = np.zeros((len(c.T), c.layout.kinds["s"] // 3, 3))
    v[:, 0] = [1.0, -2.0, 0.5]
    assert v.ravel() @ M @ v.ravel() == pytest.approx(m * 5.25, rel=1e-12)
    spin = np.array([0.7, -1.1, 0.4])
    x = c.vectors(c.q).copy()
    x[:, 0] -= [a / 2, b / 2, 0.0]
    v = np.cross(spin, x)
    inertia = m / 12.0 * np.array([b**2 + h**2, a**2 + h**2, a**2 + b**2])
    assert v.ravel() @ M @ v.ravel() == pytest.approx(inertia @ spin**2, rel=1e-12)


def flat(c, r_z, slope_x, slope_y, n):
    """Small displacement r_z (nodes,) [m] with its slopes, and dn (nodes, 2) of a flat plate."""
    u = np.zeros_like(c.vectors(c.q))
    X = c.vectors(c.q)
    u[:, 0, 2] = r_z
    u[:, -1, :2] = n
    for k in range(1, u.shape[1] - 1):
        u[:, k, 2] = slope_x * X[:, k, 0] + slope_y * X[:, k, 1]
    return u.ravel()


@families
def test_resultants_of_stretched_bent_and_sheared_plates(family):
    h, D = 0.05, E * 0.05**3 / 12 / (1 - NU**2)
    c = case(family, plate(1.0, 0.8, 2, 2), h)
    x, y = c.vectors(c.q)[:, 0, :2].T
    small = 1e-7
    pulled = c.vectors(c.q) * np.array([1.0 + small, 1.0, 1.0])
    pull = c.term.resultants(pulled.ravel(), 0 * c.q, c.coef)[0]
    plane = E * h * small / (1 + NU) / (1 - 2 * NU)  # thickness is held
    assert pull == pytest.approx([plane * (1 - NU), plane * NU, 0, 0, 0, 0, 0, 0], abs=1e-6 * plane)
    bent = flat(c, 0.5 * small * x**2, small * x, 0 * x, np.stack([-small * x, 0 * x], 1))
    bend = c.term.resultants(c.q + bent, 0 * c.q, c.coef)[0]
    expected = [0, 0, 0, D * small, NU * D * small, 0, 0, 0]
    assert bend == pytest.approx(expected, abs=1e-4 * D * small)
    sheared = flat(c, small * y, 0 * x, small + 0 * x, np.zeros((len(x), 2)))
    shear = c.term.resultants(c.q + sheared, 0 * c.q, c.coef)[0]
    kGh = 5 / 6 * E / 2 / (1 + NU) * h
    assert shear == pytest.approx([0, 0, 0, 0, 0, 0, 0, kGh * small], abs=1e-6 * kGh * small)


def supported(c):
    """Free bending coordinates of a square plate with hard simple supports on all edges."""
    X = c.vectors(c.q)[:, 0]
    k = c.layout.kinds["s"] // 3
    free = np.zeros((len(X), k, 3), bool)
    edge_x = np.isclose(X[:, 0], 0.0) | np.isclose(X[:, 0], 1.0)
    edge_y = np.isclose(X[:, 1], 0.0) | np.isclose(X[:, 1], 1.0)
    free[:, 0, 2] = ~(edge_x | edge_y)
    free[:, -1, 0], free[:, -1, 1] = ~edge_y, ~edge_x
    if k == 4:
        free[:, 1, 2], free[:, 2, 2] = ~edge_y, ~edge_x
    return np.flatnonzero(free.ravel())


def second_order(solve, expected, error):
    """Error at 12 elements along a side at most ``error``, and four times that at 6."""
    coarse, fine = (abs(solve(n) / expected - 1.0) for n in (6, 12))
    assert fine < error
    assert np.log2(coarse / fine) == pytest.approx(2.0, abs=0.25)


@families
def test_first_frequency_of_a_thin_square_plate(family):
    """omega = 2 pi^2 sqrt(D/(rho h))/a^2, simply supported (Kirchhoff)."""
    h = 0.002

    def omega(n):
        c = case(family, plate(1.0, 1.0, n, n), h)
        free = np.ix_(*[supported(c)] * 2)
        K, M = stiffness(c, c.q, c.coef).toarray()[free], mass(c).toarray()[free]
        return np.sqrt(eigh(K, M, eigvals_only=True, subset_by_index=[0, 0])[0])

    D = E * h**3 / 12 / (1 - NU**2)
    second_order(omega, 2 * np.pi**2 * np.sqrt(D / (2700.0 * h)), 8e-3)


@families
def test_thick_square_plate_under_a_sine_load(family):
    """w = p a^4/(4 pi^4 D) (1 + 2 pi^2 D/(k G h a^2)), simply supported (Reissner, Mindlin)."""
    h = 0.2

    def deflection(n):
        c = case(family, plate(1.0, 1.0, n, n), h)
        free = supported(c)
        load = mass(c) @ sine(c) / (2700.0 * h)  # the consistent load of 1 Pa
        K = stiffness(c, c.q, c.coef).toarray()[np.ix_(free, free)]
        u = np.zeros_like(c.q)
        u[free] = np.linalg.solve(K, load[free])
        return c.vectors(u)[(n // 2) * (n + 1) + n // 2, 0, 2]

    D, kGh = E * h**3 / 12 / (1 - NU**2), 5 / 6 * E / 2 / (1 + NU) * h
    second_order(deflection, (1.0 + 2 * np.pi**2 * D / kGh) / (4 * np.pi**4 * D), 1.6e-2)


def sine(c):
    """The wave sin(pi x) sin(pi y) along z, interpolated."""
    wave = np.zeros_like(c.vectors(c.q))
    x, y = np.pi * c.vectors(c.q)[:, 0, :2].T
    wave[:, 0, 2] = np.sin(x) * np.sin(y)
    if wave.shape[1] == 4:
        wave[:, 1, 2] = np.pi * np.cos(x) * np.sin(y)
        wave[:, 2, 2] = np.pi * np.sin(x) * np.cos(y)
    return wave.ravel()


@families
def test_what_can_be_no_shell_is_named(family):
    good = plate(1.0, 1.0, 2, 1)
    folded = replace(good, points=good.points[[2, 1, 0, 3, 4, 5]])
    single = replace(good, points=good.points[[0, 1, 0, 1, 4, 5]], d_u=0.0 * good.d_u + [0, 0, 1.0])
    for surface, thickness in ((folded, 0.1), (single, 0.1), (good, 0.0)):
        with pytest.raises(ValueError, match="shell 's': an element has no area"):
            case(family, surface, thickness)
