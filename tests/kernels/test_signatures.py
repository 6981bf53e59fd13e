"""A compiled function is read from its cache, and never when a file that it is made of has changed."""

import os
import subprocess
import sys
from pathlib import Path

LEVEL = """
from numba import types
from fric.kernels.signatures import compiled

@compiled(types.float64(types.float64))
def level(v):
    return {factor} * v
"""
MODEL = """
from fric.kernels.signatures import compiled_step
from level import level

@compiled_step
def step(dz, v, dt, state, parameters):
    return {factor} * level(v)
"""
CALL = "import numpy as np; from model import step; e = np.zeros(0); " + (
    "print(step(0.0, 1.0, 0.0, e, e), sum(step.stats.cache_hits.values()))"
)


def _run(folder: Path, level: float, model: float) -> tuple[float, bool]:
    for name, text in (("level", LEVEL.format(factor=level)), ("model", MODEL.format(factor=model))):
        path = folder / f"{name}.py"
        if not path.exists() or path.read_text() != text:
            path.write_text(text)
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(folder), *sys.path])}
    out = subprocess.run(
        [sys.executable, "-c", CALL], env=environment, cwd=folder, check=True, capture_output=True, text=True
    )
    value, hits = out.stdout.split()
    return float(value), int(hits) > 0


def test_cache_is_warm_in_a_new_process_and_sees_every_edit(tmp_path: Path) -> None:
    assert _run(tmp_path, level=2.0, model=3.0) == (6.0, False)
    assert _run(tmp_path, level=2.0, model=3.0) == (6.0, True)
    assert _run(tmp_path, level=2.0, model=5.0) == (10.0, False)
    assert _run(tmp_path, level=7.0, model=5.0) == (35.0, False)  # the step's own file is untouched
