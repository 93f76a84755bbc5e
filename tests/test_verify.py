"""Every registered verification problem, and the registry itself."""

from io import StringIO
from math import inf, isfinite, nan

import pytest
from rich.console import Console

from coupling.errors import BadCase
from coupling.verify import registry, table
from coupling.verify.registry import (
    AREAS,
    GROUPS,
    Check,
    Convergence,
    Grid,
    Problem,
    problem,
    problems,
)

SLOW = {  # more than 5 s, some of them by CalculiX
    "dynamics: flying spaghetti",
    "contact: energy over ten thousand impacts",
    "contact: restitution, each law at 1 mm/s to 10 m/s",
    "contact: slider-crank with a loose slider",
    "heat: semi-infinite aluminium, flux",
    "heat: semi-infinite aluminium, step",
    "heat: slab cooled by convection, Bi = 1",
    "heat: 1 mm aluminium plate radiates",
    "heat: NAFEMS T2, radiating end",
    "heat: NAFEMS T3, transient conduction",
    "heat: shocks with steps by tolerance",
    "coupling: friction that feeds itself: speed of seizure",
    "coupling: friction that feeds itself: course",
    "coupling: thermal flutter: rate of growth",
    "coupling: thermal flutter: critical damping",
}


def _title(p):
    return f"{p.area}: {p.name}"


def _parameter(p):
    marks = [pytest.mark.slow] if _title(p) in SLOW else []
    return pytest.param(p, id=_title(p), marks=marks)


@pytest.mark.parametrize("solved", [_parameter(p) for p in problems()])
def test_problem(solved):
    results = solved.solve()
    assert results
    assert all(isfinite(r.tolerance) and r.tolerance >= 0.0 for r in results)
    assert not [_said(r) for r in results if not r.passed]


def _said(result):
    if isinstance(result, Convergence):
        return f"{result.name}: order {result.order:.2f} instead of {result.theory}"
    if isinstance(result, Grid):
        return f"{result.name}: {dict(zip(result.rows, result.errors, strict=True))}"
    return f"{result.name}: {result.value} instead of {result.reference}, {result.error:.2g}"


def test_slow_ones_exist():
    assert {_title(p) for p in problems()} >= SLOW


# -- checks ------------------------------------------------------------------------------------


def test_error_is_relative_to_the_reference():
    assert Check("", 99.0, 100.0, 0.0).error == pytest.approx(0.01)
    assert Check("", -99.0, -100.0, 0.0).error == pytest.approx(0.01)
    assert Check("", 99.0, 100.0, 0.0, absolute=True).error == 1.0


@pytest.mark.parametrize(("value", "passed"), [(1.009, True), (0.991, True), (1.011, False)])
def test_tolerance(value, passed):
    assert Check("", value, 1.0, 0.01).passed is passed
    assert Check("", 10.0 * value, 10.0, 0.1, absolute=True).passed is passed


@pytest.mark.parametrize("absolute", [True, False])
@pytest.mark.parametrize(
    "numbers",
    [
        (nan, 1.0, 1.0),
        (1.0, nan, 1.0),
        (1.0, 1.0, nan),
        (inf, 1.0, 1.0),
        (inf, inf, inf),
        (-inf, 1.0, inf),
    ],
)
def test_what_is_no_number_never_passes(numbers, absolute):
    assert not Check("", *numbers, absolute=absolute).passed


@pytest.mark.parametrize("value", [0.0, 1e-300, 1.0])
def test_nothing_is_relative_to_zero(value):
    assert not Check("", value, 0.0, 1e-3).passed
    assert Check("", value, 0.0, 1.0, absolute=True).passed


# -- convergence -------------------------------------------------------------------------------


def _convergence(order, sizes=(4, 8, 16), theory=2.0, tolerance=0.1):
    falling = sizes[0] > sizes[-1]
    errors = [0.3 * s ** (order if falling else -order) for s in sizes]
    return Convergence("rows", sizes, errors, theory, tolerance)


@pytest.mark.parametrize("sizes", [(4, 8, 16), (3, 5, 21, 40), (0.1, 0.05, 0.01)])
@pytest.mark.parametrize("order", [1.0, 2.0, 4.0])
def test_observed_order(order, sizes):
    rows = _convergence(order, sizes)
    assert rows.order == pytest.approx(order)
    assert rows.orders == pytest.approx([order] * (len(sizes) - 1))


@pytest.mark.parametrize(
    ("order", "passed"), [(2.0, True), (2.09, True), (1.91, True), (1.85, False), (2.2, False)]
)
def test_the_order_must_be_that_of_the_theory_to_either_side(order, passed):
    assert _convergence(order).passed is passed


@pytest.mark.parametrize("errors", [(1.0, 0.25), (1.0, 0.0, 0.1), (1.0, nan, 0.1), (1.0, inf, 0.1)])
def test_rows_without_an_order_never_pass(errors):
    assert not Convergence("rows", (1, 2, 4)[: len(errors)], errors, 2.0, 10.0).passed


# -- grids -------------------------------------------------------------------------------------


def _grid(values, tolerance=0.1):
    return Grid("rebound", ("slow", "fast"), ("steel", "wood"), values, [[1, 2], [3, 4]], tolerance)


def test_errors_of_a_grid_are_the_largest_of_each_row():
    assert _grid([[1.01, 1.95], [3.0, 4.0]]).errors == pytest.approx([0.05, 0.0])


@pytest.mark.parametrize("worst", [4.2, 3.8, nan, inf, -inf])
def test_one_value_decides_about_a_grid(worst):
    assert _grid([[1.0, 2.0], [3.0, 4.05]]).passed
    assert not _grid([[1.0, 2.0], [3.0, worst]]).passed


# -- registry ----------------------------------------------------------------------------------


def test_each_area_has_problems_with_name_and_source():
    for area in AREAS:
        found = problems(area)
        assert found
        assert {p.area for p in found} == {area}
        assert all(p.name and p.source for p in found)


def test_names_are_unique():
    titles = [_title(p) for p in problems()]
    assert len(titles) == len(set(titles))


def test_all_areas_together_are_the_areas_one_by_one():
    assert len(problems()) == sum(len(problems(area)) for area in AREAS)


def test_a_group_is_its_areas():
    mechanics = problems("mechanics")
    assert {p.area for p in mechanics} == set(GROUPS["mechanics"])
    assert {p.area for p in problems()} - {p.area for p in mechanics} == {
        "continuum", "contact", "heat", "thermoelastic", "coupling"
    }  # fmt: skip


def test_decorator_registers_and_leaves_the_function_alone(monkeypatch):
    monkeypatch.setattr(registry, "PROBLEMS", [])

    @problem("beams", "a name", "a source")
    def solve():
        return [Check("one", 1.0, 1.0, 0.0)]

    (registered,) = registry.PROBLEMS
    assert registered == Problem("beams", "a name", "a source", solve)
    assert solve()[0].passed


# -- table -------------------------------------------------------------------------------------


def _shown(monkeypatch, solve, area="beams"):
    monkeypatch.setattr(registry, "PROBLEMS", [Problem("beams", "a problem", "a source", solve)])
    out = StringIO()
    return table.show(area, Console(file=out, width=120)), out.getvalue()


def _broken():
    raise RuntimeError("no equilibrium")


@pytest.mark.parametrize(
    ("solve", "passed", "said"),
    [
        (lambda: [Check("sag", 2.0, 2.0, 0.1, "m")], True, "all pass"),
        (lambda: [Check("sag", 2.0, 2.0, 0.1), Check("tip", 2.0, 1.0, 0.1)], False, "1 FAIL"),
        (lambda: [Check("sag", nan, 2.0, 0.1)], False, "nan"),
        (lambda: [_convergence(2.0)], True, "2.00"),
        (lambda: [_convergence(1.0)], False, "-1.00"),
        (lambda: [Convergence("rows", (1, 2), (1.0, 0.0), 2.0, 0.1)], False, "-inf"),
        (lambda: [_grid([[1.0, 2.0], [3.0, 4.05]])], True, "5.0e-02"),
        (lambda: [_grid([[1.0, nan], [3.0, 4.0]])], False, "inf"),
        (lambda: [], False, "nothing was checked"),
        (_broken, False, "RuntimeError: no equilibrium"),
    ],
    ids=[
        "good",
        "one of two bad",
        "not a number",
        "order",
        "wrong order",
        "none",
        "grid",
        "bad grid",
        "empty",
        "raises",
    ],
)
def test_table(monkeypatch, solve, passed, said):
    verdict, text = _shown(monkeypatch, solve)
    assert verdict is passed
    assert said in text
    assert "a problem" in text
    assert ("FAIL" in text) is not passed


def test_table_of_an_area_that_does_not_exist(monkeypatch):
    with pytest.raises(BadCase, match="beems"):
        _shown(monkeypatch, _broken, "beems")
