"""What the thermal module needs to know of a scene, in its own words."""

import numpy as np
from numpy.typing import NDArray

import thermal.description as heat
from coupling import body_tables, heat_tables
from coupling.descriptions import line_bodies, line_of, shells, sided_joints, sites_of
from coupling.materials_used import material_of
from coupling.scene import Scene

Array = NDArray[np.float64]


def heat_description(scene: Scene) -> heat.Description:
    """The line bodies, shells and parts, and what connects and heats them."""
    table = scene.thermal
    assert table is not None
    return heat.Description(
        [_member(scene, table, name, body) for name, body in line_bodies(scene).items()],
        [_part(scene, table, name, part) for name, part in table.part.items()],
        [_link(scene, name, link) for name, link in table.link.items()],
        _conditions(scene, table),
        [_sheet(scene, table, name, body) for name, body in shells(scene).items()],
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
    scene: Scene, table: heat_tables.Thermal, name: str, body: body_tables.LineBody
) -> heat.Member:
    points, axes, section, material = line_of(scene, name, body)
    around = table.wall_points if section.kind == "tube" else 1
    return heat.Member(name, points, axes, section, material, around, table.initial)


def _sheet(
    scene: Scene, table: heat_tables.Thermal, name: str, body: body_tables.ShellBody
) -> heat.Sheet:
    material = material_of(scene, body.material)
    return heat.Sheet(name, scene.shapes[name].surface, body.thickness, material, table.initial)


def region_of(name: str, part: heat_tables.Part) -> str:
    """Region of a part: the side of the joint that it is, or its own name."""
    return part.of or name


def _part(scene: Scene, table: heat_tables.Thermal, name: str, part: heat_tables.Part) -> heat.Part:
    initial = table.initial if part.initial is None else part.initial
    material = material_of(scene, part.material)
    position = np.zeros(3) if part.of is None else _position(scene, part.of)
    return heat.Part(region_of(name, part), position, material, part.mass, initial)


def _position(scene: Scene, side: str) -> Array:
    joint = sided_joints(scene)[side.rpartition(".")[0]]
    return sites_of(scene, joint.journal, joint.bearing)[2]


def _place(scene: Scene, place: heat_tables.ThermalPlace) -> heat.Place:
    if place.body is not None:
        return heat.Place(place.body, place.at)
    assert scene.thermal is not None and place.part is not None
    return heat.Place(region_of(place.part, scene.thermal.part[place.part]))


def _link(scene: Scene, name: str, link: heat_tables.Link) -> heat.Link:
    other = link.temperature if link.b is None else _place(scene, link.b)
    assert other is not None  # a link has either
    return heat.Link(f"link.{name}", _place(scene, link.a), other, link.conductance)


def _wall(scene: Scene, name: str, wall: heat_tables.Wall) -> heat.Wall | heat.Faces:
    hot, cold = wall.sides
    if isinstance(scene.body[wall.body], body_tables.ShellBody):
        return heat.Faces(name, wall.body, hot[0], cold[0])
    end = scene.shapes[wall.body].along[-1] if wall.end is None else wall.end
    side = None if wall.side is None else np.array(wall.side)
    return heat.Wall(name, wall.body, wall.start or 0.0, float(end), side, hot, cold)


def _flux(name: str, flux: heat_tables.Flux) -> heat.Flux:
    direction = None if flux.direction is None else np.array(flux.direction)
    return heat.Flux(name, flux.body, lambda t: flux.absorptivity * flux.density(t), direction)
