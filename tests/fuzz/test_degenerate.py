"""Degenerate members of what comes from outside, in every command that takes them: a sentence, or what is plausible."""

import json
import shutil
from collections.abc import Iterator
from itertools import count
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from fric.documents.yaml import plain, read_tree
from tests.fuzz import structure
from tests.hostile.test_types import SPOILT, TIMES

SERIES = {how: spoil for how, spoil in (SPOILT | TIMES).items() if how not in {"objects", "lists"}}
"""What HDF5 and text can hold of what a series may be."""
VALUES: dict[str, Any] = {
    "none": None,
    "empty": [],
    "zero": 0,
    "negative": -1.0,
    "NaN": float("nan"),
    "infinite": float("inf"),
    "1e300": 1e300,
    "1e300 with a unit": "1e300 N",
    "text": "a",
    "an object": {"a": 1},
    "rank 2": [[1.0], [1.0]],
    "lone surrogate": "\ud800",
    "long": [1.0] * 300,
}
OF_SERIES = ("foreign", "records", *structure.OF_STEM.values(), "frequency-response", "circle", "run", "feedforward")
SECTIONS = [kind for kind in structure.COMMANDS if structure.COMMANDS[kind]]


@pytest.fixture(scope="module")
def known(tmp_path_factory: pytest.TempPathFactory) -> dict[str, list[Path]]:
    structure.ready()
    return structure.known_files(tmp_path_factory.mktemp("whole"))


def series_of(path: Path) -> list[str]:
    """Return the datasets of an HDF5 file, of one record, scheme and test alone."""
    names: list[str] = []
    with h5py.File(path) as file:
        file.visititems(lambda name, node: names.append(name) if getattr(node, "size", 0) else None)
    first = names[0].split("/")[:2]
    return [name for name in names if name.split("/")[:2] == first] if first[0] == "records" else names


def leaves(tree: Any, at: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Yield the places of a document's values, but not of what is only told."""
    for key, value in tree.items() if isinstance(tree, dict) else enumerate(tree[:2]):
        if key not in {"fric", "provenance", "warnings", "warnings_coded", "source", "ci95", "unit"}:
            yield from leaves(value, (*at, key)) if isinstance(value, dict | list) and value else [(*at, key)]


def spoilt(section: str, how: str, n: int, folder: Path, known: dict[str, list[Path]]) -> Path:
    """Write the n-th series or value of a type as a degenerate member."""
    if section == "foreign":
        t = np.arange(300) * 1e-3
        made: dict[str, Any] = {"time [s]": t, "position [mm]": np.sin(9 * t), "force [N]": np.cos(9 * t)}
        name = list(made)[n % 3]
        made[name] = SERIES[how](made[name]) if how != "complex" else made[name]
        structure.as_csv(folder / "input.csv", made, structure.Random(0))
        return folder / "input.csv"
    if how in SERIES:
        held = [*known["values"], *known["tests"], *known["run"], *known["feedforward"]]
        path = Path(shutil.copy(next((one for one in held if one.stem == section), held[0]), folder / "input.h5"))
        name = (names := series_of(path))[n % len(names)]
        with h5py.File(path, "a") as file:
            values, about = SERIES[how](file[name][()]), dict(file[name].attrs)
            del file[name]
            file[name] = values
            file[name].attrs.update(about)
        return path
    shutil.copytree(structure.ROOT / "configs", folder / "reality")
    (folder / "logs").mkdir()
    shutil.copy(structure.ROOT / "data/strokes/constant-velocity-01.csv", folder / "logs")
    source = next(one for one in reversed(known["yaml"]) if f"fric: {section}/" in one.read_text())
    tree = plain(read_tree(source))
    node, place = tree, (places := list(leaves(tree)))[n % len(places)]
    for key in place[:-1]:
        node = node[key]
    node[place[-1]] = VALUES[how]
    text = json.dumps(tree).replace("NaN", ".nan").replace("Infinity", ".inf")
    for path in (folder / "logs/fric-mapping.yaml", folder / "reality/input.yaml"):
        path.write_text(text)
    return path


def cases(section: str) -> list[tuple[str, str, int]]:
    """Return, of a type, each command with each degenerate member; which series or value is in turn."""
    hows = SERIES if section in OF_SERIES else VALUES
    turn = count()
    return [(line, how, next(turn)) for line in structure.COMMANDS[section] for how in hows]


def wrong(line: str, how: str, n: int, section: str, place: Path, known: dict[str, list[Path]]) -> list[str]:
    """Run a command on a degenerate member; return what must not be."""
    shutil.rmtree(place / "case", ignore_errors=True)
    (place / "case").mkdir()
    file = spoilt(section, how, n, place / "case", known)
    named = structure.named(known) | {"KIND": "motion"}
    what = structure.judged([named.get(word, word.replace("FILE", str(file))) for word in line.split()], place / "case")
    what = "" if what.startswith("silent") and "1e300 N" in what else what  # a title, which may be any text
    return [f"{line}, {how}, number {n}: {what}"] if what else []


def test_a_number_that_is_none_in_a_command_of_each_type(tmp_path: Path, known: dict[str, list[Path]]) -> None:
    found = []
    for section in ("foreign", "presliding-sine", "circle", "machine", "friction"):
        found += wrong(structure.COMMANDS[section][0], "NaN", 1, section, tmp_path, known)
    assert found == []


@pytest.mark.long(60)
@pytest.mark.parametrize("section", SECTIONS)
def test_every_degenerate_member_in_every_command(section: str, tmp_path: Path, known: dict[str, list[Path]]) -> None:
    assert [text for case in cases(section) for text in wrong(*case, section, tmp_path, known)] == []
