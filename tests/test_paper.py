"""The report on the source of the project: its document, its workshop, its checklist."""

import json
import re
from html.parser import HTMLParser

import numpy as np
import pytest
from ball_case import BALL
from rich.console import Console

from coupling.paper import checklist, document, sections, table_1, table_2, table_4
from coupling.paper.entries import VERDICTS, Entry, Section, away, number, numbers
from coupling.paper.workshop import Workshop
from coupling.verify.registry import Check, Convergence, Grid, problems


def entry(verdict="reproduced", rows=(), pictures=()):
    return Entry("Table 9", "a | b", "1", "2", "3", verdict, rows, pictures)


@pytest.fixture
def work(tmp_path):
    (tmp_path / "cases" / "ball").mkdir(parents=True)
    (tmp_path / "cases" / "ball" / "case.toml").write_text(BALL)
    return Workshop(tmp_path / "report", tmp_path / "cases")


class Links(HTMLParser):
    """Links and what they may point to."""

    def __init__(self, text):
        super().__init__()
        self.found, self.ids, self.cells = [], set(), 0
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        given = dict(attrs)
        self.cells += tag == "td"
        if "id" in given:
            self.ids.add(given["id"])
        self.found += [given[key] for key in ("href", "src") if key in given]


def test_verdicts_begin_with_known_words():
    for kind in VERDICTS:
        assert entry(f"{kind}: so it is").kind == kind
    with pytest.raises(ValueError, match="begins with one of"):
        _ = entry("perhaps").kind


def test_numbers_in_words():
    assert number(0.00190001, "m") == "0.0019 m"
    assert numbers([1.0, 2.5], "s") == "1, 2.5 s"
    assert away(1.1, 1.0) == "+10 %"
    assert away(np.nan, 1.0) == away(1.0, 0.0) == "not to be compared"


def test_every_link_of_the_document_leads_somewhere(tmp_path):
    picture = tmp_path / "fig.png"
    picture.touch()
    made = [
        Section("table_9", [entry(), entry("not determined by it", (2,), (picture,))], 1.0),
        Section("broken", [], 0.1, "ValueError: no"),
    ]
    rows = [checklist.Row(2, "beam", True, "error 1e-6"), checklist.Row(3, "arc", False, "")]
    markdown, html = document._written(tmp_path, None, made, rows)
    found = Links(html.read_text())
    for link in found.found:
        assert link[1:] in found.ids if link.startswith("#") else (tmp_path / link).exists()
    assert found.cells == 2 * 6 + 2 * 6 + 2 * 4
    text = markdown.read_text()
    assert "2 statements: 1 reproduced, 0 trend reproduced, 0 does not follow" in text
    assert "1 of 2 components" in text
    assert "Not finished: ValueError: no" in text
    assert "a \\| b" in text


def test_a_section_that_fails_does_not_lose_the_others(monkeypatch, tmp_path):
    def fails(work):
        yield entry()
        raise KeyError("gone")

    monkeypatch.setattr(document, "load", lambda name: fails)
    monkeypatch.setattr(document, "SECTIONS", {"one": "", "two": ""})
    monkeypatch.setattr(document.checklist, "rows", lambda work, made: [])
    files = document.report(None, tmp_path, Console(quiet=True))
    assert files[0].read_text().count("Not finished: KeyError: 'gone'") == 2


def test_an_unknown_section_is_bad_input(tmp_path):
    from coupling.errors import BadCase

    with pytest.raises(BadCase, match="did you mean 'table_1'"):
        document.report("tabel_1", tmp_path, Console(quiet=True))


def test_a_case_is_run_once_for_what_is_sought(work):
    said = []
    work.say = said.append
    fallen = work.run("ball", quantities={"z": "probe.ball.z"})
    np.testing.assert_allclose(fallen.values["z"][-1], -1.0, rtol=1e-6)  # g t^2 / 2
    again = work.run("ball", quantities={"z": "probe.ball.z"})
    np.testing.assert_array_equal(again.values["z"], fallen.values["z"])
    assert again.wall == fallen.wall
    longer = work.run("ball", ["heavy"], quantities={"z": "probe.ball.z"})
    np.testing.assert_allclose(longer.values["z"][-1], -4.0, rtol=1e-6)
    half = work.run("ball", overrides={"time.end": "0.5 s"}, quantities={"z": "probe.ball.z"})
    np.testing.assert_allclose(half.values["z"][-1], -0.25, rtol=1e-6)
    assert len(said) == 3


def test_a_recorded_run_has_results_and_pictures(work):
    run = work.recorded("ball")
    assert (run.code, run.reason) == (0, "")
    assert (run.folder / "results.h5").exists()
    assert run.picture("motion").exists()
    assert work.recorded("ball") == run
    assert work.picture(run.picture("motion"), "fig_1").parent == work.folder


def test_what_was_interrupted_is_not_kept(work):
    with pytest.raises(ZeroDivisionError):
        work.once("", ("key",), lambda: 1 / 0)
    assert work.once("", ("key",), lambda: [1, 2]) == [1, 2]
    assert [json.loads(f.read_text()) for f in work.kept.iterdir()] == [[1, 2]]


def test_the_checklist_is_whole_and_its_problems_exist():
    assert list(checklist.COMPONENTS) == list(range(1, 81))
    known = {problem.name for problem in problems()}
    named = {name for _, names in checklist.COMPONENTS.values() for name in names}
    assert named <= known


def test_a_component_works_where_all_that_shows_it_is_good(monkeypatch, work):
    good, bad = Check("a", 1.0, 1.0, 1e-3), Check("b", 2.0, 1.0, 1e-3)
    answers = {"one": [good], "two": [good, bad]}
    monkeypatch.setattr(work, "verified", lambda name: answers[name])
    table = {1: ("x", ("one",)), 2: ("y", ("one", "two")), 3: ("z", ()), 4: ("w", ())}
    monkeypatch.setattr(checklist, "COMPONENTS", table)
    rows = checklist.rows(work, [Section("s", [entry(rows=(4,))], 0.0)])
    assert [row.works for row in rows] == [True, False, False, True]
    assert "b 2 for 1, error 1 of it" in rows[1].shown


def test_the_worst_result_of_a_problem_is_shown():
    orders = Convergence("tip", (1, 2, 4), (1.0, 0.25, 0.0625), 2.0, 0.1)
    grid = Grid("table", ("a",), ("r",), [[0.5]], [[0.52]], 0.1)
    assert checklist._said(orders) == "tip: order 2.00, theory 2"
    assert checklist._said(grid) == "table: errors up to 0.02"
    assert checklist._margin(grid) == pytest.approx(0.2)


def test_determination_of_a_perfect_law_and_of_the_mean():
    measured = np.array([1.0, 2.0, 4.0])
    assert table_1.determination(measured, measured) == 1.0
    assert table_1.determination(np.full(3, measured.mean()), measured) == pytest.approx(0.0)


def test_the_material_of_the_paper_has_its_printed_numbers(work):
    shown = {one.claim: one.inputs for one in table_1.entries(work)}
    assert shown["Young's modulus E [GPa] at -200, 25, 200 degC"].startswith("69.58, 69, 66.13")
    assert "4.96 %" in shown["fall of E from -200 to 200 degC"]


def test_kinematics_of_table_4(work):
    shown = {one.claim: one for one in table_4.entries(work)}
    turn = shown["Configuration 2: 0.05 rad/s for 567 s"]
    assert turn.inputs.startswith("1624 deg, 4.5 turns")  # 28.35 rad
    assert turn.corrected.startswith("0.0801 deg/s")
    ring = shown["Configuration 3: 0.01 rad/s^2 for 6000 s"]
    assert ring.inputs.startswith("1.8e+05 rad, 60 rad/s, a rim of 3000 m/s")
    assert "1.745e-07 rad/s^2" in ring.corrected
    assert "25.07 s" in ring.corrected


def test_rayleigh_factors_of_table_2():
    low, high = re.findall(r"(\d\.\d{3}) (?:and|Hz)", table_2._damping().inputs)[:2]
    # zeta = (a/w + b w)/2 at both
    for f in (float(low), float(high)):
        w = 2 * np.pi * f
        assert 0.5 * (0.12 / w + 1.5e-4 * w) == pytest.approx(0.005, rel=1e-3)


@pytest.mark.parametrize("name", sections.SECTIONS)
def test_every_section_can_be_loaded(name):
    assert callable(sections.load(name))
