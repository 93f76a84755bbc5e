"""Heat by CalculiX: closed forms, our other solvers, refusals, broken programs."""

import re
import shutil
from dataclasses import replace
from math import cos, exp, tan

import numpy as np
import pytest
from heat_cases import member, plain, ramp, still, varying
from scipy.optimize import brentq
from scipy.special import erfc

from meshes.materials import polynomial, table
from meshes.mesh import Mesh
from meshes.solids import box
from meshes.surfaces import plate
from thermal import calculix_deck
from thermal.calculix import CalculixHeat
from thermal.description import (
    Description,
    Enclosure,
    Film,
    Fixed,
    Flux,
    Interface,
    Irradiation,
    Link,
    Part,
    Place,
    Radiation,
    Settings,
    Sheet,
    Side,
    Solid,
    Source,
    Wall,
)
from thermal.solvers import build

pytestmark = pytest.mark.skipif(shutil.which("ccx") is None, reason="ccx is not installed")

EQUAL = Settings(steps=4, scheme="backward-euler", capacity="consistent")


def cube(material=None, initial=300.0, counts=(3, 3, 3), size=0.1, order=1, axes=None):
    """A cube whose faces are x0 to z1."""
    mesh = box([size] * 3, counts, order)
    return Solid("cube", mesh, {"": material or plain()}, initial, axes)


def lumps(**more):
    """Two parts with everything a part can have."""
    parts = (
        Part("hub", np.zeros(3), plain(), 0.5, 320.0, 0.01),
        Part("pin", np.ones(3), plain(16.0, 500.0, 8000.0), 0.2, 280.0, 0.02),
    )
    return replace(Description((), parts), **more)


def advanced(name, description, settings=EQUAL, t=0.5, h=2.0, heat=None, outside=None):
    """Temperatures after a window from the start, with its flows, and the solver."""
    solver = build(name, description, settings)
    T = solver.initial()
    heat = np.zeros(len(T)) if heat is None else heat
    T, flows, why = solver.advance(T, t, h, heat, outside or {})
    assert why == ""
    return T, flows, solver


# ------------------------------------------------------------------------- lumps and links

LAW = polynomial("law", "1", [1.0, 0.002], 300.0)
EXPRESSED = {
    "link": {"links": (Link("l", Place("hub"), Place("pin"), 2.0),)},
    "link with a law": {"links": (Link("l", Place("hub"), Place("pin"), 2.0, LAW),)},
    "link to a given": {"links": (Link("l", Place("pin"), ramp(280.0, 350.0, 2.0), 2.0),)},
    "film": {"conditions": (Film("f", "hub", ramp(20.0, 60.0, 1.0), still(350.0)),)},
    "radiation": {"conditions": (Radiation("r", "pin", 0.8, ramp(4.0, 500.0, 2.0)),)},
    "flux": {"conditions": (Flux("f", "pin", ramp(0.0, 900.0, 3.0)),)},
    "fluxes": {"conditions": (Flux("f", "pin", still(90.0)), Flux("g", "pin", ramp(0, 50, 2.0)))},
    "sources": {"conditions": (Source("s", Place("pin"), still(3.0)),
                               Source("z", Place("pin"), ramp(0.0, 9.0, 3.0)))},
    "fixed": {"conditions": (Fixed("f", Place("hub"), ramp(320.0, 380.0, 2.0)),),
              "links": (Link("l", Place("hub"), Place("pin"), 2.0),)},
}  # fmt: skip


@pytest.mark.parametrize("what", EXPRESSED)
def test_lumps_and_links_are_those_of_the_network(what):
    d, heat = lumps(**EXPRESSED[what]), np.array([3.0, 5.0])
    T, flows, solver = advanced("calculix", d, heat=heat)
    other, other_flows, _ = advanced("lumped", d, heat=heat)
    np.testing.assert_allclose(T, other, rtol=0.0, atol=1e-9)
    assert solver.exact
    for name, flow in other_flows.items():
        assert flows[name] == pytest.approx(flow, rel=1e-7, abs=1e-9)


@pytest.mark.parametrize("conductance", [0.0, 3.0])
def test_a_conductance_from_outside_is_that_of_the_window(conductance):
    d = lumps(links=(Link("contact", Place("hub"), Place("pin"), None, LAW),
                     Link("mount", Place("pin"), still(290.0), 1.0)))  # fmt: skip
    outside = {"contact": (np.array([conductance]),) * 2}
    T, flows, _ = advanced("calculix", d, outside=outside)
    other, other_flows, _ = advanced("lumped", d, outside=outside)
    np.testing.assert_allclose(T, other, rtol=0.0, atol=1e-9)
    assert flows["mount"] == pytest.approx(other_flows["mount"], rel=1e-9)


@pytest.mark.parametrize("b", [Place("pin"), still(500.0)])
def test_a_radiating_link_is_exact_but_for_the_table_of_cubes(b):
    d = lumps(links=(Link("l", Place("hub"), b, 0.0, None, 0.02),))
    T, _, solver = advanced("calculix", d)
    other, _, _ = advanced("lumped", d)
    change = np.abs(other - solver.initial()).max()
    np.testing.assert_allclose(T, other, rtol=0.0, atol=5e-6 * change)


# ------------------------------------------------------------------------------ closed forms


def test_a_step_at_the_end_of_a_long_bar():
    """Semi-infinite aluminium: T(10 mm, 1 s) = erfc(x / sqrt(4 a t)) = .39473."""
    bar = member(length=0.1, elements=50)
    d = Description((bar,), conditions=(Fixed("hot", Place("arm", "start"), still(301.0)),))
    T, flows, solver = advanced("calculix", d, Settings(steps=80), t=0.0, h=1.0)
    a = 167.0 / (896.0 * 2700.0)
    x = solver.x[:, 0]
    exact = 300.0 + erfc(x / np.sqrt(4.0 * a))
    assert abs(T - exact)[x > 0.0].max() < 6e-3
    inflow = 2.0 * 167.0 * 1e-4 / np.sqrt(np.pi * a)
    assert flows["hot"] == pytest.approx(inflow, rel=0.06)


def test_a_slab_between_films():
    """Bi = 1, Fo = .5: middle .7725, face .5045 of the first difference; by the series."""
    half, k, h = 0.05, 167.0, 3340.0
    slab = cube(size=2.0 * half, counts=(20, 1, 1))
    films = tuple(Film(f, "cube", still(h), still(300.0), f) for f in ("x0", "x1"))
    t = 0.5 * half**2 / (k / (896.0 * 2700.0))
    d = Description(conditions=films, solids=(replace(slab, initial=400.0),))
    T, flows, solver = advanced("calculix", d, Settings(steps=200), t=0.0, h=t)
    for x, place in ((0.0, half), (half, 0.0)):
        at = np.isclose(solver.x[:, 0], place)
        assert (T[at] - 300.0).mean() / 100.0 == pytest.approx(_slab(x / half), abs=2e-3)
    stored = solver.energy(T) - solver.energy(solver.initial())
    assert sum(flows.values()) == pytest.approx(stored, rel=1e-7)


def _slab(x):
    roots = [brentq(lambda z: z * tan(z) - 1.0, n * np.pi, (n + 0.5) * np.pi - 1e-9)
             for n in range(8)]  # fmt: skip
    return sum(
        4.0 * np.sin(z) / (2.0 * z + np.sin(2.0 * z)) * cos(z * x) * exp(-0.5 * z * z)
        for z in roots
    )


def test_steady_state_with_radiation():
    """NAFEMS T2: k = 55.6, 1000 K at one end, the other radiates to 300 K: 927.004 K there."""
    d = Description(
        solids=(cube(plain(55.6), 900.0, (2, 1, 1)),),
        conditions=(
            Fixed("hot", Place("cube", "x0"), still(1000.0)),
            Radiation("end", "cube", 0.98, still(300.0), "x1"),
        ),
    )
    solver = build("calculix", d)
    T, flows, why = solver.steady(solver.initial(), 0.0)
    assert why == ""
    assert T[np.isclose(solver.x[:, 0], 0.1)] == pytest.approx(927.004, abs=1e-3)
    assert flows["end"] == pytest.approx(-55.6 * 0.1 * (1000.0 - 927.004), rel=2e-5)


def test_conductivities_differ_by_direction():
    """The power through a cube is k of its direction, times side and difference."""
    stuff = replace(
        plain(100.0),
        conductivity_around=polynomial("k2", "W/(m K)", [10.0]),
        conductivity_through=polynomial("k3", "W/(m K)", [1.0]),
    )
    turned = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
    for axis, k in zip("xyz", (1.0, 100.0, 10.0), strict=True):
        ends = (
            Fixed("cold", Place("cube", f"{axis}0"), still(300.0)),
            Film("warm", "cube", still(1e9), still(310.0), f"{axis}1"),
        )
        d = Description(conditions=ends, solids=(cube(stuff, axes=turned),))
        solver = build("calculix", d)
        _, flows, why = solver.steady(solver.initial(), 0.0)
        assert why == ""
        assert flows["warm"] == pytest.approx(k * 0.1 * 10.0, rel=1e-5)


# ------------------------------------------------------------------- our solids, equal mesh


def radiating(order=1, counts=(4, 4, 4)):
    """A cube with k(T), c(T), radiation, a flux and a film."""
    return Description(
        conditions=(
            Radiation("space", "cube", 0.8, still(4.0), "x1"),
            Flux("sun", "cube", ramp(0.0, 20e3, 100.0), np.array([-1.0, 0.5, 0.0])),
            Film("air", "cube", still(50.0), still(350.0), "z0"),
            Fixed("base", Place("cube", "y1"), ramp(400.0, 420.0, 100.0)),
        ),
        solids=(cube(varying(), 400.0, counts, order=order),),
    )


@pytest.mark.parametrize("order", [1, 2])
def test_a_radiating_cube_of_varying_properties_is_that_of_our_solid(order):
    settings = replace(EQUAL, steps=20, order=order)
    counts = (4, 4, 4) if order == 1 else (2, 2, 2)
    T, flows, solver = advanced("calculix", radiating(order, counts), settings, h=100.0)
    other, other_flows, our = advanced("solid", radiating(order, counts), settings, h=100.0)
    np.testing.assert_array_equal(solver.x, our.x)
    assert {k: v.tolist() for k, v in solver.regions.items()} == {
        k: v.tolist() for k, v in our.regions.items()
    }
    assert np.abs(other - 400.0).max() > 10.0
    np.testing.assert_allclose(T, other, rtol=1e-4)
    for name, flow in other_flows.items():
        assert flows[name] == pytest.approx(flow, rel=2e-3, abs=1.0)


def test_constant_properties_agree_to_what_newtons_method_leaves():
    d = radiating()
    d = replace(d, solids=(cube(plain(), 400.0, (4, 4, 4)),))
    settings = replace(EQUAL, steps=5)
    T, flows, solver = advanced("calculix", d, settings, h=50.0)
    other, _, _ = advanced("solid", d, settings, h=50.0)
    np.testing.assert_allclose(T, other, rtol=1e-12)
    stored = solver.energy(T) - solver.energy(solver.initial())
    assert abs(sum(flows.values()) - stored) < 1e-11 * max(map(abs, flows.values()))


def test_a_sunlit_tube():
    """Parallel rays on a tube, radiation to space, against our solid at equal mesh."""
    tube = member(length=2.0, elements=6, wall_points=8)
    d = Description(
        (tube,),
        conditions=(
            Flux("sun", "arm", still(400.0), np.array([0.2, -1.0, 0.0])),
            Radiation("space", "arm", 0.8, still(3.0)),
        ),
    )
    settings = replace(EQUAL, steps=10)
    T, flows, _ = advanced("calculix", d, settings, h=100.0)
    other, other_flows, _ = advanced("solid", d, settings, h=100.0)
    assert np.ptp(other) > 2.0
    np.testing.assert_allclose(T, other, atol=0.01 * np.ptp(other))
    assert flows["sun"] == pytest.approx(other_flows["sun"], rel=1e-9)


def test_members_parts_walls_and_links_together():
    """What the main case is made of: a wall, two parts, links between all of them."""
    hot = (ramp(300.0, 340.0, 4.0),) * 2
    d = Description(
        (member(length=2.0, elements=6, wall_points=4),),
        lumps().parts,
        (
            Link("fitting", Place("hub"), Place("arm", "start"), 2.0),
            Link("film", Place("hub"), Place("pin"), 0.2),
            Link("mount", Place("pin"), still(293.15), 1.0),
        ),
        (Wall("sun", "arm", 0.5, 2.0, np.array([0.0, 1.0, 0.0]), hot, (still(300.0),) * 2),),
    )
    heat = np.zeros(len(build("solid", d).x))
    heat[-2:] = 4.0
    T, flows, solver = advanced("calculix", d, heat=heat)
    other, other_flows, _ = advanced("solid", d, EQUAL, heat=heat)
    np.testing.assert_allclose(T, other, rtol=0.0, atol=1e-6)
    stored = solver.energy(T) - solver.energy(solver.initial())
    assert sum(flows.values()) + heat.sum() == pytest.approx(stored, abs=1e-4 * abs(stored))
    assert flows["sun"] == pytest.approx(other_flows["sun"], rel=1e-6)


def test_irradiation_from_outside_goes_linearly_through_a_window():
    d = Description(conditions=(Irradiation("sky", "cube", "x1"),), solids=(cube(),))
    points = sum(b.areas.size for b in build("solid", d).irradiated["sky"])
    outside = {"sky": (np.zeros(points), np.full(points, 1e4))}
    T, flows, _ = advanced("calculix", d, EQUAL, h=8.0, outside=outside)
    other, _, _ = advanced("solid", d, EQUAL, h=8.0, outside=outside)
    np.testing.assert_allclose(T, other, rtol=0.0, atol=1e-7)
    assert flows["sky"] == pytest.approx(1e4 * 0.01 * 8.0 * 0.625, rel=1e-9)


def test_left_to_itself_it_neither_undershoots_nor_loses_heat_beside_a_shock():
    """The first element takes no heat at once from the jump at its end."""
    bar = member(length=1.0, elements=4, section=None)
    d = Description((bar,), conditions=(Fixed("hot", Place("arm", "start"), still(400.0)),))
    raw, flows, solver = advanced("calculix", d, Settings(steps=4), h=0.1)
    coupled, _, _ = advanced("calculix", d, EQUAL, h=0.1)
    assert raw.min() > 300.0 - 1e-2
    assert coupled.min() < 290.0
    stored = solver.energy(raw) - solver.energy(solver.initial())
    assert sum(flows.values()) == pytest.approx(stored, rel=1e-10)


def test_increments_of_its_own_follow_the_tolerance():
    d = radiating(counts=(2, 2, 2))
    exact, _, _ = advanced("solid", d, Settings(1e-6, capacity="consistent"), t=0.0, h=50.0)
    errors = []
    for tolerance in (1e-1, 1e-3):
        T, _, solver = advanced(
            "calculix", d, Settings(tolerance, capacity="consistent"), t=0.0, h=50.0
        )
        assert not solver.exact
        errors.append(np.abs(T - exact).max())
    assert errors[1] < 0.25 * errors[0]  # first order: a tenth of the increments' length


def test_a_window_leaves_its_arguments_alone_and_repeats_itself():
    d = radiating(counts=(2, 2, 2))
    solver = build("calculix", d, EQUAL)
    T, heat = solver.initial(), np.ones(len(solver.x))
    first, flows, _ = solver.advance(T, 0.0, 5.0, heat)
    again, again_flows, _ = solver.advance(T, 0.0, 5.0, heat)
    np.testing.assert_array_equal(T, solver.initial())
    np.testing.assert_array_equal(first, again)
    assert flows == again_flows


def test_the_inside_of_a_tube_exchanges_with_itself():
    """View factors of CalculiX's own: no heat is lost, and the field is that of a long tube."""
    tube = member(length=0.4, elements=4, wall_points=8, material=plain(1.0))
    sun = Flux("sun", "arm", still(1000.0), np.array([0.0, -1.0, 0.0]))
    inside = Enclosure("bore", (Side("arm", "inner"),), (0.9,))
    d = Description((tube,), conditions=(sun, inside))
    T, flows, solver = advanced("calculix", d, h=100.0)
    other, _, _ = advanced("solid", d, h=100.0)
    stored = solver.energy(T) - solver.energy(solver.initial())
    assert stored == pytest.approx(flows["sun"], rel=1e-3)
    # the ends of CalculiX's tube are open, those of a long tube are not seen
    between = np.abs(solver.x[:, 0] - 0.2) < 0.15
    assert np.abs(T - other)[between].max() < 0.01 * np.ptp(other)
    alone, _, _ = advanced("solid", replace(d, conditions=(sun,)), h=100.0)
    assert np.ptp(other) < 0.98 * np.ptp(alone)


def test_grey_plates_face_to_face():
    """One at 400 K, the other cooled by a film: q = sigma (Ta^4 - Tb^4) / (1/ea + 1/eb - 1)."""
    hot = Solid("hot", box([1.0, 1.0, 0.1], (4, 4, 1)), {"": plain(1e4)}, 400.0)
    below = replace(hot.mesh, points=hot.mesh.points - [0.0, 0.0, 0.11])
    cold = replace(hot, name="cold", mesh=below, initial=320.0)
    film = 20.0
    d = Description(
        conditions=(
            Fixed("fire", Place("hot"), still(400.0)),
            Film("air", "cold", still(film), still(300.0), "z0"),
            Enclosure(
                "gap", (Side("hot", "z0"), Side("cold", "z1")), (0.8, 0.5), None, still(350.0)
            ),
        ),
        solids=(hot, cold),
    )
    solver = build("calculix", d)
    T, _, why = solver.steady(solver.initial(), 0.0)
    assert why == ""
    factor = 5.670374419e-8 / (1.0 / 0.8 + 1.0 / 0.5 - 1.0)
    exact = brentq(lambda Tb: factor * (400.0**4 - Tb**4) - film * (Tb - 300.0), 300.0, 400.0)
    assert T[solver.regions["cold"]].mean() == pytest.approx(exact, abs=0.05 * (exact - 300.0))


def test_a_solid_whose_region_is_a_face_is_meshed_whole():
    bodies = (replace(cube(), name="first", rubbing="x1"), replace(cube(), rubbing="y0"))
    d = Description(
        conditions=(Film("air", "cube", still(500.0), still(400.0), "z1"),), solids=bodies
    )
    heat = np.zeros(2 * 64)
    heat[build("solid", d).regions["first"]] = 10.0
    T, _, _ = advanced("calculix", d, heat=heat)
    other, _, _ = advanced("solid", d, heat=heat)
    np.testing.assert_allclose(T, other, rtol=1e-12)


def test_a_tube_of_three_conductivities():
    """Along, around and through, of each cell those at its middle."""
    stuff = replace(
        varying(),
        conductivity_around=polynomial("k2", "W/(m K)", [20.0, 0.1], 300.0),
        conductivity_through=polynomial("k3", "W/(m K)", [2.0]),
    )
    tube = member(length=0.3, elements=4, wall_points=16, material=stuff)
    sun = Flux("sun", "arm", still(5e3), np.array([0.0, -1.0, 0.0]))
    base = Fixed("base", Place("arm", "start"), still(300.0))
    d = Description((tube,), conditions=(sun, base))
    settings = replace(EQUAL, steps=20, layers=2)
    T, _, _ = advanced("calculix", d, settings, h=60.0)
    other, _, _ = advanced("solid", d, settings, h=60.0)
    assert np.ptp(other) > 20.0
    np.testing.assert_allclose(T, other, rtol=0.0, atol=0.01 * np.ptp(other))


def test_a_sheet_in_the_sun():
    surface = plate(0.4, 0.3, 4, 3)
    sheet = Sheet("panel", surface, 0.01, varying(), 300.0)
    sun = Flux("sun", "panel", ramp(0.0, 1400.0, 20.0), np.array([0.0, 0.3, -1.0]), "top")
    d = Description(
        conditions=(sun, Radiation("space", "panel", 0.8, still(4.0), "bottom")), sheets=(sheet,)
    )
    T, flows, _ = advanced("calculix", d, replace(EQUAL, steps=20), h=100.0)
    other, other_flows, _ = advanced("solid", d, replace(EQUAL, steps=20), h=100.0)
    np.testing.assert_allclose(T, other, rtol=0.0, atol=1e-3 * np.abs(other - 300.0).max())
    assert flows["sun"] == pytest.approx(other_flows["sun"], rel=1e-9)


# ------------------------------------------------------------------------ what it refuses


def test_what_calculix_cannot_express_is_refused_at_once():
    emissivity = polynomial("emissivity", "1", [0.5, 1e-4])
    other = replace(cube(), name="other")
    d = Description(
        (),
        lumps().parts,
        (),
        (
            Radiation("space", "cube", emissivity, still(4.0)),
            Enclosure("box", (Side("cube", "x0"), Side("other", "x1")), (0.5, 0.5), np.eye(2)),
        ),
        (),
        (cube(), other),
        (Interface("press", Side("cube", "x1"), Side("other", "x0"), 100.0),),
    )
    with pytest.raises(ValueError) as error:
        build("calculix", d, Settings(capacity="lumped"))
    text = str(error.value)
    for word in ("capacity", "'space'", "'box'", "'press'"):
        assert word in text
    assert len(text.splitlines()) == 5


def test_cells_that_calculix_has_not_are_refused():
    mesh = box([1.0] * 3, (1, 1, 1), family="hexahedron27")
    with pytest.raises(ValueError, match="hexahedron27"):
        build("calculix", Description(solids=(Solid("cube", mesh, {"": plain()}, 300.0),)))


def test_two_radiations_on_one_face_are_refused():
    radiations = tuple(Radiation(n, "cube", 0.5, still(4.0), f)
                       for n, f in (("all", "outer"), ("end", "x1")))  # fmt: skip
    with pytest.raises(ValueError, match="'all' and 'end'"):
        build("calculix", Description(conditions=radiations, solids=(cube(),)))


def test_a_steady_state_that_does_not_exist_is_a_reason():
    d = lumps(conditions=(Source("s", Place("pin"), still(3.0)),))
    solver = build("calculix", d)
    _, _, why = solver.steady(solver.initial(), 0.0)
    assert why.startswith("there is no steady state: CalculiX")


def test_leaving_the_range_of_a_property_is_a_reason():
    d = lumps()
    parts = tuple(replace(p, material=varying(200.0, 330.0)) for p in d.parts)
    d = replace(d, parts=parts, conditions=(Source("s", Place("pin"), still(1e4)),))
    solver = build("calculix", d, EQUAL)
    _, _, why = solver.advance(solver.initial(), 0.0, 2.0, np.zeros(2))
    assert "'pin' left the range" in why


# ---------------------------------------------------------------------- broken programs


def test_without_the_program_it_says_so(monkeypatch):
    monkeypatch.setenv("THERMOBODY_CCX", "/nowhere/ccx")
    with pytest.raises(ValueError, match=r"ccx is not installed.*'/nowhere/ccx'"):
        CalculixHeat(lumps())


@pytest.mark.parametrize(
    ("script", "said"),
    [
        ("echo '*ERROR in the deck:'; echo 'it is wrong'; exit 201", "code 201.*it is wrong"),
        ("echo done; exit 0", "0 temperature fields of 0 increments"),
        ("printf 'a\\nb\\n1 1 1 1 1.0 1.0 1.0\\n' > heat.sta; exit 0", "0 temperature fields of 1"),
    ],
)
def test_a_broken_program_is_a_reason(monkeypatch, tmp_path, script, said):
    program = tmp_path / "ccx"
    program.write_text(f"#!/bin/sh\n{script}\n")
    program.chmod(0o755)
    monkeypatch.setenv("THERMOBODY_CCX", str(program))
    solver = CalculixHeat(lumps(), EQUAL)
    T = solver.initial()
    new, flows, why = solver.advance(T, 0.0, 1.0, np.zeros(2))
    assert flows == {}
    np.testing.assert_array_equal(new, T)
    assert re.search(said, why)


# ------------------------------------------------------------------------------- the deck


@pytest.mark.parametrize(
    "p",
    [
        polynomial("c", "J/(kg K)", [800.0, 1.2, 2e-3, -1e-6], 300.0, 100.0, 600.0),
        table("k", "W/(m K)", [100.0, 250.0, 400.0], [80.0, 120.0, 125.0]),
        table("k", "W/(m K)", [4.0, 20.0, 80.0, 300.0], [5.0, 28.0, 80.0, 155.0], smooth=True),
        polynomial("k", "W/(m K)", [1.0, 0.5]),
    ],
)
def test_tables_of_properties_are_interpolated_closely(p):
    entries = calculix_deck.table(p)
    low, high = max(p.lower, 1.0), min(p.upper, 3000.0)
    T = np.linspace(low, high, 5000)
    np.testing.assert_allclose(np.interp(T, *entries), p(T), rtol=1e-5)


def test_series_are_split_into_magnitudes_and_few_amplitudes():
    base = np.array([0.0, 1.0, 0.5])
    values = np.array([2.0 * base, -3.0 * base, [7.0, 7.0, 7.0], 5.0 * base, [0.0, 0.0, 0.0]])
    found = calculix_deck.series(values)
    assert len(found.amplitudes) == 4
    np.testing.assert_allclose(found.magnitudes[:, None] * found.amplitudes[found.which], values)


def test_meshes_are_not_required_to_be_used_whole():
    """Points that no cell uses have no temperature, here as in our solid."""
    mesh = box([0.1] * 3, (2, 2, 2))
    more = Mesh(np.vstack([mesh.points, [[9.0, 9.0, 9.0]]]), mesh.cells, mesh.regions)
    d = Description(
        conditions=(Flux("f", "cube", still(1e3)),),
        solids=(Solid("cube", more, {"": plain()}, 300.0),),
    )
    T, _, solver = advanced("calculix", d)
    assert len(T) == len(mesh.points)
    stored = solver.energy(T) - solver.energy(solver.initial())
    assert stored == pytest.approx(1e3 * 0.06 * 2.0, rel=1e-7)
