"""What the report on the paper says of Sec. 4.1.3 and Fig. 12."""

import numpy as np
import pytest

from coupling.paper import slider_crank as section
from coupling.paper.workshop import Workshop
from coupling.reports import response_amplitude as shaken
from coupling.reports.timed_runs import Ran
from coupling.verify.registry import Check


class Ready(Workshop):
    """Runs are there already."""

    def run(self, case, variants=(), overrides=None, quantities=None):
        scene = self.scene(case, variants, overrides)
        assert scene.joint["pin"].clearance == pytest.approx(1e-4)
        printed = scene.joint["pin"].contact.dissipation == "hua2026"
        values = {"acceleration": np.array([[-2e5], [1e5]]), "impacts": np.array([[0.0], [20.0]]),
                  "force": np.array([[0.0], [1e4 if printed else 3e4]])}  # fmt: skip
        return Ran("done", "", values=values)

    def verified(self, name):
        return [Check("  times of all of them", 3e-6, 0.0, 1e-5, "turns", True)]


@pytest.fixture
def work(tmp_path):
    return Ready(tmp_path)


def _swept(kind, clearance):
    """Of the describing function."""
    w = np.array(shaken.FREQUENCIES)
    height, place = shaken.expected_peak(clearance)
    return (height - 0.1 * (w - place) ** 2).clip(0.0).tolist()


def test_peaks_and_map_are_set_beside_what_is_printed(work, monkeypatch):
    monkeypatch.setattr(section, "_swept", _swept)
    entries = list(section.entries(work))
    assert [e.place for e in entries] == [
        "Sec. 4.1.3", "Fig. 12 b", "Fig. 12 a", "Fig. 12 c", "Fig. 12 d"
    ]  # fmt: skip
    assert "10 kN" in entries[0].inputs and "30 kN" in entries[0].corrected
    assert entries[1].printed.startswith("4.8 to 5.4")
    assert [e.kind for e in entries[1:4]] == ["trend reproduced"] * 3
    assert all(e.rows == (61,) for e in entries)
    assert all(p.exists() for e in entries for p in e.pictures)


def test_a_trend_that_is_not_there_is_not_said():
    rows = [("spherical", 0.02, 5.0, 9.5), ("spherical", 0.04, 4.9, 9.4)]
    assert section._verdict(rows).startswith("not determined")


def test_ideal_acceleration_is_that_of_a_slider_without_play():
    r, rod, w = 0.05, 0.12, 2.0 * np.pi * 5000.0 / 60.0
    h = 1e-5
    x = [r * np.cos(a) + np.sqrt(rod**2 - (r * np.sin(a)) ** 2) for a in (-w * h, 0.0, w * h)]
    assert abs(x[0] - 2.0 * x[1] + x[2]) / h**2 == pytest.approx(section.IDEAL, rel=1e-4)
