"""The linear solver on chains, trees, grids, dense mechanisms and their constraints."""

import time
from functools import cache

import numpy as np
import pytest

from mechanics import beam3243, blocks, factor, kernels, libraries
from mechanics.assembly import pattern
from mechanics.description import Beam
from mechanics.layout import Layout
from meshes.materials import constant_material
from meshes.sections import rectangle

CHAIN = [(i, i + 1) for i in range(11)]
TREE = [((i - 1) // 2, i) for i in range(1, 15)]
STAR = [(0, i) for i in range(1, 9)]
CYCLE = [*CHAIN, (11, 0)]
GRID = [(6 * i + j, 6 * i + j + 1) for i in range(6) for j in range(5)]
GRID += [(6 * i + j, 6 * i + j + 6) for i in range(5) for j in range(6)]
GRAPHS = {"chain": CHAIN, "tree": TREE, "star": STAR, "cycle": CYCLE, "grid": GRID}
graphs = pytest.mark.parametrize("graph", GRAPHS.values(), ids=GRAPHS.keys())


class Case:
    """A matrix of random node blocks and constraint rows, and its dense equal."""

    def __init__(self, edges, node=4, held=(), massless=0, symmetric=True, seed=0):
        rng = np.random.default_rng(seed)
        count = max(max(e) for e in edges) + 1
        self.n = node * count + massless
        self.size = self.n + 2 * len(held) + massless + massless // 2
        self.node_of = np.arange(self.size) // node
        A, pairs = np.zeros((2, self.size, self.size))
        dofs = [node * i + np.arange(node) for i in range(count)]
        for i, j in edges:
            both = np.concatenate([dofs[i], dofs[j]])
            B = rng.standard_normal((2 * node, 2 * node))
            A[np.ix_(both, both)] += B @ B.T if symmetric else B @ B.T + 0.3 * B
            pairs[np.ix_(both, both)] = 1.0
        self.A, self.pairs, self.rng = A, pairs, rng
        row, block = self.n, count + massless
        for ends in held:
            self._hold(np.concatenate([dofs[e] for e in ends]), row, block)
            row, block = row + 2, block + 1
        self._add_massless(dofs, node * count, massless, row, block)
        pairs[np.diag_indices(self.size)] = 1.0
        column, line = np.nonzero(pairs.T)
        self.pattern, _ = pattern(self.size, [(line[:, None], column[:, None])])

    def _hold(self, dofs, row, block, count=2):
        """Rows that hold coordinates."""
        rows = np.arange(row, row + count)
        J = self.rng.standard_normal((count, len(dofs)))
        self.A[np.ix_(rows, dofs)], self.A[np.ix_(dofs, rows)] = J, J.T
        self.pairs[np.ix_(rows, dofs)], self.pairs[np.ix_(dofs, rows)] = 1.0, 1.0
        self.node_of[rows] = block

    def _add_massless(self, dofs, first, count, row, block):
        """Coordinates of which each is tied to a node by a row; rows that tie two of them."""
        for i in range(count):
            self.node_of[first + i] = len(dofs) + i
            self._hold(np.append(dofs[i], first + i), row + i, block + i, 1)
        for i in range(0, count, 2):
            at = first + np.array([i, i + 1])
            self._hold(at, row + count + i // 2, block + count + i // 2, 1)

    @property
    def data(self):
        column = np.repeat(np.arange(self.size), np.diff(self.pattern.indptr))
        return np.append(self.A[self.pattern.indices, column], 0.0)

    def solver(self, symmetric=True, prefer="blocks"):
        return factor.choose(self.pattern, self.node_of, symmetric, prefer)


def check(case, solver, tolerance=1e-9):
    """Whether the solver's own factors solve; returns whether a library had to."""
    work = np.zeros(solver.work_size)
    assert factor._factor(solver.factor, solver.ints, case.data, work) == 0
    x = case.rng.standard_normal(case.size)
    b = case.A @ x
    factor._solve(solver.solve, solver.ints, work, b)
    expected = np.linalg.solve(case.A, case.A @ x)
    assert b == pytest.approx(expected, rel=tolerance, abs=tolerance * np.abs(expected).max())
    return work[0] != 0.0


@graphs
@pytest.mark.parametrize("symmetric", [True, False])
@pytest.mark.parametrize("node", [1, 3, 12])
def test_blocks_solve_graphs_of_nodes(graph, symmetric, node):
    case = Case(graph, node, symmetric=symmetric)
    case.node_of = np.arange(case.size) // node
    assert not check(case, case.solver(symmetric))


@graphs
@pytest.mark.parametrize("symmetric", [True, False])
def test_blocks_solve_constraints_without_pivoting(graph, symmetric):
    last = max(max(e) for e in graph)
    case = Case(graph, 4, held=[(0,), (0, last), (2, 5)], symmetric=symmetric)
    assert not check(case, case.solver(symmetric))


@pytest.mark.parametrize("symmetric", [True, False])
def test_massless_coordinates_and_constraints_between_them(symmetric):
    case = Case(CHAIN, 4, held=[(0, 3)], massless=4, symmetric=symmetric)
    assert not check(case, case.solver(symmetric))


@pytest.mark.parametrize("symmetric", [True, False])
def test_a_node_whose_mass_is_singular_but_for_its_own_constraints(symmetric):
    """Director inertia of a flat body: no mass in one direction, which its constraints hold."""
    case = Case(CHAIN, 4, held=[(i,) for i in range(12)], symmetric=symmetric)
    case.A[: case.n, : case.n] = np.kron(np.eye(12), np.diag([1.0, 2.0, 1e-17, 3.0]))
    assert np.linalg.cond(case.A) < 1e4
    assert not check(case, case.solver(symmetric))


def test_ranks_given_are_those_guessed():
    case = Case(CHAIN, 4, held=[(0, 3)], massless=2)
    rank = np.array([0] * 48 + [2, 2] + [1] * 5)
    given = factor.choose(case.pattern, case.node_of, True, "blocks", rank)
    assert np.array_equal(given.ints[4:], case.solver().ints[4:])  # but for addresses


def test_ranks_count_the_steps_from_what_has_a_mass():
    case = Case(CHAIN, 4, held=[(0, 3)], massless=2)
    rank = blocks.ranks(case.pattern, np.arange(case.size) < 48)
    assert rank.tolist() == [0] * 48 + [2, 2] + [1, 1] + [1, 1] + [3]
    assert np.array_equal(factor._guessed(case.pattern, case.node_of), rank == 0)


def test_order_of_unknowns_does_not_matter():
    case = Case(GRID, 3, held=[(0, 35), (7,)])
    there = case.rng.permutation(case.n)
    there = np.concatenate([there, np.arange(case.n, case.size)])
    case.A, case.pairs = case.A[np.ix_(there, there)], case.pairs[np.ix_(there, there)]
    case.node_of = case.node_of[there]
    column, line = np.nonzero(case.pairs.T)
    case.pattern, _ = pattern(case.size, [(line[:, None], column[:, None])])
    assert not check(case, case.solver())


def test_fill_of_a_cycle_stays_narrow():
    """Any block of a cycle has at most two later neighbours when it is eliminated."""
    edges = [*((i, i + 1) for i in range(199)), (199, 0)]
    case = Case(edges, 2)
    found = blocks.arrange(case.pattern, case.node_of, np.zeros(case.size, np.int64))
    assert sorted(np.concatenate(found.members)) == list(range(400))
    assert max(len(later) for later in found.later) == 2
    assert all((later > j).all() for j, later in enumerate(found.later))


def test_fill_of_a_grid_is_that_of_a_good_order():
    """Nested dissection of a k x k grid needs about 31/4 k^2 log2 k numbers (George 1973); by
    rows of the grid it would be k^3."""
    k = 24
    edges = [(k * i + j, k * i + j + 1) for i in range(k) for j in range(k - 1)]
    edges += [(k * i + j, k * i + j + k) for i in range(k - 1) for j in range(k)]
    case = Case(edges, 1)
    found = blocks.arrange(case.pattern, case.node_of, np.zeros(case.size, np.int64))
    assert sum(len(later) for later in found.later) < 0.5 * k**3


def test_factors_follow_new_data_and_outlive_others():
    case = Case(GRID, 4, held=[(0,), (35, 3)])
    solver = case.solver()
    b = case.rng.standard_normal(case.size)
    first, A = solver.factorise(case.data), case.A.copy()
    case.A = case.A.copy()
    case.A[: case.n, : case.n] *= 3.0
    second = solver.factorise(case.data)
    assert first(b) == pytest.approx(np.linalg.solve(A, b), rel=1e-8, abs=1e-10)
    assert second(b) == pytest.approx(np.linalg.solve(case.A, b), rel=1e-8, abs=1e-10)


@pytest.mark.parametrize("prefer", ["dense", "blocks", "superlu"])
def test_singular_and_infinite_matrices_have_no_factors(prefer):
    case = Case(CHAIN, 4, held=[(0, 3), (5,)])
    assert case.solver(prefer=prefer).factorise(case.data) is not None
    repeated = case.A.copy()
    repeated[case.n + 2] = 0.0
    repeated[:, case.n + 2] = 0.0  # a row that holds nothing
    case.A = repeated
    assert case.solver(prefer=prefer).factorise(case.data) is None
    case.A = repeated * np.nan
    assert case.solver(prefer=prefer).factorise(case.data) is None


@pytest.mark.parametrize("symmetric", [True, False])
def test_a_body_held_at_its_far_end_only(symmetric):
    """Statics of a free chain held by its last node: eliminated from the free end, nothing but
    round-off is left for the last pivot, and a library must pivot."""
    n, k = 40, 1.0e6
    K = k * (2.0 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1))
    K[0, 0] = K[-1, -1] = k
    case = Case([(i, i + 1) for i in range(n - 1)], 1, held=[(n - 1,)], seed=3)
    case.A[:n, :n] = K
    case.A[n + 1] = case.A[:, n + 1] = 0.0
    case.A[n + 1, n + 1] = 1.0
    for solver in (case.solver(symmetric), case.solver(symmetric, "superlu")):
        x = solver.factorise(case.data)(np.append(np.ones(n), [0.0, 0.0]))
        assert x[n - 1] == pytest.approx(0.0, abs=1e-12)
        assert (K @ x[:n])[:-1] == pytest.approx(np.ones(n - 1), rel=1e-6)
        assert x[0] == pytest.approx(n * (n - 1) / 2 / k, rel=1e-6)


@pytest.mark.parametrize("symmetric", [True, False])
def test_growth_is_noticed(symmetric):
    """A pivot that is small, but not lost, spoils the solution: the library takes over."""
    case = Case(CHAIN, 2, seed=5)
    case.A[:2, :2] = 1e-12 * np.array([[1.0, 0.1], [0.1, 1.0]])
    assert np.linalg.cond(case.A) < 1e5
    assert check(case, case.solver(symmetric))


def test_a_library_that_fails_makes_the_matrix_singular():
    """Compiled code sees an error in a library as a matrix without factors, then as NaN."""
    case = Case(CHAIN, 4)
    solver = case.solver(prefer="superlu")
    case.A = np.zeros_like(case.A)
    work, b = np.zeros(solver.work_size), np.ones(case.size)
    assert factor._factor(solver.factor, solver.ints, case.data, work) == 1
    factor._solve(solver.solve, solver.ints, work, b)
    assert np.isnan(b).all()


def test_libraries_by_name():
    case = Case(CHAIN, 4)
    with pytest.raises(ValueError, match="no linear solver 'gauss'"):
        case.solver(prefer="gauss")
    for name in libraries.MAKERS:
        try:
            solver = case.solver(prefer=name)
        except ValueError as error:
            assert "is not installed" in str(error)
        else:
            assert solver.name == name
            check(case, solver)


@pytest.mark.parametrize("symmetric", [True, False])
def test_pardiso(symmetric):
    case = Case(GRID, 6, held=[(0, 35), (7,)], symmetric=symmetric)
    try:
        solver = case.solver(symmetric, "pardiso")
    except ValueError:
        pytest.skip("no mkl")
    check(case, solver)


@pytest.mark.parametrize("n", [1, 2, 7, 70])
def test_dense_pivots(n):
    case = Case([(0, 0)], n)
    case.A = case.rng.standard_normal((n, n))
    np.fill_diagonal(case.A, 0.0 if n > 1 else 2.0)
    check(case, case.solver(prefer="dense"))


def test_size_chooses_between_dense_and_blocks():
    assert Case(CHAIN, 4).solver(prefer=None).name == "dense"
    assert Case(GRID, 4).solver(prefer="auto").name == "blocks"


# -- benchmark -------------------------------------------------------------------------------------


@cache
def ring(bays=36, elements=9, h=1e-4):
    """Matrix of a cyclic truss of beams: four members a bay, three hinges at each of its nodes."""
    angle = 2.0 * np.pi * np.arange(bays) / bays
    top = np.column_stack([10.0 * np.cos(angle), 10.0 * np.sin(angle), 0.0 * angle + 1.5])
    bottom = top - [0.0, 0.0, 1.5]
    bodies, hinges = [], []
    for i in range(bays):
        j, k = (i + 1) % bays, (i - 1) % bays
        ends = {"t": (top[i], top[j]), "b": (bottom[i], bottom[j])}
        ends |= {"v": (top[i], bottom[i]), "d": (top[i], bottom[j])}
        bodies += [_member(f"{name}{i}", *ab, elements) for name, ab in ends.items()]
        for rows, name, end in ((5, f"t{i}", 0), (5, f"t{k}", -1), (3, f"d{i}", 0)):
            hinges.append((rows, (name, end), (f"v{i}", 0)))
        for rows, name, end in ((5, f"b{i}", 0), (5, f"b{k}", -1), (3, f"d{k}", -1)):
            hinges.append((rows, (name, end), (f"v{i}", -1)))
    return _constrained(bodies, hinges, h)


def _member(name, a, b, elements):
    points = a + np.linspace(0.0, 1.0, elements + 1)[:, None] * (b - a)
    e1 = (b - a) / np.linalg.norm(b - a)
    e2 = np.cross([0.0, 0.0, 1.0] if abs(e1[2]) < 0.9 else [1.0, 0.0, 0.0], e1)
    e2 /= np.linalg.norm(e2)
    axes = np.tile(np.stack([e1, e2, np.cross(e1, e2)]), (elements + 1, 1, 1))
    plain = constant_material("plain", 2700.0, 70e9, 0.3, 23e-6, 160.0, 900.0)
    return Beam(name, points, axes, rectangle(0.03, 0.02), plain, 293.15)


def _constrained(bodies, hinges, h):
    """Pattern, data and blocks of mass/(beta h^2) + stiffness, and of hinge rows; the first node
    of the first body is held."""
    layout, rng = Layout.of(bodies), np.random.default_rng(0)
    term, n = beam3243.build(bodies, layout), layout.ndof
    rows, owner = [], []
    for index, (count, *sites) in enumerate(hinges):
        first = [layout.node_dofs[body][node] for body, node in sites]
        for c in range(count):
            part = np.arange(c, c + 1) if c < 3 else 6 + 3 * (c - 3) + np.arange(3)
            values = np.array([1.0, -1.0]) if c < 3 else rng.standard_normal(6)
            rows.append((np.concatenate([f + part for f in first]), values))
            owner.append(n // 12 + index)
    start = layout.node_dofs[bodies[0].name][0]
    for c in (0, 1, 2, 6, 7, 9):
        rows.append((np.array([start + c]), np.ones(1)))
        owner.append(n // 12 + len(hinges))
    dofs = np.concatenate([d for d, _ in rows])[:, None]
    line = np.repeat(n + np.arange(len(rows)), [len(d) for d, _ in rows])[:, None]
    size = n + len(rows)
    diagonal = np.arange(size)[:, None]
    pairs = [(term.dofs, term.dofs), (dofs, line), (line, dofs), (diagonal, diagonal)]
    shape, slots = pattern(size, pairs)
    data, places = shape.zeros(), slots[0].reshape(len(slots[0]), -1).astype(np.int64)
    np.add.at(data, places.ravel(), term.mass_blocks().ravel() / (0.3 * h * h))
    coef = term.coefficients(np.tile([293.15, 0.0, 0.0], (len(layout.x), 1)))
    kernels.add_tangent(term, layout.q0, 0.0 * layout.q0, coef, 1.0, 0.0, places, data)
    values = np.concatenate([v for _, v in rows])
    data[slots[1].ravel()], data[slots[2].ravel()], data[-1] = values, values, 0.0
    return shape, data, np.concatenate([np.arange(n) // 12, owner])


def milliseconds(work, repeat=9):
    """Least processor time of a call."""
    times = []
    for _ in range(repeat):
        start = time.thread_time()
        work()
        times.append(time.thread_time() - start)
    return 1e3 * min(times)


def timed(name, shape, data, node_of, symmetric=True):
    """Times [ms] to factorise and to solve, or None where the solver is not installed."""
    try:
        solver = factor.choose(shape, node_of, symmetric, name)
    except ValueError:
        return None
    work, b = np.zeros(solver.work_size), np.ones(shape.size)
    assert factor._factor(solver.factor, solver.ints, data, work) == 0
    return (
        milliseconds(lambda: factor._factor(solver.factor, solver.ints, data, work)),
        milliseconds(lambda: factor._solve(solver.solve, solver.ints, work, b)),
    )


def shell_grid(k=24, node=12):
    """Quadrilaterals of random stiffness on k x k nodes with 12 coordinates, one row held."""
    rng = np.random.default_rng(0)
    corner = (k * np.arange(k - 1)[:, None] + np.arange(k - 1)).ravel()
    nodes = corner[:, None] + np.array([0, 1, k, k + 1])
    dofs = (node * nodes[:, :, None] + np.arange(node)).reshape(len(nodes), -1)
    n = node * k * k
    held, line, diagonal = np.arange(k)[:, None], n + np.arange(k)[:, None], np.arange(n + k)
    pairs = [(dofs, dofs), (node * held, line), (line, node * held)]
    shape, slots = pattern(n + k, [*pairs, (diagonal[:, None], diagonal[:, None])])
    B = rng.standard_normal((len(nodes), dofs.shape[1], dofs.shape[1]))
    data = shape.zeros()
    np.add.at(data, slots[0], B @ B.transpose(0, 2, 1))
    data[slots[1]], data[slots[2]] = 1.0, 1.0
    blocks_of = np.concatenate([np.arange(n) // node, k * k + np.arange(k)])
    return shape, data, blocks_of


def mechanism(n=70):
    """A matrix without a zero entry."""
    case = Case([(0, 0)], n)
    return case.pattern, case.data, np.arange(n) // 12


def test_ring_is_solved_by_blocks_alone():
    shape, data, node_of = ring(6, 3)
    x = np.random.default_rng(0).standard_normal(shape.size)
    A = shape.matrix(data)
    for symmetric in (True, False):
        solver = factor.choose(shape, node_of, symmetric)
        work, b = np.zeros(solver.work_size), A @ x
        assert factor._factor(solver.factor, solver.ints, data, work) == 0
        assert work[0] == 0.0
        factor._solve(solver.solve, solver.ints, work, b)
        terms = abs(A) @ abs(b) + abs(A @ x)
        assert np.abs(A @ x - A @ b).max() <= 1e-12 * terms.max()


@pytest.mark.benchmark
@pytest.mark.parametrize("make", [ring, shell_grid, mechanism])
def test_blocks_are_faster_than_libraries(make, capsys):
    """Own solver at most half as slow as SuperLU in factorising a ring or a grid; a small
    mechanism in 60 us and 6 us."""
    shape, data, node_of = make()
    times = {}
    for name in ("dense", "blocks", "general", *libraries.MAKERS):
        if name != "dense" or shape.size < 1000:
            known = "blocks" if name == "general" else name
            found = timed(known, shape, data, node_of, name not in ("general", "dense"))
            times |= {name: found} if found else {}
    with capsys.disabled():
        print(f"\n{make.__name__}: {shape.size} unknowns, {len(shape.indices)} entries")
        for name, (refactor, solve) in times.items():
            ratio = refactor / times["blocks"][0], solve / times["blocks"][1]
            print(f"  {name:8} {refactor:9.3f} {solve:8.4f} ms  x {ratio[0]:6.2f} {ratio[1]:6.2f}")
    if shape.size < 1000:
        assert times["dense"][0] < 0.06 and times["dense"][1] < 0.006
    else:
        assert times["blocks"][0] < 0.5 * times["superlu"][0]
        assert times["blocks"][1] < times["superlu"][1]
