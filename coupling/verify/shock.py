"""Heat shocks on coarse meshes: which schemes keep temperatures between start and boundary.

An insulated bar of 10 elements, one end of which jumps or falls at 25 K/s from 200 to -50 degC as
in Hua et al. (2026). Numbers are how far temperatures leave the range of start and boundary, in %
of the jump, over Fourier numbers of a step from 1e-3 to 1e6.
"""

from math import sqrt

import numpy as np
from numpy.typing import NDArray

from coupling.reports.heat_shock import (
    CONTROLLED,
    ELEMENTS,
    FOURIER,
    KINDS,
    OWN,
    SCHEMES,
    SHOCKS,
    STEPS,
    undershoot,
)
from coupling.verify.registry import Check, Grid, problem

Array = NDArray[np.float64]

EULER = SCHEMES[0]
LENGTHWISE = (
    "line", "line, tube", "wall, tube", "lumped", "lumped, tube", "solid", "solid, circle",
)  # fmt: skip
"""Those that come to linear elements along the bar, with heat stored at nodes."""
KEPT = (*LENGTHWISE, "solid, tube", "solid, half a face", "solid, half a face, cells 1:5")
"""Those whose heat is stored at nodes and whose neighbours exchange heat by positive conductances:
with backward Euler they keep the range at any step."""
NONE = 1e-9  # [%]  round-off
BY_TOLERANCE = 4e-4  # [%]  of 250 K: 1e-3 K, the tolerance of a step
ALIKE = 1e-6  # [%]
BOUNDS = {
    ("hermite", EULER): 0.2,
    ("hermite", "sdirk2"): 20.0,
    ("wall, tube, order 2", EULER): 2.0,
    ("solid, order 2", EULER): 15.0,
    ("solid, order 2", "sdirk2"): 20.0,
    ("solid, order 2", "crank-nicolson"): 100.0,
}
"""Where it is known that the range is left, by how much at most [%]."""


@problem("heat", "shocks without undershoot", "maximum principle; Varga 2000, M-matrices")
def no_undershoot() -> list[Check]:
    """Backward Euler at any step."""
    return [
        Check(f"{name}, {EULER}, {shock}", worst(name, EULER, shock), 0.0, NONE, "%", absolute=True)
        for shock in SHOCKS
        for name in KEPT
    ]


@problem("heat", "shocks with steps by tolerance", "1e-3 K of 250 K")
def controlled() -> list[Check]:
    """SDIRK2 with steps controlled by the estimated error, as is the default."""
    return [
        Check(f"{name}, {shock}", worst(name, CONTROLLED, shock), 0.0, BY_TOLERANCE, "%",
              absolute=True)
        for shock in SHOCKS
        for name in ("line", "line, tube", "wall, tube", "solid, tube")
    ]  # fmt: skip


@problem("heat", "undershoot of single steps", "the same scheme on the matrices of the bar")
def of_schemes() -> list[Grid]:
    """All schemes on heat stored at nodes, and on heat stored by integrals."""
    return [_grid(name) for name in (*LENGTHWISE, "solid, consistent")]


@problem("heat", "bounds of undershoot", "0 to the bound; measured, of higher order in space")
def bounded() -> list[Check]:
    """Cubic and quadratic functions have no maximum principle."""
    checks = []
    for (name, scheme), bound in BOUNDS.items():
        found = worst(name, scheme, "jump")
        half = 0.5 * bound
        checks.append(Check(f"{name}, {scheme}", found, half, half, "%", absolute=True))
    return checks


def worst(name: str, scheme: str, shock: str) -> float:
    """Over all lengths of a step [%]."""
    return max(undershoot(name, scheme, Fo, shock) for Fo in FOURIER)


def _grid(name: str) -> Grid:
    kept = "consistent" not in name
    schemes = [s for s in KINDS[name].schemes if s != CONTROLLED]
    values = [[undershoot(name, s, Fo) for Fo in FOURIER] for s in schemes]
    references = [[of_matrices(s, Fo, kept) for Fo in FOURIER] for s in schemes]
    return Grid(name, [f"{Fo:g}" for Fo in FOURIER], schemes, values, references, ALIKE)


def of_matrices(scheme: str, Fo: float, at_nodes: bool) -> float:
    """What a scheme makes of linear elements from 1 to 0 [%], written out.

    at_nodes : whether heat is stored there
    """
    M, K, given = matrices(at_nodes)
    step, x, beyond = STEP[scheme], np.ones(ELEMENTS), 0.0
    for i in range(STEPS):
        # what the end stored leaves it in the first step, in part into its neighbour
        x = step(M, Fo * K, M @ x + (given if i == 0 else 0.0), x)
        beyond = max(beyond, -x.min(), x.max() - 1.0)
    return 100.0 * beyond


def matrices(at_nodes: bool) -> tuple[Array, Array, Array]:
    """Storage, conduction, and storage with the end that jumps; of unit elements."""
    n = ELEMENTS
    beside = np.eye(n, k=1) + np.eye(n, k=-1)
    ends = np.ones(n)
    ends[-1] = 0.5
    K = 2.0 * np.diag(ends) - beside
    if at_nodes:
        return np.diag(ends), K, np.zeros(n)
    return np.diag(ends) * 2.0 / 3.0 + beside / 6.0, K, np.eye(n)[0] / 6.0


def solved(A: Array, b: Array) -> Array:
    """x of A x = b."""
    return np.asarray(np.linalg.solve(A, b), dtype=np.float64)


def _euler(M: Array, K: Array, heat: Array, x: Array) -> Array:
    return solved(M + K, heat)


def _crank_nicolson(M: Array, K: Array, heat: Array, x: Array) -> Array:
    return solved(M + 0.5 * K, heat - 0.5 * K @ x)


def _sdirk2(M: Array, K: Array, heat: Array, x: Array) -> Array:
    g = 1.0 - 1.0 / sqrt(2.0)
    first = solved(M + g * K, heat)
    return solved(M + g * K, heat - (1.0 - g) * K @ first)


def _tr_bdf2(M: Array, K: Array, heat: Array, x: Array) -> Array:
    """Trapezoids to 2 - sqrt(2) of the step, then backward differences (Bank et al. 1985)."""
    g = 2.0 - sqrt(2.0)
    middle = solved(M + 0.5 * g * K, heat - 0.5 * g * K @ x)
    late = (1.0 - g) / (2.0 - g)
    stored = (M @ middle - (1.0 - g) ** 2 * heat) / (g * (2.0 - g))
    return solved(M + late * K, stored)


STEP = {EULER: _euler, "crank-nicolson": _crank_nicolson, "sdirk2": _sdirk2, OWN: _tr_bdf2}
