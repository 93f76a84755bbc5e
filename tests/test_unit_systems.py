"""In metres and kilograms or in millimetres and tonnes: the same steps and the same physics.

Between SI and units of 1/1024 m and 1024 kg nothing is rounded, so that numbers of any kind that
stand in the program with a unit would show at once. In mm-t-s round-off differs, which impacts
magnify.
"""

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from unit_systems import BINARY, MM_T_S, SI

from coupling import casefile
from coupling.model import build
from coupling.simulation import Done, windows

ROOT = Path(__file__).parent.parent
ARM = ("body.arm.elements=4", "time.end=0.5")
CASES = {
    "line": ("arm_rotation", ARM),
    "wall": ("arm_rotation", (*ARM, "thermal.solver=wall")),
    "solid": ("arm_rotation", ("body.arm.elements=2", "time.end=0.3", "thermal.solver=solid")),
    "guide": ("slider_crank_guide", ("time.end=2e-4",)),
}


class End(NamedTuple):
    """What a run came to, in SI; counts (windows, 4): steps, refused, corrections, factors."""

    counts: Any
    T: Any
    probes: dict[str, Any]
    ledger: Any


def end(units, case, settings):
    with units.spoken():
        model = build(casefile.read(ROOT / "cases" / case, settings))
        done = list(windows(model, model.initial()))
        assert all(isinstance(window, Done) for window in done)
        last = done[-1].state
        probes = model.probes(last)
    counts = np.array([window.state.motion.counts for window in done])
    found = {
        f"{name}/{what}": row[what] / units.length
        for name, row in probes.items()
        for what in ("position", "velocity")
    }
    return End(counts, last.T, found, last.motion.ledger / units.energy)


@pytest.fixture(scope="module", params=CASES)
def both(request):
    """A case, and what it came to in SI."""
    return CASES[request.param], end(SI, *CASES[request.param])


def assert_close(ours, theirs, relative):
    """Temperatures and positions to 1e-9 of the largest; velocities and energies ``relative``."""
    np.testing.assert_allclose(ours.T, theirs.T, rtol=1e-9)
    for what in ("position", "velocity"):
        names = [name for name in theirs.probes if name.endswith(what)]
        a, b = (np.array([run.probes[name] for name in names]) for run in (ours, theirs))
        tolerance = 1e-9 if what == "position" else relative
        assert np.abs(a - b).max() <= tolerance * np.abs(b).max(), what
    largest = np.abs(theirs.ledger).max()
    np.testing.assert_allclose(ours.ledger, theirs.ledger, rtol=0.0, atol=relative * largest)


def test_units_without_rounding_change_nothing(both):
    case, expected = both
    found = end(BINARY, *case)
    assert np.array_equal(found.counts, expected.counts)
    assert_close(found, expected, 1e-9)


def test_millimetres_and_tonnes_take_the_same_steps(both):
    """Round-off may cost one correction in 200, which changes rates by what Newton may leave."""
    case, expected = both
    found = end(MM_T_S, *case)
    assert np.array_equal(found.counts[:, :2], expected.counts[:, :2])
    corrections = expected.counts[-1, 2]
    assert abs(found.counts[-1, 2] - corrections) <= 0.005 * corrections
    assert_close(found, expected, 1e-6)
