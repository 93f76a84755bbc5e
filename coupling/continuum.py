"""Beams of a scene as solids in 3D: their meshes, and the places of them that others use.

The mesh is swept from station to station of the beam as the heat in 3D sweeps its own, so that
nodes coincide where the numbers of cells do.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

import mechanics.description as motion
from coupling.body_tables import LineBody
from coupling.heat_tables import Thermal
from coupling.joint_references import sites_of
from coupling.mechanics_tables import MechanicsTable, MeshNumbers
from coupling.places import Place, place_of
from coupling.scene import Scene
from coupling.site_tables import GROUND
from coupling.surfaces import centre_line
from meshes.generate import line
from meshes.sections import Section
from meshes.solids import member_mesh
from thermal.solid_bodies import AROUND

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

IN_3D = ("solid", "calculix")
"""Solvers of heat that mesh beams in 3D."""
ROUND = 16
"""Cells round a section where nothing else is said."""
ROUNDED = 1000.0
"""Units of rounding that Newton's method leaves in the strain of solids."""
SAME = 1e-6
"""How near two planes of nodes are that are one, relative to the cells there [-]."""


class Numbers(NamedTuple):
    """Cells of a body: of which kind, from node to node, round the section, through the wall."""

    element: str
    along: int
    round: int
    layers: int

    @property
    def family(self) -> str:
        """Of the cells of the mesh."""
        return self.element.removesuffix("-full")


class Solid(NamedTuple):
    """A beam as a solid.

    points : (n, 3) float [m];  cells : (c, k) intp
    local : (n, 3) float [-], [m]  part of the length, coordinates along e2 and e3
    planes : (s, p) intp  nodes of the cross-section at each station, alike in order
    areas : (p,) float [m^2]  that belong to them
    axes : (s, 3, 3) float  triads there
    pieces : stations from node to node of the beam
    surface : (f, 8 or 9) intp  facets of the boundary, which turn outward
    """

    name: str
    section: Section
    element: str
    points: Array
    cells: Indices
    local: Array
    planes: Indices
    areas: Array
    axes: Array
    pieces: int
    surface: Indices

    @property
    def nodes(self) -> Indices:
        """(b, p)  nodes of the cross-sections where the beam has its nodes."""
        return self.planes[:: self.pieces]

    def fit(self) -> tuple[csr_array, csr_array, csr_array]:
        """(b, n) each: mean over the cross-section, and slopes [1/m] along e2 and e3 there."""
        rows = self.nodes
        y, z = self.local[rows[0], 1], self.local[rows[0], 2]
        basis = np.column_stack([np.ones_like(y), y, z])
        weighted = self.areas[:, None] * basis
        maps = np.linalg.solve(basis.T @ weighted, weighted.T)
        start = np.arange(len(rows) + 1) * rows.shape[1]
        shape = len(rows), len(self.points)
        mean, by_y, by_z = (
            csr_array((np.tile(m, len(rows)), rows.ravel(), start), shape=shape) for m in maps
        )
        return mean, by_y, by_z

    def station_of(self, place: Place) -> float:
        """Number of the station at a place; between stations not a whole one."""
        return self.pieces * (place.node + place.fraction)


def is_solid(scene: Scene, body: str) -> bool:
    """Whether a body of the scene is computed as a solid."""
    return scene.mechanics.is_continuum and isinstance(scene.body.get(body), LineBody)


def solids(scene: Scene) -> dict[str, Solid]:
    """The beams that are computed as solids, by name."""
    return {name: solid_of(scene, name) for name in scene.body if is_solid(scene, name)}


def numbers_of(scene: Scene, name: str) -> Numbers:
    """Cells of a body of a scene."""
    return chosen(scene.mechanics, scene.thermal, name)


def chosen(table: MechanicsTable, heat: Thermal | None, name: str) -> Numbers:
    """Cells of a body: its own, those of all, those of the heat in 3D, or the fewest."""
    own = table.mesh.get(name, MeshNumbers())
    along, around, layers = 1, ROUND, 1
    if heat is not None and heat.solver in IN_3D:
        along, around, layers = heat.refine, max(AROUND, heat.wall_points), heat.layers
    return Numbers(
        own.element or table.element or "hexahedron20",
        own.along or table.along or along,
        own.round or table.round or around,
        own.layers or table.layers or layers,
    )


def solid_of(scene: Scene, name: str) -> Solid:
    """One beam as a solid."""
    from coupling.descriptions import line_of

    table, numbers = scene.body[name], numbers_of(scene, name)
    assert isinstance(table, LineBody)
    points, axes, section, _ = line_of(scene, name, table)
    points, axes = centre_line(points, axes, numbers.along)
    sizes = numbers.round, numbers.layers, 2, numbers.family
    mesh = member_mesh(points, axes, section, *sizes)
    # the same mesh along x has part of the length and section coordinates as positions
    s = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    s /= s[-1]
    flat, straight = line((0, 0, 0), (1, 0, 0), len(s) - 1, normal=(0, 1, 0))
    flat[:, 0] = s
    local = member_mesh(flat, straight, section, *sizes).points
    planes = np.stack([np.flatnonzero(np.abs(local[:, 0] - x) < SAME / len(s)) for x in s])
    (facets,) = (c for f, c in mesh.cells.items() if f.startswith("quad"))
    start = mesh.cells_of("start")
    (rows,) = start.values()
    flat_local = local * [0.0, 1.0, 1.0]
    areas = face_areas(flat_local, facets[rows])[planes[0]]
    return Solid(
        name, section, numbers.element, mesh.points, mesh.cells[numbers.family], local, planes,
        areas, axes, numbers.along, facets,
    )  # fmt: skip


def face_areas(points: Array, facets: Indices) -> Array:
    """(n,) [m^2]  integral of the function of each node over facets."""
    from thermal.solid_elements import SURFACE, shape

    family = f"quad{facets.shape[1]}"
    form = shape(family, SURFACE[family])
    first, second = np.einsum("qnd,fnc->dfqc", form.slopes, points[facets])
    sizes = np.linalg.norm(np.cross(first, second), axis=-1) * form.weights
    found = np.zeros(len(points))
    np.add.at(found, facets, np.einsum("fq,qn->fn", sizes, form.values))
    return found


def resolution(scene: Scene) -> float:
    """Corrections of positions, relative to the size of a body, that rounding leaves [-].

    Rounding of positions strains a cell by as much, times length over thickness of the cell.
    """
    found = 0.0
    for solid in solids(scene).values():
        corners = solid.points[solid.cells[:, :4]]
        edges = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
        length = float(np.linalg.norm(np.ptp(solid.points, axis=0)))
        found = max(found, ROUNDED * np.finfo(float).eps * length / float(edges.min()))
    return found


# --------------------------------------------------------------------------- places and bodies


def used_places(scene: Scene) -> dict[str, list[Place]]:
    """Places of each solid at which joints, loads and probes sit, once each."""
    sites: list[Any] = [site for joint in scene.joint.values() for site in sites_of(joint).values()]
    for load in scene.load.values():
        sites += [getattr(load, key) for key in ("at", "a", "b") if hasattr(load, key)]
    found: dict[str, dict[str, Place]] = {}
    for site in [*sites, *scene.probe.values()]:
        if site.body != GROUND and is_solid(scene, site.body):
            place = place_of(scene.shapes[site.body], site)
            found.setdefault(site.body, {})[point_name(scene, site.body, place)] = place
    return {name: list(places.values()) for name, places in found.items()}


def point_name(scene: Scene, body: str, place: Place) -> str:
    """What the reference point at a place of a body is called, such as ``boom@end``."""
    along = scene.shapes[body].along
    if place.node == len(along) - 1:
        return f"{body}@end"
    if place.node + place.fraction == 0.0:
        return f"{body}@start"
    step = along[place.node + 1] - along[place.node]
    return f"{body}@{along[place.node] + place.fraction * step:.9g}"


def site_of(scene: Scene, body: str, place: Place) -> motion.Site:
    """The material point of a solid that a place of its beam means."""
    return motion.Site(point_name(scene, body, place), 0, offset=place.offset)


def bodies_of(
    scene: Scene, name: str, places: list[Place]
) -> list[motion.Continuum | motion.ReferencePoint]:
    """A solid, and its reference points."""
    from coupling.descriptions import reference_of
    from coupling.materials_used import material_of

    table, solid = scene.body[name], solid_of(scene, name)
    assert isinstance(table, LineBody)
    body = motion.Continuum(
        name, solid.points, solid.cells, material_of(scene, table.material), reference_of(table),
        solid.element, table.damping, np.array(table.velocity), np.array(table.spin),
    )  # fmt: skip
    points = []
    for place in places:
        station = round(solid.station_of(place))
        points.append(
            motion.ReferencePoint(
                point_name(scene, name, place),
                name,
                solid.planes[station],
                solid.areas,
                solid.axes[station],
            )
        )
    return [body, *points]
