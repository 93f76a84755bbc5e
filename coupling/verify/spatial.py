"""Rigid bodies that turn in space: free, on a point, on universal joints, geared; sliding arms.

Part of the area "multibody".
"""

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.special import ellipj

from coupling.verify import mechanisms as m
from coupling.verify.mechanisms import ALPHA, mechanism, stepped
from coupling.verify.models import Model, bent, elastic, model, straight
from coupling.verify.registry import Check, Convergence, Result, problem
from mechanics.description import (
    Distance,
    Force,
    Gear,
    Guide,
    Joint,
    Revolute,
    RigidBody,
    Site,
    Spherical,
    Torque,
    TorsionSpring,
    Universal,
)
from meshes.sections import general

Array = NDArray[np.float64]

X, Y, Z = np.eye(3)


# -- free body ---------------------------------------------------------------------------------

MOMENTS = np.array([1.0, 2.0, 2.5])
SPIN = np.array([0.3, 0.0, 2.0])
"""Principal moments [kg m^2] and initial angular velocity [rad/s] along e1, e2, e3."""


def _euler(t: Array) -> Array:
    """(k, 3) [rad/s] angular velocity in the body; Landau & Lifshitz, Mechanics, sec. 37."""
    I1, I2, I3 = MOMENTS
    twice, square = MOMENTS @ SPIN**2, MOMENTS**2 @ SPIN**2
    high, low = twice * I3 - square, square - twice * I1
    tau = t * np.sqrt((I3 - I2) * low / (I1 * I2 * I3))
    sn, cn, dn, _ = ellipj(tau, (I2 - I1) * high / ((I3 - I2) * low))
    sizes = np.sqrt([high / (I1 * (I3 - I1)), high / (I2 * (I3 - I2)), low / (I3 * (I3 - I1))])
    return np.stack([cn, sn, dn], axis=1) * sizes


def _free() -> Model:
    axes = np.array([[0.6, 0.8, 0.0], [-0.8, 0.6, 0.0], [0.0, 0.0, 1.0]])
    inertia = axes.T @ np.diag(MOMENTS) @ axes
    velocity = np.array([1.0, -2.0, 0.5])
    body = RigidBody("body", np.zeros(3), 3.0, inertia, axes, velocity, SPIN @ axes)
    return mechanism([body], ())


@problem("multibody", "free rigid body", "Euler; Jacobi's elliptic functions")
def free_body() -> list[Result]:
    made, steps, end = _free(), m.halved(0.02, 4), 10.0
    spins, energies, momenta = [], [], []
    for h in steps:
        p = stepped(made, end, h)
        w, e = m.spin(made, p.q, p.v, "body"), m.directors(made, p.q, "body")
        L = np.einsum("kj,kji->ki", w * MOMENTS, e)
        start = SPIN * MOMENTS @ m.directors(made, made.system.layout.q0[None], "body")[0]
        spins.append(float(np.abs(w - _euler(p.t)).max()))
        energies.append(float(abs(0.5 * MOMENTS @ w[-1] ** 2 - 0.5 * MOMENTS @ SPIN**2)))
        momenta.append(float(np.abs(L - start).max()))
    path = p.q[-1, :3] - np.array([1.0, -2.0, 0.5]) * end
    return [
        Convergence("angular velocity", steps, spins, 2.0, 0.1, "s"),
        Convergence("energy after 10 s", steps, energies, 2.0, 0.2, "s"),
        Convergence("angular momentum in space", steps, momenta, 2.0, 0.2, "s"),
        Check("path of the centre of mass", float(np.abs(path).max()), 0.0, 1e-9, "m", True),
        Check("directors", _skewness(made, p.q), 0.0, 1e-11, "", True),
    ]


def _skewness(made: Model, q: Array) -> float:
    """Largest deviation of the directors from an orthonormal triad."""
    e = m.directors(made, q, "body")
    return float(np.abs(e @ e.swapaxes(1, 2) - np.eye(3)).max())


# -- heavy top ---------------------------------------------------------------------------------

MASS, ARM = 15.0, np.array([0.0, 1.0, 0.0])
INERTIA = np.diag([0.234375, 0.46875, 0.234375])
WHIRL = np.array([0.0, 150.0, -4.61538])
PULL = np.array([0.0, 0.0, -9.81])


def _top_rates(_: float, y: Array) -> Array:
    """Rotation matrix (9) and angular velocity in the body (3)."""
    R, w = y[:9].reshape(3, 3), y[9:]
    about = INERTIA + MASS * (np.eye(3) - np.outer(ARM, ARM))
    moment = MASS * np.cross(ARM, R.T @ PULL) - np.cross(w, about @ w)
    hat = np.cross(w, np.eye(3)).T  # hat @ x = w x x
    return np.concatenate([(R @ hat).ravel(), np.linalg.solve(about, moment)])


@problem("multibody", "heavy top", "Géradin & Cardona 2001; Euler's equations by DOP853")
def heavy_top() -> list[Result]:
    speed = np.cross(WHIRL, ARM)
    top = RigidBody("top", ARM, MASS, INERTIA, velocity=speed, spin=WHIRL)
    made = mechanism(
        [top], [Spherical("point", Site("top", offset=-ARM), Site(None))], gravity=PULL
    )
    start = np.concatenate([np.eye(3).ravel(), WHIRL])
    exact = solve_ivp(_top_rates, (0, 1.0), start, "DOP853", rtol=1e-11, atol=1e-11)
    where = exact.y[:9, -1].reshape(3, 3) @ ARM
    steps = m.halved(1e-3, 4)
    found = [stepped(made, 1.0, h, ALPHA).q[-1, :3] for h in steps]
    published = (0.17334396, 0.64008859, -0.74849079)
    return [
        Convergence("centre of mass at 1 s", steps, m.largest([f - where for f in found]), 2.0,
                    0.1, "s"),
        *(Check(f"{n}(1 s), Euler's equations", w, r, 2e-7, "m")
          for n, w, r in zip("xyz", where, published, strict=True)),
        *(Check(f"{n}(1 s)", f, r, 2e-3, "m")
          for n, f, r in zip("xyz", found[-1], published, strict=True)),
    ]  # fmt: skip


# -- transmissions -----------------------------------------------------------------------------

BEND = np.pi / 6.0


@problem("multibody", "universal joint between shafts at 30 degrees", "tan(out) = tan(in)/cos(30°)")
def universal() -> list[Result]:
    away = np.array([np.cos(BEND), np.sin(BEND), 0.0])
    side = np.array([-np.sin(BEND), np.cos(BEND), 0.0])
    axes = np.stack([away, side, Z])
    bodies = [RigidBody("in", -X, 1.0, np.eye(3)), RigidBody("out", away, 1.0, np.eye(3), axes)]
    joints: list[Joint] = [
        Revolute("drive", Site("in"), Site(None, position=-X), X, lambda t: t),
        Universal("cross", Site("in", offset=X), Site("out", offset=-X), Y, Z),
        Guide("bearing", Site("out"), np.stack([side, Z])),
    ]
    made = mechanism(bodies, joints)
    p = stepped(made, 7.0, 0.01)
    e = m.directors(made, p.q, "out")[:, 1]
    # arms of the cross: y in the first, z in the second shaft; y(t).z(t) = 0
    turned = np.unwrap(np.arctan2(e @ Z, e @ side))
    exact = np.unwrap(np.arctan2(np.sin(p.t), np.cos(BEND) * np.cos(p.t)))
    error = float(np.abs(turned - exact).max())
    return [Check("largest error of the turn", error, 0.0, 1e-9, "rad", True)]


def _wheels() -> list[RigidBody]:
    return [
        RigidBody("small", np.zeros(3), 1.0, 0.2 * np.eye(3)),
        RigidBody("large", 3.0 * X, 4.0, 1.5 * np.eye(3)),
    ]


_HINGES = (
    Revolute("first", Site("small"), Site(None), Z),
    Revolute("second", Site("large"), Site(None, position=3.0 * X), Z),
)


@problem("multibody", "gear with a motor", "constant acceleration T/(J1 + i^2 J2)")
def gear() -> list[Result]:
    joints: list[Joint] = [*_HINGES, Gear("gear", "first", "second", -0.5)]
    motor = Torque("motor", Site("small"), Site(None), Z, lambda t: 10.0)
    made, steps = mechanism(_wheels(), joints, [motor]), m.halved(4e-3, 3)
    turn = 0.5 * 10.0 / (0.2 + 0.25 * 1.5) * 4.0
    paths = [stepped(made, 2.0, h, ALPHA).q for h in steps]
    errors = [float(abs(m.turn(made, q, "small")[-1] - turn)) for q in paths]
    q, coordinate = paths[-1], made.system.layout.joint_dofs["second.turn"]
    return [
        Convergence("turn of the first after 2 s", steps, errors, 2.0, 0.1, "s"),
        Check("turn of the first", m.turn(made, q, "small")[-1], turn, 1e-3, "rad"),
        Check("turn of the second", m.turn(made, q, "large")[-1], -0.5 * turn, 1e-3, "rad"),
        Check("its coordinate", q[-1, coordinate], -0.5 * turn, 1e-3, "rad"),
    ]


@problem("multibody", "wheel on a torsion spring with a damper", "damped oscillator")
def torsion() -> list[Result]:
    k, c, J, start = 3.0, 0.1, 0.2, 1.0
    spring = TorsionSpring("coil", "first", k, c, start)
    made, steps = mechanism(_wheels()[:1], [_HINGES[0], spring]), m.halved(0.02, 3)
    decay, w = c / (2.0 * J), np.sqrt(k / J - (c / (2.0 * J)) ** 2)
    errors = []
    for h in steps:
        p = stepped(made, 8.0, h)
        swing = np.exp(-decay * p.t) * (np.cos(w * p.t) + decay / w * np.sin(w * p.t))
        errors.append(float(np.abs(m.turn(made, p.q, "small") - start * (1.0 - swing)).max()))
    return [Convergence("turn", steps, errors, 2.0, 0.1, "s")]


# -- telescope ---------------------------------------------------------------------------------

OVERHANG, OVERLAP, PLAY, TIP = 2.0, 0.5, 1e-3, 100.0


@problem("multibody", "telescoping arm in its sleeve", "lever; play tilts the arm by 2 c/a")
def telescope() -> list[Result]:
    """The arm, all but rigid, touches the sleeve at its inner end and, .5 m on, at the mouth.

    Both contacts are struts that give way by the play.
    """
    arm = straight(OVERHANG, 8, general(1.0, 1.0, 1.0, 1.0), elastic(1e12))
    inner, mouth = Site("beam", 0), Site("beam", 2)
    above, below = np.array([0.0, 100.0, 0.0]), np.array([OVERLAP, -100.0, 0.0])
    joints: list[Joint] = [
        Distance("inner", inner, Site(None, position=above), lambda s: -PLAY * s),
        Distance("mouth", mouth, Site(None, position=below), lambda s: -PLAY * s),
        Guide("held", inner, np.stack([X, Z])),
        Guide("level", Site("beam", 8), Z[None]),
        Guide("roll", Site("beam", 4, offset=np.array([0.0, 0.1, 0.0])), Z[None]),
    ]
    load = Force("tip", Site("beam", 8), -Y, lambda s: TIP * s)
    made = model(arm, joints, [load])
    found = bent(made, 2)
    names = list(made.system.row_names)
    held = {name: float(abs(found.lam[names.index(name)])) for name in ("inner", "mouth")}
    droop = -made.position(found.q, "beam", 8)[1]
    return [
        Check("force at the mouth", held["mouth"], TIP * OVERHANG / OVERLAP, 1e-4, "N"),
        Check("force at the inner end", held["inner"],
              TIP * (OVERHANG - OVERLAP) / OVERLAP, 1e-4, "N"),
        Check("droop from the play", droop,
              PLAY + 2.0 * PLAY / OVERLAP * (OVERHANG - OVERLAP), 1e-4, "m"),
    ]  # fmt: skip
