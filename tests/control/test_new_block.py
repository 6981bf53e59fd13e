"""The walk-through of docs/new-block.md is true: its one file is seen by command, schema, runs, report and tests."""

import json
import re
from pathlib import Path

import pytest

from tests.new_file import place, python, shared_tests

ROOT = Path(__file__).parents[2]
FRIC = "import sys, new_block_plugin; from fric.cli.main import main; sys.exit(main())"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("block")
    page = place(folder, "new-block.md", "fric.control", "smooth_sign.py", "new_block_plugin")
    (schemes,) = re.findall(r"^```yaml\n(.*?)^```", page, re.MULTILINE | re.DOTALL)
    (folder / "schemes.yaml").write_text(schemes)
    return folder


def test_command_simulation_schema_and_report_find_it(folder, warm):
    assert re.search(
        r"smooth-sign  feedforward, not linear; asks for: the velocity of the ref",
        python(warm, folder, FRIC, "design", "block", "list"),
    )
    schema = json.loads(python(warm, folder, FRIC, "schema", "block"))
    assert "smooth-sign" in schema["properties"]["block"]["enum"]
    (part,) = [one["then"] for one in schema["allOf"] if one["if"]["properties"]["block"]["const"] == "smooth-sign"]
    assert set(part["properties"]["parameters"]["properties"]) == {"level", "width"}
    machine = folder / "machine.yaml"
    given = (ROOT / "configs/xy-table.yaml").read_text()
    machine.write_text(given.replace("    encoder:\n", "    blocks: {smooth-sign: {level: 140 mV}}\n    encoder:\n"))
    words = ["simulate", "circle", str(machine), "--schemes", str(folder / "schemes.yaml")]
    told = json.loads(python(warm, folder, FRIC, *words, "-o", str(folder / "run.h5"), "--json"))
    bare, sign = (told["schemes"][name]["glitch"] for name in ("a", "sign"))
    assert sign < 0.7 * bare
    python(warm, folder, FRIC, "report", str(folder / "run.h5"), "-o", str(folder / "report.html"))
    page = (folder / "report.html").read_text()
    assert "smooth-sign" in page
    assert "the velocity of the reference alone" in page


def test_it_passes_the_shared_tests_unasked(folder, warm):
    told = shared_tests(
        warm, folder, "new_block_plugin", str(ROOT / "tests/control/test_properties.py"), "-k", "smooth-sign"
    )
    assert int(re.search(r"(\d+) passed", told)[1]) >= 3
    assert "failed" not in told
