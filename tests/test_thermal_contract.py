"""What every thermal solver owes its caller, and what all of them refuse."""

import os
import shutil
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from heat_cases import everything, member, plain, ramp, still, varying

from meshes.sections import circle
from thermal.description import (
    Description,
    Fixed,
    Flux,
    Link,
    Part,
    Place,
    Radiation,
    Source,
    Wall,
)
from thermal.solvers import SOLVERS, build

PROGRAM = pytest.mark.skipif(
    shutil.which(os.environ.get("THERMOBODY_CCX", "ccx")) is None,
    reason="CalculiX (ccx) is not installed",
)
EVERY = pytest.mark.parametrize(
    "name", [pytest.param(n, marks=PROGRAM) if n == "calculix" else n for n in SOLVERS]
)
EXACT = pytest.mark.parametrize("name", [n for n in SOLVERS if n != "calculix"])
"""All but CalculiX, whose heat is known to its printed digits only."""
NUMBERED = pytest.mark.parametrize("name", ["line", "wall", "lumped", "prescribed"])
"""Those whose temperatures are those of stations, points round them, and lumps."""
SIDE = np.array([0.0, 1.0, 0.0])


def covered(material=None):
    """A description that also the prescribed solver takes: every station has its condition."""
    d = everything(material)
    walls = (
        replace(d.conditions[0], start=0.0, end=2.0),
        Wall("bar", "bar", 0.0, 0.5, SIDE, (still(305.0),) * 2, (ramp(305.0, 290.0, 6.0),) * 2),
    )
    return replace(d, conditions=(*walls, *d.conditions[1:]))


@EVERY
def test_every_temperature_has_a_place_and_an_owner(name):
    solver = build(name, covered())
    n = len(solver.x)
    assert solver.x.shape == (n, 3)
    owned = np.concatenate(list(solver.regions.values()))
    assert len(set(owned)) == len(owned)
    if name == "hermite":  # besides 11 stations' temperatures as many slopes, of one value or four
        assert len(owned) == 7 * 4 + 4 + 2
    elif name not in ("solid", "calculix"):
        assert n == len(owned) == 7 * 4 + 4 + 2
    assert list(solver.regions) == ["boom", "bar", "hub", "pin"]
    assert solver.initial().shape == (n,)


@NUMBERED
def test_wall_points_sit_on_the_mean_surface_from_e2_towards_e3(name):
    solver = build(name, covered())
    first = solver.x[solver.regions["boom"]][:4]
    expected = 0.05 * np.array([[0, 1, 0], [0, 0, 1], [0, -1, 0], [0, 0, -1]])
    np.testing.assert_allclose(first, expected, atol=1e-15)
    np.testing.assert_allclose(solver.x[solver.regions["bar"]][-1], [2.5, 0, 0], atol=1e-15)
    np.testing.assert_allclose(solver.x[solver.regions["pin"]], [[1, 1, 1]])


@NUMBERED
def test_all_number_and_place_their_temperatures_alike(name):
    one, other = build(name, covered()), build("line", covered())
    np.testing.assert_array_equal(one.x, other.x)
    for region, nodes in one.regions.items():
        np.testing.assert_array_equal(nodes, other.regions[region])


@EXACT
@pytest.mark.parametrize("material", [plain(), varying()])
def test_flows_and_heat_are_what_is_stored(name, material):
    solver = build(name, covered(material))
    T, rng = solver.initial(), np.random.default_rng(0)
    for i in range(10):
        heat = rng.uniform(0.0, 20.0, len(T))
        new, flows, why = solver.advance(T, 0.7 * i, 0.7, heat)
        assert why == ""
        stored = solver.energy(new) - solver.energy(T)
        largest = max(*map(abs, flows.values()), heat.sum())
        assert abs(sum(flows.values()) + heat.sum() - stored) < 1e-11 * largest
        T = new


@EVERY
def test_advancing_leaves_its_arguments_alone_and_repeats_itself(name):
    solver = build(name, covered())
    T = solver.initial()
    heat = np.arange(float(len(T)))
    kept, kept_heat = T.copy(), heat.copy()
    first, flows, _ = solver.advance(T, 1.0, 0.5, heat)
    solver.advance(first, 1.5, 0.5, heat)
    again, again_flows, _ = solver.advance(T, 1.0, 0.5, heat)
    np.testing.assert_array_equal(T, kept)
    np.testing.assert_array_equal(heat, kept_heat)
    np.testing.assert_array_equal(first, again)
    assert flows == again_flows
    fresh = build(name, covered())
    np.testing.assert_array_equal(fresh.advance(T, 1.0, 0.5, heat)[0], first)


@NUMBERED
def test_given_temperatures_are_met_at_the_end(name):
    solver = build(name, covered())
    T, _, _ = solver.advance(solver.initial(), 0.0, 3.0, np.zeros(len(solver.x)))
    assert T[solver.regions["pin"]][0] == pytest.approx(305.0 + 25.0 * 3.0 / 4.0, rel=1e-14)
    np.testing.assert_allclose(T[solver.regions["bar"]], (305.0 + 297.5) / 2, rtol=1e-14)


@EVERY
def test_leaving_the_range_of_a_property_is_a_reason(name):
    solver = build(name, covered(varying(200.0, 330.0)))
    T, why = solver.initial(), ""
    for i in range(10):
        T, _, why = solver.advance(T, float(i), 1.0, np.zeros(len(T)))
        if why:
            break
    assert "'boom' left the range of" in why
    assert i < 9


@pytest.mark.parametrize("name", ["line", "lumped"])
def test_the_range_of_the_conductivity_is_watched_too(name):
    material = replace(varying(), conductivity=varying(200.0, 320.0).conductivity)
    solver = build(name, scene(WALL, members=(replace(ARM, material=material),)))
    _, _, why = solver.advance(solver.initial(), 0.0, 1.0, np.zeros(len(solver.x)))
    assert "'arm' left the range of conductivity (200 K to 320 K)" in why


@EVERY
def test_two_half_windows_are_as_good_as_one(name):
    solver = build(name, covered())
    T, heat = solver.initial(), np.full(len(solver.x), 10.0)
    once, _, _ = solver.advance(T, 0.0, 2.0, heat)
    half, _, _ = solver.advance(T, 0.0, 1.0, heat / 2)
    twice, _, _ = solver.advance(half, 1.0, 1.0, heat / 2)
    np.testing.assert_allclose(once, twice, rtol=0.0, atol=5e-3)


@pytest.mark.parametrize("name", ["line", "lumped"])
def test_flows_carry_the_names_of_conditions_and_outer_links(name):
    d = covered()
    solver = build(name, d)
    _, flows, _ = solver.advance(solver.initial(), 0.0, 1.0, np.zeros(len(solver.x)))
    assert set(flows) == {c.name for c in d.conditions} | {"mount", "air"}
    assert flows["heater"] == pytest.approx(12.0, rel=1e-12)
    assert flows["mount"] < 0.0
    assert flows["space"] < 0.0 < flows["sun"]


def test_prescribed_heat_goes_to_the_reservoir():
    solver = build("prescribed", covered())
    T = solver.initial()
    end, flows, _ = solver.advance(T, 100.0, 1.0, np.full(len(T), 2.0))
    _, more, _ = solver.advance(end, 101.0, 1.0, np.full(len(T), 2.0))
    assert more["reservoir"] == pytest.approx(-2.0 * len(T), rel=1e-12)
    assert set(flows) == {"reservoir"}


def test_prescribed_needs_all_members_covered():
    with pytest.raises(ValueError, match=r"member 'boom'.* at 0 m, 0.333333 m") as error:
        build("prescribed", everything())
    assert "member 'bar'" in str(error.value)


def test_unknown_solver_is_answered_with_the_list():
    with pytest.raises(ValueError, match="line, hermite, wall, solid, lumped"):
        build("lines", everything())


def test_only_the_line_solver_imports_scikit_fem():
    code = (
        "import sys; sys.path.insert(0, 'tests'); from thermal.solvers import build;"
        "from test_thermal_contract import covered; build('lumped', covered());"
        "build('prescribed', covered()); assert 'skfem' not in sys.modules;"
        "build('line', covered()); assert 'skfem' in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


HOT = (still(350.0), still(350.0))
WALL = Wall("wall", "arm", 0.0, 1.0, SIDE, HOT, HOT)
HUB = Part("hub", np.zeros(3), plain(), 1.0, 300.0)
ARM = member(wall_points=4)
LINK = Link("link", Place("hub"), Place("arm", "start"), 1.0)
DENSITY = still(1.0)


def scene(*conditions, members=(ARM,), parts=(HUB,), links=(LINK,)):
    return Description(members, parts, links, conditions)


BAD = {
    "neither members nor parts": Description(()),
    "member, part, sheet or solid 'arm': the name is used 2 times": scene(members=(ARM, ARM)),
    "member, part, sheet or solid 'hub': the name is used 2 times": scene(parts=(HUB, HUB)),
    "condition or link 'link': the name is used 2 times": scene(
        Source("link", Place("hub"), DENSITY)
    ),
    "wall_points must be 1 or an even number from 4 on, got 0": scene(
        members=(replace(ARM, wall_points=0),)
    ),
    "wall_points must be 1 or an even number from 4 on, got 2": scene(
        members=(replace(ARM, wall_points=2),)
    ),
    "wall_points must be 1 or an even number from 4 on, got 5": scene(
        members=(replace(ARM, wall_points=5),)
    ),
    "a section of kind 'circle' has no wall": scene(members=(replace(ARM, section=circle(0.1)),)),
    "needs two or more points": scene(members=(replace(ARM, points=ARM.points[:1]),)),
    "needs axes of shape (9, 3, 3)": scene(members=(replace(ARM, axes=ARM.axes[1:]),)),
    "must be finite": scene(members=(replace(ARM, points=ARM.points * np.nan),)),
    "two neighbouring points coincide": scene(
        members=(replace(ARM, points=ARM.points.repeat(2, 0)[:9]),)
    ),
    "its axes must be orthonormal": scene(members=(replace(ARM, axes=2.0 * ARM.axes),)),
    "member 'arm': its initial temperature must be above 0 K": scene(
        members=(replace(ARM, initial=-20.0),)
    ),
    "member 'arm': initial temperature 300 K is outside the range of conductivity": scene(
        members=(replace(ARM, material=varying(310.0, 400.0)),)
    ),
    "part 'hub': its mass must be positive": scene(parts=(replace(HUB, mass=0.0),)),
    "part 'hub': its position must be": scene(parts=(replace(HUB, position=np.zeros(2)),)),
    "part 'hub': its initial temperature": scene(parts=(replace(HUB, initial=float("nan")),)),
    "link 'link': there is no member, part, sheet or solid 'hull'": scene(
        links=(replace(LINK, a=Place("hull")),)
    ),
    "link 'link': part 'hub' has no ends": scene(links=(replace(LINK, a=Place("hub", "end")),)),
    "link 'link': both its ends are at the same place": scene(
        links=(replace(LINK, b=Place("hub")),)
    ),
    "link 'link': conductance must be positive": scene(links=(replace(LINK, conductance=-1.0),)),
    "wall 'wall': there is no member 'leg'": scene(replace(WALL, member="leg")),
    "wall 'wall': its stretch from 0.5 m to 1.2 m": scene(replace(WALL, start=0.5, end=1.2)),
    "wall 'wall': its stretch from 0.8 m to 0.2 m": scene(replace(WALL, start=0.8, end=0.2)),
    "wall 'wall': no station of member 'arm'": scene(replace(WALL, start=0.51, end=0.52)),
    "wall 'wall': side is parallel to member 'arm'": scene(replace(WALL, side=ARM.axes[0, 0])),
    "wall 'wall': side must be a direction": scene(replace(WALL, side=np.zeros(3))),
    "flux 'sun': there is no member, part, sheet or solid 'leg'": scene(
        Flux("sun", "leg", DENSITY)
    ),
    "flux 'sun': direction must not be zero": scene(Flux("sun", "arm", DENSITY, np.zeros(3))),
    "radiation 'space': there is no member, part, sheet or solid 'leg'": scene(
        Radiation("space", "leg", 0.5, DENSITY)
    ),
    "radiation 'space': emissivity must be 0 to 1, got 1.2": scene(
        Radiation("space", "arm", 1.2, DENSITY)
    ),
    "fixed 'base': there is no member, part, sheet or solid 'leg'": scene(
        Fixed("base", Place("leg"), DENSITY)
    ),
    "source 'heater': of 'arm' give 'start', 'end', got 'middle'": scene(
        Source("heater", Place("arm", "middle"), DENSITY)
    ),
    "'wall' and 'base' both prescribe temperatures of 'arm'": scene(
        WALL, Fixed("base", Place("arm", "start"), DENSITY)
    ),
    "'one' and 'two' both prescribe temperatures of 'hub'": scene(
        Fixed("one", Place("hub"), DENSITY), Fixed("two", Place("hub"), DENSITY)
    ),
}


@EVERY
@pytest.mark.parametrize("problem", BAD)
def test_senseless_descriptions_are_refused(name, problem):
    with pytest.raises(ValueError) as error:
        build(name, BAD[problem])
    assert problem in str(error.value)


def test_all_problems_are_listed_at_once():
    with pytest.raises(ValueError) as error:
        build(
            "line",
            scene(
                replace(WALL, start=5.0, end=6.0),
                Radiation("space", "arm", -0.1, DENSITY),
                Fixed("base", Place("leg"), DENSITY),
            ),
        )
    assert "3 problems" in str(error.value)
    assert len(str(error.value).splitlines()) == 4


@pytest.mark.parametrize(("name", "module"), [("line", "integration"), ("lumped", "trbdf2")])
def test_a_history_too_rough_for_any_step_is_a_reason(name, module, monkeypatch):
    """A source that is noise at every scale ends in a sentence, not in a hang."""
    monkeypatch.setattr(f"thermal.{module}.STEPS", 500)
    source = Source("noise", Place("hub"), lambda t: 1e9 * np.sin(1e9 * t * t))
    hub = Part("hub", np.zeros(3), plain(), 1e3, 300.0)
    solver = build(name, Description((), (hub,), conditions=(source,)))
    _, _, why = solver.advance(solver.initial(), 0.0, 10.0, np.zeros(1))
    assert "more than 500 steps" in why
