"""What the report on the paper says of floating frames."""

import numpy as np
import pytest

from coupling.paper import floating_frame as section
from coupling.reports.timed_runs import Ran

L = section.LENGTH


@pytest.mark.parametrize("gradient", [50.0, 600.0])
def test_bows_are_those_of_an_arc_and_of_its_linear_theory(gradient):
    turn = section.EXPANSION * gradient * L
    assert section.bow(None, gradient) == pytest.approx(L * (1.0 - np.cos(turn)) / turn, rel=2e-4)
    assert section.bow(section.VIBRATIONS, gradient) == pytest.approx(0.5 * turn * L, rel=2e-4)


def test_excess_is_that_of_linear_theory():
    turn = 0.3
    assert section.excess(turn) == pytest.approx(turn**2 / 12.0, rel=0.01)


def test_loads_bend_as_the_elastica_and_as_linear_theory():
    """Bisshopp & Drucker (1945), P L^2/EI = 1; shear adds 3 EI/(k G A L^2), 2e-4."""
    assert section.deflection(None, 1.0) / L == pytest.approx(0.30172, rel=1e-3)
    assert section.deflection(section.VIBRATIONS, 1.0) / L == pytest.approx(1.0 / 3.0, rel=1e-3)


def test_rotation_softens_a_frame_and_stiffens_the_arm():
    first = 0.84
    assert section.softened(0.0, first) == 0.0
    assert section.softened(0.1, first) == pytest.approx(
        -0.5 * 1.193 * (0.1 / first) ** 2, rel=0.02
    )


def _ran(x, y, turn):
    zero = np.zeros((2, 1))
    values = {"x": np.array([[L], [x]]), "y": np.array([[0.0], [y]]), "root_x": zero,
              "root_y": zero, "turn": np.array([[0.0], [turn]]), "force": 1.0 + zero,
              "peak": 2.0 + zero}  # fmt: skip
    return Ran("done", "", 0.0, (2.0,), times=np.array([0.0, 1.0]), values=values)


def test_the_pose_is_seen_from_the_root():
    c, s = np.cos(0.3), np.sin(0.3)
    turned = _ran(c * 63.0 - s * 2.0, s * 63.0 + c * 2.0, 0.3)
    pose = section._pose(turned, turned.times)
    assert (pose.along[-1], pose.across[-1]) == pytest.approx((63.0, 2.0))
    assert section._pose(turned, np.array([0.0, 0.5, 1.0])).along.size == 3
    entry = section._arm(_ran(63.0, 2.0, 0.0), _ran(63.05, 2.02, 0.0))
    assert "+1.00 %" in entry.inputs and "0.05 m of it" in entry.inputs
    assert entry.kind == "does not follow"
