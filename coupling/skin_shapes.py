"""Recorded skins: their facets in space, with tubes made thicker, and laid out flat."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from coupling.reading import Results
from coupling.surfaces import Body, Patches, centre_line, read_bodies

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

MEMORY = 2**14  # facets times segments that are measured at once
TURN = 360.0


class Skin(NamedTuple):
    """One recorded face.

    body : Body | None  None: a solid
    light : whether its absorbed light is known
    """

    name: str
    body: Body | None
    light: bool

    @property
    def is_tube(self) -> bool:
        """Whether it goes round a line."""
        return self.body is not None and self.body.section is not None


class Flat(NamedTuple):
    """A face laid out.

    corners : (n, 4, 2) float  along, and around [deg] or across [m]
    period : float  after which it repeats across; 0: it does not
    along, across : titles of the axes
    """

    corners: Array
    period: float
    along: str
    across: str


def read_skins(results: Results) -> list[Skin]:
    """All recorded faces."""
    bodies = {body.name: body for body in read_bodies(results)} if results.names("skins") else {}
    return [
        Skin(name, bodies.get(name.rpartition(".")[0]), f"skins/{name}/light" in results)
        for name in results.names("skins")
    ]


def telling_frames(results: Results, most: int) -> list[int]:
    """Frames that tell what happens: evenly over time and over the change of temperature."""
    times, change = results["frames/time"], np.zeros(1)
    for name in results.names("skins"):
        T = results[f"skins/{name}/temperature"]
        change = change + np.concatenate([[0.0], np.abs(np.diff(T, axis=0)).mean(axis=1).cumsum()])
    way = [x / x[-1] if x[-1] > 0.0 else np.zeros(1) for x in (times - times[0], change)]
    way_so_far = way[0] + way[1]
    marks = np.linspace(0.0, way_so_far[-1], min(most, len(times)))
    return sorted({int(np.argmin(np.abs(way_so_far - mark))) for mark in marks} | {len(times) - 1})


# -------------------------------------------------------------------------------- smaller facets


def light_of(results: Results, skin: Skin, frame: int) -> Array:
    """(n,) or (n, p) [W/m^2]  absorbed light of facets, or of p parts of each."""
    name = f"skins/{skin.name}/parts"
    return results[name if name in results else f"skins/{skin.name}/light"][frame]


def parted(corners: Array, values: Array) -> tuple[Array, Array]:
    """Facets (n, 4, d) with values (n, p) as n p facets, row by row; others as they are."""
    if values.ndim == 1:
        return corners, values
    small = small_facets(corners, values.shape[1])
    return small.reshape(-1, *corners.shape[1:]), values.reshape(-1)


def small_facets(corners: Array, parts: int) -> Array:
    """(n, parts, 4, d)  quadrilaterals (n, 4, d) cut between Gauss points both ways."""
    side = round(parts**0.5)
    cuts = np.concatenate([[0.0], np.cumsum(0.5 * np.polynomial.legendre.leggauss(side)[1])])
    a, b = np.meshgrid(cuts, cuts, indexing="ij")
    shares = np.stack([(1 - a) * (1 - b), a * (1 - b), a * b, (1 - a) * b], axis=-1)
    grid = np.einsum("ijc,ncd->nijd", shares, corners)
    around = [grid[:, :-1, :-1], grid[:, 1:, :-1], grid[:, 1:, 1:], grid[:, :-1, 1:]]
    return np.stack(around, axis=3).reshape(len(corners), parts, 4, corners.shape[-1])


# ---------------------------------------------------------------------------------- along a line


def thickened(skin: Skin, corners: Array, frame: int, factor: float) -> Array:
    """Corners (..., 3) [m] of a tube, ``factor`` times as far from its axis."""
    if factor == 1.0 or not skin.is_tube:
        return corners
    assert skin.body is not None
    line = centre_line(skin.body.position[frame], skin.body.axes[frame])[0]
    segment, share = _nearest(line, corners.reshape(-1, 3))
    foot = (line[segment] + share[:, None] * (line[segment + 1] - line[segment])).reshape(
        corners.shape
    )
    return foot + factor * (corners - foot)


def _nearest(line: Array, points: Array) -> tuple[Indices, Array]:
    """Segment (m,) of a line (s + 1, 3) that is nearest to points (m, 3), and where on it."""
    size = max(1, MEMORY // len(line))
    pieces = [_of_few(line, points[i : i + size]) for i in range(0, len(points), size)]
    return np.concatenate([a for a, _ in pieces]), np.concatenate([b for _, b in pieces])


def _of_few(line: Array, points: Array) -> tuple[Indices, Array]:
    way = np.diff(line, axis=0)
    away = points[:, None] - line[:-1]
    share = np.clip(np.einsum("msx,sx->ms", away, way) / np.sum(way**2, axis=1), 0.0, 1.0)
    distance = np.linalg.norm(away - share[..., None] * way, axis=2)
    segment = np.argmin(distance, axis=1)
    return segment, share[np.arange(len(points)), segment]


# ------------------------------------------------------------------------------------- laid out


def laid_out(skin: Skin, corners: Array) -> Flat | None:
    """A face on paper, from its corners (n, 4, 3) [m] in the first frame; None for solids."""
    if skin.body is None:
        return None
    if skin.is_tube:
        return _unrolled(skin.body, corners)
    patches = skin.body.patches
    if patches is not None and len(patches.quads) == len(corners):
        return Flat(_spread(patches, skin.name), 0.0, "u [m]", "v [m]")
    return None


def _unrolled(body: Body, corners: Array) -> Flat:
    line, axes = centre_line(body.position[0], body.axes[0])
    points = corners.reshape(-1, 3)
    segment, share = _nearest(line, points)
    way = np.diff(line, axis=0)
    lengths = np.linalg.norm(way, axis=1)
    start = np.concatenate([[0.0], np.cumsum(lengths)])
    along = start[segment] + share * lengths[segment]
    out = points - line[segment] - share[:, None] * way[segment]
    e2, e3 = axes[segment, 1], axes[segment, 2]
    angle = np.degrees(np.arctan2(np.sum(out * e3, axis=1), np.sum(out * e2, axis=1)))
    angle = angle.reshape(-1, 4)
    apart = (angle - angle[:, :1] + 0.5 * TURN) % TURN - 0.5 * TURN
    flat = np.stack([along.reshape(-1, 4), angle[:, :1] + apart], axis=2)
    return Flat(flat, TURN, "along [m]", "around [deg]")


def _spread(patches: Patches, name: str) -> Array:
    """(n, 4, 2) [m]  u and v of the elements of a shell, each beside its neighbours."""
    origin = np.zeros((len(patches.quads), 2))
    for new, old, step in _walk(patches.quads):
        origin[new] = origin[old] + np.where(step > 0, patches.sizes[old], 0.0) * step
        origin[new] -= np.where(step < 0, patches.sizes[new], 0.0) * np.abs(step)
    square = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], dtype=float)
    corners = origin[:, None] + patches.sizes[:, None] * square
    return corners[:, ::-1] if name.endswith(".bottom") else corners


EDGES = {(1, 2): (0, 3, (1, 0)), (0, 3): (1, 2, (-1, 0)), (3, 2): (0, 1, (0, 1)),
         (0, 1): (3, 2, (0, -1))}  # fmt: skip
"""Corners on an edge of an element: those of its neighbour that are there, and the way to it."""


def _walk(quads: Indices) -> Iterator[tuple[int, int, NDArray[np.intp]]]:
    """New element, its known neighbour and the way to it, until all are known."""
    by_edge: dict[tuple[int, ...], dict[tuple[int, int], int]] = {}
    for number, quad in enumerate(quads):
        for a, b in EDGES:
            by_edge.setdefault((quad[a], quad[b]), {})[a, b] = number
    known, waiting = {0}, [0]
    while waiting:
        old = waiting.pop(0)
        for (a, b), (c, d, step) in EDGES.items():
            new = by_edge[quads[old][a], quads[old][b]].get((c, d))
            if new is not None and new not in known:
                known.add(new)
                waiting.append(new)
                yield new, old, np.array(step)
