"""Temperature fields from tables and files: exact where they must be, refused where not."""

from itertools import product

import meshio
import numpy as np
import pytest

from meshes.fields import Frame, SampledField, Units, along_line, read_field, table_field
from meshes.generate import line

SLOPE = np.array([30.0, -20.0, 50.0])


def linear(x, t=0.0):
    """A field linear in space and in time."""
    return 300.0 + 2.0 * t + x @ SLOPE


def box(n=4):
    grid = np.linspace(0.0, 1.0, n)
    return np.array(list(product(grid, grid, grid)))


def scattered(n, seed=0):
    return np.random.default_rng(seed).random((n, 3))


def on_tube(stations, around, radius=0.05, length=1.0):
    s, phi = np.linspace(0, length, stations), 2 * np.pi * np.arange(around) / around
    s, phi = (a.ravel() for a in np.meshgrid(s, phi, indexing="ij"))
    return np.column_stack([s, radius * np.cos(phi), radius * np.sin(phi)])


def of(points, values=None):
    return SampledField([Frame(0.0, points, linear(points) if values is None else values)], "data")


# ------------------------------------------------------------------------------- interpolation


@pytest.mark.parametrize(
    ("data", "asked"),
    [
        (scattered(200), 0.1 + 0.8 * scattered(50, 1)),
        (box(), 0.1 + 0.8 * scattered(50, 1)),
        (box(2), scattered(20, 1)),  # one cell
        (np.linspace([0, 0, 0], [1, 2, 3], 7), np.linspace([0.1, 0.2, 0.3], [0.9, 1.8, 2.7], 11)),
        (scattered(60) * [1, 1, 0], scattered(20, 1) * [1, 1, 0]),
        (on_tube(21, 16), on_tube(13, 7)),
        (on_tube(500, 8), on_tube(13, 7)),  # neighbours along are 25 times nearer than around
        (on_tube(21, 16), on_tube(13, 8, 0.049)),
    ],
    ids=["cloud", "box", "cell", "line", "plane", "tube", "uneven tube", "within the wall"],
)
def test_linear_fields_are_exact(data, asked):
    np.testing.assert_allclose(of(data)(asked, 0.0), linear(asked), rtol=0, atol=1e-8)


def test_values_of_the_points_are_met():
    points, values = scattered(100), 300.0 + 50.0 * np.random.default_rng(1).random(100)
    np.testing.assert_allclose(of(points, values)(points, 0.0), values, atol=1e-3)


def test_smooth_fields_converge_with_the_square_of_the_distance():
    asked, errors = np.random.default_rng(2).random((200, 3)) * [1, 1, 0], []

    def smooth(x):
        return 300.0 + 10.0 * np.sin(3.0 * x[:, 0]) * np.cos(2.0 * x[:, 1])

    for n in (11, 21, 41):
        grid = np.linspace(0.0, 1.0, n)
        data = np.array([(x, y, 0.0) for x in grid for y in grid])
        errors.append(np.sqrt(np.mean((of(data, smooth(data))(asked, 0.0) - smooth(asked)) ** 2)))
    assert (np.log2(np.divide(errors[:-1], errors[1:])) > 1.8).all()


def test_a_thin_plate_of_two_layers_keeps_its_gradient():
    data = np.array([(x, y, z) for x in range(6) for y in range(6) for z in (0.0, 0.01)], float)
    asked = np.array([[2.5, 2.5, 0.005], [1.2, 3.9, 0.0025], [0.0, 0.0, 0.01]])
    values = 300.0 + 1000.0 * data[:, 2]
    np.testing.assert_allclose(of(data, values)(asked, 0), 300 + 1000 * asked[:, 2], atol=1e-6)


def test_positions_far_from_the_data_are_refused():
    with pytest.raises(ValueError, match=r"data: 1 of 2 positions are far .*unit of length\?"):
        of(box())(np.array([[0.5, 0.5, 0.5], [5.0, 0.0, 0.0]]), 0.0)


def test_between_frames_the_field_is_linear_and_outside_it_is_no_number():
    x = box()
    field = SampledField([Frame(t, x, linear(x, t)) for t in (1.0, 2.0, 5.0)], "data")
    assert field.times == (1.0, 5.0)
    for t in (1.0, 1.3, 2.0, 4.0, 5.0):
        np.testing.assert_allclose(field(x, t), linear(x, t), atol=1e-8)
    assert np.isnan(field(x, 0.9)).all()
    assert np.isnan(field(x, 5.1)).all()


def test_frames_of_other_meshes_are_joined_in_time():
    field = SampledField(
        [Frame(t, x, linear(x, t)) for t, x in ((0.0, box(3)), (1.0, scattered(300)))], "data"
    )
    asked = 0.2 + 0.6 * scattered(10, 5)
    np.testing.assert_allclose(field(asked, 0.25), linear(asked, 0.25), atol=1e-8)


# -------------------------------------------------------------------------------------- tables


def test_table_is_bilinear_in_arclength_and_time():
    bent = np.array([[0.0, 0, 0], [1.0, 0, 0], [1.0, 1.0, 0]])
    t, s = np.array([0.0, 10.0]), np.array([0.0, 0.5, 2.0])
    field = table_field(t, s, np.add.outer(3.0 * t, 300.0 + 40.0 * s), bent)
    asked = np.array([[0.25, 0.01, 0.0], [1.0, 0.5, 0.2], [1.0, 1.0, 0.0]])
    np.testing.assert_allclose(along_line(bent, asked), [0.25, 1.5, 2.0])
    np.testing.assert_allclose(field(asked, 4.0), [322.0, 372.0, 392.0])
    assert np.isnan(field(asked, 10.1)).all()
    assert table_field([0.0], s, [[300.0, 310.0, 320.0]], bent).times == (-np.inf, np.inf)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"times": [0.0, 0.0]}, "times must be finite and rise"),
        ({"distances": [0.0, np.nan]}, "distances must be finite and rise"),
        ({"values": [[300.0, 300.0]]}, "values must have the shape (2, 2), got (1, 2)"),
        ({"values": [[300.0, 300.0], [20.0, -5.0]]}, "values must be finite and above 0 K"),
        ({"line": [[0.0, 0.0, 0.0]]}, "a line needs two or more points"),
    ],
)
def test_senseless_tables_are_refused(change, said):
    sound = {
        "times": [0.0, 1.0], "distances": [0.0, 1.0], "values": np.full((2, 2), 300.0),
        "line": [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]],
    }  # fmt: skip
    with pytest.raises(ValueError) as error:
        table_field(**{**sound, **change})
    assert said in str(error.value)


def test_a_table_shorter_than_its_line_is_refused():
    points = line((0, 0, 0), (2, 0, 0), 4, (0, 1, 0))[0]
    field = table_field([0.0], [0.0, 1.0], [[300.0, 310.0]], points)
    with pytest.raises(ValueError, match=r"the table goes from 0 m to 1 m, 1\.5 m is asked for"):
        field(points, 0.0)


# --------------------------------------------------------------------------------------- files


def test_csv_with_times_in_units_of_its_header(tmp_path):
    x = scattered(30)
    rows = [
        ";".join(f"{number:.17g}" for number in (t, *(1e3 * p), linear(p, t) - 273.15, 7))
        for t in (0.0, 2.0)
        for p in x
    ]
    head = "Time [s];x [mm];y [mm];z [mm];Temperature [degC];id"
    (tmp_path / "t.csv").write_text("\n".join(["# made elsewhere", head, *rows, ""]))
    field = read_field(tmp_path / "t.csv")
    assert field.times == (0.0, 2.0)
    np.testing.assert_allclose(field(x, 0.5), linear(x, 0.5), atol=1e-4)
    asked = 0.3 + 0.4 * scattered(10, 3)
    np.testing.assert_allclose(field(asked, 0.5), linear(asked, 0.5), atol=1e-7)


def test_csv_without_time_in_units_of_the_caller(tmp_path):
    x = box()
    fahrenheit = (linear(x) - 273.15) * 1.8 + 32.0
    table = np.column_stack([fahrenheit, x / 0.0254])
    np.savetxt(tmp_path / "t.csv", table, delimiter=",", header="nt11,x,y,z", comments="")
    field = read_field(tmp_path / "t.csv", Units("in", "degF"))
    assert field.times == (-np.inf, np.inf)
    np.testing.assert_allclose(field(x, 1e9), linear(x), atol=1e-3)


CUBE = [("hexahedron", [[0, 4, 6, 2, 1, 5, 7, 3]])]


@pytest.mark.parametrize("binary", [True, False])
def test_vtu_of_points(tmp_path, binary):
    x = box(2)
    data = {"stress": np.ones((8, 6)), "Temperature": linear(x)}
    meshio.Mesh(x, CUBE, point_data=data).write(tmp_path / "t.vtu", binary=binary)
    asked = scattered(10)
    field = read_field(tmp_path / "t.vtu")
    np.testing.assert_allclose(field(asked, 0.0), linear(asked), atol=1e-7)


def bricks(n):
    """Cells of ``box(n)``."""
    at = np.arange(n**3).reshape(n, n, n)
    corners = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
    corners += [(i, j, 1) for i, j, _ in corners]
    last = n - 1
    return np.stack(
        [at[i : i + last, j : j + last, k : k + last].ravel() for i, j, k in corners], axis=1
    )


def test_vtu_of_cells_under_a_name(tmp_path):
    x, cells = box(5), bricks(5)
    data = {"heat": [linear(x[cells].mean(axis=1))], "temp": [np.zeros(len(cells))]}
    meshio.Mesh(x, [("hexahedron", cells)], cell_data=data).write(tmp_path / "t.vtu")
    field = read_field(tmp_path / "t.vtu", array="heat")
    np.testing.assert_allclose(field(x, 0.0), linear(x), atol=1e-7)


def series(folder, times=("0", "10"), files=("a.vtu", "b.vtu")):
    sets = [
        f'<DataSet timestep="{t}" part="0" file="{file}"/>'
        for t, file in zip(times, files, strict=True)
    ]
    text = "\n".join(['<VTKFile type="Collection"><Collection>', *sets, "</Collection></VTKFile>"])
    (folder / "t.pvd").write_text(text)
    return folder / "t.pvd"


def test_pvd_is_a_series(tmp_path):
    x = box(2)
    for name, t in (("a", 0.0), ("b", 10.0)):
        data = {"temperature": linear(x, t) - 273.15}
        meshio.Mesh(x, CUBE, point_data=data).write(tmp_path / f"{name}.vtu")
    field = read_field(series(tmp_path), Units("m", "degC"))
    assert field.times == (0.0, 10.0)
    np.testing.assert_allclose(field(x, 2.5), linear(x, 2.5), atol=1e-3)


ROWS = "\n0,0,0,300\n1,0,0,310\n0,1,0,320\n"
BAD_CSV = {
    "no column": ("x,y,z,T2" + ROWS, "no column 'temperature'; its columns are x, y, z, T2"),
    "two columns": ("x,y,x,t" + ROWS, "2 columns for 'x'"),
    "nan": ("x,y,z,t" + ROWS + "1,1,0,nan\n", "line 5: temperature is nan"),
    "blank": ("x,y,z,t" + ROWS + "1,1,0\n", "line 5: '' for temperature is not a number"),
    "words": ("x,y,z,t" + ROWS + "1,1,zero,300\n", "line 5: 'zero' for z is not a number"),
    "code": ("x,y,z,t" + ROWS + "1,1,__import__('os'),300\n", "is not a number"),
    "unknown unit": ("x,y,z,t [C]" + ROWS, "unit of temperature 'C' is not known"),
    "mixed units": ("x [m],y [mm],z [m],t" + ROWS, "x, y and z need the same unit"),
    "minutes": ("time [min],x,y,z,t\n0,0,0,0,300\n0,1,0,0,310\n", "time is in s"),
    "below zero": ("x,y,z,t" + ROWS.replace("310", "-20"), "unit of temperature?"),
    "empty": ("", "has no rows"),
    "header only": ("x,y,z,t\n", "has no rows"),
    "one point": ("x,y,z,t\n0,0,0,300\n", "two or more points"),
}


@pytest.mark.parametrize("case", BAD_CSV)
def test_bad_csv_is_refused_by_name(tmp_path, case):
    text, said = BAD_CSV[case]
    (tmp_path / "t.csv").write_text(text)
    with pytest.raises(ValueError) as error:
        read_field(tmp_path / "t.csv")
    assert said in str(error.value)
    assert str(error.value).startswith(str(tmp_path / "t.csv"))


def test_other_files_are_refused_by_name(tmp_path):
    (tmp_path / "t.txt").write_text("x")
    (tmp_path / "t.csv").write_bytes(b"\xff\xfe\x00\x01")
    (tmp_path / "t.vtu").write_text("<VTKFile>")
    (tmp_path / "u.pvd").write_text("<VTKFile><Collection")
    (tmp_path / "v.pvd").write_text("<VTKFile/>")
    said = {
        "t.txt": "fields are read from .csv, .vtu, .vtk, .pvd files only",
        "t.csv": "is not a text file",
        "t.vtu": "cannot be read as a mesh",
        "u.pvd": "cannot be read as a series",
        "v.pvd": "has no data sets",
        "none.vtu": "there is no such file",
    }
    for name, reason in said.items():
        with pytest.raises(ValueError) as error:
            read_field(tmp_path / name)
        assert reason in str(error.value)
        assert str(error.value).startswith(str(tmp_path / name))


def test_units_of_the_caller_are_looked_at(tmp_path):
    (tmp_path / "t.csv").write_text("x,y,z,t" + ROWS)
    with pytest.raises(ValueError, match="unit of length 'km' is not known"):
        read_field(tmp_path / "t.csv", Units("km", "K"))


@pytest.mark.parametrize(
    ("data", "array", "said"),
    [
        (
            {"a": np.ones(8)},
            None,
            "which array holds temperatures is not clear; its arrays are 'a'",
        ),
        ({"temp": np.ones(8)}, "b", "which array holds 'b' is not clear"),
        ({"temp": np.ones(8), "T": np.ones(8)}, None, "is not clear"),
        ({"temp": np.ones((8, 3))}, None, "not one value per point"),
        ({"temp": np.full(8, np.nan)}, None, "8 temperatures are not numbers"),
        ({}, None, "its arrays are none"),
    ],
)
def test_bad_arrays_are_refused(tmp_path, data, array, said):
    meshio.Mesh(box(2), CUBE, point_data=data).write(tmp_path / "t.vtu")
    with pytest.raises(ValueError) as error:
        read_field(tmp_path / "t.vtu", array=array)
    assert said in str(error.value)


@pytest.mark.parametrize(
    ("times", "files", "said"),
    [
        (("0", "one"), ("a.vtu", "a.vtu"), "time 'one' is not a number"),
        (("0", "1"), ("a.vtu", "c.vtu"), "names 'c.vtu', which is no .vtu or .vtk file"),
        (("0", "1"), ("a.vtu", "t.pvd"), "names 't.pvd'"),
        (("0", "1"), ("a.vtu", "b.vtu"), "'b.vtu': which array"),
    ],
)
def test_bad_series_are_refused(tmp_path, times, files, said):
    x = box(2)
    meshio.Mesh(x, CUBE, point_data={"T": linear(x)}).write(tmp_path / "a.vtu")
    meshio.Mesh(x, CUBE, point_data={"u": linear(x)}).write(tmp_path / "b.vtu")
    with pytest.raises(ValueError) as error:
        read_field(series(tmp_path, times, files))
    assert said in str(error.value)


@pytest.mark.benchmark
def test_time_of_many_positions():
    """50,000 positions in 20,000 points once, and then at every time again."""
    from time import perf_counter

    field, asked = of(scattered(20_000)), 0.1 + 0.8 * scattered(50_000, 1)
    start = perf_counter()
    field(asked, 0.0)
    first = perf_counter()
    field(asked, 1.0)
    print(f"\nfirst {first - start:.2f} s, again {perf_counter() - first:.4f} s")
