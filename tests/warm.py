"""A warm fric: a process that has imported everything, and becomes, by a fork, each command that a shell runs.

`python -m tests.warm ADDRESS` imports every module of fric: what is compiled is compiled then, and kept for all that
follows. Then it listens. In a shell with `on_path` in front, `fric`, `python -c` and `python FILE.py` are clients of
it: the command runs in a child of the warm process with the client's words, folder, environment, files 0, 1 and 2 and
limit of the size of files; the client hands on Ctrl-C and a polite kill, and ends with its status.
"""

from __future__ import annotations

import atexit
import gc
import importlib
import json
import os
import pkgutil
import resource
import runpy
import socket
import subprocess
import sys
import traceback
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext, suppress
from pathlib import Path

LATE = ("scipy.io", "rich.console", "rich.table", "pint", "scipy.signal", "matplotlib.backends.backend_agg", "pytest")
"""What commands import where they need it, as most do; and what runs tests of a new file."""

UNDRAWN = "FRIC_UNDRAWN"
"""Set where no figure of a command is looked at: they are empty files then."""

CLIENT = """#!{python} -IS
import json, os, resource, signal, socket, sys
if os.path.basename(sys.argv[0]) == "python" and not "".join(sys.argv[1:2]).endswith(("-c", ".py")):
    os.execv({python!r}, [{python!r}, *sys.argv[1:]])
signals = signal.SIGINT, signal.SIGTERM
signal.pthread_sigmask(signal.SIG_BLOCK, signals)
with socket.socket(socket.AF_UNIX) as line:
    line.connect({address!r})
    socket.send_fds(line, [b"."], [0, 1, 2])
    told = sys.argv, os.getcwd(), dict(os.environ), resource.getrlimit(resource.RLIMIT_FSIZE)
    line.sendall(json.dumps(told).encode())
    line.shutdown(socket.SHUT_WR)
    child = int(line.recv(8))
    for number in signals:
        signal.signal(number, lambda number, frame: os.kill(child, number))
    signal.pthread_sigmask(signal.SIG_UNBLOCK, signals)
    told = line.recv(8)
os._exit(int(told) if told else 70)
"""


def modules() -> list[str]:
    """Return the names of all modules of fric that can be imported without being run."""
    import fric

    return [one.name for one in pkgutil.walk_packages(fric.__path__, "fric.") if one.name != "fric.__main__"]


@contextmanager
def on_path(folder: Path, environment: dict[str, str]) -> Iterator[dict[str, str]]:
    """Yield an environment in which `fric` and `python -c` are run by a warm process; it ends with the block."""
    address = folder / "warm"
    for name in ("fric", "python"):
        (folder / name).write_text(CLIENT.format(python=sys.executable, address=str(address)))
        (folder / name).chmod(0o755)
    words = [sys.executable, "-m", "tests.warm", str(address)]
    root = Path(__file__).parents[1]
    path = {"PYTHONPATH": f"{environment['PYTHONPATH']}{os.pathsep}{root}", "OPENBLAS_NUM_THREADS": "1"}
    server = subprocess.Popen(words, env=environment | path, cwd=root, stdout=subprocess.PIPE, text=True)
    try:
        assert server.stdout is not None
        assert server.stdout.readline() == "warm\n"
        server.stdout.close()
        yield environment | {"PATH": f"{folder}{os.pathsep}{environment['PATH']}"}
    finally:
        server.terminate()
        server.wait()


def run_python(path: str, code: str, *words: str) -> subprocess.CompletedProcess[bytes]:
    """Run code as `fric.process.run_python` does, by the warm process that comes first on a PATH."""
    command = [f"{path.partition(os.pathsep)[0]}/python", "-c", code, *words]
    return subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, check=False)


def serve(address: str) -> None:
    """Listen; return, with the words of a command, in the child that is to run it."""
    with socket.socket(socket.AF_UNIX) as listening:
        listening.bind(address)
        listening.listen()
        print("warm", flush=True)
        while True:
            line, _ = listening.accept()
            if os.fork() == 0:
                listening.close()
                break
            line.close()
            while _reaped():
                pass
    _, files, _, _ = socket.recv_fds(line, 1, 3)
    words, folder, environment, limit = json.loads(line.makefile("rb").read())
    child = os.fork()
    if child:
        line.sendall(f"{child:8}".encode())
        _, status = os.waitpid(child, 0)
        line.sendall(str(os.waitstatus_to_exitcode(status) & 0xFF).encode())
        os._exit(0)
    line.close()
    for number, file in enumerate(files):
        os.dup2(file, number)
        os.close(file)
    os.chdir(folder)
    resource.setrlimit(resource.RLIMIT_FSIZE, limit)
    os.environ.clear()
    os.environ.update(environment)
    sys.path[:0] = [folder, *environment.get("PYTHONPATH", "").split(os.pathsep)]
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        errors = "backslashreplace" if name == "stderr" else "strict"
        number = ("stdin", "stdout", "stderr").index(name)
        stream = open(number, mode, encoding="utf-8", errors=errors, closefd=False)  # noqa: SIM115
        setattr(sys, name, stream)
        setattr(sys, f"__{name}__", stream)
    sys.argv[:] = words
    here = sys.modules["__main__"]
    here.__spec__ = here.__package__ = here.__file__ = None  # nor is a usage line, or a worker, to know of this file


def _reaped() -> bool:
    try:
        return os.waitpid(-1, os.WNOHANG)[0] != 0
    except ChildProcessError:
        return False


def main() -> None:
    """Import everything, serve at the address, and be the command that is asked for."""
    for name in (*modules(), *LATE):
        importlib.import_module(name)
    import numba

    from fric import units
    from fric.cli import console
    from fric.simulate import processes
    from tests.figures.drawn import undrawn
    from tests.nudge import nudge

    processes.default_workers = lambda: 1  # as in the tests' own processes (`alone` in tests/conftest.py)
    console.EVERY = 1e6
    nudge()
    units._registry()
    numba.njit("float64(float64)")(lambda x: x)  # what Numba prepares once, before it compiles
    gc.freeze()  # what is there stays shared by all children
    serve(sys.argv[1])
    with undrawn() if os.environ.pop(UNDRAWN, "") else nullcontext():
        status = _run()
    sys.stdout.flush()
    sys.stderr.flush()
    with suppress(OSError):  # of what code kept of it; a full disk was told by the command
        if sys.__stdout__ is not None:
            sys.__stdout__.flush()
    atexit._run_exitfuncs()
    os._exit(status)  # to take all modules down takes longer than most commands


def _run() -> int:
    try:
        if Path(sys.argv[0]).name == "fric":
            from fric.cli.main import main as fric

            fric()
        elif sys.argv[1] != "-c":
            sys.argv.pop(0)
            runpy.run_path(sys.argv[0], run_name="__main__")
        else:
            code = sys.argv[2]
            sys.argv[:] = ["-c", *sys.argv[3:]]
            exec(compile(code, "<string>", "exec"), {"__name__": "__main__"})
    except SystemExit as ended:
        if isinstance(ended.code, str):
            print(ended.code, file=sys.stderr)
        return ended.code if isinstance(ended.code, int) else int(ended.code is not None)
    except BaseException:
        traceback.print_exc()
        return 1
    return 0


if __name__ == "__main__":
    main()
