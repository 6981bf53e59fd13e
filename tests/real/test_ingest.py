"""Real logs through `fric ingest`, with the mappings that are kept in configs/."""

from pathlib import Path

import numpy as np
import pytest

import fric
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


def fric_command(*words):
    from typer.testing import CliRunner

    from fric.cli.main import app

    done = CliRunner().invoke(app, list(map(str, words)))
    if done.exception is not None:
        raise done.exception
    return done.stdout


def test_the_tribometer_in_a_file_a_channel_is_joined_to_the_same_record(tmp_path):
    """Position and friction apart, the friction at a quarter of the rate; by a proposal that is edited in one place."""
    rows = (DATA / "tribometer/reciprocating-first-75s.txt").read_text().splitlines()
    cells = [row.split("\t") for row in rows]
    (tmp_path / "position.txt").write_text("\n".join(f"{c[0]}\t{c[2]}" for c in cells))
    (tmp_path / "friction.txt").write_text("\n".join(f"{c[0]}\t{c[3]}" for c in [cells[0], *cells[3::4]]))
    files = (tmp_path / "position.txt", tmp_path / "friction.txt")
    text = fric_command("ingest", "--join", *files, "--propose", tmp_path / "map.yaml")
    assert 'file: "friction.txt"' in text
    edited = (tmp_path / "map.yaml").read_text().replace('unit: "uN"', 'unit: "uN", sign: -1')
    (tmp_path / "map.yaml").write_text(edited)
    log = tmp_path / "log.h5"
    fric_command("ingest", "--join", *files, "--map", tmp_path / "map.yaml", "--from", "8.5 s", "-o", log)
    ingest(DATA / "tribometer/reciprocating-first-75s.txt", tmp_path / "whole.h5", mapping=mapping("tribometer"))
    (one,), (whole,) = read_logs(log), read_logs(tmp_path / "whole.h5")
    assert one.time[0] >= 8.5
    at = np.searchsorted(whole.time, one.time)
    assert np.array_equal(one.position, whole.position[at])
    assert np.allclose(one.force, whole.force[at], atol=0.02 * np.ptp(whole.force))


def test_screwdrive_as_a_table_of_means_gives_the_map_of_its_strokes(tmp_path):
    lines = ["speed [rpm];torque [%];std [%];n"]
    for file in sorted((DATA / "screwdrive1/steady_state/0.096kg").glob("*.csv")):
        body = file.read_text(errors="replace").partition("\nms;")[2].splitlines()[1:]
        v, T = np.array([[float(cell) for cell in row.split(";")[1:3]] for row in body if row]).T
        lines.append(f"{v.mean():.5f};{T.mean():.5f};{T.std(ddof=1):.5f};{len(v)}")
    (tmp_path / "table.csv").write_text("\n".join(lines))
    fric_command("ingest", tmp_path / "table.csv", "--propose", tmp_path / "map.yaml")
    text = (tmp_path / "map.yaml").read_text()
    assert "kind: force-velocity" in text
    text = text.replace("motion: rotary/%", "motion: rotary").replace('unit: "rpm"', 'unit: "rpm", sign: -1')
    text = text.replace('"torque", unit: "%"', '"torque", scale: "0.0984 mN*m", sign: -1')
    text = text.replace('"std", unit: "%"', '"std", scale: "0.0984 mN*m"')
    (tmp_path / "map.yaml").write_text(text)
    fric_command("ingest", tmp_path / "table.csv", "--map", tmp_path / "map.yaml", "-o", tmp_path / "table.h5")
    files = sorted((DATA / "screwdrive1/steady_state/0.096kg").glob("*.csv"))
    ingest(files, tmp_path / "strokes.h5", mapping=mapping("screwdrive1"))
    found = fric.identify_static(tmp_path / "table.h5").document["static"]
    whole = fric.identify_static(tmp_path / "strokes.h5").document["static"]
    for name in ("F_c", "F_s", "v_s", "sigma", "offset"):
        low, high = whole[name]["ci95"]
        assert low < found[name]["value"] < high
    assert found["F_s"]["value"] == pytest.approx(whole["F_s"]["value"], rel=0.01)
