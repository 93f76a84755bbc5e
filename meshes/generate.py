"""Points and section triads of lines, and surfaces swept along them.

A triad is three rows: e1 the tangent, e2 the given normal made perpendicular to it, and
e3 = e1 x e2.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

PARALLEL = 1e-6  # sine of the angle below which a normal counts as parallel to a tangent


def line(
    start: ArrayLike, end: ArrayLike, elements: int, normal: ArrayLike | None = None
) -> tuple[Array, Array]:
    """Straight line of equal ``elements``.

    Returns
    -------
    points : (elements + 1, 3) float [m]
    axes : (elements + 1, 3, 3) float  triads; without ``normal`` e2 comes from the coordinate
        axis least parallel to the line
    """
    a, b = _vector("start", start), _vector("end", end)
    _require_elements(elements)
    if not np.linalg.norm(b - a) > 0.0:
        raise ValueError("line: start and end coincide")
    points = a + np.linspace(0.0, 1.0, elements + 1)[:, None] * (b - a)
    points[-1] = b
    return points, frames(points, _default_normal(b - a) if normal is None else normal)


def arc(
    center: ArrayLike, start: ArrayLike, axis: ArrayLike, angle: float, elements: int
) -> tuple[Array, Array]:
    """Circular arc of equal ``elements``, turning ``start`` about ``axis`` by ``angle`` [rad].

    Returns
    -------
    points : (elements + 1, 3) float [m]
    axes : (elements + 1, 3, 3) float  exact tangents; e2 points to the axis
    """
    c, a = _vector("center", center), _vector("start", start)
    k = _unit("axis", _vector("axis", axis))
    _require_elements(elements)
    if not 0.0 < abs(angle) <= 2.0 * np.pi:
        raise ValueError(f"arc: angle must lie between 0 and a full turn, got {angle!r} rad")
    along = np.dot(a - c, k) * k
    radius = a - c - along
    _unit("start, seen from the axis,", radius)
    turn = np.linspace(0.0, angle, elements + 1)[:, None]
    radial = np.cos(turn) * radius + np.sin(turn) * np.cross(k, radius)
    tangents = np.sign(angle) * np.cross(k, radial)
    return c + along + radial, _triads(tangents, -radial)


def resample(points: ArrayLike, elements: int) -> Array:
    """``elements + 1`` points at equal arclength on a polyline, ends kept, corners cut.

    Parameters
    ----------
    points : (n, 3) float [m]
    """
    path = _polyline(points)
    _require_elements(elements)
    s = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
    targets = np.linspace(0.0, s[-1], elements + 1)
    sampled = np.column_stack([np.interp(targets, s, x) for x in path.T])
    sampled[-1] = path[-1]
    return sampled


def frames(points: ArrayLike, normal: ArrayLike | None = None) -> Array:
    """Triads at the points of a polyline.

    Tangents are the mean of the directions of the adjacent segments. With ``normal`` e2 is
    that vector made perpendicular to each tangent; without, e2 of the first point is carried
    along without twist (double reflection, Wang et al. 2008).

    Parameters
    ----------
    points : (n, 3) float [m]

    Returns
    -------
    (n, 3, 3) float
    """
    path = _polyline(points)
    tangents = _tangents(path)
    if normal is not None:
        n = _unit("normal", _vector("normal", normal))
        return _triads(tangents, np.broadcast_to(n, path.shape))
    first = _triads(tangents[:1], _default_normal(tangents[0])[None])[0, 1]
    return _triads(tangents, _carried(path, tangents, first))


def sweep(points: Array, axes: Array, outline: Array) -> tuple[Array, Indices]:
    """Surface of quadrilaterals made by moving a closed outline along a line.

    Parameters
    ----------
    points : (n, 3) float [m]
    axes : (n, 3, 3) float  rows e1, e2, e3; e2 and e3 may be stretched or sheared
    outline : (k, 2) float [m]  y along e2 and z along e3, turning from e2 towards e3

    Returns
    -------
    points : (n k, 3) float [m]  station by station, in the order of the outline
    quads : ((n - 1) k, 4) int  seen counterclockwise from outside
    """
    n, k = len(points), len(outline)
    y, z = outline[:, 0, None], outline[:, 1, None]
    surface = points[:, None] + y * axes[:, None, 1] + z * axes[:, None, 2]
    near = np.arange(n * k).reshape(n, k)
    beside = np.roll(near, -1, axis=1)
    quads = np.stack([near[:-1], beside[:-1], beside[1:], near[1:]], axis=-1)
    return surface.reshape(-1, 3), quads.reshape(-1, 4)


def _tangents(path: Array) -> Array:
    directions = np.diff(path, axis=0)
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    mean = np.vstack([directions[:1], directions[:-1] + directions[1:], directions[-1:]])
    length = np.linalg.norm(mean, axis=1, keepdims=True)
    if length.min() < PARALLEL:
        raise ValueError(f"the line turns back on itself at point {int(length.argmin())}")
    return mean / length


def _carried(path: Array, tangents: Array, first: Array) -> Array:
    """Normals carried from point to point by two reflections, so that they do not twist."""
    normals = np.empty_like(path)
    normals[0] = first
    for i, chord in enumerate(np.diff(path, axis=0)):
        normal = _reflected(normals[i], chord)
        tangent = _reflected(tangents[i], chord)
        normals[i + 1] = _reflected(normal, tangents[i + 1] - tangent)
    return normals


def _reflected(v: Array, across: Array) -> Array:
    """v reflected in the plane through the origin that is perpendicular to ``across``."""
    square = across @ across
    return v if square == 0.0 else v - 2.0 * (across @ v) / square * across


def _triads(tangents: Array, normals: Array) -> Array:
    e1 = tangents / np.linalg.norm(tangents, axis=1, keepdims=True)
    e2 = normals - np.sum(normals * e1, axis=1, keepdims=True) * e1
    length = np.linalg.norm(e2, axis=1, keepdims=True)
    limit = PARALLEL * np.linalg.norm(normals, axis=1, keepdims=True)
    if (length <= limit).any():
        raise ValueError("the normal is parallel to the line")
    e2 = e2 / length
    return np.stack([e1, e2, np.cross(e1, e2)], axis=1)


def _default_normal(tangent: Array) -> Array:
    """The coordinate axis least parallel to the tangent, the first one if two are alike."""
    alignment = np.abs(tangent) / np.linalg.norm(tangent)
    return np.eye(3)[int(np.argmin(np.round(alignment, 6)))]


def _polyline(points: ArrayLike) -> Array:
    path = np.array(points, dtype=float)
    if path.ndim != 2 or path.shape[1] != 3 or len(path) < 2:
        raise ValueError(f"a line needs two or more points in space, got shape {path.shape}")
    if not np.isfinite(path).all():
        raise ValueError("the points of a line must be finite")
    repeated = np.flatnonzero(np.linalg.norm(np.diff(path, axis=0), axis=1) == 0.0)
    if repeated.size:
        raise ValueError(f"points {repeated[0]} and {repeated[0] + 1} of the line coincide")
    return path


def _vector(name: str, values: ArrayLike) -> Array:
    v = np.array(values, dtype=float)
    if v.shape != (3,) or not np.isfinite(v).all():
        raise ValueError(f"{name} must be three finite numbers, got {values!r}")
    return v


def _unit(name: str, v: Array) -> Array:
    length = np.linalg.norm(v)
    if not length > 0.0:
        raise ValueError(f"{name} must not be zero")
    return v / length


def _require_elements(elements: int) -> None:
    if isinstance(elements, bool) or not isinstance(elements, int | np.integer) or elements < 1:
        raise ValueError(f"elements must be a positive integer, got {elements!r}")
