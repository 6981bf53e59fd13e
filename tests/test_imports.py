"""Modules import one way: no two of them need each other, not for a type alone either."""

from __future__ import annotations

import re
from collections import Counter
from graphlib import CycleError, TopologicalSorter
from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules

import grimp

import benchmarks

ROOT = Path(__file__).parents[1]


def circle_in(graph: grimp.ImportGraph) -> list[str]:
    """Return the modules of one import circle; none where there is none."""
    needed = {module: graph.find_modules_directly_imported_by(module) for module in graph.modules}
    try:
        TopologicalSorter(needed).prepare()
    except CycleError as error:
        return list(error.args[1])
    return []


def test_no_import_circle() -> None:
    graph = grimp.build_graph("fric", cache_dir=None)
    assert len(graph.modules) > 200
    assert circle_in(graph) == []


def test_a_circle_is_seen() -> None:
    graph = grimp.ImportGraph()
    for importer, imported in (("a", "b"), ("b", "c"), ("c", "a"), ("a", "d")):
        graph.add_import(importer=importer, imported=imported)
    assert set(circle_in(graph)) == {"a", "b", "c"}


def test_no_two_classes_share_a_name() -> None:
    files = (ROOT / "src/fric").rglob("*.py")
    names = Counter(
        name for file in files for name in re.findall(r"^class (\w+)", file.read_text("utf-8"), re.MULTILINE)
    )
    assert [name for name, count in names.items() if count > 1] == []


def test_contributing_names_every_room() -> None:
    """A room that is new has a row in CONTRIBUTING.md, and one that is gone has none."""
    text = (ROOT / "CONTRIBUTING.md").read_text()
    table = text.partition("| room | content |")[2].partition("\n\n")[0]
    cells = " ".join(line.split("|")[1] for line in table.splitlines() if line.count("|") > 2)
    rooms = {room.strip("/") for room in re.findall(r"`([a-z_/]+)`", cells)}
    there = {
        path.stem for path in (ROOT / "src/fric").iterdir() if path.suffix == ".py" or (path / "__init__.py").exists()
    }
    assert rooms == there - {"__init__", "__main__"}


def test_every_benchmark_finds_what_it_imports() -> None:
    """Type checks and other tests do not reach them: one imported a name that had moved for weeks."""
    for module in iter_modules(benchmarks.__path__, "benchmarks."):
        import_module(module.name)
