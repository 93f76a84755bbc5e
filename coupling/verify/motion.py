"""Running small models in time, for verification problems."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from coupling.verify.models import Model
from mechanics.dynamics import Control, Window, advance, initial_state
from mechanics.march import Rows
from mechanics.schemes import Scheme
from mechanics.system import Coefficients

Array = NDArray[np.float64]


class Path(NamedTuple):
    """Of each step: t : (k,) [s], q, v : (k, n), lam : (k, m), response : (k, n_j, columns),
    ledger : (k, terms) [J], approach : (k, n_j) [m/s]
    """

    t: Array
    q: Array
    v: Array
    lam: Array
    response: Array
    ledger: Array
    approach: Array


def fixed(h: float, alpha: float = -0.1, newton: float = 1e-13) -> Control:
    """Constant steps of ``h`` [s]."""
    return Control(np.inf, h, h, Scheme(alpha=alpha, newton_tolerance=newton))


def run(
    made: Model,
    end: float,
    control: Control,
    windows: int = 1,
    heated: Callable[[float], Coefficients] | None = None,
) -> Path:
    """All accepted steps up to ``end`` [s]; an error if the run stops.

    ``heated`` gives the coefficients at a time, when they change.
    """
    coefficients = heated or (lambda t: made.coef)
    state, why = initial_state(made.system, control, coefficients(0.0))
    kept: list[Rows] = []
    for k in range(windows):
        if state is None or why:
            raise RuntimeError(why)
        t = k * end / windows
        h = (k + 1) * end / windows - t
        c0, c1 = coefficients(t), None if heated is None else heated(t + h)
        window = Window.between(made.system, state.motion.t, h, c0, c1)
        state, _, why = advance(made.system, control, state, window, kept.append, full=True)
    if why:
        raise RuntimeError(why)
    n = made.system.n
    rows = Rows._make(np.concatenate(parts) for parts in zip(*kept, strict=True))
    return Path(
        rows.t, rows.y[:, :n], rows.v[:, :n], rows.y[:, n:], rows.response, rows.ledger,
        rows.approach,
    )  # fmt: skip


def order(errors: Array, ratio: float = 2.0) -> float:
    """Observed order from the last two of a sequence of errors, steps refined by ``ratio``."""
    return float(np.log(errors[-2] / errors[-1]) / np.log(ratio))
