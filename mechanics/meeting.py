"""What meets in an impact: the mass of both sides as far as it is felt while the impact lasts.

A force on a contact moves the nodes next to it at once, what lies behind them as their elasticity
lets it: within the duration T of an impact the system gives way like M + (T/pi)^2 K, joints
included. So a beam takes part with the length that a wave passes meanwhile, and a slider together
with the mechanism behind it.

The masses are those of the reference, along the axes of the bearing. They serve to estimate how
long impacts last and what is one, and enter no force.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from mechanics.contact_laws import CLEARANCE, RADIUS, SLOT, duration, stored

Array = NDArray[np.float64]

DEPTH = 1e-4
"""Depth of the impact whose duration is estimated, in radii of the journal: about where metals
begin to yield, (1.6 pi Y/2E*)^2 (Johnson 1985, secs. 4.2 and 6.1), and elastic laws end. A
duration falls with the fourth root of the depth only [-]."""
FLAT_DEPTH = 1e-2
"""The same of corners that have no radius, in clearances, a hundredth of a radius as a rule [-]."""
LEAST = 1e-6
"""Part of the mobility of the nodes that is left where joints hold a direction [-]."""
PASSES = 2
"""Estimates of the duration, each with the masses that the one before gives."""


def mobility(system: Any, coef: tuple[Array, ...]) -> Array:
    """(n_c, 3, 3) float [1/kg]  of all contacts; that of the nodes where no more is known."""
    nodes = system.program.mobility.reshape(-1, 3, 3)
    pushes = [push for term in system.contacts for push in _pushes(term, system.n)]
    found = nodes
    for _ in range(PASSES):
        solve = _solver(system, coef, float(np.median(_durations(system, coef, found))))
        if solve is None:
            break
        found = np.array([
            node if push is None else _felt(push, solve, system.m, node)
            for node, push in zip(nodes, pushes, strict=True)
        ])  # fmt: skip
    return found


def _pushes(term: Any, n: int) -> list[Array | None]:
    """Unit forces of each contact of a term."""
    return term.pushes(n) if hasattr(term, "pushes") else [None] * len(term.contact_names)


def _durations(system: Any, coef: tuple[Array, ...], found: Array) -> Array:
    """(n_c,) float [s]  of an impact of each contact in the direction that gives way most."""
    flat = np.concatenate([c.ravel() for c in coef])
    rows = (flat[start : start + SLOT] for start in system.program.contact_at)
    masses = 1.0 / np.linalg.eigvalsh(found)[:, -1]
    return np.array([_duration(m, row) for m, row in zip(masses, rows, strict=True)])


def _duration(mass: float, row: Array) -> float:
    """Of an elastic impact as deep as ``DEPTH`` says [s]: the same in all units."""
    depth = DEPTH * row[RADIUS] or FLAT_DEPTH * abs(row[CLEARANCE])
    speed = np.sqrt(2.0 * stored(depth, row) / mass)
    return float(duration(mass, speed, row))


def _solver(system: Any, coef: tuple[Array, ...], T: float) -> Any:
    """Solver of M + (T/pi)^2 K in the reference; None where it is singular."""
    y = system.unknowns(system.layout.q0)
    data = system.matrix(y, np.zeros_like(y), 0.0, coef, (1.0, (T / np.pi) ** 2, 0.0))
    return system.factorise(data)


def _felt(push: Array, solve: Any, m: int, node: Array) -> Array:
    """(3, 3) float [1/kg]  in the directions of ``push`` (k, n); that of the nodes in others."""
    answers = np.array([solve(np.append(one, np.zeros(m)))[: one.size] for one in push])
    found, k = node.copy(), len(push)
    found[:k, :k] = push @ answers.T
    found = 0.5 * (found + found.T) + LEAST * np.trace(node) * np.eye(3)
    return found if np.all(np.linalg.eigvalsh(found) > 0.0) else node
