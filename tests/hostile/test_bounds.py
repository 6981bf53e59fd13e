"""Sizes that SECURITY.md states are refused before anything is read; sparse files, archives of zeros cost nothing."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any
from zipfile import ZIP_DEFLATED, ZipFile

import h5py
import numpy as np
import pytest

import fric
from fric.automatic.sources import find_sources
from fric.contour import circularity
from fric.documents.controller import block_values
from fric.documents.machine_files import read_machine
from fric.documents.mapping import Layout
from fric.errors import FricError
from fric.io.hdf5 import read_records, write_logs
from fric.io.ingest import ingest
from fric.io.readers import sinumerik, xlsx
from fric.io.recognise import read_report
from fric.log import Log
from fric.results.base import in_si


def sparse(path: Path, size: int) -> Path:
    with path.open("wb") as file:
        file.truncate(size)
    return path


def test_a_report_of_more_than_32_mib(tmp_path: Path) -> None:
    with pytest.raises(FricError, match="are read at most"):
        read_report(sparse(tmp_path / "report.html", (32 << 20) + 1))


def test_a_trace_of_more_than_1_gib(tmp_path: Path) -> None:
    with pytest.raises(FricError, match="are read at most"):
        list(sinumerik.tables(sparse(tmp_path / "trace.xml", (1 << 30) + 1), Layout()))


def test_a_trace_with_entities(tmp_path: Path) -> None:
    path = tmp_path / "trace.xml"
    path.write_text(
        '<?xml version="1.0"?><!DOCTYPE a [<!ENTITY b "bbbb"><!ENTITY c "&b;&b;&b;">]>'
        '<traceData><dataSignal name="&c;"/></traceData>'
    )
    with pytest.raises(FricError, match="document type"):
        list(sinumerik.tables(path, Layout()))


@pytest.mark.parametrize(("name", "size"), [("xl/sharedStrings.xml", (64 << 20) + 1), ("xl/worksheets/sheet1.xml", 0)])
def test_a_workbook_that_unpacks_to_more_than_is_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, size: int
) -> None:
    if not size:  # four GiB of zeros take a while to pack
        assert xlsx.MOST_UNPACKED == 4 << 30
        monkeypatch.setattr(xlsx, "MOST_UNPACKED", 1 << 20)
    with ZipFile(tmp_path / "log.xlsx", "w", ZIP_DEFLATED, compresslevel=1) as archive:
        archive.writestr(name, bytes(size or (1 << 20) + 1))
    with pytest.raises(FricError, match="unpacks to more"):
        list(xlsx.tables(tmp_path / "log.xlsx", Layout()))


def test_a_channel_that_reaches_what_no_machine_does() -> None:
    t = np.arange(100) * 1e-3
    with pytest.raises(FricError, match="which no machine does"):
        Log(t, position=np.sin(t), force=np.where(t > 0.05, 1e13, 1.0))


def test_a_list_in_place_of_a_text_is_damage(tmp_path: Path) -> None:
    """HDF5 ends the process where the type of such a list is damaged (`log-601-381.h5` of the corpus)."""
    t = np.arange(400) * 1e-3
    path = tmp_path / "log.h5"
    for place, match in (("fric", "attribute 'fric' is neither a text"), ("list", "holds lists")):
        write_logs(path, [Log(time=t, position=t**2, name="a", source="a.csv", sha256="a" * 64)], force=True)
        with h5py.File(path, "a") as file:
            kind = h5py.vlen_dtype("f8")
            if place == "fric":
                made = np.empty(1, object)
                made[0] = t[:3]
                file.attrs.create(place, made, dtype=kind)
            else:
                file["records/a"].create_dataset(place, (2,), dtype=kind)
        with pytest.raises(FricError, match=match):
            read_records(path)


def test_a_heap_of_texts_that_does_not_end_is_damage(tmp_path: Path) -> None:
    """HDF5 goes round for ever in one whose free rest is said to be of no size (seeds 601 and 603 of the fuzz)."""
    path = tmp_path / "log.h5"
    t = np.arange(400) * 1e-3
    write_logs(path, [Log(time=t, position=t**2, name="a", source="a.csv", sha256="a" * 64)])
    whole = path.read_bytes()
    at = whole.index(b"GCOL") + 16
    path.write_bytes(whole[:at] + bytes(16) + whole[at + 16 :])
    with pytest.raises(FricError, match="texts in it have no end"):
        read_records(path)


def test_a_circle_too_fast_to_be_seen_is_refused() -> None:
    """As 0.1 mm at 500 mm/s at 4 kHz: no sample near a reversal."""
    angle = np.pi / 4 + np.linspace(0.0, 2 * np.pi, 5)
    with pytest.raises(FricError, match="5 samples, and none near one of its reversals"):
        circularity(np.cos(angle), np.sin(angle), 1.0)


def test_a_model_that_is_none_is_refused() -> None:
    with pytest.raises(FricError, match=r"no friction model '\[/\]'"):
        read_machine(Path(__file__).parents[2] / "configs" / "xy-table.yaml", friction_model="[/]")


@pytest.mark.parametrize(
    ("given", "dimension"),
    [
        ("1e300 N", "force"),
        ("1e12 N", "force"),
        ("1e300 N/V", "force per input"),
        (np.inf, "force"),
        ("nan N", "force"),
    ],
)
def test_an_option_that_no_machine_has_is_refused(given: str | float, dimension: str) -> None:
    """As an overflow of noise, and `array must not contain infs` of a force constant."""
    with pytest.raises(FricError):
        in_si(given, dimension)


def test_a_list_in_place_of_a_parameter_of_a_block() -> None:
    with pytest.raises(ValueError, match="a list of 2 where one value is expected"):
        block_values("kalman", {"cutoff": {"value": [1.0, 2.0], "unit": "Hz"}}, "linear", "x")


@pytest.mark.parametrize(
    ("verb", "given"),
    [
        (fric.circle_map, {"points": 10**9}),
        (fric.experiment, {"steps": 10**9}),
        (fric.compare, {"folds": 10**8}),
        (fric.experiment, {"seed": 10**24}),
    ],
)
def test_a_count_that_no_memory_holds_is_refused(verb: Callable[..., Any], given: dict[str, Any]) -> None:
    with pytest.raises(FricError, match=r" from \d+ to "):
        verb(Path("nothing"), **given)


@pytest.mark.parametrize("half", ["\\ud800", "\\ud83d\\ude00", "\\U0000DFFF"])
def test_half_of_a_character_is_no_name_of_a_file(tmp_path: Path, half: str) -> None:
    path = tmp_path / "machine.yaml"
    path.write_text(f'fric: machine/1\nlike: "{half}.yaml"\naxes: {{}}\n')
    with pytest.raises(FricError, match="half of a character"):
        read_machine(path)


def test_more_rows_than_a_log_file_has(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A packed text of 2·10⁸ rows took over a minute before its end said that it is none."""
    monkeypatch.setattr("fric.io.readers.base.MOST_ROWS", 100)
    (tmp_path / "a.csv").write_text("time [s],position [m]\n" + "".join(f"{n},{n % 7}\n" for n in range(101)))
    with pytest.raises(FricError, match="has over 100 rows"):
        ingest(tmp_path / "a.csv", tmp_path / "a.h5")


def test_more_files_than_are_logs_of_a_machine(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("fric.automatic.sources.MOST_MEMBERS", 3)
    for n in range(4):
        (tmp_path / f"{n}.csv").write_text("time [s],position [m]\n0,0\n")
    with pytest.raises(FricError, match="4 files may be logs"):
        find_sources([tmp_path])


def test_more_records_than_are_replayed() -> None:
    """A comparison of 2,000 logs took over two minutes of processor before it said anything."""
    time = np.arange(400) * 1e-3
    record = Log(time, position=1e-3 * np.sin(9 * time), force=np.cos(9 * time))
    with pytest.raises(FricError, match="201 records are given, and 200 at most are replayed"):
        fric.compare(*[record] * 201)
