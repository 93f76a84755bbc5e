"""Steps whose new Jacobians keep what the bodies add, where contacts call for them."""

import numpy as np
import pytest

from coupling.verify.models import ROOM, clamp, elastic, model, straight
from mechanics.description import ClearanceRevolute, Friction, NormalContact, Site
from mechanics.dynamics import Control, Window, advance, initial_state
from mechanics.march import loop
from mechanics.schemes import Scheme
from meshes.sections import tube

METAL = elastic(7e10, 0.3, 2700.0)
SPAN, WINDOWS = 20e-3, 3


@pytest.fixture(scope="module")
def beam():
    """A clamped tube whose free end falls into the play of a pin, and rebounds."""
    arm = straight(1.0, 4, tube(0.02, 1e-3, 0.3), METAL)
    pin = ClearanceRevolute(
        "pin", Site("beam", 4), Site(None, position=np.array([1.0, 0.0, 0.0])),
        np.array([0.0, 1.0, 0.0]), 10e-3, 20e-6, METAL, METAL, ROOM,
        contact=NormalContact(restitution=0.85), friction=Friction(0.1),
    )  # fmt: skip
    return model([arm], [clamp(), pin], gravity=(0.0, 0.0, -9.81))


def windows(made, monkeypatch, kept, count=WINDOWS, begin=None):
    """States at the ends of the windows, from the start or from a state."""
    monkeypatch.setattr(loop, "LARGE", 0 if kept else 10**9)
    system, how = made.system, Control(1e-5, 1e-3, scheme=Scheme(newton_tolerance=1e-10))
    state = begin if begin is not None else initial_state(system, how, made.coef)[0]
    found = []
    for _ in range(count):
        window = Window.between(system, state.motion.t, SPAN, made.coef, None)
        state, _, why = advance(system, how, state, window)
        assert why == ""
        found.append(state)
    return found


def test_the_motion_is_that_with_bodies_taken_anew(beam, monkeypatch):
    """What Newton leaves is all that may differ, far below what the local error allows."""
    kept = windows(beam, monkeypatch, True)[-1]
    anew = windows(beam, monkeypatch, False)[-1]
    assert anew.counts[3] > 4 * WINDOWS  # contacts call for new Jacobians
    assert not np.array_equal(kept.motion.q, anew.motion.q)  # something was kept
    np.testing.assert_array_equal(kept.counts[:2], anew.counts[:2])
    assert kept.counts[2] < 1.1 * anew.counts[2]
    assert kept.counts[3] < 1.2 * anew.counts[3]
    way = np.abs(anew.motion.q - beam.system.layout.q0).max()
    assert np.abs(kept.motion.q - anew.motion.q).max() < 1e-4 * way


def test_nothing_of_them_outlives_a_window(beam, monkeypatch):
    """A motion that goes on from the end of a window is the same to the last bit."""
    whole = windows(beam, monkeypatch, True)
    rest = windows(beam, monkeypatch, True, WINDOWS - 1, begin=whole[0])
    for one, other in zip(whole[-1].motion, rest[-1].motion, strict=True):
        np.testing.assert_array_equal(one, other)
    np.testing.assert_array_equal(whole[-1].ledger, rest[-1].ledger)
