"""Lines, triads and swept surfaces against geometry; mesh files, good and bad."""

import subprocess
import sys
from math import inf, nan, pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshes.generate import arc, frames, line, resample, sweep
from meshes.io import read, read_line, write
from meshes.mesh import Mesh
from meshes.sections import rectangle, tube

# --- lines and triads ---------------------------------------------------------------------------


def is_right_handed_triads(axes):
    identity = axes @ np.swapaxes(axes, 1, 2)
    return np.allclose(identity, np.eye(3), atol=1e-12) and np.allclose(np.linalg.det(axes), 1.0)


def test_line_has_equal_elements_and_exact_ends():
    points, axes = line((0.1, 0.2, 0.3), (0.4, -0.7, 2.0), 7)
    assert points.shape == (8, 3)
    assert axes.shape == (8, 3, 3)
    assert points[0].tolist() == [0.1, 0.2, 0.3]
    assert points[-1].tolist() == [0.4, -0.7, 2.0]
    steps = np.diff(points, axis=0)
    assert steps == pytest.approx(np.broadcast_to(steps[0], steps.shape))
    assert axes[:, 0] == pytest.approx(np.broadcast_to(steps[0], (8, 3)) / np.linalg.norm(steps[0]))
    assert is_right_handed_triads(axes)


def test_line_along_x_has_the_global_axes():
    _, axes = line((0, 0, 0), (63.5, 0, 0), 16)
    assert axes == pytest.approx(np.broadcast_to(np.eye(3), (17, 3, 3)))


def test_given_normal_is_projected():
    _, axes = line((0, 0, 0), (2, 0, 0), 1, normal=(5.0, 0.0, -3.0))
    assert axes[0] == pytest.approx(np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]]))


@given(st.tuples(*[st.floats(-1.0, 1.0)] * 3), st.tuples(*[st.floats(-1.0, 1.0)] * 3))
def test_default_triads_are_right_handed_in_every_direction(start, end):
    if np.linalg.norm(np.subtract(end, start)) > 1e-6:
        assert is_right_handed_triads(line(start, end, 2)[1])


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (((0, 0, 0), (0, 0, 0), 3), "coincide"),
        (((0, 0, 0), (1, 0, nan), 3), "end must be three finite numbers"),
        (((0, 0), (1, 0, 0), 3), "start must be three finite numbers"),
        (((0, 0, 0), (1, 0, 0), 0), "elements must be a positive integer"),
        (((0, 0, 0), (1, 0, 0), 2.5), "elements must be a positive integer"),
        (((0, 0, 0), (1, 0, 0), True), "elements must be a positive integer"),
        (((0, 0, 0), (1, 0, 0), nan), "elements must be a positive integer"),
        (((0, 0, 0), (1, 0, 0), 3, (2, 0, 0)), "normal is parallel"),
        (((0, 0, 0), (1, 0, 0), 3, (0, 0, 0)), "normal must not be zero"),
    ],
)
def test_impossible_lines(arguments, words):
    with pytest.raises(ValueError, match=words):
        line(*arguments)


@pytest.mark.parametrize("angle", [pi / 2, -pi / 3, 2 * pi])
def test_arc_lies_on_its_circle(angle):
    center, axis = np.array([1.0, 2.0, 3.0]), np.array([0.0, 0.0, 2.0])
    points, axes = arc(center, (3.0, 2.0, 4.0), axis, angle, 12)
    assert np.linalg.norm((points - center)[:, :2], axis=1) == pytest.approx(2.0)
    assert points[:, 2] == pytest.approx(4.0)
    end = [1.0 + 2.0 * np.cos(angle), 2.0 + 2.0 * np.sin(angle), 4.0]
    assert points[-1] == pytest.approx(end, abs=1e-12)
    assert is_right_handed_triads(axes)
    inwards = (center - points) * [1, 1, 0] / 2.0
    assert axes[:, 1] == pytest.approx(inwards)
    assert axes[:, 2] == pytest.approx(np.broadcast_to([0, 0, np.sign(angle)], (13, 3)))
    chords = np.diff(points, axis=0)
    assert (np.sum(chords * axes[:-1, 0], axis=1) > 0).all()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (((0, 0, 0), (0, 0, 1), (0, 0, 1), 1.0, 3), "start, seen from the axis"),
        (((0, 0, 0), (1, 0, 0), (0, 0, 0), 1.0, 3), "axis must not be zero"),
        (((0, 0, 0), (1, 0, 0), (0, 0, 1), 0.0, 3), "angle"),
        (((0, 0, 0), (1, 0, 0), (0, 0, 1), 7.0, 3), "angle"),
        (((0, 0, 0), (1, 0, 0), (0, 0, 1), nan, 3), "angle"),
        (((0, 0, 0), (1, 0, 0), (0, 0, 1), 1.0, -1), "elements"),
    ],
)
def test_impossible_arcs(arguments, words):
    with pytest.raises(ValueError, match=words):
        arc(*arguments)


def test_resampling_is_equal_in_arclength():
    bent = [[0, 0, 0], [1, 0, 0], [1, 2, 0], [1, 2, 1]]
    points = resample(bent, 8)
    assert points[[0, 2, 6, 8]] == pytest.approx(np.array(bent), abs=1e-12)
    assert np.linalg.norm(np.diff(points, axis=0), axis=1) == pytest.approx(0.5)


def test_resampling_a_circle_keeps_its_length():
    points = resample(arc((0, 0, 0), (1, 0, 0), (0, 0, 1), pi, 400)[0], 100)
    length = np.linalg.norm(np.diff(points, axis=0), axis=1).sum()
    assert length == pytest.approx(pi, rel=1e-4)


def test_frames_of_a_polyline_bisect_its_corners():
    axes = frames([[0, 0, 0], [1, 0, 0], [1, 1, 0]])
    half = np.sqrt(0.5)
    assert axes[1, 0] == pytest.approx([half, half, 0])
    assert is_right_handed_triads(axes)


def test_frames_of_a_helix_do_not_twist():
    """Bishop frame: relative to Frenet's it turns by minus the integral of the torsion."""
    t = np.linspace(0.0, 4 * pi, 2001)
    helix = np.column_stack([np.cos(t), np.sin(t), 0.5 * t])
    axes = frames(helix)
    speed = np.hypot(1.0, 0.5)
    frenet = np.column_stack([-np.cos(t), -np.sin(t), 0 * t])
    binormal = np.cross(axes[:, 0], frenet)
    angle = np.unwrap(np.arctan2(np.sum(axes[:, 1] * binormal, 1), np.sum(axes[:, 1] * frenet, 1)))
    torsion = 0.5 / speed**2
    assert is_right_handed_triads(axes)
    assert angle[-1] - angle[0] == pytest.approx(-torsion * 4 * pi * speed, rel=1e-3)


def test_frames_with_a_normal_project_it_at_each_point():
    points, expected = arc((0, 0, 0), (1, 0, 0), (0, 0, 1), pi / 2, 200)
    axes = frames(points, normal=(0, 0, 1))
    assert axes[:, 1] == pytest.approx(np.broadcast_to([0, 0, 1], (201, 3)))
    assert axes[:, 0] == pytest.approx(expected[:, 0], abs=0.005)


@pytest.mark.parametrize(
    ("points", "words"),
    [
        ([[0, 0, 0]], "two or more points"),
        ([[0, 0], [1, 1]], "points in space"),
        ([[0, 0, 0], [inf, 0, 0]], "finite"),
        ([[0, 0, 0], [1, 0, 0], [1, 0, 0]], "points 1 and 2 of the line coincide"),
        ([[0, 0, 0], [1, 0, 0], [0, 0, 0]], "turns back on itself at point 1"),
    ],
)
def test_impossible_polylines(points, words):
    with pytest.raises(ValueError, match=words):
        frames(points)


# --- swept surfaces -----------------------------------------------------------------------------


def flux_of_position(points, quads):
    """Integral of x . n / 3 over the surface, from its quadrilaterals as triangle pairs."""
    a, b, c, d = (points[quads[:, k]] for k in range(4))
    pairs = np.sum(a * np.cross(b, c), 1) + np.sum(a * np.cross(c, d), 1)
    return pairs.sum() / 6.0


@pytest.mark.parametrize("section", [tube(0.27, 0.002), rectangle(0.4, 0.2)])
def test_swept_surface_encloses_its_volume_outwards(section):
    """Divergence theorem; the two end faces add length * area / 3 of flux."""
    points, axes = line((0, 0, 0), (3, 0, 0), 5)
    outline = section.outline(24)
    surface, quads = sweep(points, axes, outline)
    assert surface.shape == (6 * 24, 3)
    assert quads.shape == (5 * 24, 4)
    y, z = outline.T
    area = 0.5 * np.sum(y * np.roll(z, -1) - z * np.roll(y, -1))
    assert flux_of_position(surface, quads) + 3 * area / 3 == pytest.approx(3 * area)


def test_swept_points_follow_station_and_angle():
    points, axes = line((0, 0, 0), (0, 2, 0), 2, normal=(0, 0, 1))
    surface, _ = sweep(points, axes, tube(1.0, 0.5).outline(4))
    second = surface.reshape(3, 4, 3)[1]
    assert second == pytest.approx(
        np.array([[0, 1, 1.25], [1.25, 1, 0], [0, 1, -1.25], [-1.25, 1, 0]]), abs=1e-12
    )


def test_swept_surface_closes_around():
    points, axes = line((0, 0, 0), (1, 0, 0), 3)
    _, quads = sweep(points, axes, tube(0.1, 0.01).outline(6))
    edges = np.sort(np.vstack([quads[:, [k, (k + 1) % 4]] for k in range(4)]), axis=1)
    counts = np.unique(edges, axis=0, return_counts=True)[1]
    assert (counts == 1).sum() == 2 * 6  # only the two open ends have free edges
    assert set(counts.tolist()) == {1, 2}


# --- meshes and files ---------------------------------------------------------------------------

NODES = np.array([[2.0, 0, 0], [0, 0, 0], [3, 0, 0.5], [1, 0, 0], [9, 9, 9], [9, 9, 8]])
BOOM = [[3, 1], [0, 3], [0, 2]]


def scrambled(regions=None, extra=()):
    return Mesh(NODES, {"line": np.array([*BOOM, *extra])}, regions or {})


@pytest.mark.parametrize("ending", ["vtu", "vtk", "inp", "msh", "xdmf"])
def test_line_is_put_in_order(tmp_path, ending):
    write(tmp_path / f"line.{ending}", scrambled())
    points = read_line(tmp_path / f"line.{ending}")
    assert points == pytest.approx(NODES[[1, 3, 0, 2]])


@pytest.mark.parametrize("ending", ["inp", "msh"])
def test_region_is_one_line_among_others(tmp_path, ending):
    path = tmp_path / f"line.{ending}"
    regions = {
        "boom": ("line", np.array([0, 1, 2])),
        "strut": ("line", np.array([3])),
        "face": ("triangle", np.array([0])),
    }
    cells = {"line": np.array([*BOOM, [4, 5]]), "triangle": np.array([[0, 1, 4]])}
    write(path, Mesh(NODES, cells, regions))
    back = read(path)
    assert {name: (f, i.tolist()) for name, (f, i) in back.regions.items()} == {
        name: (f, i.tolist()) for name, (f, i) in regions.items()
    }
    assert read_line(path, "boom") == pytest.approx(NODES[[1, 3, 0, 2]])
    assert read_line(path, "strut") == pytest.approx(NODES[[4, 5]])
    with pytest.raises(ValueError, match=r"several pieces: from node 1 at .* only 4 of 6 nodes"):
        read_line(path)
    with pytest.raises(ValueError, match="'face' consists of triangle cells"):
        read_line(path, "face")
    with pytest.raises(ValueError, match="no region 'mast'; its regions are: 'boom', 'strut'"):
        read_line(path, "mast")


GMSH_41 = """$MeshFormat
4.1 0 8
$EndMeshFormat
$PhysicalNames
1
1 7 "boom"
$EndPhysicalNames
$Entities
3 2 0 0
1 0 0 0 0
2 1 0 0 0
3 2 1 0 0
1 0 0 0 1 0 0 1 7 2 1 -2
2 1 0 0 2 1 0 1 7 2 2 -3
$EndEntities
$Nodes
3 3 1 3
0 1 0 1
1
0 0 0
0 2 0 1
2
1 0 0
0 3 0 1
3
2 1 0
$EndNodes
$Elements
2 2 1 2
1 1 1 1
1 1 2
1 2 1 1
2 2 3
$EndElements
"""


def test_gmsh_region_of_two_curves(tmp_path):
    path = tmp_path / "boom.msh"
    path.write_text(GMSH_41)
    assert read(path).regions["boom"][1].tolist() == [0, 1]
    assert read_line(path, "boom") == pytest.approx(np.array([[0, 0, 0], [1, 0, 0], [2, 1, 0]]))


@pytest.mark.parametrize(
    ("points", "cells", "words"),
    [
        (NODES, {"triangle": np.array([[0, 1, 2]])}, "no line cells, only triangle"),
        (NODES, {"line": np.array([*BOOM, [3, 4]])}, r"branches at node 3 at \(1, 0, 0\)"),
        (NODES, {"line": np.array([[0, 2], [2, 4], [4, 0]])}, "closed: it has no ends"),
        (NODES, {"line": np.array([*BOOM, [4, 5]])}, "several pieces"),
        (NODES, {"line": np.array([[0, 1], [2, 4], [4, 5], [5, 2]])}, "several pieces"),
        (NODES * [1, 0, 0], {"line": np.array([*BOOM, [2, 4], [4, 5]])}, "nodes 4 and 5 coincide"),
        (NODES, {"line": np.array([*BOOM, [2, 2]])}, "node 2 is joined to itself"),
        (NODES, {"line": np.array([*BOOM, [0, 3]])}, "nodes 0 and 3 are joined twice"),
    ],
)
def test_cells_that_are_not_one_open_line(tmp_path, points, cells, words):
    path = tmp_path / "line.vtu"
    write(path, Mesh(points, cells))
    with pytest.raises(ValueError, match=rf"line\.vtu: .*{words}"):
        read_line(path)


def test_coordinates_must_be_finite(tmp_path):
    path = tmp_path / "line.vtk"
    write(path, scrambled())
    text = path.read_bytes().replace(np.array(9.0, ">f8").tobytes(), np.array(nan, ">f8").tobytes())
    path.write_bytes(text)
    with pytest.raises(ValueError, match=r"line\.vtk: mesh points must be finite"):
        read_line(path)


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("none.vtu", None, "there is no such file"),
        ("bad.vtu", "hello", "cannot be read as a mesh"),
        ("bad.msh", "hello", "cannot be read as a mesh"),
        ("bad.vtk", "# vtk DataFile Version 4.2\n", "cannot be read as a mesh"),
        ("line.unknown", "hello", "cannot be read as a mesh"),
        ("empty.inp", "", "has no points"),
    ],
)
def test_files_that_cannot_be_read(tmp_path, capsys, name, content, words):
    if content is not None:
        (tmp_path / name).write_text(content)
    with pytest.raises(ValueError, match=rf"{name}: .*{words}"):
        read_line(tmp_path / name)
    assert capsys.readouterr() == ("", "")


def test_a_directory_is_no_mesh(tmp_path):
    with pytest.raises(ValueError, match="is a directory"):
        read_line(tmp_path)


@pytest.mark.parametrize("name", ["line.unknown", "no/such/folder/line.vtu"])
def test_files_that_cannot_be_written(tmp_path, name):
    with pytest.raises(ValueError, match="cannot be written"):
        write(tmp_path / name, scrambled())


def test_regions_are_not_lost_in_silence(tmp_path):
    with pytest.raises(ValueError, match=r"regions can be kept in \.inp and \.msh files only"):
        write(tmp_path / "line.vtu", scrambled({"boom": ("line", np.array([0]))}))
    shared = {"boom": ("line", np.array([0, 1])), "root": ("line", np.array([0]))}
    with pytest.raises(ValueError, match="'root' shares cells"):
        write(tmp_path / "line.msh", scrambled(shared))
    write(tmp_path / "line.inp", scrambled(shared))
    assert set(read(tmp_path / "line.inp").regions) == {"boom", "root"}


def test_flat_files_get_a_third_coordinate(tmp_path):
    import meshio

    meshio.Mesh([[0.0, 1.0], [2.0, 3.0]], {"line": [[0, 1]]}).write(tmp_path / "flat.xdmf")
    assert read_line(tmp_path / "flat.xdmf") == pytest.approx(np.array([[0, 1, 0], [2, 3, 0]]))


@pytest.mark.parametrize(
    ("points", "cells", "regions", "words"),
    [
        (NODES[:, :2], {}, {}, r"shape \(n, 3\)"),
        (NODES * nan, {}, {}, "finite"),
        (NODES, {"line": np.array([[0, 6]])}, {}, "line cells: an index lies outside"),
        (NODES, {"line": np.array([[-1, 2]])}, {}, "line cells: an index lies outside"),
        (NODES, {"line": np.array(BOOM)}, {"a": ("quad", np.array([0]))}, "no quad cells"),
        (NODES, {"line": np.array(BOOM)}, {"a": ("line", np.array([3]))}, "region 'a'"),
    ],
)
def test_impossible_meshes(points, cells, regions, words):
    with pytest.raises(ValueError, match=words):
        Mesh(points, cells, regions)


def test_importing_the_package_loads_no_heavy_library():
    code = (
        "import sys, meshes.generate, meshes.io, meshes.materials, meshes.mesh, meshes.sections;"
        "print([m for m in ('meshio', 'pyvista', 'matplotlib', 'skfem', 'pint', 'mechanics',"
        " 'thermal', 'coupling') if m in sys.modules])"
    )
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert out.stdout.strip() == "[]"
