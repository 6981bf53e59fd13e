"""Foreign logs, read into a log file."""

from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import replace
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import fric
from fric.columns import CIRCLE
from fric.documents.listings import IngestCirclesDocument, IngestDocument
from fric.documents.mapping import MappingDocument
from fric.documents.yaml import read_document, read_text
from fric.errors import FricError
from fric.flaws.files import COLUMNS_LEFT_OUT, MAPPING_BESIDE, MAPPING_PROPOSED, THERE_ALREADY
from fric.input import files_of, other_kind
from fric.io.ingest import Ingested, IngestedCircles, sizes
from fric.io.ingest import ingest as read_foreign
from fric.io.propose import first_of, guessed, proposal
from fric.io.questions import Ask, Review, answered, beside
from fric.io.readers.base import ForeignTable, Memory, named
from fric.io.recognise import recognise
from fric.io.words import axis_of_file
from fric.log import Columns
from fric.notice import Notice, enumerated
from fric.output import FORMATS
from fric.results.base import Advance, DataFrame, Figure, Piece, Result, in_si, path_of, quantity, silent
from fric.results.kinds import MappingLike, Quantity, RecordKind, SchemeName
from fric.series import real
from fric.units import Motion, readable, words_of
from fric.verb import Kind, refused, verb

if TYPE_CHECKING:
    from fric.circles.measured import MeasuredCircle

LIKELIEST = "`assume=True` takes the likeliest of what is open."


class CirclesResult(Result, schema=IngestCirclesDocument, of="done"):
    """A circle test file that was written."""

    done: IngestedCircles  # The file, and its tests

    def report(self) -> list[Piece]:
        """Return a line for each test."""
        pieces: list[Piece] = []
        for test in self.done.tests:
            sense = "counter-clockwise" if test.direction > 0 else "clockwise"
            held = ", ".join(f"{name}: {' '.join(list(trace.channels())[1:])}" for name, trace in test.axes.items())
            of = f"{test.name}: {readable(test.radius, 'm')} at {readable(test.feed, 'm/s')}, {sense}"
            pieces.append(f"{of}; {held or 'ball bar: angle deviation'}")
        count = len(self.done.tests)
        return [*pieces, f"{count} circle test{'s' * (count != 1)} in {self.done.output}"]


@verb
def ingest_circles(
    *files: Annotated[Path | str, Kind(metavar="FILE")], output: Annotated[Path | str, Kind(metavar="LOG.h5")],
    mapping: MappingLike | None = None, radius: Annotated[Quantity | None, "position"] = None,
    feed: Annotated[Quantity | None, "velocity"] = None, sampling: Annotated[Quantity | None, "frequency"] = None,
    instrument: Literal["encoders", "grid", "ball-bar"] | None = None, scheme: SchemeName | None = None,
    clockwise: bool | None = None, append: bool = False, bad_cells: Literal["error", "drop"] = "error",
    assume: bool = False, force: bool = False, advance: Advance = silent,
) -> CirclesResult:  # fmt: skip
    """Read traces of circle tests, or a ball bar's angle and radial deviation, into a circle test file.

    files: Text (also ``.gz``, also LinuxCNC's sampler), MATLAB ``.mat`` or Parquet files. A trace may hold several
        circles.
    output: The circle test file to write, whole or not at all.
    mapping: What the columns mean, or its file. Without it the header must name axes and units: ``x_ref [mm]``.
    radius: Circle: nominal radius; by default found from the data.
    feed: Circle: feed; by default found from the data.
    sampling: Circle: sampling rate of a trace without time, as 4 kHz.
    instrument: Circle: instrument that measured the position.
    scheme: Circle: compensation that was on, as f. A prediction uses it.
    clockwise: Circle: direction; by default found from the data.
    append, bad_cells, assume, force, advance: As in `fric.ingest`.
    Raises FricError: When a file cannot be read, or contains no whole circle.
    """
    paths, direction = list(map(Path, files)), -1 if clockwise else 1
    from fric.io.ingest_circle import StatedCircle  # which brings what models are compiled by
    from fric.io.ingest_circle import ingest_circles as read_circles

    way = None if clockwise is None else direction
    size, speed = quantity(radius, "position"), quantity(feed, "velocity")
    stated = StatedCircle(size, speed, way, quantity(sampling, "frequency"), instrument or "", scheme or "")
    advance(0, total=sizes(paths))
    given: dict[str, Any] = {"append": append, "force": force, "progress": advance, "stated": stated}
    try:
        done = read_circles(paths, Path(output), mapping=mapping_of(mapping), bad_cells=bad_cells, **given)
    except FricError as error:
        with ExitStack() as opened:
            found = guessed(paths, opened, assume=True) if mapping is None else None
            if found is None or not found.usable:
                raise
            if not assume:
                raise FricError(error.what, where=error.where, hint=f"{error.hint} {LIKELIEST}") from None
            likeliest, notices = read_text(found.text(), MappingDocument), found.notices()
        done = read_circles(paths, Path(output), mapping=likeliest, bad_cells="drop", **given)
        done = replace(done, warnings=(*notices, *done.warnings))
    return CirclesResult(done)


@verb
def circles_from_frame(
    frame: Columns, *, radius: Annotated[Quantity | None, "position"] = None,
    feed: Annotated[Quantity | None, "velocity"] = None, scheme: str = "",
) -> list["MeasuredCircle"]:  # fmt: skip
    """Return the circle tests of a data frame, for `diagnose`, `tune` and `make_report`.

    frame: A `pandas.DataFrame`, or a mapping of columns, whose names are of axes, with units: ``x_ref [mm]``.
    radius, feed, scheme: As in `fric.ingest_circles`.
    Raises FricError: When no two axes are named, or they run on no whole circle.
    """
    if not hasattr(frame, "keys"):
        raise refused("circles_from_frame", "a data frame, or columns by name", frame)
    from fric.io.ingest_circle import StatedCircle, circles_in

    values = [real(frame[name], "circles_from_frame", f"the column '{name}'") for name in frame]
    table = Memory(Path("frame"), [named(str(name)) for name in frame], values)
    stated = StatedCircle(quantity(radius, "position"), quantity(feed, "velocity"), scheme=scheme)
    return circles_in(table, stated)[0]


class IngestResult(Result, schema=IngestDocument, of="done"):
    """A log file that was written."""

    done: Ingested  # The log file, its axis, and the records added or skipped
    mapped: bool  # Whether a mapping defined the columns
    guesses: Sequence[Notice] = ()  # Guesses about the columns

    @property
    def warnings(self) -> Sequence[Notice]:
        """What was skipped, left out or wrong."""
        skipped = [THERE_ALREADY.found(source, record=name) for source, name in self.done.skipped]
        partly = (record for record in self.done.records if record.left_out and not self.mapped)
        left_out = [COLUMNS_LEFT_OUT.found(record.source, columns=record.left_out) for record in partly]
        return [*self.guesses, *self.done.warnings, *skipped, *left_out]

    def brief(self) -> str:
        """Return how many records there are, and which: as many names as a line takes."""
        names = [record.name for record in self.done.records]
        return f"{len(names)} record{'s' * (len(names) != 1)}: {enumerated(names, 32)}"

    def report(self) -> list[Piece]:
        """Return the number of records and samples."""
        done, count = self.done, len(self.done.records)
        of = f"{count} record{'s' * (count != 1)} of the {words_of(done.motion)} axis {done.axis}"
        return [f"{of}, {done.samples} samples, in {done.output}"]

    def figure(self) -> Figure:
        """Return the figure of the records in the log file."""
        return fric.inspect(self.done.output).figure()

    def to_frame(self) -> DataFrame:
        """Return the samples of the log file, as `Records` gives them."""
        return fric.read(self.done.output).to_frame()


@verb
def ingest(
    *files: Annotated[Path | str, Kind(metavar="FILE")], output: Annotated[Path | str, Kind(metavar="LOG.h5")],
    mapping: MappingLike | None = None, kind: RecordKind | None = None,
    axis: Annotated[str | None, Kind(metavar="NAME")] = None,
    motion: Annotated[Motion | None, Kind(metavar="linear|rotary[/UNIT]")] = None, append: bool = False,
    bad_cells: Literal["error", "drop"] = "error", begin: Annotated[Quantity | None, "time"] = None,
    end: Annotated[Quantity | None, "time"] = None, join: bool = False, assume: bool = False, ask: Ask | None = None,
    force: bool = False, advance: Advance = silent,
) -> IngestResult:  # fmt: skip
    """Read logs of a drive into a log file, each as a record in SI units.

    files: Logs: text (also .gz), .mat, .mf4, …; `fric ingest --list` shows the formats. fric's log files are read, too.
    output: The log file to write. It is written whole or not at all.
    mapping: What the columns mean, where the header does not say it. Without it the header must name channels and
        units: ``time [s]``.
    kind: What was logged. It overrides mapping and files.
    axis: Name of the axis, such as x.
    motion: Motion of the axis, if the units do not show it.
    append: Add to LOG.h5; files already in it are skipped. A file is recognised by its sha256.
    bad_cells: What to do with a cell that is not a number: raise an error, or drop the sample.
    begin: First time to read, as 8.5 s.
    end: Last time to read.
    join: Join all files to one record: its channels were logged separately with a common clock.
    assume: Assume the likeliest meaning where header and values leave it open, and report it; samples that cannot be
        used are dropped.
    ask: Asks about what header and values leave open, three questions at most, or shows all columns at once. The
        answers become a mapping beside the logs, which is used from then on.
    Raises FricError: When a file cannot be read, a column has no meaning, or a cell is no number.
    """
    paths, mapping = files_of(files), mapping_of(mapping)
    for path in paths:
        if path.suffix in FORMATS["YAML"] and path.is_file():
            raise other_kind(path, recognise(path), "log/1")
    of = {letter: path for path in paths if (letter := axis_of_file(path))}
    if axis is None and mapping is None and not join and len(of) > 1:
        what = f"the files are named by axes {' and '.join(of)}, and a log file is of one"
        raise FricError(what, where=first_of([*of.values()]), hint="Ingest those of each axis, or say `axis=`.")
    low, high = -inf if begin is None else in_si(begin, "time"), inf if end is None else in_si(end, "time")
    if not low < high:
        raise FricError(f"a window from {low:g} to {high:g} s holds nothing", hint="Give `begin=` before `end=`.")
    advance(0, total=sizes(paths))
    notices: list[Notice] = []
    reviewed = isinstance(ask, Review)
    if mapping is None and not (join or reviewed):
        known = {held[0] for path in paths if path.is_file() and (held := beside(path))}
        if len(known) == 1:
            mapping, assume = mapping_of(*known), True
            notices = [MAPPING_BESIDE.found(str(paths[0]), mapping=str(*known))]
    if mapping is None and join and assume:
        if '"?' in (text := proposal(paths, join=True, assume=True)):
            hint = "`fric ingest FILES --join --propose map.yaml` writes a mapping to fill in, for --map."
            raise FricError("a unit is open that no likelihood tells", where=str(paths[0]), hint=hint)
        mapping = read_text(text, MappingDocument)
        means = ", ".join(f'{channel} is "{at.column}"' for channel, at in mapping.columns.items() if at.column)
        notices = [MAPPING_PROPOSED.found(means=means, files=first_of(paths))]
    if mapping is None and not join:
        with ExitStack() as opened:
            found = guessed(paths, opened, kind, motion, assume=assume or ask is not None, every=reviewed)
            places = paths[0].parent, Path(output).parent
            file, found = answered(found, ask, *places) if ask and not assume else (None, found)
            assume = assume or file is not None
            if found.usable:
                if not (assume or found.sure):
                    raise found.error()
                mapping, notices = read_text(found.text(), MappingDocument), found.notices(str(file or ""))
    done = read_foreign(
        paths, Path(output), mapping=mapping, kind=kind, axis=axis, motion=motion, append=append,
        bad_cells="drop" if assume else bad_cells, force=force, progress=advance, window=(low, high), join=join,
        is_other=_holds_circle,
    )  # fmt: skip
    return IngestResult(done, mapping is not None, notices)


def _holds_circle(table: ForeignTable) -> bool:
    from fric.io.ingest_circle import holds_circle  # which brings what models are compiled by

    return holds_circle(table)


def mapping_of(given: MappingDocument | Path | str | None) -> MappingDocument | None:
    """Return the mapping of the columns, given directly or as its file."""
    if given is None or isinstance(given, MappingDocument):
        return given
    return read_document(path_of("a mapping, or its file", given), MappingDocument)


@verb
def holds_circles(mapping: MappingDocument | Path | str | None = None, kind: str | None = None) -> bool:
    """Return whether files hold circles, by the kind or else by the mapping.

    mapping: What the columns mean, or its file.
    kind: The kind that is stated.
    """
    found = mapping_of(mapping)
    kinds = {part.kind for part in found.parts or [found]} if found else set()
    return kind == CIRCLE if kind else kinds == {CIRCLE}
