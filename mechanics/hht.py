"""One step of HHT-alpha for index-3 systems, with a frozen Jacobian.

Hilber, Hughes & Taylor (1977); for constrained systems Negrut, Rampalli, Ottarsson & Sajdak
(2007), eqs. 8-13. Constraints are enforced at positions in every step; the unknowns are the
increment of the coordinates and of the multipliers scaled by beta h^2 (1 + alpha), which
keeps the condition of the matrix independent of h (Bottasso, Bauchau & Cardona 2007).
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mechanics.factor import Solve
from mechanics.system import Coefficients, Factors, System

Array = NDArray[np.float64]

REFRESH = 0.5
"""A contraction of the Newton corrections above this calls for a new Jacobian [-]."""
ACCELERATION = 1e-4
"""Part of the accelerations that may remain uncorrected: since a correction of q divided by
beta h^2 is one of a, this keeps forces and multipliers converged when steps are short [-]."""
ROUND_OFF = 8.0 * np.finfo(float).eps
"""Corrections below this part of the coordinates mean nothing [-]."""
FROZEN = 0.35
"""A Jacobian serves step sizes within this fraction of its own [-]."""


@dataclass(frozen=True)
class Scheme:
    """Parameters of HHT-alpha and of its Newton iteration.

    alpha : float  in [-1/3, 0]; rho_inf = (1 + alpha)/(1 - alpha)
    newton_tolerance : float  largest remaining correction, relative to ``System.scale``
    iterations : int  largest number of corrections with one Jacobian
    """

    alpha: float = -0.1
    newton_tolerance: float = 1e-12
    iterations: int = 12

    @property
    def beta(self) -> float:
        return (1.0 - self.alpha) ** 2 / 4.0

    @property
    def gamma(self) -> float:
        return (1.0 - 2.0 * self.alpha) / 2.0


class Motion(NamedTuple):
    """Where the system is.

    t : float [s]
    q, v, a : (n,) float  coordinates, velocities, accelerations
    lam : (m,) float  multipliers of the constraints
    force : (n,) float  all forces but inertia, constraints included, at ``t``
    force_before : (n,) float  the same, one step before
    approach : (n_j,) float [m/s]  approach speed of the impact that runs in each clearance
        joint; 0 where there is none
    """

    t: float
    q: Array
    v: Array
    a: Array
    lam: Array
    force: Array
    force_before: Array
    approach: Array


class Jacobian(NamedTuple):
    """A factorised system matrix, the step size and the contacts that it was made for."""

    solve: Solve
    h: float
    touching: bytes


class Step(NamedTuple):
    """Outcome of one step: the new motion, or the reason that there is none."""

    motion: Motion | None
    jacobian: Jacobian | None
    iterations: int
    why: str = ""


class _Trial(NamedTuple):
    """What stays the same through the Newton iteration of one step."""

    start: Motion
    h: float
    coef: Coefficients
    touching: bytes


def step(
    system: System,
    scheme: Scheme,
    start: Motion,
    h: float,
    coef: Coefficients,
    jacobian: Jacobian | None,
    touching: bytes,
) -> Step:
    """Advance by ``h`` with the coefficients of the end of the step.

    Parameters
    ----------
    jacobian : of an earlier step, used again while it contracts
    touching : one byte for each clearance joint; a change calls for a new Jacobian

    Returns
    -------
    Step  with ``motion`` None and a reason if the Newton iteration did not converge
    """
    trial = _Trial(start, h, coef, touching)
    fresh = jacobian is None or not _serves(jacobian, h, touching)
    spent = 0
    for _ in range(2):
        if fresh:
            jacobian = _jacobian(system, scheme, trial)
        if jacobian is None:
            return Step(None, None, spent, "the system matrix is singular")
        motion, count, why = _newton(system, scheme, trial, jacobian)
        spent += count
        if motion is not None or fresh:
            return Step(motion, jacobian, spent, why)
        fresh = True
    return Step(None, jacobian, spent, why)


def _serves(jacobian: Jacobian, h: float, touching: bytes) -> bool:
    return abs(h / jacobian.h - 1.0) <= FROZEN and jacobian.touching == touching


def _predict(scheme: Scheme, trial: _Trial) -> tuple[Array, Array]:
    """Newmark coordinates and velocities for zero acceleration at the end."""
    s, h = trial.start, trial.h
    q = s.q + h * s.v + h * h * (0.5 - scheme.beta) * s.a
    return q, s.v + h * (1.0 - scheme.gamma) * s.a


def _jacobian(system: System, scheme: Scheme, trial: _Trial) -> Jacobian | None:
    """Factorised at the predicted configuration."""
    s, h = trial.start, trial.h
    q0, v0 = _predict(scheme, trial)
    q = q0 + scheme.beta * h * h * s.a
    v = v0 + scheme.gamma * h * s.a
    weight = 1.0 + scheme.alpha
    factors = Factors(1.0, weight * scheme.beta * h * h, weight * scheme.gamma * h)
    data = system.matrix(q, v, s.t + h, s.lam, trial.coef, s.approach, factors)
    solve = system.factorise(data)
    return None if solve is None else Jacobian(solve, h, trial.touching)


def _newton(
    system: System, scheme: Scheme, trial: _Trial, jacobian: Jacobian
) -> tuple[Motion | None, int, str]:
    """Correct until the estimated remaining correction is below the tolerance."""
    s, h, n = trial.start, trial.h, system.n
    t, weight = s.t + h, 1.0 + scheme.alpha
    q0, v0 = _predict(scheme, trial)
    bh2 = scheme.beta * h * h
    a, lam = s.a.copy(), s.lam.copy()
    before, contraction, worst = np.inf, 0.0, 0
    tolerance, floor = scheme.newton_tolerance, ROUND_OFF * np.max(np.abs(s.q) / system.scale)
    for count in range(scheme.iterations + 1):
        q = q0 + bh2 * a
        v = v0 + scheme.gamma * h * a
        total = system.force(q, v, t, trial.coef, s.approach)
        phi = system.constraints.add_force(q, t, lam, total)
        if count and contraction * before <= tolerance:
            return Motion(t, q, v, a, lam, total, s.force, s.approach), count, ""
        residual = system.mass @ a + weight * total - scheme.alpha * s.force
        x = jacobian.solve(-np.concatenate([bh2 * residual, phi]))
        sizes = np.abs(x[:n]) / system.scale
        worst = int(np.argmax(sizes))
        size = sizes[worst]
        contraction = size / before if count else 1.0
        if not np.isfinite(size) or (count and contraction > REFRESH and size > tolerance):
            break
        moved = bh2 * np.max(np.abs(a) / system.scale)
        tolerance = max(floor, min(scheme.newton_tolerance, ACCELERATION * moved))
        a = a + x[:n] / bh2
        lam = lam + x[n:] / (weight * bh2)
        before = size
    why = f"Newton did not converge at {system.name_of(worst)}"
    return None, count + 1, why
