"""Mass that follows the temperature, an option.

In a Lagrangian description mass stays where it is, whatever the temperature; this is the default.
Hua et al. (2026) let the density in the mass matrix fall with the temperature, M(T), without
letting the volume grow: as an option, the mass of each element is multiplied by the ratio of the
densities at its mean temperature and in the reference.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mechanics.description import Flexible
from mechanics.layout import Layout
from meshes.materials import Material

Array = NDArray[np.float64]


class Share(NamedTuple):
    """Elements (n,) of one material, and the rows (n, k) of the temperatures of their nodes."""

    material: Material
    elements: NDArray[np.intp]
    rows: NDArray[np.intp]


class DensityFactors:
    """Factors of the mass of the elements of a term: ``factors(T)``.

    Bodies without a temperature, and materials without a density law, keep the factor 1.
    """

    def __init__(self, term: Any, layout: Layout):
        self._count = len(term.names)
        self._shares = []
        for body in dict.fromkeys(term.names):
            part = layout.bodies[body]
            if isinstance(part, Flexible) and part.material.density_law is not None:
                mine = np.flatnonzero(np.asarray(term.names) == body)
                rows = np.stack([_rows(term.dofs[e], body, layout) for e in mine])
                self._shares.append(Share(part.material, mine, rows))

    def factors(self, T: Array) -> Array:
        """(n_e,) factors at section temperatures T (m, 3), of the mean over the nodes."""
        found = np.ones(self._count)
        for material, elements, rows in self._shares:
            found[elements] = material.density_factor(T[rows, 0].mean(axis=1))
        return found


def _rows(dofs: NDArray[np.intp], body: str, layout: Layout) -> NDArray[np.intp]:
    """Temperature rows of the nodes of an element with these coordinates."""
    first = layout.node_dofs[body][0]
    nodes = np.unique((dofs[dofs >= 0] - first) // layout.kinds[body])
    return layout.point_index[body][nodes]
