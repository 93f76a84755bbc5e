"""What is recorded of solids: the beam that they stand for, and the cells themselves."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from coupling.continuum import solids
from coupling.continuum_lugs import FAMILY, lugs, ring_mesh, ring_name
from coupling.scene import Scene
from mechanics.system import Coefficients, System

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

SECTION = ("radius", "thickness", "height", "width", "area", "second_moment_2",
           "second_moment_3", "torsion_constant")  # fmt: skip


class SolidRows:
    """Rows of the solids of a scene from motions and temperatures."""

    def __init__(self, scene: Scene, system: System) -> None:
        self._system, self._solids = system, solids(scene)
        self._fits = {name: solid.fit() for name, solid in self._solids.items()}
        rings = {ring_name(joint): ring_mesh(scene, joint) for joint in lugs(scene)}
        self._cells = {name: (s.cells, s.surface) for name, s in self._solids.items()}
        self._cells |= {n: (m.cells[FAMILY], m.cells["quad8"]) for n, m in rings.items()}

    def attributes(self) -> dict[str, dict[str, Any]]:
        """What drawing needs to know of the beams."""
        return {
            name: {"section_kind": s.section.kind, "element": s.element}
            | {key: getattr(s.section, key) for key in SECTION}
            for name, s in self._solids.items()
        }

    def elements(self) -> dict[str, dict[str, Indices]]:
        """Cells and facets of the boundary, by group."""
        found = {}
        for name, (cells, facets) in self._cells.items():
            found[f"cells/{name}"] = {"cells": cells}
            found[f"facets/{name}"] = {"facets": facets}
        return found

    def bodies(self, q: Array, T: Array) -> dict[str, dict[str, Array]]:
        """Mean positions, triads and section temperatures where the beams have their nodes."""
        rows = {}
        for name, (mean, by_y, by_z) in self._fits.items():
            x, own = self._points(name, q), T[self._system.layout.point_index[name], 0]
            section = np.stack([fit @ own for fit in (mean, by_y, by_z)], axis=1)
            axes = _triads(by_y @ x, by_z @ x)
            rows[name] = {"position": mean @ x, "axes": axes, "temperature": section}
        return rows

    def cells(self, motion: Any, T: Array, coef: Coefficients) -> dict[str, dict[str, Array]]:
        """Positions and temperatures of the nodes, equivalent stress of the cells."""
        index = self._system.layout.point_index
        stress = self._stresses(motion, coef)
        return {
            name: {
                "position": self._points(name, motion.q),
                "temperature": T[index[name], 0],
                "stress": stress[name],
            }
            for name in self._cells
        }

    def _points(self, name: str, q: Array) -> Array:
        return q[self._system.layout.node_dofs[name][:, None] + np.arange(3)]

    def _stresses(self, motion: Any, coef: Coefficients) -> dict[str, Array]:
        """(n_c,) [Pa]  mean over each cell."""
        from mechanics.continuum import von_mises

        y = self._system.unknowns(motion.q, motion.lam)
        found: dict[str, Array] = {}
        for term, c in zip(self._system.terms, coef, strict=True):
            if hasattr(term, "stresses"):
                share = term.volumes / term.volumes.sum(axis=1, keepdims=True)
                values = np.sum(share * von_mises(term.stresses(y, c)), axis=1)
                names = np.array(term.names)
                found |= {name: values[names == name] for name in dict.fromkeys(term.names)}
        return found


def _triads(r_y: Array, r_z: Array) -> Array:
    e2 = r_y / np.linalg.norm(r_y, axis=1, keepdims=True)
    e1 = np.cross(e2, r_z)
    e1 /= np.linalg.norm(e1, axis=1, keepdims=True)
    return np.stack([e1, e2, np.cross(e1, e2)], axis=1)
