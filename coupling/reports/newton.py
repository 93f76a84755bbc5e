"""Frozen Jacobian against full Newton: the same motion, a new matrix in every correction."""

from collections.abc import Iterator
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from coupling.reports.measure import factors, fixed, march, room
from coupling.reports.registry import Result
from mechanics.dynamics import State, initial_state
from mechanics.schemes import Scheme
from mechanics.system import Coefficients, System

Array = NDArray[np.float64]

FROZEN, FULL = 100, 20
"""Steps that are timed with either iteration."""


def report(system: System, h: float) -> Iterator[Result]:
    """Time of a step of ``h`` [s] with either iteration, from the same start."""
    scheme, coef = Scheme(), room(system)
    start, why = initial_state(system, fixed(h), coef)
    if start is None:
        raise RuntimeError(why)
    frozen = march(system, fixed(h), FROZEN * h, 2)
    same = march(system, fixed(h), FULL * h, 1)
    q, corrections, seconds = _full(system, scheme, start, h, coef)
    rows: list[tuple[str | float | int, ...]] = [
        ("frozen", frozen.steps, frozen.corrections, 1e3 * frozen.seconds),
        ("full", FULL, corrections, 1e3 * seconds),
    ]
    apart = float(np.max(np.abs(q - same.state.motion.q) / system.scale))
    notes = [
        f"a frozen Jacobian is {seconds / frozen.seconds:.1f} times faster",
        f"both are {apart:.1e} of the size of a body apart after {FULL} steps",
    ]
    columns = ("Jacobian", "steps", "corrections per step", "time per step [ms]")
    yield Result("newton", f"Newton's method in steps of {h:g} s", columns, rows, notes)


def _full(
    system: System, scheme: Scheme, start: State, h: float, coef: Coefficients
) -> tuple[Array, float, float]:
    """Coordinates after ``FULL`` steps, corrections and time [s] per step."""
    m = start.motion
    q, v, a, lam, force, spent = m.q, m.v, m.a, m.lam, m.force, 0
    begun = perf_counter()
    for step in range(1, FULL + 1):
        q, v, a, lam, force, count = _step(system, scheme, (q, v, a, lam, force), step * h, h, coef)
        spent += count
    return q, spent / FULL, (perf_counter() - begun) / FULL


def _step(
    system: System,
    scheme: Scheme,
    motion: tuple[Array, Array, Array, Array, Array],
    t: float,
    h: float,
    coef: Coefficients,
) -> tuple[Array, Array, Array, Array, Array, int]:
    """One step of HHT-alpha in index 3. Hilber, Hughes & Taylor (1977), eqs. 11 and 12.

    motion : q, v, a, lambda, and all forces but inertia, at the start of the step
    """
    q, v, a, lam, before = motion
    n, beta, gamma, (_, alpha_f) = system.n, scheme.beta, scheme.gamma, scheme.alphas
    q_hat = q + h * v + (0.5 - beta) * h * h * a
    v_hat, a1 = v + (1.0 - gamma) * h * a, a
    y = system.unknowns(q_hat + beta * h * h * a1, lam)
    count, converged = 0, False
    while not converged and count < scheme.iterations:
        rate = np.concatenate([v_hat + gamma * h * a1, np.zeros(system.m)])
        total = system.residual(y, rate, t, coef)
        balance = system.mass @ a1 + (1.0 - alpha_f) * total[:n] + alpha_f * before
        solve = system.factorise(system.matrix(y, rate, t, coef, factors(h, scheme)))
        if solve is None:
            raise RuntimeError(f"the system matrix is singular at t = {t:g} s")
        x = solve(-np.concatenate([balance, total[n:]]))
        y = y + np.concatenate([x[:n], x[n:] / (1.0 - alpha_f)])
        a1 = (y[:n] - q_hat) / (beta * h * h)
        converged = bool(np.max(np.abs(x[:n]) / system.scale) <= scheme.newton_tolerance)
        count += 1
    v1 = v_hat + gamma * h * a1
    after = system.residual(y, np.concatenate([v1, np.zeros(system.m)]), t, coef)[:n]
    return y[:n], v1, a1, y[n:], after, count
