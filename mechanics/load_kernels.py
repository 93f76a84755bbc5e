"""Compiled kernels of loads that depend on nothing but time."""

from mechanics.kernels import FORCE, TANGENT, kernel


@kernel(FORCE)
def add_dead(y, v, coef, ints, floats, out):
    """Constant generalised forces times an amplitude; ints: first coordinate of each vector."""
    for e in range(ints.shape[0]):
        for j in range(ints.shape[1]):
            if ints[e, j] >= 0:
                for i in range(3):
                    out[ints[e, j] + i] -= coef[e, 0] * floats[e, 3 * j + i]


@kernel(TANGENT)
def add_nothing(y, v, coef, ints, floats, cK, cC, slots, data):
    pass
