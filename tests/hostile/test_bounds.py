"""Sizes that SECURITY.md states are refused before anything is read; sparse files, archives of zeros cost nothing."""

from __future__ import annotations

from pathlib import Path
from zipfile import ZIP_DEFLATED, ZipFile

import numpy as np
import pytest

from fric.documents.mapping import Layout
from fric.errors import FricError
from fric.io.readers import sinumerik, xlsx
from fric.io.report import read_report
from fric.log import Log


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
        assert xlsx.MOST == 4 << 30
        monkeypatch.setattr(xlsx, "MOST", 1 << 20)
    with ZipFile(tmp_path / "log.xlsx", "w", ZIP_DEFLATED, compresslevel=1) as archive:
        archive.writestr(name, bytes(size or (1 << 20) + 1))
    with pytest.raises(FricError, match="unpacks to more"):
        list(xlsx.tables(tmp_path / "log.xlsx", Layout()))


def test_a_channel_that_reaches_what_no_machine_does() -> None:
    t = np.arange(100) * 1e-3
    log = Log(t, position=np.sin(t), force=np.where(t > 0.05, 1e13, 1.0))
    with pytest.raises(FricError, match="which no machine does"):
        log.require("force", "a map")
