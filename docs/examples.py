"""The examples of the documentation: run each console block of a page, and write what it prints into the page.

A Python block that imports fric is a script; what it prints stands in a text block behind it.

`python docs/examples.py` refreshes every page, `python docs/examples.py logs` that one; the tests run the same blocks
and compare.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / "README.md", *sorted(page for page in (ROOT / "docs").glob("*.md") if page.stem != "commands")]
FILE = re.compile(r"^`([\w-]+\.\w+)`:\n\n```\w+\n(.*?)^```", flags=re.MULTILINE | re.DOTALL)
BLOCK = re.compile(
    r"^```console\n(?P<console>.*?)^```|^```python\n(?P<python>import fric\n.*?)^```\n\n```text\n(?P<text>.*?)^```",
    flags=re.MULTILINE | re.DOTALL,
)


def environment() -> dict[str, str]:
    """Return the environment in which examples run: this checkout's fric, a fixed width and a fixed date."""
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    fixed = {"PATH": path, "PYTHONPATH": str(ROOT / "src"), "COLUMNS": "100", "SOURCE_DATE_EPOCH": "1790000000"}
    return os.environ | fixed


def examples(page: Path) -> list[tuple[str, str]]:
    """Return each command of the console blocks of a page, with the output that is shown behind it."""
    found = []
    for block in BLOCK.finditer(page.read_text()):
        if block["python"]:
            found.append((block["python"], plain(block["text"])))
        for part in re.split(r"^\$ ", block["console"] or "", flags=re.MULTILINE)[1:]:
            command, _, shown = part.partition("\n")
            found.append((command, plain(shown)))
    return found


def write_files(page: Path, folder: Path) -> None:
    """Write the files that a page shows, each a block behind its name and a colon, into a folder."""
    for name, text in FILE.findall(page.read_text()):
        (folder / name).write_text(text)


def run(command: str, folder: Path, environ: dict[str, str] | None = None) -> tuple[int, str]:
    """Run a command as a reader would, in a folder with data and configs; return its status and what it printed."""
    environ = environ or environment()
    for name in ("data", "configs"):
        link = folder / name
        if not link.exists():
            link.symlink_to(ROOT / name)
    script = command.startswith("import fric\n")
    words: Any = [shutil.which("python", path=environ["PATH"]), "-c", command] if script else command
    done = subprocess.run(words, shell=not script, cwd=folder, env=environ, capture_output=True, text=True, check=False)
    return done.returncode, plain(done.stdout + done.stderr)


def plain(text: str) -> str:
    """Return text without trailing blanks, and without the lines of progress that a slow machine prints."""
    return "\n".join(line.rstrip() for line in text.strip("\n").splitlines() if not PROGRESS.fullmatch(line))


PROGRESS = re.compile(r"[\w ]+: (?:\d+ %, )?\d+ s(?: \(.*\))?")


NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")


INTERVAL = re.compile(rf"(?:{NUMBER.pattern} +\(?)?({NUMBER.pattern}) … ({NUMBER.pattern})")
"""An interval as it is printed, with the value in front of it: the three are in one unit."""

HALF_WIDTH = re.compile(rf"({NUMBER.pattern})(?: ([^\s\d]\S*))? +± ({NUMBER.pattern})(?: ([^\s\d]\S*))?")
"""A value with half the width of its interval, each with its own prefix of a unit."""

OF_DRAWS = re.compile(r"(?<=\d±)(\d[\d.]*)")
"""Half the width of a chance, as in ``13.3±0.8``."""

PREFIXES = {"n": 1e-9, "µ": 1e-6, "m": 1e-3, "k": 1e3, "M": 1e6}


def alike(printed: str, shown: str, also: float = 0.0, share: float = 0.02) -> bool:
    """Tell whether two outputs have the same words, and numbers that differ by no more than chance and rounding allow.

    On another machine the last digit of a fit may round the other way, and where a drive hunts from count to count the
    fit is of another record: numbers may differ by two of their last digits and a share, by ``also``, and by half the
    interval that is printed with them; what the example says stays true.
    """
    if NUMBER.sub("#", " ".join(printed.split())) != NUMBER.sub("#", " ".join(shown.split())):
        return False
    pairs = zip(NUMBER.findall(printed), NUMBER.findall(shown), _by_intervals(shown), strict=True)
    return all(
        abs(float(a) - float(b)) <= max(share * abs(float(b)) + 2 * _last_digit(b) + also, half) for a, b, half in pairs
    )


def _by_intervals(shown: str) -> list[float]:
    """Return by how much each number of an output may differ: half of the interval that is printed with it, or 0."""
    found = {number.start(): 0.0 for number in NUMBER.finditer(shown)}
    for interval in INTERVAL.finditer(shown):
        half = 0.5 * abs(float(interval[2]) - float(interval[1]))
        found |= {at: half for at in found if interval.start() <= at < interval.end()}
    for one in HALF_WIDTH.finditer(shown):
        found[one.start(1)] = float(one[3]) * _prefix(one[4], one[2]) / _prefix(one[2], one[4])
    for draws in OF_DRAWS.finditer(shown):  # of five runs the half-width itself is known to a half
        found[draws.start(1)] = 0.6 * float(draws[1])
    return list(found.values())


def _prefix(unit: str | None, other: str | None) -> float:
    """Return the factor of a unit's prefix; a letter that another form of the unit begins with is none."""
    if not unit or not other or unit == other or unit[0] not in PREFIXES:
        return 1.0
    return PREFIXES[unit[0]] if unit[1:] in {other, other[1:]} else 1.0


def _last_digit(number: str) -> float:
    mantissa, _, exponent = number.partition("e")
    return 10.0 ** (int(exponent or 0) - len(mantissa.partition(".")[2]))


def is_make(command: str) -> bool:
    """Tell whether a command is one of the Makefile's, which no example runs."""
    return command.startswith("make ")


def refreshed(page: Path) -> str:
    """Return a page with what its examples print now; an example that shows nothing, or ends in …, stays as it is."""
    text = page.read_text()
    with tempfile.TemporaryDirectory() as folder:
        write_files(page, Path(folder))
        for command, shown in examples(page):
            if is_make(command):
                continue
            status, printed = run(command, Path(folder))
            if status:
                raise SystemExit(f"{page.name}: $ {command}\n{printed}")
            for left in Path(folder).glob(f"{page.stem}-*.png"):
                shutil.copyfile(left, ROOT / "docs" / "figures" / left.name)
            if shown and not shown.endswith("…"):
                head = f"{command}```\n\n```text\n" if command.startswith("import fric\n") else f"$ {command}\n"
                text = text.replace(f"{head}{shown}\n", f"{head}{printed}\n")
    return text


if __name__ == "__main__":
    for path in [page for page in PAGES if page.stem in sys.argv[1:] or not sys.argv[1:]]:
        path.write_text(refreshed(path))
