"""A mapping as fric would guess it, with comments, to be looked at and edited."""

import json
from collections.abc import Sequence
from contextlib import ExitStack, closing
from pathlib import Path
from typing import NamedTuple

import numpy as np

from fric.columns import CHANNELS, FORCE_VELOCITY, FORCE_VELOCITY_DIMENSIONS, KINDS, channel_dimension
from fric.documents.mapping import MappingDocument
from fric.errors import FricError, printable
from fric.io.likely import MOTIONS, axis_of, looking_like, measures, named_as
from fric.io.readers import tables
from fric.io.readers.base import Column, Table, plain_name
from fric.io.words import OF_MEANS
from fric.output import staged
from fric.units import Motion, converts, si_unit

LIKELY = ("time", "reference", "position", "velocity", "force", "input")
"""Channels in the order in which columns are given to them."""


def proposal(paths: Sequence[Path], *, join: bool = False) -> str:
    """Return the text of a mapping that files of one kind may have, with what is uncertain in comments.

    Parameters
    ----------
    paths
        The files; the first tells the columns, and the others must have the same.
    join
        The files hold the channels of one record: each tells those that it has.

    Raises
    ------
    FricError
        When a file does not read, or the files differ in their columns.
    """
    if not paths:
        raise FricError("there is no file to make a mapping for")
    with ExitStack() as files:  # a table is read as long as its file is open
        found = [next(files.enter_context(closing(tables(path, None)))) for path in paths]
        return _text(paths, found, join)


def _text(paths: Sequence[Path], opened: Sequence[Table], join: bool) -> str:
    """Return the text of a mapping of tables that are open."""
    first, *others = opened
    for other in others:
        if not join and [c.name for c in other.columns] != [c.name for c in first.columns]:
            raise FricError(
                f"has the columns {other.listed(8)}, and {paths[0].name} has {first.listed(8)}", where=str(other.path),
                hint="Propose a mapping for files of one kind at a time; or say --join, if they hold one record.",
            )  # fmt: skip
    found = {table.path: _chosen(table) for table in ([first, *others] if join else [first])}
    means = not join and _holds_means(first, found[first.path])
    if means:
        found[first.path] = _chosen_means(first)
    columns = [table.columns[n] for table in [first, *others] for n in found.get(table.path, _NONE).taken.values()]
    motion = _motion(columns)
    kind = f"kind: {FORCE_VELOCITY}" if means else f"# kind: {KINDS[0]}"
    axis = _axis(columns, paths)
    lines = [
        f"fric: {MappingDocument.type_name()}",
        f"# Guessed from {', '.join(path.name for path in found)}. Look at every line; lines that say ? are for you to "
        "fill in. Then",
        f"#   fric ingest {' '.join(path.name for path in found)}{' …' * (len(paths) > len(found))} "
        f"{'--join ' * join}--map THIS.yaml -o LOG.h5",
        f"axis: {axis or 'x'}" + f"                     # {'by the names' if axis else 'guessed'}",
        f"motion: {motion}                # or {'linear' if motion == 'rotary' else 'rotary'}",
        f"{kind}      # the experiment, where all files are of one; there are {', '.join(KINDS)}",
        "columns:",
    ]
    written: set[str] = set()
    for channel in FORCE_VELOCITY_DIMENSIONS if means else CHANNELS:
        for table in [first, *others]:
            if channel in written or channel not in found.get(table.path, _NONE).taken:
                continue
            written.add(channel)
            own = found[table.path]
            file = table.path.name if join and channel != "time" else ""
            lines += _line(table, channel, own, motion, file)
    if "time" not in written and not means:
        lines.append('  time: {rate: "? Hz"}      # no column looks like it: say the sampling rate, or the period')
    for channel in ("position", "force"):
        if channel not in written and not (channel == "position" and "velocity" in written):
            lines.append(f"  # {channel}: {{column: ?, unit: {si_unit(channel_dimension(channel), motion)}}}")
    if left := [
        column.name
        for table in ([first, *others] if join else [first])
        for n, column in enumerate(table.columns)
        if n not in found[table.path].taken.values()
    ]:
        lines.append(f"# not read: {', '.join(left)}")
    if first.constants:
        lines.append(
            f"# the file says, for use as {{fields}}: {', '.join(f'{k} = {v}' for k, v in first.constants.items())}"
        )
    return "\n".join(printable(line, 10_000) for line in lines) + "\n"


def propose(paths: Sequence[Path], output: Path, *, force: bool = False, join: bool = False) -> str:
    """Write a proposal to a file, whole or not at all, and return its text."""
    text = proposal(paths, join=join)
    with staged(output, force=force) as draft:
        draft.write_text(text, encoding="utf-8")
    return text


def sure_proposal(path: Path) -> str | None:
    """Return the text of the mapping that a file must have; None where anything in it would be a guess.

    It is sure of a table of time and position or velocity where one column alone looks like each channel, has a unit of
    it, and no column looks like a force without one.
    """
    with closing(tables(path, None)) as opened:
        table = next(opened)
        guess = _chosen(table)
        if "time" not in guess.taken or not {"position", "velocity"} & guess.taken.keys() or _holds_means(table, guess):
            return None
        for channel, n in guess.taken.items():
            if guess.others[channel] or not measures(table.columns[n], channel):
                return None
        return _text([path], [table], join=False)


def _axis(columns: Sequence[Column], paths: Sequence[Path]) -> str | None:
    """Return the axis that the names of columns tell, or else those of the files."""
    return axis_of(*(column.name for column in columns)) or axis_of(*(path.name.split(".")[0] for path in paths))


class _Guess(NamedTuple):
    """A column for each channel that one looks like, and what else does."""

    taken: dict[str, int]
    others: dict[str, list[int]]


_NONE = _Guess({}, {})


def _holds_means(table: Table, guess: _Guess) -> bool:
    """Say whether a table looks like mean forces at velocities: both, no time, and a deviation, an error or n."""
    names = {OF_MEANS.get(plain_name(column.name), plain_name(column.name)) for column in table.columns}
    timed = guess.taken.get("time")
    named = timed is not None and named_as(table.columns[timed]) == "time"
    return not named and {"velocity", "force"} <= guess.taken.keys() and bool({"n", "deviation", "error"} & names)


def _chosen_means(table: Table) -> _Guess:
    taken: dict[str, int] = {}
    names = [OF_MEANS.get(plain_name(column.name), plain_name(column.name)) for column in table.columns]
    for column in ("deviation", "error", "n"):
        if column in names:
            taken[column] = names.index(column)
    others: dict[str, list[int]] = {}
    for channel in ("velocity", "force"):
        found = [names.index(channel)] if channel in names else looking_like(table, channel, tuple(taken.values()))
        if found:
            taken[channel], others[channel] = found[0], found[1:]
    return _Guess(taken, others)


def _chosen(table: Table) -> _Guess:
    """Return a column for each channel that one looks like, and what else does."""
    chosen: dict[str, int] = {}
    others: dict[str, list[int]] = {}
    for channel in LIKELY:
        found = looking_like(table, channel, tuple(chosen.values()))
        if channel == "time" and not found:
            found = _rising(table)
        if found:
            chosen[channel], others[channel] = found[0], found[1:]
    return _Guess(chosen, others)


def _rising(table: Table) -> list[int]:
    """Return the first column whose values rise evenly from row to row."""
    for n in range(min(len(table.columns), 3)):
        block = next(iter(table.blocks([n])), None)
        if block is None:
            continue
        steps = np.diff(block.columns[0][:1000])
        if len(steps) > 8 and (steps > 0).all() and np.ptp(steps) < 0.01 * np.median(steps):
            return [n]
    return []


def _motion(columns: Sequence[Column]) -> Motion:
    """Return the motion that more of the units are of."""
    moving = ("position", "velocity", "force")

    def fits(motion: Motion) -> int:
        return sum(
            converts(column.unit, channel_dimension(channel), motion) for column in columns for channel in moving
        )

    return max(MOTIONS, key=fits)


def _quoted(text: str) -> str:
    return json.dumps(text, ensure_ascii=False)


def _line(table: Table, channel: str, guess: _Guess, motion: Motion, file: str) -> list[str]:
    n, others = guess.taken[channel], guess.others.get(channel, [])
    column = table.columns[n]
    same = [k for k, other in enumerate(table.columns) if other.name == column.name]
    named = str(n) if len(same) > 1 or not column.name.isprintable() or not column.name else _quoted(column.name)
    said = f", file: {_quoted(file)}" if file else ""
    if channel == "n":
        return [f"  n: {{column: {named}}}      # samples of each mean"]
    measured = "force" if channel in {"deviation", "error"} else channel
    si = si_unit(channel_dimension(measured), motion)
    if converts(column.unit, channel_dimension(measured), motion):
        unit, why = (
            f"unit: {_quoted(column.unit or '')}",
            "by its name" if named_as(column) == measured else "by its unit",
        )
    elif column.unit:
        unit, why = f'scale: "? {si}"', f'logged in {column.unit}: say what one of these is, as in scale: "0.1 {si}"'
    else:
        unit, why = 'unit: "?"', f"the file gives no unit: as {si}"
    beside = [f"'{table.columns[k].name}'" for k in others]
    text = why + (f"; or {', '.join(beside)}" if beside else "")
    text += "; add sign: -1 where it counts the other way" if channel == "force" else ""
    return [f"  {channel}: {{column: {named}, {unit}{said}}}      # {text}"]
