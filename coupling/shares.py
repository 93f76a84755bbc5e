"""How much of a body each of its temperatures stands for."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from coupling.descriptions import line_bodies
from coupling.scene import Scene

Array = NDArray[np.float64]


def shares(scene: Scene, heat_solver: Any) -> dict[str, Array]:
    """Area or volume of the temperatures that motion reads, by region, where it is known.

    heat_solver : ThermalSolver or None
    """
    if scene.thermal is None:
        return {}
    if scene.thermal.participant is not None:
        return dict(heat_solver.shares)
    return _of_spaces(scene, heat_solver) if hasattr(heat_solver, "space") else {}


def _of_spaces(scene: Scene, heat_solver: Any) -> dict[str, Array]:
    from coupling.heat_descriptions import region_of
    from thermal.description import Place

    assert scene.thermal is not None
    places = {name: Place(name) for name in line_bodies(scene)}
    for name, solid in scene.thermal.solid.items():
        if solid.of is not None:
            places[region_of(name, solid)] = Place(region_of(name, solid), solid.rubbing)
    found = {}
    for name, place in places.items():
        mean, parts = heat_solver.space.place(place), np.zeros(len(heat_solver.x))
        np.add.at(parts, mean.nodes, mean.weights)
        own = parts[heat_solver.regions[name]]
        if (own > 0.0).all():  # corners of quadratic cells have negative volumes
            found[name] = own
    return found
