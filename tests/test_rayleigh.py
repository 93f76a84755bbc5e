"""Rayleigh damping and mass that follows temperature: options, each with its known effect."""

from dataclasses import replace

import numpy as np
import pytest
from element_cases import (
    COLD,
    FLEXIBLE,
    PAPER,
    PLAIN,
    SOLIDS,
    Case,
    body,
    build,
    derivative,
    make,
    spun,
)
from scipy.linalg import eigh
from scipy.spatial.transform import Rotation

from mechanics import kernels
from mechanics.density import DensityFactors
from mechanics.rayleigh import build as build_rayleigh

ALPHA_M, ALPHA_K = 0.12, 1.5e-4
families = pytest.mark.parametrize("family", [*FLEXIBLE, *SOLIDS])


def damped(family, alpha_m=ALPHA_M, alpha_k=ALPHA_K, shape="curved"):
    """The undamped case and the case of its Rayleigh term."""
    case = make(family, shape, 2, PLAIN)
    (term,) = build_rayleigh([case.term], case.layout, alpha_m, alpha_k)
    return case, Case(term, case.layout)


@families
def test_damping_ratio_of_a_mode(family):
    """C phi = 2 zeta w M phi with zeta = alpha_M/(2 w) + alpha_K w/2."""
    case, rayleigh = damped(family)
    K, M = case.matrix(case.q, 0 * case.q, case.coefficients()), case.mass()
    squares, modes = eigh(K, M)
    w, phi = np.sqrt(squares[-1]), modes[:, -1]
    ratio = ALPHA_M / (2.0 * w) + ALPHA_K * w / 2.0
    f = rayleigh.force(case.q, phi, rayleigh.coefficients())
    expected = 2.0 * ratio * w * (M @ phi)
    assert f == pytest.approx(expected, abs=1e-9 * np.abs(expected).max())


@families
def test_tangent_and_power(family):
    case, rayleigh = damped(family)
    rng = np.random.default_rng(1)
    q, v = case.q + 0.1 * rng.standard_normal(case.q.size), rng.standard_normal(case.q.size)
    coef = rayleigh.coefficients()
    C = derivative(lambda x: rayleigh.force(q, x, coef), v)
    found = rayleigh.matrix(q, v, coef, 0.7, -0.3)
    assert np.abs(found + 0.3 * C).max() < 1e-9 * np.abs(C).max()
    stored, lost, heating = rayleigh.energies(q, v, coef)
    assert stored == heating == 0.0
    assert lost == pytest.approx(v @ rayleigh.force(q, v, coef), rel=1e-12)
    assert lost > 0.0


def test_stiffness_part_does_not_follow_a_body_that_turns():
    """A rigid spin is free of it in the reference, not after a quarter of a turn."""
    case, rayleigh = damped("beam3243", 0.0, 1e-3)
    coef, omega = rayleigh.coefficients(), [0.0, 0.0, 1.0]
    size = np.abs(rayleigh.term.floats).max()
    here = spun(case.q, omega)
    assert np.abs(rayleigh.force(case.q, here, coef)).max() < 1e-12 * size
    there = case.turned(case.q, Rotation.from_rotvec([0.0, 0.5 * np.pi, 0.0]))
    assert np.abs(rayleigh.force(there, spun(there, omega), coef)).max() > 1e-3 * size


def test_mass_part_slows_translation_down():
    """v = exp(-alpha_M t): the force is alpha_M times the momentum of each node."""
    case, rayleigh = damped("beam3333", 0.5, 0.0)
    v = np.zeros(case.q.size).reshape(-1, 3, 3)
    v[:, 0] = 1.0, -2.0, 0.5
    f = rayleigh.force(case.q, v.ravel(), rayleigh.coefficients())
    assert f == pytest.approx(0.5 * case.mass() @ v.ravel(), rel=1e-12)


def test_only_flexible_bodies_are_damped_and_factors_are_positive():
    case = make("beam3243", "straight", 2)
    other = make("cable", "straight", 2).term
    other.mass_blocks = lambda: None
    assert len(build_rayleigh([case.term, other], case.layout, 0.1, 0.0)) == 1
    with pytest.raises(ValueError, match="not be negative, got -1 and 0"):
        build_rayleigh([case.term], case.layout, -1.0, 0.0)


# -- density of temperature --------------------------------------------------------------------


def test_density_law_of_the_paper():
    """2700 (1 - 2e-5 (T - 25 °C)) kg/m^3, constant beyond -200 °C and 200 °C."""
    for celsius, density in ((-200.0, 2712.15), (25.0, 2700.0), (200.0, 2690.55), (300.0, 2690.55)):
        factor = PAPER.density_factor(celsius + 273.15)
        assert factor * PAPER.density == pytest.approx(density, rel=1e-12)
    assert PLAIN.density_law is None
    assert np.array_equal(PLAIN.density_factor(np.array([10.0, 900.0])), [1.0, 1.0])


@families
def test_mass_follows_the_mean_temperature_of_the_element(family):
    case = build([
        replace(body(family, "straight", 2, PAPER), name="a"),
        replace(body(family, "straight", 1, PLAIN), name="b"),
    ])  # fmt: skip
    T = case.temperatures(298.15)
    T[case.layout.point_index["a"], 0] += 100.0 * case.layout.x[case.layout.point_index["a"], 0]
    found = DensityFactors(case.term, case.layout).factors(T)
    for e, name in enumerate(case.term.names):
        at = case.q[case.term.dofs[e]].reshape(-1, case.vectors, 3)[:, 0, 0]
        expected = 1.0 - 2e-5 * 100.0 * at.mean() if name == "a" else 1.0
        assert found[e] == pytest.approx(expected, rel=1e-14)


def test_density_of_a_material_must_be_positive():
    falling = replace(PAPER.density_law, curve=PAPER.density_law.curve._replace(
        value=-PAPER.density_law.curve.value))  # fmt: skip
    with pytest.raises(ValueError, match="density must be positive"):
        replace(PAPER, density_law=falling)


def test_stiffness_is_that_of_the_reference():
    """At the temperature at which the body is free of thermal strain."""
    case, rayleigh = damped("beam3243", 0.0, 1.0, "straight")
    K = kernels.tangent_blocks(
        case.term, case.q, 0 * case.q, case.coefficients(COLD), 1.0, 0.0
    )  # fmt: skip
    assert rayleigh.term.floats == pytest.approx(K.reshape(len(K), -1), rel=1e-12)
