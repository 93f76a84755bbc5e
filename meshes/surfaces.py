"""Surfaces made of quadrilaterals, with the parametric derivatives that shell elements need."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Indices = NDArray[np.intp]


@dataclass(frozen=True)
class Surface:
    """Middle surface of a shell.

    Parameters u, v are lengths [m]; an element spans ``sizes`` of them. Derivatives are by u and v,
    continuous from element to element.

    Attributes
    ----------
    points : (n, 3) float [m]
    quads : (n_e, 4) int  corners at (0, 0), (a, 0), (a, b), (0, b)
    sizes : (n_e, 2) float [m]  a, b of each element
    d_u, d_v : (n, 3) float [-]  first derivatives
    d_uv : (n, 3) float [1/m]  mixed derivative
    """

    points: Array
    quads: Indices
    sizes: Array
    d_u: Array
    d_v: Array
    d_uv: Array
