"""How cost grows with size: the ring truss from Level 1 to Level 4, and ten times Level 4."""

from collections.abc import Iterator
from time import perf_counter

from coupling.reports.measure import Parts, exponent, fixed, march, parts
from coupling.reports.registry import Curve, Picture, Result
from coupling.reports.rings import STEP, ring
from mechanics.system import System
from meshes.truss import LEVELS

TEN_TIMES = 178
"""Elements of a span for ten times the coordinates of Level 4."""
STEPS = 50
COLUMNS = (
    "level", "elements", "coordinates", "residual [ms]", "tangent [ms]", "refactor [ms]",
    "solve [ms]", "step [ms]", "building [s]",
)  # fmt: skip


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
    found: dict[str, list[float]] = {name: [] for name in ("size", "step", *Parts._fields)}
    notes: list[str] = []
    for level, elements in sizes.items():
        begun = perf_counter()
        system = ring(elements)
        built = perf_counter() - begun
        once = parts(system, STEP, 5)
        seconds, why = _step(system, STEPS if elements < TEN_TIMES else 5)
        notes += [f"level {level}: no steps of {STEP:g} s: {why}"] if why else []
        for name, value in (("size", system.n), ("step", seconds), *once._asdict().items()):
            found[name].append(float(value))
        times = (*(1e3 * t for t in once), 1e3 * seconds)
        rows.append((level, 144 * (elements + 1), system.n, *times, built))
        del system
    yield Result(
        "levels", f"Ring truss, steps of {STEP:g} s", COLUMNS, rows, [*_powers(found), *notes],
        _drawn(found),
    )  # fmt: skip


def _step(system: System, steps: int) -> tuple[float, str]:
    """Time of a step [s], or not a number and the reason."""
    try:
        return march(system, fixed(STEP), steps * STEP, 2, warm=2 * STEP).seconds, ""
    except RuntimeError as error:
        return float("nan"), str(error)


def _powers(found: dict[str, list[float]]) -> list[str]:
    notes = []
    spans = {"Level 1 to 4": slice(0, 4), "Level 4 to 10 x 4": slice(3, None)}
    for span, part in spans.items():
        if len(found["size"][part]) < 2:
            continue
        powers = [
            f"{name} {exponent(found['size'][part], found[name][part]):.2f}"
            for name in ("step", *Parts._fields)
        ]
        notes.append(f"power of the number of coordinates, {span}: {', '.join(powers)}")
    return notes


def _drawn(found: dict[str, list[float]]) -> Picture:
    curves = [
        Curve(name, found["size"], [1e3 * t for t in found[name]])
        for name in ("step", *Parts._fields)
    ]
    return Picture("coordinates", "time [ms]", curves)
