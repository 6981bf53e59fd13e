"""The theory page names files, functions and tests that exist."""

from __future__ import annotations

import re
from functools import reduce
from importlib import import_module
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "docs/theory.md").read_text()
NAMED = [
    (path, name)
    for path, names in re.findall(r"`([\w/]+\.py)`:\s+((?:`[\w.]+`(?:,\s+)?)+)", PAGE)
    for name in re.findall(r"`([\w.]+)`", names)
]


def test_every_file_on_the_page_is_followed_by_a_name():
    assert len(re.findall(r"`[\w/]+\.py`", PAGE)) == len(re.findall(r"`[\w/]+\.py`:\s+`", PAGE))
    assert len(NAMED) > 40


@pytest.mark.parametrize(("path", "name"), NAMED, ids=["-".join(pair) for pair in NAMED])
def test_what_the_page_names_exists(path, name):
    if path.startswith("tests/"):
        assert f"def {name}(" in (ROOT / path).read_text()
    else:
        module = import_module("fric." + path.removesuffix(".py").replace("/", "."))
        assert Path(str(module.__file__)) == ROOT / "src/fric" / path
        reduce(getattr, name.split("."), module)


def test_every_equation_of_the_paper_has_its_place():
    rows = dict(re.findall(r"^\| \((\d)\) \| [^|]* \| (.*) \|$", PAGE, flags=re.MULTILINE))
    assert sorted(rows) == list("12345678")
    assert all("`" in row for row in rows.values())
