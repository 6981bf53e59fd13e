"""The tests' other settings: they are what they say, each comes in its turn, and a moved last bit arrives in a run."""

from __future__ import annotations

import json
import os
import platform
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import fric
from docs import examples
from fric.kernels import loop
from tests import legs, nudge

SHOW = """
import json, os
import numpy as np, threadpoolctl
from numba import config
blas = {one["architecture"] for one in threadpoolctl.threadpool_info() if one["user_api"] == "blas"}
found = np.show_config(mode="dicts")["SIMD Extensions"].get("found", [])
print(json.dumps([sorted(blas), found, config.CPU_NAME, config.CPU_FEATURES, float(np.exp(1.0)).hex()]))
"""


@pytest.mark.skipif(platform.machine() != "x86_64", reason="names processors of x86-64")
def test_settings_of_a_processor_are_taken_by_the_libraries() -> None:
    environment = os.environ | legs.processor("sandybridge")
    done = subprocess.run([sys.executable, "-c", SHOW], env=environment, capture_output=True, text=True, check=True)
    blas, found, name, features, _ = json.loads(done.stdout)
    assert (blas, name, features) == (["Sandybridge"], "sandybridge", "")
    assert not {"AVX2", "FMA3", "X86_V3", "X86_V4"}.intersection(found)
    assert set(legs.numpys(0).split()) >= set(legs.numpys(1).split()) >= set(legs.numpys(2).split())
    assert "AVX512F" in legs.processor("avx2")["GLIBC_TUNABLES"]
    assert "AVX2" not in legs.processor("avx2")["GLIBC_TUNABLES"].split("-")


SESSION = """
fric identify plant data/frequency-response.h5 -o plant.yaml
fric identify static data/constant-velocity.h5 --plant plant.yaml -o static.yaml
fric identify gms data/presliding-sine.h5 data/sliding-sine.h5 --static static.yaml --plant plant.yaml -o friction.yaml
fric simulate circle xy-table
fric simulate circle xy-table --velocity "10 mm/s"
fric simulate circle virtual-rig
fric simulate circle virtual-rig --velocity "10 mm/s"
fric simulate circle xy-table --scheme f -o fast.h5
fric simulate circle xy-table --scheme f --velocity "10 mm/s" -o slow.h5
fric tune xy-table fast.h5 slow.h5 -o tuned
fric learn xy-table --rounds 2 -o table.h5
fric plan friction.yaml --machine xy-table -o next
fric auto data/strokes -o found
"""


@pytest.mark.long(600)
@pytest.mark.skipif(platform.machine() != "x86_64", reason="names processors of x86-64")
def test_what_commands_print_is_the_same_on_every_processor(tmp_path: Path) -> None:
    """To the last digit: tables, warnings and their codes, each processor with what it compiles itself."""
    shown: dict[str, list[tuple[str, int, str]]] = {}
    for name in ("native", *legs.PROCESSORS):
        (tmp_path / name).mkdir()
        environment = examples.environment() | (legs.processor(name) if name != "native" else {})
        commands = SESSION.strip().splitlines()
        shown[name] = [(one, *examples.run(one, tmp_path / name, environment)) for one in commands]
    for command, status, printed in shown["native"]:
        assert status == 0, f"$ {command}\n{printed}"
    for name, found in shown.items():
        assert found == shown["native"], name


def test_what_is_lacking_is_said_and_what_fails_fails() -> None:
    def lacks() -> None:
        legs.interpreter("2.99")

    def fails() -> None:
        subprocess.run([sys.executable, "-c", "raise SystemExit(3)"], check=True)

    told = legs.run({"a": lacks, "b": fails, "c": lambda: None})
    assert told["a"] == "skipped: this computer does not have Python 2.99"
    assert told["b"].startswith("FAILED")
    assert told["b"].endswith("ended with 3")
    assert told["c"] == "passed"


def test_a_nudge_moves_the_last_bits_of_a_run_and_no_more(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    def position() -> np.ndarray:
        return fric.circle("xy-table", "a", axis="x").runs[0].traces["x"].position

    monkeypatch.setattr(loop, "_closed_loop", loop._closed_loop)
    before = position()
    monkeypatch.setenv("FRIC_NUDGE", "5")
    nudge.nudge()
    moved = np.abs(position() - before).max()
    assert 0.0 < moved < 1e-6  # a few counts at most
