"""Skins and their pictures: parts of facets, faces laid out flat, thicker tubes, the sky."""

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from coupling import casefile, light_pictures, skin_pictures
from coupling.environments import environment
from coupling.light_pictures import Sun, eclipses, looking, thickening
from coupling.model import build
from coupling.pictures import _merged
from coupling.plot import STYLE, _pictures
from coupling.reading import Results
from coupling.simulation import run
from coupling.skin_shapes import Skin, laid_out, parted, small_facets, telling_frames, thickened
from coupling.surfaces import Body, Patches
from meshes import generate, sections, surfaces
from thermal.illumination import sky

ROOT = Path(__file__).parent
SUN = np.array([0.3, -0.8, 0.52])
SUN /= np.linalg.norm(SUN)
FLUX = 1361.0

SCENE = """
[time]
end = "4 s"
window = "1 s"
[section.tube]
kind = "tube"
mean_radius = "5 cm"
thickness = "1 mm"
[body.tube]
kind = "beam"
start = [0, 0, 0]
end = ["4 m", 0, 0]
elements = 4
normal = [0, 1, 0]
section = "tube"
material = "al6061"
[body.plate]
kind = "shell"
surface = { kind = "plate", length = "2 m", width = "1 m", elements = [3, 2], origin = [0, 3, 0] }
thickness = "2 cm"
material = "al6061"
[joint.foot]
kind = "clamp"
a = { body = "tube", at = "start" }
[joint.edge]
kind = "clamp"
a = { body = "plate", edge = "u-start" }
[thermal]
solver = "SOLVER"
initial = "20 degC"
wall_points = 8
order = ORDER
[thermal.environment]
sun = { direction = [0.3, -0.8, 0.52] }
[thermal.surface.tube]
body = "tube"
absorptivity = 0.5
emissivity = 0.8
[thermal.surface.top]
body = "plate"
face = "top"
absorptivity = 0.7
emissivity = 0.8
[thermal.surface.bottom]
body = "plate"
face = "bottom"
absorptivity = 0.7
emissivity = 0.8
[output]
frames = 4
skins = ["tube", "plate"]
export = []
"""


def scene(order=1, solver="wall", more=""):
    text = SCENE.replace("ORDER", str(order)).replace("SOLVER", solver)
    return casefile.from_text(text + more, ROOT)


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    outcome = run(scene(), tmp_path_factory.mktemp("skins"))
    assert outcome.code == 0, outcome.reason
    with Results.open(outcome.folder) as opened:
        yield opened


def area(corners):
    return 0.5 * np.linalg.norm(
        np.cross(corners[..., 2, :] - corners[..., 0, :], corners[..., 3, :] - corners[..., 1, :]),
        axis=-1,
    )


# ------------------------------------------------------------------------------ parts of facets


def test_parts_cover_the_facet_and_lie_row_by_row():
    corners = np.array([[[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [3.0, 2.0, 0.0], [0.0, 2.0, 0.0]]])
    small = small_facets(corners, 16)
    assert small.shape == (1, 16, 4, 3)
    assert area(small).sum() == pytest.approx(6.0)
    middles = small[0].mean(axis=1)
    assert np.all(np.diff(middles[::4, 0]) > 0.3) and np.all(np.diff(middles[:4, 1]) > 0.2)
    assert_allclose(area(small)[0] / 6.0, np.outer(*2 * [_gauss()]).ravel(), rtol=1e-12)
    turned = np.cross(small[..., 1, :] - small[..., 0, :], small[..., 2, :] - small[..., 1, :])
    assert np.all(turned[..., 2] > 0.0)


def _gauss():
    return 0.5 * np.polynomial.legendre.leggauss(4)[1]


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize(("name", "share"), [("tube.outer", 0.5), ("plate.top", 0.7),
                                             ("plate.bottom", 0.7)])  # fmt: skip
def test_each_part_has_the_light_of_its_own_direction(order, name, share):
    """Nothing shades: what a part takes up is the cosine of its own normal."""
    model = build(scene(order))
    row = model.skins(model.initial())[name]
    small = small_facets(row["corners"], 16)
    normal = np.cross(small[:, :, 2] - small[:, :, 0], small[:, :, 3] - small[:, :, 1])
    if name == "tube.outer":
        middle = small.mean(axis=2)
        normal = middle * [0.0, 1.0, 1.0]
    normal /= np.linalg.norm(normal, axis=2, keepdims=True)
    expected = share * FLUX * np.maximum(0.0, normal @ SUN)
    # the middle of a part is beside its Gauss point by up to 0.018 of an eighth of a turn
    assert_allclose(row["parts"], expected, atol=0.02 * share * FLUX)
    weights = np.outer(_gauss(), _gauss()).ravel()
    assert_allclose(row["light"], row["parts"] @ weights, rtol=1e-12)


@pytest.mark.parametrize(("order", "exact"), [(1, False), (2, True)])
def test_the_temperature_of_a_facet_is_its_mean(order, exact):
    """Of a quadratic field along the tube: exact at order 2, too high by h^2 f''/12 at order 1."""
    model = build(scene(order))
    state = model.initial()
    x = model.pair.heat_solver.x[:, 0]
    state = state._replace(T=300.0 + 4.0 * x**2)
    row = model.skins(state)["tube.outer"]
    ends = row["corners"][..., 0].min(axis=1), row["corners"][..., 0].max(axis=1)
    mean = 300.0 + 4.0 / 3.0 * (ends[1] ** 3 - ends[0] ** 3) / (ends[1] - ends[0])
    assert_allclose(row["temperature"], mean + (0.0 if exact else 8.0 / 12.0), rtol=1e-12)


def test_lines_have_skins_too():
    text = (
        SCENE.replace("ORDER", "1").replace("SOLVER", "line").replace('"tube", "plate"', '"tube"')
    )
    table, rest = text.split("[body.plate]")
    text = table + "[joint.foot]" + rest.split("[joint.foot]")[1]
    text = text.replace(
        '[joint.edge]\nkind = "clamp"\na = { body = "plate", edge = "u-start" }\n', ""
    )
    start, end = text.index("[thermal.surface.top]"), text.index("[output]")
    model = build(casefile.from_text(text[:start] + text[end:], ROOT))
    row = model.skins(model.initial())["tube.outer"]
    round_area = 2.0 * np.pi * 0.0505 * 4.0
    assert area(row["corners"]).sum() == pytest.approx(round_area, rel=2e-3)
    assert (row["light"] * area(row["corners"])).sum() == pytest.approx(
        0.5 * FLUX * 2.0 * 0.0505 * 4.0 * np.hypot(SUN[1], SUN[2]), rel=5e-3
    )


# ------------------------------------------------------------------------------------- recorded


def test_the_sky_is_recorded_for_every_window(tmp_path):
    orbit = 'orbit = { kind = "circular", altitude = "500 km", phase = "115 deg" }\n'
    lit = scene().text.replace("[thermal.surface.tube]", orbit + "[thermal.surface.tube]", 1)
    lit = lit.replace("direction = [0.3, -0.8, 0.52]", 'beta = "10 deg"')
    read = casefile.from_text(lit, ROOT)
    outcome = run(read, tmp_path)
    assert outcome.code == 0, outcome.reason
    with Results.open(outcome.folder) as found:
        table = found.table("sky")
    assert_allclose(table["time"], np.arange(5.0))
    for row, t in enumerate(table["time"]):
        now = sky(environment(read.thermal.environment), t)
        assert_allclose(table["sun"][row], now.sun)
        assert_allclose(table["planet"][row], now.nadir)
        assert table["flux"][row] == now.flux and table["visible"][row] == now.visible


def test_a_run_with_skins_gets_their_pictures(results):
    from matplotlib import rc_context
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    drawn = [p for p in _pictures(results) if p.name in ("light", "skin_temperature", "sky")]
    assert len(drawn) == 3
    for picture in drawn:
        with rc_context(STYLE):
            figure = Figure(figsize=picture.size, dpi=60, layout="constrained")
            canvas = FigureCanvasAgg(figure)
            picture.draw(results, figure)
            canvas.draw()
        image = np.asarray(canvas.buffer_rgba(), dtype=int)
        background = (np.abs(image - image[2, 2]).max(axis=2) < 5).mean()
        assert 0.05 < background < 0.99, picture.name
    assert light_pictures.sky_rows(results) == 2  # the sunlight does not change
    assert skin_pictures.map_rows(results) == 5  # no light on the bottom of the plate


def test_powers_are_what_the_skins_absorb(results):
    found = light_pictures.powers(results)
    corners, light = results["skins/plate.top/corners"], results["skins/plate.top/light"]
    absorbed = (area(corners[0]) * light[0]).sum()
    assert found["light.top"][0] == pytest.approx(absorbed, rel=1e-3)
    assert np.all(found["light.bottom"] == 0.0) and np.all(found["surface.bottom"] < 0.0)


def test_many_heats_are_drawn_as_sums_of_their_kinds():
    few = {f"heat_light.{i}": np.full(3, float(i)) for i in range(4)}
    assert _merged(few) == few
    many = {"heat_stored": np.ones(3)} | {f"heat_light.{i}": np.full(3, i) for i in range(5)}
    many |= {f"heat_surface.{i}": np.full(3, -i) for i in range(5)}
    merged = _merged(many)
    assert list(merged) == ["heat_stored", "heat_light, 5 together", "heat_surface, 5 together"]
    assert list(merged["heat_surface, 5 together"]) == [-10.0] * 3


# ------------------------------------------------------------------------------------- laid out


def line_body(points, radius=0.1):
    frames = generate.frames(points)
    return Body("b", points[None], frames[None], None, None, sections.tube(radius, 0.01))


def tube_corners(points, radius, around=16):
    body = line_body(points, radius)
    x, quads = generate.sweep(points, body.axes[0], body.section.outline(around))
    return x[quads]


def arc(radius=5.0, n=41):
    phi = np.linspace(0.0, 0.5 * np.pi, n)
    return np.stack([radius * np.sin(phi), radius * (1.0 - np.cos(phi)), 0.0 * phi], axis=1)


@pytest.mark.parametrize("points", [arc(), np.linspace([0, 0, 0], [3, 2, 1], 7)])
def test_a_tube_unrolls_to_its_length_and_a_turn(points):
    body = line_body(points)
    flat = laid_out(Skin("b.outer", body, False), tube_corners(points, 0.1))
    length = np.linalg.norm(np.diff(points, axis=0), axis=1).sum()
    assert flat.period == 360.0
    u, v = np.moveaxis(flat.corners, -1, 0)
    assert u.min() == pytest.approx(0.0, abs=1e-9) and u.max() == pytest.approx(length, rel=1e-3)
    assert_allclose(np.ptp(v, axis=1), 22.5, rtol=1e-2)
    assert _flat_area(flat.corners).sum() == pytest.approx(length * 360.0, rel=2e-3)


def _flat_area(corners):
    a, b = corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]
    return 0.5 * np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])


@pytest.mark.parametrize("factor", [1.0, 5.0])
def test_tubes_are_drawn_thicker_about_their_bent_axis(factor):
    points = arc()
    skin = Skin("b.outer", line_body(points), False)
    drawn = thickened(skin, tube_corners(points, 0.1), 0, factor)
    x, y, z = np.moveaxis(drawn, -1, 0)
    inside = (x > 0.6) & (y < 4.4)  # away from the ends
    away = np.hypot(np.hypot(x, y - 5.0) - 5.0, z)
    assert_allclose(away[inside], factor * 0.105, rtol=3e-3)


def test_only_slender_tubes_are_drawn_thicker():
    short, long = line_body(np.linspace([0, 0, 0], [2, 0, 0], 3)), line_body(
        np.linspace([0, 0, 0], [60, 0, 0], 3)
    )  # fmt: skip
    assert thickening([Skin("a.outer", short, True)]) == 1.0
    factor = thickening([Skin("a.outer", long, True), Skin("p.top", None, True)])
    assert factor in (10.0, 20.0)


@pytest.mark.parametrize("around", [4, 5])
def test_a_closed_shell_is_laid_out_without_overlap(around):
    surface = surfaces.tube(1.0, 3.0, around, 3)
    patches = Patches(surface.quads, surface.sizes, None)
    points = surface.points[None]
    body = Body("s", points, np.zeros((1, len(surface.points), 3, 3)), None, None, None, patches)
    flat = laid_out(Skin("s.top", body, True), surface.points[surface.quads])
    assert _flat_area(flat.corners).sum() == pytest.approx(np.prod(surface.sizes, axis=1).sum())
    middles = flat.corners.mean(axis=1).round(6)
    assert len(np.unique(middles, axis=0)) == len(surface.quads)
    assert np.prod(np.ptp(flat.corners.reshape(-1, 2), axis=0)) == pytest.approx(
        _flat_area(flat.corners).sum()
    )


def test_solids_are_not_laid_out():
    assert laid_out(Skin("solid.outer", None, True), np.zeros((2, 4, 3))) is None


def test_parts_of_flat_facets_keep_their_values():
    corners = np.array([[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]])
    values = np.arange(4.0)[None]
    small, light = parted(corners, values)
    assert small.shape == (4, 4, 2) and list(light) == [0.0, 1.0, 2.0, 3.0]
    same, one = parted(corners, values[:, 0])
    assert same is corners and one.shape == (1,)


# ----------------------------------------------------------------------------------------- times


def test_eclipses_are_found_with_their_penumbra():
    time = np.arange(8.0)
    visible = np.array([1.0, 0.4, 0.0, 0.0, 0.6, 1.0, 1.0, 0.2])
    assert eclipses(time, visible) == [(0.0, 5.0), (6.0, 7.0)]
    assert eclipses(time, np.ones(8)) == []


def test_telling_frames_are_denser_where_temperatures_change(monkeypatch):
    class Made(dict):
        def names(self, group):
            return ["a.outer"]

    time = np.linspace(0.0, 100.0, 101)
    T = np.where(time < 50.0, 0.0, np.where(time < 60.0, 10.0 * (time - 50.0), 100.0))
    made = Made({"frames/time": time, "skins/a.outer/temperature": T[:, None]})
    frames = telling_frames(made, 9)
    assert frames[0] == 0 and frames[-1] == 100 and len(frames) <= 10
    assert sum(50 <= f <= 60 for f in frames) >= 4
    still = Made({"frames/time": time, "skins/a.outer/temperature": np.zeros((101, 1))})
    assert telling_frames(still, 5) == [0, 25, 50, 75, 100]


def test_the_lit_side_is_looked_at():
    points = tube_corners(np.linspace([0, 0, 0], [0, 9, 0], 5), 0.1)
    for sun in (np.array([1.0, 0.0, 0.0]), np.array([-0.6, 0.0, -0.8]), np.array([0.0, 0.6, 0.8])):
        camera = looking(points, Sun(sun, np.zeros(3), 1.0))
        assert_allclose(camera.basis @ camera.basis.T, np.eye(3), atol=1e-12)
        assert np.linalg.det(camera.basis) == pytest.approx(1.0)
        assert camera.project(sun)[2] > 0.4
        assert np.ptp(camera.project(points.reshape(-1, 3))[:, 0]) > 8.0
    end_on = looking(points, Sun(np.array([0.0, 1.0, 0.0]), np.zeros(3), 1.0))
    assert_allclose(end_on.basis, plain_camera(points).basis)


def plain_camera(points):
    from coupling.painting import camera_for

    return camera_for(points.reshape(-1, 3))


# ------------------------------------------------------------------------------------- solids

BOX = """
[body.mass]
kind = "particle"
position = [0, 0, 0]
mass = 1.0
[thermal]
solver = "solid"
initial = "20 degC"
[thermal.solid.box]
box = { size = [0.2, 0.3, 0.4], elements = [2, 2, 2] }
material = "al6061"
[thermal.environment]
sun = { direction = [0.3, -0.8, 0.52] }
[thermal.surface.box]
solid = "box"
absorptivity = 0.6
emissivity = 0.8
[output]
frames = 2
skins = ["box"]
export = []
"""


def test_a_solid_in_the_sun_has_a_skin_and_a_picture(tmp_path):
    from matplotlib.figure import Figure

    text = '[time]\nend = "2 s"\nwindow = "1 s"\n' + BOX
    outcome = run(casefile.from_text(text, ROOT), tmp_path)
    assert outcome.code == 0, outcome.reason
    with Results.open(outcome.folder) as found:
        (name,) = found.names("skins")
        corners, light = (found[f"skins/{name}/{k}"][0] for k in ("corners", "light"))
        assert skin_pictures.map_rows(found) == 0
        pictures = {picture.name: picture for picture in _pictures(found)}
        assert {"light", "solid_temperature"} <= pictures.keys()
        figure = Figure(figsize=(12.8, 7.2))
        pictures["solid_temperature"].draw(found, figure)
        assert any("temperature" in text.get_text() for text in figure.texts)
    normal = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    assert_allclose(light, 0.6 * FLUX * np.maximum(0.0, normal @ SUN), atol=1e-6)
    assert area(corners).sum() == pytest.approx(2.0 * (0.06 + 0.08 + 0.12))
