"""Painting surfaces in space: parallel projection, farthest quadrilaterals first, matt shading."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from coupling.pictures import scaled
from coupling.surfaces import Surface

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]

ELEVATION = np.radians(52.0)  # of the eye above the plane of the largest extents
LIGHT = np.array([-0.45, 0.55, 0.70])  # to the right, up, towards the eye
PLAIN = (0.62, 0.70, 0.82, 1.0)


class Camera(NamedTuple):
    """Parallel projection; rows of ``basis`` point to the right, up, and towards the eye."""

    basis: Array

    def project(self, points: Array) -> Array:
        """(…, 3) [m] in space as right, up, nearness [m]."""
        return points @ self.basis.T


class Colouring(NamedTuple):
    """What colours show: a field of the surfaces as factor * (value + offset), and its range."""

    field: str
    label: str
    offset: float
    factor: float
    lower: float
    upper: float

    def colors(self, values: Array) -> Array:
        """(n, 4) colours of (n,) values of the field."""
        shown = self.factor * (values + self.offset)
        return palette()((shown - self.lower) / (self.upper - self.lower))


def camera_for(points: Array) -> Camera:
    """Looks at the plane of the largest extents, the longest one to the right, z upwards.

    points : (n, 3) float [m]
    """
    spread = points - points.mean(axis=0)
    # a line or a point lets the last coordinate axis be the normal
    preference = np.diag([3.0, 2.0, 1.0]) * (1e-6 * np.abs(spread).max() + 1e-12)
    _, _, principal = np.linalg.svd(np.vstack([spread, preference]), full_matrices=False)
    right, normal = principal[0], principal[2]
    right = right * np.sign(right[np.argmax(np.abs(right))])
    up = np.cos(ELEVATION) * normal + np.sin(ELEVATION) * np.cross(normal, right)
    upright = up[2] if abs(up[2]) > 1e-3 else up[np.argmax(np.abs(up))]
    up = up * np.sign(upright)
    return Camera(np.stack([right, up, np.cross(right, up)]))


def palette() -> Any:
    """Plasma without its darkest part, which a dark background would swallow."""
    from matplotlib import colormaps
    from matplotlib.colors import ListedColormap

    return ListedColormap(colormaps["plasma"](np.linspace(0.12, 1.0, 256)))


def colouring_of(surfaces: Sequence[Surface]) -> Colouring | None:
    """Temperature if there is any that differs, otherwise axial stress, otherwise nothing."""
    for field, label, offset, unit in (
        ("temperature", "temperature", -273.15, "°C"),
        ("stress", "axial stress", 0.0, "Pa"),
    ):
        values = np.concatenate([getattr(s, field) for s in surfaces]) + offset
        values = values[np.isfinite(values)]
        if values.size and np.ptp(values) > 1e-9 * np.abs(values).max():
            factor, unit = (1.0, unit) if unit == "°C" else scaled(values, unit)
            lower, upper = factor * float(values.min()), factor * float(values.max())
            return Colouring(field, f"{label} [{unit}]", offset, factor, lower, upper)
    return None


def paint(
    ax: "Axes", camera: Camera, surfaces: Sequence[Surface], colouring: Colouring | None
) -> None:
    """All surfaces as one collection, sorted by nearness."""
    from matplotlib.collections import PolyCollection

    painted = [_painted(camera, s, colouring) for s in surfaces if len(s.quads)]
    if not painted:
        return
    quads: Any = np.concatenate([corners for corners, _ in painted])
    colors = np.concatenate([shades for _, shades in painted])
    order = np.argsort(quads[:, :, 2].mean(axis=1))
    quads, colors = quads[order, :, :2], colors[order]
    # thin edges close the hairlines between neighbours
    ax.add_collection(PolyCollection(quads, facecolors=colors, edgecolors=colors, linewidths=0.25))


def _painted(camera: Camera, shape: Surface, colouring: Colouring | None) -> tuple[Array, Array]:
    """Projected corners (k, 4, 3) of the quads that face the eye, and their colours (k, 4)."""
    quads = camera.project(shape.points)[shape.quads]
    normal = np.cross(quads[:, 2] - quads[:, 0], quads[:, 3] - quads[:, 1])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
    if shape.is_open:
        normal *= np.where(normal[:, 2:] < 0.0, -1.0, 1.0)
    front = normal[:, 2] > 0.0
    quads, normal = quads[front], normal[front]
    base = np.tile(PLAIN, (len(quads), 1))
    if colouring is not None:
        values = getattr(shape, colouring.field)[shape.quads[front]].mean(axis=1)
        known = np.isfinite(values)
        base[known] = colouring.colors(values[known])
    bright = np.clip(normal @ LIGHT, 0.0, 1.0)[:, None]
    base[:, :3] = np.clip(base[:, :3] * (0.5 + 0.6 * bright) + 0.12 * bright**8, 0.0, 1.0)
    return quads, base
