"""Elimination of solids: dissection, wide blocks with pivots, signs of eigenvalues."""

import numpy as np
import pytest
from continuum_cases import bar, cantilever, straight
from scipy.linalg import eigh, null_space

from mechanics import block_kernels
from mechanics.continuum_blocks import NODES, dissected
from mechanics.modes import stiffness
from mechanics.signs import negatives_dense
from mechanics.system import Factors
from meshes.sections import tube


def test_halves_share_separators_only():
    """No cell has nodes of two clusters of the first stage, and stages rise towards the middle."""
    mesh = bar((0.16, 0.08, 0.08), (16, 8, 8))
    cells = mesh.cells["hexahedron20"]
    found = dissected(mesh.points, cells)
    assert np.bincount(found.cluster).max() <= NODES
    first = np.where(found.stage == 0, found.cluster, -1)[cells]
    lowest = np.where(first < 0, np.iinfo(np.int64).max, first).min(axis=1)
    assert np.all((first < 0) | (first == lowest[:, None]))
    last = mesh.points[found.stage == found.stage.max()]
    assert np.ptp(last[:, 0]) < 1e-12
    assert last[0, 0] == pytest.approx(0.08)


def test_a_single_cell_is_one_stage():
    mesh = bar((0.1, 0.1, 0.1), (1, 1, 1))
    found = dissected(mesh.points, mesh.cells["hexahedron20"])
    assert set(found.stage) == {0}
    assert set(found.cluster) == {0}


def matrix(made, shift=0.0):
    system = made.system
    y = system.unknowns(system.layout.q0)
    return system.matrix(y, 0.0 * y, 0.0, made.rest(), Factors(-shift, 1.0, 0.0))


def test_a_wide_face_is_eliminated_with_pivots():
    made = cantilever(bar((0.1, 0.1, 0.1), (3, 6, 6)))
    data, rng = matrix(made), np.random.default_rng(0)
    solve, _ = made.system.solver.counted(data)
    whole = made.system.pattern.matrix(data)
    face = np.count_nonzero(made.system.layout.q0[::3] == 0.0)
    assert 3 * face > block_kernels.WIDE
    b = whole @ rng.standard_normal((whole.shape[0], 3))
    x = solve(b)
    assert np.abs(whole @ x - b).max() < 1e-10 * np.abs(b).max()
    one = made.system.factorise(data)(b[:, 1])
    assert one == pytest.approx(x[:, 1], rel=1e-9, abs=1e-12 * np.abs(one).max())


@pytest.mark.parametrize("shape", ["block", "tube"])
def test_signs_are_those_of_the_eigenvalues(shape):
    """Eigenvalues below a shift on the motions that the clamp allows, against dense ones."""
    if shape == "block":
        made = cantilever(bar((0.2, 0.05, 0.05), (4, 2, 2)))
    else:
        made = cantilever(straight(0.2, tube(0.0125, 0.001), 3, 8), ends=("start", "end"))
    system = made.system
    K, B = stiffness(system, system.unknowns(system.layout.q0), 0.0, made.rest())
    free = null_space(B.toarray())
    # coordinates without mass are tied to others: no eigenvalue is infinite
    squares = eigh(free.T @ K @ free, free.T @ system.mass @ free, eigvals_only=True)
    for count in (0, 1, 5, 40, 200):
        shift = 0.5 * squares[0] if count == 0 else 0.5 * (squares[count - 1] + squares[count])
        if count and squares[count] - squares[count - 1] < 1e-6 * squares[count]:
            shift, count = 1.001 * squares[count], int(np.sum(squares < 1.001 * squares[count]))
        _, negative = system.solver.counted(matrix(made, shift))
        assert negative - system.m == count


def test_signs_of_badly_scaled_blocks():
    """Constraints of the size of one beside stiffnesses of 1e12."""
    rng = np.random.default_rng(1)
    B, D = rng.standard_normal((3, 8)), np.diag(10.0 ** rng.uniform(6.0, 12.0, 8))
    saddle = np.block([[D, B.T], [B, np.zeros((3, 3))]])
    assert negatives_dense(saddle) == 3
    assert negatives_dense(-saddle) == 8
