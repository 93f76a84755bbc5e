"""Amplitude over frequency of a payload that shakes an elastic arm through a joint with clearance.

The question is that of Hua et al. (2026), sec. 4.1.3 and Fig. 12, whose masses, stiffnesses,
damping and loads are not printed: the kinds of joints, the clearances and the range of frequencies
are, and a resonance near 10 rad/s. The rest is assumed, in round numbers, and fitted to nothing.

A payload of nearly 1 kg is joined to the end of an arm of 100 N/m, along whose direction it moves,
and shaken by a harmonic force. The describing function of the gap (Gelb & Vander Velde 1968, dead
zone), which knows neither impacts nor the end of the arm, is the independent check; Dubowsky &
Freudenstein (1971) give the model of two masses with a gap between.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import asin, cos, pi, sqrt

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from coupling.reports.maps import DONE, Map, Spot
from coupling.reports.registry import Curve, Picture, Result
from coupling.verify.mechanisms import mechanism
from coupling.verify.models import ROOM, Model, elastic
from mechanics.description import (
    ClearanceRevolute,
    ClearanceSpherical,
    ClearanceTranslational,
    Force,
    Guide,
    Joint,
    NormalContact,
    Prismatic,
    RigidBody,
    Site,
    Spring,
)
from mechanics.dynamics import Control, State, Window, advance, initial_state
from mechanics.march import Rows

Array = NDArray[np.float64]
Known = dict[tuple[str, float], Array]
"""Amplitudes by kind of joint and clearance [m]."""

KINDS = ("spherical", "revolute", "translational")
CLEARANCES = (0.02e-3, 0.04e-3, 0.08e-3, 0.10e-3)
"""Radial, or to each wall [m] (Hua et al. 2026, Fig. 12)."""
MASS, STIFFNESS, DAMPING = 1.0, 100.0, 2.0
"""Of payload and end of the arm [kg], arm [N/m], between payload and ground [N s/m]: 10 rad/s, and
five times the static deflection at resonance without clearance."""
END_MASS, END_DAMPING = 0.01, 0.1
"""Of the end of the arm [kg], within the arm [N s/m]."""
FORCE = 0.01
"""Amplitude [N]: the arm yields by 0.1 mm, the largest of the clearances."""
RADIUS, LENGTH, CORNER, SIZE = 10e-3, 20e-3, 2e-3, 40e-3
"""Of pin and ball, of the bore, of rounded corners, of the slider [m]."""
RESTITUTION = 0.85
"""Of the impacts (Hua et al. 2026, Table 2)."""
ARM = 0.1
"""Length [m] over which a clearance is an angle (reading): 0.2 mrad, the least of Fig. 12 d, is
then 0.02 mm, the least of Fig. 12 a-c."""
ANGLES = (0.2e-3, 0.4e-3, 0.6e-3, 0.8e-3, 1.0e-3, 1.4e-3, 1.7e-3, 2.0e-3)
"""Clearances of the map [rad] (Hua et al. 2026, Fig. 12 d)."""
MAPPED = "revolute"
LARGE = 2.0
"""Amplitude over the static deflection from which a response is called large [-]."""
FREQUENCIES = (1.0, 4.0, 6.0, 7.0, 7.5, 8.0, 8.5, 9.0, 9.5, 10.0, 10.5, 12.0, 15.0, 25.0, 60.0)
"""Of the sweep, upwards [rad/s]."""
SETTLING, MEASURED = 5.0, 4
"""Time of settling at each frequency, or eight cycles if that is longer [s]; cycles after it."""
TOLERANCE, PARTS = 1e-4, 100
"""Local error [-]; steps in a cycle at least."""

STEEL = elastic(207e9, 0.3)
X, Y, Z = np.eye(3)


def report() -> Iterator[Result]:
    """Amplitudes of the three kinds of joints with four clearances each, then a map of one."""
    known: Known = {}
    yield kinds_of(known)
    yield map_of(known)


def _swept(known: Known, kind: str, clearance: float) -> Array:
    """Amplitudes of ``sweep``, each of them once."""
    key = kind, round(clearance, 9)
    if key not in known:
        known[key] = sweep(kind, clearance)
    return known[key]


def kinds_of(known: Known) -> Result:
    """Peaks of the three kinds of joints with four clearances each; takes what is ``known``."""
    rows, pictures = [], []
    for kind in KINDS:
        curves = []
        for c in CLEARANCES:
            found = _swept(known, kind, c)
            curves.append(Curve(f"{1e3 * c:.2f} mm", FREQUENCIES, found.tolist()))
            rows.append((kind, 1e3 * c, *peak(found), *expected_peak(c)))
        pictures.append(Picture("", f"{kind}: amplitude [-]", [*curves, *_expected()], ""))
    pictures[-1] = pictures[-1]._replace(x="excitation frequency [rad/s]")
    columns = (
        "joint", "clearance [mm]", "peak amplitude / static deflection [-]", "at [rad/s]",
        "describing function, peak [-]", "describing function, at [rad/s]",
    )  # fmt: skip
    title = "Response amplitude over excitation frequency, joints with clearance"
    return Result("response_amplitude", title, columns, rows, _notes(rows), pictures)


def map_of(known: Known) -> Result:
    """Amplitudes over clearance, as an angle, and frequency."""
    rows, spots = [], []
    for angle in ANGLES:
        c = angle * ARM
        found = _swept(known, MAPPED, c)
        spots += [
            Spot(w, 1e3 * angle, DONE, a) for w, a in zip(FREQUENCIES, found.tolist(), strict=True)
        ]
        rows.append((1e3 * angle, 1e3 * c, *peak(found), *expected_peak(c), *large(found)))
    columns = (
        "clearance [mrad]", "clearance [mm]", "peak amplitude / static deflection [-]",
        "at [rad/s]", "describing function, peak [-]", "describing function, at [rad/s]",
        f"above {LARGE:g} from [rad/s]", f"above {LARGE:g} to [rad/s]",
    )  # fmt: skip
    ridge = [expected_peak(angle * ARM)[1] for angle in ANGLES]
    curve = Curve("peak of the describing function", ridge, [1e3 * a for a in ANGLES], "-")
    picture = Map(
        "", "excitation frequency [rad/s]", "clearance over arm length [mrad]",
        "amplitude / static deflection [-]", spots, [curve], "x", (0.3, 7.0),
    )  # fmt: skip
    title = "Response amplitude over clearance and excitation frequency, revolute joint"
    return Result("response_map", title, columns, rows, _map_notes(rows), [picture])


def large(amplitudes: Array) -> tuple[float, float]:
    """Least and largest frequency [rad/s] of amplitudes above ``LARGE``, linear between points."""
    w = np.linspace(FREQUENCIES[0], FREQUENCIES[-1], 20001)
    inside = w[np.interp(w, FREQUENCIES, amplitudes) >= LARGE]
    return (float(inside[0]), float(inside[-1])) if inside.size else (np.nan, np.nan)


# ------------------------------------------------------------------------------------- motion


@dataclass
class Drive:
    """FORCE cos(phase) whose frequency [rad/s] can change, while its phase does not jump."""

    frequency: float
    since: float = 0.0
    phase: float = 0.0

    def __call__(self, t: float) -> float:
        return FORCE * cos(self.phase + self.frequency * (t - self.since))

    def change(self, t: float, frequency: float) -> None:
        self.phase += self.frequency * (t - self.since)
        self.since, self.frequency = t, frequency


def shaken(kind: str, clearance: float, drive: Drive) -> Model:
    """Payload (journal) and end of the arm (bearing), both on the line x."""
    payload = RigidBody("payload", np.zeros(3), MASS - END_MASS, 1e-3 * np.eye(3))
    end = RigidBody("end", np.zeros(3), END_MASS, 1e-6 * np.eye(3))
    one, other, root = Site("payload"), Site("end"), Site(None, position=-X)
    joints: list[Joint] = [
        Prismatic("line", other, Site(None), X),
        Spring("arm", other, root, STIFFNESS, END_DAMPING),
        Spring("damper", one, root, 0.0, DAMPING),
        _loose(kind, clearance, one, other),
        Guide("way", one, np.array([Y])) if kind == "translational"
        else Prismatic("way", one, Site(None), X),
    ]  # fmt: skip
    return mechanism([payload, end], joints, [Force("drive", one, X, drive)])


def _loose(kind: str, c: float, journal: Site, bearing: Site) -> Joint:
    """The joint with clearance ``c``, whose walls or bore the payload meets along x."""
    rest = (STEEL, STEEL, ROOM)
    internal = NormalContact("hertz-internal", restitution=RESTITUTION)
    if kind == "spherical":
        return ClearanceSpherical("loose", journal, bearing, RADIUS, c, *rest, internal)
    if kind == "revolute":
        law = NormalContact("cylinder", restitution=RESTITUTION)
        return ClearanceRevolute(
            "loose", journal, bearing, Z, RADIUS, c, *rest, law, length=LENGTH
        )  # fmt: skip
    law = NormalContact("hertz-external", restitution=RESTITUTION)
    return ClearanceTranslational(
        "loose", journal, bearing, Y, X, SIZE, SIZE, c, *rest, law, corner_radius=CORNER
    )


def sweep(kind: str, clearance: float, frequencies: tuple[float, ...] = FREQUENCIES) -> Array:
    """Amplitudes (k,) over the static deflection: half of what the payload travels in a cycle."""
    drive = Drive(frequencies[0])
    made = shaken(kind, clearance, drive)
    state, why = initial_state(made.system, _control(frequencies[0]), made.coef)
    found = []
    for frequency in frequencies:
        if state is None or why:
            raise RuntimeError(why)
        drive.change(state.motion.t, frequency)
        cycle = 2.0 * pi / frequency
        state, _ = _during(made, state, max(SETTLING, 8.0 * cycle), frequency)
        state, way = _during(made, state, MEASURED * cycle, frequency)
        found.append(0.5 * np.ptp(way) * STIFFNESS / FORCE)
    return np.array(found)


def _control(frequency: float) -> Control:
    return Control(TOLERANCE, 2.0 * pi / frequency / PARTS, 1e-12)


def _during(made: Model, state: State, span: float, frequency: float) -> tuple[State, Array]:
    """The state after ``span`` [s], and the places (k,) [m] of the payload on the way."""
    kept: list[Rows] = []
    window = Window.between(made.system, state.motion.t, span, made.coef, None)
    control = _control(frequency)
    state, _, why = advance(made.system, control, state, window, kept.append, full=True)
    if why:
        raise RuntimeError(why)
    along = made.system.layout.node_dofs["payload"][0]
    return state, np.concatenate([rows.y[:, along] for rows in kept])


def peak(amplitudes: Array, frequencies: tuple[float, ...] = FREQUENCIES) -> tuple[float, float]:
    """Largest amplitude and its frequency, by the parabola through the three highest points."""
    k = int(np.clip(np.argmax(amplitudes), 1, len(amplitudes) - 2))
    near = slice(k - 1, k + 2)
    a, b, c = np.polyfit(np.array(frequencies[near]) - frequencies[k], amplitudes[near], 2)
    return float(c - b * b / (4.0 * a)), float(frequencies[k] - b / (2.0 * a))


# ------------------------------------------------------------------------- describing function


def stiffness_share(ratio: float) -> float:
    """Stiffness of a spring behind a gap c over its own, at amplitudes A = c/``ratio`` of a sine.

    The first harmonic of a dead zone: 1 - 2/pi (asin(c/A) + c/A sqrt(1 - (c/A)²)).
    """
    if ratio >= 1.0:
        return 0.0
    return 1.0 - 2.0 / pi * (asin(ratio) + ratio * sqrt(1.0 - ratio**2))


def response(amplitude: float, clearance: float) -> tuple[float, float] | None:
    """Frequencies [rad/s] at which the payload has the amplitude [m]; None if it never has it.

    (k - m w²)² + (d w)² = (F/A)² with the stiffness of that amplitude; 0 for one below zero.
    """
    k, d = STIFFNESS * stiffness_share(clearance / amplitude), DAMPING + END_DAMPING
    half = k / MASS - 0.5 * (d / MASS) ** 2
    rest = half**2 - (k**2 - (FORCE / amplitude) ** 2) / MASS**2
    if rest < 0.0:
        return None
    low, high = half - sqrt(rest), half + sqrt(rest)
    return sqrt(max(low, 0.0)), sqrt(max(high, 0.0))


def expected_peak(clearance: float) -> tuple[float, float]:
    """Largest amplitude over the static deflection, and its frequency [rad/s]."""
    d = (DAMPING + END_DAMPING) / MASS

    def beyond(amplitude: float) -> float:
        w2 = STIFFNESS * stiffness_share(clearance / amplitude) / MASS
        return w2 * d**2 - 0.25 * d**4 - (FORCE / amplitude / MASS) ** 2

    static = FORCE / STIFFNESS
    A = brentq(beyond, 2.0 * static + clearance, 100.0 * static)
    w2 = STIFFNESS * stiffness_share(clearance / A) / MASS - 0.5 * d**2
    return A / static, sqrt(w2)


def _expected() -> list[Curve]:
    """Curves of the describing function for the least and the largest clearance."""
    curves, static = [], FORCE / STIFFNESS
    for c, style in ((CLEARANCES[0], "k:"), (CLEARANCES[-1], "k--")):
        heights = np.linspace(0.02 * static, expected_peak(c)[0] * static, 2000)
        pairs = [(a / static, w) for a in heights if (w := response(a, c)) is not None]
        rising = [(w[0], a) for a, w in pairs if w[0] >= FREQUENCIES[0]]
        falling = [(w[1], a) for a, w in reversed(pairs) if w[1] <= FREQUENCIES[-1]]
        x, y = zip(*rising, *falling, strict=True)
        curves.append(Curve(f"{1e3 * c:.2f} mm, describing function", x, y, style))
    return curves


def moved_peak(clearance: float, base: float) -> float:
    """Largest amplitude over that of a ``base`` [m] that moves the root of the arm instead.

    X = B k/(k - m w² + i d w) at the resonance of the relative motion U = X - B, whose amplitude
    sets the stiffness.
    """
    d, best = DAMPING + END_DAMPING, 0.0
    for frequency in np.linspace(5.0, 11.0, 601):
        push = abs(complex(MASS * frequency**2, -d * frequency)) * base

        def lacking(U: float, w: float = frequency, push: float = push) -> float:
            k = STIFFNESS * stiffness_share(clearance / U)
            return U * abs(complex(k - MASS * w**2, d * w)) - push

        U = brentq(lacking, 1e-3 * base, 100.0 * base)
        k = STIFFNESS * stiffness_share(clearance / U)
        best = max(best, k / abs(complex(k - MASS * frequency**2, d * frequency)))
    return best


# ------------------------------------------------------------------------------------ in words


def _notes(rows: list[tuple]) -> list[str]:
    off = max(abs(row[2] / row[4] - 1.0) for row in rows)
    late = max(abs(row[3] - row[5]) for row in rows)
    least, largest = CLEARANCES[0], CLEARANCES[-1]
    base = FORCE / STIFFNESS
    return [
        *(_trend(kind, [row for row in rows if row[0] == kind]) for kind in KINDS),
        f"describing function: peaks within {100 * off:.1f} %, frequencies {late:.2f} rad/s; "
        "it leaves out the end of the arm, 10 g, which rings in the gap and loses energy there",
        "why: at amplitude A the arm acts with 1 - 2/pi (asin(c/A) + c/A sqrt(1 - c²/A²)) of its "
        "stiffness k; the resonance falls with c/A, and F/(d w) there rises",
        "that holds for a given force; where the root of the arm is moved by a given "
        f"{1e3 * base:g} mm instead, the describing function has peaks that fall, from "
        f"{moved_peak(least, base):.2f} to {moved_peak(largest, base):.2f} times it",
        "Hua et al. (2026) print peaks from 5.1 to 5.8 (spherical), 4.8 to 5.4 (revolute), 4.9 to "
        "5.1 (sliding), near 10 rad/s, falling in frequency, and none of masses, stiffnesses, "
        "damping, loads, measure of the amplitude",
        f"assumed: {MASS:g} kg, {STIFFNESS:g} N/m, {DAMPING:g} N s/m, {FORCE:g} N, pins of "
        f"{1e3 * RADIUS:g} mm of steel, restitution {RESTITUTION:g}, no friction, one direction: "
        "the kinds differ in their contact only, which is far stiffer than the arm",
    ]  # fmt: skip


def _map_notes(rows: list[tuple]) -> list[str]:
    off = max(abs(row[2] / row[4] - 1.0) for row in rows)
    first, last = rows[0], rows[-1]
    return [
        f"peaks from {first[2]:.2f} at {first[3]:.2f} rad/s to {last[2]:.2f} at {last[3]:.2f} rad/s"
        f"; describing function within {100 * off:.1f} %",
        f"above {LARGE:g} times the static deflection: {first[6]:.1f} to {first[7]:.1f} rad/s at "
        f"{first[0]:g} mrad, {last[6]:.1f} to {last[7]:.1f} rad/s at {last[0]:g} mrad; within the "
        "gap nothing holds the payload, and slow forces move it by the clearance besides",
        "Hua et al. (2026), Fig. 12 d, print amplitudes of 1.0 to 4.5, largest from 5 to 20 rad/s "
        "and 0.2 to 1.8 mrad; their Fig. 12 b has peaks of 4.8 to 5.4 within the same range of "
        "clearances",
        f"clearance as an angle: over {ARM:g} m (reading)",
    ]


def _trend(kind: str, rows: list[tuple]) -> str:
    """What amplitude and frequency of the peak do as the clearance grows."""
    parts = []
    for name, column, unit in (("peak", 2, ""), ("frequency", 3, " rad/s")):
        values = np.array([row[column] for row in rows])
        steps = np.diff(values)
        way = "rises" if (steps > 0).all() else "falls" if (steps < 0).all() else "goes up and down"
        parts.append(f"{name} {way} from {values[0]:.2f} to {values[-1]:.2f}{unit}")
    return f"{kind}: " + ", ".join(parts)
