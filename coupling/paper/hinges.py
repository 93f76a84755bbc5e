"""Secs. 4.1.1 and 4.1.2, Figs. 8-11: five branches of a hinge, without heat and with it."""

import csv
from collections.abc import Iterator, Mapping
from math import cos, radians, sin
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from coupling.errors import BadCase
from coupling.paper.entries import Entry, away, numbers
from coupling.paper.workshop import Workshop
from coupling.reports.timed_runs import DONE
from meshes.materials import library_material

Array = NDArray[np.float64]
TRIANGLE, PENTAGON = "hinge_triangular", "hinge_pentagonal"
ROOM = 298.15
"""Where both hinges are straight [K]."""
LEAF, LENGTH = 1e-3, 0.1
"""Thickness and length of the first leaf of both [m]."""
ARM = 0.3
"""Of the triangular hinge [m]."""
LEAVES = {1: 0.1, 2: 0.075, 3: 0.05, 4: 0.1, 5: 0.1}
SENSE = {1: 1.0, 2: 1.0, 3: 1.0, 4: -1.0, 5: -1.0}
"""Lengths of the leaves of the triangular hinge [m], and ratios of its gears."""
DEPLOYED = 45.0
"""[variant.degeneration] [deg]."""
SPRING, SECOND_MOMENT = 345.0, 0.02 * 1e-9 / 12.0
"""At the end of the fourth leaf of the pentagonal hinge [N/m]; of its section [m^4]."""
AXIAL = {"5": "hua2026", "10": "hua2026_10", "15": "hua2026_15"}
"""Printed gradient [degC/mm] and its variant."""
SPAN = 50.0
"""Length that the printed gradients are taken along [mm] (assumed)."""


def entries(work: Workshop) -> Iterator[Entry]:
    """Kinematics without heat; even warmth; gradients."""
    yield _degeneration(work)
    yield from _triangular(work)
    yield from _pentagonal(work)


def _reference(work: Workshop, case: str, name: str) -> list[dict[str, str]]:
    text = (work.cases / case / "reference" / name).read_text(encoding="utf-8")
    return list(csv.DictReader(line for line in text.splitlines() if not line.startswith("#")))


def _drawn(work: Workshop, sweep: object, name: str) -> tuple[Path, ...]:
    """Pictures of a sweep, in the folder of the report."""
    files = [Path(str(file)) for file in getattr(sweep, "files", ())]
    shown = ("quantities", "portraits_branch_1")
    pictures = [file for file in files if file.suffix == ".png" and file.stem in shown]
    return tuple(work.picture(file, f"{name}_{file.stem}") for file in pictures)


# ---------------------------------------------------------------------------------- no heat


def _degeneration(work: Workshop) -> Entry:
    """Where five arms arrive that gears turn, against rotations of rigid bodies."""
    wanted = {f"{axis}_{i}": f"probe.arm_{i}.{axis}" for i in LEAVES for axis in "xy"}
    rates = {f"rate_{i}": f"joint.pin_{i}.rate" for i in LEAVES}
    ran = work.run(TRIANGLE, ("degeneration",), {}, {**wanted, **rates})
    if ran.outcome != DONE:
        return _failed("Sec. 4.1.1", "end positions without heat and play", ran.reason, (59,))
    worst = max(_missed(ran.values, i) for i in LEAVES)
    odd = max(_unequal(ran.values, i) for i in LEAVES)
    return Entry(
        "Sec. 4.1.1",
        "Figs. 8, 9: end positions and speeds of five branches without heat and play, against "
        "closed form",
        "error below 0.5 %; neither geometry, drive nor positions are given",
        "",
        f"five flexible branches, turned by gears through {DEPLOYED:g} deg: ends are off by at "
        f"most {worst:.1e} of the way that they went; speeds at the gears agree to {odd:.1e}",
        "reproduced, in a hinge of our own" if worst < 0.005 else "does not follow here",
        (12, 15, 59),
    )


def _missed(values: Mapping[str, Array], i: int) -> float:
    """Distance of the end of arm i from where it belongs, over the way to there [-]."""
    x, y = (np.ravel(values[f"{axis}_{i}"]) for axis in "xy")
    reach, turn = LEAVES[i] + ARM, SENSE[i] * radians(DEPLOYED)
    goal = np.array([x[0] + reach * (cos(turn) - 1.0), y[0] + reach * sin(turn)])
    way = float(np.hypot(goal[0] - x[0], goal[1] - y[0]))
    return float(np.hypot(x[-1] - goal[0], y[-1] - goal[1])) / way


def _unequal(values: Mapping[str, Array], i: int) -> float:
    """Largest difference of the rate of pin i from that of the drive, over the largest [-]."""
    drive = np.ravel(values["rate_1"])
    own = SENSE[i] * np.ravel(values[f"rate_{i}"])
    return float(np.max(np.abs(own - drive)) / np.max(np.abs(drive)))


def _failed(place: str, claim: str, reason: str, rows: tuple[int, ...]) -> Entry:
    return Entry(place, claim, "", "", f"no value: {reason}", "not determined", rows)


# ------------------------------------------------------------------------------ even warmth


def bimetal_curvature(T: float, first: str = "al6061", second: str = "invar") -> float:
    """Curvature [1/m] of two equal layers, together ``LEAF`` thick, at T [K] (Timoshenko 1925).

    24 (e1 - e2)/(h (14 + n + 1/n)), n = E1/E2, with free strains e since ``ROOM``.
    """
    one, other = library_material(first), library_material(second)
    free = float(one.thermal_strain(T, ROOM)) - float(other.thermal_strain(T, ROOM))
    n = float(one.youngs_modulus(T)) / float(other.youngs_modulus(T))
    return 24.0 * free / (LEAF * (14.0 + n + 1.0 / n))


def _triangular(work: Workshop) -> Iterator[Entry]:
    """Fig. 10: what one metal does, what two do, rates, frequencies."""
    printed = _reference(work, TRIANGLE, "fig_10.csv")
    sweep = work.sweep(TRIANGLE, "fig_10")
    if sweep.failures:
        yield _failed("Fig. 10", "triangular hinge", sweep.failures[0], (39, 60))
        return
    rises = np.array([float(row["rise [K]"]) for row in printed])
    angles = [np.degrees(np.array(sweep.column(f"angle_{i}"), float)) for i in LEAVES]
    ones = work.run(TRIANGLE, ("hua2026",), {}, {f"a{i}": f"probe.arm_{i}.rz" for i in LEAVES})
    turned = max(float(np.max(np.abs(rows))) for rows in ones.values.values())
    yield _angles(printed, rises, angles, turned, _drawn(work, sweep, "fig_10"))
    yield _rates(printed, rises, np.array(sweep.column("largest_rate"), float))
    yield _softer(rises)


def _angles(
    printed: list[dict[str, str]],
    rises: Array,
    angles: list[Array],
    turned: float,
    pictures: tuple[Path, ...],
) -> Entry:
    closed = np.degrees([-bimetal_curvature(ROOM + rise) * LENGTH for rise in rises])
    worst = float(np.max(np.abs(angles[0] / closed - 1.0)))
    straight = np.ptp(angles[0] / rises) / np.mean(angles[0] / rises)
    last = float(printed[-1]["largest angle [deg]"])
    needed = radians(last) / (bimetal_curvature(ROOM + rises[-1]) * LEAF)
    each = "; ".join(f"branch {i}: {numbers(a)}" for i, a in zip(LEAVES, angles, strict=True))
    return Entry(
        "Fig. 10",
        "largest angle of the triangular hinge after even rises of 55, 105, 155 K [deg]",
        ", ".join(row["largest angle [deg]"] or "-" for row in printed),
        f"{turned:.1e} rad: a hinge of one metal, free or on a base of that metal, only becomes "
        f"larger ({1e3 * float(library_material('al6061').thermal_strain(ROOM + 155, ROOM)):.2f} "
        "per thousand)",
        f"leaves of aluminium on invar, 0.1 m long and 1 mm thick: {each} deg; by Timoshenko "
        f"{numbers(closed)} for the first, {100 * worst:.2f} % apart; angle per kelvin the same "
        f"to {100 * abs(straight):.1f} %; {last:g} deg ask for leaves {needed:.0f} times as long "
        "as thick",
        "does not follow from one metal; the angle is proportional to the rise, as printed "
        "(2.80 for 2.82), where there are two",
        (39, 44, 60),
        pictures,
    )


def _rates(printed: list[dict[str, str]], rises: Array, rates: Array) -> Entry:
    given = [float(row["largest rate [rad/s]"] or "nan") for row in printed]
    return Entry(
        "Fig. 10",
        "largest angular velocity of the triangular hinge [rad/s]",
        ", ".join(row["largest rate [rad/s]"] or "-" for row in printed),
        f"the rate of 155 K over that of 55 K: {given[2] / given[0]:.2f}, of the rises "
        f"{rises[2] / rises[0]:.2f}; how fast it warms is not said",
        f"warmed in 2 s (assumed): {numbers(rates)}; ratio {rates[2] / rates[0]:.2f}",
        "trend reproduced: proportional to the rise; the size is not determined",
        (60,),
    )


def _softer(rises: Array) -> Entry:
    """What a softer metal does to a frequency."""
    E = library_material("al6061").youngs_modulus
    change = [100.0 * (np.sqrt(float(E(ROOM + rise) / E(ROOM))) - 1.0) for rise in rises]
    return Entry(
        "Fig. 10",
        "'accelerated fluctuation frequency', from a modulus that falls with temperature",
        "faster when warmer",
        "a smaller modulus makes vibrations slower",
        f"frequency of an aluminium leaf changes by {numbers(change, '%', 3)} at these rises",
        "does not follow: the sign is the other one",
        (60,),
    )


# -------------------------------------------------------------------------------- gradients


def _pentagonal(work: Workshop) -> Iterator[Entry]:
    """Fig. 11: as printed, and a tenth of it across the leaves."""
    printed = _reference(work, PENTAGON, "fig_11.csv")
    yield _refused(work)
    sweep = work.sweep(PENTAGON, "fig_11")
    if sweep.failures:
        yield _failed("Fig. 11", "pentagonal hinge", sweep.failures[0], (38, 60))
        return
    angles = [np.degrees(np.array(sweep.column(f"angle_{i}"), float)) for i in held()]
    along = work.run(PENTAGON, ("axial",), {}, {f"a{i}": f"probe.arm_{i}.rz" for i in held()})
    turned = max(float(np.max(np.abs(rows))) for rows in along.values.values())
    yield _bows(printed, angles, turned, _drawn(work, sweep, "fig_11"))
    rates = np.abs(np.array(sweep.column("largest_rate"), float))
    given = [float(row["largest rate [rad/s]"] or "nan") for row in printed]
    yield Entry(
        "Fig. 11",
        "largest angular velocity of the pentagonal hinge [rad/s]",
        ", ".join(row["largest rate [rad/s]"] or "-" for row in printed),
        f"ratio of the last to the first {given[2] / given[0]:.2f}, of the gradients 3",
        f"{numbers(rates)} for 0.5, 1, 1.5 degC/mm in 2 s (assumed); ratio "
        f"{rates[2] / rates[0]:.2f}",
        "trend reproduced: proportional to the gradient; the size is not determined",
        (60,),
    )


def held() -> dict[int, float]:
    """Turns of the ends of leaves of the curvature kappa, over kappa L, by the theory of beams.

    Free: 1; half as long: 1/2; on a spring k: 1 - 3/4 k/(k + 3 E I/L^3), which is 1/4 where it is
    rigid; with an end that cannot turn: 0.
    """
    E = float(library_material("al6061").youngs_modulus(ROOM))
    own = 3.0 * E * SECOND_MOMENT / LENGTH**3
    return {1: 1.0, 2: 0.5, 3: 0.25, 4: 1.0 - 0.75 * SPRING / (SPRING + own), 5: 0.0}


def _refused(work: Workshop) -> Entry:
    """What the program says of gradients as printed."""
    said = []
    for gradient, variant in AXIAL.items():
        hottest = 25.0 + float(gradient) * SPAN
        said.append(f"{gradient} degC/mm, {hottest:g} degC: {_refusal(work, variant)}")
    conductivity = float(library_material("al6061-paper").conductivity(ROOM))
    return Entry(
        "Fig. 11",
        "axial gradients of 5, 10, 15 degC/mm in a hinge of aluminium",
        "60 s of motion in each",
        f"along {SPAN:g} mm 250, 500, 750 K and, for the last, a heat flux of "
        f"{conductivity * 15e3 / 1e6:.1f} MW/m^2; {'; '.join(said)}",
        "aluminium 6061 melts from 582 degC on",
        "does not follow: the second leaves every table of the metal, the third melts it",
        (38, 60),
    )


def _refusal(work: Workshop, variant: str) -> str:
    try:
        scene = work.scene(PENTAGON, (variant,))
        from coupling.model import build

        build(scene)
    except BadCase as error:
        return f"refused ({error.problems[0].text})"
    return "run"


def _bows(
    printed: list[dict[str, str]], angles: list[Array], turned: float, pictures: tuple[Path, ...]
) -> Entry:
    gradients = 1e3 * np.array([0.5, 1.0, 1.5])
    alpha = float(library_material("al6061").expansion(ROOM))
    closed = {i: np.degrees(-part * alpha * gradients * LENGTH) for i, part in held().items()}
    worst = max(
        float(np.max(np.abs(angles[i - 1] - closed[i]))) / abs(closed[1][-1]) for i in closed
    )
    each = "; ".join(f"branch {i}: {numbers(a)}" for i, a in zip(closed, angles, strict=True))
    first, last = (
        float(printed[k]["largest angle between adjacent branches [deg]"]) for k in (0, 2)
    )
    long = radians(first) / (alpha * 5e3)
    return Entry(
        "Fig. 11",
        "angles of the pentagonal hinge between adjacent branches [deg]",
        f"{first:g} at 5 degC/mm, {last:g} at 15: ratio {last / first:.2f}",
        f"{turned:.1e} rad: a gradient along a leaf makes it longer and bends nothing",
        f"0.5, 1, 1.5 degC/mm through leaves of 1 mm: {each} deg; alpha G L and how the leaves "
        f"are held give the same to {100 * worst:.2f} %; {first:g} deg at 5 degC/mm through it "
        f"ask for {long:.2f} m of leaf",
        "does not follow; proportional to the gradient, "
        f"{away(float(angles[0][2]), 3.0 * float(angles[0][0]))} here over a factor 3",
        (38, 44, 60),
        pictures,
    )
