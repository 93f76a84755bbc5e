"""One stage of a conservative one-step scheme: E(T) = base + tau F(T, t), some T given.

The schemes are applied to the stored heat E, so that what flows in over a step is what is stored
at its end, to round-off, whatever the material. Where temperatures are given, the rest of the
balance of their rows is the heat that holds them there.
"""

from collections.abc import Callable
from math import inf, isfinite
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
Solve = Callable[[Array], Array]

ITERATIONS = 20
ROUND_OFF = 3e-16  # change of temperature, relative, at which Newton's method has ended
FLOOR = 1e-10  # below it a change that no longer shrinks is round-off too
ASTRAY = 0.3  # contraction from which a tangent of an earlier stage has led nowhere
LASTING = 0.015  # contraction up to which a tangent serves the next stage too
BALANCE = 2e-9  # of the heat exchanged, that may be missing where Newton ends before round-off


class System(Protocol):
    """What is integrated."""

    @property
    def free(self) -> Indices:
        """Temperatures to solve for; all others are given."""
        ...

    @property
    def accuracy(self) -> float:
        """Relative error of temperature that may be left; 0: Newton ends at round-off."""
        ...

    @property
    def refresh(self) -> float:
        """A slower contraction of Newton's method asks for a new tangent."""
        ...

    @property
    def kept(self) -> dict[float, Solve]:
        """Solvers of an earlier stage by tau, where stages need not end at round-off."""
        ...

    @property
    def trouble(self) -> str:
        """Why the last linear system has no solution, of which x = nan; or ""."""
        ...

    def given_at(self, t: float) -> tuple[Indices, Array]:
        """Given temperatures: which and their values [K]."""
        ...

    def heat(self, T: Array) -> Array:
        """(n,) [J] stored."""
        ...

    def power(self, T: Array, t: float) -> tuple[Array, Array]:
        """(n,) [W] received, and (m,) [W] of it through each boundary."""
        ...

    def factorise(self, T: Array, t: float, tau: float) -> Solve:
        """Solver of (dE/dT - tau dF/dT) x = r among the free temperatures."""
        ...

    def senseless(self, t: float) -> str:
        """What the conditions ask for at ``t`` that cannot be, or ""."""
        ...

    def unusable(self, T: Array, t: float) -> str:
        """Why temperatures cannot be accepted, or ""."""
        ...

    def owner(self, node: int) -> str:
        """What a temperature belongs to, in words."""
        ...


class Point(NamedTuple):
    """Temperatures [K], heat stored [J], power received [W], and through boundaries [W]."""

    T: Array
    heat: Array
    power: Array
    flows: Array


class Stage(NamedTuple):
    """Its end, the solver of its tangent, and why there is none."""

    point: Point
    solve: Solve | None
    why: str


class Step(NamedTuple):
    """A step of a scheme.

    flows, reactions : float [J]  through each boundary; that held the given temperatures
    error : float [K]  estimated; 0 where none was asked for
    """

    end: Point
    flows: Array
    reactions: Array
    error: float
    why: str


def failed(start: Point, why: str) -> Step:
    """A step that did not come about."""
    return Step(start, np.zeros(0), np.zeros(0), inf, why)


def balance(system: System, end: Point, given: Array) -> Array:
    """(n,) [J]  what the given temperatures took in beyond what was ``given`` to them."""
    reactions = end.heat - given
    reactions[system.free] = 0.0
    return reactions


def damped(solve: Solve, system: System, defect: Array) -> float:
    """Largest error [K] of a defect [J], damped by the tangent as Hosea & Shampine (1996) do."""
    error = float(np.abs(solve(defect[system.free])).max(initial=0.0))
    return error if isfinite(error) else inf


def stage(
    system: System,
    guess: Array,
    base: Array,
    t: float,
    tau: float,
    source: Array,
    solve: Solve | None,
) -> Stage:
    """Solve E(T) = base + tau F(T, t) by Newton's method; the tangent is kept while it serves."""
    T = first = _imposed(system, guess, t)
    solve = solve or system.kept.get(tau)
    previous, contraction, worst, left = inf, 0.0, 0, inf
    for _ in range(ITERATIONS):
        point = evaluate(system, T, t, source)
        defect = point.heat - base - tau * point.power
        residual = defect[system.free]
        sound = bool(np.isfinite(residual).all())
        astray = solve is not None and not (sound and contraction <= ASTRAY)
        if astray and solve is system.kept.pop(tau, None):  # conditions have changed since
            T, solve, previous, contraction, left = first, None, inf, 0.0, inf
            continue
        if not sound:
            break
        if left <= system.accuracy and _balanced(point, defect, residual, tau, source):
            _keep(system, tau, solve, contraction)
            return Stage(point, solve, fault(system, point, t))
        if solve is None or contraction > system.refresh:
            solve = system.factorise(T, t, tau)
        change = solve(residual)
        size = float(np.abs(change).max(initial=0.0) / max(1.0, np.abs(T).max()))
        if size <= ROUND_OFF or 0.1 * previous < size <= FLOOR:
            return Stage(point, solve, fault(system, point, t))
        worst = int(np.abs(change).argmax())
        T = T.copy()
        T[system.free] -= change
        contraction, previous = size / previous, size
        left = size * (contraction or 1.0)
    owner = system.owner(int(system.free[worst])) if len(system.free) else "a boundary"
    did_not = f"the heat balance of {owner} did not converge"
    why = system.senseless(t) or system.trouble or did_not
    return Stage(point, None, f"t = {t:g} s: {why}")


def _keep(system: System, tau: float, solve: Solve | None, contraction: float) -> None:
    """For the next stage, if the tangent has served well."""
    system.kept.clear()
    if solve is not None and contraction <= LASTING:
        system.kept[tau] = solve


def _balanced(point: Point, defect: Array, residual: Array, tau: float, source: Array) -> bool:
    """Whether the heat of all temperatures together is in balance with what is exchanged."""
    held = np.abs(defect).sum() - np.abs(residual).sum()
    exchanged = held + tau * (np.abs(point.flows).sum() + np.abs(source).sum())
    allowed = BALANCE * exchanged + ROUND_OFF * np.abs(point.heat).sum()
    return bool(abs(residual.sum()) <= allowed)


def start(system: System, T: Array, t: float, source: Array) -> Point:
    """The heat stored in ``T``, but powers with the given temperatures of ``t`` in their place."""
    imposed = _imposed(system, T, t)
    power, flows = system.power(imposed, t)
    return Point(imposed, system.heat(T), power + source, flows)


def _imposed(system: System, T: Array, t: float) -> Array:
    T = T.copy()
    nodes, values = system.given_at(t)
    T[nodes] = values
    return T


def evaluate(system: System, T: Array, t: float, source: Array) -> Point:
    power, flows = system.power(T, t)
    return Point(T, system.heat(T), power + source, flows)


def fault(system: System, point: Point, t: float) -> str:
    """Why a point cannot be accepted, or ""."""
    why = system.senseless(t)
    if not why and not isfinite(float(point.T.sum() + point.power.sum())):
        why = "a temperature or a power is not a number"
    why = why or system.unusable(point.T, t)
    return f"t = {t:g} s: {why}" if why else ""
