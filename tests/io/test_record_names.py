"""Names of records, as HDF5 keeps them."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from fric.io.hdf5 import read_logs, write_logs
from fric.log import Log


def test_a_record_may_be_named_by_its_speed(tmp_path: Path) -> None:
    t = np.arange(20) / 100
    write_logs(tmp_path / "log.h5", [Log(t, position=t, name=name) for name in ("20 mm/s", "20 mm/s", "5 mm/s")])
    names = [log.name for log in read_logs(tmp_path / "log.h5")]
    assert sorted(names) == ["20 mm∕s", "20 mm∕s-2", "5 mm∕s"]
