"""Files that lead to other files, small files that would eat the machine, damaged files: a sentence each."""

import os
import shutil
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pyarrow as pa
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from nptdms import ChannelObject, TdmsWriter
from pyarrow import parquet

from fric.documents.machine_files import MachineDocument
from fric.documents.mapping import MappingDocument
from fric.documents.plant import PlantDocument
from fric.documents.yaml import read_document
from fric.errors import FricError, printable
from fric.identify.gms.identify import identify_gms
from fric.identify.replay.replay_fit import identify_by_replay
from fric.identify.static_map.identify import identify_static
from fric.identify.static_map.points import Asked
from fric.io.hdf5 import read_logs, read_records, write_logs
from fric.io.ingest import ingest
from fric.io.readers import tables
from fric.log import Log
from fric.records.prepared import prepared
from fric.report.collect import collect
from fric.units import factor, parse

DATA = Path(__file__).parents[2] / "data"


@pytest.fixture
def log(tmp_path: Path) -> Path:
    t = np.arange(400) * 1e-3
    path = tmp_path / "log.h5"
    write_logs(path, [Log(time=t, position=t**2, force=t, name="a", source="a.csv", sha256="a" * 64)])
    return path


def said(call) -> str:
    """Return the sentence that a call ends in; empty where it went well."""
    try:
        call()
    except FricError as error:
        return str(error)
    return ""


def refused(path: Path, match: str) -> None:
    """Both ways into a log file end with a sentence."""
    with pytest.raises(FricError, match=match):
        read_records(path)
    with pytest.raises(FricError, match=match):
        ingest(path, path.with_name("again.h5"), force=True)


def test_a_log_cannot_carry_another_file_into_a_report(tmp_path, log):
    secret = tmp_path / "secret.bin"
    secret.write_bytes(np.arange(400.0).tobytes())
    with h5py.File(log, "a") as file:
        del file["records/a/force"]
        data = file["records/a"].create_dataset("force", (400,), "f8", external=[(str(secret), 0, 3200)])
        data.attrs["unit"] = "N"
    refused(log, "takes its values from another file")


@pytest.mark.parametrize("kind", ["external", "soft"])
def test_links_out_of_a_log_are_refused(tmp_path, log, kind):
    write_logs(tmp_path / "other.h5", [Log(time=np.arange(9.0), position=np.arange(9.0), name="b", source="b")])
    with h5py.File(log, "a") as file:
        del file["records/a/force"]
        file["records/a/force"] = (
            h5py.ExternalLink(str(tmp_path / "other.h5"), "/records/b/position")
            if kind == "external"
            else h5py.SoftLink("/records/a/position")
        )
    refused(log, "is a link")


def test_a_virtual_dataset_is_refused(tmp_path, log):
    write_logs(tmp_path / "other.h5", [Log(time=np.arange(400.0), position=np.arange(400.0), name="b", source="b")])
    with h5py.File(log, "a") as file:
        del file["records/a/force"]
        layout = h5py.VirtualLayout((400,), "f8")
        layout[:] = h5py.VirtualSource(str(tmp_path / "other.h5"), "records/b/position", (400,))
        file["records/a"].create_virtual_dataset("force", layout)
    refused(log, "takes its values from another file")


def test_what_is_declared_and_not_stored_is_refused_at_once(log):
    with h5py.File(log, "a") as file:
        for name in ("time", "position", "force"):
            del file[f"records/a/{name}"]
            file["records/a"].create_dataset(name, (100_000_000,), "f8", chunks=(1_000_000,)).attrs["unit"] = "s"
    start = time.process_time()
    refused(log, "declares 800 MB of samples, and has 0 MB")
    assert time.process_time() - start < 5


@pytest.mark.parametrize(
    "spoil",
    [
        lambda g: g.create_dataset("force", data=3.0),
        lambda g: g.create_dataset("force", data=np.zeros((20, 20))),
        lambda g: g.create_dataset("force", data=np.zeros(400, complex)),
        lambda g: g.create_dataset("force", data=np.array([b"a"] * 400)),
        lambda g: g.create_dataset("force", dtype="f8", data=h5py.Empty("f8")),
        lambda g: g.create_dataset("force", data=np.zeros(400, [("a", "f8"), ("b", "i4")])),
        lambda g: g.create_group("force"),
        lambda g: g.attrs.__setitem__("kind", np.arange(4)),
        lambda g: g["position"].attrs.__setitem__("unit", np.arange(4)),
        lambda g: g["position"].attrs.__setitem__("unit", h5py.Empty("f8")),
    ],
)
def test_what_is_no_column_of_numbers_is_told(log, spoil):
    with h5py.File(log, "a") as file:
        group = file["records/a"]
        if "force" in group:
            del group["force"]
        spoil(group)
    for call in (lambda: read_records(log), lambda: ingest(log, log.with_name("again.h5"), force=True)):
        assert len(said(call)) < 1200


@settings(max_examples=80, deadline=None)
@given(st.data())
def test_bytes_of_a_log_that_were_changed_end_in_a_sentence_or_a_log(tmp_path_factory, data):
    folder = tmp_path_factory.mktemp("fuzz")
    whole = bytearray((DATA / "presliding-sine.h5").read_bytes())
    for _ in range(data.draw(st.integers(1, 12))):
        whole[data.draw(st.integers(0, min(len(whole) - 1, 8192)))] = data.draw(st.integers(0, 255))
    path = folder / "log.h5"
    path.write_bytes(
        whole[: data.draw(st.integers(len(whole) // 2, len(whole)))] if data.draw(st.booleans()) else whole
    )
    assert len(said(lambda: read_records(path)).splitlines()) <= 2


def test_references_in_a_circle_end(tmp_path):
    path = tmp_path / "ring.mat"
    with h5py.File(path, "w", userblock_size=512) as file:
        cell = file.create_dataset("cell", (1, 1), h5py.ref_dtype)
        cell[0, 0] = cell.ref
    with path.open("r+b") as raw:
        raw.write(b"MATLAB 7.3 MAT-file".ljust(512))
    with pytest.raises(FricError, match="in a circle"):
        list(tables(path))


@pytest.mark.parametrize("unit", ["9**9**9**9 m", "m**(9**9**9)", "m^9^9^9", "m" * 5000, "(" * 3000, "m**99999999999"])
def test_units_that_would_be_worked_out_for_years(unit):
    start = time.process_time()
    with pytest.raises(FricError, match="not a unit"):
        factor(unit, "position")
    assert time.process_time() - start < 20
    for known, kind in (("m/s^2", "acceleration"), ("m/s**2", "acceleration"), ("N*s*m**-1", "viscous")):
        assert factor(known, kind) == 1


@pytest.mark.parametrize("text", ["inf m", "nan m", "1e999 m"])
def test_quantities_are_finite(text):
    with pytest.raises(FricError, match="finite"):
        parse(text, "position")


def bomb(depth: int) -> str:
    lines = ["fric: plant/1", "axis: x", "a0: &a0 [1, 1, 1, 1, 1, 1, 1, 1, 1]"]
    lines += [f"a{n}: &a{n} [{', '.join([f'*a{n - 1}'] * 9)}]" for n in range(1, depth)]
    return "\n".join(lines)


@pytest.mark.parametrize(
    ("text", "match"),
    [
        (bomb(9), "without aliases"),
        ("fric: plant/1\nA: " + "[" * 5000 + "]" * 5000, "nests deeper|damaged|not YAML"),
        ("fric: plant/1\nA: " + "{a: " * 300 + "1" + "}" * 300, "nests deeper|damaged"),
        ("%YAML 9.9\n---\nfric: plant/1\n", "."),
        ("fric: plant/1\naxis: x\nA: null\nT_d: 1 ms\n", "A: "),
        ("fric: plant/1\nA: " + "9" * 6000, "."),
        ("fric: plant/1\ncreated: 2026-99-99\n", "."),
        ("fric: plant/1\n? [a, b]\n: c\n", "."),
        ("\x1b[31mfric: plant/1\n", "."),
        ("fric: plant/1\n<<: *nothing\n", "."),
        ("fric: !!python/object/apply:os.system [echo]\n", "."),
    ],
)
def test_yaml_that_is_made_to_hurt(tmp_path, text, match):
    path = tmp_path / "plant.yaml"
    path.write_text(text)
    start = time.process_time()
    with pytest.raises(FricError, match=match) as caught:
        read_document(path, PlantDocument)
    assert time.process_time() - start < 20
    assert len(str(caught.value).splitlines()) <= 2
    assert all(one.isprintable() or one == "\n" for one in str(caught.value))


@settings(max_examples=60, deadline=None)
@given(st.binary(max_size=400))
def test_any_bytes_are_a_document_or_a_sentence(tmp_path_factory, data):
    path = tmp_path_factory.mktemp("yaml") / "a.yaml"
    path.write_bytes(b"fric: plant/1\naxis: x\n" + data)
    for kind in (PlantDocument, MachineDocument):
        with pytest.raises(FricError) as caught:
            read_document(path, kind)
        assert all(one.isprintable() or one == "\n" for one in str(caught.value))


def test_devices_and_pipes_are_no_inputs(tmp_path):
    os.mkfifo(tmp_path / "pipe.yaml")
    machine = tmp_path / "machine.yaml"
    for name in ("/dev/zero", str(tmp_path / "pipe.yaml"), "."):
        machine.write_text(
            f"fric: machine/1\naxes:\n  x:\n    plant: {name}\n    controller: {name}\n    friction: {name}\n"
        )
        with pytest.raises(FricError, match=r"not a regular file|a folder"):
            read_document(machine, MachineDocument)
    for path in (Path("/dev/zero"), tmp_path / "pipe.yaml"):
        for read in (lambda p: list(tables(p)), read_records, lambda p: collect([p])):
            with pytest.raises(FricError, match="not a regular file"):
                read(path)


def test_names_are_taken_apart_without_backtracking():
    def mapping(file: str) -> MappingDocument:
        return MappingDocument.model_validate(
            {"fric": "mapping/1", "file": file, "columns": {"time": {"column": 0, "unit": "s"}}}
        )

    fields = mapping("{axis}_{speed}mmps-{run}").fields({"stem": "x_20mmps-3-b"}, "here")
    assert (fields["axis"], fields["speed"], fields["run"]) == ("x", "20", "3-b")
    start = time.process_time()
    with pytest.raises(FricError, match="is not made like"):
        mapping("".join(f"{{f{n}}}a" for n in range(12)) + "b").fields({"stem": "a" * 250}, "here")
    assert time.process_time() - start < 5


def test_messages_are_two_short_lines_whatever_the_file_says():
    error = FricError("\x1b[2J" + "a\nb" * 900, where="\x07where\x9b", hint="x" * 5000)
    assert len(str(error).splitlines()) == 2
    assert len(str(error)) < 1300
    assert all(one.isprintable() for one in str(error).replace("\n", ""))
    assert printable("tab\there") == "tab here"


@pytest.mark.parametrize("verb", ["static", "gms", "dahl"])
@pytest.mark.parametrize(
    ("spoil", "match"),
    [
        (lambda force: 0.0 * force, "does not change|the same force"),
        (lambda force: 0.0 * force + 5.0, "does not change|the same force"),
        (lambda force: np.where(np.arange(len(force)) == len(force) // 2, 1e300, force), "which no machine does"),
    ],
)
def test_a_force_that_tells_nothing_ends_in_a_sentence(verb, spoil, match):
    """As R² of minus infinity at status 0, an abort in nnls and a traceback before."""
    kind = "constant-velocity" if verb == "static" else "presliding-sine"
    whole = read_logs(DATA / f"{kind}.h5")
    identify = {
        "static": lambda logs: identify_static(logs, Asked()),
        "gms": identify_gms,
        "dahl": lambda logs: identify_by_replay("dahl", prepared(logs)),
    }[verb]
    with pytest.raises(FricError, match=match):
        identify([replace(one, force=spoil(one.force)) for one in whole])


@pytest.mark.parametrize("words", [["--kind", "circle"], ["--join"], []])
def test_a_device_without_end_is_no_log(tmp_path, words, warm):
    done = subprocess.run(
        ["fric", "ingest", "/dev/zero", "-o", str(tmp_path / "a.h5"), *words],
        env=warm, capture_output=True, text=True, check=False, timeout=600,
    )  # fmt: skip
    assert (done.returncode, "not a regular file" in done.stderr) == (1, True), done.stderr


def test_a_virtual_dataset_ends_no_process(tmp_path, log):
    """As a segmentation fault behind the sentence: HDF5's end, where the dataset's properties were still held."""
    with h5py.File(log, "a") as file:
        del file["records/a/force"]
        layout = h5py.VirtualLayout((400,), "f8")
        layout[:] = h5py.VirtualSource(str(log), "records/a/position", (400,))
        file["records/a"].create_virtual_dataset("force", layout)
    code = f"from pathlib import Path\nfrom fric.io.ingest import ingest\ningest(Path({str(log)!r}), Path('x.h5'))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False, cwd=tmp_path)
    assert (done.returncode, "another file" in done.stderr) == (1, True), done.stderr


@pytest.mark.parametrize("place", ["records", "records/a"])
def test_a_dataset_in_place_of_a_group_is_damage(tmp_path, log, place):
    with h5py.File(log, "a") as file:
        del file[place]
        file[place] = np.arange(3.0)
    shutil.copy(DATA / "strokes" / "constant-velocity-09.csv", tmp_path / "a.csv")
    for call in (
        lambda: read_records(log),
        lambda: ingest(log, tmp_path / "again.h5"),
        lambda: ingest(tmp_path / "a.csv", log, append=True),
    ):
        with pytest.raises(FricError, match=r"holds no record|is not a group"):
            call()


@pytest.mark.parametrize("key", ["wf_increment", "wf_start_offset", "wf_start_time"])
@pytest.mark.parametrize("value", ["text", float("nan"), float("inf"), -1.0, 5.0])
def test_clocks_of_tdms_of_any_type(tmp_path, key, value):
    """Text where a number should be: 13 tracebacks of a fuzz."""
    with TdmsWriter(tmp_path / "a.tdms") as file:
        about = {"wf_increment": 1e-3, "wf_start_offset": 0.0, "unit_string": "mm"} | {key: value}
        two = [("position", about), ("force", about | {"unit_string": "N", key: 0.5})]
        file.write_segment([ChannelObject("g", name, np.arange(50.0), properties) for name, properties in two])
    assert len(said(lambda: ingest(tmp_path / "a.tdms", tmp_path / "a.h5")).splitlines()) <= 2


def test_a_unit_of_parquet_that_is_no_text(tmp_path):
    """As nine tracebacks of a fuzz."""
    fields = [pa.field("time", pa.float64(), metadata={b"unit": b"\xff\xfes"}), pa.field("position [m]", pa.float64())]
    parquet.write_table(pa.table([np.arange(9.0)] * 2, schema=pa.schema(fields)), tmp_path / "a.parquet")
    with pytest.raises(FricError, match="is not a unit"):
        ingest(tmp_path / "a.parquet", tmp_path / "a.h5")
