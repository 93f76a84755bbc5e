"""From members to the finite element terms of ``thermal.line``."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from thermal.description import Member
from thermal.layout import arclength
from thermal.profiles import profile, scales
from thermal.terms import Chain, Crossing

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
Regions = Mapping[str, Indices]


class Line(NamedTuple):
    """Linear elements along one member.

    shape : (2, n_e, q) float  shape functions at Gauss points
    stiffness : (n_e, q) float [1/m]  Gauss weight times squared slope of the shape functions
    lengths : (n_s,) float [m]  length of member that belongs to each station
    """

    shape: Array
    stiffness: Array
    lengths: Array


def discretise(members: Sequence[Member]) -> dict[str, Line]:
    """Linear elements of each member, from one scikit-fem mesh of all of them."""
    if not members:
        return {}
    from skfem import Basis, ElementLineP1, LinearForm, MeshLine

    vertices, elements, last = _axis(members)
    mesh = MeshLine(vertices[None, :], elements)
    basis = Basis(mesh, ElementLineP1(), intorder=3)
    shape = np.stack([np.broadcast_to(b[0], basis.dx.shape) for b in basis.basis])
    stiffness = basis.dx * np.asarray(basis.basis[1][0].grad[0]) ** 2
    at_stations = (np.array([[0.0, 1.0]]), np.array([0.5, 0.5]))
    trapezoids = Basis(mesh, ElementLineP1(), quadrature=at_stations)
    lengths = np.split(LinearForm(lambda v, _: v).assemble(trapezoids), last[:-1])
    bounds = (last - np.arange(1, len(last) + 1))[:-1]  # a member has one element less
    shapes, stiffnesses = np.split(shape, bounds, axis=1), np.split(stiffness, bounds)
    lines = zip(shapes, stiffnesses, lengths, strict=True)
    return {m.name: Line(*line) for m, line in zip(members, lines, strict=True)}


def _axis(members: Sequence[Member]) -> tuple[Array, Indices, Indices]:
    """Stations on one axis with gaps between members, elements (2, n_e), ends of members."""
    along = [arclength(m.points) for m in members]
    offsets = np.cumsum([0.0] + [1.001 * s[-1] for s in along[:-1]])
    last = np.cumsum([len(s) for s in along])
    near = np.setdiff1d(np.arange(last[-1]), last - 1)
    vertices = np.concatenate([s + o for s, o in zip(along, offsets, strict=True)])
    return vertices, np.stack([near, near + 1]), last


def chains(members: Sequence[Member], lines: Mapping[str, Line], regions: Regions) -> list[Chain]:
    """Storage and conduction; members with the same material and number of values together."""
    return [
        _chain(group, [lines[m.name] for m in group], [stations(m, regions) for m in group])
        for group in alike(members)
    ]


def alike(members: Sequence[Member]) -> list[list[Member]]:
    """Members of one material and one number of values."""
    groups: dict[tuple[int, int], list[Member]] = {}
    for m in members:
        groups.setdefault((id(m.material), m.wall_points), []).append(m)
    return list(groups.values())


def stations(m: Member, regions: Regions) -> Indices:
    """(stations, N)  the temperatures of a member."""
    return regions[m.name].reshape(-1, m.wall_points)


def _chain(members: Sequence[Member], lines: Sequence[Line], dofs: Sequence[Indices]) -> Chain:
    n, material = members[0].wall_points, members[0].material
    values, slopes = profile(n)
    shares = [m.section.area / len(values) for m in members]
    pairs = list(zip(shares, lines, strict=True))
    volumes = [share * line.lengths for share, line in pairs]
    sizes = [scales(m.section, n) for m in members]
    last = np.cumsum([len(d) for d in dofs])
    crossings = [
        Crossing(
            np.concatenate([v / size[d] ** 2 for v, size in zip(volumes, sizes, strict=True)]),
            slopes[d],
            material.conductivities[1 + d],
        )
        for d in range(len(slopes))
    ]
    return Chain(
        np.concatenate(dofs),
        np.setdiff1d(np.arange(last[-1]), last - 1),
        material.density * np.concatenate(volumes),
        np.concatenate([line.shape for line in lines], axis=1),
        np.concatenate([share * line.stiffness for share, line in pairs]),
        values,
        tuple(crossings),
        material,
    )
