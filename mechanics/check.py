"""What cannot be in a description, in one sentence each, before anything is built from it."""

from collections import Counter
from collections.abc import Iterator
from dataclasses import fields
from math import isfinite
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mechanics.description import (
    Beam,
    Body,
    BoreContact,
    Clearance,
    ClearanceRevolute,
    Continuum,
    Cylindrical,
    Description,
    Fixing,
    Flexible,
    Gear,
    Joint,
    Latch,
    Load,
    Particle,
    Prismatic,
    Pulley,
    ReferencePoint,
    Revolute,
    RigidBody,
    Shell,
    Site,
    Sliding,
    Telescope,
    TorsionSpring,
    Traction,
)
from mechanics.elements import FAMILIES
from mechanics.layout import node_count

Array = NDArray[np.float64]

TURNING = (Revolute, Cylindrical, ClearanceRevolute)
SLIDING = (Prismatic, Cylindrical)
_LENGTHS = (
    "radius", "clearance", "length", "height", "width", "corner_radius", "axial_clearance",
    "flange_radius", "pin_radius",
)  # fmt: skip
TOGETHER = 1e-9
"""Distance of two nodes, relative to the size of the body, that is none [-]."""
TILTED = 1e-6
"""Deviation from unit length or right angle that is none [-]."""
_RAYLEIGH = "Rayleigh damping does not go with a floating frame; give it a damping time"


def check(description: Description) -> list[str]:
    """One sentence for each problem; none if the system can be built."""
    problems = []
    for name, count in Counter(body.name for body in description.bodies).items():
        if count > 1:
            problems.append(f"{count} bodies have the same name {name!r}")
    kinds = "joint", description.joints, "load", description.loads
    for kind, items in zip(kinds[::2], kinds[1::2], strict=True):
        for name, count in Counter(item.name for item in items).items():
            if count > 1:
                problems.append(f"{count} {kind}s have the same name {name!r}")
    for body in description.bodies:
        if not isinstance(body, ReferencePoint):
            problems += [f"body {body.name!r}: {problem}" for problem in _body(body)]
    bodies = {body.name: body for body in description.bodies}
    joints = {joint.name: joint for joint in description.joints}
    for joint in description.joints:
        problems += [f"joint {joint.name!r}: {p}" for p in _joint(joint, bodies, joints)]
    for load in description.loads:
        problems += [f"load {load.name!r}: {p}" for p in _load(load, bodies)]
    if description.rayleigh is not None:
        floating = [b for b in description.bodies if isinstance(b, Beam) and b.modes is not None]
        problems += [f"body {b.name!r}: {_RAYLEIGH}" for b in floating]
    if not _finite(description.gravity):
        problems.append("gravity is not finite")
    return problems


# --------------------------------------------------------------------------------------- bodies


def _body(body: Body) -> Iterator[str]:
    if not (_finite(body.velocity) and _finite(getattr(body, "spin", 0.0))):
        yield "its velocity is not finite"
    if isinstance(body, Beam):
        yield from _beam(body)
    elif isinstance(body, Shell):
        yield from _shell(body)
    elif isinstance(body, Continuum):
        yield from _solid(body)
    elif isinstance(body, Particle | RigidBody):
        if not _finite(body.position):
            yield "its position is not finite"
        if not (isfinite(body.mass) and body.mass > 0.0):
            yield f"its mass must be positive and finite, got {body.mass:g} kg"
        if isinstance(body, RigidBody):
            yield from _rigid(body)


def _beam(beam: Beam) -> Iterator[str]:
    if beam.element not in FAMILIES:
        yield f"there is no element {beam.element!r}"
        return
    section = beam.section
    values = {
        "area": section.area,
        "second moment 2": section.second_moment_2,
        "second moment 3": section.second_moment_3,
    }
    if beam.element != "cable":
        values |= {
            "torsion constant": section.torsion_constant,
            "shear factor 2": section.shear_factor_2,
            "shear factor 3": section.shear_factor_3,
        }
    for name, value in values.items():
        if not (isfinite(value) and value > 0.0):
            yield f"the {name} of its section must be positive and finite, got {value:g}"
    yield from _times(beam)
    yield from _modes(beam)
    points, axes = np.asarray(beam.points, float), np.asarray(beam.axes, float)
    stride = FAMILIES[beam.element].stride
    if len(points) < stride + 1 or (len(points) - 1) % stride:
        wanted = "two nodes or more" if stride == 1 else f"1 + a multiple of {stride} nodes"
        yield f"it has {len(points)} nodes; {beam.element} needs {wanted}"
    elif not (_finite(points) and _finite(axes)):
        yield "its points and axes are not finite"
    elif len(axes) != len(points):
        yield f"it has {len(points)} points and {len(axes)} triads"
    else:
        yield from _coincident(points)
        product = np.einsum("nij,nkj->nik", axes, axes)
        if np.max(np.abs(product - np.eye(3))) > TILTED:
            yield "a section triad is not orthonormal"


def _modes(beam: Beam) -> Iterator[str]:
    if beam.modes is None:
        return
    if beam.element != "beam3243":
        yield f"a floating frame takes elements beam3243, not {beam.element}"
    most = 6 * max(len(beam.points) - 2, 0)
    if not 0 <= beam.modes <= most or beam.modes % 3:
        yield (
            f"its {len(beam.points) - 1} elements have from 0 to {most} modes besides those of its "
            f"ends, by threes, not {beam.modes}"
        )


def _coincident(points: Array) -> Iterator[str]:
    """Neighbours at the same place, the first pair."""
    gaps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    size = np.max(np.ptp(points, axis=0), initial=0.0)
    if np.any(gaps <= TOGETHER * size):
        node = int(np.argmin(gaps))
        yield f"nodes {node} and {node + 1} coincide"


def _shell(shell: Shell) -> Iterator[str]:
    if shell.element not in FAMILIES:
        yield f"there is no element {shell.element!r}"
    if not (isfinite(shell.thickness) and shell.thickness > 0.0):
        yield f"its thickness must be positive and finite, got {shell.thickness:g} m"
    yield from _times(shell)
    surface = shell.surface
    if not _finite(surface.points):
        yield "its points are not finite"
        return
    size = float(np.max(np.ptp(surface.points, axis=0), initial=0.0))
    corners = surface.points[surface.quads]
    for a, b in ((0, 1), (1, 2), (2, 3), (3, 0)):
        gaps = np.linalg.norm(corners[:, a] - corners[:, b], axis=1)
        if np.any(gaps <= TOGETHER * size):
            nodes = surface.quads[int(np.argmin(gaps))]
            yield f"nodes {nodes[a]} and {nodes[b]} coincide"
            return


def _solid(body: Continuum) -> Iterator[str]:
    if body.element not in FAMILIES:
        yield f"there is no element {body.element!r}"
    yield from _times(body)
    points, cells = np.asarray(body.points, float), np.asarray(body.cells)
    if not _finite(points):
        yield "its points are not finite"
    if not cells.size or cells.min() < 0 or cells.max() >= len(points):
        yield "its cells have nodes that do not exist"
    elif np.unique(cells).size < len(points):
        yield f"{len(points) - np.unique(cells).size} of its nodes belong to no cell"


def _times(body: Flexible) -> Iterator[str]:
    if not (isfinite(body.damping_time) and body.damping_time >= 0.0):
        yield f"its damping time must not be negative, got {body.damping_time:g} s"
    if not (isfinite(body.reference_temperature) and body.reference_temperature > 0.0):
        yield f"its reference temperature must be above 0 K, got {body.reference_temperature:g} K"


def _rigid(body: RigidBody) -> Iterator[str]:
    inertia, axes = np.asarray(body.inertia, float), np.asarray(body.axes, float)
    if not _finite(inertia) or np.abs(inertia - inertia.T).max() > 1e-9 * np.abs(inertia).max():
        yield "its inertia is not a symmetric matrix of finite numbers"
        return
    moments = np.linalg.eigvalsh(inertia)
    if moments[0] <= 0.0:
        yield f"its moments of inertia must be positive, got {moments[0]:g} kg m^2"
    elif moments[2] > (1.0 + 1e-9) * (moments[0] + moments[1]):
        yield "no body has such inertia: one principal moment exceeds the sum of the others"
    if not _finite(axes) or np.max(np.abs(axes @ axes.T - np.eye(3))) > TILTED:
        yield "its axes are not orthonormal"


# ------------------------------------------------------------------------------ joints and loads


def _joint(joint: Joint, bodies: dict[str, Body], joints: dict[str, Joint]) -> Iterator[str]:
    yield from _sites(joint, bodies)
    yield from _signs(joint)
    if isinstance(joint, Sliding):
        yield from _slide(joint, bodies)
    if isinstance(joint, Fixing):
        yield from _site(Site(joint.body, joint.node), bodies)
    if isinstance(joint, Gear):
        yield from _refers(joint.first, joints, TURNING, "turns")
        yield from _refers(joint.second, joints, TURNING, "turns")
        if joint.first == joint.second:
            yield "it couples a joint with itself"
        if not (isfinite(joint.ratio) and joint.ratio != 0.0):
            yield f"its ratio must be finite and not zero, got {joint.ratio:g}"
    if isinstance(joint, TorsionSpring):
        yield from _refers(joint.joint, joints, TURNING, "turns")
    if isinstance(joint, Latch):
        yield from _refers(joint.joint, joints, (*TURNING, *SLIDING), "turns or slides")
        if not isfinite(joint.at):
            yield "where it locks is not finite"
    if isinstance(joint, Clearance | Telescope | BoreContact):
        for name in _LENGTHS:
            value = getattr(joint, name, None)
            if value is not None and not (isfinite(value) and value > 0.0):
                yield f"its {name.replace('_', ' ')} must be positive and finite, got {value:g} m"
    if isinstance(joint, Telescope):
        yield from _tubes(joint, bodies)


def _tubes(joint: Telescope, bodies: dict[str, Body]) -> Iterator[str]:
    for name in (joint.inner, joint.outer):
        if name not in bodies:
            yield f"there is no body {name!r}"
        elif not isinstance(bodies[name], Beam):
            yield f"{name!r} is no beam"
    if joint.inner == joint.outer:
        yield f"{joint.inner!r} is no tube in itself"


def _refers(name: str, joints: dict[str, Joint], kinds: tuple, what: str) -> Iterator[str]:
    if name not in joints:
        yield f"there is no joint {name!r}"
    elif not isinstance(joints[name], kinds):
        yield f"joint {name!r} is none that {what}"


def _slide(joint: Sliding, bodies: dict[str, Body]) -> Iterator[str]:
    if joint.body not in bodies:
        yield f"there is no body {joint.body!r}"
    elif not isinstance(bodies[joint.body], Beam):
        yield f"{joint.body!r} is no beam or cable to slide on"
    elif joint.a.body == joint.body:
        yield f"{joint.body!r} cannot slide on itself"


def _sites(item: Any, bodies: dict[str, Body]) -> Iterator[str]:
    """Ends that do not exist, and joints of the ground with itself."""
    ends = _ends(item)
    for site in ends:
        yield from _site(site, bodies)
    if len(ends) > 1 and all(site.body is None for site in ends):
        yield "all its ends are on the ground"
    elif len(ends) == 2 and _same(*ends):
        yield "both its ends are the same point"


def _ends(item: Any) -> list[Site]:
    if isinstance(item, Pulley):
        return list(item.points)
    values = [getattr(item, f.name) for f in fields(item)]
    return [value for value in values if isinstance(value, Site)]


def _same(a: Site, b: Site) -> bool:
    places = [(s.body, s.node, s.fraction, *np.ravel(s.offset)) for s in (a, b)]
    return places[0] == places[1]


def _site(site: Site, bodies: dict[str, Body]) -> Iterator[str]:
    if not (_finite(site.position) and _finite(site.offset) and isfinite(site.fraction)):
        yield "one of its points is not finite"
    if site.body is None:
        return
    if site.body not in bodies:
        yield f"there is no body {site.body!r}"
        return
    body = bodies[site.body]
    nodes = node_count(body)
    if not -nodes <= site.node < nodes:
        yield f"body {site.body!r} has {nodes} nodes, not a node {site.node}"
    if isinstance(body, Particle) and np.any(site.offset):
        yield f"particle {site.body!r} has no point beside its centre"


def _signs(joint: Joint) -> Iterator[str]:
    """Directions without length; stiffness, damping and length with the wrong sign."""
    for name in ("axis", "axis_a", "axis_b", "normal"):
        if hasattr(joint, name) and not _direction(getattr(joint, name)):
            yield f"its {name} has no direction"
    for name in ("stiffness", "damping"):
        value = getattr(joint, name, None)
        if value is not None and not (_finite(value) and np.all(np.asarray(value) >= 0.0)):
            yield f"its {name} must not be negative"
    length = getattr(joint, "length", None)
    if isinstance(length, float | int) and not (isfinite(length) and length >= 0.0):
        yield f"its length must not be negative, got {length:g} m"


def _load(load: Load, bodies: dict[str, Body]) -> Iterator[str]:
    yield from _sites(load, bodies)
    if not _direction(load.direction):
        yield "its direction has no length"
    if isinstance(getattr(load, "site", None), Site) and load.site.body is None:  # type: ignore
        yield "it must act on a body, not on the ground"
    if isinstance(load, Traction):
        yield from _traction(load, bodies)


def _traction(load: Traction, bodies: dict[str, Body]) -> Iterator[str]:
    body = bodies.get(load.body)
    if body is None:
        yield f"there is no body {load.body!r}"
    elif isinstance(body, Continuum):
        if load.edge is not None:
            yield f"{load.body!r} is a solid: it takes a load per area of its faces, not of an edge"
        yield from _faces(load, body)
    elif not isinstance(body, Shell):
        yield f"{load.body!r} is neither shell nor solid"
    elif load.faces is not None:
        yield f"{load.body!r} is a shell: only solids have faces"


def _faces(load: Traction, body: Continuum) -> Iterator[str]:
    faces, nodes = np.asarray(() if load.faces is None else load.faces), len(body.points)
    wanted = 9 if np.shape(body.cells)[1:] == (27,) else 8
    if faces.ndim != 2 or not faces.size or faces.shape[1] != wanted:
        yield f"it needs the faces of {load.body!r} that it acts on, with {wanted} nodes each"
    elif faces.min() < 0 or faces.max() >= nodes:
        yield f"{load.body!r} has {nodes} nodes, its faces others"


def _finite(value: Any) -> bool:
    return bool(np.all(np.isfinite(np.asarray(value, float))))


def _direction(vector: Any) -> bool:
    return _finite(vector) and float(np.linalg.norm(vector)) > 0.0
