"""Thermal flutter of a sunlit boom: both sides of the threshold, and schemes that move it."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from coupling.reports.registry import Curve, Picture, Result, Row
from coupling.verify.flutter import BOOM, Boom, found_ratio, measured, swing

Array = NDArray[np.float64]

PARTS = (0.5, 0.75, 1.0, 1.25, 1.5)
"""Damping, over the critical one of the formula."""
WINDOWS = (1.0, 2.0, 4.0, 8.0)
"""[s]; the boom swings once in 53 s."""
SCHEMES = ("serial", "parallel", "corrected", "iterated")
END = 1200.0


def report() -> Iterator[Result]:
    """Rates of growth over damping, and the threshold of each scheme and window."""
    yield _growth()
    yield _schemes()


def _growth() -> Result:
    rows, swings, rates = list[Row](), [], []
    for part in PARTS:
        boom = _damped(part * BOOM.critical_ratio)
        t, y = swing(boom.model("iterated", 1.0, END))
        rate = measured(t, y, boom.growth)
        rows.append((100.0 * boom.ratio, part, 1e3 * boom.growth.real, 1e3 * rate.real,
                     boom.growth.imag, rate.imag))  # fmt: skip
        rates.append(1e3 * rate.real)
        if part in (PARTS[0], PARTS[-1]):
            swings.append(Curve(f"damping {100.0 * boom.ratio:.2g} %", t, y, "-"))
    ratios = np.linspace(0.4, 1.6, 25) * BOOM.critical_ratio
    formula = [1e3 * _damped(float(z)).growth.real for z in ratios]
    damping = [100.0 * p * BOOM.critical_ratio for p in PARTS]
    lines = [Curve("formula", 100.0 * ratios, formula, "-"), Curve("runs", damping, rates, "o"),
             Curve("", 100.0 * ratios, 0.0 * ratios, "k:")]  # fmt: skip
    pictures = (
        Picture("time [s]", "tip [m]", swings, ""),
        Picture("damping ratio [%]", "rate of growth [1/1000 s]", lines, ""),
    )
    columns = ("damping [%]", "of critical", "formula [1/ks]", "run [1/ks]",
               "formula [rad/s]", "run [rad/s]")  # fmt: skip
    notes = [
        f"critical damping by Routh and Hurwitz {100.0 * BOOM.critical_ratio:.4g} %: L = "
        f"{BOOM.feedback:.4g}, lag {BOOM.lag:.3g} s, omega tau = {BOOM.frequency * BOOM.lag:.3g}",
    ]
    return Result("flutter", "Thermal flutter of a sunlit boom", columns, rows, notes, pictures)


def _schemes() -> Result:
    rows, curves = list[Row](), []
    for scheme in SCHEMES:
        found = [100.0 * found_ratio(BOOM, scheme, h) for h in WINDOWS]
        rows.append((scheme, *(round(z, 4) for z in found)))
        curves.append(Curve(scheme, WINDOWS, found, "o-"))
    late = [100.0 * BOOM.delayed_ratio(0.5 * h) for h in WINDOWS]
    rows.append(("formula, light late by half a window", *(round(z, 4) for z in late)))
    curves.append(Curve("late by half a window", WINDOWS, late, "k--"))
    exact = 100.0 * BOOM.critical_ratio
    curves.append(Curve("Routh and Hurwitz", WINDOWS, [exact] * len(WINDOWS), "k-"))
    columns = ("scheme", *(f"{h:g} s" for h in WINDOWS))
    notes = [f"critical damping [%] by runs, by window; Routh and Hurwitz: {exact:.4g} %"]
    picture = Picture("window [s]", "critical damping [%]", curves, "x")
    return Result("flutter_schemes", "Threshold by scheme", columns, rows, notes, (picture,))


def _damped(ratio: float) -> Boom:
    return replace(BOOM, damping=2.0 * ratio / BOOM.frequency)
