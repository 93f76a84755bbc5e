"""What motion decides for the heat in a window, with made-up joints and light."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.sparse import csr_array

from coupling.joint_conductance import Joint, JointConductance, Tabled
from coupling.surroundings import Around
from coupling.transfer import Transfer
from mechanics import march

COLUMNS = 1 + max(march.ELASTIC, march.DISSIPATIVE, march.DEPTH)
READ = Transfer(csr_array(np.kron(np.eye(2), [[1.0], [0.0], [0.0]])), np.zeros((2, 3)))
T = np.array([300.0, 320.0])


def rows(t, elastic, dissipative, depth):
    """Steps of one contact."""
    response = np.zeros((len(t), 1, COLUMNS))
    response[:, 0, march.ELASTIC], response[:, 0, march.DISSIPATIVE] = elastic, dissipative
    response[:, 0, march.DEPTH] = depth
    return SimpleNamespace(t=np.array(t), response=response)


def around(law, exposure=None, elastic=None):
    joint = Joint("contact.c", np.array([0]), np.array([0, 1]), law)
    return Around(READ, exposure, JointConductance([joint]), elastic)


def before(outside, temperatures=T):
    return SimpleNamespace(outside=outside, T=temperatures)


BY_FORCE = Tabled((0.0, 10.0), (0.0, 1.0), (0.0, 1e-3), (0.5, 0.1))


def test_joints_are_open_at_the_start():
    np.testing.assert_allclose(around(BY_FORCE).at(0.0, None, T)["contact.c"], [0.5, 0.5])


def test_the_mean_of_a_window_is_straight_within_steps():
    """Force is elastic and dissipative; 1 s at 0.5 to 0.8 W/K, 3 s from there to a gap of 1 mm."""
    made = around(BY_FORCE)
    start = made.at(0.0, None, T)
    seen = [rows([11.0], [6.0], [2.0], [1e-6]), rows([14.0], [0.0], [0.0], [-1e-3])]
    found = made.after(10.0, 4.0, before(start), None, T, seen)
    mean = (0.5 * (0.5 + 0.8) + 3.0 * 0.5 * (0.8 + 0.1)) / 4.0
    np.testing.assert_allclose(found["contact.c"], [mean, 0.1])


@pytest.mark.parametrize("cuts", [[4.0], [1.0, 4.0], [1.0, 2.0, 3.0, 4.0]])
def test_means_do_not_depend_on_how_steps_are_cut_into_windows(cuts):
    made, t = around(BY_FORCE), np.arange(1.0, 5.0)
    force = np.array([2.0, 5.0, 1.0, 7.0])
    outside, first, heat = made.at(0.0, None, T), 0.0, 0.0
    for last in cuts:
        own = (t > first) & (t <= last)
        seen = [rows(t[own], force[own], 0.0, 0.0)]
        outside = made.after(first, last - first, before(outside), None, T, seen)
        heat += (last - first) * outside["contact.c"][0]
        first = last
    assert heat == pytest.approx(0.5 * (0.5 + 0.2) + 0.35 + 0.3 + 0.4)


def test_conductance_is_that_of_the_mean_temperature_of_a_window():
    made = around(lambda force, gap, temperature: np.full(len(force), temperature)[:, None])
    found = made.after(0.0, 1.0, before(made.at(0.0, None, T)), None, T + 20.0,
                       [rows([1.0], [1.0], [0.0], [0.0])])  # fmt: skip
    np.testing.assert_allclose(found["contact.c"], [0.5 * (310.0 + 320.0), 320.0])


def test_light_is_that_of_the_end_and_conductance_is_held():
    light = SimpleNamespace(at=lambda t, motion: {"light.s": np.array([t])})
    made = around(BY_FORCE, light)
    found = made.after(1.0, 2.0, before(made.at(1.0, None, T)), None, T,
                       [rows([3.0], [1.0], [0.0], [0.0])])  # fmt: skip
    assert found["light.s"] == [3.0]
    assert made.held == {"contact.c"}
    assert Around(READ, light).after(1.0, 2.0, before({}), None, T, []) == {"light.s": [3.0]}


def test_heat_of_deformation_is_asked_for_only_where_it_is_wanted():
    assert around(BY_FORCE).released(None, None, T, T) is None
    given = around(BY_FORCE, elastic=lambda a, b, T0, T1: T1 - T0)
    np.testing.assert_array_equal(given.released(None, None, T, T + 1.0), [1.0, 1.0])
