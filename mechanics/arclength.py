"""Equilibrium paths through limit points and bifurcations, by arc length.

The load factor p is an unknown beside y = (q, lambda); what closes the equations is the length of
the change of the coordinates, each relative to its size: a cylinder about the last point
(Crisfield 1981, Comput. Struct. 13:55), linearised consistently (Schweizerhof & Wriggers 1986,
Comput. Meth. Appl. Mech. Engng 59:261), so that no root is to be chosen. A step continues in the
direction of the one before (Feng, Peric & Owen 1995). At a limit point the load turns; at a
bifurcation the stiffness loses a sign while the load goes on.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array, diags_array

from mechanics.eigen import negatives, ratio, saddle_solve
from mechanics.modes import stiffness
from mechanics.prediction import predicted
from mechanics.statics import STIFFNESS, at_rest, between, load_change, unbalanced
from mechanics.system import Coefficients, System

Array = NDArray[np.float64]

LIMIT, BIFURCATION = "limit point", "bifurcation"
WANTED = 5
"""Iterations towards which the arc is adapted."""
SHRUNK = 1.0 / 1024.0
"""Smallest arc, of the first one, before a path is given up."""
CORRECTION = 1e-9
"""Largest correction of a point on the path, relative to the size of the coordinates [-]."""
ITERATIONS = 12
BISECTIONS = 14
INVERSIONS = 100
"""Inverse iterations for the shape that is free at an event."""
SHIFT = 1e-14
"""What is added to the stiffness there, relative to ``eigen.ratio`` [-]."""


class Point(NamedTuple):
    """A point of a path.

    y : (n + m,) coordinates and multipliers;  load : load factor p
    slope : dp/ds, per arc;  unstable : number of negative eigenvalues of the stiffness
    """

    y: Array
    load: float
    slope: float
    unstable: int


class Event(NamedTuple):
    """Where stability changes: a limit point or bifurcation, and the motion that is free there.

    shape : (n,) float  lowest eigenvector of the stiffness, largest change 1
    """

    kind: str
    point: Point
    shape: Array


class Path(NamedTuple):
    """Points of a path and what happens on it; ``why`` is empty if it went where it should."""

    points: Sequence[Point]
    events: Sequence[Event]
    iterations: int
    why: str

    @property
    def loads(self) -> Array:
        """(k,) load factors."""
        return np.array([p.load for p in self.points])


class _Problem(NamedTuple):
    """What is followed, and how a change of coordinates is measured."""

    system: System
    c0: Coefficients
    c1: Coefficients

    def coefficients(self, load: float) -> Coefficients:
        return between(self.c0, self.c1, load)

    def measured(self, step: Array) -> Array:
        """Change of the coordinates relative to their size, (n,)."""
        n = self.system.n
        return step[:n] / (self.system.scale * np.sqrt(n))

    def weights(self) -> Array:
        """Squares of ``measured`` are weights times squares of changes, (n,)."""
        return 1.0 / (self.system.n * self.system.scale**2)


def follow(
    system: System,
    c0: Coefficients,
    c1: Coefficients,
    arc: float = 0.01,
    largest: float = 0.05,
    count: int = 200,
    until: Callable[[Point], bool] | None = None,
    start: Point | None = None,
    direction: Array | None = None,
) -> Path:
    """The path of equilibria from ``start`` (the reference, load 0) on.

    Loads and drives follow their histories with the load factor in place of time, below 0 and
    beyond 1 too; coefficients go from ``c0`` at 0 to ``c1`` at 1.

    Parameters
    ----------
    arc, largest : first and largest step: root mean square of the changes of all coordinates,
        relative to ``System.scale``
    count : number of points after which the path ends
    until : ends it at a point; None: when the load factor reaches 1
    direction : (n,) coordinates move this way at first; None: with growing load
    """
    problem = _Problem(system, c0, c1)
    reached = until or (lambda p: p.load >= 1.0)
    here = start or _point(problem, at_rest(system), 0.0, None)
    if here is None:
        return Path([], [], 0, "the stiffness is singular where the path begins")
    points, events, spent = [here], list[Event](), 0
    first, heading = arc, direction
    while len(points) <= count and not (len(points) > 1 and reached(here)):
        ahead, iterations = _step(problem, here, arc, heading)
        spent += iterations
        if ahead is None:
            arc *= 0.5
            if arc < SHRUNK * first:
                return Path(points, events, spent, f"the path is lost at load {here.load:.6g}")
            continue
        found = _event(problem, here, ahead, heading)
        if found is not None:
            events.append(found)
        heading = (ahead.y - here.y)[: system.n]
        points.append(ahead)
        here = ahead
        arc = min(largest, arc * min(2.0, max(0.5, (WANTED / iterations) ** 0.5)))
    return Path(points, events, spent, "")


def branch(
    system: System, c0: Coefficients, c1: Coefficients, event: Event, size: float = 1e-2
) -> tuple[Point, Array] | None:
    """A point on the branch that leaves a bifurcation along its shape, and the way there (n,).

    The equilibrium whose change from the bifurcation has the component ``size`` along the shape,
    to be given to ``follow`` as start and direction; a negative size is the other way.
    """
    problem = _Problem(system, c0, c1)
    y = event.point.y.copy()
    normal = problem.weights() * event.shape
    guess = y.copy()
    guess[: system.n] += size * event.shape
    offset = float(normal @ guess[: system.n])

    def plane(now: Array) -> tuple[float, Array]:
        return float(normal @ now[: system.n]) - offset, normal

    found = _correct(problem, guess, event.point.load, plane)[0]
    if found is None:
        return None
    way = (found[0] - y)[: system.n]
    point = _point(problem, *found, way)
    return None if point is None else (point, way)


# ---------------------------------------------------------------------------------------- steps


def _step(
    problem: _Problem, here: Point, arc: float, heading: Array | None
) -> tuple[Point | None, int]:
    """The point ``arc`` further, and iterations spent."""
    tangent = _tangent(problem, here.y, here.load, heading)
    if tangent is None:
        return None, 1
    change, slope = tangent
    weights, n = problem.weights(), problem.system.n

    def cylinder(now: Array) -> tuple[float, Array]:
        away = (now - here.y)[:n]
        return 0.5 * (float(weights @ away**2) - arc * arc), weights * away

    first = here.y + arc * change
    found, iterations = _correct(problem, first, here.load + arc * slope, cylinder)
    if found is None:
        return None, iterations
    way = (found[0] - here.y)[:n]
    if float((weights * way) @ change[:n]) < 0.5 * arc:  # turned back, or aside
        return None, iterations
    return _point(problem, *found, way), iterations


def _tangent(
    problem: _Problem, y: Array, load: float, heading: Array | None
) -> tuple[Array, float] | None:
    """Change of y (n + m,) and of the load per arc, towards ``heading``; None if singular."""
    system, coef = problem.system.following(y[: problem.system.n]), problem.coefficients(load)
    solve = system.factorise(system.matrix(y, np.zeros_like(y), load, coef, STIFFNESS))
    if solve is None:
        return None
    change = solve(-load_change(system, y, problem.c0, problem.c1, load))
    length = float(np.linalg.norm(problem.measured(change)))
    if not np.isfinite(length) or length == 0.0:
        return None
    if heading is not None and (problem.weights() * heading) @ change[: system.n] < 0.0:
        length = -length
    return change / length, 1.0 / length


def _correct(
    problem: _Problem,
    y: Array,
    load: float,
    closing: Callable[[Array], tuple[float, Array]],
) -> tuple[tuple[Array, float] | None, int]:
    """Newton for y and the load on the surface ``closing``, which gives its value and normal."""
    system, still = problem.system.following(y[: problem.system.n]), np.zeros_like(y)
    n, shift = system.n, None
    for count in range(1, ITERATIONS + 1):
        coef = problem.coefficients(load)
        stressed = coef if shift is None else predicted(system, coef, *shift, y)
        data = system.matrix(y, still, load, stressed, STIFFNESS)
        solve = system.factorise(data)
        if solve is None:
            return None, count
        residual = system.residual(y, still, load, coef)
        step = solve(-residual)
        per_load = solve(-load_change(system, y, problem.c0, problem.c1, load))
        value, normal = closing(y)
        slope = float(normal @ per_load[:n])
        more = -(value + float(normal @ step[:n])) / slope if slope else np.nan
        step = step + more * per_load
        size = float(np.max(np.abs(step[:n]) / system.scale, initial=0.0))
        if not np.isfinite(size) or size > 1.0:
            return None, count
        shift = y, step
        y, load = y + step, load + more
        if size <= CORRECTION:
            coef = problem.coefficients(load)
            residual = system.residual(y, still, load, coef)
            if unbalanced(system, y, load, coef, data, residual) is None:
                return (y, load), count
    return None, ITERATIONS


def _point(problem: _Problem, y: Array, load: float, heading: Array | None) -> Point | None:
    tangent = _tangent(problem, y, load, heading)
    if tangent is None:
        return None
    K, B = stiffness(problem.system, y, load, problem.coefficients(load))
    return Point(y, load, tangent[1], negatives(K, B))


# --------------------------------------------------------------------------------------- events


def _event(problem: _Problem, here: Point, ahead: Point, heading: Array | None) -> Event | None:
    """What lies between two points, found by halving the arc."""
    turned = here.slope * ahead.slope < 0.0
    if not turned and here.unstable == ahead.unstable:
        return None
    n = problem.system.n
    arc = float(np.linalg.norm(problem.measured(ahead.y - here.y)))
    low, high, best = 0.0, arc, (here, ahead)
    way = (ahead.y - here.y)[:n]
    part = 0.5
    for _ in range(BISECTIONS):
        at = low + part * (high - low)
        middle, _ = _step(problem, here, at, way)
        if middle is None:  # too close to where the stiffness is singular
            if part < 0.5:
                break
            part = 0.3
            continue
        part = 0.5
        same = middle.slope * here.slope > 0.0 if turned else middle.unstable == here.unstable
        low, high = (at, high) if same else (low, at)
        best = (middle, best[1]) if same else (best[0], middle)
    point = min(best, key=lambda p: abs(p.slope)) if turned else best[0]
    kind = LIMIT if turned else BIFURCATION
    return Event(kind, point, _free_shape(problem, point))


def _free_shape(problem: _Problem, point: Point) -> Array:
    """Eigenvector (n,) of the eigenvalue of the stiffness that is nearest to zero.

    By inverse iteration: near an event it is nearer than all others by far. Where it is zero to
    round-off, a shift of that size keeps the factors regular.
    """
    system, weights = problem.system, problem.weights()
    K, B = stiffness(system, point.y, point.load, problem.coefficients(point.load))
    M = csc_array(diags_array(weights))
    shift = SHIFT * ratio(K, M, system.scale)
    inverse = saddle_solve(csc_array(0.5 * (K + K.T) + shift * M), B)
    shape, before = np.random.default_rng(0).standard_normal(system.n), np.zeros(system.n)
    for _ in range(INVERSIONS):
        shape = inverse(weights * shape)
        shape /= np.sqrt(weights @ shape**2) * np.sign(shape[np.argmax(np.abs(before))] or 1.0)
        if np.sqrt(weights @ (shape - before) ** 2) < 1e-9:
            break
        before = shape
    return shape / np.max(np.abs(shape) / system.scale)
