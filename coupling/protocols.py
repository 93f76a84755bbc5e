"""The two contracts that the coupling manager knows."""

from collections.abc import Callable, Mapping
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Indices = NDArray[np.intp]


class ThermalSolver(Protocol):
    """Transient heat; the state is the vector of temperatures and nothing else."""

    x: Array
    """(n, 3) [m] reference positions of the temperatures."""
    regions: Mapping[str, Indices]
    """Which temperatures belong to which body or part."""

    def initial(self) -> Array:
        """(n,) [K]"""
        ...

    def advance(
        self,
        T: Array,
        t: float,
        h: float,
        heat: Array,
        outside: Mapping[str, tuple[Array, Array]] = ...,
    ) -> tuple[Array, Mapping[str, float], str]:
        """Temperatures at ``t + h``, heat [J] that entered through each named boundary, reason.

        ``heat`` (n,) [J] is deposited evenly over the interval. ``outside`` holds what time and
        motion decide, by the name of condition or link, at the start and the end of the interval:
        irradiation (m,) [W/m^2] at the points of a face, conductance (1,) [W/K]. The sum of the
        flows and of ``heat`` equals the change of ``energy`` to round-off. The reason is "" when
        all went well, and then only may the result be used.
        """
        ...

    def steady(
        self, T: Array, t: float, outside: Mapping[str, Array] | None = None
    ) -> tuple[Array, Mapping[str, float], str]:
        """Temperatures that the conditions of ``t`` hold, power [W] through each, reason.

        ``T`` (n,) [K] is a first guess, and tells the heat of what exchanges none.
        """
        ...

    def energy(self, T: Array) -> float:
        """Stored heat [J]."""
        ...


class MechanicalSolver(Protocol):
    """Motion; its state is a record of arrays."""

    x: Array
    """(m, 3) [m] reference positions of the points that carry a temperature."""
    axes: Array
    """(m, 3, 3) rows e1, e2, e3 of the section; zeros where a point has no section."""
    regions: Mapping[str, Indices]
    """Which points belong to which body or part."""

    def initial(self, T: Array, rest: Array | None = None) -> Any:
        """State at t = 0 for section temperatures ``T`` (m, 3): mean [K], two gradients [K/m].

        With temperatures ``rest``, of the reference, in equilibrium under ``T``.
        """
        ...

    def advance(
        self,
        state: Any,
        h: float,
        T0: Array,
        T1: Array,
        observe: Callable[[Any], None] | None = None,
    ) -> tuple[Any, Array, str]:
        """State after ``h``, heat (m,) [J] that friction released at each point, reason.

        Substeps are the solver's own; section temperatures vary linearly from ``T0`` to ``T1``.
        ``observe`` is called now and then with what was kept of the accepted substeps: times,
        responses of the clearance joints, and more (``mechanics.march.Rows``).
        """
        ...
