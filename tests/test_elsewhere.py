"""Where there is no POSIX: nothing imports what is not there, and workers start from nothing."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]

HIDDEN = """
import importlib, multiprocessing, os, pkgutil, sys

import {others}  # what others import of these on this system is theirs to know

for name in ("resource", "fcntl", "pwd", "grp", "termios", "multiprocessing.forkserver"):
    sys.modules[name] = None
for name in ("sched_getaffinity", "fork", "geteuid", "getuid", "mkfifo"):
    if hasattr(os, name):
        delattr(os, name)
multiprocessing.get_all_start_methods = lambda: ["spawn"]
"""


def run(code: str, folder: Path, others: str) -> str:
    (folder / "script.py").write_text(HIDDEN.replace("{others}", others) + code, encoding="utf-8")
    path = f"{ROOT / 'src'}{os.pathsep}{ROOT}"
    environment = os.environ | {"PYTHONPATH": path}
    words = [sys.executable, "script.py"]
    done = subprocess.run(words, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_every_module_is_imported_without_what_only_posix_has(tmp_path):
    said = run(
        """
import fric
found = [one.name for one in pkgutil.walk_packages(fric.__path__, "fric.") if one.name != "fric.__main__"]
for name in found:
    importlib.import_module(name)
print(len(found))
""",
        tmp_path,
        "distributed, h5py, matplotlib.figure, nlopt, numba, pandas, scipy.signal",
    )
    assert int(said) > 150


def test_many_machines_run_in_processes_that_start_from_nothing(tmp_path):
    said = run(
        """
import fric
if __name__ == "__main__":
    one = fric.circle("xy-table", "a", revolutions=1, machines=2, workers=2, seed=3)
    two = fric.circle("xy-table", "a", revolutions=1, machines=2, workers=1, seed=3)
    assert (one.many.glitches == two.many.glitches).all()
    print(len(one.many))
""",
        tmp_path,
        "numba",
    )
    assert said == "2\n"
