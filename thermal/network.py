"""From a description to the lumps and conductors of ``thermal.lumped``."""

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from meshes.materials import Material, Property
from meshes.sections import Section
from meshes.surfaces import Surface
from thermal.description import Description, Member, Sheet
from thermal.layout import arclength, node_areas
from thermal.profiles import GRADIENTS

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
Regions = Mapping[str, Indices]

RIGHT = 1e-9  # cosine below which an angle is a right one


class Store(NamedTuple):
    """Lumps of one material; ``needs``: properties to whose range they must keep.

    nodes : (k,) intp
    mass : (k,) float [kg]
    """

    nodes: Indices
    mass: Array
    material: Material
    needs: tuple[Property, ...]


class Conductors(NamedTuple):
    """Conductors of one conductivity, which each takes at the mean of its two temperatures.

    a, b : (m,) intp
    shape : (m,) float [m]  cross-section over length
    """

    a: Indices
    b: Indices
    shape: Array
    conductivity: Property


def stores(description: Description, regions: Regions) -> list[Store]:
    """All lumps; those of one material that need the same properties are one store."""
    found = [
        Store(regions[m.name], masses(m), m.material, _member_needs(m)) for m in description.members
    ]
    for p in description.parts:
        needs: tuple[Property, ...] = (p.material.heat_capacity,)
        found.append(Store(regions[p.name], np.array([float(p.mass)]), p.material, needs))
    for s in description.sheets:
        needs = (s.material.heat_capacity, *s.material.conductivities)
        found.append(Store(regions[s.name], face_masses(s), s.material, needs))
    groups: dict[tuple[int, tuple[int, ...]], list[Store]] = {}
    for store in found:
        key = id(store.material), tuple(id(p) for p in store.needs)
        groups.setdefault(key, []).append(store)
    return [_merged_stores(group) for group in groups.values()]


def conductors(description: Description, regions: Regions) -> list[Conductors]:
    """All conductors, those of one conductivity together."""
    found = [c for m in description.members for c in _member_conductors(m, regions[m.name])]
    found += [c for s in description.sheets for c in _sheet_conductors(s, regions[s.name])]
    groups: dict[int, list[Conductors]] = {}
    for c in found:
        groups.setdefault(id(c.conductivity), []).append(c)
    return [_merged_conductors(group) for group in groups.values()]


def cell_lengths(m: Member) -> Array:
    """(stations,) [m]  half the distance to each neighbouring station."""
    steps = np.diff(arclength(m.points))
    return 0.5 * (np.append(steps, 0.0) + np.append(0.0, steps))


def masses(m: Member) -> Array:
    """(stations * wall_points,) [kg]  half of the wall to each neighbouring station."""
    share = m.material.density * m.section.area / m.wall_points
    return np.repeat(share * cell_lengths(m), m.wall_points)


def face_masses(s: Sheet) -> Array:
    """(2 nodes,) [kg]  half of the thickness to each face."""
    return np.repeat(0.5 * s.material.density * s.thickness * node_areas(s), 2)


def _merged_stores(group: Sequence[Store]) -> Store:
    nodes, mass = (np.concatenate([store[k] for store in group]) for k in (0, 1))
    return Store(nodes, mass, group[0].material, group[0].needs)


def _merged_conductors(group: Sequence[Conductors]) -> Conductors:
    a, b, shape = (np.concatenate([c[k] for c in group]) for k in (0, 1, 2))
    return Conductors(a, b, shape, group[0].conductivity)


def _member_needs(m: Member) -> tuple[Property, ...]:
    """Of the heat capacity and of the conductivities along, around and through, as used."""
    used = 1 if m.wall_points == 1 else 3 if m.wall_points == GRADIENTS else 2
    return m.material.heat_capacity, *m.material.conductivities[:used]


def _member_conductors(m: Member, nodes: Indices) -> Iterator[Conductors]:
    """Along a member, and round its wall or across its section."""
    n, grid = m.wall_points, nodes.reshape(-1, m.wall_points)
    steps, lengths = np.diff(arclength(m.points)), cell_lengths(m)
    along, around, through = m.material.conductivities
    shapes = np.repeat(m.section.area / n / steps, n)
    yield Conductors(grid[:-1].ravel(), grid[1:].ravel(), shapes, along)
    onward = np.roll(grid, -1, axis=1)
    if n == GRADIENTS:
        for ring, k in zip(_across(m.section), (around, through), strict=True):
            yield Conductors(grid.ravel(), onward.ravel(), np.outer(lengths, ring).ravel(), k)
    elif n > 1:
        yield Conductors(grid.ravel(), onward.ravel(), np.repeat(lengths * _around(m), n), around)


def _around(m: Member) -> float:
    """Wall over the arc between two wall points, per length of the member."""
    return m.section.thickness * m.wall_points / (2.0 * np.pi * m.section.radius)


def _across(section: Section) -> tuple[Array, Array]:
    """(3,) [-]  from each of three temperatures of a section to the next, per length.

    With them the gradients along e2 (first) and e3 (second) dissipate what they do in the
    section, the squares of the gradients times area and conductivity. Where the sum of two is
    negative, as of a section that is wide along e3, so is that conductor.
    """
    y, z = (section.area**2 / (2.0 * x) for x in (section.second_moment_2, section.second_moment_3))
    return y * np.array([2.0, -1.0, 2.0]) / 9.0, z * np.array([0.0, 1.0, 0.0]) / 3.0


def _sheet_conductors(s: Sheet, nodes: Indices) -> Iterator[Conductors]:
    """In both faces, each with half of the thickness, and between them."""
    grid = nodes.reshape(-1, 2)
    along, across, through = s.material.conductivities
    for a, b, by_along, by_across in _in_plane(s.surface):
        for shape, conductivity in ((by_along, along), (by_across, across)):
            kept = shape != 0.0
            for face in grid.T:
                half = 0.5 * s.thickness * shape[kept]
                yield Conductors(face[a[kept]], face[b[kept]], half, conductivity)
    yield Conductors(grid[:, 0], grid[:, 1], node_areas(s) / s.thickness, through)


def _in_plane(surface: Surface) -> Iterator[tuple[Indices, Indices, Array, Array]]:
    """Conductors between the corners of elements, with their share of both conductivities.

    The energy of conduction, by the gradient along d_u and across it, is summed at the corners.
    Where d_u and d_v are not at right angles, the product p q of two differences is written
    p^2 + q^2 - (p - q)^2 over 2, which is a conductor from tip to tip.
    """
    a, b = surface.sizes.T
    for corner in range(4):
        at = surface.quads[:, corner]
        to_u, to_v = surface.quads[:, corner ^ 1], surface.quads[:, 3 - corner]
        aspect, lean = _shape_at(surface, at)
        mixed = 0.25 * lean / aspect * (1.0 if corner in (0, 2) else -1.0)
        zero = np.zeros_like(mixed)
        yield at, to_u, 0.25 * b / a * aspect, 0.25 * b / a * lean**2 / aspect - mixed
        yield at, to_v, zero, 0.25 * a / b / aspect - mixed
        yield to_u, to_v, zero, mixed


def _shape_at(surface: Surface, nodes: Indices) -> tuple[Array, Array]:
    """Of d_v, its part across d_u and its part along d_u, both over the length of d_u."""
    u, v = surface.d_u[nodes], surface.d_v[nodes]
    square = np.einsum("nc,nc->n", u, u)
    across = np.linalg.norm(np.cross(u, v), axis=1) / square
    along = np.einsum("nc,nc->n", u, v) / square
    return across, np.where(np.abs(along) > RIGHT * across, along, 0.0)
