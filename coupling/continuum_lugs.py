"""Bores of joints as elastic rings: what [mechanics.lug.JOINT] makes of a clearance_revolute joint.

The ring is a solid body of its own with the name of the bearing. Its outer surface is held by the
bearing's side of the joint: its mean position and orientation follow, it swells freely. Without a
length the joint is planar: the pin stays in its plane and upright.
"""

import numpy as np
from numpy.typing import NDArray

import mechanics.description as motion
from coupling.body_tables import LineBody, RigidBody
from coupling.contact_tables import ClearanceRevolute
from coupling.mechanics_tables import Lug
from coupling.scene import Scene
from coupling.site_tables import GROUND
from meshes.materials import Material
from meshes.mesh import Mesh
from meshes.solids import bore

Array = NDArray[np.float64]

PENALTY = 10.0
"""Stiffness of the surface where none is given, in Young's moduli over the size of a cell [-]."""
FAMILY = "hexahedron20"


def ring_name(joint: str) -> str:
    """Name of the body, which is that of the bearing among the temperatures."""
    return f"{joint}.bearing"


def lugs(scene: Scene) -> dict[str, Lug]:
    """Joints whose bore is a solid."""
    return scene.mechanics.lug if scene.mechanics.is_continuum else {}


def ring_mesh(scene: Scene, name: str) -> Mesh:
    """Mesh of a bore in its place: its middle where the bearing is."""
    from coupling.descriptions import sites_of

    joint, lug = _joint(scene, name), scene.mechanics.lug[name]
    inner = joint.radius + joint.clearance
    mesh = bore(inner, lug.outer_radius, lug.length, lug.round, lug.layers, lug.cells, 2, FAMILY)
    *_, at = sites_of(scene, joint.bearing, joint.journal)
    axes = _axes(np.array(joint.axis))
    local = mesh.points - [0.0, 0.0, 0.5 * lug.length]
    return Mesh(at + local[:, [2, 0, 1]] @ axes, mesh.cells, mesh.regions)


def bodies_of(scene: Scene, name: str) -> list[motion.Continuum | motion.ReferencePoint]:
    """The ring, and what stands for its outer surface."""
    from coupling.continuum import face_areas
    from coupling.descriptions import reference_of
    from coupling.materials_used import material_of

    joint, mesh = _joint(scene, name), ring_mesh(scene, name)
    velocity, spin = _motion_of(scene, joint.bearing.body)
    lug = scene.mechanics.lug[name]
    single = lug.layers == lug.cells == 1  # reduced quadrature leaves a row of cells loose
    ring = motion.Continuum(
        ring_name(name),
        mesh.points,
        mesh.cells[FAMILY],
        material_of(scene, joint.bearing_material),
        reference_of(joint),
        f"{FAMILY}-full" if single else FAMILY,
        0.0,
        velocity,
        spin,
    )
    ((_, rows),) = mesh.cells_of("outer").items()
    facets = mesh.cells["quad8"][rows]
    areas = face_areas(mesh.points, facets)
    nodes = np.unique(facets)
    axes = _axes(np.array(joint.axis))
    outer = motion.ReferencePoint(_outer(name), ring_name(name), nodes, areas[nodes], axes)
    return [ring, outer]


def joints_of(scene: Scene, name: str, loose: motion.Clearance) -> list[motion.Joint]:
    """Pin in bore, what holds the ring, and what a planar joint holds besides.

    loose : the joint as it would be without a ring
    """
    joint, mesh = _joint(scene, name), ring_mesh(scene, name)
    ((_, rows),) = mesh.cells_of("inner").items()
    contact = motion.BoreContact(
        name, ring_name(name), mesh.cells["quad8"][rows], loose.journal, np.array(joint.axis),
        joint.radius, _stiffness(scene, name, loose.bearing_material), loose.journal_material,
        loose.bearing_material, loose.reference_temperature, None, loose.friction,
        loose.contact.restitution, loose.contact.dissipation, loose.contact.reference_speed,
    )  # fmt: skip
    found: list[motion.Joint] = [
        contact,
        motion.Clamp(f"{name}.ring", motion.Site(_outer(name)), loose.bearing),
    ]
    if joint.length is None:
        found.append(
            motion.Planar(f"{name}.plane", loose.journal, loose.bearing, np.array(joint.axis))
        )
    return found


def _joint(scene: Scene, name: str) -> ClearanceRevolute:
    joint = scene.joint[name]
    assert isinstance(joint, ClearanceRevolute)
    return joint


def _outer(name: str) -> str:
    return f"{ring_name(name)}@outer"


def _stiffness(scene: Scene, name: str, material: Material) -> float:
    """Pressure per depth [N/m^3]."""
    from coupling.descriptions import reference_of

    joint, lug = _joint(scene, name), scene.mechanics.lug[name]
    if lug.stiffness is not None:
        return lug.stiffness
    size = 2.0 * np.pi * (joint.radius + joint.clearance) / lug.round
    return PENALTY * float(material.youngs_modulus(reference_of(joint))) / size


def _axes(axis: Array) -> Array:
    """(3, 3) orthonormal rows, the first along ``axis``."""
    e1 = axis / np.linalg.norm(axis)
    e2 = np.eye(3)[int(np.argmin(np.abs(e1)))]
    e2 = e2 - (e2 @ e1) * e1
    e2 /= np.linalg.norm(e2)
    return np.stack([e1, e2, np.cross(e1, e2)])


def _motion_of(scene: Scene, body: str) -> tuple[Array, Array]:
    """Velocity [m/s] and spin [rad/s] about the origin with which a side begins."""
    table = None if body == GROUND else scene.body[body]
    if isinstance(table, RigidBody):
        spin = np.array(table.spin)
        return np.array(table.velocity) - np.cross(spin, table.position), spin
    if isinstance(table, LineBody):
        return np.array(table.velocity), np.array(table.spin)
    return np.zeros(3), np.zeros(3)
