"""Real logs through `fric ingest`, with the mappings that are kept in configs/."""

from pathlib import Path

import numpy as np
import pytest

from fric.documents.mapping import MappingDocument
from fric.documents.yaml import read_document
from fric.io.hdf5 import read_logs
from fric.io.ingest import ingest

ROOT = Path(__file__).parents[2]
DATA = ROOT.parent / "shared" / "data"
MAPPINGS = ROOT / "configs" / "mappings"

pytestmark = [
    pytest.mark.real,
    pytest.mark.skipif(not DATA.exists(), reason="the real logs are not here (../shared/data)"),
]


def mapping(name):
    return read_document(MAPPINGS / f"{name}.yaml", MappingDocument)


def test_screwdrive_ingests_in_one_call(tmp_path):
    files = sorted((DATA / "screwdrive1/steady_state/0.096kg").glob("*.csv"))
    done = ingest(files, tmp_path / "log.h5", mapping=mapping("screwdrive1"))
    assert len(done.records) == 32
    logs = {log.name: log for log in read_logs(tmp_path / "log.h5")}
    # the file name holds the nominal speed of the load in rpm; n is for negative
    for stem, log in logs.items():
        nominal = float(stem.replace("n", "-"))
        assert log.velocity.mean() * 60 / (2 * np.pi) == pytest.approx(nominal, rel=0.01, abs=0.2)
        assert np.sign(log.force.mean()) == np.sign(nominal)
        assert len(log) == 500
        assert log.kind == "constant-velocity"
        assert (log.axis, log.motion, log.position) == ("z", "rotary", None)
    assert 1 / np.diff(logs["n2"].time).mean() == pytest.approx(1 / 0.128)
    # -28.0604 % of 9.84 mN·m, and the sign that is flipped
    assert logs["10"].force.mean() == pytest.approx(0.280604 * 9.84e-3, rel=1e-12)


def test_tribometer_needs_its_sign(tmp_path):
    file = DATA / "tribometer/reciprocating-first-75s.txt"
    done = ingest(file, tmp_path / "log.h5", mapping=mapping("tribometer"))
    (log,) = read_logs(tmp_path / "log.h5")
    assert len(log) == 14822
    work = np.sum((log.force[1:] + log.force[:-1]) / 2 * np.diff(log.position))
    assert work > 0
    assert np.ptp(log.position) == pytest.approx(0.24e-3, rel=0.05)
    (warning,) = done.warnings
    assert "line 419" in warning
    assert "100 Hz there, 200 Hz elsewhere" in warning
