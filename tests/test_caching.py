"""Compiled code on disk is used again, unless a file that it takes helpers from has changed."""

import re
import subprocess
import sys

from mechanics.caching import PACKAGE, sources

HELPER = """
from numba import njit

@njit
def helper():
    return 1
"""
CALLER = """
from numba import njit
from mechanics.kernels import kernel
from mechanics.helping import helper

@njit(cache=True)
def caller():
    return helper()
"""
RUN = "from mechanics.calling import caller; print(caller(), sum(caller.stats.cache_hits.values()))"


def test_a_helper_that_has_changed_is_compiled_anew(tmp_path):
    package = tmp_path / "mechanics"
    package.mkdir()
    for name in ("__init__", "caching", "kernels"):
        (package / f"{name}.py").write_text((PACKAGE / f"{name}.py").read_text(encoding="utf-8"))
    (package / "calling.py").write_text(CALLER)

    def called(text):
        (package / "helping.py").write_text(text)
        command = [sys.executable, "-c", RUN]
        ended = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=60)
        assert ended.returncode == 0, ended.stderr
        return ended.stdout.split()

    assert called(HELPER) == ["1", "0"]
    assert called(HELPER) == ["1", "1"]
    assert called(HELPER.replace("1", "2")) == ["2", "0"]


def test_sources_are_followed_through_files():
    names = {file.relative_to(PACKAGE).as_posix() for file in sources(PACKAGE / "march/loop.py")}
    assert {"march/steps.py", "march/store.py", "contact_laws.py", "kernels.py"} <= names
    assert "dynamics.py" not in names


def test_compiled_files_that_import_others_are_watched():
    """``kernels`` sets the watch, before anything is compiled in a file that imports it."""
    compiled = [
        file
        for file in PACKAGE.rglob("*.py")
        if re.search("@njit|@kernel|@inner", file.read_text(encoding="utf-8"))
    ]
    found = {str(file): sources(file) for file in compiled}
    assert len(found) > 20
    helped = {name: files for name, files in found.items() if len(files) > 1}
    assert [name for name, files in helped.items() if PACKAGE / "kernels.py" not in files] == []
