"""Pictures of a run: which ones are drawn, that they can be read, and what their numbers mean."""

import itertools
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import synthetic
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from coupling.contact_maps import _touch
from coupling.contact_pictures import direction_name, flat_orbit, regime_shares
from coupling.overview import enlargement
from coupling.painting import Camera, camera_for, colouring_of, paint
from coupling.pictures import scaled
from coupling.plot import STYLE, _pictures, plot
from coupling.results import BadResults, Recorder, Results
from coupling.surfaces import Body, Surface
from coupling.turning import Drive, chord_angle, departure, find_drive, outermost_probe, turned

EVERYTHING = ["overview", "temperature", "motion", "orbit", "contact", "energy", "steps"]


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("run")
    return synthetic.arm_run(folder, frames=12, windows=60, rows=3000)


def names(written: list[Path]) -> list[str]:
    return [path.stem for path in written]


# ------------------------------------------------------------------------ which and whether


def test_a_run_with_everything_gets_every_picture(run: Path) -> None:
    from matplotlib.image import imread

    written = plot(run)
    assert names(written) == EVERYTHING
    for path in written:
        assert path.parent == run.parent / "pictures" and path.suffix == ".png"
        image = imread(path)
        assert image.shape[0] > 600 and image.shape[1] > 1000
        background = (np.abs(image - image[2, 2]).max(axis=2) < 0.02).mean()
        assert 0.05 < background < 0.995


def test_what_was_not_recorded_is_not_drawn(tmp_path: Path) -> None:
    (tmp_path / "cold").mkdir()
    cold = synthetic.arm_run(tmp_path / "cold", frames=3, windows=5, rows=100, heat=False)
    assert names(plot(cold)) == [name for name in EVERYTHING if name != "temperature"]
    (tmp_path / "stiff").mkdir()
    stiff = synthetic.arm_run(tmp_path / "stiff", frames=3, windows=5, hinge=False)
    assert names(plot(stiff)) == ["overview", "temperature", "motion", "energy", "steps"]
    (tmp_path / "short").mkdir()
    short = synthetic.arm_run(tmp_path / "short", frames=1, windows=1, rows=20)
    assert names(plot(short)) == ["overview", "orbit", "contact"]


def test_a_swinging_particle_is_drawn(tmp_path: Path) -> None:
    recorder = Recorder(tmp_path, {"title": "Pendulum"})
    for t in np.linspace(0.0, 2.0, 21):
        position = [np.sin(t), 0.0, -np.cos(t)]
        recorder.append("frames", {"time": t})
        recorder.append("windows", {"time": t})
        recorder.append("bodies/ball", {"position": [position]})
        recorder.append("probes/ball", {"time": t, "position": position})
    recorder.describe_group("bodies/ball", {"section_kind": "point"})
    recorder.close("done")
    assert names(plot(tmp_path)) == ["overview", "motion"]


def test_several_joints_get_pictures_of_their_own_the_most_loaded_first(tmp_path: Path) -> None:
    recorder = Recorder(tmp_path, {"title": "Chain"})
    time = np.linspace(0.0, 1.0, 30)
    for k in range(8):
        rows = {"time": time, "orbit": np.outer(time, [1e-5, 0]), "clearance": 0 * time + 1e-4}
        force = {"normal_force": k * time, "friction_force": 0 * time, "slip_speed": 0 * time}
        recorder.append_many(f"joints/h{k}", {**rows, **force, "regime": np.arange(30) % 4})
    recorder.close("done")
    expected = [f"{name}_h{k}" for k in (7, 6, 5, 4, 3, 2) for name in ("orbit", "contact")]
    with Results.open(tmp_path) as results:
        assert [picture.name for picture in _pictures(results)] == expected


def test_nothing_to_draw_is_said(tmp_path: Path) -> None:
    Recorder(tmp_path, {}).close("stopped", "nothing happened")
    with pytest.raises(BadResults, match="nothing was recorded that can be drawn"):
        plot(tmp_path)
    assert not (tmp_path / "pictures").exists()


def test_drawing_is_silent_and_needs_no_display(run: Path) -> None:
    code = "import sys; from coupling.plot import plot; plot(sys.argv[1])"
    found = subprocess.run(
        [sys.executable, "-W", "error", "-c", code, str(run)],
        capture_output=True,
        text=True,
        check=False,
        cwd=Path(__file__).parents[1],
        env={"PATH": "", "HOME": str(run.parent), "MPLCONFIGDIR": str(run.parent / "config")},
    )
    assert found.returncode == 0 and found.stdout == "" and "rror" not in found.stderr
    assert "arning" not in found.stderr


def test_joints_with_several_contacts_get_pictures_that_suit_them(tmp_path: Path) -> None:
    written = names(plot(synthetic.loose_run(tmp_path)))
    assert written[0] == "overview" and written[-1] == "regimes"
    assert sorted(written[1:-1]) == [
        "contact_guide", "contact_pin", "contact_socket", "map_tubes", "orbit_pin", "orbit_socket",
        "snapshot_tubes", "surfaces_tubes",
    ]  # fmt: skip


def test_an_orbit_in_space_is_seen_along_its_smallest_motion(tmp_path: Path) -> None:
    with Results.open(synthetic.loose_run(tmp_path)) as results:
        table, seen = flat_orbit(results, "socket")
        recorded = results["joints/socket/orbit"]
    assert seen == ["along y ", "along z "]
    assert_allclose(table["orbit"], recorded[:, 1:])
    assert_allclose(table["distance"] - table["clearance"], table["penetration"], atol=1e-17)


def test_a_map_tells_places_and_directions_of_contact(tmp_path: Path) -> None:
    """Station k is at 0.4 + 0.3 t + 0.1 k along the outer tube, 3 t + k around it, from y to z."""
    with Results.open(synthetic.loose_run(tmp_path)) as results:
        touch = _touch(results, "tubes.node_05", 5, True)
        mouth = _touch(results, "tubes.mouth", 12, True)
    assert_allclose(touch.place, 0.9 + 0.3 * touch.time)
    turned_by = np.radians(touch.angle) - (3.0 * touch.time + 5.0)
    assert_allclose(np.cos(turned_by), 1.0)
    assert np.all(touch.force > 0.0) and set(np.unique(touch.regime)) <= {1, 2, 3}
    assert_allclose(mouth.place, synthetic.OUTER)


# -------------------------------------------------------------------------------- legibility


@pytest.fixture(scope="module")
def wide_run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A short window, whose displacements have to be enlarged, under a long title."""
    folder = tmp_path_factory.mktemp("wide")
    title = "Main arm of the antenna, first quarter, mean winter sun, clearance widened (variant 3)"
    return synthetic.arm_run(
        folder, duration=10.0, angle=3e-4, frames=9, windows=60, rows=3000, title=title
    )


def drawn_figures(path: Path) -> Iterator[tuple[str, Any]]:
    import matplotlib
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    with Results.open(path) as results, matplotlib.rc_context(STYLE):
        for picture in _pictures(results):
            figure = Figure(figsize=picture.size, dpi=100, layout="constrained")
            picture.draw(results, figure)
            FigureCanvasAgg(figure).draw()
            yield picture.name, figure


def texts(figure: Any) -> list[tuple[str, Any]]:
    """Titles, labels and legends with their boxes; ticks of one axis do not meet by design."""
    from matplotlib.axis import Axis
    from matplotlib.text import Text

    ticks = {
        text
        for axis in figure.findobj(Axis)
        for text in (*axis.get_ticklabels(which="both"), axis.offsetText)
    }
    shown = [t for t in figure.findobj(Text) if t.get_visible() and t.get_text().strip()]
    return [(t.get_text(), t.get_window_extent()) for t in shown if t not in ticks]


@pytest.fixture(scope="module")
def loose_run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return synthetic.loose_run(tmp_path_factory.mktemp("loose"))


@pytest.mark.parametrize("which", ["run", "wide_run", "loose_run"])
def test_no_text_is_cut_off_or_meets_another(which: str, request: pytest.FixtureRequest) -> None:
    found = []
    for name, figure in drawn_figures(request.getfixturevalue(which)):
        page = figure.bbox
        boxes = texts(figure)
        assert len(boxes) > 3
        for text, box in boxes:
            if box.x0 < page.x0 or box.y0 < page.y0 or box.x1 > page.x1 or box.y1 > page.y1:
                found.append(f"{name}: {text!r} is cut off")
        for (a, box_a), (b, box_b) in itertools.combinations(boxes, 2):
            if box_a.shrunk(0.98, 0.9).overlaps(box_b.shrunk(0.98, 0.9)):
                found.append(f"{name}: {a!r} meets {b!r}")
    assert found == [], found


def test_every_axis_of_the_plane_pictures_has_its_unit(run: Path) -> None:
    for name, figure in drawn_figures(run):
        if name == "overview":
            continue
        labelled = [ax for ax in figure.axes if ax.yaxis.get_visible() and len(ax.get_yticks())]
        bare = [
            f"{name}: {ax.get_title(loc='left')}"
            for ax in labelled
            if "[" not in ax.get_ylabel()
            and not any(word in ax.get_title(loc="left") for word in ("per window", "per step"))
            and ax.get_subplotspec() is not None
            and ax.get_subplotspec().is_first_col()
        ]
        assert bare == []


@pytest.mark.parametrize(
    ("largest", "factor", "unit"),
    [(5e-5, 1e6, "µm"), (0.25, 1e3, "mm"), (1.0, 1.0, "m"), (2300.0, 1e-3, "km"), (0.0, 1.0, "m")],
)
def test_units_get_a_prefix_that_fits(largest: float, factor: float, unit: str) -> None:
    found, name = scaled(np.array([-largest, 0.0, np.nan]), "m")
    assert_allclose(found, factor)
    assert name == unit


# ------------------------------------------------------------------------------- what is shown


def test_shares_of_time_are_those_of_the_regimes() -> None:
    """Steps of unequal length; a row tells the regime of the step that ends at its time."""
    time = np.array([0.0, 1.0, 1.5, 3.5, 4.0])
    regime = np.array([0, 0, 2, 3, 1])
    assert_allclose(regime_shares(time, regime, np.array([0.0, 4.0])), [[0.25, 0.125, 0.125, 0.5]])
    halves = regime_shares(time, regime, np.array([0.0, 2.0, 4.0]))
    assert_allclose(halves, [[0.5, 0.0, 0.25, 0.25], [0.0, 0.25, 0.0, 0.75]])


@pytest.mark.parametrize(
    ("direction", "name"),
    [([0, 1, 0], "y"), ([-1, 1e-17, 0], "-x"), ([0.6, 0, -0.8], "(0.6, 0, -0.8)")],
)
def test_directions_of_an_orbit_are_named(direction: list[float], name: str) -> None:
    assert direction_name(np.array(direction)) == name


def test_turning_agrees_with_scipy() -> None:
    random = np.random.default_rng(4)
    vectors, angles = random.standard_normal((20, 3)), random.uniform(-4, 4, 20)
    axis = np.array([2.0, -1.0, 2.0]) / 3.0
    expected = Rotation.from_rotvec(angles[:, None] * axis).apply(vectors)
    assert_allclose(turned(vectors, axis, angles), expected, atol=1e-14)


def turning_drive() -> Drive:
    time = np.linspace(0.0, 10.0, 101)
    return Drive("hinge", time, 0.2 + 0.15 * time, np.eye(3)[2], np.array([1.0, 2.0, 0.0]), "arm")


def test_a_rigid_turn_departs_nowhere() -> None:
    drive = turning_drive()
    time = np.linspace(0.0, 10.0, 40)
    rotation = Rotation.from_rotvec(np.outer(drive.demanded(time), drive.axis))
    position = drive.position + rotation.apply([3.0, 0.5, 2.0])
    assert_allclose(departure(time, position, drive), 0.0, atol=1e-13)


def test_departure_is_told_in_the_directions_of_the_turn() -> None:
    drive = turning_drive()
    time = np.linspace(0.0, 10.0, 40)
    rotation = Rotation.from_rotvec(np.outer(drive.demanded(time), drive.axis))
    away = np.column_stack([0.01 * time, -0.02 * time, 0.03 * time])
    position = drive.position + rotation.apply(np.array([3.0, 0.0, 2.0]) + away)
    assert_allclose(departure(time, position, drive), away, atol=1e-13)


def test_angle_of_the_chord_counts_turns_and_ignores_what_leaves_the_plane() -> None:
    angles = np.linspace(0.0, 9.0, 60)
    start = np.array([[1.0, 1.0, 0.0], [4.0, 1.5, 0.7]])
    rotation = Rotation.from_rotvec(np.outer(angles, [0, 0, 1]))
    position = np.stack([rotation.apply(point) for point in start], axis=1)
    position[:, 1, 2] += 0.1 * angles
    assert_allclose(chord_angle(position, np.eye(3)[2]), angles, atol=1e-12)


def test_the_drive_of_a_run_is_found(run: Path, tmp_path: Path) -> None:
    with Results.open(run) as results:
        drive = find_drive(results)
        assert drive is not None and (drive.joint, drive.body) == ("hinge", "arm")
        assert_allclose(drive.demanded(np.array([0.0, 567.0])), [0.0, np.radians(45.36)])
        assert outermost_probe(results, drive) == "tip"
    with Results.open(synthetic.arm_run(tmp_path, frames=2, windows=2, hinge=False)) as results:
        assert find_drive(results) is None


# ---------------------------------------------------------------------------------- painting


def flat_surface(z: float, upwards: bool) -> Surface:
    """A unit square at height z whose temperature is its height."""
    points = np.array([[0.0, 0, z], [1, 0, z], [1, 1, z], [0, 1, z]])
    quads = np.array([[0, 1, 2, 3]] if upwards else [[3, 2, 1, 0]])
    return Surface(points, quads, 0 * points, np.full(4, 300.0 + z), np.full(4, np.nan))


def test_the_camera_keeps_lengths_and_has_z_upwards() -> None:
    random = np.random.default_rng(0)
    for scale in ([10, 5, 1], [1, 5, 10], [5, 0, 0], [0, 0, 0]):
        camera = camera_for(random.standard_normal((30, 3)) * scale)
        assert_allclose(camera.basis @ camera.basis.T, np.eye(3), atol=1e-12)
        assert_allclose(np.linalg.det(camera.basis), 1.0)
        assert camera.basis[1, 2] > -1e-12
    points = random.standard_normal((500, 3)) * [10, 5, 1]
    assert_allclose(np.abs(camera_for(points).basis[0]), [1, 0, 0], atol=0.1)


def test_near_quads_are_painted_last_and_those_turned_away_not_at_all() -> None:
    from matplotlib.figure import Figure

    ax = Figure().add_subplot()
    heights = (2.0, -1.0, 5.0, 0.5)
    surfaces = [flat_surface(z, upwards=z != 5.0) for z in heights]
    colouring = colouring_of(surfaces)
    assert colouring is not None and colouring.label == "temperature [°C]"
    assert_allclose([colouring.lower, colouring.upper], [25.85, 31.85])
    paint(ax, Camera(np.eye(3)), surfaces, colouring)
    (collection,) = ax.collections
    brightness = collection.get_facecolors()[:, :3].sum(axis=1)
    assert len(brightness) == 3
    assert (np.diff(brightness) > 0).all()  # the palette brightens with temperature, thus height


def test_colours_show_stress_when_there_is_no_temperature() -> None:
    cold = flat_surface(0.0, upwards=True)
    stressed = cold._replace(stress=np.array([-2e6, 0, 1e6, 3e6]))
    colouring = colouring_of([cold, stressed])
    assert colouring is not None
    assert (colouring.field, colouring.label) == ("stress", "axial stress [MPa]")
    assert_allclose([colouring.lower, colouring.upper], [-2.0, 3.0])
    assert colouring_of([cold]) is None


@pytest.mark.parametrize(
    ("travel", "expected"), [(0.0, 1.0), (5.0, 1.0), (1.0, 20.0), (0.1, 200.0), (3e-5, 1e6)]
)
def test_small_displacements_are_enlarged_by_a_round_factor(travel: float, expected: float) -> None:
    """A line of 100 m whose end moves sideways."""
    position = np.zeros((2, 2, 3))
    position[:, 1, 0] = 100.0
    position[1, 1, 1] = travel
    body = Body("arm", position, np.zeros((2, 2, 3, 3)), None, None, synthetic.TUBE)
    assert enlargement([body], [0, 1]) == expected
