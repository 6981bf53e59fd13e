"""A new file of a room, as its page shows it, in a folder of its own: fric finds it there without another edit."""

import os
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]


def place(folder: Path, page: str, package: str, file: str, plugin: str) -> str:
    """Write the code of a page, and a plugin by which fric finds it; return the page's text."""
    text = (ROOT / "docs" / page).read_text()
    (code,) = re.findall(r"^```python\n(.*?)^```", text, re.MULTILINE | re.DOTALL)
    (folder / file).write_text(code)
    (folder / f"{plugin}.py").write_text(f"import {package}\n\n{package}.__path__.append({str(folder)!r})\n")
    return text


def python(folder: Path, *words: str) -> str:
    """Run Python with the folder on its path; return what it printed."""
    path = os.pathsep.join([str(folder), str(ROOT / "src"), str(ROOT)])
    done = subprocess.run(
        [sys.executable, *words], cwd=ROOT, env=os.environ | {"PYTHONPATH": path, "COLUMNS": "200"},
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout
