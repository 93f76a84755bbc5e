"""Where the contacts of a run are: grouped by joint, and in space in each frame."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from coupling.reading import Results
from coupling.surfaces import Body

Array = NDArray[np.float64]

TUBE, WALL = "tube", "wall"


def contact_groups(results: Results) -> dict[str, list[str]]:
    """Contacts of each joint with clearance that were recorded, both in their order."""
    numbers: dict[str, int] = {}
    joints: dict[str, str] = {}
    for name in results.names("joints"):
        if f"joints/{name}/normal_force" in results:
            attributes = results.attributes(f"joints/{name}")
            numbers[name] = int(attributes.get("number", len(numbers)))
            joints[name] = str(attributes.get("joint", name))
    found: dict[str, list[str]] = {}
    for name in sorted(numbers, key=lambda name: numbers[name]):
        found.setdefault(joints[name], []).append(name)
    return found


def form_of(results: Results, contact: str) -> str:
    """Form of a contact, see ``coupling.contacts``."""
    return str(results.attributes(f"joints/{contact}").get("form", "planar"))


def peak_force(results: Results, contact: str) -> float:
    """Largest normal force [N] that was recorded."""
    return float(np.max(results[f"joints/{contact}/normal_force"], initial=0.0))


class Place(NamedTuple):
    """A point of a body: ``offset`` (3,) [m] from a node along its axes."""

    body: Body
    node: int
    offset: Array


class Placement(NamedTuple):
    """Where a contact is.

    journal, bearing : points of bodies, or None for the ground
    position : (3,) float [m]  of the bearing when it is on the ground
    directions : (d, 3) float  of the components of the orbit, or to the wall, in the first frame
    axes : (3, 3) float  of those of the friction vector, likewise
    along : (3,) float | None  axis along which the place of the contact is counted
    outer : tube along which it is counted instead;  mouth : float [m]  a place that stays; nan
    """

    journal: Place | None
    bearing: Place | None
    position: Array
    directions: Array
    axes: Array
    along: Array | None = None
    outer: Body | None = None
    mouth: float = np.nan


class Located(NamedTuple):
    """Centre of the bearing (3,) [m], gap (3,) [m] from it to the journal, force (3,) [N] on it."""

    centre: Array
    gap: Array
    force: Array


def placement(results: Results, contact: str, bodies: Mapping[str, Body]) -> Placement | None:
    """Placement of a contact, None when that was not recorded."""
    attributes = results.attributes(f"joints/{contact}")
    columns = results.names(f"joints/{contact}")
    if "directions" not in attributes or not {"orbit", "towards_wall"} & set(columns):
        return None
    directions = np.asarray(attributes["directions"], dtype=float)
    position = np.asarray(attributes.get("position", np.zeros(3)), dtype=float)
    axes = np.asarray(attributes.get("axes", np.eye(3)), dtype=float)
    if attributes.get("form") == TUBE:
        outer = bodies.get(str(attributes["bearing_body"]))
        mouth = float(attributes.get("mouth", np.nan))
        if outer is None:
            return None
        return Placement(None, None, position, directions, axes, None, outer, mouth)
    journal, bearing = (_site(attributes, side, bodies) for side in ("journal", "bearing"))
    along = attributes["axis"] if "place" in columns and "axis" in attributes else None
    return Placement(journal, bearing, position, directions, axes, along)


def _site(attributes: dict[str, Any], side: str, bodies: Mapping[str, Body]) -> Place | None:
    body = bodies.get(str(attributes.get(f"{side}_body", "")))
    away = np.asarray(attributes.get(f"{side}_offset", np.zeros(3)))
    return Place(body, int(attributes[f"{side}_node"]), away) if body else None


def located(place: Placement, frame: int, row: Mapping[str, Array]) -> Located:
    """Where a contact is in a frame, with the ``row`` of its history at that time."""
    if place.outer is not None:
        return _in_tubes(place, place.outer, frame, row)
    centre, turn = _bearing(place, frame)
    if place.along is not None:
        centre = centre + row["place"] * (place.along @ turn)
    path = np.atleast_1d(row["orbit"] if "orbit" in row else row["towards_wall"])
    gap = path @ (place.directions @ turn)
    return Located(centre, gap, _force(place, path, gap, place.axes @ turn, row))


def _bearing(place: Placement, frame: int) -> tuple[Array, Array]:
    """Centre of the bearing (3,) [m]; its turn (3, 3), which is multiplied from the right."""
    if place.bearing is None:
        return place.position, np.eye(3)
    body, node, offset = place.bearing
    if not body.axes.any():
        return body.position[frame, node], np.eye(3)
    turn = body.axes[0, node].T @ body.axes[frame, node]
    return body.position[frame, node] + offset @ body.axes[frame, node], turn


def _in_tubes(place: Placement, outer: Body, frame: int, row: Mapping[str, Array]) -> Located:
    """The gap goes from the axis of the outer tube to that of the inner one."""
    points, path = outer.position[frame], row["orbit"]
    along = lengths(outer.position[0])
    at = float(row["place"]) if np.isnan(place.mouth) else place.mouth
    centre = np.array([np.interp(at, along, column) for column in points.T])
    node = int(np.argmin(np.abs(along - at)))
    return Located(centre, path, _force(place, path, path, outer.axes[frame, node], row))


def _force(
    place: Placement, path: Array, gap: Array, axes: Array, row: Mapping[str, Array]
) -> Array:
    """(3,) [N] on the journal."""
    if "normal_force" not in row:
        return np.full(3, np.nan)
    n = np.sign(path[0]) * gap if len(path) == 1 else gap
    n = n / max(float(np.linalg.norm(n)), 1e-300)
    if "friction_vector" in row:
        return row["friction_vector"] @ axes - row["normal_force"] * n
    across = np.cross(axes[2], n)  # planar: counter-clockwise about the axis
    return row.get("friction_force", np.nan) * across - row["normal_force"] * n


def nearest_row(table: Mapping[str, Array], time: float) -> dict[str, Array]:
    """The row of a history that is nearest in time."""
    nearest = int(np.argmin(np.abs(table["time"] - time)))
    return {column: values[nearest] for column, values in table.items()}


def lengths(points: Array) -> Array:
    """(n,) [m]  along a line through points (n, 3)."""
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    return np.concatenate([[0.0], np.cumsum(steps)])
