"""Small files that unpack to, or say that they hold, more than is read: refused in a sentence, at once."""

from __future__ import annotations

import bz2
import gzip
import re
import sqlite3
import struct
import time
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import h5py
import numpy as np
import pytest

from fric.documents.mapping import Layout
from fric.documents.plant import PlantDocument
from fric.documents.yaml import read_document
from fric.errors import FricError
from fric.io.ingest import ingest
from fric.io.readers import xlsx as xlsx_reader
from fric.io.safe_hdf5 import open_file
from tests.fuzz.reading import MAPPINGS
from tests.fuzz.whole import archive_of, mcap, members, mf4, old_bag, parquet, tdms, xlsx

SOON = 20.0
"""Seconds of this process, within which each ends."""


def refused(path: Path, match: str) -> None:
    begun = time.process_time()
    with pytest.raises(FricError, match=match):
        ingest(path, path.with_name("out.h5"), mapping=MAPPINGS.get(path.suffix), force=True)
    assert time.process_time() - begun < SOON
    assert not path.with_name("out.h5").exists()


SHEET = "xl/worksheets/sheet1.xml"


def _xlsx(folder: Path, change: Callable[[dict[str, bytes]], dict[str, bytes]]) -> Path:
    path = xlsx(folder)
    path.write_bytes(archive_of(change(members(path.read_bytes()))))
    return path


def test_a_workbook_that_unpacks_to_what_no_memory_holds(tmp_path: Path) -> None:
    for name, what in (("xl/styles.xml", 80 << 20), (SHEET, 80 << 20)):
        refused(_xlsx(tmp_path, lambda files, name=name, what=what: files | {name: bytes(what)}), "unpacks to more")


def test_a_workbook_that_lies_about_what_it_unpacks_to(tmp_path: Path) -> None:
    path = _xlsx(tmp_path, lambda files: files | {"xl/styles.xml": bytes(80 << 20)})
    content = path.read_bytes()
    path.write_bytes(content.replace(struct.pack("<I", 80 << 20), struct.pack("<I", 1000)))
    refused(path, "damaged")


def test_a_workbook_of_a_million_rows_that_are_not_there_is_read(tmp_path: Path) -> None:
    def wide(files: dict[str, bytes]) -> dict[str, bytes]:
        sheet = files[SHEET].decode()
        sheet = sheet.replace("A1:C301", "A1:XFD1048576")
        assert "XFD1048576" in sheet
        return files | {SHEET: sheet.encode()}

    begun = time.process_time()
    assert ingest(_xlsx(tmp_path, wide), tmp_path / "out.h5").samples == 300
    assert time.process_time() - begun < SOON


def test_a_row_beyond_all_sheets_ends(tmp_path: Path) -> None:
    def far(files: dict[str, bytes]) -> dict[str, bytes]:
        sheet = files[SHEET].decode().replace('<row r="301"', '<row r="99999999999"')
        assert "99999999999" in sheet
        return files | {SHEET: sheet.encode()}

    refused(_xlsx(tmp_path, far), "more rows than a sheet has")


def test_entities_of_a_workbook_do_not_grow(tmp_path: Path) -> None:
    laugh = "".join(f'<!ENTITY a{n} "{f"&a{n - 1};" * 10 if n else "ha" * 50}">' for n in range(10))
    text = f'<?xml version="1.0"?><!DOCTYPE a [{laugh}]><sst><si><t>&a9;</t></si></sst>'
    path = _xlsx(tmp_path, lambda files: files | {"xl/workbook.xml": text.encode()})
    refused(path, "damaged|no sheet")


def test_a_measurement_that_says_it_has_more_samples_than_fit(tmp_path: Path) -> None:
    path = mf4(tmp_path)
    content = bytearray(path.read_bytes())
    at = content.find(b"##CG")
    block = struct.unpack_from("<Q", content, at + 16)[0]  # links
    struct.pack_into("<Q", content, at + 24 + 8 * block + 8, 10**12)
    path.write_bytes(content)
    refused(path, "declares|damaged")


def test_a_tdms_file_that_says_it_has_more_samples_than_fit(tmp_path: Path) -> None:
    path = tdms(tmp_path)
    content = path.read_bytes()
    count = struct.pack("<Q", 150)
    assert count in content
    path.write_bytes(content.replace(count, struct.pack("<Q", 10**11)))
    begun = time.process_time()
    assert ingest(path, tmp_path / "out.h5").samples <= 300  # what is there
    assert time.process_time() - begun < SOON


def test_a_parquet_file_of_rows_that_take_no_room(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """With the bound brought down, so that a small file is beyond it."""
    import pyarrow as pa
    from pyarrow import parquet as writer

    monkeypatch.setattr("fric.input.MOST_PACKED", 100)
    path = parquet(tmp_path)
    writer.write_table(pa.table({name: np.zeros(1_000_000) for name in ("time [s]", "position [m]")}), path)
    refused(path, "declares 16 MB")


def test_no_text_of_a_parquet_file_is_read(tmp_path: Path) -> None:
    """As 60 kB whose one text of a MB recurs: 2.2 GB of memory."""
    import pyarrow as pa
    from pyarrow import parquet as writer

    from fric.io.readers.parquet import tables

    def write(plain: bool) -> None:
        text = pa.DictionaryArray.from_arrays(np.zeros(300, "i4"), ["1" * 100_000])
        columns = {"time [s]": np.arange(300.0), "position [mm]": text.dictionary_decode() if plain else text}
        writer.write_table(pa.table(columns), tmp_path / "a.parquet")

    for plain in (False, True):
        write(plain)
        with closing(tables(tmp_path / "a.parquet", Layout())) as opened:
            (block,) = next(opened).read([0, 1])
            assert pa.total_allocated_bytes() < 10e6
        assert np.array_equal(block.columns[0], np.arange(300.0))
        assert np.isnan(block.columns[1]).all()


def test_a_log_whose_zeros_take_no_room(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """With the bound brought down, so that a small file is beyond it."""
    monkeypatch.setattr("fric.io.safe_hdf5.MOST_EMPTY", 1 << 20)
    with h5py.File(tmp_path / "log.h5", "w") as file:
        file.create_dataset("records/a/force", data=np.zeros(1_000_000), compression="gzip", compression_opts=9)
    with pytest.raises(FricError, match=r"unpacks .* to 8 MB"), open_file(tmp_path / "log.h5"):
        pass


@pytest.mark.parametrize("kind", ["zstd", "lz4"])
def test_a_chunk_of_a_bag_that_unpacks_to_a_gibibyte(kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """With the bound brought down, so that this test makes no gibibyte itself."""
    from rosbags.rosbag2 import storage_mcap

    from fric.io.readers import rosbag

    monkeypatch.setattr(rosbag, "MOST_CHUNK", 1 << 20)
    whole = bytes(8 << 20)
    if kind == "zstd":
        packed = storage_mcap.zstd.compress(whole)
    else:
        from lz4.frame import compress

        packed = compress(whole)
    small = bytes(1 << 19)
    again = storage_mcap.zstd.compress(small) if kind == "zstd" else compress(small)
    with rosbag._bounded():
        with pytest.raises(FricError, match="unpacks to more"):
            storage_mcap.DECOMPRESSORS[kind](packed, 1)
        assert storage_mcap.DECOMPRESSORS[kind](again, 1) == small


def test_a_chunk_of_an_old_bag_that_unpacks_to_more(monkeypatch: pytest.MonkeyPatch) -> None:
    from rosbags.rosbag1 import reader

    from fric.io.readers import rosbag

    monkeypatch.setattr(rosbag, "MOST_CHUNK", 1 << 20)
    with rosbag._bounded():
        with pytest.raises(FricError, match="unpacks to more"):
            reader.decompressors["bz2"](bz2.compress(bytes(8 << 20)))
        assert reader.decompressors["bz2"](bz2.compress(b"a") + bz2.compress(b"b")) == b"ab"


@pytest.mark.parametrize("make", [mcap, old_bag])
def test_what_a_bag_is_unpacked_with_is_put_back(tmp_path: Path, make: Callable[[Path], Path]) -> None:
    """It belongs to the whole process, as a hook that a user's program has in SQLite."""
    apsw, ros_1 = pytest.importorskip("apsw"), pytest.importorskip("rosbags.rosbag1.reader")
    from rosbags.rosbag2 import storage_mcap

    from fric.io.readers import rosbag

    def state() -> tuple[object, ...]:
        return list(apsw.connection_hooks), dict(ros_1.decompressors), dict(storage_mcap.DECOMPRESSORS)

    apsw.connection_hooks.append(hook := lambda file: None)
    try:
        before = state()
        with closing(rosbag.tables(make(tmp_path), Layout())) as tables:
            next(tables)
            assert hook in apsw.connection_hooks
            assert len(apsw.connection_hooks) == len(before[0]) + 2
        assert state() == before
    finally:
        apsw.connection_hooks.remove(hook)


def test_a_dataset_that_unpacks_as_far_as_deflate_reaches_is_read_and_no_further(tmp_path: Path) -> None:
    import h5py

    from fric.io.hdf5 import read_records, write_logs
    from fric.log import Log

    t = np.arange(4000.0)
    path = tmp_path / "log.h5"
    write_logs(path, [Log(time=t, position=t, name="a", source="a")])
    with h5py.File(path, "a") as file:
        del file["records/a/position"]
        data = file["records/a"].create_dataset("position", (10**9,), "f8", chunks=(10**6,), compression="gzip")
        data.attrs["unit"] = "m"
        data[:1000] = 1.0
    with pytest.raises(FricError, match="declares"):
        read_records(path)


@pytest.mark.parametrize("end", [b"," * 64, b"0" * 64, b'"a' * 32, b"1.0,2.0\n" * 8])
def test_a_packed_text_that_unpacks_to_what_no_log_does(tmp_path: Path, end: bytes) -> None:
    """As 0.5 MB that took 9.5 GB of memory."""
    rows = b"".join(b"%d.0,1.0\n" % n for n in range(500))
    with gzip.open(tmp_path / "log.csv.gz", "wb") as file:
        file.write(b"time [s],position [m]\n" + rows)
        for _ in range(70 if end.endswith(b"\n") else 3):
            file.write(end * (1 << 14))
    refused(tmp_path / "log.csv.gz", "unpacks to over|a line of over|runs backwards")


def test_a_row_of_a_workbook_that_does_not_end(tmp_path: Path) -> None:
    long = b"<c><v>1</v></c>" * 700_000
    path = _xlsx(tmp_path, lambda files: files | {SHEET: files[SHEET].replace(b"</row>", long + b"</row>", 1)})
    refused(path, "a row of over 8 MiB")


def test_a_workbook_that_does_not_say_its_size_is_not_read_for_it(tmp_path: Path, monkeypatch) -> None:
    """As 95 s before a header that names no time was told."""
    more = b"<row><c><v>1</v></c></row>" * 200_000
    sheet = re.sub(rb"<dimension[^>]*>", b"", members(xlsx(tmp_path).read_bytes())[SHEET])
    path = _xlsx(tmp_path, lambda files: files | {SHEET: sheet.replace(b"</sheetData>", more + b"</sheetData>")})
    read: list[int] = []
    whole = xlsx_reader._Rows.read
    monkeypatch.setattr(xlsx_reader._Rows, "read", lambda self, size=-1: read.append(size) or whole(self, size))
    table = next(xlsx_reader.tables(path, Layout()))
    assert [column.name for column in table.columns] == ["time", "position", "force"]
    assert len(read) < 10


def test_a_document_of_as_many_keys_as_none_has_is_refused_at_once(tmp_path: Path) -> None:
    """As 16 s before the first of 200,000 keys was told."""
    path = tmp_path / "a.yaml"
    path.write_text("fric: plant/1\n" + "".join(f"k{n}: 1\n" for n in range(100_000)))
    begun = time.process_time()
    with pytest.raises(FricError, match="holds over"):
        read_document(path, PlantDocument)
    assert time.process_time() - begun < 5.0


@pytest.mark.parametrize("messages", [
    "create table messages as select 1 as id, 1 as topic_id, 1 as timestamp, zeroblob(8388608) as data",
    "create view messages as with recursive n(i) as (select 1 union all select i + 1 from n) "
    "select i as id, 1 as topic_id, i as timestamp, zeroblob(12) as data from n",
])  # fmt: skip
def test_a_message_of_a_database_of_gibibytes_and_one_that_does_not_end(
    tmp_path: Path, messages: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As 2.7 GB that took 3.7 GB of memory; with the bound brought down."""
    monkeypatch.setattr("fric.io.readers.rosbag.MOST_CHUNK", 1 << 20)
    with closing(sqlite3.connect(tmp_path / "a.db3")) as file, file:
        file.execute(
            "create table topics(id integer primary key, name, type, serialization_format, offered_qos_profiles)"
        )
        file.execute("create table schema(schema_version integer, ros_distro text)")
        file.execute("insert into topics values(1, '/a', 'std_msgs/msg/Float64', 'cdr', '')")
        file.execute("insert into schema values(3, 'humble')")
        file.execute(messages)
    refused(tmp_path / "a.db3", "damaged")
