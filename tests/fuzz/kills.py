"""Commands killed by SIGKILL at random times: no half file, no process left, and the next run works and cleans up."""

from __future__ import annotations

import json
import os
import re
import shutil
import signal
import sys
import time
from collections.abc import Iterator
from contextlib import chdir, suppress
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np

from fric.documents.yaml import read_tree

ROOT = Path(__file__).parents[2]
DATA, CONFIGS = ROOT / "data", ROOT / "configs"
GRACE = 5.0
"""Seconds after which no process of a killed run may be there."""
_DRAFT = re.compile(r"\..+-[0-9a-f]{8}(\.\w+)?")
_ENDS: dict[str, tuple[bytes, ...]] = {
    ".png": (b"IEND\xaeB`\x82",), ".html": (b"</html>", b"</html>\n"), ".pdf": (b"%%EOF\n",), ".svg": (b"</svg>\n",)
}  # fmt: skip


@dataclass(frozen=True)
class Command:
    """One command line: its words, and whether what a killed run made is gone on with."""

    words: tuple[str, ...]
    resumes: bool = False


def commands(folder: Path) -> dict[str, Command]:
    """Return the commands by name; each writes into the folder that it is run in."""
    run = folder / "run.h5"
    circle = ("simulate", "circle", "xy-table", "--radius", "2 mm", "--velocity", "50 mm/s")
    _fric(folder, (*circle, "--scheme", "f", "-o", str(run)))
    strokes_log, sines = (str(DATA / f"{name}.h5") for name in ("constant-velocity", "presliding-sine"))
    strokes = tuple(map(str, sorted((DATA / "strokes").glob("*.csv"))))
    return {
        "ingest": Command(("ingest", *strokes, "-o", "log.h5", "--force")),
        "identify": Command(("identify", "static", strokes_log, "-o", "f.yaml", "--plot", "f.png", "--force")),
        "simulate": Command((*circle, "--scheme", "a,c,f", "-o", "run.h5", "--plot", "run.png", "--force")),
        "export": Command(("export", "c", "xy-table", "--axis", "x", "--scheme", "f", "-o", "c", "--force")),
        "tune": Command(("tune", "xy-table", str(run), "-o", "tuned", "--force")),
        "auto": Command(("auto", strokes_log, sines, "-o", "auto"), resumes=True),
        "reproduce": Command(("reproduce", "-o", "paper"), resumes=True),
    }  # fmt: skip


def _fric(folder: Path, words: tuple[str, ...]) -> int:
    """Run a command in this process, in a folder; return its exit status."""
    from fric.cli.main import main

    before, sys.argv = sys.argv, ["fric", *words]
    try:
        with chdir(folder):
            main()
    except SystemExit as end:
        return int(end.code or 0)
    finally:
        sys.argv = before
    return 0


def _begun(folder: Path, words: tuple[str, ...]) -> int:
    """Begin a command in a process of its own, which has imported and compiled all; return its number."""
    sys.stdout.flush()
    child = os.fork()
    if child:
        return child
    status = 70
    try:
        os.setsid()  # by which its own children are known
        told = os.open(folder.parent / "told", os.O_RDWR | os.O_CREAT | os.O_TRUNC)
        for stream in (1, 2):
            os.dup2(told, stream)
        status = _fric(folder, words)
    finally:
        sys.stdout.flush()
        os._exit(status)


def _living(session: int) -> list[str]:
    """Return the number and the command line of each process of a session; of one that has ended, nothing."""
    found = []
    for place in Path("/proc").iterdir():
        if place.name.isdigit():
            with suppress(OSError):
                state, _, _, its = (place / "stat").read_text().rpartition(")")[2].split()[:4]
                if int(its) == session and state != "Z":
                    found.append(f"{place.name} {(place / 'cmdline').read_bytes().replace(bytes(1), b' ').decode()}")
    return found


def halves(folder: Path) -> Iterator[str]:
    """Yield what is wrong with the files in a folder that have a name: each must be whole."""
    for path in sorted(one for one in folder.rglob("*") if one.is_file() and not one.name.startswith(".")):
        try:
            if path.suffix == ".h5":
                with h5py.File(path) as file:
                    file.visititems(lambda _, node: node[()] if isinstance(node, h5py.Dataset) else None)
            elif path.suffix in {".yaml", ".yml"}:
                assert read_tree(path)["fric"]
            elif path.suffix == ".json":
                json.loads(path.read_text())
            else:
                content = path.read_bytes()
                assert content
                assert content.endswith(_ENDS.get(path.suffix, (b"",)))
        except Exception as error:
            yield f"{path.relative_to(folder)} is not whole: {type(error).__name__} {error}"


def drafts(folder: Path) -> list[str]:
    """Return the files that are left over from killed runs."""
    return [str(one.relative_to(folder)) for one in folder.rglob(".*") if _DRAFT.fullmatch(one.name)]


class Trials:
    """Runs a command, kills it, and judges what is left.

    Parameters
    ----------
    name, command
        The command.
    folder
        Where it runs.
    """

    def __init__(self, name: str, command: Command, folder: Path) -> None:
        self.name, self.command, self.folder = name, command, folder
        folder.mkdir()
        _fric(folder, command.words)  # what is imported and compiled here need not be in each run
        self.clear()
        begun = time.monotonic()
        self.whole()
        self.lasting = time.monotonic() - begun

    def whole(self) -> str:
        """Run the command to its end; return what is wrong with that."""
        _, status = os.waitpid(_begun(self.folder, self.command.words), 0)
        if status:
            told = (self.folder.parent / "told").read_text(errors="replace")
            return f"the next run ended with {os.waitstatus_to_exitcode(status)}: {told[-300:]}"
        left = drafts(self.folder)
        return f"the next run left {left}" if left else ""

    def clear(self) -> None:
        """Begin again with nothing."""
        shutil.rmtree(self.folder)
        self.folder.mkdir()

    def kill(self, after: float) -> str:
        """Run the command, kill it after a time [s]; return what is wrong then."""
        child, until = _begun(self.folder, self.command.words), time.monotonic() + after
        while time.monotonic() < until and os.waitid(os.P_PID, child, os.WEXITED | os.WNOHANG | os.WNOWAIT) is None:
            time.sleep(0.002)
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
        until = time.monotonic() + GRACE
        while (living := _living(child)) and time.monotonic() < until:
            time.sleep(0.1)
        for one in living:
            os.kill(int(one.partition(" ")[0]), signal.SIGKILL)
        return "; ".join([*(f"lives on: {one[:200]}" for one in living), *halves(self.folder)])


def run_kills(
    count: int, seed: int, folder: Path, names: frozenset[str] | None = None
) -> Iterator[tuple[str, float, bool, str]]:
    """Yield command, time of the kill [s], whether a draft was left, and what was wrong; of so many kills."""
    rng = np.random.default_rng(seed)
    known = {name: one for name, one in commands(folder).items() if names is None or name in names}
    for k, (name, command) in enumerate(known.items()):
        trials = Trials(name, command, folder / name)
        share = count // len(known) + (k < count % len(known))
        for n in range(share):
            if not command.resumes or n % 4 == 0:
                trials.clear()
            after = float(rng.uniform(0.0, trials.lasting))
            wrong = trials.kill(after)
            left = bool(drafts(trials.folder))
            if not command.resumes or n % 4 == 3 or n == share - 1:
                wrong = "; ".join(filter(None, [wrong, trials.whole(), *halves(trials.folder)]))
            yield name, after, left, wrong
