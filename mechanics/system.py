"""The assembled mechanical system: M a + f(q, v, t) + Phi_q^T lambda = 0, Phi(q, t) = 0.

Everything in it is a term: a family of elements, joints, springs, loads or contacts with its data
in flat arrays and its kernels known by address (``mechanics.kernels``). Temperature enters through
coefficient arrays, one per term, that are evaluated at the ends of a coupling window and
interpolated linearly inside it; functions of time are written into them before every use.
"""

import ctypes
from collections.abc import Sequence
from copy import copy
from importlib import import_module
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, kron

from mechanics import factor, march
from mechanics.assembly import pattern
from mechanics.description import (
    BoreContact,
    Bushing,
    Clearance,
    Continuum,
    Description,
    Flexible,
    History,
    Particle,
    Pulley,
    ReferencePoint,
    RigidBody,
    Spring,
    Telescope,
    TorsionSpring,
)
from mechanics.elements import FAMILIES
from mechanics.kernels import INTERRUPTS, callback
from mechanics.layout import Layout

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
Coefficients = tuple[Array, ...]

HOLDING = 1
"""Column of the coefficients of a latch that says whether it holds."""
REFACTOR = {True: 3, False: 8}
"""What a tangent and its factorisation cost, in corrections: dense and sparse. Measured."""
LARGE = 1000
"""Unknowns above which half the factors are worth a Jacobian that is not exact [-]."""
JOURNAL_SCALE = 1e3
"""Coordinates of a node in a clearance joint are measured in this many clearances [-]."""

FOLLOWERS = 4
"""Patterns that are kept for contacts that go to and fro [-]."""


class Factors(NamedTuple):
    """Factors (1, cK, cC) with which mass, stiffness and damping enter a system matrix."""

    mass: float
    stiffness: float
    damping: float


class System:
    """Arrays and patterns of a description; holds nothing that changes while it moves.

    Attributes
    ----------
    layout : Layout
    n, m : int  number of coordinates and of constraints
    terms : list  everything that makes forces or holds
    elements : list  those of them that are flexible bodies
    contacts : terms of the joints with clearance
    contact_names : (n_c,) str  their contacts: joint, with the place where it has several
    mass : (n, n) csr  constant mass matrix
    scale : (n,) float  size of each coordinate, for dimensionless norms
    row_names : (m,) str  joint or body of each multiplier
    driven : (k,) int  rows that depend on time
    columns : number of coefficients of an element of each term
    limits : coordinates of joints that have a meaning in a range only
    """

    def __init__(self, description: Description, solver: str = "auto"):
        self.layout = Layout.of(description.bodies, description.joints)
        self.n = self.layout.ndof
        self.elements = _elements(description, self.layout)
        holding = _rigid(description, self.layout) + _ties(description, self.layout)
        first = self.n + sum(term.rows for term in holding)
        holding += _frames(self.elements, self.layout, first)
        holding += _joints(description, self.layout, self.n + sum(term.rows for term in holding))
        self.m = sum(term.rows for term in holding)
        self._inertia = _inertia([*self.elements, *holding], _points(description, self.layout))
        self.mass = _mass(self.n, self._inertia)
        self.contacts = _contacts(description, self.layout)
        self.contact_names = [name for term in self.contacts for name in term.contact_names]
        loads = _loads(description, self.layout, self.mass)
        springs = _springs(description, self.layout, self.n + self.m)
        damping = _rayleigh(description, self.elements, self.layout)
        self.terms = [*self.elements, *damping, *holding, *springs, *loads, *self.contacts]
        self.scale = _scale(description, self.layout)
        self.row_names, self.driven = _rows(self.n, self.m, holding)
        self.limits = [limit for term in holding for limit in getattr(term, "limits", ())]
        self.pattern, self._mass_slots, self._slots = _pattern(self)
        blocks, stages, ranks = _blocks(self)
        self._prefer = solver
        self.solver = factor.choose(self.pattern, blocks, _symmetry(self), solver, ranks, stages)
        self._evaluated: list[tuple[Array, Coefficients]] = []
        self._followers: dict[tuple[bytes, ...], System] = {}
        room = np.tile([293.15, 0.0, 0.0], (len(self.layout.x), 1))
        self.columns = [c.shape[1] for c in self.coefficients(room)]
        self._histories = _histories(self.terms, self.columns)
        self.program = _program(self)
        self.packed = march.pack(self.program)
        if self.contacts:
            mobility = import_module("mechanics.meeting").mobility(self, self.coefficients(room))
            self.program = self.program._replace(mobility=mobility)
            self.packed = march.pack(self.program)
        self._densities = _densities(description, self.elements, self.layout)

    # -- temperature and time ------------------------------------------------------------------

    def coefficients(self, T: Array) -> Coefficients:
        """Coefficient arrays of all terms for section temperatures ``T`` (m, 3).

        The last two are remembered: the end of a window is the beginning of the next.
        """
        for known, coef in self._evaluated:
            if np.array_equal(known, T):
                return coef
        coef = tuple(np.ascontiguousarray(term.coefficients(T), float) for term in self.terms)
        self._evaluated = [(T.copy(), coef), *self._evaluated[:1]]
        return coef

    def with_rates(
        self, c0: Coefficients, c1: Coefficients, h: float
    ) -> tuple[Coefficients, Coefficients]:
        """Coefficients at both ends of ``h`` [s] that know how fast free strains change."""
        pairs = [t.with_rates(a, b, h) for t, a, b in zip(self.terms, c0, c1, strict=True)]
        return tuple(p[0] for p in pairs), tuple(p[1] for p in pairs)

    def timed(self, coef: Coefficients, t: float) -> Coefficients:
        """Coefficients with the functions of time at ``t`` [s]."""
        changed = list(coef)
        for k, term in enumerate(self.terms):
            for row, column, history in getattr(term, "signals", ()):
                changed[k] = changed[k].copy() if changed[k] is coef[k] else changed[k]
                changed[k][row, column] = _value(history, t)
        return tuple(changed)

    def following(self, q: Array) -> "System":
        """This system, with room in its matrices for contacts where they are at ``q`` (n,).

        It follows from ``q`` alone, and differs in nothing but the pattern of matrices.
        """
        at = tuple(t.bands(q) if hasattr(t, "bands") else b"" for t in self.contacts)
        if not any(at):
            return self
        if not self._followers:
            self._followers[tuple(getattr(t, "band", b"") for t in self.contacts)] = self
        if at not in self._followers:
            if len(self._followers) >= FOLLOWERS:
                del self._followers[next(iter(self._followers))]
            self._followers[at] = _arranged(self, at)
        return self._followers[at]

    def packed_at(self, T: Array) -> march.Packed:
        """The program with the masses at section temperatures ``T`` (m, 3)."""
        if not self._densities:
            return self.packed
        count = len(self.elements)
        scaled = [
            (dofs, blocks * density.factors(T)[:, None, None])
            for (dofs, blocks), density in zip(self._inertia, self._densities, strict=False)
        ]
        mass = _mass(self.n, [*scaled, *self._inertia[count:]])
        data = self.pattern.zeros()
        np.add.at(data, self._mass_slots, mass.tocoo().data)
        return march.pack(self.program._replace(mass=_vectorwise(mass)[-1], mass_data=data))

    # -- forces, energies, matrices ------------------------------------------------------------

    def residual(self, y: Array, v: Array, t: float, coef: Coefficients) -> Array:
        """(n + m,)  f + Phi_q^T lambda, and Phi."""
        out = np.zeros(self.n + self.m)
        march.forces(self.packed, y, v, flat(self.timed(coef, t)), -1, out)
        return out

    def external(self, y: Array, t: float, coef: Coefficients) -> Array:
        """(n,) generalised force of loads and gravity."""
        out = np.zeros(self.n + self.m)
        v = np.zeros_like(y)
        march.forces(self.packed, y, v, flat(self.timed(coef, t)), march.LOAD, out)
        return -out[: self.n]

    def constraints(self, y: Array, t: float, coef: Coefficients) -> Array:
        """(m,)  Phi [m] or [1]."""
        return self._holding(y, t, coef)[self.n :]

    def constraint_force(self, y: Array, t: float, coef: Coefficients) -> Array:
        """(n,)  Phi_q^T lambda."""
        return self._holding(y, t, coef)[: self.n]

    def _holding(self, y: Array, t: float, coef: Coefficients) -> Array:
        out = np.zeros(self.n + self.m)
        rest = np.zeros_like(y)
        march.forces(self.packed, y, rest, flat(self.timed(coef, t)), march.CONSTRAINT, out)
        return out

    def energies(self, y: Array, v: Array, coef: Coefficients) -> Array:
        """(4,) energy of bodies and of contacts [J], power lost, power on free strains [W]."""
        out = np.zeros(4)
        march.energies(self.packed, y, v, flat(coef), out)
        return out

    def matrix(self, y: Array, v: Array, t: float, coef: Coefficients, factors: Factors) -> Array:
        """Data of [[cM M + cK K + cC C, Phi_q^T], [Phi_q, 0]] on ``pattern``."""
        data = self.pattern.zeros()
        now = flat(self.timed(coef, t))
        cM, cK, cC = map(float, factors)
        march.matrix(self.packed, y, v, now, cM, cK, cC, data)
        return data

    def jacobian(self, y: Array, t: float, coef: Coefficients) -> csr_array:
        """(m, n) csr  Phi_q."""
        data = self.matrix(y, np.zeros_like(y), t, coef, Factors(0.0, 0.0, 0.0))
        return self.pattern.matrix(data).tocsr()[self.n :, : self.n]

    def factorise(self, data: Array) -> factor.Solve | None:
        """Solver for [rhs (n), constraint rhs (m)], or None if the matrix is singular."""
        return self.solver.factorise(data)

    def unknowns(self, q: Array, lam: Array | None = None) -> Array:
        """(n + m,) of coordinates and multipliers (default: zero)."""
        return np.concatenate([q, np.zeros(self.m) if lam is None else lam])

    def respond(self, y: Array, v: Array, coef: Coefficients) -> Array:
        """(n_c, 32) response of the contacts, columns of ``mechanics.march``."""
        response = np.zeros((len(self.contact_names), march.COLUMNS))
        march.respond(self.packed, y, v, flat(coef), response)
        return response

    def contact_rows(self, term: Any) -> slice:
        """Which of all contacts are those of a term of ``contacts``."""
        before = self.contacts[: self.contacts.index(term)]
        first = sum(len(other.contact_names) for other in before)
        return slice(first, first + len(term.contact_names))

    # -- names ---------------------------------------------------------------------------------

    def name_of(self, index: int) -> str:
        """Body, node and joints of a coordinate, or joint of a constraint row."""
        if index >= self.n:
            return f"joint {self.row_names[index - self.n]}"
        joints = dict.fromkeys(
            term.names[row]
            for term in self.terms
            if term in self.contacts or getattr(term, "rows", 0) > 0
            for row in np.flatnonzero(np.any(term.dofs == index, axis=1))
        )
        named = [name for name in joints if name not in self.layout.bodies]
        at = f" (joint {', '.join(named)})" if named else ""
        return self.layout.name_of(index) + at


def flat(coef: Coefficients) -> Array:
    """All coefficients, one term after the other."""
    return np.concatenate([np.zeros(0), *(c.ravel() for c in coef)])


# ----------------------------------------------------------------------------------- the terms


def _elements(description: Description, layout: Layout) -> list:
    """One term for each flexible family that the scene uses."""
    flexible = [b for b in description.bodies if isinstance(b, Flexible)]
    found = []
    for name, family in FAMILIES.items():
        members = [b for b in flexible if b.element == name and not _floats(b)]
        if members:
            module, function = family.build.split(":")
            found.append(getattr(import_module(module), function)(members, layout))
    floating = [b for b in flexible if _floats(b)]
    return found + [import_module("mechanics.floating").build(b, layout) for b in floating]


def _floats(body: Flexible) -> bool:
    return getattr(body, "modes", None) is not None


def _frames(elements: list, layout: Layout, first_row: int) -> list:
    floating = [term for term in elements if hasattr(term, "modes")]
    if not floating:
        return []
    return import_module("mechanics.floating").holding(floating, layout, first_row)


def _rigid(description: Description, layout: Layout) -> list:
    bodies = [b for b in description.bodies if isinstance(b, RigidBody)]
    if not bodies:
        return []
    return [import_module("mechanics.rigid").build(bodies, layout, layout.ndof)]


def _ties(description: Description, layout: Layout) -> list:
    if not any(isinstance(b, ReferencePoint) for b in description.bodies):
        return []
    rigid = sum(isinstance(b, RigidBody) for b in description.bodies)
    return [import_module("mechanics.reference_point_ties").build(layout, layout.ndof + 6 * rigid)]


def _joints(description: Description, layout: Layout, first_row: int) -> list:
    if not description.joints:
        return []
    from mechanics import joints

    return joints.build(description.joints, layout, first_row)


def _rayleigh(description: Description, elements: list, layout: Layout) -> list:
    if description.rayleigh is None:
        return []
    return import_module("mechanics.rayleigh").build(elements, layout, *description.rayleigh)


def _densities(description: Description, elements: list, layout: Layout) -> list:
    """How the mass of the elements follows their temperature, where it does."""
    if not description.heavy_when_cold:
        return []
    factors = import_module("mechanics.density").DensityFactors
    return [factors(term, layout) for term in elements]


def _springs(description: Description, layout: Layout, first_row: int) -> list:
    kinds = Spring | TorsionSpring | Bushing | Pulley
    items = [
        j for j in description.joints
        if isinstance(j, kinds) and getattr(j, "stiffness", None) is not None
    ]  # fmt: skip
    return import_module("mechanics.springs").build(items, layout, first_row) if items else []


def _contacts(description: Description, layout: Layout) -> list:
    """Terms of joints with clearance, imported (and compiled) only when there are some."""
    found = []
    modules = (Clearance, "clearance"), (Telescope, "telescope"), (BoreContact, "bore")
    for kinds, module in modules:
        loose = [j for j in description.joints if isinstance(j, kinds)]
        if loose:
            found += import_module(f"mechanics.{module}").build(loose, layout)
    return found


def _loads(description: Description, layout: Layout, mass: csr_array) -> list:
    if not description.loads and not np.any(description.gravity):
        return []
    build = import_module("mechanics.loads").build
    return build(description.loads, description.gravity, layout, mass)


def _points(description: Description, layout: Layout) -> tuple[Indices, Array]:
    """Coordinates (n_p, 3) of particles and their masses (n_p, 3, 3) [kg]."""
    particles = [b for b in description.bodies if isinstance(b, Particle)]
    at = [layout.node_dofs[p.name][0] + np.arange(3) for p in particles]
    mass = [p.mass * np.eye(3) for p in particles]
    return np.array(at, np.intp).reshape(-1, 3), np.array(mass).reshape(-1, 3, 3)


def _inertia(terms: Sequence[Any], points: tuple[Indices, Array]) -> list[tuple[Indices, Array]]:
    """Coordinates (n_e, k) and mass (n_e, k, k) of the elements of each term, then of points."""
    found = []
    for term in terms:
        blocks = term.mass_blocks() if hasattr(term, "mass_blocks") else None
        if blocks is not None:
            found.append((term.dofs[:, : blocks.shape[1]], blocks))
    return [*found, points]


def _mass(n: int, parts: Sequence[tuple[Indices, Array]]) -> csr_array:
    """(n, n) mass matrix of all bodies."""
    rows = [np.repeat(dofs, dofs.shape[1], axis=1).ravel() for dofs, _ in parts]
    columns = [np.tile(dofs, (1, dofs.shape[1])).ravel() for dofs, _ in parts]
    values = [blocks.ravel() for _, blocks in parts]
    entries = np.concatenate(rows), np.concatenate(columns)
    mass = csr_array((np.concatenate(values), entries), shape=(n, n))
    mass.sum_duplicates()
    mass.eliminate_zeros()
    return mass


def _vectorwise(mass: csr_array) -> tuple[int, Indices, Indices, Array]:
    """Coordinates for which a number stands, and starts of rows, first columns and numbers.

    Bodies have vectors of three coordinates, and mass does not tell x, y and z apart.
    """
    coo = mass.tocoo()
    n = 3 * (1 + int(coo.row.max(initial=-1)) // 3)
    if n <= mass.shape[0]:
        first = mass[:n:3, :n:3].tocsr()
        if (csr_array(kron(first, np.eye(3))) != mass[:n, :n]).nnz == 0:
            return 3, first.indptr, 3 * first.indices, first.data
    return 1, mass.indptr, mass.indices, mass.data


def _scale(description: Description, layout: Layout) -> Array:
    scale = layout.scale.copy()
    for joint in description.joints:
        if isinstance(joint, Clearance):
            for site in (joint.journal, joint.bearing):
                if site.body is not None:
                    r = layout.node_dofs[site.body][site.node] + np.arange(3)
                    scale[r] = np.minimum(scale[r], JOURNAL_SCALE * joint.clearance)
    return scale


# -------------------------------------------------------------------------- patterns and program


def _rows(n: int, m: int, holding: Sequence[Any]) -> tuple[tuple[str, ...], Indices]:
    """Joint or body of each multiplier, and the rows that depend on time."""
    names, driven = [""] * m, []
    for term in holding:
        moving = getattr(term, "driven", np.zeros(len(term.dofs), bool))
        for element, dofs in enumerate(term.dofs):
            for row in dofs[dofs >= n] - n:
                names[row] = term.names[element]
                if moving[element]:
                    driven.append(row)
    return tuple(names), np.array(driven, dtype=np.int64)


def _pattern(system: System) -> tuple[Any, Indices, list[Indices]]:
    """Pattern of the system matrix, slots of the mass matrix and (n_e, k k) of each term."""
    coo = system.mass.tocoo()
    diagonal = np.arange(system.n + system.m)[:, None]
    pairs = [(coo.row[:, None], coo.col[:, None]), (diagonal, diagonal)]
    pairs += [(dofs, dofs) for dofs in (getattr(t, "pattern_dofs", t.dofs) for t in system.terms)]
    ties, last = _tied(system), len(pairs)
    if ties:
        found = import_module("mechanics.floating").reached(ties, system.terms, system.n)
        pairs += [pair for rows, frame in found for pair in ((rows, frame), (frame, rows))]
    shape, slots = pattern(system.n + system.m, pairs)
    return shape, slots[0].ravel(), [s.reshape(len(s), -1) for s in slots[2:last]]


def _tied(system: System) -> list:
    """What ties nodes to floating frames."""
    return [term for term in system.terms if getattr(term, "tied", 0)]


def _arranged(system: System, bands: Sequence[bytes]) -> System:
    """The system with its contacts in other bands of the matrix."""
    new = copy(system)
    moved = [t.banded(band) if band else t for t, band in zip(system.contacts, bands, strict=True)]
    start = len(system.terms) - len(moved)
    new.contacts, new.terms = moved, [*system.terms[:start], *moved]
    new.pattern, new._mass_slots, new._slots = _pattern(new)
    blocks, stages, ranks = _blocks(new)
    new.solver = factor.choose(new.pattern, blocks, _symmetry(new), system._prefer, ranks, stages)
    solver = system.program.solver.copy()
    solver[:2] = new.solver.factor, new.solver.solve
    new.program = system.program._replace(
        ints=_line([t.ints for t in new.terms], np.int64),
        slots=_line(new._slots, np.int64),
        mass_data=_on_pattern(new),
        solver=solver,
        solver_ints=np.ascontiguousarray(new.solver.ints, np.int64),
    )
    new.packed = march.pack(new.program)
    return new


def _on_pattern(system: System) -> Array:
    """The mass matrix on the pattern of the system matrix."""
    data = system.pattern.zeros()
    np.add.at(data, system._mass_slots, system.mass.tocoo().data)
    return data


def _symmetry(system: System) -> bool | None:
    """Whether matrices are symmetric; None: all but the damping, whose forces turn with elements,
    and contact.

    What damping adds to one side is a part (damping time) x (speed of rotation) of the stiffness;
    friction adds its coefficient's part of that of the contact.
    """
    loose = (*system.elements, *system.contacts)
    if not all(getattr(term, "symmetric", True) for term in system.terms if term not in loose):
        return False
    if all(term.symmetric for term in loose):
        return True
    return None if system.pattern.size > LARGE else False


def _blocks(system: System) -> tuple[Indices, Indices, Indices]:
    """Block of each unknown, its node, its cluster of nodes in a solid, or its joint; the
    stage in which it is eliminated, that of solids by stages of their own before all others; and
    its rank.
    """
    layout = system.layout
    block, start = np.zeros(system.n + system.m, dtype=np.intp), 0
    stage = np.zeros(system.n + system.m, dtype=np.intp)
    solid = np.zeros(system.n + system.m, dtype=bool)
    for name, first in layout.node_dofs.items():
        kind, body = layout.kinds[name], layout.bodies[name]
        cluster, own = np.arange(len(first)), slice(first[0], first[-1] + kind)
        if isinstance(body, Continuum):
            dissected = import_module("mechanics.continuum_blocks").dissected
            cluster, stages = dissected(np.asarray(body.points, float), np.asarray(body.cells))
            stage[own], solid[own] = np.repeat(stages, kind), True
        block[own] = start + np.repeat(cluster, kind)
        start += int(cluster.max()) + 1
    stage[~solid] = stage.max(initial=0) + int(solid.any())
    for dof in layout.joint_dofs.values():
        block[dof] = start
        start += 1
    number = {name: start + i for i, name in enumerate(dict.fromkeys(system.row_names))}
    block[system.n :] = [number[name] for name in system.row_names]
    if any(isinstance(body, ReferencePoint) for body in layout.bodies.values()):
        import_module("mechanics.continuum_blocks").gather(block, layout, number)
    rank = _ranks(system)
    if ties := _tied(system):
        import_module("mechanics.floating").arrange(ties, block, stage, rank)
    return block, stage, rank


def _ranks(system: System) -> Indices:
    """0: coordinates with a mass; 1: multipliers; 2: coordinates that only constraints hold."""
    rank = np.ones(system.n + system.m, dtype=np.intp)
    rank[: system.n] = np.where(system.mass.diagonal() > 0.0, 0, 2)
    return rank


def _histories(terms: Sequence[Any], columns: Sequence[int]) -> list[tuple[int, History]]:
    """Place among all coefficients, and function, of each function of time."""
    found, start = [], 0
    for term, coef in zip(terms, columns, strict=True):
        for row, column, history in getattr(term, "signals", ()):
            found.append((start + row * coef + column, history))
        start += coef * len(term.dofs)
    return found


def _value(history: History, t: float) -> float:
    """Of a function of time; one that fails gives no number."""
    try:
        return float(history(t))
    except Exception:
        return np.nan


def _signals(histories: Sequence[tuple[int, History]]) -> int:
    """Address of what writes the functions of time; a failing one writes a NaN.

    So do all once an interrupt waits, which ends the march.
    """

    def write(t: float, address: int) -> None:
        values = (ctypes.c_double * len(histories)).from_address(address)
        values[:] = [np.nan] * len(histories)
        if INTERRUPTS:
            return
        values[:] = [_value(history, t) for _, history in histories]

    return callback(write, ctypes.c_double, ctypes.c_int64) if histories else 0


def _role(term: Any) -> int:
    if hasattr(term, "remember"):
        return march.CONTACT
    if getattr(term, "external", False):
        return march.LOAD
    return march.CONSTRAINT if getattr(term, "rows", 0) else march.BODY


def _program(system: System) -> march.Program:
    terms, rows = system.terms, []
    ints = floats = coefs = slots = joints = 0
    for term, places, columns in zip(terms, system._slots, system.columns, strict=True):
        contacts = len(getattr(term, "contact_names", ()))
        rows.append([
            len(term.dofs), term.ints.shape[1], term.floats.shape[1], columns, ints, floats, coefs,
            places.shape[1], slots, len(places), _role(term), joints, contacts,
        ])  # fmt: skip
        ints, floats = ints + term.ints.size, floats + term.floats.size
        coefs, slots = coefs + columns * len(term.dofs), slots + places.size
        joints += contacts
    kernels = [
        [t.force, t.tangent, t.energy, getattr(t, "respond", 0), getattr(t, "remember", 0)]
        for t in terms
    ]
    at, values = _latches(system)
    wound = any(t.energy and len(getattr(t, "signals", ())) for t in terms)
    solver = system.solver
    meeting = [term.masses(system.mass) for term in system.contacts]
    stride, mass_rows, mass_columns, mass = _vectorwise(system.mass)
    return march.Program(
        sizes=np.array([system.n, system.m, joints, wound, stride], np.int64),
        terms=np.array(rows, np.int64).reshape(-1, march.SIZES),
        kernels=np.array(kernels, np.int64).reshape(-1, march.KERNELS),
        ints=_line([t.ints for t in terms], np.int64),
        floats=_line([t.floats for t in terms], float),
        slots=_line(system._slots, np.int64),
        mass_rows=mass_rows.astype(np.int64),
        mass_columns=mass_columns.astype(np.int64),
        mass=np.ascontiguousarray(mass),
        mass_data=_on_pattern(system),
        scale=np.ascontiguousarray(system.scale),
        driven=system.driven,
        signals=np.array([place for place, _ in system._histories], np.int64),
        signal=np.array([_signals(system._histories)], np.int64),
        mobility=_line([np.multiply.outer(1.0 / mass, np.eye(3)) for mass in meeting], float),
        contact_at=_contact_starts(rows),
        latch_at=at,
        latch_value=values,
        limited=np.array([limit.coordinate for limit in system.limits], np.int64),
        limits=np.array([(x.lower, x.upper) for x in system.limits], float).reshape(-1, 2),
        solver=np.array(
            [
                solver.factor,
                solver.solve,
                REFACTOR[solver.name == "dense"],
                march.attempt,
                march.locating() if joints else 0,
                march.take,
            ],
            np.int64,
        ),
        solver_ints=np.ascontiguousarray(solver.ints, np.int64),
    )


def _line(parts: Sequence[NDArray], dtype: type) -> NDArray:
    return np.concatenate([np.zeros(0, dtype), *(p.ravel().astype(dtype) for p in parts)])


def _contact_starts(rows: Sequence[Sequence[int]]) -> NDArray[np.int64]:
    """(n_c,) first coefficient of each contact."""
    starts = [
        row[march.COEF0] + row[march.ROWS] * row[march.COEFS] // row[march.CONTACTS]
        * np.arange(row[march.CONTACTS], dtype=np.int64)
        for row in rows
        if row[march.CONTACTS]
    ]  # fmt: skip
    return _line(starts, np.int64)


def _latches(system: System) -> tuple[NDArray[np.int64], Array]:
    """Coordinate and activity coefficient of each latch, and where it catches."""
    at, values, start = [], [], 0
    for term, columns in zip(system.terms, system.columns, strict=True):
        for latch in getattr(term, "latches", ()):
            at.append((latch.coordinate, start + latch.row * columns + HOLDING))
            values.append(latch.at)
        start += columns * len(term.dofs)
    return np.array(at, np.int64).reshape(-1, 2), np.array(values, float)
