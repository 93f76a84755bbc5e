"""Andrews' squeezing mechanism, IFToMM benchmark A03; part of the area "multibody"."""

import numpy as np
from numpy.typing import NDArray

from coupling.verify import mechanisms as m
from coupling.verify.mechanisms import (
    Z,
    at,
    bar,
    coupler,
    ground,
    mechanism,
    plane_body,
    stepped,
    towards,
)
from coupling.verify.models import Model
from coupling.verify.registry import Check, Convergence, Result, problem
from mechanics.description import Joint, Revolute, Site, Spring, Torque

Array = NDArray[np.float64]

_A, _B = np.array([-0.06934, -0.00227]), np.array([-0.03635, 0.03273])
_C = np.array([0.014, 0.072])
_START = {
    "beta": -0.0617138900142764496, "theta": 0.0, "gamma": 0.455279819163070380,
    "phi": 0.222668390165885885, "delta": 0.487364979543842550, "omega": -0.222668390165885885,
    "epsilon": 1.23054744454982120,
}  # fmt: skip
_ANDREWS = (15.8107711952, -15.7563710584, 0.0408222401, -0.534730116, 0.524409966, 1.048080741)


def _squeezer() -> Model:
    """Seven bodies; data of Schiehlen (1990) as in Hairer & Wanner (1996), sec. VII.7.

    Centres of mass of bodies 3, 5 and 7, given by two lengths, turn about fixed points without
    weight: only their distance matters.
    """
    s = _START
    crank = 0.007 * towards(s["beta"])
    meet = crank - 0.028 * towards(s["beta"] + s["theta"])
    five, seven = (
        _A + 0.04 * towards(s["delta"]),
        _A + 0.04 * towards(s["epsilon"] - 0.5 * np.pi),
    )
    c, sine = towards(s["gamma"])
    spring = _B + np.array([0.02 * c + 0.018 * sine, 0.02 * sine - 0.018 * c])
    across = np.array([-sine, c])
    K1 = bar("K1", (0.0, 0.0), crank, 0.04325, 2.194e-6, 0.00092 / 0.007)
    K2 = bar("K2", meet, crank, 0.00365, 4.410e-7, 1.0 - 0.0115 / 0.028)
    heavy3 = _B + 0.01043 * np.array([c, sine]) - 0.01874 * across
    K3 = plane_body("K3", heavy3, 0.02373, 5.255e-6, s["gamma"])
    K4 = bar("K4", five, meet, 0.00706, 5.667e-7, 1.0 - 0.01421 / 0.02)
    heavy5 = _A + np.hypot(0.02308, 0.00916) * towards(s["delta"])
    K5 = plane_body("K5", heavy5, 0.07050, 1.169e-5, s["delta"])
    K6 = bar("K6", seven, meet, 0.00706, 5.667e-7, 1.0 - 0.01421 / 0.02)
    heavy7 = _A + np.hypot(0.01228, 0.00449) * towards(s["epsilon"] - 0.5 * np.pi)
    K7 = plane_body("K7", heavy7, 0.05498, 1.912e-5, s["epsilon"])
    joints: list[Joint] = [
        Revolute("O", at(K1, (0.0, 0.0)), ground((0.0, 0.0)), Z),
        Revolute("B", at(K3, _B), ground(_B), Z),
        Revolute("A5", at(K5, _A), ground(_A), Z),
        Revolute("A7", at(K7, _A), ground(_A), Z),
        *coupler(K2, (at(K3, meet), meet), (at(K1, crank), crank)),
        *coupler(K4, (at(K3, meet), meet), (at(K5, five), five)),
        *coupler(K6, (at(K3, meet), meet), (at(K7, seven), seven)),
        Spring("spring", at(K3, spring), ground(_C), 4530.0, length=0.07785),
    ]
    motor = Torque("motor", Site("K1"), Site(None), Z, lambda t: 0.033)
    return mechanism([K1, K2, K3, K4, K5, K6, K7], joints, [motor])


def _squeezed(made: Model, h: float) -> Array:
    """beta, theta, gamma, phi, delta, epsilon [rad] at .03 s."""
    q = stepped(made, 0.03, h).q
    turn = {name: float(m.turn(made, q, name)[-1]) for name in made.system.layout.bodies}
    return np.array([
        _START["beta"] + turn["K1"], _START["theta"] + turn["K2"] - turn["K1"],
        _START["gamma"] + turn["K3"], _START["phi"] + turn["K4"] - turn["K5"],
        _START["delta"] + turn["K5"], _START["epsilon"] + turn["K7"],
    ])  # fmt: skip


@problem("multibody", "Andrews' squeezer", "IFToMM benchmark A03, Schiehlen 1990")
def squeezer() -> list[Result]:
    made, steps = _squeezer(), m.halved(4e-5, 3)
    found = [_squeezed(made, h) for h in steps]
    errors = m.largest([f - np.array(_ANDREWS) for f in found])
    names = "beta", "theta", "gamma", "phi", "delta", "epsilon"
    return [
        Convergence("largest error of an angle at .03 s", steps, errors, 2.0, 0.2, "s"),
        *(Check(n, f, r, 1e-3, "rad") for n, f, r in zip(names, found[-1], _ANDREWS, strict=True)),
    ]
