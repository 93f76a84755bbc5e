"""Surfaces made of quadrilaterals, with the parametric derivatives that shell elements need."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
Span = tuple[float, float]
Count = int | Sequence[float]
"""Number of elements of one size, or where the grid lines are, as fractions rising from 0 to 1."""
Shape = Callable[[Array, Array], tuple[Array, Array, Array, Array]]

WHOLE = (0.0, 2.0 * np.pi)
"""A full turn [rad]."""


@dataclass(frozen=True)
class Surface:
    """Middle surface of a shell.

    Parameters u, v are lengths [m]; an element spans ``sizes`` of them. Derivatives are by u and v,
    continuous from element to element.

    Attributes
    ----------
    points : (n, 3) float [m]
    quads : (n_e, 4) int  corners at (0, 0), (a, 0), (a, b), (0, b)
    sizes : (n_e, 2) float [m]  a, b of each element
    d_u, d_v : (n, 3) float [-]  first derivatives
    d_uv : (n, 3) float [1/m]  mixed derivative
    """

    points: Array
    quads: Indices
    sizes: Array
    d_u: Array
    d_v: Array
    d_uv: Array


def patch(shape: Shape, u: ArrayLike, v: ArrayLike, closed: bool = False) -> Surface:
    """A grid of elements on a surface given by a function of its parameters.

    Parameters
    ----------
    shape : takes u, v [m], each (n,); gives r [m], r_u, r_v [-], r_uv [1/m], each (n, 3)
    u, v : (n_u + 1,), (n_v + 1,) float [m]  where the grid lines are, rising
    closed : the last grid line of u is the first one again

    Returns
    -------
    Surface whose node (i, j), at u[i] and v[j], has number ``i * (n_v + 1) + j``
    """
    u, v = np.asarray(u, float), np.asarray(v, float)
    _check_rising(u, v)
    rows, columns = u.size - closed, v.size
    at = np.meshgrid(u[:rows], v, indexing="ij")
    points, d_u, d_v, d_uv = (np.array(x, float) for x in shape(at[0].ravel(), at[1].ravel()))
    i, j = (x.ravel() for x in np.meshgrid(range(u.size - 1), range(v.size - 1), indexing="ij"))
    ahead = (i + 1) % rows
    corners = [i * columns + j, ahead * columns + j, ahead * columns + j + 1, i * columns + j + 1]
    sizes = np.stack([np.diff(u)[i], np.diff(v)[j]], axis=1)
    return Surface(points, np.stack(corners, axis=1).astype(np.intp), sizes, d_u, d_v, d_uv)


def plate(length: float, width: float, n_u: Count, n_v: Count) -> Surface:
    """Rectangle in the plane z = 0, from the origin along x (u) and y (v); its normal is z."""

    def shape(u: Array, v: Array) -> tuple[Array, Array, Array, Array]:
        o = np.zeros_like(u)
        x, y = np.stack([o + 1.0, o, o], axis=1), np.stack([o, o + 1.0, o], axis=1)
        return np.stack([u, v, o], axis=1), x, y, np.stack([o, o, o], axis=1)

    return patch(shape, _lines((0.0, length), n_u), _lines((0.0, width), n_v))


def tube(radius: float, length: float, n_u: Count, n_v: Count, angle: Span = WHOLE) -> Surface:
    """Circular cylinder about z, from z = 0: u runs around it, v along it; the normal is outward.

    angle : [rad]  from x towards y; a full turn is closed, anything less is a panel
    """

    def shape(u: Array, v: Array) -> tuple[Array, Array, Array, Array]:
        o, phi = np.zeros_like(u), u / radius
        around = np.stack([-np.sin(phi), np.cos(phi), o], axis=1)
        r = np.stack([radius * np.cos(phi), radius * np.sin(phi), v], axis=1)
        return r, around, np.stack([o, o, o + 1.0], axis=1), np.zeros_like(r)

    u = radius * _lines(angle, n_u)
    return patch(shape, u, _lines((0.0, length), n_v), closed=_is_whole(angle))


def annulus(inner: float, outer: float, n_u: Count, n_v: Count, angle: Span = WHOLE) -> Surface:
    """Annular sector in z = 0, slit along its first radius: u outward, v around; normal z.

    angle : [rad]  from x towards y; a full turn remains slit, with two edges in one place
    """
    middle = 0.5 * (inner + outer)

    def shape(u: Array, v: Array) -> tuple[Array, Array, Array, Array]:
        o, phi = np.zeros_like(u), v / middle
        out = np.stack([np.cos(phi), np.sin(phi), o], axis=1)
        around = np.stack([-np.sin(phi), np.cos(phi), o], axis=1)
        r = u[:, None]
        return r * out, out, r / middle * around, around / middle

    return patch(shape, _lines((inner, outer), n_u), middle * _lines(angle, n_v))


def sphere(radius: float, n_u: Count, n_v: Count, latitude: Span, azimuth: Span = WHOLE) -> Surface:
    """Part of a sphere about the origin: u runs around z, v up to the pole; outward normal.

    latitude : [rad]  from the plane z = 0; the poles themselves are no part of it
    azimuth : [rad]  from x towards y; a full turn is closed
    """
    if not -0.5 * np.pi < latitude[0] < latitude[1] < 0.5 * np.pi:
        raise ValueError(f"latitudes must lie between -pi/2 and pi/2, got {latitude}")

    def shape(u: Array, v: Array) -> tuple[Array, Array, Array, Array]:
        phi, theta, o = u / radius, v / radius, np.zeros_like(u)
        out = np.stack([np.cos(phi), np.sin(phi), o], axis=1)
        around = np.stack([-np.sin(phi), np.cos(phi), o], axis=1)
        sine, cosine = np.sin(theta)[:, None], np.cos(theta)[:, None]
        pole = np.array([0.0, 0.0, 1.0])
        r, up = radius * (cosine * out + sine * pole), cosine * pole - sine * out
        return r, cosine * around, up, -sine / radius * around

    u, v = radius * _lines(azimuth, n_u), radius * _lines(latitude, n_v)
    return patch(shape, u, v, closed=_is_whole(azimuth))


def placed(surface: Surface, origin: ArrayLike, axes: ArrayLike) -> Surface:
    """The surface with its x, y, z along the rows of ``axes`` (3, 3), moved to ``origin`` [m]."""
    turn = np.asarray(axes, float)
    vectors = {name: getattr(surface, name) @ turn for name in ("d_u", "d_v", "d_uv")}
    return replace(surface, points=np.asarray(origin, float) + surface.points @ turn, **vectors)


def _lines(span: Span, count: Count) -> Array:
    if isinstance(count, int) and count < 1:
        raise ValueError(f"a surface needs at least one element each way, got {count}")
    fractions = np.linspace(0.0, 1.0, count + 1) if isinstance(count, int) else np.asarray(count)
    return span[0] + (span[1] - span[0]) * fractions


def _is_whole(angle: Span) -> bool:
    return bool(abs(angle[1] - angle[0] - 2.0 * np.pi) < 1e-9)


def _check_rising(u: Array, v: Array) -> None:
    for name, x in (("u", u), ("v", v)):
        if x.ndim != 1 or x.size < 2 or not (np.diff(x) > 0.0).all():
            raise ValueError(f"grid lines of {name} must rise, got {x}")
