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
    """Return text without trailing blanks."""
    return "\n".join(line.rstrip() for line in text.strip("\n").splitlines())


NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")


def alike(printed: str, shown: str, also: float = 0.0) -> bool:
    """Tell whether two outputs have the same words, and numbers that differ in their last digits alone, or by ``also``.

    On another machine the last digit of a fit may round the other way; what the example says stays true.
    """
    if NUMBER.sub("#", " ".join(printed.split())) != NUMBER.sub("#", " ".join(shown.split())):
        return False
    pairs = zip(NUMBER.findall(printed), NUMBER.findall(shown), strict=True)
    return all(abs(float(a) - float(b)) <= 0.02 * abs(float(b)) + 2 * _last_digit(b) + also for a, b in pairs)


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
