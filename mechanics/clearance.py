"""Planar revolute joints with clearance in space.

The journal centre has coordinates y1, y2 in the bearing's plane and the journal turns by θ. With
ρ = |(y1, y2)|, n = (y1, y2)/ρ, τ = (−n2, n1, R):

    δ = ρ − c,   F = max(0, K δ^p (1 + D δ̇/v)),   v_t = τ·(ẏ1, ẏ2, θ̇),   S = μ v_t/(|v_t| + ε)

and the generalised force on (y1, y2, θ) is −F (n1, n2, 0) − F S τ. Virtual work carries it to the
coordinates of journal and bearing.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from mechanics import clearance_kernels as kernels
from mechanics import contact
from mechanics.description import ClearanceRevolute, Friction
from mechanics.directions import direction, normal_to, origin, unit, unit_direction
from mechanics.layout import Layout, Side

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

COEFFICIENTS = (
    "stiffness", "clearance", "friction", "factor", "radius", "exponent",
    "regularisation_speed", "reference_speed", "core", "approach",
)  # fmt: skip
"""Columns of ``Clearance.coefficients``: K, c, μ, D, R, p, ε, a given v (0: none), the core, and
the approach speed of the running impact, which the integrator writes (not positive: none)."""

CORE = 1e-6
"""Distance in clearances that the radius keeps at the centre, so that n is smooth there [-]:
ρ² = y1² + y2² + core²."""

COLUMNS = (
    "y1", "y2", "theta", "y1_rate", "y2_rate", "theta_rate", "clearance", "penetration", "rate",
    "elastic_force", "dissipative_force", "friction_force", "slip_speed",
)  # fmt: skip
"""Columns of ``Clearance.response``: position [m] and turn [rad, within ±π] of the journal in the
bearing with their rates, clearance c, penetration δ [m] and its rate [m/s], elastic and
dissipative part of the normal force, friction on the journal along τ [N], slip speed [m/s]."""


@dataclass(frozen=True, eq=False)
class Clearance:
    """All clearance joints of a system as one term.

    Attributes
    ----------
    names : joints
    dofs : (n_j, 6 K) int  coordinates of journal and bearing; -1 where absent
    points : (n_j, 2) int  rows of journal and bearing in the temperature array
    planes : (n_j, 2, 3) float  directions of y1 and y2 in the reference
    factors : (n_j,) float  D of the dissipation law and restitution of each joint
    sides : journal and bearing of each joint
    columns : names of the columns of a response
    """

    names: list[str]
    dofs: Indices
    ints: NDArray[np.int64]
    floats: Array
    points: Indices
    planes: Array
    joints: tuple[ClearanceRevolute, ...]
    factors: Array
    sides: tuple[tuple[Side, Side], ...]
    name: str = "clearance"
    symmetric: bool = False
    columns: tuple[str, ...] = COLUMNS
    force: int = kernels.add_force
    tangent: int = kernels.add_tangent
    energy: int = kernels.add_energy
    respond: int = kernels.respond

    def coefficients(self, T: Array) -> Array:
        """(n_j, 10) float, columns ``COEFFICIENTS``, for section temperatures ``T`` (m, 3)."""
        each = zip(self.joints, self.factors, T[self.points, 0], strict=True)
        return np.array([_coefficients(joint, D, *at) for joint, D, at in each])

    def with_rates(self, c0: Array, c1: Array, h: float) -> tuple[Array, Array]:
        """The coefficients as they are: contacts have no free strains."""
        return c0, c1

    def partition(self, T: Array) -> Array:
        """(n_j, 2) float [-]  share of the frictional heat of journal and bearing."""
        at = T[self.points, 0]
        weights = [_heat_weights(j, *t) for j, t in zip(self.joints, at, strict=True)]
        return np.array(weights) / np.sum(weights, axis=1, keepdims=True)

    def masses(self, mass: csr_array) -> Array:
        """(n_j,) [kg]  what meets in an impact: reduced mass of the two ends."""
        diagonal = mass.diagonal()
        inverse = [sum(_mobility(side, diagonal) for side in pair) for pair in self.sides]
        return 1.0 / np.array(inverse)


def _mobility(side: Side, diagonal: Array) -> float:
    """1/mass [1/kg] with which the point of a side gives way."""
    return float(np.sum(side.weights[0] ** 2 / diagonal[side.vectors]))


def build(joints: Sequence[ClearanceRevolute], layout: Layout) -> Clearance:
    """One term for all clearance joints; one that cannot be made is a ``ValueError``."""
    sides = tuple((layout.site(joint.journal), layout.site(joint.bearing)) for joint in joints)
    for joint in joints:
        _check(joint)
    planes = np.array([_plane(joint, *ab) for joint, ab in zip(joints, sides, strict=True)])
    K = max(side.vectors.size for pair in sides for side in pair)
    vectors = np.array([[_padded(side.vectors, K, -1) for side in pair] for pair in sides])
    components = np.where(vectors[..., None] >= 0, vectors[..., None] + np.arange(3), -1)
    parts = [[f"{joint.name}.{part}" for part in ("journal", "bearing")] for joint in joints]
    laws = [joint.contact for joint in joints]
    return Clearance(
        names=[j.name for j in joints],
        dofs=components.reshape(len(joints), -1).astype(np.intp),
        ints=np.array([_ints(pair, v) for pair, v in zip(sides, vectors, strict=True)], np.int64),
        floats=np.array([_floats(pair, p, K) for pair, p in zip(sides, planes, strict=True)]),
        points=np.array([[layout.point_index[p][0] for p in pair] for pair in parts], np.intp),
        planes=planes,
        joints=tuple(joints),
        factors=np.array([contact.DISSIPATION[w.dissipation](w.restitution) for w in laws]),
        sides=sides,
    )


def _padded(values: NDArray, K: int, absent: float) -> NDArray:
    return np.concatenate([values, np.full(K - len(values), absent)])


def _ints(pair: tuple[Side, Side], vectors: NDArray) -> NDArray:
    return np.concatenate([[side.vectors.size for side in pair], vectors.ravel()])


def _floats(pair: tuple[Side, Side], plane: Array, K: int) -> Array:
    """Row of constants of a joint; see ``mechanics.clearance_kernels``."""
    journal, bearing = pair
    turning = np.zeros(7) if not journal.directions else direction(journal, plane[0])
    directions = [unit_direction(bearing, e) for e in plane]
    weights = [_padded(side.weights.T.ravel(), 3 * K, 0.0) for side in pair]
    return np.concatenate([origin(*pair), turning, *directions, *weights])


def _check(joint: ClearanceRevolute) -> None:
    law = joint.contact
    known = law.stiffness in contact.EXPONENT and law.dissipation in contact.DISSIPATION
    if not known:
        raise ValueError(f"joint {joint.name!r}: unknown law {law.stiffness}, {law.dissipation}")
    if law.stiffness == "linear" and law.value is None:
        raise ValueError(f"joint {joint.name!r}: a linear contact needs its stiffness")


def _plane(joint: ClearanceRevolute, a: Side, b: Side) -> Array:
    """(2, 3) unit vectors along which y1 and y2 are measured in the reference."""
    axis = unit(joint.axis)
    if a.directions == 1:
        first = unit(a.triad[0] - (a.triad[0] @ axis) * axis)
    else:
        first = normal_to(axis, b.triad if not a.directions else a.triad)
    return np.array([first, np.cross(axis, first)])


def _coefficients(joint: ClearanceRevolute, factor: float, Tj: float, Tb: float) -> Array:
    """(10,) coefficients at journal and bearing temperature [K]."""
    law, reference = joint.contact, joint.reference_temperature
    strain = joint.journal_material.thermal_strain(Tj, reference)
    bore = joint.bearing_material.thermal_strain(Tb, reference)
    mu, eps = _friction(joint.friction, 0.5 * (Tj + Tb))
    return np.array([
        _stiffness(joint, Tj, Tb) if law.value is None else law.value,
        contact.thermal_clearance(joint.clearance, joint.radius, strain, bore),
        mu,
        factor,
        joint.radius * (1.0 + strain),
        contact.EXPONENT[law.stiffness],
        eps,
        law.reference_speed or 0.0,
        CORE * joint.clearance,
        0.0,
    ])  # fmt: skip


def _stiffness(joint: ClearanceRevolute, Tj: float, Tb: float) -> contact.Value:
    """Hertz stiffness [N/m^1.5] of the reference radii at both temperatures [K]."""
    radii = joint.radius, joint.radius + joint.clearance
    sides = (joint.journal_material, Tj), (joint.bearing_material, Tb)
    elastic = [f(T) for m, T in sides for f in (m.youngs_modulus, m.poissons_ratio)]
    return contact.hertz_stiffness(contact.hertz_radius(joint.contact.stiffness, *radii), *elastic)


def _friction(friction: Friction | None, T: float) -> tuple[float, float]:
    """Coefficient and regularisation speed [m/s] at the mean temperature."""
    if friction is None:
        return 0.0, 1.0
    mu = contact.friction_coefficient(
        T, friction.coefficient, friction.temperature_slope, friction.reference_temperature
    )
    return float(mu), friction.regularisation_speed


def _heat_weights(joint: ClearanceRevolute, Tj: float, Tb: float) -> tuple[float, float]:
    weight = contact.PARTITION[joint.friction.partition if joint.friction else "effusivity"]
    pairs = ((joint.journal_material, Tj), (joint.bearing_material, Tb))
    return tuple(weight(m.conductivity(T), m.density, m.heat_capacity(T)) for m, T in pairs)
