"""The integrator, point masses, and beams that move far."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from coupling.verify.models import clamp, elastic, model, straight
from coupling.verify.motion import fixed, run
from coupling.verify.registry import Check, problem
from mechanics.description import (
    Force,
    Guide,
    Load,
    Moment,
    Revolute,
    Site,
)
from mechanics.dynamics import Control
from mechanics.schemes import Scheme
from meshes.sections import general, rectangle

Array = NDArray[np.float64]
GRAVITY = (0.0, -9.81, 0.0)
PLANE = np.array([[0.0, 0.0, 1.0]])


@problem(
    "dynamics", "spectral radius of HHT at infinity", "ρ = (1 + α)/(1 − α), Hilber et al. 1977"
)
def spectral_radius() -> list[Check]:
    return [
        Check(f"α = {alpha:.4g}", _radius(alpha), (1 + alpha) / (1 - alpha), 1e-3)
        for alpha in (-0.1, -1 / 3)
    ]


def _radius(alpha: float) -> float:
    """From the decay of an axial mode of a cable whose period is a 1e4th of the step.

    At infinity the radius is a double root: x'' - 2 rho x' + rho^2 x = 0 for the sequence.
    """
    cable = straight(1.0, 1, rectangle(0.01, 0.01), elastic(1e15, 0.0, 1000.0), "cable")
    hold = Guide("hold", Site("beam", 0), np.eye(3))
    push = Force("kick", Site("beam", 1), np.array([1.0, 0, 0]), lambda t: 1e-3 * float(t <= 0.0))
    x = run(model(cable, [hold], [push]), 0.2, fixed(1e-2, alpha, 1e-15)).v[4:, -6]
    _, minus_square = np.linalg.lstsq(np.column_stack([x[1:-1], x[:-2]]), x[2:], rcond=None)[0]
    return float(np.sqrt(-minus_square))


@problem("dynamics", "spin-up of a flexible beam", "Simo & Vu-Quoc 1986")
def spin_up() -> list[Check]:
    EA, GA, EI = 2.8e7, 1e7, 1.4e4
    nu = 0.0
    section = general(1.0, EI / EA, EI / EA, 1e-3, 2 * GA / EA, 2 * GA / EA)
    beam = straight(10.0, 8, section, elastic(EA, nu, 1.2))
    hinge = Revolute("hub", Site("beam", 0), Site(None), np.array([0, 0, 1.0]), _spin_up_angle)
    path = run(model(beam, [hinge]), 20.0, Control(1e-4, 0.02, 1e-6))
    late = path.t > 16.0
    tip = path.q[late][:, -12:-9]
    stretch = np.linalg.norm(tip, axis=1).mean() - 10.0
    bend = [_transverse(t, x) for t, x in zip(path.t, path.q[:, -12:-10], strict=True)]
    return [
        Check("steady extension", float(stretch), 5.1432e-4, 0.01, "m"),
        Check("largest lag of the tip", float(-min(bend)), 0.573, 0.02, "m"),
    ]


def _spin_up_angle(t: float) -> float:
    if t >= 15.0:
        return 6.0 * t - 45.0
    w = 2.0 * np.pi / 15.0
    return 0.4 * (0.5 * t * t + (np.cos(w * t) - 1.0) / w**2)


def _transverse(t: float, x: Array) -> float:
    """Deviation of the tip from the rotating axis, across it."""
    a = _spin_up_angle(t)
    return float(-np.sin(a) * x[0] + np.cos(a) * x[1])


@problem("dynamics", "flying spaghetti", "Simo & Vu-Quoc 1986; momentum and energy exact")
def flying_spaghetti() -> list[Check]:
    EA, EI = 1e4, 500.0
    section = general(1.0, EI / EA, EI / EA, 1e-1, 2.0, 2.0)
    beam = straight(10.0, 8, section, elastic(EA, 0.0, 1.0), direction=(-0.6, 0.8, 0.0))
    start = np.array([6.0, 0.0, 0.0])
    beam = replace(beam, points=beam.points + start)

    def on(t: float) -> float:
        return float(t <= 2.5)

    loads: list[Load] = [
        Force("push", Site("beam", 0), np.array([1.0, 0, 0]), lambda t: 8.0 * on(t)),
        Moment("turn", Site("beam", 0), np.array([0, 0, -1.0]), lambda t: 80.0 * on(t)),
    ]
    made = model(beam, (), loads)
    path = run(made, 5.0, Control(1e-4, 0.01, 1e-6, Scheme(alpha=-0.02)), windows=2)
    unit = np.zeros((made.system.n, 2))
    unit[0::12, 0], unit[1::12, 1] = 1.0, 1.0
    momentum = path.v[-1] @ (made.system.mass @ unit)
    stored = path.ledger[:, 0] + path.ledger[:, 1]
    after = stored[path.t > 2.51]
    return [
        Check("momentum along x", momentum[0], 20.0, 1e-3, "kg m/s"),
        Check("momentum along y", momentum[1], 0.0, 1e-6, "kg m/s", True),
        Check("energy lost after 2.5 s", 1.0 - after[-1] / after[0], 0.0, 1e-2, "", True),
    ]


@problem("dynamics", "cantilever released, energy ledger closes", "exact identity of the scheme")
def released_cantilever() -> list[Check]:
    tip = Site("beam", 8)
    push = Force("pull", tip, np.array([0, 1.0, 0]), lambda t: 50.0 * float(t <= 0.1))
    beam = straight(1.0, 8, rectangle(0.01, 0.01), elastic(70e9, 0.3, 2700.0))
    control = Control(1e-4, 1e-3, 1e-9, Scheme(newton_tolerance=1e-13))
    path = run(model(beam, [clamp()], [push]), 0.3, control)
    largest = np.abs(path.ledger).max()
    return [Check("defect / largest term", path.ledger[-1, -1] / largest, 0.0, 1e-6, "", True)]
