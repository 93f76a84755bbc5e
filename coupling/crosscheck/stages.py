"""The stages: what each yields of a model."""

from collections.abc import Callable, Collection, Iterator
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from coupling.crosscheck.quantities import Quantity
from coupling.crosscheck.solved import Failed, Solved, asked
from coupling.descriptions import flexible_bodies, line_bodies

Array = NDArray[np.float64]

ANGLE = 1.0
"""By which a body is turned to see whether it strains [rad]."""


def measured(solved: Solved, stage: str) -> list[Quantity]:
    """All quantities of a stage but frequencies, which are paired first.

    Raises
    ------
    Failed : with the reason
    """
    return list(YIELDS[stage](solved))


# ---------------------------------------------------------------------------------- bodies


def _mass(solved: Solved) -> Iterator[Quantity]:
    layout, mass = solved.model.layout, solved.model.motion_solver.system.mass

    def moving(**how: Any) -> Array:
        return rigid_motion(layout, layout.q0, bodies=solved.scene.body, **how)

    along = np.stack([moving(shift=e) for e in np.eye(3)])
    total = float(along[0] @ (mass @ along[0]))
    turning = np.stack([moving(turn=e) for e in np.eye(3)])
    first = turning @ (mass @ along.T) / total  # rows: turn about x, columns: motion along
    centre = np.array([first[1, 2], first[2, 0], first[0, 1]]) * -1.0
    about = np.stack([moving(turn=e, centre=centre) for e in np.eye(3)])
    size = float(np.linalg.norm(np.ptp(layout.x, axis=0)))
    yield Quantity("mass", "kg", np.array(total))
    yield Quantity("centre of mass", "m", centre, scale=size)
    moments = np.linalg.eigvalsh(about @ (mass @ about.T))
    for name, moment in zip(("least", "middle", "greatest"), moments, strict=True):
        yield Quantity(f"{name} moment of inertia", "kg m²", np.array(moment))


def rigid_motion(
    layout: Any,
    q: Array,
    shift: Array | None = None,
    turn: Array | None = None,
    centre: Array | None = None,
    bodies: Collection[str] | None = None,
) -> Array:
    """(n,) velocities of all coordinates (n,) in a rigid motion with the given speeds.

    bodies : those that move; None: all
    """
    v = np.zeros_like(q)
    for name, first in layout.node_dofs.items():
        if bodies is not None and name.partition("@")[0] not in bodies:
            continue
        at = first[:, None] + np.arange(layout.kinds[name])
        vectors = q[at].reshape(len(first), -1, 3).copy()
        moved = np.zeros_like(vectors)
        if turn is not None:
            vectors[:, 0] -= 0.0 if centre is None else centre
            moved = np.cross(turn, vectors)
        if shift is not None:
            moved[:, 0] += shift
        v[at] = moved.reshape(len(first), -1)
    return v


def _rigid_modes(solved: Solved) -> Iterator[Quantity]:
    for name in flexible_bodies(solved.scene):
        yield from solved.timed("rigid_modes", partial(_of_free_body, solved, name))


def _of_free_body(solved: Solved, name: str) -> list[Quantity]:
    from mechanics.description import Description
    from mechanics.modes import modes
    from mechanics.system import System

    body: Any = solved.model.layout.bodies[name]
    system = System(Description([body]))
    rest = np.zeros((len(system.layout.x), 3))
    rest[:, 0] = body.reference_temperature
    coef, q0 = system.coefficients(rest), system.layout.q0
    found = modes(system, q0, np.zeros(system.m), coef, 7)
    elastic = float(found.frequencies[6])
    strain = _strain_of_turning(system, coef, elastic)
    rigid = float(np.abs(found.frequencies[:6]).max()) / elastic
    return [
        Quantity(f"{name}: first elastic frequency", "Hz", np.array(elastic)),
        Quantity(f"{name}: six rigid frequencies / elastic", "1", np.array(rigid),
                 "nothing"),
        Quantity(f"{name}: strain energy of a turn / vibration", "1", np.array(strain),
                 "nothing"),
    ]  # fmt: skip


def _strain_of_turning(system: Any, coef: Any, elastic: float) -> float:
    """Energy of a body turned about an odd axis, over what it would have in a vibration as wide."""
    from scipy.spatial.transform import Rotation

    layout, axis = system.layout, np.array([2.0, 3.0, 6.0]) / 7.0
    turn = Rotation.from_rotvec(ANGLE * axis).as_matrix()
    q = (layout.q0.reshape(-1, 3) @ turn.T).ravel()
    y, still = system.unknowns(q), np.zeros(system.n + system.m)
    stored = float(system.energies(y, still, system.timed(coef, 0.0))[0])
    centre = layout.q0[next(iter(layout.node_dofs.values()))[:, None] + np.arange(3)].mean(axis=0)
    v = ANGLE * rigid_motion(layout, layout.q0, turn=axis, centre=centre)
    wide = 0.5 * (2.0 * np.pi * elastic) ** 2 * float(v @ (system.mass @ v))
    return abs(stored) / wide


# ------------------------------------------------------------------------------------ rest


def _thermal_load(solved: Solved) -> Iterator[Quantity]:
    place = solved.expanded
    for name, moved in _displacements(solved, place).items():
        body = solved.scene.probe[name].body
        if body in line_bodies(solved.scene):
            e1 = solved.scene.shapes[body].axes[0, 0]
            along = float(moved @ e1)
            yield Quantity(f"{name}: along", "m", np.array(along))
            yield Quantity(f"{name}: across", "m", moved - along * e1)

    for name, section in solved.sections.items():
        swelling = section.distortion(solved.expanded.q)
        yield Quantity(f"{name}: out of round", "µm", np.array(1e6 * swelling), "told")
    yield Quantity(
        "greatest stress", "MPa", np.array(1e-6 * solved.stress(solved.expanded)), "told"
    )


def _static(solved: Solved) -> Iterator[Quantity]:
    for name, moved in _displacements(solved, solved.equilibrium).items():
        yield Quantity(f"{name}: displacement", "m", moved)


def _displacements(solved: Solved, place: Any) -> dict[str, Array]:
    """(3,) [m]  of each probe from the reference."""
    before, after = solved.probed(solved.model.layout.q0), solved.probed(place.q)
    return {name: after[name] - before[name] for name in after}


def _pointing(solved: Solved) -> Iterator[Quantity]:
    table = asked(solved.scene)
    for name, section in solved.sections.items():
        if "transient" in table.stages:
            turns = 1e3 * solved.course.turns[name]
            yield Quantity(f"{name}: rotation, rms", "mrad", turns, "rms")
            yield Quantity(f"{name}: rotation, most", "mrad", turns, "most")
        else:
            turn = 1e3 * section.rotation(solved.equilibrium.q)
            yield Quantity(f"{name}: rotation", "mrad", turn)


# ---------------------------------------------------------------------------------- motion


def _transient(solved: Solved) -> Iterator[Quantity]:
    for name, places in solved.course.places.items():
        moved = places - places[0]
        far = np.array(np.linalg.norm(moved, axis=1).max())
        yield Quantity(f"{name}: farthest", "m", far)
        yield Quantity(f"{name}: displacement, rms", "m", moved, "rms")
        yield Quantity(f"{name}: displacement, most", "m", moved, "most")


def _contact(solved: Solved) -> Iterator[Quantity]:
    course = solved.course
    if not course.steps:
        raise Failed("it has no contacts")
    times, force = _forces(course.steps)
    mean = float(np.trapezoid(force, times) / (times[-1] - times[0]))
    yield Quantity("normal force, mean", "N", np.array(mean))
    yield Quantity("normal force, greatest", "N", np.array(float(force.max())))
    ledger = solved.model.ledger(course.final)
    yield Quantity("friction work", "J", np.array(ledger["friction"]))
    if solved.scene.thermal is not None:
        yield Quantity("frictional heat", "J", np.array(course.final.released))
        yield from _warmed(solved)


def _forces(steps: list[Any]) -> tuple[Array, Array]:
    """Times [s] and the sum of the sizes of all normal forces [N], step by step."""
    times = np.concatenate([s.times[1:] for s in steps])
    return times, np.concatenate([s.force[1:].sum(axis=1) for s in steps])


def _warmed(solved: Solved) -> Iterator[Quantity]:
    """Rise of temperature of the sides of the joints."""
    model, course = solved.model, solved.course
    before, after = (model.sections(state)[:, 0] for state in (course.initial, course.final))
    for name, rows in model.motion_solver.regions.items():
        joint, _, side = name.rpartition(".")
        if joint in solved.scene.joint and side in ("journal", "bearing"):
            rise = float((after[rows] - before[rows]).mean())
            yield Quantity(f"{joint}: rise of the {side}", "K", np.array(rise))


YIELDS: dict[str, Callable[[Solved], Iterator[Quantity]]] = {
    "mass": _mass,
    "rigid_modes": _rigid_modes,
    "thermal_load": _thermal_load,
    "static": _static,
    "transient": _transient,
    "contact": _contact,
    "pointing": _pointing,
}
