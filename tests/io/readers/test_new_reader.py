"""A reader is one new file, whatever its name: command, schema, report and the shared tests of readers find it."""

import json
import re
from pathlib import Path

import pytest

from fric.documents.listings import FormatsDocument
from fric.io.hdf5 import read_records
from tests.new_file import python, shared_tests
from tests.turns import in_turns

ROOT = Path(__file__).parents[3]
FRIC = "import sys, new_reader_plugin; from fric.cli.main import main; sys.exit(main())"
READER = '''
"""A format of this test alone: a mark, a number of samples, and a line of numbers for each."""
import numpy as np
from fric.io.readers.base import Column, Format, Memory

FORMAT = Format("Own", (".own",))

def recognises(path, head):
    return float(head.startswith(b"OWN-FORMAT"))

def tables(path, layout):
    n = int(path.read_text().split()[1])
    t = np.arange(n) * 1e-3
    yield Memory(path, (Column("time", "s"), Column("position", "m")), [t, np.sin(t)])
'''


@pytest.mark.parametrize("name", in_turns(["aaa", "zzz"], ["zzz"]))
def test_command_schema_report_and_shared_tests_find_it(tmp_path, warm, name):
    """The surest reader is asked: text would take any file without a zero byte."""
    (tmp_path / f"{name}.py").write_text(READER)
    plugin = f"import fric.io.readers\n\nfric.io.readers.__path__.append({str(tmp_path)!r})\n"
    (tmp_path / "new_reader_plugin.py").write_text(plugin)
    (tmp_path / "own.csv").write_text("OWN-FORMAT 500\n1,2\n")
    log, page = tmp_path / "log.h5", tmp_path / "report.html"
    told = json.loads(python(warm, tmp_path, FRIC, "ingest", str(tmp_path / "own.csv"), "-o", str(log), "--json"))
    assert (told["samples"], len(read_records(log)[0])) == (500, 500)
    listed = json.loads(python(warm, tmp_path, FRIC, "ingest", "--list", "--json"))
    FormatsDocument.model_validate(listed)  # of `fric schema formats`
    assert ["Own", [".own"]] in [[one["name"], one["endings"]] for one in listed["formats"]]
    friction = str(ROOT / "tests/documents/before/static.yaml")
    python(warm, tmp_path, FRIC, "report", friction, str(log), "-o", str(page))
    assert "log.h5" in page.read_text()
    if name == "zzz":
        return
    words = ["tests/io/readers/test_every_reader.py", "-k", name]
    assert int(re.search(r"(\d+) passed", shared_tests(warm, tmp_path, "new_reader_plugin", *words))[1]) >= 3
