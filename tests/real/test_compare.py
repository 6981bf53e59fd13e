"""Models compared on a reciprocating contact that was measured by others."""

import json
from pathlib import Path

import pytest

from tests.command import fric

ROOT = Path(__file__).parents[2]
RECORD = ROOT / "../shared/data/tribometer/reciprocating-first-75s.txt"

pytestmark = [pytest.mark.real, pytest.mark.skipif(not RECORD.exists(), reason="the tribometer record is not here")]


@pytest.mark.parametrize(
    "models", [("maxwell_slip", "lugre"), pytest.param(("gms", "maxwell_slip", "lugre"), marks=pytest.mark.long(8))]
)
def test_slip_blocks_fitted_to_five_loops_hold_for_the_rest(tmp_path, models):
    log, figure = tmp_path / "tribometer.h5", tmp_path / "models.png"
    fric("ingest", RECORD, "--map", ROOT / "configs/mappings/tribometer.yaml", "-o", log)
    words = ["--models", ",".join(models), "--cycles", 5, "--json", "--plot", figure]
    found = json.loads(fric("compare", log, *words).stdout)["models"]
    for blocks in models[:-1]:
        assert found[blocks]["rms"] <= 0.16
        assert found[blocks]["rms"] < found["lugre"]["rms"]
    assert figure.stat().st_size > 10_000
