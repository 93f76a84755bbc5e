"""Extremes of heat: correct, or a reason that says what is wrong and where."""

from dataclasses import replace

import numpy as np
import pytest
from heat_cases import everything, member, plain, ramp, still

from coupling.reports import heat_extremes
from coupling.reports.heat_extremes import MEMBERS, cases, row
from coupling.verify.heat import calculix_is_there
from meshes.fields import table_field
from meshes.materials import polynomial, table
from meshes.solids import box
from thermal.description import (
    Description,
    Enclosure,
    Field,
    Fixed,
    Flux,
    Link,
    Part,
    Place,
    Radiation,
    Settings,
    Side,
    Solid,
    Source,
    Wall,
)
from thermal.solvers import build

CASES = list(cases())


@pytest.mark.parametrize("case", CASES, ids=[case.what for case in CASES])
def test_correct_or_with_the_reason_that_is_due(case):
    found = [row(case, name) for name in case.solvers]
    assert [r for r in found if r[2] not in ("correct", "reason")] == []


@pytest.mark.slow
@pytest.mark.skipif(not calculix_is_there(), reason="CalculiX is not installed")
def test_calculix_is_never_wrong_in_silence():
    """It gives up on some, and says so."""
    for case in CASES:
        if case.outside:
            outcome = row(case, "calculix")[2]
            assert outcome in ("correct", "reason", "no result"), case.what


@pytest.mark.slow
def test_report():
    (result,) = heat_extremes.report()
    assert {r[1] for r in result.rows} >= {*MEMBERS, "prescribed"}
    assert not [r for r in result.rows if str(r[2]).startswith(("crash", "silent", "off"))]


# -------------------------------------------------------------------- what conditions ask for


def advanced(name, d, t, h, settings=None):
    solver = build(name, d, settings or Settings())
    return solver.advance(solver.initial(), t, h, np.zeros_like(solver.initial()))[2]


LUMP = Part("hub", np.zeros(3), plain(), 1.0, 300.0, 0.1)
COLD = ramp(300.0, -100.0, 10.0)
BAD = {
    "wall 'c': its temperature is below 0 K": Wall(
        "c", "arm", 0.0, 1.0, None, (COLD,) * 2, (COLD,) * 2
    ),
    "fixed 'c': its temperature is below 0 K": Fixed("c", Place("arm", "end"), COLD),
    "enclosure 'c': its temperature is below 0 K": Enclosure(
        "c", (Side("arm", "start"),), (0.5,), np.zeros((1, 1)), COLD
    ),
    "flux 'c': its density is not a number": Flux("c", "arm", still(float("nan"))),
}


@pytest.mark.parametrize("said", BAD)
@pytest.mark.parametrize("name", MEMBERS)
def test_conditions_that_ask_for_the_impossible_are_named(name, said):
    d = Description((member("arm", wall_points=4),), conditions=(BAD[said],))
    why = advanced(name, d, 9.0, 1.0)
    assert said in why
    assert why.startswith("t = ")


@pytest.mark.parametrize("name", MEMBERS)
def test_links_to_below_absolute_zero_and_beyond_their_law_are_named(name):
    mount = Link("mount", Place("hub"), still(-1.0), 1.0)
    assert "link 'mount': its temperature is below 0 K: -1 K" in advanced(
        name, Description(parts=(LUMP,), links=(mount,)), 0.0, 1.0
    )
    law = table("law", "-", [290.0, 310.0], [1.0, 2.0])
    hot = Link("mount", Place("hub"), still(400.0), 1.0, law)
    why = advanced(name, Description(parts=(LUMP,), links=(hot,)), 0.0, 1.0)
    assert "link 'mount' left the range of its law (290 K to 310 K) with 350" in why


@pytest.mark.parametrize("name", (*MEMBERS, "prescribed"))
def test_a_field_outside_its_times_is_named(name):
    arm = member("arm")
    field = table_field([0.0, 5.0], [0.0, 1.0], [[300.0] * 2, [310.0] * 2], arm.points[[0, -1]])
    d = Description((arm,), conditions=(Field("told", "arm", field),))
    assert advanced(name, d, 0.0, 5.0) == ""
    assert "field 'told' is known from 0 s to 5 s only" in advanced(name, d, 4.0, 2.0)


@pytest.mark.parametrize("name", (*MEMBERS, "prescribed"))
@pytest.mark.parametrize(
    ("field", "said"),
    [
        (lambda x, t: np.full(len(x), -5.0), "temperatures must be above 0 K, got -5 K"),
        (lambda x, t: np.full(3, 300.0), "temperatures, got (3,)"),
        (table_field([0.0], [0.0, 0.5], [[300.0] * 2], [[0, 0, 0], [1, 0, 0]]), "0.5 m"),
    ],
    ids=["below 0 K", "of a wrong shape", "far away"],
)
def test_a_field_is_asked_before_anything_is_solved(name, field, said):
    with pytest.raises(ValueError, match="field 'told'") as error:
        build(name, Description((member("arm"),), conditions=(Field("told", "arm", field),)))
    assert said in str(error.value)


# ------------------------------------------------------------------------------- given twice

BLOCK = Solid("block", box((1.0, 1.0, 1.0), (2, 2, 2)), {"": plain()}, 300.0)


def held(name, face):
    return Fixed(name, Place("block", face), still(310.0))


@pytest.mark.parametrize("name", ["line", "solid", "prescribed"])
@pytest.mark.parametrize(
    "pair",
    [
        (held("a", "x0"), held("b", "x0")),
        (held("a", None), held("b", "x0")),
        (held("a", "outer"), held("b", "y1")),
        (held("a", "x0"), Field("b", "block", lambda x, t: np.full(len(x), 300.0))),
    ],
    ids=["face", "whole", "boundary", "field"],
)
def test_pieces_of_a_solid_prescribed_twice_are_refused(name, pair):
    with pytest.raises(ValueError, match="'a' and 'b' both prescribe temperatures of 'block'"):
        build(name, Description(solids=(BLOCK,), conditions=pair))


def test_faces_may_meet_and_the_first_has_the_edge():
    both = (held("a", "x0"), replace(held("b", "y0"), temperature=still(400.0)))
    solver = build("solid", Description(solids=(BLOCK,), conditions=both))
    T, flows, why = solver.advance(solver.initial(), 0.0, 1.0, np.zeros(27))
    assert why == ""
    edge = (solver.x[:, 0] == 0.0) & (solver.x[:, 1] == 0.0)
    assert (T[edge] == 310.0).all()
    assert (T[(solver.x[:, 1] == 0.0) & ~edge] == 400.0).all()
    assert set(flows) == {"a", "b"}


# ----------------------------------------------------------------------------- single sentences


@pytest.mark.parametrize("name", MEMBERS)
def test_parallel_rays_do_not_fall_on_a_lump(name):
    sun = Flux("sun", "hub", still(1.0), np.array([0.0, 0.0, 1.0]))
    said = "flux 'sun': parallel rays do not fall on part 'hub', which has no shape"
    with pytest.raises(ValueError, match=said):
        build(name, Description(parts=(LUMP,), conditions=(sun,)))


def test_emissivities_beyond_one_are_refused_or_told_when_reached():
    bounded = polynomial("emissivity", "-", [0.0, 2e-3], 0.0, 100.0, 600.0)
    with pytest.raises(ValueError, match="emissivity must be 0 to 1"):
        build("line", Description(parts=(LUMP,), conditions=(
            Radiation("space", "hub", bounded, still(4.0)),)))  # fmt: skip
    endless = polynomial("emissivity", "-", [0.0, 2e-3])
    conditions = (
        Radiation("space", "hub", endless, still(4.0)),
        Source("s", Place("hub"), still(1e5)),
    )
    why = advanced("line", Description(parts=(LUMP,), conditions=conditions), 0.0, 1e3)
    assert "radiation 'space': emissivity must be 0 to 1, got 1" in why


@pytest.mark.parametrize("exponent", [-9, -3, 3, 9])
def test_heat_is_booked_in_windows_of_every_length(exponent):
    solver, h = build("line", everything()), 10.0**exponent
    T = solver.initial()
    end, flows, why = solver.advance(T, 20.0, h, np.zeros_like(T))
    if exponent < 9:
        assert why == ""
    if why == "":
        exchanged = sum(abs(flow) for flow in flows.values())
        size = abs(solver.energy(T)) + abs(solver.energy(end)) + exchanged
        assert abs(solver.energy(end) - solver.energy(T) - sum(flows.values())) < 1e-12 * size
