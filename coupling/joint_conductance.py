"""Heat through joints with clearance: conductance by contact force, gap and temperature.

The contacts of a joint come and go within a coupling window; what the heat feels is the mean of
the conductance over the window's mechanical steps.
"""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from coupling.contact_tables import Sided
from coupling.contacts import contacts_of
from coupling.heat_tables import Contact
from coupling.materials_used import material_of
from coupling.scene import Scene
from meshes.materials import Material

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

CMY_EXPONENT, CMY_FACTOR = 0.95, 1.25


class Law(Protocol):
    """Conductance of a contact."""

    def __call__(self, force: Array, gap: Array, temperature: float) -> Array:
        """[W/K] by normal force [N], gap [m] (zero where it is closed) and temperature [K]."""
        ...


class Tabled(NamedTuple):
    """Conductance [W/K] over force where the contact is closed, over gap where it is open."""

    forces: tuple[float, ...]
    by_force: tuple[float, ...]
    gaps: tuple[float, ...]
    by_gap: tuple[float, ...]

    def __call__(self, force: Array, gap: Array, temperature: float) -> Array:
        found = np.interp(force, self.forces, self.by_force)
        return np.where(force > 0.0, found, np.interp(gap, self.gaps, self.by_gap))


class Pressed(NamedTuple):
    """Cooper, Mikic & Yovanovich (1969): h = 1.25 k m/sigma (p/H)^0.95, plastic asperities.

    k is the harmonic mean of both conductivities, p = F/A.

    roughness, slope : combined rms height sigma [m] and slope m [-] of the asperities
    hardness : of the softer side, H [Pa]
    area : nominal, A [m^2]
    """

    roughness: float
    slope: float
    hardness: float
    area: float
    journal: Material
    bearing: Material

    def __call__(self, force: Array, gap: Array, temperature: float) -> Array:
        k1 = float(self.journal.conductivity(temperature))
        k2 = float(self.bearing.conductivity(temperature))
        h = CMY_FACTOR * 2.0 * k1 * k2 / (k1 + k2) * self.slope / self.roughness
        pressure = np.maximum(force, 0.0) / self.area
        return h * self.area * (pressure / self.hardness) ** CMY_EXPONENT


class Joint(NamedTuple):
    """A joint whose contacts conduct.

    name : of the thermal link
    contacts : (k,) intp  among all contacts
    points : (2,) intp  of journal and bearing, among the points that carry a temperature
    """

    name: str
    contacts: Indices
    points: Indices
    law: Law


class JointConductance:
    """Mean conductance of joints over what their contacts did.

    contacts : int  how many there are at least
    """

    def __init__(self, joints: Sequence[Joint]) -> None:
        self.joints = list(joints)
        self.contacts = 1 + max((int(joint.contacts.max()) for joint in joints), default=-1)

    def at(self, force: Array, gap: Array, T: Array) -> dict[str, Array]:
        """Conductance (k,) [W/K] of each joint at k times, by the name of its link.

        Parameters
        ----------
        force, gap : (k, n_c) float [N], [m]  of all contacts; no gap where closed
        T : (m,) float [K]  at the points that carry a temperature
        """
        return {
            joint.name: joint.law(
                force[:, joint.contacts], gap[:, joint.contacts], float(T[joint.points].mean())
            ).sum(axis=1)
            for joint in self.joints
        }

    def start(self, T: Array) -> dict[str, Array]:
        """As ``mean`` of open contacts that touch nothing."""
        nothing = np.zeros((1, self.contacts))
        return {name: np.repeat(G, 2) for name, G in self.at(nothing, nothing, T).items()}

    def mean(
        self, before: Mapping[str, Array], durations: Array, force: Array, gap: Array, T: Array
    ) -> dict[str, Array]:
        """Mean conductance over steps, straight within each, and conductance at their end (2,).

        Parameters
        ----------
        before : what this gave for the steps before
        durations : (k,) float [s]  of the steps
        force, gap, T : at the ends of the steps, as in ``at``
        """
        found = {}
        for name, ends in self.at(force, gap, T).items():
            G = np.concatenate([before[name][1:], ends])
            mean = 0.5 * durations @ (G[:-1] + G[1:]) / durations.sum()
            found[name] = np.array([mean, ends[-1]])
        return found


def joint_conductance(scene: Scene, motion_solver: Any) -> JointConductance:
    """The joints of the [thermal.contact.NAME] of a scene."""
    assert scene.thermal is not None
    contacts = contacts_of(scene, motion_solver.system)
    return JointConductance(
        [
            Joint(
                f"contact.{name}",
                np.array([c.row for c in contacts if c.joint == table.joint]),
                _points(motion_solver, table.joint),
                _law(scene, table),
            )
            for name, table in scene.thermal.contact.items()
        ]
    )


def _points(motion_solver: Any, joint: str) -> Indices:
    sides = (motion_solver.regions[f"{joint}.{side}"] for side in ("journal", "bearing"))
    return np.concatenate([np.atleast_1d(side) for side in sides])


def _law(scene: Scene, table: Contact) -> Law:
    if table.by_force is not None:
        forces, by_force = zip(*table.by_force, strict=True)
        gaps, by_gap = zip(*(table.by_gap or [(0.0, 0.0)]), strict=True)
        return Tabled(forces, by_force, gaps, by_gap)
    joint = scene.joint[table.joint]
    assert isinstance(joint, Sided)
    assert table.roughness and table.slope and table.hardness and table.area
    return Pressed(
        table.roughness, table.slope, table.hardness, table.area,
        material_of(scene, joint.journal_material), material_of(scene, joint.bearing_material),
    )  # fmt: skip
