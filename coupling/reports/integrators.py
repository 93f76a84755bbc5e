"""Error against time for schemes and steps: a flexible beam falls about a spherical joint.

The reference is the same mesh in small steps of the scheme without numerical damping, so that only
errors of time count.
"""

from collections.abc import Iterator

import numpy as np

from coupling.reports.measure import fixed, march
from coupling.reports.registry import Curve, Picture, Result
from mechanics.description import Beam, Description, Site, Spherical
from mechanics.dynamics import Control
from mechanics.schemes import Scheme
from mechanics.system import System
from meshes.generate import frames
from meshes.materials import constant_material
from meshes.sections import rectangle

SCHEMES = {
    "hht -0.1": Scheme("hht", alpha=-0.1),
    "hht 0": Scheme("hht", alpha=0.0),
    "generalised-alpha 0.8": Scheme("generalised-alpha", spectral_radius=0.8),
    "bdf2": Scheme("bdf2"),
    "backward-euler": Scheme("backward-euler"),
}
STEPS = (4e-3, 2e-3, 1e-3, 5e-4, 2.5e-4)
TOLERANCES = (1e-3, 1e-4, 1e-5, 1e-6)
FINE, END = 2.5e-5, 0.5
ELEMENTS, LENGTH, SIDE = 8, 1.0, 0.02
"""Steps [s], local errors of the adaptive runs [-], step of the reference and end [s]; elements,
length and side of the section [m]."""


def report() -> Iterator[Result]:
    """Error of the place of the tip at the end, and time of the whole run."""
    system = pendulum()
    best = _tip(system, march(system, fixed(FINE, SCHEMES["hht 0"]), END, 1).state)
    rows: list[tuple[str | float | int, ...]] = []
    curves = []
    for name, scheme in SCHEMES.items():
        points = [_row(system, fixed(h, scheme), best) for h in STEPS]
        rows += [(name, f"{h:g} s", *row)
                 for h, row in zip(STEPS, _with_orders(points), strict=True)]  # fmt: skip
        curves.append(_curve(name, points))
    points = [_row(system, Control(tol, 2e-2, 1e-9, Scheme()), best) for tol in TOLERANCES]
    rows += [("hht -0.1", f"local error {tol:g}", *row, float("nan"))
             for tol, row in zip(TOLERANCES, points, strict=True)]  # fmt: skip
    curves.append(_curve("hht -0.1, adaptive", points))
    columns = ("scheme", "step", "steps", "corrections per step", "error of the tip / L [-]",
               "time of the run [ms]", "order [-]")  # fmt: skip
    title = f"Flexible pendulum, {ELEMENTS} elements, {END:g} s: error against time"
    picture = Picture("time of the run [ms]", "error of the tip / length [-]", curves)
    yield Result("integrators", title, columns, rows, [], [picture])


def _row(system: System, control: Control, best: np.ndarray) -> tuple[int, float, float, float]:
    """Steps, corrections per step, error [-], time [ms]."""
    try:
        run = march(system, control, END, 3)
    except RuntimeError:
        return 0, np.nan, np.nan, np.nan
    error = float(np.linalg.norm(_tip(system, run.state) - best)) / LENGTH
    return run.steps, run.corrections, error, 1e3 * run.seconds * run.steps


def _curve(name: str, points: list[tuple[int, float, float, float]]) -> Curve:
    return Curve(name, [p[3] for p in points], [p[2] for p in points])


def _with_orders(points: list[tuple[int, float, float, float]]) -> list[tuple]:
    """The rows with the order observed between each and the one before, of twice the step."""
    errors = np.array([p[2] for p in points])
    orders = [float("nan"), *np.log2(errors[:-1] / errors[1:]).tolist()]
    return [(*p, order) for p, order in zip(points, orders, strict=True)]


def _tip(system: System, state) -> np.ndarray:
    return state.motion.q[system.layout.node_dofs["beam"][-1] + np.arange(3)]


def pendulum() -> System:
    """A soft beam, horizontal at the start, on a spherical joint, under gravity."""
    points = np.column_stack([np.linspace(0.0, LENGTH, ELEMENTS + 1), np.zeros((ELEMENTS + 1, 2))])
    material = constant_material("rubber", 1100.0, 5e6, 0.3, 0.0, 1.0, 1.0)
    axes = frames(points, [0.0, 1.0, 0.0])
    beam = Beam("beam", points, axes, rectangle(SIDE, SIDE, 0.3), material, 293.15, 1e-3)
    joint = Spherical("pivot", Site("beam", 0), Site(None))
    return System(Description([beam], [joint], [], np.array([0.0, 0.0, -9.81])))
