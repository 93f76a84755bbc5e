"""Tangents of terms against differences of their forces, dense."""

import numpy as np

from mechanics import kernels


def force(term, y, v, coef):
    """(size of y,) what the term adds."""
    out = np.zeros_like(y)
    kernels.add_force(term, y, v, coef, out)
    return out


def jacobian(term, y, v, coef, cK, cC):
    """(size of y, size of y) what the term adds, dense."""
    found = np.zeros((y.size + 1, y.size + 1))
    for dofs, block in zip(
        term.dofs, kernels.tangent_blocks(term, y, v, coef, cK, cC), strict=True
    ):
        np.add.at(found, np.ix_(dofs, dofs), block)
    return found[:-1, :-1]


def slopes(function, x, step=1e-3):
    """Derivative by central differences, extrapolated once (error of fourth order)."""

    def central(h):
        ends = [(function(x + d) - function(x - d)) / (2.0 * h) for d in h * np.eye(x.size)]
        return np.array(ends).T

    return (4.0 * central(0.5 * step) - central(step)) / 3.0


def expected_jacobian(term, y, v, coef, cK, cC, n, step=1e-3):
    """The same by differences: constraints enter with Phi_q and its transpose, whatever cK."""
    K = slopes(lambda x: force(term, x, v, coef), y, step)
    C = slopes(lambda x: force(term, y, x, coef), v, step)
    J = cK * K + cC * C
    J[n:], J[:, n:] = K[n:], K[:, n:]
    return J
