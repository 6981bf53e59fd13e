"""MATLAB files: v5 through SciPy, v7.3 (which is HDF5) through h5py. Structs are taken apart to ``a.b(2).c``."""

import io
import pickle
import re
import struct
import sys
import zlib
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from fric.documents.mapping import Layout
from fric.errors import FricError, printable
from fric.io.readers.base import OF_SEVERAL, RECORD, Column, ForeignTable, Format, Memory, named, whole_stamps
from fric.io.readers.text import OF_UNITS, remarked
from fric.io.safe_hdf5 import members, open_file, text
from fric.io.words import axis_of, spoken
from fric.process import run_python
from fric.units import is_unit

_V73 = b"MATLAB 7.3 MAT-file"
MOST_DEPTH, MOST_PARTS = 16, 20_000  # Most levels and parts of nested structs and cells: references can repeat one
MOST_TEXT = 10_000  # Letters of a text at most
_READ = """
import pickle, sys
from scipy.io import loadmat
out, sys.stdout = sys.stdout.buffer, sys.stderr
try:
    found = loadmat(sys.argv[1], simplify_cells=True, mat_dtype=True)
except BaseException as error:
    found = f"{error}"
pickle.dump(found, out, protocol=5)
"""

FORMAT = Format("MATLAB", (".mat",))
MOST_UNPACKED, PACKED = 512 << 20, 15  # Bytes that a MATLAB 5 file unpacks to at most; type of a packed element
MOST_COLUMNS = 200  # Columns that a matrix has at most, where it is longer than wide
SHORT = 30  # Samples that a record has at least, where lengths part records
_AXIS = re.compile(  # The name of a struct of an axis
    r"(?i)(.+\.)?(?P<name>((axis|axe|achse|asse|eje)_?)?(?P<letter>[xyzabcuvw])|(axis|axe|achse|asse|eje|joint)_?\d+|"
    r"(axis|axes?|achsen?|ass[ei]|ejes?|joints?)\((?P<number>\d+)\))"
)
_VALUES, _UNIT = ("values", "value", "data", "signal", "yvalue"), ("unit", "units", "units_of_measure")
_TIMES = ("time", "t", "timestamps", "timestamp", "xvalue")
_OF_CELL = re.compile(r"(.+?\(\d+\))\.(.+)")  # A field of an element of a struct array
_OF_STRUCT = re.compile(r"(.+)\.([^.()]+\(:,\d+\)(?: \[[^\[\]]*\])?)")  # A column of a matrix in a struct
_PARTED = re.compile(  # A name as `_take_apart` makes it: a field of a struct, or a column of a matrix
    r"(?P<struct>.+)\.(?P<field>(?:[^.()\[\]]|\[[^\[\]]*\])+)|(?P<matrix>.+)\(:,(?P<line>\d+)\)(?P<unit> \[[^\[\]]*\])?"
)


def recognises(path: Path, head: bytes) -> float:
    """Both versions have a signature in their first bytes; version 4 only its ending."""
    return 1.0 if head.startswith((b"MATLAB 5.0 MAT-file", _V73)) else 0.5 * (path.suffix.lower() == ".mat")


def tables(path: Path, layout: Layout) -> Iterator[ForeignTable]:
    """Read a MATLAB file: its vectors, and the columns of its matrices, are one table; scalars are constants."""
    with path.open("rb") as file:
        new = file.read(len(_V73)) == _V73
    if not new:
        kept, about = (_KEPT if _unpacked(path) < KEPT else _load), path.stat()
        yield from tables_of(path, kept(path, about.st_mtime_ns, about.st_size))
        return
    with open_file(path, "is not a complete MATLAB file (cut short?)", "Save it again.", most=sys.maxsize) as source:
        yield from tables_in(path, source)


def tables_in(path: Path, source: h5py.File) -> Iterator[ForeignTable]:
    """Read the groups and datasets of an open HDF5 file, as those of MATLAB 7.3."""
    left = iter(range(MOST_PARTS))
    nodes = [(name, node) for name, node in members(source) if not name.startswith("#")]
    variables = {_with_unit(name, node): _tree(node, source, left) for name, node in nodes}
    yield from tables_of(path, _said(source) | variables)


def _unpacked(path: Path) -> int:
    """Return to what the variables of a MATLAB 5 file say that they unpack [byte], at most `MOST_UNPACKED`."""
    with path.open("rb") as file:
        order = "<" if (head := file.read(128))[126:] == b"IM" else ">"
        declared = 0
        while head[124:126] in {b"\0\1", b"\1\0"} and len(tag := file.read(8)) == 8:
            kind, stored = struct.unpack(f"{order}II", tag)
            first = file.read(min(stored, 64))
            if kind != PACKED:
                declared += stored
            else:
                with suppress(zlib.error):  # which SciPy reports
                    first = zlib.decompressobj().decompress(first, 8)
                declared += int.from_bytes(first[4:8], "little" if order == "<" else "big")
            file.seek(max(stored - 64, 0), io.SEEK_CUR)
    if declared > MOST_UNPACKED:
        what = f"unpacks to {declared / 1e6:.0f} MB, and {MOST_UNPACKED / 1e6:.0f} MB are read at most"
        raise FricError(what, hint="Save it with -v7.3, or only what is needed of it.")
    return declared


@lru_cache(maxsize=2)
def _load(path: Path, changed: int, size: int) -> dict[str, Any]:
    """Return what SciPy reads, in another process: a damaged file can crash its reader, and not each time."""
    done = run_python(_READ, str(path))
    try:
        found: dict[str, Any] | str = _Values(io.BytesIO(done.stdout)).load()
    except (EOFError, pickle.UnpicklingError):
        found = "it ends the program that reads it"
    if isinstance(found, str):
        raise FricError(f"is not a complete MATLAB file ({found})", hint="Save it again, with -v7 or -v7.3.")
    return {name: value for name, value in found.items() if not name.startswith("__")}


KEPT = 4_000_000  # Size unpacked [byte] of the files that are kept, a folder of which is read several times
_KEPT = lru_cache(maxsize=64)(_load.__wrapped__)


class _Values(pickle.Unpickler):
    """Takes arrays and what SciPy makes of objects, and calls nothing else: who read may have been misled."""

    def find_class(self, module: str, name: str) -> Any:
        """Return a class that makes values; raise `pickle.UnpicklingError` for any other."""
        makes = name in {"_reconstruct", "_frombuffer", "ndarray", "dtype", "scalar"}
        if not ((module.startswith("numpy") and makes) or module == "scipy.io.matlab._mio5_params"):
            raise pickle.UnpicklingError(f"{module}.{name} is no value")
        return super().find_class(module, name)


@dataclass(frozen=True)
class _DatasetLine:
    """One line of a dataset of v7.3, which stores matrices transposed: read when it is sliced."""

    data: Any
    at: int
    along: int = 1

    def __len__(self) -> int:
        return int(self.data.shape[self.along])

    def __getitem__(self, part: slice) -> Any:
        if self.data.ndim == 1:
            return self.data[part]
        return self.data[self.at, part] if self.along else self.data[part, self.at]


def _tree(node: Any, file: h5py.File, left: Iterator[int], depth: int = 0) -> Any:
    """Return a group, a dataset or a reference of v7.3 as dicts, lists, lines and scalars; ``left`` counts parts."""
    if depth > MOST_DEPTH or next(left, None) is None:
        what = f"nests deeper than {MOST_DEPTH}, in a circle, or into over {MOST_PARTS} parts"
        raise FricError(what, where=file.filename, hint="Save arrays.")
    if isinstance(node, h5py.Group):
        fields = {_with_unit(name, child): _tree(child, file, left, depth + 1) for name, child in members(node)}
        lists = [value for value in fields.values() if isinstance(value, list)]
        if lists and len(lists) == len(fields) and len({len(value) for value in lists}) == 1:  # a struct array
            return [dict(zip(fields, values, strict=True)) for values in zip(*lists, strict=True)]
        return _said(node) | fields
    if not isinstance(node, h5py.Dataset) or node.shape is None:
        return None
    if node.dtype == h5py.ref_dtype:
        return [_tree(file[reference], file, left, depth + 1) for reference in np.ravel(node[()], order="F")]
    if node.attrs.get("MATLAB_class") == b"char" and node.dtype.kind == "u" and node.size < MOST_TEXT:
        letters = () if "MATLAB_empty" in node.attrs else np.ravel(node[()], order="F")
        return "".join(chr(letter) for letter in letters if letter < 0xD800)
    if node.dtype.kind not in "fiub" or "MATLAB_empty" in node.attrs:
        return None
    if node.size == 1:
        return float(node[()].item())
    if node.ndim == 1 or (node.ndim == 2 and node.shape[1] == 1):
        return _DatasetLine(node, 0, along=0)
    if node.ndim == 3 and 1 in node.shape:  # a row or a column an instant
        return np.squeeze(node[()])
    if node.ndim != 2:
        return None
    flat = _lies(*node.shape)
    lines = [_DatasetLine(node, n, along=int(not flat)) for n in range(node.shape[flat])]
    titles = (np.ravel(values) for _, values in members(node.attrs) if np.size(values) == len(lines) > 1)
    named_so = next((found for found in titles if found.dtype.kind in "OSU"), None)  # an attribute names the columns
    if named_so is None:
        return lines
    names = [
        printable(title.decode(errors="replace") if isinstance(title, bytes) else str(title)) for title in named_so
    ]
    return _said(node) | dict(zip(names, lines, strict=True)) if len({*names}) == len(names) else lines


def _said(node: Any) -> dict[str, Any]:
    """Return the numbers and texts that are attributes of a group, as its sampling rate."""
    of_format = ("MATLAB", "H5PATH", "CLASS", "TITLE", "VERSION")
    said = {name: value for name, value in members(node.attrs) if not name.startswith(of_format) and name not in _UNIT}
    texts = {name: text(node.attrs, name) for name, value in said.items() if isinstance(value, str | bytes)}
    numbers = {name: float(np.ravel(value)[0]) for name, value in said.items()
               if np.size(value) == 1 and getattr(value, "dtype", np.dtype("O")).kind in "fiu"}  # fmt: skip
    return texts | numbers


def _with_unit(name: str, node: Any) -> str:
    """Return the name of a dataset with the unit that is its attribute."""
    unit = next((text(node.attrs, key) for key in _UNIT if isinstance(node, h5py.Dataset) and key in node.attrs), "")
    return f"{name} [{unit}]" if unit else name


def _lies(columns: int, rows: int) -> bool:
    """Return whether the rows of a matrix are signals: no log has so many columns and so few rows."""
    return columns > max(MOST_COLUMNS, 4 * rows)


def tables_of(path: Path, variables: Mapping[str, Any]) -> Iterator[ForeignTable]:
    """Yield the tables of variables: one, or one a record where structs, cells or matrices have the same columns."""
    columns: dict[str, Any] = {}
    constants: dict[str, str] = {}
    apart: dict[str, dict[str, Any]] = {}
    for name, value in _titled(variables).items():
        _take_apart(name, value, columns, constants)
        _take_apart(name, value, apart.setdefault(name, {}), {})
    if max(Counter(key for of in apart.values() for key in of if key != "time").values(), default=0) > 1:
        keys = ((name, key, values) for name, of in apart.items() for key, values in of.items())
        columns = {key if f"{key}.".startswith(f"{name}.") else f"{name}.{key}": of for name, key, of in keys}
    if not columns:
        hint = "Objects such as timeseries and timetable are not read: save their arrays."
        raise FricError("holds no vector of numbers", hint=hint)
    names = [*columns]
    stamped = whole_stamps([*map(Column, names)], [*columns.values()].__getitem__, range(len(names)))
    columns = dict(zip(names, stamped, strict=True))
    records = _records(columns)
    found = {name: match for name in records if (match := _AXIS.fullmatch(name) or _AXIS.fullmatch(name.split(".")[0]))}
    axes = {name: (match["letter"] or match["number"] or match["name"]).lower() for name, match in found.items()}
    said_of = {name: [said for at, said in constants.items() if at.startswith(f"{name}.")] for name in records}
    axes |= {name: axis for name, texts in said_of.items() if name and (axis := axis_of(*texts))}
    axes = axes if len({*axes.values()}) > 1 and len(axes) == len(records) else {}
    for name, fields in records.items():
        titles: Sequence[Column] = [*map(named, fields)]
        said = {"name": f"{path.stem}-{name}", RECORD: name} if len(records) > 1 else {}
        said |= {"axis": axes[name], OF_SEVERAL: " ".join(dict.fromkeys(axes.values()))} if axes else {}
        own = {key.removeprefix(f"{name}."): text for key, text in constants.items() if key.startswith(f"{name}.")}
        others = tuple(f"{other}." for other in records if other != name)
        shared = {key: text for key, text in constants.items() if not key.startswith(others)}
        said_beside = [f"# {text}" for pair in (own | shared).items() for text in (pair[1], ": ".join(pair))]
        titles = remarked(titles, said_beside, ())
        yield Memory(path, titles, list(fields.values()), own | shared, said)


def _records(columns: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """Return the columns of each record, the longest first; of all in one where nothing parts them.

    Structs or cells with the same fields are records, and so are matrices with as many columns; a variable beside them
    with their length, as a time, belongs to each. Else columns of one length are a record.
    """
    cells: dict[str, dict[str, Any]] = {}
    for name, values in columns.items():
        if found := _OF_CELL.fullmatch(name) or _OF_STRUCT.fullmatch(name):
            cells.setdefault(found[1], {})[found[2]] = values
    alike = len({frozenset(fields) for fields in cells.values()}) == 1
    even = all(len(fields) > 1 and len({*map(len, fields.values())}) == 1 for fields in cells.values())
    if len(cells) > 1 and alike and even:
        rest = {k: v for k, v in columns.items() if not (_OF_CELL.fullmatch(k) or _OF_STRUCT.fullmatch(k))}
        own = {n: {k: v for k, v in rest.items() if k.rpartition(".")[0] not in cells.keys() - {n}} for n in cells}
        return {name: _beside(fields, own[name]) | fields for name, fields in cells.items()}  # each is an experiment
    groups: dict[str, dict[str, Any]] = {}
    matrices = set[str]()
    for name, values in columns.items():
        found = _PARTED.fullmatch(name)
        prefix, leaf = (found["struct"] or found["matrix"], found["field"]) if found else ("", name)
        leaf = leaf if found is None or leaf else f"column {int(found['line']) - 1}{found['unit'] or ''}"
        groups.setdefault(prefix, {})[leaf] = values
        matrices |= {prefix} if found and found["matrix"] else set()
    fields = Counter(frozenset(group) for name, group in groups.items() if name and len(group) > 1)
    common, count = fields.most_common(1)[0] if fields else (frozenset(), 0)
    same = {name for name, group in groups.items() if name and group.keys() == common}
    of_alike = {len(values) for name in same for values in groups[name].values()}
    beside = {len(values) for name in groups.keys() - same for values in groups[name].values()}
    shown = [spoken(Column(name)).quantity for name in same]  # position, velocity, torque: a column a joint
    parts = None not in shown and len({*shown}) == len(shown)
    joints = matrices >= same and len(of_alike) == 1 and (of_alike <= beside or parts)
    if count > 1 and not joints:  # matrices of equal length on a common time are channels of several axes
        records = {}
        for name, group in groups.items():
            if name and group.keys() == common:
                above = [of.items() for at, of in groups.items() if name.startswith(f"{at}.") or not at]
                records[name] = _beside(group, {k: v for of in above for k, v in of}) | group
            elif name and {*map(len, group.values())}.isdisjoint(of_alike) and _is_record(group):
                records[name] = group  # of other columns, as a circle beside strokes
        longest = {name: -len(next(iter(group.values()))) for name, group in records.items()}
        return dict(sorted(records.items(), key=lambda pair: (pair[0] not in same, longest[pair[0]])))
    lengths: dict[int, dict[str, Any]] = {}
    for name, values in columns.items():
        lengths.setdefault(len(values), {})[name] = values
    whole = {n: names for n, names in lengths.items() if len(names) > 1 and n > SHORT}
    return {str(n): whole[n] for n in sorted(whole, reverse=True)} if len(whole) > 1 else {"": dict(columns)}


def _is_record(fields: Mapping[str, Any]) -> bool:
    """Return whether columns are a record: of one length, with a time, or with positions among other columns."""
    lengths, shown = {*map(len, fields.values())}, {spoken(Column(name)).quantity for name in fields}
    return len(lengths) == 1 and max(lengths) > SHORT and ("time" in shown or ("position" in shown and len(fields) > 2))


def _beside(fields: Mapping[str, Any], others: Mapping[str, Any]) -> dict[str, Any]:
    """Return those of other columns, as a time, that have the length of a record."""
    n = len(next(iter(fields.values())))
    return {name.rpartition(".")[2]: values for name, values in others.items() if len(values) == n}


def _titled(variables: Mapping[str, Any]) -> dict[str, Any]:
    """Return variables with matrices as structs, where lists of texts beside them name their columns and units."""
    texts = {
        bool(OF_UNITS.search(name)): [*map(str, value)] for name, value in variables.items()
        if isinstance(value, list | np.ndarray) and len(value) > 1 and all(isinstance(text, str) for text in value)
    }  # fmt: skip
    names, units = texts.get(False, []), texts.get(True, [])

    def titled(value: Any) -> Any:
        if not (lines := _lines_of(value)) and isinstance(value, list | np.ndarray) and any(map(_lines_of, value)):
            return [titled(matrix) for matrix in value]  # matrices in cells
        if not names or len({*names}) != len(lines):
            return value
        of_names = units if len(units) == len(names) else [""] * len(names)
        heads = [f"{name} [{unit}]" if is_unit(unit) else name for name, unit in zip(names, of_names, strict=True)]
        return dict(zip(heads, lines, strict=True))

    return {name: titled(value) for name, value in variables.items()}


def _lines_of(value: Any) -> list[Any]:
    """Return the columns of a matrix; none of any other value."""
    if isinstance(value, np.ndarray) and value.ndim == 2 and value.dtype.kind in "fiub":
        return [*(value if _lies(*value.shape[::-1]) else value.T)]
    return value if isinstance(value, list) and all(isinstance(line, _DatasetLine) for line in value) else []


def _signal(value: Mapping[str, Any]) -> tuple[Any, Mapping[str, Any]] | None:
    """Return the time of a struct that is a signal, and its values by names beside them; None of any other struct."""
    keys = {key.casefold(): key for key in value}
    at, of = (next((keys[key] for key in known if key in keys), "") for known in (_TIMES, _VALUES))
    time: Any = value.get(at)
    beside = _titled({key: part for key, part in value.items() if key != at})
    content = beside.pop(of, None)
    lines = content if isinstance(content, Mapping) else {of: content}
    whole = _is_vector(time) and all(_is_vector(line) and len(line) == len(time) for line in lines.values())
    return (time, lines) if whole and not any(_is_vector(p) and len(p) == len(time) for p in beside.values()) else None


def _is_vector(value: Any) -> bool:
    array = isinstance(value, np.ndarray) and value.ndim == 1 and value.dtype.kind in "fiub"
    return (array or isinstance(value, _DatasetLine)) and len(value) > 1


def _take_apart(name: str, value: Any, columns: dict[str, Any], constants: dict[str, str]) -> None:
    """Sort a variable into columns and constants."""
    if isinstance(value, Mapping):
        fields = {key.casefold(): key for key in value}
        data, unit = (next((value[fields[key]] for key in keys if key in fields), None) for keys in (_VALUES, _UNIT))
        label, unit = (text if isinstance(text, str) else "" for text in (value.get("Name", value.get("label")), unit))
        of = f" [{unit}]" if unit else ""
        if (signal := _signal(value)) is not None:
            time, content = signal
            known = [other for key, other in columns.items() if key.endswith("time") and len(other) == len(time)]
            if not any(np.array_equal(time[:], other[:]) for other in known):
                columns[f"{name}.time" if known or "time" in columns else "time"] = time
            ends = {key: f".{key}{of}" if len(content) > 1 else of for key in content}
            head = label or name.rpartition(".")[2]
            head = name if any(head + end in columns for end in ends.values()) else head
            columns |= {head + ends[key]: line for key, line in content.items()}
            return
        if data is not None and (label or (unit and len(value) == 2)):
            column = named(label) if label else Column(name)  # as dSPACE and Simulink write signals
            of = f" [{column.unit}]" if column.unit else of
            _take_apart(f"{column.name}{of}" if of else label or name, data, columns, constants)
            return
        lines = [key for key, child in value.items() if _is_vector(child)]
        for key, child in _titled(value).items():  # a unit beside it is its own, or of the only signal
            of = value.get(f"{key}_unit", value.get(f"{key}_units", unit if lines == [key] else ""))
            stated = isinstance(of, str) and key in lines and is_unit(of)
            _take_apart(f"{name}.{key} [{of}]" if stated else f"{name}.{key}", child, columns, constants)
    elif isinstance(value, str):
        constants[name] = value
    elif _is_vector(value):
        columns[name] = value
    elif lines := _lines_of(value):
        alone = isinstance(value, list) and len(lines) == 1
        head, of, unit = name.rpartition(" [") if name.endswith("]") else (name, "", "")
        for n, line in enumerate(lines, 1):
            _take_apart(name if alone else f"{head}(:,{n}){of}{unit}", line, columns, constants)
    elif isinstance(value, list) or (isinstance(value, np.ndarray) and value.dtype == object):
        for n, child in enumerate(value, 1):
            _take_apart(f"{name}({n})", child, columns, constants)
    elif isinstance(value, int | float | np.integer | np.floating):
        constants[name] = repr(float(value))
