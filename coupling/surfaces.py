"""The outer surface of the bodies in each recorded frame, with what is known on it."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from coupling.reading import Results
from meshes import generate
from meshes.sections import Section

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

AROUND = 24  # points of the outline
PIECES = 4  # pieces of an element between two nodes


class Patches(NamedTuple):
    """Elements of a shell, as recorded.

    quads : (n_e, 4) int;  sizes : (n_e, 2) float [m]
    slopes : (f, n, 3, 3) float  r_u, r_v [-], r_uv [1/m] at the nodes; None: straight edges
    """

    quads: Indices
    sizes: Array
    slopes: Array | None


class Facets(NamedTuple):
    """Boundary of a beam that was computed as a solid, as recorded.

    position : (f, n, 3) float [m];  temperature : (f, n) float [K]
    quads : (k, 4) int  four of each facet, with its middle
    """

    position: Array
    temperature: Array
    quads: Indices


class Body(NamedTuple):
    """History of one body as recorded.

    position : (f, n, 3) float [m]
    axes : (f, n, 3, 3) float  rows e1, e2, e3; zeros where they are not known
    temperature : (f, n, 3) float | None  mean [K], gradients along e2 and e3 [K/m]
    resultants : (f, e, 6) float | None  N, Q2, Q3 [N], Mt, M2, M3 [N m]
    section : None for all but beams and cables
    patches : elements of a shell
    box : (3, 3) float | None [m]  of a rigid body: rows are half edges of a solid box of the same
        inertia, along its axes e1, e2, e3
    facets : of a beam that was computed as a solid
    """

    name: str
    position: Array
    axes: Array
    temperature: Array | None
    resultants: Array | None
    section: Section | None
    patches: Patches | None = None
    box: Array | None = None
    facets: Facets | None = None

    @property
    def is_point(self) -> bool:
        """Whether it is drawn as a point."""
        return self.section is None and self.patches is None and self.box is None


class Surface(NamedTuple):
    """Surface of a body; temperature and stress are NaN where they are not known.

    points : (m, 3) float [m]
    quads : (k, 4) int; none for a particle
    displacement : (m, 3) float [m]  since the first frame
    temperature : (m,) float [K]
    stress : (m,) float [Pa]  axial, without the part that is in balance within the section
    resultants : (m, 8) float [N/m], [N]  of shells: N11, N22, N12, M11, M22, M12, Q1, Q2; or None
    is_open : both sides of it are seen
    gradient : (m,) float [K/m]  of the temperature of shells along their normal; or None
    """

    points: Array
    quads: Indices
    displacement: Array
    temperature: Array
    stress: Array
    resultants: Array | None = None
    is_open: bool = False
    gradient: Array | None = None


def read_bodies(results: Results) -> list[Body]:
    """All bodies that have positions."""
    return [
        _read_body(results, name)
        for name in results.names("bodies")
        if f"bodies/{name}/position" in results
    ]


def extent(body: Body) -> float:
    """Diagonal [m] of the box around the body in the first frame."""
    return float(np.linalg.norm(np.ptp(body.position[0], axis=0)))


def surface(body: Body, frame: int) -> Surface:
    """Surface of ``body`` in ``frame``, smooth between the nodes."""
    points, quads = _drawn(body, frame)
    unknown = np.full(len(points), np.nan)
    temperature = stress = resultants = gradient = None
    if body.facets is not None:
        temperature = body.facets.temperature[frame]
    elif body.section is not None:
        stations = len(points) // AROUND
        temperature = _wall_temperature(body, frame, stations)
        stress = _axial_stress(body, frame, stations)
    elif body.patches is not None:
        from coupling import patches

        temperature, gradient, resultants = patches.fields(body, body.patches, frame)
    elif body.temperature is not None:
        temperature = body.temperature[frame, :, 0]
    return Surface(
        points,
        quads,
        points - _drawn(body, 0)[0],
        unknown if temperature is None else temperature,
        unknown if stress is None else stress,
        resultants,
        body.patches is not None,
        gradient,
    )


def centre_line(position: Array, axes: Array, pieces: int = PIECES) -> tuple[Array, Array]:
    """Cubic Hermite curve through the nodes along e1, and section triads on it.

    The derivative at the ends of an element has the length chord / cos(angle / 4)^2 with the
    angle between its tangents: a uniformly bent line stays a circle but for the sixth power of
    that angle (Goldapp 1991).

    Parameters
    ----------
    position : (n, 3) float [m]
    axes : (n, 3, 3) float  rows e1, e2, e3

    Returns
    -------
    points : (s, 3) float [m], s = (n - 1) * pieces + 1
    axes : (s, 3, 3) float
    """
    if not axes.any():  # a line without sections
        axes = generate.frames(position)
    element, x = _stations(len(position), pieces)
    chord = np.linalg.norm(np.diff(position, axis=0), axis=1)
    cosine = np.clip(np.sum(axes[1:, 0] * axes[:-1, 0], axis=1), -1.0, 1.0)
    scale = chord / np.cos(0.25 * np.arccos(cosine)) ** 2
    length, x = scale[element, None], x[:, None]
    points = (
        (1 - 3 * x**2 + 2 * x**3) * position[element]
        + (x - 2 * x**2 + x**3) * length * axes[element, 0]
        + (3 * x**2 - 2 * x**3) * position[element + 1]
        + (x**3 - x**2) * length * axes[element + 1, 0]
    )
    return points, _between(axes, element, x[:, None])


def _between(axes: Array, element: Indices, x: Array) -> Array:
    """Triads between those of the nodes: e2 and e3 by linear interpolation, made orthonormal."""
    mixed = (1 - x) * axes[element] + x * axes[element + 1]
    e1 = np.cross(mixed[:, 1], mixed[:, 2])
    e1 /= np.linalg.norm(e1, axis=1, keepdims=True)
    e2 = mixed[:, 1] / np.linalg.norm(mixed[:, 1], axis=1, keepdims=True)
    return np.stack([e1, e2, np.cross(e1, e2)], axis=1)


def _stations(nodes: int, pieces: int) -> tuple[Indices, Array]:
    """Element and local coordinate in [0, 1] of each station."""
    s = np.arange((nodes - 1) * pieces + 1)
    element = np.minimum(s // pieces, nodes - 2)
    return element, (s - element * pieces) / pieces


def _drawn(body: Body, frame: int) -> tuple[Array, Indices]:
    """Points (m, 3) [m] and quads (k, 4) of what is drawn of a body."""
    if body.facets is not None:
        return body.facets.position[frame], body.facets.quads
    if body.patches is not None:
        from coupling import patches

        return patches.refined(body.position[frame], body.patches, frame)
    if body.box is not None:
        return _box(body.position[frame, 0], body.box @ body.axes[frame, 0])
    if body.section is None:
        return body.position[frame], np.empty((0, 4), dtype=np.intp)
    points, axes = centre_line(body.position[frame], body.axes[frame])
    return generate.sweep(points, axes, body.section.outline(AROUND))


CORNERS = np.array([[x, y, z] for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)], float)
SIDES = np.array(
    [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
)
"""Corners of a cube, and its sides seen counterclockwise from outside."""


def _box(centre: Array, edges: Array) -> tuple[Array, Indices]:
    """A box about ``centre`` (3,) [m] with half edges (3, 3) [m] as rows."""
    return centre + CORNERS @ edges, SIDES


def box_of(mass: float, inertia: Array) -> Array:
    """(3, 3) [m]  half edges of a solid box of this mass [kg] and inertia (3, 3) [kg m^2].

    J1 = m (b^2 + c^2)/12 and so on, hence a^2 = 6 (J2 + J3 - J1)/m. Edges of no length are drawn
    with a twentieth of the longest.
    """
    moments, axes = np.linalg.eigh(inertia)
    squares = 6.0 * (moments.sum() - 2.0 * moments) / mass
    edges = np.sqrt(np.maximum(squares, 0.0))
    edges = np.maximum(edges, 0.05 * edges.max())
    rows = 0.5 * edges[:, None] * axes.T
    return rows * np.sign(np.linalg.det(axes))


def _wall_temperature(body: Body, frame: int, stations: int) -> Array | None:
    """Mean + G2 y + G3 z at the outline, linear along the elements; (stations * AROUND,) [K]."""
    if body.temperature is None or body.section is None:
        return None
    nodal = body.temperature[frame]
    at = np.linspace(0.0, len(nodal) - 1.0, stations)
    mean, g2, g3 = (np.interp(at, np.arange(len(nodal)), value)[:, None] for value in nodal.T)
    y, z = body.section.outline(AROUND).T
    return (mean + g2 * y + g3 * z).ravel()


def _axial_stress(body: Body, frame: int, stations: int) -> Array | None:
    """N/A - M2 y/I2 - M3 z/I3 at the outline; (stations * AROUND,) [Pa].

    M2 = E I2 times the curvature towards e2, which compresses the side of +e2 (Navier).
    """
    if body.resultants is None or body.section is None:
        return None
    section = body.section
    normal, m2, m3 = _along(body.resultants[frame][:, [0, 4, 5]], stations).T[:, :, None]
    y, z = section.outline(AROUND).T
    bending = m2 * y / section.second_moment_2 + m3 * z / section.second_moment_3
    return (normal / section.area - bending).ravel()


def _along(values: Array, stations: int) -> Array:
    """(e, c) values at the middle of e elements as (stations, c): linear, also beyond the ends."""
    count = len(values)
    if count > 1:
        values = np.vstack([2 * values[0] - values[1], values, 2 * values[-1] - values[-2]])
    middle = np.arange(len(values)) - (0.5 if count > 1 else 0.0)
    at = np.linspace(0.0, count, stations)
    return np.column_stack([np.interp(at, middle, column) for column in values.T])


def _read_body(results: Results, name: str) -> Body:
    table, known = results.table(f"bodies/{name}"), results.attributes(f"bodies/{name}")
    position = table["position"]
    box = None
    if known.get("section_kind") == "rigid":
        box = box_of(float(known["mass"]), np.asarray(known["inertia"]))
    return Body(
        name,
        position,
        table.get("axes", np.zeros((*position.shape, 3))),
        table.get("temperature"),
        table.get("resultants"),
        _section(known),
        _patches(results, name, table),
        box,
        _facets(results, name),
    )


def _facets(results: Results, name: str) -> Facets | None:
    """The boundary of a solid, with the middles of its facets after the nodes."""
    table = results.table(f"solids/{name}")
    if not table:
        return None
    facets = results[f"facets/{name}/facets"]
    position, T = table["position"], table["temperature"]
    count = position.shape[1]
    middle = count + np.arange(len(facets))
    both = np.concatenate([position, T[:, :, None]], axis=2)
    # where a quadratic facet of eight nodes has its middle
    added = 0.5 * both[:, facets[:, 4:8]].sum(axis=2) - 0.25 * both[:, facets[:, :4]].sum(axis=2)
    both = np.concatenate([both, added], axis=1)
    quads = [
        np.stack([facets[:, i], facets[:, 4 + i], middle, facets[:, 4 + (i + 3) % 4]], axis=1)
        for i in range(4)
    ]
    return Facets(both[:, :, :3], both[:, :, 3], np.concatenate(quads))


def _patches(results: Results, name: str, table: dict[str, Array]) -> Patches | None:
    elements = results.table(f"surfaces/{name}")
    if not elements:
        return None
    slopes = table.get("slopes")
    smooth = slopes is not None and slopes[:, :, :2].any()
    return Patches(elements["quads"], elements["sizes"], slopes if smooth else None)


def _section(attributes: dict[str, object]) -> Section | None:
    """The section as recorded, None where there is none; what drawing does not need may miss."""
    kind = attributes.get("section_kind", "point")
    if kind in ("point", "shell", "rigid"):
        return None
    names = (
        "area second_moment_2 second_moment_3 torsion_constant shear_factor_2 shear_factor_3 "
        "outer_perimeter height width radius thickness"
    )
    numbers = {name: attributes.get(name, 0.0) for name in names.split()}
    return Section(kind=str(kind), **numbers)  # type: ignore[arg-type]
