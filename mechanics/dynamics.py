"""Motion over a coupling window: substeps of HHT-alpha under step control.

One substep: try -> refuse, or locate the onset of an impact -> accept -> book the energy.
Step sizes lie on a ladder of halvings so that factorisations survive; they shrink below their
rung only to end the window exactly or to land on the onset of an impact.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from math import ceil
from typing import NamedTuple

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

from mechanics import ledger
from mechanics.hht import Jacobian, Motion, Scheme, step
from mechanics.ledger import Balance
from mechanics.system import Coefficients, System

Array = NDArray[np.float64]

LANDING = 1e-6
"""An impact begins, and ends, within this fraction of the clearance before touching [-]."""
BERNSTEIN = np.array([[1, 0, 0, 0], [-3, 3, 0, 0], [3, -6, 3, 0], [-1, 3, -3, 1]], float)
"""(4, 4) Coefficients of a cubic from its four control points."""
CALM = 4
"""Steps between a refusal and the next doubling of the step size."""
IMPACT_RESOLUTION = 32.0
"""Steps into which the estimated duration of an impact is divided."""
VIOLENT = 0.1
"""Penetration rate, in approach speeds, above which a contact is resolved as an impact [-]."""
DOUBLING_ERROR = 0.1
"""Part of the tolerance below which a local error allows twice the step, eight times the error."""
UNMEASURED = -1.0
"""Marks an impact that runs without a positive approach speed: no dissipation is known for it."""


@dataclass(frozen=True)
class Control:
    """Step-size control.

    tolerance : float  local error of a step relative to ``System.scale``
    largest_step, smallest_step : float [s]
    """

    tolerance: float = 1e-6
    largest_step: float = 1e-2
    smallest_step: float = 1e-10
    scheme: Scheme = field(default_factory=Scheme)


class State(NamedTuple):
    """Everything that a later step depends on.

    ledger : (len(TERMS),) float [J]  energies and cumulative works
    rung : int  step size = largest_step / 2**rung
    calm : int  accepted steps since the last refusal
    counts : (3,) int  accepted steps, refused steps, Newton corrections so far
    """

    motion: Motion
    ledger: Array
    rung: int
    calm: int
    counts: Array


class Window(NamedTuple):
    """Coefficients at both ends of a window that starts at ``t0`` and lasts ``h`` [s]."""

    t0: float
    h: float
    c0: Coefficients
    c1: Coefficients

    @classmethod
    def between(
        cls, system: System, t0: float, h: float, c0: Coefficients, c1: Coefficients | None
    ) -> "Window":
        """From ``c0`` to ``c1``, free strains changing evenly; None: all stays as it is."""
        return cls(t0, h, c0, c0) if c1 is None else cls(t0, h, *system.with_rates(c0, c1, h))

    def at(self, t: float) -> Coefficients:
        """Coefficients at time ``t``, linear inside the window."""
        if self.c0 is self.c1:
            return self.c0
        s = (t - self.t0) / self.h
        return tuple(a + s * (b - a) for a, b in zip(self.c0, self.c1, strict=True))


class _Here(NamedTuple):
    """A state with what was computed along with it."""

    state: State
    coef: Coefficients
    balance: Balance
    jacobian: Jacobian | None


class _Tried(NamedTuple):
    """A converged step that has not been accepted yet."""

    motion: Motion
    coef: Coefficients
    jacobian: Jacobian
    error: float


Observe = Callable[[State, Array], None]


def initial_state(
    system: System, control: Control, coef: Coefficients, t: float = 0.0
) -> tuple[State | None, str]:
    """State at rest or in the initial motion, with consistent accelerations and multipliers."""
    q, v = system.layout.q0.copy(), system.layout.v0.copy()
    approach = system.apart
    found = system.initial_acceleration(q, v, t, coef, approach)
    if found is None:
        return None, "initial accelerations: the constraints contradict or repeat one another"
    a, lam = found
    force = system.force(q, v, t, coef, approach) + system.constraint_force(q, t, lam)
    motion = Motion(t, q, v, a, lam, force, force, approach)
    motion = motion._replace(approach=_approach(system, motion, coef))
    return State(motion, ledger.balance(system, motion, coef).row, 0, 0, np.zeros(3, np.int64)), ""


def advance(
    system: System, control: Control, state: State, window: Window, observe: Observe | None = None
) -> tuple[State, Array, str]:
    """Carry the state through the window.

    Returns
    -------
    state : State  at the end of the window
    lost : (n_j, 2) float [J]  normal dissipation and frictional work of each clearance joint
    why : str  "" or the reason why the window could not be finished
    """
    here, end = _enter(system, state, window), window.t0 + window.h
    lost = np.zeros((len(state.motion.approach), 2))
    while here.state.motion.t < end:
        new, why = _substep(system, control, here, window, end)
        if new is None:
            return state, lost, f"{why}, at t = {here.state.motion.t:.9g} s"
        lost += ledger.contact_losses(here.balance, new.balance)
        here = new
        if observe is not None:
            observe(here.state, _responses(system, here))
    return here.state, lost, ""


def _responses(system: System, here: _Here) -> Array:
    if system.contact is None:
        return np.zeros((0, 0))
    m = here.state.motion
    return system.contact.response(m.q, m.v, here.coef[-1], m.approach)


def _enter(system: System, state: State, window: Window) -> _Here:
    """Begin a window; a jump of the coefficients since the last one is work of heating."""
    b = ledger.balance(system, state.motion, window.c0)
    row = b.row
    row[ledger.TERMS.index("work_thermal")] = b.stored - (state.ledger[1] + state.ledger[2])
    return _Here(state._replace(ledger=ledger.accumulate(state.ledger, row)), window.c0, b, None)


def _substep(
    system: System, control: Control, here: _Here, window: Window, end: float
) -> tuple[_Here | None, str]:
    """One accepted substep, whatever number of refused ones it takes."""
    target: float | None = None
    while True:
        h = _size(control, here.state, end, target)
        tried, spent, why = _try(system, control, here, window, h, end)
        here = _count(here, refused=int(tried is None), corrections=spent)
        if tried is not None:
            landing = _landing(system, here, tried)
            if landing is None:
                return _accept(system, control, here, tried), ""
            target = landing * h
        elif h <= 2.0 * control.smallest_step:
            return None, why
        elif target is not None:
            target = 0.5 * h
        else:
            here = _lower(control, here, h)


def _size(control: Control, state: State, end: float, target: float | None) -> float:
    """Step size on the ladder that ends the window in a whole number of steps, or the target."""
    if target is not None:
        return target
    remaining = end - state.motion.t
    rung = control.largest_step / 2**state.rung
    return remaining / max(1, ceil(remaining / rung - 1e-9))


def _try(
    system: System, control: Control, here: _Here, window: Window, h: float, end: float
) -> tuple[_Tried | None, int, str]:
    """A converged step within the error tolerance, or the reason why not; and its corrections."""
    start = here.state.motion
    last = start.t + h > end - 1e-9 * window.h
    coef = window.at(end if last else start.t + h)
    touching = start.approach != 0.0
    acting = _acting(coef, touching)
    made = step(system, control.scheme, start, h, acting, here.jacobian, touching.tobytes())
    if made.motion is None or made.jacobian is None:
        return None, made.iterations, made.why
    error, worst = _error(system, control, start, made.motion)
    if error > 1.0:
        why = f"the local error stays above the tolerance at {system.name_of(worst)}"
        return None, made.iterations, why
    motion = made.motion._replace(t=end) if last else made.motion
    return _Tried(motion, coef, made.jacobian, error), made.iterations, ""


def _acting(coef: Coefficients, touching: NDArray[np.bool_]) -> Coefficients:
    """No contact acts in a step that begins in free flight: it ends where the impact begins.

    A force at the end of a long step would slow the journal down before it arrives.
    """
    if touching.all():
        return coef
    joints = coef[-1].copy()
    joints[~touching, 0] = 0.0
    return *coef[:-1], joints


def _error(system: System, control: Control, m0: Motion, m1: Motion) -> tuple[float, int]:
    """Local error (beta - 1/6) h^2 |da| over the tolerance, and the coordinate where it is.

    Zienkiewicz & Xie (1991).
    """
    h = m1.t - m0.t
    factor = (control.scheme.beta - 1.0 / 6.0) * h * h / control.tolerance
    sizes = np.abs(m1.a - m0.a) / system.scale
    worst = int(np.argmax(sizes))
    return factor * float(sizes[worst]), worst


def _landing(system: System, here: _Here, tried: _Tried) -> float | None:
    """Fraction of the step at which the first impact begins; None: no onset inside.

    Journals fly along cubics through both ends of the step. One whose control points lie in the
    bearing circle stays in it.
    """
    if system.contact is None or here.state.motion.approach.all():
        return None
    m0, m1 = here.state.motion, tried.motion
    third = (m1.t - m0.t) / 3.0
    (y0, v0, c0), (y1, v1, c1) = _planar(system, m0, here.coef), _planar(system, m1, tried.coef)
    corners = np.stack([y0, y0 + third * v0, y1 - third * v1, y1], axis=1)
    reach = np.linalg.norm(corners, axis=2).max(axis=1)
    suspects = (m0.approach == 0.0) & (reach > (1.0 - LANDING) * np.minimum(c0, c1))
    found = [_onset(corners[j], c0[j], c1[j]) for j in np.flatnonzero(suspects)]
    return min((s for s in found if s is not None), default=None)


def _planar(system: System, motion: Motion, coef: Coefficients) -> tuple[Array, Array, Array]:
    """Position (n_j, 2) [m] and velocity [m/s] of the journals, clearances [m]."""
    response, columns = _response(system, motion, coef)
    at = [columns.index(c) for c in ("y1", "y2", "y1_rate", "y2_rate", "clearance")]
    return response[:, at[:2]], response[:, at[2:4]], response[:, at[4]]


def _gaps(system: System, motion: Motion, coef: Coefficients) -> tuple[Array, Array, Array]:
    """Penetration [m], its rate [m/s] and the clearance [m] of each joint."""
    response, columns = _response(system, motion, coef)
    gap, rate, clearance = (columns.index(c) for c in ("penetration", "rate", "clearance"))
    return response[:, gap], response[:, rate], response[:, clearance]


def _response(system: System, motion: Motion, coef: Coefficients) -> tuple[Array, tuple[str, ...]]:
    assert system.contact is not None
    arguments = motion.q, motion.v, coef[-1], motion.approach
    return system.contact.response(*arguments), system.contact.columns


def _onset(corners: Array, c0: float, c1: float) -> float | None:
    """Where in (0, 1) a journal is about to leave the circle of radius c; None if it does not.

    It stops ``near``/2 before. A flight that begins closer than ``near``, as only one from the
    initial state can, may go ``near`` too far.

    Parameters
    ----------
    corners : (4, 2) float [m]  control points of the path
    c0, c1 : float [m]  clearance at both ends
    """
    y1, y2 = (Polynomial(BERNSTEIN @ corners[:, i] / c0) for i in range(2))
    square = y1**2 + y2**2

    def leaving(radius: float) -> Array:
        rising = square - (Polynomial([1.0, c1 / c0 - 1.0]) - 1.0 + radius) ** 2
        roots = rising.roots()
        real = roots[np.abs(roots.imag) < 1e-9].real
        inside = real[(real > 0.0) & (real < 1.0)]
        return inside[rising.deriv()(inside) > 0.0]

    limit = 1.0 if square(0.0) < (1.0 - LANDING) ** 2 else 1.0 + LANDING
    outside = leaving(limit)
    if not len(outside):
        return None
    return float(np.min(leaving(limit - 0.5 * LANDING), initial=outside.min()))


def _accept(system: System, control: Control, here: _Here, tried: _Tried) -> _Here:
    """Book the step, update the running impacts and choose the next rung."""
    m0 = here.state.motion
    b1 = ledger.balance(system, tried.motion, tried.coef)
    ends = m0, tried.motion, here.balance, b1
    heating = ledger.work_of_heating(system, *ends, here.coef, tried.coef)
    row = ledger.entries(system, control.scheme, *ends, heating)
    motion = tried.motion._replace(approach=_approach(system, tried.motion, tried.coef))
    state = here.state._replace(motion=motion, ledger=ledger.accumulate(here.state.ledger, row))
    state = _next_rung(system, control, state, tried)
    return _count(_Here(state, tried.coef, b1, tried.jacobian), accepted=1)


def _approach(system: System, motion: Motion, coef: Coefficients) -> Array:
    """Approach speed of each running impact: the largest since its onset; 0 once it is over.

    Taking the largest keeps the rate ratio of the hysteresis laws below one in contacts that
    are loaded anew without a separation. Once begun, an impact is over when the journal is
    clearly apart, so that no flight is too short for its end to be located.
    """
    if system.contact is None:
        return motion.approach
    gap, rate, clearance = _gaps(system, motion, coef)
    closing = (rate > 0.0) | (motion.approach != 0.0)
    touching = (gap > 0.0) | ((gap > -LANDING * np.abs(clearance)) & closing)
    largest = np.maximum(motion.approach, rate)
    return np.where(touching, np.where(largest > 0.0, largest, UNMEASURED), 0.0)


def _next_rung(system: System, control: Control, state: State, tried: _Tried) -> State:
    """Steps that resolve running impacts; longer ones when the error has been small for long."""
    calm = state.calm + 1
    finest = _impact_rung(system, control, state.motion, tried.coef)
    if finest > state.rung:
        return state._replace(rung=finest, calm=0)
    if state.rung > finest and calm >= CALM and tried.error < DOUBLING_ERROR:
        return state._replace(rung=state.rung - 1, calm=0)
    return state._replace(calm=calm)


def _impact_rung(system: System, control: Control, motion: Motion, coef: Coefficients) -> int:
    """Rung that resolves the impacts in which penetration changes noticeably; 0 if none does."""
    if system.contact is None or not motion.approach.any():
        return 0
    _, rate, _ = _gaps(system, motion, coef)
    violent = (motion.approach != 0.0) & (np.abs(rate) > VIOLENT * motion.approach)
    durations = _durations(system, motion, coef)[violent]
    return max((_rung_below(control, d / IMPACT_RESOLUTION) for d in durations), default=0)


def _durations(system: System, motion: Motion, coef: Coefficients) -> Array:
    """Estimated duration [s] of an elastic impact of each joint at its approach speed."""
    assert system.contact is not None
    speed = np.maximum(motion.approach, 1e-9)
    return system.contact.impact_duration(coef[-1], system.contact_mass, speed)


def _rung_below(control: Control, h: float) -> int:
    """First rung of the ladder whose step is not longer than ``h``."""
    h = max(h, control.smallest_step)
    return max(0, ceil(np.log2(control.largest_step / h) - 1e-9))


def _lower(control: Control, here: _Here, h: float) -> _Here:
    rung = _rung_below(control, 0.5 * h * (1.0 + 1e-9))
    return here._replace(state=here.state._replace(rung=rung, calm=0))


def _count(here: _Here, accepted: int = 0, refused: int = 0, corrections: int = 0) -> _Here:
    counts = here.state.counts + np.array([accepted, refused, corrections])
    return here._replace(state=here.state._replace(counts=counts))
