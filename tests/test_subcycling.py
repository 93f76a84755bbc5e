"""Each side takes steps of its own in a window: what that does to order and balance."""

import numpy as np
import pytest

from coupling.manager import SCHEMES
from coupling.verify.coupled import RUBBED, RUBBING, windows
from mechanics.dynamics import Control
from mechanics.schemes import Scheme
from thermal.description import Settings

TIGHT = Scheme(newton_tolerance=1e-12)
STEPS = [
    pytest.param(1, 1, id="one step of each"),
    pytest.param(1, 6, id="heat takes six"),
    pytest.param(8, 1, id="motion takes eight"),
    pytest.param(8, 6, id="both sub-cycle"),
]


def pair(window: float, of_motion: int, of_heat: int):
    """The rubbing hinge with equal steps in each window."""
    h = window / of_motion
    return RUBBING.stepped(Control(1.0, h, h / 1e6, TIGHT), Settings(steps=of_heat))


@pytest.fixture(scope="module")
def exact() -> np.ndarray:
    return RUBBING.exact(RUBBED)


@pytest.mark.parametrize(("of_motion", "of_heat"), STEPS)
def test_order_in_the_window(exact: np.ndarray, of_motion: int, of_heat: int) -> None:
    """The corrector is of second order, serial exchange of first, whoever sub-cycles."""
    for scheme, order in (("corrected", 2.0), ("serial", 1.0)):
        errors = []
        for count in (20, 40):
            own = pair(RUBBED / count, of_motion, of_heat)
            end = windows(own, SCHEMES[scheme], RUBBED, count)
            errors.append(np.abs(end.T - exact).max())
        assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.25)


@pytest.mark.parametrize(("of_motion", "of_heat"), STEPS)
def test_balance(of_motion: int, of_heat: int) -> None:
    """What friction releases is what heat receives, to round-off, and stored or given away."""
    own = pair(RUBBED / 10, of_motion, of_heat)
    end = windows(own, SCHEMES["corrected"], RUBBED, 10)
    stored = own.heat_solver.energy(end.T) - own.heat_solver.energy(own.heat_solver.initial())
    assert end.motion.counts[0] >= 10 * of_motion
    assert end.deposited == pytest.approx(end.released, rel=1e-13)
    assert stored == pytest.approx(end.deposited + sum(end.flows.values()), rel=1e-11)
