"""Fleets: which axes changed, with hundreds of numbers compared; the same digits alone and on a cluster."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import fric
from fric.automatic.fleet import LEVEL, find_fleet, holm, probability
from fric.automatic.steps import Step
from fric.cli.main import app
from fric.documents.listings import FleetDocument
from fric.documents.yaml import read_document
from fric.io.circle import write_circles
from fric.report.collect import Change
from tests.automatic.fleet_rig import DATES, make_fleet
from tests.circles.synthetic_circles import Faults, circle
from tests.figures.drawn import undrawn

DRIFTED = {1}


@pytest.fixture(scope="module")
def logs(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("fleet") / "logs"
    make_fleet(folder, 2, DRIFTED)
    return folder


@pytest.mark.long(5)
def test_the_axis_that_drifted_stands_first_and_alone(logs: Path, tmp_path: Path) -> None:
    with undrawn():
        found = fric.auto(logs, output=tmp_path / "out", workers=1, run=Step.make)
    assert found.changed == [("machine-001", "x")]
    (first, *_) = found.drifts
    assert first.change.name == "F_c"
    assert first.change.relative == pytest.approx(0.15, abs=0.02)
    assert found.values()[0][0] == "machine-001 x"
    page = (tmp_path / "out" / "fleet.html").read_text()
    assert page.index("machine-001") < page.index("machine-000")
    assert "http" not in page.split("<body>")[1]
    written = read_document(tmp_path / "out" / "fleet.yaml", FleetDocument)
    assert written.changed == [["machine-001", "x"]]
    assert written.tests == len(found.drifts)
    script = (tmp_path / "out" / "machine-000" / DATES[0] / "steps.sh").read_text()
    assert "fric identify static" in script
    again = fric.auto(logs, output=tmp_path / "out", workers=1, run=Step.make)
    assert sum(one.made for one in again.outcomes) == 0
    assert [one.change for one in again.drifts] == [one.change for one in found.drifts]


@pytest.mark.long(2)
def test_a_log_that_is_damaged_is_no_end_of_the_fleet(logs: Path, tmp_path: Path) -> None:
    folder = tmp_path / "logs"
    for machine in ("machine-000", "machine-001"):
        for date in DATES:
            (folder / machine / date).mkdir(parents=True)
            (folder / machine / date / "x.h5").write_bytes((logs / machine / date / "x.h5").read_bytes())
    (folder / "machine-000" / DATES[0] / "x.h5").write_bytes(b"\x89HDF\r\n\x1a\n and no more")
    with undrawn():
        found = fric.auto(folder, output=tmp_path / "out", workers=1, run=Step.make)
    assert found.changed == [("machine-001", "x")]
    assert any("machine-000/2026-01-10" in notice and notice.code for notice in found.warnings)


def test_a_fleet_is_a_folder_of_machines_and_dates_alone(logs: Path, tmp_path: Path) -> None:
    assert [(one.machine, one.date) for one in find_fleet([logs])[:2]] == [("machine-000", date) for date in DATES]
    assert find_fleet([logs, logs]) == []
    assert find_fleet([logs / "machine-000"]) == []
    (tmp_path / "machine" / "strokes").mkdir(parents=True)
    assert find_fleet([tmp_path]) == []
    with pytest.raises(fric.FricError, match="takes no machine"):
        fric.auto(logs, output=tmp_path / "out", machine="xy-table")
    with pytest.raises(fric.FricError, match="takes no machine, circle, controller or tolerance"):
        fric.auto(logs, output=tmp_path / "out", controllers=["K_v=100 1/s, K_p=131 V*s/m, K_i=4090 V/m"])
    with pytest.raises(fric.FricError, match="no fleet use no cluster"):
        fric.auto(logs / "machine-000", output=tmp_path / "out", scheduler="tcp://127.0.0.1:8786")


def test_holm_by_hand() -> None:
    np.testing.assert_allclose(holm(np.array([0.01, 0.04, 0.03, 0.005])), [0.03, 0.06, 0.06, 0.02])
    assert holm(np.zeros(0)).shape == (0,)


def test_a_fleet_without_a_change_shows_one_in_one_fleet_of_twenty() -> None:
    """Intervals of few degrees of freedom have heavy tails: by the normal distribution many fleets would show some."""
    rng = np.random.default_rng(5)
    freedom, numbers, fleets = 5, 300, 300
    t = 2.570581835636314  # Student's quantile at 97.5 % for 5 degrees of freedom, from a table
    found, naive = 0, 0
    for _ in range(fleets):
        p, loose = [], []
        for value, after, error in zip(
            rng.normal(size=numbers), rng.normal(size=numbers), np.sqrt(rng.chisquare(freedom, numbers) / freedom),
            strict=True,
        ):  # fmt: skip
            half = t * error
            change = Change("F_c", "N", value, after, (value - half, value + half), (after - half, after + half))
            p.append(probability(change, freedom))
            loose.append(probability(change, 1e9))
        found += bool(holm(np.array(p)).min() <= LEVEL)
        naive += bool(np.min(loose) * numbers <= LEVEL)
    assert found <= 0.05 * fleets + 3 * np.sqrt(0.05 * 0.95 * fleets)
    assert naive > 0.15 * fleets


def test_what_has_no_limit_tells_of_no_change() -> None:
    assert probability(Change("v_s", "m/s", 1.0, 2.0, (0.5, np.inf), (1.5, 2.5)), 10) is None
    assert probability(Change("v_s", "m/s", 1.0, 2.0), 10) is None
    assert probability(Change("v_s", "m/s", 1.0, 1.0, (0.5, 1.5), (0.5, 1.5)), 10) == pytest.approx(1.0)


@pytest.mark.long(40)
def test_the_same_digits_in_two_processes_and_on_a_dask_cluster(logs: Path, tmp_path: Path) -> None:
    distributed = pytest.importorskip("distributed")
    alone = fric.auto(logs, output=tmp_path / "alone", workers=1, run=Step.make)
    done = CliRunner().invoke(app, ["auto", str(logs), "-o", str(tmp_path / "two"), "--workers", "2", "--json"])
    assert done.exit_code == 0, done.output
    two = json.loads(done.stdout)
    assert two["changes"] == alone.document["changes"]
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        shared = fric.auto(logs, output=tmp_path / "dask", scheduler=cluster.scheduler_address, run=Step.make)
    assert [vars(one) for one in shared.drifts] == [vars(one) for one in alone.drifts]


def test_a_glitch_that_grew_on_measured_circles_is_a_change_of_its_axis(tmp_path: Path) -> None:
    """At the second date one machine's glitches of x are 3 µm higher, and nothing else of the two differs."""
    logs = tmp_path / "logs"
    for machine in range(2):
        for n, date in enumerate(DATES):
            along_x = 6e-6 + (3e-6 if machine and n else 0.0)
            made = circle(Faults(glitch=(along_x, 5e-6) * 2), np.random.default_rng(2 * machine + n))
            place = logs / f"m-{machine}" / date
            place.mkdir(parents=True)
            write_circles(place / "circle.h5", [made])
    found = fric.auto(logs, output=tmp_path / "out", workers=1, run=Step.make)
    assert found.changed == [("m-1", "x")]
    assert {one.change.name[:9] for one in found.drifts if one.changed} == {"glitch +x", "glitch -x"}
    assert len(found.drifts) == 8
    assert "µm ±" in found.values()[0][-1]
