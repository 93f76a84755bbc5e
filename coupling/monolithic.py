"""Heat and motion in one Newton iteration per step: the reference for the schemes in windows.

Motion by generalised-alpha or HHT on the positions (index 3), heat by the trapezoidal rule, work of
friction by mean force and mean slip: all of second order, nothing is handed over late or predicted.

    M ((1 - alpha_m) a1 + alpha_m a0) + (1 - alpha_f) F(q1, v1, T1) + alpha_f F(q0, v0, T0) = 0
    Phi(q1, t1) = 0
    E(T1) - E(T0) - h/2 (P(T0) + P(T1)) - Q(q0, v0, T0, q1, v1, T1) = 0

Matrices are dense, and what couples the two sides is found by differences: for small scenes. Not
for motion with memory beyond the approach speeds of contacts (bristles, latches), nor for heat that
light or the conductance of joints brings.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from coupling.manager import Coupled, Pair
from mechanics import march
from mechanics.contact_laws import APPROACH, FRICTION, NONE, REGULARISED, STEP, STRIBECK
from mechanics.schemes import Scheme
from mechanics.system import Coefficients, Factors, System, flat
from thermal.boundary import Moment

Array = NDArray[np.float64]

ITERATIONS = 25
SETTLED = 1e-11
"""Newton ends when no correction is larger, relative to the scale of what it corrects [-]."""
SLOW = 0.1
"""Ratio of two corrections above which the matrix is made anew [-]."""
DIFFERENCE = 1e-6
"""Step of numerical derivatives, relative to the same scales [-]."""


class Together(NamedTuple):
    """State of motion and heat at one time.

    q, v, a : (n,);  lam : (m,);  T : (k,) [K]
    approach : (n_c,) [m/s]  of the impacts that run
    released : float [J]  frictional heat so far; heat : float [J]  all that temperatures received
    """

    t: float
    q: Array
    v: Array
    a: Array
    lam: Array
    T: Array
    approach: Array
    released: float
    heat: float


class Monolithic:
    """Steps of a pair. ValueError with everything in it that cannot be done in this way.

    Parameters
    ----------
    scheme : of the motion, "hht" or "generalised-alpha"
    """

    def __init__(self, pair: Pair, scheme: Scheme | None = None) -> None:
        self.pair, self.scheme = pair, scheme or Scheme()
        motion_solver: Any = pair.motion_solver
        self.system: System = motion_solver.system
        self.heat: Any = pair.heat_solver
        problems = _refused(pair, self.system, self.scheme)
        if problems:
            raise ValueError("\n".join(problems))
        self._mass = self.system.mass.toarray()
        dofs = [np.unique(term.dofs) for term in self.system.contacts]
        touched = np.unique(np.concatenate([np.zeros(0, np.intp), *dofs]))
        deformed = pair.surroundings is not None  # releases heat
        self._felt = np.arange(self.system.n) if deformed else touched[touched < self.system.n]

    def begin(self, state: Coupled) -> Together:
        """From a coupled state."""
        m = state.motion.motion
        return Together(
            m.t, m.q, m.v, m.a, m.lam, state.T, m.approach, state.released, state.deposited
        )

    def advance(self, state: Together, h: float) -> tuple[Together | None, str]:
        """State after a step of ``h`` [s], or the reason why there is none."""
        step = _Step(self, state, h)
        n, m = self.system.n, self.system.m
        z = np.concatenate([step.q_free, state.lam, state.T[self.heat.free]])
        scale = np.concatenate([
            self.system.scale, np.ones(m),
            np.full(len(self.heat.free), max(1.0, float(np.abs(state.T).max(initial=0.0)))),
        ])  # fmt: skip
        scale[n : n + m] = max(1.0, float(np.abs(step.force0).max(initial=0.0)))
        tangent, before = step.jacobian(z, scale), np.inf
        for _ in range(ITERATIONS):
            correction = _solved(tangent, step.residual(z))
            if correction is None:
                return None, f"the matrix is singular, at t = {state.t:.9g} s"
            z = z - correction
            moved = np.abs(correction / scale)
            size = max(moved[:n].max(initial=0.0), moved[n + m :].max(initial=0.0))
            if size <= SETTLED:
                return step.end(z), ""
            if size > SLOW * before:
                tangent = step.jacobian(z, scale)
            before = size
        return None, f"Newton did not converge, at t = {state.t:.9g} s"

    def run(self, state: Together, h: float, count: int) -> Together:
        """State after ``count`` steps of ``h`` [s]. RuntimeError where one fails."""
        for _ in range(count):
            new, why = self.advance(state, h)
            if new is None:
                raise RuntimeError(why)
            state = new
        return state

    def coefficients(self, state: Together, T: Array) -> Coefficients:
        """Of all terms at temperatures ``T`` (k,), contacts knowing their approach speeds."""
        found = list(self.system.coefficients(self.pair.transfer.read(T)))
        for term in self.system.contacts:
            index, rows = self.system.terms.index(term), self.system.contact_rows(term)
            each = found[index].reshape(len(term.contact_names), -1)
            each[:, APPROACH], each[:, STEP] = state.approach[rows], 0.0
        return tuple(found)


class _Step:
    """Equations of one step from a state over ``h`` [s]."""

    def __init__(self, owner: Monolithic, state: Together, h: float) -> None:
        self.owner, self.state, self.h = owner, state, h
        self.system: System = owner.system
        self.heat, scheme = owner.heat, owner.scheme
        self.alpha_m, self.alpha_f = scheme.alphas
        self.B, self.G = scheme.beta * h * h, scheme.gamma * h
        self.q_free = state.q + h * state.v + (0.5 - scheme.beta) * h * h * state.a
        self.v_free = state.v + (1.0 - scheme.gamma) * h * state.a
        self.c0 = owner.coefficients(state, state.T)
        self.response0 = self._respond(state.q, state.v, self.c0)
        self.force0 = self._force(state.q, state.v, state.lam, state.t, self.c0)[: self.system.n]
        self.stored = self.heat.space.heat(state.T)
        self.power0 = self._power(state.T, state.t)

    def residual(self, z: Array) -> Array:
        """(n + m + k,)  [N], [m] or [1], [J]."""
        n, free = self.system.n, self.heat.free
        q, v, a, lam, T = self._parts(z)
        c1 = self.owner.coefficients(self.state, T)
        c0, c1 = self.system.with_rates(self.c0, c1, self.h)
        t1, state = self.state.t + self.h, self.state
        force1 = self._force(q, v, lam, t1, c1)
        force0 = self._force(state.q, state.v, state.lam, state.t, c0)[:n]
        inertia = self.owner._mass @ ((1.0 - self.alpha_m) * a + self.alpha_m * state.a)
        motion = inertia + (1.0 - self.alpha_f) * force1[:n] + self.alpha_f * force0
        return np.concatenate([motion, force1[n:], self._heat_defect(q, v, T)[free]])

    def jacobian(self, z: Array, scale: Array) -> Array:
        """(n + m + k, n + m + k): blocks of the motion exact, what couples by differences."""
        n, m, k = self.system.n, self.system.m, len(self.heat.free)
        q, v, _, lam, T = self._parts(z)
        part, c1 = 1.0 - self.alpha_f, self.owner.coefficients(self.state, T)
        factors = Factors((1.0 - self.alpha_m) / self.B, part, part * self.G / self.B)
        y = self.system.unknowns(q, lam)
        w = np.concatenate([v, np.zeros(m)])
        data = self.system.matrix(y, w, self.state.t + self.h, c1, factors)
        out = np.zeros((n + m + k, n + m + k))
        out[: n + m, : n + m] = self.system.pattern.matrix(data).toarray()
        out[:n, n : n + m] *= part
        for column in range(n + m, n + m + k):
            out[:, column] = self._slope(self.residual, z, column, DIFFERENCE * scale[column])
        for column in self.owner._felt:
            change = self._slope(self._heat_of, z, int(column), DIFFERENCE * scale[column])
            out[n + m :, column] = change
        return out

    def end(self, z: Array) -> Together:
        """The state that solves the equations."""
        q, v, a, lam, T = self._parts(z)
        friction, elastic = self._released(q, v, T)
        c1 = self.owner.coefficients(self.state, T)
        response, approach = self._respond(q, v, c1), self.state.approach.copy()
        if len(approach):
            program = self.system.program
            march.note_approach(program.contact_at, flat(c1), program.mobility, response, approach)
        made = float(friction.sum())
        return Together(
            self.state.t + self.h, q, v, a, lam, T, approach,
            self.state.released + made, self.state.heat + made + float(elastic.sum()),
        )  # fmt: skip

    def _parts(self, z: Array) -> tuple[Array, Array, Array, Array, Array]:
        n, m = self.system.n, self.system.m
        q, lam = z[:n], z[n : n + m]
        a = (q - self.q_free) / self.B
        T = self.state.T.copy()
        nodes, values = self.heat.given_at(self.state.t + self.h)
        T[nodes], T[self.heat.free] = values, z[n + m :]
        return q, self.v_free + self.G * a, a, lam, T

    def _force(self, q: Array, v: Array, lam: Array, t: float, coef: Coefficients) -> Array:
        w = np.concatenate([v, np.zeros(self.system.m)])
        return self.system.residual(self.system.unknowns(q, lam), w, t, coef)

    def _respond(self, q: Array, v: Array, coef: Coefficients) -> Array:
        w = np.concatenate([v, np.zeros(self.system.m)])
        return self.system.respond(self.system.unknowns(q), w, coef)

    def _power(self, T: Array, t: float) -> Array:
        return self.heat.power(T, Moment(t, {}))[0]

    def _heat_defect(self, q: Array, v: Array, T: Array) -> Array:
        """(k,) [J] that temperatures store beyond what they received."""
        power = 0.5 * (self.power0 + self._power(T, self.state.t + self.h))
        received = self.h * power + sum(self._released(q, v, T))
        return self.heat.space.heat(T) - self.stored - received

    def _heat_of(self, z: Array) -> Array:
        q, v, _, _, T = self._parts(z)
        return self._heat_defect(q, v, T)[self.heat.free]

    def _released(self, q: Array, v: Array, T: Array) -> tuple[Array, Array]:
        """(k,) [J] twice: heat of friction and of deformation over the step."""
        pair, system = self.owner.pair, self.system
        friction, elastic = np.zeros_like(T), np.zeros_like(T)
        if system.contacts:
            r0, r1 = self.response0, self._respond(q, v, self.owner.coefficients(self.state, T))
            force, slip = (
                r0[:, at : at + 3] + r1[:, at : at + 3] for at in (march.FRICTION, march.SLIP)
            )
            work = -0.25 * self.h * (force * slip).sum(axis=1)
            sections = pair.transfer.read(0.5 * (self.state.T + T))
            points = np.zeros(len(sections))
            for term in system.contacts:
                rows = system.contact_rows(term)
                points = points + term.deposit(sections, work[rows], r1[rows])
            friction = pair.transfer.deposit(points)
        if pair.surroundings is not None:
            lam = self.state.lam  # of no account to stress
            first = _Posed(_Pose(self.state.q, self.state.v, lam))
            last = _Posed(_Pose(q, v, lam))
            found = pair.surroundings.released(first, last, self.state.T, T)
            elastic = elastic if found is None else found
        return friction, elastic

    @staticmethod
    def _slope(of: Any, z: Array, column: int, size: float) -> Array:
        up, down = z.copy(), z.copy()
        up[column] += size
        down[column] -= size
        return (of(up) - of(down)) / (2.0 * size)


class _Pose(NamedTuple):
    q: Array
    v: Array
    lam: Array


class _Posed(NamedTuple):
    """What heat of deformation wants to know of a mechanical state."""

    motion: _Pose


def _solved(matrix: Array, right: Array) -> Array | None:
    """Solution after scaling rows; None if there is none."""
    size = np.abs(matrix).max(axis=1)
    if not (np.all(np.isfinite(matrix)) and np.all(np.isfinite(right)) and np.all(size > 0.0)):
        return None
    try:
        return np.linalg.solve(matrix / size[:, None], right / size)
    except np.linalg.LinAlgError:
        return None


def _refused(pair: Pair, system: System, scheme: Scheme) -> list[str]:
    """What the monolithic reference cannot do, a sentence for each."""
    found = []
    if scheme.name not in ("hht", "generalised-alpha"):
        found.append(f"scheme {scheme.name}: expected hht or generalised-alpha")
    if scheme.constraints != "index3":
        found.append(f"constraints {scheme.constraints}: expected index3")
    if not hasattr(pair.heat_solver, "space"):
        found.append("heat: a solver that does not say what each temperature stores")
    if len(system.program.latch_value):
        found.append("latches: they remember")
    if getattr(pair.surroundings, "lit", False) or getattr(pair.surroundings, "held", False):
        found.append("light and conductance of joints: what the pose decides for the heat")
    room = np.tile([293.15, 0.0, 0.0], (len(system.layout.x), 1))
    laws = flat(system.coefficients(room))[system.program.contact_at + FRICTION]
    if not np.all(np.isin(laws, (NONE, REGULARISED, STRIBECK))):
        found.append("friction with memory: expected regularised or stribeck")
    return found
