"""From a description to the lumps and conductances of ``thermal.lumped``."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from meshes.materials import Material, Property
from thermal.description import (
    Description,
    Flux,
    History,
    Member,
    Place,
    Radiation,
    Source,
)
from thermal.layout import place_nodes, wall_angles

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
Regions = Mapping[str, Indices]

SIGMA = 5.670374419e-8  # Stefan-Boltzmann constant [W/(m^2 K^4)]


class Substance(NamedTuple):
    """Nodes and conductors of one material; ``needs``: whose range which nodes must keep to."""

    material: Material
    nodes: Indices
    conductors: Indices
    needs: tuple[tuple[Property, Indices], ...]


class Radiator(NamedTuple):
    """Faces that radiate; strength (k,) float [W/K^4] = sigma * emissivity * area."""

    name: str
    nodes: Indices
    strength: Array
    sink: History


class Feed(NamedTuple):
    """Power: loads (k,) of nodes times a history."""

    name: str
    nodes: Indices
    loads: Array
    history: History


class Outlet(NamedTuple):
    """Conductance [W/K] from the mean of ``nodes`` to a given temperature."""

    name: str
    nodes: Indices
    conductance: float
    history: History


class Bridge(NamedTuple):
    """Conductance [W/K] between the means of two sets of nodes."""

    a: Indices
    b: Indices
    conductance: float


class Network(NamedTuple):
    """Lumps, conductors between them, and what joins them to the outside.

    mass : (n,) float [kg]
    a, b : (m,) intp, shape : (m,) float [m]  cross-section over length of each conductor
    link_rows, link_columns, link_values : entries of the matrix [W/K] of bridges and outlets
    """

    mass: Array
    a: Indices
    b: Indices
    shape: Array
    substances: list[Substance]
    radiators: list[Radiator]
    feeds: list[Feed]
    outlets: list[Outlet]
    bridges: list[Bridge]
    link_rows: Indices
    link_columns: Indices
    link_values: Array


def network(description: Description, regions: Regions) -> Network:
    """Network of a description whose temperatures are numbered by ``regions``."""
    mass = np.zeros(sum(len(nodes) for nodes in regions.values()))
    for p in description.parts:
        mass[regions[p.name]] = p.mass
    for m in description.members:
        per_length = m.material.density * m.section.area / m.wall_points
        mass[regions[m.name]] = per_length * _cell_lengths(m)
    wires = [_conductors(m, regions[m.name]) for m in description.members]
    none = (np.empty(0, np.intp), np.empty(0, np.intp), np.empty(0))
    a, b, shape = (np.concatenate(column) for column in zip(none, *wires, strict=True))
    outlets, bridges = _links(description, regions)
    return Network(
        mass,
        a,
        b,
        shape,
        _substances(description, regions, a),
        _radiators(description, regions),
        _feeds(description, regions),
        outlets,
        bridges,
        *_link_entries(outlets, bridges),
    )


def _cell_lengths(m: Member) -> Array:
    """(stations * wall_points,) [m]  half the distance to each neighbouring station."""
    steps = np.linalg.norm(np.diff(m.points, axis=0), axis=1)
    return np.repeat(0.5 * (np.append(steps, 0.0) + np.append(0.0, steps)), m.wall_points)


def _conductors(m: Member, nodes: Indices) -> tuple[Indices, Indices, Array]:
    n, grid = m.wall_points, nodes.reshape(-1, m.wall_points)
    steps = np.linalg.norm(np.diff(m.points, axis=0), axis=1)
    along = np.repeat(m.section.area / n / steps, n)
    if n == 1:
        return grid[:-1].ravel(), grid[1:].ravel(), along
    arc = 2.0 * np.pi * m.section.radius / n
    around = m.section.thickness * _cell_lengths(m) / arc
    return (
        np.concatenate([grid[:-1].ravel(), grid.ravel()]),
        np.concatenate([grid[1:].ravel(), np.roll(grid, -1, axis=1).ravel()]),
        np.concatenate([along, around]),
    )


def _substances(description: Description, regions: Regions, a: Indices) -> list[Substance]:
    materials = {id(m.material): m.material for m in description.members}
    materials.update({id(p.material): p.material for p in description.parts})
    found = []
    for key, material in materials.items():
        walls = _nodes_of([m.name for m in description.members if id(m.material) == key], regions)
        lumps = _nodes_of([p.name for p in description.parts if id(p.material) == key], regions)
        nodes = np.concatenate([walls, lumps])
        needs = ((material.heat_capacity, nodes), (material.conductivity, walls))
        found.append(Substance(material, nodes, np.flatnonzero(np.isin(a, walls)), needs))
    return found


def _nodes_of(names: Sequence[str], regions: Regions) -> Indices:
    return np.concatenate([np.empty(0, np.intp), *(regions[name] for name in names)])


def _radiators(description: Description, regions: Regions) -> list[Radiator]:
    members = {m.name: m for m in description.members}
    found = []
    for c in description.conditions:
        if isinstance(c, Radiation):
            m = members[c.body]
            area = m.section.outer_perimeter / m.wall_points * _cell_lengths(m)
            found.append(Radiator(c.name, regions[m.name], SIGMA * c.emissivity * area, c.sink))
    return found


def _feeds(description: Description, regions: Regions) -> list[Feed]:
    members = {m.name: m for m in description.members}
    found = []
    for c in description.conditions:
        if isinstance(c, Flux):
            m = members[c.body]
            loads = _lit_widths(m, c.direction).ravel() * _cell_lengths(m)
            found.append(Feed(c.name, regions[m.name], loads, c.density))
        elif isinstance(c, Source):
            nodes = place_nodes(description, regions, c.place)
            found.append(Feed(c.name, nodes, np.full(len(nodes), 1.0 / len(nodes)), c.power))
    return found


def _lit_widths(m: Member, direction: Array | None) -> Array:
    """(stations, wall_points) [m]  of the outer contour as the rays see it, cell by cell."""
    n, section = m.wall_points, m.section
    if direction is None:
        return np.full((len(m.points), n), section.outer_perimeter / n)
    unit = np.asarray(direction, dtype=float) / np.linalg.norm(direction)
    y, z = -np.asarray(m.axes)[:, 1] @ unit, -np.asarray(m.axes)[:, 2] @ unit
    if n > 1:
        centre = wall_angles(n) - np.arctan2(z, y)[:, None]
        lit = _lit_up_to(centre + np.pi / n) - _lit_up_to(centre - np.pi / n)
        return 0.5 * section.height * np.hypot(y, z)[:, None] * lit
    if section.kind in ("tube", "circle"):
        return section.height * np.hypot(y, z)[:, None]
    return (section.width * np.abs(y) + section.height * np.abs(z))[:, None]


def _lit_up_to(psi: Array) -> Array:
    """Integral of max(0, cos) from -pi/2 to psi: 2 for each full turn, sin + 1 within one."""
    turns = np.floor((psi + np.pi) / (2.0 * np.pi))
    within = np.clip(psi - 2.0 * np.pi * turns, -0.5 * np.pi, 0.5 * np.pi)
    return 2.0 * turns + np.sin(within) + 1.0


def _links(description: Description, regions: Regions) -> tuple[list[Outlet], list[Bridge]]:
    outlets, bridges = [], []
    for x in description.links:
        a = place_nodes(description, regions, x.a)
        if isinstance(x.b, Place):
            bridges.append(Bridge(a, place_nodes(description, regions, x.b), x.conductance))
        else:
            outlets.append(Outlet(x.name, a, x.conductance, x.b))
    return outlets, bridges


def _link_entries(
    outlets: Sequence[Outlet], bridges: Sequence[Bridge]
) -> tuple[Indices, Indices, Array]:
    """Entries of minus the derivative of the link powers."""
    pairs = [(o.nodes, o.nodes, o.conductance) for o in outlets]
    for c in bridges:
        pairs += [(c.a, c.a, c.conductance), (c.b, c.b, c.conductance)]
        pairs += [(c.a, c.b, -c.conductance), (c.b, c.a, -c.conductance)]
    none = [np.empty(0, np.intp)]
    rows = np.concatenate(none + [np.repeat(i, len(j)) for i, j, _ in pairs])
    columns = np.concatenate(none + [np.tile(j, len(i)) for i, j, _ in pairs])
    values = [np.full(len(i) * len(j), g / (len(i) * len(j))) for i, j, g in pairs]
    return rows, columns, np.concatenate([np.empty(0), *values])
