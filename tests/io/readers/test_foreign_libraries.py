"""Files written by the libraries of other formats, read and held to what was written."""

import re
import subprocess
import sys

import numpy as np
import pytest

from fric import FricError
from fric.io.hdf5 import read_logs
from fric.io.ingest import ingest
from fric.io.readers import formats, tables

N = 150_000  # more than a block
TIME = np.arange(N) / 4000.0
POSITION = 3.0 * np.sin(TIME)
FORCE = 50.0 * np.cos(TIME)
SLOW = np.arange(0.0003, TIME[-1], 0.002)


def read(path, **given):
    done = ingest(path, path.with_suffix(".h5"), force=True, **given)
    return done, read_logs(path.with_suffix(".h5"))


def mf4(path, *, joined=False, compression=0):
    from asammdf import MDF, Signal

    with MDF(version="4.10") as file:
        signals = [Signal(POSITION, TIME, name="position", unit="mm")]
        if not joined:
            signals.append(Signal(FORCE.astype("f4"), TIME, name="force", unit="N"))
        signals.append(Signal(np.arange(N, dtype="u2"), TIME, name="status"))
        file.append(signals)
        if joined:
            file.append([Signal(50.0 * np.cos(SLOW), SLOW, name="force", unit="N")])
        file.save(path, overwrite=True, compression=compression)


def tdms(path, *, joined=False):
    from nptdms import ChannelObject, TdmsWriter

    clock = {"wf_increment": 1 / 4000.0}
    slow = {"wf_increment": 0.002, "wf_start_offset": SLOW[0]}
    with TdmsWriter(path) as file:
        for part in np.array_split(np.arange(N), 3):  # in segments, as it is logged
            objects = [ChannelObject("drive", "position", POSITION[part], {**clock, "unit_string": "mm"})]
            if not joined:
                objects.append(ChannelObject("drive", "force", FORCE[part], {**clock, "unit_string": "N"}))
            file.write_segment(objects)
        if joined:
            file.write_segment([ChannelObject("amplifier", "force [N]", 50.0 * np.cos(SLOW), slow)])


def parquet(path):
    from pyarrow import parquet, table

    columns = [TIME, POSITION, FORCE.astype("f4")]
    parquet.write_table(table(columns, ["time [s]", "position [mm]", "force [N]"]), path)


@pytest.mark.parametrize(
    ("ending", "write", "exact"), [(".mf4", mf4, 0.0), (".tdms", tdms, 1e-15), (".parquet", parquet, 0.0)]
)
def test_round_trip(tmp_path, ending, write, exact):
    path = tmp_path / f"log{ending}"
    write(path)
    _, (log,) = read(path)
    np.testing.assert_allclose(log.time, TIME, rtol=exact)
    np.testing.assert_array_equal(log.position, POSITION * 1e-3)
    np.testing.assert_array_equal(log.force, FORCE if ending == ".tdms" else FORCE.astype("f4"))


@pytest.mark.parametrize(("ending", "write"), [(".mf4", mf4), (".tdms", tdms)])
def test_two_rates_are_put_on_one_clock_and_the_shift_is_told(tmp_path, ending, write):
    path = tmp_path / f"log{ending}"
    write(path, joined=True)
    done, (log,) = read(path)
    clock = TIME[round(SLOW[0] / TIME[1]) % 8 :: 8]  # the samples beside those of the slowest channel
    inside = clock[(clock >= SLOW[0]) & (clock <= SLOW[-1])]
    np.testing.assert_allclose(log.time, inside, rtol=1e-15)
    np.testing.assert_allclose(log.position, 3e-3 * np.sin(inside), rtol=1e-15)
    np.testing.assert_allclose(log.force, 50.0 * np.cos(log.time), atol=50.0 * 0.002**2 / 8)  # of a straight line
    told = " ".join(done.warnings)
    assert "'position': one sample in 8 is taken" in told
    assert "(sampled at 500 Hz, 4000 Hz there) moved by -50 µs" in told


def test_packed_mf4_and_samples_marked_invalid(tmp_path):
    from asammdf import MDF, Signal

    mf4(tmp_path / "packed.mf4", compression=2)
    assert (tmp_path / "packed.mf4").stat().st_size < N * 18
    np.testing.assert_array_equal(read(tmp_path / "packed.mf4")[1][0].position, POSITION * 1e-3)
    bad = np.zeros(100, bool)
    bad[[7, 8]] = True
    marked = Signal(POSITION[:100], TIME[:100], name="position", unit="mm", invalidation_bits=bad)
    with MDF(version="4.10") as file:
        file.append([marked])
        file.save(tmp_path / "marked.mf4")
    with pytest.raises(FricError, match="sample 8, column 'position'"):
        read(tmp_path / "marked.mf4")
    assert read(tmp_path / "marked.mf4", bad_cells="drop")[0].dropped == 2


def test_tdms_groups_of_the_same_channels_are_records_and_a_column_may_be_the_time(tmp_path):
    from nptdms import ChannelObject, TdmsWriter

    with TdmsWriter(tmp_path / "runs.tdms") as file:
        for k in (1, 2):
            columns = {"Time [ms]": TIME[:500] * 1e3, "position [mm]": k * POSITION[:500]}
            file.write_segment([ChannelObject(f"run {k}", name, values) for name, values in columns.items()])
    _, logs = read(tmp_path / "runs.tdms")
    assert [log.name for log in logs] == ["run 1", "run 2"]
    np.testing.assert_allclose(logs[1].position, 2e-3 * POSITION[:500], rtol=1e-15)
    np.testing.assert_allclose(logs[1].time, TIME[:500], rtol=1e-12)


@pytest.mark.parametrize("plugin", ["MCAP", "SQLITE3"])
def test_ros_2_bag(tmp_path, plugin):
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    from fric.documents.mapping import MappingDocument

    store = get_typestore(Stores.ROS2_HUMBLE)
    kinds = store.types
    state, header, stamp = (
        kinds[f"{name}"]
        for name in ("sensor_msgs/msg/JointState", "std_msgs/msg/Header", "builtin_interfaces/msg/Time")
    )
    wrench = (
        kinds["geometry_msgs/msg/WrenchStamped"],
        kinds["geometry_msgs/msg/Wrench"],
        kinds["geometry_msgs/msg/Vector3"],
    )

    def head(t):
        return header(stamp=stamp(sec=int(t), nanosec=round((t % 1) * 1e9)), frame_id="")

    n = 3000
    with Writer(tmp_path / "bag", version=9, storage_plugin=StoragePlugin[plugin]) as bag:
        joints = bag.add_connection("/joint_states", state.__msgtype__, typestore=store)
        forces = bag.add_connection("/wrench", wrench[0].__msgtype__, typestore=store)
        for k in range(n):
            t = 100.0 + TIME[k]
            message = state(head(t), ["x", "y"], np.array([POSITION[k], 0.0]), np.array([0.0, 0.0]), np.array([]))
            bag.write(joints, int(t * 1e9) + 5_000_000, store.serialize_cdr(message, state.__msgtype__))
            if k % 4 == 0:
                zero = wrench[2](0.0, 0.0, 0.0)
                message = wrench[0](head(t), wrench[1](wrench[2](FORCE[k], 0.0, 0.0), zero))
                bag.write(forces, int(t * 1e9) + 6_000_000, store.serialize_cdr(message, wrench[0].__msgtype__))
    (path,) = (one for one in (tmp_path / "bag").iterdir() if one.suffix in {".mcap", ".db3"})
    mapping = MappingDocument.model_validate({
        "fric": "mapping/1",
        "columns": {
            "time": {"column": "time"}, "position": {"column": "/joint_states.position[x]", "unit": "mm"},
            "force": {"column": "/wrench.wrench.force.x", "unit": "N"},
        },
    })  # fmt: skip
    done, (log,) = read(path, mapping=mapping)
    np.testing.assert_allclose(log.time, 100.0 + TIME[:n:4], atol=2e-8)  # stamps, not when it was recorded
    np.testing.assert_allclose(log.position, POSITION[:n:4] * 1e-3, rtol=1e-15)
    np.testing.assert_array_equal(log.force, FORCE[:n:4])
    assert any("one sample in 4" in warning for warning in done.warnings)


def test_workbook_with_sheets_dates_and_a_bad_cell(tmp_path):
    from datetime import datetime, timedelta

    from openpyxl import Workbook

    book = Workbook()
    for k, sheet in enumerate((book.active, book.create_sheet("second"))):
        sheet.append(["measured by", "me"])
        sheet.append(["time [s]", "position [mm]", "force [N]"])
        for n in range(300):
            at = datetime(2026, 3, 1) + timedelta(milliseconds=10 * n) if k else TIME[n]
            sheet.append([at, POSITION[n], FORCE[n] if (k, n) != (1, 200) else "over"])
    book.active.append([None, None])
    book.save(tmp_path / "log.xlsx")
    with pytest.raises(FricError, match=r"sheet 'second', row 203, column 'force': 'over' is not a number"):
        read(tmp_path / "log.xlsx")
    done, logs = read(tmp_path / "log.xlsx", bad_cells="drop")
    assert [log.name for log in logs] == ["Sheet", "second"]
    np.testing.assert_allclose(logs[0].force, FORCE[:300], rtol=1e-15)
    np.testing.assert_allclose(logs[0].time, TIME[:300], rtol=1e-15)
    assert done.dropped == 1
    assert np.median(np.diff(logs[1].time)) == pytest.approx(0.01, rel=1e-4)


@pytest.mark.parametrize("ending", [".mf4", ".tdms", ".parquet", ".mcap", ".db3", ".bag", ".xlsx"])
def test_damaged_files_are_told_as_such(tmp_path, ending):
    marks = {
        ".mf4": b"MDF     4.10    ", ".tdms": b"TDSm", ".parquet": b"PAR1", ".mcap": b"\x89MCAP0\r\n",
        ".db3": b"SQLite format 3\0", ".bag": b"#ROSBAG V2.0\n", ".xlsx": b"PK\x03\x04",
    }  # fmt: skip
    path = tmp_path / f"cut{ending}"
    path.write_bytes(marks[ending] + bytes(300))
    with pytest.raises(FricError) as refused:
        read(path)
    assert str(path) in str(refused.value)


def test_a_library_that_lacks_is_named_with_the_command(tmp_path):
    marks = {"mf4": b"MDF     4.10", "tdms": b"TDSm", "parquet": b"PAR1", "ros": b"\x89MCAP0", "xlsx": b"PK\x03\x04"}
    hidden = {form.module.partition(".")[0]: form for form in formats() if form.extra}
    assert {form.extra for form in hidden.values()} == marks.keys()
    script = "import sys\n" + "".join(f"sys.modules['{name}'] = None\n" for name in hidden) + (
        "from pathlib import Path\nfrom fric.io.readers import tables\n"
        "for name in sys.argv[1:]:\n"
        "    try:\n        list(tables(Path(name)))\n    except Exception as error:\n        print(repr(str(error)))\n"
    )  # fmt: skip
    files = []
    for form in hidden.values():
        files.append(tmp_path / f"log{form.endings[0]}")
        files[-1].write_bytes(marks[form.extra] + bytes(100))
    done = subprocess.run([sys.executable, "-c", script, *map(str, files)], capture_output=True, text=True, check=True)
    for form, line in zip(hidden.values(), done.stdout.splitlines(), strict=True):
        assert "which is not installed" in line
        assert f"pip install 'fric[{form.extra}]'" in line


def test_memory_does_not_grow_with_the_file(tmp_path):
    sizes = []
    for path, write in ((tmp_path / "a.mf4", mf4), (tmp_path / "a.tdms", tdms), (tmp_path / "a.parquet", parquet)):
        write(path)
        table = next(found := tables(path))
        names = [column.name for column in table.columns]
        wanted = [names.index(name) for name in ("time", "position", "force")]
        sizes += [len(block.columns[0]) for block in table.read(wanted)]
        found.close()
    assert max(sizes) < N


def test_what_a_library_logs_of_a_file_is_a_warning_of_the_file_and_nothing_on_standard_error(tmp_path, capfd):
    tdms(tmp_path / "whole.tdms")
    whole = (tmp_path / "whole.tdms").read_bytes()
    (tmp_path / "cut.tdms").write_bytes(whole[: len(whole) * 2 // 3])
    done, (log,) = read(tmp_path / "cut.tdms")
    assert len(log) < N
    assert {warning.code for warning in done.warnings} >= {"library-warns"}
    assert "less data than expected" in " ".join(done.warnings)
    mf4(tmp_path / "whole.mf4")
    damaged = bytearray((tmp_path / "whole.mf4").read_bytes())
    damaged[100:200] = b"\xff" * 100
    (tmp_path / "bad.mf4").write_bytes(damaged)
    with pytest.raises(FricError):
        read(tmp_path / "bad.mf4")
    assert capfd.readouterr().err == ""


def test_a_channel_of_mf4_beyond_its_records_is_refused(tmp_path):
    """The library copies it in compiled code, which ended with signal 11."""
    mf4(tmp_path / "log.mf4")
    content = bytearray((tmp_path / "log.mf4").read_bytes())
    for block in (found.start() for found in re.finditer(b"##CN", bytes(content))):
        data = block + 24 + 8 * int.from_bytes(content[block + 16 : block + 24], "little")
        if any(content[data + 4 : data + 8]):
            content[data + 4 : data + 8] = (2**31 - 1).to_bytes(4, "little")
    (tmp_path / "log.mf4").write_bytes(content)
    with pytest.raises(FricError, match="begins beyond its records"):
        read(tmp_path / "log.mf4")
