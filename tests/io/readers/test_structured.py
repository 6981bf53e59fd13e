"""JSON and XML as programs write them: columns, records, lines, structs; and what is damaged."""

import json
from pathlib import Path

import numpy as np
import pytest

from fric.automatic.sources import find_sources
from fric.errors import FricError
from fric.io.readers import tables
from fric.io.readers.structured import recognises

RNG = np.random.default_rng(2)
T = np.round(np.arange(400) * 2e-3, 4)
X = np.round(np.cumsum(RNG.normal(0, 0.1, 400)), 5)
I = np.round(RNG.normal(0, 1, 400), 4)  # noqa: E741 - a current


def read(path: Path) -> dict[str, tuple[str | None, np.ndarray]]:
    (table,) = tables(path)
    blocks = [block.columns for block in table.read(range(len(table.columns)))]
    values = map(np.concatenate, zip(*blocks, strict=True))
    return {column.name: (column.unit, found) for column, found in zip(table.columns, values, strict=True)}


ROWS = [{"ts": t, "joint": {"position": x, "current": i}, "state": "RUN"} for t, x, i in zip(T, X, I, strict=True)]
XML_ROWS = "".join(f'<s pos="{x}" t="{t}"><cur>{i}</cur></s>' for t, x, i in zip(T, X, I, strict=True))


@pytest.mark.parametrize(("name", "text", "names"), [
    ("a.json", json.dumps({"meta": {"fs": 500, "tags": ["a", "b"]}, "t": [*T], "x_mm": [*X], "i_A": [*I]}),
     ("t", "x_mm", "i_A")),
    ("a.json", json.dumps({"sample_time_us": 800, "channels": [
        {"name": n, "unit": "", "values": [*map(float, v)]} for n, v in (("t", T), ("x", X), ("i", I))]}),
     ("channels.t", "channels.x", "channels.i")),
    ("a.json", json.dumps({"data": ROWS}, indent=1), ("data.ts", "data.joint.position", "data.joint.current")),
    ("a.json", json.dumps(ROWS), ("ts", "joint.position", "joint.current")),
    ("a.jsonl", "\n".join(map(json.dumps, ROWS)) + "\n\n", ("ts", "joint.position", "joint.current")),
    ("a.json", json.dumps({"names": ["t", "x", "i"], "rows": np.column_stack([T, X, I]).tolist()}),
     ("rows.t", "rows.x", "rows.i")),
    ("a.xml", f'<?xml version="1.0"?><log unit="mm"><head/><data>{XML_ROWS}</data></log>', ("t", "pos", "cur")),
    ("a.xml", '<?xml version="1.0"?><log>' + "".join(
        f'<channel name="{n}">{" ".join(map(str, v))}</channel>' for n, v in (("t", T), ("x", X), ("i", I))) + "</log>",
     ("t", "x", "i")),
    ("putty.log", "PuTTY log 2024\nboot: ok=1\n" + "\n".join(
        f"t={t} pos: {x}, cur={i}" for t, x, i in zip(T, X, I, strict=True)), ("t", "pos", "cur")),
])  # fmt: skip
def test_every_value_is_in_its_column(tmp_path, name, text, names):
    path = tmp_path / name
    path.write_text(text)
    found = read(path)
    for column, values in zip(names, (T, X, I), strict=True):
        key = column if column in found else column.rpartition("_")[0]
        assert found[key][1] == pytest.approx(values), column


@pytest.mark.parametrize(("name", "text"), [
    ("a.json", json.dumps({"units": {"pos": "mm", "t": "s"}, "t": [*T], "pos": [*X], "cur": [*I]})),
    ("a.xml", f'<?xml version="1.0"?><log unit_pos="mm" unit_t="s">{XML_ROWS}</log>'),
])  # fmt: skip
def test_units_beside_the_columns_are_theirs(tmp_path, name, text):
    (tmp_path / name).write_text(text)
    assert {column: unit for column, (unit, _) in read(tmp_path / name).items()} == {"t": "s", "pos": "mm", "cur": None}


def test_dates_are_seconds_and_gaps_are_no_numbers(tmp_path):
    path = tmp_path / "a.json"
    rows = [
        {"time": f"2024-05-04T10:00:{s:09.6f}Z", "x": None if n == 7 else x}
        for n, (s, x) in enumerate(zip(T, X, strict=True))
    ]
    path.write_text(json.dumps(rows))
    found = read(path)
    assert np.diff(found["time"][1]) == pytest.approx(2e-3, abs=1e-6)
    assert np.flatnonzero(np.isnan(found["x"][1])).tolist() == [7]


def test_runs_are_records_and_settings_beside_logs_are_none(tmp_path):
    folder = tmp_path / "logs"
    folder.mkdir()
    v = np.sin(2 * np.pi * 1.3 * T) + 0.4 * np.sin(2 * np.pi * 3 * T)
    x, f = np.cumsum(v) * 2e-3, 20 * np.sign(v) + 3 * v + np.gradient(v, 2e-3)
    run = {"time_s": [*T], "position_rad": [*x], "torque_Nm": [*f]}
    (folder / "runs.json").write_text(json.dumps([run, run | {"torque_Nm": [*(f + 0.1)]}]))
    (folder / "settings.json").write_text(json.dumps({"drive": {"kp": 12.5, "limits": [1, 2]}, "name": "x"}))
    (folder / "page.html").write_text("<html><p>1, 2, 3, 4</p><p>2</p><p>3</p></html>")
    assert len(list(tables(folder / "runs.json"))) == 2
    found = find_sources([folder], (), tmp_path / "out/mappings", assume=True)
    assert [log.path.name for log in found.logs] == ["runs.json"]
    assert not found.refused


@pytest.mark.parametrize(("name", "text", "says"), [
    ("a.json", json.dumps(ROWS)[:3000], "is no JSON"),
    ("a.jsonl", "\n".join(map(json.dumps, ROWS))[:-9], "line 400"),
    ("a.xml", f'<?xml version="1.0"?><log>{XML_ROWS}', "not complete XML"),
    ("a.xml", f'<?xml version="1.0"?><!DOCTYPE a [<!ENTITY b "1">]><log>{XML_ROWS}</log>', "a document type"),
    ("a.json", '{"a": [1, 2, 3, 4, 5, 6, 7, 8], "b": ' + "[" * 100_000 + "1", "is no JSON|nests too deep"),
    ("a.json", '{"a": "[1, 2, 3]", "b": {"c": [1, 2, 3, 4, 5, 6, 7, 8', "is no JSON"),
])  # fmt: skip
def test_what_is_damaged_ends_in_a_sentence(tmp_path, name, text, says):
    path = tmp_path / name
    path.write_text(text)
    with pytest.raises(FricError, match=says) as caught:
        list(tables(path))
    assert name in str(caught.value)


def test_a_heading_in_brackets_is_no_json():
    """A text of an oscilloscope with [HEADER] was refused as damaged JSON."""
    rows = b"1.5;2.5;0.1;1.5;2.5;0.1;7;8\n" * 4
    assert recognises(Path("osci.dat"), b"[HEADER]\nSampleTime=0.003\n[DATA]\n" + rows) == 0.0
    assert recognises(Path("rows.json"), b"[[1.5, 2.5, 0.1, 1.5, 2.5, 0.1, 7, 8], [1, 2]]") > 0.0


@pytest.mark.parametrize("ranged", [False, True])
@pytest.mark.parametrize("name", ["rig.txt", "rig.mat"])
def test_variables_that_octave_writes_as_text_are_columns(tmp_path, name, ranged):
    """As ``save -text`` writes them; a time ``0:dt:T`` is written as a range. The file was a text without columns."""
    t = np.arange(500) * 2e-3
    values = {"theta": np.sin(t)[:, None], "speeds": np.column_stack([np.cos(t), -np.cos(t)])}
    if not ranged:
        values["t"] = t[:, None]
    lines = ["# Created by Octave 8.4.0, Tue Mar 12 10:14:22 2024 CET <user@lab>"]
    for key, part in values.items():
        lines += [f"# name: {key}", "# type: matrix", f"# rows: {len(part)}", f"# columns: {part.shape[1]}"]
        lines += [" " + " ".join(f"{cell:.17g}" for cell in row) for row in part] + ["", ""]
    lines += ["# name: t", "# type: double_range", "# base, limit, increment", "0 0.998 0.002", ""] if ranged else []
    (tmp_path / name).write_text("\n".join(lines) + "\n")
    (table,) = tables(tmp_path / name)
    (block,) = table.read(range(4))
    found = dict(zip([column.name for column in table.columns], block.columns, strict=True))
    assert found["t"] == pytest.approx(t)
    assert found["theta"] == pytest.approx(np.sin(t))
    assert [column for key, column in found.items() if "speeds" in key][1] == pytest.approx(-np.cos(t))


@pytest.mark.parametrize("body", [
    "# name: a\n# type: matrix\n# rows: 3\n# columns: 2\n 1 2\n 3 NA\n x\n",
    "# name: a\n# type: range\n# base, limit, increment\n0 1e300 1e-300\n", "# name: a\n# type: matrix\n", "",
])  # fmt: skip
def test_broken_texts_of_octave_end_in_a_sentence(tmp_path, body):
    path = tmp_path / "a.txt"
    path.write_text("# Created by Octave 8.4.0\n" + body)
    with pytest.raises(FricError):
        list(next(tables(path)).read([0, 1, 2, 3]))


@pytest.mark.parametrize("row", ["t={} s, pos={} deg, i={} A", "t: {} s pos: {} deg i: {} A"])
def test_units_behind_the_values_of_lines_are_those_of_columns(tmp_path, row):
    path = tmp_path / "out.log"
    path.write_text("\n".join(row.format(*z) for z in zip(T, X, I, strict=True)) + "\n")
    found = read(path)
    assert {name: unit for name, (unit, _) in found.items()} == {"t": "s", "pos": "deg", "i": "A"}
    assert found["pos"][1] == pytest.approx(X)


def test_a_name_behind_a_value_is_no_unit(tmp_path):
    path = tmp_path / "out.log"
    path.write_text("\n".join(f"t=1{n} m={n} s : {n}" for n in range(200)) + "\n")
    assert [unit for unit, _ in read(path).values()] == [None, None, None]
