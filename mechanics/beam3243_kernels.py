"""Strains, forces and tangents of the beam of ``mechanics.beam3243``.

An element is described by seven vectors X: c = (r_b - r_a)/L, then r_x, d2, d3 at node a, then
r_x, d2, d3 at node b; only c contains the length. Its strains eps are made in five sweeps:

1. sums of products X_J.X_K, by table;
2. u.n_k at four points: u = L r'' at two Gauss points (bending), u = r_x at two nodes (shear);
3. sums of products eps_p eps_q, by table: what axial strain and bending owe to shear and twist;
4. bending divided by Gamma_1, the component of r' along the normal of the section;
5. sums of products again: what bending owes to directors that are not orthogonal, and what axial
   strain and torsion owe to bending.

Forces go the same way back, number by number (reverse differentiation). What the first two sweeps
make are the measures z. All that the others do to them happens among the twelve ``INNER`` ones,
so that the tangent is made of small matrices: derivatives J of the strains in the inner measures,
H = sum J D J + curvatures, and last G^T H G with the gradients G of the measures in X. Rows in X
are 24 numbers long instead of 21, a multiple of what processors add at once.

Bending has one internal coordinate, the turn phi of the section between the nodes. Its stress is
zero: phi is found from the strains, and their stiffness is less by what phi gives way.
"""

import numpy as np
from numba import njit

from mechanics.beam3243_lanes import (
    DAMPING,
    MOVING,
    RATES,
    STILL,
    TINY,
    VECTORS,
    damped_energies,
    damped_forces,
    still_energies,
    still_forces,
)
from mechanics.beam3243_tables import (
    A2,
    AHEAD,
    AXIS,
    BENDING,
    BENT,
    ENDS,
    FACTOR,
    FIRST,
    INNER,
    INSIDE,
    LEFT,
    LONG,
    MIX_FACTOR,
    MIX_P,
    MIX_Q,
    MIX_ROW,
    NORMAL,
    OF,
    ONE,
    OUTER,
    OWED_ROW,
    OWED_TO,
    PLACE,
    POINT_ROW,
    RIGHT,
    ROW,
    ROWS,
    SECTION,
    SHEAR,
    STRAINS,
    SWEEP,
    TORSION,
    TURN,
)
from mechanics.kernels import ENERGY, FORCE, TANGENT, kernel
from mechanics.lanes import WIDTH


@njit(cache=True, error_model="numpy")
def _gather(q, ints, e, L, X):
    """The seven vectors of an element, flat (21,)."""
    a, b = ints[e, 0], ints[e, 1]
    for i in range(3):
        X[i] = (q[b + i] - q[a + i]) / L
    for i in range(9):
        X[3 + i] = q[a + 3 + i]
        X[12 + i] = q[b + 3 + i]


# -- strains ---------------------------------------------------------------------------------------


@njit(cache=True, error_model="numpy")
def _strains(X, eps, arms):
    """Strains (22,), and of each point and k (8, 10) the vectors u, n = n_k and
    (u - (u.n) n)/|d|, and 1/|d|."""
    eps[:] = 0.0
    for m in range(FACTOR.size):
        j, k = 3 * LEFT[m], 3 * RIGHT[m]
        dot = X[j] * X[k] + X[j + 1] * X[k + 1] + X[j + 2] * X[k + 2]
        eps[ROW[m]] += FACTOR[m] * dot
    for g in range(4):
        for k in range(2):
            row, arm = POINT_ROW[g, k], arms[2 * g + k]
            dd, ud = 0.0, 0.0
            for i in range(3):
                arm[i] = AHEAD[g, 0] * X[i] + AHEAD[g, 1] * X[3 + i] + AHEAD[g, 2] * X[12 + i]
                d = ENDS[g, 0] * X[6 + 3 * k + i] + ENDS[g, 1] * X[15 + 3 * k + i]
                arm[3 + i] = d
                dd += d * d
                ud += arm[i] * d
            N = 1.0 / np.sqrt(dd)
            eps[row] = ud * N
            arm[9] = N
            for i in range(3):
                arm[3 + i] *= N
                arm[6 + i] = (arm[i] - eps[row] * arm[3 + i]) * N
    eps[ONE] = 1.0
    _mix(eps, SWEEP[0], SWEEP[1])
    for r in range(BENDING, SHEAR):
        eps[r] /= np.sqrt(eps[NORMAL + (r - BENDING) % 2])
    _mix(eps, SWEEP[1], SWEEP[2])


@njit(cache=True, error_model="numpy")
def _mix(eps, first, end):
    """Add products of strains to strains."""
    for m in range(first, end):
        eps[MIX_ROW[m]] += MIX_FACTOR[m] * eps[MIX_P[m]] * eps[MIX_Q[m]]


@njit(cache=True, error_model="numpy")
def _rates(X, V, eps, arms, rate):
    """Rates (22,) of the strains."""
    rate[:] = 0.0
    for m in range(FACTOR.size):
        j, k = 3 * LEFT[m], 3 * RIGHT[m]
        for i in range(3):
            rate[ROW[m]] += FACTOR[m] * (X[j + i] * V[k + i] + V[j + i] * X[k + i])
    for g in range(4):
        for k in range(2):
            row, arm = POINT_ROW[g, k], arms[2 * g + k]
            for i in range(3):
                u = AHEAD[g, 0] * V[i] + AHEAD[g, 1] * V[3 + i] + AHEAD[g, 2] * V[12 + i]
                d = ENDS[g, 0] * V[6 + 3 * k + i] + ENDS[g, 1] * V[15 + 3 * k + i]
                rate[row] += arm[3 + i] * u + arm[6 + i] * d
    _mixed_rates(eps, rate, SWEEP[0], SWEEP[1])
    for r in range(BENDING, SHEAR):
        z = NORMAL + (r - BENDING) % 2
        rate[r] = rate[r] / np.sqrt(eps[z]) - 0.5 * eps[r] / eps[z] * rate[z]
    _mixed_rates(eps, rate, SWEEP[1], SWEEP[2])


@njit(cache=True, error_model="numpy")
def _mixed_rates(eps, rate, first, end):
    for m in range(first, end):
        p, q = MIX_P[m], MIX_Q[m]
        rate[MIX_ROW[m]] += MIX_FACTOR[m] * (eps[p] * rate[q] + rate[p] * eps[q])


@njit(cache=True, error_model="numpy")
def _relief(coef, b):
    """Slope and stiffness of the energy in the turn phi of the section at both Gauss points.

    A parabola that vanishes at the nodes: its torsion costs 6 GJ/L phi^2; it makes b_2 + phi b_3
    and b_3 - phi b_2 of the bending strains b (4,).
    """
    slope, stiffness = 0.0, 12.0 * coef[TORSION] + TINY
    for g in range(2):
        k, m = coef[BENDING + g], coef[BENDING + 2 + g]
        M2 = k * (b[g] - coef[STRAINS + BENDING + g])
        M3 = m * (b[2 + g] - coef[STRAINS + BENDING + 2 + g])
        slope += M2 * b[2 + g] - M3 * b[g]
        stiffness += k * b[2 + g] * b[2 + g] + m * b[g] * b[g]
    return slope, stiffness


@njit(cache=True, error_model="numpy")
def _stresses(coef, tau, eps, rate, S, U):
    """Stress of each strain; rows that are no strains have none. Of the four bending stresses also
    the derivatives U (4, 4): in the own strain, the other of that point, and the turn phi; last
    that of phi in the strain."""
    S[:] = 0.0
    for r in range(STRAINS):
        S[OF[r]] = coef[r] * (eps[OF[r]] - coef[STRAINS + r])
    slope, stiffness = _relief(coef, eps[BENT:])
    phi = -slope / stiffness
    for g in range(2):
        p, q, k, m = BENT + g, BENT + 2 + g, coef[BENDING + g], coef[BENDING + 2 + g]
        M2, M3 = S[p] + phi * k * eps[q], S[q] - phi * m * eps[p]
        S[p], S[q] = M2 - phi * M3, M3 + phi * M2
        U[g, 0], U[g, 1] = k + phi * phi * m, phi * (k - m)
        U[2 + g, 0], U[2 + g, 1] = m + phi * phi * k, phi * (k - m)
        U[g, 2] = k * eps[q] - M3 + phi * m * eps[p]
        U[2 + g, 2] = M2 - m * eps[p] + phi * k * eps[q]
    for i in range(4):
        U[i, 3] = -U[i, 2] / stiffness
    if tau > 0.0:
        for r in range(STRAINS):
            S[OF[r]] += tau * coef[r] * (rate[OF[r]] - coef[2 * STRAINS + r])


@njit(cache=True, error_model="numpy")
def _pass_on(eps, S, first, end):
    """Pass the stresses of products on to their factors."""
    for m in range(end - 1, first - 1, -1):
        p, q = MIX_P[m], MIX_Q[m]
        s = S[MIX_ROW[m]] * MIX_FACTOR[m]
        S[p] += s * eps[q]
        S[q] += s * eps[p]


@njit(cache=True, error_model="numpy")
def _divide_stresses(eps, S):
    """Pass the bending moments on to numerator and denominator."""
    for r in range(BENDING, SHEAR):
        z = NORMAL + (r - BENDING) % 2
        S[z] -= 0.5 * eps[r] / eps[z] * S[r]
        S[r] /= np.sqrt(eps[z])


@njit(cache=True, error_model="numpy")
def evaluate(q, v, ints, floats, strains, rates):
    """Strains and their rates (n_e, 18) of all elements."""
    X, V, arms = np.empty(21), np.empty(21), np.empty((8, 10))
    eps, rate = np.empty(ROWS), np.empty(ROWS)
    for e in range(len(floats)):
        _gather(q, ints, e, floats[e, 0], X)
        _gather(v, ints, e, floats[e, 0], V)
        _strains(X, eps, arms)
        _rates(X, V, eps, arms, rate)
        for r in range(STRAINS):
            strains[e, r], rates[e, r] = eps[OF[r]], rate[OF[r]]


@njit(cache=True, error_model="numpy")
def _damped(floats, first):
    """Whether any of ``WIDTH`` elements is damped."""
    found = False
    for e in range(first, min(first + WIDTH, len(floats))):
        found = found or floats[e, 1] > 0.0
    return found


@njit(cache=True, error_model="numpy")
def _load(y, v, coef, ints, floats, first, damped, source):
    """What ``WIDTH`` elements from ``first`` on are computed from; the last one stands for those
    that there are not."""
    columns = 3 * STRAINS if damped else 2 * STRAINS
    X, start = np.empty(21), MOVING if damped else STILL
    for k in range(WIDTH):
        e = min(first + k, len(floats) - 1)
        source[DAMPING * WIDTH + k] = floats[e, 1]
        _gather(y, ints, e, floats[e, 0], X)
        for i in range(21):
            source[(VECTORS + i) * WIDTH + k] = X[i]
        if damped:
            _gather(v, ints, e, floats[e, 0], X)
            for i in range(21):
                source[(RATES + i) * WIDTH + k] = X[i]
        for r in range(columns):
            source[(start + r) * WIDTH + k] = coef[e, r]


@kernel(FORCE)
def add_force(y, v, coef, ints, floats, out):
    """Add the sum over strains of stress times gradient to ``out``."""
    source, f = np.empty((MOVING + 3 * STRAINS) * WIDTH), np.empty(21 * WIDTH)
    for first in range(0, len(floats), WIDTH):
        damped = _damped(floats, first)
        _load(y, v, coef, ints, floats, first, damped, source)
        if damped:
            damped_forces(source, f)
        else:
            still_forces(source, f)
        for k in range(min(WIDTH, len(floats) - first)):
            e = first + k
            a, b, L = ints[e, 0], ints[e, 1], floats[e, 0]
            for i in range(3):
                out[a + i] -= f[i * WIDTH + k] / L
                out[b + i] += f[i * WIDTH + k] / L
            for i in range(9):
                out[a + 3 + i] += f[(3 + i) * WIDTH + k]
                out[b + 3 + i] += f[(12 + i) * WIDTH + k]


@kernel(ENERGY)
def add_energy(y, v, coef, ints, floats, out):
    """Add elastic energy, and powers lost in damping and done by it on changing free strains."""
    source, found = np.empty((MOVING + 3 * STRAINS) * WIDTH), np.zeros(3 * WIDTH)
    for first in range(0, len(floats), WIDTH):
        damped = _damped(floats, first)
        _load(y, v, coef, ints, floats, first, damped, source)
        if damped:
            damped_energies(source, found)
        else:
            still_energies(source, found)
        for k in range(min(WIDTH, len(floats) - first)):
            out[0] += found[k]
            if damped:
                out[1] += found[WIDTH + k]
                out[2] += found[2 * WIDTH + k]


# -- tangent ---------------------------------------------------------------------------------------


@njit(cache=True, error_model="numpy")
def _products(X, G):
    """Gradients (22, 24) of the sums of products of vectors; linear in X."""
    for m in range(FACTOR.size):
        row, j, k, factor = ROW[m], 3 * LEFT[m], 3 * RIGHT[m], FACTOR[m]
        for i in range(3):
            G[row, j + i] += factor * X[k + i]
            G[row, k + i] += factor * X[j + i]


@njit(cache=True, error_model="numpy")
def _points(arms, G):
    """Gradients of u.n_k at the four points."""
    for g in range(4):
        for k in range(2):
            row, arm = POINT_ROW[g, k], arms[2 * g + k]
            for i in range(3):
                for m in range(3):
                    G[row, 3 * AXIS[m] + i] += AHEAD[g, m] * arm[3 + i]
                for m in range(2):
                    G[row, 9 * m + 6 + 3 * k + i] += ENDS[g, m] * arm[6 + i]


@njit(cache=True, error_model="numpy")
def _derivatives(eps, J):
    """Derivatives (24, 12) of the strains in the inner measures."""
    J[:] = 0.0
    for a in range(INNER):
        J[INSIDE[a], a] = 1.0
    for m in range(SWEEP[0], SWEEP[1]):
        r, p, q, f = MIX_ROW[m], MIX_P[m], MIX_Q[m], MIX_FACTOR[m]
        J[r, PLACE[p]] += f * eps[q]
        J[r, PLACE[q]] += f * eps[p]
    for r in range(BENDING, SHEAR):
        z = NORMAL + (r - BENDING) % 2
        s, half = 1.0 / np.sqrt(eps[z]), 0.5 * eps[r] / eps[z]
        for j in range(INNER):
            J[r, j] = s * J[r, j] - half * J[z, j]
    for m in range(SWEEP[1], SWEEP[2]):
        r, p, q, f = MIX_ROW[m], MIX_P[m], MIX_Q[m], MIX_FACTOR[m]
        for j in range(INNER):
            J[r, j] += f * eps[q] * J[p, j]
        if q != ONE:
            for j in range(INNER):
                J[r, j] += f * eps[p] * J[q, j]


@njit(cache=True, error_model="numpy")
def _changes(eps, rate, J, Jv):
    """Rates (24, 12) of the derivatives."""
    Jv[:] = 0.0
    for m in range(SWEEP[0], SWEEP[1]):
        r, p, q, f = MIX_ROW[m], MIX_P[m], MIX_Q[m], MIX_FACTOR[m]
        Jv[r, PLACE[p]] += f * rate[q]
        Jv[r, PLACE[q]] += f * rate[p]
    for r in range(BENDING, SHEAR):
        z = NORMAL + (r - BENDING) % 2
        s, half = 1.0 / np.sqrt(eps[z]), 0.5 / eps[z]
        a = half * (half * eps[r] * rate[z] - rate[r])
        for j in range(INNER):
            Jv[r, j] = s * Jv[r, j] - half * (eps[r] * Jv[z, j] + rate[z] * J[r, j]) + a * J[z, j]
    for m in range(SWEEP[1], SWEEP[2]):
        r, p, q, f = MIX_ROW[m], MIX_P[m], MIX_Q[m], MIX_FACTOR[m]
        for j in range(INNER):
            Jv[r, j] += f * eps[q] * Jv[p, j]
        if q != ONE:
            for j in range(INNER):
                Jv[r, j] += f * (eps[p] * Jv[q, j] + rate[p] * J[q, j] + rate[q] * J[p, j])


@njit(cache=True, error_model="numpy")
def _weigh(D, J, W):
    """Add stiffness times derivatives to W of the strains."""
    for r in range(BENDING, SECTION):
        for j in range(INNER):
            W[OF[r], j] += D[r] * J[OF[r], j]


@njit(cache=True, error_model="numpy")
def _weigh_bending(cK, U, J, W):
    """The same for the elastic part of bending, with its turn between the nodes."""
    for j in range(INNER):
        turn = 0.0
        for i in range(4):
            turn += U[i, 3] * J[BENT + i, j]
        for i in range(4):
            bent = U[i, 0] * J[BENT + i, j] + U[i, 1] * J[BENT + (i + 2) % 4, j]
            W[BENT + i, j] += cK * (bent + U[i, 2] * turn)


@njit(cache=True, error_model="numpy")
def _pull_back(eps, J, S, W):
    """The last sweep, backwards: W and stresses of strains become those of bending and turn."""
    for m in range(SWEEP[2] - 1, SWEEP[1] - 1, -1):
        r, p, q = MIX_ROW[m], MIX_P[m], MIX_Q[m]
        a, b, s = MIX_FACTOR[m] * eps[q], MIX_FACTOR[m] * eps[p], MIX_FACTOR[m] * S[r]
        S[p] += a * S[r]
        S[q] += b * S[r]
        for j in range(INNER):
            W[p, j] += a * W[r, j] + s * J[q, j]
        if q != ONE:
            for j in range(INNER):
                W[q, j] += b * W[r, j] + s * J[p, j]


@njit(cache=True, error_model="numpy")
def _curvatures(eps, J, S, W):
    """Curvatures of the strains, W (24, 12) such that their sum is J_r (x) W_r; S becomes the
    stresses of the measures.

    b = eta z^-1/2 has the second derivative z^-1/2 eta'' - b/(2 z) z'' - (b' z' + z' b')/(2 z)
    + b/(4 z^2) z' z'.
    """
    _pull_back(eps, J, S, W)
    for r in range(BENDING, SHEAR):
        z = NORMAL + (r - BENDING) % 2
        half = 0.5 / eps[z]
        for j in range(INNER):
            W[r, j] -= half * S[r] * J[z, j]
            W[z, j] -= half * S[r] * (J[r, j] - half * eps[r] * J[z, j])
    _divide_stresses(eps, S)
    for m in range(SWEEP[0], SWEEP[1]):
        p, q, s = MIX_P[m], MIX_Q[m], S[MIX_ROW[m]] * MIX_FACTOR[m]
        W[p, PLACE[q]] += s
        W[q, PLACE[p]] += s
    _pass_on(eps, S, SWEEP[0], SWEEP[1])


@njit(cache=True, error_model="numpy")
def _arm_rates(V, arms, arms_v):
    """Rates of n_k and of (u - (u.n) n)/|d| at all points."""
    for g in range(4):
        for k in range(2):
            arm, arm_v = arms[2 * g + k], arms_v[2 * g + k]
            N, un, nu, nd, ud = arm[9], 0.0, 0.0, 0.0, 0.0
            for i in range(3):
                u = AHEAD[g, 0] * V[i] + AHEAD[g, 1] * V[3 + i] + AHEAD[g, 2] * V[12 + i]
                d = ENDS[g, 0] * V[6 + 3 * k + i] + ENDS[g, 1] * V[15 + 3 * k + i]
                arm_v[i], arm_v[6 + i] = d, u
                un += arm[i] * arm[3 + i]
                nu += arm[3 + i] * u
                nd += arm[3 + i] * d
                ud += arm[i] * d
            for i in range(3):
                n, d = arm[3 + i], arm_v[i]
                bent = un * (3.0 * nd * n - d) - arm[i] * nd - n * ud
                arm_v[3 + i] = N * (d - nd * n)
                arm_v[6 + i] = N * (arm_v[6 + i] - nu * n + N * bent)


@njit(cache=True, error_model="numpy")
def _alike(arms, S, P):
    """Second derivatives of the measures that act on x, y, z alike, between vectors: P (7, 7)."""
    P[:] = 0.0
    for m in range(FACTOR.size):
        s = FACTOR[m] * S[ROW[m]]
        P[LEFT[m], RIGHT[m]] += s
        P[RIGHT[m], LEFT[m]] += s
    for g in range(4):
        for k in range(2):
            arm, row = arms[2 * g + k], POINT_ROW[g, k]
            un = arm[0] * arm[3] + arm[1] * arm[4] + arm[2] * arm[5]
            a, b = S[row] * arm[9], S[row] * un * arm[9] * arm[9]
            for o in range(2):
                d = A2 + k + 3 * o
                for m in range(3):
                    P[AXIS[m], d] += a * AHEAD[g, m] * ENDS[g, o]
                    P[d, AXIS[m]] += a * AHEAD[g, m] * ENDS[g, o]
                for m in range(2):
                    P[A2 + k + 3 * m, d] -= b * ENDS[g, m] * ENDS[g, o]


@njit(cache=True, error_model="numpy")
def _add_four(A, a, i, B, b, C, c, count):
    """C[c + k] += sum over four rows r of A[a + r, i + k] B[b + r], for k < ``count``."""
    for k in range(count):
        p, q, r, s = A[a, i + k], A[a + 1, i + k], A[a + 2, i + k], A[a + 3, i + k]
        for j in range(B.shape[1]):
            C[c + k, j] += (p * B[b, j] + q * B[b + 1, j]) + (r * B[b + 2, j] + s * B[b + 3, j])


@njit(cache=True, error_model="numpy")
def _turning(arms, S, G, R, K, A, Q):
    """The others: with the gradient g of u.n and the vector m that has n at d, they are
    -(g m^T + m g^T - u.n/|d| m m^T)/|d|. What stands behind g goes to R, the rest, A^T Q, to K."""
    for k in range(2):
        for g in range(4):
            arm, row = arms[2 * g + k], POINT_ROW[g, k]
            un = arm[0] * arm[3] + arm[1] * arm[4] + arm[2] * arm[5]
            a = -S[row] * arm[9]
            for j in range(LONG):
                Q[g, j] = a * G[row, j]
            for i in range(6):
                A[g, i] = ENDS[g, i // 3] * arm[3 + i % 3]
                j = 9 * (i // 3) + 6 + 3 * k + i % 3
                R[row, j] += a * A[g, i]
                Q[g, j] -= a * un * arm[9] * A[g, i]
        _add_four(A, 0, 0, Q, 0, K, 6 + 3 * k, 3)
        _add_four(A, 0, 3, Q, 0, K, 15 + 3 * k, 3)


@njit(cache=True, error_model="numpy")
def _inner_rows(J, W, G, R, H):
    """Add H G, H = sum J_r (x) W_r, to the rows R of the inner measures; ``H`` is transposed."""
    H[:] = 0.0
    _add_four(W, BENDING, 0, J, BENDING, H, 0, INNER)
    _add_four(W, NORMAL, 0, J, NORMAL, H, 0, INNER)
    for r in range(SHEAR, TORSION):  # J is 1
        for j in range(INNER):
            H[j, PLACE[r]] += W[r, j]
    for m in range(0, INNER, 4):
        _add_four(H, m, 0, G, INSIDE[m], R, BENDING, 8)
        _add_four(H, m, 8, G, INSIDE[m], R, NORMAL, 3)


@njit(cache=True, error_model="numpy")
def _whole(J, G, B):
    """Add what axial strains owe to others to their gradients."""
    for m in range(OWED_ROW.size):
        r, row = OWED_ROW[m], OWED_TO[m]
        c = J[r, PLACE[row]]
        for j in range(LONG):
            B[r, j] += c * G[row, j]


@njit(cache=True, error_model="numpy")
def _outer_rows(D, G, R):
    """Add the rows R of the strains on which no other depends."""
    for m in range(OUTER.size):
        r = OUTER[m]
        for j in range(LONG):
            R[r, j] += D[r] * G[r, j]


@kernel(TANGENT)
def add_tangent(y, v, coef, ints, floats, cK, cC, slots, data):
    """Add cK df/dq + cC df/dv to ``data``.

    f = sum S B with S = D (eps - free + tau B.v); hence df/dq = sum D B (B + tau dB/dt)^T + S dB/dq
    and df/dv = sum D tau B B^T.
    """
    X, V, K, row = np.empty(21), np.zeros(21), np.empty((21, LONG)), np.empty(LONG)
    G, Gv, R = np.empty((LONG, LONG)), np.zeros((LONG, LONG)), np.empty((LONG, LONG))
    J, Jv, W = np.empty((ROWS, INNER)), np.zeros((ROWS, INNER)), np.empty((ROWS, INNER))
    H, P, D, Dv = np.empty((INNER, INNER)), np.empty((7, 7)), np.empty(STRAINS), np.empty(STRAINS)
    arms, arms_v, A, Q = np.empty((8, 10)), np.empty((8, 10)), np.empty((4, 6)), np.empty((4, LONG))
    eps, rate, S, none = np.empty(ROWS), np.zeros(ROWS), np.empty(ROWS), np.zeros(ROWS)
    U = np.empty((4, 4))
    for e in range(len(floats)):
        L, tau = floats[e, 0], floats[e, 1]
        _gather(y, ints, e, L, X)
        _strains(X, eps, arms)
        if tau > 0.0:
            _gather(v, ints, e, L, V)
            _rates(X, V, eps, arms, rate)
        _stresses(coef[e], tau, eps, rate, S, U)
        S *= cK
        for r in range(STRAINS):
            c = cC * tau if BENDING <= r < SHEAR else cK + cC * tau
            D[r], Dv[r] = coef[e, r] * c, coef[e, r] * cK * tau
        G[:], R[:], K[:] = 0.0, 0.0, 0.0
        _products(X, G)
        _points(arms, G)
        _derivatives(eps, J)
        W[:] = 0.0
        _weigh(D, J, W)
        _weigh_bending(cK, U, J, W)
        if tau > 0.0:
            _changes(eps, rate, J, Jv)
            _weigh(Dv, Jv, W)
        _curvatures(eps, J, S, W)
        _alike(arms, S, P)
        for a in range(7):
            for b in range(7):
                for i in range(3):
                    K[3 * a + i, 3 * b + i] = P[a, b]
        _turning(arms, S, G, R, K, A, Q)
        _inner_rows(J, W, G, R, H)
        if tau > 0.0:
            Gv[:] = 0.0
            _products(V, Gv)
            _arm_rates(V, arms, arms_v)
            _points(arms_v, Gv)
            W[:] = 0.0
            _weigh(Dv, J, W)
            _pull_back(eps, J, none, W)
            _inner_rows(J, W, Gv, R, H)
            _whole(J, Gv, Gv)
            _whole(Jv, G, Gv)
            _outer_rows(Dv, Gv, R)
        _whole(J, G, G)
        _outer_rows(D, G, R)
        for j in range(LONG):  # the row of torsion has no measure of its own
            G[TORSION, j], R[TORSION, j] = G[TURN, j], R[TURN, j]
        for r in range(0, TURN, 4):
            first = FIRST[r // 4]
            _add_four(G, r, first, R, r, K, first, 21 - first)
        for i in range(24):
            c = -1.0 / L if i < 3 else (1.0 / L if 12 <= i < 15 else 1.0)
            k = i if i < 12 else (i - 12 if i < 15 else i - 3)
            for j in range(3):
                row[j], row[12 + j] = -c * K[k, j] / L, c * K[k, j] / L
            for j in range(9):
                row[3 + j], row[15 + j] = c * K[k, 3 + j], c * K[k, 12 + j]
            for j in range(24):
                data[slots[e, 24 * i + j]] += row[j]
