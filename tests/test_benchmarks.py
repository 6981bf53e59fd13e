"""Benchmarks call what there is: a call that no longer fits a signature is found before an hour of measuring."""

from __future__ import annotations

import ast
import importlib
import inspect
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
FILES = sorted(path for path in (ROOT / "benchmarks").rglob("*.py") if path.stem != "__main__")


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(ROOT)))
def test_each_call_of_fric_fits_its_signature(path: Path) -> None:
    module = importlib.import_module(".".join(path.relative_to(ROOT).with_suffix("").parts))
    for call in ast.walk(ast.parse(path.read_text())):
        named = call.func.id if isinstance(call, ast.Call) and isinstance(call.func, ast.Name) else ""
        called = getattr(module, named, None)
        if not isinstance(call, ast.Call) or not callable(called) or not str(called.__module__).startswith("fric"):
            continue
        spread = any(isinstance(arg, ast.Starred) for arg in call.args) or None in {one.arg for one in call.keywords}
        signature = inspect.signature(called)
        bind = signature.bind_partial if spread else signature.bind
        bind(
            *(arg for arg in call.args if not isinstance(arg, ast.Starred)),
            **{one.arg: one for one in call.keywords if one.arg},
        )
