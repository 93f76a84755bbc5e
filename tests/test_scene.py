import json
import subprocess
import sys
import tomllib
from math import pi

import numpy as np
import pytest

from coupling import overrides
from coupling.casefile import from_text, read
from coupling.errors import BadCase
from coupling.histories import Constant, Ramp, SCurve, Sine, Step, Table
from coupling.materials_used import material_of
from coupling.places import distances, place_of
from coupling.scene import Scene

EVERYTHING = """
title = "Secondary arm rotation"
description = "free text"

[time]
end = "20 s"
window = "0.1 s"

[coupling]
scheme = "serial"
smallest_window = "1 ms"

[integrator]
alpha = -0.05
tolerance = 1e-6
largest_step = "10 ms"
smallest_step = "1e-9 s"
newton_tolerance = 1e-11

[material.my-alloy]
density = "2700 kg/m^3"
youngs_modulus = { table = [["100 K", "78 GPa"], ["500 K", 6.1e10]], source = "tensile tests" }
poissons_ratio = 0.33
expansion = { polynomial = ["23.1e-6 1/K", 1e-8], reference = "25 degC", range = ["73 K", "473 K"] }
conductivity = { value = "167 W/m/K", source = "handbook" }
heat_capacity = "896 J/kg/K"
source = "our own"

[section.arm-tube]
kind = "tube"
mean_radius = "0.27 m"
thickness = "2 mm"

[section.strip]
kind = "rectangle"
height = "2 mm"
width = "40 mm"

[section.rope]
kind = "circle"
radius = "3 mm"

[section.profile]
kind = "general"
area = "5 cm^2"
second_moment_2 = "12 cm^4"
second_moment_3 = "8 cm^4"
torsion_constant = "1 cm^4"

[body.arm]
kind = "beam"
start = [0, "0 m", 0]
end = ["63.5 m", 0, 0]
elements = 16
normal = [0, 2, 0]
section = "arm-tube"
material = "al6061-paper"
damping = "2 ms"
velocity = ["0 m/s", 0, 0]
spin = [0, 0, "6 deg/s"]

[body.stay]
kind = "cable"
start = [0, 0, "1 m"]
end = [4, 0, "1 m"]
elements = 4
section = "rope"
material = "my-alloy"
reference_temperature = "0 degC"

[body.weight]
kind = "particle"
position = [4, 0, 1]
mass = "500 g"

[joint.root]
kind = "clamp"
a = { body = "stay", at = "start" }

[joint.elbow]
kind = "revolute"
a = { body = "arm", at = "end" }
axis = [0, 0, 3]
angle = { s_curve = { rate = "0.08 deg/s", rise = "1 s", total = "1 deg", start = "2 s" } }

[joint.knot]
kind = "spherical"
a = { body = "weight" }
b = { body = "stay", at = "4 m" }

[joint.rod]
kind = "distance"
a = { body = "weight" }
b = { body = "ground", position = [4, 0, "5 m"] }

[joint.hinge]
kind = "clearance_revolute"
journal = { body = "arm", at = "start" }
bearing = { body = "ground" }
axis = [0, 0, 1]
radius = "25 mm"
clearance = "0.05 mm"
journal_material = "steel-304"
bearing_material = "al6061-paper"
reference_temperature = "20 degC"
contact = { stiffness = "linear", value = "3 MN/m", restitution = 0.9, dissipation = "flores" }
angle = { s_curve = { rate = "0.08 deg/s", rise = "10 s", total = "45.36 deg" } }

[joint.hinge.friction]
coefficient = 0.1
temperature_slope = "-1e-3 1/K"
reference_temperature = "25 degC"
regularisation_speed = "1e-6 m/s"
partition = "product"

[load.push]
kind = "force"
at = { body = "arm", at = "end" }
direction = [0, 3, 4]
amplitude = { step = { at = "1 s", from = 0, to = "2 kN" } }

[load.twist]
kind = "moment"
at = { body = "arm", at = "31.75 m" }
direction = [1, 0, 0]
amplitude = { sine = { amplitude = "3 N m", period = "4 s", phase = "90 deg", offset = 0 } }

[gravity]
acceleration = [0, 0, "-9.81 m/s^2"]

[thermal]
solver = "lumped"
initial = "25 degC"
wall_points = 8

[thermal.wall.sun]
body = "arm"
start = "2 m"
end = "63.5 m"
side = [0, 1, 0]
hot = { start = { ramp = { end = "10 s", from = "25 degC", to = "75 degC" } }, end = "50 degC" }
cold = { table = [["0 s", "25 degC"], ["5 s", 290]] }

[thermal.flux.sun]
body = "arm"
density = "1361 W/m^2"
absorptivity = 0.3
direction = [0, -1, 0]

[thermal.radiation.space]
body = "arm"
emissivity = 0.8
sink = "3 K"

[thermal.fixed.base]
at = { body = "arm", at = "start" }
temperature = "20 degC"

[thermal.source.heater]
at = { part = "bearing" }
power = "5 W"

[thermal.part.journal]
of = "hinge.journal"
material = "steel-304"
mass = "1.5 kg"

[thermal.part.bearing]
of = "hinge.bearing"
material = "al6061-paper"
mass = "1 kg"
initial = "30 degC"

[thermal.link.fitting]
a = { part = "journal" }
b = { body = "arm", at = "start" }
conductance = "2 W/K"

[thermal.link.ship]
a = { part = "bearing" }
temperature = "20 degC"
conductance = 4

[probe.tip]
body = "arm"
at = "end"

[probe.weight]
body = "weight"

[output]
frames = 50
export = ["vtk", "pictures"]
"""

SMALLEST = """
[time]
end = 1
window = 0.25
[body.ball]
kind = "particle"
position = [1, 2, 3]
mass = 1
"""


@pytest.fixture(scope="module")
def everything(tmp_path_factory):
    folder = tmp_path_factory.mktemp("everything")
    (folder / "case.toml").write_text(EVERYTHING)
    return read(folder)


def test_plain_tables(everything):
    s = everything
    assert (s.title, s.description) == ("Secondary arm rotation", "free text")
    assert (s.time.end, s.time.window, s.time.windows) == (20.0, 0.1, 200)
    assert (s.coupling.scheme, s.coupling.smallest_window) == ("serial", 1e-3)
    assert s.integrator.model_dump(exclude_defaults=True) == {
        "alpha": -0.05,
        "largest_step": 0.01,
        "smallest_step": 1e-9,
        "newton_tolerance": 1e-11,
    }
    assert (s.integrator.tolerance, s.integrator.scheme) == (1e-6, "hht")
    assert s.gravity.acceleration == (0.0, 0.0, -9.81)
    assert (s.output.frames, s.output.export) == (50, ["vtk", "pictures"])
    assert s.probe["tip"].at == "end"


def test_materials(everything):
    material = material_of(everything, "my-alloy")
    assert material.density == 2700.0
    assert material.youngs_modulus(300.0) == pytest.approx((78e9 + 61e9) / 2)
    assert material.youngs_modulus.source == "tensile tests"
    assert material.expansion(308.15) == pytest.approx(23.1e-6 + 10 * 1e-8)
    assert (material.expansion.lower, material.expansion.upper) == (73.0, 473.0)
    assert material.conductivity(10.0) == 167.0
    assert material_of(everything, "al6061-paper").name == "al6061-paper"


def test_sections(everything):
    assert everything.section["arm-tube"].thickness == 0.002
    assert everything.section["strip"].width == 0.04
    assert everything.section["rope"].radius == 0.003
    profile = everything.section["profile"]
    assert profile.second_moment_2 == pytest.approx(12e-8)
    assert profile.shear_factor_2 == pytest.approx(5 / 6)


def test_bodies(everything):
    arm, stay, weight = (everything.body[name] for name in ("arm", "stay", "weight"))
    assert (arm.kind, stay.kind, weight.kind) == ("beam", "cable", "particle")
    assert arm.normal == (0.0, 1.0, 0.0)
    assert arm.spin == pytest.approx((0, 0, 6 * pi / 180))
    assert arm.damping == 0.002
    assert weight.mass == 0.5
    assert everything.points["arm"].shape == (17, 3)
    assert np.array_equal(everything.points["stay"], [[x, 0, 1] for x in range(5)])
    assert np.array_equal(everything.points["weight"], [[4, 0, 1]])


def test_reference_temperatures_default_to_the_initial_one(everything):
    assert everything.body["arm"].reference_temperature == pytest.approx(298.15)
    assert everything.body["stay"].reference_temperature == pytest.approx(273.15)
    assert everything.joint["hinge"].reference_temperature == pytest.approx(293.15)
    assert everything.thermal.part["journal"].initial == pytest.approx(298.15)
    assert everything.thermal.part["bearing"].initial == pytest.approx(303.15)


def test_joints(everything):
    root, elbow, knot, rod, hinge = (
        everything.joint[name] for name in ("root", "elbow", "knot", "rod", "hinge")
    )
    assert (root.b.body, root.b.position) == ("ground", None)
    assert elbow.axis == (0.0, 0.0, 1.0)
    assert elbow.angle == SCurve(0.08 * pi / 180, 1.0, pi / 180, 2.0)
    assert place_of(everything.shapes["stay"], knot.b)[:2] == (4, 0.0)
    assert rod.b.position == (4.0, 0.0, 5.0)
    assert (hinge.radius, hinge.clearance) == (0.025, 5e-5)
    assert (hinge.contact.stiffness, hinge.contact.value) == ("linear", 3e6)
    assert hinge.friction.temperature_slope == -1e-3


def test_loads(everything):
    push, twist = everything.load["push"], everything.load["twist"]
    assert push.direction == pytest.approx((0.0, 0.6, 0.8))
    assert push.amplitude == Step(1.0, 0.0, 2000.0)
    assert twist.amplitude == Sine(3.0, 0.25, pi / 2, 0.0)


def test_heat(everything):
    heat = everything.thermal
    assert (heat.solver, heat.initial, heat.wall_points) == ("lumped", 298.15, 8)
    wall = heat.wall["sun"]
    assert wall.hot == (Ramp(0.0, 10.0, 298.15, 348.15), Constant(323.15))
    assert wall.cold == (Table((0.0, 5.0), (298.15, 290.0)),) * 2
    assert heat.flux["sun"].density(7.0) == 1361.0
    assert heat.radiation["space"].sink(0.0) == 3.0
    assert (heat.fixed["base"].at.body, heat.fixed["base"].at.at) == ("arm", "start")
    assert heat.source["heater"].at.part == "bearing"
    assert heat.part["journal"].of == "hinge.journal"
    assert heat.link["fitting"].b.body == "arm"
    assert heat.link["ship"].temperature(1.0) == pytest.approx(293.15)


def test_smallest_case_and_its_defaults(tmp_path):
    (tmp_path / "other.toml").write_text(SMALLEST)
    scene = read(tmp_path / "other.toml")
    assert (scene.folder, scene.text, scene.overrides) == (tmp_path, SMALLEST, ())
    assert scene.thermal is None and scene.gravity is None
    assert scene.joint == scene.load == scene.material == scene.section == scene.probe == {}
    assert (scene.coupling.scheme, scene.integrator.scheme) == ("corrected", "hht")
    assert (scene.output.frames, scene.output.export) == (100, [])


def test_a_line_mesh_is_read_from_its_file(tmp_path):
    import meshio

    points = np.array([[0, 0, 0], [1, 0, 0], [1, 2, 0.0]])
    meshio.Mesh(points, [("line", [[0, 1], [1, 2]])]).write(tmp_path / "boom.vtu")
    case = SMALLEST + (
        '[section.s]\nkind = "circle"\nradius = 0.01\n[body.boom]\nkind = "cable"\n'
        'mesh = "boom.vtu"\nsection = "s"\nmaterial = "invar"\n[probe.p]\nbody = "boom"\nat = 1\n'
    )
    scene = from_text(case, tmp_path)
    assert np.allclose(scene.points["boom"], points)
    assert np.allclose(distances(scene.points["boom"]), [0, 1, 3])
    assert place_of(scene.shapes["boom"], scene.probe["p"])[:2] == (1, 0.0)


@pytest.mark.parametrize(
    ("setting", "get", "value"),
    [
        ("time.end=2 min", lambda s: s.time.end, 120.0),
        ("time.end = '2 min'", lambda s: s.time.end, 120.0),
        ("time.end=40", lambda s: s.time.end, 40.0),
        ("thermal.solver=line", lambda s: s.thermal.solver, "line"),
        ("title=two words", lambda s: s.title, "two words"),
        ("title=a = b", lambda s: s.title, "a = b"),
        ("body.arm.end=[10, 0, '63.5 m']", lambda s: s.body["arm"].end, (10.0, 0.0, 63.5)),
        ("body.stay.end[0]='4 km'", lambda s: s.body["weight"].position, (4000.0, 0.0, 1.0)),
        ("coupling.scheme=corrected", lambda s: s.coupling.scheme, "corrected"),
        ("probe.mid={body='arm', at='31.75 m'}", lambda s: s.probe["mid"].at, 31.75),
        ("probe.top.body=arm", lambda s: s.probe["top"].body, "arm"),
        ("output.export=[]", lambda s: s.output.export, []),
    ],
)
def test_an_entry_can_be_set(tmp_path, setting, get, value):
    also = {
        "body.arm.end=[10": ["thermal.wall.sun.end=60", "load.twist.at.at=start"],
        "body.stay.end[0]": [
            "body.weight.position[0]=4000", "joint.knot.b.at=end", "joint.rod.b.position[0]=4000"
        ],
        "probe.top.body": ["probe.top.at=end"],
    }  # fmt: skip
    (tmp_path / "case.toml").write_text(EVERYTHING)
    more = next((v for k, v in also.items() if setting.startswith(k)), [])
    scene = read(tmp_path, [setting, *more])
    assert get(scene) == value
    assert scene.overrides == (setting, *more)
    assert from_text(scene.text, tmp_path).model_dump(exclude={"text", "overrides", "shapes"}) == (
        scene.model_dump(exclude={"text", "overrides", "shapes"})
    )


def test_later_settings_win(tmp_path):
    (tmp_path / "case.toml").write_text(SMALLEST)
    assert read(tmp_path, ["time.end=2", "time.end=3"]).time.end == 3.0


def test_written_toml_says_the_same():
    case = tomllib.loads(EVERYTHING)
    case["description"] = 'quote " backslash \\ tab \t newline \n delete \x7f, ü'
    assert tomllib.loads(overrides.toml(case)) == case


def test_errors_in_one_table_hide_none_in_others(tmp_path):
    case = EVERYTHING
    for old, new in (
        ("elements = 16", "elements = 0"),  # a table that fails ...
        ("mass = '1 kg'", "mass = 1"),
        ('a = { body = "weight" }\nb = { body = "stay", at = "4 m" }', 'a = { body = "wait" }'),
        ("emissivity = 0.8", "emissivity = 8"),
        ('at = { part = "bearing" }', 'at = { part = "baring" }'),
        ('scheme = "serial"', 'scheme = "cereal"'),
    ):
        case = case.replace(old, new, 1)
    with pytest.raises(BadCase) as refusal:
        from_text(case, tmp_path)
    paths = [problem.path for problem in refusal.value.problems]
    assert sorted(paths) == [
        "body.arm.elements",
        "coupling.scheme",
        "joint.knot.a.body",
        "thermal.radiation.space.emissivity",
        "thermal.source.heater.at.part",
    ]


def test_json_schema_describes_the_file():
    schema = Scene.model_json_schema()
    json.dumps(schema)
    tables = set(tomllib.loads(EVERYTHING))
    others = {"generate", "analysis", "damping", "report", "mechanics", "crosscheck"}
    others |= {"sweep", "variant"}
    assert set(schema["properties"]) == tables | others
    assert set(schema["required"]) == {"time", "body"}
    wall = schema["$defs"]["Wall"]
    assert wall["additionalProperties"] is False
    assert {"type": "string", "examples": ["25 mm"]} in wall["properties"]["start"]["anyOf"]


def test_json_schema_accepts_the_case_that_has_everything():
    jsonschema = pytest.importorskip("jsonschema")
    jsonschema.validate(tomllib.loads(EVERYTHING), Scene.model_json_schema())


def test_reading_in_si_imports_nothing_heavy(tmp_path):
    (tmp_path / "case.toml").write_text(SMALLEST)
    code = (
        "import sys; from coupling.casefile import read; read(sys.argv[1]);"
        "heavy = {'pint', 'numba', 'skfem', 'h5py', 'meshio', 'matplotlib', 'pyvista'};"
        "assert not heavy & set(sys.modules), heavy & set(sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code, str(tmp_path)], check=True)
