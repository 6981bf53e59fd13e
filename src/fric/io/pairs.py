"""Files that hold the channels of one record each: position in one, force in another, with the same clock and names."""

import re
from collections import Counter
from collections.abc import Collection, Iterator, Sequence
from contextlib import ExitStack, closing, suppress
from pathlib import Path
from typing import cast

import h5py
import numpy as np

from fric.arrays import Real
from fric.errors import FricError
from fric.flaws.files import FILES_JOINED
from fric.io.propose import JOINED
from fric.io.questions import Ask, Question
from fric.io.readers import tables
from fric.io.readers.base import Column, ForeignTable, Memory
from fric.io.readers.joined import Joined, SharedClock
from fric.io.roles import follows
from fric.io.words import LETTERS, spoken
from fric.notice import Notice
from fric.output import folder_made, staged

TOGETHER, PERHAPS = 0.45, 0.2  # How much of a force goes with sign(v) and acceleration: above the first in one record
CLEAR = 3  # Records in which the force goes with the motion, from which others of the same words are joined, too
MOST_PARTS = 6  # Files of a record at most
SAME_SPAN = 0.05  # Share of their span by which the clocks of files of one record begin or end apart at most


def with_joined(
    paths: list[Path], folder: Path | None, ask: Ask | None, *, assume: bool
) -> tuple[list[Path], list[Notice], int]:
    """Return files, with one of all channels in place of those that are of one record; what is said; questions put.

    The names of such files differ in a word, as ``run1_pos`` and ``run1_force``, their time has the same name and
    span, and the force goes with the motion, or does so in other records of these words: what is less sure is asked, or
    with ``assume`` taken and said.

    folder: Where files are written; None to join none.
    """
    followed, files_of = dict[tuple[Path, ...], float](), Counter(path.name for path in paths)
    for group in _alike(paths) if folder else ():
        with suppress(FricError), ExitStack() as files:
            followed[group] = follows(_together(group, files))
    shares = dict[tuple[Path, ...], float]()
    for group in sorted(followed, key=lambda group: -followed[group]):  # of groups that share a file the clearest
        if not any({*group} & {*other} for other in shares):
            shares[group] = followed[group]
    clear = Counter(_parts(group) for group, share in shares.items() if share >= TOGETHER)
    sure = {group for group, share in shares.items() if share >= TOGETHER or clear[_parts(group)] >= CLEAR}
    open_ones = [group for group, share in shares.items() if group not in sure and share > PERHAPS]
    wanted = [assume]
    if asks := bool(open_ones and ask and not assume):
        names = "; ".join(" + ".join(part.name for part in parts) for parts in open_ones[:3])
        text = f"Do these files hold one record each, by one clock? {names}"
        cast("Ask", ask)(Question(text, [("no", False), ("yes", True)], wanted.append))
    said = []
    for taken, assumed in ((sure, False), (open_ones if wanted[-1] else [], True)):
        joined = [group for group in followed if folder and group in taken]
        for parts in joined:
            whole = all(files_of[part.name] > 1 for part in parts)  # such files are in the folder of each record
            name = parts[0].parent.name if whole else "+".join(part.stem for part in parts)
            path = cast("Path", folder) / f"{name}.h5"
            with ExitStack() as files:
                _write(path, _together(parts, files), ", ".join(map(str, parts)))
            paths = [*(path for path in paths if path not in parts), path]
        if joined:
            share, first = shares[joined[0]], ", ".join(map(str, joined[0]))
            said.append(FILES_JOINED.found(first, share=share, assumed=assumed, more=len(joined) - 1))
    return paths, said, int(asks)


def _parts(group: Sequence[Path]) -> frozenset[str]:
    """Return the words in which the names of files differ."""
    words = [{*re.split(r"[\W_]+", path.stem.casefold())} for path in group]
    return frozenset(set.union(*words) - set.intersection(*words))


def _alike(paths: Collection[Path]) -> Iterator[tuple[Path, ...]]:
    """Yield files of a folder whose names differ in a word without digits, where that makes few of them.

    All of a folder that holds few, beside another of files of the same names, are alike, too.
    """
    groups: dict[tuple[Path, str, frozenset[str]], list[Path]] = {}
    folders: dict[Path, list[Path]] = {}
    for path in paths:
        folders.setdefault(path.parent, []).append(path)
    known = Counter(path.name for path in paths)
    for files in folders.values():
        if 1 < len(files) <= MOST_PARTS and max(known[path.name] for path in files) > 1:
            yield tuple(files)
    for path in paths:
        words = frozenset(re.split(r"[\W_]+", path.stem.casefold()))
        for word in words:
            if not re.search(r"\d", word):
                groups.setdefault((path.parent, path.suffix, words - {word}), []).append(path)
    yield from (tuple(group) for group in groups.values() if 1 < len(group) <= MOST_PARTS)


def _together(parts: Sequence[Path], files: ExitStack) -> ForeignTable:
    """Return the channels of files as one table; of files without a time in each see `_of_variables`.

    Raises FricError: When they are not parts of a record: a file has several tables or both motion and force, their
        times differ in name or span, or there is no motion or no force in them.
    """
    clocks, shown, spans = list[SharedClock](), list[set[str | None]](), list[tuple[float, float]]()
    times = set[Column]()
    for path in parts:
        table, *more = files.enter_context(closing(tables(path)))
        quantities = [spoken(column).quantity for column in table.columns]
        if more or quantities.count("time") != 1:
            return _of_variables(parts, files)
        n = quantities.index("time")
        clocks.append(SharedClock(table, n, label=path.stem))
        shown.append({"force" if quantity in {"force", "input"} else "motion" for quantity in quantities
                      if quantity in {"position", "velocity", "force", "input"}})  # fmt: skip
        stamps = [block.columns[0] for block in table.read([n])]
        spans.append((stamps[0][0], stamps[-1][-1]))
        times.add(table.columns[n])
    ends = np.array(spans)
    apart = float(np.ptp(ends, axis=0).max()) > SAME_SPAN * float(np.ptp(ends, axis=1).min())
    both = [*shown].count({"force"}), [*shown].count({"motion"})
    if len(times) > 1 or apart or not all(both) or sum(both) < len(parts):
        raise FricError("are not parts of a record", where=", ".join(map(str, parts)))
    table = Joined(parts[0], sorted(clocks, key=lambda clock: shown[clocks.index(clock)] == {"force"}))
    table.columns = (*times, *table.columns[1:])
    return table


def _of_variables(parts: Sequence[Path], files: ExitStack) -> Memory:
    """Return files of a variable each, which their names say, as ``q``, ``dq``, ``tau`` and ``t``, as one table.

    Raises FricError: When a name says none, the columns say another, two say the same, or no force or motion is there.
    """
    words = [re.split(r"[\W_]+", path.stem) for path in parts]
    columns, data, shown = list[Column](), list[Real](), list[tuple[str | None, bool]]()
    for path, parted in zip(parts, words, strict=True):
        name = " ".join(word for word in parted if any(word not in others for others in words))
        table, *more = files.enter_context(closing(tables(path)))
        said, count = spoken(Column(name)), len(table.columns)
        quantity = LETTERS.get(name, said.quantity)
        shown.append((quantity, said.commanded))
        if more or quantity is None or {spoken(c).quantity for c in table.columns} - {None, quantity}:
            raise FricError("is not a part of a record", where=str(path))
        name = f"{quantity} {name}" if name in LETTERS else name
        parts_of = [f" {c.name}" if c.name.isidentifier() else f"[{n}]" for n, c in enumerate(table.columns)]
        columns += [Column(name + part * (count > 1), c.unit) for part, c in zip(parts_of, table.columns, strict=True)]
        data += map(np.concatenate, zip(*(block.columns for block in table.read(range(count))), strict=True))
    quantities = {quantity for quantity, _ in shown}
    if "force" not in quantities or not quantities & {"position", "velocity"} or len({*shown}) < len(shown):
        raise FricError("are not parts of a record", where=", ".join(map(str, parts)))
    return Memory(parts[0], columns, data)


def _write(path: Path, table: ForeignTable, parts: str) -> None:
    """Write a table as datasets, with their units, and what it was joined of."""
    blocks = [block.columns for block in table.read(range(len(table.columns)))]
    folder_made(path.parent)
    with staged(path, force=True) as draft, h5py.File(draft, "w", locking=False) as file:
        file.attrs[JOINED] = parts
        for column, *values in zip(table.columns, *blocks, strict=True):
            data = file.create_dataset(column.name.replace("/", "∕"), data=np.concatenate(values))
            data.attrs.update({"unit": column.unit} if column.unit else {})
