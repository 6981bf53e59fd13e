"""The static map of a real screw drive, and what a real ball screw's log is, from the command line."""

import json
from pathlib import Path

import pytest

from tests.command import fric

ROOT = Path(__file__).parents[2]
DATA = ROOT.parent / "shared" / "data"
# of eq. (2) on the medians of the 32 logs, all weighing the same, in SI units; v_s moves with the weighting
KNOWN = {"F_c": 2.315e-3, "F_s": 3.172e-3, "v_s": 4.62, "sigma": 58.3e-6, "offset": -0.375e-3}

pytestmark = [
    pytest.mark.real,
    pytest.mark.skipif(not DATA.exists(), reason="the real logs are not here (../shared/data)"),
]


def told(*words):
    return json.loads(fric(*words, "--json").stdout)


@pytest.fixture(scope="module")
def screwdrive(tmp_path_factory):
    log = tmp_path_factory.mktemp("screwdrive") / "log.h5"
    files = sorted((DATA / "screwdrive1/steady_state/0.096kg").glob("*.csv"))
    assert len(told("ingest", *files, "--map", ROOT / "configs/mappings/screwdrive1.yaml", "-o", log)["records"]) == 32
    return log


@pytest.mark.parametrize(
    ("options", "rmse"), [(["--average", "median", "--weights", "equal"], 37.2e-6), ([], 40e-6)], ids=["equal", "error"]
)
def test_screwdrive_gives_its_known_map(screwdrive, tmp_path, options, rmse):
    found = told("identify", "static", screwdrive, "-o", tmp_path / "map.yaml", *options)
    if options:
        assert {name: found["static"][name]["value"] for name in KNOWN} == pytest.approx(KNOWN, rel=0.01)
        assert found["fit"]["rmse"]["value"] == pytest.approx(rmse, abs=0.05e-6)
    assert found["fit"]["rmse"]["value"] <= rmse + 0.05e-6
    for name, known in KNOWN.items():
        low, high = found["static"][name]["ci95"]
        assert low <= known <= high, name
    low, high = found["static"]["v_s"]["ci95"]
    assert low <= 3.9
    assert high >= 4.8


def test_emps_through_its_mapping_is_a_motion_with_seven_reversals(tmp_path):
    log = tmp_path / "log.h5"
    told("ingest", DATA / "emps/DATA_EMPS.mat", "--map", ROOT / "configs/mappings/emps.yaml", "-o", log)
    (record,) = told("inspect", log)["records"]
    assert (record["kind"], record["stated"], record["samples"]) == ("motion", False, 24841)
    assert record["sampling"] == pytest.approx(1000, rel=1e-4)
    assert len(record["reversals"]) == 7
    force, voltage = record["channels"]["force"], record["channels"]["input"]
    assert force["high"] == pytest.approx(35.15 * voltage["high"], rel=1e-3)
