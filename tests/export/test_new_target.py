"""The walk-through of docs/new-target.md is true: its one file is a target of Python and of the command."""

import json
import re

import numpy as np
import pytest

from tests.export.parts import scheme_part
from tests.new_file import place, python

FRIC = "import sys, new_target_plugin; from fric.cli.main import main; sys.exit(main())"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("target")
    place(folder, "new-target.md", "fric.export", "header.py", "new_target_plugin")
    return folder


def test_a_new_target_writes_its_files_and_a_manifest(folder, warm):
    words = [
        "export",
        "header",
        "configs/xy-table.yaml",
        "--axis",
        "x",
        "--scheme",
        "b",
        "-o",
        str(folder / "out"),
        "--force",
    ]
    python(warm, folder, FRIC, *words)
    written = json.loads((folder / "out/manifest.json").read_text())["files"]
    (name,) = written
    text = (folder / "out" / name).read_text()
    v, u = (
        np.array([float(x.rstrip("f")) for x in body.split(",")]) for body in re.findall(r"\{\s*([^}]*?)\s*\}", text)
    )
    belief = scheme_part("b")
    force = np.asarray(belief.model.steady_state(v[v != 0.0]))
    np.testing.assert_allclose(u[v != 0.0], belief.gain * force / belief.K_f, rtol=1e-4)
    np.testing.assert_allclose(u, -u[::-1], rtol=1e-6)
