"""How the nodes of solids read temperatures: those of the heat in 3D, or of sections of a beam.

Each node reads a mean with weights of sum one: a constant is kept, and what goes the other way is
conserved. Where nodes coincide each reads its own. Between nodes of the heat in 3D it is the shape
functions of the cell there that weigh. From sections it is mean and gradients, and of a tube what
is left of its temperatures round the circumference, straight between them; stations are joined by
straight lines.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array

from coupling.continuum import IN_3D, Solid, solids
from coupling.scene import Scene
from coupling.transfer import SAME_STATION, section_coordinates, weighted_fit

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

COINCIDENT = 1e-7
"""Distance of nodes that are the same, relative to the size of a body [-]."""
ROUNDS = 12  # of Newton's method for the place of a point in a cell
TURN = 2.0 * np.pi


def readings(scene: Scene, heat_solver: Any, shares: Mapping[str, Array]) -> dict[str, csr_array]:
    """How the nodes (n) of each solid read the temperatures (k) of its region."""
    if scene.thermal is None or not scene.mechanics.is_continuum:
        return {}
    found = {}
    for name, solid in solids(scene).items():
        if scene.thermal.solver in IN_3D:
            found[name] = _from_cells(scene, solid, len(heat_solver.regions[name]))
        else:
            x = heat_solver.x[heat_solver.regions[name]]
            own = shares.get(name, np.ones(len(x)))
            found[name] = from_sections(scene, solid, x, own)
    return found


# ----------------------------------------------------------------------------------- sections


def from_sections(scene: Scene, solid: Solid, x: Array, shares: Array) -> csr_array:
    """(n, k)  from temperatures at ``x`` (k, 3), station by station of the beam."""
    shape = scene.shapes[solid.name]
    s, y, z = section_coordinates(x, shape.points, shape.axes)
    stations, groups = _stations(s / _length(shape.points))
    maps = [_section_map(solid, y[g], z[g], shares[g]) for g in groups]
    at = solid.local[:, 0]
    after = np.clip(np.searchsorted(stations, at), 1, max(len(stations) - 1, 1))
    low, high = after - 1, np.minimum(after, len(stations) - 1)
    gap = np.maximum(stations[high] - stations[low], 1e-300)
    share = np.clip((at - stations[low]) / gap, 0.0, 1.0)
    parts = []
    for number, weight in ((low, 1.0 - share), (high, share)):
        for k, (group, section) in enumerate(zip(groups, maps, strict=True)):
            rows = np.flatnonzero((number == k) & (weight > 0.0))
            values = weight[rows, None] * section(rows)
            parts.append((np.repeat(rows, len(group)), np.tile(group, len(rows)), values.ravel()))
    rows, columns, values = (np.concatenate(p) for p in zip(*parts, strict=True))
    block = coo_array((values, (rows, columns)), shape=(len(at), len(x))).tocsr()
    block.eliminate_zeros()
    return block


def _length(points: Array) -> float:
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())


def _stations(s: Array) -> tuple[Array, list[Indices]]:
    """Places of the stations, and the temperatures of each."""
    order = np.argsort(s, kind="stable")
    groups = np.split(order, np.flatnonzero(np.diff(s[order]) > SAME_STATION) + 1)
    return np.array([s[g].mean() for g in groups]), groups


def _section_map(solid: Solid, y: Array, z: Array, shares: Array) -> Any:
    """What gives the weights (r, k) of the k temperatures of a station for some of the nodes."""
    fit = weighted_fit(y, z, shares)
    around = _rings(y, z) if solid.section.kind == "tube" and len(y) >= 4 else None
    rest = np.eye(len(y)) - np.column_stack([np.ones_like(y), y, z]) @ fit

    def weights(rows: Indices) -> Array:
        _, there_y, there_z = solid.local[rows].T
        found = np.column_stack([np.ones(len(rows)), there_y, there_z]) @ fit
        if around is not None:
            found += _round(around, there_y, there_z, len(y)) @ rest
        return found

    return weights


def _rings(y: Array, z: Array) -> list[tuple[float, Array, Indices]]:
    """Radius, angles that rise, and temperatures of each ring."""
    radius, angle = np.hypot(y, z), _angle(y, z)
    order = np.argsort(radius, kind="stable")
    groups = np.split(order, np.flatnonzero(np.diff(radius[order]) > 1e-6 * radius.max()) + 1)
    sorted_groups = [g[np.argsort(angle[g])] for g in groups]
    return [(float(radius[g].mean()), angle[g], g) for g in sorted_groups]


def _angle(y: Array, z: Array) -> Array:
    return np.mod(np.arctan2(z, y) + 1e-9, TURN) - 1e-9


def _round(rings: list[tuple[float, Array, Indices]], y: Array, z: Array, count: int) -> Array:
    """(r, count)  straight along the circumference, and from ring to ring."""
    radii, angle = np.array([r for r, _, _ in rings]), _angle(y, z)
    found = np.zeros((len(y), count))
    for k, (_, angles, members) in enumerate(rings):
        part = np.interp(np.hypot(y, z), radii, np.eye(len(rings))[k])
        for i, member in enumerate(members):
            found[:, member] += part * np.interp(angle, angles, np.eye(len(angles))[i], period=TURN)
    return found


# -------------------------------------------------------------------------------------- cells


def _from_cells(scene: Scene, solid: Solid, count: int) -> csr_array:
    """(n, k)  from the nodes of the same body as the heat in 3D meshes it."""
    from coupling.heat_descriptions import heat_description, settings
    from thermal.solid_bodies import member_body

    assert scene.thermal is not None
    (member,) = [m for m in heat_description(scene).members if m.name == solid.name]
    body = member_body(member, settings(scene.thermal))
    assert len(body.points) == count
    ((family, cells),) = body.volumes[""].items()
    theirs = np.column_stack([body.local[:, 0] / body.local[:, 0].max(), body.local[:, 1:]])
    return from_mesh(
        solid.points, _unrolled(solid, solid.local), body.points, _unrolled(solid, theirs),
        family, cells, TURN if solid.section.kind == "tube" else 0.0,
    )  # fmt: skip


def _unrolled(solid: Solid, local: Array) -> Array:
    """(n, 3)  coordinates in which cells of two meshes lie in each other: of a tube part of the
    length, part of the wall and angle."""
    if solid.section.kind != "tube":
        size = 2.0 * np.abs(local[:, 1:]).max(axis=0)
        return local / np.array([1.0, *size])
    s, y, z = local.T
    radius = np.hypot(y, z)
    inner, outer = radius.min(), radius.max()
    return np.column_stack([s, (radius - inner) / (outer - inner), _angle(y, z)])


def from_mesh(
    points: Array, places: Array, nodes: Array, coordinates: Array, family: str, cells: Indices,
    period: float = 0.0,
) -> csr_array:  # fmt: skip
    """(n, k)  from nodes of a mesh to points: identity where they coincide, else shape functions.

    Parameters
    ----------
    points, places : (n, 3) float [m], [-]  where they are, and in which coordinates cells are
        looked for
    nodes, coordinates : (k, 3)  likewise of the nodes
    period : of the last coordinate; 0: none
    """
    from scipy.spatial import cKDTree

    size = float(np.linalg.norm(np.ptp(nodes, axis=0)))
    away, same = cKDTree(nodes).query(points)
    alike = away <= COINCIDENT * size
    other = np.flatnonzero(~alike)
    cell, x = _located(places[other], _unwrapped(coordinates[cells], period), family)
    values = _functions(family, x)
    k = cells.shape[1]
    rows = np.concatenate([np.flatnonzero(alike), np.repeat(other, k)])
    columns = np.concatenate([same[alike], cells[cell].ravel()])
    data = np.concatenate([np.ones(alike.sum()), values.ravel()])
    block = coo_array((data, (rows, columns)), shape=(len(points), len(nodes))).tocsr()
    block.eliminate_zeros()
    return block


def _unwrapped(corners: Array, period: float) -> Array:
    """Cells (c, k, 3) whose last coordinate does not jump within them."""
    if not period:
        return corners
    corners = corners.copy()
    least = corners[:, :, 2].min(axis=1, keepdims=True)
    wide = np.ptp(corners[:, :, 2], axis=1, keepdims=True) > 0.5 * period
    low = wide & (corners[:, :, 2] < least + 0.5 * period)
    corners[:, :, 2] += period * low
    return corners


def _located(places: Array, corners: Array, family: str) -> tuple[Indices, Array]:
    """Cell of each of the places, and where it is in the reference cell: the nearest within it."""
    cell, x = np.zeros(len(places), np.intp), np.zeros((len(places), 3))
    low, high = corners.min(axis=1), corners.max(axis=1)
    margin = 1e-6 * (high - low)
    for part in np.array_split(np.arange(len(places)), max(1, len(places) // 500)):
        if not len(part):
            continue
        at = places[part]
        outside = np.maximum(low - margin - at[:, None], at[:, None] - high - margin)
        gap = np.linalg.norm(np.maximum(outside, 0.0), axis=2)
        point, candidate = np.nonzero(gap <= gap.min(axis=1, keepdims=True) + 1e-12)
        found = _inverse(at[point], corners[candidate], family)
        beyond = np.abs(found - np.clip(found, 0.0, 1.0)).max(axis=1)
        order = np.lexsort((beyond, point))
        best = order[np.unique(point[order], return_index=True)[1]]
        cell[part], x[part] = candidate[best], np.clip(found[best], 0.0, 1.0)
    return cell, x


def _inverse(at: Array, corners: Array, family: str) -> Array:
    """(m, 3)  reference coordinates at which cells (m, k, 3) have the points ``at``."""
    x = np.full((len(at), 3), 0.5)
    for _ in range(ROUNDS):
        values, slopes = _shape(family, x)
        J = np.einsum("mkd,mkc->mcd", slopes, corners)
        away = at - np.einsum("mk,mkc->mc", values, corners)
        x = np.clip(x + np.linalg.solve(J, away[..., None])[..., 0], -1.0, 2.0)
    return x


def _functions(family: str, x: Array) -> Array:
    return _shape(family, x)[0]


def _shape(family: str, x: Array) -> tuple[Array, Array]:
    from thermal.solid_elements import functions

    return functions(family, x.T)
