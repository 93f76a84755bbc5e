"""Extremes of the exchange of heat and motion: feedback from nothing to far too strong."""

from collections.abc import Callable, Iterator
from math import exp
from typing import Any

import numpy as np

from coupling.acceleration import KINDS
from coupling.iteration import Iterated
from coupling.manager import Pair, initial
from coupling.reports.mechanics_extremes import COLUMNS, Case, NoMotionError, row
from coupling.reports.registry import Result
from coupling.reports.stability_exchange import ADVANCES, AWAY, OUTSIDE, answering
from coupling.verify.coupled import answering as wells


def report() -> Iterator[Result]:
    """All cases."""
    rows = [row(case) for case in cases()]
    bad = [f"{r[0]}: {r[1]}" for r in rows if r[1] != r[2]]
    note = f"{len(rows)} rows; neither right nor with the reason that is due: "
    yield Result("coupling_extremes", "Extremes of the exchange", COLUMNS, rows,
                 [note + ("; ".join(bad) or "none")])  # fmt: skip


def cases() -> Iterator[Case]:
    """One after the other."""
    for strength in (0.0, 1e-12):
        yield Case(
            f"feedback of {strength:g}, serial", "left after 10 time constants",
            _left("serial", strength, 0.5, 20), exp(-10.0), tolerance=1e-6,
        )  # fmt: skip
    for kind in ("iterated, aitken", "iterated, quasi-newton"):
        yield Case(
            f"feedback of 1e6, windows of 100 time constants, {kind}", "left after 3 windows",
            _left(kind, 1e6, 100.0, 3), -_trapezoid(1e6, 100.0) ** 3, tolerance=1e-6,
        )  # fmt: skip
    for kind in ("iterated, none", "iterated, half"):
        yield Case(
            f"feedback of 1e6, windows of 100 time constants, {kind}", "",
            _left(kind, 1e6, 100.0, 3), said="heat and motion do not agree",
        )  # fmt: skip
    yield Case(
        "heat that feeds itself, twice the loss, iterated", "left after 1 time constant",
        _left("iterated, quasi-newton", -2.0, 0.01, 100), exp(1.0),
    )  # fmt: skip
    for kind in ("iterated, none", "iterated, aitken", "iterated, quasi-newton"):
        yield Case(
            f"feedback of 1, at rest after 100 windows, {kind}", "left",
            _left(kind, 1.0, 1.0, 100), 0.0, unit=1.0, tolerance=1e-9,
        )  # fmt: skip
    for kind in KINDS:
        for size in (0.9, 1.5, 1e3):
            yield _first_window(kind, size)
    yield Case("motion that refuses every window", "", _refused, said="motion: it cannot")


def _trapezoid(strength: float, h: float) -> float:
    """What an agreed window leaves, of the other sign: see ``stability_exchange.radius``."""
    b, S = 1.0 - exp(-h), 0.5 * strength
    return (b * S - exp(-h)) / (1.0 + b * S)


def _left(scheme: str, strength: float, h: float, count: int) -> Callable[[], float]:
    return lambda: _followed(scheme, answering(strength), h, count)


def _followed(scheme: str, pair: Pair, h: float, count: int) -> float:
    """Deviation after ``count`` windows, in that of the start."""
    state = initial(pair)
    for k in range(count):
        new, why = ADVANCES[scheme](pair, state, k * h, h, None)
        if new is None:
            raise NoMotionError(why)
        state = new
    return float(state.T[0] - OUTSIDE) / AWAY


def _first_window(kind: str, size: float) -> Case:
    """Two wells whose exchange has the eigenvalues -size and 0.3 size."""
    pair = wells(size)
    gains: Any = pair.motion_solver
    rise = np.linalg.solve(np.eye(2) - gains.gains, [1.0, 2.0])
    plain = KINDS[kind] is KINDS["none"]
    scheme = Iterated(1e-8, 1e-8, 400, kind)

    def found() -> float:
        new, why = scheme(pair, initial(pair), 0.0, 0.1, None)
        if new is None:
            raise NoMotionError(why)
        return float(new.T[0]) - 300.0

    said = "heat and motion do not agree" if plain and size >= 1.0 else ""
    return Case(f"spectral radius {size:g}, {kind}", "rise [K]", found, float(rise[0]), said,
                tolerance=1e-6)  # fmt: skip


def _refused() -> float:
    pair = answering(1.0)
    motion: Any = pair.motion_solver
    motion.advance = lambda state, h, T0, T1, observe=None: (state, np.zeros(1), "it cannot")
    return _followed("corrected", pair, 1.0, 1)
