"""Stability of the exchange over window and coupling strength.

First a linear pair: one temperature in surroundings, whose loss is answered by a motion that
releases less heat the warmer it is. Taken together it always settles; what the schemes of the
exchange do follows from small matrices, written down here, not taken from them. Then a journal
whose friction falls with temperature, in the solvers themselves.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import product
from math import exp, expm1
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.sparse import csr_array

from coupling.iteration import Iterated
from coupling.manager import SCHEMES, Pair, initial
from coupling.manager import Result as Exchanged
from coupling.reports.maps import DONE, GROWS, REFUSED, Map, Spot, counted, largest, reasons
from coupling.reports.registry import Curve, Result, Row
from coupling.transfer import Transfer
from coupling.verify.models import ROOM
from coupling.verify.sliding import RADIUS, RATE, STEEL, Sliding

Array = NDArray[np.float64]
Advance = Callable[..., Exchanged]

TIGHT, MOST = 1e-5, 200
"""Tolerances of the iterations, and most of them."""
ADVANCES: Mapping[str, Advance] = {
    "serial": SCHEMES["serial"],
    "parallel": SCHEMES["parallel"],
    "corrected": SCHEMES["corrected"],
    "iterated, none": Iterated(TIGHT, TIGHT, MOST, "none"),
    "iterated, half": Iterated(TIGHT, TIGHT, MOST, "relaxation", 0.5),
    "iterated, aitken": Iterated(TIGHT, TIGHT, MOST, "aitken"),
    "iterated, quasi-newton": Iterated(TIGHT, TIGHT, MOST),
}
OUTSIDE, AWAY = 300.0, 1.0
"""Temperature of the surroundings, and how far it begins from rest [K]."""
WINDOWS = tuple(10.0**e for e in np.arange(-2.0, 2.1, 0.5))
STRENGTHS = tuple(10.0**e for e in np.arange(-1.0, 4.1, 0.5))
COUNT = 60
BOUND = 1e12
"""What a deviation that grows is stopped at, in that of the start [-]."""
SETTLED = 1e-4
"""Deviation at which it has settled, in that of the start [-]."""
REMAINS = 0.05
"""Deviation in the last windows of a run with friction that counts as not settled [-]."""
NEAR = 0.06
"""Of a border, relative: what grows by less in a window may not show yet."""


def report() -> Iterator[Result]:
    """The linear pair, then friction."""
    yield linear()
    yield rubbing()


# -- a linear pair ------------------------------------------------------------------------------

REGIONS: Mapping[str, NDArray[np.intp]] = {"cup": np.arange(1)}


class _Cup:
    """T' = outside - T + heat/h, exactly: capacity 1 J/K, loss 1 W/K."""

    x, regions = np.zeros((1, 3)), REGIONS

    def initial(self) -> Array:
        return np.array([OUTSIDE + AWAY])

    def energy(self, T: Array) -> float:
        return float(T.sum())

    def steady(self, T: Array, t: float, outside: Any = None) -> tuple[Array, dict, str]:
        return np.array([OUTSIDE]), {}, ""

    def advance(
        self, T: Array, t: float, h: float, heat: Array, outside: Any = None
    ) -> tuple[Array, dict, str]:
        settled = OUTSIDE + heat / h
        end = settled + (T - settled) * exp(-h)
        return end, {"air": float((end - T - heat)[0])}, ""


class _Answer:
    """Motion that releases -strength x (T - outside) [W], T linear through the window."""

    x, axes, regions = np.zeros((1, 3)), np.zeros((1, 3, 3)), REGIONS

    def __init__(self, strength: float) -> None:
        self.strength = strength

    def initial(self, T: Array, rest: Array | None = None) -> float:
        return 0.0

    def advance(
        self, state: float, h: float, T0: Array, T1: Array, observe: Any = None
    ) -> tuple[float, Array, str]:
        mean = 0.5 * (T0[:, 0] + T1[:, 0]) - OUTSIDE
        return state + h, -self.strength * h * mean, ""


def answering(strength: float) -> Pair:
    """The pair whose temperature obeys T' = -(1 + strength) (T - outside)."""
    read = csr_array(np.array([[1.0], [0.0], [0.0]]))
    return Pair(_Cup(), _Answer(strength), Transfer(read, np.zeros((1, 3))))


def radius(scheme: str, h: float, strength: float) -> float:
    """What a window multiplies deviations by in the end [-]; infinite where iterations diverge.

    With e = exp(-h), b = 1 - e: heat makes T1 = e T + b Q/h, and motion Q/h = -S (T0 + T1)/2.
    """
    e, b, S = exp(-h), -expm1(-h), 0.5 * strength
    if scheme == "serial":  # T, Q/h of the last window
        matrix = [[e, b], [-S * (1.0 + e), -S * b]]
    elif scheme == "parallel":  # T, Q/h, T of the window before
        matrix = [[e, b, 0.0], [-3.0 * S, 0.0, S], [1.0, 0.0, 0.0]]
    elif scheme == "corrected":  # T, Q/h: the guess, then heat again
        matrix = [[e - b * S * (1.0 + e), -S * b * b], [-S * (1.0 + e), -S * b]]
    else:
        factor = iterates(scheme, h, strength)
        return float("inf") if factor >= 1.0 else abs((e - b * S) / (1.0 + b * S))
    return float(np.abs(np.linalg.eigvals(np.array(matrix))).max())


def iterates(scheme: str, h: float, strength: float) -> float:
    """What an iteration multiplies its error by [-]; 0: it ends, as secants of one unknown do."""
    feedback = 0.5 * strength * expm1(-h)  # dT/dT of one pass, negative
    if scheme == "iterated, none":
        return abs(feedback)
    return abs(0.5 + 0.5 * feedback) if scheme == "iterated, half" else 0.0


def linear(windows: Sequence[float] = WINDOWS, strengths: Sequence[float] = STRENGTHS) -> Result:
    """All schemes over windows in time constants of the loss, and strengths in the loss."""
    rows, maps = list[Row](), list[Map]()
    notes = [
        f"T' = -(1 + strength) (T - outside), in time constants of the loss; {COUNT} windows",
        "theory: spectral radius of a window's matrix, and of an iteration, below 1; within "
        f"{100 * NEAR:g} % of 1 it is not compared",
        "explicit schemes do not know that they diverge: what grows ends as a number, and with a "
        "reason only where the solvers refuse it",
    ]
    for scheme in ADVANCES:
        spots = [linear_spot(scheme, h, S) for h, S in product(windows, strengths)]
        found, differ = counted(spots), [s for s in spots if not agrees(scheme, s)]
        rows.append((scheme, len(spots), found[DONE], found[REFUSED], found[GROWS], len(differ),
                     len([s for s in spots if near(scheme, s)]), largest(spots)))  # fmt: skip
        notes += [f"{scheme}: {text}" for text in reasons(spots)]
        maps.append(Map(scheme, "window [time constants of the loss]", "strength [-]",
                        "left in the end [-]", spots, [border(scheme, windows, strengths)],
                        limits=(SETTLED, 1.0)))  # fmt: skip
    columns = ("scheme", "runs", "settles", "stopped", "grows", "against theory", "too near to it",
               "most left in the end [-]")  # fmt: skip
    return Result("stability_exchange", "Linear exchange: window and strength", columns, rows,
                  notes, maps)  # fmt: skip


def linear_spot(scheme: str, h: float, strength: float) -> Spot:
    """What becomes of a deviation."""
    left, why = _followed(ADVANCES[scheme], answering(strength), h, COUNT, OUTSIDE, AWAY)
    return _spot(h, strength, left, why, _further)


def _followed(
    advance: Advance, pair: Pair, h: float, count: int, rest: float, away: float
) -> tuple[Array, str]:
    """Deviations after each window, in that of the start; the reason why it stopped."""
    state, found = initial(pair), [1.0]
    for k in range(count):
        with np.errstate(over="ignore", invalid="ignore"):
            new, why = advance(pair, state, k * h, h, None)
        if new is None:
            return np.array(found), why
        state = new
        found.append(float(np.abs(state.T - rest).max()) / away)
        if not max(found[-3:]) > SETTLED or not found[-1] < BOUND:
            break
    return np.array(found), ""


def _spot(x: float, y: float, left: Array, why: str, grows: Callable[[Array], bool]) -> Spot:
    if why:
        return Spot(x, y, REFUSED, why=why)
    bad = left[-1] > SETTLED and (grows(left) or not left[-1] < BOUND)
    return Spot(x, y, GROWS if bad else DONE, max(float(left[-1]), SETTLED))


def _further(left: Array) -> bool:
    """Whether the second half goes further than the first."""
    half = max(2, len(left) // 2)
    return left[half:].max(initial=0.0) > left[1:half].max()


def _remains(left: Array) -> bool:
    """Whether it has not come down: friction cannot be negative, so that what would grow swings."""
    return left[-8:].max() > REMAINS


def agrees(scheme: str, spot: Spot) -> bool:
    """Whether a run did what theory says."""
    if near(scheme, spot):
        return True
    stable = radius(scheme, spot.x, spot.y) < 1.0
    refused = iterates(scheme, spot.x, spot.y) >= 1.0
    expected = REFUSED if refused else DONE if stable else GROWS
    return spot.outcome == expected


def near(scheme: str, spot: Spot) -> bool:
    """Too near to a border of theory for a run to tell."""
    factors = (radius(scheme, spot.x, spot.y), iterates(scheme, spot.x, spot.y))
    return any(abs(factor - 1.0) < NEAR for factor in factors)


def border(scheme: str, windows: Sequence[float], strengths: Sequence[float]) -> Curve:
    """Strength above which theory sees no stability, over windows."""
    low, high = 0.1 * min(strengths), 10.0 * max(strengths)

    def beyond(log_strength: float, h: float) -> float:
        value = radius(scheme, h, exp(log_strength))
        return min(value, 10.0) - 1.0

    h = np.logspace(np.log10(min(windows)), np.log10(max(windows)), 80)
    found = np.full(h.size, np.nan)
    for k, one in enumerate(h):
        if beyond(np.log(low), one) < 0.0 < beyond(np.log(high), one):
            found[k] = exp(brentq(beyond, np.log(low), np.log(high), args=(one,)))
    stable = bool(np.all(np.isnan(found)))
    return Curve("theory: stable everywhere" if stable else "theory", h, found)


# -- friction -----------------------------------------------------------------------------------

LOAD, COEFFICIENT, SLOPE = 2e3, 0.3, -5e-3
"""Of a journal [N], [-], [1/K]."""
POWER = COEFFICIENT * LOAD * RADIUS * RATE  # [W] at the start
LUMP = 2e-5  # [kg] of journal and bearing each
CAPACITY = 2.0 * LUMP * 500.0  # [J/K]
RUBBED = ("serial", "parallel", "corrected", "iterated, none", "iterated, quasi-newton")
RUBBING_WINDOWS = (0.1, 0.3, 1.0, 3.0)
RUBBING_STRENGTHS = (0.3, 1.0, 3.0, 10.0)
RUBBING_COUNT = 36


class Rest(NamedTuple):
    """A journal's conductance to surroundings [W/K], its time constant [s], its steady rise [K]."""

    outwards: float
    constant: float
    rise: float


def at_rest(strength: float) -> Rest:
    """Where friction that falls by ``strength`` of the loss with each kelvin comes to."""
    outwards = POWER * abs(SLOPE) / strength
    return Rest(outwards, CAPACITY / outwards, POWER / outwards / (1.0 + strength))


def journal(strength: float) -> Pair:
    """A steel journal in steel, so well joined that both have one temperature."""
    return Sliding((STEEL, STEEL), (LUMP, LUMP), COEFFICIENT, LOAD, SLOPE, 1.0,
                   at_rest(strength).outwards).build()  # fmt: skip


def rubbing(
    windows: Sequence[float] = RUBBING_WINDOWS, strengths: Sequence[float] = RUBBING_STRENGTHS
) -> Result:
    """Friction that falls with temperature, in the solvers."""
    rows, maps = list[Row](), list[Map]()
    notes = [
        f"journal in a bearing, mu falls by {abs(SLOPE):g} of it with each kelvin; strength: fall "
        f"of the friction's power over the conductance outwards; {RUBBING_COUNT} windows from "
        "surroundings' temperature on",
        "theory: as of the linear pair; grows: friction cannot become negative, so that what is "
        "unstable swings about the right temperature for ever, and nothing says so",
    ]
    for scheme in RUBBED:
        spots = [rubbing_spot(scheme, h, S) for h, S in product(windows, strengths)]
        found, differ = counted(spots), [s for s in spots if not agrees(scheme, s)]
        rows.append((scheme, len(spots), found[DONE], found[REFUSED], found[GROWS], len(differ),
                     largest(spots)))  # fmt: skip
        notes += [f"{scheme}: {text}" for text in reasons(spots)]
        maps.append(Map(scheme, "window [time constants of the loss]", "strength [-]",
                        "left in the end [-]", spots, [border(scheme, windows, strengths)],
                        limits=(SETTLED, 1.0)))  # fmt: skip
    columns = ("scheme", "runs", "settles", "stopped", "grows", "against theory",
               "most left in the end [-]")  # fmt: skip
    return Result("stability_friction", "Friction that falls with temperature: window and strength",
                  columns, rows, notes, maps)  # fmt: skip


def rubbing_spot(scheme: str, window: float, strength: float) -> Spot:
    """What becomes of the start's deviation from the steady temperature."""
    rest = at_rest(strength)
    left, why = _followed(
        ADVANCES[scheme], journal(strength), window * rest.constant, RUBBING_COUNT,
        ROOM + rest.rise, rest.rise,
    )  # fmt: skip
    return _spot(window, strength, left, why, _remains)
