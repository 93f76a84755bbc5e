"""Light on faces that move: exact in rigid motion, on bent tubes, in shadows."""

from math import cos, pi, radians, sin
from types import SimpleNamespace

import numpy as np
import pytest
from heat_cases import member, plain
from scipy.spatial.transform import Rotation

from coupling.exposure import Exposure
from mechanics.description import Beam, Particle, RigidBody, Shell
from mechanics.elements import FAMILIES
from mechanics.layout import Layout, family_of
from meshes import surfaces
from meshes.sections import tube
from thermal.description import Description, Irradiation, Part, Sheet
from thermal.discretisation import Block
from thermal.illumination import (
    Attitude,
    Coating,
    Environment,
    infrared,
    quaternions,
    sky,
    sunlight,
)
from thermal.lumps import LumpSpace
from thermal.orbit import FixedSun, Orbit, circular, sun_at_beta
from thermal.planet import Planet, mean_view_factor
from thermal.solvers import build

SECTION = tube(0.05, 0.002)
OUTER = 0.051
UP = np.array([0.0, 0.0, 1.0])
TURN = Rotation.from_rotvec([0.4, -1.1, 0.7]).as_matrix()


def above(flux=1000.0, direction=UP):
    """A sun that stands still, far from any planet."""
    return Environment(FixedSun(direction), flux=flux)


def tubular(name="arm", start=(0.0, 0.0, 0.0), elements=8, length=2.0):
    """A tube along x with 16 temperatures round it."""
    return member(name, length, elements, 16, SECTION, start=start)


def beam_of(m, element="beam3243"):
    """The beam of a member."""
    return Beam(m.name, m.points, m.axes, m.section, m.material, 300.0, element=element)


def lit(*members):
    """Their description and its solver, every outer face lit under the name of the member."""
    description = Description(members, conditions=[Irradiation(m.name, m.name) for m in members])
    return description, build("line", description)


def coats(*names, absorptivity=1.0, emissivity=1.0):
    return [Coating(n, n, "outer", absorptivity, emissivity) for n in names]


def exposed(environment, *members, layout=None, **values):
    """Exposure of members, with the solver that integrates over their faces."""
    description, solver = lit(*members)
    names = [m.name for m in members]
    coatings = coats(*names, **values)
    return Exposure(environment, coatings, solver.irradiated, description, layout), solver


def areas(face):
    return np.concatenate([block.areas.ravel() for block in face])


def moved(layout, turn, shift, bodies=None):
    """Coordinates of a rigid motion: about the origin, then by a shift."""
    q = layout.q0.copy()
    for name in bodies or layout.bodies:
        body = layout.bodies[name]
        for first in layout.node_dofs[name]:
            k = len(family_of(body).vectors)
            vectors = q[first : first + 3 * k].reshape(k, 3) @ turn.T
            vectors[0] += shift
            q[first : first + 3 * k] = vectors.ravel()
    return q


def pose(q):
    return SimpleNamespace(q=q)


# ------------------------------------------------------------------------------- one tube


def test_a_tube_absorbs_by_its_diameter():
    exposure, solver = exposed(above(), tubular(), absorptivity=0.3)
    absorbed = exposure.at(0.0)["arm"]
    exact = 0.3 * 1000.0 * 2.0 * OUTER * 2.0
    assert areas(solver.irradiated["arm"]) @ absorbed == pytest.approx(exact, rel=2e-3)
    assert absorbed.max() <= 300.0 * (1.0 + 1e-12) and absorbed.min() == 0.0


def test_the_reference_pose_is_where_nothing_has_moved():
    arm = tubular()
    layout = Layout.of([beam_of(arm)])
    exposure, _ = exposed(above(), arm, layout=layout)
    alone, _ = exposed(above(), arm)
    for now in (None, pose(layout.q0), SimpleNamespace(motion=pose(layout.q0))):
        assert np.allclose(exposure.at(0.0, now)["arm"], alone.at(0.0)["arm"], atol=1e-10)


@pytest.mark.parametrize("element", ["beam3243", "beam3333"])
def test_beams_carry_their_faces_in_rigid_motion(element):
    """Turned with the sun they absorb what they did."""
    first, second = tubular(), tubular("other", (0.3, 0.0, -0.4))
    layout = Layout.of([beam_of(m, element) for m in (first, second)])
    before, _ = exposed(above(), first, second, layout=layout)
    after, _ = exposed(above(direction=TURN @ UP), first, second, layout=layout)
    then = pose(moved(layout, TURN, np.array([3.0, -1.0, 2.0])))
    a, b = before.at(0.0), after.at(0.0, then)
    assert max(np.abs(a[name] - b[name]).max() for name in a) < 1e-9
    assert b["other"].max() > 990.0  # beyond the end of the first
    points = TURN @ before.look(0.0).points.T + np.array([[3.0], [-1.0], [2.0]])
    assert np.allclose(after.look(0.0, then).points.T, points, atol=1e-12)


def test_a_cable_carries_its_face():
    arm = tubular()
    layout = Layout.of([beam_of(arm, "cable")])
    exposure, _ = exposed(above(), arm, layout=layout)
    light = exposure.look(0.0, pose(moved(layout, TURN, UP)))
    axis = (light.points - UP) @ TURN[:, 0]
    away = light.points - UP - axis[:, None] * TURN[:, 0]
    assert np.allclose(away, OUTER * light.normals, atol=1e-12)


def test_a_bent_tube_carries_its_face():
    """A boom of 2 m bent to a quarter of a circle: points at the outer radius round the arc."""
    arm = tubular(elements=8)
    layout = Layout.of([beam_of(arm)])
    radius, q = 2.0 / (0.5 * pi), layout.q0.copy()
    for s, first in zip(np.linspace(0.0, 0.5 * pi, 9), layout.node_dofs["arm"], strict=True):
        e1, e3 = np.array([cos(s), 0.0, sin(s)]), np.array([-sin(s), 0.0, cos(s)])
        at = radius * np.array([sin(s), 0.0, 1.0 - cos(s)])
        q[first : first + 12] = np.concatenate([at, e1, [0.0, 1.0, 0.0], e3])
    exposure, _ = exposed(above(), arm, layout=layout)
    light = exposure.look(0.0, pose(q))
    inplane = light.points * [1.0, 0.0, 1.0] - [0.0, 0.0, radius]
    ring = radius * inplane / np.linalg.norm(inplane, axis=1, keepdims=True) + [0.0, 0.0, radius]
    assert np.allclose(light.points - ring, OUTER * light.normals, atol=2e-5)
    assert np.all(light.seen[light.normals @ UP > 0.05] == 1.0)  # nowhere in its own shadow


def test_flows_into_the_heat_solver_are_what_was_absorbed():
    exposure, solver = exposed(above(), tubular())
    absorbed = exposure.at(0.0)
    _, flows, why = solver.advance(
        solver.initial(), 0.0, 10.0, np.zeros(len(solver.x)),
        {name: (value, value) for name, value in absorbed.items()},
    )  # fmt: skip
    assert not why
    power = areas(solver.irradiated["arm"]) @ absorbed["arm"]
    assert flows["arm"] == pytest.approx(10.0 * power, rel=1e-12)


# ------------------------------------------------------------------------------- shadows


def test_the_shadow_follows_the_boom():
    """A boom across another shades it where it is; slid along, the shadow goes with it."""
    low = member("low", 4.0, 40, 16, SECTION)
    across = {"along": (0.0, 1.0, 0.0), "normal": (0.0, 0.0, 1.0)}
    high = member("high", 2.0, 4, 16, SECTION, start=(1.0, -1.0, 2.0), **across)
    layout = Layout.of([beam_of(low), beam_of(high)])
    exposure, _ = exposed(above(), low, high, layout=layout)
    for shift in (0.0, 1.7):
        q = moved(layout, np.eye(3), np.array([shift, 0.0, 0.0]), ["high"])
        light = exposure.look(0.0, pose(q))
        rows = exposure.rows["low"]
        top = light.normals[rows] @ UP > 0.5
        x, seen = light.points[rows, 0][top], light.seen[rows][top]
        assert np.all(seen[np.abs(x - 1.0 - shift) < OUTER - 0.01] < 1e-12)
        assert np.all(seen[np.abs(x - 1.0 - shift) > OUTER + 0.01] > 1.0 - 1e-12)


def sheet_at(height, element="shell48"):
    """A plate 1 m wide over the middle of a boom, thermal and mechanical."""
    flat = surfaces.placed(surfaces.plate(1.0, 1.0, 4, 4), (0.5, -0.5, height), np.eye(3))
    sheet = Sheet("panel", flat, 0.01, plain(), 300.0)
    return sheet, Shell("panel", flat, 0.01, plain(), 300.0, element=element)


@pytest.mark.parametrize("element", ["shell48", "shell24", "shell3443"])
def test_a_panel_shades_a_boom_and_itself_is_lit(element):
    sheet, shell = sheet_at(1.5, element)
    arm = member("arm", 2.0, 40, 16, SECTION)
    layout = Layout.of([beam_of(arm), shell])
    description, solver = lit(arm)
    description = Description(description.members, sheets=[sheet])
    face = faces_of(sheet)
    irradiated = {**solver.irradiated, **face}
    coatings = [*coats("arm"), Coating("top", "panel", "top"), Coating("bottom", "panel", "bottom")]
    exposure = Exposure(above(), coatings, irradiated, description, layout)
    for turn, sun in ((np.eye(3), UP), (TURN, TURN @ UP)):
        exposure.environment = above(direction=sun)
        light = exposure.look(0.0, pose(moved(layout, turn, 0.0)))
        rows = exposure.rows
        x = light.points[rows["arm"]] @ turn[:, 0]
        top = light.normals[rows["arm"]] @ sun > 0.5
        seen = light.seen[rows["arm"]]
        assert np.all(seen[top & (np.abs(x - 1.0) < 0.49)] < 1e-9)
        assert np.all(seen[top & (np.abs(x - 1.0) > 0.51)] > 1.0 - 1e-9)
        assert np.all(light.seen[rows["top"]] == 1.0)
        assert np.all(light.seen[rows["bottom"]] == 0.0)
        assert np.allclose(light.points[rows["top"]] @ sun, 1.505)


def faces_of(sheet):
    """Both faces of a plate, a point in every element; only points and normals matter here."""
    at = sheet.surface.points[sheet.surface.quads].mean(axis=1)[:, None]
    found = {}
    for name, side in (("top", 1.0), ("bottom", -1.0)):
        points = at + 0.5 * side * sheet.thickness * UP
        normals = np.broadcast_to(side * UP, points.shape)
        nodes = np.zeros((len(at), 1), np.intp)
        block = Block(nodes, np.ones((1, 1)), np.ones(points.shape[:2]), points, normals, points)
        found[name] = [block]
    return found


def box_face(side, height):
    """Outer face of a cube about (1, 0, height)."""
    h = 0.5 * side
    axes = [np.roll(np.eye(3), k, axis=0) for k in range(3)]
    quads, normals = [], []
    for x, y, z in axes:
        for sign in (1.0, -1.0):
            corners = [sign * x + u * y + v * z for u, v in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
            quads.append(corners if sign > 0.0 else corners[::-1])
            normals.append(sign * x)
    polygons = h * np.array(quads) + np.array([1.0, 0.0, height])
    points = polygons.mean(axis=1)[:, None]
    normals = np.array(normals)[:, None]
    nodes = np.zeros((6, 1), np.intp)
    return [Block(nodes, np.ones((1, 1)), np.full((6, 1), side**2), points, normals, polygons)]


def test_a_solid_shades_by_its_polygons_and_goes_with_its_body():
    arm, face = member("arm", 2.0, 40, 16, SECTION), box_face(0.5, 1.0)
    hub = RigidBody("hub", np.array([1.0, 0.0, 1.0]), 1.0, np.eye(3))
    layout = Layout.of([beam_of(arm), hub])
    description, solver = lit(arm)
    irradiated = {**solver.irradiated, "hub": face}
    coatings = coats("arm", "hub")
    exposure = Exposure(above(), coatings, irradiated, description, layout, {"hub": face})
    for shift in (0.0, 0.6):
        q = moved(layout, np.eye(3), np.array([shift, 0.0, 0.0]), ["hub"])
        light = exposure.look(0.0, pose(q))
        rows = exposure.rows["arm"]
        x, top = light.points[rows, 0], light.normals[rows] @ UP > 0.5
        seen = light.seen[rows]
        assert np.all(seen[top & (np.abs(x - 1.0 - shift) < 0.24)] < 1e-9)
        assert np.all(seen[top & (np.abs(x - 1.0 - shift) > 0.26)] > 1.0 - 1e-9)
        assert light.seen[exposure.rows["hub"]].sum() == pytest.approx(1.0)  # its top


# --------------------------------------------------------------------------------- lumps


def lump(name="node", position=(5.0, 0.0, 0.0)):
    description = Description(parts=[Part(name, np.array(position), plain(), 1.0, 300.0, 0.2)])
    space = LumpSpace(description)
    return description, {"node": space.irradiated(SimpleNamespace(thing=name))}


def test_a_lump_takes_a_quarter_of_the_sun_and_the_mean_of_the_planet():
    orbit = circular(500e3)
    environment = Environment(sun_at_beta(orbit, 0.0), orbit=orbit, planet=Planet(albedo=0.0))
    description, face = lump()
    coating = Coating("node", "node", "outer", 0.5, 0.8)
    absorbed = Exposure(environment, [coating], face, description).at(0.0)["node"]
    factor = mean_view_factor(orbit.semi_major_axis / 6378137.0)
    exact = 0.5 * 0.25 * sky(environment, 0.0).flux + 0.8 * 238.0 * factor
    assert absorbed == pytest.approx([exact], rel=1e-12)


def test_a_side_of_a_joint_goes_with_the_body_that_it_is_on():
    arm = tubular()
    layout = Layout.of([beam_of(arm), Particle("far", np.zeros(3), 1.0)])
    index = {**layout.point_index, "hinge.journal": np.array([0])}
    layout = SimpleNamespace(**{**vars(layout), "point_index": index})
    description, face = lump("hinge.journal", (2.0, 0.0, 0.0))
    coating = Coating("node", "hinge.journal")
    exposure = Exposure(above(), [coating], face, description, layout)
    q = moved(layout, TURN, UP)
    assert np.allclose(exposure.look(0.0, pose(q)).points, [TURN @ [2.0, 0.0, 0.0] + UP])


# -------------------------------------------------------------------------------- attitude


def test_attitudes_turn_evenly_between_times():
    angles = np.array([[0.0, 0.0, 0.0], [1.2, 0.0, 0.0]])
    attitude = Attitude("inertial", [10.0, 30.0], quaternions(angles))
    for t, angle in ((0.0, 0.0), (10.0, 0.0), (15.0, 0.3), (30.0, 1.2), (50.0, 1.2)):
        exact = Rotation.from_euler("Z", angle).as_matrix()
        assert np.allclose(attitude.within(t), exact, atol=1e-12)


def test_quaternions_of_either_sign_go_the_short_way():
    q = quaternions([[0.0, 0.0, 0.0], [0.4, 0.3, -0.2]])
    there = Attitude("inertial", [0.0, 1.0], q).within(0.3)
    assert np.allclose(Attitude("inertial", [0.0, 1.0], q * [[1.0], [-1.0]]).within(0.3), there)


def test_axes_to_nadir_and_ahead():
    orbit = Orbit(8e6, 0.1, 0.8, 0.3, 0.2, 1.0)
    environment = Environment(FixedSun(UP), Attitude("nadir"), orbit, Planet())
    for t in (0.0, 1234.0):
        assert np.allclose(sky(environment, t).nadir, UP, atol=1e-12)
        r, v = orbit.at(t)
        sun = sky(environment, t).sun
        assert sun[1] == pytest.approx(-orbit.normal @ UP, abs=1e-4)
        assert sun[0] == pytest.approx(UP @ np.cross(orbit.normal, r) / np.linalg.norm(r), abs=1e-4)
        assert v @ np.cross(orbit.normal, r) > 0.0  # x is ahead


@pytest.mark.parametrize("beta", [0.0, 0.7, pi / 2])
def test_a_fixed_offset_from_the_sun(beta):
    """The case turned by 30 degrees about z within the frame sees the sun 30 degrees behind x."""
    orbit = circular(500e3, 0.4)
    offset = Attitude("sun", [0.0], quaternions([[radians(30.0), 0.0, 0.0]]))
    environment = Environment(sun_at_beta(orbit, beta), offset, orbit, Planet())
    for t in (0.0, 1000.0, 2000.0):
        expected = [cos(radians(30.0)), -sin(radians(30.0)), 0.0]
        assert np.allclose(sky(environment, t).sun, expected, atol=1e-12)


# ----------------------------------------------------------------------------------- orbit


def nadir_plate(environment, t, normal):
    now = sky(environment, t)
    n = np.array([normal], float)
    return sunlight(now, n, np.ones(1))[0], infrared(now, n)[0]


def test_noon_and_midnight():
    """At noon the far side takes the sun and the near side albedo; at midnight infrared alone."""
    orbit = circular(400e3)
    environment = Environment(sun_at_beta(orbit, 0.0), Attitude("nadir"), orbit, Planet())
    height = orbit.semi_major_axis / 6378137.0
    far, _ = nadir_plate(environment, 0.0, -UP)
    near, warm = nadir_plate(environment, 0.0, UP)
    assert far == pytest.approx(1361.0, rel=2e-4)
    assert warm == pytest.approx(238.0 / height**2)
    assert 0.9 * 0.3 * 1361.0 / height**2 < near < 0.3 * 1361.0 / height**2
    midnight = 0.5 * orbit.period
    assert sky(environment, midnight).visible == 0.0
    assert nadir_plate(environment, midnight, -UP) == (0.0, 0.0)
    assert nadir_plate(environment, midnight, UP) == (0.0, pytest.approx(238.0 / height**2))


def test_absorbed_of_a_tube_over_an_orbit():
    """Mean over the circumference: sun q 2/(2 pi) past the shadow, planet by view factor."""
    orbit = circular(400e3)
    environment = Environment(sun_at_beta(orbit, 0.0), Attitude("nadir"), orbit, Planet(albedo=0.0))
    across = member("arm", 1.0, 4, 32, SECTION, along=(0.0, 1.0, 0.0), normal=(0.0, 0.0, 1.0))
    exposure, solver = exposed(environment, across, absorptivity=0.4, emissivity=0.7)
    w = areas(solver.irradiated["arm"])
    phi = 2.0 * pi * np.arange(4000) / 4000
    ring = np.stack([np.sin(phi), 0.0 * phi, np.cos(phi)], axis=1)
    for t, sun in ((0.0, 1.0), (0.5 * orbit.period, 0.0)):
        now = sky(environment, t)
        exact = 0.4 * sun * now.flux / pi + 0.7 * infrared(now, ring).mean()
        assert w @ exposure.at(t)["arm"] / w.sum() == pytest.approx(exact, rel=2e-3)


# --------------------------------------------------------------------------------- refusals


def test_what_does_not_fit_is_refused_with_all_that_is_wrong():
    description, solver = lit(tubular())
    coatings = [Coating("arm", "arm"), Coating("arm", "arm", "inner"), Coating("no", "arm")]
    with pytest.raises(ValueError, match=r"two coatings.*\n.*no light falls.*\n.*no such"):
        Exposure(above(), coatings, solver.irradiated, description)
    with pytest.raises(ValueError, match=r"absorptivity.*\n.*emissivity"):
        Coating("a", "b", "outer", 1.5, -0.1)
    with pytest.raises(ValueError, match=r"no frame.*\n.*rise.*\n.*quaternions"):
        Attitude("up", [1.0, 0.0], [[0.0, 0.0, 0.0, 1.0]])
    with pytest.raises(ValueError, match=r"flux.*\n.*needs an orbit.*\n.*'nadir'"):
        Environment(FixedSun(UP), Attitude("nadir"), None, Planet(), -1.0)
    with pytest.raises(ValueError, match=r"6000 km"):
        Environment(FixedSun(UP), Attitude(), Orbit(6e6), Planet())


def test_every_flexible_family_was_tried():
    """A new family must be added above."""
    tried = {"beam3243", "beam3333", "cable", "shell48", "shell24", "shell3443"}
    # refused, or without a face
    unlit = {"rigid", "particle", "reference", "hexahedron20", "hexahedron27"}
    assert {name.partition("-")[0] for name in FAMILIES} - unlit == tried
