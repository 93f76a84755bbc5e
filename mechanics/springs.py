"""Springs, dampers and actuators between points, on hinges, along ropes; bushings.

Every one is an energy with a damping power. What an actuator or a motor does is external work
and not energy of the spring beside it: they are terms of their own.
"""

from collections.abc import Sequence
from importlib import import_module
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mechanics import spring_kernels as kernels
from mechanics.description import Bushing, History, Pulley, Site, Spring, TorsionSpring
from mechanics.layout import TURN, Layout, Side

Array = NDArray[np.float64]
Item = Spring | TorsionSpring | Bushing | Pulley
Signal = tuple[int, int, History]

COINCIDENT = 1e-9
"""Distance of two points, over the size of a body, below which a spring has no direction [-]."""
RATE_STEP = 1e-6
"""Step [s] of the differences that give the speed of a winch."""


class Lines:
    """Springs between two points, or ropes over several.

    Attributes
    ----------
    names : name of each spring
    dofs : (n_e, 3 P W) intp  coordinates of W vectors of each of P points
    ints, floats : see ``spring_kernels``
    external : bool  actuators: what they do is work of a load
    """

    force, tangent = kernels.add_force, kernels.add_tangent
    columns = 2

    def __init__(
        self,
        name: str,
        names: list[str],
        paths: Sequence[Sequence[Side]],
        laws: Sequence[Sequence[float]],
        signals: list[Signal],
        external: bool = False,
    ):
        self.name, self.names, self.signals, self.external = name, names, signals, external
        self.symmetric = True
        self.energy = 0 if external else kernels.add_energy
        kind = kernels.ROPE if name == "ropes" else kernels.SPRING
        points = max(len(path) for path in paths)
        width = max(1, *(side.vectors.size for path in paths for side in path))
        self.ints = np.full((len(paths), 2 + points * width), -1, dtype=np.int64)
        self.floats = np.zeros((len(paths), kernels.LAW + points * (3 + width)))
        self.floats[:, : kernels.LAW] = laws
        for e, path in enumerate(paths):
            self.ints[e, :2] = kind, len(path)
            for p, side in enumerate(path):
                self._place(e, p, side, points, width)
        first = self.ints[:, 2:, None]
        dofs = np.where(first < 0, -1, first + np.arange(3))
        self.dofs = dofs.reshape(len(paths), -1).astype(np.intp)

    def _place(self, e: int, p: int, side: Side, points: int, width: int) -> None:
        """Write point p of line e into ``ints`` and ``floats``."""
        k, constant = side.vectors.size, kernels.LAW + 3 * p
        self.ints[e, 2 + p * width : 2 + p * width + k] = side.vectors
        weights = kernels.LAW + 3 * points + p * width
        self.floats[e, weights : weights + k] = side.weights[0]
        if side.fixed:
            self.floats[e, constant : constant + 3] = side.position

    def coefficients(self, T: Array) -> Array:
        """(n_e, 2) force of actuators [N], or rope paid out [m] and its rate: signals."""
        return np.zeros((len(self.names), 2))

    def with_rates(self, c0: Array, c1: Array, h: float) -> tuple[Array, Array]:
        """As they are."""
        return c0, c1

    def mass_blocks(self) -> None:
        """Springs have no mass."""


class Turns:
    """Springs, dampers and motors on the turns of hinges.

    Attributes
    ----------
    dofs : (n_e, 1) intp  the turn
    floats : (n_e, 4)  stiffness [N m/rad], damping [N m s/rad], angle free of moment [rad],
        preload [N m]
    """

    force, tangent = kernels.add_turning_force, kernels.add_turning_tangent
    columns = 1

    def __init__(
        self,
        name: str,
        springs: Sequence[TorsionSpring],
        laws: Sequence[Sequence[float]],
        layout: Layout,
        signals: list[Signal],
        external: bool = False,
    ):
        self.name, self.signals, self.external, self.symmetric = name, signals, external, True
        self.energy = 0 if external else kernels.add_turning_energy
        self.names = [spring.name for spring in springs]
        self.dofs = np.array([[_turn(spring, layout)] for spring in springs], dtype=np.intp)
        self.ints = self.dofs.astype(np.int64)
        self.floats = np.array(laws, dtype=float)

    def coefficients(self, T: Array) -> Array:
        """(n_e, 1) moment of motors [N m], a signal."""
        return np.zeros((len(self.names), 1))

    def with_rates(self, c0: Array, c1: Array, h: float) -> tuple[Array, Array]:
        """As they are."""
        return c0, c1

    def mass_blocks(self) -> None:
        """Springs have no mass."""


Term = Any  # Lines, Turns, or mechanics.bushing.Bushings


def build(items: Sequence[Item], layout: Layout, first_row: int) -> list[Term]:
    """Terms of all springs, ropes with a stiffness, bushings, and their actuators.

    Parameters
    ----------
    first_row : index of the first free multiplier; springs take none

    Raises
    ------
    ValueError : a spring that cannot be made, with its name
    """
    terms: list[Term] = []
    if springs := [item for item in items if isinstance(item, Spring)]:
        terms += _springs(springs, layout)
    if turns := [item for item in items if isinstance(item, TorsionSpring)]:
        terms += _turns(turns, layout)
    if ropes := [item for item in items if isinstance(item, Pulley)]:
        terms.append(_ropes(ropes, layout))
    if bushings := [item for item in items if isinstance(item, Bushing)]:
        terms.append(import_module("mechanics.bushing").build(bushings, layout))
    return terms


def _springs(springs: Sequence[Spring], layout: Layout) -> list[Lines]:
    paths = [_path(spring, (spring.a, spring.b), layout) for spring in springs]
    reference = [_length(path) for path in paths]
    passive = [
        _spring_law(spring, length) for spring, length in zip(springs, reference, strict=True)
    ]
    terms = [Lines("springs", [s.name for s in springs], paths, passive, [])]
    driven = [(i, spring.force) for i, spring in enumerate(springs) if spring.force is not None]
    if driven:
        names = [springs[i].name for i, _ in driven]
        signals = [(row, 0, force) for row, (_, force) in enumerate(driven)]
        nothing = [[0.0, 0.0, 0.0, 0.0, reference[i]] for i, _ in driven]
        terms.append(
            Lines("actuators", names, [paths[i] for i, _ in driven], nothing, signals, True)
        )
    return terms


def _spring_law(spring: Spring, reference: float) -> list[float]:
    free = reference if spring.length is None else spring.length
    _positive(spring, spring.stiffness, spring.damping)
    return [spring.stiffness, spring.damping, free, spring.preload, reference]


def _turns(springs: Sequence[TorsionSpring], layout: Layout) -> list[Turns]:
    for spring in springs:
        _positive(spring, spring.stiffness, spring.damping)
    laws = [[s.stiffness, s.damping, s.angle, s.preload] for s in springs]
    terms = [Turns("torsion springs", springs, laws, layout, [])]
    motors = [(spring, spring.torque) for spring in springs if spring.torque is not None]
    if motors:
        signals = [(i, 0, torque) for i, (_, torque) in enumerate(motors)]
        nothing = [[0.0] * 4 for _ in motors]
        terms.append(Turns("motors", [s for s, _ in motors], nothing, layout, signals, True))
    return terms


def _turn(spring: TorsionSpring, layout: Layout) -> int:
    name = f"{spring.joint}.{TURN}"
    if name not in layout.joint_dofs:
        raise ValueError(f"spring {spring.name!r}: there is no joint {spring.joint!r} that turns")
    return layout.joint_dofs[name]


def _ropes(pulleys: Sequence[Pulley], layout: Layout) -> Lines:
    paths = [_path(pulley, pulley.points, layout) for pulley in pulleys]
    laws: list[list[float]] = []
    signals: list[Signal] = []
    for e, (pulley, path) in enumerate(zip(pulleys, paths, strict=True)):
        reference = _length(path)
        free = reference if pulley.length is None else pulley.length
        _positive(pulley, pulley.stiffness or 0.0, pulley.damping)
        if free <= 0.0:
            raise ValueError(f"rope {pulley.name!r}: its length must be positive")
        laws.append([pulley.stiffness or 0.0, pulley.damping, free, 0.0, reference])
        if pulley.winch is not None:
            signals += [(e, 0, pulley.winch), (e, 1, _rate(pulley.winch))]
    return Lines("ropes", [pulley.name for pulley in pulleys], paths, laws, signals)


def _path(item: Item, points: Sequence[Site], layout: Layout) -> list[Side]:
    """Ends of a line; no two neighbours coincide."""
    sides = [layout.site(site) for site in points]
    if len(sides) < 2:
        raise ValueError(f"spring {item.name!r}: it needs two points")
    if all(side.fixed for side in sides):
        raise ValueError(f"spring {item.name!r}: all its points are on the ground")
    for a, b in pairwise(sides):
        distance = float(np.linalg.norm(a.position - b.position))
        if distance <= COINCIDENT * max(a.size, b.size):
            raise ValueError(
                f"spring {item.name!r}: its points on {a.name!r} and {b.name!r} coincide, "
                "so that it has no direction"
            )
    return sides


def _length(path: Sequence[Side]) -> float:
    points = np.array([side.position for side in path])
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())


def _positive(item: Item, *values: float) -> None:
    if not all(np.isfinite(value) and value >= 0.0 for value in values):
        raise ValueError(f"spring {item.name!r}: stiffness and damping must not be negative")


def _rate(history: History) -> History:
    """Central difference of a function of time."""

    def rate(t: float) -> float:
        return (history(t + RATE_STEP) - history(t - RATE_STEP)) / (2.0 * RATE_STEP)

    return rate
