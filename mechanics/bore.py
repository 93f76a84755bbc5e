"""A pin in the bore of a solid body: contact over the surface of the bore, friction and its heat.

The bore is the surface of a ``Continuum``, facet by facet; the pin is a cylinder that a section
carries. At the points of a quadrature of each facet a penalty gives the pressure from the depth,
with the hysteresis of the impact that runs, and one of the laws of friction the shear, with a
memory of its own at every point where the law has one: the pin sticks and does not creep.
``mechanics.bore_kernels`` has the forces.

For the integrator the whole bore is one contact, that of its deepest point: impacts begin, are
resolved and end with it, and it carries the approach speed. A contact for each point would land a
step wherever the edge of the pressed region passes one, which is no event: pressure begins there
from zero. The points follow it as contacts without events. They carry the history of friction, and
the work that is booked for each of them says where its heat arises. The depth of a point is its gap
less the radius of the pin.

Response of the first contact: the way to the wall is that of the deepest point (its second
component is the integral of pressure [N]), the elastic force the resultant of all pressure, the
first component of the moment that of friction about the axis, friction and its mean slip the sums
over the points along global directions.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from mechanics import bore_kernels as kernels
from mechanics import contact
from mechanics.bore_kernels import HALF, RIM, SHAPES, SPAN
from mechanics.contact_laws import (
    ACTIVE,
    CORE,
    FACTOR,
    FRICTION,
    LAW,
    POWER,
    RADIUS,
    REFERENCE,
    SLOT,
    K,
    P,
)
from mechanics.description import BoreContact, Continuum
from mechanics.directions import direction, fixed, normal_to, unit
from mechanics.layout import Layout, Side
from mechanics.march import DISSIPATIVE, ELASTIC

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

FACETS = {8: "ElementQuadS2", 9: "ElementQuad2"}
"""Element of scikit-fem for facets with so many nodes."""
DEGREE = 5
"""Degree of the quadrature: three by three points."""
ROUNDING = 0.1
"""Radius of the rims of the pin, in its own [-]."""
LEAST = 1e-3
"""Least distance from which depth is counted on the way into contact, in radii: that of a pin that
has no clearance [-]."""


class Facets(NamedTuple):
    """Surface of a bore with q points in each of its n_f facets, in the reference.

    nodes : (n_f, l) int  first coordinates;  rows : (n_f, l) int  among the temperatures
    values : (q, l) float [-]  shape functions
    areas : (n_f, q) float [m^2];  places : (n_f, q, 3) float [m]
    """

    nodes: Indices
    rows: Indices
    values: Array
    areas: Array
    places: Array


@dataclass(frozen=True, eq=False)
class Bore:
    """The contact of a pin in a bore as a term of one element.

    Attributes
    ----------
    joint : as it is described;  pin : what carries it
    dofs : (1, k) int  coordinates of the pin, then of the bore
    pattern_dofs : (n_f, k) int  of each facet, then of the pin; rows of its ``slots``
    clearance : float [m]  least radial gap in the reference
    length : float [m]  of the bore along the axis
    journal : row of the temperature of the pin
    frame : (2, 3) float  axis of the pin and a direction across it, in the reference
    body : (n_b,) int  first coordinates of the nodes of the bore's body
    """

    joint: BoreContact
    pin: Side
    facets: Facets
    frame: Array
    dofs: Indices
    pattern_dofs: Indices
    ints: NDArray[np.int64]
    floats: Array
    clearance: float
    length: float
    journal: int
    body: Indices
    name: str = "bore"
    symmetric: bool = False
    force: int = kernels.add_force
    tangent: int = kernels.add_tangent
    energy: int = kernels.add_energy
    respond: int = kernels.respond
    remember: int = kernels.remember

    @property
    def names(self) -> list[str]:
        """Name of the joint."""
        return [self.joint.name]

    @property
    def slots(self) -> int:
        """The contact and its points."""
        return 1 + self.facets.areas.size

    @property
    def contact_names(self) -> list[str]:
        """The joint itself, then its points."""
        points = (f"{self.joint.name}.point_{i:04d}" for i in range(self.facets.areas.size))
        return [self.joint.name, *points]

    def coefficients(self, T: Array) -> Array:
        """(1, slots SLOT) columns of ``contact_laws`` at section temperatures (m, 3)."""
        joint, row = self.joint, np.zeros((self.slots, SLOT))
        pin = float(T[self.journal, 0])
        strain = joint.journal_material.thermal_strain(pin, joint.reference_temperature)
        row[:, ACTIVE], row[:, RADIUS] = 1.0, joint.pin_radius * (1.0 + strain)
        row[:, LAW] = POWER
        row[0, K], row[0, P] = self._as_a_whole()
        row[1:, K], row[1:, P] = joint.stiffness * self.facets.areas.ravel(), 1.0
        row[:, FACTOR] = contact.DISSIPATION[joint.dissipation](joint.restitution)
        row[:, REFERENCE] = joint.reference_speed or 0.0
        means = 0.5 * (pin + self._temperatures(T))
        each, which = np.unique(means, return_inverse=True)
        rubbing = np.array([contact.friction_columns(joint.friction, float(t)) for t in each])
        row[1:, FRICTION:CORE] = rubbing[which.ravel()]
        row[0, FRICTION:CORE] = rubbing[0]
        return row.reshape(1, -1)

    def with_rates(self, c0: Array, c1: Array, h: float) -> tuple[Array, Array]:
        """The coefficients as they are: contacts have no free strains."""
        return c0, c1

    def deposit(self, T: Array, work: Array, response: Array) -> Array:
        """(m,) float [J]  heat at the temperature points from ``work`` (slots,) [J] of friction.

        It is shared at each point of the bore by the temperatures there; what the bore takes goes
        to the nodes of the facet as a flux through it would.
        """
        heat, joint, done = np.zeros(len(T)), self.joint, work[1:]
        materials, pin = (joint.journal_material, joint.bearing_material), float(T[self.journal, 0])
        there, shares = self._temperatures(T), np.zeros((len(done), 2))
        for k in np.flatnonzero(done):
            shares[k] = contact.heat_shares(joint.friction, materials, (pin, float(there[k])))
        heat[self.journal] = shares[:, 0] @ done
        into = (shares[:, 1] * done).reshape(self.facets.areas.shape)
        np.add.at(heat, self.facets.rows, into @ self.facets.values)
        return heat

    def pressures(self, response: Array) -> Array:
        """(n_f, q) float [N/m^2] at the points, from the response (slots, columns)."""
        force = response[1:, ELASTIC] + response[1:, DISSIPATIVE]
        return force.reshape(self.facets.areas.shape) / self.facets.areas

    def masses(self, mass: csr_array) -> Array:
        """(slots,) [kg]  of pin and bore as they meet; points have their part of it.

        The bore takes part as a whole: what its surface gives way makes impacts last longer.
        """
        diagonal, areas = mass.diagonal(), self.facets.areas.ravel()
        heavy = diagonal[self.pin.vectors] > 0.0
        give = float(np.sum(self.pin.weights[0, heavy] ** 2 / diagonal[self.pin.vectors[heavy]]))
        whole = 1.0 / (give + float(np.mean(1.0 / diagonal[self.body]) / self.body.size))
        return whole * np.concatenate([[1.0], areas / areas.sum()])

    def pushes(self, n: int) -> list[Array | None]:
        """A unit force on the pin across its axis, and its reaction on all nodes of the bore."""
        push, across = np.zeros(n), self.frame[1]
        at = self.pin.vectors[:, None] + np.arange(3)
        np.add.at(push, at, self.pin.weights[0][:, None] * across)
        push[self.body[:, None] + np.arange(3)] -= across / self.body.size
        return [push[None], *[None] * (self.slots - 1)]

    def _temperatures(self, T: Array) -> Array:
        """(n_f q,) [K]  of the bore at its points."""
        return (T[self.facets.rows, 0] @ self.facets.values.T).ravel()

    def _as_a_whole(self) -> tuple[float, float]:
        """K and exponent of all points together, to estimate how long impacts last.

        A parabola pressed into an even foundation, 4/3 k l sqrt(2 R') δ^(3/2), 1/R' = 1/R - 1/(R +
        c); a pin without clearance meets π k l R all round.
        """
        k, R, c = self.joint.stiffness * self.length, self.joint.pin_radius, self.clearance
        if c <= LEAST * R:
            return np.pi * k * R, 1.0
        return 4.0 / 3.0 * k * float(np.sqrt(2.0 * R * (R + c) / c)), 1.5


def build(joints: Sequence[BoreContact], layout: Layout) -> list[Bore]:
    """A term for each contact; one that cannot be made is a ``ValueError``."""
    found = []
    for joint in joints:
        try:
            found.append(_term(joint, layout))
        except ValueError as problem:
            raise ValueError(f"joint {joint.name!r}: {problem}") from None
    return found


def _term(joint: BoreContact, layout: Layout) -> Bore:
    _check(joint)
    pin, facets = layout.site(joint.pin), _facets(joint, layout)
    axis = unit(np.asarray(joint.axis, float))
    frame = np.array([axis, normal_to(axis, pin.triad)])
    away = facets.places - pin.position
    along = away @ axis
    gaps = np.linalg.norm(away - along[..., None] * axis, axis=-1) - joint.pin_radius
    clearance = float(gaps.min())
    pinned, bored = (v[..., None] + np.arange(3) for v in (pin.vectors, facets.nodes))
    every = np.concatenate([pinned.ravel(), np.unique(bored)])
    mine = np.tile(pinned.ravel(), (len(facets.nodes), 1))
    return Bore(
        joint=joint,
        pin=pin,
        facets=facets,
        frame=frame,
        dofs=every[None],
        pattern_dofs=np.concatenate([bored.reshape(len(bored), -1), mine], axis=1),
        ints=_ints(pin, facets),
        floats=_floats(joint, pin, facets, frame, clearance),
        clearance=clearance,
        length=float(np.ptp(layout.q0[bored] @ axis)),
        body=layout.node_dofs[joint.body],
        journal=int(layout.point_index[f"{joint.name}.journal"][0]),
    )


def _ints(pin: Side, facets: Facets) -> NDArray[np.int64]:
    sizes = [pin.vectors.size, len(facets.nodes), *facets.values.shape]
    return np.concatenate([sizes, pin.vectors, facets.nodes.ravel()]).astype(np.int64)[None]


def _floats(joint: BoreContact, pin: Side, facets: Facets, frame: Array, clearance: float) -> Array:
    """Row of constants; see ``mechanics.bore_kernels``."""
    row = np.zeros(SHAPES)
    row[:3] = pin.position * pin.fixed
    row[3:17] = np.concatenate([_carried(pin, vector) for vector in frame])
    row[HALF] = 0.5 * joint.length if joint.length else np.inf
    row[RIM] = ROUNDING * joint.pin_radius
    row[SPAN] = max(clearance, LEAST * joint.pin_radius)
    return np.concatenate([row, facets.values.ravel(), pin.weights.T.ravel()])[None]


def _carried(pin: Side, vector: Array) -> Array:
    """A direction of the pin; that of a point mass stays as it is."""
    return fixed(vector) if pin.directions == 0 else direction(pin, vector)


def _facets(joint: BoreContact, layout: Layout) -> Facets:
    body = layout.bodies.get(joint.body)
    if not isinstance(body, Continuum):
        raise ValueError(f"{joint.body!r} is no solid body")
    facets = np.asarray(joint.facets, np.intp)
    if facets.ndim != 2 or facets.shape[1] not in FACETS or not facets.size:
        raise ValueError("the facets of a bore have 8 or 9 nodes each")
    if facets.min() < 0 or facets.max() >= len(body.points):
        raise ValueError(f"{joint.body!r} has {len(body.points)} nodes, its facets others")
    values, slopes, weights = _shape(facets.shape[1])
    X = np.asarray(body.points, float)[facets]
    first, second = np.einsum("qlt,fli->tfqi", slopes, X)
    areas = np.linalg.norm(np.cross(first, second), axis=-1) * weights
    nodes, rows = layout.node_dofs[joint.body][facets], layout.point_index[joint.body][facets]
    return Facets(nodes, rows, values, areas, np.einsum("ql,fli->fqi", values, X))


@cache
def _shape(nodes: int) -> tuple[Array, Array, Array]:
    """Shape functions (q, l), their slopes (q, l, 2) and the weights (q,) of a quadrature.

    Nodes are numbered as in ``meshes.families``.
    """
    import skfem
    from skfem.quadrature import get_quadrature

    element = getattr(skfem, FACETS[nodes])()
    corners = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    middles = 0.5 * (corners + np.roll(corners, -1, axis=0))
    places = np.vstack([corners, middles, [[0.5, 0.5]]])[:nodes]
    far = np.linalg.norm(element.doflocs[None] - places[:, None], axis=2)
    X, weights = get_quadrature(element.refdom, DEGREE)
    pairs = [element.lbasis(X, int(i)) for i in far.argmin(axis=1)]
    values = np.stack([v for v, _ in pairs], axis=-1)
    slopes = np.stack([np.stack(list(g)) for _, g in pairs], axis=-1)
    return np.ascontiguousarray(values), slopes.transpose(1, 2, 0), weights


def _check(joint: BoreContact) -> None:
    if not (joint.pin_radius > 0.0 and joint.stiffness > 0.0):
        raise ValueError("radius of the pin and stiffness are positive")
    if joint.length is not None and not joint.length > 0.0:
        raise ValueError("the length of the pin is positive")
    if joint.dissipation not in contact.DISSIPATION or not 0.0 < joint.restitution <= 1.0:
        raise ValueError(f"there is no restitution {joint.restitution:g} by {joint.dissipation!r}")
    if joint.friction is not None and joint.friction.law not in contact.FRICTION:
        raise ValueError(f"unknown friction {joint.friction.law!r}")
