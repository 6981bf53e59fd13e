"""What every reader is held to, without further work: how sure it is, and how it refuses what it cannot read."""

from contextlib import suppress

import numpy as np
import pytest

from fric.documents.mapping import Layout
from fric.errors import FricError
from fric.io import readers
from fric.io.readers import tables

READERS = {module.__name__.rpartition(".")[2]: module for module in readers._readers()}
HEADS = [b"", b"\0" * 64, b"time [s];position [mm]\n0;0\n", np.random.default_rng(1).bytes(4096)]


@pytest.mark.parametrize("name", READERS)
def test_it_says_what_it_reads(name):
    reader = READERS[name]
    assert reader.__doc__.partition("\n")[0].endswith(".")
    assert reader.FORMAT.name
    assert all(ending.startswith(".") for ending in reader.FORMAT.endings)
    assert bool(reader.FORMAT.module) == bool(reader.FORMAT.extra)


@pytest.mark.parametrize("name", READERS)
def test_it_is_sure_of_its_own_alone(name, tmp_path):
    """Between 0 and 1 of any bytes, and surer of none by its mark but of its own files."""
    for n, head in enumerate(HEADS):
        sure = READERS[name].recognises(tmp_path / f"file-{n}", head)
        assert 0 <= sure < 0.5 or (sure, name) == (1, "text")


@pytest.mark.parametrize("name", READERS)
def test_a_file_of_another_format_is_read_or_refused(name, tmp_path, monkeypatch):
    """Asked of a file of another format, as though it were surest: numbers, or an error that names the file."""
    monkeypatch.setattr(readers, "_readers", lambda: (Surest(READERS[name]),))
    for n, head in enumerate(HEADS[1:]):
        path = tmp_path / f"file-{n}{(*READERS[name].FORMAT.endings, '')[0]}"
        path.write_bytes(head)
        with suppress(FricError):
            for table in tables(path, Layout()):
                for block in table.read(range(len(table.columns))):
                    assert all(column.dtype == float for column in block.columns)


class Surest:
    def __init__(self, reader):
        self.tables = reader.tables

    def recognises(self, path, head):
        return 1.0
