# ruff: noqa: E501 (inline tables stand on one line)
"""Joints with clearance in a case file: what their tables become in mechanics."""

import json
import tomllib
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

import mechanics.description as motion
from coupling import simulation
from coupling.casefile import from_text
from coupling.contact_places import contact_groups
from coupling.contact_tables import FRICTION_LAWS, Friction
from coupling.descriptions import motion_description
from coupling.heat_descriptions import heat_description
from coupling.results import Results
from coupling.scene import Scene
from meshes.materials import library_material

BODIES = """
[time]
end = 1.0
window = 0.1

[section.tube]
kind = "tube"
mean_radius = "20 mm"
thickness = "1 mm"

[body.boom]
kind = "beam"
start = [0, 0, 0]
end = [2, 0, 0]
elements = 4
section = "tube"
material = "al6061"

[body.sleeve]
kind = "beam"
start = [-1, 0, 0]
end = [1, 0, 0]
elements = 2
section = "tube"
material = "titanium-6al4v"

[body.hub]
kind = "rigid"
position = [0, 1, 0]
mass = 2
inertia = [1, 1, 1]
"""
EVERYTHING = (
    BODIES
    + """
[joint.pin]
kind = "clearance_revolute"
journal = { body = "boom", at = "start" }
bearing = { body = "hub", position = ["0.01 mm", 0, "0.05 mm"] }
axis = [0, 0, 2]
radius = "10 mm"
clearance = "20 um"
length = "3 cm"
axial_clearance = "0.1 mm"
flange_radius = "18 mm"
journal_material = "titanium-6al4v"
bearing_material = "al6061"
reference_temperature = "20 degC"
contact = { stiffness = "cylinder", restitution = 0.7, dissipation = "flores" }
friction = { coefficient = 0.1, law = "stick", static_coefficient = 0.15, presliding = "1 um", bristle_damping = 0.5, viscous = "0.02 s/m" }
angle = { ramp = { end = "1 s", from = "0 deg", to = "10 deg" } }

[joint.ball]
kind = "clearance_spherical"
journal = { body = "boom", at = "end" }
radius = "8 mm"
clearance = "0.1 mm"
journal_material = "steel-304"
bearing_material = "al6061"
contact = { stiffness = "hertz-internal", reference_speed = "0.1 m/s" }
friction = { coefficient = 0.1, law = "lugre", static_coefficient = 0.15, stribeck_speed = "1 mm/s", table = [["0 degC", 1.2], ["100 degC", 0.8]] }

[joint.rod]
kind = "clearance_cylindrical"
journal = { body = "boom", at = "1 m" }
bearing = { body = "hub", position = [1, 0, 0] }
axis = [1, 0, 0]
radius = "1 cm"
clearance = "0.1 mm"
length = "5 cm"
journal_material = "steel-304"
bearing_material = "al6061"
friction = { coefficient = 0.1, law = "rising", static_coefficient = 0.15, rise_rate = 0.4, rise_exponent = 0.5, temperature_slope = 1e-3 }

[joint.slider]
kind = "clearance_translational"
journal = { body = "hub" }
axis = [1, 0, 0]
normal = [0, 0, -3]
length = "5 cm"
height = "2 cm"
width = "3 cm"
clearance = "0.1 mm"
corner_radius = "2 mm"
journal_material = "steel-304"
bearing_material = "al6061"
friction = { coefficient = 0.1, law = "stribeck", static_coefficient = 0.15, regularisation_speed = "1 um/s" }

[joint.tubes]
kind = "telescope"
inner = "boom"
outer = "sleeve"
mouth = "end"
radius = "20.5 mm"
clearance = "1 mm"
stations = 3
contact = { stiffness = "linear", value = "5 MN/m" }
friction = { coefficient = 0.2 }
"""
)


@pytest.fixture(scope="module")
def joints():
    described = motion_description(from_text(EVERYTHING, Path())).joints
    return {joint.name: joint for joint in described}


def test_a_revolute_with_a_length(joints):
    pin = joints["pin"]
    assert isinstance(pin, motion.ClearanceRevolute)
    assert (pin.journal.body, pin.bearing.body) == ("boom", "hub")
    assert_allclose(pin.bearing.offset, [1e-5, -1.0, 5e-5])
    assert_allclose(pin.axis, [0, 0, 1])
    assert_allclose([pin.radius, pin.clearance, pin.length], [0.01, 2e-5, 0.03])
    assert_allclose([pin.axial_clearance, pin.flange_radius], [1e-4, 0.018])
    materials = pin.journal_material, pin.bearing_material
    assert materials == (library_material("titanium-6al4v"), library_material("al6061"))
    assert pin.contact == motion.NormalContact("cylinder", None, "flores", 0.7, None)
    assert pin.friction == motion.Friction(
        0.1, law="stick", static_coefficient=0.15, presliding=1e-6, bristle_damping=0.5,
        viscous=0.02,
    )  # fmt: skip
    assert pin.angle(0.5) == pytest.approx(np.radians(5.0))
    assert pin.reference_temperature == pytest.approx(293.15)


def test_a_ball_in_a_socket(joints):
    ball = joints["ball"]
    assert isinstance(ball, motion.ClearanceSpherical)
    assert (ball.radius, ball.clearance) == (pytest.approx(0.008), pytest.approx(1e-4))
    assert_allclose(ball.bearing.position, [2, 0, 0])
    assert ball.contact == motion.NormalContact("hertz-internal", reference_speed=0.1)
    assert ball.friction.law == "lugre" and ball.friction.stribeck_speed == pytest.approx(1e-3)
    assert_allclose(ball.friction.table, [[273.15, 1.2], [373.15, 0.8]])
    assert ball.reference_temperature == pytest.approx(293.15)


def test_a_rod_in_a_bush(joints):
    rod = joints["rod"]
    assert isinstance(rod, motion.ClearanceCylindrical)
    assert_allclose([*rod.axis, rod.radius, rod.clearance, rod.length], [1, 0, 0, 0.01, 1e-4, 0.05])
    friction = rod.friction
    assert (friction.law, friction.rise_rate, friction.rise_exponent) == ("rising", 0.4, 0.5)
    assert friction.temperature_slope == 1e-3 and friction.table is None


def test_a_slider_in_a_guide(joints):
    slider = joints["slider"]
    assert isinstance(slider, motion.ClearanceTranslational)
    assert_allclose([*slider.axis, *slider.normal], [1, 0, 0, 0, 0, -1])
    assert_allclose([slider.length, slider.height, slider.width], [0.05, 0.02, 0.03])
    assert_allclose([slider.clearance, slider.corner_radius], [1e-4, 2e-3])
    assert slider.friction.regularisation_speed == pytest.approx(1e-6)


def test_a_telescope_takes_the_names_of_its_tubes(joints):
    tubes = joints["tubes"]
    contact = motion.NormalContact("linear", 5e6)
    assert tubes == motion.Telescope(
        "tubes", "boom", "sleeve", 0.0205, 0.001, 293.15, "end", 3, contact, motion.Friction(0.2)
    )


def test_a_telescope_with_preloaded_pads_and_line_contact():
    plain = """contact = { stiffness = "linear", value = "5 MN/m" }"""
    pads = (
        'contact = { stiffness = "cylinder" }\npreload = { force = "20 N", stiffness = "3 kN/m" }'
    )
    assert EVERYTHING.count(plain) == 1
    described = motion_description(from_text(EVERYTHING.replace(plain, pads), Path())).joints
    tubes = described[-1]
    assert tubes.preload == motion.Preload(20.0, 3000.0)
    assert tubes.contact == motion.NormalContact("cylinder")


def test_an_absent_length_means_planar_as_ever():
    text = EVERYTHING.split("[joint.ball]")[0]
    for line in ('length = "3 cm"', 'axial_clearance = "0.1 mm"', 'flange_radius = "18 mm"'):
        text = text.replace(line, "")
    text = text.replace('stiffness = "cylinder", ', "").replace('"0.05 mm"', "0")
    (pin,) = motion_description(from_text(text, Path())).joints
    assert (pin.length, pin.axial_clearance, pin.flange_radius) == (None, None, None)


def test_both_sides_of_every_kind_take_part_in_the_heat():
    text = EVERYTHING + "[thermal]\ninitial = '20 degC'\n"
    for joint in ("pin", "ball", "rod", "slider"):
        for side in ("journal", "bearing"):
            text += f"[thermal.part.{joint}-{side}]\nof = '{joint}.{side}'\n"
            text += "material = 'al6061'\nmass = 0.1\n"
    parts = {part.name: part for part in heat_description(from_text(text, Path())).parts}
    assert len(parts) == 8
    assert_allclose(parts["ball.bearing"].position, [2, 0, 0])
    assert_allclose(parts["slider.journal"].position, [0, 1, 0])


def test_every_law_takes_every_key_that_belongs_to_it():
    values = {"static_coefficient": 0.2, "rise_exponent": 0.5}
    for law, keys in FRICTION_LAWS.items():
        given = {key: values.get(key, 1e-3) for key in keys}
        table = Friction.model_validate({"coefficient": 0.1, "law": law, **given})
        assert {key: getattr(table, key) for key in keys} == given


def test_defaults_of_the_tables_are_those_of_the_descriptions():
    table = Friction(coefficient=0.1).model_dump()
    assert motion.Friction(**table) == motion.Friction(0.1)


def test_friction_laws_are_those_of_mechanics():
    from mechanics.contact import FRICTION

    assert FRICTION_LAWS.keys() == FRICTION.keys()


def test_json_schema_knows_the_tables():
    schema = Scene.model_json_schema()
    json.dumps(schema)
    jsonschema = pytest.importorskip("jsonschema")
    jsonschema.validate(tomllib.loads(EVERYTHING), schema)
    wrong = tomllib.loads(EVERYTHING)
    wrong["joint"]["tubes"]["stations"] = "many"
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(wrong, schema)


# ------------------------------------------------------------------------------------ a run

HANGING = """
[time]
end = "12 ms"
window = "2 ms"
[gravity]
acceleration = [0, -3, -9.81]
[body.arm]
kind = "rigid"
position = [0.2, 0, 0]
mass = 1
inertia = [1e-3, 5e-3, 5e-3]
spin = [0, 0, 2]
velocity = [0, 0.4, 0]
[joint.pin]
kind = "clearance_revolute"
journal = { body = "arm", position = [0, 0, 0] }
axis = [0, 0, 1]
radius = "10 mm"
clearance = "50 um"
length = "30 mm"
axial_clearance = "0.1 mm"
journal_material = "steel-304"
bearing_material = "al6061"
friction = { coefficient = 0.1, law = "stick", static_coefficient = 0.15, presliding = "1 um" }
"""


@pytest.fixture(scope="module")
def hanging(tmp_path_factory):
    folder = tmp_path_factory.mktemp("hanging")
    assert simulation.run(from_text(HANGING, folder), folder).code == 0
    return Results.open(folder / "001")


def test_each_contact_has_a_history_and_knows_its_place(hanging):
    labels = ["end_1", "end_2", *(f"flange_{i}_{k}" for i in (1, 2) for k in (1, 2, 3))]
    groups = contact_groups(hanging)
    assert groups == {"pin": [f"pin.{label}" for label in labels]}
    for label in labels:
        attributes = hanging.attributes(f"joints/pin.{label}")
        assert (attributes["joint"], attributes["label"]) == ("pin", label)
        gap = 5e-5 if label.startswith("end") else 1e-4
        assert attributes["reference_clearance"] == pytest.approx(gap)
        assert_allclose(hanging[f"joints/pin.{label}/clearance"], gap)
    assert_allclose(hanging["joints/pin.end_1/place"], -0.015)
    assert_allclose(hanging["joints/pin.end_2/place"], 0.015)
    assert_allclose(hanging.attributes("joints/pin.flange_1_1")["directions"], [[0, 0, 1]])


def test_events_are_where_penetration_changes_its_sign(hanging):
    found = hanging.table("events")
    assert np.all(np.diff(found["time"]) >= 0.0) and np.all(found["speed"] >= 0.0)
    for number, contact in enumerate(contact_groups(hanging)["pin"]):
        time, depth = (hanging[f"joints/{contact}/{c}"] for c in ("time", "penetration"))
        mine = found["contact"] == number
        for t, kind in zip(found["time"][mine], found["kind"][mine], strict=True):
            at = np.searchsorted(time, t)
            before, after = depth[max(at - 1, 0)], depth[min(at + 1, len(time) - 1)]
            assert (before < 0.0 < after) if kind == 1 else (after < 0.0)
        kinds = found["kind"][mine]
        assert np.all(np.diff(kinds.astype(int)) != 0)  # one after the other
    assert len(found["time"]) > 4


def test_totals_of_the_windows_are_those_of_events_and_ledger(hanging):
    totals, found = hanging.table("contacts"), hanging.table("events")
    assert_allclose(totals["time"], hanging["windows/time"])
    onsets = np.bincount(found["contact"][found["kind"] == 1], minlength=8)
    assert totals["impacts"].sum(axis=0).tolist() == onsets.tolist()
    assert_allclose(totals["shares"].sum(axis=2), 1.0, rtol=1e-6)
    assert totals["friction_work"].sum() == pytest.approx(hanging["ledger/friction"][-1], rel=1e-9)
    for number, contact in enumerate(contact_groups(hanging)["pin"]):
        peak = hanging[f"joints/{contact}/normal_force"].max()
        assert totals["peak_force"][:, number].max() == peak


def test_a_longer_run_goes_on_with_the_history_of_friction(hanging, tmp_path):
    """Bit for bit: bristles, approach speeds, rows, events and totals of each window."""
    begun = from_text(HANGING.replace('"12 ms"', '"6 ms"'), tmp_path)
    assert simulation.run(begun, tmp_path).code == 0
    assert simulation.run(from_text(HANGING, tmp_path), tmp_path, resume=True).code == 0
    resumed = Results.open(tmp_path / "001")
    for group in ("events", "contacts", *(f"joints/{name}" for name in hanging.names("joints"))):
        whole = hanging.table(group)
        for name, values in resumed.table(group).items():
            assert np.array_equal(values, whole[name]), f"{group}/{name}"
    history = hanging.read_state()["coupled"]["motion"]["motion"]["history"]
    assert history.any()
    again = resumed.read_state()["coupled"]["motion"]["motion"]["history"]
    assert np.array_equal(history, again)
