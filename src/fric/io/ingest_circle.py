"""Foreign traces of circle tests in, one circle test file out: every arc of a trace that is a whole circle."""

import json
import re
from collections.abc import Iterable, Iterator, Mapping
from contextlib import closing
from dataclasses import dataclass, replace
from functools import partial
from math import inf, pi
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from fric.arrays import Real
from fric.circles.measured import CHANNELS, AxisTrace, Instrument, MeasuredCircle
from fric.circles.revolutions import find_circles, fit_circle, rounded
from fric.columns import BALL_BAR
from fric.documents.base import provenance
from fric.documents.mapping import ColumnMapping, FileMapping, MappingDocument, filled
from fric.errors import FricError
from fric.estimate import Estimate
from fric.flaws.files import COLUMNS_BY_CONTENT, FORCE_BY_FILE, NO_REFERENCE, RADIUS_ASSUMED, THERE_ALREADY
from fric.input import files_of
from fric.io.channels import ColumnPlan, Origin, origin_of
from fric.io.circle import FORMAT, read_circles, write_circles
from fric.io.hdf5 import read_logs
from fric.io.ingest import ClockCheck, IngestedCircles, Progress, Signs, WholeRows, digest_of, ingest
from fric.io.readers import tables
from fric.io.readers.base import RECORD, Column, ForeignTable, plain_name
from fric.io.roles import said_clock
from fric.io.words import bare, of_axis, says_something, spoken, tags
from fric.log import Log
from fric.notice import Notice
from fric.output import refuse_ending, refuse_existing
from fric.units import Motion, converts, in_units_of, parse, readable, si_unit

AXES = "xyz"
SILENT = frozenset({"position", "pos", "axis", "value", "lage", "achse", "wert"})
"""Words that say nothing of a position's role: an actual position is actual."""


def circle_plan(
    table: ForeignTable, mapping: FileMapping | None, sampling: float | None, fields: Mapping[str, str]
) -> tuple[ColumnPlan, list[Notice]]:
    """Return where each channel of a circle test comes from, and what had to be assumed for it.

    mapping: The meaning of its columns; None where the header defines it, or there is none.
    sampling: Samples a second of a trace without time [Hz].
    """
    warnings: list[Notice] = []
    if mapping is not None:
        channels = dict(mapping.columns)
    else:
        channels = _by_header(table)
        if not channels and all(re.fullmatch(r"column \d+", column.name) for column in table.columns):
            return _by_content(table, sampling)
    motion = _motion_of(table, channels, fields)
    called = {name: "ball-bar.deviation" if name == "deviation" else name for name in channels}
    origins = {name: origin_of(table, called[name], channel, motion, fields) for name, channel in channels.items()}
    if sampling is not None:
        origins["time"] = Origin(None, 1.0 / sampling)
    elif "time" not in origins and (clock := said_clock(table.constants)) and clock.unit:
        origins["time"] = Origin(None, parse(clock.unit, "time"))
    axes = list(dict.fromkeys(name.partition(".")[0] for name in origins if "." in name))
    whole = [axis for axis in axes if f"{axis}.position" in origins]
    where, columns = str(table.path), table.listed(14)
    if not set(BALL_BAR) <= origins.keys():
        if len(whole) < 2:
            raise FricError(
                f"holds the position of {' and '.join(whole) or 'no axis'}, and a circle test takes two axes, or angle "
                "and deviation of a ball bar",
                where=where, hint=f"The columns are {columns}. Name them as in 'x_ref [mm]', 'x_pos [mm]', or in a "
                "mapping (`mapping=`) with `kind: circle` as x.reference, x.position.",
            )  # fmt: skip
        if "time" not in origins:
            raise FricError(
                "no column is time", where=where,
                hint="Say the rate: `sampling='4 kHz'`, or in a mapping `time: {rate: 4 kHz}`.",
            )  # fmt: skip
        if not any(name.endswith(".reference") for name in origins):
            warnings.append(NO_REFERENCE.found(where))
    return ColumnPlan(motion, origins), warnings


def _motion_of(table: ForeignTable, channels: Mapping[str, ColumnMapping], fields: Mapping[str, str]) -> Motion:
    """Return the motion of axes whose force is in the unit of the first force: in N, or in the drive's."""
    forces = (channel for name, channel in channels.items() if name.endswith(".force") and channel.column is not None)
    if (force := next(forces, None)) is None:
        return "linear"
    wanted = filled(force.column, fields, str(table.path)) if isinstance(force.column, str) else force.column or 0
    return in_units_of("linear", force.scale or force.unit or table.columns[table.find(wanted, "force")].unit)


def _by_header(table: ForeignTable) -> dict[str, ColumnMapping]:
    """Return the channels that the header names, as ``x_ref [mm]`` or ``position x [µm]``; measured ones first."""
    found: dict[str, tuple[bool, bool, int]] = {}  # an effort that is asked for comes last
    for n, (column, tag) in enumerate(zip(table.columns, tags(table.columns), strict=True)):
        axis, name = _axis_of(column._replace(name=bare(column)))
        says = spoken(Column(name, column.unit))
        if not axis and tag in {*AXES}:  # Xdac_V beside Xfb_mm
            axis, says = str(tag), of_axis(column, tag)
        unit = column.unit or says.unit
        measures = partial(converts, unit)
        if axis and measures("position"):
            moved = says.measured or says.means == "position" or not name
            shown = {"reference": says.commanded or "nominal" in name, "position": moved}
        elif axis:
            moves = in_units_of("linear", unit)
            of = {"force", "current", *([""] if moves in {"linear", "linear/A"} else [])}  # % may be of anything
            pushes = says.means in of
            shown = {"input": measures("input") and says.means in {"", "input"},
                     "force": pushes and converts(unit, "force", moves)}  # fmt: skip
        else:
            deviates = says.means == "error"
            shown = {"time": says.quantity == "time", "deviation": deviates and measures("position"),
                     "angle": not deviates and measures("angle")}  # fmt: skip
        channel = next((f"{axis}.{of}".removeprefix(".") for of, fits in shown.items() if fits), "")
        rank = says.commanded and not channel.endswith("reference"), not says.measured, n
        if channel and (channel not in found or rank < found[channel]):
            found[channel] = rank
    return {name: ColumnMapping(column=n) for name, (*_, n) in found.items()}


def _axis_of(column: Column) -> tuple[str, str]:
    """Return the axis in a name, which may run on as in ``xref``, and the rest; no axis where there is none."""
    words = [word for word in re.split(r"[\W_]+", plain_name(column.name)) if word and word not in SILENT]
    if len(words) == 1 and len(word := words[0]) > 1:
        ends = ((word[0], word[1:]), (word[-1], word[:-1]))
        words = next(([*end] for end in ends if end[0] in AXES and (end[1] in SILENT or says_something(end[1]))), words)
    axes = [word for word in words if word in {*AXES}]
    rest = " ".join(word for word in words if word not in {*axes, *SILENT})
    return (axes[0], rest) if len(axes) == 1 else ("", column.name)


def _by_content(table: ForeignTable, sampling: float | None) -> tuple[ColumnPlan, list[Notice]]:
    """Return the columns of LinuxCNC's sampler text: a running number, then pairs of axes in mm, without a header."""
    first = next(table.read(range(len(table.columns))))
    count = np.diff(first.columns[0])
    numbered = len(count) > 0 and bool(np.all(count == np.round(count))) and bool(np.median(count) == 1.0)
    if sampling is None:
        raise FricError(
            "has no header and no time", where=str(table.path),
            hint="Say its rate, as in `sampling='4 kHz'`; or what its columns are in a mapping (`mapping=`).",
        )  # fmt: skip
    radii = {
        n: radius
        for n in range(int(numbered), len(table.columns) - 1, 2)
        if (radius := _is_circle(first.columns[n], first.columns[n + 1]))
    }
    pairs = [(n, n + 1) for n, radius in radii.items() if abs(radius / next(iter(radii.values())) - 1) < 0.01]
    if not pairs:
        raise FricError(
            "has no header, and no two neighbouring columns run on a circle", where=str(table.path),
            hint="Say what its columns are in a mapping (`mapping=`) with `kind: circle`.",
        )  # fmt: skip
    reference, position = (pairs[0], pairs[-1]) if len(pairs) > 1 else (None, pairs[0])
    origins = {"time": Origin(0 if numbered else None, 1.0 / sampling)}
    for axis, k in (("x", 0), ("y", 1)):
        if reference is not None:
            origins[f"{axis}.reference"] = Origin(reference[k], 1e-3)
        origins[f"{axis}.position"] = Origin(position[k], 1e-3)
    of_reference = " and ".join(map(str, reference)) if reference else ""
    columns = {"reference": of_reference, "position": " and ".join(map(str, position))}
    return ColumnPlan("linear", origins), [COLUMNS_BY_CONTENT.found(str(table.path), **columns)]


def _is_circle(x: Real, y: Real) -> float:
    """Return the radius of the circle that two columns run on while they move; 0 where they do not."""
    moving = np.hypot(np.diff(x, append=x[-1:]), np.diff(y, append=y[-1:])) > 0
    if np.count_nonzero(moving) < 100 or not 0.9 * np.ptp(y) < np.ptp(x) < 1.1 * np.ptp(y):
        return 0.0
    a, b, r = fit_circle(x[moving], y[moving])
    return r if np.quantile(np.abs(np.hypot(x[moving] - a, y[moving] - b) - r), 0.9) < 0.01 * r else 0.0


@dataclass(frozen=True)
class StatedCircle:
    """What the user states about a circle; None is found from the trace."""

    radius: float | None = None  # radius, feed: nominal radius [m], and speed along the circle [m/s]
    feed: float | None = None
    direction: int | None = None  # 1 counter-clockwise, -1 clockwise
    sampling: float | None = None  # Samples a second of a trace without time [Hz]
    instrument: Instrument = ""  # What measured the position
    scheme: str = ""  # Name of the compensation that was on; empty where it is not known
    within: tuple[float, float] = (2e-4, 5.0)  # Radius [m] where none is stated: of another, the unit is wrong


def ingest_circles(
    paths: Iterable[Path] | Path, output: Path, *, mapping: MappingDocument | None = None,
    stated: StatedCircle | None = None, append: bool = False, bad_cells: str = "error", force: bool = False,
    progress: Progress | None = None,
) -> IngestedCircles:  # fmt: skip
    """Read traces of circle tests, or a ball bar's angle and radial deviation, into a circle test file.

    paths: Text (also ``.gz``, also LinuxCNC's sampler), MATLAB ``.mat``, Parquet. A trace may hold several circles.
    output: The file that is written, whole or not at all.
    mapping: What the columns mean. Without it the header must name axes and units, as in ``x_ref [mm], x_pos [mm]``.
    stated: Properties of the circle that are stated and not found.
    append: Add to the file.
    bad_cells, force, progress: As in `fric.io.ingest.ingest`.
    Raises FricError: When a file does not read, or there is no whole circle in it.
    """
    stated, output, sources = stated or StatedCircle(), Path(output), files_of(paths)
    refuse_ending(output, "HDF5")
    refuse_existing(None if append else output, force=force)
    held = read_circles(output) if append and output.exists() else []
    known = {test.sha256 for test in held}
    found: list[MeasuredCircle] = []
    warnings: list[Notice] = []
    samples = beside = 0
    for source in sources:
        if (digest := digest_of(source)) in known:
            warnings.append(THERE_ALREADY.found(str(source), record=""))
            continue
        part = part_of(mapping, source) if mapping and mapping.parts else mapping
        if mapping and not part:
            channels, motion = _of_axes(source, mapping, bad_cells)
            samples += len(channels["time"])
            found += _tests(channels, motion, stated, str(source), digest)
            continue
        refused, tests = list[FricError](), list[MeasuredCircle]()
        for table in tables(source, part.format if part else None):
            fields = {"stem": source.stem, "name": source.name, **table.constants}
            fields = part.fields(fields, str(source)) if part else fields
            try:
                chosen, text = circle_plan(table, part, stated.sampling, fields)
                channels = _whole(table, chosen, bad_cells == "drop", progress or (lambda _: None))
                against = _turned(channels, part)
                channels |= {name: -channels[name] for name in against}
                tests += _tests(channels, chosen.motion, stated, str(source), digest)
            except FricError as error:
                if RECORD not in table.said:
                    raise
                refused.append(error)  # strokes are beside the circle
                continue
            turned = [FORCE_BY_FILE.found(files=f"{source}, axis {name.partition('.')[0]}") for name in against]
            warnings += [*text, *table.notices, *turned]
            samples += len(next(iter(channels.values())))
        if refused and not tests:
            raise refused[0]
        found, beside = found + tests, beside + len(refused)
    if stated.radius is None:
        blind = [test for test in found if any(axis.reference is None for axis in test.axes.values())]
        warnings += [RADIUS_ASSUMED.found(test.source, radius=Estimate(test.radius, "m")) for test in blind]
    write_circles(output, [*held, *found], json.dumps(provenance() | {"format": FORMAT}), force=force or append)
    return IngestedCircles(str(output), tuple(found), samples, tuple(dict.fromkeys(warnings)), beside)


def _turned(channels: Mapping[str, Real], part: FileMapping | None) -> list[str]:
    """Return the forces and voltages by whose sign friction would drive the axis, unless a mapping states it."""
    against = []
    for name in (name for name in channels if name.endswith((".force", ".input"))):
        stated = part.columns[name].sign if part and name in part.columns else None
        if stated is None and (position := channels.get(f"{name.partition('.')[0]}.position")) is not None:
            (signs := Signs()).add({"time": channels["time"], "position": position, "force": channels[name]})
            against += [name] if signs.against() else []
    return against


def part_of(mapping: MappingDocument | None, source: Path) -> FileMapping | None:
    """Return the mapping, or its part, of a file that holds a circle test; None where it has none of it."""
    if mapping is None:
        return None
    with closing(tables(source, mapping.format)) as opened:
        return mapping.of_circle(source, {column.name for table in opened for column in table.columns})


def holds_circle(table: ForeignTable) -> bool:
    """Return whether the axes of a table run on whole circles for most of it."""
    try:
        tests, samples = circles_in(table, StatedCircle(within=(0.0, inf)))
    except FricError:
        return False
    return 2 * sum(len(test.axes[name].time) for test in tests for name in test.names[:1]) > samples


def circles_in(table: ForeignTable, stated: StatedCircle) -> tuple[list[MeasuredCircle], int]:
    """Return the circles of a table whose header names axes and units, and its number of samples."""
    chosen, _ = circle_plan(table, None, stated.sampling, table.constants)
    channels = _whole(table, chosen, False, lambda _: None)
    return [*_tests(channels, chosen.motion, stated, str(table.path), "")], len(next(iter(channels.values())))


def _of_axes(source: Path, mapping: MappingDocument, bad_cells: str) -> tuple[dict[str, Real], Motion]:
    """Return the channels of axes that parts of a mapping read, less forces in another unit, and the first's motion."""
    logs = dict[str, Log]()
    columns = {column.name for table in tables(source, mapping.format) for column in table.columns}
    with TemporaryDirectory() as folder:
        for axis in [part.axis for part in mapping.parts if part.axis and part.fits(source, columns)]:
            output = Path(folder) / "log.h5"
            ingest(source, output, mapping=mapping, axis=axis, bad_cells=bad_cells, force=True)
            logs[axis] = read_logs(output)[0]
    if len(logs) < 2 or len({len(log) for log in logs.values()}) > 1:
        raise FricError(
            f"the mapping reads {' and '.join(logs) or 'nothing'} in it, and a circle test takes two axes of one clock",
            where=str(source), hint="Give the mapping a part for each axis, or `kind: circle`.",
        )  # fmt: skip
    first = next(iter(logs.values()))
    return {"time": first.time} | {
        f"{axis}.{name}": values for axis, log in logs.items() for name, values in log.channels().items()
        if name != "force" or log.motion == first.motion
    }, first.motion  # fmt: skip


def _whole(table: ForeignTable, chosen: ColumnPlan, drop: bool, progress: Progress) -> dict[str, Real]:
    """Return all channels of a table in SI."""
    rows_of, clock, parts = WholeRows(table, chosen, drop), ClockCheck(table.place), []
    for block in table.read(chosen.wanted):
        good, rows = rows_of.good(block)
        if "time" in (channels := chosen.convert(good, rows)):
            clock.tick(channels["time"], rows)
        parts.append(channels)
        progress(block.size)
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


def _tests(
    channels: dict[str, Real], motion: Motion, stated: StatedCircle, source: str, digest: str
) -> Iterator[MeasuredCircle]:
    if set(BALL_BAR) <= channels.keys():
        yield _ball_bar(channels, stated, source, digest)
        return
    names = list(dict.fromkeys(name.partition(".")[0] for name in channels if name.endswith(".position")))[:2]
    time, unit = channels["time"], si_unit("force", motion)
    by = "reference" if all(f"{name}.reference" in channels for name in names) else "position"
    moved = [channels[f"{name}.{by}"] for name in names]
    circles = find_circles(time, moved[0], moved[1]) if len(moved) > 1 else []  # axes may have velocities alone
    if not circles:
        raise FricError(
            "there is no whole circle in it", where=source,
            hint="Record a whole revolution at steady feed, of both axes that make the circle.",
        )  # fmt: skip
    traces = {
        name: AxisTrace(
            time, **{of: channels[key] for of in CHANNELS[1:] if (key := f"{name}.{of}") in channels}, unit=unit
        )
        for name in names
    }
    for n, circle in enumerate(circles, start=1):
        cut = {name: trace.part(circle.samples) for name, trace in traces.items()}
        axes = {name: replace(trace, time=trace.time - trace.time[0]) for name, trace in cut.items()}
        radius = stated.radius or rounded(circle.radius, 1e-5 if by == "reference" else 2e-3)
        if stated.radius is None and not stated.within[0] <= radius <= stated.within[1]:
            size, hint = readable(radius, "m", 3), "Check the unit of its columns; where it is right, say `radius=`."
            raise FricError(f"the circle has a radius of {size}", where=source, hint=hint)
        yield MeasuredCircle(
            radius, stated.feed or rounded(circle.feed), stated.direction or circle.direction, axes,
            instrument=stated.instrument, scheme=stated.scheme, name=f"{Path(source).stem}-{n}", source=source,
            sha256=digest,
        )  # fmt: skip


def _ball_bar(channels: dict[str, Real], stated: StatedCircle, source: str, digest: str) -> MeasuredCircle:
    angle = np.unwrap(channels["angle"])
    if stated.radius is None:
        raise FricError("a ball bar's deviation does not tell the radius", where=source, hint="Say `radius='150 mm'`.")
    if abs(covered := float(angle[-1] - angle[0])) < 2 * pi - 0.02:
        raise FricError(
            f"the angle covers {np.degrees(abs(covered)):.0f}°, and a whole revolution is needed", where=source,
            hint="Is its unit right? Record a revolution and more.",
        )  # fmt: skip
    if (feed := stated.feed) is None and "time" in channels:
        time = channels["time"]
        rate = float(np.median(np.diff(angle) / np.diff(time))) or covered / (time[-1] - time[0])  # each logged twice
        feed = rounded(abs(rate) * stated.radius)
    if feed is None:
        raise FricError("a ball bar's deviation does not tell the feed", where=source, hint="Say `feed='100 mm/s'`.")
    return MeasuredCircle(
        stated.radius, feed, stated.direction or (1 if covered > 0 else -1), angle=angle,
        deviation=channels["deviation"], instrument="ball-bar", name=Path(source).stem, scheme=stated.scheme,
        source=source, sha256=digest,
    )  # fmt: skip
