"""Constraint rows Φ = Σ weight y − constant − coef[0]; one that is not active has λ = 0."""

from mechanics.kernels import FORCE, TANGENT, kernel


@kernel(FORCE)
def add_force(y, v, coef, ints, floats, out):
    """λ Φ_y and Φ; ``ints``: multiplier, coordinates, their indices; ``floats``: constant, weights;
    ``coef``: drive, 1 where active."""
    for e in range(ints.shape[0]):
        row, lam = ints[e, 0], y[ints[e, 0]]
        if coef[e, 1] == 0.0:
            out[row] += lam
            continue
        value = -floats[e, 0] - coef[e, 0]
        for i in range(ints[e, 1]):
            value += floats[e, 1 + i] * y[ints[e, 2 + i]]
            out[ints[e, 2 + i]] += lam * floats[e, 1 + i]
        out[row] += value


@kernel(TANGENT)
def add_tangent(y, v, coef, ints, floats, cK, cC, slots, data):
    """Φ_y as row and as column, or 1 on the diagonal of a row that is not active."""
    n = ints.shape[1] - 1
    for e in range(ints.shape[0]):
        at = slots[e]
        if coef[e, 1] == 0.0:
            data[at[n * n - 1]] += 1.0
            continue
        for i in range(ints[e, 1]):
            data[at[i * n + n - 1]] += floats[e, 1 + i]
            data[at[(n - 1) * n + i]] += floats[e, 1 + i]
