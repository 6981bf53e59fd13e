"""The walk-through of docs/new-verb.md is true: its one file is a verb of Python and a command with help."""

import json

import pytest

from docs.examples import environment
from tests.new_file import place, python

FRIC = "import sys, new_verb_plugin; from fric.cli.main import main; sys.exit(main())"
LOG = "data/constant-velocity.h5"
IN_PYTHON = f"""
import json, new_verb_plugin, fric
found = fric.travel({LOG!r}, above=0.02)
try:
    fric.travel({LOG!r}, above=None)
except fric.FricError as error:
    print(json.dumps([found.document["travel"], str(error)]))
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("verb")
    place(folder, "new-verb.md", "fric.results", "travel.py", "new_verb_plugin")
    return folder


def test_python_and_command_find_it(folder, warm):
    by_name, refused = json.loads(python(warm, folder, IN_PYTHON))
    assert refused == "travel takes above as a number or a text, and was given None"
    cold = environment()  # the commands are those of the verbs that are there when they are imported
    told = json.loads(python(cold, folder, FRIC, "travel", LOG, "--above", "20 mm/s", "--json"))
    assert told["travel"] == by_name
    assert all(0 < one["travel"] < 10 for one in by_name.values() if one["time"])
    assert any(one["time"] > 0.1 for one in by_name.values())
    text = " ".join(python(cold, folder, FRIC, "travel", "-h").split())
    assert "Tell how far an axis travelled" in text
    assert "--above SPEED Speed from which on it moves. [default: 0.1 mm/s]" in text
