"""Stability over step length and stiffness: an oscillator, and a beam that spins.

The oscillator is linear: the schemes promise that nothing grows, however long the steps. What its
positions do is compared with the characteristic polynomials of the schemes. The beam turns by large
angles, of which the theory says nothing.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from coupling.reports.maps import DONE, GROWS, REFUSED, Map, Spot, counted, largest, reasons
from coupling.reports.registry import Curve, Picture, Result, Row
from coupling.reports.travel import Travel, travel
from coupling.verify.models import Model, elastic, model, straight
from mechanics.description import Guide, Joint, Particle, Revolute, Site, Spring
from mechanics.dynamics import Control
from mechanics.schemes import FORMULATIONS, SCHEMES, Scheme
from meshes.sections import rectangle

Array = NDArray[np.float64]
X, Y, Z = np.eye(3)

MASS, MOVED = 1.0, 0.1
"""Of the oscillator [kg]; what it would move in the first step if it were free [m]."""
LENGTHS = (1e-5, 1e-3, 1e-1, 1e1)
STIFFNESSES = tuple(10.0**e for e in range(-4, 15, 2))
STEPS = 200
ROUND_OFF = 1e-9
"""Energy gained that counts as none [-]."""
FITTED = (0.03, 0.1, 0.3, 1.0, 3.0, 10.0)
"""Steps in radians at which the spectral radius is measured."""

SPIN = 10.0  # [rad/s]
BEAM_LENGTHS = tuple(10.0**e for e in np.arange(-6.0, 0.5, 0.5))
MODULI = tuple(10.0**e for e in range(6, 15))
BEAM_STEPS, LONGEST = 40, 0.3
"""Equal steps; how long controlled ones go on at most [s]."""
ALLOWED = 1e-3
"""Energy that a run of the beam may gain and count as stable [-]."""


def report() -> Iterator[Result]:
    """Oscillator, then beam."""
    yield oscillators()
    yield beams()


# ------------------------------------------------------------------------------------ oscillator


def oscillators(
    lengths: Sequence[float] = LENGTHS, stiffnesses: Sequence[float] = STIFFNESSES
) -> Result:
    """All schemes and formulations of constraints."""
    rows, pictures, notes = list[Row](), [], [
        f"mass on a spring and a guide, {STEPS} equal steps of 1e-5 to 10 s: 1e-7 to 1e8 radians; "
        "it begins in the middle with a speed",
        "energy gained: largest over the start; by the scheme's own recursion: what the theory "
        "says of the same start (hht and generalised-alpha may gain in the first steps, and lose "
        "it again: overshoot)",
        "spectral radius: largest root of the recursion that the positions obey (Prony's method), "
        f"less that of the theory, at {', '.join(f'{x:g}' for x in FITTED)} radians",
    ]  # fmt: skip
    for name, constraints in product(SCHEMES, FORMULATIONS):
        scheme = Scheme(name=name, constraints=constraints)
        spots = [oscillator(h, k, scheme) for h, k in product(lengths, stiffnesses)]
        off = max(abs(measured(x, scheme) - radius(x, scheme)) for x in FITTED)
        found = counted(spots)
        rows.append((name, constraints, len(spots), found[DONE], found[REFUSED], found[GROWS],
                     largest(spots), max(promised(s.x * np.sqrt(s.y), scheme) for s in spots),
                     off))  # fmt: skip
        notes += [f"{name}, {constraints}: {text}" for text in reasons(spots)]
    pictures.append(_radii())
    columns = ("scheme", "constraints", "runs", "done", "stopped", "grows", "energy gained [-]",
               "by the recursion [-]", "spectral radius off by [-]")  # fmt: skip
    return Result("stability_oscillator", "Oscillator: step length and stiffness", columns, rows,
                  notes, pictures)  # fmt: skip


def spring(k: float, speed: float) -> Model:
    """A ball on a spring and a guide along x."""
    ball = Particle("ball", X, MASS, speed * X)
    joints: list[Joint] = [
              Guide("guide", Site("ball"), np.array([Y, Z])),
              Spring("spring", Site("ball"), Site(None), k)]  # fmt: skip
    return model(ball, joints)


def _moved(h: float, k: float, scheme: Scheme, steps: int) -> Travel:
    return travel(spring(k, MOVED / h), steps * h, _fixed(h, scheme))


def _fixed(h: float, scheme: Scheme) -> Control:
    return Control(np.inf, h, h, scheme)


def oscillator(h: float, k: float, scheme: Scheme) -> Spot:
    """A run of ``STEPS`` steps of ``h`` [s] with stiffness ``k`` [N/m]."""
    path = _moved(h, k, scheme, STEPS)
    if path.why:
        return Spot(h, k, REFUSED, why=path.why)
    gained = max(path.gained, 0.0)
    x = h * float(np.sqrt(k / MASS))
    stable = radius(x, scheme) <= 1.0 + ROUND_OFF
    limit = ROUND_OFF + (promised(x, scheme) if stable else 0.0)
    return Spot(h, k, DONE if gained <= limit else GROWS, gained)


def promised(x: float, scheme: Scheme) -> float:
    """Energy gained over the most stored by the recursion from rest in the middle, ``x`` radians.

    Of backward Euler and BDF2 nothing (Hairer & Wanner 1996, V.6: G-stable).
    """
    if scheme.name not in ("hht", "generalised-alpha"):
        return 0.0
    A, state, energies = recursion(x, scheme), np.array([0.0, 1.0, 0.0]), [1.0]
    for _ in range(STEPS):
        state = A @ state
        energies.append(x**2 * state[0] ** 2 + state[1] ** 2)
    return (max(energies) - 1.0) / max(energies)


def recursion(x: float, scheme: Scheme) -> Array:
    """(3, 3)  u, h u', h^2 a of one step to the next; Chung & Hulbert 1993, eqs. 10 to 13."""
    (am, af), beta, gamma = scheme.alphas, scheme.beta, scheme.gamma
    left = np.array([[1, 0, -beta], [0, 1, -gamma], [(1 - af) * x**2, 0, 1 - am]])
    right = np.array([[1, 1, 0.5 - beta], [0, 1, 1 - gamma], [-af * x**2, 0, -am]])
    return np.linalg.solve(left, right)


def radius(x: float, scheme: Scheme) -> float:
    """Spectral radius of a scheme at steps of ``x`` radians."""
    if scheme.name == "backward-euler":
        return float(1.0 / np.hypot(1.0, x))
    if scheme.name == "bdf2":
        return float(np.abs(np.roots([1.5 - 1j * x, -2.0, 0.5])).max())
    return float(np.abs(np.linalg.eigvals(recursion(x, scheme))).max())


ORDER = {"hht": 3, "generalised-alpha": 3, "bdf2": 4, "backward-euler": 2}
"""Of the recursion that the positions obey."""


def measured(x: float, scheme: Scheme) -> float:
    """Spectral radius from the positions of a run: largest root of their recursion (Prony)."""
    order = ORDER[scheme.name]
    path = _moved(1.0, x**2 * MASS, scheme, 3 * order + 4)
    u = path.q[2:, 0] - path.q[0, 0]
    rows = np.lib.stride_tricks.sliding_window_view(u, order + 1)
    sizes = np.linalg.norm(rows, axis=1, keepdims=True)
    rows = rows / sizes
    weights = np.linalg.lstsq(rows[:, :-1], rows[:, -1])[0]
    return float(np.abs(np.roots(np.append(1.0, -weights[::-1]))).max())


def _radii() -> Picture:
    """Theory as lines, runs as marks."""
    x, curves = np.logspace(-2, 4, 121), []
    for name, colour in zip(SCHEMES, ("C0", "C1", "C2", "C3"), strict=True):
        scheme = Scheme(name=name)
        curves.append(Curve(f"{name}, theory", x, [radius(v, scheme) for v in x], f"{colour}-"))
        values = [measured(v, scheme) for v in FITTED]
        curves.append(Curve(f"{name}, run", FITTED, values, f"{colour}o"))
    return Picture("step [radians of the oscillator]", "spectral radius [-]", curves, "x")


# ------------------------------------------------------------------------------------------ beam


class Way(NamedTuple):
    """How the beam is followed; ``tolerance`` [-] of the local error, inf: equal steps."""

    scheme: Scheme
    tolerance: float = np.inf

    @property
    def name(self) -> str:
        if np.isfinite(self.tolerance):
            return f"{self.scheme.name}, local error {self.tolerance:g}"
        return f"{self.scheme.name}, {self.scheme.constraints}"


WAYS = (
    *(Way(Scheme(name=name)) for name in SCHEMES),
    Way(Scheme(constraints="projected")),
    Way(Scheme(constraints="baumgarte")),
    Way(Scheme(), 1e-5),
)
DRAWN = (0, 1, 2, 3, 6)


def beams(
    ways: Sequence[Way] = WAYS,
    lengths: Sequence[float] = BEAM_LENGTHS,
    moduli: Sequence[float] = MODULI,
) -> Result:
    """A beam that spins on a hinge, unstretched at the start."""
    rows, pictures = list[Row](), []
    notes = [
        f"beam of 1 m, 20 x 10 mm, on a hinge, spins at {SPIN:g} rad/s, {BEAM_STEPS} equal steps "
        f"(with control of the local error: no longer steps, to {LONGEST:g} s at most)",
        f"grows: more than {ALLOWED:g} of the most stored energy gained, though a run was done",
    ]
    for k, way in enumerate(ways):
        spots = [beam(h, E, way) for h, E in product(lengths, moduli)]
        found = counted(spots)
        rows.append((way.name, len(spots), found[DONE], found[REFUSED], found[GROWS],
                     largest(spots), longest(spots)))  # fmt: skip
        notes += [f"{way.name}: {text}" for text in reasons(spots)]
        if k in DRAWN:
            pictures.append(_map(way, spots))
    columns = ("scheme", "runs", "done", "stopped", "grows", "energy gained [-]",
               "all done up to a turn per step of [rad]")  # fmt: skip
    return Result("stability_beam", "Beam that spins: step length and stiffness", columns, rows,
                  notes, pictures)  # fmt: skip


def beam(h: float, E: float, way: Way) -> Spot:
    """A run with steps of ``h`` [s], or controlled ones, and Young's modulus ``E`` [Pa]."""
    bar = replace(
        straight(1.0, 2, rectangle(0.01, 0.02), elastic(E, 0.3, 2700.0)), spin=SPIN * Z
    )  # fmt: skip
    made = model(bar, [Revolute("hinge", Site("beam", 0), Site(None), Z)])
    fixed = way.tolerance == np.inf
    smallest, end = (h, BEAM_STEPS * h) if fixed else (1e-6 * h, min(BEAM_STEPS * h, LONGEST))
    path = travel(made, end, Control(way.tolerance, h, smallest, way.scheme))
    gained = max(path.gained, 0.0)
    if path.why:
        return Spot(h, E, REFUSED, gained, path.why)
    return Spot(h, E, DONE if gained <= ALLOWED else GROWS, gained)


def longest(spots: Sequence[Spot]) -> float:
    """Largest turn per step [rad] up to which every run is done."""
    bad = min((s.x for s in spots if s.outcome != DONE), default=np.inf)
    return SPIN * max((s.x for s in spots if s.x < bad), default=0.0)


def _map(way: Way, spots: Sequence[Spot]) -> Map:
    moduli = np.array(sorted({s.y for s in spots}))
    # first bending frequency of a free beam on a hinge: 15.418 sqrt(EI/(rho A L^4))
    omega = 15.418 * np.sqrt(moduli * 0.01**2 / 12.0 / 2700.0)
    curves = [Curve("a radian of turn", 0.0 * moduli + 1.0 / SPIN, moduli, "--"),
              Curve("a radian of bending", 1.0 / omega, moduli, ":")]  # fmt: skip
    return Map(way.name, "step [s]", "E [Pa]", "energy gained [-]", spots, curves,
               limits=(1e-12, 1e-2))  # fmt: skip
