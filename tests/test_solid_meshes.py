"""Volume meshes: volumes and areas against geometry, closed boundaries, regions, files."""

from itertools import combinations
from math import pi

import meshio
import numpy as np
import pytest

from meshes import surfaces
from meshes.families import CORNERS, EDGES, FACES, FACET
from meshes.generate import arc, line
from meshes.io import read, write
from meshes.mesh import Mesh
from meshes.sections import circle, general, rectangle, tube
from meshes.solids import ORDER, bore, box, member_mesh, pin, pin_and_bore, sheet_mesh, tetrahedra
from thermal.solid_elements import STORAGE, SURFACE, geometry, reference, shape

FAMILY = pytest.mark.parametrize("family", list(ORDER))


def volume(mesh, family):
    at = geometry(mesh.points[mesh.cells[family]], shape(family, STORAGE[family]))
    assert at.volumes.min() > 0.0
    return at.volumes.sum()


def vector_area(mesh, family, rows=slice(None)):
    """Sums over facets: (3,) vector area, area, volume under them by the divergence theorem."""
    form = shape(FACET[family], SURFACE[FACET[family]])
    nodes = mesh.points[mesh.cells[FACET[family]][rows]]
    a, b = (np.einsum("qn,gni->gqi", form.slopes[..., i], nodes) for i in range(2))
    normals = np.cross(a, b) * form.weights[:, None]
    at = np.einsum("qn,gni->gqi", form.values, nodes)
    return (
        normals.sum(axis=(0, 1)),
        np.linalg.norm(normals, axis=2).sum(),
        (at * normals).sum() / 3.0,
    )


def region_area(mesh, family, name):
    return vector_area(mesh, family, mesh.regions[name][1])[1]


def made(family):
    """One mesh of each kind, with the volume that it has when it is fine."""
    points, axes = arc((0, 0, 0), (1, 0, 0), (0, 0, 1), pi / 2, 8)
    sections = tube(0.1, 0.04), circle(0.1), rectangle(0.1, 0.2)
    for section in sections:
        mesh = member_mesh(points, axes, section, 24, 2, family=family)
        yield mesh, section.area * pi / 2
    panel = surfaces.tube(1.0, 2.0, 24, 2)
    yield sheet_mesh(panel, 0.1, 2, family=family), 2 * pi * 0.1 * 2.0
    yield (
        sheet_mesh(surfaces.sphere(1.0, 8, 6, (-0.7, 0.7), (0.0, 1.0)), 0.1, 1, family=family),
        ((1.05**3 - 0.95**3) / 3.0 * 2.0 * np.sin(0.7)),
    )
    yield box((1.0, 2.0, 3.0), (2, 3, 1), family=family), 6.0
    yield pin(0.5, 2.0, 24, 2, 2, family=family), 0.5 * pi
    yield bore(0.5, 1.0, 2.0, 24, 2, 2, family=family), 1.5 * pi


@FAMILY
def test_volumes_are_those_of_the_shapes(family):
    for mesh, expected in made(family):
        assert volume(mesh, family) == pytest.approx(
            expected, rel=0.02 if ORDER[family] < 2 else 4e-4
        )


@FAMILY
def test_regions_together_close_the_volume_and_turn_outward(family):
    for mesh, _ in made(family):
        total, area, enclosed = vector_area(mesh, family)
        assert np.abs(total).max() < 1e-12 * area
        # curved facets of two families differ by what the quadrature of degree 5 leaves
        assert enclosed == pytest.approx(
            volume(mesh, family), rel=1e-12 if ORDER[family] < 2 else 1e-6
        )
        rows = np.concatenate([r for _, r in mesh.regions.values()])
        assert sorted(rows) == list(range(len(mesh.cells[FACET[family]])))


@FAMILY
def test_every_node_is_used_and_none_lies_on_another(family):
    for mesh, _ in made(family):
        used = np.unique(mesh.cells[family])
        np.testing.assert_array_equal(used, np.arange(len(mesh.points)))
        rounded = np.unique(np.round(mesh.points, 9), axis=0)
        assert len(rounded) == len(mesh.points)


@FAMILY
def test_cells_meet_face_to_face(family):
    """Every face belongs to two cells, or to one and to a region."""
    for mesh, _ in made(family):
        k = CORNERS[FACET[family]]
        faces = mesh.cells[family][:, FACES[family][:, :k]].reshape(-1, k)
        _, counts = np.unique(np.sort(faces, axis=1), axis=0, return_counts=True)
        assert counts.max() == 2
        assert (counts == 1).sum() == len(mesh.cells[FACET[family]])


@FAMILY
def test_nodes_of_cells_are_in_the_order_of_meshio(family):
    """Middles lie midway in a box; the faces' nodes are where meshio's facets have them."""
    mesh = box((1.0, 2.0, 3.0), (1, 1, 1), family=family)
    kind = "hexahedron" if family.startswith("hexa") else "tetra"
    for cell in mesh.points[mesh.cells[family]]:
        middles = [cell[list(e)].mean(axis=0) for e in EDGES[kind]] if ORDER[family] == 2 else []
        n = CORNERS[family]
        np.testing.assert_allclose(
            cell[n : n + len(middles)], middles, atol=1e-14
        ) if middles else 0
        for face in FACES[family]:
            corners = cell[face[: CORNERS[FACET[family]]]]
            for i, node in enumerate(face[len(corners) : 2 * len(corners)]):
                between = corners[[i, (i + 1) % len(corners)]].mean(axis=0)
                np.testing.assert_allclose(cell[node], between, atol=1e-14)
            if len(face) == 9:
                np.testing.assert_allclose(cell[face[8]], corners.mean(axis=0), atol=1e-14)


def test_hexahedra_of_27_nodes_are_those_of_vtk():
    pyvista = pytest.importorskip("pyvista")
    mesh = pin(0.5, 2.0, 8, 1, 1, family="hexahedron27")
    grid = pyvista.from_meshio(
        meshio.Mesh(mesh.points, {"hexahedron27": mesh.cells["hexahedron27"]})
    )
    table = grid.GetCell(0).GetParametricCoords()
    coordinates = np.array([table[i] for i in range(81)]).reshape(27, 3)
    np.testing.assert_allclose(coordinates, reference("hexahedron27"), atol=1e-12)


@pytest.mark.parametrize("around", [8, 12, 36])
def test_chords_keep_wall_and_mean_circumference_of_a_tube(around):
    section = tube(0.05, 0.002)
    points, axes = line((0, 0, 0), (1, 0, 0), 2)
    mesh = member_mesh(points, axes, section, around, 1)
    assert volume(mesh, "hexahedron") == pytest.approx(section.area, rel=1e-12)
    outer, inner = (region_area(mesh, "hexahedron", n) for n in ("outer", "inner"))
    assert 0.5 * (outer + inner) == pytest.approx(2 * pi * 0.05, rel=1e-12)
    assert outer == pytest.approx(section.outer_perimeter, rel=0.02 * (2 * pi / around) ** 2)
    assert region_area(mesh, "hexahedron", "start") == pytest.approx(section.area, rel=1e-12)


def test_chords_keep_the_area_of_a_circle():
    points, axes = line((0, 0, 0), (1, 0, 0), 2)
    mesh = member_mesh(points, axes, circle(0.1), 16, 1)
    assert volume(mesh, "hexahedron") == pytest.approx(pi * 0.01, rel=1e-12)


@pytest.mark.parametrize("order", [1, 2])
def test_nodes_of_a_tube_go_ring_by_ring_from_e2(order):
    points, axes = line((0, 0, 0), (2, 0, 0), 4)
    family = {1: "hexahedron", 2: "hexahedron27"}[order]
    mesh = member_mesh(points, axes, tube(0.1, 0.02), 12, 2, family=family)
    planes = mesh.points.reshape(4 * order + 1, 2 * order + 1, 12 * order, 3)
    np.testing.assert_allclose(planes[:, 0, 0, 0], np.linspace(0, 2, 4 * order + 1), atol=1e-15)
    y, z = planes[0, :, :, 1], planes[0, :, :, 2]
    angles = np.unwrap(np.arctan2(z, y), axis=1)
    expected = np.broadcast_to(2 * pi * np.arange(12 * order) / (12 * order), angles.shape)
    np.testing.assert_allclose(angles, expected, atol=1e-14)
    assert (np.diff(np.hypot(y, z), axis=0) > 0.0).all()


@FAMILY
def test_curved_geometry_converges_with_the_order_of_the_family(family):
    errors = []
    for n in (8, 16):
        points, axes = arc((0, 0, 0), (1, 0, 0), (0, 0, 1), pi / 2, n)
        mesh = member_mesh(points, axes, tube(0.1, 0.1), 2 * n, 1, family=family)
        errors.append(abs(volume(mesh, family) / (tube(0.1, 0.1).area * pi / 2) - 1.0))
    rate = np.log2(errors[0] / errors[1])
    assert rate > (3.6 if ORDER[family] == 2 else 1.9)


def test_closed_sheets_have_edges_at_their_ends_only():
    mesh = sheet_mesh(surfaces.tube(1.0, 2.0, 16, 3), 0.05, 2)
    assert len(mesh.regions["edges"][1]) == 2 * 16 * 2
    assert region_area(mesh, "hexahedron", "top") > region_area(mesh, "hexahedron", "bottom")


def test_a_pin_lies_within_its_bore_facet_by_facet():
    inside, outside = pin_and_bore(0.01, 1e-5, 0.02, 0.03, 10, 1, 2)
    nodes = [np.unique(m.cells["quad"][m.regions[r][1]]) for m, r in
             ((inside, "outer"), (outside, "inner"))]  # fmt: skip
    a, b = inside.points[nodes[0]], outside.points[nodes[1]]
    assert len(a) == len(b)
    gaps = [np.linalg.norm(b - x, axis=1).min() for x in a]
    np.testing.assert_allclose(gaps, 1e-5, rtol=1e-9)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: box((1, 1, 1), (1, 0, 1)), "counts must be a whole number of at least 1, got 0"),
        (lambda: box((1, 1, 1), (1, 1, 1), order=3), "order must be 1 or 2"),
        (lambda: box((1, 1, 1), (1, 1, 1), family="wedge"), "got wedge"),
        (lambda: pin(1.0, 1.0, 2, 1, 1), "around must be a whole number of at least 4"),
        (
            lambda: member_mesh(*line((0, 0, 0), (1, 0, 0), 1), general(1, 1, 1, 1), 8, 1),
            "a section of kind 'general' has no shape",
        ),
    ],
)
def test_impossible_meshes(call, words):
    with pytest.raises(ValueError, match=words):
        call()


# --- files --------------------------------------------------------------------------------------


def mixed():
    """A hexahedron on the side of tetrahedra: a surface region of quads and triangles."""
    left = box((1, 1, 1), (1, 1, 1))
    right = tetrahedra(box((1, 1, 1), (1, 1, 1)))
    points = np.vstack([left.points, right.points + np.array([2.0, 0.0, 0.0])])
    cells = dict(left.cells)
    cells |= {f: c + len(left.points) for f, c in right.cells.items()}
    every = {f: np.arange(len(c)) for f, c in cells.items()}
    regions = {"skin": ("quad", every["quad"]), "body": ("hexahedron", every["hexahedron"])}
    others = {"skin": {"triangle": every["triangle"]}, "body": {"tetra": every["tetra"]}}
    return Mesh(points, cells, regions, others)


def test_regions_of_several_families_survive_a_file(tmp_path):
    mesh = mixed()
    write(tmp_path / "mixed.msh", mesh)
    again = read(tmp_path / "mixed.msh")
    assert set(again.regions) == {"skin", "body"}
    for name in again.regions:
        found, expected = again.cells_of(name), mesh.cells_of(name)
        assert set(found) == set(expected)
        for family, rows in found.items():
            np.testing.assert_array_equal(
                again.cells[family][rows], mesh.cells[family][expected[family]]
            )


def test_files_that_keep_one_family_to_a_region_refuse_more(tmp_path):
    with pytest.raises(ValueError, match=r"of several families can be kept in .msh files only"):
        write(tmp_path / "mixed.inp", mixed())


def test_further_cells_need_a_region_and_a_family():
    mesh = mixed()
    with pytest.raises(ValueError, match="region 'ghost': it has further cells, but no first ones"):
        Mesh(mesh.points, mesh.cells, mesh.regions, {"ghost": {"tetra": np.array([0])}})
    with pytest.raises(ValueError, match="region 'skin': the mesh has no wedge cells"):
        Mesh(mesh.points, mesh.cells, mesh.regions, {"skin": {"wedge": np.array([0])}})


@pytest.mark.parametrize(
    "family", ["tetra", "tetra10", "hexahedron", "hexahedron20", "hexahedron27"]
)
def test_second_order_nodes_survive_a_file(tmp_path, family):
    mesh = pin(0.5, 1.0, 8, 1, 1, family=family)
    write(tmp_path / "pin.msh", mesh)
    again = read(tmp_path / "pin.msh")
    np.testing.assert_array_equal(again.cells[family], mesh.cells[family])
    assert volume(again, family) == pytest.approx(volume(mesh, family), rel=1e-14)


def test_tetrahedra_have_no_edge_twice_in_one_place():
    """Divisions of neighbours agree: the edges on a face shared by two hexahedra are five."""
    mesh = tetrahedra(box((1, 1, 1), (2, 1, 1)))
    middle = np.flatnonzero(np.isclose(mesh.points[:, 0], 0.5))
    edges = {
        (a, b) for cell in mesh.cells["tetra"] for a, b in combinations(sorted(cell), 2)
        if a in middle and b in middle
    }  # fmt: skip
    assert len(edges) == 5
