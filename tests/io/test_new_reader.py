"""The walk-through of docs/new-reader.md is true: its one file is a format that is ingested and listed."""

import json

import h5py
import numpy as np
import pytest

from tests.new_file import place, python

FRIC = "import sys, new_reader_plugin; from fric.cli.main import main; sys.exit(main())"
TRY = """
import sys, new_reader_plugin, fric
try:
    fric.ingest(sys.argv[1], output=sys.argv[2])
except fric.FricError as error:
    print(error)
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("reader")
    place(folder, "new-reader.md", "fric.io.readers", "daq.py", "new_reader_plugin")
    return folder


def test_a_new_reader_is_listed_ingests_and_refuses_what_is_damaged(folder, warm):
    listed = json.loads(python(warm, folder, FRIC, "ingest", "--list", "--json"))["formats"]
    assert any(form["name"] == "DAQ1" for form in listed)
    t = np.arange(4000) / 1000.0
    position = np.round(20.0 * np.sin(t), 4)
    force = 30.0 * np.sign(np.cos(t)) + np.random.default_rng(1).normal(0.0, 0.5, len(t))
    head = b"DAQ1 1000\nposition [mm];force [N]\n"
    samples = np.column_stack([position, force]).astype("<f4").tobytes()
    log = folder / "run.daq"
    log.write_bytes(head + samples)
    python(warm, folder, FRIC, "ingest", str(log), "-o", str(folder / "run.h5"), "--axis", "x", "--motion", "linear")
    with h5py.File(folder / "run.h5") as file:
        found = []
        file.visititems(lambda name, item: found.append((name, item)) if isinstance(item, h5py.Dataset) else None)
        (logged,) = (item[:] for name, item in found if name.endswith("force"))
    np.testing.assert_allclose(logged, force, rtol=1e-6)
    log.write_bytes(head + samples[:-2])
    text = python(warm, folder, TRY, str(log), str(folder / "damaged.h5"))
    assert "ends within a sample" in text
    assert not (folder / "damaged.h5").exists()
