"""What a step is made of, and how near it comes to the least it can be."""

from collections.abc import Iterator

from coupling.reports.measure import Parts, Run, fixed, march, parts
from coupling.reports.registry import Result
from mechanics.system import System

STEPS = 100
"""Steps that are timed."""


def report(system: System, h: float) -> Iterator[Result]:
    """Times of residual, tangent, factorisation and solution; of a step of ``h`` [s]."""
    once = parts(system, h)
    try:
        run = march(system, fixed(h), STEPS * h, 2, warm=2 * h)
        stopped = ""
    except RuntimeError as error:
        run, stopped = None, f"no step of {h:g} s is possible: {error}"
    yield Result(
        "work",
        f"Work of a step of {h:g} s: {system.n} coordinates, {system.m} constraints",
        ("part", "time [ms]", "in floors [-]"),
        _rows(once, run),
        [_said(once, run) if run is not None else stopped],
    )


def _rows(once: Parts, run: Run | None) -> list[tuple[str | float | int, ...]]:
    named = {"residual": once.residual, "tangent": once.tangent, "refactor": once.refactor,
             "solve": once.solve, "floor: residual + solve": once.floor}  # fmt: skip
    if run is not None:
        named["step, on average"] = run.seconds
    return [(name, 1e3 * time, time / once.floor) for name, time in named.items()]


def _said(once: Parts, run: Run) -> str:
    full = run.corrections * (once.residual + once.tangent + once.refactor + once.solve)
    return (
        f"{run.steps} steps with {run.corrections:.2f} corrections each: "
        f"{run.seconds / once.floor:.2f} floors, and {full / run.seconds:.1f} times faster than "
        "with a new matrix in every correction"
    )
