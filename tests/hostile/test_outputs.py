"""Outputs: devices and links, two runs on one name, drafts that killed runs left, disks that are full."""

import contextlib
import fcntl
import os
import shutil
import signal
import stat
import subprocess
import sys
import threading
from pathlib import Path
from types import ModuleType

import h5py
import numpy as np
import pytest

from fric import output
from fric.cli.command import Command
from fric.cli.commands import COMMANDS
from fric.errors import FricError
from fric.io.hdf5 import read_logs, write_logs
from fric.log import Log
from fric.output import refuse_existing, staged
from fric.search import minimised


def log(name: str = "a") -> Log:
    t = np.arange(200) * 1e-3
    return Log(time=t, position=t**2, force=t, name=name, kind="motion", source=f"{name}.csv", sha256=name * 8)


def test_a_device_or_a_pipe_is_never_replaced(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    for path in (Path("/dev/null"), tmp_path / "pipe", tmp_path):
        for force in (False, True):
            with pytest.raises(FricError, match=r"not a regular file|a folder"), staged(path, force=force):
                pass
    assert stat.S_ISCHR(os.stat("/dev/null").st_mode)
    with pytest.raises(FricError, match="not a regular file"):
        refuse_existing(Path("/dev/null"), force=True)


def test_links_are_followed_and_stay_links(tmp_path):
    (tmp_path / "there").mkdir()
    link, real = tmp_path / "link.txt", tmp_path / "there" / "real.txt"
    link.symlink_to(real)
    with staged(link) as draft:  # dangling
        draft.write_text("one")
    assert link.is_symlink()
    assert real.read_text() == "one"
    with pytest.raises(FricError, match="exists"), staged(link):
        pass
    with staged(link, force=True) as draft:
        draft.write_text("two")
    assert (link.is_symlink(), real.read_text()) == (True, "two")
    loop = tmp_path / "loop"
    loop.symlink_to(loop)
    with pytest.raises(FricError, match="leads nowhere"), staged(loop):
        pass
    assert loop.is_symlink()


@pytest.mark.parametrize(
    ("verb", "holds"), [("plan", "plan.yaml"), ("tune", "machine.yaml"), ("export", "manifest.json")]
)
def test_a_folder_with_an_earlier_result_is_refused_before_the_work(verb: str, holds: str, tmp_path: Path) -> None:
    """`plan` said after a minute that its file exists."""
    command = COMMANDS[verb]
    assert isinstance(command, Command)
    (tmp_path / holds).touch()
    with pytest.raises(FricError, match=f"{holds}: the output exists"):
        command.end(lambda advance: pytest.fail("it began"), {"output": tmp_path, "json": False})
    with pytest.raises(FricError, match="it began"):
        command.end(lambda advance: _began(), {"output": tmp_path, "json": False, "force": True})


def _began() -> None:
    raise FricError("it began")


def test_of_two_runs_on_one_name_the_second_fails(tmp_path):
    path = tmp_path / "out.txt"

    def second() -> None:
        with staged(path) as late:
            with staged(path) as first:
                first.write_text("first")
            late.write_text("second")

    with pytest.raises(FricError, match="came to be while"):
        second()
    assert path.read_text() == "first"
    assert list(tmp_path.iterdir()) == [path]


def test_the_next_run_removes_what_a_killed_one_left_and_nothing_else(tmp_path):
    path = tmp_path / "out.txt"
    left, other = tmp_path / ".out-0123abcd.txt", tmp_path / ".out-plan.txt"
    left.write_text("half")
    other.write_text("mine")
    with staged(path) as living:
        living.write_text("living")
        with staged(path, force=True) as draft:
            draft.write_text("next")
        assert living.exists()  # its process lives
        assert not left.exists()
        path.unlink()
    assert sorted(tmp_path.iterdir()) == [other, path]


ADDS = """
import sys
from pathlib import Path
import nlopt
import numpy as np
from fric.io.hdf5 import log_writer
from fric.log import Log
path, name = sys.argv[1:]
time = np.arange(64.0)
sys.stdin.readline()
with log_writer(Path(path), axis="x", motion="linear", append=True) as writer:
    writer.write(Log(time=time, position=time, name=name))
"""


def test_what_is_added_at_once_is_all_there(tmp_path, warm):
    path = tmp_path / "log.h5"
    write_logs(path, [log("first")])
    names = [f"r{n}" for n in range(4)]
    words = ["python", "-c", ADDS, str(path)]
    adding = [
        subprocess.Popen([*words, name], env=warm, stdin=subprocess.PIPE, stderr=subprocess.PIPE) for name in names
    ]
    for one in adding:
        assert one.stdin is not None
        one.stdin.close()  # all begin at once
        one.stdin = None
    said = [one.communicate(timeout=600)[1] for one in adding]
    assert [one.returncode for one in adding] == [0] * len(names), said
    assert sorted(one.name for one in read_logs(path)) == ["first", *names]


def test_who_waits_too_long_is_told(tmp_path, monkeypatch):
    monkeypatch.setattr(output, "WAIT", 0.1)
    path = tmp_path / "a.h5"
    with output.alone(path), pytest.raises(FricError, match="another process"), output.alone(path):
        pass


@pytest.fixture
def windows(monkeypatch):
    """Locks as Windows has them, of files alone, where no open file can be moved; the event of a lock not given."""
    locks, refused = ModuleType("msvcrt"), threading.Event()
    locks.LK_NBLCK = 2

    def locking(file, mode, count):
        assert (mode, count, stat.S_ISREG(os.fstat(file).st_mode)) == (locks.LK_NBLCK, 1, True)
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            refused.set()
            raise PermissionError from None

    locks.locking = locking
    monkeypatch.setitem(sys.modules, "msvcrt", locks)
    monkeypatch.setattr(output, "LOCKED_MOVE", False)
    return refused


def opened() -> set[str]:
    """Return the paths of all that this process holds open."""
    held = set()
    for link in Path("/proc/self/fd").iterdir():
        with contextlib.suppress(OSError):  # that of the folder that is listed
            held.add(str(link.readlink()))
    return held


@pytest.mark.skipif(not Path("/proc/self/fd").exists(), reason="says what is open")
def test_where_no_open_file_can_be_moved_a_draft_is_held_open_by_no_lock(tmp_path, windows):
    """On Windows no output could be written: its draft was locked, and so open, when it was to be moved."""
    path = tmp_path / "out.txt"
    for force, text in ((False, "one"), (True, "two")):
        with staged(path, force=force) as draft:
            assert draft.read_bytes() == b""
            assert str(draft) not in opened()
            draft.write_text(text)
        assert path.read_text() == text
        assert list(tmp_path.iterdir()) == [path]
    with pytest.raises(KeyError), staged(path, force=True):
        raise KeyError
    assert (path.read_text(), [*tmp_path.iterdir()]) == ("two", [path])


def test_where_no_folder_can_be_locked_a_file_beside_is_while_one_adds_and_is_gone_then(tmp_path, windows):
    """On Windows no record could be added to a log: its folder cannot be opened to be locked."""
    path, beside = tmp_path / "a.h5", tmp_path / ".a.h5.lock"
    begun, ends, order = threading.Event(), threading.Event(), []

    def first() -> None:
        with output.alone(path):
            order.append("in")
            begun.set()
            assert ends.wait(60.0)
            order.append("out")

    def second() -> None:
        with output.alone(path):
            order.append("other")

    one, other = threading.Thread(target=first), threading.Thread(target=second)
    one.start()
    assert begun.wait(60.0)
    assert [*tmp_path.iterdir()] == [beside]
    other.start()
    assert windows.wait(60.0)
    ends.set()
    one.join()
    other.join()
    assert order == ["in", "out", "other"]
    assert not list(tmp_path.iterdir())


WRITERS = {
    "run": "from fric.io.circle import write_runs\nwrite = lambda p: write_runs(p, RUNS)",
    "log": "from fric.io.hdf5 import write_logs\nwrite = lambda p: write_logs(p, LOGS)",
}
FULL = """
import sys, resource, signal
from pathlib import Path
import nlopt
import numpy as np
import fric
from fric.control.scheme import choose_schemes
from fric.documents.machine_files import read_machine
from fric.log import Log
from fric.simulate.contour_run import Circle, run_circle
machine = read_machine(Path("configs/xy-table.yaml"))
RUNS = [run_circle(machine, one, Circle(0.001, 0.05)) for one in choose_schemes("a")]
t = np.arange(200_000) * 1e-3
LOGS = [Log(time=t, position=np.random.default_rng(0).normal(size=len(t)), name="a", source="a", sha256="a")]
{writer}
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
for limit in (1_000, 9_000, 40_000):
    resource.setrlimit(resource.RLIMIT_FSIZE, (limit, resource.getrlimit(resource.RLIMIT_FSIZE)[1]))
    try:
        write(Path(sys.argv[1]))
    except fric.FricError as error:
        print(error.what)
"""


@pytest.mark.parametrize("name", WRITERS)
def test_a_disk_that_fills_up_ends_every_writer_with_a_sentence(tmp_path, name, warm):
    done = subprocess.run(
        ["python", "-c", FULL.replace("{writer}", WRITERS[name]), str(tmp_path / "out.h5")],
        env=warm, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.splitlines() == ["cannot be written: File too large"] * 3
    assert not list(tmp_path.iterdir())


class FailingAtError(OSError):
    """The n-th write fails."""


def test_whichever_write_of_a_log_fails_there_is_a_whole_file_or_none(tmp_path, monkeypatch):
    """The n-th write fails, for every n: the old file stays as it was, and no draft is left."""
    from fric.io import safe_hdf5 as staged_hdf5

    path = tmp_path / "log.h5"
    write_logs(path, [log("before")])
    before = path.read_bytes()
    for n in range(1, 400):
        count = 0

        def failing(self, act, otherwise, n=n):
            nonlocal count
            count += 1
            if self._failed is None and count == n:
                self._failed = FailingAtError(28, "No space left on device")
            if self._failed is None:
                return act()
            return otherwise

        monkeypatch.setattr(staged_hdf5.Unfailing, "_kept", failing)
        told = ""
        try:
            write_logs(path, [log("after")], force=True)
        except FricError as error:
            told = error.what
        if not told:
            assert n > 5
            break
        assert "No space left" in told
        assert path.read_bytes() == before
        assert list(tmp_path.iterdir()) == [path]
    monkeypatch.undo()
    assert read_logs(path)[0].name == "after"
    with h5py.File(path) as file:
        assert file.attrs["fric"] == "log/1"


def test_a_polite_kill_leaves_nothing(tmp_path):
    code = (
        "import sys, time\nfrom pathlib import Path\nfrom fric.output import staged\n"
        "from fric.cli.main import _interrupt\nimport signal\nsignal.signal(signal.SIGTERM, _interrupt)\n"
        "with staged(Path(sys.argv[1])) as draft:\n    print('in', flush=True)\n    time.sleep(3600)\n"
    )
    words = [sys.executable, "-c", code, str(tmp_path / "out.txt")]
    with subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL) as child:
        assert child.stdout.readline() == b"in\n"
        child.send_signal(signal.SIGTERM)
        child.wait(600)
    assert not list(tmp_path.iterdir())


STRUCK = """
import importlib, os, signal, sys
from fric.cli import main as command
from fric.kernels import plant
function, kind, nth = *sys.argv[1:3], int(sys.argv[3])
seen = 0
def strike(frame, event, argument):
    global seen
    if event == kind and frame.f_code.co_name == function:
        seen += 1
        if seen == nth:
            sys.setprofile(None)
            print("struck", flush=True)
            os.kill(os.getpid(), signal.SIGTERM)
app = command.app
def begin(**how):
    sys.setprofile(strike)
    importlib.reload(plant)  # is loaded from the cache
    app(**how)
    print("went on")
command.app = begin
sys.argv[1:] = ["simulate", "circle", "xy-table", "--scheme", "a"]
command.main()
"""


@pytest.mark.parametrize(
    ("function", "event", "nth"),
    [
        ("__del__", "call", 2),
        ("_unserialize", "return", 1),
        ("_numba_unpickle", "return", 1),
        ("_numba_unpickle", "return", 3),
    ],
)
def test_a_polite_kill_inside_the_compiler_ends_as_one_elsewhere(function, event, nth, warm, tmp_path):
    """It was lost in finalizers, and ended in another error in what compiled code had unpickled."""
    words = [shutil.which("python", path=warm["PATH"]), "-c", STRUCK, function, event, str(nth)]
    done = subprocess.run(words, capture_output=True, text=True, cwd=tmp_path, env=warm, check=False)
    assert done.stdout == "struck\n"
    assert done.stderr.splitlines() == ["error: interrupted", "Outputs that were not finished are not there."]
    assert done.returncode == 128 + signal.SIGTERM


SWALLOWED = """
import os, signal, sys
from fric.cli import main as command
def app(**how):
    try:
        os.kill(os.getpid(), signal.SIGTERM)
    except BaseException as error:
        raise SystemError("<built-in function loads> returned a result with an exception set") from error
    if "warn" in sys.argv:
        import numpy as np
        np.float64(1e308) * 10
command.app = app
command.main()
"""


def test_a_polite_kill_that_a_library_makes_an_error_of_ends_as_one_elsewhere(warm, tmp_path):
    """As four nested SystemErrors where it struck Numba's unpickling."""
    words = [shutil.which("python", path=warm["PATH"]), "-c", SWALLOWED]
    done = subprocess.run(words, capture_output=True, text=True, cwd=tmp_path, env=warm, check=False)
    assert done.stderr.splitlines() == ["error: interrupted", "Outputs that were not finished are not there."]
    assert done.returncode == 128 + signal.SIGTERM


def test_a_library_warns_of_its_own_code_in_no_command(warm, tmp_path):
    """As NumPy's RuntimeWarnings in `auto`, `report`, `tune` and `export`."""
    code = SWALLOWED.replace("os.kill(os.getpid(), signal.SIGTERM)", "pass")
    words = [shutil.which("python", path=warm["PATH"]), "-c", code, "warn"]
    done = subprocess.run(words, capture_output=True, text=True, cwd=tmp_path, env=warm, check=False)
    assert (done.returncode, done.stderr) == (0, "")


def test_what_is_raised_inside_a_search_ends_it():
    """NLopt went on, and made SystemErrors in one another of a polite kill and of any error of a model."""
    calls = []

    def cost(x):
        calls.append(x)
        raise KeyError("static")

    with pytest.raises(KeyError, match="static"):
        minimised("LN_SBPLX", cost, np.zeros(2), -1.0, 1.0)
    assert len(calls) == 1
