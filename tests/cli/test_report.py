"""`fric report` as a user runs it."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

import fric
from fric.cli.main import app
from fric.errors import FricError

FRICTION = """
fric: friction/1
axis: x
static: {{F_c: {{value: {F_c}, unit: N, ci95: [{low}, {high}]}}, F_s: 165 N, v_s: 1 mm/s, sigma: 40 N*s/m}}
provenance: {{created: '{created}'}}
"""


@pytest.fixture
def dates(tmp_path: Path) -> list[Path]:
    paths = []
    for n, F_c in enumerate((105, 120)):
        paths.append(tmp_path / f"{n}.yaml")
        text = FRICTION.format(F_c=F_c, low=F_c - 2, high=F_c + 2, created=f"2026-0{n + 1}-01")
        paths[-1].write_text(text, encoding="utf-8")
    return paths


def run(*arguments: object) -> str:
    result = CliRunner().invoke(app, ["report", *map(str, arguments)], catch_exceptions=False)
    assert result.exit_code == 0, result.output
    return result.stdout


def test_two_reports_at_two_dates_show_the_drift(dates: list[Path], tmp_path: Path) -> None:
    reports = []
    for date in dates:
        reports.append(date.with_suffix(".html"))
        run(date, "-o", reports[-1])
    told = json.loads(run(*reports, "-o", tmp_path / "drift.html", "--json"))
    (drift,) = told["drift"]
    assert drift["told"].startswith("1 of 1 numbers moved beyond their intervals: F_c (+14.3%)")
    assert {one["name"]: one["verdict"] for one in drift["changes"]}["F_c"] == "moved"
    assert told["axes"] == ["x"]
    assert "F_c" in (tmp_path / "drift.html").read_text(encoding="utf-8")
    assert "friction x: 1 of 1 numbers moved" in run(*dates, "-o", tmp_path / "of-files.html")


def test_notes_of_files_are_no_warnings_on_the_screen(dates: list[Path], tmp_path: Path) -> None:
    """Each note of the example's files began with `warning:` in what `fric report` printed."""
    for severity, head in (("note", "note: flat"), ("doubt", "warning: flat")):
        coded = f"warnings: [flat]\nwarnings_coded: [{{severity: {severity}, text: flat}}]\n"
        dates[0].write_text(FRICTION.format(F_c=105, low=103, high=107, created="2026-01-01") + coded, encoding="utf-8")
        assert head in repr(fric.make_report(dates[0]))


def test_an_existing_report_is_kept(dates: list[Path], tmp_path: Path) -> None:
    kept = tmp_path / "report.html"
    kept.write_text("mine")
    with pytest.raises(FricError, match="exists"):
        run(dates[0], "-o", kept)
    assert kept.read_text() == "mine"
    assert "wrote" in run(dates[0], "-o", kept, "--force", "--title", "A & B")
    assert "A &amp; B" in kept.read_text(encoding="utf-8")
