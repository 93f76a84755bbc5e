"""A made-up run of a turning, heated arm with a clearance hinge: realistic in shape and size.

Nothing here is a reference. It feeds the tests of what becomes of results and shows what the
pictures look like.
"""

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from coupling.results import Recorder
from meshes import generate, sections

Array = NDArray[np.float64]

LENGTH, ELEMENTS = 63.5, 16
CLEARANCE = 5e-5
TUBE = sections.tube(0.27, 0.002)
ROOT = np.array([1.0, 0.0, 0.5])
EXPANSION, BENDING = 23.1e-6, 8.53e6


def turn(t: Array, duration: float, angle: float) -> Array:
    """S-curve from 0 to ``angle``."""
    s = np.clip(np.asarray(t) / duration, 0.0, 1.0)
    return angle * (10 * s**3 - 15 * s**4 + 6 * s**5)


@cache
def orbit(rows: int, step: float) -> dict[str, Array]:
    """A particle that bounces in a circle under a load that swings: explicit, linear contact."""
    mass, stiffness, damping, friction = 20.0, 4e7, 2e3, 0.15
    r, v = np.array([2e-5, 1e-5]), np.array([0.0, 1e-3])
    found: dict[str, list[Any]] = {name: [] for name in ("orbit", "n", "f", "slip", "depth")}
    for k in range(rows):
        t = k * step
        direction = -0.5 * np.pi + 0.8 * np.sin(2 * np.pi * t / (0.7 * rows * step))
        force = 40.0 * np.array([np.cos(direction), np.sin(direction)])
        distance = float(np.hypot(*r))
        depth = distance - CLEARANCE
        normal, tangential, slip = 0.0, 0.0, 0.0
        n = r / max(distance, 1e-12)
        along = np.array([-n[1], n[0]])
        slip = float(v @ along) + 1e-4
        if depth > 0:
            normal = max(stiffness * depth + damping * float(v @ n), 0.0)
            tangential = -friction * normal * np.tanh(slip / 1e-4)
        v = v + step * (force - normal * n + tangential * along) / mass
        r = r + step * v
        for name, value in zip(found, (r, normal, tangential, slip, depth), strict=True):
            found[name].append(value)
    return {name: np.array(values) for name, values in found.items()}


def regime(o: dict[str, Array]) -> NDArray[np.int8]:
    """0 free flight, 1 impact, 2 slip, 3 stick."""
    contact = o["n"] > 0
    begins = np.flatnonzero(np.diff(contact.astype(int), prepend=0) == 1)
    code = np.where(contact, np.where(np.abs(o["slip"]) < 1.2e-4, 3, 2), 0)
    for k in begins:
        code[k : k + 12][contact[k : k + 12]] = 1
    return code.astype(np.int8)


def shape(t: float, duration: float, angle: float, heat: bool) -> tuple[Array, ...]:
    """Position, axes, temperature of the nodes and resultants of the elements at time t."""
    s = np.linspace(0.0, 1.0, ELEMENTS + 1)
    warm = (1.0 - np.exp(-5.0 * t / duration)) if heat else 0.0
    gradient = 50.0 * warm * (1.0 - 0.2 * s)
    mean = 298.15 + warm * (25.0 - 50.0 * s)
    temperature = np.column_stack([mean, 0.3 * gradient, -gradient])
    swing = 0.25 * np.sin(2 * np.pi * 0.127 * t) * np.exp(-t / 150.0) * s**2
    bow = 0.5 * EXPANSION * LENGTH**2 * s**2 * gradient
    theta = float(turn(np.array(t), duration, angle))
    slope_y = np.gradient(swing, s * LENGTH)
    slope_z = np.gradient(bow, s * LENGTH)
    local = np.column_stack([LENGTH * s - 0.5 * s * LENGTH * slope_z**2, swing, bow])
    rotation = np.array(
        [[np.cos(theta), np.sin(theta), 0], [-np.sin(theta), np.cos(theta), 0], [0, 0, 1.0]]
    )
    tangent = np.column_stack([np.ones_like(s), slope_y, slope_z])
    axes = generate._triads(tangent, np.broadcast_to([0.0, 1.0, 0.0], tangent.shape))
    middle = 0.5 * (s[1:] + s[:-1])
    resultants = np.zeros((ELEMENTS, 6))
    resultants[:, 4] = BENDING * 2.0 * swing[-1] / LENGTH**2 * (1.0 - middle)
    resultants[:, 0] = 200.0 * (1.0 - middle)
    return ROOT + local @ rotation, axes @ rotation, temperature, resultants


def arm_run(
    folder: Path,
    *,
    duration: float = 567.0,
    angle: float = np.radians(45.36),
    frames: int = 40,
    windows: int = 600,
    rows: int = 20_000,
    heat: bool = True,
    hinge: bool = True,
    title: str = "Turning arm with a hinge in the sun",
) -> Path:
    """Record the made-up run in ``folder`` and return the path of the results."""
    recorder = Recorder(folder, {"title": title, "scene": ""})
    for t in np.linspace(0.0, duration, frames):
        position, axes, temperature, resultants = shape(t, duration, angle, heat)
        row = {"position": position, "axes": axes, "resultants": resultants}
        recorder.append("frames", {"time": t})
        recorder.append("bodies/arm", row | ({"temperature": temperature} if heat else {}))
    recorder.describe_group("bodies/arm", _section_attributes())
    _record_windows(recorder, duration, angle, windows, heat)
    if hinge:
        _record_hinge(recorder, duration, angle, rows)
    recorder.close("done")
    return recorder.path


def _section_attributes() -> dict[str, Any]:
    names = "area second_moment_2 second_moment_3 torsion_constant radius thickness height width"
    return {
        "section_kind": TUBE.kind,
        "element": "beam3243",
        **{n: getattr(TUBE, n) for n in names.split()},
    }


def _record_windows(
    recorder: Recorder, duration: float, angle: float, windows: int, heat: bool
) -> None:
    random = np.random.default_rng(3)
    kinetic, friction, numerical = 0.0, 0.0, 0.0
    for t in np.linspace(0.0, duration, windows + 1)[1:]:
        position, _, temperature, _ = shape(t, duration, angle, heat)
        rate = float(turn(t + 0.5, duration, angle) - turn(t - 0.5, duration, angle))
        kinetic = 0.5 * 600.0 * LENGTH**2 / 3.0 * rate**2
        strain = 40.0 * np.sin(2 * np.pi * 0.127 * t) ** 2 * np.exp(-t / 75.0)
        friction += 0.15 * 40.0 * 1e-4 * duration / windows
        numerical += 1e-7 * random.random()
        damping = 60.0 * (1.0 - np.exp(-t / 75.0))
        recorder.append(
            "windows",
            {
                "time": t,
                "step_min": 10.0 ** random.uniform(-5.5, -4.0),
                "step_max": 10.0 ** random.uniform(-3.3, -3.0),
                "steps": random.integers(5, 40),
                "rejected": random.poisson(0.4),
                "iterations": random.integers(12, 120),
            },
        )
        terms = {
            "kinetic": kinetic,
            "strain": strain,
            "work_drive": kinetic + strain + friction + numerical + damping,
            "friction": friction,
            "damping": damping,
            "numerical": numerical,
            "defect": 1e-9 * random.standard_normal(),
        }
        if heat:
            warm = 1.0 - np.exp(-5.0 * t / duration)
            terms |= {
                "heat_sun": 6e6 * warm,
                "heat_space": -1e6 * warm**2,
                "heat_exchanged": friction,
                "heat_stored": 6e6 * warm - 1e6 * warm**2 + friction,
                "heat_defect": 1e-6 * random.standard_normal(),
            }
        recorder.append("ledger", terms)
        velocity = np.array([0.0, rate * LENGTH, 0.0])
        tip: dict[str, Any] = {"time": t, "position": position[-1], "velocity": velocity}
        recorder.append("probes/tip", tip | ({"temperature": temperature[-1, 0]} if heat else {}))


def _record_hinge(recorder: Recorder, duration: float, angle: float, rows: int) -> None:
    o = orbit(rows, 2e-5)
    t = np.linspace(0.0, duration, rows)
    warm = 1.0 - np.exp(-5.0 * t / duration)
    recorder.append_many(
        "joints/hinge",
        {
            "time": t,
            "orbit": o["orbit"],
            "clearance": CLEARANCE * (1.0 - 0.03 * warm),
            "penetration": np.maximum(o["depth"], 0.0),
            "normal_force": o["n"],
            "friction_force": o["f"],
            "slip_speed": o["slip"],
            "angle": turn(t, duration, angle),
            "torque": 40.0 * np.cos(2 * np.pi * t / duration),
            "regime": regime(o),
            "temperature_journal": 298.15 + 12.0 * warm,
            "temperature_bearing": 298.15 + 20.0 * warm,
        },
    )
    recorder.describe_group(
        "joints/hinge",
        {
            "kind": "clearance-revolute",
            "position": ROOT,
            "directions": np.eye(3)[:2],
            "axis": np.eye(3)[2],
            "journal_body": "arm",
            "journal_node": 0,
            "bearing_body": "",
            "bearing_node": 0,
        },
    )


# ------------------------------------------------------------------------ several contacts

STATIONS, OUTER, INNER = 12, 2.0, 3.0
"""Of a telescope: stations of its inner tube, lengths of its tubes [m]."""


def loose_run(folder: Path, rows: int = 600, windows: int = 20) -> Path:
    """A made-up run with a pin in space, a ball, a slider and a telescope."""
    recorder = Recorder(folder, {"title": "Tube out of a tube, hinged and guided", "scene": ""})
    _record_tubes(recorder)
    time = np.linspace(0.0, 1.0, rows)
    contacts = [*_pin(time), *_socket(time), *_slider(time), *_stations(time)]
    for number, (name, columns, attributes) in enumerate(contacts):
        joint, _, label = name.partition(".")
        known = {"joint": joint, "label": label, "number": number, "axes": np.eye(3)}
        recorder.append_many(f"joints/{name}", columns)
        recorder.describe_group(f"joints/{name}", known | attributes)
    random = np.random.default_rng(1)
    for t in np.linspace(0.0, 1.0, windows + 1)[1:]:
        shares = random.dirichlet([3.0, 0.3, 1.0, 1.0], len(contacts))
        peak = 1e3 * random.random(len(contacts)) ** 4
        row = {"shares": shares, "peak_force": peak, "impacts": random.poisson(2, len(contacts))}
        recorder.append("contacts", {"time": t, "friction_work": 1e-3 * peak, **row})
    recorder.close("done")
    return recorder.path


def _record_tubes(recorder: Recorder) -> None:
    for t in np.linspace(0.0, 1.0, 5):
        recorder.append("frames", {"time": t})
        for name, start, length in (("outer", 0.0, OUTER), ("inner", 0.4 + 0.3 * t, INNER)):
            position, axes = generate.line([start, 0, 0], [start + length, 0, 0], 8, [0, 1, 0])
            recorder.append(f"bodies/{name}", {"position": position, "axes": axes})
    for name in ("outer", "inner"):
        recorder.describe_group(f"bodies/{name}", _section_attributes())


def _touching(time: Array, phase: float, clearance: float) -> dict[str, Array]:
    """Columns that all contacts have: in contact where a sine is positive."""
    beat = np.sin(40.0 * time + phase)
    depth = 1e-2 * clearance * beat
    force = 300.0 * np.maximum(beat, 0.0) ** 1.5
    regime = np.where(beat <= 0.0, 0, 1 + (np.arange(len(time)) // 20) % 3)
    return {
        "time": time, "clearance": np.full_like(time, clearance), "penetration": depth,
        "normal_force": force, "friction_force": 0.1 * force, "slip_speed": 1e-3 * np.abs(beat),
        "approach": 0.0 * time, "regime": regime, "stuck": (regime == 3).astype(int),
        "friction_vector": np.outer(0.1 * force, [1.0, 0.0, 0.0]),
    }  # fmt: skip


Contacts = list[tuple[str, dict[str, Array], dict[str, Any]]]


def _pin(time: Array) -> Contacts:
    found: Contacts = []
    for k, height in enumerate((-0.03, 0.03)):
        columns = _touching(time, 2.0 * k, 5e-5)
        reach, angle = columns["clearance"] + columns["penetration"], 5.0 * time + k
        columns["orbit"] = reach[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
        columns["place"] = np.full_like(time, height)
        form = {"form": "end", "directions": np.eye(3)[:2], "axis": np.eye(3)[2]}
        found.append((f"pin.end_{k + 1}", columns, form | {"position": np.array([0, 0, 1.0])}))
    return found


def _socket(time: Array) -> Contacts:
    columns = _touching(time, 1.0, 1e-4)
    away = np.column_stack([0.1 * np.sin(time), np.cos(7 * time), np.sin(7 * time)])
    away /= np.linalg.norm(away, axis=1, keepdims=True)
    columns["orbit"] = (columns["clearance"] + columns["penetration"])[:, None] * away
    form = {"form": "ball", "directions": np.eye(3), "position": np.array([0, 1.0, 0])}
    return [("socket", columns, form)]


def _slider(time: Array) -> Contacts:
    found: Contacts = []
    for k, (end, side) in enumerate(((1, 1), (1, 2), (2, 1), (2, 2))):
        columns = _touching(time, 1.5 * k, 1e-4)
        columns["towards_wall"] = columns["clearance"] + columns["penetration"]
        columns["place"] = np.full_like(time, 0.1 * (2 * end - 3)) + 0.2 * time
        form = {"form": "wall", "directions": [[0.0, 2.0 * side - 3.0, 0.0]]}
        more = {"axis": np.eye(3)[0], "position": np.array([1.0, 0.02 * (2 * side - 3), 1.0])}
        found.append((f"guide.corner_{end}_{side}", columns, form | more))
    return found


def _stations(time: Array) -> Contacts:
    found: Contacts = []
    form: dict[str, Any] = {"form": "tube", "directions": np.eye(3), "radius": 0.05}
    form |= {"bearing_body": "outer", "journal_body": "inner"}
    for k in range(STATIONS + 1):
        columns = _touching(time, 0.5 * k, 1e-3)
        reach = columns["clearance"] + columns["penetration"]
        direction = np.column_stack([0.0 * time, np.cos(3 * time + k), np.sin(3 * time + k)])
        columns["orbit"] = reach[:, None] * direction
        columns["place"] = 0.4 + 0.3 * time + 0.1 * k
        if k < STATIONS:
            found.append((f"tubes.node_{k:02d}", columns, form | {"station": 0.1 * k}))
        else:
            found.append(("tubes.mouth", columns, form | {"mouth": OUTER, "station": OUTER}))
    return found
