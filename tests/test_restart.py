"""A run that is broken off after any window and resumed ends as if it had never been, bit for bit.

Whatever the solvers: nothing that later windows depend on may stand outside of the state.
"""

from pathlib import Path

import numpy as np
import pytest
from heat_cases import varying
from run_folders import assert_same, assert_same_results, consistent

from coupling import casefile, simulation
from coupling.journal import packed, unpacked
from coupling.progress import Progress
from meshes.solids import box
from thermal import multigrid, solvers
from thermal.description import Description, Film, Radiation, Settings, Solid

ROOT = Path(__file__).parent.parent
ARM = ("time.end=1", "body.arm.elements=4", "output.frames=4", "output.export=[]")
SOLID = (*ARM, "time.end=0.5", "body.arm.elements=2")
LIGHT = ("time.end=40", "output.frames=4", "output.export=[]")
STROKE = (  # over two elements of the boom
    "time.end=0.6", "body.boom.elements=6", "body.arm.elements=6", "joint.sleeve.stations=0",
    "time.window=0.1", "output.frames=4", "output.export=[]",
    "joint.screw.travel.s_curve.start=0 s", "joint.screw.travel.s_curve.rate=40 m/s",
    "joint.screw.travel.s_curve.rise=0.1 s",
)  # fmt: skip
CASES = {
    "line": ("arm_rotation", ARM),
    "hermite": ("arm_rotation", (*ARM, "thermal.solver=hermite")),
    "wall": ("arm_rotation", (*ARM, "thermal.solver=wall")),
    "lumped": ("arm_rotation", (*ARM, "thermal.solver=lumped")),
    "solid": ("arm_rotation", (*SOLID, "thermal.solver=solid")),
    "multigrid": ("arm_rotation", (*SOLID, "thermal.solver=solid", "thermal.linear=multigrid")),
    "serial": ("arm_rotation", (*ARM, "coupling.scheme=serial")),
    "parallel": ("arm_rotation", (*ARM, "coupling.scheme=parallel")),
    "iterated": ("arm_rotation", (*ARM, "coupling.scheme=iterated")),
    "adaptive": ("arm_rotation", (*ARM, "coupling.adaptive.tolerance=0.01")),
    "generalised-alpha": ("arm_rotation", (*ARM, "integrator.scheme=generalised-alpha")),
    "bdf2": ("arm_rotation", (*ARM, "integrator.scheme=bdf2", "integrator.tolerance=1e-4")),
    "sunlit tube": ("sunlit_tube", LIGHT),
    "folding array": ("folding_array", (*LIGHT, "time.end=12")),
    "telescope": ("arm_extension", STROKE),
    "slider crank": ("slider_crank_guide", ("time.end=2e-4", "output.export=[]")),
}
SLOW = {
    "calculix": ("arm_rotation", (*SOLID, "thermal.solver=calculix")),
    "ring truss": ("ring_truss", ("generate.ring.level=1", "time.end=0.5", "output.export=[]")),
    "ring with clearance": (
        "ring_clearance",
        ("generate.ring.level=1", "time.end=0.1", "time.window=0.01", "output.export=[]"),
    ),
}


class Killed(BaseException):
    """Nobody catches it, as nobody catches SIGKILL."""


def killed_after(count, scene, folder, monkeypatch, resume=False):
    """Break a run off after ``count`` windows; what it has written is left as it is."""
    seen = []

    def window(self, model, done):
        seen.append(done)
        if len(seen) == count:
            raise Killed

    with monkeypatch.context() as patch, pytest.raises(Killed):
        patch.setattr(Progress, "window", window)
        simulation.run(scene, folder, resume)


def assert_resumes(case, settings, tmp_path, monkeypatch):
    """Broken off after the second window, and after the third of those that follow."""
    scene = casefile.read(ROOT / "cases" / case, settings)
    whole = simulation.run(scene, tmp_path / "whole")
    assert whole.code == 0
    windows = len(consistent(whole.folder)[0]["windows"]["time"])
    assert windows >= 5
    killed_after(2, scene, tmp_path / "parts", monkeypatch)
    killed_after(3 if windows > 5 else 1, scene, tmp_path / "parts", monkeypatch, resume=True)
    assert_same_results(simulation.run(scene, tmp_path / "parts", resume=True), whole)


@pytest.mark.parametrize("name", CASES)
def test_a_resumed_run_ends_as_the_whole_one(name, tmp_path, monkeypatch):
    assert_resumes(*CASES[name], tmp_path, monkeypatch)


@pytest.mark.slow
@pytest.mark.parametrize("name", SLOW)
def test_a_resumed_run_of_a_large_case_ends_as_the_whole_one(name, tmp_path, monkeypatch):
    assert_resumes(*SLOW[name], tmp_path, monkeypatch)


# ------------------------------------------------------------- heat whose solutions are inexact


def cooled(linear="multigrid", size=(0.1, 0.1, 0.1), counts=(14, 14, 14), **settings):
    """A box that radiates and is blown at; k and c vary."""
    conditions = (
        Film("film", "box", lambda t: 5.0 + t, lambda t: 300.0, "x1"),
        Radiation("space", "box", 0.8, lambda t: 3.0),
    )
    solid = Solid("box", box(size, counts), {"": varying()}, 400.0)
    description = Description(solids=(solid,), conditions=conditions)
    return solvers.build("solid", description, Settings(linear=linear, **settings))


def marched(solver, T, begin, end):
    """Temperatures after each interval of 5 s, and what the solver then remembered."""
    found = []
    for i in range(begin, end):
        T, _, why = solver.advance(T, 5.0 * i, 5.0, np.zeros_like(T))
        assert why == ""
        found.append((T, read_again(solver.memory())))
    return found


def read_again(memory):
    """What a journal would give back."""
    return unpacked(packed(memory))


HEATS = {
    "aggregation": {},
    "backward euler": {"scheme": "backward-euler", "steps": 1},
    "classical": {"size": (0.4, 0.4, 0.002), "counts": (40, 40, 2)},
    "direct": {"linear": "direct", "counts": (6, 6, 6)},
}


@pytest.mark.parametrize("name", HEATS)
def test_heat_goes_on_from_temperatures_and_memory(name):
    solver = cooled(**HEATS[name])
    whole = marched(solver, solver.initial(), 0, 7)
    for k in (0, 2, 5):
        other = cooled(**HEATS[name])
        T, memory = whole[k]
        other.remember(memory)
        rest = marched(other, T, k + 1, 7)
        for (ours, our_memory), (theirs, their_memory) in zip(rest, whole[k + 1 :], strict=True):
            assert np.array_equal(ours, theirs)
            assert_same(our_memory, their_memory)


def test_memory_is_needed_by_multigrid_only():
    solver = cooled()
    whole = marched(solver, solver.initial(), 0, 3)
    forgetful = marched(cooled(), whole[0][0], 1, 3)
    difference = np.abs(forgetful[-1][0] - whole[-1][0]).max()
    assert 0.0 < difference < 1e-6
    assert cooled(linear="direct", counts=(4, 4, 4)).memory() == {}


def test_direct_solutions_after_multigrid_has_failed_are_found_again(monkeypatch):
    monkeypatch.setattr(multigrid, "ITERATIONS", 1)
    solver, other = cooled(), cooled()
    (T, memory), *rest = marched(solver, solver.initial(), 0, 3)
    assert solver.linear.fallen_back
    other.remember(memory)
    for (ours, _), (theirs, _) in zip(marched(other, T, 1, 3), rest, strict=True):
        assert np.array_equal(ours, theirs)
