"""Ctrl-C reaches Python while compiled code is at work: nothing may swallow it."""

import signal

import numpy as np
import pytest

from mechanics.description import Description, Force, RigidBody, Site, Spring
from mechanics.dynamics import Control
from mechanics.kernels import INTERRUPTS
from mechanics.solver import Mechanics

ROOM = np.zeros((0, 3))


@pytest.fixture(autouse=True)
def heard():
    """Ctrl-C as Python takes it: what is started in the background inherits that it is ignored."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def pulled(amplitude, solver="auto") -> Mechanics:
    """A mass on a spring under a force in time."""
    body = RigidBody("mass", np.zeros(3), 1.0, np.eye(3))
    wall = Site(None, position=np.array([-1.0, 0.0, 0.0]))
    spring = Spring("spring", Site("mass"), wall, stiffness=100.0)
    force = Force("force", Site("mass"), np.array([1.0, 0.0, 0.0]), amplitude)
    return Mechanics(Description([body], [spring], [force]), Control(1e-6, 1e-2), solver)


def test_in_a_function_of_time() -> None:
    """The march ends at once and the interrupt is raised; then one can go on as if nothing was."""
    calls = []

    def amplitude(t: float) -> float:
        calls.append(t)
        if len(calls) == 20:
            signal.raise_signal(signal.SIGINT)
        return float(np.sin(t))

    solver = pulled(amplitude)
    start = solver.initial(ROOM)
    with pytest.raises(KeyboardInterrupt):
        solver.advance(start, 10.0, ROOM, ROOM)
    assert len(calls) == 20, "no function is asked any more"
    assert not INTERRUPTS
    again, _, why = solver.advance(start, 1.0, ROOM, ROOM)
    other, _, _ = pulled(lambda t: float(np.sin(t))).advance(start, 1.0, ROOM, ROOM)
    assert not why and np.array_equal(again.motion.q, other.motion.q)


def test_in_a_library_that_factorises(monkeypatch: pytest.MonkeyPatch) -> None:
    """The linear solver of another library is Python for the march."""
    from mechanics import libraries

    calls = []
    splu = libraries.splu

    def interrupted(*things):
        calls.append(1)
        if len(calls) == 3:
            signal.raise_signal(signal.SIGINT)
        return splu(*things)

    monkeypatch.setattr(libraries, "splu", interrupted)
    solver = pulled(lambda t: 1.0, "superlu")
    with pytest.raises(KeyboardInterrupt):
        solver.advance(solver.initial(ROOM), 10.0, ROOM, ROOM)
    assert not INTERRUPTS
