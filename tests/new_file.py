"""A new file of a room, as its page shows it, in a folder of its own: fric finds it there without another edit."""

import os
import re
import subprocess
from pathlib import Path

ROOT = Path(__file__).parents[1]


def place(folder: Path, page: str, package: str, file: str, plugin: str) -> str:
    """Write the code of a page, and a plugin by which fric finds it; return the page's text."""
    text = (ROOT / "docs" / page).read_text()
    (code,) = re.findall(r"^```python\n(.*?)^```", text, re.MULTILINE | re.DOTALL)
    (folder / file).write_text(code)
    (folder / f"{plugin}.py").write_text(f"import {package}\n\n{package}.__path__.append({str(folder)!r})\n")
    return text


def python(warm: dict[str, str], folder: Path, code: str, *words: str) -> str:
    """Run code in a Python (of the fixture `warm`) with the folder on its path; return what it printed."""
    path = os.pathsep.join([str(folder), str(ROOT / "src"), str(ROOT)])
    done = subprocess.run(
        ["python", "-c", code, *words], cwd=ROOT, env=warm | {"PYTHONPATH": path, "COLUMNS": "200"},
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def shared_tests(warm: dict[str, str], folder: Path, plugin: str, *words: str) -> str:
    """Run tests of this suite with a plugin; return what pytest told."""
    code = "import sys, pytest; sys.exit(pytest.main(sys.argv[1:]))"
    return python(warm, folder, code, "-p", plugin, "-p", "no:xdist", *words)
