from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import fric
from fric.cli.main import app
from fric.errors import FricError
from fric.io.hdf5 import write_logs
from tests.turns import in_turns

DATA = Path(__file__).parents[2] / "data"


def run(*words):
    return CliRunner().invoke(app, ["inspect", *map(str, words)], catch_exceptions=False)


def test_json_is_one_object_of_plain_numbers(tmp_path):
    done = run(DATA / "presliding-sine.h5", DATA / "constant-velocity.h5", "--json")
    records = json.loads(done.stdout)["records"]
    assert len(records) == 19
    first = records[0]
    assert first["kind"] == "presliding-sine"
    assert first["sine"]["amplitude"] == pytest.approx(15e-6, rel=0.01)
    assert first["encoder_step"] == pytest.approx(1e-7)
    assert len(first["reversals"]) == 10
    assert first["channels"]["force"]["unit"] == "N"
    assert {use["purpose"] for use in first["uses"]} == {"static", "gms", "plant"}
    speeds = [speed for record in records[2:] for speed in record["speeds"]]
    assert len(speeds) == 34
    assert max(speeds) == pytest.approx(0.03, rel=0.01)
    assert all(s["start"] < s["stop"] for record in records for s in record["stretches"])


def test_few_records_are_told_one_by_one_and_many_in_a_table():
    told = run(DATA / "presliding-sine.h5").stdout
    assert re.search(r"15(\.\d+)? µm, 0\.1 Hz", told)
    assert "good for identify gms" in told
    assert "not good for identify static: no segment" in told
    told = run(DATA / "constant-velocity.h5").stdout
    assert told.count("constant-velocity-") == 17  # no name is cut short
    assert "static 17" in told


@pytest.mark.parametrize(
    "name",
    in_turns(
        ["constant-velocity", "presliding-sine", "sliding-sine", "frequency-response"],
        ["sliding-sine", "frequency-response"],
    ),
)
def test_plot_is_drawn_and_not_overwritten(name, tmp_path):
    figure = tmp_path / "record.svg"
    done = run(DATA / f"{name}.h5", "--plot", figure)
    assert done.exit_code == 0
    assert "wrote" in done.stdout
    drawn = figure.read_text()
    assert drawn.startswith("<?xml")
    if name != "sliding-sine":  # what is there is as dear to a command whichever record it draws
        return
    with pytest.raises(FricError, match="the output exists"):
        run(DATA / f"{name}.h5", "--plot", figure)
    assert figure.read_text() == drawn
    assert run(DATA / f"{name}.h5", "--plot", figure, "--force").exit_code == 0


def test_a_response_as_measured_is_told_and_drawn(tmp_path):
    frequency = np.geomspace(1.0, 200.0, 40)
    response = fric.FrequencyResponse(frequency, 1 / frequency**2, -np.ones(40), np.full(40, 0.9))
    write_logs(tmp_path / "log.h5", [response])
    done = run(tmp_path / "log.h5", "--plot", tmp_path / "figure.png")
    assert "40 frequencies from 1 to 200 Hz" in done.stdout
    assert (tmp_path / "figure.png").stat().st_size > 1000


def test_no_such_file_is_an_error(tmp_path):
    with pytest.raises(FricError, match="no such file"):
        run(tmp_path / "none.h5")
