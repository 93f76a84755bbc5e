"""Temperatures read at sections and heat deposited: exact, conservative, the right shares."""

import numpy as np
import pytest

from coupling.transfer import transfer
from meshes.generate import arc, line
from meshes.materials import library_material
from meshes.sections import rectangle, tube
from thermal.description import Member
from thermal.layout import wall_positions

RADIUS = 0.05
MATERIAL = library_material("al6061")
STRAIGHT = ([0.3, -0.2, 0.1], [2.3, 0.8, 0.6])
NORMAL = [0.2, 1.0, -0.4]


def member(points, axes, wall_points):
    section = tube(RADIUS, 0.002) if wall_points > 1 else rectangle(0.02, 0.03)
    return Member("arm", points, axes, section, MATERIAL, wall_points, 300.0)


def straight(elements):
    return line(*STRAIGHT, elements, NORMAL)


def bent(elements):
    return arc([0.0, 1.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 1.0], 2.0, elements)


def between(stations, nodes, wall_points):
    """Transfer from a member of some stations to a beam of some nodes along the same line."""
    x = wall_positions(member(*stations, wall_points))
    points, axes = nodes
    here, there = {"arm": np.arange(len(x))}, {"arm": np.arange(len(points))}
    return transfer(x, here, points, axes, there, np.full(len(points), 250.0))


def wall(fields, wall_points):
    """Wall temperatures of section fields (k, 3) given at the stations."""
    phi = 2.0 * np.pi * np.arange(wall_points) / wall_points
    across = RADIUS * (np.outer(fields[:, 1], np.cos(phi)) + np.outer(fields[:, 2], np.sin(phi)))
    return (fields[:, :1] + across).ravel()


def fields_along(s, *, gradients=True):
    """Mean and gradients that are linear in the arclength."""
    found = np.column_stack([300.0 + 40.0 * s, 25.0 - 30.0 * s, -10.0 + 50.0 * s])
    return found * [1.0, gradients, gradients]


def arclength(points):
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])


# -------------------------------------------------------------------------------- consistent


@pytest.mark.parametrize("wall_points", [1, 4, 6, 8])
@pytest.mark.parametrize("shape", [straight, bent])
def test_a_constant_temperature_is_read_as_such(shape, wall_points):
    read = between(shape(7), shape(7), wall_points)
    sections = read.read(np.full(read.matrix.shape[1], 321.5))
    np.testing.assert_allclose(sections[:, 0], 321.5, rtol=1e-14)
    np.testing.assert_allclose(sections[:, 1:], 0.0, atol=1e-10)


@pytest.mark.parametrize("wall_points", [4, 6, 8])
def test_a_linear_field_in_space_gives_its_value_and_its_gradients(wall_points):
    points, axes = straight(7)
    read = between((points, axes), (points, axes), wall_points)
    slope = np.array([30.0, -50.0, 20.0])
    x = wall_positions(member(points, axes, wall_points))
    sections = read.read(300.0 + x @ slope)
    expected = np.column_stack([300.0 + points @ slope, axes[:, 1:] @ slope])
    np.testing.assert_allclose(sections, expected, rtol=1e-11)


@pytest.mark.parametrize("wall_points", [1, 4, 6, 8])
@pytest.mark.parametrize("shape", [straight, bent])
def test_what_varies_along_the_member_is_read_at_its_stations(shape, wall_points):
    points, axes = shape(7)
    read = between((points, axes), (points, axes), wall_points)
    fields = fields_along(arclength(points), gradients=wall_points > 1)
    np.testing.assert_allclose(read.read(wall(fields, wall_points)), fields, rtol=1e-11)


@pytest.mark.parametrize("wall_points", [1, 4, 6])
@pytest.mark.parametrize(("stations", "nodes"), [(3, 8), (8, 3), (5, 7)])
def test_sections_between_stations_are_interpolated_linearly(stations, nodes, wall_points):
    there = straight(nodes)
    read = between(straight(stations), there, wall_points)
    told = fields_along(arclength(straight(stations)[0]), gradients=wall_points > 1)
    expected = fields_along(arclength(there[0]), gradients=wall_points > 1)
    np.testing.assert_allclose(read.read(wall(told, wall_points)), expected, rtol=1e-11)


def test_a_temperature_between_two_stations_is_weighted_by_the_distances():
    read = between(straight(1), straight(4), 1)
    np.testing.assert_allclose(read.read(np.array([300.0, 400.0]))[1], [325.0, 0.0, 0.0])


@pytest.mark.parametrize("shape", [straight, bent])
def test_higher_harmonics_round_the_wall_are_not_read(shape):
    """Mean and gradients are the zeroth and first harmonic of all points of the station."""
    points, axes = shape(7)
    read = between((points, axes), (points, axes), 8)
    phi = 2.0 * np.pi * np.arange(8) / 8
    T = np.tile(20.0 * np.cos(2.0 * phi) + 5.0 * np.sin(3.0 * phi), len(points))
    np.testing.assert_allclose(read.read(T), 0.0, atol=1e-10)


# ------------------------------------------------------------------------------ conservative


@pytest.mark.parametrize("wall_points", [1, 4, 6, 8])
@pytest.mark.parametrize("shape", [straight, bent])
def test_heat_at_a_node_is_spread_evenly_over_the_wall_of_its_station(shape, wall_points):
    read = between(shape(7), shape(7), wall_points)
    heat = np.zeros(8)
    heat[3] = 2.0
    nodal = read.deposit(heat).reshape(8, wall_points)
    np.testing.assert_allclose(nodal[3], 2.0 / wall_points, rtol=1e-12)
    assert np.abs(np.delete(nodal, 3, axis=0)).max() < 1e-12


@pytest.mark.parametrize(("stations", "nodes"), [(3, 8), (8, 3), (7, 7)])
def test_no_heat_is_lost_on_the_way(stations, nodes):
    read = between(straight(stations), straight(nodes), 4)
    heat = np.random.default_rng(1).standard_normal(nodes + 1)
    assert read.deposit(heat).sum() == pytest.approx(heat.sum(), rel=1e-13)


def test_depositing_is_the_transpose_of_reading_means():
    rng = np.random.default_rng(2)
    read = between(straight(5), straight(8), 6)
    T, heat = rng.standard_normal(read.matrix.shape[1]), rng.standard_normal(9)
    assert heat @ read.read(T)[:, 0] == pytest.approx(T @ read.deposit(heat), rel=1e-12)


# ---------------------------------------------------------------------------- parts, no heat


def with_parts():
    """A beam that has temperatures, a cable that has none, a journal and a bearing."""
    points, axes = straight(4)
    walls = wall_positions(member(points, axes, 4))
    x = np.vstack([[[9.0, 9.0, 9.0]], walls, [[0.0, 0.0, 0.0]]])
    regions = {
        "pin.bearing": np.array([0]),
        "arm": 1 + np.arange(20),
        "pin.journal": np.array([21]),
    }
    where = np.vstack([points, points + 5.0, points[:1], points[:1]])
    triads = np.concatenate([axes, axes, np.zeros((2, 3, 3))])
    rows = {"arm": np.arange(5), "rope": 5 + np.arange(5), "pin.journal": np.array([10]),
            "pin.bearing": np.array([11])}  # fmt: skip
    rest = np.concatenate([np.full(5, 250.0), np.full(5, 260.0), [270.0, 280.0]])
    return transfer(x, regions, where, triads, rows, rest)


def test_parts_are_read_by_name_wherever_they_are():
    T = np.concatenate([[333.0], np.full(20, 300.0), [444.0]])
    sections = with_parts().read(T)
    assert sections[10].tolist() == [444.0, 0.0, 0.0]
    assert sections[11].tolist() == [333.0, 0.0, 0.0]


def test_points_of_a_region_without_temperatures_stay_at_rest():
    sections = with_parts().read(np.full(22, 300.0))
    assert np.array_equal(sections[5:10], np.tile([260.0, 0.0, 0.0], (5, 1)))
    np.testing.assert_allclose(sections[:5, 0], 300.0, rtol=1e-14)


def test_heat_goes_to_the_part_that_released_it_and_to_nobody_where_there_is_none():
    heat = np.zeros(12)
    heat[[5, 10, 11]] = 7.0, 3.0, 2.0
    nodal = with_parts().deposit(heat)
    assert nodal[21] == 3.0 and nodal[0] == 2.0
    assert nodal.sum() == 5.0


def test_without_heat_everything_rests():
    points, axes = straight(3)
    none = transfer(np.zeros((0, 3)), {}, points, axes, {"arm": np.arange(4)}, np.full(4, 299.0))
    assert np.array_equal(none.read(np.zeros(0)), np.tile([299.0, 0.0, 0.0], (4, 1)))
    assert none.deposit(np.ones(4)).shape == (0,)
