"""The walk-through of docs/new-model.md is true: its one file, of at most 60 lines, is found and passes unasked."""

import re
from pathlib import Path

import pytest

from fric.cli.identify.by_replay import models_in
from tests.new_file import place, python, shared_tests

ROOT = Path(__file__).parents[2]
FIT = """
import new_model_plugin
from fric.friction import models
from fric.identify.replay.replay_fit import identify_by_replay
from fric.identify.records.prepared import prepared
from tests.identify.virtual_logs import logs_of

truth = models()["bouc_wen"].typical()
fit = identify_by_replay("bouc_wen", prepared(logs_of(truth, 1)))
assert abs(fit.model.F_c / truth.F_c - 1) < 0.01 and abs(fit.model.k / truth.k - 1) < 0.01, fit.model
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


def test_it_is_fitted_as_any_other(folder, warm):
    python(warm, folder, FIT)
