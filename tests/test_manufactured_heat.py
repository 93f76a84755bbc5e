"""Manufactured heat: its light is right, and the solvers show their orders."""

import numpy as np
import pytest

from coupling.verify import manufactured as made
from coupling.verify.registry import PROBLEMS

OWN = [p for p in PROBLEMS if p.solve.__module__ == made.__name__]
SIGMA = 5.670374419e-8


@pytest.mark.parametrize("section", [made.BAR, made.TUBE])
def test_light_makes_the_field_a_solution(section):
    """Heat balance of a small cell of the wall, fluxes by differences."""
    d, t = 1e-4, 0.7 * made.TIME
    s, phi = np.array([0.31, 0.8]), np.array([0.4, 2.0])

    def T(ds=0.0, dphi=0.0, dt=0.0):
        return made._temperature(section, s + ds, phi + dphi, t + dt)[0]

    def flux(one, other, distance):
        return made.ALLOY.conductivity(0.5 * (one + other)) * (one - other) / distance

    net = (flux(T(ds=d), T(), d) - flux(T(), T(ds=-d), d)) / d
    if section.kind == "tube":
        arc = section.radius * d
        net += (flux(T(dphi=d), T(), arc) - flux(T(), T(dphi=-d), arc)) / arc
    stored = 2700.0 * made.ALLOY.heat_capacity.integral(T(dt=-d), T(dt=d)) / (2.0 * d)
    width = section.area / section.outer_perimeter
    light = width * (stored - net) + 0.8 * SIGMA * (T() ** 4 - 200.0**4)
    np.testing.assert_allclose(made._light(section, s, phi, t, True), light, rtol=1e-4)
    assert np.abs(width * net).min() > 1.0


@pytest.mark.parametrize("moving", [False, True])
def test_the_field_of_solids_obeys_its_equation(moving):
    x, d, dt, t = np.array([[0.03, 0.05, 0.02]]), 1e-4, 1.0, 500.0

    def T(shift, later=0.0):
        return made._kirchhoff(made._potential(x + shift, t + later, moving)[0])

    k, net = made.CERAMIC.conductivity, 0.0
    for e in d * np.eye(3):
        right, left = T(e), T(-e)
        net += (k(0.5 * (right + T(0))) * (right - T(0)) - k(0.5 * (left + T(0))) * (T(0) - left))[
            0
        ]
    stored = 2700.0 * made.CERAMIC.heat_capacity.integral(T(0, -dt), T(0, dt))[0] / (2.0 * dt)
    largest = abs(k(T(0)) * (T(d * np.eye(3)[:1]) - 2 * T(0) + T(-d * np.eye(3)[:1])))[0]
    assert abs(net / d**2 - stored) < 1e-4 * largest / d**2
    gradient = made._potential(x, t, moving)[1][0]
    found = [(made._potential(x + e, t, moving)[0] - made._potential(x - e, t, moving)[0])[0]
             for e in d * np.eye(3)]  # fmt: skip
    np.testing.assert_allclose(gradient, np.array(found) / (2.0 * d), rtol=1e-6)


@pytest.mark.parametrize("problem", OWN, ids=[p.name for p in OWN])
def test_orders(problem):
    for table in problem.solve():
        assert table.passed, (table.name, table.orders, table.errors)
