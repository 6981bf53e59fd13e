"""Recordings in the form of public ones of a SINUMERIK Edge: JSON, and its rows as CSV."""

import json
from pathlib import Path

import numpy as np
import pytest

from fric.errors import FricError
from fric.io.readers import tables
from fric.results.ingest import ingest

SIGNALS = (("CYCLE", "Cycle"), ("DES_POS|1", "X1"), ("ENC_POS|1", "X1"), ("CURRENT|1", "X1"), ("LOAD|1", "X1"),
           ("ENC1_POS|4", "C1"), ("ENC2_POS|4", "C1"), ("TORQUE|4", "C1"), ("CURRENT|4", "C1"), ("CMD_SPEED|4", "C1"),
           ("ENC_POS|5", "B1"), ("CURRENT|5", "B1"))  # fmt: skip
FIRST = 5558098


def rows(count: int, seed: int = 0) -> np.ndarray:
    """Return rows in which the machine has no axis 5, and two counts are missing in the middle."""
    rng = np.random.default_rng(seed)
    values = np.round(np.cumsum(rng.normal(0, 1, (count, len(SIGNALS))), axis=0), 6)
    values[:, 0] = FIRST + np.arange(count) + 2 * (np.arange(count) >= count // 2)
    values[:, 10:] = 0.0
    return values


def recording(path: Path, values: np.ndarray, *, cycle: float | None = 2, message: int = 7) -> Path:
    """Write a recording as Capture does: some rows a message, blocks and slow data between them."""
    header = {"Version": {"outputFileFormatVersion": "1.0"}, "SignalListHFData": [
        {"Name": name, "Type": "DOUBLE", "Axis": axis, "Address": name} for name, axis in SIGNALS
    ], "SignalListLFData": [{"id": "0", "path": "/Channel/State/actTNumber", "samplingPeriod": 500}]}  # fmt: skip
    if cycle is not None:
        header["CycleTimeMs"] = cycle
    payload = []
    for n in range(0, len(values), message):
        payload.append({"HFData": [[int(row[0]), *row[1:]] for row in values[n : n + message].tolist()]})
        payload.append({"HFBlockEvent": {"HFProbeCounter": n, "GCode": "G1 X1 ]}", "ipoReadError": None}})
    payload.append({"LFData": [{"address": "/Channel/State/actTNumber", "value": "6", "HfProbeCounter": 7}]})
    path.write_text(json.dumps({"Header": header, "Payload": payload}, indent=1))
    return path


def read(path: Path) -> dict[str, tuple[dict[str, str | None], dict[str, np.ndarray]]]:
    found = {}
    for table in tables(path):
        blocks = [block.columns for block in table.read(range(len(table.columns)))]
        names = [column.name for column in table.columns]
        values = dict(zip(names, map(np.concatenate, zip(*blocks, strict=True)), strict=True))
        found[table.said["axis"]] = ({column.name: column.unit for column in table.columns}, values)
    return found


@pytest.mark.parametrize("cycle", [2, 4, None])
def test_every_value_is_on_its_axis_with_the_unit_that_the_address_means(tmp_path, cycle):
    values = rows(100)
    found = read(recording(tmp_path / "a.json", values, cycle=cycle))
    assert found.keys() == {"x1", "c1"}  # axis 5 is listed and stays at zero
    units, x = found["x1"]
    assert (units["position"], units["reference"], units["force"], units["LOAD"]) == ("mm", "mm", "A", None)
    units, c = found["c1"]
    assert (units["position"], units["load_position"], units["force"]) == ("deg", "deg", "N*m")
    time = (values[:, 0] - FIRST) * (cycle or 2) * 1e-3  # a pause of two counts is one of the time
    for channel, column in (("reference", 1), ("position", 2), ("force", 3), ("LOAD", 4)):
        assert np.array_equal(x[channel], values[:, column])
    for channel, column in (("position", 5), ("load_position", 6), ("force", 7), ("CMD_SPEED", 9)):
        assert np.array_equal(c[channel], values[:, column])
    np.testing.assert_allclose(x["time"] - x["time"][0], time, atol=1e-9)


def test_its_rows_as_csv_say_what_is_assumed(tmp_path):
    """The addresses tell the signals; what the JSON's header tells besides is assumed, and said."""
    values = rows(200)
    path = tmp_path / "IMP-01_hfdata.csv"
    lines = [",".join(name for name, _ in SIGNALS), *(",".join(map(repr, row)) for row in values.tolist())]
    path.write_text("\n".join(lines))
    found = read(path)
    assert found["axis1"][0]["position"] == "mm"
    assert found["axis4"][0]["position"] == "deg"
    assert np.array_equal(found["axis1"][1]["force"], values[:, 3])
    np.testing.assert_allclose(np.diff(found["axis1"][1]["time"])[:50], 0.002, rtol=1e-6)
    said = ingest(path, output=tmp_path / "log.h5", axis="axis1").warnings
    assert "cycle-assumed" in [warning.code for warning in said]


@pytest.mark.parametrize(
    ("damage", "why"),
    [
        (lambda text: text[: len(text) // 2], "cut off"),
        (lambda text: text.replace('"Payload"', '"Load"'), "has no Payload"),
        (lambda text: text.replace(f"{FIRST},", f"1, {FIRST},", 1), "does not hold the 12"),
        (lambda text: text.replace('"CycleTimeMs": 2', '"CycleTimeMs": "soon"'), "CycleTimeMs"),
        (lambda text: text.replace('"HFData"', '"LFData"'), "holds no samples"),
        (lambda text: text.replace("_POS|", "_PATH|"), "no axis that moves"),
        (lambda text: text.replace('"CYCLE"', '"CYCLIST"'), "lacks the column CYCLE"),
    ],
)  # fmt: skip
def test_a_damaged_recording_ends_in_a_sentence(tmp_path, damage, why):
    path = recording(tmp_path / "a.json", rows(40))
    path.write_text(damage(path.read_text()))
    with pytest.raises(FricError, match=why):
        read(path)


def test_auto_finds_recordings_among_other_json_and_passes_on_what_is_assumed(tmp_path):
    from fric.automatic.sources import find_sources

    (tmp_path / "package.json").write_text('{"name": "no log", "version": [1, 2, 3]}')
    recording(tmp_path / "a.json", rows(300))
    found = find_sources([tmp_path])
    assert [log.axis for log in found.logs] == ["x1", "c1"]
    assert not found.refused
