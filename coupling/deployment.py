"""[generate.NAME] kind = "deployable_ring" written out: tables as if they were in the file."""

from math import pi
from typing import Any, NamedTuple

import numpy as np

from coupling.deployment_tables import DeployableRing, Winch
from meshes.deployable_ring import Bar, Corner, Form, Panel, Ring, deployable_ring, slope_of

Tables = dict[str, Any]
SLACK = 1e-9
"""Angle within which a member counts as on the border of the two halves of a ring [rad]."""


class Pin(NamedTuple):
    """A joint with play: its name, and the members of its journal and bearing."""

    joint: str
    journal: str
    bearing: str


def deployable(table: DeployableRing) -> Tables:
    """The tables of a ring that deploys, in the form of TOML."""
    ring = deployable_ring(table.form, table.fraction)
    joints: Tables = {}
    for k, panel in enumerate(ring.panels):
        joints |= _chord_hinges(panel, table) | _diagonal_joints(panel, table)
        if table.gears:
            joints |= _gear(ring.panels[k - 1], panel)
        if table.latches:
            joints |= _latch(panel)
        if table.resistance is not None:
            joints |= _resistance(k, panel, table)
    joints |= _dampers(joints, table)
    if table.rope is not None:
        joints["rope"] = _rope(ring, table)
    if table.support == "clamp":
        joints["support"] = {"kind": "clamp", "a": {"body": ring.bars[0].name, "at": "start"}}
    made: Tables = {"body": {bar.name: _body(bar, table) for bar in ring.bars}, "joint": joints}
    if table.clearance and table.clearance.sliders and table.clearance.sliders.press:
        press = table.clearance.sliders.press
        made["load"] = {
            f"press_{p.inner.removeprefix('inner_')}": _press(p, press) for p in ring.panels
        }
    heat = _heat(ring, table)
    return {**made, "thermal": heat} if heat else made


def _body(bar: Bar, table: DeployableRing) -> Tables:
    own = {"outer": table.outer_section, "inner": table.inner_section}
    return {
        "kind": "beam",
        "start": bar.start.tolist(),
        "end": bar.end.tolist(),
        "elements": table.elements,
        "normal": bar.normal.tolist(),
        "section": own.get(bar.kind, table.section),
        "material": table.material,
        "damping": table.damping,
    }


# -- joints ------------------------------------------------------------------------------------


def _site(corner: Corner) -> Tables:
    return {"body": corner.post, "at": corner.at}


def _chord_hinges(panel: Panel, table: DeployableRing) -> Tables:
    """Revolutes about the normal of the panel at both ends of both chords."""
    made = {}
    for chord, level in ((panel.lower, "start"), (panel.upper, "end")):
        for at, post in (("start", panel.near), ("end", panel.far)):
            ends = {"body": chord, "at": at}, {"body": post, "at": level}
            made[f"{chord}_{at}"] = _hinge(*ends, panel.normal.tolist(), table)
    return made


def _hinge(chord: Tables, post: Tables, axis: list[float], table: DeployableRing) -> Tables:
    if table.clearance is None:
        return {"kind": "revolute", "a": chord, "b": post, "axis": axis}
    given = table.clearance.model_dump(
        exclude={"spherical", "mass", "sliders", "grease"}, exclude_unset=True, by_alias=True
    )
    return {
        "kind": "clearance_revolute",
        "journal": chord,
        "bearing": post,
        "axis": axis,
        **_materials(table),
        **given,
    }


def _diagonal_joints(panel: Panel, table: DeployableRing) -> Tables:
    """A ball at the head, a universal joint at the foot that keeps the tubes from spinning."""
    outer, inner = panel.outer, panel.inner
    foot = {
        "kind": "universal",
        "a": {"body": outer, "at": "start"},
        "b": _site(panel.foot),
        "axis_a": panel.normal.tolist(),
        "axis_b": panel.along.tolist(),
    }
    head = {"kind": "spherical", "a": {"body": inner, "at": "end"}, "b": _site(panel.head)}
    return {
        f"{outer}_foot": foot,
        f"{inner}_head": head,
        _slider_name(panel): _slider(panel, table),
    }


def _dampers(joints: Tables, table: DeployableRing) -> Tables:
    """What resists motion in the gaps of pins, and turning at the ends of diagonals."""
    made: Tables = {}
    play = table.clearance
    if play is None:
        return made
    for name, joint in joints.items():
        if joint["kind"] == "clearance_revolute" and play.grease is not None:
            ends = {"a": joint["journal"], "b": joint["bearing"], "axes": _triad(joint["axis"])}
            made[f"grease_{name}"] = _damper(ends, damping=[play.grease, play.grease, 0.0])
        if joint["kind"] in ("universal", "spherical") and play.sliders and play.sliders.pivots:
            ends = {"a": joint["a"], "b": joint["b"]}
            made[f"pivot_{name}"] = _damper(ends, turn_damping=3 * [play.sliders.pivots])
    return made


def _press(panel: Panel, moment: float) -> Tables:
    """A spiral spring between the post and the outer tube; it turns that as folding does."""
    ends = {"a": {"body": panel.outer, "at": "start"}, "b": _site(panel.foot)}
    against = -moment if panel.foot.at == "end" else moment
    return {"kind": "torque", **ends, "direction": panel.normal.tolist(), "amplitude": against}


def _damper(ends: Tables, **resistance: list[float]) -> Tables:
    return {"kind": "bushing", **ends, "stiffness": [0.0, 0.0, 0.0], **resistance}


def _triad(axis: list[float]) -> list[list[float]]:
    """Two directions across the axis, and the axis."""
    third = np.array(axis)
    first = np.cross(third, np.eye(3)[np.argmin(np.abs(third))])
    first /= np.linalg.norm(first)
    return [first.tolist(), np.cross(third, first).tolist(), axis]


def _slider_name(panel: Panel) -> str:
    return f"slider_{panel.inner.removeprefix('inner_')}"


def _slider(panel: Panel, table: DeployableRing) -> Tables:
    """The start of the inner tube on a line through the mouth of the outer one."""
    ends = {"body": panel.inner, "at": "start"}, {"body": panel.outer, "at": "end"}
    axis = panel.axis.tolist()
    if table.clearance is None or table.clearance.sliders is None:
        return {"kind": "prismatic", "a": ends[0], "b": ends[1], "axis": axis}
    play = table.clearance.model_dump(
        include={"contact", "friction", "clearance", "reference_temperature"},
        exclude_unset=True,
        by_alias=True,
    )
    own = table.clearance.sliders.model_dump(exclude={"pivots", "press"}, exclude_unset=True)
    return {
        "kind": "clearance_translational",
        "journal": ends[0],
        "bearing": ends[1],
        "axis": axis,
        "normal": np.cross(panel.normal, panel.axis).tolist(),
        **_materials(table),
        **play,
        **own,
    }


def _materials(table: DeployableRing) -> Tables:
    return {"journal_material": table.material, "bearing_material": table.material}


def _gear(before: Panel, panel: Panel) -> Tables:
    """Wheels on the two lower chords at the foot of the post between two panels."""
    wheels = {"first": f"{before.lower}_end", "second": f"{panel.lower}_start", "ratio": -1.0}
    return {f"gear_{panel.lower.removeprefix('chord_low_')}": {"kind": "gear", **wheels}}


def _latch(panel: Panel) -> Tables:
    name = f"latch_{panel.lower.removeprefix('chord_low_')}"
    return {name: {"kind": "latch", "joint": f"{panel.lower}_start", "at": panel.turn}}


def _resistance(k: int, panel: Panel, table: DeployableRing) -> Tables:
    assert table.resistance is not None
    against = table.resistance.moment if k % 2 else -table.resistance.moment
    spring = {"joint": f"{panel.lower}_start", "damping": table.resistance.damping}
    name = f"resistance_{panel.lower.removeprefix('chord_low_')}"
    return {name: {"kind": "torsion_spring", **spring, "preload": against}}


# -- drive -------------------------------------------------------------------------------------


def _rope(ring: Ring, table: DeployableRing) -> Tables:
    assert table.rope is not None
    made: Tables = {"kind": "pulley", "points": [_site(corner) for corner in ring.rope]}
    slope = slope_of(table.fraction)
    if table.rope.stiffness is not None:
        made |= {"stiffness": table.rope.stiffness, "damping": table.rope.damping}
        made["length"] = slack_rope(table, slope)
    if table.winch is not None:
        times, angles = winch_law(table.form, slope, table.winch)
        paid_out = [slack_rope(table, float(a)) - slack_rope(table, slope) for a in angles]
        rows = zip(times, paid_out, strict=True)
        made["winch"] = {"table": [[float(t), float(x)] for t, x in rows]}
    return made


def slack_rope(table: DeployableRing, slope: float) -> float:
    """Length [m] without force of the rope that holds the ring at a slope [rad]."""
    assert table.rope is not None
    if table.rope.stiffness is None:
        return table.form.rope(slope)
    against = 0.0 if table.resistance is None else table.resistance.moment
    if table.clearance and table.clearance.sliders and table.clearance.sliders.press:
        against += table.clearance.sliders.press * table.form.swing(slope)
    tension = against / table.form.lever(slope)
    return table.form.rope(slope) / (1.0 + tension / table.rope.stiffness)


def winch_law(form: Form, slope: float, winch: Winch) -> tuple[np.ndarray, np.ndarray]:
    """Times [s], and slopes [rad] to which the rope belongs that is then left, (points,) each."""
    share = np.linspace(0.0, 1.0, winch.points)
    last = _slope_at(form, form.rope(0.0) - winch.overrun)
    return winch.start + winch.duration * share, slope + (last - slope) * _there(share)


def _there(share: np.ndarray) -> np.ndarray:
    """From 0 to 1: at one acceleration, and from the middle on at the opposite one."""
    return np.where(share < 0.5, 2.0 * share**2, 1.0 - 2.0 * (1.0 - share) ** 2)


def _slope_at(form: Form, rope: float) -> float:
    """Slope [rad] at which the rope has a length [m]."""
    L, H = form.chord, form.height
    return float(np.arcsin(((rope / form.bays) ** 2 - L**2 - H**2) / (2.0 * L * H)))


# -- heat --------------------------------------------------------------------------------------


def _heat(ring: Ring, table: DeployableRing) -> Tables:
    """What the ring adds to [thermal]."""
    if table.shock is None:
        return {}
    made: Tables = {"wall": {bar.name: _wall(bar, table) for bar in ring.bars}}
    if table.clearance is None or table.clearance.mass is None:
        return made
    lump = {"material": table.material, "mass": table.clearance.mass}
    member = {bar.name: bar for bar in ring.bars}
    made["part"], made["fixed"] = {}, {}
    for pin in _pins(ring, table):
        for side, of in (("journal", pin.journal), ("bearing", pin.bearing)):
            name = f"{pin.joint}_{side}"
            made["part"][name] = {"of": f"{pin.joint}.{side}", **lump}
            warm = _temperature(member[of], table)
            made["fixed"][name] = {"at": {"part": name}, "temperature": warm}
    return made


def _pins(ring: Ring, table: DeployableRing) -> list[Pin]:
    assert table.clearance is not None
    found = []
    for panel in ring.panels:
        for chord in (panel.lower, panel.upper):
            found.append(Pin(f"{chord}_start", chord, panel.near))
            found.append(Pin(f"{chord}_end", chord, panel.far))
        if table.clearance.sliders is not None:
            found.append(Pin(_slider_name(panel), panel.inner, panel.outer))
    return found


def _wall(bar: Bar, table: DeployableRing) -> Tables:
    warm = _temperature(bar, table)
    return {"body": bar.name, "side": bar.normal.tolist(), "hot": warm, "cold": warm}


def _temperature(bar: Bar, table: DeployableRing) -> Any:
    """History of the temperature of a member."""
    shock = table.shock
    assert shock is not None
    if shock.over == "half" and not SLACK < bar.angle < pi - SLACK:
        return shock.first
    end = shock.start + shock.duration
    return {"ramp": {"start": shock.start, "end": end, "from": shock.first, "to": shock.last}}
