"""Time and memory of heat in 3D as it grows, against plain scikit-fem and CalculiX in one run."""

import resource
from collections.abc import Iterator
from statistics import median

import numpy as np

from coupling.reports.heat_rivals import STEP, calculix, ours, plain
from coupling.reports.registry import Result, Row

CELLS, LARGE = (20, 36), (53, 79)
"""Cells along an edge: 9,261 and 50,653 temperatures; 157,464 and 512,000."""
STEPS = 4
COLUMNS = (
    "temperatures", "building [s]", "first step [s]", "step [s]", "memory [GB]",
    "scikit-fem [s]", "ratio", "differs by [K]", "CalculiX [s]", "ratio ", "differs by [K] ",
)  # fmt: skip


def report(largest: bool = False) -> Iterator[Result]:
    """Times of a step of a radiating box with k(T), c(T).

    Parameters
    ----------
    largest : boxes of 157,464 and 512,000 temperatures as well, without the other programs
    """
    ours(3, 1, "multigrid")  # compiles
    rows = [compared(cells) for cells in CELLS]
    rows += [alone(cells) for cells in LARGE] if largest else []
    yield Result(
        "heat_speed",
        f"Heat in 3D: a radiating box, backward Euler in steps of {STEP:g} s",
        COLUMNS,
        rows,
        [
            f"steps are medians of {STEPS - 1}, the first apart; memory is the largest so far",
            "processor times with one thread each; CalculiX with iterative Cholesky, its fastest "
            "solver here, not its usual one; scikit-fem assembled in each iteration, with CG "
            "and Jacobi",
            "CalculiX takes c at the end of a step, which makes the difference to it",
        ],
    )


def compared(cells: int) -> Row:
    """A row of the table, with the other programs."""
    row = alone(cells)
    T, step = ours(cells, 3, "multigrid").T, float(row[3])
    others = []
    for other in (plain, calculix):
        answer = other(cells, 3)
        each = median(answer.steps)
        others += [each, each / step, float(np.abs(answer.T - T).max())]
    return (*row[:5], *others)


def alone(cells: int) -> Row:
    """A row of the table without them."""
    answer = ours(cells, STEPS, "multigrid")
    used = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
    times = answer.start, answer.steps[0], median(answer.steps[1:])
    return (len(answer.T), *times, used, *[""] * 6)
