"""Temperatures of a scene for another program, from our own heat or from CalculiX's."""

import numpy as np
from numpy.typing import NDArray

from coupling.deck import History
from coupling.errors import BadCase, Problem
from coupling.manager import settled
from coupling.model import Model
from coupling.simulation import Stopped, windows

Array = NDArray[np.float64]

SOLID = ("solid", "calculix")
"""Thermal solvers whose temperatures are those of nodes in three dimensions."""


def history(model: Model) -> History:
    """Temperatures that a scene has.

    In statics and for modes those that the conditions hold at the end; in dynamics those of a run
    of the scene, window by window.

    Raises
    ------
    BadCase : no heat is held, or the run stopped
    """
    moving = model.scene.analysis.kind == "dynamics"
    if model.pair.heat_solver is None:
        return _named(model, np.array([0.0, model.end if moving else 1.0]), [np.zeros(0)] * 2)
    if moving:
        return _named(model, *_run(model))
    start = model.pair.heat_solver.initial()
    try:
        end = settled(model.pair, start, model.end, None)
    except ValueError as error:
        text = str(error).removeprefix("heat: ")
        raise BadCase(str(model.scene.folder), [Problem("thermal", text)]) from None
    return _named(model, np.array([0.0, 1.0]), [start, end])


def _run(model: Model) -> tuple[Array, list[Array]]:
    """Times [s], and temperatures of the heat at them."""
    state = model.initial()
    times, fields = [0.0], [state.T]
    for window in windows(model, state):
        if isinstance(window, Stopped):
            text = f"our own run stopped at t = {window.t:.9g} s: {window.why}"
            raise BadCase(str(model.scene.folder), [Problem("", text)])
        times.append(window.t)
        fields.append(window.state.T)
    return np.array(times), fields


def _named(model: Model, times: Array, fields: list[Array]) -> History:
    """The same temperatures by body: sections, and nodes in three dimensions."""
    sections = np.array([model.pair.transfer.read(T) for T in fields])
    layout, table, solver = model.layout, model.scene.thermal, model.pair.heat_solver
    flexible = [name for name in layout.bodies if name in layout.point_index]
    named = {name: sections[:, layout.point_index[name]] for name in flexible}
    if table is None or solver is None or table.solver not in SOLID:
        return History(times, named)
    values = np.array(fields)
    own = [name for name in flexible if name in solver.regions]
    return History(
        times,
        named,
        {name: solver.x[solver.regions[name]] for name in own},
        {name: values[:, solver.regions[name]] for name in own},
    )
