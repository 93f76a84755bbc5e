"""What the mechanical module needs to know of a scene, in its own words."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

import mechanics.description as motion
from coupling import body_tables, contact_tables, joint_tables, load_tables, section_tables
from coupling.materials_used import material_of
from coupling.places import Place, edge_nodes, place_of, point_of
from coupling.scene import Scene
from coupling.site_tables import GROUND, Site
from meshes import sections
from meshes.materials import Material

Array = NDArray[np.float64]


def section_of(scene: Scene, name: str, poissons_ratio: float) -> sections.Section:
    """Section [section.NAME] in a material of the given Poisson's ratio (shear factor)."""
    table = scene.section[name]
    match table:
        case section_tables.Tube():
            return sections.tube(table.mean_radius, table.thickness, poissons_ratio)
        case section_tables.Circle():
            return sections.circle(table.radius, poissons_ratio)
        case section_tables.Rectangle():
            return sections.rectangle(table.height, table.width, poissons_ratio)
        case _:
            return sections.general(**table.model_dump(exclude={"kind"}))


def line_bodies(scene: Scene) -> dict[str, body_tables.LineBody]:
    """The beams and cables by name."""
    return {n: b for n, b in scene.body.items() if isinstance(b, body_tables.LineBody)}


def shells(scene: Scene) -> dict[str, body_tables.ShellBody]:
    """The shells by name."""
    return {n: b for n, b in scene.body.items() if isinstance(b, body_tables.ShellBody)}


def flexible_bodies(scene: Scene) -> dict[str, body_tables.LineBody | body_tables.ShellBody]:
    """The bodies that have a material, by name."""
    kinds = body_tables.LineBody | body_tables.ShellBody
    return {n: b for n, b in scene.body.items() if isinstance(b, kinds)}


def loose_joints(scene: Scene) -> dict[str, contact_tables.Loose]:
    """The joints with clearance by name."""
    return {n: j for n, j in scene.joint.items() if isinstance(j, contact_tables.Loose)}


def sided_joints(scene: Scene) -> dict[str, contact_tables.Sided]:
    """The joints with clearance of a journal in a bearing, by name."""
    return {n: j for n, j in scene.joint.items() if isinstance(j, contact_tables.Sided)}


def motion_description(scene: Scene) -> motion.Description:
    """Everything that moves."""
    gravity = (0.0, 0.0, 0.0) if scene.gravity is None else scene.gravity.acceleration
    return motion.Description(
        _bodies(scene),
        [joint for name in scene.joint for joint in _joints(scene, name)],
        [_load(scene, name) for name in scene.load],
        np.asarray(gravity, float),
        None if scene.damping is None else (scene.damping.mass, scene.damping.stiffness),
        scene.coupling.density == "temperature",
    )


# ---------------------------------------------------------------------------------- bodies


def _bodies(scene: Scene) -> list[motion.Body]:
    if not scene.mechanics.is_continuum:
        return [_body(scene, name) for name in scene.body]
    from coupling import continuum, continuum_lugs

    places, found = continuum.used_places(scene), list[motion.Body]()
    for name in scene.body:
        if continuum.is_solid(scene, name):
            found += continuum.bodies_of(scene, name, places.get(name, []))
        else:
            found.append(_body(scene, name))
    for name in continuum_lugs.lugs(scene):
        found += continuum_lugs.bodies_of(scene, name)
    return found


def _body(scene: Scene, name: str) -> motion.Body:
    table = scene.body[name]
    match table:
        case body_tables.LineBody():
            return _beam(scene, name, table)
        case body_tables.ShellBody():
            return _shell(scene, name, table)
        case body_tables.RigidBody():
            axes = np.array(table.axes)
            inertia = axes.T @ body_tables.inertia_matrix(table.inertia) @ axes
            return motion.RigidBody(
                name, np.array(table.position), table.mass, inertia, axes,
                np.array(table.velocity), np.array(table.spin),
            )  # fmt: skip
    return motion.Particle(name, np.array(table.position), table.mass, np.array(table.velocity))


def _beam(scene: Scene, name: str, table: body_tables.LineBody) -> motion.Beam:
    points, axes, section, material = line_of(scene, name, table)
    return motion.Beam(
        name, points, axes, section, material, reference_of(table), table.damping, table.family,
        np.array(table.velocity), np.array(table.spin), table.modes,
    )  # fmt: skip


def _shell(scene: Scene, name: str, table: body_tables.ShellBody) -> motion.Shell:
    surface = scene.shapes[name].surface
    return motion.Shell(
        name, surface, table.thickness, material_of(scene, table.material), reference_of(table),
        table.damping, table.element, np.array(table.velocity), np.array(table.spin),
    )  # fmt: skip


def reference_of(
    table: body_tables.LineBody | body_tables.ShellBody | contact_tables.Loose,
) -> float:
    """Temperature [K] at which a body or joint is free of thermal strain."""
    assert table.reference_temperature is not None  # filled in when the case was read
    return table.reference_temperature


def line_of(
    scene: Scene, name: str, table: body_tables.LineBody
) -> tuple[Array, Array, sections.Section, Material]:
    """Nodes, triads, section and material of a line body."""
    material = material_of(scene, table.material)
    nu = float(material.poissons_ratio(reference_of(table)))
    shape = scene.shapes[name]
    return shape.points, shape.axes, section_of(scene, table.section, nu), material


# ---------------------------------------------------------------------------------- joints


def _site(scene: Scene, site: Site, elsewhere: Array | None = None) -> motion.Site:
    """A material point of a body; on the ground the given point, or one that is ``elsewhere``."""
    if site.body != GROUND:
        place = place_of(scene.shapes[site.body], site)
        return material_point(scene, site.body, place)
    if site.position is not None:
        return motion.Site(None, position=np.array(site.position))
    return motion.Site(None, position=np.zeros(3) if elsewhere is None else elsewhere)


def material_point(scene: Scene, body: str, place: Place) -> motion.Site:
    """A place of a body in the words of mechanics; of a solid the cross-section there."""
    if scene.mechanics.is_continuum:
        from coupling import continuum

        if continuum.is_solid(scene, body):
            return continuum.site_of(scene, body, place)
    return motion.Site(body, place.node, fraction=place.fraction, offset=place.offset)


def position_of(scene: Scene, site: Site) -> Array | None:
    """(3,) [m]  where a site is at the start; None: on the ground, where the other side is."""
    if site.body == GROUND:
        return None if site.position is None else np.array(site.position)
    shape = scene.shapes[site.body]
    return point_of(shape, place_of(shape, site))


def sites_of(scene: Scene, a: Site, b: Site) -> tuple[motion.Site, motion.Site, Array]:
    """Both sides of a joint, and where the first one is at the start (3,) [m]."""
    first, second = position_of(scene, a), position_of(scene, b)
    at = second if first is None else first
    assert at is not None  # one side is on a body
    return _site(scene, a, second), _site(scene, b, first), at


def _joints(scene: Scene, name: str) -> list[motion.Joint]:
    """What a table makes: one joint, or one for each node of an edge."""
    table = scene.joint[name]
    if name in scene.mechanics.lug and isinstance(table, contact_tables.Sided):
        from coupling.continuum_lugs import joints_of

        return joints_of(scene, name, _clearance(scene, name, table))
    site = getattr(table, "a", None)
    if site is None or site.edge is None:
        return [_joint(scene, name, table)]
    nodes = edge_nodes(scene.body[site.body], site.edge)
    points = scene.shapes[site.body].points[nodes]
    return [
        _joint(scene, f"{name}.{i}", table.model_copy(update={"a": _at_node(site, point)}))
        for i, point in enumerate(points)
    ]


def _at_node(site: Site, point: Array) -> Site:
    return site.model_copy(update={"edge": None, "position": tuple(point)})


def _joint(scene: Scene, name: str, table: joint_tables.Joint) -> motion.Joint:
    if isinstance(table, contact_tables.Sided):
        return _clearance(scene, name, table)
    match table:
        case contact_tables.Telescope():
            return _telescope(name, table)
        case joint_tables.Gear():
            return motion.Gear(name, table.first, table.second, table.ratio)
        case joint_tables.Latch():
            return motion.Latch(name, table.joint, table.at)
        case joint_tables.TorsionSpring():
            return motion.TorsionSpring(
                name, table.joint, table.stiffness, table.damping, table.angle, table.preload,
                table.torque,
            )  # fmt: skip
        case joint_tables.Guide() | joint_tables.Fixing() | joint_tables.Sliding():
            return _of_one_side(scene, name, table)
        case joint_tables.Pulley():
            sites = [_site(scene, site) for site in table.points]
            return motion.Pulley(
                name, sites, table.stiffness, table.damping, table.length, table.winch
            )
    return _of_two_sides(name, table, *sites_of(scene, table.a, table.b)[:2])


def _of_one_side(
    scene: Scene, name: str, table: joint_tables.Guide | joint_tables.Fixing | joint_tables.Sliding
) -> motion.Joint:
    site = _site(scene, table.a)
    match table:
        case joint_tables.Guide():
            return motion.Guide(name, site, np.array(table.directions))
        case joint_tables.Sliding():
            return motion.Sliding(name, site, table.body, table.aligned, table.travel)
    directions = np.array(table.directions)
    assert site.body is not None  # the ground needs no fixing
    return motion.Fixing(name, site.body, site.node, table.vector, directions)


def _of_two_sides(
    name: str, table: joint_tables.Joint, a: motion.Site, b: motion.Site
) -> motion.Joint:
    match table:
        case joint_tables.Clamp():
            return motion.Clamp(name, a, b)
        case joint_tables.Spherical():
            return motion.Spherical(name, a, b)
        case joint_tables.Revolute():
            return motion.Revolute(name, a, b, np.array(table.axis), table.angle)
        case joint_tables.Universal():
            return motion.Universal(name, a, b, np.array(table.axis_a), np.array(table.axis_b))
        case joint_tables.Cylindrical():
            return motion.Cylindrical(name, a, b, np.array(table.axis), table.angle, table.travel)
        case joint_tables.Prismatic():
            return motion.Prismatic(name, a, b, np.array(table.axis), table.travel)
        case joint_tables.AxialDrive():
            return motion.AxialDrive(name, a, b, np.array(table.axis), table.travel)
        case joint_tables.Planar():
            return motion.Planar(name, a, b, np.array(table.normal))
        case joint_tables.Spring():
            return motion.Spring(
                name, a, b, table.stiffness, table.damping, table.length, table.preload,
                table.force,
            )  # fmt: skip
        case joint_tables.Bushing():
            stiffness = np.array([*table.stiffness, *table.turn_stiffness])
            damping = np.array([*table.damping, *table.turn_damping])
            return motion.Bushing(name, a, b, np.array(table.axes), stiffness, damping)
        case joint_tables.Distance():
            return motion.Distance(name, a, b, table.length)
    raise TypeError(f"no joint with two sides: {table.kind}")


CLEARANCES: dict[str, type[motion.Clearance]] = {
    "clearance_revolute": motion.ClearanceRevolute,
    "clearance_spherical": motion.ClearanceSpherical,
    "clearance_cylindrical": motion.ClearanceCylindrical,
    "clearance_translational": motion.ClearanceTranslational,
}
"""What tables of journals in bearings describe."""


def _clearance(scene: Scene, name: str, table: contact_tables.Sided) -> motion.Clearance:
    """Sizes have the same names in the table as in the description."""
    journal, bearing, _ = sites_of(scene, table.journal, table.bearing)
    made = {
        "journal": journal,
        "bearing": bearing,
        "journal_material": material_of(scene, table.journal_material),
        "bearing_material": material_of(scene, table.bearing_material),
        **_laws(table),
    }
    sizes = {key: value for key, value in table if key not in made and key != "kind"}
    for key in sizes.keys() & {"axis", "normal"}:
        sizes[key] = np.array(sizes[key])
    return CLEARANCES[table.kind](name, **made, **sizes)


def _telescope(name: str, table: contact_tables.Telescope) -> motion.Telescope:
    sizes = {key: value for key, value in table if key not in ("kind", "preload")}
    pads = None if table.preload is None else motion.Preload(**table.preload.model_dump())
    return motion.Telescope(name, **sizes | _laws(table), preload=pads)


def _laws(table: contact_tables.Loose) -> dict[str, Any]:
    """Contact and friction of a joint in the words of mechanics."""
    friction = None if table.friction is None else motion.Friction(**table.friction.model_dump())
    return {"contact": motion.NormalContact(**table.contact.model_dump()), "friction": friction}


# ----------------------------------------------------------------------------------- loads


def _load(scene: Scene, name: str) -> motion.Load:
    table = scene.load[name]
    direction = np.array(table.direction)
    match table:
        case load_tables.TorqueLoad():
            a, b, _ = sites_of(scene, table.a, table.b)
            return motion.Torque(name, a, b, direction, table.amplitude)
        case load_tables.TractionLoad():
            nodes = None
            if table.edge is not None:
                nodes = edge_nodes(scene.body[table.body], table.edge).tolist()
            amplitude = table.pressure or table.line_load
            assert amplitude is not None  # the table has either
            return motion.Traction(name, table.body, direction, amplitude, nodes)
        case load_tables.ForceLoad():
            return motion.Force(name, _site(scene, table.at), direction, table.amplitude)
    return motion.Moment(name, _site(scene, table.at), direction, table.amplitude)
