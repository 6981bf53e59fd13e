"""The documentation is true: every command has help and a page, and every example runs and prints what it shows."""

from __future__ import annotations

import re
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import typer
from matplotlib import image
from typer.testing import CliRunner

import fric.flaws
from docs import examples
from fric.cli.main import app
from tests.warm import UNDRAWN

ROOT = Path(__file__).parents[1]
SHOWING = [page for page in examples.PAGES if examples.examples(page)]


LONG = {
    "target-linuxcnc": 400, "plan": 30, "tutorial": 9, "gallery": 10, "schemes": 14, "data-quality": 8, "targets": 7,
    "target-mat": 1, "target-xlsx": 1, "target-st": 1, "target-csv": 1, "target-twincat": 1, "target-sinumerik": 6,
    "target-fmi": 2, "monte-carlo": 2,
}  # fmt: skip
"""Pages whose examples take long, and how long [s]; what those of targets do is in tests/export/test_command.py."""

COLD = {"target-linuxcnc"}
"""Pages whose commands start as processes of their own."""

NEEDED = {"target-linuxcnc": ["linuxcnc", "halcompile"], "target-c": ["cc"], "target-fmi": ["cc"]}
"""What must be installed for a page's examples."""

COUNTS = {"target-linuxcnc": 0.3}
"""By how much figures of a page may differ besides: a count of 0.25 µm may fall on another sample elsewhere."""

GOOD_TO = {"plan": 0.2, "data-quality": 0.1}
"""To which share the figures of a page are good: as it says itself, or of misfits of an axis that hunts."""


def _marked(page: Path) -> object:
    return pytest.param(page, marks=pytest.mark.long(LONG[page.stem])) if page.stem in LONG else page


def _commands(group: Any, path: tuple[str, ...] = ("fric",)) -> Iterator[tuple[tuple[str, ...], str]]:
    for name in group.list_commands(None):
        command = group.get_command(None, name)
        if hasattr(command, "list_commands"):
            yield from _commands(command, (*path, name))
        else:
            yield (*path, name), command.help or ""


COMMANDS = dict(_commands(typer.main.get_command(app)))


@pytest.mark.parametrize("path", COMMANDS, ids=" ".join)
def test_every_command_has_help_and_a_page(path):
    assert len(COMMANDS[path].strip()) > 20
    page = (ROOT / "docs/commands.md").read_text()
    assert f"`{' '.join(path)}`" in page
    told = CliRunner().invoke(app, [*path[1:], "--help"], env={"COLUMNS": "80", "TERM": "dumb"}, terminal_width=80)
    assert max(map(len, told.output.splitlines())) <= 80


PAGE = """
import typer
from typer.cli import get_docs_for_click
from fric.cli.main import app
group = typer.main.get_command(app)
print(get_docs_for_click(obj=group, ctx=typer.Context(group, info_name="fric"), name="fric", title="Commands"))
"""
"""Prints what `make docs` writes, in a process where no command was run: a command keeps the options of its help."""


def test_commands_page_is_fresh(warm):
    made = subprocess.run(["python", "-c", PAGE], check=True, capture_output=True, text=True, cwd=ROOT, env=warm).stdout
    assert made.strip() + "\n" == (ROOT / "docs/commands.md").read_text(), "stale: run `make docs`"


def test_codes_page_is_fresh_and_help_shows_each_code():
    assert fric.flaws.page() == (ROOT / "docs/codes.md").read_text("utf-8"), "stale: run `make docs`"
    shown = CliRunner().invoke(app, ["help", "implausible-speed"])
    assert shown.exit_code == 0
    assert "linear motors reach 10 m/s" in shown.output
    unknown = CliRunner().invoke(app, ["help", "implausible-sped"])
    assert "implausible-speed" in str(unknown.exception) + unknown.output


@pytest.mark.parametrize("page", [*map(_marked, SHOWING)], ids=[page.name for page in SHOWING])
def test_examples_run_and_print_what_is_shown(page, tmp_path, warm):
    for word in NEEDED.get(page.stem, ()):
        if shutil.which(word) is None:
            pytest.skip(f"{word} is not installed")
    examples.write_files(page, tmp_path)
    drawn = {} if page.stem == "gallery" else {UNDRAWN: "1"}  # the others' figures have tests of their own
    environment = None if page.stem in COLD else warm | drawn
    for command, shown in examples.examples(page):
        if examples.is_make(command):
            assert re.search(rf"^{command.split()[1]}:", (ROOT / "Makefile").read_text(), flags=re.MULTILINE)
            continue
        status, printed = examples.run(command, tmp_path, environment)
        assert status == 0, f"$ {command}\n{printed}"
        if shown and not shown.endswith("…"):
            alike = examples.alike(printed, shown, COUNTS.get(page.stem, 0.0), GOOD_TO.get(page.stem, 0.02))
            assert alike, f"$ {command}: refresh by `make docs`\n{printed}"
    for picture in re.findall(rf"figures/({page.stem}-\w+\.png)", page.read_text()):
        if page.stem == "gallery":  # what an example draws is what the page shows
            drawn, kept = (image.imread(folder / picture) for folder in (tmp_path, ROOT / "docs" / "figures"))
            assert drawn.shape == kept.shape, f"{picture}: refresh by `make docs`"
            assert np.mean(np.abs(drawn - kept)) < 0.01, f"{picture}: refresh by `make docs`"


def test_a_scheme_of_the_literature_is_simulated(tmp_path, warm):
    """What docs/schemes.md does with all of them."""
    command = "fric simulate circle xy-table --schemes literature --scheme c,two-dof"
    assert any(
        told.startswith(command.partition(" --scheme ")[0]) for told, _ in examples.examples(ROOT / "docs/schemes.md")
    )
    status, printed = examples.run(command, tmp_path, warm)
    assert (status, "two-dof" in printed) == (0, True), printed


def test_examples_may_differ_in_last_digits_alone():
    assert examples.alike("F_c  60.8 N, 97%", "F_c  60.9 N, 98%")
    assert not examples.alike("F_c  60.8 N", "F_s  60.8 N")
    assert not examples.alike("F_c  60.8 N", "F_c  66.8 N")
    assert not examples.alike("glitch 2.5 µm", "glitch 25 µm")
    assert examples.alike("glitch 0.17 µm", "glitch 0.34 µm", 0.3)
    assert not examples.alike("glitch 2.5 µm", "glitch 3.1 µm", 0.3)


def test_examples_may_differ_by_half_the_interval_that_they_print():
    assert examples.alike("k_1  100  93 … 106  N/µm", "k_1  104  96 … 112  N/µm")
    assert not examples.alike("k_1  80  73 … 86  N/µm", "k_1  104  96 … 112  N/µm")
    assert examples.alike("offset  -9 mN  ± 22.8 mN", "offset  5.7 mN  ± 22.8 mN")
    assert examples.alike("T_d  650.7 µs  ± 827 ns", "T_d  650.1 µs  ± 827 ns")
    assert not examples.alike("F_c  100.0 N  ± 95 mN", "F_c  105.0 N  ± 95 mN")
    assert examples.alike("13.3±0.4 µm", "13.3±0.8 µm")
    assert not examples.alike("13.3±0.2 µm", "13.3±0.8 µm")
    assert examples.alike("F_c  105.0 N  ± 80 mN", "F_c  105.0 N  ± 95 mN", share=0.2)
    assert not examples.alike("F_c  105.0 N  ± 60 mN", "F_c  105.0 N  ± 95 mN", share=0.2)
