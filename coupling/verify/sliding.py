"""A turning journal, pressed against its bearing, whose friction heats both.

The journal turns at a constant rate about its axis; a guide takes the reaction to the friction,
so that the normal force is the load and the power is mu(T) F v at all times. Journal and bearing
are lumps, joined to one another and the bearing to the surroundings by conductances.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

import thermal.description as heat
from coupling.manager import SCHEMES, Coupled, Pair, initial
from coupling.transfer import transfer
from coupling.verify.models import ROOM, elastic, straight
from mechanics.description import (
    ClearanceRevolute,
    Description,
    Force,
    Friction,
    Guide,
    NormalContact,
    Site,
)
from mechanics.dynamics import Control
from mechanics.schemes import Scheme
from mechanics.solver import Mechanics
from meshes.materials import Material, constant_material
from meshes.sections import circle
from thermal import solvers
from thermal.description import DEFAULT, Settings

Array = NDArray[np.float64]

ALUMINIUM = constant_material("aluminium", 2700.0, 69e9, 0.33, 0.0, 167.0, 896.0)
STEEL = constant_material("steel", 8000.0, 193e9, 0.29, 0.0, 16.2, 500.0)
RADIUS, RATE = 0.05, 0.05  # [m], [rad/s]
REGULARISATION = 1e-8  # [m/s]
AXIS = np.array([0.0, 0.0, 1.0])
SIDES = ("hinge.journal", "hinge.bearing")


@dataclass(frozen=True)
class Sliding:
    """Materials, masses [kg], friction, load [N]; conductances [W/K] between and outwards."""

    materials: tuple[Material, Material]
    masses: tuple[float, float]
    friction: float
    load: float
    slope: float = 0.0
    film: float = 0.0
    outwards: float = 0.0

    def build(self) -> Pair:
        """The two solvers and their transfer."""
        return self.stepped(_CONTROL, DEFAULT)

    def stepped(self, control: Control, settings: Settings) -> Pair:
        """The same with steps of motion and of heat as given."""
        motion = Mechanics(self._motion(), control)
        lumps = solvers.build("lumped", self._heat(), settings)
        rest = np.full(len(motion.x), ROOM)
        read = transfer(lumps.x, lumps.regions, motion.x, motion.axes, motion.regions, rest)
        return Pair(lumps, motion, read)

    def _motion(self) -> Description:
        stiffness, clearance, x = 1e11, 1e-4, np.array([1.0, 0.0, 0.0])
        depth = (self.load / stiffness) ** (2.0 / 3.0)
        body = straight(
            0.1, 1, circle(RADIUS), elastic(2e11, 0.3, 7800.0), direction=AXIS, normal=x
        )  # fmt: skip
        hinge = ClearanceRevolute(
            "hinge", Site("beam"), Site(None, position=-(clearance + depth) * x), AXIS, RADIUS,
            clearance, *self.materials, ROOM, NormalContact(value=stiffness),
            Friction(self.friction, self.slope, ROOM, REGULARISATION), lambda t: RATE * t,
        )  # fmt: skip
        slide = Guide("slide", Site("beam"), np.array([[0.0, 1.0, 0.0]]))
        press = Force("press", Site("beam"), x, lambda t: self.load)
        return Description([replace(body, spin=RATE * AXIS)], [hinge, slide], [press])

    def _heat(self) -> heat.Description:
        zero, (journal, bearing) = np.zeros(3), (heat.Place(side) for side in SIDES)
        parts = [
            heat.Part(side, zero, material, mass, ROOM)
            for side, material, mass in zip(SIDES, self.materials, self.masses, strict=True)
        ]
        links = []
        if self.film > 0.0:
            links.append(heat.Link("film", journal, bearing, self.film))
        if self.outwards > 0.0:
            links.append(heat.Link("mount", bearing, lambda t: ROOM, self.outwards))
        return heat.Description((), parts, links)

    def run(self, scheme: str, end: float, windows: int) -> tuple[Pair, Coupled]:
        """State after ``windows`` windows of a coupling scheme."""
        pair = self.build()
        state, h = initial(pair), end / windows
        for k in range(windows):
            new, why = SCHEMES[scheme](pair, state, k * h, h, None)
            if new is None:
                raise RuntimeError(why)
            state = new
        return pair, state

    def exact(self, end: float) -> Array:
        """Temperatures (2,) [K] of journal and bearing, by DOP853."""
        capacity = [m.heat_capacity(ROOM) for m in self.materials] * np.array(self.masses)
        speed = RATE * RADIUS
        power = self.friction * self.load * speed**2 / (speed + REGULARISATION)
        shares = np.array([_effusivity(m) for m in self.materials])
        shares /= shares.sum()

        def rate(t: float, T: Array) -> Array:
            made = shares * power * (1.0 + self.slope * (T.mean() - ROOM))
            through = self.film * (T[0] - T[1]) * np.array([-1.0, 1.0])
            return (made + through - self.outwards * np.array([0.0, T[1] - ROOM])) / capacity

        found = solve_ivp(rate, (0.0, end), [ROOM, ROOM], "DOP853", rtol=1e-12, atol=1e-10)
        return found.y[:, -1]


def _effusivity(material: Material) -> float:
    k, c = material.conductivity(ROOM), material.heat_capacity(ROOM)
    return float(np.sqrt(k * material.density * c))


_CONTROL = Control(1e-5, 2.0, 1e-9, Scheme(newton_tolerance=1e-12))
