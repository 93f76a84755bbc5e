"""Unit and meaning of every column that a run records."""

from typing import NamedTuple

import numpy as np
from numpy.typing import DTypeLike


class Column(NamedTuple):
    """Unit (SI, "" for a pure number), meaning in a few words, number type."""

    unit: str
    description: str
    dtype: DTypeLike = np.float64


STANDARD: dict[str, dict[str, Column]] = {
    "windows": {
        "time": Column("s", "end of the coupling window"),
        "window": Column("s", "length of the coupling window"),
        "step_min": Column("s", "smallest mechanical step"),
        "step_max": Column("s", "largest mechanical step"),
        "steps": Column("", "accepted mechanical steps", np.int64),
        "rejected": Column("", "rejected mechanical steps", np.int64),
        "iterations": Column("", "Newton iterations", np.int64),
        "factorisations": Column("", "factorised Jacobians", np.int64),
        "halvings": Column("", "rejected attempts at this window", np.int64),
        "exchanges": Column("", "times that motion was computed for it", np.int64),
        "motion_error": Column("", "sum of the estimated local errors of the steps of the motion"),
        "heat_error": Column("K", "sum of the estimated local errors of the steps of the heat"),
        "window_error": Column("K", "predicted less found temperatures, largest"),
        "wall_time": Column("s", "elapsed time on the clock"),
    },
    "ledger": {
        "kinetic": Column("J", "kinetic energy"),
        "strain": Column("J", "stored energy of the elements"),
        "work_loads": Column("J", "work of forces, moments and gravity"),
        "work_drive": Column("J", "work of driven joints"),
        "work_thermal": Column("J", "work of the changing temperature on the elements"),
        "contact_elastic": Column("J", "elastic energy of contacts"),
        "friction": Column("J", "dissipated by friction"),
        "hysteresis": Column("J", "dissipated by impacts"),
        "damping": Column("J", "dissipated by structural damping"),
        "numerical": Column("J", "dissipated by the integrator"),
        "defect": Column("J", "what the mechanical balance lacks"),
        "heat_stored": Column("J", "change of stored heat"),
        "heat_exchanged": Column("J", "frictional heat given to the thermal model"),
        "heat_defect": Column("J", "what the heat balance lacks"),
    },
    "probes": {
        "time": Column("s", "time"),
        "position": Column("m", "position"),
        "velocity": Column("m/s", "velocity"),
        "acceleration": Column("m/s^2", "acceleration"),
        "temperature": Column("K", "mean temperature of the section"),
    },
    "joints": {
        "time": Column("s", "time"),
        "orbit": Column(
            "m", "journal centre relative to the bearing, along the directions of the group"
        ),
        "towards_wall": Column("m", "way of a corner to its wall, which is at the clearance"),
        "clearance": Column("m", "clearance at the present temperatures"),
        "penetration": Column("m", "indentation, positive in contact"),
        "normal_force": Column("N", "normal contact force"),
        "friction_force": Column(
            "N", "friction force on the journal: planar, counter-clockwise; otherwise its size"
        ),
        "slip_speed": Column(
            "m/s", "speed of the journal's surface on the bearing's, as the friction force"
        ),
        "friction_vector": Column("N", "friction force on the journal, along the group's axes"),
        "approach": Column("m/s", "approach speed of the running impact; 0 none, -1 not known"),
        "angle": Column("rad", "prescribed rotation"),
        "torque": Column("N m", "torque of the drive"),
        "regime": Column("", "0 free flight, 1 impact, 2 slip, 3 stick", np.int8),
        "stuck": Column("", "1 where bristles stick", np.int8),
        "place": Column("m", "of the contact, along the bearing"),
        "temperature_journal": Column("K", "temperature of the journal"),
        "temperature_bearing": Column("K", "temperature of the bearing"),
    },
    "contacts": {
        "time": Column("s", "end of the coupling window"),
        "impacts": Column("", "onsets of each contact in the window", np.int64),
        "peak_force": Column("N", "largest normal force of each contact in the window"),
        "shares": Column(
            "", "of the window, of each contact, in free flight, impact, slip, stick", np.float32
        ),
        "friction_work": Column("J", "of each contact in the window"),
        "hysteresis": Column("J", "lost in the normal direction of each contact in the window"),
    },
    "events": {
        "time": Column("s", "when a contact began or ended"),
        "contact": Column("", "number of the contact, an attribute of its history", np.int32),
        "kind": Column("", "1 onset, 0 release", np.int8),
        "speed": Column("m/s", "of approach or separation"),
    },
    "bodies": {
        "position": Column("m", "nodes"),
        "axes": Column("", "section triads, rows e1, e2, e3"),
        "temperature": Column(
            "K, K/m, K/m",
            "mean, gradients along e2 and e3; of shells mean, 0 and gradient along the normal",
        ),
        "resultants": Column(
            "N, N m",
            "of each element: N, Q2, Q3, Mt, M2, M3; of shells per length N11, N22, N12, M11, M22, "
            "M12, Q1, Q2",
        ),
        "slopes": Column("1, 1, 1/m", "of shells: derivatives by u, by v, and by both"),
    },
    "surfaces": {
        "quads": Column("", "nodes at the corners of each element of a shell", np.int64),
        "sizes": Column("m", "what each element spans of the parameters u and v"),
    },
    "solids": {
        "position": Column("m", "nodes"),
        "temperature": Column("K", "of the nodes"),
        "stress": Column("Pa", "equivalent stress (von Mises), mean of each cell", np.float32),
    },
    "cells": {"cells": Column("", "nodes of each cell of a solid", np.int64)},
    "facets": {"facets": Column("", "nodes of each facet of its boundary", np.int64)},
    "skins": {
        "corners": Column("m", "of each facet, in the present pose"),
        "temperature": Column("K", "of each facet"),
        "light": Column("W/m^2", "absorbed by each facet: sun, reflected sun, planet"),
        "parts": Column("W/m^2", "absorbed by parts of each facet, row by row", np.float32),
    },
    "sky": {
        "time": Column("s", "time"),
        "sun": Column("", "direction to it"),
        "planet": Column("", "direction to its centre; zeros: there is none"),
        "flux": Column("W/m^2", "of sunlight that the planet leaves, on a plate that faces it"),
        "visible": Column("", "part of the sun's disc beside the planet"),
    },
    "frames": {"time": Column("s", "time of the frame")},
}
"""The first part of a group's name leads to its columns."""


def standard(group: str, name: str) -> Column | None:
    """Column ``name`` of ``group`` ("joints/hinge"), None when it is not a standard one."""
    kind = group.split("/", 1)[0]
    known = STANDARD.get(kind, {}).get(name)
    if known is None and kind == "ledger" and name.startswith("heat_"):
        return Column("J", f"heat that entered through {name.removeprefix('heat_')}")
    return known
