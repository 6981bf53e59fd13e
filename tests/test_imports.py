"""Modules import one way: no two of them need each other, not for a type alone either."""

from __future__ import annotations

from graphlib import CycleError, TopologicalSorter

import grimp


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
