"""[sweep.NAME]: what points it makes, and what is wrong with it said with its place."""

from pathlib import Path

import pytest
from sweep_cases import CASE

from coupling.casefile import from_text
from coupling.errors import BadCase
from coupling.sweeps import points
from coupling.sweeps.command import prepared
from coupling.sweeps.table import differing


def read(text: str = CASE):
    return from_text(text, Path("."))


def refused(old: str, new: str) -> dict[str, str]:
    assert old in CASE
    with pytest.raises(BadCase) as error:
        read(CASE.replace(old, new))
    return {problem.path: problem.text for problem in error.value.problems}


def test_points_of_a_grid_and_of_a_design():
    scene = read()
    grid, design = scene.sweep["stiffness"], scene.sweep["two"]
    assert [s["joint.spring.stiffness"] for s in grid.settings()] == ["8 N/m", "18 N/m", "32 N/m"]
    assert [tuple(s.values()) for s in design.settings()] == [
        ("1.0 kg", "4.0 N/m"), ("4.0 kg", "4.0 N/m"), ("1.0 kg", "16.0 N/m"),
        ("4.0 kg", "16.0 N/m"),
    ]  # fmt: skip
    assert [s.time.end for s in points.scenes(scene, design, "two")] == [0.5] * 4


def test_a_variant_comes_before_the_point():
    text = CASE.replace('title = "Weight on springs"', 'variant = ["heavy"]')
    scene = read(text)
    made = points.scenes(scene, scene.sweep["stiffness"], "stiffness")
    assert [s.body["weight"].mass for s in made] == [4.0] * 3
    assert [s.joint["spring"].stiffness for s in made] == [8.0, 18.0, 32.0]


@pytest.mark.parametrize(
    ("old", "new", "path", "text"),
    [
        ('title = "Weight on springs"', 'variant = ["light"]', "stiffness.variant", "no variant"),
        ('"joint.spring.stiffness" = [', '"joint.spring.stifness" = [', "stiffness.vary",
         "did you mean 'stiffness'?"),
        ('"joint.spring.stiffness" = [', '"report.a" = [', "stiffness.vary", "cannot change"),
        ('"joint.spring.stiffness" = [', '"sweep.two.set" = [', "stiffness.vary", "no notice"),
        ('entries = ["joint.spring.stiffness"]', 'entries = ["joint.sprung.stiffness"]',
         "two.factor.stiffness.entries", "did you mean 'spring'?"),
        ("printed = [0.35, nan, 0.5]", "printed = [0.35]", "stiffness.quantity",
         "1 printed values, and there are 3 points"),
        ('y = "probe.weight.vx"', 'y = "probe.weight.velocity"', "stiffness.portrait.motion.y",
         "is a vector"),
        ('of = "probe.weight.x"\nprinted', 'of = "probe.wait.x"\nprinted',
         "stiffness.quantity.place.of", "did you mean 'weight'?"),
        ('kind = "full-factorial"', 'kind = "factorial"', "two.design.kind", "expected"),
        ('kind = "full-factorial"', 'kind = "full-factorial", runs = 8', "two.design.runs",
         "belongs to"),
        ('kind = "full-factorial"', 'kind = "latin-hypercube"', "two.design.runs", "missing"),
        ('kind = "full-factorial"', 'kind = "sobol", runs = 12', "two.design.runs",
         "power of two"),
        ('kind = "full-factorial"', 'kind = "box-behnken"', "two.factor", "takes 3 or more"),
        ('low = "1 kg"\n', "", "two.factor.mass.low", "missing"),
        ('high = "4000 g"', 'high = "4 m"', "two.factor.mass.high", "do not fit"),
        ('low = "1 kg"', 'levels = ["1 kg", "2 kg"]', "two.factor.mass.high",
         "levels stand in its place"),
        ('design = { kind = "full-factorial" }', "", "two.vary", "missing"),
        ('of = "probe.weight.x"\nprinted', 'of = "probe.weight.x"\nmeasure = "course"\nprinted',
         "stiffness.quantity.place.measure", "one number"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_said_with_its_place(old, new, path, text):
    problems = refused(old, new)
    assert text in problems[f"sweep.{path}"], problems


def test_all_points_are_checked_before_any_is_run():
    text = CASE.replace('["8 N/m", "18 N/m", "32 N/m"]', '["8 N/m", "-1 N/m", "5 kg"]')
    with pytest.raises(BadCase) as error:
        prepared(read(text), "stiffness")
    paths = [problem.path for problem in error.value.problems]
    assert paths == [
        "point 2 (stiffness -1 N/m): joint.spring.stiffness",
        "point 3 (stiffness 5 kg): joint.spring.stiffness",
    ]


def test_there_is_no_such_sweep():
    with pytest.raises(BadCase, match="did you mean 'stiffness'"):
        prepared(read(), "stifness")


def test_the_name_of_a_point_follows_from_the_case_alone():
    scene = read()
    table = scene.sweep["stiffness"]
    keys = [points.key(s) for s in points.scenes(scene, table, "")]
    assert len(set(keys)) == 3
    other = read(CASE.replace('of = "probe.weight.x"\nprinted', 'of = "probe.weight.y"\nprinted'))
    assert [points.key(s) for s in points.scenes(other, other.sweep["stiffness"], "")] == keys
    heavier = read(CASE.replace('mass = "2 kg"', 'mass = "3 kg"'))
    assert not set(keys) & {points.key(s) for s in points.scenes(heavier, table, "")}


def test_the_name_of_a_point_follows_from_files_too(tmp_path):
    (tmp_path / "mesh.msh").write_text("one")
    scene = read().model_copy(update={"folder": tmp_path, "text": 'mesh = "mesh.msh"'})
    before = points.key(scene)
    (tmp_path / "mesh.msh").write_text("other")
    assert points.key(scene) != before


def test_ramps_that_differ_in_their_end_are_told_apart_by_it():
    ramps = [{"ramp": {"end": "2 s", "to": f"{T} degC"}} for T in (80, 130, 180)]
    assert differing(ramps) == ["80 degC", "130 degC", "180 degC"]
    two = [{"ramp": {"end": "1 s", "to": "80 degC"}}, {"ramp": {"end": "2 s", "to": "90 degC"}}]
    assert differing(two) == [two[0]["ramp"], two[1]["ramp"]]
    assert differing(["1 m", "2 m"]) == ["1 m", "2 m"]
    assert differing([ramps[0], ramps[0]]) == [ramps[0], ramps[0]]
