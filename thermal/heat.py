"""Transient and steady heat on a discretisation in space: ``Heat``."""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from thermal import integration, steady
from thermal.boundary import Boundary, Moment
from thermal.description import DEFAULT, Description, Settings
from thermal.discretisation import Discretisation, Face
from thermal.layout import given_nodes
from thermal.limits import Limits, watched
from thermal.linear import Linear, Recalling, linear_solver
from thermal.stages import System

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
Outside = Mapping[str, tuple[Array, Array]]
"""What comes from outside by name, at the start and at the end of an interval; linear between."""

NOTHING: Outside = {}

Integrate = Callable[[System, Array, float, float, Array, Settings], integration.Interval]
"""From T at t over h under a source [W]; see ``thermal.integration.integrate``."""


class Heat:
    """The state is the vector of temperatures.

    Attributes
    ----------
    x : (n, 3) float [m]  reference positions
    regions : name -> its temperatures
    irradiated : condition -> Face, at whose points it takes irradiation from outside
    settings : Settings
    taken : int  steps of the last interval
    error : float [K]  sum of their estimated local errors; nan where none were estimated
    """

    def __init__(
        self,
        space: Discretisation,
        description: Description,
        settings: Settings = DEFAULT,
        integrate: Integrate = integration.integrate,
    ) -> None:
        self.space, self.settings, self._integrate = space, settings, integrate
        self.x, self.regions = space.x, space.regions
        self._given = list(space.given)
        self._given_nodes = given_nodes(self._given)
        self.free = np.setdiff1d(np.arange(len(self.x)), self._given_nodes)
        self._boundary = Boundary(description, space)
        self._limits = Limits(description)
        self._watched = watched(description, space)
        self.irradiated: Mapping[str, Face] = self._boundary.irradiated
        rows, columns = zip(space.entries(), self._boundary.entries(), strict=True)
        self.linear: Linear = linear_solver(
            settings.linear, len(self.x), self.free, np.concatenate(rows), np.concatenate(columns)
        )
        self._temperatures = [nodes for nodes in self.regions.values() if len(nodes)]
        self.kept: dict[float, Any] = {}
        self.taken, self.error = 0, 0.0

    def initial(self) -> Array:
        """(n,) [K]"""
        return self.space.start.copy()

    def energy(self, T: Array) -> float:
        """Stored heat [J] above the materials' datum of enthalpy."""
        return float(self.space.heat(T).sum())

    def advance(
        self, T: Array, t: float, h: float, heat: Array, outside: Outside = NOTHING
    ) -> tuple[Array, Mapping[str, float], str]:
        """Temperatures at ``t + h``, heat [J] through each boundary, reason; see ThermalSolver."""
        system = _Within(self, t, h, outside)
        end = self._integrate(system, T, t, h, heat / h, self.settings)
        self.taken, self.error = end.steps, end.error
        flows = {g.name: float(end.reactions[g.nodes].sum()) for g in self._given}
        flows.update(zip(self._boundary.names, end.flows.tolist(), strict=True))
        return end.T, flows, end.why

    def steady(
        self, T: Array, t: float, outside: Mapping[str, Array] | None = None
    ) -> tuple[Array, Mapping[str, float], str]:
        """Steady temperatures under the conditions of ``t``, power [W] through each, reason.

        T : (n,) float [K]  first guess
        outside : what comes from outside, at that time
        """
        still = {name: (value, value) for name, value in (outside or {}).items()}
        T, flows, why = steady.settle(_Within(self, t, 1.0, still), T, t)
        return T, dict(zip(self._boundary.names, flows.tolist(), strict=True)), why

    def given_at(self, t: float) -> tuple[Indices, Array]:
        """Prescribed temperatures: which, and their values [K]."""
        return self._given_nodes, np.concatenate([np.empty(0), *(g.at(t) for g in self._given)])

    def power(self, T: Array, at: Moment) -> tuple[Array, Array]:
        """(n,) [W] received by each temperature, and (m,) [W] of it through each boundary."""
        out, flows = self._boundary.power(T, at)
        return out + self.space.power(T), flows

    def factorise(self, T: Array, at: Moment, tau: float) -> Callable[[Array], Array]:
        """Solver of (dE/dT - tau dF/dT) x = r among the free temperatures."""
        own = self.space.tangent(T, tau)
        return self.linear.factorise(np.concatenate([own, tau * self._boundary.slopes(T, at)]))

    def memory(self) -> Mapping[str, Any]:
        """What later intervals depend on beside the temperatures; {} where that is nothing.

        Solvers that end before round-off go on with tangents and multigrid of earlier intervals.
        """
        if not isinstance(self.linear, Recalling):
            return {}
        kept = {str(tau): solve.data for tau, solve in self.kept.items()}
        return {"kept": kept, "linear": self.linear.memory()}

    def remember(self, memory: Mapping[str, Any]) -> None:
        """Become as the solver was that told its ``memory``."""
        if memory and isinstance(self.linear, Recalling):
            self.linear.remember(memory["linear"])
            kept = {float(tau): data for tau, data in memory["kept"].items()}
            self.kept = {tau: self.linear.prepared(data) for tau, data in kept.items()}

    def senseless(self, t: float) -> str:
        """What the conditions ask for at ``t`` that cannot be, or ""."""
        return self._limits.complaint(t)

    def unusable(self, T: Array, t: float) -> str:
        """Why temperatures cannot be accepted at ``t``, or ""."""
        coldest = min(self._temperatures, key=lambda nodes: T[nodes].min(), default=None)
        if coldest is not None and T[coldest].min() < 0.0:
            return f"{self.owner(int(coldest[0]))} fell below 0 K"
        complaints = (w.complaint(T, t) for w in self._watched)
        return self.space.unusable(T) or next(filter(None, complaints), "")

    def owner(self, node: int) -> str:
        """What a temperature belongs to."""
        return next((f"'{name}'" for name, nodes in self.regions.items() if node in nodes), "it")


class _Within(NamedTuple):
    """The heat of an interval: what comes from outside goes linearly from start to end."""

    solver: Heat
    t: float
    h: float
    outside: Outside

    @property
    def free(self) -> Indices:
        return self.solver.free

    @property
    def accuracy(self) -> float:
        return self.solver.linear.accuracy

    @property
    def refresh(self) -> float:
        return self.solver.linear.refresh

    @property
    def kept(self) -> dict[float, Callable[[Array], Array]]:
        return self.solver.kept

    @property
    def trouble(self) -> str:
        return self.solver.linear.trouble

    def given_at(self, t: float) -> tuple[Indices, Array]:
        return self.solver.given_at(t)

    def heat(self, T: Array) -> Array:
        return self.solver.space.heat(T)

    def power(self, T: Array, t: float) -> tuple[Array, Array]:
        return self.solver.power(T, self._at(t))

    def factorise(self, T: Array, t: float, tau: float) -> Callable[[Array], Array]:
        return self.solver.factorise(T, self._at(t), tau)

    def senseless(self, t: float) -> str:
        return self.solver.senseless(t)

    def unusable(self, T: Array, t: float) -> str:
        return self.solver.unusable(T, t)

    def owner(self, node: int) -> str:
        return self.solver.owner(node)

    def _at(self, t: float) -> Moment:
        s = min(1.0, max(0.0, (t - self.t) / self.h))
        now = {name: (1.0 - s) * a + s * b for name, (a, b) in self.outside.items()}
        return Moment(t, now)
