"""The ring truss: its counts, its shape, and that it stands."""

import numpy as np
import pytest

from meshes.truss import LEVELS, ring_truss


def test_counts_of_level_3():
    truss = ring_truss(elements=LEVELS[3])
    kinds = [m.kind for m in truss.members]
    assert {k: kinds.count(k) for k in set(kinds)} == dict.fromkeys(
        ("chord_low", "chord_up", "batten", "diagonal"), 36
    )
    turning = sum(h.axis is not None for h in truss.hinges)
    assert (turning, len(truss.hinges) - turning) == (144, 72)
    assert (truss.elements, truss.nodes, 12 * truss.nodes) == (1296, 1440, 17280)
    assert len(truss.corners) == 72
    # 5 multipliers of a revolute, 3 of a spherical hinge, 6 of the support
    assert 5 * turning + 3 * (len(truss.hinges) - turning) + 6 == 942


@pytest.mark.parametrize(("level", "dof"), [(1, 6912), (2, 10368), (3, 17280), (4, 31104)])
def test_levels_double_the_elements_of_the_spans(level, dof):
    truss = ring_truss(elements=LEVELS[level])
    assert 12 * truss.nodes == dof
    lengths = np.linalg.norm(np.diff(truss.members[0].points, axis=0), axis=1)
    assert lengths[0] == pytest.approx(0.3)
    assert len(lengths) == 2**level + 1
    assert np.ptp(lengths[1:]) < 1e-12


@pytest.mark.parametrize("bays", [5, 36])
def test_hinged_ends_are_where_their_posts_end(bays):
    truss = ring_truss(bays, 20.0, 3.0, 2, 0.1)
    at = {m.name: {"start": m.points[0], "end": m.points[-1]} for m in truss.members}
    for hinge in truss.hinges:
        gap = at[hinge.a][hinge.at] - at[hinge.base][hinge.base_at]
        assert np.abs(gap).max() < 1e-14
        if hinge.axis is not None:
            along = at[hinge.a]["end"] - at[hinge.a]["start"]
            assert abs(along @ hinge.axis) < 1e-12
            assert np.linalg.norm(hinge.axis) == pytest.approx(1.0)
    for k in range(bays):
        assert np.linalg.norm(at[f"batten_{k:0{len(str(bays - 1))}d}"]["end"][:2]) == (
            pytest.approx(10.0)
        )


def test_each_end_of_chords_and_diagonals_is_hinged_once():
    truss = ring_truss()
    ends = sorted((h.a, h.at) for h in truss.hinges)
    expected = sorted(
        (m.name, at) for m in truss.members if m.kind != "batten" for at in ("start", "end")
    )
    assert ends == expected


@pytest.mark.parametrize(
    ("numbers", "said"),
    [({"bays": 2}, "at least 3 bays"), ({"fitting": 9.0}, "fitting must be between")],
)
def test_impossible_numbers_are_refused(numbers, said):
    with pytest.raises(ValueError, match=said):
        ring_truss(**numbers)


def _rigid_motions(truss):
    """Number of independent small motions of the hinged members, taken as rigid."""
    column = {m.name: 6 * i for i, m in enumerate(truss.members)}
    at = {m.name: {"start": m.points[0], "end": m.points[-1]} for m in truss.members}
    rows = []
    for hinge in truss.hinges:
        point = at[hinge.a][hinge.at]
        cross = np.cross(np.eye(3), point)  # row i of it times the rotation: component i at point
        block = np.zeros((6, 6 * len(truss.members)))
        for name, sign in ((hinge.a, 1.0), (hinge.base, -1.0)):
            block[:3, column[name] : column[name] + 3] += sign * np.eye(3)
            block[:3, column[name] + 3 : column[name] + 6] += sign * -cross
            block[3:, column[name] + 3 : column[name] + 6] += sign * np.eye(3)
        if hinge.axis is None:
            rows.append(block[:3])
        else:
            across = np.linalg.svd(hinge.axis[None])[2][1:]
            rows += [block[:3], across @ block[3:]]
    jacobian = np.concatenate(rows)
    return jacobian.shape[1] - np.linalg.matrix_rank(jacobian, tol=1e-9)


@pytest.mark.parametrize("bays", [3, 7, 36])
def test_it_moves_only_as_a_whole(bays):
    assert _rigid_motions(ring_truss(bays, 20.0, 3.0, 1, 0.0)) == 6


def test_without_its_diagonals_it_folds():
    truss = ring_truss(7, 20.0, 3.0, 1, 0.0)
    keep = [h for h in truss.hinges if not h.a.startswith("diagonal")]
    members = [m for m in truss.members if m.kind != "diagonal"]
    assert _rigid_motions(truss._replace(hinges=keep, members=members)) > 6


# ------------------------------------------------------------------------------ from a case

CASE = """
[time]
end = 0.02
window = 0.01
[section.rod]
kind = "tube"
mean_radius = "2 cm"
thickness = "1 mm"
[generate.ring]
kind = "ring_truss"
bays = 6
diameter = "20 m"
height = "3 m"
level = 1
fitting = "20 cm"
section = "rod"
material = "al6061"
shakers = { count = 4, amplitude = "2 N", frequency = "1 Hz" }
shock = { from = "60 degC", to = "10 degC", duration = "2 s" }
[body.diagonal_3]
damping = "2 ms"
[thermal]
solver = "prescribed"
initial = "60 degC"
"""


def test_a_case_says_it_in_a_few_numbers(tmp_path):
    from coupling.casefile import from_text

    scene = from_text(CASE, tmp_path)
    assert (len(scene.body), len(scene.joint), len(scene.load)) == (24, 37, 4)
    assert scene.body["diagonal_3"].damping == 2e-3
    assert scene.body["diagonal_2"].damping == 0.0
    cooled = {name for name, wall in scene.thermal.wall.items() if wall.hot[0](2.0) < 300.0}
    assert cooled == {
        *(f"{kind}_{k}" for kind in ("chord_low", "chord_up", "diagonal") for k in (0, 1, 2)),
        "batten_1", "batten_2",
    }  # fmt: skip


def test_one_override_changes_the_mesh_and_is_kept(tmp_path):
    from coupling.casefile import from_text
    from coupling.overrides import parse

    scene = from_text(CASE, tmp_path, parse(["generate.ring.level=3", "body.batten_0.damping=1"]))
    assert all(len(points) == 10 for points in scene.points.values())
    again = from_text(scene.text, tmp_path)
    assert "[body.batten_1]" not in scene.text
    assert (len(again.body), again.body["batten_0"].damping) == (24, 1.0)


def test_it_runs_and_only_the_cooled_half_gets_shorter(tmp_path):
    from coupling import simulation
    from coupling.casefile import from_text
    from coupling.results import Results

    outcome = simulation.run(from_text(CASE, tmp_path), tmp_path)
    assert outcome.code == 0, outcome.reason
    with Results.open(outcome.folder) as results:
        at = {name: results[f"bodies/{name}/temperature"][-1] for name in ("batten_1", "batten_4")}
        ledger = {name: column[-1] for name, column in results.table("ledger").items()}
    assert np.allclose(at["batten_1"][:, 0], 333.15 - 0.5)
    assert np.allclose(at["batten_4"][:, 0], 333.15)
    largest = max(abs(x) for name, x in ledger.items() if not name.startswith("heat_"))
    assert abs(ledger["defect"]) < 1e-5 * largest


# ------------------------------------------------------------------------------- with play

KINDS = "chord_low", "chord_up", "diagonal"
PLAY = """
[generate.ring.clearance]
radius = "10 mm"
clearance = "30 um"
contact = { restitution = 0.5 }
friction = { coefficient = 0.1 }
"""


def loose(tmp_path, added="", settings=()):
    from coupling.casefile import from_text
    from coupling.overrides import parse

    return from_text(CASE + PLAY + added, tmp_path, parse(settings))


def test_play_makes_every_revolute_a_pin_in_a_bore_of_a_post(tmp_path):
    scene = loose(tmp_path, "[joint.diagonal_3_end.friction]\ncoefficient = 0.2\n")
    kinds = [joint.kind for joint in scene.joint.values()]
    assert {k: kinds.count(k) for k in set(kinds)} == {
        "clearance_revolute": 24, "spherical": 12, "clamp": 1,
    }  # fmt: skip
    pins = {n: j for n, j in scene.joint.items() if j.kind == "clearance_revolute"}
    assert {pin.bearing.body.partition("_")[0] for pin in pins.values()} == {"batten"}
    assert all(name.startswith(pin.journal.body) for name, pin in pins.items())
    pin = scene.joint["chord_up_2_start"]
    assert (pin.radius, pin.clearance) == (0.01, pytest.approx(30e-6))
    assert (pin.contact.restitution, pin.journal_material) == (0.5, "al6061")
    coefficients = [pins[f"diagonal_{k}_end"].friction.coefficient for k in (2, 3)]
    assert coefficients == [0.1, 0.2]


def test_balls_in_sockets_as_well_if_asked_for(tmp_path):
    scene = loose(tmp_path, settings=["generate.ring.clearance.spherical=true"])
    kinds = [joint.kind for joint in scene.joint.values()]
    assert (kinds.count("clearance_revolute"), kinds.count("clearance_spherical")) == (24, 12)


def test_pins_with_a_mass_follow_the_shock_of_their_members(tmp_path):
    heat = loose(tmp_path, settings=["generate.ring.clearance.mass=40 g"]).thermal
    assert (len(heat.part), heat.part["diagonal_4_end_bearing"].mass) == (48, 0.04)
    assert heat.part["diagonal_4_end_bearing"].of == "diagonal_4_end.bearing"
    at = {name: fixed.temperature(2.0) for name, fixed in heat.fixed.items()}
    # diagonal 2 is cooled and ends at batten 3, on the border of the halves, which is not
    assert at["diagonal_2_end_journal"] == pytest.approx(283.15)
    assert at["diagonal_2_end_bearing"] == pytest.approx(333.15)
    assert at["diagonal_1_end_bearing"] == pytest.approx(283.15)


def test_pins_without_a_mass_are_no_parts(tmp_path):
    heat = loose(tmp_path).thermal
    assert not heat.part and not heat.fixed


def test_play_wider_than_the_pin_is_refused(tmp_path):
    from coupling.errors import BadCase

    with pytest.raises(BadCase, match="must be below the radius of the pin"):
        loose(tmp_path, settings=["generate.ring.clearance.clearance=2 cm"])


@pytest.mark.parametrize("spherical", [False, True])
def test_the_ring_for_measuring_has_the_play_of_the_case(tmp_path, spherical):
    from coupling.descriptions import motion_description
    from coupling.rings import Play, ring_description
    from mechanics.description import Friction, NormalContact
    from meshes.materials import library_material
    from meshes.sections import tube

    word = str(spherical).lower()
    scene = loose(tmp_path, settings=[f"generate.ring.clearance.spherical={word}"])
    play = Play(0.01, 30e-6, NormalContact(restitution=0.5), Friction(0.1), spherical)
    made = ring_description(
        ring_truss(6, 20.0, 3.0, LEVELS[1], 0.2), tube(0.02, 1e-3), library_material("al6061"),
        reference_temperature=333.15, clearance=play,
    )  # fmt: skip
    expected = {joint.name: joint for joint in motion_description(scene).joints}
    assert len(made.joints) == len(expected) == 37
    for joint in made.joints[1:]:
        case = expected[joint.name]
        assert type(case) is type(joint)
        if hasattr(joint, "journal"):
            assert (joint.journal.body, joint.bearing.body) == (
                case.journal.body, case.bearing.body,
            )  # fmt: skip
            assert joint.clearance == pytest.approx(case.clearance)
            assert (joint.contact, joint.friction.coefficient) == (case.contact, 0.1)
            assert joint.reference_temperature == case.reference_temperature


def test_with_play_it_runs_and_energy_balances(tmp_path):
    from coupling import simulation
    from coupling.results import Results

    scene = loose(tmp_path, settings=["time.end=0.04", "generate.ring.clearance.mass=40 g"])
    outcome = simulation.run(scene, tmp_path)
    assert outcome.code == 0, outcome.reason
    with Results.open(outcome.folder) as results:
        hinges = [results.table(f"joints/{k}_{i}_start") for k in KINDS for i in range(6)]
        ledger = {name: column[-1] for name, column in results.table("ledger").items()}
    depth = [float(np.max(hinge["penetration"])) for hinge in hinges]
    assert 0.0 < max(depth) < 30e-6
    assert ledger["friction"] > 0.0 and ledger["hysteresis"] > 0.0
    largest = max(abs(x) for name, x in ledger.items() if not name.startswith("heat_"))
    assert abs(ledger["defect"]) < 1e-5 * largest
