"""What the thermal module needs to know of a scene, in its own words."""

import numpy as np
from numpy.typing import NDArray

import thermal.description as heat
from coupling import body_tables, heat_tables
from coupling.descriptions import line_bodies, line_of, shells, sided_joints, sites_of
from coupling.heat_faces import FaceTable
from coupling.heat_geometry import field_of, solid_mesh
from coupling.histories import Constant
from coupling.laws import Law
from coupling.materials_used import material_of
from coupling.scene import Scene
from meshes.materials import Property

Array = NDArray[np.float64]

OUTER = "outer"
LIGHT = "light"
"""Irradiation of a [thermal.surface.NAME] is called light.NAME."""


def heat_description(scene: Scene) -> heat.Description:
    """The line bodies, shells, parts and solids, and what connects and heats them."""
    table = scene.thermal
    assert table is not None
    return heat.Description(
        [_member(scene, table, name, body) for name, body in line_bodies(scene).items()],
        [_part(scene, table, name, part) for name, part in table.part.items()],
        [
            *(_link(scene, name, link) for name, link in table.link.items()),
            *(_contact(f"contact.{name}", contact) for name, contact in table.contact.items()),
        ],
        [*_given(scene, table), *_on_faces(scene, table), *_inside(scene, table)],
        [_sheet(scene, table, name, body) for name, body in shells(scene).items()],
        [_solid(scene, table, name, solid) for name, solid in table.solid.items()],
        [_interface(scene, name, face) for name, face in table.interface.items()],
    )


def settings(table: heat_tables.Thermal) -> heat.Settings:
    """How the heat is solved."""
    return heat.Settings(
        table.tolerance, table.scheme, table.steps, table.linear, table.order, table.layers
    )


# Conditions are named by kind and name, ``wall.sun``: a wall and a flux may have the same name.


def _given(scene: Scene, table: heat_tables.Thermal) -> list[heat.Condition]:
    found: list[heat.Condition] = []
    found += [_wall(scene, f"wall.{n}", w) for n, w in table.wall.items()]
    found += [_field(scene, f"field.{n}", f) for n, f in table.field.items()]
    found += [
        heat.Fixed(f"fixed.{n}", _place(scene, f.at), f.temperature) for n, f in table.fixed.items()
    ]
    return found


def _on_faces(scene: Scene, table: heat_tables.Thermal) -> list[heat.Condition]:
    found: list[heat.Condition] = []
    found += [_flux(scene, f"flux.{n}", f) for n, f in table.flux.items()]
    for name, film in table.film.items():
        side = side_of(scene, film)
        found.append(
            heat.Film(f"film.{name}", side.thing, film.coefficient, film.surroundings, side.face)
        )
    for name, r in table.radiation.items():
        side = side_of(scene, r)
        law = r.emissivity.property("emissivity", "1")
        emissivity = float(law(300.0)) if law.is_constant else law
        found.append(heat.Radiation(f"radiation.{name}", side.thing, emissivity, r.sink, side.face))
    found += [_enclosure(scene, f"enclosure.{n}", e) for n, e in table.enclosure.items()]
    for name, surface in table.surface.items():
        side = side_of(scene, surface)
        found += [
            heat.Irradiation(f"{LIGHT}.{name}", side.thing, side.face),
            heat.Radiation(
                f"surface.{name}", side.thing, surface.emissivity, Constant(surface.sink), side.face
            ),
        ]
    return found


def _inside(scene: Scene, table: heat_tables.Thermal) -> list[heat.Condition]:
    return [
        heat.Source(f"source.{n}", _place(scene, s.at), s.power) for n, s in table.source.items()
    ]


def _enclosure(scene: Scene, name: str, table: heat_tables.Enclosure) -> heat.Enclosure:
    factors = None if table.view_factors is None else np.array(table.view_factors)
    sides = [side_of(scene, face) for face in table.faces]
    return heat.Enclosure(name, sides, [f.emissivity for f in table.faces], factors, table.sink)


def side_of(scene: Scene, table: FaceTable) -> heat.Side:
    """The face that a table names."""
    assert scene.thermal is not None
    if table.part is not None:
        return heat.Side(region_of(table.part, scene.thermal.part[table.part]))
    if table.solid is not None:
        return heat.Side(
            region_of(table.solid, scene.thermal.solid[table.solid]), table.face or OUTER
        )
    assert table.body is not None
    return heat.Side(table.body, table.face or OUTER)


def _member(
    scene: Scene, table: heat_tables.Thermal, name: str, body: body_tables.LineBody
) -> heat.Member:
    points, axes, section, material = line_of(scene, name, body)
    if table.refine > 1:
        points, axes = refined(points, axes, table.refine)
    around = table.wall_points if section.kind == "tube" else 1
    if section.kind in ("circle", "rectangle") and table.full_sections == "gradients":
        around = 3
    return heat.Member(name, points, axes, section, material, around, table.initial)


def refined(points: Array, axes: Array, times: int) -> tuple[Array, Array]:
    """Stations between stations: ``times`` on each stretch, with axes turned in between."""
    from scipy.spatial.transform import Rotation

    n = len(points) - 1
    at = np.arange(n * times + 1) / times
    first = np.minimum(at.astype(int), n - 1)
    s = (at - first)[:, None]
    new = (1.0 - s) * points[first] + s * points[first + 1]
    turns = Rotation.from_matrix(axes)
    back = turns[first].inv() * turns[first + 1]
    turned = turns[first] * Rotation.from_rotvec(s * back.as_rotvec())
    return new, turned.as_matrix()


def _sheet(
    scene: Scene, table: heat_tables.Thermal, name: str, body: body_tables.ShellBody
) -> heat.Sheet:
    material = material_of(scene, body.material)
    return heat.Sheet(name, scene.shapes[name].surface, body.thickness, material, table.initial)


def _solid(
    scene: Scene, table: heat_tables.Thermal, name: str, solid: heat_tables.SolidTable
) -> heat.Solid:
    names = dict(solid.materials) | ({} if solid.material is None else {"": solid.material})
    return heat.Solid(
        region_of(name, solid),
        solid_mesh(scene.folder, solid, table.order),
        {region: material_of(scene, material) for region, material in names.items()},
        table.initial if solid.initial is None else solid.initial,
        None if solid.axes is None else np.array(solid.axes),
        solid.rubbing,
    )


def region_of(name: str, part: heat_tables.Part | heat_tables.SolidTable) -> str:
    """Region of a part or solid: the side of the joint that it is, or its own name."""
    return part.of or name


def _part(scene: Scene, table: heat_tables.Thermal, name: str, part: heat_tables.Part) -> heat.Part:
    initial = table.initial if part.initial is None else part.initial
    material = material_of(scene, part.material)
    position = np.zeros(3) if part.of is None else _position(scene, part.of)
    return heat.Part(region_of(name, part), position, material, part.mass, initial, part.area)


def _position(scene: Scene, side: str) -> Array:
    joint = sided_joints(scene)[side.rpartition(".")[0]]
    return sites_of(scene, joint.journal, joint.bearing)[2]


def _place(scene: Scene, place: heat_tables.ThermalPlace) -> heat.Place:
    if place.body is not None:
        return heat.Place(place.body, place.at)
    assert scene.thermal is not None
    if place.solid is not None:
        return heat.Place(region_of(place.solid, scene.thermal.solid[place.solid]), place.at)
    assert place.part is not None
    return heat.Place(region_of(place.part, scene.thermal.part[place.part]))


def _link(scene: Scene, name: str, link: heat_tables.Link) -> heat.Link:
    other = link.temperature if link.b is None else _place(scene, link.b)
    assert other is not None  # a link has either
    law = _factor(link.factor)
    return heat.Link(
        f"link.{name}", _place(scene, link.a), other, link.conductance, law, link.radiating
    )


def _contact(name: str, table: heat_tables.Contact) -> heat.Link:
    """Between the two sides of a joint; its conductance comes from what the contacts do."""
    journal, bearing = heat.Place(f"{table.joint}.journal"), heat.Place(f"{table.joint}.bearing")
    return heat.Link(name, journal, bearing, None, None, table.radiating)


def _factor(law: Law | None) -> Property | None:
    return None if law is None else law.property("factor", "1")


def _interface(scene: Scene, name: str, table: heat_tables.Interface) -> heat.Interface:
    a, b = side_of(scene, table.a), side_of(scene, table.b)
    return heat.Interface(
        f"interface.{name}", a, b, table.coefficient, _factor(table.factor), table.radiating
    )


def _wall(scene: Scene, name: str, wall: heat_tables.Wall) -> heat.Wall | heat.Faces:
    hot, cold = wall.sides
    if isinstance(scene.body[wall.body], body_tables.ShellBody):
        return heat.Faces(name, wall.body, hot[0], cold[0])
    end = scene.shapes[wall.body].along[-1] if wall.end is None else wall.end
    side = None if wall.side is None else np.array(wall.side)
    return heat.Wall(name, wall.body, wall.start or 0.0, float(end), side, hot, cold)


def _flux(scene: Scene, name: str, flux: heat_tables.Flux) -> heat.Flux:
    direction = None if flux.direction is None else np.array(flux.direction)
    side = side_of(scene, flux)
    return heat.Flux(
        name, side.thing, lambda t: flux.absorptivity * flux.density(t), direction, side.face
    )


def _field(scene: Scene, name: str, table: heat_tables.FieldTable) -> heat.Field:
    return heat.Field(name, table.body, field_of(scene.folder, scene.shapes, table))
