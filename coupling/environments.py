"""The surroundings in space of a scene, in the words of the thermal module."""

from typing import Any

import numpy as np

from coupling import environment_tables
from coupling.heat_descriptions import LIGHT, heat_description, region_of, side_of
from coupling.scene import Scene
from thermal.description import Side
from thermal.illumination import Attitude, Coating, Environment, quaternions
from thermal.orbit import (
    GEOSTATIONARY,
    DatedSun,
    FixedSun,
    Orbit,
    Sun,
    circular,
    sun_at_beta,
)
from thermal.planet import Planet


def environment(table: environment_tables.EnvironmentTable) -> Environment:
    """Sun, orbit, planet, attitude. Raises ValueError with what does not fit together."""
    orbit = None if table.orbit is None else _orbit(table.orbit, table.planet.radius)
    planet = None
    if orbit is not None:
        planet = Planet(table.planet.radius, table.planet.albedo, table.planet.infrared)
    return Environment(_sun(table.sun, orbit), _attitude(table.attitude), orbit, planet, table.flux)


def exposure(scene: Scene, heat_solver: Any, layout: Any) -> Any:
    """The ``coupling.exposure.Exposure`` of a scene's surfaces."""
    from coupling.exposure import Exposure

    assert scene.thermal is not None and scene.thermal.environment is not None
    coatings = []
    for name, surface in scene.thermal.surface.items():
        side = side_of(scene, surface)
        coatings.append(
            Coating(
                f"{LIGHT}.{name}", side.thing, side.face, surface.absorptivity, surface.emissivity
            )
        )
    return Exposure(
        environment(scene.thermal.environment),
        coatings,
        heat_solver.irradiated,
        heat_description(scene),
        layout,
        _shading(scene, heat_solver),
    )


def _shading(scene: Scene, heat_solver: Any) -> dict[str, Any]:
    """Faces of solids, which cast shadows besides beams and shells."""
    assert scene.thermal is not None
    names = (region_of(name, solid) for name, solid in scene.thermal.solid.items())
    return {name: heat_solver.space.face(Side(name)) for name in names}


def _orbit(table: environment_tables.OrbitTable, radius: float) -> Orbit:
    turned = (table.inclination, table.node)
    match table.kind:
        case "geostationary":
            return Orbit(GEOSTATIONARY, 0.0, *turned, 0.0, table.phase)
        case "circular":
            assert table.altitude is not None
            return circular(table.altitude, *turned, table.phase, radius)
    assert table.semi_major_axis is not None and table.eccentricity is not None
    perigee = table.perigee or 0.0
    return Orbit(table.semi_major_axis, table.eccentricity, *turned, perigee, table.phase)


def _sun(table: environment_tables.SunTable, orbit: Orbit | None) -> Sun:
    if table.direction is not None:
        return FixedSun(np.array(table.direction))
    if table.date is not None:
        return DatedSun(table.date)
    assert orbit is not None and table.beta is not None
    return sun_at_beta(orbit, table.beta, table.noon or 0.0)


def _attitude(table: environment_tables.AttitudeTable) -> Attitude:
    if table.table is not None:
        times = np.array([row[0] for row in table.table])
        return Attitude(table.frame, times, quaternions([row[1:] for row in table.table]))
    if table.axes is None:
        return Attitude(table.frame)
    from scipy.spatial.transform import Rotation

    turn = Rotation.from_matrix(np.array(table.axes).T)
    return Attitude(table.frame, np.zeros(1), turn.as_quat()[None])
