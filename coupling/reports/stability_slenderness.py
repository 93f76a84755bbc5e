"""Slenderness: a cantilever from stout to a hair, in every element that can be one.

Deflection under a force at the end against Timoshenko's; roll-up into half a circle under a moment
against that circle (of a shell with its stretch); first frequency; and the deflection half a period
after a force has come suddenly, against the series of modes of the Euler beam: from a length of 20
heights on, as shorter ones bend by shear and are not measured by it.
"""

from collections.abc import Callable, Iterator, Sequence
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from coupling.reports.maps import DONE, REFUSED, WRONG, Spot, counted, reasons
from coupling.reports.registry import Curve, Picture, Result, Row
from coupling.reports.travel import travel
from coupling.verify.models import ROOM, Model, clamp, elastic, model, sections, straight
from mechanics.description import Description, Fixing, Force, Moment, Shell, Site
from mechanics.dynamics import Control
from mechanics.modes import modes
from mechanics.statics import equilibrium
from mechanics.system import System
from meshes import surfaces
from meshes.sections import rectangle

Array = NDArray[np.float64]
X, Y, Z = np.eye(3)

SLENDERNESSES = (5.0, 20.0, 1e2, 1e3, 1e4, 1e5, 1e6)
E, NU, DENSITY = 70e9, 0.3, 2700.0
ELEMENTS = {"beam3243": 8, "beam3333": 8, "shell48": 8}
"""Elements along the length, by family."""
RIGHT = 2e-2
"""Error that counts as right [-]; what is larger is counted as wrong."""
SMALL = 1e-3
"""Deflection of the end of what bends little [L]."""
EULER_FROM = 20.0
ROOTS = np.array([1.87510407, 4.69409113, 7.85475744, 10.99554073, 14.13716839])
"""cos x cosh x = -1; Rao 2007, table 8.4."""


class Found(NamedTuple):
    """Delivered over expected, or the reason why there is nothing."""

    ratio: float
    why: str = ""


def report() -> Iterator[Result]:
    """All families, all questions."""
    yield slenderness()


def slenderness(
    families: Sequence[str] = tuple(ELEMENTS), ratios: Sequence[float] = SLENDERNESSES
) -> Result:
    """Errors over length by height."""
    rows, curves = list[Row](), list[Curve]()
    every = list[Spot]()
    for family, question in product(families, QUESTIONS):
        if (family, question) in LEFT_OUT:
            continue
        least = EULER_FROM if question == "suddenly loaded" else 0.0
        spots = [asked(question, family, r) for r in ratios if r >= least]
        every += spots
        found = counted(spots)
        errors = [s.value for s in spots]
        rows.append((family, question, len(spots), found[DONE], found[REFUSED], found[WRONG],
                     max([e for e in errors if np.isfinite(e)], default=float("nan")),
                     "; ".join(reasons(spots))))  # fmt: skip
        curves.append(
            Curve(f"{family}, {question}", [s.x for s in spots], np.maximum(errors, 1e-9))
        )
    notes = [
        f"elements: {', '.join(f'{n} {name}' for name, n in ELEMENTS.items())}; wrong: off by more "
        f"than {RIGHT:g}",
        "bends: end force, against Timoshenko; rolls: end moment, to half a circle; frequency: the "
        "first, against Euler's less Timoshenko's part; suddenly loaded: after half a period",
        f"{sum(s.outcome == DONE for s in every)} of {len(every)} right, "
        f"{sum(s.outcome == REFUSED for s in every)} stopped with a reason",
    ]
    columns = ("element", "question", "runs", "done", "stopped", "wrong", "largest error [-]",
               "reasons")  # fmt: skip
    pictures = [_picture(curves, name) for name in families]
    return Result("stability_slenderness", "Slenderness", columns, rows, notes, pictures)


def _picture(curves: Sequence[Curve], family: str) -> Picture:
    own = [c for c in curves if c.label.startswith(family)]
    return Picture("length over height [-]", "error [-]", own)


def asked(question: str, family: str, ratio: float) -> Spot:
    """A family's answer at a slenderness."""
    found = QUESTIONS[question](family, ratio)
    if found.why:
        return Spot(ratio, 0.0, REFUSED, why=found.why)
    error = abs(found.ratio - 1.0)
    return Spot(ratio, 0.0, DONE if error <= RIGHT else WRONG, error)


# ------------------------------------------------------------------------------------- the strip


def _height(ratio: float) -> float:
    return 1.0 / ratio


def bending_stiffness(ratio: float) -> float:
    """EI [N m^2] of a square section; of the strip of shell a tenth as wide as long: see below."""
    return E * _height(ratio) ** 4 / 12.0


def beam(family: str, ratio: float, loads: Sequence[Force | Moment] = ()) -> Model:
    """A square cantilever of 1 m."""
    h = _height(ratio)
    bar = straight(1.0, ELEMENTS[family], rectangle(h, h), elastic(E, NU, DENSITY), family)
    return model(bar, [clamp()], loads)


WIDTH = 0.1
"""Of the strip of shell [m]: Poisson's ratio 0, so that it bends as a beam."""


def strip(ratio: float, size: float, moment: bool) -> Model:
    """A strip of shell, clamped, with a force or a moment at its end (in ``size``)."""
    n = ELEMENTS["shell48"]
    surface = surfaces.plate(1.0, WIDTH, n, 1)
    grid = np.arange(len(surface.points)).reshape(n + 1, 2)
    held = [(int(node), v) for node in grid[0] for v in ("position", "r_v")]
    joints = [Fixing(f"{v} {node}", "shell", node, v, np.eye(3)) for node, v in held]
    joints += [Fixing(f"{v} {node}", "shell", int(node), v, Z[None])
               for node in grid[0] for v in ("r_u", "r_uv")]  # fmt: skip
    joints += [Fixing(f"end {node}", "shell", int(node), "r_uv", np.eye(3)) for node in grid[-1]]
    half = _half(size)
    loads = [
        Moment(f"m{k}", Site("shell", int(k)), -Y, half) if moment
        else Force(f"f{k}", Site("shell", int(k)), Z, half)
        for k in grid[-1]
    ]  # fmt: skip
    shell = Shell("shell", surface, _height(ratio), elastic(E, 0.0, DENSITY), ROOM)
    system = System(Description([shell], joints, loads))
    return Model(system, system.coefficients(sections(system)))


def _half(size: float) -> Callable[[float], float]:
    return lambda s: 0.5 * size * s


def strip_stiffness(ratio: float) -> float:
    """EI [N m^2] of the strip."""
    return E * WIDTH * _height(ratio) ** 3 / 12.0


def end_of(made: Model, q: Array, family: str) -> Array:
    """(3,) [m] position of the end."""
    name = "shell" if family.startswith("shell") else "beam"
    nodes = len(made.system.layout.node_dofs[name])
    return made.position(q, name, nodes - 1)


# ----------------------------------------------------------------------------------- the questions


def bends(family: str, ratio: float) -> Found:
    """Deflection under a force that bends it by ``SMALL``; P L^3/3EI + P L/kGA."""
    if family == "shell48":
        P = 3.0 * strip_stiffness(ratio) * SMALL
        made, across, expected = strip(ratio, P, False), 2, SMALL
    else:
        P = 3.0 * bending_stiffness(ratio) * SMALL
        bar = rectangle(_height(ratio), _height(ratio))
        made = beam(family, ratio, [_force(ELEMENTS[family], P)])
        across = 1
        expected = SMALL + P / (E / (2.0 + 2.0 * NU) * bar.shear_factor_2 * bar.area)
    found = equilibrium(made.system, made.coef, made.coef, 1)
    if found.why:
        return Found(float("nan"), found.why)
    return Found(float(end_of(made, found.q, family)[across]) / expected)


def _force(node: int, size: float) -> Force:
    return Force("push", Site("beam", node), Y, lambda s: size * s)


def rolls(family: str, ratio: float) -> Found:
    """Half a circle under pi EI/L: the end comes to 2 L/pi across."""
    expected = 2.0 / np.pi
    if family == "shell48":
        made, across = strip(ratio, np.pi * strip_stiffness(ratio), True), 2
        expected = rolled(_height(ratio))
    else:
        size = np.pi * bending_stiffness(ratio)
        turn = Moment("turn", Site("beam", ELEMENTS[family]), Z, lambda s: size * s)
        made, across = beam(family, ratio, [turn]), 1
    found = equilibrium(made.system, made.coef, made.coef, 5)
    if found.why:
        return Found(float("nan"), found.why)
    return Found(float(end_of(made, found.q, family)[across]) / expected)


def rolled(h: float) -> float:
    """Place across [m] of the end of a strip ``h`` high of unit length under pi EI.

    Of the energy EA/8 (s^2 - 1)^2 + EI/2 (s theta')^2: s^2 = 1 - h^2 theta'^2/6, s^2 theta' = pi.
    """
    turn = brentq(lambda x: (1.0 - (h * x) ** 2 / 6.0) * x - np.pi, np.pi, np.sqrt(2.0) / h)
    return float(np.sqrt(1.0 - (h * turn) ** 2 / 6.0) * (1.0 - np.cos(turn)) / turn)


def frequency(family: str, ratio: float) -> Found:
    """The first one; shear and rotatory inertia take off (x^2 r^2/2)(1 + E/kG), Timoshenko 1937."""
    made = beam(family, ratio)
    found = modes(made.system, made.system.layout.q0, np.zeros(made.system.m), made.coef, 2)
    bar = rectangle(_height(ratio), _height(ratio))
    omega = ROOTS[0] ** 2 * np.sqrt(bending_stiffness(ratio) / (DENSITY * bar.area))
    gyration = bar.second_moment_2 / bar.area
    # of a cantilever: Rayleigh's quotients of shear and of rotation in the first mode
    omega /= np.sqrt(1.0 + gyration * (4.648 + 4.648 * 2.6 / bar.shear_factor_2))
    return Found(float(found.frequencies[0]) * 2.0 * np.pi / float(omega))


def suddenly(family: str, ratio: float) -> Found:
    """A force that is there at once, half a period of the first mode later."""
    EI, area = bending_stiffness(ratio), _height(ratio) ** 2
    P = 3.0 * EI * SMALL
    push = Force("push", Site("beam", ELEMENTS[family]), Y, lambda t: P)
    omegas = ROOTS**2 * np.sqrt(EI / (DENSITY * area))
    end = np.pi / omegas[0]
    # u = sum 4 P/(m L w^2) (1 - cos w t): all modes of a cantilever are 2 at the end
    parts = 4.0 * P / (DENSITY * area * omegas**2)
    expected = float((parts * (1.0 - np.cos(omegas * end))).sum())
    made = beam(family, ratio, [push])
    path = travel(made, end, Control(1e-6, 0.01 * end, 1e-9 * end))
    if path.why:
        return Found(float("nan"), path.why)
    return Found(float(end_of(made, path.q[-1], family)[1]) / expected)


QUESTIONS: dict[str, Callable[[str, float], Found]] = {
    "bends": bends,
    "rolls": rolls,
    "frequency": frequency,
    "suddenly loaded": suddenly,
}
LEFT_OUT = (("shell48", "frequency"), ("shell48", "suddenly loaded"))
"""Asked of beams only."""
