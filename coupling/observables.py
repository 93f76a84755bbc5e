"""What is read from states: probes, shapes of the bodies, resultants."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from coupling.descriptions import material_point
from coupling.places import place_of
from coupling.scene import Scene
from mechanics.description import (
    Beam,
    Continuum,
    FloatingFrame,
    ReferencePoint,
    RigidBody,
    Shell,
    Site,
)
from mechanics.dynamics import Motion
from mechanics.layout import Layout, Side, family_of
from mechanics.system import Coefficients, System

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

SECTION = ("radius", "thickness", "height", "width", "area", "second_moment_2",
           "second_moment_3", "torsion_constant")  # fmt: skip
SLOPES = ("r_u", "r_v", "r_uv")
UNSEEN = Continuum | ReferencePoint | FloatingFrame
"""What is not drawn as it is."""


# ---------------------------------------------------------------------------------- probes


class Probed(NamedTuple):
    """Where a probe is: point of a body, and how its place follows from coordinates.

    rows : (k,) int  rows of the section temperatures of the body; None: it has none
    """

    site: Site
    side: Side
    rows: Indices | None


def probed(scene: Scene, layout: Layout) -> dict[str, Probed]:
    """The probes of a scene by name."""
    found = {}
    for name, probe in scene.probe.items():
        site = material_point(scene, probe.body, place_of(scene.shapes[probe.body], probe))
        found[name] = Probed(site, layout.site(site), layout.point_index.get(probe.body))
    return found


def probes(
    places: Mapping[str, Probed], layout: Layout, motion: Any, T: Array
) -> dict[str, dict[str, Any]]:
    """Position, velocity, acceleration of a motion in time, and temperature at each probe.

    Parameters
    ----------
    places : see ``probed``
    motion : has t, q, v, and a if it is one in time
    T : (m, 3) float [K, K/m, K/m]  section temperatures
    """
    rows: dict[str, dict[str, Any]] = {}
    fields = {"position": motion.q, "velocity": motion.v}
    if isinstance(motion, Motion):
        fields["acceleration"] = motion.a
    for name, (site, side, points) in places.items():
        at = side.vectors[:, None] + np.arange(3)
        rows[name] = {"time": motion.t}
        rows[name] |= {key: side.weights[0] @ values[at] for key, values in fields.items()}
        if points is not None:
            body = layout.bodies[str(site.body)]
            rows[name]["temperature"] = _temperature(body, site, T[points, 0])
    return rows


def _temperature(body: Any, site: Site, points: Array) -> float:
    """Mean [K] of the section at a site from the temperatures (n,) of the nodes."""
    if isinstance(body, ReferencePoint):
        return float(np.average(points[body.nodes], weights=body.weights))
    ends = points[site.node], points[min(site.node + 1, len(points) - 1)]
    return float((1.0 - site.fraction) * ends[0] + site.fraction * ends[1])


# ---------------------------------------------------------------------------------- bodies


def bodies(
    system: System, motion: Any, T: Array, coef: Coefficients
) -> dict[str, dict[str, Array]]:
    """Shape, section temperatures and resultants of each body but solids."""
    layout = system.layout
    rows: dict[str, dict[str, Array]] = {}
    found = resultants(system, motion, coef)
    for name, first in layout.node_dofs.items():
        body, kind = layout.bodies[name], layout.kinds[name]
        if isinstance(body, UNSEEN):
            continue
        nodes = motion.q[first[:, None] + np.arange(kind)].reshape(len(first), -1, 3)
        vectors = dict(zip(family_of(body).vectors, np.moveaxis(nodes, 1, 0), strict=True))
        rows[name] = {"position": vectors["position"], "axes": _triads(body, vectors)}
        if isinstance(body, Shell):
            rows[name]["slopes"] = _slopes(vectors)
        if name in layout.point_index:
            rows[name]["temperature"] = T[layout.point_index[name]]
        if name in found:
            rows[name]["resultants"] = found[name]
    return rows


def resultants(system: System, motion: Any, coef: Coefficients) -> dict[str, Array]:
    """(n_e, 6) of line bodies, (n_e, 8) of shells, by name."""
    y = system.unknowns(motion.q, motion.lam)
    v = np.concatenate([motion.v, np.zeros(system.m)])
    found: dict[str, Array] = {}
    for term, c in zip(system.terms, coef, strict=True):
        if term in system.elements and hasattr(term, "resultants"):
            values, names = term.resultants(y, v, c), np.array(term.names)
            found |= {name: values[names == name] for name in dict.fromkeys(term.names)}
    return found


def _triads(body: Any, vectors: Mapping[str, Array]) -> Array:
    """(n, 3, 3) orthonormal triads e1, e2, e3 of the nodes from their vectors."""
    position = vectors["position"]
    if isinstance(body, RigidBody):
        return np.stack([vectors["e1"], vectors["e2"], vectors["e3"]], axis=1)
    if isinstance(body, Beam) and "r_z" in vectors:
        e2 = _unit(vectors["r_y"])
        e1 = _unit(np.cross(e2, vectors["r_z"]))
        return np.stack([e1, e2, np.cross(e1, e2)], axis=1)
    if isinstance(body, Beam):
        from meshes.generate import frames

        return frames(position)
    if isinstance(body, Shell):
        return _shell_triads(body, vectors)
    return np.tile(np.eye(3), (len(position), 1, 1))


def _shell_triads(body: Shell, vectors: Mapping[str, Array]) -> Array:
    """e3 normal, e1 along u; of shells that carry only a normal, as far as that allows."""
    if "r_u" in vectors:
        e1 = _unit(vectors["r_u"])
        e3 = _unit(np.cross(e1, vectors["r_v"]))
    else:
        e3 = _unit(vectors["r_n"])
        start = np.asarray(body.surface.d_u, float)
        e1 = _unit(start - np.sum(start * e3, axis=1, keepdims=True) * e3)
    return np.stack([e1, np.cross(e3, e1), e3], axis=1)


def _slopes(vectors: Mapping[str, Array]) -> Array:
    """(n, 3, 3)  r_u, r_v [-], r_uv [1/m]; zeros where a shell has none."""
    nothing = np.zeros_like(vectors["position"])
    return np.stack([vectors.get(name, nothing) for name in SLOPES], axis=1)


def _unit(a: Array) -> Array:
    return a / np.linalg.norm(a, axis=-1, keepdims=True)


def attributes(layout: Layout) -> dict[str, dict[str, Any]]:
    """What drawing needs to know of the bodies but solids."""
    rows: dict[str, dict[str, Any]] = {}
    for name, body in layout.bodies.items():
        if isinstance(body, Beam):
            section = {key: getattr(body.section, key) for key in SECTION}
            rows[name] = {"section_kind": body.section.kind, "element": body.element, **section}
        elif isinstance(body, Shell):
            rows[name] = {"section_kind": "shell", "element": body.element,
                          "thickness": body.thickness}  # fmt: skip
        elif isinstance(body, RigidBody):
            own = body.axes @ body.inertia @ np.asarray(body.axes).T
            rows[name] = {"section_kind": "rigid", "element": "rigid", "mass": body.mass,
                          "inertia": own}  # fmt: skip
        elif not isinstance(body, UNSEEN):
            rows[name] = {"section_kind": "point", "element": "particle", "mass": body.mass}
    return rows


def surfaces(layout: Layout) -> dict[str, dict[str, NDArray]]:
    """Elements of the shells: nodes at their corners (n_e, 4), sizes (n_e, 2) [m]."""
    return {
        name: {"quads": body.surface.quads, "sizes": body.surface.sizes}
        for name, body in layout.bodies.items()
        if isinstance(body, Shell)
    }
