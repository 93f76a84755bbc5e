"""Heat by a participant in another process."""

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from threading import Thread

import numpy as np
import pytest

from coupling import casefile, wire
from coupling.errors import BadCase
from coupling.external_heat import ExternalHeat
from coupling.model import build
from coupling.simulation import Done, Stopped, windows

ROOT = Path(__file__).parent.parent

CASE = """
[time]
end = "2 s"
window = "0.1 s"

[integrator]
largest_step = "20 ms"

[coupling]
scheme = "corrected"
smallest_window = "50 ms"

[section.tube]
kind = "tube"
mean_radius = "0.1 m"
thickness = "2 mm"

[body.arm]
kind = "beam"
start = [0, 0, 0]
end = ["5 m", 0, 0]
elements = 4
normal = [0, 1, 0]
section = "tube"
material = "al6061"
damping = "2 ms"

[joint.hinge]
kind = "clearance_revolute"
journal = { body = "arm", at = "start" }
axis = [0, 0, 1]
radius = "25 mm"
clearance = "0.05 mm"
journal_material = "steel-304"
bearing_material = "al6061"
angle = { s_curve = { rate = "2 deg/s", rise = "1 s", total = "10 deg" } }

[joint.hinge.contact]
restitution = 0.85

[joint.hinge.friction]
coefficient = 0.1
regularisation_speed = "1e-5 m/s"

[thermal]
solver = "line"
initial = "25 degC"

[thermal.flux.sun]
body = "arm"
density = "1361 W/m^2"
absorptivity = 0.3
direction = [0, -1, 0]

[thermal.part.journal]
of = "hinge.journal"
material = "steel-304"
mass = "1.5 kg"

[thermal.part.bearing]
of = "hinge.bearing"
material = "al6061"
mass = "2 kg"
"""


@pytest.fixture
def case(tmp_path: Path) -> Path:
    folder = tmp_path / "case"
    folder.mkdir()
    (folder / "case.toml").write_text(CASE)
    return folder


def external(address: str) -> list[str]:
    return ["thermal.solver=external", f"thermal.participant.address='{address}'"]


@contextmanager
def participant(case: Path, address: str, *settings: str) -> Iterator[subprocess.Popen]:
    """A thermal solver of the case in another process."""
    command = [sys.executable, "-m", "coupling.cli", "participant", str(case), "--listen", address]
    command += [part for s in settings for part in ("--set", s)]
    process = subprocess.Popen(
        command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    )
    try:
        yield process
    finally:
        process.kill()
        process.wait()


def listening(process: subprocess.Popen) -> str:
    """The address, once it listens there."""
    assert process.stdout is not None
    line = process.stdout.readline()
    assert line.startswith("listening at "), line + process.stdout.read()
    return line.removeprefix("listening at ").strip()


def test_same_bits_as_in_one_process(case: Path, tmp_path: Path) -> None:
    """Over a socket nothing is lost, and checkpoints make the corrector's repetition exact."""
    here = list(_states(case, []))
    with participant(case, "127.0.0.1:0") as other:
        there = list(_states(case, external(listening(other))))
        assert other.wait(20) == 0, "it ends with the run"
    assert len(here) == len(there) == 20
    for a, b in zip(here, there, strict=True):
        assert np.array_equal(a.T, b.T)
        assert np.array_equal(a.motion.motion.q, b.motion.motion.q)
        assert a.flows == b.flows
    assert here[-1].released > 0.0 and here[-1].T.max() > 298.3


def _states(case: Path, settings: list[str]) -> Iterator:
    model = build(casefile.read(case, settings))
    for window in windows(model, model.initial()):
        assert isinstance(window, Done), window
        yield window.state


def test_participant_that_dies_stops_the_run_and_can_be_replaced(
    case: Path, tmp_path: Path
) -> None:
    """The run stops with the reason; with a new participant it goes on to the same end."""
    whole = list(_states(case, []))
    address = str(tmp_path / "socket")
    settings = external(address)
    with participant(case, address) as other:
        assert listening(other) == address
        model = build(casefile.read(case, settings))
        ongoing = windows(model, model.initial())
        done = [next(ongoing) for _ in range(5)][-1]
        other.send_signal(signal.SIGKILL)
        other.wait()
        stopped = next(ongoing)
    assert isinstance(stopped, Stopped) and stopped.t == done.t
    assert f"heat: participant at {address}: " in stopped.why
    os.unlink(address)
    assert isinstance(done, Done)
    with participant(case, address) as other:
        listening(other)
        model = build(casefile.read(case, settings))
        ends = list(windows(model, done.state, done.tick, done.size))
    assert isinstance(ends[-1], Done)
    assert np.array_equal(ends[-1].state.T, whole[-1].T)
    assert np.array_equal(ends[-1].state.motion.motion.q, whole[-1].motion.motion.q)


def test_other_case_is_refused(case: Path, tmp_path: Path) -> None:
    address = str(tmp_path / "socket")
    with participant(case, address, "thermal.flux.sun.absorptivity=0.4") as other:
        listening(other)
        with pytest.raises(BadCase, match=r"its case has another \[thermal\] than the run"):
            build(casefile.read(case, external(address)))


def test_nobody_there(case: Path, tmp_path: Path) -> None:
    with pytest.raises(BadCase, match=r"nobody answers at .*; start the participant first"):
        build(casefile.read(case, external(str(tmp_path / "nothing"))))


@pytest.mark.parametrize(
    ("settings", "where", "text"),
    [
        (["thermal.solver=external"], "thermal.participant", "missing"),
        (["thermal.participant.address='a:1'"], "thermal.participant", "belongs to the solver"),
        (external("there"), "thermal.participant.address", "HOST:PORT or the path"),
        (external("host:123456"), "thermal.participant.address", "HOST:PORT or the path"),
        (
            [*external("a:1"), "thermal.elastic.bodies=['arm']"],
            "thermal.elastic",
            "of a solver of this process",
        ),
    ],
)
def test_bad_tables(case: Path, settings: list[str], where: str, text: str) -> None:
    with pytest.raises(BadCase) as error:
        casefile.read(case, settings)
    assert any(p.path == where and text in p.text for p in error.value.problems)


# ---------------------------------------------------------------- a participant of another kind


class Slab:
    """A lumped body that knows nothing of this program but the words, with memory of its own.

    It takes heat only after a delay: what was deposited in one window warms it in the next. Its
    temperature alone does not tell its state, so that only checkpoints can bring it back.
    """

    def __init__(self, rows: int, capacity: float) -> None:
        self.T, self.delayed, self.capacity = np.full(rows, 300.0), np.zeros(rows), capacity
        self.kept = (self.T, self.delayed)
        self.heat = np.zeros(rows)
        self.words: list[str] = []

    def answer(self, m: wire.Message) -> tuple:
        self.words.append(m.word)
        match m.word:
            case "initialize":
                n = len(self.T)
                regions = {"arm": [0], "hinge.journal": [1], "hinge.bearing": [2]}
                x = np.zeros((n, 3))
                return "mesh", {"name": "slab", "regions": regions}, {"x": x, "T": self.T}
            case "set_state":
                self.T, self.delayed = m.arrays["T"], np.zeros_like(self.T)
            case "write_checkpoint":
                self.kept = (self.T, self.delayed)
            case "read_checkpoint":
                self.T, self.delayed = self.kept
            case "write_data":
                self.heat = m.arrays["heat"]
            case "advance":
                self.T, self.delayed = self.T + self.delayed / self.capacity, self.heat
                return "done", {"why": "", "flows": {}}, {}
            case "read_data":
                return "data", {}, {"T": self.T}
            case "energy":
                return "done", {"energy": self.capacity * float(m.arrays["T"].sum())}, {}
        return "done", {}, {}


def _serve(slab: Slab, here) -> None:
    line, _ = here.accept()
    with line, line.makefile("rwb") as stream:
        while (message := wire.receive(stream)).word != "finalize":
            wire.send(stream, *slab.answer(message))


@pytest.fixture
def slab(tmp_path: Path) -> Iterator[tuple[Slab, ExternalHeat]]:
    slab = Slab(3, 10.0)
    with wire.listen(str(tmp_path / "slab")) as here:
        thread = Thread(target=_serve, args=(slab, here), daemon=True)
        thread.start()
        yield slab, ExternalHeat(str(tmp_path / "slab"), 10.0, "")


def test_state_that_temperatures_do_not_show_is_rolled_back(slab) -> None:
    """Each window twice, as a corrector does it: as if each had been done once, by hand."""
    own, solver = slab
    T, t, h = solver.initial(), 0.0, 0.1
    expected, delayed = T.copy(), np.zeros(3)
    for heat in (np.array([1.0, 2.0, 3.0]), np.array([0.5, 0.0, 1.0]), np.ones(3)):
        _, _, why = solver.advance(T, t, h, 10.0 * heat)
        assert not why
        T, _, why = solver.advance(T, t, h, heat)
        assert not why
        expected, delayed = expected + delayed / 10.0, heat
        assert np.array_equal(T, expected)
        t += h
    assert own.words.count("read_checkpoint") == 3
    assert own.words.count("write_checkpoint") == 3
    assert "set_state" in own.words[:3] and own.words.count("set_state") == 1


def test_energy_and_going_on_from_elsewhere(slab) -> None:
    own, solver = slab
    assert solver.energy(np.array([1.0, 2.0, 3.0])) == 60.0
    T, _, why = solver.advance(np.array([5.0, 6.0, 7.0]), 3.0, 0.1, np.ones(3))
    assert not why and np.array_equal(T, [5.0, 6.0, 7.0])
    assert own.words[2:4] == ["set_state", "write_checkpoint"]


# ------------------------------------------------------------------------------------ messages


def test_messages_keep_every_bit() -> None:
    arrays = {"a": np.array([np.pi, -0.0, 5e-324, np.inf]), "b": np.arange(6.0).reshape(2, 3)}
    stream = BytesIO()
    wire.send(stream, "word", {"why": "ä", "n": 3}, arrays)
    stream.seek(0)
    found = wire.receive(stream)
    assert found.word == "word" and found.fields == {"why": "ä", "n": 3}
    assert all(found.arrays[k].tobytes() == v.tobytes() for k, v in arrays.items())
    assert found.arrays["b"].shape == (2, 3)


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"\x01",
        b"\xff\xff\xff\xff",
        b"\x04\x00\x00\x00nope",
        b"\x02\x00\x00\x00{}",
        wire.LENGTH.pack(44) + b'{"word": "w", "arrays": [["a", [99999999999]]]}'[:44],
        wire.LENGTH.pack(38) + b'{"word": "w", "arrays": [["a", [-1]]]}',
    ],
)
def test_what_is_no_message_is_an_error(data: bytes) -> None:
    with pytest.raises(OSError):
        wire.receive(BytesIO(data))
