import contextlib
import json
import os
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from time import monotonic, sleep
from typing import Any

import distributed
import h5py
import numpy as np
import pytest
from typer.testing import CliRunner

from fric.cli import main
from fric.cli.main import app
from fric.io.circle import read_runs
from fric.simulate import processes
from fric.simulate.processes import Study
from tests.io.test_spread import FRICTION

RUN = CliRunner()
MACHINE = Path("configs/xy-table.yaml").resolve()
SMALL = ("simulate", "circle", str(MACHINE), "--radius", "5 mm", "--velocity", "50 mm/s", "--revolutions", "1")


def circle(*words: str) -> str:
    done = RUN.invoke(app, [*SMALL, *words])
    if done.exception is not None:
        raise done.exception
    return done.stdout


def many_of(run: Path, scheme: str) -> np.ndarray:
    with h5py.File(run) as file:
        group = file["monte_carlo"]
        return np.abs(group["quadrants"][:, list(group.attrs["schemes"]).index(scheme)]).max(axis=1)


def test_the_table_json_and_run_file_tell_the_same(tmp_path):
    out = tmp_path / "run.h5"
    words = ("--scheme", "a,f", "--monte-carlo", "5", "--seed", "3")
    told = json.loads(circle(*words, "--json", "-o", str(out)))
    many = told["monte_carlo"]
    assert (many["machines"], many["asked"], many["seed"]) == (5, 5, 3)
    assert many["spreads"]["level"] == {"distribution": "uniform", "factor": [0.7, 1.3]}
    table = [line.split() for line in circle(*words).splitlines() if line.startswith("(")]
    for line, (name, one) in zip(table, many["schemes"].items(), strict=True):
        assert one["p05"] <= one["median"] <= one["p95"]
        left = many_of(out, name)  # of five machines 95 % are all of them
        shown = [told["schemes"][name]["glitch"], one["median"], left.max()]
        assert line[-4:-1] == [f"{value * 1e6:.1f}" for value in shown]
        assert line[-1] == f"{one['best']:.0%}"
    assert [run.scheme.name for run in read_runs(out)] == ["a", "f"]
    with h5py.File(out) as file:
        group = file["monte_carlo"]
        assert list(group.attrs["schemes"]) == ["a", "f"]
        glitches = np.abs(group["quadrants"][:]).max(axis=2)
        assert glitches.shape == (5, 2)
        np.testing.assert_allclose(np.median(glitches, axis=0), group.attrs["median"])
        assert group.attrs["ci95"].shape == (2, 2)
        assert len(group["drawn/x.level"]) == 5
        assert json.loads(group.attrs["spreads"]) == many["spreads"]


def test_workers_and_a_cluster_change_no_digit(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1790000000")
    words = ("--scheme", "a", "--monte-carlo", "3", "--json")
    one = circle(*words, "--workers", "1")
    assert one == circle(*words, "--workers", "2")
    with distributed.LocalCluster(
        n_workers=1, threads_per_worker=2, processes=False, dashboard_address=":0", protocol="tcp"
    ) as cluster:
        assert one == circle(*words, "--scheduler", cluster.scheduler_address)


def test_from_intervals_prints_what_is_expected_and_at_most(tmp_path):
    (tmp_path / "x.yaml").write_text(FRICTION)
    (tmp_path / "none.yaml").write_text("fric: spread/1\nspreads: {}\n")
    words = ["--scheme", "a,c", "--axis", "x", "--gain", "1", "--monte-carlo", "8", "--from-intervals"]
    words += ["--friction", f"x={tmp_path / 'x.yaml'}", "--spread", str(tmp_path / "none.yaml")]
    done = RUN.invoke(app, [*SMALL, *words])
    assert done.exit_code == 0
    assert "cannot be drawn: the interval" in done.stderr
    line = next(line for line in done.stdout.splitlines() if line.startswith("(a)"))
    assert "expected  at most" in done.stdout
    told = json.loads(circle(*words, "--json"))["monte_carlo"]
    one = told["schemes"]["a"]
    low, high = one["ci95"]
    expected, most = map(float, line.split()[-3:-1])
    assert expected == pytest.approx(one["median"] * 1e6, abs=0.06)
    assert low * 1e6 < most < 1.05 * high * 1e6
    assert "F_c" in told["from_intervals"]["x"]
    # a well identified machine is known better than one of the default spreads
    wide = json.loads(circle("--scheme", "a", "--axis", "x", "--monte-carlo", "8", "--json"))["monte_carlo"]["schemes"]
    assert high - low < 0.5 * np.ptp(wide["a"]["ci95"])


def test_figures_are_drawn(tmp_path):
    many, reversal = tmp_path / "many.svg", tmp_path / "reversal.svg"
    circle("--scheme", "a,c,f", "--monte-carlo", "3", "--plot", str(many), "--plot-reversal", str(reversal))
    assert "least glitch on" in _text_of(many)
    assert reversal.stat().st_size > 10_000


def _text_of(figure: Path) -> str:
    return figure.read_text().replace("<!-- ", "").replace(" -->", "")


def test_ctrl_c_keeps_what_is_done(tmp_path, monkeypatch, capsys):
    """The real signal through the real handler: what is kept is what a smaller N gives."""
    out = tmp_path / "run.h5"
    run, calls = processes.run_circle, []

    def interrupting(*given: Any, **named: Any) -> Any:
        calls.append(1)
        if len(calls) == 5:
            os.kill(os.getpid(), signal.SIGINT)
        return run(*given, **named)

    words = [*SMALL, "--scheme", "a", "--json", "--workers", "1", "--monte-carlo"]
    monkeypatch.setattr(processes, "run_circle", interrupting)
    monkeypatch.setattr(sys, "argv", ["fric", *words, "5000", "-o", str(out)])
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        with pytest.raises(SystemExit) as ended:
            main.main()
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
    assert ended.value.code == 130
    printed = capsys.readouterr()
    told = json.loads(printed.out)["monte_carlo"]
    assert 1 <= told["machines"] < 50
    assert told["asked"] == 5000
    assert f"{told['machines']} of 5000 machines are done" in printed.err
    monkeypatch.setattr(processes, "run_circle", run)
    again = json.loads(circle("--scheme", "a", "--json", "--monte-carlo", str(told["machines"])))["monte_carlo"]
    assert again["schemes"] == told["schemes"]
    with h5py.File(out) as file:
        assert len(file["monte_carlo/quadrants"]) == told["machines"]


def _group(leader: int) -> list[int]:
    """Return the processes of a group that are alive."""
    found = []
    for stat in Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):
            state, _, group = stat.read_text().rpartition(") ")[2].split()[:3]
            if int(group) == leader and state != "Z":
                found.append(int(stat.parent.name))
    return found


def _until(condition: Callable[[], bool], seconds: float = 600.0) -> None:
    end = monotonic() + seconds
    while not condition():
        assert monotonic() < end
        sleep(0.05)


TELLING = """
import sys
from pathlib import Path
from fric.cli.main import main
from fric.simulate import processes
unbroken, told = processes._unbroken, Path(sys.argv.pop(1))
def telling(found):
    for n, outcome in enumerate(unbroken(found)):
        yield outcome
        if n == 1:
            told.touch()
processes._unbroken = telling
main()
"""
"""The command, which writes a file when two machines are done."""


@pytest.mark.skipif(sys.platform != "linux", reason="looks into /proc")
@pytest.mark.parametrize("to_all", [True, pytest.param(False, marks=pytest.mark.long(5))], ids=["Ctrl-C", "kill"])
def test_processes_keep_what_is_done_and_none_is_left(tmp_path, to_all):
    """Ctrl-C reaches a terminal's whole process group, a polite kill one process."""
    words = [*SMALL, "--scheme", "a", "--json", "--workers", "2", "--monte-carlo", "20000", "-o", tmp_path / "run.h5"]
    running = subprocess.Popen(
        [sys.executable, "-c", TELLING, str(tmp_path / "begun"), *map(str, words)], stdout=subprocess.PIPE,
        stderr=subprocess.PIPE, text=True, start_new_session=True,
    )  # fmt: skip
    _until(lambda: running.poll() is not None or (tmp_path / "begun").exists())
    if to_all:
        os.killpg(running.pid, signal.SIGINT)
    else:
        running.terminate()
    printed, told = running.communicate(timeout=600)
    assert running.returncode == 128 + (signal.SIGINT if to_all else signal.SIGTERM)
    assert "Traceback" not in told
    machines = json.loads(printed)["monte_carlo"]["machines"]
    assert f"{machines} of 20000 machines are done" in told
    with h5py.File(tmp_path / "run.h5") as file:
        assert len(file["monte_carlo/quadrants"]) == machines
    _until(lambda: not _group(running.pid))


def test_ctrl_c_before_a_machine_is_done_writes_nothing(tmp_path, monkeypatch):
    def interrupting(*given: Any, **named: Any) -> Any:
        os.kill(os.getpid(), signal.SIGINT)
        return iter(())

    monkeypatch.setattr(Study, "__call__", interrupting)
    monkeypatch.setattr(processes, "map", lambda study, machines: study(0), raising=False)
    with pytest.raises(SystemExit) as ended:
        circle("--scheme", "a", "--monte-carlo", "3", "--workers", "1", "-o", str(tmp_path / "run.h5"))
    assert ended.value.code == 130
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("words", [("--workers", "2"), ("--from-intervals",), ("--scheduler", "tcp://a:1")])
def test_what_goes_with_many_machines_alone_is_wrong_usage(words):
    assert RUN.invoke(app, [*SMALL, *words]).exit_code == 2
