"""Tables 7 and 8 and Figs. 22 to 30: the main boom over temperature, clearance, contact and drive.

The paper gives neither how its boom is driven nor what its hinge is made of. So the numbers of
Table 8 and the portraits are not determined; what is compared are directions. A direction is
Spearman's rank correlation of a number with what is varied: 1 if it always rises, -1 if it always
falls.
"""

from collections.abc import Iterator, Sequence
from csv import reader
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.stats import spearmanr

from coupling.paper.entries import Entry, number, numbers
from coupling.paper.workshop import Workshop

Array = NDArray[np.float64]

WARM, LOOSE = "boom_temperature", "boom_clearance"
CLEAR = 0.7
"""Rank correlation from which a direction counts, of six points."""


class Figure(NamedTuple):
    """A figure of phase portraits and what the paper reads from it.

    what : is varied, with its range;  printed : what the paper says
    direction : 1 if the motion is said to grow and to become irregular with it, -1 if the opposite,
        0 if neither goes one way
    why : what decides it here
    largest : point at which forces are said to be largest; 0: at none
    """

    number: int
    what: str
    printed: str
    direction: int
    row: int
    why: str
    largest: int = 0


PRELOADED, PRELOAD = 28, 16
"""Figure about preload, and the component of that name in the checklist."""
FIGURES = (
    Figure(22, "bearing heated to 19.85-169.85 degC", "compact to chaotic with temperature", 1, 67,
           "the clearance grows by 0.17 um/K between steel and aluminium; E(T) alone does nothing"),
    Figure(23, "all at -150 to 100 degC", "compact to chaotic with temperature", 1, 68,
           "the clearance grows from 11 to 63 um between steel and aluminium"),
    Figure(24, "clearance 0.02-0.14 mm", "contact, then three phases, then free flight and impact",
           1, 70, "the pin crosses a wider gap later in the swing, and faster"),
    Figure(25, "clearance 0.002-0.012 mm", "the same at a tenth of the size", 1, 71,
           "one drive cannot make both ranges chaotic at their upper ends; here it is that of Fig. "
           "24"),
    Figure(26, "linear contact of 1-3.5 MN/m", "chaotic to compact with stiffness", -1, 72,
           "so soft a contact gives way by a quarter of the clearance, and the largest force is "
           "the reaction of the swing, not an impact"),
    Figure(27, "friction 0.06-0.16", "chaotic to compact with friction", -1, 73,
           "the moment of friction, mu N r, is small beside that of the drive: only the path of "
           "the pin in its bore notices"),
    Figure(28, "preload 0-100 N", "straight line, then chaos, then locked", -1, 74,
           "the pin stays where it is pressed once preload exceeds the reaction of the swing"),
    Figure(29, "drive of 0.05-0.30 rad/s", "compact, free flight at 0.20, chaotic", 0, 75,
           "m L/2 W^2 presses the pin outwards: 49 N at 0.05 rad/s, 1770 N at 0.30"),
    Figure(30, "excitation of 0.1-1.2 rad/s", "largest and chaotic at 0.8 rad/s", 0, 76,
           "0.8 rad/s is the first bending mode of a tube of 0.27 m radius; slower drives shake "
           "the joint less, but as irregularly", 4),
)  # fmt: skip


def entries(work: Workshop) -> Iterator[Entry]:
    """Table 7, Table 8, the figures, claims of the abstract, interactions."""
    yield from _table_7(work)
    yield from _table_8(work)
    for figure in FIGURES:
        yield _figure(work, figure)
    yield _friction(work)
    yield _field(work)
    yield from _interactions(work)


# ---------------------------------------------------------------------------------- what is read


def _sweep(work: Workshop, case: str, name: str) -> Any:
    """A sweep all of whose points are done."""
    found = work.sweep(case, name)
    if found.failures:
        raise RuntimeError(f"sweep {name} of {case}: {found.failures[0]}")
    return found


def _column(swept: Any, name: str) -> Array:
    return np.array(swept.column(name), dtype=float)


def _printed(work: Workshop, case: str, table: str) -> Array:
    """(k, n) float  columns of a table that the paper prints."""
    text = (work.cases / case / "reference" / f"{table}.csv").read_text(encoding="utf-8")
    rows = [row for row in reader(text.splitlines()) if not row[0].startswith("#")]
    return np.array(rows[1:], dtype=float).T


def _pictures(swept: Any) -> tuple[Path, ...]:
    """Of the portraits of a sweep."""
    return tuple(file for file in map(Path, swept.files) if file.suffix == ".png")


def direction(values: Array) -> float:
    """Spearman's rank correlation of values with their order; nan where they are all alike."""
    good = np.isfinite(values)
    if good.sum() < 3 or np.ptp(values[good]) == 0.0:
        return np.nan
    return float(spearmanr(np.arange(len(values))[good], values[good]).statistic)


def exponent(x: Array, y: Array) -> float:
    """p of y ~ x^p by least squares of the logarithms."""
    return float(np.polyfit(np.log(x), np.log(y), 1)[0])


def _rise(values: Array) -> str:
    return f"{100.0 * (values[-1] / values[0] - 1.0):+.3g} %"


# ---------------------------------------------------------------------------------------- Table 7


def _table_7(work: Workshop) -> Iterator[Entry]:
    printed = _printed(work, WARM, "table_7")
    yield _displacement(work, printed[1])
    bending = _sweep(work, WARM, "table_7_bending")
    yield _frequency(work, printed[2], _column(bending, "frequency"))
    yield _swing(work, printed[3], _column(bending, "frequency"))


def _displacement(work: Workshop, printed: Array) -> Entry:
    theirs, ours = (_sweep(work, WARM, f"table_7{end}") for end in ("_hua2026", ""))
    bows = [_column(one, "bow") for one in (theirs, ours)]
    reach = [float(np.ptp(_column(one, "reach"))) for one in (theirs, ours)]
    far = 100.0 * np.abs(bows[0] / printed - 1.0).max()
    return Entry(
        "Table 7",
        "end displacement [m] at -200, -100, 25, 100, 200 degC",
        f"{numbers(printed)}: {_rise(printed)}, 'primarily axial expansion'",
        f"bow at 50 degC/m across the boom: {numbers(bows[0])}: {_rise(bows[0])}; growth along the "
        f"boom over the range: {number(reach[0], 'm', 3)}",
        f"with alpha(T) of NIST: {numbers(bows[1])}: {_rise(bows[1])}; growth "
        f"{number(reach[1], 'm', 3)}",
        f"trend reproduced by the bow, within {far:.1f} %; it cannot be axial, which would be "
        f"{reach[0] / np.ptp(printed):.0f} times the printed change",
        (66, 38),
    )


def _frequency(work: Workshop, printed: Array, bending: Array) -> Entry:
    axial = _column(_sweep(work, WARM, "table_7_axial"), "frequency")
    half = len(printed)
    return Entry(
        "Table 7",
        "first natural frequency [Hz]",
        f"{numbers(printed)}: {_rise(printed)}, not monotonic",
        f"Table 1: bending {numbers(bending[half:])}: {_rise(bending[half:])}; along the boom "
        f"{numbers(axial[half:])}: {_rise(axial[half:])}",
        f"NIST and EN 1999: bending {numbers(bending[:half])}: {_rise(bending[:half])}; along the "
        f"boom {numbers(axial[:half])}: {_rise(axial[:half])}",
        f"does not follow: bending is {printed[2] / bending[half + 2]:.0f} times lower; 16 to 18 "
        "Hz is near the first mode along the boom; E(T) of Table 1 falls too little, measured "
        "E(T) by as much as printed",
        (66,),
    )


def _swing(work: Workshop, printed: Array, frequencies: Array) -> Entry:
    """Amplitudes: those of the speed of the tip over the circular frequency."""
    half = len(printed)
    omega = 2.0 * np.pi * frequencies
    names = ("table_7_gradient", "table_7_flux_hua2026", "table_7_flux")
    speeds = [_column(_sweep(work, WARM, name), "speed") for name in names]
    held, given, real = (
        1e3 * v / w for v, w in zip(speeds, (omega[half:], omega[half:], omega[:half]), strict=True)
    )
    return Entry(
        "Table 7",
        "amplitude of the thermally induced vibration [mm]",
        f"{numbers(1e3 * printed)}: {_rise(printed)}",
        f"sudden sunlight that holds 50 degC/m: {numbers(held)}: {_rise(held)}; the same sunlight "
        f"at each temperature: {numbers(given)}: {_rise(given)}",
        f"the same sunlight, NIST: {numbers(real)}: {_rise(real)}",
        "trend reproduced in size, and in direction only if the gradient and not the flux is the "
        "same at each temperature: the wall then warms faster, k(T) rising; with a given flux c(T) "
        "of Table 1 makes the swing smaller",
        (66,),
    )


# ---------------------------------------------------------------------------------------- Table 8


def _table_8(work: Workshop) -> Iterator[Entry]:
    clearance, force, rate = _printed(work, LOOSE, "table_8")
    laws = ("table_8", "table_8_hua2026", "table_8_linear")
    swept = [_sweep(work, LOOSE, name) for name in laws]
    forces = [_column(one, "peak_force") for one in swept]
    powers = [exponent(clearance, f) for f in forces]
    floor = float(forces[2].min())
    above = forces[0] > 1.1 * floor
    struck = exponent(clearance[above], forces[0][above])
    yield Entry(
        "Table 8",
        "peak impact force [N] at 0.01, 0.02, 0.05, 0.08, 0.1 mm of clearance",
        f"{numbers(force)}: c^{exponent(clearance, force):.3f}",
        f"contact as printed: {numbers(forces[1])}: c^{powers[1]:.2f}",
        f"pin in bore: {numbers(forces[0])}: c^{powers[0]:.2f}, without points at which the "
        f"reaction of the swing of {number(floor, 'N', 3)} is the largest force c^{struck:.2f}; "
        f"2 MN/m: {numbers(forces[2])}: c^{powers[2]:.2f}. From rest at constant acceleration "
        "theory gives c^0.5 for a linear contact, c^0.6 for Hertz, c^0.4 for a bore; when "
        "the reaction passes through zero at a steady rate, v ~ c^(2/3)",
        _law_verdict(powers[0], exponent(clearance, force)),
        (69,),
        _pictures(swept[0]),
    )
    rates = _column(swept[0], "rate")
    yield Entry(
        "Table 8",
        "amplitude of the fluctuation of the angular velocity [rad/s]",
        f"{numbers(rate)}: c^{exponent(clearance, rate):.3f}",
        "the drive is not given",
        f"beside a drive of 1e-3 rad/s: {numbers(rates, digits=3)}: "
        f"c^{exponent(clearance, rates):.2f}",
        "not determined by the paper: drive, inertia at the hinge and bandwidth are not given",
        (69,),
    )


def _law_verdict(power: float, printed: float) -> str:
    if 0.3 <= power <= 0.75:
        return (
            f"trend reproduced: c^{power:.2f} beside c^{printed:.2f}; forces are as large as "
            "the drive makes them, which is assumed and was not fitted"
        )
    return f"not determined by the paper: with this drive it is c^{power:.2f}, not c^{printed:.2f}"


# ---------------------------------------------------------------------------------------- figures


def _figure(work: Workshop, figure: Figure) -> Entry:
    swept = _sweep(work, LOOSE, f"fig_{figure.number}")
    measures = {name: _column(swept, f"joint {name}") for name in _measures(swept)}
    size, force = _column(swept, "rate"), _column(swept, "peak_force")
    rows = [f"amplitude of the rate {numbers(1e3 * size, 'mrad/s', 3)}",
            f"peak force {numbers(force, 'N', 3)}",
            f"impacts {numbers(_column(swept, 'impacts'))}"]  # fmt: skip
    rows += [f"{_NAMES[name]} {numbers(values, digits=2)}" for name, values in measures.items()]
    return Entry(
        f"Fig. {figure.number}",
        f"phase portraits, {figure.what}",
        figure.printed,
        "the drive, the boom's section and the pin are not given",
        "; ".join(rows),
        _verdict(figure, force, size, measures),
        (figure.row, PRELOAD) if figure.number == PRELOADED else (figure.row,),
        _pictures(swept),
    )


_NAMES = {"chaos": "K", "spread": "spread", "entropy": "permutation entropy"}


def _measures(swept: Any) -> Sequence[str]:
    """Measures of regularity that the sweep has."""
    known = {label.partition(" [")[0] for label in swept.columns}
    return [name for name in _NAMES if f"joint {name}" in known]


def _verdict(figure: Figure, force: Array, size: Array, measures: dict[str, Array]) -> str:
    found = {"size": direction(size), **{n: direction(v) for n, v in measures.items()}}
    words = ", ".join(f"{n} {r:+.2f}" for n, r in found.items() if np.isfinite(r))
    if figure.direction == 0:
        return _largest(figure, int(np.argmax(force)) + 1)
    grows = figure.direction * found["size"] >= CLEAR
    disorder = [figure.direction * r for n, r in found.items() if n != "size" and np.isfinite(r)]
    wilder = max(disorder, default=0.0) >= CLEAR and min(disorder, default=0.0) > -CLEAR
    if grows and wilder:
        return f"trend reproduced (rank correlations: {words}): {figure.why}"
    if grows or wilder:
        part = "size" if grows else "irregularity"
        return f"trend reproduced in {part} only (rank correlations: {words}): {figure.why}"
    found_not = f"and not found here (rank correlations: {words})"
    return f"not determined by the paper, {found_not}: {figure.why}"


def _largest(figure: Figure, most: int) -> str:
    text = f"the force is largest at point {most} of six: {figure.why}"
    kind = "trend reproduced" if most == figure.largest else "not determined by the paper"
    return f"{kind}; {text}"


# ---------------------------------------------------------------------- claims, interactions


def _friction(work: Workshop) -> Entry:
    """The abstract: +0.1 of friction, +15-20 % of impact force."""
    force = _column(_sweep(work, LOOSE, "fig_27"), "peak_force")
    return Entry(
        "Abstract",
        "0.1 more of friction raises the impact force",
        "by 15 to 20 %; Sec. 4.3.3 says that friction calms impacts",
        "no data in the paper",
        f"friction 0.06 to 0.16: {_rise(force)} ({numbers(force, 'N')})",
        "does not follow from anything in the paper, whose Fig. 27 says the opposite",
        (73,),
    )


def _field(work: Workshop) -> Entry:
    """The abstract: a field that is not uniform, +32-45 % of amplitude."""
    change = {"body.boom.reference_temperature": "25 degC"}
    sought = {"y": "probe.tip.y", "x": "probe.tip.x", "vy": "probe.tip.vy"}
    lit = work.run(WARM, overrides=change, quantities=sought)
    turn = {**change, "thermal.flux.sun": {
        "body": "boom", "face": "outer", "density": "39.4 W/m^2"}}  # fmt: skip
    even = work.run(WARM, overrides=turn, quantities=sought)
    swing = [float(np.ptp(ran.values["vy"])) / 2 for ran in (lit, even)]
    return Entry(
        "Abstract",
        "amplitude under a field that is not uniform against one that is",
        "32 to 45 % more",
        "no data in the paper",
        f"the same heat on one side and all round: speed of the swing {number(swing[0], 'm/s', 3)} "
        f"and {number(swing[1], 'm/s', 3)}: a uniform field does not bend a straight boom at all",
        "does not follow: the ratio is infinite for a straight boom, not 1.32 to 1.45",
        (79,),
    )


def _interactions(work: Workshop) -> Iterator[Entry]:
    for name, what in (
        ("temperature_clearance_friction", "temperature, clearance, friction"),
        ("clearance_speed_preload", "clearance, speed of the drive, preload"),
        ("gradient_clearance", "gradient across the boom, clearance"),
    ):
        swept = _sweep(work, LOOSE, name)
        force = _column(swept, "peak_force")
        yield Entry(
            "Sec. 4.3.4",
            f"interactions of {what}",
            "named as future work",
            "none",
            f"{len(force)} runs: peak force {number(force.min(), 'N', 3)} to "
            f"{number(force.max(), 'N', 3)}; {_effects(swept, force)}",
            "not determined by the paper: computed here as a design of experiments",
            (77,),
            _pictures(swept),
        )


def _effects(swept: Any, force: Array) -> str:
    """Coefficients of a model with main effects and pairs, coded -1 to 1, over its mean."""
    names = [axis.name for axis in swept.axes]
    terms: dict[str, Array] = {name: swept.coded[:, k] for k, name in enumerate(names)}
    for i, one in enumerate(names):
        terms |= {f"{one} x {other}": terms[one] * terms[other] for other in names[i + 1 :]}
    matrix = np.column_stack([np.ones(len(force)), *terms.values()])
    mean, *found = np.linalg.lstsq(matrix, force, rcond=None)[0]
    shown = (f"{n} {100 * f / mean:+.1f} %" for n, f in zip(terms, found, strict=True))
    return f"half effects over the mean of {number(mean, 'N', 3)}: {', '.join(shown)}"
