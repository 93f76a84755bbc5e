"""Flexible multibody dynamics behind the contract of a mechanical solver."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from mechanics.description import Description
from mechanics.dynamics import Control, State, Window, advance, initial_state
from mechanics.system import Coefficients, System

Array = NDArray[np.float64]

START = 1e-9
"""Sine of the angle at t = 0 above which a drive jumps [-]."""


class Mechanics:
    """ANCF bodies, joints and clearances, advanced by HHT-alpha.

    ValueError with one line for each joint that cannot be.

    Attributes
    ----------
    x : (m, 3) float [m]  reference positions of the points that carry a temperature
    axes : (m, 3, 3) float  their section triads; zeros where there is no section
    regions : mapping  body name, ``<joint>.journal``, ``<joint>.bearing`` to rows of ``x``
    """

    def __init__(self, description: Description, control: Control):
        self.system = System(description)
        refused = _refused(self.system)
        if refused:
            raise ValueError("\n".join(refused))
        self.control = control
        self.x = self.system.layout.x
        self.axes = self.system.layout.axes
        self.regions = self.system.layout.point_index

    def initial(self, T: Array) -> State:
        """State at t = 0; ValueError if the joints allow none."""
        state, why = initial_state(self.system, self.control, self.system.coefficients(T))
        if state is None:
            raise ValueError(why)
        return state

    def advance(
        self,
        state: State,
        h: float,
        T0: Array,
        T1: Array,
        observe: Callable[[State, Array], None] | None = None,
    ) -> tuple[State, Array, str]:
        """State after ``h``, frictional heat (m,) [J] at each point, "" or the reason.

        Section temperatures (m, 3) [K, K/m, K/m] go linearly from ``T0`` to ``T1``.
        """
        c0 = self.system.coefficients(T0)
        c1 = None if np.array_equal(T0, T1) else self.system.coefficients(T1)
        window = Window.between(self.system, state.motion.t, h, c0, c1)
        new, lost, why = advance(self.system, self.control, state, window, observe)
        return new, self._heat(lost, T0), why

    def _heat(self, lost: Array, T: Array) -> Array:
        """Share the frictional work of each joint between its journal and its bearing."""
        heat = np.zeros(len(self.x))
        contact = self.system.contact
        if contact is not None:
            np.add.at(heat, contact.points, contact.partition(T) * lost[:, 1:2])
        return heat

    def coefficients(self, T: Array) -> Coefficients:
        """Coefficient arrays of all terms at section temperatures ``T`` (m, 3)."""
        return self.system.coefficients(T)


def _refused(system: System) -> list[str]:
    """What is wrong with joints, one sentence for each."""
    text = "it holds something that joints before it hold already"
    found = [f"joint {name!r}: {text}" for name in system.repeated_joints()]
    start = system.constraints.values(system.layout.q0, 0.0)
    names = np.array(system.constraints.names, dtype=object)[np.abs(start) > START]
    text = "its angle must be zero at t = 0: angles count from the reference"
    return found + [f"joint {name!r}: {text}" for name in dict.fromkeys(names)]
