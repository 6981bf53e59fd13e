"""A compiled function is read from its cache, and never when a file that it is made of has changed."""

import ast
import importlib
import inspect
import os
import subprocess
import sys
from pathlib import Path

import pytest
from numba import types
from numba.core.dispatcher import Dispatcher

from docs.examples import environment
from fric.kernels.signatures import _sources, compiled
from tests.warm import modules

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
BEFORE = "import sys; sys.dont_write_bytecode = True; "
"""Python takes a file of the same second and length for unchanged: here two edits may follow within a second."""
WITHOUT = "import fric.kernels.signatures as s; s._link_runtime = lambda: s.moved; "
"""As another version of Numba may be: what is reached into is not there."""
CALL = "import numpy as np; from model import step; e = np.zeros(0); " + (
    "print(step(0.0, 1.0, 0.0, e, e), sum(step.stats.cache_hits.values()))"
)


def _run(environment: dict[str, str], folder: Path, level: float, model: float, before: str = "") -> tuple[float, bool]:
    for name, text in (("level", LEVEL.format(factor=level)), ("model", MODEL.format(factor=model))):
        path = folder / f"{name}.py"
        if not path.exists() or path.read_text() != text:
            path.write_text(text)
    path = {"PYTHONPATH": os.pathsep.join([str(folder), *sys.path])}
    out = subprocess.run(
        ["python", "-c", BEFORE + before + CALL],
        env=environment,
        cwd=folder,
        check=True,
        capture_output=True,
        text=True,
    )
    value, hits = out.stdout.split()
    return float(value), int(hits) > 0


def test_cache_is_warm_in_a_new_process_and_sees_every_edit(tmp_path: Path, warm: dict[str, str]) -> None:
    assert _run(warm, tmp_path, level=2.0, model=3.0) == (6.0, False)
    assert _run(environment(), tmp_path, level=2.0, model=3.0) == (6.0, True)  # a process that nothing has warmed
    assert _run(warm, tmp_path, level=2.0, model=5.0) == (10.0, False)
    assert _run(warm, tmp_path, level=7.0, model=5.0) == (35.0, False)  # the step's own file is untouched
    assert _run(warm, tmp_path, level=7.0, model=5.0, before=WITHOUT) == (35.0, True)  # by Numba's own way


def test_a_user_without_a_folder_for_the_cache_computes_all_the_same(monkeypatch):
    """A service has no home, and fric was installed by another user: Numba finds no place for its cache."""

    def refuse(self: Dispatcher) -> None:
        raise RuntimeError("cannot cache function: no locator available")

    monkeypatch.setattr(Dispatcher, "enable_caching", refuse)
    assert compiled(types.float64(types.float64))(lambda v: 2.0 * v)(3.0) == 6.0


@pytest.mark.long(2)
def test_the_file_of_every_number_that_is_compiled_in_is_watched():
    """An index of a signal that had moved would be read, and written, at its old place."""
    taken = set()
    for module in map(importlib.import_module, modules()):
        tree = ast.parse(inspect.getsource(module))
        homes = {
            name.asname or name.name: node.module
            for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) and node.module for name in node.names
        }  # fmt: skip
        for made in vars(module).values():
            if isinstance(made, Dispatcher) and made.py_func.__module__ == module.__name__:
                for name in made.py_func.__code__.co_names:
                    if isinstance(made.py_func.__globals__.get(name), int | float) and name in homes:
                        home = importlib.import_module(homes[name])
                        if home.__name__.startswith("fric."):
                            taken.add((module.__name__, name))
                            assert home.__file__ in _sources(made.py_func), (module.__name__, name, home.__name__)
    assert ("fric.kernels.loop", "FRICTION") in taken
