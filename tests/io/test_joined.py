"""Channels in separate files joined into one record, and tables of means as records of their own kind."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from typer.testing import CliRunner

import fric
from fric.cli.main import app
from fric.errors import FricError
from fric.friction.stribeck import StaticMap
from fric.io.channels import plan
from fric.io.ingest import joined
from fric.io.readers.base import Column, Memory
from fric.log import ForceVelocity
from fric.notice import Notice

LAW = StaticMap(F_c=60.0, F_s=90.0, v_s=2e-3, sigma=800.0)


def run(*words: object) -> str:
    done = CliRunner().invoke(app, [*map(str, words)])
    if done.exception is not None:
        raise done.exception
    return done.stdout


def force_at(v: np.ndarray) -> np.ndarray:
    return np.sign(v) * LAW.level(v) + LAW.sigma * v


def motion(t: np.ndarray) -> np.ndarray:
    return 3.0 * np.sin(2.0 * t) + 0.4 * t


def read(*files: tuple[str, dict[str, np.ndarray]]) -> tuple[dict[str, np.ndarray], list[Notice]]:
    """Join tables in memory, each a name and its columns with the time first; return the channels and what is told."""
    known = []
    for name, columns in files:
        unit = {"time": "s", "position": "m", "velocity": "m/s", "force": "N", "input": "V"}
        table = Memory(Path(name), tuple(Column(key, unit[key]) for key in columns), list(columns.values()))
        known.append((table, plan(table, None, None, "linear", {}, part=True)))
    table, chosen = joined(known)
    blocks = [chosen.convert(block.columns, np.arange(len(block.columns[0]))) for block in table.read(chosen.wanted)]
    return {name: np.concatenate([block[name] for block in blocks]) for name in chosen.origins}, list(table.notices)


@settings(max_examples=30, deadline=None)
@given(rate=st.floats(20.0, 2000.0), other=st.floats(20.0, 2000.0), late=st.floats(-0.3, 0.3), long=st.floats(1.0, 3.0))
def test_two_files_of_any_rates_become_one_record_of_what_both_hold(
    rate: float, other: float, late: float, long: float
) -> None:
    """Against the motion itself: the position is never made up, and the force is off by what a chord is off."""
    t, s = np.arange(0.0, 2.5, 1 / rate), late + np.arange(0.0, long, 1 / other)
    channels, notices = read(("a", {"time": t, "position": motion(t)}), ("b", {"time": s, "force": motion(s)}))
    clock = channels["time"]
    assert np.isin(clock, t).all()
    assert np.array_equal(channels["position"], motion(clock))
    steps = np.diff(clock)
    assert np.allclose(steps, steps[0])
    assert steps[0] >= 0.94 * max(1 / rate, 1 / other)
    assert clock[0] >= max(t[0], s[0]) - 1e-3 / rate
    assert clock[-1] <= min(t[-1], s[-1]) + 1e-3 / rate
    chord = 12.0 / other**2 / 8 + 7e-3 / rate  # |z''| of the motion is 12 at most, |z'| 6.4
    assert np.abs(channels["force"] - motion(clock)).max() <= chord + 1e-9
    nearest = np.clip(np.searchsorted(s, clock), 1, len(s) - 1)
    off = np.minimum(np.abs(s[nearest] - clock), np.abs(s[nearest - 1] - clock)).max()
    if off > 2e-3 * max(1 / rate, 1 / other):
        assert "joined-moved" in {one.code for one in notices}


def test_one_clock_moves_nothing_and_a_shift_is_told_with_its_size() -> None:
    t = np.arange(1000) * 1e-3
    same, told = read(("a", {"time": t, "position": t}), ("b", {"time": t + 1e-9, "force": t}))
    assert np.allclose(same["force"], same["position"])
    assert not told
    holed = t[(t < 0.4) | (t > 0.6)]
    found, told = read(("a", {"time": t, "position": t}), ("b", {"time": holed, "force": holed}))
    assert not ((found["time"] > 0.401) & (found["time"] < 0.599)).any()
    assert [one.values["holes"] > 0 for one in told if one.code == "joined-in-part"] == [True]
    _, told = read(("a.csv", {"time": t, "velocity": t}), ("b.csv", {"time": t + 3e-4, "force": t}))
    assert any("moved by -300 µs" in one for one in told)


@pytest.mark.parametrize(
    ("parts", "what"),
    [
        ([("a", 0.0, "position"), ("b", 0.0, "position")], "position is in a and in b"),
        ([("a", 0.0, "force"), ("b", 0.0, "input")], "no file holds position or velocity"),
        ([("a", 0.0, "position"), ("b", 1600.0, "force")], "no time in common"),
    ],
)
def test_files_that_are_no_one_record_are_refused(parts: list[tuple[str, float, str]], what: str) -> None:
    t = np.arange(100) * 0.01
    with pytest.raises(FricError, match=what):
        read(*[(name, {"time": start + t, channel: t}) for name, start, channel in parts])


def test_joined_files_are_identified_as_the_whole_file_is(tmp_path: Path) -> None:
    rows = Path("data/strokes/constant-velocity-09.csv").read_text().splitlines()
    cells = [row.split(",") for row in rows]
    (tmp_path / "z.csv").write_text("\n".join(f"{a},{b}" for a, b, _ in cells))
    (tmp_path / "f.csv").write_text("\n".join(f"{a},{c}" for a, _, c in cells))
    log = tmp_path / "log.h5"
    told = json.loads(run("ingest", "--join", tmp_path / "z.csv", tmp_path / "f.csv", "-o", log, "--json"))
    (record,) = told["records"]
    assert record["channels"] == {"time": "time", "position": "z.csv: position", "force": "f.csv: force"}
    run("ingest", "data/strokes/constant-velocity-09.csv", "-o", tmp_path / "whole.h5")
    one, whole = fric.read(log)[0], fric.read(tmp_path / "whole.h5")[0]
    for channel, values in whole.channels().items():
        assert np.array_equal(getattr(one, channel), values)
    again = json.loads(run("ingest", "--join", tmp_path / "z.csv", tmp_path / "f.csv", "-o", log, "--append", "--json"))
    assert again["skipped"]
    assert not again["records"]


def test_columns_of_one_name_are_told_apart_by_their_files(tmp_path: Path) -> None:
    t = np.arange(200) * 0.01
    for name, values in (("ch1", np.sin(t)), ("ch2", np.cos(t))):
        np.savetxt(tmp_path / f"{name}.csv", np.column_stack([t, values]), delimiter=",", header="t,value", comments="")
    (tmp_path / "map.yaml").write_text(
        "fric: mapping/1\nmotion: linear\ncolumns:\n  time: {column: t, unit: s}\n"
        '  position: {column: value, unit: mm, file: "ch1*"}\n  force: {column: value, unit: N, file: "ch2*"}\n'
    )
    files = (tmp_path / "ch1.csv", tmp_path / "ch2.csv")
    run("ingest", "--join", *files, "--map", tmp_path / "map.yaml", "-o", tmp_path / "log.h5")
    log = fric.read(tmp_path / "log.h5")[0]
    assert np.allclose(log.position, 1e-3 * np.sin(t))
    assert np.allclose(log.force, np.cos(t))
    text = run("ingest", "--join", *files, "--propose", tmp_path / "guess.yaml")
    assert 'file: "ch1.csv"' in text or "value" in text


def means(*, n: bool = True, rows: int = 12, noise: float = 0.0, seed: int = 0) -> str:
    v = np.geomspace(5e-5, 2e-2, rows // 2)
    v = np.concatenate([-v[::-1], v])
    F = force_at(v) + noise * np.random.default_rng(seed).standard_normal(rows)
    head = "velocity [mm/s], force [N], std [N]" + (", samples" if n else "")
    body = [f"{1e3 * a:.9g}, {b:.9g}, 2.0" + (", 400" if n else "") for a, b in zip(v, F, strict=True)]
    return "\n".join([head, *body]) + "\n"


def test_a_table_of_means_is_a_record_and_gives_the_map_that_made_it(tmp_path: Path) -> None:
    (tmp_path / "means.csv").write_text(means())
    run("ingest", tmp_path / "means.csv", "-o", tmp_path / "means.h5")
    (table,) = fric.read(tmp_path / "means.h5")
    assert isinstance(table, ForceVelocity)
    assert table.n is not None
    assert (table.n == 400).all()
    found = fric.identify_static(table)
    for name in ("F_c", "F_s", "v_s", "sigma"):
        assert found.document["static"][name]["value"] == pytest.approx(getattr(LAW, name), rel=1e-3)
    assert "errors-of-means" in {one["code"] for one in found.document["warnings_coded"]}
    seen = fric.inspect(table).document["records"][0]
    assert (seen["kind"], seen["points"], seen["directions"]) == ("force-velocity", 12, 2)
    assert seen["uses"][0]["good"]


@pytest.mark.long(3)
def test_intervals_of_a_table_hold_the_truth() -> None:
    """30 tables whose means scatter by their errors: the 95 % intervals miss each parameter seldom."""
    v = np.geomspace(5e-5, 2e-2, 9)
    v = np.concatenate([-v, v])
    missed = dict.fromkeys(("F_c", "F_s", "sigma"), 0)
    for seed in range(30):
        noise = 0.5 * np.random.default_rng(seed).standard_normal(len(v))
        table = ForceVelocity(v, force_at(v) + noise, np.full_like(v, 10.0), n=np.full_like(v, 400.0))
        static = fric.identify_static(table).document["static"]
        for name in missed:
            low, high = static[name]["ci95"]
            missed[name] += not low <= getattr(LAW, name) <= high
    assert all(count <= 5 for count in missed.values()), missed


def test_tables_and_strokes_make_one_map() -> None:
    strokes = fric.read("data/constant-velocity.h5")[::2]
    whole = fric.identify_static(strokes, over_position="off")  # a table tells no places
    slow, fast = strokes[:5], strokes[5:]  # speeds rise from record to record
    points = fric.identify_static(*fast, form="coulomb", over_position="off").fit.points
    table = ForceVelocity(
        np.array([p.velocity for p in points]), np.array([p.force for p in points]),
        error=np.array([p.standard_error for p in points]),
    )  # fmt: skip
    mixed = fric.identify_static(*slow, table)
    for name in ("F_c", "F_s", "sigma"):
        value = whole.document["static"][name]["value"]
        assert mixed.document["static"][name]["value"] == pytest.approx(value, rel=1e-6)


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("velocity [mm/s], force [N]\n-1, -5\n1, 5\n2, 6\n", "no column is time"),
        ("velocity [mm/s], force [N], n\n-1, -5, 0\n1, 5, 3\n", "n is 0 in row 1"),
        ("velocity [mm/s], force [N], std [N]\n-1, -5, -2\n1, 5, 3\n", "deviation is -2"),
        ("velocity [mm/s], force [N], std [N]\n-1, 5, 2\n1, -5, 3\n2, -5, 1\n", "the force opposes the motion"),
    ],
)
def test_a_table_that_cannot_be_is_refused(tmp_path: Path, text: str, what: str) -> None:
    (tmp_path / "bad.csv").write_text(text)
    with pytest.raises(FricError, match=what):
        fric.read(fric.ingest(tmp_path / "bad.csv", output=tmp_path / "bad.h5").done.output)


def test_a_table_serves_nothing_else_and_says_so(tmp_path: Path) -> None:
    (tmp_path / "means.csv").write_text(means(n=False))
    done = fric.ingest(tmp_path / "means.csv", output=tmp_path / "means.h5")
    table = fric.read(done.done.output)[0]
    for verb in (fric.identify_gms, fric.identify_plant):
        with pytest.raises(FricError, match="record"):
            verb(table)
    assert any("no n" in text for text in fric.identify_static(table).document["warnings"])
