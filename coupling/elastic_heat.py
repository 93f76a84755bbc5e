"""Heat that deformation releases: dq = -T alpha dsigma per volume (Gough 1805, Joule 1859).

Of beams and cables, whose only stress is sigma = N/A - M2 y/I2 - M3 z/I3 along the axis; Boley &
Weiner 1960, eq. 1.12.24, for uniaxial stress. Stretched metal cools, and warms when let go.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from coupling.descriptions import line_bodies, line_of
from coupling.observables import resultants
from coupling.scene import Scene
from coupling.transfer import Transfer, section_coordinates
from mechanics.system import System
from meshes.materials import Material
from thermal.description import Place

Array = NDArray[np.float64]
Indices = NDArray[np.intp]


class _Body(NamedTuple):
    """Temperatures of a body, and how its resultants make stress there.

    nodes : (k,) intp
    volumes : (k,) float [m^3]
    middles : (n_e,) float [m]  of the elements, along the axis; length : of the body
    along, factors : (k,) [m], (3, k) [1/m^2], [1/m^3]  of N, M2, M3
    """

    name: str
    nodes: Indices
    volumes: Array
    middles: Array
    length: float
    along: Array
    factors: Array
    material: Material

    def stress(self, found: Array) -> Array:
        """(k,) [Pa] from resultants (n_e, 6)."""
        columns = (self._there(found[:, i]) for i in (0, 4, 5))
        return sum(f * c for f, c in zip(self.factors, columns, strict=True))

    def _there(self, values: Array) -> Array:
        """(k,) from values at the middles: straight between, and on to the ends."""
        at = np.concatenate([[0.0], self.middles, [self.length]])
        if len(values) == 1:
            return np.full(len(self.along), values[0])
        ends = [
            values[i] + (values[j] - values[i]) * (x - self.middles[i])
            / (self.middles[j] - self.middles[i])
            for i, j, x in ((0, 1, 0.0), (-1, -2, self.length))
        ]  # fmt: skip
        return np.interp(self.along, at, [ends[0], *values, ends[1]])


class ElasticHeat:
    """Heat (n,) [J] of a window from the motions at its ends."""

    def __init__(self, scene: Scene, system: System, heat_solver: Any, reading: Transfer) -> None:
        assert scene.thermal is not None and scene.thermal.elastic is not None
        self._system, self._reading, self._n = system, reading, len(heat_solver.x)
        self._bodies = [_body(scene, heat_solver, name) for name in scene.thermal.elastic.bodies]

    def __call__(self, before: Any, after: Any, T0: Array, T1: Array) -> Array:
        """Heat that the temperatures receive; ``T0``, ``T1`` (n,) [K] at both ends."""
        first, last = self._resultants(before, T0), self._resultants(after, T1)
        heat, T = np.zeros(self._n), 0.5 * (T0 + T1)
        for body in self._bodies:
            change = body.stress(last[body.name]) - body.stress(first[body.name])
            at = T[body.nodes]
            heat[body.nodes] -= at * body.material.expansion(at) * change * body.volumes
        return heat

    def _resultants(self, state: Any, T: Array) -> dict[str, Array]:
        coef = self._system.coefficients(self._reading.read(T))
        return resultants(self._system, state.motion, coef)


def _body(scene: Scene, heat_solver: Any, name: str) -> _Body:
    if not hasattr(heat_solver, "space"):
        raise ValueError(
            "thermal.elastic: this thermal solver does not say which volume a temperature has; "
            "use line, hermite, wall, solid or lumped"
        )
    assert scene.thermal is not None
    if (scene.thermal.solver, scene.thermal.order) == ("solid", 2):
        raise ValueError(
            "thermal.elastic: corners of quadratic cells in 3D have negative volumes; use order = 1"
        )
    table = line_bodies(scene)[name]
    points, axes, section, material = line_of(scene, name, table)
    mean = heat_solver.space.place(Place(name))
    s, y, z = section_coordinates(heat_solver.x[mean.nodes], points, axes)
    lengths = np.linalg.norm(np.diff(points, axis=0), axis=1)
    ends = np.concatenate([[0.0], np.cumsum(lengths)])
    factors = np.stack(
        [
            np.full(len(s), 1.0 / section.area),
            -y / section.second_moment_2,
            -z / section.second_moment_3,
        ]
    )
    if table.kind == "cable":  # its moment has no direction
        factors[1:] = 0.0
    volumes = mean.weights * section.area * ends[-1]
    middles = 0.5 * (ends[:-1] + ends[1:])
    return _Body(name, mean.nodes, volumes, middles, ends[-1], s, factors, material)
