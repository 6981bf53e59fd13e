"""`ingest`: many files, appending, merging, and a memory that does not grow with the file."""

import gzip
import hashlib
from itertools import product

import h5py
import numpy as np
import pytest

import fric
from fric import FricError, Log
from fric.io.hdf5 import CHUNK, read_logs, write_logs
from fric.io.ingest import ingest
from fric.io.readers import text
from tests.turns import in_turns


def write(path, samples=50, speed=1.0):
    rows = "".join(f"{n / 1000:.3f},{speed * n / 1000:.6f},{2.0 * np.sign(speed)}\n" for n in range(samples))
    path.write_text("time [s],position [mm],force [N]\n" + rows)
    return path


def test_many_files_in_one_call_in_their_order(tmp_path):
    files = [write(tmp_path / f"{name}.csv", speed=speed) for name, speed in (("b", 1), ("a", 2), ("c", -3))]
    steps = []
    done = ingest(files, tmp_path / "log.h5", kind="constant-velocity", axis="y", progress=steps.append)
    logs = read_logs(tmp_path / "log.h5")
    assert [log.name for log in logs] == ["b", "a", "c"]
    assert {(log.kind, log.axis, log.motion) for log in logs} == {("constant-velocity", "y", "linear")}
    assert done.samples == 150
    assert sum(steps) == pytest.approx(sum(path.stat().st_size for path in files), rel=0.2)


def test_the_same_file_twice_is_one_record(tmp_path):
    one, other = write(tmp_path / "one.csv"), write(tmp_path / "other.csv", speed=2)
    (tmp_path / "copy.csv").write_bytes(one.read_bytes())
    ingest(one, tmp_path / "log.h5")
    done = ingest([one, tmp_path / "copy.csv", other, other], tmp_path / "log.h5", append=True)
    assert [record.name for record in done.records] == ["other"]
    assert [name for _, name in done.skipped] == ["one", "one", "other"]
    assert len(read_logs(tmp_path / "log.h5")) == 2


def test_names_that_are_taken_get_a_number(tmp_path):
    (tmp_path / "monday").mkdir()
    files = [write(tmp_path / "run.csv"), write(tmp_path / "monday" / "run.csv", speed=2)]
    ingest(files, tmp_path / "log.h5")
    assert [log.name for log in read_logs(tmp_path / "log.h5")] == ["run", "run-2"]


def test_appending_keeps_the_axis(tmp_path):
    ingest(write(tmp_path / "one.csv"), tmp_path / "log.h5", axis="y")
    before = (tmp_path / "log.h5").read_bytes()
    ingest(write(tmp_path / "two.csv", speed=2), tmp_path / "log.h5", append=True)
    assert {log.axis for log in read_logs(tmp_path / "log.h5")} == {"y"}
    with pytest.raises(FricError, match="the linear axis y, and the new record is of the linear axis x"):
        ingest(write(tmp_path / "three.csv", speed=3), tmp_path / "log.h5", axis="x", append=True)
    assert before != (tmp_path / "log.h5").read_bytes()
    assert len(read_logs(tmp_path / "log.h5")) == 2


def test_an_error_in_the_last_file_leaves_the_file_as_it_was(tmp_path):
    ingest(write(tmp_path / "one.csv"), tmp_path / "log.h5")
    before = (tmp_path / "log.h5").read_bytes()
    (tmp_path / "bad.csv").write_text("time [s],position [mm]\n0,0\n1,x\n")
    with pytest.raises(FricError, match="line 3"):
        ingest([write(tmp_path / "two.csv", speed=2), tmp_path / "bad.csv"], tmp_path / "log.h5", append=True)
    assert (tmp_path / "log.h5").read_bytes() == before


def test_log_files_are_merged_record_by_record(tmp_path):
    rng = np.random.default_rng(3)
    ingest([write(tmp_path / "one.csv"), write(tmp_path / "two.csv", speed=2)], tmp_path / "a.h5")
    simulated = Log(time=np.arange(9) / 4e3, position=rng.normal(size=9), name="simulated", dropped=2)
    write_logs(tmp_path / "b.h5", [simulated])
    done = ingest([tmp_path / "a.h5", tmp_path / "b.h5", tmp_path / "a.h5"], tmp_path / "c.h5")
    first, second, third = read_logs(tmp_path / "c.h5")
    assert (first.name, second.name, third.name) == ("one", "two", "simulated")
    np.testing.assert_array_equal(third.position, simulated.position)
    assert third.dropped == 2
    assert len(done.skipped) == 2  # the records of a.h5, by their own sha256
    again = ingest([tmp_path / "one.csv", tmp_path / "b.h5"], tmp_path / "c.h5", append=True)
    assert again.records == ()
    assert len(again.skipped) == 2


def test_dropping_counts_and_leaves_a_gap(tmp_path):
    path = write(tmp_path / "log.csv", samples=100)
    lines = path.read_text().splitlines()
    lines[11] = "0.010,abc,2"
    lines[21:26] = [f"0.{n:03},,2" for n in range(20, 25)]
    path.write_text("\n".join(lines))
    done = ingest(path, tmp_path / "log.h5", bad_cells="drop")
    (log,) = read_logs(tmp_path / "log.h5")
    assert done.dropped == log.dropped == 6
    assert len(log) == 94
    assert np.diff(log.time).max() == pytest.approx(0.006)


@pytest.mark.parametrize("cell", ["1,234", "-12,000"])
def test_a_mark_of_a_fraction_or_of_thousands_is_not_dropped(tmp_path, cell):
    """Four fifths of the samples of such a file went, with a warning alone."""
    path = tmp_path / "log.csv"
    path.write_text(write(path).read_text().replace(",", ";").replace("0.020;0.020000", f"0.020;{cell}"))
    with pytest.raises(FricError, match="two values") as refused:
        fric.ingest(path, output=tmp_path / "log.h5", assume=True)
    assert "line 22" in str(refused.value)
    assert not (tmp_path / "log.h5").exists()


@pytest.mark.parametrize(
    ("cell", "taken"), [("({})", False), ("{}-", False), ("1.0D{}", False), ("---", True), ("", True)]
)
def test_most_of_a_log_is_not_dropped_for_a_way_to_write_that_is_unknown(tmp_path, cell, taken):
    """Without digits, as of a channel that is logged at a third of the rate, the others are left out as before."""
    path = tmp_path / "log.csv"
    rows = [f"{n / 1000:.3f};{cell.format(n) if n % 3 else n / 10};2.0\n" for n in range(60)]
    path.write_text("time [s];position [mm];force [N]\n" + "".join(rows))
    if taken:
        fric.ingest(path, output=tmp_path / "log.h5", assume=True)
        assert len(read_logs(tmp_path / "log.h5")[0]) == 20
        return
    with pytest.raises(FricError, match="40 of 60 samples") as refused:
        fric.ingest(path, output=tmp_path / "log.h5", assume=True)
    assert "line 3" in str(refused.value)
    assert not (tmp_path / "log.h5").exists()


@pytest.mark.parametrize("samples", [CHUNK - 1, CHUNK, CHUNK + 1, 5 * CHUNK + 17])
def test_chunks_hold_every_kind_of_number(tmp_path, samples):
    """What is compressed beside the reading is what HDF5's own filters read: noise, ramps, steps, constants."""
    rng = np.random.default_rng(samples)
    channels = {
        "position": np.round(np.cumsum(rng.normal(size=samples)) * 4) / 4e6,
        "velocity": rng.normal(size=samples),
        "force": np.sign(np.sin(np.arange(samples) / 100)),
        "input": 1e6 * rng.random(samples),
    }
    log = Log(time=np.arange(samples) / 4000, **channels)
    write_logs(tmp_path / "log.h5", [log])
    (read,) = read_logs(tmp_path / "log.h5")
    for name, values in log.channels().items():
        np.testing.assert_array_equal(read.channels()[name].view("u8"), values.view("u8"))
    with h5py.File(tmp_path / "log.h5") as file:
        data = file["records/record/force"]
        assert (data.compression, data.shuffle) == ("gzip", True)
        assert data.id.get_storage_size() < data.nbytes / 20


@pytest.mark.parametrize(
    ("piece", "end", "encoding"),
    in_turns(
        product([1, 7, 64, 1000], ["\n", "\r\n"], ["utf-8", "latin-1", "utf-16"]),
        [(1, "\r\n", "utf-8"), (1, "\n", "utf-16"), (7, "\r\n", "utf-16"), (7, "\n", "latin-1"), (64, "\r\n", "utf-8")],
    ),
)
def test_where_a_file_is_cut_into_pieces_changes_nothing(tmp_path, monkeypatch, piece, end, encoding):
    """Also a piece shorter than a line; and the digest is that of the file, told piece by piece or not."""
    monkeypatch.setattr(text, "PIECE", piece)
    table = np.random.default_rng(piece).normal(size=(60, 3))
    table[:, 0], table[:, 2] = np.arange(60) / 1000, np.gradient(table[:, 1])
    lines = [
        "Prüfstand 3, µm",
        "time [s],position [mm],force [N]",
        *(",".join(map(repr, row)) for row in table.tolist()),
    ]
    path = tmp_path / "log.csv"
    path.write_bytes(end.join(lines).encode(encoding))
    ingest(path, tmp_path / "log.h5")
    (log,) = read_logs(tmp_path / "log.h5")
    np.testing.assert_allclose(log.time, table[:, 0], rtol=1e-15)
    np.testing.assert_allclose(log.position, table[:, 1] / 1000, rtol=1e-15)
    np.testing.assert_allclose(log.force, table[:, 2], rtol=1e-15)
    assert log.sha256 == hashlib.sha256(path.read_bytes()).hexdigest()


def test_a_row_too_long_is_found_in_a_late_piece(tmp_path, monkeypatch):
    monkeypatch.setattr(text, "PIECE", 64)
    path = write(tmp_path / "log.csv")
    path.write_text(path.read_text() + "0.05,1,2,3\n0.051,1,2\n")
    with pytest.raises(FricError, match=r"log.csv, line 52: has more cells than the 3 of the header"):
        ingest(path, tmp_path / "log.h5")


def test_gz_is_the_same_log(tmp_path):
    path = write(tmp_path / "log.csv")
    (tmp_path / "log.csv.gz").write_bytes(gzip.compress(path.read_bytes()))
    ingest([path, tmp_path / "log.csv.gz"], tmp_path / "log.h5")
    plain, zipped = read_logs(tmp_path / "log.h5")
    assert zipped.name == "log-2"
    np.testing.assert_array_equal(plain.position, zipped.position)
    assert plain.sha256 != zipped.sha256


def test_files_that_are_named_by_axes_are_not_one_axis(tmp_path):
    """Both were one axis, with a friction between theirs."""
    files = [write(tmp_path / f"{name}_axis.csv", speed=speed) for name, speed in (("X", 1), ("Y", 2))]
    with pytest.raises(FricError, match="named by axes x and y"):
        fric.ingest(*files, output=tmp_path / "log.h5")
    assert not (tmp_path / "log.h5").exists()
    fric.ingest(*files, output=tmp_path / "log.h5", axis="z")
    fric.ingest(files[0], write(tmp_path / "X_more.csv", speed=3), output=tmp_path / "x.h5")


def test_a_few_samples_at_rest_do_not_turn_the_force(tmp_path):
    """ "By these signs friction drives the axis" was said of four samples of noise."""
    rows = "0,0,2.795\n4.5,-0.1,-0.932\n9,-0.1,1.1\n13.5,-0.1,0.9\n"
    (tmp_path / "a.csv").write_text(f"time [ms],position [um],force [N]\n{rows}")
    fric.ingest(tmp_path / "a.csv", output=tmp_path / "log.h5")
    assert [len(log) for log in read_logs(tmp_path / "log.h5")] == [4]


@pytest.mark.parametrize("count", [1, 2, 8, 60])
def test_the_line_of_an_ingest_names_its_records(count, tmp_path):
    """ "8 records, 400 samples": which file became which record stood in no line."""
    names = [f"stroke-{n:02}" for n in range(count)]
    files = [write(tmp_path / f"{name}.csv", samples=20, speed=n + 1.0) for n, name in enumerate(names)]
    line = fric.ingest(*files, output=tmp_path / "log.h5").brief()
    many, _, told = line.partition(": ")
    assert many == f"{count} record{'s' * (count > 1)}"
    assert told.startswith(", ".join(names[:2]))
    assert told.endswith({1: "stroke-00", 2: "stroke-01"}.get(count, f" and {count - 2} more"))
    assert len(f"{'x: ingest constant-velocity':<18} {line}") <= 72  # behind which the time is
