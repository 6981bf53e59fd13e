"""The wheel, installed away from the repository: bundled names, the example, pages, and the README's session."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import sysconfig
import venv
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
pytestmark = pytest.mark.long


@pytest.fixture(scope="module")
def fric(tmp_path_factory):
    """Run a command of the wheel, in the environment of FRIC_WHEEL_PYTHON where that is set."""
    folder = tmp_path_factory.mktemp("wheel")
    python = Path(os.environ["FRIC_WHEEL_PYTHON"]) if "FRIC_WHEEL_PYTHON" in os.environ else installed(folder)
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}

    def run(*words, cwd, status=0):
        command = [python.with_name("fric"), *words]
        done = subprocess.run(command, cwd=cwd, env=environment, capture_output=True, text=True, check=False)
        assert done.returncode == status, f"{words}: {done.stdout[-500:]}{done.stderr[-2000:]}"
        return done.stdout

    where = subprocess.run(
        [python, "-c", "import fric; print(fric.__file__)"], cwd=folder, env=environment, capture_output=True, text=True
    )
    assert Path(where.stdout.strip()).is_relative_to(python.parents[1])
    return run


def installed(folder: Path) -> Path:
    """Return the Python of an environment with the wheel alone; its dependencies are those of this one, fric is not."""
    pip = [sys.executable, "-m", "pip", "--quiet", "--disable-pip-version-check"]
    built = subprocess.run(
        [*pip, "wheel", "--no-deps", "-w", folder, ROOT], capture_output=True, text=True, check=False
    )
    if built.returncode and "hatchling" in built.stderr:
        pytest.skip("hatchling, which builds the wheel, is not to be had")
    assert built.returncode == 0, built.stderr
    (wheel,) = folder.glob("*.whl")
    venv.create(folder / "venv")
    python = folder / "venv" / ("Scripts" if os.name == "nt" else "bin") / "python"
    subprocess.run([*pip, "--python", python, "install", "--no-deps", wheel], check=True)
    (own,) = (folder / "venv").rglob("site-packages")
    (own / "dependencies.pth").write_text(sysconfig.get_path("purelib"))
    return python


def test_bundled_names_and_pages_in_an_empty_folder(fric, tmp_path):
    assert "(a) none" in fric("simulate", "circle", "xy-table", "--scheme", "a", cwd=tmp_path)
    named = ["--schemes", "literature", "--scheme", "two-dof", "--velocity", "10 mm/s"]
    assert "two-dof" in fric("simulate", "circle", "xy-table", *named, cwd=tmp_path)
    pages = {line.split()[0] for line in fric("help", cwd=tmp_path).splitlines()}
    assert pages == {path.stem for path in (ROOT / "docs").glob("*.md")}
    (tmp_path / "log.csv").write_text("nothing;here\n1;2\n")
    fric("ingest", "log.csv", "--map", "tribometer", "-o", "log.h5", cwd=tmp_path, status=1)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["log.csv"]


def test_the_session_of_the_readme_in_a_copied_example(fric, tmp_path):
    fric("example", "-o", "session", cwd=tmp_path)
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    commands = [line.removeprefix("$ fric ").split() for line in re.findall(r"^\$ fric .*$", text, re.MULTILINE)]
    assert commands
    for words in commands:
        shown = fric(*(word for word in words if word != "2>&1"), cwd=tmp_path / "session")
        assert shown.count("trusted.") == 1
