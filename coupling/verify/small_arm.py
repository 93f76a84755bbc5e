"""A small coupled scene with everything: drive, clearance, friction, sunlight, radiation, links."""

from pathlib import Path
from typing import NamedTuple

from coupling.casefile import from_text
from coupling.manager import Coupled
from coupling.model import Model, build
from coupling.simulation import Stopped, windows

CASE = """
[time]
end = "1 s"
window = "50 ms"

[coupling]
scheme = "corrected"

[integrator]
largest_step = "10 ms"
tolerance = 1e-6

[section.tube]
kind = "tube"
mean_radius = "50 mm"
thickness = "2 mm"

[body.arm]
kind = "beam"
start = [0, 0, 0]
end = ["2 m", 0, 0]
elements = 4
section = "tube"
material = "al6061-paper"
damping = "1 ms"

[joint.hinge]
kind = "clearance_revolute"
journal = { body = "arm", at = "start" }
axis = [0, 0, 1]
radius = "10 mm"
clearance = "0.05 mm"
journal_material = "steel-304"
bearing_material = "al6061-paper"
angle = { s_curve = { rate = "20 deg/s", rise = "0.3 s", total = "20 deg" } }

[joint.hinge.friction]
coefficient = 0.3
temperature_slope = "-1e-3 1/K"

[gravity]
acceleration = [0, "-9.81 m/s^2", 0]

[thermal]
initial = "25 degC"

[thermal.flux.sun]
body = "arm"
density = "1361 W/m^2"
absorptivity = 0.3
direction = [0, -1, 0]

[thermal.radiation.space]
body = "arm"
emissivity = 0.8
sink = "4 K"

[thermal.part.journal]
of = "hinge.journal"
material = "steel-304"
mass = "0.1 kg"
initial = "60 degC"

[thermal.part.bearing]
of = "hinge.bearing"
material = "al6061-paper"
mass = "0.2 kg"

[thermal.link.fitting]
a = { part = "journal" }
b = { body = "arm", at = "start" }
conductance = "2 W/K"

[thermal.link.film]
a = { part = "journal" }
b = { part = "bearing" }
conductance = "0.5 W/K"

[thermal.link.base]
a = { part = "bearing" }
temperature = "20 degC"
conductance = "1 W/K"
"""


class Ran(NamedTuple):
    """The model, its last state, and the sum of the heat exchanged in each window [J]."""

    model: Model
    state: Coupled
    exchanged: float


def run(scheme: str) -> Ran:
    """All windows of the case with a coupling scheme; an error if it stops."""
    text = CASE.replace('"corrected"', f'"{scheme}"')
    model = build(from_text(text, Path()))
    state, exchanged = model.initial(), 0.0
    for window in windows(model, state):
        if isinstance(window, Stopped):
            raise RuntimeError(window.why)
        new = window.state
        flows = [abs(q - state.flows.get(name, 0.0)) for name, q in new.flows.items()]
        exchanged += sum(flows) + new.deposited - state.deposited
        state = new
    return Ran(model, state, exchanged)
