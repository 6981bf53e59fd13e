"""Foreign traces of circle tests in, one circle test file out: every arc of a trace that is a whole circle."""

import json
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from math import pi
from pathlib import Path

import numpy as np

from fric.arrays import Real
from fric.circles.measured import AxisTrace, Instrument, MeasuredCircle
from fric.circles.revolutions import FoundCircle, find_circles, rounded
from fric.columns import BALL_BAR
from fric.documents.base import provenance
from fric.documents.mapping import MappingDocument
from fric.errors import FricError
from fric.estimate import Estimate
from fric.flaws.files import RADIUS_ASSUMED, THERE_ALREADY
from fric.io.audit import Clock
from fric.io.channels import Plan
from fric.io.circle import FORMAT, read_circles, write_circles
from fric.io.circle_columns import circle_plan
from fric.io.digest import digest_of
from fric.io.ingest_session import Progress
from fric.io.readers import tables
from fric.io.readers.base import Table
from fric.io.rows import WholeRows
from fric.notice import Notice
from fric.output import refuse_ending, refuse_existing


@dataclass(frozen=True)
class StatedCircle:
    """What the user says of a circle; None is found from the trace."""

    # radius, feed: nominal radius [m], and speed along the circle [m/s]
    radius: float | None = None
    feed: float | None = None
    direction: int | None = None  # 1 counter-clockwise, -1 clockwise
    sampling: float | None = None  # Samples a second of a trace without time [Hz]
    instrument: Instrument = ""  # What told the position
    scheme: str = ""  # Name of the compensation that was on; empty where it is not known


@dataclass(frozen=True)
class IngestedCircles:
    """What was read: the tests, the file they are in, and what the user should know."""

    output: str
    tests: tuple[MeasuredCircle, ...]
    samples: int
    warnings: tuple[Notice, ...]


def ingest_circles(
    paths: Iterable[Path] | Path,
    output: Path,
    *,
    mapping: MappingDocument | None = None,
    stated: StatedCircle | None = None,
    append: bool = False,
    bad_cells: str = "error",
    force: bool = False,
    progress: Progress | None = None,
) -> IngestedCircles:
    """Read traces of circle tests, or a ball bar's angle and radial deviation, into a circle test file.

    Parameters
    ----------
    paths
        Text (also ``.gz``, also LinuxCNC's sampler), MATLAB ``.mat``, Parquet. A trace may hold several circles.
    output
        The file that is written, whole or not at all.
    mapping
        What the columns mean. Without it the header must name axes and units, as in ``x_ref [mm], x_pos [mm]``.
    stated
        What is said of the circle and not found.
    append
        Add to the file.
    bad_cells, force, progress
        As in `fric.io.ingest.ingest`.

    Raises
    ------
    FricError
        When a file does not read, or there is no whole circle in it.
    """
    stated, output = stated or StatedCircle(), Path(output)
    sources = [Path(paths)] if isinstance(paths, str | Path) else [Path(path) for path in paths]
    refuse_ending(output, "HDF5")
    refuse_existing(None if append else output, force=force)
    if not sources:
        raise FricError("there is no file to ingest")
    held = read_circles(output) if append and output.exists() else []
    known = {test.sha256 for test in held}
    found: list[MeasuredCircle] = []
    warnings: list[Notice] = []
    samples = 0
    for source in sources:
        digest = digest_of(source)
        if digest in known:
            warnings.append(THERE_ALREADY.found(str(source), record=""))
            continue
        for table in tables(source, mapping.format if mapping else None):
            fields = {"stem": source.stem, "name": source.name, **table.constants}
            fields = mapping.fields(fields, str(source)) if mapping else fields
            chosen, text = circle_plan(table, mapping, stated.sampling, fields)
            warnings += text
            channels = _whole(table, chosen, bad_cells == "drop", progress or (lambda _: None))
            warnings += table.notices
            samples += len(next(iter(channels.values())))
            for test in _tests(channels, stated, str(source), digest):
                found.append(test)
    for test in found:
        warnings += _guesses(test, stated)
    write_circles(output, [*held, *found], json.dumps(provenance() | {"format": FORMAT}), force=force or append)
    return IngestedCircles(str(output), tuple(found), samples, tuple(dict.fromkeys(warnings)))


def _whole(table: Table, chosen: Plan, drop: bool, progress: Progress) -> dict[str, Real]:
    """Return all channels of a table in SI."""
    rows_of, clock, parts = WholeRows(table, chosen, drop), Clock(table.place), []
    for block in table.read(chosen.wanted):
        good, rows = rows_of.good(block)
        channels = chosen.convert(good, rows)
        if "time" in channels:
            clock.tick(channels["time"], rows)
        parts.append(channels)
        progress(block.size)
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


def _tests(channels: dict[str, Real], stated: StatedCircle, source: str, digest: str) -> Iterator[MeasuredCircle]:
    if set(BALL_BAR) <= channels.keys():
        yield _ball_bar(channels, stated, source, digest)
        return
    names = list(dict.fromkeys(name.partition(".")[0] for name in channels if name.endswith(".position")))[:2]
    time = channels["time"]
    by = "reference" if all(f"{name}.reference" in channels for name in names) else "position"
    circles = find_circles(time, channels[f"{names[0]}.{by}"], channels[f"{names[1]}.{by}"])
    if not circles:
        raise FricError(
            "there is no whole circle in it", where=source,
            hint="Record a whole revolution at steady feed, of both axes that make the circle.",
        )  # fmt: skip
    for n, circle in enumerate(circles, start=1):
        axes = {
            name: AxisTrace(
                time[circle.samples] - time[circle.samples][0],
                **{
                    channel: channels[f"{name}.{channel}"][circle.samples]
                    for channel in ("position", "reference", "input", "force")
                    if f"{name}.{channel}" in channels
                },
            )
            for name in names
        }
        yield _named(circle, axes, stated, source, digest, n, by == "reference")


def _named(
    circle: FoundCircle, axes: dict[str, AxisTrace], stated: StatedCircle, source: str, digest: str, n: int, exact: bool
) -> MeasuredCircle:
    radius = stated.radius or rounded(circle.radius, 1e-5 if exact else 2e-3)
    feed = stated.feed or rounded(circle.feed)
    return MeasuredCircle(
        radius, feed, stated.direction or circle.direction, axes, instrument=stated.instrument, scheme=stated.scheme,
        name=f"{Path(source).stem}-{n}", source=source, sha256=digest,
    )  # fmt: skip


def _ball_bar(channels: dict[str, Real], stated: StatedCircle, source: str, digest: str) -> MeasuredCircle:
    angle = np.unwrap(channels["angle"])
    if stated.radius is None:
        raise FricError("a ball bar's deviation does not tell the radius", where=source, hint="Say `radius='150 mm'`.")
    feed = stated.feed
    if feed is None and "time" in channels:
        time = channels["time"]
        feed = rounded(abs(float(np.median(np.diff(angle) / np.diff(time)))) * stated.radius)
    if feed is None:
        raise FricError("a ball bar's deviation does not tell the feed", where=source, hint="Say `feed='100 mm/s'`.")
    covered = float(angle[-1] - angle[0])
    if abs(covered) < 2 * pi - 0.02:
        raise FricError(
            f"the angle covers {np.degrees(abs(covered)):.0f}°, and a whole revolution is needed", where=source,
            hint="Is its unit right? Record a revolution and more.",
        )  # fmt: skip
    return MeasuredCircle(
        stated.radius, feed, stated.direction or (1 if covered > 0 else -1), angle=angle,
        deviation=channels["deviation"], instrument="ball-bar", name=Path(source).stem, scheme=stated.scheme,
        source=source, sha256=digest,
    )  # fmt: skip


def _guesses(test: MeasuredCircle, stated: StatedCircle) -> Iterator[Notice]:
    if test.is_ball_bar or stated.radius is not None or all(t.reference is not None for t in test.axes.values()):
        return
    yield RADIUS_ASSUMED.found(test.source, radius=Estimate(test.radius, "m"))
