"""Rigid bodies, shells, arcs, points between nodes, joints and springs: from text to mechanics."""

from pathlib import Path

import numpy as np
import pytest

import mechanics.description as motion
from coupling.casefile import from_text
from coupling.descriptions import motion_description
from coupling.places import point_of
from mechanics.layout import Layout

START = """
[time]
end = 1
window = 0.5
[section.rod]
kind = "circle"
radius = "5 mm"
[body.rod]
kind = "beam"
start = [0, 0, 0]
end = [2, 0, 0]
elements = 4
normal = [0, 1, 0]
section = "rod"
material = "al6061"
[body.box]
kind = "rigid"
position = [2, 0, 1]
mass = "3 kg"
inertia = [0.1, 0.2, 0.25]
"""


def described(text):
    return motion_description(from_text(START + text, Path()))


def named(description, name):
    every = [*description.bodies, *description.joints, *description.loads]
    return next(item for item in every if item.name == name)


# ----------------------------------------------------------------------------------- bodies


def test_inertia_along_turned_axes_is_global():
    text = (
        '[body.r]\nkind = "rigid"\nposition = [0, 0, 0]\nmass = 1\ninertia = [0.1, 0.2, 0.25]\n'
        "axes = [[0, 1, 0], [-1, 0, 0]]\n"
    )
    body = named(described(text), "r")
    assert np.allclose(body.axes, [[0, 1, 0], [-1, 0, 0], [0, 0, 1]])
    assert np.allclose(body.inertia, np.diag([0.2, 0.1, 0.25]), atol=1e-15)


@pytest.mark.parametrize(
    "numbers", ["[2, 3, 4, 0.1, 0.2, 0.3]", "[2, 0.3, 0.2, 0.3, 3, 0.1, 0.2, 0.1, 4]"]
)
def test_six_and_nine_numbers_of_inertia(numbers):
    text = f'[body.r]\nkind = "rigid"\nposition = [0, 0, 0]\nmass = 1\ninertia = {numbers}\n'
    expected = [[2, 0.3, 0.2], [0.3, 3, 0.1], [0.2, 0.1, 4]]  # xx yy zz, yz xz xy
    assert np.allclose(named(described(text), "r").inertia, expected)


def test_an_arc_lies_on_its_circle_with_its_tangents():
    text = (
        '[body.c]\nkind = "beam"\nstart = [0, 0, 2]\nelements = 6\nnormal = [0, 1, 0]\n'
        'section = "rod"\nmaterial = "al6061"\n'
        'arc = { center = [0, 5, 0], axis = [0, 1, 0], angle = "90 deg" }\n'
    )
    body = named(described(text), "c")
    angle = np.radians(np.linspace(0.0, 90.0, 7))
    # from z about y towards x
    circle = 2.0 * np.column_stack([np.sin(angle), 0.0 * angle, np.cos(angle)])
    assert np.allclose(body.points, circle, atol=1e-14)
    tangents = np.column_stack([np.cos(angle), 0.0 * angle, -np.sin(angle)])
    assert np.allclose(body.axes[:, 0], tangents, atol=1e-14)
    assert np.allclose(body.axes[:, 1], [0, 1, 0], atol=1e-14)


def test_three_node_elements_have_nodes_in_between():
    text = '[body.q]\nkind = "beam"\nelement = "beam3333"\nstart = [0, 0, 0]\nend = [1, 0, 0]\n'
    end = 'section = "rod"\nmaterial = "al6061"\n'
    body = named(described(text + "elements = 3\n" + end), "q")
    assert np.allclose(body.points[:, 0], np.linspace(0, 1, 7))
    body = named(described(text + "nodes = [0, 0.2, 1]\n" + end), "q")
    assert np.allclose(body.points[:, 0], [0, 0.1, 0.2, 0.6, 1])


def test_nodes_at_given_distances():
    text = (
        '[body.q]\nkind = "beam"\nstart = [0, 0, 1]\nend = [0, 3, 1]\nnodes = [0, "10 cm", 1, 3]\n'
        'section = "rod"\nmaterial = "al6061"\nelement = "beam3243-enhanced"\n'
    )
    body = named(described(text), "q")
    assert body.element == "beam3243-enhanced"
    assert np.allclose(body.points[:, 1], [0, 0.1, 1, 3])


@pytest.mark.parametrize(
    ("surface", "nodes", "corner"),
    [
        ('{ kind = "plate", length = 2, width = 1, elements = [4, 2], origin = [0, 0, 3] }',
         15, [2, 1, 3]),
        ('{ kind = "tube", radius = 1, length = 4, elements = [8, 2] }', 24, [0, 1, 4]),
        ('{ kind = "tube", radius = 1, length = 4, end = "90 deg", elements = [8, 2], '
         "axes = [[0, 1, 0], [0, 0, 1]] }", 27, [4, 0, 1]),
        ('{ kind = "annulus", inner_radius = 1, outer_radius = 2, end = "180 deg", '
         "elements = [1, 4] }", 10, [-2, 0, 0]),
        ('{ kind = "sphere", radius = 2, south = 0, north = "30 deg", elements = [4, 1] }',
         8, [0, 3**0.5, 1]),
    ],
)  # fmt: skip
def test_surfaces_of_shells(surface, nodes, corner):
    text = '[body.s]\nkind = "shell"\nthickness = "2 mm"\nmaterial = "al6061"\n'
    text += f"surface = {surface}\n"
    body = named(described(text), "s")
    assert (body.element, body.thickness) == ("shell48", 0.002)
    assert len(body.surface.points) == nodes
    assert np.linalg.norm(body.surface.points - corner, axis=1).min() < 1e-12


# ------------------------------------------------------------------------------------ sites


@pytest.mark.parametrize(
    ("site", "expected"),
    [
        ('{ body = "rod", at = "1 m" }', (2, 0.0, [0, 0, 0], [1, 0, 0])),
        ('{ body = "rod", at = 1.2 }', (2, 0.4, [0, 0, 0], [1.2, 0, 0])),
        ('{ body = "rod", at = 1.2, offset = [0, "2 cm", "-1 cm"] }',
         (2, 0.4, [0, 0.02, -0.01], [1.2, 0.02, -0.01])),
        ('{ body = "box" }', (0, 0.0, [0, 0, 0], [2, 0, 1])),
        ('{ body = "box", position = [2, 0, 0] }', (0, 0.0, [0, 0, -1], [2, 0, 0])),
        ('{ body = "box", offset = [0.5, 0, 0] }', (0, 0.0, [0.5, 0, 0], [2.5, 0, 1])),
    ],
)  # fmt: skip
def test_material_points(site, expected):
    load = f'[load.f]\nkind = "force"\nat = {site}\ndirection = [1, 0, 0]\namplitude = 1\n'
    made = described(load)
    found = named(made, "f").site
    assert (found.node, found.fraction) == (expected[0], pytest.approx(expected[1]))
    assert np.allclose(found.offset, expected[2])
    # the mechanical module finds the same point
    assert np.allclose(Layout.of(made.bodies).site(found).position, expected[3], atol=1e-14)


@pytest.mark.parametrize("at", [0.3, 1.0, 2.5])
def test_a_point_on_an_arc_is_where_the_elements_have_it(at):
    text = (
        '[body.c]\nkind = "beam"\nstart = [2, 0, 0]\nelements = 5\nsection = "rod"\n'
        'material = "al6061"\narc = { center = [0, 0, 0], axis = [0, 0, 1], angle = "80 deg" }\n'
        f'[joint.s]\nkind = "spherical"\na = {{ body = "c", at = {at}, offset = [0, 0, 0.1] }}\n'
    )
    made = described(text)
    joint = named(made, "s")
    side = Layout.of(made.bodies).site(joint.a)
    assert np.allclose(joint.b.position, side.position, atol=1e-13)
    circle = [2 * np.cos(at / 2), 2 * np.sin(at / 2)]
    assert np.allclose(side.position[:2], circle, atol=2e-5)
    assert abs(side.position[2]) == pytest.approx(0.1, abs=1e-13)


def test_the_end_of_an_arc_may_be_given_by_its_length():
    text = (
        '[body.c]\nkind = "beam"\nstart = [2, 0, 0]\nelements = 5\nsection = "rod"\n'
        f'material = "al6061"\narc = {{ center = [0, 0, 0], axis = [0, 0, 1], angle = {0.5} }}\n'
        '[probe.p]\nbody = "c"\nat = 1.0\n'
    )
    scene = from_text(START + text, Path())
    from coupling.places import place_of

    place = place_of(scene.shapes["c"], scene.probe["p"])
    assert place[:2] == (5, 0.0)
    assert np.allclose(point_of(scene.shapes["c"], place), [2 * np.cos(0.5), 2 * np.sin(0.5), 0])


def test_a_node_of_a_shell_is_named_by_its_place():
    text = (
        '[body.s]\nkind = "shell"\nthickness = "2 mm"\nmaterial = "al6061"\n'
        'surface = { kind = "plate", length = 2, width = 1, elements = [4, 2] }\n'
        '[joint.f]\nkind = "fixing"\na = { body = "s", position = [1.5, 0.5, 0] }\n'
        'vector = "r_u"\ndirections = [[0, 0, 2]]\n'
    )
    made = described(text)
    fixing = named(made, "f")
    assert np.allclose(named(made, "s").surface.points[fixing.node], [1.5, 0.5, 0])
    assert np.allclose(fixing.directions, [[0, 0, 1]])


PLATE = """
[body.s]
kind = "shell"
thickness = "2 mm"
material = "al6061"
surface = { kind = "plate", length = 2, width = 1, elements = [4, 2] }
"""


def test_an_edge_of_a_shell_is_held_node_by_node():
    made = described(PLATE + '[joint.c]\nkind = "clamp"\na = { body = "s", edge = "u-end" }\n')
    clamps = [joint for joint in made.joints if joint.name.startswith("c.")]
    points = named(made, "s").surface.points[[clamp.a.node for clamp in clamps]]
    assert np.allclose(points, [[2, 0, 0], [2, 0.5, 0], [2, 1, 0]])
    assert np.allclose([clamp.b.position for clamp in clamps], points)


@pytest.mark.parametrize(
    ("where", "nodes", "value"),
    [('pressure = "2 kPa"', None, 2000.0),
     ('edge = "v-end"\nline_load = "3 N/m"', [2, 5, 8, 11, 14], 3.0)],
)  # fmt: skip
def test_traction_on_a_shell_or_its_edge(where, nodes, value):
    text = f'[load.t]\nkind = "traction"\nbody = "s"\ndirection = [0, 0, -1]\n{where}\n'
    load = named(described(PLATE + text), "t")
    assert (load.body, load.edge, load.amplitude(0.0)) == ("s", nodes, value)


# ----------------------------------------------------------------------------------- joints

ROD, BOX = '{ body = "rod", at = "end" }', '{ body = "box", position = [2, 0, 0] }'
HINGE = f'[joint.hinge]\nkind = "revolute"\na = {ROD}\nb = {BOX}\naxis = [0, 0, 1]\n'


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ('kind = "universal"\naxis_a = [0, 0, 2]\naxis_b = [0, 1, 0]\n',
         {"axis_a": [0, 0, 1], "axis_b": [0, 1, 0]}),
        ('kind = "cylindrical"\naxis = [1, 0, 0]\nangle = "1 deg"\ntravel = "2 mm"\n',
         {"axis": [1, 0, 0], "angle": np.radians(1.0), "travel": 0.002}),
        ('kind = "prismatic"\naxis = [1, 0, 0]\n', {"axis": [1, 0, 0], "travel": None}),
        ('kind = "planar"\nnormal = [0, 3, 0]\n', {"normal": [0, 1, 0]}),
        ('kind = "bushing"\nstiffness = ["1 N/mm", 2, 3]\nturn_stiffness = [4, 5, 6]\n'
         'damping = [7, 8, 9]\nturn_damping = [1, 1, "2 N m s/rad"]\n'
         "axes = [[0, 1, 0], [1, 0, 0]]\n",
         {"stiffness": [1000, 2, 3, 4, 5, 6], "damping": [7, 8, 9, 1, 1, 2],
          "axes": [[0, 1, 0], [1, 0, 0], [0, 0, -1]]}),
    ],
)  # fmt: skip
def test_joints_between_two_sides(text, expected):
    joint = named(described(f"[joint.j]\na = {ROD}\nb = {BOX}\n{text}"), "j")
    assert (joint.a.body, joint.a.node, joint.b.body) == ("rod", 4, "box")
    for key, value in expected.items():
        got = getattr(joint, key)
        got = got(0.0) if callable(got) else got
        assert got is None if value is None else np.allclose(got, value), key


def test_springs_and_ropes():
    sides = 'a = { body = "rod", at = "end" }\nb = { body = "box" }\n'
    spring = named(described(
        f'[joint.s]\nkind = "spring"\n{sides}stiffness = "2 N/mm"\ndamping = "3 N s/m"\n'
        'length = "5 cm"\npreload = "1 kN"\nforce = "4 N"\n'
    ), "s")  # fmt: skip
    assert (spring.stiffness, spring.damping, spring.length, spring.preload) == (2e3, 3, 0.05, 1e3)
    assert spring.force(0.0) == 4.0
    rope = named(described(
        '[joint.r]\nkind = "pulley"\nstiffness = "2 kN"\ndamping = "1 N s"\nwinch = "1 cm"\n'
        'points = [{ body = "ground", position = [0, 0, 4] }, { body = "rod", at = 0.7 }, '
        '{ body = "box" }]\n'
    ), "r")  # fmt: skip
    assert isinstance(rope, motion.Pulley)
    assert [site.body for site in rope.points] == [None, "rod", "box"]
    assert (rope.stiffness, rope.damping, rope.length, rope.winch(0.0)) == (2e3, 1.0, None, 0.01)


def test_joints_on_joints():
    twist = '[joint.t]\nkind = "torsion_spring"\njoint = "hinge"\nstiffness = "3 N m/rad"\n'
    made = described(
        HINGE + twist + 'angle = "90 deg"\npreload = 2\ntorque = "1 N m"\n'
        '[joint.l]\nkind = "latch"\njoint = "hinge"\nat = "45 deg"\n'
    )
    spring, latch = named(made, "t"), named(made, "l")
    assert (spring.joint, spring.stiffness, spring.preload) == ("hinge", 3.0, 2.0)
    assert spring.angle == pytest.approx(np.pi / 2)
    assert spring.torque(0.0) == 1.0
    assert (latch.joint, latch.at) == ("hinge", pytest.approx(np.pi / 4))


def test_gears_guides_and_sliders():
    made = described(
        HINGE
        + '[joint.other]\nkind = "revolute"\na = { body = "box" }\naxis = [0, 0, 1]\n'
        + '[joint.g]\nkind = "gear"\nfirst = "hinge"\nsecond = "other"\nratio = -2\n'
        + '[joint.w]\nkind = "guide"\na = { body = "rod", at = 0.3 }\ndirections = [[0, 0, 2]]\n'
        + '[joint.s]\nkind = "sliding"\na = { body = "box", position = [2, 0, 0] }\n'
        + 'body = "rod"\ntravel = "-1 cm"\n'
        + '[load.m]\nkind = "torque"\na = { body = "box" }\nb = { body = "rod", at = 1 }\n'
        + "direction = [0, 0, 1]\namplitude = 2\n"
    )
    assert named(made, "g") == motion.Gear("g", "hinge", "other", -2.0)
    guide, slider, torque = (named(made, name) for name in "wsm")
    assert guide.a.fraction == pytest.approx(0.6) and np.allclose(guide.directions, [[0, 0, 1]])
    assert (slider.body, slider.aligned, slider.travel(0.0)) == ("rod", False, -0.01)
    assert (torque.a.body, torque.b.body, torque.b.node) == ("box", "rod", 2)


def test_a_distance_may_change():
    text = (
        '[joint.d]\nkind = "distance"\na = { body = "rod", at = 0 }\nb = { body = "box" }\n'
        'length = { ramp = { end = 1, from = 0, to = "5 cm" } }\n'
    )
    assert named(described(text), "d").length(0.5) == pytest.approx(0.025)


def test_damping_and_density_are_options():
    plain = described("")
    assert (plain.rayleigh, plain.heavy_when_cold) == (None, False)
    text = '[damping]\nmass = "0.1 1/s"\nstiffness = "2 ms"\n[coupling]\ndensity = "temperature"\n'
    made = described(text)
    assert made.rayleigh == (0.1, 0.002)
    assert made.heavy_when_cold
