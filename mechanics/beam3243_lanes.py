"""Forces and energies of ``mechanics.beam3243_kernels`` for several elements at once.

Formulas are those of that module, in the same order, unrolled over the tables: see
``mechanics.lanes``.
"""

from itertools import product
from typing import NamedTuple

from mechanics.beam3243_tables import (
    AHEAD,
    AXIS,
    BENDING,
    BENT,
    ENDS,
    FACTOR,
    LEFT,
    MIX_FACTOR,
    MIX_P,
    MIX_Q,
    MIX_ROW,
    NORMAL,
    OF,
    ONE,
    POINT_ROW,
    RIGHT,
    ROW,
    ROWS,
    SHEAR,
    STRAINS,
    SWEEP,
    TORSION,
)
from mechanics.lanes import Lanes, compiled

TINY = 1e-300
"""Added to a stiffness that is zero where an element is left without any."""
DAMPING, VECTORS, RATES = 0, 1, 22
"""First rows of what goes in: damping time, the vectors X (21) and their rates (21), coefficients;
without damping only the vectors and the first two thirds of the coefficients after them."""
STILL = VECTORS + 21
"""First row of the coefficients without damping."""
MOVING = RATES + 21
"""The same with damping."""
POINTS = list(product(range(4), range(2)))


class Arm(NamedTuple):
    """u, n = n_k and (u - (u.n) n)/|d| of a point and k, and 1/|d|."""

    u: list[Lanes]
    n: list[Lanes]
    m: list[Lanes]
    N: Lanes


def _dot(a: list[Lanes], b: list[Lanes]) -> Lanes:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _at(X: list[Lanes], g: int, k: int, i: int) -> tuple[Lanes, Lanes]:
    """Component i of u and of d_k at a point."""
    u = X[i] * AHEAD[g, 0] + X[3 + i] * AHEAD[g, 1] + X[12 + i] * AHEAD[g, 2]
    return u, X[6 + 3 * k + i] * ENDS[g, 0] + X[15 + 3 * k + i] * ENDS[g, 1]


def _mix(eps: list, first: int, end: int) -> None:
    for m in range(first, end):
        eps[MIX_ROW[m]] += MIX_FACTOR[m] * eps[MIX_P[m]] * eps[MIX_Q[m]]


def _strains(X: list[Lanes]) -> tuple[list, list[Arm]]:
    eps: list = [0.0] * ROWS
    for m in range(FACTOR.size):
        j, k = 3 * LEFT[m], 3 * RIGHT[m]
        eps[ROW[m]] += _dot(X[j : j + 3], X[k : k + 3]) * FACTOR[m]
    arms = []
    for g, k in POINTS:
        u, d = map(list, zip(*(_at(X, g, k, i) for i in range(3)), strict=True))
        N = 1.0 / _dot(d, d).root()
        strain, n = _dot(u, d) * N, [one * N for one in d]
        eps[POINT_ROW[g, k]] = strain
        arms.append(Arm(u, n, [(u[i] - strain * n[i]) * N for i in range(3)], N))
    eps[ONE] = 1.0
    _mix(eps, SWEEP[0], SWEEP[1])
    for r in range(BENDING, SHEAR):
        eps[r] = eps[r] / eps[NORMAL + (r - BENDING) % 2].root()
    _mix(eps, SWEEP[1], SWEEP[2])
    return eps, arms


def _mixed_rates(eps: list, rate: list, first: int, end: int) -> None:
    for m in range(first, end):
        p, q = MIX_P[m], MIX_Q[m]
        rate[MIX_ROW[m]] += (eps[p] * rate[q] + rate[p] * eps[q]) * MIX_FACTOR[m]


def _rates(X: list[Lanes], V: list[Lanes], eps: list, arms: list[Arm]) -> list:
    rate: list = [0.0] * ROWS
    for m in range(FACTOR.size):
        j, k = 3 * LEFT[m], 3 * RIGHT[m]
        for i in range(3):
            rate[ROW[m]] += (X[j + i] * V[k + i] + V[j + i] * X[k + i]) * FACTOR[m]
    for (g, k), arm in zip(POINTS, arms, strict=True):
        for i in range(3):
            u, d = _at(V, g, k, i)
            rate[POINT_ROW[g, k]] += arm.n[i] * u + arm.m[i] * d
    _mixed_rates(eps, rate, SWEEP[0], SWEEP[1])
    for r in range(BENDING, SHEAR):
        z = NORMAL + (r - BENDING) % 2
        rate[r] = rate[r] / eps[z].root() - 0.5 * eps[r] / eps[z] * rate[z]
    _mixed_rates(eps, rate, SWEEP[1], SWEEP[2])
    return rate


def _relief(coef: list[Lanes], b: list[Lanes]) -> tuple[float | Lanes, Lanes]:
    slope: float | Lanes = 0.0
    stiffness = 12.0 * coef[TORSION] + TINY
    for g in range(2):
        k, m = coef[BENDING + g], coef[BENDING + 2 + g]
        M2 = k * (b[g] - coef[STRAINS + BENDING + g])
        M3 = m * (b[2 + g] - coef[STRAINS + BENDING + 2 + g])
        slope = slope + M2 * b[2 + g] - M3 * b[g]
        stiffness = stiffness + k * b[2 + g] * b[2 + g] + m * b[g] * b[g]
    return slope, stiffness


def _stresses(coef: list[Lanes], eps: list) -> list:
    S: list = [0.0] * ROWS
    for r in range(STRAINS):
        S[OF[r]] = coef[r] * (eps[OF[r]] - coef[STRAINS + r])
    slope, stiffness = _relief(coef, eps[BENT:])
    phi = -slope / stiffness
    for g in range(2):
        p, q, k, m = BENT + g, BENT + 2 + g, coef[BENDING + g], coef[BENDING + 2 + g]
        M2, M3 = S[p] + phi * k * eps[q], S[q] - phi * m * eps[p]
        S[p], S[q] = M2 - phi * M3, M3 + phi * M2
    return S


def _pass_on(eps: list, S: list, first: int, end: int) -> None:
    for m in range(end - 1, first - 1, -1):
        p, q = MIX_P[m], MIX_Q[m]
        s = S[MIX_ROW[m]] * MIX_FACTOR[m]
        S[p] += s * eps[q]
        S[q] += s * eps[p]


def _forces(X: list[Lanes], eps: list, arms: list[Arm], S: list) -> list:
    _pass_on(eps, S, SWEEP[1], SWEEP[2])
    for r in range(BENDING, SHEAR):
        z = NORMAL + (r - BENDING) % 2
        S[z] = S[z] - 0.5 * eps[r] / eps[z] * S[r]
        S[r] = S[r] / eps[z].root()
    _pass_on(eps, S, SWEEP[0], SWEEP[1])
    f: list = [0.0] * 21
    for m in range(FACTOR.size):
        j, k, s = 3 * LEFT[m], 3 * RIGHT[m], S[ROW[m]] * FACTOR[m]
        for i in range(3):
            f[j + i] += s * X[k + i]
            f[k + i] += s * X[j + i]
    for (g, k), arm in zip(POINTS, arms, strict=True):
        s = S[POINT_ROW[g, k]]
        for i in range(3):
            for m in range(3):
                f[3 * AXIS[m] + i] += s * AHEAD[g, m] * arm.n[i]
            for m in range(2):
                f[9 * m + 6 + 3 * k + i] += s * ENDS[g, m] * arm.m[i]
    return f


def _still_forces(given: list[Lanes]) -> list:
    X, coef = given[VECTORS:STILL], given[STILL:]
    eps, arms = _strains(X)
    return _forces(X, eps, arms, _stresses(coef, eps))


def _damped_forces(given: list[Lanes]) -> list:
    X, V, coef = given[VECTORS:RATES], given[RATES:MOVING], given[MOVING:]
    eps, arms = _strains(X)
    rate, S = _rates(X, V, eps, arms), _stresses(coef, eps)
    for r in range(STRAINS):
        S[OF[r]] += given[DAMPING] * coef[r] * (rate[OF[r]] - coef[2 * STRAINS + r])
    return _forces(X, eps, arms, S)


def _elastic(coef: list[Lanes], eps: list) -> Lanes:
    energy = 0.0
    for r in range(STRAINS):
        far = eps[OF[r]] - coef[STRAINS + r]
        energy = energy + 0.5 * coef[r] * (far * far)
    slope, stiffness = _relief(coef, [eps[OF[BENDING + i]] for i in range(4)])
    return energy - 0.5 * slope * slope / stiffness


def _still_energies(given: list[Lanes]) -> list:
    return [_elastic(given[STILL:], _strains(given[VECTORS:STILL])[0])]


def _damped_energies(given: list[Lanes]) -> list:
    X, V, coef = given[VECTORS:RATES], given[RATES:MOVING], given[MOVING:]
    eps, arms = _strains(X)
    rate, lost, heated = _rates(X, V, eps, arms), 0.0, 0.0
    for r in range(STRAINS):
        fast = rate[OF[r]] - coef[2 * STRAINS + r]
        viscous = given[DAMPING] * coef[r] * fast
        lost = lost + viscous * fast
        heated = heated + viscous * coef[2 * STRAINS + r]
    return [_elastic(coef, eps), lost, heated]


still_forces = compiled(_still_forces, STILL + 2 * STRAINS)
damped_forces = compiled(_damped_forces, MOVING + 3 * STRAINS)
still_energies = compiled(_still_energies, STILL + 2 * STRAINS)
damped_energies = compiled(_damped_energies, MOVING + 3 * STRAINS)
