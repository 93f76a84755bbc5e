"""What CalculiX and Exudyn tell a crosscheck."""

import os
import shutil

import numpy as np
import pytest
import test_deck
from test_deck import TIP, beam, clamp, force, scene, wall

from coupling.crosscheck import outside
from coupling.crosscheck.outside import measured_by as told

needs_ccx = pytest.mark.skipif(
    shutil.which(os.environ.get("THERMOBODY_CCX", "ccx")) is None, reason="ccx is not installed"
)
STAGES = ["mass", "rigid_modes", "thermal_load", "static", "frequencies", "pointing", "contact"]


def asked(*parts, stages=STAGES, **more):
    table = (
        f'[crosscheck]\nstages = {stages}\nmodes = 2\ncontinuum = [{{ "mechanics.round" = 8 }}]\n'
    )
    return scene(beam(), clamp(), TIP, *parts, table, **more)


def values(found, stage):
    return {q.name: q.value for q in found.quantities[stage]}


@needs_ccx
def test_calculix_tells_all_stages_but_contact():
    case = asked(wall('"35 degC"', '"15 degC"'), force("1 N"), stages=STAGES[:-1])
    found = told("calculix", case)
    assert not found.why
    assert values(found, "mass")["mass"] == pytest.approx(0.27)
    free = values(found, "rigid_modes")
    assert free["boom: first elastic frequency"] == pytest.approx(51.96, rel=2e-3)
    assert free["boom: six rigid frequencies / elastic"] ** 2 < 1e-5  # zero eigenvalues
    bend = test_deck.ALPHA * 20.0 / 0.01
    assert values(found, "thermal_load")["tip: across"][1] == pytest.approx(-bend / 2, rel=2e-3)
    heat_and_load = -bend / 2 - 1.0 / (3 * test_deck.STIFF)
    assert values(found, "static")["tip: displacement"][1] == pytest.approx(heat_and_load, rel=3e-3)
    turn = -1e3 * (bend + 1.0 / (2 * test_deck.STIFF))
    np.testing.assert_allclose(
        values(found, "pointing")["tip: rotation"], [0, 0, turn], rtol=2e-3, atol=1e-3
    )
    assert len(found.quantities["frequencies"]) == 2
    assert set(found.seconds) == {"mass", "rigid_modes", "thermal_load", "static", "frequencies"}


def test_exudyn_tells_what_it_can():
    pytest.importorskip("exudyn")
    found = told("exudyn", asked(force("1 N"), stages=["static", "frequencies"]))
    moved = values(found, "static")["tip: displacement"]
    assert moved[1] == pytest.approx(-1.0 / (3 * test_deck.STIFF), rel=1e-3)
    assert found.dof > 0


def test_exudyn_says_why_it_cannot():
    pytest.importorskip("exudyn")
    case = asked(wall('"35 degC"', '"15 degC"'), stages=["mass", "static"])
    found = told("exudyn", case)
    assert isinstance(found, str) and "no heat" in found


@needs_ccx
def test_a_motion_is_told_at_the_ends_of_windows(monkeypatch):
    monkeypatch.setattr(outside, "STEPS", 4)
    case = asked(
        force("1 N"), stages=["transient", "pointing"], kind="dynamics", end="20 ms", window="5 ms"
    )
    found = told("calculix", case)
    course = values(found, "transient")["tip: displacement, rms"]
    assert course.shape == (5, 3)
    assert not course[0].any()
    assert values(found, "pointing")["tip: rotation, rms"].shape == (5, 3)
