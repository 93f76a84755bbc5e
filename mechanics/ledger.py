"""Where the mechanical energy went, step by step.

Works are trapezoidal: the mean of the force at both ends of a step times the increment of its
coordinates. For Newmark's update the change of kinetic energy is exactly

    dK = -dq.(G0 + G1)/2 + dq.M(a0 + a1)/2 + dq.(G0 + G1)/2
         + (gamma - 1/2) dq.M da - h^2 (beta - gamma/2) da.M((a0 + a1)/2 + (gamma - 1/2) da)

with G all forces but inertia. HHT-alpha makes M a1 = -(1 + alpha) G1 + alpha G0, so all but the
first term are the scheme's own; they are computed from the forces by that relation, while dK is
computed from the velocities. What remains is the ``defect``, which measures the convergence of
Newton and round-off. What the forces do by the trapezoidal rule beyond the change of their
potentials and the works listed is numerical as well. (Krenk & Hogsberg 2005 give the linear case.)
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mechanics.hht import Motion, Scheme
from mechanics.system import Coefficients, System

Array = NDArray[np.float64]

TERMS = (
    "kinetic", "strain", "contact_elastic",
    "work_loads", "work_drive", "work_thermal",
    "friction", "hysteresis", "damping", "numerical", "defect",
)  # fmt: skip
"""Stored energies, works done on the system, losses (positive), and what is unexplained [J]."""


class Balance(NamedTuple):
    """What the trapezoidal works need to know of one instant.

    kinetic, strain, contact_elastic : float [J]
    damping_power : float [W]  lost in structural damping
    heating_power : float [W]  done by damping stresses on the changing free strains
    external, drive : (n,) float  generalised forces of the loads and of driven constraints
    relative : (n_j, 3) float  planar coordinates of the clearance joints [m, m, rad]
    losses : (n_j, 2, 3) float  dissipative normal force and friction, conjugate to ``relative``
    """

    kinetic: float
    strain: float
    contact_elastic: float
    damping_power: float
    heating_power: float
    external: Array
    drive: Array
    relative: Array
    losses: Array

    @property
    def stored(self) -> float:
        """Strain energy and elastic energy of the contacts [J]."""
        return self.strain + self.contact_elastic

    @property
    def row(self) -> Array:
        """Row of ``TERMS`` with the stored energies only [J]."""
        row = np.zeros(len(TERMS))
        row[:3] = self.kinetic, self.strain, self.contact_elastic
        return row


def balance(system: System, motion: Motion, coef: Coefficients) -> Balance:
    """Evaluate what the ledger needs at ``motion``."""
    q, v, t = motion.q, motion.v, motion.t
    strain, contact_elastic = system.energy(q, coef)
    driven = np.where(system.constraints.driven, motion.lam, 0.0)
    relative, losses = _relative(system, motion, coef)
    return Balance(
        0.5 * float(v @ (system.mass @ v)), strain, contact_elastic,
        *system.damping(q, v, coef), system.external(q, t),
        system.constraint_force(q, t, driven), relative, losses,
    )  # fmt: skip


def _relative(system: System, motion: Motion, coef: Coefficients) -> tuple[Array, Array]:
    if system.contact is None:
        return np.zeros((0, 3)), np.zeros((0, 2, 3))
    arguments = motion.q, motion.v, coef[-1], motion.approach
    response, losses = system.contact.losses(*arguments)
    return response[:, :3], losses


def work_of_heating(
    system: System, m0: Motion, m1: Motion, b0: Balance, b1: Balance,
    c0: Coefficients, c1: Coefficients,
) -> float:  # fmt: skip
    """Energy [J] that a change of coefficients brings, mean over both ends of a step."""
    if c0 is c1:
        return 0.0
    first = sum(system.energy(m0.q, c1)) - b0.stored
    return 0.5 * (first + b1.stored - sum(system.energy(m1.q, c0)))


def contact_losses(b0: Balance, b1: Balance) -> Array:
    """(n_j, 2) [J] lost in each joint over a step by normal dissipation and by friction."""
    turn = b1.relative - b0.relative
    turn[:, 2] = (turn[:, 2] + np.pi) % (2.0 * np.pi) - np.pi
    return -0.5 * np.einsum("jkc,jc->jk", b0.losses + b1.losses, turn)


def entries(
    system: System,
    scheme: Scheme,
    m0: Motion,
    m1: Motion,
    b0: Balance,
    b1: Balance,
    heating: float,
) -> Array:
    """Row of ``TERMS``: stored energies at the end, works and losses of the step [J]."""
    dq, h = m1.q - m0.q, m1.t - m0.t
    loads = 0.5 * float(dq @ (b0.external + b1.external))
    drive = -0.5 * float(dq @ (b0.drive + b1.drive))
    hysteresis, friction = contact_losses(b0, b1).sum(axis=0)
    damping = 0.5 * h * (b0.damping_power + b1.damping_power)
    heating -= 0.5 * h * (b0.heating_power + b1.heating_power)
    known = loads + drive + heating - hysteresis - friction - damping
    stored = b1.stored - b0.stored
    by_forces = -0.5 * float(dq @ (m0.force + m1.force))
    numerical = (known - stored) - by_forces - _scheme_work(system, scheme, m0, m1)
    kinetic = b1.kinetic - b0.kinetic
    defect = kinetic + stored - (known - numerical)
    return np.array([
        b1.kinetic, b1.strain, b1.contact_elastic, loads, drive, heating,
        friction, hysteresis, damping, numerical, defect,
    ])  # fmt: skip


def _scheme_work(system: System, scheme: Scheme, m0: Motion, m1: Motion) -> float:
    """Energy that HHT-alpha itself adds over a step (negative: numerical damping) [J]."""
    h, alpha = m1.t - m0.t, scheme.alpha
    dq, da, mean = m1.q - m0.q, m1.a - m0.a, 0.5 * (m0.a + m1.a)
    excess = scheme.gamma - 0.5
    dissipated = -0.5 * alpha * float(dq @ (m1.force - m0.force_before))
    inertia = system.mass @ da
    shift = float(inertia @ (excess * dq))
    drift = h * h * (scheme.beta - 0.5 * scheme.gamma)
    return dissipated + shift - drift * float(inertia @ (mean + excess * da))


def accumulate(ledger: Array, row: Array) -> Array:
    """Stored energies are replaced, works and losses add up."""
    total = ledger + row
    total[:3] = row[:3]
    return total
