"""The walk-through of docs/new-model.md is true: its one file, of at most 60 lines, is found and passes unasked."""

import json
import re
from pathlib import Path

import pytest

from docs.examples import environment
from fric.cli.commands import models_in
from fric.friction.base import Parametrised
from tests.new_file import place, python, shared_tests

ROOT = Path(__file__).parents[2]
FRIC = "import sys, new_model_plugin; from fric.cli.main import main; sys.exit(main())"
LOGS = """
import sys, new_model_plugin
from fric.friction import models
from fric.io.hdf5 import write_logs
from tests.identify.virtual_logs import logs_of
from pathlib import Path

truth = models()["bouc_wen"].typical()
write_logs(Path(sys.argv[1]), logs_of(truth, 1))
print(truth.F_c, truth.k)
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("model")
    place(folder, "new-model.md", "fric.friction", "bouc_wen.py", "new_model_plugin")
    return folder


def test_it_takes_at_most_60_lines(folder):
    assert len((folder / "bouc_wen.py").read_text().splitlines()) <= 60


def test_the_command_line_finds_it(folder):
    assert models_in(folder)["bouc_wen"].startswith("The Bouc-Wen model")


def test_it_passes_the_shared_tests_unasked(folder, warm):
    told = shared_tests(warm, folder, "new_model_plugin", "tests/friction", "-k", "bouc_wen")
    assert int(re.search(r"(\d+) passed", told)[1]) > 20
    assert "failed" not in told


def test_command_schema_and_report_find_it(folder, warm):
    log, found, page = (str(folder / name) for name in ("log.h5", "friction.yaml", "report.html"))
    F_c, k = map(float, python(warm, folder, LOGS, log).split())
    cold = environment()  # the commands of `fric identify` are those of the models that are there when it is imported
    told = json.loads(python(cold, folder, FRIC, "identify", "bouc_wen", log, "-o", found, "--json"))
    assert told["bouc_wen"]["F_c"]["value"] == pytest.approx(F_c, rel=0.01)
    assert told["bouc_wen"]["k"]["value"] == pytest.approx(k, rel=0.01)
    schema = json.loads(python(warm, folder, FRIC, "schema", "friction"))
    assert {"bouc_wen", "bouc_wen_fit"} <= schema["properties"].keys()
    python(warm, folder, FRIC, "report", found, log, "-o", page)
    assert "Bouc_wen <code>friction.yaml</code>" in (folder / "report.html").read_text()


def test_a_file_with_a_table_of_parameters_is_refused_by_its_name():
    with pytest.raises(TypeError, match="Old: annotate fields with their Parameter"):
        type("Old", (Parametrised,), {"name": "old", "parameters": ()})
