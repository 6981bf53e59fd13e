"""One value a line, as historians and loggers of events write it, is the table with a column a channel."""

import datetime
from contextlib import closing
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import fric
from fric.errors import FricError
from fric.io.hdf5 import read_logs
from fric.io.propose import proposal
from fric.io.readers import tables
from fric.io.readers.base import ForeignTable
from fric.log import Log
from tests.io.test_roles import axis_of_a_drive, told


def table_of(path: Path) -> tuple[ForeignTable, dict[str, np.ndarray]]:
    with closing(tables(path)) as found:
        table = next(found)
        blocks = [block.columns for block in table.read(range(len(table.columns)))]
    columns = [np.concatenate(parts) for parts in zip(*blocks, strict=True)]
    return table, dict(zip((column.name for column in table.columns), columns, strict=True))


def channels(n: int = 1500) -> tuple[np.ndarray, dict[str, tuple[str, np.ndarray]]]:
    a = axis_of_a_drive(n=n)
    return a["t"], {
        "ActPos": ("rad", a["position"]), "ActVel": ("rad/s", a["velocity"]), "Torque": ("N*m", a["current"]),
    }  # fmt: skip


def stamp(t: float, form: str) -> str:
    if form == "iso":
        start = datetime.datetime(2024, 3, 5, 8, 0, tzinfo=datetime.UTC)
        return (start + datetime.timedelta(seconds=t)).strftime("%Y-%m-%dT%H:%M:%S.%fZ")
    if form == "two cells":
        return f"2024-03-05 08:{int(t) // 60:02d}:{t % 60:09.6f}"
    return f"{1.7e12 + 1e3 * t:.1f}" if form == "epoch" else f"{1e3 * t:.3f}" if form == "ms" else f"{t:.6f}"


def listing(seed: int) -> tuple[str, np.ndarray, dict[str, np.ndarray]]:
    """Return a text of one value a line, written in one of many ways, and what it holds."""
    rng = np.random.default_rng(seed)
    t, values = channels()
    form = str(rng.choice(["iso", "s", "ms", "epoch", "two cells"]))
    mark = " " if form == "two cells" else str(rng.choice([",", ";", "\t"]))
    comma = mark == ";" and form in {"s", "ms"} and bool(rng.integers(2))
    order = [str(name) for name in rng.permutation([*values])]
    with_unit, with_axis, with_quality = (bool(rng.integers(2)) for _ in range(3))
    heads = [f"Time{' [ms]' * (form == 'ms')}", "signal", "value"] + ["machine"] * with_axis + ["unit"] * with_unit
    heads += ["quality"] * with_quality
    places = rng.permutation(len(heads))
    lines = []
    for k in range(len(t)):
        for name in order:
            unit, x = values[name]
            cells = [stamp(t[k], form), name, f"{x[k]:.6f}"] + ["mill4"] * with_axis + [unit] * with_unit
            cells += ["192"] * with_quality
            lines.append((order.index(name), mark.join(cells[n].replace(".", "," if comma else ".") for n in places)))
    if rng.integers(2):  # channel by channel
        lines.sort(key=lambda line: line[0])
    elif rng.integers(2):  # the newest first
        lines.reverse()
    header = [mark.join(heads[n] for n in places)] if form != "two cells" else []
    return "\n".join([*header, *(line for _, line in lines)]) + "\n", t, {n: x for n, (_, x) in values.items()}


@pytest.mark.parametrize("seed", range(24))
def test_one_value_a_line_is_a_table(tmp_path: Path, seed: int) -> None:
    """There were "no rows of numbers", or "no column looks like the position"."""
    text, t, values = listing(seed)
    (tmp_path / "export.csv").write_text(text)
    table, found = table_of(tmp_path / "export.csv")
    assert {name for name in found if name in values} == {*values}
    for name, x in values.items():
        np.testing.assert_allclose(found[name], x, atol=1e-6)
    stamps = next(x for name, x in found.items() if name not in values)
    np.testing.assert_allclose(
        np.diff(stamps) * (1e-3 if table.columns[0].unit == "ms" else 1.0), np.diff(t), atol=5e-6
    )
    (axis,) = told(tmp_path / "export.csv")
    named = {of: table.columns[role.column].name for of, role in axis.roles.items() if role.column}
    assert named == {"position": "ActPos", "velocity": "ActVel", "force": "Torque"}
    assert axis.roles["time"].unit_likelihood > 0.95


def test_it_is_ingested_and_its_mapping_fits(tmp_path: Path) -> None:
    text, t, values = listing(4)
    folder = tmp_path / "logs"
    folder.mkdir()
    (folder / "export.csv").write_text(text)
    (tmp_path / "map.yaml").write_text(proposal([folder / "export.csv"], assume=True))
    fric.ingest(folder / "export.csv", output=tmp_path / "log.h5", mapping=tmp_path / "map.yaml")
    (log,) = read_logs(tmp_path / "log.h5")
    np.testing.assert_allclose(log.position, values["ActPos"], atol=1e-6)
    np.testing.assert_allclose(log.time - log.time[0], t, atol=1e-5)


@pytest.mark.parametrize("late", [0.0, 3e-4])
def test_channels_of_other_instants_are_resampled_and_said(tmp_path: Path, late: float) -> None:
    t, values = channels()
    rows = [(t[k] + late * j, name, x[k]) for k in range(len(t)) for j, (name, (_, x)) in enumerate(values.items())]
    rows += [(float(s), "Oil temp", 40.0 + s) for s in (0.1, 0.5, 0.9, 1.3)] + [(0.05, "load", 3.0)]
    lines = [f"{stamp:.6f};{name};{x:.6f}" for stamp, name, x in sorted(rows)]
    (tmp_path / "events.txt").write_text("\n".join(["t [s];tag;v", *lines]) + "\n")
    table, found = table_of(tmp_path / "events.txt")
    assert [*found] == ["t", "ActPos", "ActVel", "Torque"]
    assert table.constants["load"] == "3"
    said = [notice.code for notice in table.notices]
    assert "columns-left-out" in said
    assert ("joined-moved" in said) == (late > 0.0)
    np.testing.assert_allclose(found["ActVel"], np.interp(found["t"], t + late, values["ActVel"][1]), atol=2e-6)


def test_the_axes_of_a_listing_are_axes(tmp_path: Path) -> None:
    """Channels of one name on two axes are two, though they were sampled at other instants."""
    t, values = channels(1800)
    lines = [
        f"{t[k] + 5e-4 * j:.6f},{axis},{name},{x[k + 300 * j]:.6f}"
        for k in range(1500) for j, axis in enumerate("xy") for name, (_, x) in values.items()
    ]  # fmt: skip
    (tmp_path / "two.csv").write_text("\n".join(["time_s,axis,channel,value", *lines]) + "\n")
    axes = told(tmp_path / "two.csv")
    names = [column.name for column in table_of(tmp_path / "two.csv")[0].columns]
    found = [{of: names[role.column] for of, role in axis.roles.items() if role.column} for axis in axes]
    assert found == [
        {"position": f"{of} ActPos", "velocity": f"{of} ActVel", "force": f"{of} Torque"} for of in ("x", "y")
    ]


def test_a_frame_of_one_value_a_row_says_how_it_is_turned() -> None:
    frame = pd.DataFrame(
        {"time": [0.0, 0.0, 1e-3], "signal": ["position", "force", "position"], "value": [1.0, 2.0, 3.0]}
    )
    with pytest.raises(FricError, match="no column is named position or velocity") as refused:
        Log.from_frame(frame)
    assert "values='value'" in refused.value.hint


def test_a_state_beside_a_single_number_names_no_channels(tmp_path: Path) -> None:
    """Such a file is a part of a record: its force, beside a file of positions."""
    t, values = channels()
    state = np.where((t % 0.4) < 0.2, "up", "down")
    lines = [f"{t[k]:.4f};{state[k]};{values['Torque'][1][k]:.4f}" for k in range(len(t))]
    (tmp_path / "force.csv").write_text("\n".join(["time [s];phase;force [N]", *lines]) + "\n")
    table, _ = table_of(tmp_path / "force.csv")
    assert [column.name for column in table.columns] == ["time", "phase", "force"]


def test_names_without_end_are_refused_and_a_million_lines_are_read(tmp_path: Path) -> None:
    lines = [f"{k * 1e-3:.3f},{'pos' if k % 2 else 'cur'},{k % 7}" for k in range(2000)]
    lines += [f"{k * 1e-3:.3f},name{k},{k % 7}" for k in range(2000, 60_000)]
    (tmp_path / "many.csv").write_text("\n".join(["time,signal,value", *lines]) + "\n")
    with pytest.raises(FricError, match="has over 2000 names of channels"):
        table_of(tmp_path / "many.csv")
    block = "".join(f"{{}}{k:04d},{('a', 'b', 'c')[k % 3]},{k % 11}.5\n" for k in range(1000)).replace("{}", "%d")
    text = "".join(block % ((number,) * 1000) for number in range(1000, 2000))
    (tmp_path / "long.csv").write_text("t,signal,value\n" + text)
    assert len(table_of(tmp_path / "long.csv")[1]["a"]) > 300_000
