"""The assembled mechanical system: M a + f(q, v, t) + Phi_q^T lambda = 0, Phi(q, t) = 0.

``f`` is the sum of the terms that the scene has: element families, clearance contact, and
external loads with a minus sign. Temperature enters through coefficient arrays, one per term,
that are evaluated at the ends of a coupling window and interpolated linearly inside it.
"""

from importlib import import_module
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from mechanics import joints as joint_rows
from mechanics.assembly import pattern, scatter
from mechanics.description import Beam, ClearanceRevolute, Description, Particle
from mechanics.elements import FAMILIES
from mechanics.factor import Solve, factorise
from mechanics.layout import Layout

Array = NDArray[np.float64]
Coefficients = tuple[Array, ...]

JOURNAL_SCALE = 1e3
"""Coordinates of a node in a clearance joint are measured in this many clearances [-]."""

REPEATED = 1e-9
"""A constraint of which no more than this part is new repeats those before it [-]."""


class Factors(NamedTuple):
    """Factors (1, cK, cC) with which mass, stiffness and damping enter a system matrix."""

    mass: float
    stiffness: float
    damping: float


class System:
    """Arrays and patterns of a description; holds nothing that changes while it moves.

    Attributes
    ----------
    n, m : int  number of coordinates and of constraints
    contact_mass : (n_j,) float [kg]  what meets in an impact of each clearance joint
    mass : (n, n) csr  constant mass matrix
    scale : (n,) float  size of each coordinate, for dimensionless norms
    """

    def __init__(self, description: Description):
        self.layout = Layout.of(description.bodies, description.joints)
        self.n = self.layout.ndof
        self.elements = _elements(description, self.layout)
        self.constraints = joint_rows.build(description.joints, self.layout)
        self.contact = _contact(description, self.layout)
        self.m = len(self.constraints.names)
        self.mass = self._mass(description)
        self.loads = _loads(description, self.layout, self.mass)
        self.scale = _scale(description, self.layout)
        self.contact_mass = self._contact_mass()
        self._lay_pattern()

    # -- building ------------------------------------------------------------------------------

    def _mass(self, description: Description) -> csr_array:
        rows, columns, values = [], [], []
        for term in self.elements:
            blocks = term.mass_blocks()
            k = term.dofs.shape[1]
            rows.append(np.repeat(term.dofs, k, axis=1).ravel())
            columns.append(np.tile(term.dofs, (1, k)).ravel())
            values.append(blocks.ravel())
        at, mass = _point_masses(description, self.layout)
        entries = [
            np.concatenate([*part, extra])
            for part, extra in ((rows, at), (columns, at), (values, mass))
        ]
        return csr_array((entries[2], (entries[0], entries[1])), shape=(self.n, self.n))

    def _contact_mass(self) -> Array:
        """(n_j,) [kg]  reduced mass of the two nodes of each clearance joint."""
        if self.contact is None:
            return np.zeros(0)
        dofs = self.contact.dofs[:, [0, 9]]
        inverse = np.where(dofs >= 0, 1.0 / self.mass.diagonal()[dofs], 0.0)
        return 1.0 / inverse.sum(axis=1)

    def _lay_pattern(self) -> None:
        size = self.n + self.m
        coo = self.mass.tocoo()
        row_of = np.arange(self.n, size)[:, None]
        dofs = self.constraints.dofs
        diagonal = np.arange(size)[:, None]
        pairs = [(coo.row[:, None], coo.col[:, None]), (diagonal, diagonal)]
        pairs += [(t.dofs, t.dofs) for t in self.elements]
        pairs += [(dofs, dofs), (dofs, row_of), (row_of, dofs)]
        tangents = [t for t in (self.contact, self.loads) if t is not None]
        pairs += [(t.dofs, t.dofs) for t in tangents]
        self.pattern, slots = pattern(size, pairs)
        self._mass_data = self.pattern.zeros()
        np.add.at(self._mass_data, slots[0].ravel(), coo.data)
        count = len(self.elements)
        self._element_slots = slots[2 : 2 + count]
        self._hessian_slots, self._column_slots, self._row_slots = slots[2 + count : 5 + count]
        self._extra_slots = slots[5 + count :]

    @property
    def apart(self) -> Array:
        """(n_j,) [m/s]  approach speeds while no impact runs: zeros."""
        return np.zeros(len(self.contact_mass))

    # -- temperature ---------------------------------------------------------------------------

    def coefficients(self, T: Array) -> Coefficients:
        """Coefficient arrays of all terms for section temperatures ``T`` (m, 3)."""
        terms = [*self.elements, *([self.contact] if self.contact else [])]
        return tuple(term.coefficients(T) for term in terms)

    def with_rates(
        self, c0: Coefficients, c1: Coefficients, h: float
    ) -> tuple[Coefficients, Coefficients]:
        """Coefficients at both ends of ``h`` [s] that know how fast free strains change."""
        pairs = [e.with_rates(a, b, h) for e, a, b in zip(self.elements, c0, c1, strict=False)]
        rest = len(self.elements)
        return (*(p[0] for p in pairs), *c0[rest:]), (*(p[1] for p in pairs), *c1[rest:])

    # -- forces and energies -------------------------------------------------------------------

    def force(self, q: Array, v: Array, t: float, coef: Coefficients, approach: Array) -> Array:
        """Internal, contact and minus external generalised force (n,)."""
        out = -self.external(q, t)
        for term, c in zip(self.elements, coef, strict=False):
            term.force(q, v, c, out)
        if self.contact is not None:
            self.contact.force(q, v, coef[-1], approach, out)
        return out

    def external(self, q: Array, t: float) -> Array:
        """Generalised force (n,) of loads and gravity."""
        out = np.zeros(self.n)
        if self.loads is not None:
            self.loads.external(q, t, out)
        return out

    def energy(self, q: Array, coef: Coefficients) -> tuple[float, float]:
        """Strain energy of the bodies and elastic energy of the contacts [J]."""
        strain = sum(e.energy(q, c) for e, c in zip(self.elements, coef, strict=False))
        return float(strain), self.contact.energy(q, coef[-1]) if self.contact is not None else 0.0

    def damping(self, q: Array, v: Array, coef: Coefficients) -> tuple[float, float]:
        """Powers [W] lost in structural damping, and done by it on the changing free strains."""
        powers = [e.damping(q, v, c) for e, c in zip(self.elements, coef, strict=False)]
        return sum(p[0] for p in powers), sum(p[1] for p in powers)

    def constraint_force(self, q: Array, t: float, lam: Array) -> Array:
        """Phi_q^T lambda (n,)."""
        out = np.zeros(self.n)
        self.constraints.add_force(q, t, lam, out)
        return out

    # -- the system matrix ---------------------------------------------------------------------

    def matrix(
        self,
        q: Array,
        v: Array,
        t: float,
        lam: Array,
        coef: Coefficients,
        approach: Array,
        factors: Factors,
    ) -> Array:
        """Data of [[cM M + cK K + cC C, Phi_q^T], [Phi_q, 0]] on ``pattern``."""
        data = factors.mass * self._mass_data
        cK, cC = factors.stiffness, factors.damping
        for term, c, slots in zip(self.elements, coef, self._element_slots, strict=False):
            blocks = np.empty(slots.shape)
            term.tangent(q, v, c, cK, cC, blocks)
            scatter(blocks, slots, data)
        self._add_extra(q, v, t, coef, approach, cK, cC, data)
        self._add_constraints(q, t, lam, cK, data)
        return data

    def _add_extra(self, q, v, t, coef, approach, cK, cC, data) -> None:
        extra = iter(self._extra_slots)
        if self.contact is not None:
            slots = next(extra)
            blocks = np.empty(slots.shape)
            self.contact.tangent(q, v, coef[-1], approach, cK, cC, blocks)
            scatter(blocks, slots, data)
        if self.loads is not None:
            slots = next(extra)
            blocks = np.empty(slots.shape)
            self.loads.tangent(q, t, -cK, blocks)
            scatter(blocks, slots, data)

    def _add_constraints(self, q: Array, t: float, lam: Array, cK: float, data: Array) -> None:
        rows = np.empty(self.constraints.dofs.shape)
        self.constraints.jacobian(q, t, rows)
        scatter(rows, self._column_slots, data)
        scatter(rows, self._row_slots, data)
        if lam.any():
            blocks = np.empty(self._hessian_slots.shape)
            self.constraints.hessian(q, t, lam, cK, blocks)
            scatter(blocks, self._hessian_slots, data)

    def factorise(self, data: Array) -> Solve | None:
        """Solver for [rhs (n), constraint rhs (m)], or None if the matrix is singular."""
        return factorise(self.pattern, data)

    def initial_acceleration(
        self, q: Array, v: Array, t: float, coef: Coefficients, approach: Array
    ) -> tuple[Array, Array] | None:
        """Accelerations (n,) and multipliers (m,) consistent with the constraints.

        The second time derivative of Phi along the motion is a central difference of Phi on
        the straight path q + v dt, which is exact for constraints quadratic in q.
        """
        factors = Factors(1.0, 0.0, 0.0)
        data = self.matrix(q, v, t, np.zeros(self.m), coef, approach, factors)
        solve = self.factorise(data)
        if solve is None:
            return None
        eps = 1e-4 * (1.0 + np.abs(q).max()) / (1.0 + np.abs(v).max())
        phi = [self.constraints.values(q + s * eps * v, t + s * eps) for s in (-1, 0, 1)]
        gamma = -(phi[0] - 2.0 * phi[1] + phi[2]) / eps**2
        x = solve(np.concatenate([-self.force(q, v, t, coef, approach), gamma]))
        return x[: self.n], x[self.n :]

    def repeated_joints(self) -> list[str]:
        """Joints that hold, in the reference, something that joints before them hold already."""
        rows = np.empty(self.constraints.dofs.shape)
        self.constraints.jacobian(self.layout.q0, 0.0, rows)
        dense = np.zeros((self.m, self.n + 1))  # the last column takes absent coordinates
        np.add.at(dense, (np.arange(self.m)[:, None], self.constraints.dofs), rows)
        scaled = dense[:, :-1] * self.scale
        scaled /= np.linalg.norm(scaled, axis=1, keepdims=True)
        new = np.zeros(self.m)
        new[: self.n] = np.abs(np.diagonal(np.linalg.qr(scaled.T, mode="r")))
        names = np.array(self.constraints.names, dtype=object)
        return list(dict.fromkeys(names[new < REPEATED]))

    def name_of(self, coordinate: int) -> str:
        """Body, node and joints of a coordinate, or joint of a constraint row."""
        if coordinate >= self.n:
            return f"joint {self.constraints.names[coordinate - self.n]}"
        held = np.any(self.constraints.dofs == coordinate, axis=1)
        joints = [self.constraints.names[row] for row in np.flatnonzero(held)]
        if self.contact is not None:
            loose = np.any(self.contact.dofs == coordinate, axis=1)
            joints += [self.contact.names[joint] for joint in np.flatnonzero(loose)]
        at = f" (joint {', '.join(dict.fromkeys(joints))})" if joints else ""
        return self.layout.name_of(coordinate) + at


def _elements(description: Description, layout: Layout) -> list:
    """One term for each element family that the scene uses."""
    beams = [b for b in description.bodies if isinstance(b, Beam)]
    found = []
    for family, where in FAMILIES.items():
        members = [b for b in beams if b.element == family]
        if members:
            module, function = where.split(":")
            build = getattr(import_module(module), function)
            found.append(build(members, layout.node_dofs, layout.point_index))
    return found


def _point_masses(description: Description, layout: Layout) -> tuple[NDArray[np.intp], Array]:
    """Coordinates of particles and the mass [kg] that each carries."""
    particles = [b for b in description.bodies if isinstance(b, Particle)]
    at = [layout.node_dofs[p.name][0] + np.arange(3) for p in particles]
    mass = [np.full(3, p.mass) for p in particles]
    return np.concatenate([np.zeros(0, np.intp), *at]), np.concatenate([np.zeros(0), *mass])


def _contact(description: Description, layout: Layout):
    """Clearance term, imported (and compiled) only when a joint has clearance."""
    loose = [j for j in description.joints if isinstance(j, ClearanceRevolute)]
    return import_module("mechanics.clearance").build(loose, layout) if loose else None


def _loads(description: Description, layout: Layout, mass: csr_array):
    if not description.loads and not np.any(description.gravity):
        return None
    return import_module("mechanics.loads").build(
        description.loads, description.gravity, layout, mass
    )


def _scale(description: Description, layout: Layout) -> Array:
    scale = layout.scale.copy()
    for joint in description.joints:
        if isinstance(joint, ClearanceRevolute):
            for site in (joint.journal, joint.bearing):
                if site.body is not None:
                    r = layout.node_dofs[site.body][site.node] + np.arange(3)
                    scale[r] = np.minimum(scale[r], JOURNAL_SCALE * joint.clearance)
    return scale
