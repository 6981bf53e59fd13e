"""The documentation is true: every command has help and a page, and every example runs and prints what it shows."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
import typer

from fric.cli.main import app

ROOT = Path(__file__).parents[1]
BIN = Path(sys.executable).parent
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]


def _environment() -> dict[str, str]:
    return os.environ | {
        "PATH": f"{BIN}{os.pathsep}{os.environ['PATH']}",
        "PYTHONPATH": str(ROOT / "src"),
        "COLUMNS": "100",
        "SOURCE_DATE_EPOCH": "1790000000",
    }


def _commands(group: typer.Typer, path: tuple[str, ...] = ("fric",)) -> Iterator[tuple[tuple[str, ...], str]]:
    for command in group.registered_commands:
        assert command.callback is not None
        name = command.name or command.callback.__name__.replace("_", "-")
        yield (*path, name), command.help or command.callback.__doc__ or ""
    for sub in group.registered_groups:
        assert sub.typer_instance is not None
        name = str(sub.typer_instance.info.name)
        yield from _commands(sub.typer_instance, (*path, name))


COMMANDS = dict(_commands(app))


@pytest.mark.parametrize("path", COMMANDS, ids=" ".join)
def test_every_command_has_help_and_a_page(path):
    assert len(COMMANDS[path].strip()) > 20
    page = (ROOT / "docs/commands.md").read_text()
    assert f"`{' '.join(path)}`" in page


def test_commands_page_is_fresh(tmp_path):
    made = tmp_path / "commands.md"
    words = ["fric.cli.main", "utils", "docs", "--name", "fric", "--title", "Commands", "--output", str(made)]
    subprocess.run([BIN / "typer", *words], check=True, capture_output=True, env=_environment())
    assert made.read_text() == (ROOT / "docs/commands.md").read_text(), "stale: run `make docs`"


def _examples(page: Path) -> list[tuple[str, str]]:
    """Return each command of the console blocks of a page, with the output that is shown."""
    shown = []
    for block in re.findall(r"^```console\n(.*?)^```", page.read_text(), flags=re.MULTILINE | re.DOTALL):
        for part in re.split(r"^\$ ", block, flags=re.MULTILINE)[1:]:
            command, _, output = part.replace("\\\n", "").partition("\n")
            shown.append((command, output))
    return shown


@pytest.mark.parametrize(
    "page", [page for page in PAGES if page.stem != "commands" and _examples(page)], ids=lambda p: p.name
)
def test_examples_run_and_print_what_is_shown(page, tmp_path):
    for folder in ("data", "configs"):
        (tmp_path / folder).symlink_to(ROOT / folder)
    for command, shown in _examples(page):
        if command.startswith("make "):
            assert re.search(rf"^{command.split()[1]}:", (ROOT / "Makefile").read_text(), flags=re.MULTILINE)
            continue
        done = subprocess.run(
            command, shell=True, cwd=tmp_path, env=_environment(), capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, f"$ {command}\n{done.stderr}"
        if shown.strip() and not shown.strip().endswith("…"):
            assert _plain(done.stdout + done.stderr) == _plain(shown), f"$ {command}"


def _plain(text: str) -> str:
    return "\n".join(line.rstrip() for line in text.strip().splitlines())
