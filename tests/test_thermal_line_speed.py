"""Run times of line networks: what one nonlinear iteration takes, and by whom it is solved."""

from time import process_time

import numpy as np
import pytest
from heat_cases import member, plain, still, varying
from scipy.sparse.linalg import splu

from thermal.boundary import Moment
from thermal.description import Description, Link, Part, Place, Radiation
from thermal.solvers import build

NOW = Moment(0.0, {})
TAU = 10.0
MATERIAL = varying()
TARGET = 10e-3  # [s] of an iteration with 20,000 temperatures, on a machine that is left alone


def single(stations, n):
    return Description(
        (member(length=20.0, elements=stations - 1, wall_points=n, material=MATERIAL),),
        conditions=(Radiation("space", "arm", 0.8, still(4.0)),),
    )


def ring(count, stations):
    """Members from hub to hub round a ring."""
    members = [
        member(f"m{i}", 2.0, stations - 1, material=MATERIAL, start=(0, i, 0)) for i in range(count)
    ]
    hubs = [Part(f"hub{i}", np.zeros(3), plain(), 0.1, 300.0) for i in range(count)]
    links = []
    for i in range(count):
        near, far = Place(f"hub{i}"), Place(f"hub{(i + 1) % count}")
        links.append(Link(f"start{i}", near, Place(f"m{i}", "start"), 1.0))
        links.append(Link(f"end{i}", far, Place(f"m{i}", "end"), 1.0))
    space = [Radiation(f"space{i}", f"m{i}", 0.8, still(4.0)) for i in range(count)]
    return Description(members, hubs, links, space)


def best(function, times=15):
    """Shortest processor time of several runs [s]: others may be using the machine."""
    function()
    found = []
    for _ in range(times):
        start = process_time()
        function()
        found.append(process_time() - start)
    return min(found)


CASES = {
    "20,000 stations with one temperature": single(20_000, 1),
    "2,500 stations x 8 round a tube": single(2_500, 8),
    "50 members x 400 stations between hubs": ring(50, 400),
}


@pytest.mark.benchmark
@pytest.mark.parametrize("name", CASES)
def test_an_iteration_of_twenty_thousand_temperatures(name):
    """Residual, tangent, factorisation and solution with k(T), c(T), radiation."""
    solver = build("line", CASES[name])
    T = solver.initial() + np.random.default_rng(0).standard_normal(len(solver.x))

    def residual():
        return solver.space.heat(T) - TAU * solver.power(T, NOW)[0]

    def iteration():
        return solver.factorise(T, NOW, TAU)(residual()[solver.free])

    values = np.concatenate([solver.space.tangent(T, TAU), TAU * solver._boundary.slopes(T, NOW)])
    pattern = solver.linear._pattern
    matrix = pattern.matrix(values)
    own, super_lu = best(lambda: pattern._within_band(values)), best(lambda: splu(matrix), 3)
    total = best(iteration)
    print(
        f"\n{name}: {len(T)} temperatures, iteration {1e3 * total:.1f} ms, "
        f"{total / TARGET:.2f} of the target "
        f"(residual {1e3 * best(residual):.1f} ms, assembly and factors {1e3 * own:.1f} ms of it, "
        f"SuperLU {1e3 * super_lu:.1f} ms: {super_lu / own:.1f} times)"
    )
    exact, found = splu(matrix).solve(residual()), iteration()
    np.testing.assert_allclose(found, exact, atol=1e-9 * abs(exact).max())
    assert own < super_lu
