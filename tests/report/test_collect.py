"""Files are recognised by their content, sorted by date, and come out of a report as they went in."""

from __future__ import annotations

import shutil
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import fric
from fric.control.scheme import choose_schemes
from fric.documents.contours import MonteCarloPart
from fric.errors import FricError
from fric.io.circle import read_runs, write_runs
from fric.io.recognise import read_report, recognise
from fric.output import written
from fric.report.collect import as_data, collect, contour_test
from fric.report.view import render_report
from fric.simulate.contour_run import PointPath, run_circle, run_path
from fric.simulate.processes import Study
from tests.studies import monte_carlo

from .conftest import LOGS, PAPER


def test_content_counts_and_not_the_name(files: SimpleNamespace, tmp_path: Path) -> None:
    for source, found in ((files.run, "run/1"), (files.march, "friction/1"), (LOGS / "presliding-sine.h5", "log/1")):
        other = tmp_path / f"{found[:3]}.txt"
        shutil.copy(source, other)
        assert recognise(other) == found


@pytest.mark.parametrize(
    ("content", "what"),
    [
        ("a: 1\n", "not a file of fric"),
        ("<!doctype html><p>hello", "not a file of fric"),
        ("fric: scheme/1", "does not show"),
    ],
)
def test_what_is_no_part_of_a_report_is_refused(tmp_path: Path, content: str, what: str) -> None:
    path = tmp_path / "file.yaml"
    path.write_text(content)
    with pytest.raises(FricError, match=what):
        collect([path])
    with pytest.raises(FricError, match="no such file"):
        collect([tmp_path / "none.h5"])


def test_a_foreign_log_is_sent_to_ingest(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_bytes("Prüfstand\nZeit [ms];Kraft [N]\n0;1,5\n".encode("latin-1"))
    with pytest.raises(FricError, match=r"not a file of fric\n.*`fric ingest` reads foreign logs"):
        collect([path])


def test_a_bundled_machine_goes_by_its_name(files: SimpleNamespace) -> None:
    assert collect([files.run, Path("xy-table")]).machine == collect([files.run, PAPER]).machine
    with pytest.raises(FricError, match="no such file") as raised:
        collect([files.run, Path("xy-tabel")])
    assert "xy-table" in str(raised.value)


def test_a_machine_file_or_logs_alone_make_no_report() -> None:
    for given in (PAPER, LOGS / "presliding-sine.h5"):
        with pytest.raises(FricError, match="make no report"):
            collect([given])


def test_a_static_map_that_the_gms_file_carries_over_is_no_earlier_date(files: SimpleNamespace) -> None:
    inputs = collect([files.static, files.march])
    assert [item.source for item in inputs.items] == ["march.yaml"]
    assert [item.source for item in inputs.replaced] == ["static.yaml"]
    assert not inputs.pairs


def test_an_open_limit_of_an_interval_is_infinite(files: SimpleNamespace) -> None:
    (item,) = collect([files.march]).items
    assert item.sections()["gms"]["C"].ci95 == (0.0, np.inf)


def test_the_numbers_of_a_run_pass_through_a_report_to_the_last_digit(files: SimpleNamespace, tmp_path: Path) -> None:
    inputs = collect([files.run, files.march])
    path = tmp_path / "report.html"
    written(path, render_report(inputs))
    again = collect([path])
    runs = {run.scheme.name: run for run in read_runs(files.run)}
    (test,) = again.tests
    assert {one.scheme.name for one in test.contours} == set(runs)
    for one in test.contours:
        truth = runs[one.scheme.name].circularity
        assert one.glitches == truth.quadrants
        assert (one.glitch, one.rms, one.range) == (truth.glitch, truth.rms, truth.range)
    assert again.items[0].tree == inputs.items[0].tree
    assert read_report(path)["documents"] == as_data(inputs)["documents"]
    assert contour_test(read_report(path)["tests"][0], "").created == "2026-03-02T08:00:00+00:00"


@pytest.mark.long(2)
def test_what_many_machines_gave_comes_as_intervals(files: SimpleNamespace, tmp_path: Path) -> None:
    path = tmp_path / "many.h5"
    machine = fric.read_machine(PAPER)
    schemes = tuple(choose_schemes("a,c"))
    found = monte_carlo(Study(machine, schemes, seed=1), 8)
    write_runs(path, [run_circle(machine, scheme) for scheme in schemes], many=found)
    for one in collect([path]).tests[0].contours:
        low, high = one.interval
        assert low == pytest.approx(MonteCarloPart.model_validate(found).schemes[one.scheme.name].ci95[0])
        assert high == one.stays_under
        assert 0 < low <= one.middle <= one.stays_under
        assert len(one.swings) == len(one.drawn) == 8
    assert "at most" in render_report(collect([path]))
    assert "on 95 % of machines" not in render_report(collect([files.run]))


def test_the_reversals_of_a_path_are_told_by_axis_and_place(tmp_path: Path) -> None:
    turn = np.linspace(0, 2 * np.pi, 400)
    ellipse = PointPath(0.02 * np.cos(turn), 0.012 * np.sin(turn), 0.05)
    run = run_path(fric.read_machine(PAPER), choose_schemes("a")[0], ellipse)
    path = tmp_path / "path.h5"
    write_runs(path, [run])
    (test,) = collect([path]).tests
    assert test.radius is None
    assert [label.partition(",")[0] for label in test.labels[1:2]] == ["x at (-20"]
    assert test.contours[0].glitches == tuple(one.glitch for one in run.contour.reversals)
    assert "within 30°" not in render_report(collect([path]))


def test_a_picture_is_no_file_of_fric_s(tmp_path: Path) -> None:
    picture = tmp_path / "figure.png"
    picture.write_bytes(b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR")
    with pytest.raises(FricError, match="not a file of fric"):
        recognise(picture)


@pytest.mark.parametrize("fit", ["null", "{between_strokes: null, rmse: null, r2: null}"])
def test_what_a_file_leaves_null_is_absent(files: SimpleNamespace, tmp_path: Path, fit: str) -> None:
    """A scatter of null between strokes ended the page in a traceback."""
    friction = tmp_path / "friction.yaml"
    lines = files.march.read_text().splitlines()
    friction.write_text("\n".join(f"fit: {fit}" if line.startswith("fit:") else line for line in lines))
    inputs = collect([friction])
    assert "fit" not in inputs.items[0].tree or "between_strokes" not in inputs.items[0].tree["fit"]
    assert "Friction of axis x over velocity" in render_report(inputs)
