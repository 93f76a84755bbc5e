"""Pictures of a hinge with play that turns and warms: stages of its turn, stick and slip in it."""

import tomllib
from math import inf
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from coupling.contact_pictures import (
    REGIME_COLORS,
    REGIMES,
    flat_orbit,
    regime_shares,
    round_contacts,
)
from coupling.contact_places import peak_force
from coupling.pictures import heading, scaled
from coupling.reading import Results

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

STAGES = (0.0, 0.05, 0.7, 1.0)
"""Parts of a run after which a turn is shown."""
LEAST_TURN = np.radians(5.0)
"""For a picture of its stages [rad]."""
LEAST_CHANGE = 1e-4
"""Of the clearance by heat, for a picture of stick and slip over it [-]."""
STICK, SLIP = 3, 2
BINS = 600
MOST_CHANGES = 3000
CHANGE = "#8e44ad"
"""Colour of transitions."""


class Stage(NamedTuple):
    """A hinge at one time.

    time : float [s];  frame : of the recorded ones
    angle, rate : float [rad], [rad/s]  turn of the journal in its bearing since the start
    state : what it does for most of the coupling window, such as "slip"
    latch : "", "unlocked" or "locked"
    """

    time: float
    frame: int
    angle: float
    rate: float
    state: str
    latch: str


# ------------------------------------------------------------------------ stages of a turn


def turn(results: Results, joint: str) -> Array:
    """(f,) float [rad]  turn of the journal's section about the axis of the joint since the first
    frame; zeros where it is not known."""
    known = results.attributes(f"joints/{_contact(results, joint)}")
    path = f"bodies/{known.get('journal_body', '')}/axes"
    if path not in results or "axis" not in known:
        return np.zeros(len(results["frames/time"]))
    axis = known["axis"] / np.linalg.norm(known["axis"])
    triads = results[path][:, int(known["journal_node"])]
    k = int(np.argmin(np.abs(triads[0] @ axis)))  # the direction that the turn moves most
    moved = triads[:, k] - np.outer(triads[:, k] @ axis, axis)
    first = np.broadcast_to(moved[0], moved.shape)
    sine = np.sum(np.cross(first, moved) * axis, axis=1)
    return np.unwrap(np.arctan2(sine, np.sum(first * moved, axis=1)))


def stage(results: Results, joint: str, time: float) -> Stage:
    """A hinge in the recorded frame nearest to a time [s]."""
    times, angles = results["frames/time"], turn(results, joint)
    frame = int(np.argmin(np.abs(times - time)))
    rate = float(np.gradient(angles, times)[frame]) if len(times) > 1 else 0.0
    return Stage(
        float(times[frame]),
        frame,
        float(angles[frame]),
        rate,
        _state(results, joint, times[frame]),
        _latch(results, joint, angles[: frame + 1]),
    )


def _contact(results: Results, joint: str) -> str:
    """The most loaded contact of a joint."""
    return max(round_contacts(results, joint), key=lambda name: peak_force(results, name))


def _state(results: Results, joint: str, time: float) -> str:
    windows = results["contacts/time"]
    at = min(int(np.searchsorted(windows, time - 1e-9)), len(windows) - 1)
    number = int(results.attributes(f"joints/{_contact(results, joint)}")["number"])
    return REGIMES[int(np.argmax(results["contacts/shares"][at, number]))]


def _latch(results: Results, joint: str, angles: Array) -> str:
    """Whether a latch of the joint has caught by the end of ``angles`` (k,) [rad]."""
    from coupling import quantities

    case = tomllib.loads(str(results.attributes().get("scene", "")))
    for table in case.get("joint", {}).values():
        if table.get("kind") == "latch" and table.get("joint") == joint:
            at = table["at"]
            place = quantities.read(at, quantities.ANGLE) if isinstance(at, str) else float(at)
            within = np.sign(place) * angles.max() >= abs(place) * (1.0 - 1e-6)
            return "locked" if within else "unlocked"
    return ""


def draw_stages(
    results: Results, figure: "Figure", joint: str, times: tuple[float, ...] = ()
) -> None:
    """The body that turns at four times, seen along the axis, with angle and state."""
    end = float(results["frames/time"][-1])
    shown = [stage(results, joint, t) for t in times or tuple(part * end for part in STAGES)]
    heading(results, figure, f"stages of the turn in {joint}")
    for ax, one, letter in zip(
        figure.subplots(1, len(shown), sharex=True, sharey=True), shown, "abcdef", strict=False
    ):
        _draw_stage(ax, results, joint, one)
        ax.set_title(f"({letter}) {_words(one)}", fontsize=11)


def _draw_stage(ax: "Axes", results: Results, joint: str, one: Stage) -> None:
    known = results.attributes(f"joints/{_contact(results, joint)}")
    body, axis = str(known["journal_body"]), known["axis"] / np.linalg.norm(known["axis"])
    points = results[f"bodies/{body}/position"]
    across = points[0, -1] - points[0, 0]
    across = across - (across @ axis) * axis
    basis = np.stack([across / np.linalg.norm(across), np.cross(axis, across)])
    basis[1] /= np.linalg.norm(basis[1])
    flat = (points - points[0, int(known["journal_node"])]) @ basis.T
    ax.plot(*flat[0].T, color="#9aa5b1", lw=1.0, ls="--")
    ax.plot(*flat[one.frame].T, color="#c0392b", lw=3.0, solid_capstyle="round")
    ax.plot(0.0, 0.0, "o", color="#1f2933", ms=7)
    reach = float(np.abs(flat).max())
    ax.set_xlim(-0.15 * reach, 1.1 * reach)
    low, high = float(flat[..., 1].min()), float(flat[..., 1].max())
    ax.set_ylim(low - 0.12 * reach, high + 0.12 * reach)
    ax.set_aspect("equal")
    ax.set_xlabel("[m]")


def _words(one: Stage) -> str:
    lines = [
        f"{one.time:.2f} s",
        f"{np.degrees(one.angle):.2f}°, {np.degrees(one.rate):.3f} °/s",
        one.state + (f", {one.latch}" if one.latch else ""),
    ]
    return "\n".join(lines).replace("-", "\N{MINUS SIGN}")


def has_stages(results: Results, joint: str) -> bool:
    """Whether the joint turns far enough."""
    known = all(path in results for path in ("contacts/shares", "frames/time"))
    if not known or not round_contacts(results, joint):
        return False
    return bool(np.ptp(turn(results, joint)) > LEAST_TURN)


# ------------------------------------------------------------- stick and slip in a warm joint


class Course(NamedTuple):
    """A contact over time.

    time : (k,) float [s];  opened : (k,) float [m]  change of the clearance by heat
    across : (k,) float [m]  place of the journal along its largest motion
    regime : (k,)  codes
    """

    time: Array
    opened: Array
    across: Array
    regime: Array

    def transitions(self) -> NDArray[np.intp]:
        """Rows at which stick follows slip or slip stick, with nothing between but flight."""
        touching = np.flatnonzero((self.regime == STICK) | (self.regime == SLIP))
        changed = np.diff(self.regime[touching]) != 0
        return touching[1:][changed]

    def share(self, regime: int) -> float:
        """Part of the time [-]."""
        whole = np.array([self.time[0], self.time[-1]])
        return float(regime_shares(self.time, self.regime, whole)[0, regime])


def course(results: Results, joint: str, end: float = inf) -> Course:
    """The most loaded contact of a joint up to a time [s]."""
    contact = _contact(results, joint)
    table, _ = flat_orbit(results, contact)
    rows = table["time"] <= end
    reference = float(results.attributes(f"joints/{contact}")["reference_clearance"])
    orbit = table["orbit"][rows]
    _, _, directions = np.linalg.svd(orbit - orbit.mean(axis=0), full_matrices=False)
    main = directions[0] * np.sign(directions[0][np.argmax(np.abs(directions[0]))])
    return Course(
        table["time"][rows], table["clearance"][rows] - reference, orbit @ main,
        table["regime"][rows],
    )  # fmt: skip


def is_warm(results: Results, joint: str) -> bool:
    """Whether heat changes the clearance of a joint that sticks or slips."""
    if not round_contacts(results, joint):
        return False
    if "reference_clearance" not in results.attributes(f"joints/{_contact(results, joint)}"):
        return False
    table = results.table(f"joints/{_contact(results, joint)}")
    changes = float(np.ptp(table["clearance"])) > LEAST_CHANGE * float(table["clearance"][0])
    return changes and bool(np.isin(table["regime"], (STICK, SLIP)).any())


def draw_stick_slip(results: Results, figure: "Figure", joint: str, end: float = inf) -> None:
    """Thermal change of the clearance, and the journal across it, over shades of stick and slip."""
    found = course(results, joint, end)
    at = found.transitions()
    heading(results, figure, f"stick and slip in {joint} while it warms")
    axes = figure.subplots(2, 1, sharex=True)
    panels = (
        (found.opened, "change of the clearance by heat"),
        (found.across, "journal in its bearing, along its largest motion"),
    )
    for ax, (values, title) in zip(axes, panels, strict=True):
        _shade(ax, found)
        factor, unit = scaled(values, "m")
        ax.plot(found.time, factor * values, color="black", lw=0.9)
        some = at[:: max(1, -(-len(at) // MOST_CHANGES))]
        ax.plot(found.time[some], factor * values[some], "D", color=CHANGE, ms=2.5, mew=0)
        ax.set_ylabel(f"[{unit}]")
        ax.set_title(title)
    axes[-1].set_xlabel("time [s]")
    axes[-1].set_xlim(found.time[0], found.time[-1])
    figure.legend(handles=_handles(found, len(at)), loc="outside lower center", ncols=3)


def _shade(ax: "Axes", found: Course) -> None:
    """The more frequent of stick and slip in each of many short times."""
    edges = np.linspace(found.time[0], found.time[-1], BINS + 1)
    shares = regime_shares(found.time, found.regime, edges)
    for code in (SLIP, STICK):
        other = SLIP + STICK - code
        here = (shares[:, code] > 0.0) & (shares[:, code] >= shares[:, other])
        ax.fill_between(
            edges, 0.0, 1.0, where=np.append(here, here[-1]), step="post", lw=0,
            transform=ax.get_xaxis_transform(), color=REGIME_COLORS[code], alpha=0.35,
        )  # fmt: skip
    ax.grid(False)


def _handles(found: Course, transitions: int) -> list[object]:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    shades = [
        Patch(
            color=REGIME_COLORS[code], alpha=0.35, lw=0,
            label=f"{REGIMES[code]}, {100.0 * found.share(code):.0f} % of the time",
        )
        for code in (SLIP, STICK)
    ]  # fmt: skip
    marks = Line2D([], [], ls="", marker="D", color=CHANGE, label=f"{transitions} transitions")
    return [*shades, marks]
