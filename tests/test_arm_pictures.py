"""What pictures of telescopes and of turning hinges read from made-up runs."""

from pathlib import Path

import numpy as np
import pytest
import synthetic
from numpy.testing import assert_allclose

from coupling.reading import Results
from coupling.telescope_pictures import standing, surfaces
from coupling.turning_pictures import Course


@pytest.mark.parametrize("time", [0.0, 0.5, 1.0])
def test_a_telescope_stands_where_its_stations_are(tmp_path: Path, time: float) -> None:
    """Its inner tube, 3 m long, begins at 0.4 + 0.3 t in one of 2 m."""
    with Results.open(synthetic.loose_run(tmp_path)) as results:
        found = standing(results, "tubes", time)
    assert_allclose(found.travel, 0.3 * time, atol=1e-9)
    assert_allclose(found.overlap, synthetic.OUTER - 0.4 - 0.3 * time)
    assert found.counts.sum() == synthetic.STATIONS + 1
    assert len(found.points) == found.counts[1:].sum()


def test_shares_of_slip_are_those_that_were_recorded(tmp_path: Path) -> None:
    with Results.open(synthetic.loose_run(tmp_path)) as results:
        found = surfaces(results, "tubes")
        rows = [
            int(results.attributes(f"joints/{n}")["number"])
            for n in results.names("joints")
            if n.startswith("tubes")
        ]
        shares = results["contacts/shares"][:, rows]
    slip, stick = shares[..., 2].sum(), shares[..., 3].sum()
    assert_allclose(found.slipping(), slip / (slip + stick))
    assert_allclose(found.shares.sum(axis=2), 1.0)


def test_transitions_pass_over_flight() -> None:
    regime = np.array([3, 3, 0, 3, 2, 0, 1, 2, 3, 3, 2], dtype=float)
    time = np.arange(len(regime), dtype=float)
    found = Course(time, 0.0 * time, 0.0 * time, regime)
    assert found.transitions().tolist() == [4, 8, 10]
    assert_allclose(found.share(2), 0.3)  # rows 4, 7 and 10, each the step that ends there
