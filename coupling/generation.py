"""[generate.NAME] written out: the tables that it stands for, as if they were in the file."""

from collections.abc import Mapping
from math import pi
from typing import Any

from coupling.generate_tables import RingTruss, Shock
from meshes.truss import Hinge, Member, Truss, loaded_corners, ring_truss

Tables = dict[str, Any]
SLACK = 1e-9
"""Angle within which a member counts as on the border of the two halves of a ring [rad]."""


def made_by(table: RingTruss) -> Tables:
    """The tables of a ring truss, in the form of TOML."""
    truss = ring_truss(table.bays, table.diameter, table.height, table.pieces, table.fitting)
    made: Tables = {
        "body": {m.name: _member(m, table) for m in truss.members},
        "joint": {h.name: _hinge(h, table) for h in truss.hinges},
    }
    if table.support == "clamp":
        post, at = truss.corners[0]
        made["joint"]["support"] = {"kind": "clamp", "a": {"body": post, "at": at}}
    if table.shakers is not None:
        made["load"] = _shakers(truss, table)
    heat = _heat(truss, table)
    return {**made, "thermal": heat} if heat else made


def _member(member: Member, table: RingTruss) -> Tables:
    start, end = member.points[0], member.points[-1]
    along = [float(((p - start) @ (p - start)) ** 0.5) for p in member.points]
    return {
        "kind": "beam",
        "start": start.tolist(),
        "end": end.tolist(),
        "nodes": along,
        "normal": member.normal.tolist(),
        "section": table.section,
        "material": table.material,
        "damping": table.damping,
        "element": table.element,
    }


def _hinge(hinge: Hinge, table: RingTruss) -> Tables:
    ends = ({"body": hinge.a, "at": hinge.at}, {"body": hinge.base, "at": hinge.base_at})
    turning = {} if hinge.axis is None else {"axis": hinge.axis.tolist()}
    kind = "revolute" if turning else "spherical"
    if not _is_loose(hinge, table):
        return {"kind": kind, "a": ends[0], "b": ends[1], **turning}
    assert table.clearance is not None
    given = table.clearance.model_dump(
        exclude={"spherical", "mass"}, exclude_unset=True, by_alias=True
    )
    return {
        "kind": f"clearance_{kind}",
        "journal": ends[0],
        "bearing": ends[1],
        **turning,
        "journal_material": table.material,
        "bearing_material": table.material,
        **given,
    }


def _shakers(truss: Truss, table: RingTruss) -> Tables:
    assert table.shakers is not None
    count, width = table.shakers.count, len(str(table.shakers.count - 1))
    found = {}
    for i, corner in enumerate(loaded_corners(len(truss.corners), count)):
        post, at = truss.corners[corner]
        sine = {
            "amplitude": table.shakers.amplitude,
            "frequency": table.shakers.frequency,
            "phase": 2.0 * pi * i / count,
            "offset": 0.0,
        }
        found[f"shaker_{i:0{width}d}"] = {
            "kind": "force",
            "at": {"body": post, "at": at},
            "direction": [0.0, 0.0, 1.0],
            "amplitude": {"sine": sine},
        }
    return found


def _heat(truss: Truss, table: RingTruss) -> Tables:
    """What the ring adds to [thermal]."""
    made: Tables = {}
    temperature = {}
    if table.shock is not None:
        temperature = {m.name: _temperature(m, table.shock) for m in truss.members}
        made["wall"] = {m.name: _wall(m, temperature[m.name]) for m in truss.members}
    sides = _sides(truss, table)
    if table.clearance is not None and table.clearance.mass is not None:
        lump = {"material": table.material, "mass": table.clearance.mass}
        made["part"] = {f"{h}_{side}": {"of": f"{h}.{side}", **lump} for h, side, _ in sides}
        made["fixed"] = {
            f"{hinge}_{side}": {
                "at": {"part": f"{hinge}_{side}"},
                "temperature": temperature[member],
            }
            for hinge, side, member in sides
            if temperature
        }
    return made


def _sides(truss: Truss, table: RingTruss) -> list[tuple[str, str, str]]:
    """Hinge, side and member of every side of the hinges with play."""
    loose = [h for h in truss.hinges if _is_loose(h, table)]
    return [(h.name, *side) for h in loose for side in (("journal", h.a), ("bearing", h.base))]


def _is_loose(hinge: Hinge, table: RingTruss) -> bool:
    play = table.clearance
    return play is not None and (hinge.axis is not None or play.spherical)


def _temperature(member: Member, shock: Shock) -> Any:
    """History of the temperature of a member."""
    if not SLACK < member.angle < pi - SLACK:
        return shock.first
    end = shock.start + shock.duration
    return {"ramp": {"start": shock.start, "end": end, "from": shock.first, "to": shock.last}}


def _wall(member: Member, hot: Any) -> Tables:
    return {"body": member.name, "side": member.normal.tolist(), "hot": hot, "cold": hot}


def merged(made: Mapping[str, Any], given: Mapping[str, Any]) -> Tables:
    """What was ``made``, changed and added to by what is ``given``."""
    whole = dict(given)
    for key, value in made.items():
        if key not in given:
            whole[key] = value
        elif isinstance(value, Mapping) and isinstance(given[key], Mapping):
            whole[key] = merged(value, given[key])
    return whole
