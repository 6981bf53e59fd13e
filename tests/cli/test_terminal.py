"""What long commands leave on the screen of a terminal: its bars are drawn above what was printed, and go."""

from __future__ import annotations

import fcntl
import os
import pty
import re
import select
import shutil
import struct
import sys
import termios
import traceback
from collections.abc import Sequence
from dataclasses import replace
from io import StringIO
from pathlib import Path

import numpy as np
import pyte
import pytest
from rich.console import Console

import fric
from fric.cli import console
from fric.cli.main import main
from fric.io.hdf5 import read_logs, write_logs
from tests.figures.drawn import undrawn

ROOT = Path(__file__).parents[2]
CTRL_C, CTRL_D = "\x03", "\x04"
LOGS = [ROOT / "data" / f"{name}.h5" for name in ("constant-velocity", "circle")]
AUTO = ["auto", "logs.h5", "-o", "found"]
SPREAD = ["simulate", "circle", "xy-table", "--scheme", "a,c", "--monte-carlo", "2"]
COMPARE = ["compare", str(ROOT / "data" / "presliding-sine.h5"), "--models", "dahl"]


def screen_of(
    words: list[str], folder: Path, *, lines: int = 200, columns: int = 100, typed: Sequence[str] = ()
) -> tuple[int, list[str], str]:
    """Run fric in a pseudo-terminal; return its status, the lines of the screen, and all that it wrote.

    What is ``typed`` is written behind each prompt.
    """
    child, terminal = pty.fork()
    if child == 0:
        fcntl.ioctl(0, termios.TIOCSWINSZ, struct.pack("HHHH", lines, columns, 0, 0))
        os.chdir(folder)
        os.environ |= {"TERM": "xterm-256color", "COLUMNS": str(columns), "LINES": str(lines)}
        sys.stdout, sys.stderr = (os.fdopen(n, "w", encoding="utf-8") for n in (1, 2))  # not pytest's
        sys.stdin = os.fdopen(0, encoding="utf-8")
        for stream in (console.OUT, console.ERR):
            vars(stream).pop("console", None)
        try:
            sys.argv = ["fric", *words]
            main()
            status = 0
        except SystemExit as error:
            status = int(error.code or 0)
        except BaseException:  # or pytest would go on in this child
            traceback.print_exc()
            status = 70
        for stream in (sys.stdout, sys.stderr):
            stream.flush()
        os._exit(status)
    written, rest = b"", list(typed)
    while True:
        if rest and written.count(b"or Enter for 1: ") > len(typed) - len(rest):
            os.write(terminal, rest.pop(0).encode())
        # a signal between the prompt and the read that follows waits for the next: who sees nothing presses again
        if CTRL_C in typed and not rest and not select.select([terminal], [], [], 2.0)[0]:
            if Path(f"/proc/{child}/stat").read_text().rpartition(") ")[2][0] == "S":  # a busy process is on its way
                os.write(terminal, CTRL_C.encode())
            continue
        try:
            part = os.read(terminal, 65536)
        except OSError:  # its end
            break
        if not part:
            break
        written += part
    _, status = os.waitpid(child, 0)
    drawn = pyte.Screen(columns, lines)
    pyte.ByteStream(drawn).feed(written)
    return os.waitstatus_to_exitcode(status), [line.rstrip() for line in drawn.display], written.decode()


@pytest.fixture(scope="module")
def auto(tmp_path_factory: pytest.TempPathFactory) -> tuple[int, list[str], str]:
    """The screen of `fric auto` on strokes, of which each third will do."""
    folder = tmp_path_factory.mktemp("auto")
    write_logs(folder / "logs.h5", read_logs(LOGS[0])[::3])
    with undrawn():
        return screen_of(AUTO, folder)


@pytest.mark.parametrize(
    "words",
    [
        AUTO,
        ["identify", "static", str(LOGS[0]), "-o", "static.yaml"],
        pytest.param(SPREAD, marks=pytest.mark.long(3)),
        pytest.param(["diagnose", str(LOGS[1])], marks=pytest.mark.long(4)),
        pytest.param(["export", "c", "xy-table", "--axis", "x", "--force", "-o", "code"], marks=pytest.mark.long(4)),
        pytest.param(COMPARE, marks=pytest.mark.long(3)),
        pytest.param(["learn", "xy-table", "--rounds", "2", "-o", "table.h5"], marks=pytest.mark.long(5)),
        pytest.param(["plan", "--stroke", "300 mm", "--feed", "0.1 m/s", "-o", "plan"], marks=pytest.mark.long(60)),
        pytest.param(["tune", "xy-table", "circle.h5", "-o", "tuned"], marks=pytest.mark.long(15)),
        pytest.param(["auto", "fleet", "-o", "found"], marks=pytest.mark.long(20)),
        pytest.param(["reproduce", "-o", "paper"], marks=pytest.mark.long(150)),
    ],
    ids=lambda words: " ".join(words[:2]) if words[0] in {"identify", "simulate"} else words[0],
)
def test_a_bar_overwrites_nothing_and_is_gone_at_the_end(
    words: list[str], tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    for date in ("2026-01-01", "2026-02-01") if "fleet" in words else ():
        (tmp_path / "fleet" / "lathe" / date).mkdir(parents=True)
        shutil.copy(LOGS[0], tmp_path / "fleet" / "lathe" / date)
    if "circle.h5" in words:
        fric.circle("xy-table", "a").save(tmp_path / "circle.h5")
    status, shown, written = request.getfixturevalue("auto") if words is AUTO else screen_of(words, tmp_path)
    assert status == 0, "\n".join(shown)
    assert "━" in written, "no bar was drawn, and this test sees nothing"
    text = "\n".join(shown)
    assert "━" not in text, text
    assert "0/?" not in text, text
    printed = [line for line in re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", written).splitlines() if "━" not in line]
    # what was printed once stands on the screen whole
    for line in filter(None, (one.rstrip().rpartition("\r")[2].rstrip() for one in printed)):
        assert line[:90] in text.replace("\n", "") or line[:90] in text, line


def test_auto_says_each_step_in_a_line_above_its_bar(auto: tuple[int, list[str], str]) -> None:
    status, shown, written = auto
    assert status == 0
    assert "reading file 1 of " in written, "the bar says which step it is at"
    lines = [line for line in shown if line]
    (step,) = (line for line in lines if line.startswith("x: static"))
    assert re.search(r"F_c \S+ N, F_s \S+ N.* s$", step), step
    assert any(line.startswith("F_c ") for line in lines)
    assert len(lines) < 60


def test_a_sentence_breaks_between_words_and_a_command_stays_whole() -> None:
    """At 80 columns the decision ended in "n" and went on with "ow 40 µm", and a number parted from its unit."""
    stream = console.Stream(stderr=True)
    shown = vars(stream)["console"] = Console(file=StringIO(), force_terminal=True, width=30, soft_wrap=True)
    stream.say("It leaves 1.7 µm on X, at most 1.9 µm; now 40 µm.", "warning:")
    stream.say("next: fric export linuxcnc found/machine.yaml")
    stream.say("   Ms ≤ 6 dB")
    text = re.sub(r"\x1b\[[0-9;]*m", "", shown.file.getvalue())
    assert text.splitlines() == [
        "warning: It leaves 1.7 µm on", "X, at most 1.9 µm;", "now 40 µm.",
        "next: fric export linuxcnc found/machine.yaml", "   Ms ≤ 6 dB",
    ]  # fmt: skip


def test_the_steps_of_auto_fit_80_columns() -> None:
    shown = (ROOT / "README.md").read_text(encoding="utf-8")
    steps = re.findall(r"^(?:[a-z]: |circle(?::|  )).*", shown, re.MULTILINE)
    assert len(steps) == 7
    assert max(map(len, steps)) <= 72, steps  # and the time behind them


def log_without_units(folder: Path) -> Path:
    """Write a log of moves there and back whose header gives no units, and whose values leave them open."""
    t = np.arange(6000) * 1e-3
    v = 8.0 * np.clip(3.0 * np.sin(2.0 * np.pi * t / 1.5), -1.0, 1.0)
    v = np.convolve(v, np.ones(60) / 60.0, "same")
    rng = np.random.default_rng(5)
    z = np.cumsum(v) * 1e-3
    i = 2.0 * np.tanh(v / 0.05) + 0.05 * v + 0.02 * np.gradient(v, 1e-3) + rng.normal(0.0, 0.05, len(t))
    folder.mkdir()
    rows = np.column_stack([t, np.round(z, 4), v + rng.normal(0.0, 0.01, len(t)), i])
    np.savetxt(folder / "run.csv", rows, "%.6g", ",", header="t,weg,tempo ist,kraft", comments="")
    return folder


@pytest.mark.parametrize("command", ["ingest", "auto"])
def test_what_is_open_is_asked_once_and_kept_beside_the_logs(command: str, tmp_path: Path) -> None:
    logs = log_without_units(tmp_path / "logs")
    words = {"ingest": ["ingest", "logs/run.csv", "-o", "log.h5"], "auto": ["auto", "logs", "-o", "found"]}[command]
    with undrawn():
        status, shown, _ = screen_of(words, tmp_path, typed=["\n", "7\n", "N\n", "\n", "\n"])
    text = "\n".join(shown)
    assert status == 0, text
    assert 1 <= text.count("?") <= 3, text
    assert "⠀" in text
    mapping = (logs / "fric-mapping.yaml").read_text()
    assert '"?"' not in mapping
    words[-1] += "" if command == "auto" else ".h5"  # its steps are up to date, and its logs are read anew
    with undrawn():
        status, shown, _ = screen_of(words, tmp_path, typed=["\n"])
    assert status == 0, "\n".join(shown)
    asked = "\n".join(shown).count("Enter for 1")
    assert asked == (command == "auto" and "No log shows the gains" in "\n".join(shown))  # which no mapping holds
    assert sorted(path.name for path in logs.iterdir()) == ["fric-mapping.yaml", "run.csv"]


@pytest.mark.long(20)
def test_gains_that_no_log_shows_are_asked_for(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The decision is for the gains that are typed, and is not said to be for a controller that fric designed."""
    monkeypatch.setattr("fric.automatic.run.MACHINES", 2)
    (tmp_path / "logs").mkdir()
    for name in ("frequency-response", "constant-velocity"):
        bare = [replace(log, reference=None) for log in read_logs(ROOT / "data" / f"{name}.h5")]
        write_logs(tmp_path / "logs" / f"{name}.h5", bare)
    typed = "K_v=100 1/s, K_p=131 V*s/m, K_i=4090 V/m"
    with undrawn():
        status, shown, _ = screen_of(["auto", "logs", "-o", "found"], tmp_path, typed=[f"{typed}\n"])
    text = "\n".join(shown)
    assert status == 0, text
    assert text.count("No log shows the gains of axis x.") == 1, text
    assert re.search(r"^K_p +131 ", text, re.MULTILINE), text
    assert "For a controller that fric designed" not in text
    assert "K_p: {value: 131.0, unit: V*s/m}" in (tmp_path / "found/x/gains.yaml").read_text()


@pytest.mark.parametrize(("key", "status", "said"), [(CTRL_C, 130, ""), (CTRL_D, 1, "a question was not answered")])
def test_a_question_may_be_left(key: str, status: int, said: str, tmp_path: Path) -> None:
    logs = log_without_units(tmp_path / "logs")
    ended, shown, _ = screen_of(["auto", "logs", "-o", "found"], tmp_path, typed=[key])
    text = "\n".join(shown)
    assert ended == status, text
    assert said in text
    assert "Traceback" not in text
    assert [path.name for path in logs.iterdir()] == ["run.csv"]
    assert not (tmp_path / "found").exists()
