"""Flexible multibody dynamics behind the contract of a mechanical solver."""

import numpy as np
from numpy.typing import NDArray

from mechanics.check import check
from mechanics.description import Description
from mechanics.dynamics import Control, Observe, State, Window, advance, initial_state
from mechanics.redundancy import repetitions
from mechanics.system import Coefficients, System

Array = NDArray[np.float64]

START = 1e-9
"""Violation of a constraint at t = 0 above which a drive jumps, relative to what a displacement by
the size of the bodies would make it [-]."""


class Mechanics:
    """Flexible and rigid bodies, joints, springs and clearances, advanced in time.

    ValueError with one line for each thing that cannot be.

    Attributes
    ----------
    x : (m, 3) float [m]  reference positions of the points that carry a temperature
    axes : (m, 3, 3) float  their section triads; zeros where there is no section
    regions : mapping  body name, ``<joint>.journal``, ``<joint>.bearing`` to rows of ``x``
    """

    def __init__(self, description: Description, control: Control, solver: str = "auto"):
        problems = check(description)
        if problems:
            raise ValueError("\n".join(problems))
        self.system = System(description, solver)
        problems = _refused(self.system, [joint.name for joint in description.joints])
        if problems:
            raise ValueError("\n".join(problems))
        self.control = control
        self.x = self.system.layout.x
        self.axes = self.system.layout.axes
        self.regions = self.system.layout.point_index

    def initial(self, T: Array, rest: Array | None = None) -> State:
        """State at t = 0; ValueError if the joints allow none.

        rest : (m, 3)  section temperatures from which equilibrium at ``T`` under the loads of
            t = 0 is found, in which the motion begins; None: it begins in the reference
        """
        coef = self.system.coefficients(T)
        q = None if rest is None else self._settled(self.system.coefficients(rest), coef)
        state, why = initial_state(self.system, self.control, coef, q=q)
        if state is None:
            raise ValueError(why)
        return state

    def _settled(self, c0: Coefficients, c1: Coefficients) -> Array:
        from mechanics.statics import equilibrium

        found = equilibrium(self.system, c0, c1, time=0.0)
        if found.why:
            raise ValueError(f"there is no equilibrium to begin with: {found.why}")
        return found.q

    def advance(
        self,
        state: State,
        h: float,
        T0: Array,
        T1: Array,
        observe: Observe | None = None,
    ) -> tuple[State, Array, str]:
        """State after ``h``, frictional heat (m,) [J] at each point, "" or the reason.

        Section temperatures (m, 3) [K, K/m, K/m] go linearly from ``T0`` to ``T1``.
        """
        c0 = self.system.coefficients(T0)
        c1 = None if np.array_equal(T0, T1) else self.system.coefficients(T1)
        window = Window.between(self.system, state.motion.t, h, c0, c1)._replace(T=T0)
        new, lost, why = advance(self.system, self.control, state, window, observe)
        return new, self._heat(new, lost, T0, T1), why

    def _heat(self, state: State, lost: Array, T0: Array, T1: Array) -> Array:
        """Frictional work at the points of the joints where it arises, as heat (m,) [J]."""
        heat, system, motion = np.zeros(len(self.x)), self.system, state.motion
        if system.contacts:
            y, v = system.unknowns(motion.q), np.append(motion.v, np.zeros(system.m))
            response = system.respond(y, v, system.coefficients(T1))
            for term in system.contacts:
                rows = system.contact_rows(term)
                heat += term.deposit(T0, lost[rows, 1], response[rows])
        return heat

    def coefficients(self, T: Array) -> Coefficients:
        """Coefficient arrays of all terms at section temperatures ``T`` (m, 3)."""
        return self.system.coefficients(T)


def _refused(system: System, order: list[str]) -> list[str]:
    """What is wrong with joints, one sentence for each."""
    if not system.m:
        return []
    found = repetitions(system.terms, system.layout.q0, system.scale, order)
    return [str(repetition) for repetition in found] + _jumps(system)


def _jumps(system: System) -> list[str]:
    """Joints that do not fit the reference at t = 0."""
    y = system.unknowns(system.layout.q0)
    coef = system.coefficients(np.tile([293.15, 0.0, 0.0], (len(system.layout.x), 1)))
    values = np.abs(system.constraints(y, 0.0, coef))
    sizes = abs(system.jacobian(y, 0.0, coef)) @ system.layout.scale
    jumps = np.flatnonzero(~(values <= START * sizes))
    names = {system.row_names[row]: values[row] for row in jumps}
    text = "what drives it must be zero at t = 0: it counts from the reference"
    return [
        f"joint {name!r}: {text if np.isfinite(value) else 'what drives it is no number at t = 0'}"
        for name, value in names.items()
    ]
