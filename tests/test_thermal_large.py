"""Speed and memory of large heat models in 3D, measured in one run against other programs."""

import os
import resource
import shutil
import subprocess
import sys
from statistics import median

import numpy as np
import pytest

from coupling.reports.heat_rivals import DIRECT, calculix, ours, plain
from thermal import petsc

CCX = pytest.mark.skipif(shutil.which("ccx") is None, reason="CalculiX is not installed here")


def test_scikit_fem_has_the_same_answer():
    found = ours(5, 3, "multigrid").T
    assert np.abs(found - plain(5, 3).T).max() < 1e-6


@CCX
def test_calculix_has_the_same_answer():
    """But for c at the end of a step instead of its mean over it."""
    found = ours(5, 3, "multigrid").T
    assert np.abs(found - calculix(5, 3).T).max() < 0.02


def test_one_step_of_heat_is_linear_in_the_size():
    """Iterations do not grow with the mesh: at most 2 more for 8 times the temperatures."""
    from coupling.reports.heat_rivals import STEP, description
    from thermal.description import Settings
    from thermal.solvers import build

    most = []
    for cells in (10, 20):
        settings = Settings(scheme="backward-euler", steps=1, linear="multigrid")
        solver = build("solid", description(cells), settings)
        _, _, why = solver.advance(solver.initial(), 0.0, STEP, np.zeros(len(solver.x)))
        assert why == ""
        most.append(solver.linear.iterations)
    assert most[1] <= most[0] + 2


@CCX
@pytest.mark.benchmark
def test_steps_of_50_000_temperatures_against_scikit_fem_and_calculix():
    """CalculiX with its usual solver and with its iterative one, which is far faster."""
    ours(3, 1, "multigrid")
    own, skfem = ours(36, 4, "multigrid"), plain(36, 2)
    ccx, iterative = calculix(36, 1, DIRECT), calculix(36, 2)
    step = median(own.steps[1:])
    again = ours(36, 2, "multigrid").T
    print(
        f"\n50,653 temperatures: ours {step:.2f} s (first {own.steps[0]:.2f} s); "
        f"scikit-fem {min(skfem.steps):.2f} s, differs by {np.abs(skfem.T - again).max():.1g} K; "
        f"CalculiX {ccx.steps[0]:.2f} s, iterative {iterative.steps[0]:.2f} s, "
        f"differs by {np.abs(iterative.T - again).max():.1g} K"
    )
    assert min(skfem.steps) >= 10.0 * step
    assert ccx.steps[0] >= 50.0 * step
    assert iterative.steps[0] >= 5.0 * step


LARGE = """
import resource, sys
from statistics import median
from coupling.reports.heat_rivals import ours
ours(3, 1, "multigrid")
for cells in (36, 79):
    found = ours(cells, 3, sys.argv[1])
    used = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
    print(len(found.T), found.start, found.steps[0], median(found.steps[1:]), used)
"""


@pytest.mark.benchmark
@pytest.mark.parametrize("linear", ["multigrid", "petsc"])
def test_half_a_million_temperatures(linear):
    """In less than 8 GB, at a cost that grows about linearly."""
    if linear == "petsc":
        try:
            petsc.interpreter()
        except ValueError:
            pytest.skip("no Python here has petsc4py")
    command = [sys.executable, "-c", LARGE, linear]
    ended = subprocess.run(command, capture_output=True, text=True, check=True, env=os.environ)
    rows = np.array([line.split() for line in ended.stdout.splitlines()], float)
    server = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 2**20
    for n, start, first, step, used in rows:
        print(f"\n{linear}, {n:.0f}: start {start:.1f}, first {first:.1f}, step {step:.2f} s, "
              f"{used:.2f} GB; largest child {server:.2f} GB")  # fmt: skip
    assert max(rows[-1, -1], server) < 8.0
    assert rows[1, 3] / rows[0, 3] < 2.0 * rows[1, 0] / rows[0, 0]
