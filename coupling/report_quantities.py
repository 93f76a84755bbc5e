"""Quantities that reports compare: what they may be, their units, and how they are read.

``probe.tip.z`` is read from the state at the end of each window, ``contact.hinge.impacts`` counts
what happened up to then. Arrays in, arrays out: a quantity is a (k,) array at each time.
"""

import re
from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from coupling.draft import Draft
from coupling.errors import unknown
from coupling.report_tables import Measured

Array = NDArray[np.float64]

PROBE = {
    **{axis: ("position", k, "m") for k, axis in enumerate("xyz")},
    **{f"v{axis}": ("velocity", k, "m/s") for k, axis in enumerate("xyz")},
    **{f"a{axis}": ("acceleration", k, "m/s^2") for k, axis in enumerate("xyz")},
    "position": ("position", None, "m"),
    "velocity": ("velocity", None, "m/s"),
    "acceleration": ("acceleration", None, "m/s^2"),
    "temperature": ("temperature", None, "K"),
}
"""Column of the probes, component and unit."""
TURN = {
    **{f"r{axis}": ("turn", k, "rad") for k, axis in enumerate("xyz")},
    **{f"w{axis}": ("angular velocity", k, "rad/s") for k, axis in enumerate("xyz")},
}
"""The same of the section at a probe. Turns are angular velocities over time, added up from window
to window: about a fixed axis they are the angle, however often it goes round."""
JOINT = {"angle": "rad", "rate": "rad/s"}
"""Of side a (journal) relative to side b (bearing) about the axis; the angle since the start."""
BODY = {"mean": "K", "gradient": "K/m"}
HEAT = ("max", "min", "mean")
LEDGER = (
    "energy", "kinetic", "strain", "contact_elastic", "work_loads", "work_drive", "work_thermal",
    "friction", "hysteresis", "damping", "numerical", "defect", "heat_stored", "heat_exchanged",
    "heat_of_deformation",
)  # fmt: skip
CONTACT = {"peak_force": "N", "impacts": "", "friction_work": "J", "hysteresis": "J"}
"""What contacts did up to a moment."""
MEETING = {"x": "m", "y": "m", "vx": "m/s", "vy": "m/s", "force": "N", "radius_gap": "m"}
"""What they do at the moment: journal centre in the frame of the bearing and its velocity there,
normal force, and the difference of the radii at the temperatures."""
TURNING = ("revolute", "clearance_revolute")
FORMS = {
    "probe": "probe.NAME.z",
    "joint": "joint.NAME.angle",
    "body": "body.NAME.mean",
    "part": "part.NAME.temperature",
    "heat": "heat.max",
    "ledger": "ledger.friction",
    "contact": "contact.NAME.peak_force",
    "mode": "mode.1.frequency",
    "load_factor": "load_factor",
}
"""An example of each kind."""


class Moment(NamedTuple):
    """What quantities are read from.

    motion : has t, q and v;  sections : (m, 3) float [K, K/m, K/m]  temperatures of sections
    T : (n,) float [K]  nodal temperatures;  ledger : () -> energies and works [J]
    contacts : name -> what each contact did so far
    response : (n_c, columns) float  of the contacts at the end of the last step, see
        ``mechanics.march``; None: no step has been watched
    """

    motion: Any
    sections: Array
    T: Array
    ledger: Any
    contacts: dict[str, dict[str, float]]
    response: Array | None = None


# ---------------------------------------------------------------------------------- checking


def problem_of(draft: Draft, of: str) -> str:
    """Why a quantity is not there; "" if it is."""
    kind, *rest = of.split(".")
    known = f"; known here: {', '.join(FORMS.values())}"
    if kind not in FORMS:
        return f"there is no quantity '{of}'{known}"
    if len(rest) < FORMS[kind].count("."):
        return f"'{of}' says too little; expected one such as {FORMS[kind]}"
    return _PROBLEMS[kind](draft, rest) or _analysis_problem(draft, kind)


def _analysis_problem(draft: Draft, kind: str) -> str:
    table = draft.valid.get(("analysis",))
    analysis = "dynamics" if table is None else table.kind
    of_one = {"contact": "dynamics", "heat": "dynamics", "part": "dynamics", "ledger": "dynamics",
              "mode": "modes", "load_factor": "statics"}  # fmt: skip
    wanted = of_one.get(kind, analysis)
    return f"belongs to {wanted}, and the analysis is {analysis}" if wanted != analysis else ""


def _of(what: str, names: Iterable[str], rest: list[str], keys: Iterable[str]) -> str:
    """A name, which may contain dots, and a key."""
    name, key = ".".join(rest[:-1]), rest[-1]
    if name not in names:
        return unknown(what, name, names)
    return "" if key in keys else unknown(f"quantity of a {what}", key, keys)


def _probe(draft: Draft, rest: list[str]) -> str:
    text = _of("probe", draft.names("probe"), rest, PROBE | TURN)
    if not text and rest[-1] in TURN:
        return _probe_turning(draft, ".".join(rest[:-1]))
    if not text and rest[-1] == "temperature" and "thermal" not in draft.raw:
        return "the scene has no heat"
    return text


def _probe_turning(draft: Draft, name: str) -> str:
    """Why the section at a probe has no turn."""
    probe = draft.named("probe").get(name)
    body = None if probe is None else draft.named("body").get(probe.body)
    if body is not None and body.kind in ("cable", "particle"):
        return (
            f"the body of '{name}' is a {body.kind}: nothing tells how it is turned about its axis"
        )
    return ""


def _joint(draft: Draft, rest: list[str]) -> str:
    names = {n for n, j in draft.named("joint").items() if j.kind in TURNING}
    faulty = set(draft.names("joint")) - set(draft.named("joint"))
    if ".".join(rest[:-1]) in faulty:
        return ""
    return _of(f"joint that turns ({', '.join(TURNING)})", names, rest, JOINT)


def _body(draft: Draft, rest: list[str]) -> str:
    text = _of("body", draft.names("body"), rest, BODY)
    body = draft.named("body").get(".".join(rest[:-1]))
    if not text and body is not None and body.kind in ("rigid", "particle"):
        return f"'{rest[0]}' is a {body.kind}: it has no temperature"
    return text


def _part(draft: Draft, rest: list[str]) -> str:
    names = [*draft.names("thermal", "part"), *draft.names("thermal", "solid")]
    return _of("part", names, rest, ["temperature"])


def _heat(draft: Draft, rest: list[str]) -> str:
    if "thermal" not in draft.raw:
        return "the scene has no heat"
    return "" if rest[0] in HEAT else unknown("quantity of the heat", rest[0], HEAT)


def _ledger(draft: Draft, rest: list[str]) -> str:
    name = ".".join(rest)
    if name in LEDGER or name.startswith("heat_"):
        return ""
    return unknown("term of the ledger", name, LEDGER)


def _contact(draft: Draft, rest: list[str]) -> str:
    joints = {n for n, j in draft.named("joint").items() if hasattr(j, "clearance")}
    joint = next((n for n in joints if ".".join(rest[:-1]).startswith(n)), rest[0])
    return _of("joint with clearance", joints, [joint, rest[-1]], CONTACT | MEETING)


def _mode(draft: Draft, rest: list[str]) -> str:
    good = re.fullmatch(r"[1-9]\d*", rest[0]) and rest[1:] == ["frequency"]
    return "" if good else "expected mode.NUMBER.frequency, such as mode.1.frequency"


def _load_factor(draft: Draft, rest: list[str]) -> str:
    return f"'load_factor' has no '{rest[0]}'" if rest else ""


_PROBLEMS = {
    "probe": _probe, "joint": _joint, "body": _body, "part": _part, "heat": _heat,
    "ledger": _ledger, "contact": _contact, "mode": _mode, "load_factor": _load_factor,
}  # fmt: skip


def unit_of(of: str) -> str:
    """SI unit of a quantity."""
    kind, *rest = of.split(".")
    own = {"probe": {key: unit for key, (*_, unit) in (PROBE | TURN).items()}, "body": BODY,
           "contact": CONTACT | MEETING, "joint": JOINT}.get(kind)  # fmt: skip
    if own is not None:
        return own[rest[-1]]
    return {"part": "K", "heat": "K", "ledger": "J", "mode": "Hz"}.get(kind, "")


def width_of(of: str) -> int:
    """Components of a quantity."""
    kind, *rest = of.split(".")
    return 3 if kind == "probe" and rest[-1] in ("position", "velocity", "acceleration") else 1


def needs_contacts(sought: Iterable[Measured]) -> bool:
    """Whether the steps within the windows have to be watched."""
    return any(one.of.startswith("contact.") for one in sought)


# ----------------------------------------------------------------------------------- reading


def read(model: Any, of: str, at: Moment) -> Array:
    """(k,) float  of a quantity, at one moment of a run of a model. KeyError: it is not there.

    Of angles and turns it is what ``course`` makes them from.
    """
    kind, *rest = of.split(".")
    name, key = ".".join(rest[:-1]), rest[-1] if rest else ""
    match kind:
        case "probe" if key in TURN:
            return _at_section(model, name, key, at)
        case "probe":
            return _at_probe(model, name, key, at)
        case "joint":
            from coupling.turns import joint

            return np.atleast_1d(joint(model, name, key, at.motion))
        case "body":
            sections = at.sections[model.layout.point_index[name]]
            steep = np.linalg.norm(sections[:, 1:], axis=1).max()
            return np.atleast_1d(_average(model, name, sections[:, 0]) if key == "mean" else steep)
        case "part":
            return np.atleast_1d(at.T[model.pair.heat_solver.regions[_region(model, name)]].mean())
        case "heat":
            return np.atleast_1d(getattr(at.T, key)())
        case "ledger":
            return np.atleast_1d(_from_ledger(at.ledger(), ".".join(rest)))
        case "contact" if key in MEETING:
            return np.atleast_1d(_meeting(model, name, key, at))
        case "contact":
            return np.atleast_1d(_of_contacts(at.contacts, name, key))
    return np.atleast_1d(float(at.motion.t))


def _at_probe(model: Any, name: str, key: str, at: Moment) -> Array:
    from coupling import observables

    column, component, _ = PROBE[key]
    one = {name: model.probed[name]}
    row = observables.probes(one, model.layout, at.motion, at.sections)[name]
    value = np.atleast_1d(np.asarray(row[column], dtype=float))
    return value if component is None else value[component : component + 1]


def _at_section(model: Any, name: str, key: str, at: Moment) -> Array:
    """Angular velocity about an axis, or the whole triad (9,)."""
    from coupling.turns import spin, triad

    side, (what, component, _) = model.probed[name].side, TURN[key]
    if what == "turn":
        return triad(side, at.motion.q).ravel()
    return np.atleast_1d(spin(side, at.motion.q, at.motion.v)[component])


def _meeting(model: Any, name: str, key: str, at: Moment) -> float:
    """Of a contact; of several of a joint the first orbit and gap, and the largest force."""
    from coupling.contacts import ORBITS
    from mechanics import march

    found = [c for c in model.contacts if c.name == name or c.name.startswith(f"{name}.")]
    if not found:
        raise KeyError(name)
    response = _response(model, at) if at.response is None else at.response
    if key == "force":
        forces = response[:, march.ELASTIC] + response[:, march.DISSIPATIVE]
        return max(float(forces[c.row : c.row + 1 + c.parts].max()) for c in found)
    first = next((c for c in found if c.form in ORBITS), found[0])
    place = {"x": march.PATH, "y": march.PATH + 1, "vx": march.PATH_RATE,
             "vy": march.PATH_RATE + 1, "radius_gap": march.GAP}[key]  # fmt: skip
    return float(response[first.row, place])


def _response(model: Any, at: Moment) -> Array:
    """(n_c, columns) of the contacts before the first step."""
    system, motion = model.motion_solver.system, at.motion
    y = system.unknowns(motion.q, motion.lam)
    v = np.concatenate([motion.v, np.zeros(system.m)])
    return system.respond(y, v, system.coefficients(at.sections))


def course(of: str, rows: Array) -> Array:
    """(w, k) float  of a quantity from what was read of it at w moments.

    Angles go on beyond half a turn, and turns are added up, as long as a window has less than
    half a turn.
    """
    kind, *rest = of.split(".")
    if kind == "joint" and rest[-1] == "angle":
        unwrapped = np.unwrap(rows[:, 0])
        return (unwrapped - unwrapped[0])[:, None]
    if kind == "probe" and rest[-1] in TURN and TURN[rest[-1]][0] == "turn":
        from coupling.turns import added

        return added(rows.reshape(-1, 3, 3))[:, TURN[rest[-1]][1], None]
    return rows


def _region(model: Any, name: str) -> str:
    """What the heat calls a part or a solid."""
    from coupling.heat_descriptions import region_of

    thermal = model.scene.thermal
    table = thermal.part.get(name) or thermal.solid.get(name)
    return name if table is None else region_of(name, table)


def _average(model: Any, name: str, T: Array) -> float:
    """Over the length of a member; over the nodes of a shell."""
    points = model.scene.points[name]
    if len(points) != len(T) or model.scene.body[name].kind not in ("beam", "cable"):
        return float(T.mean())
    along = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1)))
    return float(np.trapezoid(T, along) / along[-1])


def _from_ledger(ledger: dict[str, float], name: str) -> float:
    if name == "energy":
        return ledger["kinetic"] + ledger["strain"] + ledger["contact_elastic"]
    return ledger[name]


def _of_contacts(contacts: dict[str, dict[str, float]], name: str, key: str) -> float:
    """Of a contact, or of all of a joint: the largest force, and the sum of what adds up."""
    of_it = [row[key] for n, row in contacts.items() if n == name or n.startswith(f"{name}.")]
    if not of_it:
        raise KeyError(name)
    return max(of_it) if key == "peak_force" else sum(of_it)
