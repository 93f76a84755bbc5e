"""Where things are: the nodes of each body, and which of them a site means."""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from coupling.motion_tables import LineBody, Particle

Array = NDArray[np.float64]

NODE_TOLERANCE = 1e-6  # how near to a node a distance along a body must be, per length of the body


def points_of(body: LineBody | Particle, folder: Path) -> Array:
    """Nodes of a body (n, 3) [m] in the order of their distance from its start.

    Raises
    ------
    ValueError : the mesh file cannot be used
    """
    if isinstance(body, Particle):
        return np.array([body.position])
    if body.mesh is None:
        return _straight(body)
    from meshes.generate import frames
    from meshes.io import read_line

    points = read_line(folder / body.mesh, body.region)
    if not np.isfinite(points).all():
        raise ValueError("the line has coordinates that are not finite numbers")
    frames(points, body.normal)
    return points


def _straight(body: LineBody) -> Array:
    from meshes.generate import line

    assert body.start and body.end and body.elements  # the table has them when it has no mesh
    return line(body.start, body.end, body.elements)[0]


def distances(points: Array) -> Array:
    """(n,) [m]  of the nodes from the start, along the body."""
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    return np.concatenate([[0.0], np.cumsum(steps)])


def node_of(points: Array, at: Any) -> int:
    """Index of the node at 'start', 'end' or a distance [m] from the start.

    Raises
    ------
    ValueError : no node is there
    """
    if at in (None, "start"):
        return 0
    if at == "end":
        return len(points) - 1
    along = distances(points)
    nearest = int(np.argmin(np.abs(along - at)))
    if abs(along[nearest] - at) <= NODE_TOLERANCE * along[-1]:
        return nearest
    if at > along[-1]:
        raise ValueError(f"lies beyond the end: the body is {along[-1]:g} m long, got {at:g} m")
    i = int(np.searchsorted(along, at))
    raise ValueError(
        f"no node at {at:g} m; the nearest are at {along[i - 1]:g} m and {along[i]:g} m"
    )
