"""How large the errors of a run in time are likely to be, from what its controllers saw.

Motion: the sum of the local errors that the step control estimated (Zienkiewicz & Xie 1991), the
largest of all coordinates at each step, relative to the size of what moves. Local errors of steps
hardly decay in free motion and do in damped motion, where the sum is too large: for a mass on a
spring, booms, a truss and an arm in a loose hinge it is 0.7 to 7 times the distance from a run with
far smaller steps. Errors of the mesh are none of it, nor those of motions that grow apart.

Heat: the sum of the local errors of its steps. Heat forgets: the sum is a bound, not an estimate.

Exchange: the largest difference between the temperatures that a window began to be computed with
and those that it ended with, which scheme and window leave or, by ``corrected``, do better than.
"""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Estimate(NamedTuple):
    """Estimated errors of a run in time; nan where nothing is known.

    motion : float [-]  relative to the size of what moves;  length : float [m]  that is at most
    heat : float [K];  exchange : float [K];  seconds : float [s]  run time
    """

    motion: float
    length: float
    heat: float
    exchange: float
    seconds: float


def of_window(model: Any, before: Any, after: Any) -> dict[str, float]:
    """What the steps of a window add, from the states around it: columns of ``windows``."""
    solver = model.pair.heat_solver
    heat = 0.0 if solver is None else float(getattr(solver, "error", np.nan))
    return {"motion_error": float((after.motion.errors - before.motion.errors)[0]),
            "heat_error": heat}  # fmt: skip


def estimate(model: Any, windows: Mapping[str, Array]) -> Estimate | None:
    """Of a run whose table ``windows`` is given; None before its first window."""
    if not len(windows.get("motion_error", ())):
        return None
    motion, controlled = float(windows["motion_error"].sum()), model.motion_solver.control
    if not np.isfinite(controlled.tolerance):
        motion = np.nan
    size = float(model.layout.scale.max())
    heat = exchange = np.nan
    if model.pair.heat_solver is not None:
        heat = float(windows["heat_error"].sum())
        exchange = float(np.max(windows["window_error"]))
    return Estimate(motion, motion * size, heat, exchange, run_time(windows["wall_time"]))


def run_time(clock: Array) -> float:
    """Elapsed time [s] over a clock that begins anew where a run was resumed."""
    ends = np.append(clock[1:] < clock[:-1], True)
    return float(clock[ends].sum())


def attributes(found: Estimate) -> dict[str, float]:
    """What the results keep."""
    return {f"estimated_{name}": value for name, value in found._asdict().items()}


def kept(root: Mapping[str, Any]) -> Estimate | None:
    """From the root attributes of results; None where they have none."""
    names = [f"estimated_{name}" for name in Estimate._fields]
    return Estimate(*(float(root[name]) for name in names)) if set(names) <= set(root) else None


def said(found: Estimate, scene: Any = None) -> str:
    """One line in words; with a scene the tolerances too."""
    motion = tolerance = ""
    if scene is not None:
        motion = f" (tolerance {scene.integrator.tolerance:.3g} per step)"
        if scene.thermal is not None and scene.thermal.steps is None:
            tolerance = f" (tolerance {scene.thermal.tolerance:.3g} K per step)"
    parts = [f"motion {found.motion:.2g} of its size, at most {found.length:.2g} m{motion}"]
    if np.isfinite(found.heat):
        parts.append(f"heat {found.heat:.2g} K{tolerance}")
    if np.isfinite(found.exchange):
        parts.append(f"exchange {found.exchange:.2g} K")
    return f"estimated error in time: {', '.join(parts)}; run time {found.seconds:.3g} s"
