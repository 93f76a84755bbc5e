"""Prescribed temperatures: walls, faces, fields of tables and files; what is refused."""

from dataclasses import replace

import meshio
import numpy as np
import pytest
from heat_cases import everything, member, plain, ramp, still, varying

from meshes import surfaces
from meshes.fields import read_field, table_field
from meshes.mesh import Mesh
from thermal.description import (
    Description,
    Field,
    Film,
    Fixed,
    Flux,
    Link,
    Part,
    Place,
    Radiation,
    Sheet,
    Solid,
    Source,
    Wall,
)
from thermal.prescribed import PrescribedHeat

SLOPE = np.array([30.0, -20.0, 50.0])


def linear(x, t):
    return 300.0 + 2.0 * t + x @ SLOPE


def brick(lengths=(0.3, 0.2, 0.1), n=(3, 2, 2)):
    """Hexahedra of a box from the origin."""
    axes = [np.linspace(0.0, length, k + 1) for length, k in zip(lengths, n, strict=True)]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    at = np.arange(len(points)).reshape([k + 1 for k in n])
    corners = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1)]
    corners.append((0, 1, 1))
    cells = [at[i : i + n[0], j : j + n[1], k : k + n[2]].ravel() for i, j, k in corners]
    return Mesh(points, {"hexahedron": np.stack(cells, axis=1)})


ARM = member(wall_points=4, elements=5)
SKIN = Sheet("skin", surfaces.plate(1.0, 0.5, 4, 2), 0.01, plain(), 300.0)
BLOCK = Solid("block", brick(), {"": plain()}, 300.0)
HUB = Part("hub", np.zeros(3), plain(), 2.0, 310.0)
BODIES = {"arm": {"members": (ARM,)}, "skin": {"sheets": (SKIN,)}, "block": {"solids": (BLOCK,)}}


def under(*fields, **things):
    return Description(conditions=tuple(Field(f"f{i}", *f) for i, f in enumerate(fields)), **things)


@pytest.mark.parametrize("name", BODIES)
def test_a_field_gives_the_temperatures_of_a_body(name):
    solver = PrescribedHeat(under((name, linear), **BODIES[name]))
    np.testing.assert_allclose(solver.initial(), linear(solver.x, 0.0), rtol=1e-14)
    T, flows, why = solver.advance(solver.initial(), 0.0, 3.0, np.zeros(len(solver.x)))
    assert why == ""
    np.testing.assert_allclose(T, linear(solver.x, 3.0), rtol=1e-14)
    assert flows["reservoir"] == pytest.approx(solver.energy(T) - solver.energy(solver.initial()))
    assert solver.unused == []
    assert solver.irradiated == {}


@pytest.mark.parametrize(
    ("name", "mass"),
    [
        ("arm", 2700.0 * ARM.section.area),
        ("skin", 2700.0 * 0.5 * 0.01),
        ("block", 2700.0 * 0.3 * 0.2 * 0.1),
    ],
)
def test_heat_is_that_of_the_mass(name, mass):
    solver = PrescribedHeat(under((name, lambda x, t: np.full(len(x), 300.0 + t)), **BODIES[name]))
    _, flows, _ = solver.advance(solver.initial(), 0.0, 10.0, np.ones(len(solver.x)))
    assert flows["reservoir"] + len(solver.x) == pytest.approx(10.0 * mass * 896.0, rel=1e-12)


def test_tetrahedra_of_two_materials_weigh_what_they_do():
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1]], float)
    cells = np.array([[0, 1, 2, 3], [1, 2, 3, 4]])
    mesh = Mesh(points, {"tetra": cells}, {"far": ("tetra", np.array([1]))})
    heavy = plain(heat_capacity=500.0, density=8000.0)
    solid = Solid("wedge", mesh, {"": plain(), "far": heavy}, 300.0)
    rise = Field("f", "wedge", lambda x, t: np.full(len(x), 300.0 + t))
    solver = PrescribedHeat(Description(solids=(solid,), conditions=(rise,)))
    _, flows, _ = solver.advance(solver.initial(), 0.0, 1.0, np.zeros(5))
    expected = 2700.0 * 896.0 / 6.0 + 8000.0 * 500.0 / 3.0
    assert flows["reservoir"] == pytest.approx(expected, rel=1e-12)


def test_all_kinds_of_things_stand_one_after_the_other():
    d = under(
        ("arm", linear), ("skin", linear), ("block", linear),
        members=(ARM,), parts=(HUB,), sheets=(SKIN,), solids=(BLOCK,),
    )  # fmt: skip
    solver = PrescribedHeat(d)
    assert list(solver.regions) == ["arm", "hub", "skin", "block"]
    np.testing.assert_array_equal(
        np.concatenate(list(solver.regions.values())), np.arange(len(solver.x))
    )
    np.testing.assert_array_equal(solver.x[solver.regions["block"]], BLOCK.mesh.points)
    T, _, why = solver.steady(solver.initial(), 5.0)
    assert why == ""
    assert T[solver.regions["hub"]] == [310.0]
    np.testing.assert_allclose(
        T[solver.regions["skin"]], linear(solver.x[solver.regions["skin"]], 5.0)
    )


def test_what_has_no_effect_is_named():
    d = everything()
    warm = (still(305.0),) * 2
    walls = (
        replace(d.conditions[0], start=0.0, end=2.0),
        Wall("bar", "bar", 0.0, 0.5, None, warm, warm),
    )
    solver = PrescribedHeat(replace(d, conditions=(*walls, *d.conditions[1:])))
    links = ["fitting", "joint", "press", "mount", "air"]
    assert solver.unused == ["light", "glow", "space", "walls", "heater", "motor", *links]


# ------------------------------------------------------------------------------ tables and files


def test_a_table_along_a_member_meets_its_wall():
    """The same history as table and as wall condition, which is linear along the member too."""
    hot = (ramp(300.0, 340.0, 10.0), ramp(300.0, 320.0, 10.0))
    wall = Wall("w", "arm", 0.0, 1.0, None, hot, hot)
    table = table_field([0.0, 10.0], [0.0, 1.0], [[300.0, 300.0], [340.0, 320.0]], ARM.points)
    one = PrescribedHeat(Description((ARM,), conditions=(wall,)))
    other = PrescribedHeat(under(("arm", table), members=(ARM,)))
    a, b = (s.advance(s.initial(), 0.0, 7.0, np.zeros(len(s.x)))[0] for s in (one, other))
    np.testing.assert_allclose(a, b, rtol=1e-13)


def series(folder, mesh, times, field=linear):
    cells = [(family, rows) for family, rows in mesh.cells.items()]
    sets = ""
    for i, t in enumerate(times):
        data = {"NT": field(mesh.points, t)}
        meshio.Mesh(mesh.points, cells, point_data=data).write(folder / f"{i}.vtu")
        sets += f'<DataSet timestep="{t}" file="{i}.vtu"/>'
    (folder / "s.pvd").write_text(f"<VTKFile><Collection>{sets}</Collection></VTKFile>")
    return read_field(folder / "s.pvd")


def test_a_field_of_another_mesh_from_files(tmp_path):
    field = series(tmp_path, brick(n=(5, 4, 3)), (0.0, 4.0))
    solver = PrescribedHeat(under(("block", field), **BODIES["block"]))
    assert solver.times == (0.0, 4.0)
    T, _, why = solver.advance(solver.initial(), 0.0, 3.0, np.zeros(len(solver.x)))
    assert why == ""
    np.testing.assert_allclose(T, linear(solver.x, 3.0), atol=1e-6)


def test_times_beyond_the_file_are_a_reason(tmp_path):
    field = series(tmp_path, brick(), (1.0, 4.0))
    solver = PrescribedHeat(under(("block", field), **BODIES["block"]))
    T = solver.initial()  # of t = 1 s, the first that is known
    np.testing.assert_allclose(T, linear(solver.x, 1.0), atol=1e-6)
    end, _, why = solver.advance(T, 3.5, 1.0, np.zeros(len(T)))
    assert why == "t = 4.5 s: field 'f0' is known from 1 s to 4 s only"
    assert np.isfinite(end).all()
    assert "known from 1 s" in solver.steady(T, 0.0)[2]


def test_fields_without_common_times_are_refused():
    table = [[300.0, 300.0]] * 2
    fields = [table_field(t, [0.0, 1.0], table, ARM.points) for t in ((0.0, 1.0), (2.0, 3.0))]
    other = replace(ARM, name="leg")
    with pytest.raises(ValueError, match="no time in common: 'f0' from 0 s to 1 s, 'f1' from 2 s"):
        PrescribedHeat(under(("arm", fields[0]), ("leg", fields[1]), members=(ARM, other)))


def test_a_body_away_from_the_file_is_refused(tmp_path):
    field = series(tmp_path, brick(), (0.0, 1.0))
    away = Solid(
        "block", replace(BLOCK.mesh, points=1000.0 * BLOCK.mesh.points), {"": plain()}, 300
    )
    with pytest.raises(ValueError, match=r"field 'f0': .*s\.pvd: .* far from the data"):
        PrescribedHeat(under(("block", field), solids=(away,)))


def test_a_field_that_is_no_number_or_out_of_range_is_a_reason():
    for later, said in ((np.nan, "with nan K"), (500.0, "(200 K to 400 K) with 500 K")):
        arm = replace(ARM, material=varying(200.0, 400.0))
        field = Field("f", "arm", lambda x, t, T=later: np.full(len(x), T if t > 1 else 300.0))
        solver = PrescribedHeat(Description((arm,), conditions=(field,)))
        _, _, why = solver.advance(solver.initial(), 1.0, 1.0, np.zeros(len(solver.x)))
        assert "t = 2 s: 'arm' left the range of heat_capacity" in why
        assert said in why


# ------------------------------------------------------------------------------------- refusals


def test_bare_bodies_are_refused():
    d = Description((ARM,), sheets=(SKIN,), solids=(BLOCK,))
    with pytest.raises(ValueError) as error:
        PrescribedHeat(d)
    for said in ("member 'arm'", "sheet 'skin'", "solid 'block': no condition gives"):
        assert said in str(error.value)


def test_a_solid_is_prescribed_as_a_whole():
    whole = Fixed("f", Place("block"), still(320.0))
    solver = PrescribedHeat(Description(solids=(BLOCK,), conditions=(whole,)))
    assert (solver.initial() == 320.0).all()
    face = replace(whole, place=Place("block", "outer"))
    with pytest.raises(ValueError, match="fixed 'f': prescribe all of the solid 'block'"):
        PrescribedHeat(Description(solids=(BLOCK,), conditions=(face,)))


def test_a_solid_given_twice_is_refused():
    with pytest.raises(ValueError, match="'f0' and 'f1' both prescribe temperatures of 'block'"):
        PrescribedHeat(under(("block", linear), ("block", linear), **BODIES["block"]))


def test_names_of_conditions_of_every_kind_without_effect():
    conditions = (
        Field("field", "arm", linear),
        Film("film", "arm", still(5.0), still(300.0)),
        Radiation("space", "arm", 0.5, still(4.0)),
        Flux("sun", "arm", still(1.0)),
        Source("heat", Place("arm", "end"), still(1.0)),
    )
    link = Link("link", Place("arm", "end"), still(300.0), 1.0)
    solver = PrescribedHeat(Description((ARM,), links=(link,), conditions=conditions))
    assert solver.unused == ["film", "space", "sun", "heat", "link"]
