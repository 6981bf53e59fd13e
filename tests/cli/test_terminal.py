"""What long commands leave on the screen of a terminal: its bars are drawn above what was printed, and go."""

from __future__ import annotations

import fcntl
import os
import pty
import re
import struct
import sys
import termios
from pathlib import Path

import pyte
import pytest

from fric.cli import console
from fric.cli.main import main

ROOT = Path(__file__).parents[2]
LOGS = [ROOT / "data" / f"{name}.h5" for name in ("constant-velocity", "circle")]


def screen_of(words: list[str], folder: Path, *, lines: int = 200, columns: int = 100) -> tuple[int, list[str], str]:
    """Run fric in a pseudo-terminal; return its status, the lines of the screen, and all that it wrote."""
    child, terminal = pty.fork()
    if child == 0:
        fcntl.ioctl(0, termios.TIOCSWINSZ, struct.pack("HHHH", lines, columns, 0, 0))
        os.chdir(folder)
        os.environ |= {"TERM": "xterm-256color", "COLUMNS": str(columns), "LINES": str(lines)}
        sys.stdout, sys.stderr = (os.fdopen(n, "w", encoding="utf-8") for n in (1, 2))  # not pytest's
        for stream in (console.OUT, console.ERR):
            vars(stream).pop("console", None)
        try:
            sys.argv = ["fric", *words]
            main()
            status = 0
        except SystemExit as error:
            status = int(error.code or 0)
        for stream in (sys.stdout, sys.stderr):
            stream.flush()
        os._exit(status)
    written = b""
    while True:
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


@pytest.mark.parametrize(
    "words",
    [
        ["auto", str(LOGS[0]), "-o", "found"],
        ["identify", "static", str(LOGS[0]), "-o", "static.yaml"],
        ["simulate", "circle", "xy-table", "--scheme", "a,c", "--monte-carlo", "2"],
        ["diagnose", str(LOGS[1])],
        ["compare", str(ROOT / "data" / "presliding-sine.h5"), "--models", "dahl"],
    ],
    ids=lambda words: " ".join(words[:2]) if words[0] in {"identify", "simulate"} else words[0],
)
def test_a_bar_overwrites_nothing_and_is_gone_at_the_end(words: list[str], tmp_path: Path) -> None:
    status, shown, written = screen_of(words, tmp_path)
    assert status == 0, "\n".join(shown)
    assert "━" in written, "no bar was drawn, and this test sees nothing"
    text = "\n".join(shown)
    assert "━" not in text, text
    assert "0/?" not in text, text
    printed = [line for line in re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", written).splitlines() if "━" not in line]
    # what was printed once stands on the screen whole
    for line in filter(None, (one.rstrip().rpartition("\r")[2].rstrip() for one in printed)):
        assert line[:90] in text.replace("\n", "") or line[:90] in text, line


def test_auto_says_each_step_in_a_line_above_its_bar(tmp_path: Path) -> None:
    status, shown, _ = screen_of(["auto", str(LOGS[0]), "-o", "found"], tmp_path)
    assert status == 0
    lines = [line for line in shown if line]
    (step,) = (line for line in lines if line.startswith("x: static"))
    assert re.search(r"F_c \S+ N, F_s \S+ N.* s$", step), step
    assert any(line.startswith("F_c ") for line in lines)
    assert len(lines) < 60
