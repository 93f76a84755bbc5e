"""A scene with every kind of body, joint, load and boundary condition, from text to results."""

from pathlib import Path

import numpy as np
import pytest

from coupling import casefile, simulation
from coupling.results import Results

TEXT = Path(__file__).with_name("everything.toml")


@pytest.fixture(scope="module", params=["serial", "corrected"])
def results(request, tmp_path_factory):
    scene = casefile.read(TEXT, [f"coupling.scheme={request.param}"])
    outcome = simulation.run(scene, tmp_path_factory.mktemp(request.param))
    assert outcome.code == 0, outcome.reason
    with Results.open(outcome.folder) as opened:
        yield opened


def test_balances_close(results):
    ledger = {name: column[-1] for name, column in results.table("ledger").items()}
    motion = {name: x for name, x in ledger.items() if not name.startswith("heat_")}
    assert abs(ledger["defect"]) < 1e-6 * max(map(abs, motion.values()))
    flows = [x for name, x in ledger.items() if name.startswith(("heat_", "friction"))]
    assert abs(ledger["heat_defect"]) < 1e-9 * sum(map(abs, flows))


def test_every_feature_left_a_trace(results):
    ledger = {name: column[-1] for name, column in results.table("ledger").items()}
    for name in ("work_loads", "work_drive", "work_thermal", "friction", "damping",
                 "heat_flux.sun", "heat_radiation.space", "heat_source.heater"):  # fmt: skip
        assert abs(ledger[name]) > 1e-9, name
    assert ledger["heat_source.heater"] == pytest.approx(5.0 * 0.2, rel=1e-9)
    assert set(results.names("bodies")) == {
        "upper", "lower", "tie", "weight", "box", "hoop", "sail"
    }  # fmt: skip
    assert results["probes/corner/position"][-1, 2] > 1e-7  # the traction lifts the sail
    # spin, motor and coil alone; the damper and the link to the hoop do a little
    rate, still = (20.0 / 0.4) ** 0.5, 1.0 / 20.0
    turn = np.radians(10.0) / rate * np.sin(0.2 * rate) + still * (1.0 - np.cos(0.2 * rate))
    assert results["bodies/box/axes"][-1, 0, 0, 1] == pytest.approx(np.sin(turn), rel=0.05)


def test_joints_hold(results):
    at = {name: results[f"bodies/{name}/position"] for name in ("upper", "lower", "tie", "weight")}
    assert np.abs(at["upper"][:, -1] - at["lower"][:, 0]).max() < 1e-12
    assert np.abs(at["lower"][:, -1] - at["tie"][:, 0]).max() < 1e-12
    assert np.abs(at["tie"][:, -1] - at["weight"][:, 0]).max() < 1e-12
    orbit = np.linalg.norm(results["joints/shoulder/orbit"], axis=1)
    gap = orbit - results["joints/shoulder/clearance"]
    assert gap.max() == pytest.approx(results["joints/shoulder/penetration"].max(), rel=1e-6)
    assert np.all(results["joints/shoulder/normal_force"][gap < 0.0] == 0.0)


def test_drives_turn_what_they_drive(results):
    axes = results["bodies/upper/axes"][-1]
    turned = np.arctan2(-axes[0, 1, 0], axes[0, 1, 1])
    assert turned == pytest.approx(np.radians(20.0) * 0.1, abs=1e-9)
