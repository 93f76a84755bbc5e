"""Surfaces of the bodies and the files for ParaView."""

import subprocess
import sys
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
import synthetic
from numpy.testing import assert_allclose, assert_array_equal

from coupling.export import export
from coupling.results import BadResults, Recorder, Results
from coupling.surfaces import AROUND, Body, centre_line, read_bodies, surface
from meshes import generate, sections, solids, surfaces

TUBE = sections.tube(0.27, 0.002)


def body_on(
    position: np.ndarray, axes: np.ndarray, section: sections.Section = TUBE, **fields: np.ndarray
) -> Body:
    """A body with one frame."""
    known = {"temperature": None, "resultants": None}
    known |= {name: values[None] for name, values in fields.items()}
    return Body("arm", position[None], axes[None], section=section, **known)


def bent(curvature: float, length: float, elements: int) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and triads of a line along x that bends towards e2 = y."""
    radius = 1.0 / curvature
    return generate.arc([0, radius, 0], [0, 0, 0], [0, 0, 1], curvature * length, elements)


# ------------------------------------------------------------------------------- surfaces


def test_centre_line_goes_through_the_nodes_and_takes_their_triads() -> None:
    position, axes = bent(0.3, 5.0, 4)
    points, between = centre_line(position, axes, pieces=5)
    assert len(points) == 21
    assert_allclose(points[::5], position, atol=1e-15)
    assert_allclose(between[::5], axes, atol=1e-14)
    assert_allclose(
        between @ between.transpose(0, 2, 1), np.tile(np.eye(3), (21, 1, 1)), atol=1e-14
    )


def test_centre_line_of_a_bent_line_is_a_circle_to_high_order() -> None:
    def deviation(elements: int) -> float:
        points, _ = centre_line(*bent(1.0, 1.5, elements), pieces=200)
        return float(np.abs(points[:, 0] ** 2 + (points[:, 1] - 1.0) ** 2 - 1.0).max())

    errors = [deviation(n) for n in (1, 2, 4)]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert_allclose(orders, 6.0, atol=0.1)
    # error of the squared radius: 4/27 sin(angle/4)^6 / cos(angle/4)^2 (Goldapp 1991)
    assert_allclose(errors[0], 4 / 27 * np.sin(0.375) ** 6 / np.cos(0.375) ** 2, rtol=2e-4)


def test_a_thermal_bow_between_two_nodes_is_drawn_bent() -> None:
    """One element under a transverse gradient: deflection of the middle L^2 kappa / 8."""
    curvature, length = 23.1e-6 * 50.0, 63.5
    points, _ = centre_line(*bent(curvature, length, 1), pieces=2)
    sagitta = np.linalg.norm(points[1] - 0.5 * (points[0] + points[2]))
    exact = (1.0 - np.cos(0.5 * curvature * length)) / curvature
    assert_allclose(sagitta, exact, rtol=1e-12)


def test_a_line_without_sections_is_drawn_through_its_nodes() -> None:
    position = np.array([[0.0, 0, 0], [1, 0.2, 0], [2, 0, 0.4]])
    points, axes = centre_line(position, np.zeros((3, 3, 3)))
    assert_allclose(points[::4], position, atol=1e-15)
    assert_allclose(np.linalg.det(axes), 1.0)


@pytest.mark.parametrize("section", [TUBE, sections.circle(0.1), sections.rectangle(0.3, 0.1)])
def test_wall_temperature_is_the_linear_field(section: sections.Section) -> None:
    """The field a + b x + c y + d z on a straight body along x with e2 = z, e3 = -y."""
    position, axes = generate.line([0, 0, 0], [4, 0, 0], 3, [0, 0, 1])
    mean = 300.0 + 7.0 * position[:, 0]
    temperature = np.column_stack([mean, np.full(4, 40.0), np.full(4, -25.0)])
    found = surface(body_on(position, axes, section, temperature=temperature), 0)
    x, y, z = found.points.T
    assert_allclose(found.temperature, 300.0 + 7.0 * x + 25.0 * y + 40.0 * z, rtol=1e-14)
    assert np.isnan(found.stress).all()


@pytest.mark.parametrize("towards", [2, 3])
def test_axial_stress_has_the_size_and_sign_of_the_strain_of_the_fibres(towards: int) -> None:
    """Bend and stretch a bar: each fibre's change of length, seen on the surface, times E."""
    E, curvature, stretch, length, elements = 70e9, 2e-3, 3e-4, 8.0, 8
    section = sections.rectangle(0.4, 0.2)
    position, axes = bent(curvature, length * (1 + stretch), elements)
    if towards == 3:  # turn the section: what was e2 is now e3
        axes = np.stack([axes[:, 0], -axes[:, 2], axes[:, 1]], axis=1)
    moment = section.second_moment_2 if towards == 2 else section.second_moment_3
    resultants = np.zeros((elements, 6))
    resultants[:, 0] = E * section.area * stretch
    resultants[:, 2 + towards] = E * moment * curvature
    found = surface(body_on(position, axes, section, resultants=resultants), 0)
    fibres = found.points.reshape(-1, AROUND, 3)
    lengths = np.linalg.norm(np.diff(fibres, axis=0), axis=2).sum(axis=0)
    strain = lengths / length - 1.0
    assert np.ptp(strain) > 3e-4
    # chords instead of arcs, and 1 + stretch on the curvature term
    assert_allclose(found.stress.reshape(-1, AROUND)[0], E * strain, atol=2e-3 * E * np.ptp(strain))


def test_resultants_are_linear_along_the_body_and_beyond_the_last_middle() -> None:
    """A cantilever under a tip load: N from the weight of what hangs below is linear too."""
    position, axes = generate.line([0, 0, 0], [10, 0, 0], 5, [0, 1, 0])
    resultants = np.zeros((5, 6))
    resultants[:, 0] = 100.0 * (10.0 - np.arange(1.0, 10.0, 2.0))
    found = surface(body_on(position, axes, resultants=resultants), 0)
    x = found.points[:, 0]
    assert_allclose(found.stress, 100.0 * (10.0 - x) / TUBE.area, rtol=1e-12, atol=1e-6)
    one = surface(body_on(position[:2], axes[:2], resultants=resultants[:1]), 0)
    assert_allclose(one.stress, 900.0 / TUBE.area)


def test_quads_look_outwards() -> None:
    position, axes = bent(0.1, 5.0, 4)
    found = surface(body_on(position, axes), 0)
    a, b, c, d = (found.points[found.quads[:, k]] for k in range(4))
    normal = np.cross(c - a, d - b)
    middle = 0.25 * (a + b + c + d)
    line, _ = centre_line(position, axes)
    nearest = line[np.argmin(np.linalg.norm(middle[:, None] - line, axis=2), axis=1)]
    assert (np.sum(normal * (middle - nearest), axis=1) > 0).all()


# ---------------------------------------------------------------------------------- files


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("run")
    return synthetic.arm_run(folder, frames=5, windows=20, rows=2000)


@pytest.fixture(scope="module")
def exported(run: Path) -> list[Path]:
    return export(run)


def test_the_index_lists_every_frame_with_its_time(run: Path, exported: list[Path]) -> None:
    assert exported[0] == run.with_name("run.pvd") and len(exported) == 11
    entries = list(ElementTree.parse(exported[0]).iter("DataSet"))
    times = Results.open(run)["frames/time"]
    assert [float(e.attrib["timestep"]) for e in entries] == np.repeat(times, 2).tolist()
    assert [e.attrib["part"] for e in entries] == ["0", "1"] * 5
    listed = {exported[0].parent / e.attrib["file"] for e in entries}
    assert listed == set(exported[1:]) and all(path.is_file() for path in listed)


def test_surfaces_read_back_by_vtk(run: Path, exported: list[Path]) -> None:
    import pyvista

    grid = pyvista.read(exported[0].parent / "vtk/bodies_00004.vtu")
    with Results.open(run) as results:
        (arm,) = read_bodies(results)
    expected = surface(arm, 4)
    assert grid.n_cells == 16 * 4 * AROUND and set(grid.celltypes) == {9}
    assert_array_equal(grid.points, expected.points)
    assert_array_equal(grid.point_data["temperature"], expected.temperature)
    assert_array_equal(grid.point_data["axial_stress"], expected.stress)
    assert set(grid.cell_data["body"]) == {0}
    first = pyvista.read(exported[0].parent / "vtk/bodies_00000.vtu")
    assert_allclose(grid.point_data["displacement"], grid.points - first.points, atol=1e-12)
    # the wall is 0.271 m from the line through the nodes
    assert_allclose(np.linalg.norm(grid.points[:AROUND] - arm.position[4, 0], axis=1), 0.271)


def test_the_whole_series_opens_as_one(exported: list[Path]) -> None:
    import pyvista

    reader = pyvista.get_reader(exported[0])
    assert len(reader.time_values) == 5
    reader.set_active_time_value(reader.time_values[-1])
    blocks = reader.read()
    assert [block.n_points for block in blocks] == [65 * AROUND, 2]


def test_joints_show_gap_force_and_regime(run: Path, exported: list[Path]) -> None:
    import pyvista

    results = Results.open(run)
    times, hinge = results["frames/time"], results.table("joints/hinge")
    for frame in (0, 3):
        row = np.argmin(np.abs(hinge["time"] - times[frame]))
        cloud = pyvista.read(exported[0].parent / f"vtk/joints_{frame:05d}.vtu")
        assert_allclose(cloud.points[0], synthetic.ROOT)
        gap = cloud.points[1] - cloud.points[0]
        assert_allclose(gap, [*hinge["orbit"][row], 0.0], atol=1e-15)
        assert_allclose(cloud.point_data["gap"], [gap, gap], atol=1e-15)
        enlarged = np.linalg.norm(cloud.point_data["gap_enlarged"][0])
        assert_allclose(enlarged, 2 * 0.271 * np.linalg.norm(gap) / hinge["clearance"][row])
        assert cloud.point_data["regime"][0] == hinge["regime"][row]
        assert cloud.point_data["normal_force"][1] == hinge["normal_force"][row]


def test_the_plane_of_an_orbit_turns_with_the_bearing(tmp_path: Path) -> None:
    """The bearing sits on the end of a bar that turns by 90 degrees about z."""
    recorder = Recorder(tmp_path, {})
    position, axes = generate.line([0, 0, 0], [2, 0, 0], 1, [0, 1, 0])
    turned = np.array([[0.0, 1, 0], [-1, 0, 0], [0, 0, 1]])
    for time, R in ((0.0, np.eye(3)), (1.0, turned)):
        recorder.append("frames", {"time": time})
        recorder.append("bodies/bar", {"position": position @ R, "axes": axes @ R})
    recorder.describe_group("bodies/bar", {"section_kind": "tube", "height": 0.1, "width": 0.1})
    row = {"orbit": [[1e-4, 0.0]] * 2, "clearance": [1e-4] * 2, "regime": [2, 3]}
    recorder.append_many("joints/pin", {"time": [0.0, 1.0], **row})
    site = {"bearing_body": "bar", "bearing_node": 1, "journal_body": ""}
    recorder.describe_group("joints/pin", {"directions": np.eye(3)[:2], **site})
    recorder.close("done")
    import pyvista

    export(tmp_path)
    cloud = pyvista.read(tmp_path / "vtk/joints_00001.vtu")
    assert_allclose(cloud.points, [[0, 2, 0], [0, 2 + 1e-4, 0]], atol=1e-15)
    assert_array_equal(cloud.point_data["regime"], [3, 3])
    assert np.isnan(cloud.point_data["normal_force"]).all()


def test_contacts_in_space_are_where_their_bearings_carry_them(tmp_path: Path) -> None:
    import pyvista

    path = synthetic.loose_run(tmp_path)
    written = export(path)
    results = Results.open(path)
    names = results.names("joints")
    cloud = pyvista.read(next(p for p in written if p.name == "joints_00002.vtu"))
    bearing, journal = cloud.points[::2], cloud.points[1::2]
    force = cloud.point_data["contact_force"][::2]
    for k, name in enumerate(names):
        table = results.table(f"joints/{name}")
        row = np.argmin(np.abs(table["time"] - 0.5))
        at = {column: values[row] for column, values in table.items()}
        directions = results.attributes(f"joints/{name}")["directions"]
        path_ = np.atleast_1d(at.get("orbit", at.get("towards_wall")))
        assert_allclose(journal[k] - bearing[k], path_ @ directions, atol=1e-15)
        normal = path_ @ directions / np.linalg.norm(path_)
        assert_allclose(force[k] @ normal, at["friction_vector"] @ normal - at["normal_force"],
                        atol=1e-9)  # fmt: skip
        if name == "tubes.mouth":
            assert_allclose(bearing[k], [synthetic.OUTER, 0, 0])
        elif name.startswith("tubes"):
            assert_allclose(bearing[k], [at["place"], 0, 0])
        elif name.startswith("guide"):
            position = results.attributes(f"joints/{name}")["position"]
            assert_allclose(bearing[k], position + at["place"] * np.eye(3)[0])


def test_particles_are_points_and_bodies_are_numbered(tmp_path: Path) -> None:
    recorder = Recorder(tmp_path, {})
    position, axes = generate.line([0, 0, 0], [2, 0, 0], 2, [0, 1, 0])
    recorder.append("frames", {"time": 0.0})
    recorder.append("bodies/bar", {"position": position, "axes": axes})
    recorder.append("bodies/mass", {"position": [[5.0, 6.0, 7.0]]})
    recorder.append("bodies/rod", {"position": position + 1.0, "axes": axes})
    for name in ("bar", "rod"):
        attributes = {"section_kind": "rectangle", "height": 0.1, "width": 0.2}
        recorder.describe_group(f"bodies/{name}", attributes)
    recorder.close("done")
    import pyvista

    grid = pyvista.read(export(tmp_path)[1])
    bodies, kinds = grid.cell_data["body"], grid.celltypes
    assert_array_equal(np.unique(bodies[kinds == 9]), [0, 2])
    assert_array_equal(bodies[kinds == 1], [1])
    assert_array_equal(grid.extract_cells(kinds == 1).points, [[5, 6, 7]])
    rod = grid.extract_cells(bodies == 2).bounds
    assert_allclose([rod.x_min, rod.x_max, rod.y_min, rod.y_max], [1, 3, 0.95, 1.05])
    assert "temperature" not in grid.point_data and "axial_stress" not in grid.point_data


def test_a_second_export_leaves_no_files_of_the_first(tmp_path: Path) -> None:
    for frames in (4, 2):
        folder = tmp_path / str(frames)
        folder.mkdir()
        synthetic.arm_run(folder, frames=frames, windows=3, rows=50)
    export(tmp_path / "4")
    (tmp_path / "2/results.h5").replace(tmp_path / "4/results.h5")
    (tmp_path / "4/vtk/mine.vtu").touch()
    written = export(tmp_path / "4")
    assert len(written) == 5
    assert set((tmp_path / "4/vtk").iterdir()) == {*written[1:], tmp_path / "4/vtk/mine.vtu"}


def test_what_cannot_be_exported_is_refused(run: Path, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="format 'stl': expected one of pvd, vtkhdf"):
        export(run, format="stl")
    with pytest.raises(BadResults, match="no such file"):
        export(tmp_path)
    Recorder(tmp_path, {}).close("stopped", "nothing happened")
    with pytest.raises(BadResults, match="no frames of bodies were recorded"):
        export(tmp_path)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["results.h5"]


def test_exporting_needs_no_drawing_library(run: Path) -> None:
    code = (
        "import sys; from coupling.export import export; export(sys.argv[1]);"
        "print([m for m in ('pyvista', 'vtk', 'vtkmodules', 'matplotlib') if m in sys.modules])"
    )
    command = [sys.executable, "-c", code, str(run)]
    found = subprocess.run(
        command, capture_output=True, text=True, check=True, cwd=Path(__file__).parents[1]
    )
    assert found.stdout.strip() == "[]"


# --------------------------------------------------------------------------- all in one file


def read_by_vtk(file: Path) -> tuple[list[float], list[dict[str, Any]]]:
    """Times, and the blocks at each of them."""
    import pyvista
    from vtkmodules.vtkCommonDataModel import vtkCompositeDataSet
    from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline
    from vtkmodules.vtkIOHDF import vtkHDFReader

    reader, found = vtkHDFReader(), []
    reader.SetFileName(str(file))
    reader.UpdateInformation()
    times = reader.GetOutputInformation(0).Get(vtkStreamingDemandDrivenPipeline.TIME_STEPS())
    for step in range(reader.GetNumberOfSteps()):
        reader.SetStep(step)
        reader.Update()
        whole, blocks = reader.GetOutputDataObject(0), {}
        for k in range(whole.GetNumberOfPartitionedDataSets()):
            name = whole.GetMetaData(k).Get(vtkCompositeDataSet.NAME())
            copy = pyvista.UnstructuredGrid()
            copy.deep_copy(whole.GetPartition(k, 0))
            blocks[name] = copy
        found.append(blocks)
    return list(times), found


def assert_same_grid(ours: Any, theirs: Any) -> None:
    """Points, cells and fields, bit for bit; a field that one lacks is no number in the other."""
    assert_array_equal(ours.points, theirs.points)
    assert_array_equal(ours.cells, theirs.cells)
    assert_array_equal(ours.celltypes, theirs.celltypes)
    for a, b in ((ours.point_data, theirs.point_data), (ours.cell_data, theirs.cell_data)):
        assert set(b) <= set(a)
        for name in a:
            assert_array_equal(a[name], b[name] if name in b else np.full_like(a[name], np.nan))


def assert_same_series(results: Path, names: set[str]) -> None:
    import pyvista

    export(results)
    (file,) = export(results, "vtkhdf")
    assert file == results.with_name("run.vtkhdf")
    times, steps = read_by_vtk(file)
    assert times == Results.open(results)["frames/time"].tolist()
    for frame, blocks in enumerate(steps):
        assert set(blocks) == names
        for name, ours in blocks.items():
            assert_same_grid(ours, pyvista.read(file.parent / f"vtk/{name}_{frame:05d}.vtu"))


def test_one_file_holds_all_frames(tmp_path: Path) -> None:
    run = synthetic.arm_run(tmp_path, frames=5, windows=20, rows=2000)
    assert_same_series(run, {"bodies", "joints"})
    assert not run.with_name("run.vtkhdf.part").exists()


def test_one_file_holds_solids_skins_and_what_single_frames_lack(tmp_path: Path) -> None:
    """Cells of three families; light that no facet has at first."""
    rng, recorder = np.random.default_rng(2), Recorder(tmp_path, {})
    families = {"a": "hexahedron", "b": "hexahedron20", "c": "hexahedron27"}
    made = {name: solids.box((1, 1, 1), (2, 1, 1), 1, kind) for name, kind in families.items()}
    for frame in range(3):
        recorder.append("frames", {"time": 0.5 * frame})
        recorder.append("bodies/ball", {"position": rng.random((1, 3)), "axes": np.eye(3)[None]})
        for name, mesh in made.items():
            count, cells = len(mesh.points), len(mesh.cells[families[name]])
            recorder.append(f"solids/{name}", {
                "position": mesh.points + rng.random(3), "temperature": rng.random(count),
                "stress": rng.random(cells),
            })  # fmt: skip
        light = rng.random(5) if frame else np.full(5, np.nan)
        row = {"corners": rng.random((5, 4, 3)), "temperature": rng.random(5)}
        recorder.append("skins/lit", row | {"light": light})
        recorder.append("skins/dark", row)
    for name, mesh in made.items():
        recorder.append_many(f"cells/{name}", {"cells": mesh.cells[families[name]]})
    recorder.close("done")
    assert_same_series(recorder.path, {"bodies", "solids", "skins"})


def test_the_command_writes_one_file(tmp_path: Path) -> None:
    from typer.testing import CliRunner

    from coupling.cli import app

    synthetic.arm_run(tmp_path, frames=2, windows=3, rows=50)
    said = CliRunner().invoke(app, ["export", str(tmp_path), "--format", "vtkhdf"])
    assert said.exit_code == 0 and (tmp_path / "run.vtkhdf").is_file()


def test_filters_and_viewers_go_through_the_times(tmp_path: Path) -> None:
    """They ask for a time, as ParaView does, not for a step."""
    import pyvista
    from vtkmodules.vtkCommonTransforms import vtkTransform
    from vtkmodules.vtkFiltersGeneral import vtkTransformFilter
    from vtkmodules.vtkIOHDF import vtkHDFReader

    run = synthetic.arm_run(tmp_path, frames=4, windows=3, rows=50)
    export(run)
    (file,) = export(run, "vtkhdf")
    reader, moved = vtkHDFReader(), vtkTransformFilter()
    reader.SetFileName(str(file))
    moved.SetTransform(vtkTransform())
    moved.SetInputConnection(reader.GetOutputPort())
    for frame in (2, 0, 3):
        moved.UpdateTimeStep(float(Results.open(run)["frames/time"][frame]))
        ours = pyvista.wrap(moved.GetOutputDataObject(0).GetPartition(0, 0))
        theirs = pyvista.read(tmp_path / f"vtk/bodies_{frame:05d}.vtu")
        assert_array_equal(ours.points, theirs.points)


# ------------------------------------------------------------------- shells and rigid bodies


def shell_body(elements: tuple[int, int], smooth: bool = True) -> tuple[Body, surfaces.Surface]:
    """A quarter of a cylinder of radius 2 as recorded in one frame."""
    from coupling.surfaces import Patches

    made = surfaces.tube(2.0, 3.0, *elements, angle=(0.0, 0.5 * np.pi))
    slopes = np.stack([made.d_u, made.d_v, made.d_uv], axis=1)[None]
    patches = Patches(made.quads, made.sizes, slopes if smooth else None)
    nodes = len(made.points)
    temperature = np.column_stack([300.0 + made.points[:, 2], np.zeros((nodes, 2))])[None]
    resultants = np.arange(8.0 * len(made.quads)).reshape(1, -1, 8)
    body = Body(
        "s", made.points[None], np.zeros((1, nodes, 3, 3)), temperature, resultants, None, patches
    )
    return body, made


@pytest.mark.parametrize("smooth", [True, False])
def test_a_shell_is_drawn_between_its_nodes(smooth: bool) -> None:
    """Deviation from the cylinder: bicubic h^4/384 R^3, bilinear h^2/8 R (h: arc of an element)."""
    body, _ = shell_body((3, 2), smooth)
    found = surface(body, 0)
    off = np.abs(np.hypot(found.points[:, 0], found.points[:, 1]) - 2.0).max()
    h = 2.0 * 0.5 * np.pi / 3
    expected = h**4 / 384 / 2.0**3 if smooth else h**2 / 8 / 2.0
    assert off == pytest.approx(expected, rel=0.15)
    assert found.is_open


def test_quads_of_a_shell_cover_it_once_and_face_along_its_normal() -> None:
    body, _ = shell_body((3, 2))
    found = surface(body, 0)
    corners = found.points[found.quads]
    normal = 0.5 * np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    assert np.linalg.norm(normal, axis=1).sum() == pytest.approx(2.0 * 0.5 * np.pi * 3.0, rel=2e-3)
    outward = corners.mean(axis=1) * [1, 1, 0]
    assert (np.sum(normal * outward, axis=1) > 0.0).all()


def test_temperature_and_resultants_of_a_shell() -> None:
    body, made = shell_body((3, 2))
    found = surface(body, 0)
    assert_allclose(found.temperature, 300.0 + found.points[:, 2], atol=1e-12)
    per_element = found.resultants.reshape(len(made.quads), -1, 8)
    assert_allclose(per_element[:, 0], np.arange(8.0 * len(made.quads)).reshape(-1, 8))
    assert np.ptp(per_element, axis=1).max() == 0.0


def test_the_box_of_a_rigid_body_has_its_inertia() -> None:
    """A solid box of given edges, turned: its inertia by the textbook gives the edges back."""
    from coupling.surfaces import box_of

    mass, edges = 3.0, np.array([0.4, 1.0, 2.5])
    squares = edges**2
    principal = mass / 12.0 * (squares.sum() - squares)
    turn = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    rows = box_of(mass, turn @ np.diag(principal) @ turn.T)
    assert_allclose(sorted(2.0 * np.linalg.norm(rows, axis=1)), edges, rtol=1e-12)
    along = rows / np.linalg.norm(rows, axis=1, keepdims=True)
    assert_allclose(np.abs(along @ turn).max(axis=1), 1.0, rtol=1e-12)


def test_a_rigid_body_is_drawn_as_a_box_seen_from_outside() -> None:
    axes = np.array([[[[0.0, 1, 0], [-1, 0, 0], [0, 0, 1]]]])
    body = Body("r", np.array([[[5.0, 0, 0]]]), axes, None, None, None, None, np.diag([1.0, 2, 3]))
    found = surface(body, 0)
    # e1 of the body points along y
    assert_allclose(np.ptp(found.points, axis=0), [4, 2, 6], atol=1e-12)
    corners = found.points[found.quads]
    normal = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    assert (np.sum(normal * (corners.mean(axis=1) - [5, 0, 0]), axis=1) > 0.0).all()
