"""One thread or two: results are the same, bit for bit."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
VARIABLES = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
ARM = ["time.end=1", "body.arm.elements=8"]
FAST = {
    "arm_rotation": ARM,
    "sunlit_tube": ["time.end=40"],
    "arm_rotation in 3D": [*ARM[1:], "time.end=0.3", "thermal.solver=solid"],
    "arm_rotation by walls": [*ARM[1:], "time.end=0.3", "thermal.solver=wall"],
}
SLOW = {
    "arm_rotation by multigrid": [
        "time.end=0.3", "thermal.solver=solid", "thermal.linear=multigrid",
        "thermal.wall_points=24",
    ],
    "ring_truss": ["time.end=0.2"],
    "ring_clearance": ["generate.ring.level=1", "time.end=0.02"],
    "folding_array": ["time.end=12"],
    "slider_crank": ["time.end=0.01"],
    "sunlit_boom": ["time.end=60"],
}  # fmt: skip

PROGRAM = """
import hashlib, json, sys
import numpy as np
from coupling import casefile
from coupling.journal import packed
from coupling.model import build
from coupling.simulation import windows
found = {}
for name, settings in json.loads(sys.argv[1]).items():
    model = build(casefile.read("cases/" + name.split()[0], settings))
    last = list(windows(model, model.initial()))[-1]
    counts = last.state.motion.counts.tolist()
    found[name] = counts, hashlib.sha256(packed({"end": last.state, "t": last.t})).hexdigest()
print(json.dumps(found))
"""


def ends(cases, threads):
    """Counts of steps and a fingerprint of the state at the end, for each case."""
    words = [sys.executable, "-c", PROGRAM, json.dumps(cases)]
    environment = os.environ | dict.fromkeys(VARIABLES, str(threads))
    said = subprocess.run(words, cwd=ROOT, env=environment, capture_output=True, text=True)
    assert said.returncode == 0, said.stderr
    return json.loads(said.stdout)


def test_results_are_those_of_one_thread():
    assert ends(FAST, 2) == ends(FAST, 1)


@pytest.mark.slow
def test_results_of_large_cases_are_those_of_one_thread():
    assert ends(SLOW, 2) == ends(SLOW, 1)
