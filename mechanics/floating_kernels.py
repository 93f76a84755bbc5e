"""Kernels of bodies in a floating frame: linear strains of modes, and what ties nodes to them.

Elements. The strains of an element are linear in the amplitudes p of the n modes, e = B p; stress,
damping and energy follow from coefficients as of the beam itself, but for the ``USED`` first
strains only: sections are rigid. ints: first amplitude. floats: damping time [s], strains of the
reference (USED), B (USED, n) [1/m]. coef: stiffness, free strain and its rate, STRAINS of each.

Ties, Phi = vector - (r + sum of c_i e_i), c_i = X_i + S_i p, of every vector of every node in two
parts, which do not know one another in the pattern of the system. ints: part, multiplier, first
coordinate of the vector (``OWN``) or of the frame (``PLACE``; ``DIRECTION``: without r). floats: X
(3), S (3, n).
"""

from mechanics.beam3243_tables import SECTION as USED
from mechanics.beam3243_tables import STRAINS
from mechanics.kernels import ENERGY, FORCE, TANGENT, kernel

OWN, PLACE, DIRECTION = 0, 1, 2
"""Parts of ties: the vector of the node; what a position, or a direction, must be."""
HEAD = 1
"""Numbers of an element before the strains of the reference."""
FRAME = 12
"""Coordinates of a frame before the amplitudes: r, e1, e2, e3."""


@kernel(FORCE)
def add_force(y, v, coef, ints, floats, out):
    n = (floats.shape[1] - HEAD) // USED - 1
    for e in range(len(ints)):
        p, tau, row = ints[e, 0], floats[e, 0], floats[e, HEAD:]
        for r in range(USED):
            B = row[USED + n * r : USED + n * (r + 1)]
            strain, rate = row[r], 0.0
            for j in range(n):
                strain += B[j] * y[p + j]
                rate += B[j] * v[p + j]
            viscous = tau * (rate - coef[e, 2 * STRAINS + r])
            stress = coef[e, r] * (strain - coef[e, STRAINS + r] + viscous)
            for j in range(n):
                out[p + j] += B[j] * stress


@kernel(ENERGY)
def add_energy(y, v, coef, ints, floats, out):
    n = (floats.shape[1] - HEAD) // USED - 1
    for e in range(len(ints)):
        p, row = ints[e, 0], floats[e, HEAD:]
        for r in range(USED):
            strain, rate = row[r], 0.0
            for j in range(n):
                strain += row[USED + n * r + j] * y[p + j]
                rate += row[USED + n * r + j] * v[p + j]
            heated = coef[e, 2 * STRAINS + r]
            viscous = floats[e, 0] * coef[e, r] * (rate - heated)
            out[0] += 0.5 * coef[e, r] * (strain - coef[e, STRAINS + r]) ** 2
            out[1] += viscous * (rate - heated)
            out[2] += viscous * heated


@kernel(TANGENT)
def add_tangent(y, v, coef, ints, floats, cK, cC, slots, data):
    n = (floats.shape[1] - HEAD) // USED - 1
    at = slots[0]
    for e in range(len(ints)):
        factor, row = cK + cC * floats[e, 0], floats[e, HEAD:]
        for r in range(USED):
            B = row[USED + n * r : USED + n * (r + 1)]
            for i in range(n):
                part = factor * coef[e, r] * B[i]
                for j in range(n):
                    data[at[n * i + j]] += part * B[j]


@kernel(FORCE)
def add_ties(y, v, coef, ints, floats, out):
    n = floats.shape[1] // 3 - 1
    for e in range(len(ints)):
        part, row, at = ints[e, 0], ints[e, 1], ints[e, 2]
        if part != DIRECTION:
            sign = 1.0 if part == OWN else -1.0
            for k in range(3):
                out[at + k] += sign * y[row + k]
                out[row + k] += sign * y[at + k]
        if part == OWN:
            continue
        p = at + FRAME
        for i in range(3):
            d, S, c, work = (
                at + 3 + 3 * i,
                floats[e, 3 + n * i : 3 + n * (i + 1)],
                floats[e, i],
                0.0,
            )
            for j in range(n):
                c += S[j] * y[p + j]
            for k in range(3):
                out[row + k] -= c * y[d + k]
                out[d + k] -= c * y[row + k]
                work += y[d + k] * y[row + k]
            for j in range(n):
                out[p + j] -= S[j] * work


@kernel(TANGENT)
def add_tie_tangents(y, v, coef, ints, floats, cK, cC, slots, data):
    n = floats.shape[1] // 3 - 1
    w, last = FRAME + n + 3, FRAME + n
    for e in range(len(ints)):
        part, row, at, s = ints[e, 0], ints[e, 1], ints[e, 2], slots[e]
        if part != DIRECTION:
            sign, here = (1.0, 3) if part == OWN else (-1.0, last)
            for k in range(3):
                data[s[w * k + here + k]] += sign
                data[s[w * (here + k) + k]] += sign
        if part == OWN:
            continue
        p = at + FRAME
        for i in range(3):
            d, S, c = 3 + 3 * i, floats[e, 3 + n * i : 3 + n * (i + 1)], floats[e, i]
            for j in range(n):
                c += S[j] * y[p + j]
            for k in range(3):
                here = last + k
                data[s[w * (d + k) + here]] -= c
                data[s[w * here + d + k]] -= c
                for j in range(n):
                    turned, held = S[j] * y[at + d + k], cK * S[j] * y[row + k]
                    data[s[w * (FRAME + j) + here]] -= turned
                    data[s[w * here + FRAME + j]] -= turned
                    data[s[w * (FRAME + j) + d + k]] -= held
                    data[s[w * (d + k) + FRAME + j]] -= held
