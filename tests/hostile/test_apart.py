"""A process of its own ends with the one that started it, also where that is killed."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time

from fric.process import run_python

WAITS = "import os, sys, time\nopen(sys.argv[1], 'w').write(str(os.getpid()))\ntime.sleep(3600)"
STARTS = f"import sys\nfrom fric.process import run_python\nrun_python({WAITS!r}, sys.argv[1])"


def test_what_a_process_of_its_own_prints_and_ends_with_comes_back() -> None:
    done = run_python("import sys\nprint(sys.argv[1])\nprint('no', file=sys.stderr)\nsys.exit(3)", "a b")
    assert (done.stdout, done.stderr, done.returncode) == (b"a b\n", b"no\n", 3)


def test_it_ends_with_a_parent_that_is_killed(tmp_path) -> None:
    told = tmp_path / "number"
    parent = subprocess.Popen([sys.executable, "-c", STARTS, str(told)], start_new_session=True)
    while not (told.exists() and told.read_text()):
        assert parent.poll() is None
        time.sleep(0.02)
    child = int(told.read_text())
    os.kill(parent.pid, signal.SIGKILL)
    parent.wait()
    until = time.monotonic() + 600.0
    while _lives(child):
        assert time.monotonic() < until
        time.sleep(0.02)


def _lives(number: int) -> bool:
    try:
        with open(f"/proc/{number}/stat") as file:
            return file.read().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False
