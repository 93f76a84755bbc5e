"""Schemes of time integration by name, and what they demand of the constraints."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mechanics.march import BAUMGARTE, BDF2, EULER, INDEX3, NEWMARK, PROJECTED

Array = NDArray[np.float64]

FORMULATIONS = {"index3": INDEX3, "projected": PROJECTED, "baumgarte": BAUMGARTE}
"""Positions obey the constraints; velocities as well; or violations decay (for comparison)."""
SCHEMES = ("hht", "generalised-alpha", "bdf2", "backward-euler")


@dataclass(frozen=True)
class Scheme:
    """Parameters of the scheme and of its Newton iteration.

    name : in ``SCHEMES``
    alpha : float  of "hht", in [-1/3, 0]; spectral radius at infinity (1 + alpha)/(1 - alpha)
    spectral_radius : float  of "generalised-alpha", in [0, 1], at infinity
    newton_tolerance : float  largest remaining correction, relative to ``System.scale``
    iterations : int  largest number of corrections with one Jacobian
    constraints : in ``FORMULATIONS``
    baumgarte_rate : float | None [1/s]  decay of violations; None: 2/h (Hua et al. 2026, Table 2)
    """

    name: str = "hht"
    alpha: float = -0.1
    spectral_radius: float = 0.8
    newton_tolerance: float = 1e-12
    iterations: int = 12
    constraints: str = "index3"
    baumgarte_rate: float | None = None

    @property
    def kind(self) -> int:
        """Kind in ``mechanics.march``."""
        return {"bdf2": BDF2, "backward-euler": EULER}.get(self.name, NEWMARK)

    @property
    def alphas(self) -> tuple[float, float]:
        """alpha_m, alpha_f. Chung & Hulbert (1993), eqs. 25 and 26."""
        if self.name == "hht":
            return 0.0, -self.alpha
        if self.name == "generalised-alpha":
            rho = self.spectral_radius
            return (2.0 * rho - 1.0) / (rho + 1.0), rho / (rho + 1.0)
        return 0.0, 0.0

    @property
    def beta(self) -> float:
        """Newmark's beta. Hilber, Hughes & Taylor (1977), eq. 16; Chung & Hulbert, eq. 20."""
        alpha_m, alpha_f = self.alphas
        return (1.0 + alpha_f - alpha_m) ** 2 / 4.0

    @property
    def gamma(self) -> float:
        """Newmark's gamma, for second order. Chung & Hulbert (1993), eq. 17."""
        alpha_m, alpha_f = self.alphas
        return 0.5 + alpha_f - alpha_m

    def settings(self, tolerance: float, largest: float, smallest: float) -> Array:
        """(12,) float  settings of ``mechanics.march``."""
        return np.array([
            tolerance, largest, smallest, self.kind, *self.alphas, self.beta, self.gamma,
            self.newton_tolerance, self.iterations, FORMULATIONS[self.constraints],
            self.baumgarte_rate or 0.0,
        ])  # fmt: skip
