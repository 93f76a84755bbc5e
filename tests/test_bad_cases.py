# ruff: noqa: E501 (one line for each broken case)
"""Broken cases: each ends in exit code 2 with all its problems, and writes nothing."""

import contextlib
import copy
import os
import random
import re
import tomllib
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from coupling.casefile import from_text
from coupling.cli import app
from coupling.errors import BadCase
from coupling.overrides import toml

GOOD = """
title = "a boom on a hinge"

[time]
end = "2 s"
window = "0.5 s"

[section.tube]
kind = "tube"
mean_radius = "20 mm"
thickness = "1 mm"

[body.boom]
kind = "beam"
start = [0, 0, 0]
end = ["2 m", 0, 0]
elements = 4
normal = [0, 1, 0]
section = "tube"
material = "al6061"

[body.ball]
kind = "particle"
position = ["2 m", 0, 0]
mass = "1 kg"

[joint.hinge]
kind = "clearance_revolute"
journal = { body = "boom", at = "start" }
axis = [0, 0, 1]
radius = "10 mm"
clearance = "0.1 mm"
journal_material = "steel-304"
bearing_material = "al6061"
contact = { restitution = 0.9 }
friction = { coefficient = 0.1 }

[joint.tip]
kind = "spherical"
a = { body = "boom", at = "end" }
b = { body = "ball" }

[load.push]
kind = "force"
at = { body = "boom", at = "1 m" }
direction = [0, 1, 0]
amplitude = { ramp = { end = "1 s", from = 0, to = "10 N" } }

[thermal]
initial = "20 degC"

[thermal.wall.sun]
body = "boom"
start = "1 m"
side = [0, 1, 0]
hot = "40 degC"
cold = { start = "20 degC", end = "30 degC" }

[thermal.radiation.space]
body = "boom"
emissivity = 0.8
sink = "3 K"

[thermal.part.pin]
of = "hinge.journal"
material = "steel-304"
mass = "0.2 kg"

[thermal.link.pin]
a = { part = "pin" }
b = { body = "boom", at = "start" }
conductance = "1 W/K"

[probe.tip]
body = "boom"
at = "end"
"""


def changed(*changes: tuple[str, str]) -> str:
    text = GOOD
    for old, new in changes:
        assert text.count(old) == 1, f"{old!r} is not there once"
        text = text.replace(old, new)
    return text


def added(text: str) -> str:
    return GOOD + text


MADE_OF = "journal_material = 'steel-304'\nbearing_material = 'al6061'\n"
BALL = f"""
[joint.socket]
kind = "clearance_spherical"
journal = {{ body = "boom", at = "end" }}
radius = '1 cm'
clearance = '1 um'
{MADE_OF}"""
ROD = f"""
[joint.rod]
kind = "clearance_cylindrical"
journal = {{ body = 'boom', at = 'end' }}
axis = [1, 0, 0]
radius = '1 cm'
clearance = '0.1 mm'
length = '5 cm'
{MADE_OF}"""
SLIDER = f"""
[joint.slider]
kind = "clearance_translational"
journal = {{ body = "boom", at = "end" }}
axis = [1, 0, 0]
normal = [0, 1, 0]
length = '5 cm'
height = '2 cm'
clearance = '0.1 mm'
{MADE_OF}"""
TELESCOPE = """
[joint.tubes]
kind = "telescope"
inner = "boom"
outer = 'outer'
radius = '20.5 mm'
clearance = '1 mm'
"""
OUTER = """
[body.outer]
kind = "beam"
start = [-1, 0, 0]
end = [1, 0, 0]
elements = 2
section = "tube"
material = "al6061"
"""

SHELL = """
[body.s]
kind = "shell"
thickness = 0.01
material = 'al6061'
surface = { kind = "plate", length = 1, width = 1, elements = [2, 2] }
"""

# name: (text of the case, the problems as "path: part of the text")
BROKEN: dict[str, tuple[str | bytes, list[str]]] = {
    # ---- not a case at all
    "empty": ("", [": the file is empty"]),
    "blank": (" \n\t\n", [": the file is empty"]),
    "only a comment": ("# nothing\n", ["time: missing", "body: missing"]),
    "not TOML": ("[time]\nend = \n", ["line 2, column 7: not TOML"]),
    "unfinished string": ('title = "no end', ["end of file: not TOML"]),
    "binary": (b"\x89HDF\r\n\x1a\n\xff\xfe\x00", [": is not text"]),
    "zeros": (b"\x00" * 50, [": is a binary file"]),
    "nested too deeply": ("a = " + "[" * 5000, [": not TOML"]),
    "number of many digits": ("a = 1" + "0" * 5000, ["not TOML"]),
    "duplicate table": (
        added("[joint.tip]\nkind='clamp'\n"),
        ["line 77, column 11: not TOML: Cannot declare ('joint', 'tip') twice"],
    ),
    "duplicate key": (
        changed(("elements = 4", "elements = 4\nelements = 5")),
        ["line 18, column 13: not TOML: the key is there twice"],
    ),
    # ---- keys
    "unknown table": (
        added("[bodies.x]\nkind = 'beam'\n"),
        ["bodies: unknown key; did you mean 'body'"],
    ),
    "unknown key": (
        changed(('clearance = "0.1 mm"', 'clearence = "0.1 mm"')),
        [
            "joint.hinge.clearance: missing",
            "joint.hinge.clearence: unknown key; did you mean 'clearance'",
        ],
    ),
    "unknown key in an inline table": (
        changed(("{ restitution = 0.9 }", "{ restitutoin = 0.9 }")),
        ["joint.hinge.contact.restitutoin: unknown key; did you mean 'restitution'"],
    ),
    "unknown key, nothing like it": (
        changed(("elements = 4", "elements = 4\nzzz = 1")),
        ["body.boom.zzz: unknown key; known here: kind, start"],
    ),
    "keys of another section": (
        changed(('kind = "tube"', 'kind = "circle"')),
        [
            "section.tube.radius: missing",
            "section.tube.mean_radius: unknown key; did you mean 'radius'",
            "section.tube.thickness: unknown key",
        ],
    ),
    "no time": (changed(('[time]\nend = "2 s"\nwindow = "0.5 s"\n', "")), ["time: missing"]),
    "no body": ("[time]\nend = 1\nwindow = 1\n", ["body: missing"]),
    "empty body": ("[time]\nend = 1\nwindow = 1\n[body]\n", ["body: missing"]),
    "body without kind": (changed(('kind = "particle"\n', "")), ["body.ball.kind: missing"]),
    "unknown kind": (
        changed(('kind = "particle"', 'kind = "partical"')),
        [
            "body.ball.kind: expected 'beam', 'cable', 'shell', 'rigid' or 'particle', got 'partical'; did you mean 'particle'"
        ],
    ),
    "several missing": (
        changed(('section = "tube"\nmaterial = "al6061"\n', ""), ("start = [0, 0, 0]\n", "")),
        ["body.boom.section: missing", "body.boom.material: missing", "body.boom.start: missing"],
    ),
    "ground as a name": (
        added("[body.ground]\nkind='particle'\nposition=[9,9,9]\nmass=1\n"),
        ["body.ground: the name is taken"],
    ),
    "name with a space": (
        added('[probe."my tip"]\nbody="ball"\n'),
        ["probe.'my tip': a name consists of"],
    ),
    # ---- types
    "text for a count": (
        changed(("elements = 4", 'elements = "many"')),
        ["body.boom.elements: expected a positive integer, got 'many'"],
    ),
    "fraction for a count": (
        changed(("elements = 4", "elements = 4.5")),
        ["body.boom.elements: expected a positive"],
    ),
    "zero elements": (
        changed(("elements = 4", "elements = 0")),
        ["body.boom.elements: expected a positive"],
    ),
    "huge count": (
        changed(("elements = 4", "elements = 10_000_000_000")),
        ["body.boom.elements: expected at most"],
    ),
    "true for a number": (
        changed(('mass = "1 kg"', "mass = true")),
        ["body.ball.mass: expected a mass"],
    ),
    "number for a table": (
        changed(("{ coefficient = 0.1 }", "0.1")),
        ["joint.hinge.friction: expected a table, got 0.1"],
    ),
    "number for named tables": (
        "load = 3\n[time]\nend = 1\nwindow = 1\n[body.ball]\nkind='particle'\nposition=[0,0,0]\nmass=1\n",
        ["load: expected tables with names such as [load.NAME], got 3"],
    ),
    "array of tables": (added("[[output]]\nframes = 3\n"), ["output: expected a table, got"]),
    "two coordinates": (
        changed(('end = ["2 m", 0, 0]', 'end = ["2 m", 0]')),
        ["body.boom.end: expected three numbers"],
    ),
    "date": (changed(('mass = "1 kg"', "mass = 2024-01-01")), ["body.ball.mass: expected a mass"]),
    "number for a title": (
        changed(('title = "a boom on a hinge"', "title = 5")),
        ["title: expected text in quotes, got 5"],
    ),
    "NaN": (
        changed(('mass = "1 kg"', "mass = nan")),
        ["body.ball.mass: expected a mass that is finite"],
    ),
    "infinity": (
        changed(('end = "2 s"', "end = inf")),
        ["time.end: expected a time that is finite"],
    ),
    "huge number": (
        changed(('mass = "1 kg"', "mass = 1e999")),
        ["body.ball.mass: expected a mass that is finite"],
    ),
    "NaN in a vector": (
        changed(("start = [0, 0, 0]", "start = [0, nan, 0]")),
        ["body.boom.start[1]: expected a length"],
    ),
    # ---- units
    "unit of another dimension": (
        changed(('mass = "1 kg"', 'mass = "1 m"')),
        [
            "body.ball.mass: expected a mass such as '1.5 kg' (a plain number is in kg), but 'm' is the unit of a length"
        ],
    ),
    "coulomb for Celsius": (
        changed(('initial = "20 degC"', 'initial = "20 C"')),
        ["thermal.initial: expected a temperature"],
    ),
    "no unit": (changed(('mass = "1 kg"', 'mass = "1"')), ["body.ball.mass: '1' has no unit"]),
    "unknown unit": (
        changed(('radius = "10 mm"\nc', 'radius = "10 milimeter"\nc')),
        ["joint.hinge.radius: unknown unit 'milimeter'"],
    ),
    "unit in a coordinate": (
        changed(('["2 m", 0, 0]\nelem', '["2 m", "0 kg", 0]\nelem')),
        ["body.boom.end[1]: expected a length"],
    ),
    "hertz for a rate": (
        changed(
            (
                "friction = {",
                'angle = { s_curve = { rate = "1 Hz", rise = "1 s", total = "90 deg" } }\nfriction = {',
            )
        ),
        ["joint.hinge.angle.s_curve.rate: expected an angular speed"],
    ),
    # ---- geometry and physics
    "no length": (
        changed(('end = ["2 m", 0, 0]', "end = [0, 0, 0]")),
        ["body.boom.end: is the same point as start"],
    ),
    "parallel normal": (
        changed(("normal = [0, 1, 0]", "normal = [-3, 0, 0]")),
        ["body.boom.normal: must not be parallel"],
    ),
    "normal of a cable": (
        changed(('kind = "beam"', 'kind = "cable"')),
        ["body.boom.normal: does not go with a cable"],
    ),
    "zero axis": (
        changed(("axis = [0, 0, 1]", "axis = [0, 0, 0]")),
        ["joint.hinge.axis: expected a direction, got the zero"],
    ),
    "negative clearance": (
        changed(('clearance = "0.1 mm"', 'clearance = "-0.1 mm"')),
        ["joint.hinge.clearance: expected a length above 0 m, got '-0.1 mm'"],
    ),
    "clearance beyond the radius": (
        changed(('clearance = "0.1 mm"', 'clearance = "1 cm"')),
        ["joint.hinge.clearance: must be below the journal radius"],
    ),
    "restitution of zero": (
        changed(("restitution = 0.9", "restitution = 0")),
        ["joint.hinge.contact.restitution: expected a number above 0 and at most 1"],
    ),
    "restitution above one": (
        changed(("restitution = 0.9", "restitution = 1.1")),
        ["joint.hinge.contact.restitution: expected a number"],
    ),
    # ---- contact and friction
    "cylinder law without a length": (
        changed(
            (
                "{ restitution = 0.9 }",
                "{ stiffness = 'cylinder', value = 1e9, restitution = 0.001 }",
            )
        ),
        [
            "joint.hinge.contact.value: does not go with 'cylinder'",
            "joint.hinge.contact.restitution: must be at least 0.01 with dissipation 'exact', got 0.001",
        ],
    ),
    "cylinder law of a planar joint": (
        changed(("{ restitution = 0.9 }", "{ stiffness = 'cylinder' }")),
        ["joint.hinge.contact.stiffness: 'cylinder' needs the length of the bore: give the joint"],
    ),
    "mistyped stiffness": (
        changed(("{ restitution = 0.9 }", "{ stiffness = 'cilinder' }")),
        [
            "joint.hinge.contact.stiffness: expected 'hertz-external', 'hertz-internal', 'cylinder' or 'linear', got 'cilinder'; did you mean 'cylinder'?"
        ],
    ),
    "flanges of a planar joint": (
        changed(
            (
                "axis = [0, 0, 1]",
                "axis = [0, 0, 1]\naxial_clearance = '1 mm'\nflange_radius = '9 mm'",
            )
        ),
        [
            "joint.hinge.axial_clearance: needs a length; without one the pin is held",
            "joint.hinge.flange_radius: must exceed the radius of the bore, 0.0101 m",
        ],
    ),
    "flange without a way to it": (
        changed(("axis = [0, 0, 1]", "axis = [0, 0, 1]\nlength = '1 cm'\nflange_radius = '2 cm'")),
        ["joint.hinge.flange_radius: needs an axial_clearance"],
    ),
    "friction law of another language": (
        changed(("{ coefficient = 0.1 }", "{ coefficient = 0.1, law = 'lu-gre' }")),
        [
            "joint.hinge.friction.law: expected 'regularised', 'stick', 'stribeck', 'lugre' or 'rising', got 'lu-gre'; did you mean 'lugre'?"
        ],
    ),
    "keys of other friction laws": (
        changed(
            (
                "{ coefficient = 0.1 }",
                "{ coefficient = 0.1, static_coefficient = 0.2, presliding = '1 um', rise_rate = 0.5, viscous = 1 }",
            )
        ),
        [
            "joint.hinge.friction.static_coefficient: belongs to law = 'stick', 'stribeck', 'lugre' or 'rising', and this one is 'regularised'",
            "joint.hinge.friction.presliding: belongs to law = 'stick', 'lugre' or 'rising'",
            "joint.hinge.friction.rise_rate: belongs to law = 'rising'",
            "joint.hinge.friction.viscous: belongs to law = ",
        ],
    ),
    "keys of regularised laws with true stick": (
        changed(
            (
                "{ coefficient = 0.1 }",
                "{ coefficient = 0.1, law = 'stick', regularisation_speed = '1 mm/s', stribeck_speed = '1 mm/s' }",
            )
        ),
        [
            "joint.hinge.friction.regularisation_speed: belongs to law = 'regularised' or 'stribeck', and this one is 'stick'",
            "joint.hinge.friction.stribeck_speed: belongs to law = 'stribeck' or 'lugre'",
        ],
    ),
    "static below kinetic": (
        changed(
            (
                "{ coefficient = 0.1 }",
                "{ coefficient = 0.1, static_coefficient = 0.05, law = 'stick' }",
            )
        ),
        [
            "joint.hinge.friction.static_coefficient: must not be below the kinetic coefficient, 0.1, got 0.05"
        ],
    ),
    "laws between two coefficients with one": (
        changed(("{ coefficient = 0.1 }", "{ coefficient = 0.1, law = 'rising' }")),
        ["joint.hinge.friction.static_coefficient: missing (law = 'rising' goes between the two)"],
    ),
    "stribeck speed without a fall": (
        changed(
            (
                "{ coefficient = 0.1 }",
                "{ coefficient = 0.1, law = 'lugre', stribeck_speed = '1 mm/s' }",
            )
        ),
        ["joint.hinge.friction.stribeck_speed: needs a static_coefficient"],
    ),
    "bristles that bear nothing": (
        changed(
            ("{ coefficient = 0.1 }", "{ coefficient = 0, law = 'stick', presliding = '-1 um' }")
        ),
        ["joint.hinge.friction.presliding: expected a length above 0 m"],
    ),
    "stick without friction": (
        changed(("{ coefficient = 0.1 }", "{ coefficient = 0, law = 'stick' }")),
        [
            "joint.hinge.friction.coefficient: must be above 0 with law = 'stick'; without friction leave out"
        ],
    ),
    "friction table": (
        changed(
            (
                "{ coefficient = 0.1 }",
                "{ coefficient = 0.1, temperature_slope = 1e-3, reference_temperature = 300, table = [[300, 1], [200, 2]] }",
            )
        ),
        [
            "joint.hinge.friction.table: the temperatures must increase",
            "joint.hinge.friction.temperature_slope: does not go with a table",
            "joint.hinge.friction.reference_temperature: does not go with a table",
        ],
    ),
    "friction table with odd rows": (
        changed(
            (
                "{ coefficient = 0.1 }",
                "{ coefficient = 0.1, table = [[300], ['1 s', 2], [300, -1]] }",
            )
        ),
        [
            "joint.hinge.friction.table[0]: expected a pair",
            "joint.hinge.friction.table[1][0]: expected a temperature",
            "joint.hinge.friction.table[2][1]: expected a number at least 0",
        ],
    ),
    "friction table of one row": (
        changed(("{ coefficient = 0.1 }", "{ coefficient = 0.1, table = [[300, 1]] }")),
        ["joint.hinge.friction.table: needs two or more rows"],
    ),
    "ball that is a cylinder and as wide as its socket": (
        added(BALL.replace("'1 um'", "'1 cm'") + "contact = { stiffness = 'cylinder' }\n"),
        [
            "joint.socket.clearance: must be below the radius of the ball, 0.01 m",
            "joint.socket.contact.stiffness: a ball is no cylinder",
        ],
    ),
    "ball outside its socket": (
        added(BALL + "bearing = { body = 'ground', position = [2, '1 mm', 0] }\n"),
        [
            "joint.socket.journal: starts 0.001 m off the centre of the bearing, more than the clearance, 1e-06 m"
        ],
    ),
    "socket of unknown material in a particle": (
        added(
            BALL.replace("bearing_material = 'al6061'", "bearing_material = 'all6061'")
            + "bearing = { body = 'ball' }\n"
        ),
        [
            "joint.socket.bearing_material: there is no material 'all6061'; did you mean 'al6061'",
            "joint.socket.bearing.body: 'ball' is a particle: it has no orientation",
        ],
    ),
    "rod beside its bush": (
        added(ROD + "bearing = { body = 'ground', position = [3, '1 mm', 0] }\n"),
        [
            "joint.rod.journal: starts 0.001 m off the centre of the bearing across the axis, more than the clearance, 0.0001 m"
        ],
    ),
    "rod without a length, of a particle": (
        added(
            ROD.replace("length = '5 cm'", "").replace("body = 'boom', at = 'end'", "body = 'ball'")
        ),
        ["joint.rod.length: missing (of the bush"],
    ),
    "rod of a particle": (
        added(ROD.replace("body = 'boom', at = 'end'", "body = 'ball'")),
        [
            "joint.rod.journal.body: 'ball' is a particle: it has no orientation and cannot be held by a clearance_cylindrical"
        ],
    ),
    "slider in a skew guide": (
        added(
            SLIDER.replace("normal = [0, 1, 0]", "normal = [1, 1, 0]").replace(
                "clearance = '0.1 mm'", "clearance = '1 cm'"
            )
        ),
        [
            "joint.slider.normal: must be at right angles to axis; the cosine is 0.707",
            "joint.slider.clearance: must be below half of the height, 0.01 m",
            "joint.slider.corner_radius: missing (a Hertz stiffness needs it",
        ],
    ),
    "slider with the laws of a bore": (
        added(SLIDER + "contact = { stiffness = 'hertz-internal' }\ncorner_radius = '2 cm'\n"),
        [
            "joint.slider.contact.stiffness: corners touch plane walls",
            "joint.slider.corner_radius: must not exceed half of the slider, 0.01 m",
        ],
    ),
    "corners that are not used": (
        added(SLIDER + "contact = { value = 1e9 }\ncorner_radius = '2 mm'\n"),
        ["joint.slider.corner_radius: is not used: contact.value is given"],
    ),
    "slider outside its guide": (
        added(
            SLIDER
            + "corner_radius = '1 mm'\nbearing = { body = 'ground', position = [2, '1 mm', 0] }\n"
        ),
        [
            "joint.slider.journal: starts 0.001 m off the centre of the bearing along the normal, more than the clearance, 0.0001 m"
        ],
    ),
    "pin beyond its flange": (
        changed(
            (
                "axis = [0, 0, 1]",
                "axis = [0, 0, 1]\nlength = '2 cm'\naxial_clearance = '0.1 mm'\nbearing = { body = 'ground', position = [0, 0, '1 mm'] }",
            )
        ),
        [
            "joint.hinge.journal: starts 0.001 m off the centre of the bearing along the axis, more than the clearance, 0.0001 m"
        ],
    ),
    "telescope of one tube": (
        added(TELESCOPE.replace("'outer'", "'boom'") + "preload = { force = '-1 N' }\n"),
        ["joint.tubes.preload.force: ", "joint.tubes.preload.stiffness: "],
    ),
    "telescope of what is no tube": (
        added(TELESCOPE.replace("'outer'", "'ball'")),
        ["joint.tubes.outer: 'ball' is no beam: only beams telescope"],
    ),
    "telescope of nothing": (
        added(TELESCOPE.replace("'outer'", "'boomm'") + "stations = -1\n"),
        ["joint.tubes.stations: expected an integer of at least 0, got -1"],
    ),
    "telescope of unknown tubes": (
        added(TELESCOPE.replace("'outer'", "'boomm'")),
        ["joint.tubes.outer: there is no body 'boomm'; did you mean 'boom'"],
    ),
    "telescope with its mouth at the wrong end": (
        added(OUTER + TELESCOPE + "mouth = 'start'\n"),
        [
            "joint.tubes.mouth: is 1 m away from the axis of 'boom', more than the radius, 0.0215 m; did you mean the other end?"
        ],
    ),
    "telescope colder than the data of its tubes": (
        added(OUTER + TELESCOPE + "reference_temperature = '1 K'\n"),
        [
            "material.al6061: poissons_ratio needed from 1 K",
            "material.al6061: youngs_modulus needed from 1 K",
            "material.al6061: expansion needed from 1 K",
            "material.al6061: conductivity needed from 1 K",
            "material.al6061: heat_capacity needed from 1 K",
        ],
    ),
    "heat of a telescope": (
        added(
            OUTER
            + TELESCOPE
            + "[thermal.part.tube]\nof = 'tubes.inner'\nmaterial = 'al6061'\nmass = 1\n[thermal.part.side]\nof = 'tubes.journal'\nmaterial = 'al6061'\nmass = 1\n"
        ),
        [
            "thermal.part.tube.of: expected 'JOINT.journal' or 'JOINT.bearing', got 'tubes.inner'",
            "thermal.part.side.of: joint.tubes is a telescope: it has no journal",
        ],
    ),
    "linear contact without value": (
        changed(("{ restitution = 0.9 }", "{ stiffness = 'linear' }")),
        ["joint.hinge.contact.value: missing"],
    ),
    "unit of the other contact": (
        changed(("{ restitution = 0.9 }", "{ stiffness = 'linear', value = '1 N/m^1.5' }")),
        ["joint.hinge.contact.value: expected a stiffness"],
    ),
    "unknown hysteresis law": (
        changed(("{ restitution = 0.9 }", "{ dissipation = 'florse' }")),
        [
            "joint.hinge.contact.dissipation: there is no hysteresis law 'florse'; did you mean 'flores'"
        ],
    ),
    "emissivity above one": (
        changed(("emissivity = 0.8", "emissivity = 1.2")),
        ["thermal.radiation.space.emissivity: expected a number at least 0 and at most 1"],
    ),
    "below absolute zero": (
        changed(('initial = "20 degC"', 'initial = "-280 degC"')),
        ["thermal.initial: expected a temperature above 0 K"],
    ),
    "history below absolute zero": (
        changed(
            (
                'hot = "40 degC"',
                'hot = { sine = { amplitude = "400 K", frequency = 1, offset = "20 degC" } }',
            )
        ),
        ["thermal.wall.sun.hot: falls to -106.85 K"],
    ),
    "tube without a bore": (
        changed(('thickness = "1 mm"', 'thickness = "4 cm"')),
        ["section.tube.thickness: must be less than twice"],
    ),
    "odd number of wall points": (
        changed(('initial = "20 degC"', 'initial = "20 degC"\nwall_points = 5')),
        ["thermal.wall_points: must be 1, or an even number"],
    ),
    "alpha of the integrator": (
        added("[integrator]\nalpha = 0.1\n"),
        ["integrator.alpha: expected a number"],
    ),
    "steps in the wrong order": (
        added("[integrator]\nlargest_step=1e-3\nsmallest_step=1e-2\n"),
        ["integrator.smallest_step: must not exceed"],
    ),
    "Poisson's ratio of one half": (
        added(
            "[material.m]\ndensity=1\nyoungs_modulus=1\npoissons_ratio=0.5\nexpansion=0\nconductivity=1\nheat_capacity=1\n"
        ),
        ["material.m.poissons_ratio: expected a number above -1 and below 0.5, got 0.5"],
    ),
    "modulus that becomes negative": (
        added(
            "[material.m]\ndensity=1\nyoungs_modulus={polynomial=[1e9, -1e7], reference=300, range=[200, 500]}\npoissons_ratio=0.3\nexpansion=0\nconductivity=1\nheat_capacity=1\n"
        ),
        ["material.m: youngs_modulus must be positive"],
    ),
    "polynomial without range": (
        added(
            "[material.m]\ndensity=1\nyoungs_modulus={polynomial=[1e9]}\npoissons_ratio=0.3\nexpansion=0\nconductivity=1\nheat_capacity=1\n"
        ),
        ["material.m.youngs_modulus.range: missing"],
    ),
    "material table that goes back": (
        added(
            "[material.m]\ndensity=1\nyoungs_modulus={table=[[300,1e9],[200,2e9]]}\npoissons_ratio=0.3\nexpansion=0\nconductivity=1\nheat_capacity=1\n"
        ),
        ["material.m.youngs_modulus.table: the temperatures must increase"],
    ),
    # ---- time
    "not a whole number of windows": (
        changed(('window = "0.5 s"', 'window = "0.3 s"')),
        ["time.end: must be a whole number of windows of 0.3 s, got 2 s"],
    ),
    "window beyond the end": (
        changed(('window = "0.5 s"', 'window = "5 s"')),
        ["time.end: must be a whole number"],
    ),
    "zero window": (
        changed(('window = "0.5 s"', "window = 0")),
        ["time.window: expected a time above 0 s"],
    ),
    "ramp that ends before it starts": (
        changed(('{ end = "1 s", from', '{ start = "2 s", end = "1 s", from')),
        ["load.push.amplitude.ramp.end: must come after the start"],
    ),
    "history of two shapes": (
        changed(
            (
                'hot = "40 degC"',
                "hot = { step = { at = 1, from = 300, to = 310 }, table = [[0, 300]] }",
            )
        ),
        ["thermal.wall.sun.hot: expected one of table, ramp, step, sine, s_curve, got 2 keys"],
    ),
    "history of no known shape": (
        changed(('hot = "40 degC"', "hot = { rampe = { end = 1, from = 300, to = 310 } }")),
        ["thermal.wall.sun.hot.rampe: unknown key; did you mean 'ramp'"],
    ),
    "table that goes back in time": (
        changed(('hot = "40 degC"', "hot = { table = [[1, 300], [0, 310]] }")),
        ["thermal.wall.sun.hot.table: the times must increase"],
    ),
    "row of three": (
        changed(('hot = "40 degC"', "hot = { table = [[0, 300, 1]] }")),
        ["thermal.wall.sun.hot.table[0]: expected a pair"],
    ),
    "temperature in watts in a table": (
        changed(('hot = "40 degC"', "hot = { table = [[0, '1 W']] }")),
        ["thermal.wall.sun.hot.table[0][1]: expected a temperature"],
    ),
    "s_curve too short": (
        changed(
            (
                "friction = {",
                "angle = { s_curve = { rate = 1, rise = 2, total = 1 } }\nfriction = {",
            )
        ),
        ["joint.hinge.angle.s_curve.total: is reached before the rate has risen"],
    ),
    "end missing of two histories": (
        changed(('{ start = "20 degC", end = "30 degC" }', '{ start = "20 degC" }')),
        ["thermal.wall.sun.cold.end: missing"],
    ),
    # ---- references
    "no such section": (
        changed(('section = "tube"', 'section = "tub"')),
        ["body.boom.section: there is no section 'tub'; did you mean 'tube'"],
    ),
    "no such material": (
        changed(('section = "tube"\nmaterial = "al6061"', 'section = "tube"\nmaterial = "al6016"')),
        ["body.boom.material: there is no material 'al6016'; did you mean 'al6061'"],
    ),
    "no such body": (
        changed(('b = { body = "ball" }', 'b = { body = "bal" }')),
        ["joint.tip.b.body: there is no body 'bal'; did you mean 'ball'"],
    ),
    "no such body for a probe": (
        changed(('[probe.tip]\nbody = "boom"', '[probe.tip]\nbody = "bom"')),
        ["probe.tip.body: there is no body 'bom'; did you mean 'boom'"],
    ),
    "no such joint": (
        changed(('of = "hinge.journal"', 'of = "hing.journal"')),
        ["thermal.part.pin.of: there is no joint 'hing'; did you mean 'hinge'"],
    ),
    "no such side": (
        changed(('of = "hinge.journal"', 'of = "hinge.pin"')),
        ["thermal.part.pin.of: expected 'JOINT.journal' or 'JOINT.bearing'"],
    ),
    "side of a joint without clearance": (
        changed(('of = "hinge.journal"', 'of = "tip.journal"')),
        ["thermal.part.pin.of: joint.tip is a spherical"],
    ),
    "no such part": (
        changed(('a = { part = "pin" }', 'a = { part = "pine" }')),
        ["thermal.link.pin.a.part: there is no part 'pine'; did you mean 'pin'"],
    ),
    "no such solver": (
        changed(('initial = "20 degC"', 'initial = "20 degC"\nsolver = "lines"')),
        ["thermal.solver: there is no thermal solver 'lines'; did you mean 'line'"],
    ),
    "no node there": (
        changed(
            ('at = "1 m"', 'at = "1.1 m"'), ("elements = 4", 'elements = 2\nelement = "beam3333"')
        ),
        [
            "load.push.at.at: these elements take points at their nodes only; the nearest are at 1 m and 1.5 m"
        ],
    ),
    "beyond the end": (
        changed(('at = "1 m"', 'at = "3 m"')),
        ["load.push.at.at: lies beyond the end: the body is 2 m long"],
    ),
    "no place": (
        changed(('{ body = "boom", at = "1 m" }', '{ body = "boom" }')),
        ["load.push.at.at: missing"],
    ),
    "place of a particle": (
        changed(('b = { body = "ball" }', 'b = { body = "ball", at = "end" }')),
        ["joint.tip.b.at: 'ball' is a particle"],
    ),
    "load on the ground": (
        changed(('{ body = "boom", at = "1 m" }', '{ body = "ground" }')),
        ["load.push.at.body: a load acts on a body"],
    ),
    "moment on a particle": (
        added("[load.m]\nkind='moment'\nat={body='ball'}\ndirection=[1,0,0]\namplitude=1\n"),
        ["load.m.at.body: 'ball' is a particle: it has no orientation and takes no moment"],
    ),
    "drive on a particle": (
        added("[joint.d]\nkind='revolute'\na={body='ball'}\naxis=[0,0,1]\nangle=1\n"),
        ["joint.d.a.body: 'ball' is a particle: it has no orientation and cannot be driven"],
    ),
    "clamped particle": (
        added("[joint.c]\nkind='clamp'\na={body='ball'}\n"),
        ["joint.c.a.body: 'ball' is a particle"],
    ),
    "points apart": (
        changed(('a = { body = "boom", at = "end" }', 'a = { body = "boom", at = "1 m" }')),
        ["joint.tip: its points a and b are 1 m apart"],
    ),
    "journal outside its bearing": (
        changed(
            (
                "axis = [0, 0, 1]",
                'bearing = { body = "ground", position = [0, "1 mm", 0] }\naxis = [0, 0, 1]',
            )
        ),
        ["joint.hinge.journal: starts 0.001 m off the centre of the bearing"],
    ),
    "joint with itself": (
        added("[joint.s]\nkind='spherical'\na={body='ball'}\nb={body='ball'}\n"),
        ["joint.s: joins a point of 'ball' with itself"],
    ),
    "joint on the ground": (
        added("[joint.s]\nkind='spherical'\na={body='ground'}\n"),
        ["joint.s: has the ground on both sides"],
    ),
    "the same joint twice": (
        added("[joint.s]\nkind='spherical'\na={body='ball'}\nb={body='boom',at='2 m'}\n"),
        ["joint.s: holds the same points in the same way as joint.tip"],
    ),
    "distance of nothing": (
        added("[joint.s]\nkind='distance'\na={body='ball'}\nb={body='ground'}\n"),
        ["joint.s: its two points coincide; give the ground a position"],
    ),
    "journal of two parts": (
        added("[thermal.part.two]\nof='hinge.journal'\nmaterial='invar'\nmass=1\n"),
        ["thermal.part.two.of: 'hinge.journal' is thermal.part.pin already"],
    ),
    "part with the name of a body": (
        added("[thermal.part.boom]\nmaterial='invar'\nmass=1\n"),
        ["thermal.part.boom: a body has the same name"],
    ),
    "heat on a particle": (
        changed(
            ('[thermal.radiation.space]\nbody = "boom"', '[thermal.radiation.space]\nbody = "ball"')
        ),
        ["thermal.radiation.space.body: 'ball' is a particle"],
    ),
    "wall beyond the body": (
        changed(('start = "1 m"', 'start = "1 m"\nend = "3 m"')),
        ["thermal.wall.sun.end: lies outside body 'boom', from 0 to 2 m, got 3 m"],
    ),
    "wall that ends before it starts": (
        changed(('start = "1 m"', 'start = "1 m"\nend = "0.5 m"')),
        ["thermal.wall.sun.end: must be beyond the start"],
    ),
    "wall between the nodes": (
        changed(('start = "1 m"', 'start = "1.1 m"\nend = "1.2 m"')),
        ["thermal.wall.sun: no node of body 'boom' lies on this stretch"],
    ),
    "side along the body": (
        changed(("side = [0, 1, 0]", "side = [1, 0, 0]")),
        ["thermal.wall.sun.side: is parallel to body 'boom'"],
    ),
    "two walls on one stretch": (
        added("[thermal.wall.two]\nbody='boom'\nend=1.5\nside=[0,1,0]\nhot=300\ncold=300\n"),
        ["thermal.wall.two: gives the temperature of 'boom' at 1 m, and so does thermal.wall.sun"],
    ),
    "wall and fixed end": (
        added("[thermal.fixed.f]\nat={body='boom',at='end'}\ntemperature=300\n"),
        ["thermal.fixed.f: gives the temperature of 'boom' at 2 m, and so does thermal.wall.sun"],
    ),
    "prescribed in part": (
        changed(('initial = "20 degC"', 'initial = "20 degC"\nsolver = "prescribed"')),
        ["body.boom: the prescribed solver needs a wall along all of it; none at 0 m"],
    ),
    "link to itself": (
        changed(('b = { body = "boom", at = "start" }\ncond', 'b = { part = "pin" }\ncond')),
        ["thermal.link.pin: joins a place with itself"],
    ),
    "link to nothing": (
        changed(('b = { body = "boom", at = "start" }\ncond', "cond")),
        ["thermal.link.pin.b: give either b or a temperature"],
    ),
    "outside the data of a material": (
        changed(
            ('material = "al6061"\n\n[body.ball]', 'material = "al6061-paper"\n\n[body.ball]'),
            ('hot = "40 degC"', "hot = { ramp = { end = 4, from = 300, to = 700 } }"),
        ),
        [
            f"material.al6061-paper: {name} needed from 293.15 K to 500 K by this run, its data end at 473.15 K"
            for name in (
                "youngs_modulus",
                "poissons_ratio",
                "expansion",
                "conductivity",
                "heat_capacity",
            )
        ],
    ),
    "outside the data of one's own material": (
        changed(('section = "tube"\nmaterial = "al6061"', 'section = "tube"\nmaterial = "m"'))
        + "[material.m]\ndensity=1\nyoungs_modulus={table=[[300,1e9],[400,2e9]]}\npoissons_ratio=0.3\nexpansion=0\nconductivity=1\nheat_capacity=1\n",
        [
            "material.m: youngs_modulus needed from 293.15 K to 313.15 K by this run, its data begin at 300 K"
        ],
    ),
    "no such mesh file": (
        changed(('start = [0, 0, 0]\nend = ["2 m", 0, 0]\nelements = 4', 'mesh = "boom.vtu"')),
        ["body.boom: boom.vtu: there is no such file"],
    ),
    "mesh and ends": (
        changed(("elements = 4", 'mesh = "boom.vtu"')),
        ["body.boom.start: does not go with mesh", "body.boom.end: does not go with mesh"],
    ),
    "region without mesh": (
        changed(("elements = 4", "elements = 4\nregion = 'x'")),
        ["body.boom.region: belongs to a mesh"],
    ),
    # ---- temperatures of shells
    "shell without a wall, prescribed": (
        changed(('initial = "20 degC"', 'initial = "20 degC"\nsolver = "prescribed"')) + SHELL,
        [
            "body.boom: the prescribed solver needs a wall",
            "body.s: the prescribed solver needs its wall or field",
        ],
    ),
    "wall of a shell like that of a beam": (
        added(
            SHELL + "[thermal.wall.s]\nbody='s'\nstart=0\nend=1\nside=[0,0,1]\n"
            "hot={start=300,end=310}\ncold=290\n"
        ),
        [
            "thermal.wall.s.start: does not go with a shell: its wall is all of it",
            "thermal.wall.s.end: does not go with a shell",
            "thermal.wall.s.side: does not go with a shell: hot is on the side of its normal",
            "thermal.wall.s.hot: a shell has no start and end",
        ],
    ),
    "two walls of a shell": (
        added(
            SHELL + "[thermal.wall.s]\nbody='s'\ntemperature=300\n"
            "[thermal.wall.t]\nbody='s'\ntemperature=300\n"
        ),
        ["thermal.wall.t: gives the temperature of 's', and so does thermal.wall.s"],
    ),
    "heat on a shell": (
        added(
            SHELL + "[thermal.wall.s]\nbody='s'\ntemperature=300\n"
            "[thermal.flux.s]\nbody='s'\ndensity=100\n"
            "[thermal.fixed.s]\nat={body='s',at='end'}\ntemperature=300\n"
        ),
        [
            "thermal.flux.s.face: missing (of a shell 'top'",
            "thermal.fixed.s.at.at: there is no place 'end'",
        ],
    ),
    "shell hotter than its data": (
        added(
            SHELL.replace("'al6061'", "'al6061-paper'")
            + "[thermal.wall.s]\nbody='s'\nhot=500\ncold=300\n"
        ),
        [
            f"material.al6061-paper: {name} needed from 293.15 K to 500 K"
            for name in (
                "youngs_modulus",
                "poissons_ratio",
                "expansion",
                "conductivity",
                "heat_capacity",
            )
        ],
    ),
    "wall with one side": (
        changed(('hot = "40 degC"\n', "")),
        ["thermal.wall.sun.hot: missing (give hot and cold, or a temperature)"],
    ),
    "wall hot everywhere and on one side": (
        changed(('hot = "40 degC"', 'temperature = 300\nhot = "40 degC"')),
        [
            f"thermal.wall.sun.{key}: does not go with temperature"
            for key in ("cold", "hot", "side")
        ],
    ),
    "wall without a side": (
        changed(("side = [0, 1, 0]\n", "")),
        ["thermal.wall.sun.side: missing (direction of the hot side)"],
    ),
    # ---- rigid bodies, shells, arcs
    "impossible inertia": (
        added("[body.r]\nkind='rigid'\nposition=[0,0,0]\nmass=1\ninertia=[1,1,3]\n"),
        ["body.r.inertia: no body has it: one principal moment, 3 kg m^2, exceeds the sum"],
    ),
    "four moments of inertia": (
        added("[body.r]\nkind='rigid'\nposition=[0,0,0]\nmass=1\ninertia=[1,1,1,1]\n"),
        ["body.r.inertia: expected 3, 6 or 9 numbers, got 4"],
    ),
    "negative inertia": (
        added("[body.r]\nkind='rigid'\nposition=[0,0,0]\nmass=1\ninertia=[1,1,1,2,0,0]\n"),
        ["body.r.inertia: has a negative principal moment, -1 kg m^2"],
    ),
    "inertia without symmetry": (
        added("[body.r]\nkind='rigid'\nposition=[0,0,0]\nmass=1\ninertia=[1,0,0,0.1,1,0,0,0,1]\n"),
        ["body.r.inertia: the nine numbers are not those of a symmetric matrix"],
    ),
    "inertia of a mass": (
        added("[body.r]\nkind='rigid'\nposition=[0,0,0]\nmass=1\ninertia=['1 kg',1,1]\n"),
        ["body.r.inertia[0]: expected a moment of inertia such as '0.2 kg m^2'"],
    ),
    "skew axes": (
        added(
            "[body.r]\nkind='rigid'\nposition=[0,0,0]\nmass=1\ninertia=[1,1,1]\naxes=[[1,0,0],[1,1,0]]\n"
        ),
        ["body.r.axes: the first two directions are not at right angles"],
    ),
    "left-handed axes": (
        added(
            "[body.r]\nkind='rigid'\nposition=[0,0,0]\nmass=1\ninertia=[1,1,1]\naxes=[[1,0,0],[0,1,0],[0,0,-1]]\n"
        ),
        ["body.r.axes: the third direction is not that of first x second"],
    ),
    "zero axis among axes": (
        added(
            "[body.r]\nkind='rigid'\nposition=[0,0,0]\nmass=1\ninertia=[1,1,1]\naxes=[[1,0,0],[0,0,0]]\n"
        ),
        ["body.r.axes[1]: expected a direction, got the zero vector"],
    ),
    "shell without thickness": (
        added(
            "[body.s]\nkind='shell'\nmaterial='al6061'\n[body.s.surface]\nkind='plate'\nlength=1\nwidth=1\nelements=[2,2]\n"
        ),
        ["body.s.thickness: missing (of the wall)"],
    ),
    "unknown surface": (
        added(
            "[body.s]\nkind='shell'\nthickness=0.1\nmaterial='al6061'\nsurface={kind='plat',length=1}\n"
        ),
        [
            "body.s.surface.kind: expected 'plate', 'tube', 'annulus' or 'sphere', got 'plat'; did you mean 'plate'"
        ],
    ),
    "faulty surface": (
        added(
            "[body.s]\nkind='shell'\nthickness=0.1\nmaterial='al6061'\nsurface={kind='tube',radius='-1 m',elements=[4],start='400 deg'}\n"
        ),
        [
            "body.s.surface.radius: expected a length above 0 m",
            "body.s.surface.length: missing (along z)",
            "body.s.surface.elements: expected a pair",
            "body.s.surface.start: expected an angle at least -6.28319 rad and at most 6.28319 rad",
        ],
    ),
    "annulus inside out": (
        added(
            "[body.s]\nkind='shell'\nthickness=0.1\nmaterial='al6061'\nsurface={kind='annulus',inner_radius=2,outer_radius=1,end='90 deg',elements=[2,2]}\n"
        ),
        ["body.s.surface.outer_radius: must exceed the inner one, 2 m"],
    ),
    "no node of the shell": (
        added(
            "[body.s]\nkind='shell'\nthickness=0.1\nmaterial='al6061'\nsurface={kind='plate',length=1,width=1,elements=[2,2]}\n[thermal.wall.s]\nbody='s'\ntemperature=300\n[probe.s]\nbody='s'\nposition=[0.4,0,0]\n"
        ),
        ["probe.s.position: no node of the shell is there; the nearest is at [0.5, 0, 0] m"],
    ),
    "nowhere on the shell": (
        added(
            "[body.s]\nkind='shell'\nthickness=0.1\nmaterial='al6061'\nsurface={kind='plate',length=1,width=1,elements=[2,2]}\n[thermal.wall.s]\nbody='s'\ntemperature=300\n[probe.s]\nbody='s'\n"
        ),
        ["probe.s.position: missing (where on 's': the place of a node)"],
    ),
    "heat on a rigid body": (
        added(
            "[body.r]\nkind='rigid'\nposition=[0,0,0]\nmass=1\ninertia=[1,1,1]\n[thermal.flux.r]\nbody='r'\ndensity=1\n"
        ),
        ["thermal.flux.r.body: 'r' is a rigid body: it carries no temperature"],
    ),
    "arc and end": (
        changed(("elements = 4", "elements = 4\narc = { center=[1,0,0], axis=[0,0,1], angle=1 }")),
        ["body.boom.arc: does not go with end"],
    ),
    "arc about its start": (
        changed(
            ('end = ["2 m", 0, 0]', "arc = { center=[0,0,0], axis=[0,0,1], angle=1 }"),
            ('at = "1 m"', 'at = "0 m"'),
        ),
        ["body.boom.arc.center: the start of the body lies on the axis of the arc"],
    ),
    "nodes that do not rise": (
        changed(("elements = 4", "nodes = [0, 1, 0.5, 2]")),
        ["body.boom.nodes: expected distances that begin with 0 and increase"],
    ),
    "nodes that end elsewhere": (
        changed(("elements = 4", "nodes = [0, 1, 1.5]")),
        ["body.boom.nodes: must end where the body does, at 2 m"],
    ),
    "element of a cable": (
        changed(
            ('kind = "beam"', 'kind = "cable"\nelement = "beam3243"'),
            ("normal = [0, 1, 0]\n", ""),
            ('at = { body = "boom", at = "1 m" }', 'at = { body = "boom", at = "1 m" }'),
        ),
        ["body.boom.element: does not go with a cable"],
    ),
    "offset on a particle and of the ground": (
        added(
            "[joint.d]\nkind='distance'\na={body='ball', offset=[0,0,1]}\nb={body='ground', offset=[0,0,1]}\n"
        ),
        [
            "joint.d.a.offset: 'ball' is a particle: it is one point, leave offset out",
            "joint.d.b.offset: the ground has no such point",
        ],
    ),
    "offset of a whole arm": (
        changed(
            (
                'a = { body = "boom", at = "end" }',
                'a = { body = "boom", at = "end", offset = [0, "3 mm", 0] }',
            )
        ),
        ["joint.tip: its points a and b are 0.003 m apart"],
    ),
    "edges that are not there": (
        added(
            "[body.s]\nkind='shell'\nthickness=0.1\nmaterial='al6061'\nsurface={kind='tube',length=1,radius=1,elements=[4,2]}\n"
            "[thermal.wall.s]\nbody='s'\ntemperature=300\n"
            "[joint.a]\nkind='clamp'\na={body='s',edge='u-start'}\n"
            "[joint.b]\nkind='clamp'\na={body='s',edge='v-start'}\nb={body='boom',at='end'}\n"
            "[joint.c]\nkind='revolute'\na={body='s',edge='v-end'}\naxis=[0,0,1]\n"
            "[joint.d]\nkind='clamp'\na={body='boom',at='end',edge='v-end'}\n"
            "[load.t]\nkind='traction'\nbody='boom'\ndirection=[1,0,0]\npressure=1\n"
            "[load.e]\nkind='traction'\nbody='s'\ndirection=[1,0,0]\nedge='v-end'\npressure=1\n"
        ),
        [
            "joint.a.a.edge: the surface is closed: it has no edge where u starts or ends",
            "joint.b.b: an edge is held by the ground, where it is: leave b out",
            "joint.c.a.edge: only side a of 'clamp', 'spherical', 'guide' or 'fixing' takes an edge",
            "joint.d.a.edge: 'boom' is a beam: only shells have edges",
            "load.t.body: 'boom' is a beam: only shells take traction",
            "load.e.line_load: missing",
            "load.e.pressure: does not go with an edge",
        ],
    ),
    # ---- joints that refer to others
    "gear on a spherical joint": (
        added("[joint.g]\nkind='gear'\nfirst='tip'\nsecond='tap'\nratio=2\n"),
        [
            "joint.g.first: joint.tip is a spherical; expected 'revolute', 'cylindrical' or 'clearance_revolute'",
            "joint.g.second: there is no joint 'tap'; did you mean 'tip'",
        ],
    ),
    "gear with itself": (
        added("[joint.g]\nkind='gear'\nfirst='tip'\nsecond='tip'\nratio=0\n"),
        ["joint.g.ratio: must not be zero", "joint.g.second: is the same joint as first"],
    ),
    "latch at a mass": (
        added("[joint.l]\nkind='latch'\njoint='tip'\nat='1 kg'\n"),
        ["joint.l.at: expected an angle such as '45 deg' or a length such as '25 mm', got '1 kg'"],
    ),
    "idle spring": (
        added("[joint.s]\nkind='spring'\na={body='boom',at='start'}\nb={body='ball'}\n"),
        ["joint.s.stiffness: missing: without it, damping, preload and force it does nothing"],
    ),
    "rope of one point": (
        added("[joint.r]\nkind='pulley'\npoints=[{body='ball'}]\ndamping='1 N s'\n"),
        [
            "joint.r.points: a rope needs two points or more",
            "joint.r.damping: belongs to a stiffness",
        ],
    ),
    "rope through nothing": (
        added("[joint.r]\nkind='pulley'\npoints=[{body='ball'},{body='bal'},{body='boom'}]\n"),
        [
            "joint.r.points[1].body: there is no body 'bal'; did you mean 'ball'",
            "joint.r.points[2].at: missing",
        ],
    ),
    "sliding on a particle": (
        added("[joint.s]\nkind='sliding'\na={body='boom',at='end'}\nbody='ball'\n"),
        ["joint.s.body: 'ball' is a particle: only beams and cables can be slid on"],
    ),
    "sliding on itself": (
        added("[joint.s]\nkind='sliding'\na={body='boom',at='end'}\nbody='boom'\n"),
        ["joint.s.body: a point of 'boom' cannot slide on it"],
    ),
    "bushing of two numbers": (
        added("[joint.s]\nkind='bushing'\na={body='boom',at='end'}\nstiffness=[1,2]\n"),
        ["joint.s.stiffness: expected three numbers, got 2"],
    ),
    "universal joint without right angle": (
        added(
            "[joint.u]\nkind='universal'\na={body='boom',at='end'}\naxis_a=[1,0,0]\naxis_b=[1,1,0]\n"
        ),
        ["joint.u.axis_b: must be at right angles to axis_a; the cosine is 0.707107"],
    ),
    "prismatic particle": (
        added("[joint.p]\nkind='prismatic'\na={body='ball'}\naxis=[1,0,0]\n"),
        [
            "joint.p.a.body: 'ball' is a particle: it has no orientation and cannot be held by a prismatic"
        ],
    ),
    "guide in four directions": (
        added("[joint.p]\nkind='guide'\na={body='ball'}\ndirections=[[1,0,0],[0,1,0],[0,0,1]]\n"),
        ["joint.p.directions: expected one or two; three are a spherical joint"],
    ),
    "fixing of a vector that is not there": (
        added("[joint.p]\nkind='fixing'\na={body='ball'}\nvector='r_x'\ndirections=[[1,0,0]]\n"),
        ["joint.p.vector: 'ball' has 'position', got 'r_x'"],
    ),
    "torque on the ground": (
        added("[load.t]\nkind='torque'\na={body='ground'}\ndirection=[1,0,0]\namplitude=1\n"),
        ["load.t.a.body: a load acts on a body, not on the ground"],
    ),
    "torsional stiffness without angle": (
        added("[joint.t]\nkind='torsion_spring'\njoint='tip'\nstiffness='10 N m'\n"),
        ["joint.t.stiffness: expected a torsional stiffness such as '10 N m/rad'"],
    ),
    # ---- steps in time
    "damping of another scheme": (
        added("[integrator]\nscheme='bdf2'\nalpha=-0.1\n"),
        ["integrator.alpha: belongs to the scheme hht, and this one is bdf2"],
    ),
    "unknown scheme": (
        added("[integrator]\nscheme='hth'\n"),
        [
            "integrator.scheme: expected 'hht', 'generalised-alpha', 'bdf2' or 'backward-euler', got 'hth'; did you mean 'hht'"
        ],
    ),
    "baumgarte without it": (
        added("[integrator]\nbaumgarte_rate='10 1/s'\n"),
        ["integrator.baumgarte_rate: belongs to constraints = 'baumgarte'"],
    ),
    # ---- generated
    "ring without a level": (
        added(
            "[generate.r]\nkind='ring_truss'\nbays=3\ndiameter=10\nheight=2\nsection='tube'\nmaterial='al6061'\n"
        ),
        ["generate.r.level: give either a level or the number of elements"],
    ),
    "ring of an unknown material": (
        added(
            "[generate.r]\nkind='ring_truss'\nbays=3\ndiameter=10\nheight=2\nlevel=1\nsection='tube'\nmaterial='al606'\n"
        ),
        [
            "body.chord_low_0.material: there is no material 'al606'; did you mean 'al6061'? (and 11 more like it)"
        ],
    ),
    "ring with long fittings": (
        added(
            "[generate.r]\nkind='ring_truss'\nbays=3\ndiameter=10\nheight=2\nlevel=9\nfitting=3\nsection='tube'\nmaterial='al6061'\n"
        ),
        ["generate.r.level: expected at most 4, got 9"],
    ),
    # ---- several at once
    "errors in many tables": (
        changed(
            ("elements = 4", "elements = 'four'"),
            ('mass = "1 kg"', 'mass = "1 s"'),
            ("emissivity = 0.8", "emissivity = 3"),
            ('part = "pin" }', 'part = "pen" }'),
            ('window = "0.5 s"', 'window = "-1 s"'),
            ('journal_material = "steel-304"', 'journal_material = "steel"'),
        ),
        [
            "time.window: expected a time above 0 s",
            "body.boom.elements: expected a positive integer",
            "body.ball.mass: expected a mass",
            "thermal.radiation.space.emissivity: expected a number",
            "thermal.link.pin.a.part: there is no part 'pen'; did you mean 'pin'",
            "joint.hinge.journal_material: there is no material 'steel'; did you mean 'steel-304'",
        ],
    ),
}


def run(*arguments: str | Path):
    return CliRunner().invoke(app, [str(a) for a in arguments])


def content(folder: Path) -> dict[Path, bytes | None]:
    return {p: p.read_bytes() if p.is_file() else None for p in folder.rglob("*")}


def assert_refused(result, source: str, problems: list[str]) -> None:
    """Exit code 2, and these problems and no others, each on its line."""
    assert result.exit_code == 2, result.output
    head, *lines = result.output.strip("\n").split("\n")
    assert head == f"{source}: {len(problems)} problem{'s' * (len(problems) != 1)}", result.output
    for problem in problems:
        path, _, text = problem.partition(": ")
        found = [x for x in lines if x.startswith(f"  {path}: {text}" if path else "  ")]
        assert any(text in line for line in found), f"{problem!r} is not among\n{result.output}"
    assert len(lines) == len(problems), result.output


def test_the_good_case_is_good(tmp_path):
    (tmp_path / "case.toml").write_text(GOOD)
    result = run("check", tmp_path)
    assert result.exit_code == 0, result.output
    assert "ok: 2 bodies, 2 joints, 1 load, heat by line, 4 windows" in result.output


@pytest.mark.parametrize("name", BROKEN)
def test_broken_case(name, tmp_path):
    text, problems = BROKEN[name]
    (tmp_path / "case.toml").write_bytes(text if isinstance(text, bytes) else text.encode())
    before = content(tmp_path)
    assert_refused(run("run", tmp_path), "case.toml", problems)
    assert content(tmp_path) == before


@pytest.mark.parametrize("command", ["check", "plan", "run"])
def test_every_command_refuses(command, tmp_path):
    (tmp_path / "case.toml").write_text(changed(("elements = 4", "elements = -4")))
    assert_refused(run(command, tmp_path), "case.toml", ["body.boom.elements: expected a positive"])


def test_region_that_the_mesh_does_not_have(tmp_path):
    from meshes.io import write
    from meshes.mesh import Mesh

    points = np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0]])
    cells, members = np.array([[0, 1], [1, 2]]), np.array([0, 1])
    write(tmp_path / "boom.msh", Mesh(points, {"line": cells}, {"boom": ("line", members)}))
    case = changed(
        (
            'start = [0, 0, 0]\nend = ["2 m", 0, 0]\nelements = 4',
            'mesh = "boom.msh"\nregion = "bom"',
        )
    )
    (tmp_path / "case.toml").write_text(case)
    result = run("run", tmp_path)
    assert_refused(result, "case.toml", ["body.boom: boom.msh: has no region 'bom'"])
    assert run("check", tmp_path, "--set", "body.boom.region=boom").exit_code == 0


def test_mesh_file_that_is_none(tmp_path):
    (tmp_path / "boom.vtu").write_text("this is not a mesh")
    case = changed(('start = [0, 0, 0]\nend = ["2 m", 0, 0]\nelements = 4', 'mesh = "boom.vtu"'))
    (tmp_path / "case.toml").write_text(case)
    assert_refused(run("run", tmp_path), "case.toml", ["body.boom: boom.vtu: cannot be read"])


PATHS = {
    "missing folder": ("nothing/here", "there is no such file or folder"),
    "mistyped folder": ("bom", "there is no such file or folder; did you mean 'boom'?"),
    "folder without a case": ("empty", "the folder has no case.toml"),
    "name that cannot be one": ("x" * 5000, "cannot be opened"),
}


@pytest.mark.parametrize("name", PATHS)
def test_path_without_a_case(name, tmp_path):
    (tmp_path / "boom").mkdir()
    (tmp_path / "empty").mkdir()
    path, text = PATHS[name]
    before = content(tmp_path)
    assert_refused(run("run", tmp_path / path), str(tmp_path / path), [f": {text}"])
    assert content(tmp_path) == before


def test_case_file_that_is_a_folder(tmp_path):
    (tmp_path / "case.toml").mkdir()
    assert_refused(run("run", tmp_path), "case.toml", [": is not a file"])


def test_case_file_of_enormous_size(tmp_path):
    with (tmp_path / "case.toml").open("wb") as file:
        file.truncate(20_000_000)
    assert_refused(run("run", tmp_path), "case.toml", [": is too large"])


def test_no_permission_to_read(tmp_path):
    (tmp_path / "case.toml").write_text(GOOD)
    (tmp_path / "case.toml").chmod(0)
    if os.access(tmp_path / "case.toml", os.R_OK):
        pytest.skip("this user may read everything")
    assert_refused(run("run", tmp_path), "case.toml", [": cannot be read: Permission denied"])


def test_no_permission_to_write(tmp_path):
    (tmp_path / "case.toml").write_text(GOOD)
    tmp_path.chmod(0o500)
    if os.access(tmp_path, os.W_OK):
        pytest.skip("this user may write everywhere")
    result = run("run", tmp_path)
    tmp_path.chmod(0o700)
    assert_refused(result, str(tmp_path / "results"), [": results cannot go there: no permission"])


def test_results_where_a_file_is(tmp_path):
    (tmp_path / "case.toml").write_text(GOOD)
    (tmp_path / "occupied").write_text("")
    result = run("run", tmp_path, "--output", tmp_path / "occupied" / "runs")
    source = str(tmp_path / "occupied" / "runs")
    assert_refused(result, source, [": results cannot go there"])


SETTINGS = {
    "no value": (["time.end"], "--set", ["time.end: expected path=value"]),
    "empty value": (["time.end="], "--set", ["time.end: has no value"]),
    "no path": (["=3"], "--set", ["=3: expected path=value"]),
    "two of them": (["a b=1", "time.window"], "--set", ["a b=1: expected", "time.window: expected"]),
    "through a value": (
        ["time.end.x=1"],
        "case.toml",
        ["--set time.end.x: 'x' is not there: what stands before it is a value"],
    ),
    "through an array": (
        ["body.boom.end.x=1"], "case.toml", ["--set body.boom.end.x: 'x' is not there"],
    ),
    "beyond an array": (
        ["body.boom.end[3]=1"], "case.toml", ["--set body.boom.end[3]: [3] is not there"],
    ),
    "wrong value": (["time.end=soon"], "case.toml", ["time.end: expected a time"]),
    "NaN": (["body.ball.mass=nan"], "case.toml", ["body.ball.mass: expected a mass that is finite"]),
    "mistyped table": (["tme.end=1"], "case.toml", ["tme: unknown key; did you mean 'time'"]),
    "mistyped name": (
        ["body.bom.elements=8"], "case.toml",
        ["--set body.bom.elements: there is no body.bom; did you mean 'boom'"],
    ),
    "mistyped name under thermal": (
        ["thermal.wall.sum.hot=300"], "case.toml",
        ["--set thermal.wall.sum.hot: there is no thermal.wall.sum; did you mean 'sun'"],
    ),
    "mistyped key": (
        ["body.boom.elemets=8"], "case.toml",
        ["body.boom.elemets: unknown key; did you mean 'elements'"],
    ),
    "new table with an error": (
        ["load.side.kind=force"], "case.toml",
        ["load.side.at: missing", "load.side.direction: missing", "load.side.amplitude: missing"],
    ),
    "table replaced by a value": (
        ["joint.hinge.contact=hard"], "case.toml",
        ["joint.hinge.contact: expected a table, got 'hard'"],
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", SETTINGS)
def test_bad_setting(name, tmp_path):
    settings, source, problems = SETTINGS[name]
    (tmp_path / "case.toml").write_text(GOOD)
    before = content(tmp_path)
    result = run("run", tmp_path, *(word for s in settings for word in ("--set", s)))
    assert_refused(result, source, problems)
    assert content(tmp_path) == before


def test_messages_are_sentences_without_jargon(tmp_path):
    """Nothing of the validation library shows through."""
    for name, (text, _) in BROKEN.items():
        (tmp_path / "case.toml").write_bytes(text if isinstance(text, bytes) else text.encode())
        output = run("check", tmp_path).output
        assert not re.search(r"pydantic|Input should|value_error|Traceback|tuple|dict", output), (
            name
        )


ODD = [
    True,
    -1,
    1e308,
    float("nan"),
    "x",
    "",
    "5 kg",
    [],
    {},
    [[]],
    {"a": 1},
    {"table": [[0, 1], [1]]},
]


def steps(value, path=()):
    """Paths of everything in a case."""
    yield path
    if isinstance(value, (dict, list)):
        for key, inner in value.items() if isinstance(value, dict) else enumerate(value):
            yield from steps(inner, (*path, key))


def test_whatever_stands_anywhere_is_read_or_refused(tmp_path):
    """Odd values in random places of the good case never end in anything but BadCase."""
    case = tomllib.loads(GOOD)
    places = [path for path in steps(case) if path]
    draw = random.Random(0)
    for _ in range(300):
        path, odd = draw.choice(places), draw.choice(ODD)
        broken = copy.deepcopy(case)
        place = broken
        for step in path[:-1]:
            place = place[step]
        place[path[-1]] = odd
        with contextlib.suppress(BadCase):
            from_text(toml(broken), tmp_path)
