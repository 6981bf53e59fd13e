"""What is in the files of a folder: records by axis and kind, foreign logs with the mapping that fits, circle tests."""

import re
import shlex
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from fric.documents.bundled import bundled
from fric.errors import FricError
from fric.flaws.files import FILE_COPIES, FILE_LEFT_OUT, MAPPING_AMBIGUOUS, MAPPING_BUNDLED, MAPPING_PROPOSED
from fric.input import regular
from fric.io.hdf5 import read_records
from fric.io.ingest_circle import ingest_circles
from fric.io.propose import sure_proposal
from fric.io.readers import endings
from fric.io.recognise import HDF5_SIGNATURE, recognise
from fric.log import Log, Record
from fric.notice import Notice
from fric.output import staged
from fric.records.inspection import inspect
from fric.results.ingest import ingest
from fric.units import Motion

PASSED_OVER = frozenset({".md", ".py", ".sh", ".png", ".svg", ".pdf", ".html", ".yaml", ".yml", ".json", ""})
"""Endings of what may lie beside logs, and is none."""


_PAPER = re.compile(
    r"(?:read[ _-]?me|licen[cs]e|copying|notes?|about|lies[ _-]?mich|changelog|citation)\b", re.IGNORECASE
)
"""Names of papers that lie beside logs."""


@dataclass(frozen=True)
class Source:
    """One file with records of one axis."""

    path: Path  # The file
    # axis, motion: of its records
    axis: str
    motion: Motion
    kinds: frozenset[str]  # The kind of each record, stated or recognised
    uses: frozenset[str]  # What its records are good for: ``static``, ``gms``, ``plant``
    # Mapping that tells its columns, by its name or file; empty where the header does, None for a log file of fric's
    mapping: str | None = None
    both: bool = False  # Whether every record has force and input: then it tells the force constant


@dataclass
class Sources:
    """All that was found."""

    logs: list[Source] = field(default_factory=list)  # Files with records
    circles: list[Path] = field(default_factory=list)  # Circle tests, and runs
    traces: list[Path] = field(default_factory=list)  # Foreign files with circle tests, which are to be ingested
    description: list[Notice] = field(default_factory=list)  # What was guessed, left out, or cannot be read
    copies: list[Path] = field(default_factory=list)  # Foreign files whose records another file holds already
    # Foreign files that are read with a bundled mapping, by its name
    guessed: dict[str, list[Path]] = field(default_factory=dict)
    refused: dict[str, list[Path]] = field(default_factory=dict)  # Foreign files that cannot be read, by what they lack
    # Mappings that were proposed for foreign files, with these: text of the mapping, its file, and what it is for
    proposed: dict[str, tuple[Path, list[Path]]] = field(default_factory=dict)


def find_sources(given: Iterable[Path], mapping: str | None = None, proposals: Path | None = None) -> Sources:
    """Look into files, and the files of folders.

    Parameters
    ----------
    given
        Files and folders.
    mapping
        What the columns of foreign logs mean. Where the header does not say it, it is the only bundled one that fits,
        or the one that `sure_proposal` makes.
    proposals
        Folder for mappings that are proposed; without it none is.

    Raises
    ------
    FricError
        When a file that is named is not there.
    """
    found, seen = Sources(), list[Record]()
    for path in _files(given):
        kind = _own(path)
        if kind in {"circle/1", "run/1"}:
            found.circles.append(path)
        elif kind == "log/1":
            records = read_records(path)
            seen += records
            found.logs.append(_source(path, records, None))
        elif kind is None and path.suffix.lower() in endings():
            _foreign(path, mapping, proposals, found, seen)
    if found.copies:
        found.description.append(FILE_COPIES.found(files=_first(found.copies)))
    papers = [path for files in found.refused.values() for path in files if _is_paper(path)]
    for why, refused in found.refused.items():
        files = [path for path in refused if path not in papers]
        if not files:
            continue
        propose = shlex.join(["fric", "ingest", str(files[0]), "--propose", "map.yaml"])
        propose = propose if "column" in why else ""
        found.description.append(FILE_LEFT_OUT.found(_first(files), why=why, propose=propose))
    for name, files in found.guessed.items():
        found.description.append(MAPPING_BUNDLED.found(mapping=name, files=_first(files)))
    for mapped, (file, files) in found.proposed.items():
        columns = re.findall(r"^  (\w+): {column: (.*?), unit", mapped, re.MULTILINE)
        means = ", ".join(f"{channel} is {column}" for channel, column in columns)
        found.description.append(MAPPING_PROPOSED.found(mapping=str(file), columns=means, files=_first(files)))
    return found


def _is_paper(path: Path) -> bool:
    """Say whether a file that is no log is there to be read by people, by its name."""
    return bool(_PAPER.match(path.name)) and path.suffix.lower() in {".txt", ".md", ".rst", ".log", ".dat"}


def _first(files: list[Path]) -> str:
    return f"{files[0]}" + (f" and {len(files) - 1} more" if len(files) > 1 else "")


def _files(given: Iterable[Path]) -> Iterator[Path]:
    """Yield the files, log files of fric's first: a foreign copy of a record is then known."""
    files: list[Path] = []
    for path in given:
        inside = sorted(one for one in path.rglob("*") if one.is_file()) if path.is_dir() else [regular(path)]
        files += [one for one in inside if one.suffix.lower() not in PASSED_OVER]
    yield from sorted(dict.fromkeys(files), key=lambda path: (path.suffix.lower() not in {".h5", ".hdf5"}, str(path)))


def _own(path: Path) -> str | None:
    """Return what a file of fric's says that it is; None for a foreign one."""
    with path.open("rb") as file:
        if not file.read(8).startswith(HDF5_SIGNATURE):
            return None
    try:
        return recognise(path)
    except FricError:
        return None


def _source(path: Path, records: list[Record], mapping: str | None) -> Source:
    inspected = [inspect(record) for record in records]
    uses = frozenset(use.purpose for one in inspected for use in one.uses if use.good)
    kinds = frozenset(str(one.kind) for one in inspected)
    both = all(isinstance(one, Log) and one.force is not None and one.input is not None for one in records)
    return Source(path, records[0].axis, records[0].motion, kinds, uses, mapping, both)


def _foreign(path: Path, mapping: str | None, proposals: Path | None, found: Sources, seen: list[Record]) -> None:
    """Read a foreign log by its header, by a mapping that was given, is bundled, or must be; or a circle test."""
    fitting: dict[str, list[Record]] = {}
    with TemporaryDirectory() as folder:
        draft, text = Path(folder), None

        def fit(chosen: str) -> str:
            """Return why a mapping does not fit; nothing where it does."""
            log = draft / f"{len(list(draft.iterdir()))}.h5"
            try:
                ingest(path, output=log, mapping=chosen or None)
                fitting[chosen] = read_records(log)
            except FricError as error:
                return error.what
            return ""

        why = fit(mapping or "")
        if why and not mapping:  # the header does not say it
            if _is_circle(path, draft / "circle.h5"):
                found.traces.append(path)
                return
            for one in bundled("mapping"):
                fit(one)
            if proposals and not fitting and (text := _proposed(path)):
                file, _ = found.proposed.get(
                    _settings(text), (proposals / f"proposed-{len(found.proposed) + 1}.yaml", [])
                )
                proposals.mkdir(parents=True, exist_ok=True)
                with staged(file, force=True) as whole:
                    whole.write_text(text, encoding="utf-8")
                why = fit(str(file))
    if len(fitting) != 1:
        if fitting:
            found.description.append(MAPPING_AMBIGUOUS.found(str(path), mappings=list(fitting)))
        else:
            found.refused.setdefault(why, []).append(path)
        return
    ((chosen, records),) = fitting.items()
    if any(_same(record, known) for record in records for known in seen):
        found.copies.append(path)
        return
    if text:
        found.proposed.setdefault(_settings(text), (Path(chosen), []))[1].append(path)
    elif chosen and not mapping:
        found.guessed.setdefault(chosen, []).append(path)
    seen += records
    found.logs.append(_source(path, records, chosen))


def _proposed(path: Path) -> str | None:
    try:
        return sure_proposal(path)
    except FricError:
        return None


def _settings(text: str) -> str:
    """Return a proposal without its comments, which name the file."""
    return "\n".join(line.split("  #")[0].rstrip() for line in text.splitlines() if not line.startswith("#"))


def _is_circle(path: Path, draft: Path) -> bool:
    try:
        ingest_circles(path, draft)
    except FricError:
        return False
    return True


def _same(one: Record, other: Record) -> bool:
    """Tell whether two records hold the same samples, to the digits of a text."""
    if not (isinstance(one, Log) and isinstance(other, Log)) or len(one) != len(other):
        return False
    a, b = one.channels(), other.channels()
    return all(
        np.allclose(a[name], b[name], rtol=1e-4, atol=1e-4 * float(np.abs(b[name]).max()))
        for name in a.keys() & b.keys()
    )
