"""Heat in 3D: patch tests, scikit-fem's own assembly, manufactured solutions, closed forms."""

import subprocess
import sys
from dataclasses import replace
from time import process_time

import numpy as np
import pytest
from heat_cases import member, plain, ramp, still, varying
from scipy.sparse import csr_array
from scipy.spatial import cKDTree

from meshes import surfaces
from meshes.families import EDGES, FACES
from meshes.generate import arc
from meshes.io import read, write
from meshes.materials import constant
from meshes.mesh import Mesh
from meshes.sections import circle, general, rectangle, tube
from meshes.solids import ORDER, bore, box, pin, pin_and_bore, tetrahedra
from thermal.boundary import STEFAN_BOLTZMANN, Boundary, Moment
from thermal.description import (
    Description,
    Enclosure,
    Faces,
    Field,
    Film,
    Fixed,
    Flux,
    Interface,
    Link,
    Member,
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
from thermal.heat import Heat
from thermal.layout import GivenField
from thermal.solid import SolidSpace
from thermal.solid_elements import CONDUCTION, STORAGE, geometry, shape
from thermal.solvers import build

FAMILY = pytest.mark.parametrize("family", list(ORDER))
CUBE = (1.0, 1.0, 1.0)


def solid(mesh, material=None, name="block", initial=300.0, **more):
    return Solid(name, mesh, {"": material or plain()}, initial, **more)


def space(*solids, settings=Settings(), conditions=()):  # noqa: B008
    return SolidSpace(Description(solids=solids, conditions=conditions), settings)


def distorted(family, counts=(3, 3, 2), size=CUBE, curved=False):
    """A box whose nodes within are moved; edges stay straight unless ``curved``."""
    mesh = box(size, counts, family=family)
    x, scale = mesh.points / size, np.array(size) / counts
    inside = np.prod(4.0 * x * (1.0 - x), axis=1)[:, None]
    waves = np.sin(3.0 * x @ np.array([[1, 2, 3], [2, -1, 1], [1, 1, -2]]) + [0.3, 1.1, 2.0])
    points = mesh.points + (0.1 if curved else 0.25) * inside * scale * waves
    if not curved:
        points = _straight(family, mesh.cells[family], points)
    return Mesh(points, mesh.cells, mesh.regions)


def _straight(family, cells, points):
    points = points.copy()
    kind = "hexahedron" if family.startswith("hexa") else "tetra"
    corners = 8 if kind == "hexahedron" else 4
    groups = [list(e) for e in EDGES[kind]]
    if kind == "hexahedron":
        groups += [list(f) for f in FACES["hexahedron"]] + [list(range(8))]
    for i, group in enumerate(groups[: cells.shape[1] - corners]):
        points[cells[:, corners + i]] = points[cells[:, group]].mean(axis=1)
    return points


def matrix(s, T, tau):
    return csr_array((s.tangent(T, tau), s.entries()), shape=(len(T), len(T)))


def boundary_nodes(s, name="block"):
    blocks = s.face(Side(name, "outer"))
    return np.unique(np.concatenate([b.dofs.ravel() for b in blocks]))


# --- what is summed up --------------------------------------------------------------------------


@FAMILY
def test_linear_fields_pass_the_patch_test_with_directed_conductivity(family):
    turn = np.linalg.qr(np.array([[1.0, 2.0, 3.0], [0.0, 1.0, -1.0], [2.0, 0.0, 1.0]]))[0].T
    k = np.array([10.0, 3.0, 0.5])
    material = replace(
        plain(conductivity=k[0]),
        conductivity_around=constant("around", "W/(m K)", k[1]),
        conductivity_through=constant("through", "W/(m K)", k[2]),
    )
    s = space(solid(distorted(family), material, axes=turn))
    gradient = np.array([5.0, -3.0, 2.0])
    T = 300.0 + s.x @ gradient
    power = s.power(T)
    inside = np.setdiff1d(np.arange(len(T)), boundary_nodes(s))
    assert len(inside)
    assert np.abs(power[inside]).max() < 1e-12 * np.abs(power).max()
    dissipated = gradient @ turn.T @ (k * (turn @ gradient))
    assert -(T - 300.0) @ power == pytest.approx(dissipated, rel=1e-12)
    for b in s.face(Side("block", "x1")):  # what leaves through a face is the flux times its area
        assert b.areas.sum() == pytest.approx(1.0, rel=1e-13)
        np.testing.assert_allclose(b.normals[..., 0], 1.0)


SKFEM = {
    "hexahedron": "ElementHex1",
    "hexahedron20": "ElementHexS2",
    "hexahedron27": "ElementHex2",
    "tetra": "ElementTetP1",
    "tetra10": "ElementTetP2",
}


def skfem_basis(mesh, family, degree):
    """scikit-fem's mesh and basis on the cells of a mesh; it has none of 20 nodes but straight."""
    import meshio
    import skfem
    from skfem.io.meshio import from_meshio

    points, cells = mesh.points, mesh.cells[family]
    if family == "hexahedron20":
        corners, place = np.unique(cells[:, :8], return_inverse=True)
        points, cells, family_of_mesh = points[corners], place.reshape(-1, 8), "hexahedron"
    else:
        family_of_mesh = family
    raw = meshio.Mesh(points, {family_of_mesh: cells})
    return skfem.Basis(from_meshio(raw), getattr(skfem, SKFEM[family])(), intorder=degree)


@FAMILY
def test_sums_are_those_of_scikit_fem(family):
    from skfem import BilinearForm, LinearForm
    from skfem.helpers import dot, grad

    mesh = distorted(family, curved=family in ("hexahedron27", "tetra10"))
    material = varying()
    k, c = material.conductivity, material.heat_capacity
    s = space(solid(mesh, material), settings=Settings(capacity="consistent"))
    bases = [skfem_basis(mesh, family, table[family]) for table in (CONDUCTION, STORAGE)]
    far, mine = cKDTree(s.x).query(bases[0].doflocs.T)
    assert far.max() < 1e-12
    T = 300.0 + 40.0 * np.sin(3.0 * s.x @ [1.0, 2.0, -1.0])
    fields = [{"T": b.interpolate(T[mine])} for b in bases]
    conducted = LinearForm(lambda v, w: -k(w.T) * dot(grad(w.T), grad(v)))
    stored = LinearForm(lambda v, w: 2700.0 * material.enthalpy(np.asarray(w.T)) * v)
    slopes = BilinearForm(
        lambda u, v, w: (
            k(w.T) * dot(grad(u), grad(v)) + k.derivative(w.T) * u * dot(grad(w.T), grad(v))
        )
    )
    capacity = BilinearForm(lambda u, v, w: 2700.0 * c(w.T) * u * v)
    expected = 5.0 * slopes.assemble(bases[0], **fields[0]) + capacity.assemble(
        bases[1], **fields[1]
    )
    found = matrix(s, T, 5.0)[mine][:, mine]
    for ours, theirs in (
        (s.power(T)[mine], conducted.assemble(bases[0], **fields[0])),
        (s.heat(T)[mine], stored.assemble(bases[1], **fields[1])),
        (found.toarray(), expected.toarray()),
    ):
        np.testing.assert_allclose(ours, theirs, rtol=0.0, atol=1e-12 * np.abs(theirs).max())


@FAMILY
@pytest.mark.parametrize("material", [plain(), varying()])
def test_tangents_are_derivatives(family, material):
    s = space(solid(distorted(family), material))
    rng = np.random.default_rng(0)
    T, v, e = 300.0 + 30.0 * rng.random(len(s.x)), rng.standard_normal(len(s.x)), 1e-4
    ahead, behind = (s.heat(t) - 7.0 * s.power(t) for t in (T + e * v, T - e * v))
    slope = matrix(s, T, 7.0) @ v
    np.testing.assert_allclose((ahead - behind) / (2 * e), slope, atol=1e-8 * np.abs(slope).max())


def test_hexahedra_of_27_nodes_can_be_lumped_and_others_of_order_2_cannot():
    lumped = Settings(capacity="lumped")
    s = space(solid(distorted("hexahedron27"), varying()), settings=lumped)
    stored = s.heat(np.full(len(s.x), 350.0))
    assert stored.min() > 0.0
    assert stored.sum() == pytest.approx(2700.0 * varying().enthalpy(350.0), rel=1e-12)
    with pytest.raises(ValueError, match="hexahedron20 would store negative heat at their corners"):
        space(solid(distorted("hexahedron20")), settings=lumped)


# --- manufactured solutions -----------------------------------------------------------------------


class Made:
    """T = 300 + 40 (1 + t) f(x), k and c as of ``varying``, radiation through x = 1."""

    material, emissivity, sink = varying(), 0.8, 250.0

    @staticmethod
    def f(x):
        return np.cos(1.5 * x[..., 0] + 0.3) * np.exp(0.5 * x[..., 1]) * np.cos(x[..., 2])

    @staticmethod
    def slope_x(x):
        return -1.5 * np.sin(1.5 * x[..., 0] + 0.3) * np.exp(0.5 * x[..., 1]) * np.cos(x[..., 2])

    @classmethod
    def squared_slope(cls, x):
        f, a, c = cls.f(x), cls.slope_x(x), np.tan(x[..., 2])
        return a**2 + (0.5 * f) ** 2 + (c * f) ** 2

    @classmethod
    def T(cls, x, t):
        return 300.0 + 40.0 * (1.0 + t) * cls.f(x)

    @classmethod
    def source(cls, x, h):
        """Of a step of backward Euler from t = 0: rho dh/dt - div (k grad T) at its end."""
        k, size = cls.material.conductivity, 40.0 * (1.0 + h)
        rise = cls.material.enthalpy(cls.T(x, h)) - cls.material.enthalpy(cls.T(x, 0.0))
        laplacian = (0.25 - 1.5**2 - 1.0) * size * cls.f(x)
        bend = k.derivative(cls.T(x, h)) * size**2 * cls.squared_slope(x)
        return 2700.0 * rise / h - k(cls.T(x, h)) * laplacian - bend

    @classmethod
    def leaving(cls, x, h):
        """Flux into x = 1 beyond what is radiated there."""
        T = cls.T(x, h)
        conducted = cls.material.conductivity(T) * 40.0 * (1.0 + h) * cls.slope_x(x)
        return conducted + STEFAN_BOLTZMANN * cls.emissivity * (T**4 - cls.sink**4)


def made_error(family, n, h):
    """Error [K] in the mean square after one step of backward Euler, whose end is exact in time."""
    mesh = distorted(
        family, (n, n, n), curved=family in ("hexahedron20", "hexahedron27", "tetra10")
    )
    radiated = Radiation("sky", "block", Made.emissivity, still(Made.sink), "x1")
    d = Description(solids=[solid(mesh, Made.material)], conditions=[radiated])
    settings = Settings(scheme="backward-euler", steps=1, capacity="consistent")
    s = SolidSpace(d, settings)
    others = [Side("block", face) for face in ("x0", "y0", "y1", "z0", "z1")]
    edge = np.unique(np.concatenate([b.dofs.ravel() for o in others for b in s.face(o)]))
    s.given = [GivenField("edge", edge, s.x[edge], Made.T)]
    heat = Heat(s, d, settings)
    form, cells = shape(family, 6), mesh.cells[family]
    at = geometry(s.x[cells], form)
    x = np.einsum("qn,mni->mqi", form.values, s.x[cells])
    loads = np.zeros(len(s.x))
    np.add.at(loads, cells, (at.volumes * Made.source(x, h)) @ form.values)
    for b in s.face(Side("block", "x1")):
        np.add.at(loads, b.dofs, (b.areas * Made.leaving(b.points, h)) @ b.values)
    T, _, why = heat.advance(Made.T(s.x, 0.0), 0.0, h, h * loads)
    assert why == ""
    miss = T[cells] @ form.values.T - Made.T(x, h)
    return np.sqrt((at.volumes * miss**2).sum())


@FAMILY
def test_manufactured_solutions_converge_with_their_order(family):
    coarse, fine = (made_error(family, n, 2.0) for n in ((4, 8) if ORDER[family] == 1 else (2, 4)))
    expected = ORDER[family] + 1
    assert expected - 0.3 < np.log2(coarse / fine) < expected + 0.8
    assert fine < (0.3 if ORDER[family] == 1 else 0.1)


# --- closed forms -------------------------------------------------------------------------------


def t4(n, family):
    """NAFEMS T4 (1990): 0.6 m by 1 m, bottom at 100 degC, convection at right and top."""
    film = {"coefficient": still(750.0), "surroundings": still(273.15)}
    d = Description(
        solids=[solid(box((0.6, 1.0, 0.1), (3 * n, 5 * n, 1), family=family), plain(52.0))],
        conditions=[
            Fixed("bottom", Place("block", "y0"), still(373.15)),
            Film("right", "block", face="x1", **film),
            Film("top", "block", face="y1", **film),
        ],
    )
    heat = build("solid", d)
    T, _, why = heat.steady(heat.initial(), 0.0)
    assert why == ""
    return T[np.linalg.norm(heat.x - [0.6, 0.2, 0.0], axis=1).argmin()] - 273.15


@FAMILY
def test_point_e_of_nafems_t4(family):
    """18.2538 degC, converged; the field is singular at the corner below, so slowly."""
    n = 10 if ORDER[family] == 1 else 5
    assert t4(n, family) == pytest.approx(18.2538, abs=0.05 if ORDER[family] == 1 else 0.02)


@FAMILY
def test_thick_cylinders_have_logarithmic_profiles(family):
    a, b = 0.5, 1.0
    misses = []
    for n in (1, 2):
        length = 0.2 / n
        mesh = bore(a, b, length, 16 * n, 4 * n, 1, family=family)
        ends = [
            Fixed(f, Place("block", f), still(T)) for f, T in (("inner", 400.0), ("outer", 300.0))
        ]
        heat = build("solid", Description(solids=[solid(mesh)], conditions=ends))
        T, _, why = heat.steady(heat.initial(), 0.0)
        assert why == ""
        exact = 300.0 + 100.0 * np.log(b / np.hypot(*heat.x.T[:2])) / np.log(b / a)
        corners = mesh.cells[family][:, : 8 if "hexa" in family else 4]  # in the circles
        misses.append(np.abs(T - exact)[np.unique(corners)].max())
        inner = heat.space.place(Place("block", "inner")).nodes
        power = -heat.space.power(T)[inner].sum()
        expected = 2 * np.pi * 167.0 * length * 100.0 / np.log(b / a)
        assert power == pytest.approx(expected, rel=0.03 / n**2 if ORDER[family] == 1 else 1e-3)
    assert misses[1] < 0.35 * misses[0]
    assert misses[1] < (0.3 if ORDER[family] == 1 else 0.02)


def test_directed_conductivity_of_a_tube_goes_along_around_and_through():
    """Steady power between the ends, the faces and the halves of a tube: each by its own k."""
    material = replace(
        plain(conductivity=100.0),
        conductivity_around=constant("around", "W/(m K)", 7.0),
        conductivity_through=constant("through", "W/(m K)", 0.4),
    )
    points, axes = arc((0, 0, 0), (2, 0, 0), (0, 0, 1), 1.0, 20)
    m = Member("bow", points, axes, tube(0.1, 0.02), material, 24, 300.0)
    s = SolidSpace(Description(members=[m]), Settings(order=2))
    along = np.arctan2(s.x[:, 1], s.x[:, 0])
    T = 300.0 + along  # dT/ds = 1 / r of the bow
    r = np.hypot(s.x[:, 0], s.x[:, 1])
    radial = np.hypot(r - 2.0, s.x[:, 2])
    around = np.arctan2(s.x[:, 2], r - 2.0)
    mean = s.place(Place("bow")).weights @ (1.0 / r[s.place(Place("bow")).nodes] ** 2)
    volume = m.section.area * 2.0
    assert -T @ s.power(T) == pytest.approx(100.0 * volume * mean, rel=2e-4)
    T = 300.0 + radial
    assert -(T - 300.0) @ s.power(T) == pytest.approx(0.4 * volume, rel=2e-3)
    T = 300.0 + np.cos(around)
    expected = 7.0 * 2.0 * np.pi * np.log(0.11 / 0.09)  # of sin^2 / r^2
    assert -(T - 300.0) @ s.power(T) == pytest.approx(expected, rel=5e-3)


def test_layers_of_different_materials_are_resistances_in_series():
    mesh = box((1.0, 1.0, 1.0), (1, 1, 5))
    regions = dict(mesh.regions, low=("hexahedron", np.array([0, 1])))
    mesh = Mesh(mesh.points, mesh.cells, regions)
    body = Solid("block", mesh, {"low": plain(1e-3), "": plain(1e3)}, 300.0)
    ends = [Fixed(f, Place("block", f), still(T)) for f, T in (("z0", 400.0), ("z1", 300.0))]
    heat = build("solid", Description(solids=[body], conditions=ends))
    T, _, why = heat.steady(heat.initial(), 0.0)
    assert why == ""
    flow = 100.0 / (0.4 / 1e-3 + 0.6 / 1e3)
    middle = heat.x[:, 2] == heat.x[np.abs(heat.x[:, 2] - 0.4).argmin(), 2]
    np.testing.assert_allclose(T[middle], 400.0 - flow * 0.4 / 1e-3, rtol=1e-12)
    bottom = heat.space.place(Place("block", "z0")).nodes
    assert -heat.space.power(T)[bottom].sum() == pytest.approx(flow, rel=1e-9)


@pytest.mark.parametrize("order", [1, 2])
def test_a_pin_in_its_bore_is_a_resistance_of_the_gap_and_one_of_the_bush(order):
    inside, outside = pin_and_bore(0.01, 1e-5, 0.02, 0.03, 24, 2, 2, order)
    bodies = [solid(inside, plain(1e4), "pin"), solid(outside, plain(), "bore")]
    d = Description(
        solids=bodies,
        interfaces=[Interface("gap", Side("pin", "outer"), Side("bore", "inner"), 1000.0)],
        conditions=[
            Fixed("seat", Place("bore", "outer"), still(300.0)),
            Source("heater", Place("pin"), still(10.0)),
        ],
    )
    heat = build("solid", d)
    T, _, why = heat.steady(heat.initial(), 0.0)
    assert why == ""
    gap = 10.0 / (1000.0 * 2 * np.pi * 0.01 * 0.03)
    bush = 10.0 * np.log(0.02 / 0.01001) / (2 * np.pi * 167.0 * 0.03)
    found = T[heat.space.place(Place("pin", "outer")).nodes].mean()
    assert found == pytest.approx(300.0 + gap + bush, abs=0.03 if order == 1 else 0.005)


def test_a_tube_that_radiates_into_itself_is_that_of_the_wall():
    m = member("boom", 1.0, 6, 24, tube(0.1, 0.002), plain(5.0))
    conditions = [
        Enclosure("cavity", [Side("boom", "inner")], [0.8]),
        Radiation("sky", "boom", 0.8, still(3.0)),
        Flux("sun", "boom", still(1400.0), np.array([0.0, -1.0, 0.0])),
    ]
    d, ends = Description([m], conditions=conditions), []
    for heat in (build("wall", d), build("solid", d), build("solid", d, Settings(order=2))):
        T, flows, why = heat.steady(heat.initial(), 0.0)
        assert why == ""
        assert abs(flows["cavity"]) < 1e-9
        ends.append((T.min(), T.mean(), T.max()))
    np.testing.assert_allclose(ends[1], ends[0], atol=1.5)  # chords are wider by 0.3 %
    np.testing.assert_allclose(ends[2], ends[0], atol=1.5)


@pytest.mark.parametrize("section", [circle(0.01), rectangle(0.02, 0.01), tube(0.01, 0.002)])
@pytest.mark.parametrize("order", [1, 2])
def test_thin_members_are_lines(section, order):
    m = member("bar", 1.0, 10, 1, section, varying())
    conditions = [
        Fixed("root", Place("bar", "start"), ramp(300.0, 360.0, 50.0)),
        Radiation("sky", "bar", 0.9, still(100.0)),
        Flux("sun", "bar", still(500.0)),
    ]
    d = Description([m], conditions=conditions)
    ends = []
    for heat in (build("line", d), build("solid", d, Settings(order=order))):
        T, _, why = heat.advance(heat.initial(), 0.0, 200.0, np.zeros(len(heat.x)))
        assert why == ""
        ends.append(T[heat.space.place(Place("bar", "end")).nodes].mean())
    assert ends[1] == pytest.approx(ends[0], abs=0.35)


# --- conditions ---------------------------------------------------------------------------------


def everything():
    """Member, sheet, solid and part with conditions of all kinds."""
    boom = member("boom", 1.0, 4, 12, tube(0.05, 0.002), varying(), 310.0)
    panel = Sheet("panel", surfaces.plate(1.0, 0.5, 4, 2), 0.01, plain(), 290.0)
    block = Solid("block", box((0.2, 0.2, 0.2), (2, 2, 2)), {"": varying()}, 320.0)
    hub = Part("hub", np.zeros(3), plain(), 2.0, 305.0, 0.1)
    rising, cool = ramp(310.0, 330.0, 9.0), still(305.0)
    conditions = [
        Wall("root", "boom", 0.0, 0.25, np.array([0.0, 1.0, 0.0]), (rising,) * 2, (cool,) * 2),
        Radiation("boom sky", "boom", 0.8, still(3.0)),
        Radiation("boom cavity", "boom", 0.5, still(250.0), "inner"),
        Flux("sun", "panel", still(1361.0), np.array([0.0, 0.3, -1.0]), "top"),
        Film("air", "panel", still(12.0), still(280.0), "bottom"),
        Fixed("seat", Place("block", "z0"), ramp(320.0, 300.0, 5.0)),
        Source("heater", Place("block"), still(40.0)),
        Radiation("hub sky", "hub", 0.9, still(3.0)),
    ]  # fmt: skip
    links = [
        Link("a", Place("boom", "end"), Place("hub"), 0.7),
        Link("b", Place("block", "x1"), Place("hub"), 3.0),
        Link("c", Place("panel"), Place("block"), 0.2, None, 0.01),
    ]
    return Description([boom], [hub], links, conditions, [panel], [block])


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("scheme", ["sdirk2", "backward-euler", "crank-nicolson"])
def test_flows_and_heat_are_what_is_stored(order, scheme):
    heat = build("solid", everything(), Settings(order=order, scheme=scheme, steps=3))
    T, rng = heat.initial(), np.random.default_rng(0)
    for i in range(3):
        given = rng.uniform(0.0, 2.0, len(T))
        new, flows, why = heat.advance(T, 2.0 * i, 2.0, given)
        assert why == ""
        stored = heat.energy(new) - heat.energy(T)
        largest = max(*map(abs, flows.values()), given.sum())
        assert abs(sum(flows.values()) + given.sum() - stored) < 1e-11 * largest
        T = new
    assert set(flows) >= {"root", "sun", "air", "seat", "heater", "boom cavity"}


def test_every_temperature_belongs_to_something():
    heat = build("solid", everything())
    owned = np.sort(np.concatenate(list(heat.regions.values())))
    np.testing.assert_array_equal(owned, np.arange(len(heat.x)))


@pytest.mark.parametrize("order", [1, 2])
def test_a_sheet_is_known_by_the_nodes_of_its_surface_from_top_to_bottom(order):
    surface = surfaces.tube(1.0, 2.0, 12, 3)
    panel = Sheet("panel", surface, 0.1, plain(), 290.0)
    s = SolidSpace(Description(sheets=[panel]), Settings(order=order, layers=2))
    x = s.x[s.regions["panel"]].reshape(len(surface.points), 3, 3)
    out = surface.points * [1.0, 1.0, 0.0]
    for level, height in enumerate((0.05, 0.0, -0.05)):
        np.testing.assert_allclose(x[:, level], surface.points + height * out, atol=1e-14)


def test_faces_have_the_areas_and_normals_of_their_things():
    s = build("solid", everything()).space
    boom, panel = tube(0.05, 0.002), 0.5
    expected = {
        ("boom", "outer"): boom.outer_perimeter,
        ("boom", "inner"): 2 * np.pi * 0.049,
        ("boom", "start"): boom.area,
        ("panel", "top"): panel,
        ("panel", "bottom"): panel,
        ("block", "outer"): 0.24,
    }
    for (thing, name), area in expected.items():
        face = s.face(Side(thing, name))
        assert sum(b.areas.sum() for b in face) == pytest.approx(area, rel=2e-3), name
        for b in face:
            np.testing.assert_allclose(np.linalg.norm(b.normals, axis=2), 1.0)
            edges = np.diff(b.polygons[:, :3], axis=1)
            turning = np.cross(edges[:, 0], edges[:, 1])
            assert (np.einsum("gi,gpi->gp", turning, b.normals) > 0.0).all()
    (top,) = s.face(Side("panel", "top"))
    np.testing.assert_allclose(
        top.normals, np.broadcast_to([0, 0, 1], top.normals.shape), atol=1e-12
    )
    (inner,) = s.face(Side("boom", "inner"))
    out = inner.points * [0, 1, 1]
    assert (np.sum(out * inner.normals, axis=2) < 0.0).all()


def test_places_are_integral_means_with_all_their_nodes():
    body = solid(pin(0.1, 0.5, 8, 1, 4, order=2))
    s = space(body)
    for end, z in ((None, 0.25), ("start", 0.0), ("end", 0.5), ("outer", 0.25)):
        mean = s.place(Place("block", end))
        assert mean.weights.sum() == pytest.approx(1.0)
        assert mean.weights @ s.x[mean.nodes, 2] == pytest.approx(z, abs=1e-14)
    assert len(s.place(Place("block")).nodes) == len(s.x)
    end = s.place(Place("block", "end")).nodes
    np.testing.assert_array_equal(end, np.flatnonzero(s.x[:, 2] > 0.5 - 1e-12))


def test_outer_is_all_of_the_boundary_where_no_region_has_that_name():
    s = space(solid(box((1.0, 2.0, 3.0), (2, 2, 2), family="tetra10")))
    assert sum(b.areas.sum() for b in s.face(Side("block", "outer"))) == pytest.approx(22.0)


def test_a_rubbing_region_stands_for_its_solid():
    s = space(solid(pin(0.1, 0.5, 8, 1, 2), rubbing="outer"))
    radii = np.hypot(*s.x[s.regions["block"]].T[:2])
    np.testing.assert_allclose(radii, 0.1)
    assert len(s.x) > len(radii)


def test_walls_are_linear_across_and_along():
    side = np.array([0.0, 1.0, 1.0])
    hot, cold = (still(400.0), still(420.0)), (still(300.0), still(310.0))
    for section, reach in ((tube(0.1, 0.02), 0.1), (circle(0.1), 0.1)):
        m = member("boom", 2.0, 4, 16, section)
        d = Description([m], conditions=[Wall("w", "boom", 0.5, 1.5, side, hot, cold)])
        s = SolidSpace(d, Settings(order=2))
        (given,) = s.given
        x = s.x[given.nodes]
        assert x[:, 0].min() == pytest.approx(0.5)
        assert x[:, 0].max() == pytest.approx(1.5)
        share = x[:, 0] - 0.5
        across = 0.5 + 0.5 * (x @ side) / np.sqrt(2.0) / reach
        expected = across * (400.0 + 20.0 * share) + (1.0 - across) * (300.0 + 10.0 * share)
        np.testing.assert_allclose(given.at(0.0), expected, rtol=1e-12)


def test_faces_of_a_sheet_and_fields_are_held():
    panel = Sheet("panel", surfaces.sphere(1.0, 6, 6, (-0.5, 0.5), (0.0, 1.0)), 0.1, plain(), 290.0)
    s = SolidSpace(
        Description(sheets=[panel], conditions=[Faces("f", "panel", still(400.0), still(300.0))]),
        Settings(order=2, layers=2),
    )
    (given,) = s.given
    height = np.linalg.norm(s.x, axis=1)
    assert len(given.nodes) == len(s.x)
    np.testing.assert_allclose(given.at(0.0), 350.0 + 1000.0 * (height - 1.0), atol=0.15)
    body = solid(box(CUBE, (2, 2, 2)))
    field = Field("g", "block", lambda x, t: 300.0 + x[:, 0] + t)
    (given,) = space(body, conditions=[field]).given
    np.testing.assert_allclose(given.at(2.0), 302.0 + box(CUBE, (2, 2, 2)).points[:, 0])


def test_the_first_of_two_faces_has_their_common_edge():
    faces = [Fixed(f, Place("block", f), still(T)) for f, T in (("x0", 400.0), ("y0", 300.0))]
    heat = build("solid", Description(solids=[solid(box(CUBE, (2, 2, 2)))], conditions=faces))
    nodes, values = heat.given_at(0.0)
    assert len(nodes) == len(set(nodes)) == 15
    assert values[np.isclose(heat.x[nodes, 0], 0.0)].tolist() == [400.0] * 9


# --- extremes -----------------------------------------------------------------------------------


def shocked(capacity, h, counts):
    """Extremes in steps of backward Euler that cool a quarter of a face of a cube to 300 K."""
    mesh = box(CUBE, counts)
    middles = mesh.points[mesh.cells["quad"]].mean(axis=1)
    quarter = (middles[:, 0] == 0.0) & (middles[:, 1] < 0.5) & (middles[:, 2] < 0.5)
    mesh = Mesh(mesh.points, mesh.cells, {"quarter": ("quad", np.flatnonzero(quarter))})
    cold = Fixed("cold", Place("block", "quarter"), still(300.0))
    d = Description(solids=[solid(mesh, initial=400.0)], conditions=[cold])
    heat = build("solid", d, Settings(scheme="backward-euler", steps=1, capacity=capacity))
    T, low, high = heat.initial(), np.inf, -np.inf
    for i in range(10):
        T, _, why = heat.advance(T, i * h, h, np.zeros(len(T)))
        assert why == ""
        low, high = min(low, T.min()), max(high, T.max())
    return low, high


@pytest.mark.parametrize("counts", [(4, 4, 4), (8, 2, 2), (2, 10, 2)])
def test_shocks_neither_under_nor_overshoot_in_boxes_of_any_ratio(counts):
    for h in (1e-3, 1.0, 1e3):
        low, high = shocked("auto", h, counts)
        assert low >= 300.0 - 1e-9
        assert high <= 400.0 + 1e-9
    assert shocked("consistent", 1e-3, counts)[1] > 405.0


@pytest.mark.parametrize("layers", [1, 2])
def test_shocks_hardly_overshoot_in_thin_tubes(layers):
    """Cells of 2 mm by 26 mm by 100 mm, hot on one side and cold on the other at one end."""
    points, axes = arc((0, 0, 0), (2, 0, 0), (0, 0, 1), 1.0, 20)
    m = Member("bow", points, axes, tube(0.05, 0.002), plain(), 12, 400.0)
    side = np.array([0.0, 0.0, 1.0])
    held = Wall("end", "bow", 0.0, 0.2, side, (still(400.0),) * 2, (still(300.0),) * 2)
    settings = Settings(scheme="backward-euler", steps=1, layers=layers)
    heat = build("solid", Description([m], conditions=[held]), settings)
    for h in (1e-3, 1.0, 1e3):
        T = heat.initial()
        for i in range(10):
            T, _, why = heat.advance(T, i * h, h, np.zeros(len(T)))
            assert why == ""
            assert T[heat.free].max() < 400.0 + 0.01
            assert T[heat.free].min() > 300.0


def test_conduction_along_edges_passes_the_patch_test_with_directed_conductivity():
    turn = np.linalg.qr(np.array([[1.0, 2.0, 3.0], [0.0, 1.0, -1.0], [2.0, 0.0, 1.0]]))[0].T
    around = constant("around", "W/(m K)", 3.0)
    material = replace(plain(conductivity=10.0), conductivity_around=around)
    s = space(solid(box(CUBE, (3, 2, 4)), material, axes=turn))
    gradient = np.array([5.0, -3.0, 2.0])
    T = 300.0 + s.x @ gradient
    power = s.power(T)
    inside = np.setdiff1d(np.arange(len(T)), boundary_nodes(s))
    assert np.abs(power[inside]).max() < 1e-12 * np.abs(power).max()
    dissipated = gradient @ turn.T @ ([10.0, 3.0, 10.0] * (turn @ gradient))
    assert -(T - 300.0) @ power == pytest.approx(dissipated, rel=1e-12)


def test_walls_of_a_micrometre():
    m = member("foil", 1.0, 20, 24, tube(0.5, 1e-6), plain())
    conditions = [Radiation("sky", "foil", 0.8, still(3.0)), Flux("sun", "foil", still(800.0))]
    heat = build("solid", Description([m], conditions=conditions))
    T, flows, why = heat.steady(heat.initial(), 0.0)
    assert why == ""
    expected = (800.0 / 0.8 / STEFAN_BOLTZMANN + 3.0**4) ** 0.25
    np.testing.assert_allclose(T, expected, rtol=1e-9)
    assert abs(sum(flows.values())) < 1e-11 * flows["sun"]


def test_leaving_the_range_of_a_property_is_a_reason():
    body = solid(box(CUBE, (1, 1, 1)), varying(250.0, 350.0))
    hot = Source("heater", Place("block"), still(1e8))
    heat = build("solid", Description(solids=[body], conditions=[hot]))
    _, _, why = heat.advance(heat.initial(), 0.0, 10.0, np.zeros(8))
    assert "'block' left the range of heat_capacity (250 K to 350 K)" in why


# --- files --------------------------------------------------------------------------------------


@FAMILY
def test_meshes_of_files_are_solved_as_those_made(tmp_path, family):
    made_mesh = box(CUBE, (2, 2, 3), family=family)
    upper = np.flatnonzero(made_mesh.points[made_mesh.cells[family]].mean(axis=1)[:, 2] > 1.0 / 3.0)
    mesh = Mesh(made_mesh.points, made_mesh.cells, {**made_mesh.regions, "top": (family, upper)})
    write(tmp_path / "block.msh", mesh)
    results = []
    for one in (mesh, read(tmp_path / "block.msh")):
        body = Solid("block", one, {"top": plain(20.0), "": plain(200.0)}, 300.0)
        conditions = [
            Fixed("seat", Place("block", "z0"), still(350.0)),
            Radiation("sky", "block", 0.9, still(3.0), "z1"),
        ]
        heat = build("solid", Description(solids=[body], conditions=conditions))
        T, flows, why = heat.steady(heat.initial(), 0.0)
        assert why == ""
        results.append(T)
    np.testing.assert_allclose(results[0], results[1], rtol=1e-12)
    k = 1.0 / (1.0 / 3.0 / 200.0 + 2.0 / 3.0 / 20.0)  # one after the other
    tip = T[heat.space.place(Place("block", "z1")).nodes].mean()
    assert k * (350.0 - tip) == pytest.approx(-flows["sky"], rel=1e-6)
    assert tip < 350.0


GMSH = """$MeshFormat
4.1 0 8
$EndMeshFormat
$PhysicalNames
3
2 1 "base"
2 2 "sides"
3 3 "body"
$EndPhysicalNames
$Entities
0 0 3 1
1 0 0 0 1 1 0 1 1 0
2 0 0 0 1 0 1 1 2 0
3 0 0 0 1 1 1 1 2 0
1 0 0 0 1 1 1 1 3 3 1 2 3
$EndEntities
$Nodes
1 5 1 5
3 1 0 5
1
2
3
4
5
0 0 0
1 0 0
0 1 0
0 0 1
9 9 9
$EndNodes
$Elements
4 4 1 4
2 1 2 1
1 1 3 2
2 2 2 1
2 1 2 4
2 3 2 1
3 2 3 4
3 1 4 1
4 1 2 3 4
$EndElements
"""


def test_physical_groups_of_gmsh_are_faces_and_nodes_of_no_cell_are_left_out(tmp_path):
    (tmp_path / "one.msh").write_text(GMSH)
    s = space(Solid("block", read(tmp_path / "one.msh"), {"body": plain()}, 300.0))
    assert len(s.x) == 4
    areas = {n: sum(b.areas.sum() for b in s.face(Side("block", n))) for n in ("base", "sides")}
    assert areas == pytest.approx({"base": 0.5, "sides": 0.5 + 0.5 * np.sqrt(3.0)})
    (base,) = s.face(Side("block", "base"))
    np.testing.assert_allclose(base.normals[0, 0], [0.0, 0.0, -1.0], atol=1e-15)


# --- refusals -----------------------------------------------------------------------------------


def swapped():
    mesh = box(CUBE, (2, 2, 2))
    cells = mesh.cells["hexahedron"].copy()
    cells[3] = cells[3][[4, 5, 6, 7, 0, 1, 2, 3]]
    return Mesh(
        mesh.points, {**mesh.cells, "hexahedron": cells}, {"corner": ("hexahedron", np.array([3]))}
    )


def flat():
    mesh = box(CUBE, (1, 1, 1), family="tetra")
    points = mesh.points * [1.0, 1.0, 0.0]
    return Mesh(points, mesh.cells, mesh.regions)


def in_pieces():
    a, b = box(CUBE, (1, 1, 1)), box(CUBE, (2, 1, 1))
    points = np.vstack([a.points, b.points + np.array([2.0, 0.0, 0.0])])
    cells = np.vstack([a.cells["hexahedron"], b.cells["hexahedron"] + 8])
    regions = {"small": ("hexahedron", np.array([0])), "large": ("hexahedron", np.array([1, 2]))}
    return Mesh(points, {"hexahedron": cells}, regions)


def wedged():
    mesh = box(CUBE, (1, 1, 1))
    return Mesh(mesh.points, {**mesh.cells, "wedge": np.array([[0, 1, 2, 4, 5, 6]])}, {})


def overlapping():
    mesh = box(CUBE, (1, 1, 1))
    return Mesh(mesh.points, {"hexahedron": np.repeat(mesh.cells["hexahedron"], 3, axis=0)})


@pytest.mark.parametrize(
    ("mesh", "words"),
    [
        (swapped(), r"1 of 8 hexahedron cells .* hexahedron 3 at \(0.75, 0.75, 0.25\) is inverted"),
        (swapped(), "in region 'corner'"),
        (
            flat(),
            "6 of 6 tetra cells have no volume or a negative one; tetra . at .* is degenerate",
        ),
        (
            in_pieces(),
            "in 2 pieces; one of 8 nodes, with hexahedron 0 .*, in region 'small', is isol",
        ),
        (wedged(), "cells of family wedge are not known, only tetra, tetra10, hexahedron"),
        (overlapping(), "share one face: they overlap"),
        (Mesh(np.zeros((3, 3)), {"triangle": np.array([[0, 1, 2]])}), "no volume cells"),
    ],
)
def test_senseless_meshes(mesh, words):
    with pytest.raises(ValueError, match=words):
        space(solid(mesh))


def test_materials_must_cover_every_cell_once():
    mesh = box(CUBE, (2, 1, 1))
    first, both = ("hexahedron", np.array([0])), ("hexahedron", np.array([0, 1]))
    mesh = Mesh(mesh.points, mesh.cells, {**mesh.regions, "first": first, "both": both})
    for materials, words in (
        ({"first": plain()}, "1 of its cells have no material"),
        ({"first": plain(), "both": plain()}, "regions 'first' and 'both' both give cells"),
        ({"x0": plain(), "": plain()}, "material of region 'x0': it has no volume cells"),
    ):
        with pytest.raises(ValueError, match=words):
            space(Solid("block", mesh, materials, 300.0))


def test_faces_must_be_on_the_boundary_and_have_an_area():
    mesh = box(CUBE, (2, 1, 1))
    middle = np.flatnonzero(mesh.points[:, 0] == 0.5)[[0, 1, 3, 2]]
    quads = np.vstack([mesh.cells["quad"], middle])
    regions = {"middle": ("quad", np.array([len(quads) - 1])), "none": ("quad", np.empty(0, int))}
    s = space(solid(Mesh(mesh.points, {**mesh.cells, "quad": quads}, regions)))
    with pytest.raises(
        ValueError, match="region 'middle' of 'block': 1 of its facets are no faces"
    ):
        s.face(Side("block", "middle"))
    with pytest.raises(ValueError, match="face 'none' of 'block' has no area"):
        s.face(Side("block", "none"))
    with pytest.raises(ValueError, match="'block' has no face 'left'; it has 'outer', 'middle'"):
        s.face(Side("block", "left"))


def test_what_is_misspelt_is_guessed():
    heater = Source("heater", Place("block", "strat"), still(1.0))
    d = Description(solids=[solid(pin(1.0, 1.0, 8, 1, 1))], conditions=[heater])
    with pytest.raises(ValueError, match="did you mean 'start'"):
        build("solid", d)


def test_sections_without_a_shape_and_wrong_settings_are_refused():
    odd = member("odd", section=general(1e-4, 1e-8, 1e-8, 1e-8))
    with pytest.raises(ValueError, match="'odd': a section of kind 'general' has no shape"):
        build("solid", Description([odd]))
    with pytest.raises(
        ValueError, match="order must be 1 or 2, got 3\n  layers must be at least 1"
    ):
        build("solid", Description([member()]), Settings(order=3, layers=0))
    with pytest.raises(ValueError, match="capacity must be one of auto, lumped, consistent"):
        build("solid", Description([member()]), Settings(capacity="some"))
    around = replace(plain(), conductivity_around=constant("around", "W/(m K)", 1.0))
    with pytest.raises(ValueError, match="'bar': a section of kind 'circle' has no directions"):
        build("solid", Description([member("bar", section=circle(0.1), material=around)]))


def test_hexahedra_and_tetrahedra_that_do_not_conform_are_refused():
    """Two hexahedra, one of them divided: quads meet triangles, which do not conform."""
    mesh = box((2.0, 1.0, 1.0), (2, 1, 1))
    parts = tetrahedra(Mesh(mesh.points, {"hexahedron": mesh.cells["hexahedron"][1:]}))
    both = Mesh(mesh.points, {"hexahedron": mesh.cells["hexahedron"][:1], **parts.cells})
    with pytest.raises(ValueError, match="triangles lie on quads"):
        space(solid(both))


# --- speed --------------------------------------------------------------------------------------


@pytest.mark.benchmark
def test_what_a_step_costs_beyond_linear_solves(capsys):
    """50,653 nodes, k(T), c(T), radiation: three evaluations and one tangent."""
    mesh = box(CUBE, (36, 36, 36))
    sky = Radiation("sky", "block", 0.8, still(3.0))
    d = Description(solids=[solid(mesh, varying())], conditions=[sky])
    s = SolidSpace(d)
    boundary, at = Boundary(d, s), Moment(0.0, {})
    T = 300.0 + 20.0 * s.x[:, 0] * s.x[:, 1]

    def evaluation():
        return s.heat(T), s.power(T), boundary.power(T, at), s.unusable(T)

    def tangent():
        return s.tangent(T, 3.0), boundary.slopes(T, at)

    times = []
    for call in (evaluation, tangent):
        spent = []
        for _ in range(8):
            start = process_time()
            call()
            spent.append(process_time() - start)
        times.append(1e3 * min(spent))
    total = 3 * times[0] + times[1]
    with capsys.disabled():
        print(
            f"\n{len(T)} nodes: evaluation {times[0]:.1f} ms, tangent {times[1]:.1f} ms, "
            f"a step {total:.0f} ms"
        )
    assert total < 60.0


@pytest.mark.benchmark
def test_refilling_against_plain_scikit_fem(capsys):
    """The tangent of 50,653 nodes with k(T), c(T), both of consistent capacity."""
    from skfem import BilinearForm
    from skfem.helpers import dot, grad

    mesh, material = box(CUBE, (36, 36, 36)), varying()
    k, c = material.conductivity, material.heat_capacity
    s = space(solid(mesh, material), settings=Settings(capacity="consistent"))
    T = 300.0 + 20.0 * s.x[:, 0] * s.x[:, 1]
    s.tangent(T, 3.0)
    start = process_time()
    s.tangent(T, 3.0)
    ours = process_time() - start
    basis = skfem_basis(mesh, "hexahedron", 3)
    form = BilinearForm(
        lambda u, v, w: (
            3.0 * k(w.T) * dot(grad(u), grad(v))
            + 3.0 * k.derivative(w.T) * u * dot(grad(w.T), grad(v))
            + 2700.0 * c(w.T) * u * v
        )
    )
    start = process_time()
    form.assemble(basis, T=basis.interpolate(T))
    theirs = process_time() - start
    with capsys.disabled():
        print(
            f"\nscikit-fem {1e3 * theirs:.0f} ms, here {1e3 * ours:.0f} ms: {theirs / ours:.0f} x"
        )
    assert theirs > 10.0 * ours


LARGE = """
import resource
import numpy as np
from meshes.materials import polynomial, Material, constant
from meshes.solids import box
from thermal.description import Description, Radiation, Settings, Solid
from thermal.solvers import build

k = polynomial("conductivity", "W/(m K)", [120.0, 0.5], 300.0)
c = polynomial("heat_capacity", "J/(kg K)", [800.0, 1.2], 300.0)
elastic = ("E", "Pa", 7e10), ("nu", "1", 0.3), ("a", "1/K", 1e-5)
others = [constant(*one) for one in elastic]
material = Material("varying", 2700.0, *others, k, c)
body = Solid("block", box((1.0, 1.0, 1.0), (79, 79, 79)), {"": material}, 300.0)
sky = Radiation("sky", "block", 0.8, lambda t: 3.0)
heat = build("solid", Description(solids=[body], conditions=[sky]), Settings(steps=1))
T, flows, why = heat.advance(heat.initial(), 0.0, 100.0, np.zeros(len(heat.x)))
assert why == "" and len(T) == 512000 and 250.0 < T.min() < 300.0
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6)
"""


@pytest.mark.slow
def test_half_a_million_nodes_fit_in_8_gigabytes():
    done = subprocess.run([sys.executable, "-c", LARGE], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert float(done.stdout) < 8.0
