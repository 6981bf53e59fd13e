"""A mapping as fric would guess it, with comments, to be looked at and edited."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from fric.documents.mapping import MappingDocument
from fric.errors import FricError
from fric.io.likely import MOTIONS, looking_like, named_as
from fric.io.readers import tables
from fric.io.readers.base import Column, Table
from fric.log import CHANNELS, KINDS, channel_dimension
from fric.output import staged
from fric.units import Motion, factor, si_unit

LIKELY = ("time", "reference", "position", "velocity", "force", "input")
"""Channels in the order in which columns are given to them."""


def proposal(paths: Sequence[Path]) -> str:
    """Return the text of a mapping that files of one kind may have, with what is uncertain in comments.

    Parameters
    ----------
    paths
        The files; the first tells the columns, and the others must have the same.

    Raises
    ------
    FricError
        When a file does not read, or the files differ in their columns.
    """
    if not paths:
        raise FricError("there is no file to make a mapping for")
    first = next(iter(tables(paths[0], None)))
    for path in paths[1:]:
        other = next(iter(tables(path, None)))
        if [c.name for c in other.columns] != [c.name for c in first.columns]:
            raise FricError(
                f"has the columns {other.listed(8)}, and {paths[0].name} has {first.listed(8)}", where=str(path),
                hint="Propose a mapping for files of one kind at a time.",
            )  # fmt: skip
    chosen, others = _chosen(first)
    motion = _motion([first.columns[n] for n in chosen.values()])
    lines = [
        f"fric: {MappingDocument.type_name()}",
        f"# Guessed from {paths[0].name}. Look at every line; lines that say ? are for you to fill in. Then",
        f"#   fric ingest {paths[0].name}{' …' * (len(paths) > 1)} --map THIS.yaml -o LOG.h5",
        "axis: x",
        f"motion: {motion}                # or {'linear' if motion == 'rotary' else 'rotary'}",
        f"# kind: {KINDS[0]}      # the experiment, where all files are of one; there are {', '.join(KINDS)}",
        "columns:",
    ]
    for channel in CHANNELS:
        if channel in chosen:
            lines += _line(first, channel, chosen[channel], others.get(channel, []), motion)
    if "time" not in chosen:
        lines.append('  time: {rate: "? Hz"}      # no column looks like it: say the sampling rate, or the period')
    for channel in ("position", "force"):
        if channel not in chosen and not (channel == "position" and "velocity" in chosen):
            lines.append(f"  # {channel}: {{column: ?, unit: {si_unit(channel_dimension(channel), motion)}}}")
    read = set(chosen.values())
    left = [column.name for n, column in enumerate(first.columns) if n not in read]
    if left:
        lines.append(f"# not read: {', '.join(left)}")
    if first.constants:
        lines.append(
            f"# the file says, for use as {{fields}}: {', '.join(f'{k} = {v}' for k, v in first.constants.items())}"
        )
    return "\n".join(lines) + "\n"


def propose(paths: Sequence[Path], output: Path, *, force: bool = False) -> str:
    """Write a proposal to a file, whole or not at all, and return its text."""
    text = proposal(paths)
    with staged(output, force=force) as draft:
        draft.write_text(text, encoding="utf-8")
    return text


def _chosen(table: Table) -> tuple[dict[str, int], dict[str, list[int]]]:
    """Return a column for each channel that one looks like, and what else does."""
    chosen: dict[str, int] = {}
    others: dict[str, list[int]] = {}
    for channel in LIKELY:
        found = looking_like(table, channel, tuple(chosen.values()))
        if channel == "time" and not found:
            found = _rising(table)
        if found:
            chosen[channel], others[channel] = found[0], found[1:]
    return chosen, others


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
        return sum(_fits(column.unit, channel, motion) for column in columns for channel in moving)

    return max(MOTIONS, key=fits)


def _fits(unit: str | None, channel: str, motion: Motion) -> bool:
    if not unit:
        return False
    try:
        factor(unit, channel_dimension(channel), motion)
    except FricError:
        return False
    return True


def _line(table: Table, channel: str, n: int, others: Sequence[int], motion: Motion) -> list[str]:
    column = table.columns[n]
    same = [k for k, other in enumerate(table.columns) if other.name == column.name]
    named = str(n) if len(same) > 1 or not column.name else '"' + column.name.replace('"', '\\"') + '"'
    si = si_unit(channel_dimension(channel), motion)
    if _fits(column.unit, channel, motion):
        unit, why = f'unit: "{column.unit}"', "by its name" if named_as(column) == channel else "by its unit"
    elif column.unit:
        unit, why = f'scale: "? {si}"', f'logged in {column.unit}: say what one of these is, as in scale: "0.1 {si}"'
    else:
        unit, why = 'unit: "?"', f"the file gives no unit: as {si}"
    beside = [f"'{table.columns[k].name}'" for k in others]
    text = why + (f"; or {', '.join(beside)}" if beside else "")
    text += "; add sign: -1 where it counts the other way" if channel == "force" else ""
    return [f"  {channel}: {{column: {named}, {unit}}}      # {text}"]
