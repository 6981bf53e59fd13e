"""`fric ingest` as it is called: each of its options."""

import json
import subprocess
import sys

import numpy as np
import pytest
from typer.testing import CliRunner

from fric.cli.main import app
from fric.errors import FricError
from fric.io.hdf5 import read_logs

RUN = CliRunner()
HEADER = "time [s],position [um],force [N]\n"
ROWS = [f"{n / 100:.2f},{10.0 * n},{5.0 + n % 2}" for n in range(40)]


@pytest.fixture
def log(tmp_path):
    path = tmp_path / "stroke.csv"
    path.write_text(HEADER + "\n".join(ROWS) + "\n")
    return path


def ingest(*words):
    done = RUN.invoke(app, ["ingest", *map(str, words)])
    if done.exception is not None:
        raise done.exception
    return done


def test_kind_axis_and_motion_are_kept(log, tmp_path):
    out = tmp_path / "log.h5"
    told = json.loads(ingest(log, "-o", out, "--kind", "constant-velocity", "--axis", "y", "--json").stdout)
    (read,) = read_logs(out)
    assert (read.kind, read.axis, read.motion) == ("constant-velocity", "y", "linear")
    assert (told["axis"], told["motion"], len(told["records"])) == ("y", "linear", 1)
    with pytest.raises(FricError):
        ingest(log, "-o", out, "--force", "--motion", "rotary")  # the header says micrometres
    assert len(read_logs(out)) == 1


def test_append_adds_and_skips_what_is_there(log, tmp_path):
    out, other = tmp_path / "log.h5", tmp_path / "other.csv"
    other.write_text(log.read_text().replace("5.0", "7.0"))
    ingest(log, "-o", out)
    with pytest.raises(FricError, match="the output exists"):
        ingest(other, "-o", out)
    done = ingest(log, other, "-o", out, "--append")
    assert [read.name for read in read_logs(out)] == ["stroke", "other"]
    assert "stroke" in done.stdout + done.stderr
    ingest(other, "-o", out, "--force")
    assert [read.name for read in read_logs(out)] == ["other"]


def test_bad_cells_are_dropped_on_demand(log, tmp_path):
    log.write_text(log.read_text().replace("0.07,70.0", "0.07,none"))
    with pytest.raises(FricError, match=r"stroke.csv, line 9, column 'position': 'none' is not a number"):
        ingest(log, "-o", tmp_path / "log.h5")
    assert not (tmp_path / "log.h5").exists()
    done = ingest(log, "-o", tmp_path / "log.h5", "--bad-cells", "drop")
    assert "1 of 40 samples are dropped" in done.stderr
    assert len(read_logs(tmp_path / "log.h5")[0]) == 39


def test_a_mapping_names_the_columns(tmp_path):
    (tmp_path / "raw.csv").write_text("a;b;c\n" + "\n".join(row.replace(",", ";") for row in ROWS) + "\n")
    (tmp_path / "map.yaml").write_text(
        "fric: mapping/1\naxis: z\nmotion: linear\nrecord: 'run {stem}'\ncolumns:\n  time: {column: a, unit: s}\n"
        "  position: {column: b, unit: um}\n  force: {column: c, unit: N}\n"
    )
    ingest(tmp_path / "raw.csv", "-o", tmp_path / "log.h5", "--map", tmp_path / "map.yaml")
    (read,) = read_logs(tmp_path / "log.h5")
    assert (read.name, read.axis) == ("run raw", "z")
    np.testing.assert_allclose(read.position, 1e-5 * np.arange(40))


@pytest.mark.parametrize("name", ["own.csv", "own.CSV", "own.csv.gz", "own.mat"])
def test_a_log_file_is_not_called_what_it_is_not(log, tmp_path, name):
    with pytest.raises(FricError, match=r"what is written is HDF5(.|\n)*Call it own.*\.h5"):
        ingest(log, "-o", tmp_path / name)
    assert not (tmp_path / name).exists()


def test_a_log_is_read_without_what_models_are_compiled_by(log, tmp_path):
    words = ["ingest", str(log), "-o", str(tmp_path / "log.h5")]
    code = f"import sys, fric.cli.main as m\ntry:\n m.app({words})\nfinally:\n print(sorted(sys.modules))"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert "'pandas'" in loaded
    assert [name for name in ("numba", "scipy", "matplotlib", "pint") if f"'{name}'" in loaded] == []


def test_two_files_in_ms_among_others_in_s_are_named(tmp_path):
    """Maps over 16.7 µm/s and 16.7 mm/s came of such a folder without a word."""
    rng, t = np.random.default_rng(1), 5e-3 * np.arange(400)
    for n, v in enumerate(np.outer([1.0, -1.0], [2e-3, 5e-3, 10e-3, 20e-3]).ravel()):
        force = np.sign(v) * (50.0 + 1e3 * abs(v)) + 0.2 * rng.standard_normal(len(t))
        scale = 1e3 if n in (2, 6) else 1.0
        rows = "".join(f"{scale * a:.6g},{1e3 * v * a:.6g},{f:.5g}\n" for a, f in zip(t, force, strict=True))
        (tmp_path / f"stroke{n}.csv").write_text("time,position [mm],force [N]\n" + rows)
    out = tmp_path / "log.h5"
    ingest(*sorted(tmp_path.glob("*.csv")), "-o", out)
    done = RUN.invoke(app, ["identify", "static", str(out), "-o", str(tmp_path / "map.yaml")])
    told = [line for line in done.output.splitlines() if "is the time in ms, and read as s?" in line]
    assert ["'stroke2'" in told[0], "'stroke6'" in told[1], len(told)] == [True, True, 2]
