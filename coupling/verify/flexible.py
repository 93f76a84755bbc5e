"""Flexible bodies that turn and fly: steady states in turning frames, invariants of free flight."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import quad
from scipy.linalg import eig, null_space
from scipy.optimize import brentq

from coupling.verify.mechanisms import ALPHA, Steps, halved, mechanism, stepped
from coupling.verify.models import Model, clamp, elastic, model, straight
from coupling.verify.registry import Check, Convergence, Result, problem
from mechanics.description import Force, Guide, Load, Moment, Site
from mechanics.schemes import Scheme
from mechanics.system import Factors
from meshes.sections import general

Array = NDArray[np.float64]


# -- steadily turning bodies -------------------------------------------------------------------


class Turning(NamedTuple):
    """Steady state in a frame turning about z: y : (n + m,), K : (n + m, n + m) tangent, with
    the centrifugal part; M : (n, n); W : (n, n) turns vectors by 90 degrees in the plane
    """

    y: Array
    K: Array
    M: Array
    W: Array


def _steady(made: Model, speed: float) -> Turning:
    """Equilibrium of f(p) - speed^2 M P p + Phi_p^T lambda = 0 by Newton's method.

    With q = R(t) p, R a turn of every vector about z, which commutes with the mass matrix, and
    objective forces, M q'' + f(q) = 0 becomes M p'' + 2 speed M W p' - speed^2 M P p + f(p) = 0,
    where P leaves the components in the plane.
    """
    system, n = made.system, made.system.n
    M = np.asarray(system.mass.toarray(), float)
    plane = np.tile([1.0, 1.0, 0.0], n // 3)
    quarter = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    W = np.asarray(np.kron(np.eye(n // 3), quarter), np.float64)
    outward = speed**2 * M * plane
    y, rest = system.unknowns(system.layout.q0), np.zeros(n + system.m)
    for _ in range(30):
        data = system.matrix(y, rest, 0.0, made.coef, Factors(0.0, 1.0, 0.0))
        K = system.pattern.matrix(data).toarray()
        K[:n, :n] -= outward
        lack = system.residual(y, rest, 0.0, made.coef)
        lack[:n] -= outward @ y[:n]
        change = np.linalg.solve(K, -lack)
        y = y + change
        if np.abs(change[:n]).max() < 1e-11:
            return Turning(y, K, M, W)
    raise RuntimeError("no steady state found")


def _rates(state: Turning, speed: float) -> tuple[Array, Array]:
    """Angular frequencies (k,) [rad/s], growing, and modes (n, k) about a steady state."""
    n = len(state.M)
    free = null_space(state.K[n:, :n])
    M, C, K = (free.T @ A @ free for A in (state.M, 2 * speed * state.M @ state.W, state.K[:n, :n]))
    zero, one = np.zeros_like(M), np.eye(len(M))
    values, vectors = eig(np.block([[zero, one], [-K, -C]]), np.block([[one, zero], [zero, M]]))
    order = [i for i in np.argsort(values.imag) if values[i].imag > 0.0]
    return values.imag[order], free @ vectors[: len(M), order]


def _blade(elements: int) -> Model:
    """Unit length, EI and mass per length; 3000 radii of gyration long, stiff in torsion."""
    section = general(1.0, 1e-7, 1e-7, 1e-6)
    return model(straight(1.0, elements, section, elastic(1e7)), [clamp()])


def _rotating(elements: int, speed: float) -> tuple[Array, Array]:
    """Frequencies of flapping (across the plane) and of lagging (in it)."""
    made = _blade(elements)
    rates, modes = _rates(_steady(made, speed), speed)
    tip = np.abs(modes[made.system.layout.node_dofs["beam"][-1] + np.arange(3)])
    flaps = tip[2] > 0.5 * np.abs(modes).max(axis=0) / elements**2
    return rates[flaps & (tip[2] > tip[1])], rates[tip[1] > tip[2]]


@problem("flexible", "rotating cantilever", "Wright et al. 1982; γ = Ω√(ρAL⁴/EI) = 12")
def rotating_cantilever() -> list[Result]:
    sizes, flaps = (4, 8, 16), (13.17015, 37.60311, 79.61448)
    found = [_rotating(n, 12.0) for n in sizes]
    flap, lag = found[-1]
    still = _rotating(16, 0.0)[0]
    errors = [[abs(f[0][k] / ref - 1.0) for f in found] for k, ref in enumerate(flaps)]
    return [
        *(Check(f"flap {k + 1}", flap[k], ref, 1e-4) for k, ref in enumerate(flaps)),
        Check("lead-lag 1", lag[0], 5.42705, 1e-4),
        Check("flap 1 at rest", still[0], 1.8751041**2, 1e-4),
        *(Convergence(f"flap {k + 1}", sizes, errors[k], 4.0, 0.5) for k in (1, 2)),
    ]


@problem("flexible", "steady extension of a turning beam", "first integral of the rod")
def extension() -> list[Result]:
    """S = EA (x'^2 - 1)/2 (Green's strain); (S x')' + m speed^2 x = 0, S(L) = 0.

    Nodes of cubics are exact to sixth order. In a slender beam the quadratic part of the axial
    strain is soft (``mechanics.beam3243.MEMBRANE``); coarse meshes pay for it here.
    """
    EA, m, L, speed = 2.8e7, 1.2, 10.0, 100.0

    def shortness(end: float) -> float:
        """Reference length that reaches to ``end``, less L, from the first integral

        3/8 x'^4 - x'^2/4 + m speed^2 x^2/(2 EA) = 1/8 + m speed^2 end^2/(2 EA).
        """

        def slope(x: float) -> float:
            c = 0.125 + m * speed**2 * (end**2 - x**2) / (2.0 * EA)
            return float(np.sqrt((1.0 + np.sqrt(1.0 + 24.0 * c)) / 3.0))

        return quad(lambda x: 1.0 / slope(x), 0.0, end, epsabs=1e-13)[0] - L

    exact = brentq(shortness, L, 1.5 * L, xtol=1e-14) - L

    def tip(elements: int, second_moment: float) -> float:
        section = general(1.0, second_moment, second_moment, 1e-3, 2e7 / EA, 2e7 / EA)
        made = model(straight(L, elements, section, elastic(EA, 0.0, m)), [clamp()])
        return made.position(_steady(made, speed).y, "beam", elements)[0] - L

    sizes = (1, 2, 4)
    stocky = [abs(tip(n, 10.0) / exact - 1.0) for n in sizes]
    slender = [abs(tip(n, 5e-4) / exact - 1.0) for n in (4, 8, 16)]
    return [
        Check("slender, 16 elements: error of the stretch", slender[-1], 0.0, 1e-6, "", True),
        Check("slender, 4 elements: error of the stretch", slender[0], 0.0, 3e-3, "", True),
        Convergence("stocky", sizes, stocky, 6.0, 0.5),
    ]


# -- free flight -------------------------------------------------------------------------------


def _spaghetti() -> Model:
    """Force and moment at the lower end until 2.5 s.

    The rotary inertia follows from the section (.05 kg m, published: 10); momenta do not depend
    on it.
    """
    EA, EI = 1e4, 500.0
    section = general(1.0, EI / EA, EI / EA, 1e-1, 2.0, 2.0)
    beam = straight(10.0, 8, section, elastic(EA, 0.0, 1.0), direction=(-0.6, 0.8, 0.0))
    beam = replace(beam, points=beam.points + np.array([6.0, 0.0, 0.0]))
    loads: list[Load] = [
        Force("push", Site("beam", 0), np.array([8.0, 0, 0]), lambda t: float(t <= 2.5 + 1e-9)),
        Moment("turn", Site("beam", 0), np.array([0, 0, -80.0]), lambda t: float(t <= 2.5 + 1e-9)),
    ]
    return mechanism([beam], (), loads)


class Flight(NamedTuple):
    """Of each step: centre (k, 3) [m], momentum (k, 3), angular momentum (k, 3)"""

    centre: Array
    momentum: Array
    spin: Array


def _flight(made: Model, p: Steps) -> Flight:
    """Sums over all vectors: the mass matrix couples them as if they were points in space."""
    rigid = np.zeros((made.system.n, 3))
    for nodes in made.system.layout.node_dofs.values():
        for i in range(3):
            rigid[nodes + i, i] = 1.0
    weight = made.system.mass @ rigid
    mass = float(rigid[:, 0] @ weight[:, 0])
    impulse = (made.system.mass @ p.v.T).T.reshape(len(p.t), -1, 3)
    spin = np.cross(p.q.reshape(len(p.t), -1, 3), impulse).sum(axis=1)
    return Flight(p.q @ weight / mass, p.v @ weight, spin)


@problem("flexible", "flying spaghetti: centre and momenta", "Simo & Vu-Quoc 1986; exact")
def flying_spaghetti() -> list[Result]:
    made, steps = _spaghetti(), halved(4e-3, 4)
    jumps, drifts = [], []
    for h in steps:
        p = stepped(made, 5.0, h, ALPHA)
        found, after = _flight(made, p), p.t > 2.6
        jumps.append(float(np.abs(found.momentum[-1] - [20.0, 0.0, 0.0]).max()))
        spin = found.spin[after, 2]
        drifts.append(float(np.ptp(spin) / abs(spin[0])))
    kept = float(np.ptp(found.momentum[after], axis=0).max())
    return [
        Check("x of the centre at 5 s", found.centre[-1, 0], 10.5, 2e-3, "m"),
        Check("y of the centre at 5 s", found.centre[-1, 1], 4.0, 1e-9, "m"),
        Check("momentum along x at 5 s", found.momentum[-1, 0], 20.0, 2e-3, "kg m/s"),
        Check("change of momentum in free flight", kept, 0.0, 1e-8, "kg m/s", True),
        # the load ends at a step that sees all of it at its end
        Convergence("momentum, from the jump of the load", steps, jumps, 1.0, 0.1, "s"),
        Convergence("drift of angular momentum", steps, drifts, 2.0, 0.3, "s"),
    ]


# -- flexible pendulum -------------------------------------------------------------------------


@problem("flexible", "very flexible pendulum, beam", "Green's axial strain; Biot's: -0.3106 m")
def pendulum() -> list[Result]:
    section = general(0.0018, 1.215e-8, 1.215e-8, 1e-8)
    beam = straight(1.2, 32, section, elastic(0.7e6, 0.3, 5540.0))
    pins = (
        Guide("pin", Site("beam", 0), np.eye(3)),
        Guide(
            "roll", Site("beam", 0, offset=np.array([0.0, 0.0, 0.01])), np.array([[0.0, 1.0, 0.0]])
        ),
    )
    made = model(beam, pins, gravity=(0.0, -9.81, 0.0))
    p = stepped(made, 1.0, 5e-4, Scheme("hht", alpha=-0.02, newton_tolerance=1e-11))
    return [Check("tip y(1 s)", made.position(p.q[-1], "beam", 32)[1], -0.1129, 0.005, "m")]
