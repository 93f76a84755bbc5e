"""The plane pictures of a run; each function fills one figure."""

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from coupling.clocks import clock_of
from coupling.reading import Results
from coupling.turning import Drive, chord_angle, departure, find_drive, outermost_probe

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

ROUND_OFF = 1e-12
"""Gradients below this part of the temperature, per metre, are drawn as none [1/m]."""
MOST_BODIES = 3
MOST_PROBES = 3
PREFIXES = {9: "G", 6: "M", 3: "k", 0: "", -3: "m", -6: "µ", -9: "n", -12: "p"}
UNSEEN = 1e-3  # of the largest displacement of a probe: components that are not drawn on a path
TRAJECTORY_COLORS = ("#0072B2", "#D55E00", "#009E73")


def scaled(values: Array, unit: str) -> tuple[float, str]:
    """Factor and prefixed unit in which the largest of ``values`` reads well."""
    finite = np.abs(values[np.isfinite(values)])
    largest = float(finite.max(initial=0.0))
    power = 3 * int(np.floor(np.log10(largest) / 3)) if largest > 0.0 else 0
    power = int(np.clip(power, min(PREFIXES), max(PREFIXES)))
    return 10.0**-power, PREFIXES[power] + unit


def heading(results: Results, figure: "Figure", text: str) -> None:
    """Title of the case and what the picture shows."""
    title = str(results.attributes().get("title", ""))
    text = f"{title}: {text}" if title else text
    size = fitting_size(text, 0.97 * figure.get_figwidth(), 13.0)
    figure.suptitle(text, x=0.01, ha="left", fontsize=size, weight="bold")


def fitting_size(text: str, width: float, largest: float) -> float:
    """Size [pt] in which a bold line of text is not wider than ``width`` [inch]."""
    em = 0.68 * max(len(text), 1)  # a letter of DejaVu Sans Bold is 0.68 em wide on average
    return min(largest, 72.0 * width / em)


# ---------------------------------------------------------------------------- temperature


def heated_bodies(results: Results) -> list[str]:
    """Lines that carry temperatures, the widest range of temperature first; a few of them."""
    ranges = {
        body: float(np.ptp(results[f"bodies/{body}/temperature"][..., 0]))
        for body in results.names("bodies")
        if f"bodies/{body}/temperature" in results
        and results[f"bodies/{body}/position"].shape[1] > 1
        and f"surfaces/{body}/quads" not in results
    }
    return sorted(ranges, key=lambda body: -ranges[body])[:MOST_BODIES]


def draw_temperature(results: Results, figure: "Figure") -> None:
    """Mean temperature and transverse gradient along the bodies over time."""
    bodies = heated_bodies(results)
    heading(results, figure, "temperature")
    axes = figure.subplots(len(bodies), 2, sharex=True, squeeze=False)
    time = results["frames/time"]
    for (left, right), body in zip(axes, bodies, strict=True):
        along = _arclength(results[f"bodies/{body}/position"][0])
        mean, g2, g3 = np.moveaxis(results[f"bodies/{body}/temperature"], -1, 0)
        _map(left, time, along, mean - 273.15, "inferno", "°C")
        gradient = np.hypot(g2, g3)
        gradient[gradient < ROUND_OFF * np.abs(mean).max()] = 0.0
        _map(right, time, along, gradient, "viridis", "K/m")
        left.set_title(f"{body}: mean of the section")
        right.set_title(f"{body}: transverse gradient")
        left.set_ylabel("along the body [m]")
    for ax in axes[-1]:
        ax.set_xlabel(clock_of(results).label)


def _map(ax: "Axes", time: Array, along: Array, values: Array, colors: str, unit: str) -> None:
    t, x, fine = _refined(time, along, values)
    image = ax.pcolormesh(t, x, fine.T, cmap=colors, shading="nearest", rasterized=True)
    bar = ax.figure.colorbar(image, ax=ax, pad=0.02, aspect=30)
    bar.set_label(f"[{unit}]")
    bar.outline.set_visible(False)
    if np.ptp(values) > 1e-9 * np.abs(values).max():
        levels = bar.get_ticks()
        ax.contour(t, x, fine.T, levels=levels, colors="white", linewidths=0.8, alpha=0.7)
    ax.grid(False)


def _refined(time: Array, along: Array, values: Array) -> tuple[Array, Array, Array]:
    """Values (f, n) linear in between, on a grid fine enough for a picture."""
    t, x = np.linspace(time[0], time[-1], 400), np.linspace(along[0], along[-1], 300)
    rows = np.array([np.interp(x, along, row) for row in values])
    return t, x, np.array([np.interp(t, time, column) for column in rows.T]).T


def _arclength(points: Array) -> Array:
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])


# --------------------------------------------------------------------------------- motion


def moving_probes(results: Results) -> list[str]:
    """The first few probes that saw a motion."""
    seen = [p for p in results.names("probes") if f"probes/{p}/position" in results]
    moved = [p for p in seen if len(results[f"probes/{p}/position"]) > 1]
    return moved[:MOST_PROBES]


def motion_rows(results: Results) -> int:
    """Number of panels that ``draw_motion`` makes."""
    return len(moving_probes(results)) + (3 if find_drive(results) else 0)


def draw_motion(results: Results, figure: "Figure") -> None:
    """Displacement of the probes; with a driven hinge also the departure from a rigid turn."""
    probes, drive = moving_probes(results), find_drive(results)
    heading(results, figure, "motion")
    axes = figure.subplots(motion_rows(results), 1, sharex=True, squeeze=False)[:, 0]
    for ax, probe in zip(axes, probes, strict=False):
        table = results.table(f"probes/{probe}")
        _components(ax, table["time"], table["position"] - table["position"][0], ("x", "y", "z"))
        ax.set_title(f"{probe}: displacement")
    if drive:
        _draw_turn(results, axes[-3:], drive)
    axes[-1].set_xlabel(clock_of(results).label)
    figure.align_ylabels(axes)


def _draw_turn(results: Results, axes: "NDArray[Any]", drive: Drive) -> None:
    probe = outermost_probe(results, drive)
    table = results.table(f"probes/{probe}")
    away = departure(table["time"], table["position"], drive)
    _components(axes[0], table["time"], away, ("outward", "ahead", "along axis"))
    axes[0].set_title(f"{probe}: departure from the demanded rigid turn")
    time, position = results["frames/time"], results[f"bodies/{drive.body}/position"]
    chord = chord_angle(position, drive.axis)
    demanded = drive.demanded(time) - drive.demanded(time[:1])
    factor, unit = (180.0 / np.pi, "deg") if np.ptp(drive.angle) > 1e-2 else (1e3, "mrad")
    axes[1].plot(drive.time, factor * drive.angle, color="#9aa5b1", lw=4, label="demanded")
    axes[1].plot(time, factor * (drive.angle[0] + chord), label=f"chord of {drive.body}")
    axes[1].set_ylabel(f"[{unit}]")
    axes[1].set_title(f"{drive.joint}: angle")
    lag, lag_unit = scaled(chord - demanded, "rad")
    axes[2].plot(time, lag * (chord - demanded), marker=".")
    axes[2].set_ylabel(f"[{lag_unit}]")
    axes[2].set_title(f"{drive.joint}: angle of the chord less the demanded one")
    _legend_beside(axes[1])


def _components(
    ax: "Axes", time: Array, values: Array, labels: tuple[str, ...], unit: str = "m"
) -> None:
    factor, unit = scaled(values, unit)
    for column, label, color in zip(values.T, labels, TRAJECTORY_COLORS, strict=True):
        ax.plot(time, factor * column, label=label, color=color)
    ax.set_ylabel(f"[{unit}]")
    _legend_beside(ax)


def _legend_beside(ax: "Axes") -> None:
    ax.legend(loc="upper left", bbox_to_anchor=(1.01, 1.03), handlelength=1.4)


def accelerated_probes(results: Results) -> list[str]:
    """Those of the moving probes whose acceleration is known."""
    return [p for p in moving_probes(results) if f"probes/{p}/acceleration" in results]


def draw_acceleration(results: Results, figure: "Figure") -> None:
    """Acceleration of the probes at the ends of the windows: where impacts jolt them."""
    probes = accelerated_probes(results)
    heading(results, figure, "acceleration")
    axes = figure.subplots(len(probes), 1, sharex=True, squeeze=False)[:, 0]
    for ax, probe in zip(axes, probes, strict=True):
        table = results.table(f"probes/{probe}")
        _components(ax, table["time"], table["acceleration"], ("x", "y", "z"), "m/s²")
        ax.set_title(probe)
    axes[-1].set_xlabel(clock_of(results).label)
    figure.align_ylabels(axes)


def draw_path(results: Results, figure: "Figure") -> None:
    """Load factor against the displacement of the probes, from equilibrium to equilibrium."""
    probes = moving_probes(results)
    heading(results, figure, "path of equilibria")
    axes = figure.subplots(1, len(probes), sharey=True, squeeze=False)[0]
    for ax, probe in zip(axes, probes, strict=True):
        table = results.table(f"probes/{probe}")
        moved = table["position"] - table["position"][0]
        factor, unit = scaled(moved, "m")
        for column, label, color in zip(moved.T, "xyz", TRAJECTORY_COLORS, strict=True):
            if np.abs(column).max() > UNSEEN * np.abs(moved).max():
                ax.plot(factor * column, table["time"], ".-", label=label, color=color, ms=4)
        ax.set_xlabel(f"displacement of {probe} [{unit}]")
        if ax.lines:  # it did move
            ax.legend(loc="best", handlelength=1.4)
    axes[0].set_ylabel(clock_of(results).label)


# --------------------------------------------------------------------------------- energy

PANELS = {
    "mechanical energy and work": (
        *("kinetic", "strain", "contact_elastic", "work_loads", "work_drive", "work_thermal"),
        "damping",
    ),
    "dissipated in joints": ("hysteresis", "heat_exchanged", "friction"),
    "heat": ("heat_stored",),
    "integrator and defects": ("numerical", "defect", "heat_defect"),
}
BEHIND = ("heat_stored", "heat_exchanged")  # drawn broad, since others should cover them
DEFECTS = "integrator and defects"
MOST_TERMS = 8  # of a panel, that can be told apart


def _ledger_panels(results: Results) -> dict[str, list[str]]:
    """Terms of each panel, without those that are zero throughout."""
    terms = [t for t in results.names("ledger") if np.any(results[f"ledger/{t}"])]
    named = {term for panel in PANELS.values() for term in panel}
    panels = {name: [t for t in panel if t in terms] for name, panel in PANELS.items()}
    for term in terms:
        if term not in named:
            panels["heat" if term.startswith("heat_") else next(iter(PANELS))].append(term)
    return {name: panel for name, panel in panels.items() if panel}


def energy_rows(results: Results) -> int:
    """Number of panels that ``draw_energy`` makes."""
    return len(_ledger_panels(results))


def draw_energy(results: Results, figure: "Figure") -> None:
    """The energy ledger; what the integrator loses and what is missing on a scale of its own."""
    heading(results, figure, "energy ledger")
    panels, time = _ledger_panels(results), results["windows/time"]
    axes = figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0]
    for ax, (name, terms) in zip(axes, panels.items(), strict=True):
        values = _merged({term: results[f"ledger/{term}"] for term in terms})
        (_plot_defects if name == DEFECTS else _plot_terms)(ax, time, values)
        ax.set_title(name)
        _legend_beside(ax)
    axes[-1].set_xlabel(clock_of(results).label)
    figure.align_ylabels(axes)


def _merged(values: dict[str, Array]) -> dict[str, Array]:
    """Of too many terms those of a kind as their sum, such as all of "heat_light."."""
    if len(values) <= MOST_TERMS:
        return values
    kinds: dict[str, list[str]] = {}
    for term in values:
        kinds.setdefault(term.partition(".")[0], []).append(term)
    return {
        terms[0] if len(terms) == 1 else f"{kind}, {len(terms)} together": np.sum(
            [values[term] for term in terms], axis=0
        )
        for kind, terms in kinds.items()
    }


def _plot_terms(ax: "Axes", time: Array, values: dict[str, Array]) -> None:
    factor, unit = scaled(np.concatenate(list(values.values())), "J")
    for term, row in values.items():
        style: dict[str, Any] = {"color": "#b8c1cb", "lw": 4.0} if term in BEHIND else {}
        ax.plot(time, factor * row, label=term.replace("_", " "), **style)
    ax.set_ylabel(f"[{unit}]")


def _plot_defects(ax: "Axes", time: Array, values: dict[str, Array]) -> None:
    """Logarithmic on both sides of zero, linear up to the size of the defects."""
    peaks = {term: float(np.abs(row).max()) for term, row in values.items()}
    defects = [peak for term, peak in peaks.items() if term != "numerical"]
    ax.axhline(0.0, color="#5b6570", lw=0.8)
    for term, row in values.items():
        thin = 1.5 if term == "numerical" else 0.8
        ax.plot(
            time, row, lw=thin, label=f"{term.replace('_', ' ')}\n  at most {peaks[term]:.1e} J"
        )
    threshold = max(defects, default=1e-6 * max(peaks.values()))
    ax.set_yscale("symlog", linthresh=10.0 ** np.ceil(np.log10(threshold)))
    ax.set_ylabel("[J]")


# ---------------------------------------------------------------------------------- steps


def draw_steps(results: Results, figure: "Figure") -> None:
    """Range of the step size, steps and iterations of each coupling window."""
    heading(results, figure, "steps and iterations")
    windows = results.table("windows")
    time = windows["time"]
    top, middle, bottom = figure.subplots(3, 1, sharex=True)
    top.fill_between(time, windows["step_min"], windows["step_max"], alpha=0.3, lw=0)
    top.plot(time, windows["step_max"], lw=0.9)
    top.plot(time, windows["step_min"], lw=0.9, color="#0072B2")
    top.set_yscale("log")
    top.set_title("smallest and largest mechanical step")
    top.set_ylabel("[s]")
    middle.plot(time, windows["steps"], drawstyle="steps-pre", label="accepted", lw=1.0)
    if "rejected" in windows:
        middle.plot(time, windows["rejected"], drawstyle="steps-pre", label="rejected", lw=1.0)
    middle.set_title("steps per window")
    _legend_beside(middle)
    per_step = windows["iterations"] / np.maximum(windows["steps"], 1)
    bottom.plot(time, per_step, drawstyle="steps-pre", lw=1.0, color="#009E73")
    bottom.set_title("Newton iterations per step")
    bottom.set_ylim(bottom=0.0)
    bottom.set_xlabel("time [s]")
    figure.align_ylabels([top, middle, bottom])
