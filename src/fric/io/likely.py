"""Which column of a foreign log looks like which channel: by its name, and by what its unit measures."""

import re
from collections.abc import Collection
from functools import cache

from fric.columns import channel_dimension
from fric.errors import FricError
from fric.io import words
from fric.io.readers.base import Column, Table, plain_name
from fric.units import PLAIN, converts, is_unit

ASKED = ("force", "position", "velocity")
"""Channels that are asked about, where a column that looks like one would be left out."""
AXES = "xyzabcuvw"
"""Letters that name axes of machine tools."""


def named_as(column: Column) -> str | None:
    """Return the channel that the name of a column tells; None where it tells none."""
    alone = column.name.removesuffix(f"_{column.unit}")
    parted = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", alone)  # ActPos is an actual position
    name = re.sub(r"[_\W]+", " ", plain_name(parted)).strip()
    for channel, known in words.CHANNELS.items():
        if any(re.search(_pattern(word, channel), name) for word in known):
            return channel
    return words.LETTERS.get(name)


@cache
def _pattern(word: str, channel: str) -> str:
    """Return the pattern of a word in a name; a long one may end a compound (Istlage), of a reference begin it."""
    if len(word) < 4:
        return rf"\b{word}\b"
    return rf"\b{word}|{word}\b" if channel == "reference" else rf"{word}\b"


def axis_of(*names: str) -> str | None:
    """Return the axis that names tell, as ``X actual position`` or ``y_strokes``; None where none does, or several do.

    A letter stands for an axis where it is the first or the last word and not the only one.
    """
    found = set()
    for name in names:
        parts = re.sub(r"[\W_]+", " ", plain_name(name)).split()
        found |= (
            {word for word in (parts[0], parts[-1]) if len(word) == 1 and word in AXES} if len(parts) > 1 else set()
        )
    return found.pop() if len(found) == 1 else None


def measures(column: Column, channel: str) -> bool:
    """Say whether the unit of a column is one of a channel."""
    unit = (column.unit or "").strip()
    if unit in {"", "1", "%", "-"} or not is_unit(unit):
        return False
    return any(converts(unit, channel_dimension(channel), motion) for motion in PLAIN)


def looking_like(table: Table, channel: str, taken: Collection[int]) -> list[int]:
    """Return the columns that look like a channel, those whose name tells it first; ``taken`` are none.

    A column whose name tells another channel is none, whatever its unit; time is told by its name or its unit.
    """
    by_name, by_unit = [], []
    for n, column in enumerate(table.columns):
        if n in taken:
            continue
        text = named_as(column)
        if channel == "reference" and not (text == channel and (not column.unit or measures(column, channel))):
            continue  # what has the unit of a position is a position first; the reference of a force is none
        if text == channel:
            by_name.append(n)
        elif (text is None or (text == "reference" and channel == "input")) and measures(column, channel):
            by_unit.append(n)
    return by_name + by_unit


def refuse_left_out(table: Table, origins: Collection[str], taken: Collection[int]) -> None:
    """Refuse a table of which a column that looks like force, position or velocity would be left out.

    table: The table, read by its header alone.
    origins: Channels that were found.
    taken: Columns that they were found in.
    Raises FricError: With the columns in question, and how to say what they are.
    """
    for channel in ASKED:
        if channel in origins or (channel == "velocity" and "position" in origins):
            continue
        found = [table.columns[n] for n in looking_like(table, channel, taken)]
        if not found:
            continue
        listed = " and ".join(f"'{one.name} [{one.unit}]'" if one.unit else f"'{one.name}'" for one in found)
        raise FricError(
            f"no column is named {channel}, and {listed} {'looks' if len(found) == 1 else 'look'} like it",
            where=str(table.path),
            hint="Say in a mapping (`mapping=`) which is what, or is left out; `fric ingest --propose` writes it.",
        )
