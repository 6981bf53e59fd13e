"""The virtual rig, everything identified from its own noisy logs and nothing given: what `make rig` prints."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


@pytest.mark.long
def test_what_is_identified_and_designed_from_the_rig_s_logs_keeps_the_paper_s_order(tmp_path: Path) -> None:
    words = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    environment = os.environ | {"PATH": words, "PYTHONPATH": str(ROOT / "src")}
    subprocess.run(["sh", ROOT / "data/rig.sh", tmp_path], check=True, capture_output=True, env=environment)
    told = json.loads((tmp_path / "circle.json").read_text())["schemes"]
    left = {name: found["glitch"] for name, found in told.items()}
    assert left["a"] > left["d"]
    assert left["b"] > left["c"] >= left["f"]
    assert left["e"] >= left["f"]
    assert left["f"] < 0.2 * left["a"]


def test_the_script_gives_nothing_of_the_truth() -> None:
    """Only the machine itself knows it: no command but the simulated ones reads the machine file."""
    reads = [line for line in (ROOT / "data/rig.sh").read_text().splitlines() if "$rig" in line]
    assert len(reads) == 3
    assert all("fric simulate" in line for line in reads)
