"""Trigonometric interpolation over the circumference of a tube.

Through N equispaced wall temperatures (N even) goes one combination of the harmonics 0 to
N/2 - 1 and cos(N/2 phi). Its cardinal functions C_k, one at point k and zero at the others, are
the basis of lines over the circumference (Fornberg 1996, ch. 2 and app. F).
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Cardinal(NamedTuple):
    """Cardinal functions at M angles.

    values : (M, N) float  C_k at the angles
    slopes : (M, N) float [1/rad]  dC_k/dphi there
    """

    values: Array
    slopes: Array


def cardinal(n: int) -> Cardinal:
    """Cardinal functions of ``n`` wall points at 2n angles, which integrate their products."""
    return cardinal_at(n, np.pi / n * np.arange(2.0 * n))


def cardinal_at(n: int, phi: Array) -> Cardinal:
    """Cardinal functions of ``n`` wall points at the angles ``phi`` (M,) [rad]."""
    harmonics = _harmonics(n)
    angle = phi[:, None, None] - 2.0 * np.pi / n * np.arange(n)[None, :, None]
    weight = np.where(harmonics == n // 2, 1.0, 2.0)
    # cos(N/2 (phi - phi_k)) = cos(N/2 phi) cos(N/2 phi_k): the sine vanishes at the points
    last = np.cos(0.5 * n * phi)[:, None] * (-1.0) ** np.arange(n)
    last_slope = -0.5 * n * np.sin(0.5 * n * phi)[:, None] * (-1.0) ** np.arange(n)
    low, w = harmonics[:-1], weight[:-1]
    values = (1.0 + (w * np.cos(low * angle)).sum(2) + last) / n
    slopes = (-(w * low * np.sin(low * angle)).sum(2) + last_slope) / n
    return Cardinal(values, slopes)


def _harmonics(n: int) -> Array:
    return np.arange(1.0, n // 2 + 1)


def half_cosine_loads(n: int, phase: Array) -> Array:
    """Integrals over the circumference of C_k max(0, cos(phi - phase)), exact.

    From the Fourier series of the half-wave cosine, 1/pi + cos(x)/2 + 2/pi sum over even m of
    (-1)^(m/2 + 1) cos(m x)/(m^2 - 1).

    Parameters
    ----------
    phase : (...,) float [rad]

    Returns
    -------
    (..., n) float  of sum 2, the width seen by parallel rays at unit radius
    """
    m = _harmonics(n)
    even = np.where(m % 2 == 0, m, 2.0)
    a = np.where(m % 2 == 0, 2.0 / np.pi * (-1.0) ** (even / 2 + 1) / (even**2 - 1.0), 0.0)
    a[0] = 0.5
    weight = np.where(m == n // 2, 1.0, 2.0)
    points = 2.0 * np.pi / n * np.arange(n)
    angle = m * (points[:, None] - np.asarray(phase, dtype=float)[..., None, None])
    return (2.0 + np.pi * (weight * a * np.cos(angle)).sum(-1)) / n
