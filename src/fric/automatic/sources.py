"""What is in the files of a folder: records by axis and kind, foreign logs with the mapping that fits, circle tests."""

import re
import shlex
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, closing
from dataclasses import dataclass, field, replace
from filecmp import cmp
from functools import partial
from math import inf
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, TypeVar
from zipfile import ZipFile

import numpy as np

from fric.columns import PRESLIDING, Kind
from fric.documents.bundled import bundled
from fric.documents.controller import ControllerDocument
from fric.documents.yaml import read_document
from fric.errors import FricError
from fric.flaws.files import COLUMNS_LEFT_OUT as LEFT_OUT
from fric.flaws.files import (
    FILE_COPIES,
    FILE_LEFT_OUT,
    FOLDERS_TOGETHER,
    FORCE_BY_FILE,
    MAPPING_AMBIGUOUS,
    MAPPING_BESIDE,
    MAPPING_BUNDLED,
)
from fric.input import foreign, reading, regular
from fric.io.circle import choose_circles
from fric.io.hdf5 import read_records
from fric.io.ingest import OPPOSES, Signs
from fric.io.ingest import ingest as read_foreign
from fric.io.ingest_circle import StatedCircle, circle_plan, holds_circle, ingest_circles, part_of
from fric.io.pairs import with_joined
from fric.io.propose import (
    AT_REST,
    JOINED,
    NO_FORCE,
    NO_POSITION,
    Guess,
    Guessed,
    axes_said,
    first_of,
    guessed,
    says_all,
)
from fric.io.questions import Ask, answered, axes_mapped, beside
from fric.io.readers import endings, marked, tables
from fric.io.readers.base import RECORD
from fric.io.recognise import is_hdf5, recognise
from fric.io.words import axis_of_file
from fric.log import Log, Record
from fric.notice import Notice
from fric.output import folder_made, written
from fric.process import tried as say_step
from fric.records.flaws import blocks_lost, evened, two_encoders
from fric.records.holding import holds, is_holding_map
from fric.records.inspection import Inspection, ResponseInspection, TableInspection, excites, inspect, is_at_rest
from fric.records.modes import switched
from fric.records.resolution import STUCK
from fric.records.segments import travelled
from fric.results.base import in_one_mode
from fric.results.ingest import holds_circles, mapping_of
from fric.units import Motion, rotates

ARCHIVES = frozenset({".zip", ".7z", ".rar", ".tar", ".tgz", ".bz2", ".xz"})  # Endings of archives
PACKED = "it is an archive, which is not read: unpack it beside it"
MOST_UNPACKED, MOST_RATIO, SMALL = 1 << 30, 200, 64 << 20  # Most bytes of a ZIP; of a member: times stored, or anyhow
MOST_MEMBERS = 2000  # Files of folders, and those that a ZIP unpacks to, at most
SHOWS = {**dict.fromkeys([*PRESLIDING, "sliding-sine"], "gms"), "constant-velocity": "static"}
"""The use of records of each kind, as `fric.inspect` names it."""
MOTION = "motion"  # Use of records of any kind whose motion determines mass, viscous and Coulomb friction
PASSED_OVER = frozenset({".md", ".py", ".sh", ".png", ".svg", ".pdf", ".html", ".yaml", ".yml", ".json", ".m"})
"""Endings of files beside logs that are not logs themselves, unless they begin with the signature of a format."""

_PAPER = re.compile(  # Names of documentation files beside logs
    r"(?:read[ _-]?me|licen[cs]e|copying|notes?|about|lies[ _-]?mich|changelog|citation)\b", re.IGNORECASE
)

ON_CIRCLES = 0.5  # Share of a file on whole circles above which it is a circle test, and no log besides
MOST_BESIDE = 8  # Files whose headers say their units for files beside them, at most
MOST_ALIKE = 3  # Files of the same names in several folders, from which it is said that their records are pooled
BROKEN = "samples are missing: the position jumps along with its reference"
LEAVES_OUT = "`assume=True` leaves such samples out"  # What opens a log with bad cells
TURNED = "the force counts the other way than in other files"
BY_SIGNS = "by these signs"  # In why logs are refused whose force or velocity seems turned
T = TypeVar("T")
LACKS_FORCE = "no column is named force"  # Why a complete header needs a question: another column looks like it


@dataclass(frozen=True)
class Source:
    """One file with records of one axis."""

    path: Path  # The file
    axis: str  # axis, motion: of its records
    motion: Motion
    kinds: frozenset[str]  # The kind of each record, stated or recognised
    uses: frozenset[str]  # Uses of its records: ``static``, ``gms``, ``plant``
    mapping: str | None = None  # Its mapping, by name or file; empty where its header is one, None for a log of fric
    both: bool = False  # Whether every record has force and input: then it determines the force constant
    driven: bool = False  # Whether every record has an input
    strokes: int = 0  # How many segments at constant velocity, or means of such, its records have
    wide: bool = False  # Whether its mapping has parts, of which this axis is chosen by name
    assumed: bool = False  # Whether samples that cannot be used are dropped
    loaded: bool = False  # Whether a record has the position of the load, by a second encoder
    lacks: str = ""  # Why its records show no friction
    unfit: str = ""  # Why a record does not show what its kind is for
    in_volts: frozenset[str] = frozenset()  # Uses of its records where their voltage is the effort
    uneven: str = ""  # Why a motion that excites the mass shows no plant
    efforts: frozenset[str] = frozenset()  # Those of force and input that a record of it has
    rates: tuple[float, ...] = ()  # Rates of its records whose input changes at nearly every sample [Hz]


@dataclass
class Sources:
    """Everything that was found."""

    logs: list[Source] = field(default_factory=list)  # Files with records
    circles: list[Path] = field(default_factory=list)  # Circle tests, and runs of one scheme
    controllers: dict[str, Path] = field(default_factory=dict)  # Files with the gains of a controller, by axis
    traces: dict[Path, str] = field(default_factory=dict)  # Foreign circle tests, and their mappings; empty without
    description: list[Notice] = field(default_factory=list)  # What was guessed, left out, or cannot be read
    copies: list[Path] = field(default_factory=list)  # Files whose records another file holds already
    guessed: dict[str, list[Path]] = field(default_factory=dict)  # Foreign files of bundled mappings, by their names
    beside: dict[str, list[Path]] = field(default_factory=dict)  # Those with a mapping beside them, by its file
    refused: dict[str, list[Path]] = field(default_factory=dict)  # Foreign files that cannot be read, by reason
    open: Guessed = field(default_factory=lambda: Guessed(()))  # What is open of foreign files


def find_sources(
    given: Iterable[Path],
    mappings: Sequence[str] = (),
    proposals: Path | None = None,
    *,
    assume: bool = False,
    ask: Ask | None = None,
) -> Sources:
    """Inspect files, and the files of folders.

    mappings: What the columns of foreign logs mean: of each file the first that fits. Else its header says it, or the
        only bundled mapping that fits, or, where none is given, a guess from its values.
    proposals: Folder for the mapping guessed from values; None to guess none.
    assume: Take the likeliest meaning where neither header nor values decide.
    ask: Asks a question where they do not decide; the answers become a mapping beside the logs.
    """
    given = list(given)
    found, seen, asking = Sources(), list[Record](), dict[Path, str]()
    archives = [path for path in _inside(given) if path.suffix.lower() in ARCHIVES]
    given += _unpacked(given, archives, proposals, asking)
    joining = proposals.parent / JOINED if proposals and not mappings else None
    paths, found.description, spent = with_joined(list(_files(given)), joining, ask, assume=assume)
    letters = {path: letter for path in paths if (letter := axis_of_file(path))}
    if len(names := {*letters.values()}) == 1:
        letters = dict.fromkeys(paths, *names)  # a file that names none is of the axis that the others name
    for n, path in enumerate(paths, 1):
        say_step(f"reading file {n} of {len(paths)}")
        kind = _own(path, asking)
        if kind in {"circle/1", "run/1"}:
            try:
                choose_circles([path])
                same = any(cmp(path, other, shallow=False) for other in found.circles)
                (found.copies if same else found.circles).append(path)
            except FricError as error:
                found.description.append(FILE_LEFT_OUT.found(str(path), why=error.what, propose=""))
        elif kind == "log/1":
            _taken(path, None, read_records(path), found, seen)
        elif (
            kind is None
            and (path.suffix.lower() in endings() or _tried(lambda: len(next(tables(path)).columns) > 1))  # noqa: B023
            and (why := _mapped(path, mappings, found, seen, assume=assume, axis=letters.get(path)))
        ):
            asking[path] = why
    if asking and proposals and not mappings:
        places = [*(path if path.is_dir() else path.parent for path in given[:1]), proposals]
        turned = {path: why for path, why in asking.items() if OPPOSES in why}
        if turned:  # friction tells the sign
            files, some = first_of([*turned]), any("force" in log.efforts for log in found.logs)
            _guessed(turned, places, found, seen, assume=assume, ask=ask, spent=spent, every=True)
            asking = {path: why for path, why in asking.items() if OPPOSES not in why} | turned
            found.description += [FORCE_BY_FILE.found(files=files)] if some and not turned else []
        _guessed(asking, places, found, seen, assume=assume, ask=ask, spent=spent)
    for path in [path for path, why in asking.items() if why == LACKS_FORCE]:
        if not (why := _read(path, "", found, seen, assume=assume)):
            del asking[path]
    _take_circles(found)
    shown = {log.path for log in found.logs if not log.lacks}
    asking |= {log.path: log.lacks for log in found.logs if log.path not in shown}
    found.logs = [log for log in found.logs if not log.lacks]
    if not (found.logs or found.circles or found.traces):
        asking = dict.fromkeys(archives, PACKED) | asking
    for path, why in ((path, why) for path, why in asking.items() if not _is_paper(path)):
        found.refused.setdefault(why, []).append(path)
    for path in _controllers(given):
        found.controllers.setdefault(read_document(path, ControllerDocument).axis, path)
    logs = [replace(record, source="") for record in seen if isinstance(record, Log)]
    findings = (of(log) for log in logs for of in (switched, two_encoders, holds))
    found.description += [notice for notice in findings if notice is not None]
    _say(found)
    return found


def _say(found: Sources) -> None:
    """Say once of files what they are, or why they were left out."""
    if found.copies:
        found.description.append(FILE_COPIES.found(files=first_of(found.copies)))
    for axis in dict.fromkeys(log.axis for log in found.logs):
        paths = dict.fromkeys(log.path for log in found.logs if log.axis == axis)
        shared = {path.name for path in paths if sum(other.name == path.name for other in paths) > 1}
        folders = dict.fromkeys(path.parent for path in paths if path.name in shared)
        if len(shared) >= MOST_ALIKE:
            found.description.append(FOLDERS_TOGETHER.found(axis=axis, folders=[folder.name for folder in folders]))
    for why, files in found.refused.items():
        propose = shlex.join(["fric", "ingest", files[0].as_posix(), "--propose", "map.yaml"])
        propose = propose if "column" in why or BY_SIGNS in why else ""
        found.description.append(FILE_LEFT_OUT.found(first_of(files), why=why, propose=propose))
    for name, files in found.beside.items():
        found.description.append(MAPPING_BESIDE.found(first_of(files), mapping=name))
    for name, files in found.guessed.items():
        found.description.append(MAPPING_BUNDLED.found(mapping=name, files=first_of(files)))


def _take_circles(found: Sources) -> None:
    """Take logs of several axes that run on circles as circle tests, which are no logs besides, if there are others."""
    several = Counter((log.path, log.mapping or "") for log in found.logs if not rotates(log.motion))
    shares = {key: _share_on_circles(*key) for key, axes in several.items() if key[1] and axes > 1}
    found.traces |= {path: of for (path, of), share in shares.items() if share}
    circles = {path for (path, _), share in shares.items() if share > ON_CIRCLES}
    found.logs = [log for log in found.logs if log.path not in circles]


def _guessed(
    asking: dict[Path, str], places: list[Path], found: Sources, seen: list[Record], *, assume: bool, ask: Ask | None,
    spent: int, every: bool = False,
) -> None:  # fmt: skip
    """Guess the meaning of files from their values; files that need no question leave the open ones.

    every: Whether that is also done where the header names all.
    """
    say_step(f"recognising the columns of {len(asking)} file{'s' * (len(asking) > 1)}")
    with ExitStack() as opened:
        guess = guessed(
            [path for path in asking if not _is_paper(path)], opened, assume=assume or ask is not None, every=every,
            refused=asking, beside=[log.path for log in found.logs if log.mapping == ""][:MOST_BESIDE],
        )  # fmt: skip
        guess = replace(guess, found=tuple(part for part in guess.found if not _of_circle(part, guess.found, found)))
        pushed = tuple(part for part in guess.found if part.kind or {"force", "input"} & part.axis.roles.keys())
        driven = {part.files for part in pushed}  # a circle may have the voltage of one axis alone
        pushed += tuple(part for part in guess.found if part not in pushed and part.files in driven
                        and {"position", "reference"} <= part.axis.roles.keys())  # fmt: skip
        axes = Counter(path for part in guess.found for path in part.files)  # several may run on a circle
        kept = pushed or tuple(
            part for part in guess.found
            if ask or {AT_REST, NO_POSITION} & part.open.keys() or max(axes[path] for path in part.files) > 1
        )  # fmt: skip
        rest = {path for part in guess.found for path in part.files}.difference(*(part.files for part in kept))
        asking |= dict.fromkeys(rest, NO_FORCE)  # what has no force needs no question
        guess = replace(guess, found=kept)
        file, guess = answered(guess, ask, *places, spent=spent) if ask and not assume else (None, guess)
        assume = assume or file is not None
        wanted = guess.usable if assume else tuple(guess for guess in guess.usable if guess.sure)
        if not assume:  # a file with an open axis is skipped as a whole: half of it would pass for all
            unsure = {path for guess in guess.found if guess not in wanted for path in guess.files}
            wanted = tuple(guess for guess in wanted if not unsure & set(guess.files))
        found.open = replace(guess, found=tuple(guess for guess in guess.found if guess.whole and guess not in wanted))
        found.description += found.open.asked()
        for path in {path for guess in found.open.found for path in guess.files}:
            del asking[path]
        for part in (part for part in guess.found if not part.whole and part.open):
            asking |= {path: "; ".join(part.open) for path in part.files if path in asking}
        if not wanted:
            return
        sure = replace(guess, found=wanted)
        if file is None:
            file = folder_made(places[-1]) / f"mapping{'-turned' * every}.yaml"
            written(file, sure.text(), force=True)
        found.description += sure.notices(str(file))
    for part in wanted:
        axis, together = part.axis.name if len(wanted) > 1 else None, len(part.files) > 1
        read = partial(_read, mapping=str(file), found=found, seen=seen, axis=axis, assume=assume, together=together)
        before, whys = len(seen), {path: read(path) for path in part.files}
        of_drive = "force" if "force" in part.axis.roles else "input"
        force = part.axis.roles.get(of_drive)
        if force and 2 * len(_against(whys)) > len(whys):  # what most of the files show is right
            part.axis.roles[of_drive] = replace(force, sign=-force.sign)
            written(file, sure.text(), force=True)
            found.logs = [log for log in found.logs if log.path not in whys]
            found.copies = [path for path in found.copies if path not in whys]
            del seen[before:]
            whys = {path: read(path) for path in whys}
        if force and 0 < len(turned := _against(whys)) < len(whys):  # the others count the other way: a part for each
            roles = part.axis.roles
            of_others = {**roles, of_drive: replace(roles[of_drive], sign=-roles[of_drive].sign)}
            parts = (
                replace(part, files=tuple(path for path in whys if path not in turned)),
                replace(part, files=tuple(turned), axis=replace(part.axis, roles=of_others)),
            )
            sure = replace(sure, found=(*(other for other in sure.found if other is not part), *parts))
            written(file, sure.text(), force=True)
            whys |= {path: read(path) for path in turned}
            found.description.append(FORCE_BY_FILE.found(files=first_of(turned)))
        for path in whys:
            asking.pop(path, None)
        asking |= {path: why for path, why in whys.items() if why}


def _against(whys: Mapping[Path, str]) -> list[Path]:
    """Return the files whose friction, by the signs that were guessed of all, would drive the axis."""
    return [path for path, why in whys.items() if why.startswith(TURNED) or OPPOSES in why]


def _of_circle(part: Guess, parts: Iterable[Guess], found: Sources) -> bool:
    """Return whether a guess is of the table of a circle, which was found beside other tables of its files."""
    others = (other for other in parts if other.files == part.files and other.table.columns != part.table.columns)
    known = found.traces.keys() >= {*part.files} and next(others, None) is not None
    return known and _tried(lambda: circle_plan(part.table, None, 1.0, {})) is not None


def _tried(read: Callable[[], T]) -> T | None:
    """Return what is read; None where that is refused."""
    try:
        return read()
    except FricError:
        return None


def _is_paper(path: Path) -> bool:
    """Return whether a file is documentation by its name, and not a log."""
    return bool(_PAPER.match(path.name)) and path.suffix.lower() in {".txt", ".md", ".rst", ".log", ".dat"}


def _unpacked(given: list[Path], archives: list[Path], proposals: Path | None, asking: dict[Path, str]) -> list[Path]:
    """Unpack the logs of ZIPs that do not lie beside them into folders of their names, and return these."""
    found: list[Path] = []
    if proposals is None or not archives:
        return found
    folder, beside_it = proposals.parent / "unpacked", {path.name for path in _files(given)}
    for path in archives:
        try:
            with foreign(path), ZipFile(path) as archive:
                names = [(member, Path(member.filename)) for member in archive.infolist()]
                kept = [(m, name) for m, name in names if name.suffix.lower() in endings() and not _is_paper(name)]
                logs = [member for member, name in kept if name.name not in beside_it]
                large = any(member.file_size > max(SMALL, MOST_RATIO * member.compress_size) for member in logs)
                if large or sum(member.file_size for member in logs) > MOST_UNPACKED or len(logs) > MOST_MEMBERS:
                    raise FricError("it unpacks to more than is unpacked here: unpack it beside it")
                archive.extractall(folder / path.stem, logs)
                found += [folder / path.stem] if logs else []
        except FricError as error:
            asking |= {path: error.what} if path.suffix.lower() == ".zip" else {}
    return found


def _files(given: Iterable[Path]) -> Iterator[Path]:
    """Yield the files, fric's log files first: a foreign copy of a record is then recognised."""
    files = [path for path in _inside(given) if path.suffix.lower() not in PASSED_OVER | ARCHIVES or marked(path)]
    if len(files) > MOST_MEMBERS:
        raise FricError(f"{len(files)} files may be logs, and {MOST_MEMBERS} are read at most", hint="Give fewer.")
    yield from sorted(dict.fromkeys(files), key=lambda path: (path.suffix.lower() not in {".h5", ".hdf5"}, str(path)))


def _inside(given: Iterable[Path]) -> list[Path]:
    """Return the files, and those of folders."""
    files: list[Path] = []
    for path in given:
        files += sorted(file for file in path.rglob("*") if file.is_file()) if path.is_dir() else [regular(path)]
    return files


def _controllers(given: Iterable[Path]) -> Iterator[Path]:
    for path in given:
        for entry in sorted(path.rglob("*.yaml")) if path.is_dir() else [path] if path.suffix == ".yaml" else []:
            with reading(entry) as file:
                if file.read(80).startswith(f"fric: {ControllerDocument.type_name()}".encode()):
                    yield entry


def _own(path: Path, asking: dict[Path, str]) -> str | None:
    """Return the stated type of a file of fric; None for a foreign file, or for a damaged file, with the reason."""
    try:
        return recognise(path) if is_hdf5(path) else None
    except FricError as error:
        asking[path] = error.what
        return None


def _source(path: Path, records: list[Record], mapping: str | None) -> Source:
    records = [part for record in records for part in in_one_mode(record)]
    inspected = [inspect(record, flaws=False) for record in records]
    uses, alone = _uses(inspected), [*map(_in_volts, records)]
    in_volts = _uses([inspect(log, flaws=False) for log in alone if log]) if all(alone) else frozenset()
    uses |= {MOTION} if True in (moving := [*map(_excites, records)]) else set()
    kinds = frozenset(str(inspection.kind) for inspection in inspected)
    both = all(isinstance(record, Log) and record.force is not None and record.input is not None for record in records)
    strokes = sum(
        len(inspection.stretches) if isinstance(inspection, Inspection) else inspection.points
        for inspection in inspected if isinstance(inspection, Inspection | TableInspection)
    )  # fmt: skip
    driven = all(isinstance(record, Log) and record.input is not None for record in records)
    pushed = any(not isinstance(record, Log) or record.force is not None for record in records) or driven
    loaded = any(isinstance(record, Log) and record.load_position is not None for record in records)
    rests = kinds == {"motion"} and all(isinstance(log, Log) and is_at_rest(travelled(log)) for log in records)
    broken = kinds == {"motion"} and any(isinstance(log, Log) and blocks_lost(log) for log in records)
    lacks = NO_FORCE if not pushed else BROKEN if broken else AT_REST if rests else ""
    axis, motion = records[0].axis, records[0].motion
    unfit = (
        f"{inspection.name}: {use.why}" for inspection in inspected for use in inspection.uses
        if use.purpose == SHOWS.get(inspection.kind) and not use.good
    )  # fmt: skip
    efforts = frozenset(of for of in ("force", "input") for log in records if getattr(log, of, None) is not None)
    rates = tuple(rate for log in records if isinstance(log, Log) and (rate := _renewed(log)))
    return Source(
        path, axis, motion, kinds, uses, mapping, both, driven, strokes, loaded=loaded, lacks=lacks, efforts=efforts,
        rates=rates, unfit=next(unfit, ""), in_volts=in_volts,
        uneven=next((why for why in moving if isinstance(why, str)), ""),
    )  # fmt: skip


def _uses(inspected: Iterable[Inspection | TableInspection | ResponseInspection]) -> frozenset[str]:
    return frozenset(use.purpose for inspection in inspected for use in inspection.uses if use.good)


def _in_volts(record: Record) -> Log | None:
    """Return a record of a voltage alone with its friction in volts, as a controller compensates it; else None."""
    if not isinstance(record, Log) or record.force is not None or record.input is None:
        return None
    return replace(record, motion="rotary/V/V" if rotates(record.motion) else "linear/V/V")


def _renewed(log: Log) -> float:
    """Return the rate of a record whose input, or else force, changes at nearly every sample [Hz]; 0 otherwise."""
    pushed = log.force if log.input is None else log.input
    changes = 0 if pushed is None else np.count_nonzero(np.diff(pushed))
    return changes / float(log.time[-1] - log.time[0]) if changes > 0.98 * len(log) else 0.0


def _excites(record: Record) -> bool | str:
    """Return whether a motion with force or input shows mass, viscous and Coulomb friction; or what its clock lacks."""
    if not isinstance(record, Log) or (record.force is None and record.input is None) or len(record) < STUCK:
        return False
    record = evened(record)[0]
    even = np.diff(record.time) / np.median(np.diff(record.time))
    if not (moves := excites(record.time, travelled(record))) or np.ptp(even) < 0.5:
        return moves
    return f"{record.name}: {even.mean() - 1:.1%} of the samples are missing, up to {even.max() - 1:.0f} in a row"


def _mapped(
    path: Path, mappings: Sequence[str], found: Sources, seen: list[Record], *, assume: bool, axis: str | None
) -> str:
    """Read a foreign log by the first of the mappings that fits, or else by its header; return why none fits.

    A mapping of circles gives the circle that a file holds, beside its logs or alone.
    """
    first = ""
    for mapping in mappings:
        fits = _tried(lambda: part_of(mapping_of(mapping), path))  # noqa: B023
        if fits and (share := _share_on_circles(path, mapping)):
            found.traces[path] = mapping
            if share > ON_CIRCLES:
                return ""
    for meaning in (*(name for name in mappings if not holds_circles(name)), None):
        why = _foreign(path, meaning, found, seen, assume=assume, axis=axis)
        if not why or (meaning and "there is no column" not in why):
            return why
        first = first or why
    return first


def _foreign(
    path: Path, mapping: str | None, found: Sources, seen: list[Record], *, assume: bool, axis: str | None
) -> str:
    """Read a foreign log by its header or a mapping, or a circle test; return why none fits, if it was not reported."""
    if not mapping and (known := beside(path)):
        file, axes = known
        whys = [_read(path, str(file), found, seen, axis=axis, assume=True) for axis in axes]
        if not all(whys):
            found.beside.setdefault(str(file), []).append(path)
            return next(filter(None, whys), "")
    if not mapping and _tried(lambda: _of_several(path)) and _share_on_circles(path, ""):
        found.traces[path] = ""
    if not mapping and _tried(lambda: says_all(path)) == "force":
        return LACKS_FORCE
    axes = [axis if said is None and not mapping else said for said in axes_said(path)]
    if (given := mapping_of(mapping or None)) and len(parts := axes_mapped(given, path)) > 1:
        axes = parts
    whys = [_read(path, mapping or "", found, seen, axis=said, assume=assume) for said in axes]
    why = next(filter(None, whys), "") if mapping or all(whys) else ""
    if not why or mapping:
        return why
    held = _records(path, "", kind="holding-map")
    if isinstance(held, list) and all(isinstance(record, Log) and is_holding_map(record) for record in held):
        _taken(path, "", held, found, seen)
        return ""
    if share := _share_on_circles(path, ""):
        found.traces[path] = ""
        if share > ON_CIRCLES:
            return ""
    fitting = {name: records for name in bundled("mapping") if isinstance(records := _records(path, name), list)}
    if len(fitting) > 1:
        found.description.append(MAPPING_AMBIGUOUS.found(str(path), mappings=list(fitting)))
    elif fitting:
        ((name, records),) = fitting.items()
        if _taken(path, name, records, found, seen):
            found.guessed.setdefault(name, []).append(path)
    return "" if fitting else why


def _of_several(path: Path) -> bool:
    """Return whether a file holds several records, of which one may be a circle."""
    with closing(tables(path)) as opened:
        return RECORD in next(opened).said


def _share_on_circles(path: Path, mapping: str) -> float:
    """Return the share of a foreign file in which its axes run on whole circles."""
    with TemporaryDirectory() as folder:
        of, any_size = mapping_of(mapping or None), StatedCircle(within=(0.0, inf))  # its step refuses another unit
        read = _tried(lambda: ingest_circles(path, Path(folder) / "circle.h5", mapping=of, stated=any_size))
        if read is None or any(test.angle is not None for test in read.tests):
            return 0.0 if read is None else 1.0
        share = sum(len(test.axes[test.names[0]].time) for test in read.tests) / read.samples
        return min(share, ON_CIRCLES) if read.beside else share


def _records(
    path: Path, mapping: str, axis: str | None = None, *, assume: bool = False, kind: Kind | None = None,
    doubts: list[Notice] | None = None,
) -> list[Record] | str:  # fmt: skip
    """Return the records of a foreign log by a mapping, or by its header without a mapping; or why it has none.

    doubts: Receives the doubts about the file, except which columns are left out.
    """
    with TemporaryDirectory() as folder:
        log = Path(folder) / "log.h5"
        try:
            cells, meaning = "drop" if assume else "error", mapping_of(mapping or None)
            about: dict[str, Any] = {"mapping": meaning, "axis": axis, "kind": kind, "bad_cells": cells}
            read = read_foreign(path, log, **about, is_other=holds_circle)
            if doubts is not None:
                doubts += [w for w in read.warnings if w.severity != "note" and w.code != LEFT_OUT.code]
            return read_records(log)
        except FricError as error:
            line = re.search(r"line \d+", error.where)
            why = f"{line[0]}: {error.what}" if line else error.what
            return f"{why} ({LEAVES_OUT})" if "bad_cells" in error.hint else why


def _read(
    path: Path, mapping: str, found: Sources, seen: list[Record], *, axis: str | None = None, assume: bool = False,
    together: bool = False,
) -> str:  # fmt: skip
    """Take the records of a foreign log; return why there are none, else None.

    together: Whether its signs were guessed from several files: one of them may count the other way.
    """
    doubts = list[Notice]()
    records = _records(path, mapping, axis, assume=assume, doubts=doubts)
    if isinstance(records, str):
        return records
    for log in (record for record in records if together and isinstance(record, Log)):
        (signs := Signs()).add(log.channels())
        if signs.against() in {"force", "input"}:
            return f"{TURNED}: {BY_SIGNS} friction drives the axis"
    if _taken(path, mapping, records, found, seen, wide=axis is not None, assume=assume):
        found.description += [doubt for doubt in doubts if doubt not in found.description]
    return ""


def _taken(
    path: Path, mapping: str | None, records: list[Record], found: Sources, seen: list[Record], *, wide: bool = False,
    assume: bool = False,
) -> bool:  # fmt: skip
    """Take the records of a log; return whether they are new, not copies of others."""
    if all(any(_same(record, known) for known in seen) for record in records):
        found.copies.append(path)
        return False
    seen += records
    found.logs.append(replace(_source(path, records, mapping), wide=wide, assumed=assume))
    return True


def _same(record: Record, other: Record) -> bool:
    """Return whether two records hold the same samples, to the digits that a text file has."""
    if not (isinstance(record, Log) and isinstance(other, Log)) or len(record) != len(other):
        return False
    a, b = record.channels(), other.channels()
    pairs = ((a[name], b[name]) for name in a.keys() & b.keys())
    return all(np.allclose(x, y, rtol=1e-4, atol=1e-4 * float(np.abs(y).max())) for x, y in pairs)
