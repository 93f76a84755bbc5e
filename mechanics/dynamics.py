"""Motion over a coupling window: states in, states out, around the compiled ``mechanics.march``.

Step sizes lie on a ladder of halvings so that factorisations survive; they shrink below their
rung only to end the window exactly or to land on the onset of an impact.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mechanics import kernels, march
from mechanics.contact_laws import (
    APPROACH,
    CYLINDER,
    HISTORIES,
    HISTORY,
    LAST_FORCE,
    LAW,
    STEP,
    P,
)
from mechanics.march import Rows
from mechanics.schemes import Scheme
from mechanics.system import HOLDING, Coefficients, Factors, System, flat

Array = NDArray[np.float64]

ROWS = 512
"""Steps between two looks of an observer."""
SLID = 1e3
"""How long a contact that slides at the start has done so [s]."""
MOVED = 1e-9
"""Change of the initial velocities, relative to the largest, that counts as a change [-]."""

_REASONS = {
    march.UNCONVERGED: "Newton did not converge at {}",
    march.SINGULAR: "the system matrix is singular",
    march.INACCURATE: "the local error stays above the tolerance at {}",
    march.INFINITE: "forces are not finite at {}",
}


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

    @property
    def settings(self) -> Array:
        """Settings of ``mechanics.march``."""
        return self.scheme.settings(self.tolerance, self.largest_step, self.smallest_step)


class Motion(NamedTuple):
    """Where the system is.

    t : float [s]
    q, v, a : (n,) float  coordinates, velocities, accelerations
    lam : (m,) float  multipliers of the constraints
    force : (n,) float  all forces but inertia, constraints included
    approach : (n_c,) float [m/s]  approach speed of the impact that runs in each contact; 0 where
        there is none, -1 where it is not known
    history : (n_c, 7) float  of friction: deflection of bristles [m], slip velocity [m/s], time
        since sticking began [s]
    before : (2, n + m) float  coordinates and velocities one step before; (2, 0) where the scheme
        does not need them
    last : float [s]  size of the last step; 0 before the first
    """

    t: float
    q: Array
    v: Array
    a: Array
    lam: Array
    force: Array
    approach: Array
    history: Array
    before: Array
    last: float


class State(NamedTuple):
    """Everything that a later step depends on.

    ledger : (len(TERMS),) float [J]  energies and cumulative works
    rung : int  step size = largest_step / 2**rung
    calm : int  accepted steps since the last refusal
    counts : (4,) int  accepted, refused steps, Newton corrections, factorisations so far
    latched : (n_l,) float  1 where a latch has caught
    errors : (2,) float  sum and largest of the estimated local errors of the accepted steps so far,
        relative to ``System.scale``
    """

    motion: Motion
    ledger: Array
    rung: int
    calm: int
    counts: NDArray[np.int64]
    latched: Array
    errors: Array


class Window(NamedTuple):
    """Coefficients at both ends of a window that starts at ``t0`` and lasts ``h`` [s].

    T : (m, 3) float  section temperatures that masses follow in this window; None: they do not
    """

    t0: float
    h: float
    c0: Coefficients
    c1: Coefficients
    T: Array | None = None

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


Observe = Callable[[Rows], None]


# --------------------------------------------------------------------------------------- the start


def initial_state(
    system: System, control: Control, coef: Coefficients, t: float = 0.0, q: Array | None = None
) -> tuple[State | None, str]:
    """State in the initial motion, with consistent velocities, accelerations and multipliers.

    Velocities that violate the constraints are changed as by an impact (see ``impulse``).

    q : (n,) coordinates that it begins with; None: those of the reference
    """
    q = (system.layout.q0 if q is None else q).copy()
    system = system.following(q)
    latched = np.zeros(len(system.program.latch_value))
    coef = _latched(system, coef, latched)
    if why := _infinite(system, q, system.layout.v0, t, coef):
        return None, why
    v = impulse(system, q, system.layout.v0.copy(), t, coef)
    if v is not None:
        coef, approach, history = _touching(system, q, v, coef)
    found = None if v is None else balanced(system, q, v, t, coef)
    if found is None or v is None or not np.all(np.isfinite(np.concatenate(found))):
        return None, (
            "initial accelerations: constraints contradict or repeat one another, "
            "or something without mass is free to move"
        )
    a, lam, force = found
    size = system.n + system.m if control.scheme.kind == march.BDF2 else 0
    motion = Motion(t, q, v, a, lam, force, approach, history, np.zeros((2, size)), 0.0)
    ledger = np.zeros(march.TERMS)
    ledger[0] = _kinetic(system, v)
    ledger[1:3] = system.energies(system.unknowns(q), _padded(system, v), coef)[:2]
    return State(motion, ledger, 0, 0, np.zeros(4, np.int64), latched, np.zeros(2)), ""


def _touching(
    system: System, q: Array, v: Array, coef: Coefficients
) -> tuple[Coefficients, Array, Array]:
    """Coefficients with what contacts carry with them, approach speeds and histories.

    Bristles of a contact that slides are deflected as if it had done so for long.
    """
    if not system.contacts:
        return coef, np.zeros(0), np.zeros((0, HISTORIES))
    y, w, p = system.unknowns(q), _padded(system, v), system.program
    response = system.respond(y, w, coef)
    approach, history = np.zeros(len(response)), np.zeros((len(response), HISTORIES))
    march.note_approach(p.contact_at, flat(coef), p.mobility, response, approach)
    changed = list(coef)
    for term in system.contacts:
        k, rows = system.terms.index(term), system.contact_rows(term)
        changed[k] = coef[k].copy()
        each = changed[k].reshape(len(term.contact_names), -1)
        each[:, STEP] = SLID
        history[rows] = kernels.histories(term, y, w, changed[k], HISTORIES)
        history[rows, -1] = 0.0
        each[:, STEP], each[:, APPROACH] = 0.0, approach[rows]
        each[:, HISTORY : HISTORY + HISTORIES] = history[rows]
    return tuple(changed), approach, history


def _infinite(system: System, q: Array, v: Array, t: float, coef: Coefficients) -> str:
    """Where forces are not finite at the start; "" if they are."""
    forces = system.residual(system.unknowns(q), _padded(system, v), t, coef)
    off = np.flatnonzero(~np.isfinite(forces))
    at = f"{system.name_of(int(off[0]))}, at t = {t:.9g} s" if off.size else ""
    return _REASONS[march.INFINITE].format(at) if at else ""


def impulse(system: System, q: Array, v: Array, t: float, coef: Coefficients) -> Array | None:
    """Velocities after an impulse that makes them obey the constraints; None if none can.

    M (v1 - v0) + Phi_q^T mu = 0, Phi_q v1 + Phi_t = 0: the least change of kinetic energy in the
    motion that it stops (Bertrand & Delaunay; Pars 1965, sec. 14.4).
    """
    if not system.m:
        return v
    y = system.unknowns(q)
    solve = system.factorise(system.matrix(y, _padded(system, v), t, coef, Factors(1.0, 0.0, 0.0)))
    if solve is None:
        return None
    rate = _slopes(system, y, _padded(system, v), t, coef)[0]
    change = solve(np.concatenate([np.zeros(system.n), -rate]))[: system.n]
    return v + change if np.all(np.isfinite(change)) else None


def balanced(
    system: System, q: Array, v: Array, t: float, coef: Coefficients
) -> tuple[Array, Array, Array] | None:
    """Accelerations (n,), multipliers (m,) and all forces (n,) that are in balance."""
    y, w = system.unknowns(q), _padded(system, v)
    solve = system.factorise(system.matrix(y, w, t, coef, Factors(1.0, 0.0, 0.0)))
    if solve is None:
        return None
    bend = _slopes(system, y, w, t, coef)[1] if system.m else np.zeros(0)
    free = system.residual(y, w, t, coef)[: system.n]
    x = solve(np.concatenate([-free, -bend]))
    a, lam = x[: system.n], x[system.n :]
    return a, lam, system.residual(system.unknowns(q, lam), w, t, coef)[: system.n]


def _slopes(
    system: System, y: Array, v: Array, t: float, coef: Coefficients
) -> tuple[Array, Array]:
    """Phi_q v + Phi_t and the rest of the second derivative of Phi along q + v dt.

    Central differences, exact for constraints quadratic in q.
    """
    eps = march.instant(y, v, system.scale)
    low, here, high = (
        system.constraints(system.unknowns((y + s * v)[: system.n]), t + s, coef)
        for s in (-eps, 0.0, eps)
    )
    return (high - low) / (2.0 * eps), (low - 2.0 * here + high) / eps**2


def _kinetic(system: System, v: Array) -> float:
    """Kinetic energy [J], to the last bit as the march finds it."""
    momentum = np.empty(system.n)
    march.inertia(system.packed, v, momentum)
    return march.half_product(v, momentum)


def _padded(system: System, v: Array) -> Array:
    return np.concatenate([v, np.zeros(system.m)])


# ---------------------------------------------------------------------------------- a window


def advance(
    system: System,
    control: Control,
    state: State,
    window: Window,
    observe: Observe | None = None,
    full: bool = False,
) -> tuple[State, Array, str]:
    """Carry the state through the window.

    Parameters
    ----------
    observe : called now and then with what was kept of the accepted steps
    full : keep coordinates, velocities and ledger of each step as well

    Returns
    -------
    state : State  at the end of the window
    lost : (n_c, 2) float [J]  normal dissipation and frictional work of each contact
    why : str  "" or the reason why the window could not be finished
    """
    carried, latched = _carried(system, state), state.latched.copy()
    while True:
        system = system.following(carried.y[: system.n])
        w = _memory(system, control, window, carried, latched, full)
        packed = system.packed if window.T is None else system.packed_at(window.T)
        how, count, worst = kernels.uninterrupted(march.march, packed, w)
        if system.contacts and (why := _outside(system, window, w, count)):
            return state, carried.lost, why
        if observe is not None and count:
            observe(_rows(system, w, count))
        carried = _returned(system, w)
        if how == march.LATCHED:
            how = _latch(system, window, carried, latched)
        if how == march.DONE and carried.clock[0] >= window.t0 + window.h:
            return _state(system, carried, latched), carried.lost, ""
        left = count and system.following(carried.y[: system.n]) is not system
        if how not in (march.DONE, march.FULL) and not left:
            why = f"{_reason(system, how, worst)}, at t = {carried.clock[0]:.9g} s"
            return state, carried.lost, why


def _outside(system: System, window: Window, w: march.Memory, count: int) -> str:
    """Which contact, if any, was pressed beyond the range of its law in the steps that are kept."""
    at, coef = system.program.contact_at, flat(window.c0)
    bounded = (coef[at + LAW] == CYLINDER) & (coef[at + P] > 0.0)
    if not bounded.any():
        return ""
    most = np.where(bounded, LAST_FORCE * coef[at + P], np.inf)
    rows = march.field(w, march.ROW_RESPONSE, ROWS, len(at), march.COLUMNS, count=count)
    step, contact = np.nonzero(rows[:, :, march.ELASTIC] > most)
    if not step.size:
        return ""
    k, j = step[0], contact[0]
    return (
        f"joint {system.contact_names[j]!r} is pressed with {rows[k, j, march.ELASTIC]:.4g} N, "
        f"Johnson's law of the cylinder holds up to {most[j]:.4g} N, "
        f"at t = {march.field(w, march.ROW_T)[k]:.9g} s"
    )


def _reason(system: System, how: int, worst: int) -> str:
    """Why no step is possible."""
    if how == march.BEYOND:
        return system.limits[worst].reason
    return _REASONS[how].format(system.name_of(worst))


def _memory(
    system: System,
    control: Control,
    window: Window,
    carried: march.Carried,
    latched: Array,
    full: bool,
) -> march.Memory:
    """Room for the march, filled with copies of where it begins."""
    c0 = flat(_latched(system, window.c0, latched))
    same = window.c1 is window.c0
    c1 = np.zeros(0) if same else flat(_latched(system, window.c1, latched))
    span = np.array([window.t0, window.t0 + window.h, window.h])
    room = march.Window(span, c0, c1)
    factors, settings = system.solver.work_size, control.settings
    return march.memory(system.program, settings, room, carried, factors, ROWS, full)


def _latched(system: System, coef: Coefficients, latched: Array) -> Coefficients:
    """Coefficients in which the latches that have caught hold."""
    changed, latch = list(coef), 0
    for k, term in enumerate(system.terms):
        for row, *_ in getattr(term, "latches", ()):
            changed[k] = changed[k].copy() if changed[k] is coef[k] else changed[k]
            changed[k][row, HOLDING] = latched[latch]
            latch += 1
    return tuple(changed)


def _latch(system: System, window: Window, c: march.Carried, latched: Array) -> int:
    """Close the latches that have reached their place: an impact that stops the relative motion.

    What kinetic energy it takes is booked as hysteresis.
    """
    p, n, t = system.program, system.n, float(c.clock[0])
    beyond = np.sign(p.latch_value) * (c.y[p.latch_at[:, 0]] - p.latch_value) >= 0.0
    latched[beyond] = 1.0
    coef = _latched(system, window.at(t), latched)
    v = impulse(system, c.y[:n], c.v[:n], t, coef)
    found = None if v is None else balanced(system, c.y[:n], v, t, coef)
    if v is None or found is None:
        return march.SINGULAR
    kinetic = _kinetic(system, v)
    c.ledger[march.HYSTERESIS] += c.ledger[march.KINETIC] - kinetic
    c.ledger[march.KINETIC] = kinetic
    c.v[:n], c.a[:], c.y[n:], c.force[:] = v, found[0], found[1], found[2]
    c.clock[1] = 0.0
    return march.DONE


def _carried(system: System, state: State) -> march.Carried:
    """Copies of a state that ``march`` may change."""
    m = state.motion
    return march.Carried(
        y=system.unknowns(m.q, m.lam),
        v=_padded(system, m.v),
        a=m.a.copy(),
        force=m.force.copy(),
        before=m.before.copy(),
        approach=m.approach.copy(),
        history=m.history.copy(),
        ledger=state.ledger.copy(),
        lost=np.zeros((len(m.approach), 2)),
        clock=np.array([m.t, m.last, *state.errors]),
        whole=np.array([state.rung, state.calm, *state.counts], np.int64),
    )


def _returned(system: System, w: march.Memory) -> march.Carried:
    """What the march has carried on, copied."""
    names = march.Y, march.V, march.A, march.FORCE0, march.BEFORE, march.APPROACH0, march.HISTORY0
    y, v, a, force, before, approach, history = (march.field(w, name) for name in names)
    ledger, lost, clock = march.field(w, march.LEDGER), march.field(w, march.LOST), march.CLOCK
    return march.Carried(
        y, v, a, force, before.reshape(2, -1), approach, history.reshape(-1, HISTORIES), ledger,
        lost.reshape(-1, 2), march.field(w, clock), w.whole[:6].copy(),
    )  # fmt: skip


def _state(system: System, c: march.Carried, latched: Array) -> State:
    n = system.n
    motion = Motion(
        float(c.clock[0]), c.y[:n], c.v[:n], c.a, c.y[n:], c.force, c.approach, c.history,
        c.before, float(c.clock[1]),
    )  # fmt: skip
    return State(
        motion, c.ledger, int(c.whole[0]), int(c.whole[1]), c.whole[2:], latched, c.clock[2:]
    )


def _rows(system: System, w: march.Memory, count: int) -> Rows:
    """The rows that the march has kept."""
    joints, size = len(system.program.contact_at), system.n + system.m
    shapes = (
        (march.ROW_T, (ROWS,)), (march.ROW_RESPONSE, (ROWS, joints, march.COLUMNS)),
        (march.ROW_APPROACH, (ROWS, joints)), (march.ROW_DRIVE, (ROWS, len(system.driven))),
        (march.ROW_LOST, (ROWS, joints, 2)),
        (march.ROW_Y, (-1, size)), (march.ROW_V, (-1, size)), (march.ROW_LEDGER, (-1, march.TERMS)),
    )  # fmt: skip
    return Rows._make(march.field(w, name, *shape, count=count) for name, shape in shapes)
