"""What the two modules need to know of a scene, in their own words."""

import numpy as np
from numpy.typing import NDArray

import mechanics.description as motion
import thermal.description as heat
from coupling import heat_tables, motion_tables
from coupling.materials_used import material_of
from coupling.places import distances, node_of
from coupling.scene import Scene
from meshes import sections
from meshes.generate import frames
from meshes.materials import Material

Array = NDArray[np.float64]


def section_of(scene: Scene, name: str, poissons_ratio: float) -> sections.Section:
    """Section [section.NAME] in a material of the given Poisson's ratio (shear factor)."""
    table = scene.section[name]
    match table:
        case motion_tables.Tube():
            return sections.tube(table.mean_radius, table.thickness, poissons_ratio)
        case motion_tables.Circle():
            return sections.circle(table.radius, poissons_ratio)
        case motion_tables.Rectangle():
            return sections.rectangle(table.height, table.width, poissons_ratio)
        case _:
            return sections.general(**table.model_dump(exclude={"kind"}))


def line_bodies(scene: Scene) -> dict[str, motion_tables.LineBody]:
    """The beams and cables by name."""
    return {n: b for n, b in scene.body.items() if isinstance(b, motion_tables.LineBody)}


def clearance_joints(scene: Scene) -> dict[str, motion_tables.ClearanceRevolute]:
    """The joints with clearance by name."""
    kind = motion_tables.ClearanceRevolute
    return {n: j for n, j in scene.joint.items() if isinstance(j, kind)}


# -- motion ------------------------------------------------------------------------------------


def motion_description(scene: Scene) -> motion.Description:
    """Everything that moves."""
    gravity = (0.0, 0.0, 0.0) if scene.gravity is None else scene.gravity.acceleration
    return motion.Description(
        [_body(scene, name) for name in scene.body],
        [_joint(scene, name) for name in scene.joint],
        [_load(scene, name) for name in scene.load],
        np.asarray(gravity, float),
    )


def _body(scene: Scene, name: str) -> motion.Body:
    table = scene.body[name]
    if isinstance(table, motion_tables.Particle):
        return motion.Particle(name, np.array(table.position), table.mass, np.array(table.velocity))
    points, axes, section, material = _line(scene, name, table)
    return motion.Beam(
        name, points, axes, section, material, _reference(table), table.damping,
        "beam3243" if table.kind == "beam" else "cable",
        np.array(table.velocity), np.array(table.spin),
    )  # fmt: skip


def _reference(table: motion_tables.LineBody | motion_tables.ClearanceRevolute) -> float:
    assert table.reference_temperature is not None  # filled in when the case was read
    return table.reference_temperature


def _line(
    scene: Scene, name: str, table: motion_tables.LineBody
) -> tuple[Array, Array, sections.Section, Material]:
    """Nodes, triads, section and material of a line body."""
    material = material_of(scene, table.material)
    nu = float(material.poissons_ratio(_reference(table)))
    points = scene.points[name]
    normal = None if table.normal is None else np.array(table.normal)
    return points, frames(points, normal), section_of(scene, table.section, nu), material


def _site(scene: Scene, site: motion_tables.Site, other: motion.Site | None) -> motion.Site:
    """A node of a body; on the ground the given point, or that of the ``other`` side."""
    if site.body != motion_tables.GROUND:
        points = scene.points[site.body]
        node = node_of(points, site.at)
        return motion.Site(site.body, node, points[node])
    if site.position is not None:
        return motion.Site(None, 0, np.array(site.position))
    return motion.Site(None, 0, np.zeros(3) if other is None else other.position)


def _sites(scene: Scene, a: motion_tables.Site, b: motion_tables.Site):
    first = _site(scene, a, None)
    second = _site(scene, b, first)
    return _site(scene, a, second), second


def _joint(scene: Scene, name: str) -> motion.Joint:
    table = scene.joint[name]
    if isinstance(table, motion_tables.ClearanceRevolute):
        return _clearance(scene, name, table)
    a, b = _sites(scene, table.a, table.b)
    match table:
        case motion_tables.Clamp():
            return motion.Clamp(name, a, b)
        case motion_tables.Spherical():
            return motion.Spherical(name, a, b)
        case motion_tables.Revolute():
            return motion.Revolute(name, a, b, np.array(table.axis), table.angle)
    return motion.Distance(name, a, b)


def _clearance(
    scene: Scene, name: str, table: motion_tables.ClearanceRevolute
) -> motion.ClearanceRevolute:
    journal, bearing = _sites(scene, table.journal, table.bearing)
    friction = None if table.friction is None else motion.Friction(**table.friction.model_dump())
    return motion.ClearanceRevolute(
        name, journal, bearing, np.array(table.axis), table.radius, table.clearance,
        material_of(scene, table.journal_material), material_of(scene, table.bearing_material),
        _reference(table), motion.NormalContact(**table.contact.model_dump()),
        friction, table.angle,
    )  # fmt: skip


def _load(scene: Scene, name: str) -> motion.Load:
    table = scene.load[name]
    kind = motion.Force if table.kind == "force" else motion.Moment
    site = _site(scene, table.at, None)
    return kind(name, site, np.array(table.direction), table.amplitude)


# -- heat --------------------------------------------------------------------------------------


def heat_description(scene: Scene) -> heat.Description:
    """Everything that conducts: the line bodies, the parts, and what connects and heats them."""
    table = scene.thermal
    assert table is not None
    return heat.Description(
        [_member(scene, table, name, body) for name, body in line_bodies(scene).items()],
        [_part(scene, table, name, part) for name, part in table.part.items()],
        [_link(scene, name, link) for name, link in table.link.items()],
        _conditions(scene, table),
    )


def _conditions(scene: Scene, table: heat_tables.Thermal) -> list[heat.Condition]:
    """Named by kind and name, ``wall.sun``: a wall and a flux may have the same name."""
    found: list[heat.Condition] = []
    found += [_wall(scene, f"wall.{n}", w) for n, w in table.wall.items()]
    found += [_flux(f"flux.{n}", f) for n, f in table.flux.items()]
    found += [
        heat.Radiation(f"radiation.{n}", r.body, r.emissivity, r.sink)
        for n, r in table.radiation.items()
    ]
    found += [
        heat.Fixed(f"fixed.{n}", _place(scene, f.at), f.temperature) for n, f in table.fixed.items()
    ]
    found += [
        heat.Source(f"source.{n}", _place(scene, s.at), s.power) for n, s in table.source.items()
    ]
    return found


def _member(
    scene: Scene, table: heat_tables.Thermal, name: str, body: motion_tables.LineBody
) -> heat.Member:
    points, axes, section, material = _line(scene, name, body)
    around = table.wall_points if section.kind == "tube" else 1
    return heat.Member(name, points, axes, section, material, around, table.initial)


def region_of(name: str, part: heat_tables.Part) -> str:
    """Region of a part: the side of the joint that it is, or its own name."""
    return part.of or name


def _part(scene: Scene, table: heat_tables.Thermal, name: str, part: heat_tables.Part) -> heat.Part:
    initial = table.initial if part.initial is None else part.initial
    material = material_of(scene, part.material)
    position = np.zeros(3) if part.of is None else _position(scene, part.of)
    return heat.Part(region_of(name, part), position, material, part.mass, initial)


def _position(scene: Scene, side: str) -> Array:
    joint = clearance_joints(scene)[side.split(".")[0]]
    return np.asarray(_sites(scene, joint.journal, joint.bearing)[0].position)


def _place(scene: Scene, place: heat_tables.ThermalPlace) -> heat.Place:
    if place.body is not None:
        return heat.Place(place.body, place.at)
    assert scene.thermal is not None and place.part is not None
    return heat.Place(region_of(place.part, scene.thermal.part[place.part]))


def _link(scene: Scene, name: str, link: heat_tables.Link) -> heat.Link:
    other = link.temperature if link.b is None else _place(scene, link.b)
    assert other is not None  # a link has either
    return heat.Link(f"link.{name}", _place(scene, link.a), other, link.conductance)


def _wall(scene: Scene, name: str, wall: heat_tables.Wall) -> heat.Wall:
    end = distances(scene.points[wall.body])[-1] if wall.end is None else wall.end
    return heat.Wall(
        name, wall.body, wall.start, float(end), np.array(wall.side), wall.hot, wall.cold
    )


def _flux(name: str, flux: heat_tables.Flux) -> heat.Flux:
    direction = None if flux.direction is None else np.array(flux.direction)
    return heat.Flux(name, flux.body, lambda t: flux.absorptivity * flux.density(t), direction)
