"""Parquet logs."""

import numpy as np
import pytest

from fric import FricError
from fric.io.hdf5 import read_logs
from fric.io.ingest import ingest

pyarrow = pytest.importorskip("pyarrow", reason="the extra 'parquet' is not installed")
from pyarrow import parquet  # noqa: E402


def test_units_in_names_in_metadata_and_in_stamps(tmp_path):
    n = 300_000
    stamps = np.datetime64("2024-05-06T07:08:09", "us") + np.arange(n) * np.timedelta64(500, "us")
    x = np.arange(n) * 1e-3
    schema = pyarrow.schema([
        pyarrow.field("time", pyarrow.timestamp("us")),
        pyarrow.field("position [mm]", pyarrow.float64()),
        pyarrow.field("force", pyarrow.float32(), metadata={"unit": "kN"}),
    ])  # fmt: skip
    columns = [stamps, x, np.full(n, 0.5, dtype="f4")]
    parquet.write_table(pyarrow.table(columns, schema=schema), tmp_path / "log.parquet")
    ingest(tmp_path / "log.parquet", tmp_path / "log.h5")
    (log,) = read_logs(tmp_path / "log.h5")
    np.testing.assert_allclose(np.diff(log.time), 0.5e-3, atol=5e-7)  # a double holds today's seconds to 0.2 µs
    np.testing.assert_allclose(log.position, x * 1e-3, rtol=1e-15)
    np.testing.assert_array_equal(log.force, 500.0)


def test_null_is_no_number(tmp_path):
    table = pyarrow.table({"time [s]": [0.0, 0.1, 0.2], "position [m]": [0.0, None, 1.0]})
    parquet.write_table(table, tmp_path / "log.parquet")
    with pytest.raises(FricError, match="sample 2, column 'position': the cell is empty"):
        ingest(tmp_path / "log.parquet", tmp_path / "log.h5")
    assert ingest(tmp_path / "log.parquet", tmp_path / "log.h5", bad_cells="drop").dropped == 1


def test_cut_short(tmp_path):
    (tmp_path / "log.parquet").write_bytes(b"PAR1" + bytes(100))
    with pytest.raises(FricError, match="is damaged: Parquet magic bytes not found"):
        ingest(tmp_path / "log.parquet", tmp_path / "log.h5")
