"""JSON, XML, NumPy's files, Octave's text, lines ``t=1 pos=2``: arrays by name, or records of the same fields.

In XML a record is an element that is repeated, its fields are attributes or elements in it; or an element holds a list
of numbers, under its ``name`` and ``unit``. Structs in each other are named as in MATLAB's files.
"""

import json
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from functools import lru_cache
from itertools import groupby
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element

import numpy as np

from fric.arrays import Real
from fric.documents.mapping import Layout
from fric.errors import FricError
from fric.input import reading, regular
from fric.io.readers.base import ForeignTable, Format, begins_again, number, numbers, read_xml
from fric.io.readers.matlab import MOST_UNPACKED, tables_of
from fric.units import is_unit

FORMAT = Format("JSON, XML, NumPy, Octave text, name=value", (".json", ".jsonl", ".ndjson", ".xml", ".npz", ".npy"))
MOST_BYTES = 128 << 20  # Bytes of a file that are read at most: its values are held in memory as objects
MOST_DEPTH, LEAST = 12, 3  # Depth of structs at most, and rows of a table at least
LINES = 20  # Last lines of a head to look at, and rows that may be channels
_ROW = re.compile(rb"(?:-?\d+(?:\.\d*)?(?:[eE][+-]?\d+)?[\s,;|\[\]]+){7}-?\d")  # Eight numbers in a row
_FIELD, _NEXT = re.compile(rb":\s*-?\d"), re.compile(rb'\}\s*,?\s*\{|"0": ?[^,{]+, ?"1": ?')

_OCTAVE, _CODESYS = b"# Created by Octave", b"[key]; [value]"
_MATRIX = re.compile(r"# name: (.+)\n# type: (?:\w+ )?matrix\n# rows: .+\n# columns: ([1-9]\d{0,3})\n((?:[^#\n].*\n)*)")
_RANGE = re.compile(r"# name: (.+)\n# type: (?:double_)?range\n# base, limit, increment\n(\S+) (\S+) (\S+)\n")
_PAIR = re.compile(r"([A-Za-z_][\w.\[\]]{0,40})\s?[=:]\s?(-?\d+(?:\.\d*)?(?:[eE][+-]?\d+)?)(?![\w:.])")
_TOLD = re.compile(r"\s*((?:[A-Za-z_]\w*, ?)+[A-Za-z_]\w*) ?[=:] ?(-?\d[-+.\deE, ]*?)\s*")  # As ``pos,vel: 1.5, 0.2``
_PAIR_UNIT = re.compile(_PAIR.pattern + r" ?([A-Za-zµ°%][\w/²*]*)(?=[\s,;)]|$)(?!\s?[=:])")


NAME, UNIT = ("name", "label", "channel", "signal", "id"), ("unit", "units")  # Keys of a channel, in small letters


def _pairs(line: str) -> list[tuple[str, str]]:
    """Return the names and numbers of a line."""
    told = _TOLD.fullmatch(line)
    names, cells = (re.split(r", ?", part) for part in told.groups()) if told else ([], [])
    return [*zip(names, cells, strict=True)] if len(names) == len(cells) > 1 else _PAIR.findall(line)


_STAMP = re.compile(r"\W*(?:\d{4}-\d\d-\d\d[ T])?(\d\d?):(\d\d):(\d\d(?:[.,]\d+)?)\b(?!\s*[AP]M)")


def _stamp(line: str) -> dict[str, str]:
    """Return the time of the day [s] that a line begins with, as a serial monitor writes it."""
    found = _STAMP.match(line)
    seconds = (3600 * int(found[1]) + 60 * int(found[2]) + float(found[3].replace(",", "."))) if found else 0.0
    return {"clock time [s]": f"{seconds:.6f}"} if found else {}


def recognises(path: Path, head: bytes) -> float:
    """It is JSON or XML by its first letters, and has arrays or records of numbers."""
    if head.startswith((b"\x93NUMPY", _OCTAVE, _CODESYS)) or (head.startswith(b"PK") and b".npy" in head[:300]):
        return 1.0
    head = head.lstrip(b"\xef\xbb\xbf \r\n\t")
    found = bool(_ROW.search(head))
    if re.match(rb"<[?\w]", head) and (path.suffix.lower() == ".xml" or b"</" in head):
        tags = re.findall(rb"<(\w+)", head)
        return 0.6 * (found or any(tags.count(tag) >= LEAST for tag in {*tags}))
    long = found and len(head) > 2048 and b"\n" not in head[-2048:] and path.stat().st_size < MOST_BYTES
    if long and path.read_bytes().count(b"\n") <= LINES:
        return 0.6
    if re.match(rb"""\{|\[\s*[\[{"\d+-]""", head) and (found or (_FIELD.search(head) and _NEXT.search(head))):
        return 0.6  # no [HEADER] of a text
    rows = [len(_pairs(line)) for line in head.decode("utf-8", "replace").splitlines()[-LINES:-1]]
    return 0.6 * (len(rows) > LEAST and min(rows) > 1 and len({*rows}) == 1)


def tables(path: Path, layout: Layout) -> Iterator[ForeignTable]:
    """Read a file: a table, or one a record where structs have the same fields."""
    about = path.stat()
    with reading(path) as file:
        head = file.read(64).lstrip(b"\xef\xbb\xbf \r\n\t")
    if head.startswith((b"\x93NUMPY", b"PK")):
        found = _of_numpy(path)
    elif head.startswith(b"<"):
        found = _of_xml(read_xml(path, MOST_BYTES))
    else:
        found = _of_text(regular(path, MOST_BYTES), about.st_mtime_ns, about.st_size)
    yield from tables_of(path, _in_units(found) if isinstance(found, Mapping) else {"log": found})


def _in_units(found: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return columns under names with their units, where a struct ``units`` or ``unit_NAME`` beside them has these."""
    units = {name.removeprefix("unit_"): unit for name, unit in found.items() if name.startswith("unit_")}
    for name, held in found.items():
        units |= held if name.casefold() in {"unit", "units"} and isinstance(held, Mapping) else {}
    units = {name: unit for name, unit in units.items() if isinstance(unit, str) and unit}
    return {f"{name} [{units[name]}]" if name in units else name: values for name, values in found.items()}


def _of_numpy(path: Path) -> Any:
    """Return arrays by name, or an array; Python objects are left out, for to unpickle runs what a file holds."""
    found = dict[str, Any]()
    with reading(path) as file:
        if isinstance(held := np.load(file, allow_pickle=False), np.ndarray):
            return _fields(held)
        if (size := sum(member.file_size for member in held.zip.infolist())) > MOST_UNPACKED:
            raise FricError(f"unpacks to {size / 1e6:.0f} MB", hint="Save only what is needed of it.")
        for name in held.files:
            with suppress(ValueError):
                found[name] = _fields(held[name])
    return found


def _fields(values: Any) -> Any:
    """Return an array, a structured array as a struct, a matrix of one column or row as a vector, or its only value."""
    if values.dtype.names:
        return {name: _fields(values[name]) for name in values.dtype.names}
    plain = np.squeeze(values)
    return numbers(plain) if plain.ndim == 1 and plain.dtype.kind in "mM" else plain if plain.ndim else plain.item()


@lru_cache(maxsize=2)
def _of_text(path: Path, changed: int, size: int) -> Any:
    """Return what a text holds, read once while it is not changed: a log is looked at several times."""
    if (text := path.read_text(encoding="utf-8-sig", errors="replace")).startswith(_OCTAVE.decode()):
        return _of_octave(text)
    if text.startswith(_CODESYS.decode()):
        parts = re.split(r"(?m)^\d+\.Variable; *(.*?) *$", text)[1:]  # names, and samples below each
        cells = (re.findall(r"(?m)^; *([^;\s]+); *([^;\s]+)", part) for part in parts[1::2])
        data = (np.array([[*map(number, pair)] for pair in of]).reshape(-1, 2).T for of in cells)
        return {name: {"Name": name, "time": t, "value": y} for name, (t, y) in zip(parts[::2], data, strict=True)}
    if text.lstrip()[:1] not in "{[" and (long := _channels(text)):
        return long
    found = [_stamp(line) | dict(_pairs(line)) for line in (text.splitlines() if text.lstrip()[:1] != "{" else ())]
    if 2 * sum(len(row) > 1 for row in found) > len(found):
        last = next((line for line in reversed(text.splitlines()) if len(_pairs(line)) > 1), "")
        units = {f"unit_{name}": unit for name, _, unit in _PAIR_UNIT.findall(last) if is_unit(unit)}
        return units | _columns([row for row in found if len(row) > 1])
    try:
        return _columns(_of_pandas(json.loads(text)))
    except RecursionError:
        raise FricError("nests too deep", hint="Export arrays.") from None
    except ValueError as error:
        whole = error
    rows = []
    for n, line in enumerate(text.splitlines(), 1):
        try:
            rows += [json.loads(line)] if line.strip() else []
        except (ValueError, RecursionError):
            if n == 1 and b"\r" in (held := path.read_bytes()) and b"\n" not in held:
                raise FricError("its lines end in CR alone", hint="Save it again, with lines that end in LF.") from None
            if n == 1:
                named = text.lstrip()[:1] in {*"{["} or path.suffix.lower() in FORMAT.endings[:3]
                what = f"is no JSON ({whole})" if named else "has no rows of samples: each takes a line"
                raise FricError(what, hint="Export it again.") from None
            raise FricError("is no JSON, or cut off", where=f"{path}, line {n}", hint="Export it again.") from None
    return _columns(rows)


def _of_pandas(found: Any) -> Any:
    """Return what JSON holds; columns by name whose cells are by the number of the row, as pandas writes, as lists."""
    columns = [*found.values()] if isinstance(found, dict) else []
    if columns and all(isinstance(of, dict) and [*of][:2] == ["0", "1"] for of in columns):
        return {name: [*of.values()] for name, of in found.items()}
    return found


def _channels(text: str) -> Mapping[str, Any]:
    """Return channels that are a few long rows, as ``numpy.savetxt`` writes arrays, with names above; else none."""
    rows = [re.split(r"[\s,;]+", line.strip("#% \t,;")) for line in text.splitlines()[: LINES + 1]]
    long = [[*map(number, row)] for row in rows if len(row) > 8 * LINES]
    if len(long) < 2 or len({*map(len, long)}) > 1 or len(rows) > LINES:
        return {}
    names = next((row for row in rows if len(row) == len(long)), None)
    return dict(zip(names, np.array(long), strict=True)) if names else {"log": np.array(long)}


def _of_octave(text: str) -> Mapping[str, Any]:
    """Return the variables that ``save -text`` wrote: matrices, and ranges such as ``0:0.001:10``."""
    found = dict[str, Any]()
    for name, width, rows in _MATRIX.findall(text):
        values = np.array([number(cell) for cell in rows.split()])
        found[name] = _fields(values[: len(values) // int(width) * int(width)].reshape(-1, int(width)))
    most = max(map(np.size, found.values()), default=0)
    for name, *cells in _RANGE.findall(text)[:MOST_DEPTH]:
        first, last, step = map(number, cells)
        if step and 0 < (last - first) / step < most:  # no longer than what is beside it
            found[name] = first + step * np.arange(round((last - first) / step) + 1)
    return found


def _columns(value: Any, depth: int = 0) -> Any:
    """Return structs of arrays in place of lists of numbers and of records."""
    if isinstance(value, Mapping) and depth < MOST_DEPTH:
        return {str(name): _columns(part, depth + 1) for name, part in value.items()}
    if not isinstance(value, list) or not value:
        return value if isinstance(value, str | int | float) else None
    if isinstance(value[0], Mapping):
        if named := _named(value):
            return named
        flat = [dict(_leaves(item)) for item in value if isinstance(item, Mapping)]
        if len(flat) >= LEAST and any(number(item) == number(item) for item in flat[0].values()):
            names = dict.fromkeys(name for item in (flat[0], flat[-1]) for name in item)
            runs = _of_tests(flat, [*names])
            kept = [name for name in names if len(runs) == 1 or not isinstance(flat[0].get(name), str)]
            tests = [{name: _column([row.get(name) for row in run]) for name in kept} for run in runs]
            return tests if len(tests) > 1 else tests[0]
    if isinstance(value[0], list | Mapping):
        if len({len(row) if isinstance(row, list) else -1 for row in value}) == 1 and len(value) >= LEAST:
            rows = np.array([[number(cell) for cell in row] for row in value])
            return rows if np.isfinite(rows).any() else None
        return [_columns(part, depth + 1) for part in value]
    found = _column(value)
    return found if np.isfinite(found).any() else value if isinstance(value[0], str) else None


def _of_tests(rows: list[dict[str, Any]], names: Sequence[str]) -> list[list[dict[str, Any]]]:
    """Return the rows of each test that the only column of words names, where a clock begins again; else all."""
    words = [name for name in names if all(isinstance(row.get(name), str) for row in rows)]
    if len(words) != 1:
        return [rows]
    runs = [list(run) for _, run in groupby(rows, lambda row: row[words[0]])]
    named = len({run[0][words[0]] for run in runs}) == len(runs) and min(map(len, runs)) >= LEAST  # else a state
    first, last = ([np.array([number(run[at].get(of)) for of in names]) for run in runs] for at in (0, -1))
    return runs if named and begins_again([*zip(first, last, strict=True)]) else [rows]


def _named(items: Sequence[Any]) -> dict[str, Real]:
    """Return the columns of structs that each have a name, perhaps a unit, and a list of numbers; none of others."""
    found = dict[str, Real]()
    for item in items:
        parts = {key.casefold(): part for key, part in item.items()} if isinstance(item, Mapping) else {}
        lists = [part for part in parts.values() if isinstance(part, list) and len(part) >= LEAST]
        texts = [next((of for key in keys if isinstance(of := parts.get(key), str)), "") for keys in (NAME, UNIT)]
        name, unit = texts
        if len(lists) != 1 or not name or not np.isfinite(column := _column(lists[0])).any():
            return {}
        found[f"{name} [{unit}]" if unit else name] = column
    return found


def _column(values: Sequence[Any]) -> Real:
    """Return numbers, of dates in seconds."""
    found = np.array([number(item) for item in values])
    if not np.isfinite(found).any() and all(isinstance(item, str) for item in values):
        with suppress(ValueError):
            found = numbers(np.array([item.strip().removesuffix("Z") for item in values], "datetime64[ns]"))
    return found


def _leaves(record: Mapping[str, Any], before: str = "", depth: int = 0) -> Iterator[tuple[str, Any]]:
    """Yield the values of a record by their dotted names; those of short lists by their numbers."""
    for name, value in record.items():
        if isinstance(value, Mapping) and depth < MOST_DEPTH:
            yield from _leaves(value, f"{before}{name}.", depth + 1)
        elif isinstance(value, list):
            yield from ((f"{before}{name}{n}", item) for n, item in enumerate(value[:64], 1))
        else:
            yield f"{before}{name}", value


def _of_xml(root: Element) -> Mapping[str, Any]:
    """Return the records of the element that is repeated most, by what holds them; else elements with many numbers."""
    lists, signals = dict[str, Any](), dict[str, Any]()
    for n, element in enumerate(root.iter()):
        if (values := _list_in(element)) is not None:
            name, unit = element.get("name") or element.tag, element.get("unit")
            name = f"{name} {n}" if name in lists else name
            lists[f"{name} [{unit}]" if unit else name] = values
        parts = {e.tag.rpartition("}")[2]: (e.text or "") if (of := _list_in(e)) is None else of for e in element}
        if sum(isinstance(part, np.ndarray) for part in parts.values()) == 2:  # a signal with its clock
            signals[f"signal({n})"] = parts
    holders = [(holder, _records(holder)) for holder in root.iter()]
    most = max((len(rows) for _, rows in holders), default=0)
    if lists or most < LEAST:
        return signals if len(signals) > 1 else lists
    found = [_columns(rows) for _, rows in holders if len(rows) > most // 10 and len(rows) >= LEAST]
    about = {name: text for holder, _ in holders for name, text in holder.attrib.items() if name.startswith("unit_")}
    return found[0] | about if len(found) == 1 else {f"{root.tag}({n})": table for n, table in enumerate(found, 1)}


def _list_in(element: Element) -> Real | None:
    values = np.array([number(text) for text in re.split(r"[\s,;|]+", (element.text or "").strip())])
    return values if len(values) >= LEAST and np.isfinite(values).all() else None


def _records(holder: Element) -> Sequence[Mapping[str, Any]]:
    """Return the fields of the elements of one name in another, as far as they are all of it but a few."""
    tags = [row.tag for row in holder]
    tag = max(set(tags), key=tags.count, default="")
    rows = [  # an empty element has its values as attributes, as ``<AIPos A1="0.1" A2="0.2"/>``
        {**row.attrib, **{part.get("name") or part.tag: part.text for part in row if part.text or not part.attrib}}
        | {f"{part.tag} {name}": value for part in row if not part.text for name, value in part.items()}
        for row in holder.iter(tag)
    ]
    return rows if tags.count(tag) >= LEAST and len(rows) == tags.count(tag) and any(rows) else []
