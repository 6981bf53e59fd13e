"""Each input that `fric ingest` cannot take: told in one or two lines, exit status 1, and no output left."""

import os
import resource
import shutil
import signal
import subprocess
from pathlib import Path

import h5py
import numpy as np
import pytest

import fric
from fric import FricError
from fric.documents.mapping import MappingDocument
from fric.documents.yaml import read_document
from fric.io.hdf5 import read_logs
from fric.io.ingest import ingest

HEADER = "time [s],position [mm],force [N]\n"


def rows(time, gap=None):
    """A sine of 1 mm with a friction of 2 N; `gap` replaces cells of the force by row."""
    x = np.sin(2 * np.pi * np.asarray(time))
    v = np.cos(2 * np.pi * np.asarray(time))
    cells = [f"{f:.3f}" for f in 2 * np.tanh(10 * v)]
    for row, cell in (gap or {}).items():
        cells[row] = cell
    return "".join(f"{t:.6f},{a:.6f},{f}\n" for t, a, f in zip(time, x, cells, strict=True))


GOOD = np.arange(400) / 400


def ingest_text(tmp_path, text):
    (tmp_path / "right.csv").write_text(text)
    return ingest(tmp_path / "right.csv", tmp_path / "right.h5")


def refused(tmp_path, text, **options):
    """Ingest a text that must be refused; return the message, having checked what holds for every refusal."""
    log, output = tmp_path / "log.csv", tmp_path / "out" / "log.h5"
    output.parent.mkdir(exist_ok=True)
    if isinstance(text, bytes):
        log.write_bytes(text)
    else:
        log.write_text(text)
    with pytest.raises(FricError) as caught:
        ingest(log, output, **options)
    assert list(output.parent.iterdir()) == []
    assert 1 <= len(str(caught.value).splitlines()) <= 2
    assert str(log) in str(caught.value)
    return str(caught.value)


@pytest.mark.parametrize("text", ["", "\n\n", "   \n"])
def test_empty_file(tmp_path, text):
    assert "is empty" in refused(tmp_path, text)


@pytest.mark.parametrize("text", [HEADER, "Date:;today\n;v;T\nms;rpm;%\n"])
def test_header_only(tmp_path, text):
    assert "no rows of numbers" in refused(tmp_path, text)


def test_header_only_after_the_mark_of_a_mapping(tmp_path):
    document = tmp_path / "map.yaml"
    document.write_text("fric: mapping/1\nformat: {data_after: 'ms;'}\ncolumns: {time: {column: 0, unit: s}}\n")
    mapping = read_document(document, MappingDocument)
    assert "a header and no data" in refused(tmp_path, ";v;T\nms;rpm;%\n", mapping=mapping)


def test_missing_column(tmp_path):
    told = refused(tmp_path, (HEADER + rows(GOOD)).replace("position", "place"))
    assert "no column is named position, and 'place" in told
    assert "--propose" in told
    told = refused(tmp_path, (HEADER + rows(GOOD)).replace("position [mm]", "place"))
    assert "no column is position or velocity" in told
    assert "'time', 'place', 'force'" in told


@pytest.mark.parametrize("row", [0, 1, 250])
def test_text_in_a_number(tmp_path, row):
    told = refused(tmp_path, HEADER + rows(GOOD, {row: "abc"}))
    assert f"line {row + 2}, column 'force': 'abc' is not a number" in told
    assert "bad_cells='drop'" in told


def test_the_line_is_right_past_blank_lines_and_blocks(tmp_path):
    time = np.arange(140_000) / 1000
    text = rows(time, {135_000: "1.2.3"}).splitlines(keepends=True)
    text.insert(100, "\n")
    told = refused(tmp_path, HEADER + "".join(text))
    assert "line 135003, column 'force': '1.2.3' is not a number" in told


def test_nan_stretch(tmp_path):
    told = refused(tmp_path, HEADER + rows(GOOD, dict.fromkeys(range(100, 130), "NaN")))
    assert "line 102, column 'force': 30 cells in a row are not numbers, the first 'NaN'" in told


def test_a_line_with_too_many_cells(tmp_path):
    text = (HEADER + rows(GOOD)).splitlines()
    text[200] += ",7"
    assert "line 201: has more cells than the 3 of the header" in refused(tmp_path, "\n".join(text))


def test_time_running_backwards(tmp_path):
    time = np.concatenate([GOOD[:200], GOOD[100:]])
    told = refused(tmp_path, HEADER + rows(time))
    assert "line 202: time runs backwards, from 0.4975 s to 0.25 s" in told


def test_repeated_stamps(tmp_path):
    time = np.repeat(GOOD[::2], 2)
    told = refused(tmp_path, HEADER + rows(time))
    assert "line 3: the stamp 0 s is repeated" in told
    assert "rate" in told


@pytest.mark.parametrize("second", [2.0, 10.0, 0.5])
def test_two_sampling_rates(tmp_path, second):
    time = np.cumsum(np.concatenate([np.full(300, 1e-3), np.full(200, 1e-3 * second)]))
    told = refused(tmp_path, HEADER + rows(time))
    assert "two sampling rates" in told
    line = int(told.split("line ")[1].split(" ")[0])
    assert abs(line - 301) <= 32
    assert "1000 Hz" in told
    assert f"{1000 / second:.4g} Hz" in told


@pytest.mark.parametrize("seed", range(5))
def test_jitter_and_lost_samples_are_no_second_rate(tmp_path, seed):
    rng = np.random.default_rng(seed)
    time = np.arange(4000) * 1e-3 + rng.uniform(-0.4e-3, 0.4e-3, 4000)
    time = time[rng.random(4000) > 0.1]
    time = np.delete(time, slice(1000, 1400))
    (tmp_path / "log.csv").write_text(HEADER + rows(time))
    done = ingest(tmp_path / "log.csv", tmp_path / "log.h5")
    assert done.samples == len(time)
    assert done.warnings == ()


def test_unit_of_the_wrong_kind(tmp_path):
    told = refused(tmp_path, (HEADER + rows(GOOD)).replace("force [N]", "force [mm]"))
    assert "column 'force': force cannot be in 'mm'" in told
    assert "converts to N" in told


def test_kelvins_of_a_turning_drive_ask_for_a_scale_and_not_for_another_speed(tmp_path):
    log = "time [ms],velocity [rpm],torque [K]\n" + "".join(f"{n},60,30\n" for n in range(50))
    told = refused(tmp_path, log)
    assert "column 'torque': force cannot be in 'K'" in told
    assert 'as in scale: "12.5 N*m"' in told


def test_no_unit(tmp_path):
    assert "column 'force' (force) has no unit" in refused(
        tmp_path, (HEADER + rows(GOOD)).replace("force [N]", "force")
    )


def test_missing_sign(tmp_path):
    time = np.arange(4000) / 1000
    lines = [line.rpartition(",") for line in rows(time).splitlines()]
    one = "\n".join(f"{a},{-float(f)}" for a, _, f in lines)
    assert ingest_text(tmp_path, HEADER + rows(time)).samples == 4000
    told = refused(tmp_path, HEADER + one)
    assert "the force opposes the motion throughout" in told
    assert "sign: -1" in told


def test_truncated_hdf5(tmp_path, log):
    whole = log.read_bytes()
    log.write_bytes(whole[: len(whole) * 2 // 3])
    with pytest.raises(FricError, match="an incomplete HDF5 file"):
        ingest(log, tmp_path / "new.h5")
    with pytest.raises(FricError, match="an incomplete HDF5 file"):
        read_logs(log)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["good.csv", "log.h5"]


@pytest.mark.parametrize("kind", ["friction", "plant", "machine"])
def test_a_document_in_place_of_a_log_and_a_run_in_place_of_a_document(kind, tmp_path):
    (tmp_path / "made.yaml").write_text(f"# made today\nfric: {kind}/1\naxis: x\n", encoding="utf-8")
    with pytest.raises(FricError, match=f"is a {kind} file, and a log file is needed"):
        fric.ingest(tmp_path / "made.yaml", output=tmp_path / "new.h5")
    (tmp_path / "run.h5").write_bytes(b"\x89HDF\r\n\x1a\n" + bytes(3 << 20))  # larger than any document
    with pytest.raises(FricError, match="is a log, a circle or a run, and a machine file is needed"):
        fric.circle(tmp_path / "run.h5")


def test_hdf5_of_another_type(tmp_path, log):
    with h5py.File(tmp_path / "run.h5", "w") as file:
        file.attrs["fric"] = "run/1"
    with pytest.raises(FricError, match="is a run file, and a log file is needed"):
        ingest(tmp_path / "run.h5", tmp_path / "new.h5")
    with pytest.raises(FricError, match="is a run file, and a log file is needed"):
        ingest(tmp_path / "good.csv", tmp_path / "run.h5", append=True)
    with h5py.File(tmp_path / "run.h5") as file:
        assert list(file) == []
    assert not (tmp_path / "new.h5").exists()


def test_hdf5_whose_axis_moves_as_none_does(log):
    with h5py.File(log, "r+") as file:
        file.attrs["motion"] = "sideways"
    with pytest.raises(FricError, match="'sideways', and not linear or rotary"):
        read_logs(log)


def test_output_that_exists(tmp_path, log):
    before = log.read_bytes()
    with pytest.raises(FricError, match="the output exists"):
        ingest(tmp_path / "good.csv", log)
    assert log.read_bytes() == before
    ingest(tmp_path / "good.csv", log, force=True)


def test_folder_that_is_not_there(tmp_path, log):
    with pytest.raises(FricError, match=r"there is no folder .*\nMake the folder first"):
        ingest(tmp_path / "good.csv", tmp_path / "nowhere" / "log.h5")


def test_a_log_that_was_not_ingested_is_sent_there(tmp_path):
    (tmp_path / "log.csv").write_text(HEADER + rows(GOOD))
    with pytest.raises(FricError, match="is not a log file of fric\nMake one of it: `fric ingest "):
        read_logs(tmp_path / "log.csv")


def test_folder_as_input(tmp_path):
    with pytest.raises(FricError, match="is a folder"):
        ingest(tmp_path, tmp_path / "log.h5")


def test_unreadable_folder(tmp_path, log):
    shut = tmp_path / "shut"
    shut.mkdir()
    (shut / "log.csv").write_text(HEADER + rows(GOOD))
    shut.chmod(0)
    root = os.geteuid() == 0
    if root:  # to whom every folder is open
        for folder in (tmp_path, *tmp_path.parents):
            if "pytest-of-" in str(folder):  # pytest's own folders, one more of them under xdist
                folder.chmod(0o755)
        os.seteuid(65534)
    try:
        with pytest.raises(FricError, match="cannot be read: Permission denied\nMay you"):
            ingest(shut / "log.csv", tmp_path / "new.h5")
        with pytest.raises(FricError, match="cannot be written: Permission denied"):
            ingest(tmp_path / "good.csv", shut / "new.h5")
    finally:
        if root:
            os.seteuid(0)
        shut.chmod(0o755)
    assert [path.name for path in shut.iterdir()] == ["log.csv"]


def command(*arguments):
    return ["fric", "ingest", *map(str, arguments)]


@pytest.fixture(scope="module")
def long_log(tmp_path_factory):
    """A log of noise, long enough to be interrupted, which HDF5 cannot shorten."""
    values = np.random.default_rng(1).normal(size=(400_000, 2))
    path = tmp_path_factory.mktemp("long") / "long.csv"
    with path.open("w") as file:
        file.write(HEADER)
        file.writelines(f"{n / 1000:.3f},{a!r},{f!r}\n" for n, (a, f) in enumerate(values.tolist()))
    return path


@pytest.mark.parametrize("room", [2_000, 300_000])
def test_full_disk(tmp_path, long_log, room, warm):
    """A limit on the size of files is to a process what a full disk is: a write that fails in the middle."""
    out = tmp_path / "out"
    out.mkdir()
    done = subprocess.run(
        command(long_log, "-o", out / "log.h5"),
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (room, room)),
        env=warm, capture_output=True, text=True, check=False, timeout=600,
    )  # fmt: skip
    assert done.returncode == 1, done.stderr
    assert "cannot be written: File too large" in done.stderr
    assert len(done.stderr.splitlines()) == 2
    assert list(out.iterdir()) == []


INTERRUPTED = """
import os, sys
from pathlib import Path
from fric.cli.main import main
from fric.io.hdf5 import RecordWriter
number, written, out = int(sys.argv[1]), int(sys.argv[2]), Path(sys.argv[3])
extend = RecordWriter.extend
def extended(record, block):
    extend(record, block)
    if any(draft.stat().st_size >= written for draft in out.iterdir()):
        os.kill(os.getpid(), number)
RecordWriter.extend = extended
sys.argv[1:4] = []
main()
"""


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("written", [0, 1_000_000])
def test_interrupt_in_the_middle(tmp_path, long_log, number, written, warm):
    out = tmp_path / "out"
    out.mkdir()
    words = [shutil.which("python", path=warm["PATH"]), "-c", INTERRUPTED, str(int(number)), str(written), str(out)]
    done = subprocess.run(
        [*words, *command(long_log, "-o", out / "log.h5")[1:]], env=warm, capture_output=True, text=True, check=False
    )
    assert done.returncode == 128 + number, done.stderr
    assert done.stderr.startswith("error: interrupted")
    assert len(done.stderr.splitlines()) <= 2
    assert list(out.iterdir()) == []


@pytest.fixture
def log(tmp_path) -> Path:
    """A log file of one good record."""
    (tmp_path / "good.csv").write_text(HEADER + rows(GOOD))
    ingest(tmp_path / "good.csv", tmp_path / "log.h5")
    return tmp_path / "log.h5"


KINDS = {
    "friction": "fric: friction/1\naxis: x\nmotion: linear\nstatic: {F_c: 60 N, F_s: 90 N, v_s: 2 mm/s}\n",
    "plant": "fric: plant/1\naxis: x\nmotion: linear\nA: 14 1/s\nB: 2.4 m/(s^2*V)\nT_d: 0.6 ms\nK_f: 150 N/V\n",
}


@pytest.mark.parametrize(
    ("call", "is_a", "types"),
    [
        (lambda f: fric.circle(f / "friction.yaml"), "friction", "fric simulate circle MACHINE.yaml --friction x="),
        (lambda f: fric.identify_gms("data/presliding-sine.h5", static=f / "plant.yaml"), "plant", "--plant "),
        (lambda f: fric.export_axis("c", f / "friction.yaml", axis="x"), "friction", "`fric auto LOGS -o found`"),
        (lambda f: fric.identify_static(f / "plant.yaml"), "plant", "`fric ingest FILES -o log.h5`"),
        (lambda f: fric.identify_static("data/circle.h5"), "circle", "`fric diagnose data/circle.h5`"),
        (lambda f: fric.diagnose("data/sliding-sine.h5"), "log", "`fric inspect data/sliding-sine.h5`"),
        (lambda f: fric.circle("data/sliding-sine.h5"), "log, a circle or a run", "`fric inspect data"),
        (
            lambda f: fric.design_controller(f / "friction.yaml"),
            "friction",
            "`fric identify plant LOG.h5 -o plant.yaml`",
        ),
        (lambda f: fric.diagnose("data/circle.h5", machine=f / "plant.yaml"), "plant", "in found/machine.yaml"),
    ],
)
def test_a_file_of_another_kind_says_what_to_type(call, is_a: str, types: str, tmp_path: Path) -> None:
    for name, text in KINDS.items():
        (tmp_path / f"{name}.yaml").write_text(text, encoding="utf-8")
    with pytest.raises(FricError, match=f"is a {is_a}.*, and a .* is needed") as refused:
        call(tmp_path)
    assert types in refused.value.hint
