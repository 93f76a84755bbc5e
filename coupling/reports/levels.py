"""How cost grows with size: the ring truss from Level 1 to Level 4, and ten times Level 4."""

from collections.abc import Iterator
from time import perf_counter

import numpy as np

from coupling.reports.measure import Parts, exponent, fixed, march, parts
from coupling.reports.registry import Curve, Picture, Result
from coupling.reports.rings import STEP, ring
from mechanics.system import System
from meshes.truss import LEVELS

TEN_TIMES = 178
"""Elements of a span for ten times the coordinates of Level 4."""
SIZES, STEPS = (STEP, 0.1 * STEP), 50
"""Sizes of the steps [s], and how many are timed; a tenth of them of the largest ring."""
COLUMNS = (
    "level", "elements", "coordinates", "residual [ms]", "tangent [ms]", "refactor [ms]",
    "solve [ms]", *(f"step of {h:g} s [ms]" for h in SIZES), "building [s]",
)  # fmt: skip


MEASURED = (*Parts._fields, *(f"step of {h:g} s" for h in SIZES))


def report(largest: bool = False) -> Iterator[Result]:
    """Times of the parts of a step and of a step, and the power with which they grow.

    Parameters
    ----------
    largest : ten times Level 4 as well, which takes minutes and gigabytes
    """
    sizes = {str(level): elements for level, elements in LEVELS.items()}
    if largest:
        sizes["10 x 4"] = TEN_TIMES
    rows: list[tuple[str | float | int, ...]] = []
    found: dict[str, list[float]] = {name: [] for name in ("size", *MEASURED)}
    notes: list[str] = []
    for level, elements in sizes.items():
        begun = perf_counter()
        system = ring(elements)
        built = perf_counter() - begun
        once = parts(system, STEP, 5)
        steps = [_step(system, h, STEPS if elements < TEN_TIMES else STEPS // 10) for h in SIZES]
        for h, (_, why) in zip(SIZES, steps, strict=True):
            notes += [f"level {level}: no steps of {h:g} s: {why}"] if why else []
        times = (*once, *(seconds for seconds, _ in steps))
        for name, value in zip(("size", *MEASURED), (system.n, *times), strict=True):
            found[name].append(float(value))
        rows.append((level, 144 * (elements + 1), system.n, *(1e3 * t for t in times), built))
        del system
    picture = Picture(
        "coordinates",
        "time [ms]",
        [Curve(name, found["size"], [1e3 * t for t in found[name]]) for name in MEASURED],
    )
    yield Result(
        "levels", "Growth of the ring truss", COLUMNS, rows, [*_powers(found), *notes], [picture]
    )


def _step(system: System, h: float, steps: int) -> tuple[float, str]:
    """Time of a step of ``h`` [s], or not a number and the reason."""
    try:
        return march(system, fixed(h), steps * h, 2, warm=2 * h).seconds, ""
    except RuntimeError as error:
        return float("nan"), str(error)


def _powers(found: dict[str, list[float]]) -> list[str]:
    notes = []
    spans = {"Level 1 to 4": slice(0, 4)}
    if len(found["size"]) > 4:
        spans |= {"Level 4 to 10 x 4": slice(3, None), "all": slice(None)}
    for span, part in spans.items():
        powers = [
            f"{name} {exponent(found['size'][part], found[name][part]):.2f}"
            for name in MEASURED
            if np.isfinite(found[name][part]).all()
        ]
        notes.append(f"power of the number of coordinates, {span}: {', '.join(powers)}")
    return notes
