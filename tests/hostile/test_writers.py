"""Every writer, with its n-th write failing, for every n: all files whole or none, no draft, a sentence; then it works.

What is counted is each call that reaches the disk under the folder: making a file or a folder, a write of bytes,
a new length, a name given.
"""

from __future__ import annotations

import builtins
import errno
import io
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import fric
from fric.automatic.fleet import FleetResult, Unit, UnitAxis, UnitOutcome
from fric.automatic.steps import Session
from fric.circles.measured import MeasuredCircle, measured_from_run
from fric.cli.console import finish
from fric.errors import FricError
from fric.export import targets
from fric.figures.style import rendered
from fric.io.circle import write_circles, write_feedforward
from fric.io.hdf5 import read_logs, write_logs
from fric.io.propose import proposal
from fric.notice import Notice
from fric.output import written
from fric.reproduce.step_cache import StepCache
from fric.results.export import export_axis
from fric.simulate.contour_run import PointPath
from tests.fuzz.kills import halves

ROOT = Path(__file__).parents[2]
DATA = ROOT / "data"
STROKES = sorted((DATA / "strokes").glob("*.csv"))


class Faults:
    """Counts what reaches the disk, and lets the n-th of it, and all that follows, meet a full disk."""

    def __init__(self, folder: Path, failing: int) -> None:
        self.folder, self.failing, self.count = str(folder), failing, 0

    def met(self, path: Any) -> None:
        """Count one; raise where it is the one that fails."""
        if isinstance(path, int) or not os.path.realpath(os.fspath(path)).startswith(self.folder):
            return
        self.count += 1
        if self.failing and self.count >= self.failing:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(path))


@contextmanager
def faults(folder: Path, failing: int) -> Iterator[Faults]:
    """Let the n-th operation under a folder fail; 0 for none."""
    found = Faults(folder, failing)
    names = ("open", "mkdir", "link", "replace")
    real: dict[str, Any] = {"open": io.open, "os": {name: getattr(os, name) for name in names}}

    class Raw(io.FileIO):
        def write(self, data: Any) -> int:
            found.met(self.name)
            return super().write(data)

        def truncate(self, size: int | None = None) -> int:
            found.met(self.name)
            return super().truncate(size)

    def opened(file: Any, mode: str = "r", buffering: int = -1, *rest: Any, **more: Any) -> Any:
        if not set(mode) & set("wax+") or not str(file).startswith(found.folder):
            return real["open"](file, mode, buffering, *rest, **more)
        raw = Raw(file, mode.replace("b", "").replace("t", ""))
        if buffering == 0:
            return raw
        whole: Any = io.BufferedRandom(raw) if "+" in mode else io.BufferedWriter(raw)
        return whole if "b" in mode else io.TextIOWrapper(whole, *rest, **more)

    def counted(name: str, place: int) -> Callable[..., Any]:
        def call(*given: Any, **more: Any) -> Any:
            if name != "open" or given[1] & os.O_CREAT:
                found.met(given[place])
            return real["os"][name](*given, **more)

        return call

    io.open = builtins.open = opened  # type: ignore[assignment]
    for name in real["os"]:
        setattr(os, name, counted(name, 1 if name in {"link", "replace"} else 0))
    try:
        yield found
    finally:
        io.open = builtins.open = real["open"]
        for name, one in real["os"].items():
            setattr(os, name, one)


@cache
def circle() -> Any:
    return fric.circle("xy-table", "f", radius="1 mm", velocity="50 mm/s")


@cache
def static() -> Any:
    return fric.identify_static(fric.read(DATA / "constant-velocity.h5")[::3])


@cache
def gms() -> Any:
    return fric.identify_gms(DATA / "presliding-sine.h5", blocks=3, refine=False)


@cache
def exported(target: str) -> Any:
    with pytest.MonkeyPatch.context() as patch:  # whether it is to be trusted is of no matter here
        patch.setattr("fric.results.export.trust_of", lambda *given, **known: ([], []))
        patch.setattr(
            "fric.export.sinumerik.glitches_of", lambda *given: lambda *run: 1e-6
        )  # nor is what its pulses leave
        return export_axis(target, "xy-table", axis="x")


def _tests() -> list[MeasuredCircle]:
    return [measured_from_run(run, "run.h5") for run in circle().runs]


@cache
def _table() -> Any:
    return fric.learn(_tests()[0], machine="xy-table").table


@cache
def learned() -> Any:
    return fric.learn("xy-table", rounds=2, radius="2 mm", velocity="100 mm/s")


@cache
def planned() -> Any:
    found = fric.plan(stroke="300 mm", feed="100 mm/s", machine="xy-table", draws=2)
    few = {name: dict(list(files.items())[:2]) for name, files in found.files().items()}
    object.__setattr__(found, "files", lambda: few)  # made once: there are hundreds of operations as it is
    return found


@cache
def mapped() -> Any:
    return fric.circle_map("xy-table", "a", feeds=[0.05], radii=[0.005], workers=1)


@cache
def followed() -> Any:
    turn = np.linspace(0.0, 2 * np.pi, 40)
    return fric.path("xy-table", PointPath(0.002 * np.cos(turn), 0.001 * np.sin(turn), 0.05), "a")


@cache
def diagnosed() -> Any:
    return fric.diagnose(*_tests())


@cache
def tuned() -> Any:
    slow = fric.circle("xy-table", "f", radius="5 mm", velocity="20 mm/s")
    return fric.tune("xy-table", *(measured_from_run(run, "run.h5") for run in slow.runs))


def _fleet(folder: Path) -> None:
    axes = {"x": UnitAxis(["static map"])}
    units = [Unit("m1", f"2026-0{n}", folder) for n in (1, 2)]
    FleetResult(
        folder, [UnitOutcome(one, axes, (Notice("a note", "some-code", "doubt"),)) for one in units], []
    ).write()


@cache
def picture(ending: str) -> bytes:
    return rendered(static().plot(), ending)


@pytest.fixture(autouse=True)
def drawn_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Draw a figure once in each format: how it is written is judged."""
    monkeypatch.setattr("fric.figures.style.rendered", lambda figure, ending="svg": picture(ending))


def _both(folder: Path) -> None:
    finish(lambda _: static(), folder / "f.yaml", folder / "f.svg")


def _session(folder: Path) -> None:
    Session(folder / "out", lambda _: None, lambda _: None).close()


def _logged(folder: Path) -> None:
    """Write the file that is added to."""
    log = replace(read_logs(DATA / "presliding-sine.h5")[0], sha256="a" * 64)
    write_logs(folder / "log.h5", [log], force=True)


PREPARED = {"ingest --append": _logged}
"""What is there before a writer begins."""


def _step(folder: Path) -> None:
    StepCache(folder).step("a", lambda: None, reads=[], leaves=[])


WRITERS: dict[str, Callable[[Path], object]] = {
    "ingest": lambda to: fric.ingest(*STROKES[:2], output=to / "log.h5"),
    "ingest --append": lambda to: fric.ingest(STROKES[0], output=to / "log.h5", append=True),
    "ingest circle": lambda to: write_circles(to / "circle.h5", _tests()),
    "ingest --propose": lambda to: written(to / "map.yaml", proposal(STROKES[:1])),
    "identify and plot": _both,
    "identify gms": lambda to: gms().save(to / "gms.yaml"),
    "plot png": lambda to: static().plot(to / "a.png"),
    "plot pdf": lambda to: static().plot(to / "a.pdf"),
    "simulate circle": lambda to: circle().save(to / "run.h5"),
    "simulate experiment": lambda to: write_logs(to / "log.h5", read_logs(DATA / "presliding-sine.h5")[:1]),
    "learn table": lambda to: write_feedforward(to / "next.h5", _table(), "{}"),
    "simulate map": lambda to: mapped().save(to / "map.yaml"),
    "simulate path": lambda to: followed().save(to / "path.h5"),
    "diagnose": lambda to: diagnosed().save(to / "diagnosis.yaml"),
    "fleet": _fleet,
    "report": lambda to: written(to / "report.html", "<!doctype html><html>" + "a" * 20_000 + "</html>\n"),
    "example": lambda to: fric.example("xy-table", output=to / "example"),
    "auto": _session,
    "steps": _step,
    **{f"export {name}": (lambda to, name=name: exported(name).save(to / name, force=True)) for name in targets()},
}
SLOW: dict[str, Callable[[Path], object]] = {
    "tune": lambda to: tuned().save(to / "tuned"),
    "learn --rounds": lambda to: learned().save(to / "rounds.h5"),
    "plan": lambda to: planned().save(to / "plan"),
}
"""Writers of what takes seconds to make."""


def _files(folder: Path) -> dict[str, bytes]:
    return {str(one.relative_to(folder)): one.read_bytes() for one in sorted(folder.rglob("*")) if one.is_file()}


def _fails_everywhere(name: str, folder: Path, numbers: Callable[[int], Iterator[int]]) -> None:
    """Let the n-th operation of a writer fail, for some n; then let it work."""
    write, prepare = (WRITERS | SLOW)[name], PREPARED.get(name, lambda to: None)
    prepare(folder)
    before = _files(folder)
    with faults(folder, 0) as counted:
        write(folder)
    last, whole = counted.count, _files(folder)
    assert last > 2
    for n in numbers(last):
        for one in whole:
            (folder / one).unlink(missing_ok=True)
        prepare(folder)
        with faults(folder, n), pytest.raises(FricError) as caught:
            write(folder)
        assert "No space left" in str(caught.value), (n, last)
        assert len(str(caught.value).splitlines()) <= 2
        left = _files(folder)
        assert left.keys() == before.keys(), (n, last)  # no draft either
        assert not list(halves(folder))
        assert not before or len(read_logs(folder / "log.h5")) == 1
    write(folder)
    assert sorted(_files(folder)) == sorted(whole)
    assert not list(halves(folder))


def _some(last: int) -> Iterator[int]:
    """The first and the last operation, and what is half way."""
    yield from sorted({1, last // 2, last})


pytestmark = pytest.mark.filterwarnings("ignore:unclosed file", "ignore::pytest.PytestUnraisableExceptionWarning")


@pytest.mark.parametrize("name", WRITERS)
def test_a_writer_that_meets_a_full_disk_leaves_nothing(tmp_path: Path, name: str) -> None:
    _fails_everywhere(name, tmp_path, _some)


@pytest.mark.long
@pytest.mark.parametrize("name", WRITERS | SLOW)
def test_whichever_operation_of_a_writer_fails_it_leaves_nothing(tmp_path: Path, name: str) -> None:
    _fails_everywhere(name, tmp_path, lambda last: iter(range(1, last + 1)))


def test_a_result_of_python_is_written_under_a_name_of_its_format_too(tmp_path: Path) -> None:
    """`fric.circle(…).save("run.yaml")` wrote HDF5 into it; the command refused the name."""
    logs = fric.read("data/constant-velocity.h5")
    for name in ("log.yaml", "log.csv"):
        with pytest.raises(FricError, match="what is written is HDF5"):
            write_logs(tmp_path / name, list(logs))
    write_logs(tmp_path / "log.hdf5", list(logs))
    assert [file.name for file in tmp_path.iterdir()] == ["log.hdf5"]
