"""Linear systems of heat: multigrid and PETSc against direct solutions, on cells of all shapes."""

import os
import subprocess
import sys
from math import inf

import numpy as np
import pytest
from scipy.sparse import csc_array
from scipy.sparse.linalg import spsolve

from meshes.materials import Material, constant, polynomial
from meshes.solids import box
from thermal import multigrid, petsc
from thermal.compressed import Compressed
from thermal.description import Description, Film, Fixed, Flux, Place, Radiation, Settings, Solid
from thermal.linear import Direct, linear_solver
from thermal.multigrid import Multigrid
from thermal.petsc import Petsc
from thermal.solvers import build


def has_petsc():
    try:
        petsc.interpreter()
    except ValueError:
        return False
    return True


PETSC = pytest.mark.skipif(not has_petsc(), reason="no Python here has petsc4py")
BOTH = pytest.mark.parametrize("linear", ["multigrid", pytest.param("petsc", marks=PETSC)])


def entries(n, seed=0):
    """Rows, columns, values of a diagonally dominant, unsymmetric matrix in 3D, entries twice."""
    i = np.arange(n**3).reshape(n, n, n)
    pairs = [(i[1:], i[:-1]), (i[:, 1:], i[:, :-1]), (i[:, :, 1:], i[:, :, :-1])]
    a = np.concatenate([p.ravel() for p, _ in pairs])
    b = np.concatenate([q.ravel() for _, q in pairs])
    g = np.random.default_rng(seed).uniform(0.5, 2.0, len(a))
    rows, columns = np.concatenate([a, b, a, b]), np.concatenate([a, b, b, a])
    values = np.concatenate([g, g, -g, -0.97 * g])
    own = np.arange(n**3)
    return (
        np.concatenate([rows, own]),
        np.concatenate([columns, own]),
        np.concatenate([values, np.full(n**3, 0.05)]),
    )


def varying():
    """k and c rise with temperature."""
    k = polynomial("conductivity", "W/(m K)", [120.0, 0.5], 300.0, -inf, inf)
    c = polynomial("heat_capacity", "J/(kg K)", [800.0, 1.2], 300.0, -inf, inf)
    young, poisson = constant("youngs_modulus", "Pa", 69e9), constant("poissons_ratio", "1", 0.33)
    return Material("varying", 2700.0, young, poisson, constant("expansion", "1/K", 23e-6), k, c)


def heated(size, counts, linear, scheme="backward-euler", steps=1):
    """A box that radiates all round; one end is held, the other absorbs."""
    conditions = (
        Radiation("radiation", "box", 0.8, lambda t: 150.0),
        Flux("sun", "box", lambda t: 5e4, None, "x1"),
        Fixed("root", Place("box", "x0"), lambda t: 420.0),
    )
    solid = Solid("box", box(size, counts), {"": varying()}, 400.0)
    settings = Settings(scheme=scheme, steps=steps, linear=linear)
    return build("solid", Description(solids=(solid,), conditions=conditions), settings)


def march(solver, h, count):
    """Temperatures after some intervals, and the worst defect over the heat exchanged."""
    T, defects = solver.initial(), []
    for i in range(count):
        before = solver.energy(T)
        T, flows, why = solver.advance(T, i * h, h, np.zeros_like(T))
        assert why == ""
        defect = solver.energy(T) - before - sum(flows.values())
        defects.append(abs(defect) / sum(map(abs, flows.values())))
    return T, max(defects)


def test_rows_of_a_pattern_hold_the_sums_of_their_entries():
    rng = np.random.default_rng(1)
    rows, columns = rng.integers(0, 40, (2, 500))
    values, free = rng.standard_normal(500), np.setdiff1d(np.arange(40), [3, 17])
    matrix = Compressed(40, free, rows, columns).matrix(values)
    full = csc_array((values, (rows, columns)), shape=(40, 40)).toarray()
    assert matrix.has_canonical_format
    assert np.abs(matrix.toarray() - full[np.ix_(free, free)]).max() < 1e-14


def test_the_bandwidth_of_a_line_is_found_whatever_its_numbers():
    order = np.random.default_rng(2).permutation(500)
    a, b = order[:-1], order[1:]
    rows, columns = np.concatenate([a, b, order]), np.concatenate([b, a, order])
    assert Compressed(500, np.arange(500), rows, columns).bandwidth() == 1


def test_who_solves_is_decided_by_the_work_expected():
    def solver(size, counts):
        return heated(size, counts, "auto").linear

    assert isinstance(solver((0.1, 0.1, 0.1), (8, 8, 8)), Direct)
    assert isinstance(solver((3.0, 0.1, 0.1), (700, 2, 2)), Direct)
    assert isinstance(solver((0.1, 0.1, 0.1), (18, 18, 18)), Multigrid)


def test_an_unknown_name_is_refused():
    none = np.empty(0, np.intp)
    with pytest.raises(ValueError, match="got 'magic'"):
        linear_solver("magic", 0, none, none, none)


@BOTH
def test_solutions_against_scipy(linear):
    rows, columns, values = entries(14)
    n, free = 14**3, np.arange(100, 14**3)
    solver = linear_solver(linear, n, free, rows, columns)
    A = csc_array((values, (rows, columns)), shape=(n, n))[free][:, free]
    r = np.random.default_rng(3).standard_normal(len(free))
    exact = spsolve(A, r)
    solve, x = solver.factorise(values), np.zeros(len(free))
    for _ in range(2):
        x = x + solve(r - A @ x)
        assert abs((r - A @ x).sum()) < 1e-11 * np.abs(r).sum()
    assert np.abs(x - exact).max() < 1e-4 * np.abs(exact).max()
    older, solve = solve, solver.factorise(2.0 * values)
    assert np.abs(solve(r) - 0.5 * exact).max() < 1e-2 * np.abs(exact).max()
    assert np.abs(older(r) - exact).max() < 1e-2 * np.abs(exact).max()
    assert not solve(np.zeros(len(free))).any()


SHAPES = {
    "cubes": ((0.1, 0.1, 0.1), (10, 10, 10), 5.0),
    "plate": ((4.0, 4.0, 0.002), (24, 24, 2), 100.0),
    "strip": ((4.0, 0.3, 0.002), (60, 20, 2), 100.0),
    "slabs": ((1.0, 0.1, 0.01), (12, 12, 12), 50.0),
}


@BOTH
@pytest.mark.parametrize("shape", SHAPES)
def test_steps_are_those_of_direct_solutions(linear, shape):
    size, counts, h = SHAPES[shape]
    exact, _ = march(heated(size, counts, "direct"), h, 3)
    solver = heated(size, counts, linear)
    T, defect = march(solver, h, 3)
    assert np.abs(T - exact).max() < 1e-6
    assert defect < 1e-8
    assert not getattr(solver.linear, "fallen_back", False)


@pytest.mark.parametrize("scheme", ["sdirk2", "crank-nicolson"])
def test_steps_by_error_are_those_of_direct_solutions(scheme):
    size, counts, h = SHAPES["cubes"]
    T, defect = march(heated(size, counts, "multigrid", scheme, None), h, 1)
    exact, _ = march(heated(size, counts, "direct", scheme, None), h, 1)
    assert np.abs(T - exact).max() < 1e-4
    assert defect < 1e-8


def test_steady_temperatures_are_those_of_direct_solutions():
    size, counts, _ = SHAPES["cubes"]
    found = []
    for linear in ("multigrid", "direct"):
        solver = heated(size, counts, linear)
        T, _, why = solver.steady(solver.initial(), 0.0)
        assert why == ""
        found.append(T)
    assert np.abs(found[0] - found[1]).max() < 1e-5


def test_small_steps_keep_the_balance():
    solver = heated((0.1, 0.1, 0.1), (14, 14, 14), "multigrid")
    assert march(solver, 1e-3, 3)[1] < 1e-8


def test_one_hierarchy_serves_steps_of_many_sizes():
    solver = heated((0.1, 0.1, 0.1), (14, 14, 14), "multigrid")
    T = solver.initial()
    for i in range(8):
        T, _, why = solver.advance(T, 0.0, 2.0 + 0.5 * i, np.zeros_like(T))
        assert why == ""
    assert len(solver.linear.built) == 1


def test_a_tangent_serves_further_steps_until_conditions_change():
    """Then it is given up, and the step is that of a solver without a past."""
    film = Film("film", "box", lambda t: 5.0 if t <= 40.0 else 5e5, lambda t: 300.0, "x1")
    solid = Solid("box", box((0.1, 0.1, 0.1), (14, 14, 14)), {"": varying()}, 400.0)
    settings = Settings(scheme="backward-euler", steps=1, linear="multigrid")
    description = Description(solids=(solid,), conditions=(film,))
    solver, other = (build("solid", description, settings) for _ in range(2))
    T, built = solver.initial(), []
    for i in range(4):
        T, _, why = solver.advance(T, 10.0 * i, 10.0, np.zeros_like(T))
        assert why == ""
        built += solver.kept.values()
    assert built[-1] is built[-2]
    after, flows, why = solver.advance(T, 40.0, 10.0, np.zeros_like(T))
    assert why == ""
    exact, _, _ = other.advance(T, 40.0, 10.0, np.zeros_like(T))
    assert np.abs(after - exact).max() < 1e-5
    assert abs(solver.energy(after) - solver.energy(T) - flows["film"]) < 1e-8 * abs(flows["film"])


def test_thin_cells_are_given_to_classical_multigrid():
    size, counts, h = SHAPES["slabs"]
    solver = heated(size, counts, "multigrid")
    march(solver, h, 3)
    assert solver.linear.built[-1] == "classical"
    assert solver.linear.iterations < 15


def test_where_multigrid_fails_solutions_are_direct(monkeypatch):
    monkeypatch.setattr(multigrid, "ITERATIONS", 1)
    size, counts, h = SHAPES["slabs"]
    solver = heated(size, counts, "multigrid")
    T, _ = march(solver, h, 2)
    monkeypatch.undo()
    exact, _ = march(heated(size, counts, "direct"), h, 2)
    assert solver.linear.fallen_back
    assert np.abs(T - exact).max() < 1e-6


THREADS = """
import numpy as np
from tests.test_thermal_linear import heated, march
T, _ = march(heated((0.1, 0.1, 0.1), (26, 26, 26), "multigrid"), 5.0, 2)
print(T.tobytes().hex())
"""


@pytest.mark.slow
def test_threads_change_nothing():
    found = set()
    for threads in ("1", "2", "3"):
        names = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS")
        environment = {**os.environ, **dict.fromkeys(names, threads)}
        command = [sys.executable, "-c", THREADS]
        ended = subprocess.run(command, env=environment, capture_output=True, check=True)
        found.add(ended.stdout)
    assert len(found) == 1


# ------------------------------------------------------------------------------------- PETSc


@PETSC
def test_a_process_that_dies_is_a_reason():
    solver = heated((0.1, 0.1, 0.1), (8, 8, 8), "petsc")
    T, _, why = solver.advance(solver.initial(), 0.0, 1.0, np.zeros(len(solver.x)))
    assert why == ""
    solver.linear._process._server.kill()
    T, _, why = solver.advance(T, 1.0, 1.0, np.zeros_like(T))
    assert why.startswith("t = 2 s: PETSc: its process has ended") or "Broken pipe" in why


@PETSC
def test_no_answer_is_a_reason(monkeypatch):
    solver = heated((0.1, 0.1, 0.1), (8, 8, 8), "petsc")
    os.kill(solver.linear._process._server.pid, 19)  # SIGSTOP
    monkeypatch.setattr(petsc, "PATIENCE", 0.5)
    _, _, why = solver.advance(solver.initial(), 0.0, 1.0, np.zeros(len(solver.x)))
    assert "PETSc: no answer within 0.5 s" in why


@PETSC
def test_the_process_ends_with_the_solver():
    rows, columns, _ = entries(4)
    solver = Petsc(64, np.arange(64), rows, columns)
    server, folder = solver._process._server, solver._process._folder.name
    del solver
    assert server.wait(10) is not None
    assert not os.path.exists(folder)


def test_no_petsc_is_refused_in_words(monkeypatch, tmp_path):
    monkeypatch.setenv(petsc.NAMED, str(tmp_path / "python"))
    with pytest.raises(ValueError, match="petsc4py with real numbers was not found"):
        petsc.interpreter()
