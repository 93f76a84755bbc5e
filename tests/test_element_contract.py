"""What every flexible element owes, whatever its family: one test each, over all families."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from element_cases import (
    BEAMS,
    COLD,
    FLEXIBLE,
    LINES,
    PAPER,
    PLAIN,
    POISSONLESS,
    SHELLS,
    SOLIDS,
    body,
    build,
    derivative,
    flat,
    make,
    spun,
    straight_line,
)
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import eigh, expm
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

from mechanics.description import Beam, Description, Shell
from mechanics.dynamics import Control, Window, advance, initial_state
from mechanics.schemes import Scheme
from mechanics.system import System
from meshes.materials import constant_material
from meshes.sections import circle, rectangle, tube
from meshes.surfaces import patch

families = pytest.mark.parametrize("family", FLEXIBLE)
with_solids = pytest.mark.parametrize("family", [*FLEXIBLE, *SOLIDS])
shapes = pytest.mark.parametrize("shape", ["straight", "curved"])
vector = st.tuples(*[st.floats(-3.0, 3.0)] * 3)


@cache
def undamped(family, shape):
    return make(family, shape)


def excited(case, seed, uneven=True):
    """Coefficients, coordinates away from the reference, and velocities."""
    rng = np.random.default_rng(seed)
    coef = case.term.coefficients(case.uneven(rng) if uneven else case.temperatures())
    q = case.q
    return coef, q + 0.03 * rng.standard_normal(q.size), rng.standard_normal(q.size)


# -- data --------------------------------------------------------------------------------------


@with_solids
def test_data_are_laid_out_as_kernels_read_them(family):
    """One row for each element, C order, whole numbers and floats of 64 bits."""
    case = make(family, elements=2)
    term, coef = case.term, case.coefficients()
    count = len(term.names)
    for array, kind in ((term.ints, np.int64), (term.floats, np.float64), (coef, np.float64)):
        assert array.dtype == kind
        assert array.ndim == 2
        assert len(array) == count
        assert array.flags["C_CONTIGUOUS"] or array is coef
    assert term.dofs.shape == (count, term.mass_blocks().shape[1])
    assert set(term.dofs.ravel()) == set(range(case.q.size))
    assert term.name in (family, family.partition("-")[0])
    assert all((term.force, term.tangent, term.energy))
    assert list(term.signals) == []


@families
def test_resultants_are_zero_at_rest_and_not_under_load(family):
    case = make(family)
    coef, q, v = excited(case, 11)
    rest = case.coefficients()
    columns = 8 if family in SHELLS else 6
    none = case.term.resultants(case.q, 0 * q, rest)
    some = case.term.resultants(q, v, coef)
    assert none.shape == some.shape == (len(case.term.names), columns)
    assert np.abs(none).max() < 1e-11 * np.abs(some).max()
    assert np.all(np.isfinite(some))


# -- invariance and equilibrium ----------------------------------------------------------------


@with_solids
@shapes
@settings(max_examples=10, deadline=None)
@given(turn=vector, shift=vector)
def test_no_rigid_motion_strains_a_body(family, shape, turn, shift):
    """Nor is any reference shape stressed (no motion is one of the examples)."""
    case = undamped(family, shape)
    coef = case.coefficients()
    q = case.turned(case.q, Rotation.from_rotvec(turn), 10.0 * np.array(shift))
    size = case.stiff(coef)
    assert np.abs(case.force(q, 0 * q, coef)).max() < 1e-12 * size
    assert abs(case.energies(q, 0 * q, coef)[0]) < 1e-24 * size


@with_solids
def test_forces_turn_with_the_body(family):
    case = make(family, damping=1e-3)
    coef, q, v = excited(case, 2)
    rotation = Rotation.from_rotvec([0.4, 2.0, -1.3])
    there = case.turned(q, rotation)
    f = rotation.apply(case.force(q, v, coef).reshape(-1, 3)).ravel()
    v_there = rotation.apply(v.reshape(-1, 3)).ravel() + spun(there, [2.0, -1.0, 0.5])
    assert case.force(there, v_there, coef) == pytest.approx(f, abs=1e-11 * np.abs(f).max())
    energy = case.energies(q, v, coef)
    assert case.energies(there, v_there, coef) == pytest.approx(energy, rel=1e-10)


@with_solids
def test_forces_and_moments_are_in_balance(family):
    case = make(family, damping=1e-2)
    coef, q, v = excited(case, 6)
    f = case.force(q, v, coef)
    size = np.abs(f).max()
    assert np.abs(f.reshape(-1, 3)[:: case.vectors].sum(axis=0)).max() < 1e-12 * size
    moments = np.cross(q.reshape(-1, 3), f.reshape(-1, 3)).sum(axis=0)
    assert np.abs(moments).max() < 1e-11 * size


@with_solids
@shapes
def test_nothing_but_rigid_motion_is_free(family, shape):
    """The stiffness of one element at rest is zero for its rigid motions, and for nothing else.

    There are six; a straight cable does not know of its spin, and where a curved one bends in
    different planes, it does not resist their turning against each other.
    """
    case = make(family, shape, 1, PLAIN)
    coef = case.coefficients()
    K = case.matrix(case.q, 0 * case.q, coef)
    x = case.q.reshape(-1, 3)
    motions = [np.cross(e, x).ravel() for e in np.eye(3)]
    for e in np.eye(3):
        shift = np.zeros((len(x) // case.vectors, case.vectors, 3))
        shift[:, 0] = e
        motions.append(shift.ravel())
    for motion in motions:
        assert np.abs(K @ motion).max() < 1e-11 * np.abs(K).max()
    squares = np.linalg.eigvalsh(K / np.sqrt(np.outer(K.diagonal(), K.diagonal())))
    cable = {"straight": 5, "curved": 7}[shape]
    assert np.sum(squares < 1e-10) == (cable if family == "cable" else 6)
    assert squares.min() > -1e-12


# -- derivatives -------------------------------------------------------------------------------


@with_solids
@pytest.mark.parametrize("damping", [0.0, 2e-3])
def test_tangent_is_the_derivative_of_the_force(family, damping):
    case = make(family, "curved", 1, damping=damping)
    coef, q, v = excited(case, 3)
    K = derivative(lambda x: case.force(x, v, coef), q)
    C = derivative(lambda x: case.force(q, x, coef), v)
    expected = 0.7 * K - 0.3 * C
    found = case.matrix(q, v, coef, 0.7, -0.3)
    assert np.abs(found - expected).max() < 1e-9 * np.abs(expected).max()


@with_solids
def test_tangents_said_to_be_symmetric_are(family):
    for damping in (0.0, 1e-2):
        case = make(family, "curved", 2, damping=damping)
        coef, q, v = excited(case, 8)
        K = case.matrix(q, v, coef)
        asymmetry = np.abs(K - K.T).max() / np.abs(K).max()
        assert not case.term.symmetric or asymmetry < 1e-13
        assert case.term.symmetric or damping > 0.0


@with_solids
def test_force_is_the_gradient_of_the_energy(family):
    case = make(family, "curved", 1)
    coef, q, v = excited(case, 4)
    gradient = derivative(lambda x: case.energies(x, 0 * v, coef)[0], q)
    f = case.force(q, 0 * v, coef)
    assert f == pytest.approx(gradient, abs=1e-9 * np.abs(f).max())


# -- damping -----------------------------------------------------------------------------------


@with_solids
def test_damping_takes_energy_but_not_from_rigid_motion(family):
    case = make(family, damping=1e-2)
    coef, q, v = excited(case, 5, uneven=False)
    damping = case.force(q, v, coef) - case.force(q, 0 * q, coef)
    _, power, heating = case.energies(q, v, coef)
    assert heating == 0.0
    assert power > 0.0
    assert v @ damping == pytest.approx(power, rel=1e-9)
    spin = spun(q, [1.0, -2.0, 0.5])
    assert case.energies(q, spin, coef)[1] < 1e-22 * power
    rigid = case.force(q, spin, coef) - case.force(q, 0 * q, coef)
    assert np.abs(rigid).max() < 1e-11 * np.abs(damping).max()


@with_solids
def test_power_of_damping_is_lost_or_works_on_free_strains(family):
    case = make(family, damping=1e-2)
    cold = case.coefficients()
    hot, q, v = excited(case, 15)
    coef = case.term.with_rates(cold, hot, 2.0)[1]
    damping = case.force(q, v, coef) - case.force(q, 0 * v, hot)
    _, lost, heating = case.energies(q, v, coef)
    assert heating != 0.0
    assert v @ damping == pytest.approx(lost + heating, rel=1e-8)


@with_solids
def test_a_body_that_expands_freely_is_not_damped(family):
    case = make(family, damping=1e-2)
    warm, hot, h = COLD + 60.0, COLD + 61.0, 0.5
    cold, last = case.coefficients(warm), case.coefficients(hot)
    c0, c1 = case.term.with_rates(cold, last, h)
    growth = [1.0 + PAPER.thermal_strain(T, COLD) for T in (warm, hot)]
    middle, v = 0.5 * sum(growth) * case.q, (growth[1] - growth[0]) / h * case.q
    coef, still = 0.5 * (c0 + c1), 0.5 * (cold + last)
    elastic = case.force(middle, 0 * v, still)
    resisted = case.force(middle, v, still) - elastic
    damping = case.force(middle, v, coef) - elastic
    assert np.abs(damping).max() < 1e-6 * np.abs(resisted).max()
    assert case.energies(middle, v, coef)[1] < 1e-8 * case.energies(middle, v, still)[1]


# -- temperature -------------------------------------------------------------------------------


@with_solids
@shapes
def test_uniform_expansion_is_free_of_stress(family, shape):
    case = make(family, shape)
    hot = COLD + 120.0
    coef = case.coefficients(hot)
    grown, size = case.q * (1.0 + PAPER.thermal_strain(hot, COLD)), case.stiff(coef)
    assert np.abs(case.force(grown, 0 * grown, coef)).max() < 1e-12 * size
    assert np.abs(case.force(case.q, 0 * grown, coef)).max() > 1e-5 * size


FREE_BENDING = {"cable": 0.0, "beam3243-continuum": 1.3 / 0.7, "shell3443-continuum": 1.3}
"""How far some families bend under a gradient, in parts of what they should, at nu = 0.3."""


@families
def test_a_gradient_bends_a_free_body(family):
    """Sag alpha G l^2/8 of an unloaded strip, the warm side outside, small enough to be linear.

    The naive continuum beam bends (1 + nu)/(1 - nu) times too far, the naive shell (1 + nu) times:
    their sections resist the expansion across; the cable does not bend at all.
    """
    case = make(family, "straight", 4, PLAIN, length=1.0, width=0.2)
    gradient = np.array([0.0, 1.0]) if family in SHELLS else np.array([0.6, -0.8])
    q, rest = case.q, np.zeros(case.q.size)
    coef = case.term.coefficients(case.temperatures(COLD, 1e-3 * gradient))
    K = case.matrix(q, rest, coef)
    moved = np.linalg.lstsq(K, -case.force(q, rest, coef), rcond=1e-11)[0]
    x = moved.reshape(-1, case.vectors, 3)[:, 0]
    edge = np.flatnonzero(np.isclose(q.reshape(-1, case.vectors, 3)[:, 0, 1], 0.0))
    sag = 0.5 * (x[edge[0]] + x[edge[-1]]) - x[edge[len(edge) // 2]]
    expected = -PLAIN.expansion(COLD) * 1e-3 / 8.0 * np.array([0.0, 0.6, -0.8])
    if family in SHELLS:
        expected = -PLAIN.expansion(COLD) * 1e-3 / 8.0 * np.array([0.0, 0.0, 1.0])
    factor = FREE_BENDING.get(family, 1.0)
    assert sag == pytest.approx(factor * expected, abs=1e-6 * np.abs(expected).max())


# -- patch test --------------------------------------------------------------------------------


def uneven_body(family):
    """A flat body, 1 m long, whose elements differ in size."""
    u = np.array([0.0, 0.2, 0.35, 0.8, 1.0])
    if family in SHELLS:
        surface = patch(flat, u, np.array([0.0, 0.2, 0.5]))
        return Shell("b", surface, 0.02, POISSONLESS, COLD, element=family)
    points, axes = straight_line(family, 4)
    if family == "beam3333":  # its middle nodes stay in the middle
        u = np.interp(np.linspace(0.0, 4.0, 9), np.arange(5), u)
    points[:, 0] = u
    return Beam("b", points, axes, body(family).section, POISSONLESS, COLD, element=family)


def inner_nodes(part):
    if isinstance(part, Shell):
        return np.flatnonzero(np.bincount(part.surface.quads.ravel()) == 4)
    return np.arange(1, len(part.points) - 1)


@families
def test_constant_strain_leaves_no_force_inside(family):
    """Stretched, and for shells sheared in their plane, then turned; elements of unequal size.

    Without Poisson's ratio, so that the section is free of stress as well.
    """
    part = uneven_body(family)
    case = build([part])
    F = np.diag([1.02, 1.0, 1.0])
    if family in SHELLS:
        F[0, 1], F[1, 1] = 0.01, 0.99
    rotation = Rotation.from_rotvec([0.5, -1.0, 2.0])
    q = rotation.apply(case.q.reshape(-1, 3) @ F.T).ravel()
    coef = case.coefficients()
    f = case.force(q, 0 * q, coef).reshape(-1, case.vectors, 3)
    inner = inner_nodes(part)
    assert len(inner)
    assert np.abs(f[inner]).max() < 1e-11 * np.abs(f).max()
    volume = 1.0 * (0.02 * 0.5 if family in SHELLS else part.section.area)
    E = 0.5 * (F.T @ F - np.eye(3))
    density = 0.5 * 70e9 * np.sum(E**2)
    if family == "beam3333":  # counts the stretch, not half its square
        density = 0.5 * 70e9 * 0.02**2
    assert case.energies(q, 0 * q, coef)[0] == pytest.approx(density * volume, rel=1e-10)


# -- inertia and vibration ---------------------------------------------------------------------


@families
def test_mass_of_translation_and_of_rotation(family):
    """Thin bodies: the inertia of a rod or plate, with that of the section where there is one."""
    part = body(family, "straight", 3, PLAIN, length=2.0, width=0.8, thickness=0.05)
    case = build([part])
    M = case.mass()
    assert np.abs(M - M.T).max() <= 1e-15 * np.abs(M).max()
    velocity, omega = np.array([1.0, -2.0, 0.5]), np.array([0.3, -1.1, 0.7])
    v = np.zeros((case.q.size // (3 * case.vectors), case.vectors, 3))
    v[:, 0] = velocity
    area = 0.8 * 0.05 if family in SHELLS else part.section.area
    mass = PLAIN.density * area * 2.0
    assert v.ravel() @ M @ v.ravel() == pytest.approx(mass * velocity @ velocity, rel=1e-13)
    spin = spun(case.q, omega)
    along = mass * 4.0 / 3.0  # integral of x^2
    across, through = 0.0, 0.0  # of y^2, z^2
    if family in BEAMS:
        per_length = mass / part.section.area
        across, through = per_length * np.array(
            [part.section.second_moment_2, part.section.second_moment_3]
        )
    if family in SHELLS:
        across = mass * 0.8**2 / 3.0
        through = 0.0 if family == "shell48" else mass * 0.05**2 / 12.0
    Jxy = mass * 1.0 * 0.4 if family in SHELLS else 0.0
    inertia = np.diag([across + through, along + through, along + across])
    inertia[0, 1] = inertia[1, 0] = -Jxy
    assert spin @ M @ spin == pytest.approx(omega @ inertia @ omega, rel=1e-12)


def held(case, family):
    """Free coordinates when the end x = 0 is clamped and its section may breathe."""
    nodes = np.flatnonzero(np.isclose(case.q.reshape(-1, case.vectors, 3)[:, 0, 0], 0.0))
    kind = {
        "cable": [0, 1, 2, 4, 5],
        "beam3333": [0, 1, 2, 3, 5, 6, 7],
        "shell48": [0, 1, 2, 5, *range(6, 9), 11],
        "shell24": [0, 1, 2, 3, 4],
        "shell3443": [0, 1, 2, *range(6, 9), 9, 10],
    }.get(family, [0, 1, 2, 6, 8, 9, 10])
    fixed = (nodes[:, None] * 3 * case.vectors + np.array(kind)).ravel()
    return np.setdiff1d(np.arange(case.q.size), fixed)


SIDE = 0.01  # [m]
LOCKED = 0.7 / (1.3 * 0.4)
"""(lambda + 2 mu)/E at nu = 0.3: what bending meets in the naive continuum beam."""
SECOND = ("beam3243-enhanced", "beam3243-continuum", "shell24", "shell3443-continuum")
ORDER = dict.fromkeys(SECOND, 2)
"""Observed order of frequencies; 4 where nothing else is said."""


def strip(family, elements, material):
    """1 m long, 20 mm wide and 10 mm thick; a cable has a round section."""
    given = {"thickness": SIDE, "width": 2.0 * SIDE, "length": 1.0}
    if family in LINES:
        section = circle(SIDE) if family == "cable" else rectangle(2.0 * SIDE, SIDE, 0.3)
        given = {"section": section, "length": 1.0}
    return make(family, "straight", elements, material, **given)


def frequency(family, elements, material, axial):
    """Lowest angular frequency [1/s] of the clamped strip, across or along its axis."""
    case = strip(family, elements, material)
    K, M = case.matrix(case.q, 0 * case.q, case.coefficients()), case.mass()
    free = held(case, family)
    squares, modes = eigh(K[np.ix_(free, free)], M[np.ix_(free, free)])
    for square, mode in zip(squares, modes.T, strict=True):
        moved = np.zeros(case.q.size)
        moved[free] = mode
        r = moved.reshape(-1, case.vectors, 3)[:, 0]
        share = np.sum(r[:, 0] ** 2) / np.sum(r**2)
        if (share > 0.9) if axial else (share < 0.1):
            return np.sqrt(square)
    raise AssertionError("no such mode")


def timoshenko(EI, kGA, mass, inertia):
    """First angular frequency of a cantilever of length 1, from its state equations."""

    def missing(omega):
        w2 = omega**2
        slope = np.zeros((4, 4))  # of deflection, rotation, moment, shear force
        slope[0, 1], slope[0, 3], slope[1, 2] = 1.0, 1.0 / kGA, 1.0 / EI
        slope[2, 1], slope[2, 3], slope[3, 0] = -inertia * w2, -1.0, -mass * w2
        return np.linalg.det(expm(slope)[2:, 2:])

    guess = 1.8751041**2 * np.sqrt(EI / mass)
    return brentq(missing, 0.9 * guess, 1.1 * guess, xtol=1e-12 * guess)


def bending_reference(family, material):
    """With shear and rotary inertia where the family has them."""
    E, G = material.youngs_modulus(COLD), material.shear_modulus(COLD)
    rho, r2, k = material.density, SIDE**2 / 12.0, rectangle(2.0 * SIDE, SIDE, 0.3).shear_factor_3
    if family in ("cable", "shell48"):
        r2 = SIDE**2 / 4.0 if family == "cable" else r2
        return timoshenko(E * r2, 1e30, rho, 0.0)
    if family == "beam3243-continuum":
        return timoshenko(E * LOCKED * r2, G, rho, rho * r2)
    if family in SHELLS:
        k = 5.0 / 6.0
    return timoshenko(E * r2, k * G, rho, rho * r2)


@families
def test_bending_frequency_of_a_cantilever_converges(family):
    """At the order of the family; of the naive continuum beam to that of a locked section."""
    material = POISSONLESS if family in SHELLS else PLAIN
    expected = bending_reference(family, material)
    errors = [frequency(family, n, material, False) / expected - 1.0 for n in (2, 4, 8)]
    order = ORDER.get(family, 4)
    assert abs(errors[2]) < (5e-3 if order == 2 else 1e-5)
    assert np.log2(abs(errors[1] / errors[2])) > order - 0.3


@families
def test_axial_frequency_of_a_cantilever_converges(family):
    """Thin families carry the quadratic part of the axial strain softly, against locking."""
    expected = 0.5 * np.pi * np.sqrt(70e9 / POISSONLESS.density)
    errors = [frequency(family, n, POISSONLESS, True) / expected - 1.0 for n in (4, 8)]
    assert abs(errors[1]) < (2e-3 if family == "shell24" else 1e-4)
    assert abs(errors[1]) < 0.3 * abs(errors[0])


@families
def test_a_heated_cantilever_vibrates_with_the_modulus_at_its_temperature(family):
    """f^2 ~ E I/(m l^3), I and l of the expanded body, its mass m constant: E (1 + e)."""
    hot, squares = COLD + 150.0, []
    fixed = replace(PAPER, poissons_ratio=POISSONLESS.poissons_ratio)
    for T in (COLD, hot):
        case = strip(family, 3, fixed)
        q = case.q * (1.0 + fixed.thermal_strain(T, COLD))
        free = np.ix_(*[held(case, family)] * 2)
        K, M = case.matrix(q, 0 * q, case.coefficients(T)), case.mass()
        squares.append(eigh(K[free], M[free], eigvals_only=True, subset_by_index=[0, 0])[0])
    ratio = fixed.youngs_modulus(hot) / fixed.youngs_modulus(COLD)
    ratio *= 1.0 + fixed.thermal_strain(hot, COLD)
    assert squares[1] / squares[0] == pytest.approx(ratio, rel=2e-5)


# -- several bodies ----------------------------------------------------------------------------


@with_solids
def test_bodies_of_one_term_do_not_mix(family):
    """Two bodies with different materials, damping and, for beams, sections."""
    parts = [
        replace(body(family, "curved", 2, PLAIN), name="a"),
        replace(body(family, "straight", 3, PAPER, damping=1e-2), name="c"),
    ]
    if family in BEAMS:
        parts[1] = replace(parts[1], section=tube(0.05, 0.004))
    both, rng = build(parts), np.random.default_rng(7)
    T = both.uneven(rng)
    q, v = both.q + 0.03 * rng.standard_normal(both.q.size), rng.standard_normal(both.q.size)
    found = both.force(q, v, both.term.coefficients(T))
    energies, expected = np.zeros(3), np.zeros_like(found)
    for part in parts:
        alone, size = build([part]), both.layout.node_dofs[part.name].size
        first = both.layout.node_dofs[part.name][0]
        mine = slice(first, first + 3 * alone.vectors * size)
        coef = alone.term.coefficients(T[both.layout.point_index[part.name]])
        expected[mine] = alone.force(q[mine], v[mine], coef)
        energies += alone.energies(q[mine], v[mine], coef)
        assert both.mass()[mine, mine] == pytest.approx(alone.mass(), rel=1e-14)
    assert sorted(set(both.term.names)) == ["a", "c"]
    assert found == pytest.approx(expected, rel=1e-11, abs=1e-12 * np.abs(expected).max())
    assert both.energies(q, v, both.term.coefficients(T)) == pytest.approx(energies, rel=1e-11)


# -- free flight -------------------------------------------------------------------------------

SOFT = constant_material("soft", 1000.0, 1e7, 0.3, 0.0, 1.0, 1.0)


def flown(part, h, end=0.04):
    """Linear and angular momentum at the start and at the end of free flight, (2, 2, 3)."""
    system = System(Description([part]))
    coef = system.coefficients(np.tile([COLD, 0.0, 0.0], (len(system.layout.x), 1)))
    control = Control(np.inf, h, h, Scheme(newton_tolerance=1e-13))
    first, why = initial_state(system, control, coef)
    assert not why
    last, _, why = advance(system, control, first, Window.between(system, 0.0, end, coef, None))
    assert not why
    assert np.abs(last.motion.q - first.motion.q).max() > 0.1
    stride = system.layout.kinds[part.name] // 3
    found = []
    for motion in (first.motion, last.motion):
        p = (system.mass @ motion.v).reshape(-1, 3)
        turning = np.cross(motion.q.reshape(-1, 3), p).sum(axis=0)
        found.append([p[::stride].sum(axis=0), turning])
    return np.array(found)


@with_solids
def test_free_flight_keeps_momentum_and_angular_momentum(family):
    """A soft body flies and tumbles: linear momentum stays to round-off, angular momentum to
    the second order of the step, which is that of the integrator."""
    part = replace(
        body(family, "curved", 2, SOFT, damping=1e-3),
        velocity=np.array([3.0, -2.0, 1.0]),
        spin=np.array([4.0, 6.0, -8.0]),
    )
    drift = []
    for h in (2e-3, 1e-3, 5e-4):
        (p0, L0), (p1, L1) = flown(part, h)
        assert np.abs(p1 - p0).max() < 1e-10 * np.abs(p0).max()
        drift.append(np.abs(L1 - L0).max() / np.abs(L0).max())
    assert drift[2] < 1e-4
    assert np.log2(drift[1] / drift[2]) > 1.7
