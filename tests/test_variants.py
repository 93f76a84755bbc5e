"""[variant.NAME] and --variant NAME: named changes of a case."""

import tomllib
from pathlib import Path

import pytest
from ball_case import BALL

from coupling import casefile
from coupling.errors import BadCase

CASES = sorted((Path(__file__).parent.parent / "cases").glob("*/case.toml"))
TOO_HOT = [("hinge_pentagonal", name) for name in ("hua2026", "hua2026_10", "hua2026_15")]
"""Variants whose printed temperatures no material of the library reaches."""


@pytest.fixture
def case(tmp_path):
    (tmp_path / "case.toml").write_text(BALL)
    return tmp_path


def test_a_variant_changes_entries_and_settings_come_after_it(case):
    scene = casefile.read(case, ["time.end='3 s'"], ["heavy"])
    assert scene.body["ball"].mass == 5.0
    assert scene.time.end == 3.0


def test_a_variant_takes_tables_away_and_variants_add_up(case):
    scene = casefile.read(case, (), ["weightless", "heavy"])
    assert scene.gravity is None
    assert scene.body["ball"].mass == 5.0
    assert casefile.read(case).gravity is not None


def test_the_text_of_the_scene_is_the_changed_case(case):
    scene = casefile.read(case, (), ["heavy", "weightless"])
    again = casefile.from_text(scene.text, case)
    assert again.body["ball"].mass == 5.0
    assert again.gravity is None


@pytest.mark.parametrize(
    ("variants", "said"),
    [
        (["haevy"], "did you mean 'heavy'"),
        (["heavy", "lighter", "none"], "lighter"),
    ],
)
def test_unknown_variants_are_all_said(case, variants, said):
    with pytest.raises(BadCase, match=said) as raised:
        casefile.read(case, (), variants)
    assert len(raised.value.problems) == sum(v != "heavy" for v in variants)


def test_what_is_wrong_in_a_variant_is_said_without_choosing_it(tmp_path):
    text = BALL.replace('"body.ball.mass" =', '"body..mass" =').replace("title", "titel")
    (tmp_path / "case.toml").write_text(text)
    with pytest.raises(BadCase) as raised:
        casefile.read(tmp_path)
    assert {p.path for p in raised.value.problems} >= {"variant.heavy.titel"}


def test_taking_away_what_is_not_there_is_bad_input(tmp_path):
    (tmp_path / "case.toml").write_text(BALL.replace('["gravity"]', '["joint.hinge"]'))
    with pytest.raises(BadCase, match="is not there to be taken away"):
        casefile.read(tmp_path, (), ["weightless"])


@pytest.mark.parametrize("file", CASES, ids=lambda file: file.parent.name)
def test_the_variants_of_the_shipped_cases_are_good_cases(file):
    for name in tomllib.loads(file.read_text()).get("variant", {}):
        if (file.parent.name, name) not in TOO_HOT:
            casefile.read(file, (), [name])


@pytest.mark.parametrize(("case", "name"), TOO_HOT)
def test_printed_gradients_leave_the_range_of_the_material(case, name):
    with pytest.raises(BadCase) as raised:
        casefile.read(CASES[0].parent.parent / case, (), [name])
    assert {p.path.partition(".")[0] for p in raised.value.problems} == {"material"}
    assert all("its data end at" in p.text for p in raised.value.problems)
