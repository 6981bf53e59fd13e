"""`fric identify plant`: from the virtual axis and from a table to a plant file, a figure and JSON."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

from fric.cli.main import app
from fric.documents.plant import PlantDocument
from fric.documents.yaml import read_document
from fric.errors import FricError
from fric.io.hdf5 import write_logs
from fric.log import FrequencyResponse, Log
from tests.identify import flawed_axis as flawed
from tests.identify.excited_axis import X, shaken
from tests.identify.test_rigid_body import F_C, F_V, OFFSET, M, motion

RUN = CliRunner()


def identified(tmp_path: Path, records: list[Log | FrequencyResponse], *words: str) -> dict[str, Any]:
    """Write the records, run the command on them, and return the JSON that it prints."""
    log, out, figure = tmp_path / "log.h5", tmp_path / "plant.yaml", tmp_path / "plant.png"
    write_logs(log, records, force=True)
    common = ["identify", "plant", str(log), "-o", str(out), "--plot", str(figure), "--json", "--force", *words]
    done = RUN.invoke(app, common)
    assert done.exit_code == 0, done.output + str(done.exception)
    assert figure.stat().st_size > 10_000
    read_document(out, PlantDocument)
    document: dict[str, Any] = json.loads(done.stdout)
    return document


def test_a_shaken_axis_gives_a_plant_file_that_the_next_command_reads(tmp_path: Path) -> None:
    told = identified(tmp_path, [shaken(X, seed=1)], "--force-constant", "548 N/V")
    for name, unit in (("A", "1/s"), ("B", "m/(s^2*V)"), ("T_d", "s")):
        low, high = told[name]["ci95"]
        assert low < told[name]["value"] < high
        assert told[name]["unit"] == unit
        assert told[name]["value"] == pytest.approx(getattr(X, name), rel=0.03)
    fit = told["fit"]
    assert fit["hold_delay"]["value"] == pytest.approx(125e-6)
    assert fit["transport_delay"]["value"] + 125e-6 == pytest.approx(told["T_d"]["value"])
    plant = read_document(tmp_path / "plant.yaml", PlantDocument).plant("linear")
    assert pytest.approx(548 / X.B, rel=0.01) == plant.M


def test_two_amplitudes_stand_in_the_document(tmp_path: Path) -> None:
    records = [replace(shaken(X, seed=1, mean=0.0, friction=0.19, peak=p), name=f"{p} V") for p in (4.0, 9.0)]
    told = identified(tmp_path, records)
    assert told["fit"]["friction"]["compared"]
    assert [response["record"] for response in told["fit"]["responses"]] == ["4.0 V", "9.0 V"]


def test_a_table_is_taken_without_hold(tmp_path: Path) -> None:
    f = np.geomspace(2, 400, 40)
    G = X.response(f)
    table = FrequencyResponse(f, np.abs(G), np.angle(G), np.full(40, 0.99))
    told = identified(tmp_path, [table], "--lowest", "4 Hz", "--highest", "0.3 kHz")
    assert told["B"]["value"] == pytest.approx(X.B, rel=1e-6)
    assert "hold_delay" not in told["fit"]
    (response,) = told["fit"]["responses"]
    assert 4 <= response["lowest"]["value"] < response["highest"]["value"] <= 300
    held = identified(tmp_path, [table], "--hold", "4 kHz")
    assert held["fit"]["hold_delay"]["value"] == pytest.approx(125e-6)


def test_a_motion_gives_mass_and_friction(tmp_path: Path) -> None:
    made = motion()  # the force acts 0.65 ms after the voltage that makes it, with which it was logged
    early = np.interp(made.time + 0.65e-3, made.time, made.require("force", "a test"))
    log = replace(made, kind="motion", force=early)
    told = identified(tmp_path, [log], "--force-constant", "548 N/V", "--delay", "0.65 ms")
    parameters = told["fit"]["parameters"]
    for name, true in zip(("M", "F_v", "F_c", "offset"), (M, F_V, F_C, OFFSET), strict=True):
        assert parameters[name]["value"] == pytest.approx(true, rel=0.01)
        assert parameters[name]["deviation"] > 0
    assert told["T_d"] == {"value": pytest.approx(0.65e-3), "unit": "s", "fixed": True}
    assert told["fit"]["condition_number"] > 1
    each = identified(tmp_path, [log], "--direction", "each")
    assert "F_c_negative" in each["fit"]["parameters"]


@pytest.mark.parametrize("unit", ["dB", "dB(m/V)"])
def test_a_table_in_decibels_and_wrapped_degrees_is_ingested_and_fitted(tmp_path: Path, unit: str) -> None:
    f = np.geomspace(2, 400, 40)
    G = X.response(f)
    rows = zip(f, 20 * np.log10(np.abs(G)), np.degrees(np.angle(G)), strict=True)
    text = f"frequency [Hz], magnitude [{unit}], phase [deg]\n"
    (tmp_path / "table.csv").write_text(text + "".join(f"{a:.6f}, {b:.6f}, {c:.6f}\n" for a, b, c in rows))
    log, out = tmp_path / "log.h5", tmp_path / "plant.yaml"
    done = RUN.invoke(app, ["ingest", str(tmp_path / "table.csv"), "-o", str(log)])
    assert done.exit_code == 0, done.exception
    done = RUN.invoke(app, ["identify", "plant", str(log), "-o", str(out), "--json"])
    told = json.loads(done.stdout)
    for name in ("A", "B", "T_d"):
        assert told[name]["value"] == pytest.approx(getattr(X, name), rel=1e-4)


def test_people_read_a_table(tmp_path: Path) -> None:
    for record in (shaken(X, seed=1), replace(motion(), kind="motion")):
        write_logs(tmp_path / "log.h5", [record], force=True)
        words = ["identify", "plant", str(tmp_path / "log.h5"), "-o", str(tmp_path / "p.yaml"), "--force"]
        done = RUN.invoke(app, words)
        assert done.exit_code == 0, done.exception
        assert "95 % interval" in done.output
        assert "wrote" in done.output


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--coherence", "1"], "coherence"),
        (["--highest", "300 mm"], "frequency"),
        (["--period", "-1 s"], "not positive"),
        (["--method", "motion", "--cutoff", "3 kHz"], "cut-off"),
    ],
)
def test_what_cannot_be_identified_leaves_no_file(tmp_path: Path, words: list[str], said: str) -> None:
    write_logs(tmp_path / "log.h5", [shaken(X, seed=1)])
    done = RUN.invoke(app, ["identify", "plant", str(tmp_path / "log.h5"), "-o", str(tmp_path / "p.yaml"), *words])
    assert isinstance(done.exception, FricError)
    assert said in str(done.exception)
    assert [path.name for path in tmp_path.iterdir()] == ["log.h5"]


def test_records_of_another_kind_are_not_taken_by_mistake(tmp_path: Path) -> None:
    write_logs(tmp_path / "log.h5", [replace(motion(), kind="presliding-sine")])
    words = ["identify", "plant", str(tmp_path / "log.h5"), "-o", str(tmp_path / "p.yaml")]
    done = RUN.invoke(app, words)
    assert isinstance(done.exception, FricError)
    assert "presliding-sine" in str(done.exception)
    assert RUN.invoke(app, [*words, "--method", "motion"]).exit_code == 0


def test_a_text_log_of_a_shaken_axis_is_ingested_as_a_frequency_response(tmp_path: Path) -> None:
    """A CSV of time, voltage, position and a force that is two samples late: the lag stands in the plant file."""
    late = flawed.shaken(flawed.Machine(), seed=1, force_lag=2.0)
    table = np.column_stack([late.time, late.input, 1e6 * late.position, late.force])  # type: ignore[operator]
    csv, log, out = tmp_path / "shaken.csv", tmp_path / "shaken.h5", tmp_path / "plant.yaml"
    np.savetxt(csv, table, delimiter=",", header="time [s],input [V],position [um],force [N]", comments="", fmt="%.9g")
    done = RUN.invoke(app, ["ingest", str(csv), "-o", str(log), "--kind", "frequency-response"])
    assert done.exit_code == 0, done.output
    words = ["identify", "plant", str(log), "-o", str(out), "--lowest", "2 Hz", "--mass", "84 kg", "--json"]
    done = RUN.invoke(app, words)
    assert done.exit_code == 0, done.output
    told = json.loads(done.stdout)
    assert told["K_f"]["value"] == pytest.approx(210.0, rel=0.01)
    assert told["force_lag"]["value"] * flawed.RATE == pytest.approx(2.0, abs=0.1)
    assert any("The force is logged 500 µs (2 samples) later" in text for text in told["warnings"])
    plant = read_document(out, PlantDocument).plant("linear")
    assert plant.force_lag == pytest.approx(2 / flawed.RATE, rel=0.05)
