"""Where there is no POSIX: nothing imports what is not there, and workers start from nothing."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]

SCRIPT = """
import importlib, multiprocessing, os, pkgutil, sys

import h5py, matplotlib.figure, nlopt, numba, pandas, scipy.signal  # what others import of what is hidden is theirs

for name in ("resource", "fcntl", "pwd", "grp", "termios", "multiprocessing.forkserver"):
    sys.modules[name] = None
for name in ("sched_getaffinity", "fork", "geteuid", "getuid", "mkfifo"):
    if hasattr(os, name):
        delattr(os, name)
multiprocessing.get_all_start_methods = lambda: ["spawn"]

import fric

found = [one.name for one in pkgutil.walk_packages(fric.__path__, "fric.") if one.name != "fric.__main__"]
for name in found:
    importlib.import_module(name)
print(len(found))
one = fric.circle("xy-table", "a", revolutions=1, machines=2, workers=2, seed=3)
two = fric.circle("xy-table", "a", revolutions=1, machines=2, workers=1, seed=3)
assert (one.many.glitches == two.many.glitches).all()
print(len(one.many))
one.save("run.h5")  # no lock of a file holds it open while it is moved
assert sorted(os.listdir()) == ["run.h5", "script.py"], os.listdir()
"""


@pytest.mark.long(6)
def test_all_is_imported_and_many_machines_run_where_there_is_no_posix(tmp_path):
    """Every module is imported without what only POSIX has; workers are processes that start from nothing.

    The script has no guard: a worker does not run it again.
    """
    (tmp_path / "script.py").write_text(SCRIPT, encoding="utf-8")
    environment = os.environ | {"PYTHONPATH": f"{ROOT / 'src'}{os.pathsep}{ROOT}"}
    words = [sys.executable, "script.py"]
    done = subprocess.run(words, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    modules, machines = map(int, done.stdout.split())
    assert modules > 150
    assert machines == 2
