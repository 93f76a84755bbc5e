"""The shipped slider-cranks against ordinary differential equations in fewest coordinates."""

from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from numpy.testing import assert_allclose

from coupling import casefile
from coupling.model import build
from coupling.reading import Results
from coupling.simulation import run
from coupling.verify import contact_references as references
from coupling.verify.contact_references import Law, Swing

CASES = Path(__file__).parent.parent / "cases"
TURN = 0.012
HALF = 0.5 * TURN


class Recorded(NamedTuple):
    """Onsets (k,) [s] with their approach speeds, largest force [N]; the slider's way along x.

    time : (w,) [s];  velocity, acceleration : (w,);  ledger : [J] at the end
    """

    onsets: np.ndarray
    speeds: np.ndarray
    peak: float
    time: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    ledger: dict[str, float]


@cache
def recorded(folder: Path, case: str, *settings: str) -> Recorded:
    """The first half turn."""
    scene = casefile.read(CASES / case, [f"time.end={HALF}", *settings])
    outcome = run(scene, folder)
    assert outcome.code == 0
    with Results.open(outcome.folder) as results:
        events, probe = results.table("events"), results.table("probes/slider")
        begun = events["kind"] == 1
        ledger = {name: float(results[f"ledger/{name}"][-1]) for name in results.names("ledger")}
        return Recorded(
            events["time"][begun], events["speed"][begun],
            float(results["contacts/peak_force"].max()), probe["time"],
            probe["velocity"][:, 0], probe["acceleration"][:, 0], ledger,
        )  # fmt: skip


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    return tmp_path_factory.mktemp("slider_crank")


def pin(clearance: float) -> Swing:
    """The reference of half a turn with a loose pin."""
    radius = references.BEARING_RADIUS - clearance
    stiffness = references.hertz_in_a_bore(
        radius, clearance, references.YOUNG, references.POISSON
    )  # fmt: skip
    law = Law(stiffness, factor=references.lankarani_nikravesh(0.9))
    return references.slider_crank(clearance, t_end=HALF, law=law, samples=601)


@pytest.mark.parametrize("clearance", [1e-4, 2e-4, 5e-4])
def test_a_loose_pin_hits_as_in_the_differential_equations(folder, clearance):
    """Errors grow from impact to impact; the first ones, and the motion on average, are compared.

    The approach speed, on which the losses depend, is that at the onset in the reference, and the
    largest since in the solver: later forces differ a little.
    """
    settings = [f"joint.pin.clearance={clearance}", f"joint.pin.radius={0.01 - clearance}"]
    ours, exact = recorded(folder, "slider_crank", *settings), pin(clearance)
    first = exact.impacts[:3]
    assert_allclose(ours.onsets[:3], [one.t for one in first], rtol=0.0, atol=2e-4 * TURN)
    assert_allclose(ours.speeds[:3], [one.speed for one in first], rtol=5e-3)
    assert_allclose(ours.peak, exact.force.max(), rtol=0.1)
    off = np.interp(exact.t, ours.time, ours.velocity) - exact.velocity
    assert np.sqrt(np.mean(off**2)) < 0.03 * np.abs(exact.velocity).max()


def test_the_drive_turns_from_the_start(folder):
    """No energy is lost in getting it going, and the integrator loses little later."""
    ledger = recorded(folder, "slider_crank").ledger
    assert abs(ledger["numerical"]) < 0.02 * ledger["hysteresis"]
    assert abs(ledger["defect"]) < 1e-6 * ledger["kinetic"]


def test_the_acceleration_of_a_probe_is_that_of_the_motion(folder):
    """What it adds up to between two times is the change of the velocity."""
    ours = recorded(folder, "slider_crank", "time.window=2e-6")
    gained = np.cumsum(0.5 * np.diff(ours.time) * (ours.acceleration[1:] + ours.acceleration[:-1]))
    change = ours.velocity[1:] - ours.velocity[0]
    assert np.abs(gained - change).max() < 5e-3 * np.abs(change).max()


@pytest.mark.parametrize("clearance", [1e-4, 5e-4])
def test_a_loose_slider_hits_as_in_the_differential_equations(folder, clearance):
    """Both corners of a side hit at once: each impact has two onsets."""
    ours = recorded(folder, "slider_crank_guide", f"joint.guide.clearance={clearance}")
    exact = references.slider_in_guide(clearance, t_end=HALF, samples=601)
    known = np.array([one.t for one in exact.impacts])
    count = min(6, len(known))
    assert_allclose(np.sort(ours.onsets)[:count], known[:count], rtol=0.0, atol=1e-3 * TURN)
    off = np.interp(exact.t, ours.time, ours.velocity) - exact.velocity
    assert np.sqrt(np.mean(off**2)) < 1e-2 * np.abs(exact.velocity).max()


@pytest.mark.parametrize("case", ["slider_crank", "slider_crank_guide"])
def test_no_joint_repeats_another(case):
    """Motions that are left: the driven crank's none; of the rod or the slider two across."""
    model = build(casefile.read(CASES / case))
    system = model.motion_solver.system
    assert system.n - system.m == 2
