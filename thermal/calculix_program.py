"""The program ``ccx``: where it is, and running it on a deck."""

import os
import shutil
import subprocess
from pathlib import Path

PROGRAM = "THERMOBODY_CCX"
"""Environment variable that names the program, if it is not the ccx of the search path."""


def program() -> str:
    """The path of the program.

    Raises
    ------
    ValueError : it is not installed
    """
    named = os.environ.get(PROGRAM, "ccx")
    found = shutil.which(named)
    if found is None:
        raise ValueError(
            f"ccx is not installed: there is no program '{named}'; "
            f"install calculix-ccx, or name it in the environment variable {PROGRAM}"
        )
    return found


def executed(program: str, job: Path, patience: float) -> tuple[str, int]:
    """What it said and its exit code; on one thread, as sums over threads vary.

    job : of the files without their suffix;  patience : float [s]
    """
    threads = {"OMP_NUM_THREADS": "1", "CCX_NPROC_EQUATION_SOLVER": "1", "CCX_NPROC_RESULTS": "1"}
    try:
        done = subprocess.run(
            [program, job.name],
            cwd=job.parent,
            env=os.environ | threads,
            capture_output=True,
            text=True,
            errors="replace",
            check=False,
            timeout=patience,
        )
    except OSError as error:
        return str(error), 1
    except subprocess.TimeoutExpired:
        return f"it was still at work after {patience:g} s", 1
    return done.stdout + done.stderr, done.returncode
