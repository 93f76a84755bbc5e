"""What solid bodies store and conduct: sums over cells, refilled by compiled code."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from meshes.materials import DATUM, Material, Property
from thermal import solid_kernels as kernels
from thermal.solid_bodies import CHUNK, Filling, conductivities
from thermal.solid_elements import (
    CONDUCTION,
    STORAGE,
    Geometry,
    Shape,
    at_corners,
    flatness,
    geometry,
    metrics,
    right_angled,
    shape,
)

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
Short = NDArray[np.uint32]

LUMPABLE = ("tetra", "hexahedron", "hexahedron27")
"""Families all of whose shape functions have a positive mean."""

ALIKE = (
    1e-12  # difference of amounts at points of a cell, relative, that positions' round-off makes
)

BENT = 0.5  # volume of a cell at a corner over the product of its edges there, to be like a box


class Pattern(NamedTuple):
    """Entries of the matrix of all temperatures, compressed by rows, columns rising."""

    starts: Short
    columns: Short

    @property
    def rows(self) -> Indices:
        """(k,) of each entry."""
        return np.repeat(np.arange(len(self.starts) - 1), np.diff(self.starts))

    @property
    def diagonal(self) -> Indices:
        """(n,) which entries are on the diagonal."""
        return np.flatnonzero(self.rows == self.columns)


class Group(NamedTuple):
    """Cells of one family, batch by batch as the kernels take them, and where they go.

    dofs : (batches, n, BATCH) uint32
    form : at the points of what is summed
    amounts : (batches, q, ..., BATCH) float
    law : of the conductivity or heat capacity
    """

    dofs: Short
    form: Shape
    amounts: Array
    law: Property
    slots: Short

    @property
    def nodes(self) -> tuple[int, ...]:
        """Of a cell: kernels are compiled for each length."""
        return tuple(range(self.dofs.shape[1]))


class Lumps(NamedTuple):
    """Heat stored at nodes.

    nodes : (k,) intp
    mass : (k,) float [kg]
    """

    nodes: Indices
    mass: Array
    law: Property


Filled = Sequence[tuple[Filling, Array]]
"""Fillings whose cells have global numbers, and all positions (n, 3) [m]."""


def pattern(fillings: Sequence[Filling], n: int) -> Pattern:
    """Every pair of nodes that share a cell."""
    total = csr_array((n, n), dtype=np.int32)
    for family in dict.fromkeys(f.family for f in fillings):
        cells = np.concatenate([f.cells for f in fillings if f.family == family])
        starts = np.arange(0, cells.size + 1, cells.shape[1])
        ones = np.ones(cells.size, dtype=np.int32)
        uses = csr_array((ones, cells.ravel(), starts), shape=(len(cells), n))
        total = total + (uses.T @ uses).tocsr()
    total.sort_indices()
    return Pattern(total.indptr.astype(np.uint32), total.indices.astype(np.uint32))


def conduction(
    fillings: Sequence[Filling], x: Array, entries: Pattern, lumped: bool
) -> list[Group]:
    """Groups of cells with the same family, quadrature and conductivity.

    lumped : boxes, and cells like them, conduct along their edges only: their quadrature is at the
        corners, lest hot and cold spread where cells are long
    """
    parts: dict[tuple[str, bool, Property], list[tuple[Indices, Array]]] = {}
    for whole in fillings:
        for filling, corners in _by_quadrature(whole, x, lumped):
            form = _conducting(filling.family, corners)
            for law, directions in conductivities(filling).items():
                amounts = [_metric(filling, at, directions) for at in _geometries(filling, x, form)]
                found = filling.cells, np.concatenate(amounts)
                parts.setdefault((filling.family, corners, law), []).append(found)
    return [
        _group(_conducting(family, corners), law, found, entries)
        for (family, corners, law), found in parts.items()
    ]


def _conducting(family: str, corners: bool) -> Shape:
    return at_corners(family) if corners else shape(family, CONDUCTION[family])


def _by_quadrature(f: Filling, x: Array, lumped: bool) -> list[tuple[Filling, bool]]:
    """Its cells with and without quadrature at their corners."""
    if not lumped or f.family != "hexahedron":
        return [(f, False)]
    whole = _geometries(f, x, at_corners(f.family))
    fit = [flatness(at) > BENT if f.regular else right_angled(at) for at in whole]
    chosen = np.concatenate(fit)
    split = [(f._replace(cells=f.cells[rows]), bool(of)) for of, rows in
             ((1, chosen), (0, ~chosen))]  # fmt: skip
    return [part for part in split if len(part[0].cells)]


def consistent_storage(fillings: Sequence[Filling], x: Array, entries: Pattern) -> list[Group]:
    """Groups of cells with the same family and heat capacity."""
    parts: dict[tuple[str, Property], list[tuple[Indices, Array]]] = {}
    for filling in fillings:
        found = filling.cells, filling.material.density * volumes(filling, x)
        key = filling.family, filling.material.heat_capacity
        parts.setdefault(key, []).append(found)
    return [_group(shape(f, STORAGE[f]), law, found, entries) for (f, law), found in parts.items()]


def lumped_storage(fillings: Sequence[Filling], x: Array) -> list[Lumps]:
    """Mass at the nodes of each material."""
    masses: dict[Property, Array] = {}
    for filling in fillings:
        mass = masses.setdefault(filling.material.heat_capacity, np.zeros(len(x)))
        form = shape(filling.family, STORAGE[filling.family])
        shares = filling.material.density * volumes(filling, x) @ form.values
        np.add.at(mass, filling.cells, shares)
    return [Lumps(np.flatnonzero(m), m[m != 0.0], law) for law, m in masses.items()]


def volumes(filling: Filling, x: Array) -> Array:
    """(m, q) [m^3]  of the cells at the points of the quadrature of storage."""
    form = shape(filling.family, STORAGE[filling.family])
    return np.concatenate([at.volumes for at in _geometries(filling, x, form)])


def _geometries(filling: Filling, x: Array, form: Shape) -> Iterator[Geometry]:
    for i in range(0, len(filling.cells), CHUNK):
        yield geometry(x[filling.cells[i : i + CHUNK]], form)


def _metric(filling: Filling, at: Geometry, directions: Sequence[int]) -> Array:
    if len(directions) == 3:
        return metrics(at, None)[0]
    return metrics(at, _directions(filling, at)[directions]).sum(axis=0)


def _directions(filling: Filling, at: Geometry) -> Array:
    """(3, m, q, 3) or (3, 1, 1, 3)  unit vectors along, around and through."""
    if not isinstance(filling.directions, str):
        return np.asarray(filling.directions, dtype=float)[:, None, None, :]
    a, b, c = (at.tangents[..., i, :] for i in range(3))
    if filling.directions == "along":
        along, through = _unit(c), _unit(np.cross(b, c))
    else:
        along, through = _unit(a), _unit(np.cross(a, b))
    return np.stack([along, np.cross(through, along), through])


def _unit(v: Array) -> Array:
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def _group(
    form: Shape,
    law: Property,
    parts: Sequence[tuple[Indices, Array]],
    entries: Pattern,
) -> Group:
    cells, amounts = (np.concatenate(a) for a in zip(*parts, strict=True))
    dofs = _batched(cells.astype(np.uint32), cells[:1])
    slots = kernels.slots_of(dofs, entries.starts, entries.columns)
    amounts = _once(amounts)
    return Group(dofs, form, _batched(amounts, np.zeros_like(amounts[:1])), law, slots)


def _once(amounts: Array) -> Array:
    """Of the first point alone where they are the same at all, to round-off: less to read."""
    first = amounts[:, :1]
    return first if (np.abs(amounts - first) <= ALIKE * np.abs(first).max()).all() else amounts


def _batched(a, filler):
    """(batches, ..., BATCH) of (m, ...), the last batch filled up."""
    short = -len(a) % kernels.BATCH
    full = np.concatenate([a, np.repeat(filler, short, axis=0).astype(a.dtype)])
    split = full.reshape(-1, kernels.BATCH, *a.shape[1:])
    return np.ascontiguousarray(np.moveaxis(split, 1, -1))


class Last:
    """A function of temperatures that knows its last values: a step begins where another ended."""

    def __init__(self, of: Callable[[Array], Array]) -> None:
        self._of = of
        self._T = self._values = np.empty(0)

    def __call__(self, T: Array) -> Array:
        """Values at T."""
        if not np.array_equal(T, self._T):
            self._T, self._values = T.copy(), self._of(T)
        return self._values.copy()


class Conduction:
    """Power conducted between all temperatures; what is constant is summed once."""

    def __init__(self, groups: Sequence[Group], entries: Pattern) -> None:
        self._entries, self._last = entries, Last(self._power)
        self._varying = [g for g in groups if not g.law.is_constant]
        self.constant = np.zeros(len(entries.columns))
        steady = [g for g in groups if g.law.is_constant]
        self._any = bool(steady)
        at = np.full(len(entries.starts) - 1, DATUM)
        for g in steady:
            _add_conductance(g, at, 1.0, self.constant)

    def power(self, T: Array) -> Array:
        """(n,) [W] received."""
        return self._last(T)

    def _power(self, T: Array) -> Array:
        out = np.zeros_like(T)
        if self._any:
            # rows have the sum 0: differences, lest large temperatures leave their round-off
            kernels.passed_on(self._entries.starts, self._entries.columns, self.constant, T, out)
        for g in self._varying:
            c = g.law.curve
            kernels.conducted(
                g.nodes,
                g.dofs,
                g.amounts,
                g.form.values,
                g.form.slopes,
                c.knots,
                c.origins,
                c.value,
                T,
                out,
            )
        return out

    def refill(self, T: Array, tau: float, data: Array) -> None:
        """Add what varies, times tau [s]."""
        for g in self._varying:
            _add_conductance(g, T, tau, data)


def _add_conductance(g: Group, T: Array, tau: float, data: Array) -> None:
    c, f = g.law.curve, g.form
    kernels.add_conductance(
        g.nodes, g.dofs, g.amounts, f.values, f.slopes, c.knots, c.origins, c.value, c.slope,
        g.slots, tau, T, data,
    )  # fmt: skip


class LumpedStorage:
    """Heat stored at nodes: a node is never cooled by heating its neighbour."""

    def __init__(self, lumps: Sequence[Lumps], entries: Pattern) -> None:
        self._lumps, diagonal = lumps, entries.diagonal
        self._places = [diagonal[one.nodes] for one in lumps]
        self.constant = np.zeros(len(entries.columns))
        for one, at in zip(lumps, self._places, strict=True):
            if one.law.is_constant:
                self.constant[at] += one.mass * one.law(DATUM)

    def heat(self, T: Array) -> Array:
        """(n,) [J]"""
        out = np.zeros_like(T)
        for one in self._lumps:
            c = one.law.curve
            h = kernels.property_at(c.knots, c.origins, c.primitive, T[one.nodes])
            out[one.nodes] += one.mass * h
        return out

    def refill(self, T: Array, data: Array) -> None:
        """Add what varies."""
        for one, at in zip(self._lumps, self._places, strict=True):
            if not one.law.is_constant:
                c = one.law.curve
                capacity = kernels.property_at(c.knots, c.origins, c.value, T[one.nodes])
                data[at] += one.mass * capacity


class ConsistentStorage:
    """Heat stored by integrals over the cells."""

    def __init__(self, groups: Sequence[Group], entries: Pattern) -> None:
        self._groups, self._last = groups, Last(self._heat)
        self.constant = np.zeros(len(entries.columns))
        at = np.full(len(entries.starts) - 1, DATUM)
        for g in groups:
            if g.law.is_constant:
                _add_capacity(g, at, self.constant)

    def heat(self, T: Array) -> Array:
        """(n,) [J]"""
        return self._last(T)

    def _heat(self, T: Array) -> Array:
        out = np.zeros_like(T)
        for g in self._groups:
            c = g.law.curve
            kernels.stored(
                g.nodes, g.dofs, g.amounts, g.form.values, c.knots, c.origins, c.primitive, T, out
            )
        return out

    def refill(self, T: Array, data: Array) -> None:
        """Add what varies."""
        for g in self._groups:
            if not g.law.is_constant:
                _add_capacity(g, T, data)


def _add_capacity(g: Group, T: Array, data: Array) -> None:
    c = g.law.curve
    kernels.add_capacity(
        g.nodes, g.dofs, g.amounts, g.form.values, c.knots, c.origins, c.value, g.slots, T, data
    )


def storage(
    fillings: Sequence[Filling], x: Array, entries: Pattern, lumped: bool
) -> LumpedStorage | ConsistentStorage:
    """Stored heat at nodes or by integrals."""
    if lumped:
        return LumpedStorage(lumped_storage(fillings, x), entries)
    return ConsistentStorage(consistent_storage(fillings, x, entries), entries)


class Watched(NamedTuple):
    """Nodes whose temperature must keep to the range of a property."""

    name: str
    nodes: Indices
    law: Property

    def complaint(self, T: Array) -> str:
        """Which range ``T`` has left and with what, or ""."""
        at, p = T[self.nodes], self.law
        slack = 1e-9 * float(at.max(initial=0.0))  # round-off
        for value in (float(at.min(initial=np.inf)), float(at.max(initial=0.0))):
            if len(at) and not p.lower - slack <= value <= p.upper + slack:
                return (
                    f"'{self.name}' left the range of {p.name} "
                    f"({p.lower:g} K to {p.upper:g} K) with {value:g} K"
                )
        return ""


def watched(name: str, materials: Mapping[Material, Indices]) -> list[Watched]:
    """The properties of a body that have a range."""
    return [
        Watched(name, nodes, p)
        for material, nodes in materials.items()
        for p in (material.heat_capacity, *dict.fromkeys(material.conductivities))
        if np.isfinite(p.lower) or np.isfinite(p.upper)
    ]
