"""The developed wall of a tube: its length by its circumference, thin."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from thermal.description import Condition, Description, Member
from thermal.discretisation import Block, GivenTemperatures, Mean, facing_loads
from thermal.layout import arclength, given, wall_positions
from thermal.wall_elements import (
    FINE,
    FRACTIONS,
    INSIDE,
    PORTIONS,
    WEIGHTS,
    Bonds,
    Shape,
    conduct,
    sharing,
    side_sharing,
    summed,
)

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

GAUSS = np.polynomial.legendre.leggauss(8)


class TubeWall:
    """Elements between the stations and wall points of a tube; see ``thermal.wall``.

    Nodes are the wall points of the member, at order 2 of one with twice as many elements both
    ways. Lines of the same wall point run straight along the member: axes that turn about it
    between stations, and bends, leave the developed rectangle as it is.

    x : (m, 3) float [m]
    named : (k,) intp  the wall points of the member among them
    volumes : (m,) float [m^3]
    bonds : along and around, each with the share of the wall's thickness in it
    """

    def __init__(self, member: Member, form: Shape) -> None:
        self.thing, self.form = member, form
        self._fine = _refined(member, form.order)
        self.x = wall_positions(self._fine)
        grid = np.arange(len(self.x)).reshape(-1, self._fine.wall_points)
        self.named = grid[:: form.order, :: form.order].ravel()
        self.cells = _cells(grid, form)
        self.steps = np.diff(arclength(member.points))
        self.turn = 2.0 * np.pi / member.wall_points
        self.areas, bonds = self._developed()
        t = member.section.thickness
        self.volumes = t * self.areas
        self.bonds = (*(Bonds(a, b, t * c) for a, b, c in bonds), None)

    def given(
        self, conditions: Sequence[Condition], nodes: Indices, x: Array
    ) -> list[GivenTemperatures]:
        """What conditions prescribe, of all nodes."""
        d = Description([self._fine], conditions=conditions)
        return given(d, {self.thing.name: nodes}, x)

    def face(self, face: str) -> list[Block]:
        """One facet for each node."""
        return [self._end(face) if face in ("start", "end") else self._strips(face)]

    def irradiated(self, face: str) -> list[Block]:
        """Elements with points in rows and columns; the ends as ``face``."""
        if face in ("start", "end"):
            return self.face(face)
        stations, angles = len(self.steps), self.thing.wall_points
        at = (np.arange(stations)[:, None] + FRACTIONS).ravel()
        phi = self.turn * (np.arange(angles)[:, None] + FRACTIONS).ravel()
        points, normals = self._skin(at, phi, face)
        whole = self._radius(face)[0] * self.turn * np.repeat(self.steps, angles)
        corners = self._quads(np.arange(stations + 1.0), self.turn * np.arange(angles + 1.0), face)
        return [
            Block(
                self.cells,
                sharing(self.form.order, INSIDE),
                whole[:, None] * PORTIONS,
                _tiles(points, stations),
                _tiles(normals, stations),
                corners,
            )
        ]

    def absorbing(self, face: str, direction: Array | None) -> Array:
        """(m,) [m^2]  rays that reach a round face, exactly; see ``thermal.discretisation``."""
        if direction is None or face in ("start", "end"):
            return facing_loads(self.face(face), direction, len(self.x))
        radius, sign = self._radius(face)
        rays = np.asarray(direction, dtype=float) / np.linalg.norm(direction)
        facing = -sign * np.asarray(self._fine.axes, dtype=float)[:, 1:] @ rays
        across = np.hypot(facing[:, 0], facing[:, 1])
        phase = np.arctan2(facing[:, 1], facing[:, 0])
        widths = lit(self.form.order, self.thing.wall_points, phase)
        return (radius * (across * self._lengths())[:, None] * widths).ravel()

    def place(self, end: str | None) -> Mean:
        """All of the wall by volume, or round one of its ends."""
        nodes = np.arange(len(self.x)) if end is None else self._ring(end)
        return Mean(nodes, self.areas[nodes] / self.areas[nodes].sum())

    def _developed(self) -> tuple[Array, tuple[Bonds, Bonds]]:
        sizes = np.repeat(self.steps, self.thing.wall_points)[:, None]
        o = np.zeros((len(sizes), len(self.form.nodes)))
        along = np.stack([sizes + o, o, o], axis=2)
        across = np.stack([o, o + self.turn * self.thing.section.radius, o], axis=2)
        shares, bonds = conduct(self.cells, along, across, self.form)
        return summed(self.cells, shares), bonds

    def _lengths(self) -> Array:
        """(stations,) [m]  of member that belong to each station of the nodes."""
        mean = 2.0 * np.pi * self.thing.section.radius
        return self.areas.reshape(-1, self._fine.wall_points).sum(axis=1) / mean

    def _radius(self, face: str) -> tuple[float, float]:
        """Of a face [m], and which way it looks."""
        section = self.thing.section
        if face == "inner":
            return section.radius - 0.5 * section.thickness, -1.0
        return 0.5 * section.height, 1.0

    def _skin(self, at: Array, phi: Array, face: str) -> tuple[Array, Array]:
        """Points and normals (stations, angles, 3) of a face."""
        points, axes = frames(self.thing, at)
        radius, sign = self._radius(face)
        out = np.cos(phi)[:, None] * axes[:, None, 1] + np.sin(phi)[:, None] * axes[:, None, 2]
        return points[:, None] + radius * out, sign * out

    def _quads(self, at: Array, phi: Array, face: str) -> Array:
        """(k, 4, 3) [m]  between stations and angles, turning about the outward normal."""
        x = self._skin(at, phi, face)[0]
        around = [x[:-1, :-1], x[:-1, 1:], x[1:, 1:], x[1:, :-1]]
        return np.stack(around, axis=2).reshape(-1, 4, 3)[:, :: int(self._radius(face)[1])]

    def _strips(self, face: str) -> Block:
        order, stations, angles = self.form.order, len(self.steps), self.thing.wall_points
        nodes = len(self.x)
        at = np.arange(order * stations + 1) / order
        phi = np.linspace(0.0, 2.0 * np.pi, order * angles, endpoint=False)
        points, normals = self._skin(at, phi, face)
        radius = self._radius(face)[0]
        return Block(
            np.arange(nodes)[:, None],
            np.ones((1, 1)),
            (radius / self.thing.section.radius * self.areas)[:, None],
            points.reshape(-1, 1, 3),
            normals.reshape(-1, 1, 3),
            self._quads(
                np.concatenate([[0.0], _bounds(order, stations), [stations]]),
                self.turn * _ring_bounds(order, angles),
                face,
            ),
        )

    def _ring(self, end: str) -> Indices:
        n = self._fine.wall_points
        return np.arange(n) if end == "start" else np.arange(len(self.x) - n, len(self.x))

    def _end(self, face: str) -> Block:
        """Sectors of the end section."""
        nodes, sign = self._ring(face), -1.0 if face == "start" else 1.0
        tip = 0.0 if face == "start" else float(len(self.steps))
        bounds = self.turn * _ring_bounds(self.form.order, self.thing.wall_points)
        inner, outer = (self._skin(np.array([tip]), bounds, side)[0][0] for side in SIDES)
        sectors = np.stack([inner[:-1], outer[:-1], outer[1:], inner[1:]], axis=1)
        normal = sign * frames(self.thing, np.array([tip]))[1][0, 0]
        return Block(
            nodes[:, None],
            np.ones((1, 1)),
            (self.thing.section.area * self.place(face).weights)[:, None],
            self.x[nodes][:, None],
            np.broadcast_to(normal, (len(nodes), 1, 3)),
            sectors[:, :: int(sign)],
        )


SIDES = ("inner", "outer")


def frames(member: Member, at: Array) -> tuple[Array, Array]:
    """Points (k, 3) and axes (k, 3, 3) of a member at ``at`` (k,), counted in elements."""
    points, axes = np.asarray(member.points, float), np.asarray(member.axes, float)
    i = np.minimum(at.astype(int), len(points) - 2)
    f = (at - i)[:, None]
    x = (1.0 - f) * points[i] + f * points[i + 1]
    e1, e2, _ = np.moveaxis((1.0 - f[..., None]) * axes[i] + f[..., None] * axes[i + 1], 1, 0)
    e1 = e1 / np.linalg.norm(e1, axis=1, keepdims=True)
    e2 = e2 - np.einsum("kx,kx->k", e1, e2)[:, None] * e1
    e2 = e2 / np.linalg.norm(e2, axis=1, keepdims=True)
    return x, np.stack([e1, e2, np.cross(e1, e2)], axis=1)


def lit(order: int, n: int, phase: Array) -> Array:
    """Shares of wall points in integrals of max(0, cos(phi - phase)) over the circumference.

    The lit half of each of ``n`` elements is integrated by itself.

    phase : (m,) float [rad]

    Returns
    -------
    (m, order * n) float  of sum 2
    """
    turn = 2.0 * np.pi / n
    middle = turn * (np.arange(n) + 0.5) - phase[:, None]
    middle = (middle + np.pi) % (2.0 * np.pi) - np.pi
    low = np.clip(middle - 0.5 * turn, -0.5 * np.pi, 0.5 * np.pi)
    high = np.clip(middle + 0.5 * turn, -0.5 * np.pi, 0.5 * np.pi)
    half = 0.5 * (high - low)[..., None]
    x = low[..., None] + half * (1.0 + GAUSS[0])
    shapes = side_sharing(order, (x - middle[..., None]) / turn + 0.5)
    parts = np.einsum("mng,mngi->mni", half * GAUSS[1] * np.cos(x), shapes)
    out = np.zeros((len(phase), order * n))
    for i in range(order + 1):
        out[:, (order * np.arange(n) + i) % (order * n)] += parts[..., i]
    return out


def _refined(member: Member, order: int) -> Member:
    """The member whose wall points are the nodes."""
    if order == 1:
        return member
    points, axes = frames(member, np.arange(2 * len(member.points) - 1) / 2)
    points[::2], axes[::2] = member.points, member.axes
    return replace(member, points=points, axes=axes, wall_points=2 * member.wall_points)


def _cells(grid: Indices, form: Shape) -> Indices:
    """(e, k) nodes of the elements of a grid that closes on itself around."""
    stations, angles = (grid.shape[0] - 1) // form.order, grid.shape[1] // form.order
    i, j = (x.ravel() for x in np.meshgrid(range(stations), range(angles), indexing="ij"))
    steps = form.steps
    rows = form.order * i[:, None] + steps[:, 0]
    return grid[rows, (form.order * j[:, None] + steps[:, 1]) % grid.shape[1]]


def _bounds(order: int, elements: int) -> Array:
    """Where the shares of neighbouring nodes meet, counted in elements."""
    within = np.cumsum(WEIGHTS[order])[:-1]
    return (np.arange(elements)[:, None] + within).ravel()


def _ring_bounds(order: int, elements: int) -> Array:
    """Where the shares of nodes on a ring begin and end, counted in elements."""
    bounds = _bounds(order, elements)
    return np.concatenate([[bounds[-1] - elements], bounds])


def _tiles(x: Array, stations: int) -> Array:
    """(e, FINE^2, 3) by element of what is (FINE * stations, FINE * angles, 3)."""
    blocks = x.reshape(stations, FINE, -1, FINE, 3)
    return np.moveaxis(blocks, 2, 1).reshape(-1, FINE * FINE, 3)
