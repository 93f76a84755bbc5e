"""Friction that feeds itself: both sides of the threshold, and which exchange holds."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from coupling.reports.registry import Curve, Picture, Result, Row
from coupling.verify.seizure import SLOW, Seizure, course, critical_rate

Array = NDArray[np.float64]

SPEEDS = (1.0, 1.2, 1.3, 1.5)
"""[rad/s]  two below the threshold, two above."""
QUICK = replace(SLOW, masses=(0.015, 0.001))
"""A tenth of the masses: the same equilibria in a tenth of the time."""
LONG, WINDOW = 800.0, 1.0
END, WINDOWS = 400.0, (1.0, 2.0, 5.0, 10.0, 20.0, 40.0)
"""[s]  of the comparison of schemes."""
SCHEMES = ("serial", "parallel", "corrected", "iterated")


def report() -> Iterator[Result]:
    """The threshold, courses on both sides of it, and the error of each scheme and window."""
    yield _threshold()
    yield _schemes()


def _threshold() -> Result:
    model, rows, curves = QUICK, list[Row](), []
    theory = model.critical_speed
    first = theory / model.radius
    found = model.radius * critical_rate(model, 0.9 * first, 1.2 * first, 5)
    for rate in SPEEDS:
        one = replace(model, rate=rate)
        times = _times(LONG, WINDOW)
        run = course(one.pair(), "iterated", LONG, len(times))
        exact = one.course(times)
        off = float(np.abs(run - exact).max())
        speed = 1e3 * rate * model.radius
        fate = "settles" if speed < 1e3 * theory else "seizes"
        ends = float(run[-1, 0]), float(exact[-1, 0])
        rows.append((speed, speed / theory / 1e3, fate, *ends, off))
        curves.append(Curve(f"{speed:g} mm/s", times, run[:, 0], "-"))
        curves.append(Curve("", times[::40], exact[::40, 0], "k."))
    notes = [
        f"critical speed: formula {1e3 * theory:.4g} mm/s, by runs {1e3 * found:.4g} mm/s "
        f"({100.0 * (found / theory - 1.0):+.2f} %)",
        f"there the shaft is {model.critical_rise[0]:.3g} K above the ambient; windows of "
        f"{WINDOW:g} s, iterated, and a tenth of the masses; dots: the differential equation",
    ]
    picture = Picture("time [s]", "rise of the shaft [K]", curves, "")
    columns = ("speed [mm/s]", "of critical", "formula", "rise [K]", "ODE [K]", "largest error [K]")
    return Result("seizure", "Friction that feeds itself", columns, rows, notes, (picture,))


def _schemes() -> Result:
    rows, curves = list[Row](), []
    for scheme in SCHEMES:
        errors = [_error(SLOW, scheme, h) for h in WINDOWS]
        rows.append((scheme, *(round(e, 3) if np.isfinite(e) else "stopped" for e in errors)))
        curves.append(Curve(scheme, WINDOWS, errors, "o-"))
    columns = ("scheme", *(f"{h:g} s" for h in WINDOWS))
    notes = [
        f"largest error [K] of any temperature in {END:g} s at {1e3 * SLOW.radius:g} mm/s against "
        "the differential equation, by window; the whole rise is 7 K",
    ]
    pictures = (Picture("window [s]", "largest error [K]", curves), _courses())
    return Result("seizure_schemes", "Schemes of the exchange", columns, rows, notes, pictures)


def _courses() -> Picture:
    """Temperatures of the bush in windows of 10 s."""
    times = _times(END, 10.0)
    curves = [Curve("ODE", times, SLOW.course(times)[:, 1], "k-")]
    for scheme in ("serial", "corrected", "iterated"):
        run = course(SLOW.pair(), scheme, END, len(times))
        curves.append(Curve(scheme, times, np.clip(run[:, 1], -5.0, 40.0), "-"))
    return Picture("time [s]", "rise of the bush, windows of 10 s [K]", curves, "")


def _error(model: Seizure, scheme: str, window: float) -> float:
    """Largest error [K]; infinite where the run stops."""
    times = _times(END, window)
    try:
        run = course(model.pair(), scheme, END, len(times))
    except RuntimeError:
        return np.inf
    return float(np.abs(run - model.course(times)).max())


def _times(end: float, window: float) -> Array:
    return window * np.arange(1.0, round(end / window) + 1.0)
