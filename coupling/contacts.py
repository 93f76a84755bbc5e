"""The contacts of the joints with clearance: where they are, and the columns of their histories."""

from collections.abc import Collection
from math import nan
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from coupling import contact_tables
from coupling.descriptions import loose_joints
from coupling.places import place_of, point_of
from coupling.scene import Scene
from coupling.site_tables import GROUND
from mechanics import march
from mechanics.contact_laws import NONE
from mechanics.system import System

Array = NDArray[np.float64]

PLANAR, END, BALL, WALL, TUBE, BORE = "planar", "end", "ball", "wall", "tube", "bore"
"""Forms of contacts: of a planar pin; of the end of a bore; a ball in a socket; a corner at a wall;
a tube in a tube; a pin in a bore that is a solid."""
ORBITS = {PLANAR: 2, END: 2, BALL: 3, TUBE: 3}
"""Components of the orbit of round contacts."""
FIRST = "end_1"
"""Label of the contact of a spatial revolute joint that carries what belongs to the joint."""
MOUTH = "mouth"
"""How labels of the contacts of a telescope begin that stay in their place on the outer tube."""


class Contact(NamedTuple):
    """One contact point of a joint with clearance.

    name : of its history;  joint, label : joint, and which of its contacts
    table : of the joint;  form : see ``PLANAR`` and the others
    axes : (3, 3) float  rows: directions of the components of the response in the reference
    arm : (3,) float [m]  from the centre of the bearing across its axis, in the reference
    normal : (3,) float  of the wall, outwards, in the reference; zeros where there is none
    points : (2 or more,) int  of the journal, then the bearing among the temperatures; None: a
        telescope
    drive : which of the driven rows drives the joint; -1 where none does
    row : of its history among all, which its parts follow, whose friction is its own
    parts : how many
    station : float [m]  of a telescope: place of the contact on its own tube in the reference
    """

    name: str
    joint: str
    label: str
    table: contact_tables.Loose
    form: str
    axes: Array
    arm: Array
    normal: Array
    points: Array | None
    drive: int
    row: int = 0
    parts: int = 0
    station: float = nan


def contacts_of(scene: Scene, system: System) -> list[Contact]:
    """All contacts in the order of their histories."""
    drives = {system.row_names[row]: i for i, row in enumerate(system.driven)}
    tables = loose_joints(scene)
    found: list[Contact] = []
    row = 0
    for term in system.contacts:
        names = term.contact_names
        if not hasattr(term, "planes") and hasattr(term, "facets"):
            found.append(_of_bore(term, tables[names[0]], row))
            row += len(names)
            continue
        for k, name in enumerate(names):
            joint = joint_of(name, tables)
            assert joint is not None
            label = name[len(joint) + 1 :]
            place = _geometry(term, tables[joint], k)
            drive, station = drives.get(joint, -1), _station(term, k)
            table = tables[joint]
            found.append(Contact(name, joint, label, table, *place, drive, row, station=station))
            row += 1
    return found


def _station(term: Any, k: int) -> float:
    stations = getattr(term, "stations", None)
    return nan if stations is None else stations[k].place


def _of_bore(term: Any, table: contact_tables.Loose, row: int) -> Contact:
    """The whole of a pin in the bore of a solid; its directions are those of space."""
    points = np.concatenate([[term.journal], np.unique(term.facets.rows)])
    name, parts = term.contact_names[0], len(term.contact_names) - 1
    nothing = np.zeros(3)
    return Contact(name, name, "", table, BORE, np.eye(3), nothing, nothing, points, -1, row, parts)


def losses(contacts: list[Contact], lost: Array) -> Array:
    """(n_c, 2) [J]  of contacts with their parts, from those of all histories (h, 2)."""
    if len(contacts) == len(lost):
        return lost
    return np.array([lost[c.row : c.row + 1 + c.parts].sum(axis=0) for c in contacts])


def joint_of(contact: str, joints: Collection[str]) -> str | None:
    """The joint whose name, followed by a label, is that of a contact; None if there is none."""
    fits = [name for name in joints if contact == name or contact.startswith(f"{name}.")]
    return max(fits, key=len, default=None)


def _geometry(
    term: Any, table: contact_tables.Loose, k: int
) -> tuple[str, Array, Array, Array, Array | None]:
    """Form, axes, arm, normal and temperature points of a contact of a term."""
    if isinstance(table, contact_tables.Telescope):
        return TUBE, np.eye(3), np.zeros(3), np.zeros(3), None
    from mechanics.clearance_kernels import BALL as SOCKET
    from mechanics.clearance_kernels import VERTEX

    joint, slot = divmod(k, term.slots)
    axes = np.array([*term.planes[joint], np.cross(*term.planes[joint])])
    point = term.contacts[joint][slot]
    kind, normal = point.geometry[0], np.zeros(3)
    form = PLANAR if term.slots == 1 else END
    arm = np.array([0.0, 0.0, 0.0])
    if kind == SOCKET:
        form = BALL
    elif kind == VERTEX:
        form, normal, arm = WALL, point.geometry[4:7] @ axes, [*point.arm[:2], 0.0] @ axes
    return form, axes, arm, normal, term.points[joint]


# ------------------------------------------------------------------------------- histories


def regimes(contacts: list[Contact], response: Array, approach: Array) -> NDArray[np.int8]:
    """Regime of motion (k, n_c), see ``mechanics.contact.classify``."""
    from mechanics.contact import FRICTION, classify

    slip = np.linalg.norm(response[..., march.SLIP : march.SLIP + 3], axis=-1)
    depth, rate = response[..., march.DEPTH], response[..., march.DEPTH_RATE]
    stuck, found = response[..., march.STUCK], np.zeros(approach.shape, np.int8)
    frictions = [contact.table.friction for contact in contacts]
    laws = np.array([NONE if f is None else FRICTION[f.law] for f in frictions])
    speeds = np.array([0.0 if f is None else f.regularisation_speed for f in frictions])
    for law in np.unique(laws):
        j = laws == law
        found[:, j] = classify(
            depth[:, j], rate[:, j], approach[:, j], slip[:, j], speeds[j], stuck[:, j], int(law)
        )
    return found


def history(
    contact: Contact, times: Array, response: Array, approach: Array, regime: NDArray[np.int8]
) -> dict[str, NDArray]:
    """Columns of the history of one contact but drive and temperatures.

    Parameters
    ----------
    response : (k, columns) of the contact; approach : (k,) [m/s]; regime : (k,)
    """
    path, friction, slip = (
        response[:, first : first + 3] for first in (march.PATH, march.FRICTION, march.SLIP)
    )
    rows: dict[str, NDArray] = {"time": times}
    if contact.form in (WALL, BORE):
        rows["towards_wall"] = path[:, 0]
    else:
        rows["orbit"] = path[:, : ORBITS[contact.form]]
    rows |= {
        "clearance": response[:, march.GAP],
        "penetration": response[:, march.DEPTH],
        "normal_force": response[:, march.ELASTIC] + response[:, march.DISSIPATIVE],
        "friction_force": _tangential(contact, path, friction),
        "slip_speed": _tangential(contact, path, slip),
        "approach": approach,
        "regime": regime,
        "stuck": response[:, march.STUCK].astype(np.int8),
    }
    if contact.form != PLANAR:
        rows["friction_vector"] = friction
    if contact.form in (END, WALL, TUBE):
        rows["place"] = response[:, march.PLACE]
    return rows


def _tangential(contact: Contact, path: Array, vector: Array) -> Array:
    """(k,) of vectors (k, 3): in the plane along the circle, counter-clockwise; else their size."""
    if contact.form != PLANAR:
        return np.linalg.norm(vector, axis=1)
    size = np.maximum(np.hypot(path[:, 0], path[:, 1]), 1e-300)
    return (path[:, 0] * vector[:, 1] - path[:, 1] * vector[:, 0]) / size


def driven(contact: Contact, times: Array, drive: Array) -> dict[str, Array]:
    """Angle and torque of a revolute joint, of its first contact if it has several.

    drive : (k, n_d) multipliers of the driven rows
    """
    table = contact.table
    if not isinstance(table, contact_tables.ClearanceRevolute) or contact.label not in ("", FIRST):
        return {}
    angle = table.angle or (lambda t: 0.0)
    # A driven row is the sine of the angle left to go, so its multiplier is the torque.
    torque = -drive[:, contact.drive] if contact.drive >= 0 else np.zeros(len(times))
    return {"angle": np.array([angle(t) for t in times]), "torque": torque}


# ------------------------------------------------------------------------------ attributes


def attributes(scene: Scene, contact: Contact, number: int, centre: Array | None) -> dict[str, Any]:
    """What drawing needs to know of a contact.

    number : among all contacts;  centre : (3,) float [m]  of the bearing at the start
    """
    table = contact.table
    rows: dict[str, Any] = {
        "kind": table.kind, "form": contact.form, "joint": contact.joint,
        "label": contact.label, "number": number, "reference_clearance": _clearance(contact),
        "directions": _directions(contact), "axes": contact.axes,
    }  # fmt: skip
    if isinstance(table, contact_tables.Telescope):
        return rows | _tubes(scene, contact, table)
    assert centre is not None
    if contact.form == BORE:  # no orbit: where it touches is in the solid
        return {key: value for key, value in rows.items() if key != "directions"}
    if not isinstance(table, contact_tables.ClearanceTranslational):
        rows["radius"] = table.radius
    if not isinstance(table, contact_tables.ClearanceSpherical):
        rows["axis"] = np.array(table.axis)
    rows |= {"position": centre + contact.arm}
    rows |= _side(scene, "journal", table.journal, np.zeros(3))
    return rows | _side(scene, "bearing", table.bearing, contact.arm)


def _clearance(contact: Contact) -> float:
    """At the reference temperature [m]."""
    table = contact.table
    if contact.form == WALL and isinstance(table, contact_tables.ClearanceRevolute):
        assert table.axial_clearance is not None
        return table.axial_clearance
    return table.clearance


def _tubes(scene: Scene, contact: Contact, table: contact_tables.Telescope) -> dict[str, Any]:
    """The tubes of a telescope, and of its mouth the place on the outer one [m]."""
    rows: dict[str, Any] = {
        "radius": table.radius, "bearing_body": table.outer, "journal_body": table.inner,
        "station": contact.station,
    }  # fmt: skip
    if not contact.label.startswith(MOUTH):
        return rows
    along = scene.shapes[table.outer].along
    return rows | {"mouth": float(along[0 if table.mouth == "start" else -1])}


def _directions(contact: Contact) -> Array:
    """(d, 3) directions of the components of the orbit, or of the way to the wall."""
    if contact.form == WALL:
        return contact.normal[None]
    return contact.axes[: ORBITS.get(contact.form, 0)]


def _side(scene: Scene, side: str, site: Any, arm: Array) -> dict[str, Any]:
    """Body and node of one side of a joint, and how far from it; nothing for the ground.

    The distance [m] is along e1, e2, e3 of the node.
    """
    if site.body == GROUND:
        return {}
    shape = scene.shapes[site.body]
    place = place_of(shape, site)
    away = shape.axes[place.node] @ (point_of(shape, place) + arm - shape.points[place.node])
    return {f"{side}_body": site.body, f"{side}_node": place.node, f"{side}_offset": away}
