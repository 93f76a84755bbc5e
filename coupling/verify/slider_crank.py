"""Slider-cranks with clearance, against ordinary differential equations in fewest coordinates.

A plane loop of hinges would say three things twice, so the crank is free along its axis and the
rod has a ball where its other end is held in the plane.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from coupling.verify import contact_references as references
from coupling.verify import mechanisms as m
from coupling.verify.contact import onsets, pressed
from coupling.verify.contact_references import SliderCrank, Swing
from coupling.verify.mechanisms import at, bar, ground, mechanism, plane_body
from coupling.verify.models import ROOM, Model, elastic, sections
from coupling.verify.motion import Path, run
from coupling.verify.registry import Check, problem
from mechanics.contact_laws import K
from mechanics.description import (
    ClearanceRevolute,
    ClearanceTranslational,
    Cylindrical,
    Joint,
    NormalContact,
    Prismatic,
    Revolute,
    RigidBody,
    Spherical,
)
from mechanics.dynamics import Control

Array = NDArray[np.float64]

FLORES = SliderCrank()
METAL = elastic(references.YOUNG, references.POISSON)
X = np.array([1.0, 0.0, 0.0])
TURN = 2.0 * np.pi / FLORES.speed
ELASTIC = ((1e-4, 0.99999, 0.15), (2e-4, 0.999985, 0.1), (5e-4, 0.99999, 0.15))
"""Clearance [m], restitution of impacts that lose next to nothing, turns of the crank."""
SOURCE = "Flores et al. 2006, 5000 rpm; ODE by DOP853"


def _bodies(slider_inertia: float) -> tuple[RigidBody, RigidBody, RigidBody, list[Joint]]:
    """Crank, rod and slider stretched along x, in their ideal motion; the driven crank."""
    c, w = FLORES.crank, FLORES.speed
    pin, end = (c, 0.0), (c + FLORES.rod, 0.0)
    crank = m.turning(bar("crank", (0.0, 0.0), pin, 0.30, 1e-4), (0.0, 0.0), w)
    rod = bar("rod", pin, end, FLORES.rod_mass, FLORES.rod_inertia)
    rod = m.turning(rod, end, FLORES.rod_angle(0.0)[1])
    slider = plane_body("slider", end, FLORES.slider_mass, slider_inertia)
    drive = Cylindrical(
        "drive", at(crank, (0.0, 0.0)), ground((0.0, 0.0)), m.Z, lambda t: w * t
    )  # fmt: skip
    return crank, rod, slider, [drive]


def _loose_pin(clearance: float, law: NormalContact) -> Model:
    """The rod ends in a pin with play in the bore of the slider."""
    crank, rod, slider, joints = _bodies(1e-4)
    pin, end = (FLORES.crank, 0.0), (FLORES.crank + FLORES.rod, 0.0)
    radius = references.BEARING_RADIUS - clearance
    joints += [
        Spherical("crank pin", at(rod, pin), at(crank, pin)),
        Prismatic("guide", at(slider, end), ground(end), X),
        ClearanceRevolute(
            "pin", at(rod, end), at(slider, end), m.Z, radius, clearance, METAL, METAL, ROOM, law
        ),
    ]  # fmt: skip
    return mechanism([crank, rod, slider], joints)


def _loose_slider(clearance: float, law: NormalContact, size: float = 50e-3) -> Model:
    """The slider has play between two walls, and its own turn."""
    crank, rod, slider, joints = _bodies(FLORES.slider_mass * size**2 / 6.0)
    pin, end = (FLORES.crank, 0.0), (FLORES.crank + FLORES.rod, 0.0)
    joints += [
        Revolute("crank pin", at(rod, pin), at(crank, pin), m.Z),
        Spherical("rod end", at(rod, end), at(slider, end)),
        ClearanceTranslational(
            "guide", at(slider, end), ground(end), X, np.array([0.0, 1.0, 0.0]), size, size,
            clearance, METAL, METAL, ROOM, law,
        ),
    ]  # fmt: skip
    return mechanism([crank, rod, slider], joints)


def _onsets(path: Path) -> Array:
    """Times [s] at which impacts of any contact begin."""
    return np.sort(np.concatenate([onsets(path, k) for k in range(path.approach.shape[1])]))


def _largest(path: Path) -> float:
    """Largest normal force [N] of any contact."""
    return float(max(pressed(path, k).max() for k in range(path.approach.shape[1])))


def _elastic(name: str, made: Model, exact: Swing) -> list[Check]:
    """Impacts, speed of the slider and forces, all of them, where impacts lose next to nothing.

    There is nothing to differ in then but errors of integration; the speed of approach, on which
    losses depend, is that of the onset in the reference, and the largest since in the solver.
    """
    path = run(made, float(exact.t[-1]), Control(1e-9, 1e-5, 1e-15))
    first = made.system.layout.node_dofs["slider"][0]
    times, known = _onsets(path), np.array([one.t for one in exact.impacts])
    late = np.abs(times - known).max() / TURN if len(times) == len(known) else np.inf
    off = np.interp(exact.t, path.t, path.v[:, first]) - exact.velocity
    force = np.column_stack([
        np.interp(exact.t, path.t, pressed(path, k)) for k in range(exact.force.shape[1])
    ])  # fmt: skip
    peak = exact.force.max()
    return [
        Check(f"{name}, impacts", len(times), len(known), 0.0),
        Check("  times of all of them", late, 0.0, 1e-5, "turns", True),
        Check("  speed / largest", np.abs(off).max() / np.abs(exact.velocity).max(), 0.0, 3e-3,
              "", True),
        Check("  largest force", _largest(path), peak, 1e-3, "N"),
        Check("  forces / largest", np.abs(force - exact.force).max() / peak, 0.0, 1e-2, "", True),
    ]  # fmt: skip


def _average(name: str, made: Model, exact: Swing) -> list[Check]:
    """First impacts, and the whole motion on average, with losses."""
    path = run(made, float(exact.t[-1]), Control(1e-7, 1e-5, 1e-15))
    first = made.system.layout.node_dofs["slider"][0]
    times, known = _onsets(path), np.array([one.t for one in exact.impacts])
    speed = np.interp(exact.t, path.t, path.v[:, first])
    rms = float(np.sqrt(np.mean((speed - exact.velocity) ** 2)))
    largest = np.abs(exact.velocity).max()
    return [
        Check(f"{name}, second impact", times[1] / TURN, known[1] / TURN, 1e-4, "turns", True),
        Check("  largest force", _largest(path), exact.force.max(), 0.1, "N"),
        Check("  speed, rms difference / largest", rms / largest, 0.0, 0.03, "", True),
    ]  # fmt: skip


PIN = NormalContact("hertz-internal", None, "exact", 0.9)
CLEARANCES = (1e-4, 2e-4, 5e-4)


@problem("contact", "slider-crank with a loose pin, elastic", SOURCE)
def loose_pin() -> list[Check]:
    checks = []
    for c, restitution, turns in ELASTIC:
        exact = references.slider_crank(c, restitution, t_end=turns * TURN)
        made = _loose_pin(c, replace(PIN, restitution=restitution))
        checks += _elastic(f"{1e3 * c:g} mm", made, exact)
    system = _loose_pin(5e-4, PIN)
    stiffness = system.system.coefficients(sections(system.system))[-1][0, K]
    return [*checks, Check("stiffness of pin in bore", stiffness, 6.6102e10, 1e-4, "N/m^1.5")]


@problem("contact", "slider-crank with a loose pin, e = 0.9, one turn", SOURCE)
def lossy_pin() -> list[Check]:
    checks = []
    for c in CLEARANCES:
        exact = references.slider_crank(c, 0.9, t_end=TURN)
        checks += _average(f"{1e3 * c:g} mm", _loose_pin(c, PIN), exact)
    return checks


@problem("contact", "slider-crank with a loose slider", SOURCE)
def loose_slider() -> list[Check]:
    """Of 50 mm by 50 mm; both corners of an end hit the wall at once while it does not turn."""
    checks, law = [], NormalContact("linear", 1e8, "exact", 1.0)
    for c in CLEARANCES:
        exact = references.slider_in_guide(c, 1.0, t_end=0.25 * TURN)
        checks += _elastic(f"{1e3 * c:g} mm", _loose_slider(c, law), exact)
    for c in CLEARANCES:
        exact = references.slider_in_guide(c, 0.9, t_end=TURN)
        made = _loose_slider(c, replace(law, restitution=0.9))
        checks += _average(f"{1e3 * c:g} mm, e = 0.9", made, exact)
    return checks
