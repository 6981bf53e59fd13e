"""A mapping as fric would guess it, with comments, to be checked and edited."""

import json
import re
import shlex
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, closing, suppress
from dataclasses import dataclass, replace
from fnmatch import fnmatch
from functools import partial
from itertools import chain, count
from pathlib import Path

import numpy as np

from fric.columns import CHANNELS, FORCE_VELOCITY, FORCE_VELOCITY_DIMENSIONS, KINDS, Kind, channel_dimension
from fric.documents.mapping import MappingDocument
from fric.errors import FricError, printable
from fric.flaws.files import MAPPING_ASSUMED, MAPPING_OPEN, MAPPING_PROPOSED
from fric.input import files_of
from fric.io.channels import plan
from fric.io.readers import tables
from fric.io.readers.base import OF_SEVERAL, RECORD, Column, ForeignTable, plain_name
from fric.io.recognise import is_hdf5
from fric.io.roles import LIKELY, SURE, AxisColumns, Role, axes_of, in_memory, is_supply, said_clock, take_reading
from fric.io.safe_hdf5 import open_file, text
from fric.io.words import (
    OF_MEANS,
    axis_of,
    axis_of_file,
    bare,
    in_counts,
    is_electrical,
    looking_like,
    measures,
    named_as,
    of_axis,
    said_axis,
    spoken,
    tags,
)
from fric.notice import Notice
from fric.units import MOTIONS, Motion, converts, in_units_of, is_scale, rotates, si_unit

NEEDED = ("time", "position", "velocity", "force")
"""Channels that need a question where they are not sure; other unsure channels are left out."""
NO_FORCE = "no column is a force, a torque, a current or a voltage of the axis that moves, with its sign"
"""Why a record of a motion shows no friction."""
NO_POSITION = "no column looks like the position"
AT_REST = "the axis does not move: what was logged is noise"
JOINED = "joined"  # Folder of files that fric joined, and their attribute that lists the parts
NO_SCALE = "say what one is, as in scale:"
BESIDE = 0.97  # Likelihood of a unit that other files of a folder give to the same quantity, and none another
MOST_MEANS = 500  # Rows of a table of velocities and forces without samples, at most
MOST_FILES = 16  # Number of files of the same columns whose values are read
_quoted = partial(json.dumps, ensure_ascii=False)


@dataclass(frozen=True)
class Guess:
    """What is guessed of one axis of files that have the same columns."""

    files: tuple[Path, ...]  # The files
    table: ForeignTable  # One of the files, for its columns
    axis: AxisColumns
    named: bool  # Whether the names show the axis
    kind: str = ""  # The kind of the record, where the columns show it
    joined: tuple[tuple[ForeignTable, AxisColumns], ...] = ()  # Of files that hold a part of the channels each

    @property
    def column_names(self) -> list[str]:
        """Names of the columns that are read."""
        return [self.table.columns[n].name for n in self.axis.columns]

    @property
    def open(self) -> dict[str, object]:
        """What is open of it: the likeliest answer, and the others; with what is equal where an answer settles both."""
        found = dict[str, object]()
        moves = bool({"position", "velocity"} & self.axis.roles.keys())
        missing = [] if moves else [AT_REST if self.axis.rests else NO_POSITION]
        missing += [] if "time" in self.axis.roles or self.kind else ["no column looks like the time"]
        found |= dict.fromkeys(missing, (self.files, self.axis.name))
        for channel, role in wanted_roles(self.axis).items() if moves else ():
            name = f"'{self.table.columns[role.column].name}'" if role.column is not None else "the sampling period"
            if role.likelihood < SURE and channel in NEEDED:
                beside = " or ".join(_other(self.table, role, n) for n in role.others)
                is_it = f"{name} ({role.likelihood:.0%}{', or ' + beside if beside else ''})"
                found[f"the {channel} is {is_it}"] = self.files, channel, self.stems(role)
            if channel in NEEDED and not _known_unit(role, self.axis.motion):
                others = f", or {', '.join(role.units)}" if role.units else ""
                unit = f"is in {role.unit} ({role.unit_likelihood:.0%}{others})" if role.unit else "has no unit"
                unit = unit if role.column is not None or role.unit else "is not in the file"
                turning = next((column.name for column in self.table.columns if is_electrical(column)), "")
                unit += f": '{turning}' counts turns of pole pairs" * bool(turning and not role.unit)
                column = self.table.columns[role.column] if role.column is not None else Column("")
                if (volts := converts(column.unit, "input")) or (in_counts(column) and channel != "force"):
                    likely = "0.1 N" if channel == "force" else "0.0055 deg"
                    unit = f'is in {"V" if volts else "counts"}: {NO_SCALE} "{likely}"'
                elif role.unit == "count":
                    unit = f"has no unit: friction is in its counts ({role.unit_likelihood:.0%}{others})"
                of_motion = channel in {"position", "velocity"} and self.axis.readings
                of_all = self.files if channel == "time" else (role.unit, role.units)
                of = replace(self.axis.readings[0], weight=1.0) if of_motion else (channel, of_all)
                found[f"{name} ({channel}) {unit}"] = of
        return found

    def stem(self, column: int | None) -> str:
        """Return the name of a column without that of its axis, as other axes of the file have it."""
        axis = re.escape(self.axis.name.removeprefix("axis"))
        name = "" if column is None else self.table.columns[column].name
        return re.sub(rf"(?i)(?<![a-z]){axis}(?![a-z0-9])|(?<=[a-z]){axis}(?!\d)", "#", name) if axis else name

    def plain(self, column: int | None) -> str:
        """Return the same without what joins them."""
        return re.sub(r"[\W_]*#[\W_]*", "", self.stem(column))

    def stems(self, role: Role) -> frozenset[str]:
        """Return the names, without that of the axis, of the columns that a role may be."""
        return frozenset(map(self.stem, (role.column, *role.others)))

    @property
    def whole(self) -> bool:
        """Whether it can be read where the likeliest is taken."""
        roles, motion = self.axis.roles, self.axis.motion
        if not {"position", "velocity"} & roles.keys() or not (self.kind or "time" in roles):
            return False
        wanted, columns = wanted_roles(self.axis).values(), self.table.columns
        counts = any(r.column is not None and in_counts(columns[r.column]) and r.unit_likelihood < 0.5 for r in wanted)
        return not counts and all(role.unit and _fits(role, motion) for role in wanted)

    @property
    def contradicts(self) -> bool:
        """Whether values contradict a unit that a header states."""
        open_of = (r for of, r in self.axis.roles.items() if of in NEEDED[1:] and r.unit_likelihood < SURE)
        return any(self.table.columns[r.column or 0].unit and _fits(r, self.axis.motion) for r in open_of)

    @property
    def sure(self) -> bool:
        """Whether nothing is open, and no column that is named a force is left out."""
        rest = [column for n, column in enumerate(self.table.columns) if n not in self.axis.columns]
        unread = "force" not in self.axis.roles and any(named_as(column) == "force" for column in rest)
        return not (self.open or unread)


def _other(table: ForeignTable, role: Role, n: int) -> str:
    return f"'{table.columns[n].name}'" + f" with sign: {role.others[n]}" * (role.others[n] != role.sign)


def _dimension(channel: str) -> str:
    return channel_dimension("force" if channel in {"deviation", "error"} else channel)


def _fits(role: Role, motion: Motion) -> bool:
    known = role.channel == "n" or role.column is None or is_scale(role.unit)  # what one logged unit is
    return known or converts(role.unit, _dimension(role.channel), motion)


def _known_unit(role: Role, motion: Motion) -> bool:
    return role.channel == "n" or (role.unit_likelihood >= SURE and _fits(role, motion))


def wanted_roles(axis: AxisColumns) -> dict[str, Role]:
    """Return the roles that are needed, and of the others those that are sure."""
    needed = {*NEEDED, "deviation", "error", "n"} - ({"velocity"} if "position" in axis.roles else set())
    free = {"reference", "velocity"}  # which have the unit of the position, or follow from it
    return {
        channel: role for channel, role in axis.roles.items()
        if channel in needed or (role.likelihood >= SURE and _fits(role, axis.motion) and (
            role.unit_likelihood >= SURE or (channel in free and role.unit)))
    }  # fmt: skip


def guesses(
    paths: Sequence[Path], files: ExitStack, *, join: bool = False, refused: dict[Path, str] | None = None,
    beside: Iterable[Column] = (),
) -> list[Guess]:  # fmt: skip
    """Return the guesses for files, those of the same columns together, each of their axes apart.

    files: Keeps them open as long as their tables are needed.
    join: The files hold the channels of one record: each names those that it has.
    refused: Receives why files cannot be read, which are left out.
    beside: Columns of other files of the folder, whose units are those of columns without.
    """
    if join:
        opened = [next(files.enter_context(closing(tables(path, None)))) for path in paths]
        parts = tuple((table, _chosen(table)) for table in opened)
        motion = _motion([t.columns[r.column] for t, a in parts for r in a.roles.values() if r.column])
        return [Guess(tuple(paths), opened[0], AxisColumns("", motion, 1.0), False, joined=parts)]
    groups: dict[tuple[tuple[Column, ...], str | None], list[ForeignTable]] = {}
    for path in paths:
        try:
            with closing(tables(path, None)) as opened_file:
                for table in opened_file:  # which is read as long as its file is open
                    of_file = axis_of_file(path) or said_axis(table.constants)
                    of_axis = table.said["axis"] if OF_SEVERAL in table.said else of_file
                    key = tuple(table.columns), of_axis
                    held = in_memory(table, rows=len(groups.get(key, ())) < MOST_FILES)
                    groups.setdefault(key, []).append(held)
        except FricError as error:
            if refused is None:
                raise
            refused[path] = error.what
    found = [guess for members in groups.values() for guess in _of_group(members)]
    known: dict[str, set[str]] = {}
    for guess in found:
        for name in guess.column_names if guess.named else ():
            known.setdefault(name, set()).add(guess.axis.name)
    for guess in found:  # a file of this axis alone, beside one of several
        owners = {next(iter(known[name])) for name in guess.column_names if len(known.get(name, ())) == 1}
        if not guess.named and len(owners) == 1:
            guess.axis.name = owners.pop()
    _agree(found, _units_said([*beside, *(column for guess in found for column in guess.table.columns)]))
    for guess in found:
        _take_over(guess, [g for g in found if (g.axis.name, g.axis.motion) == (guess.axis.name, guess.axis.motion)])
    clocks = {guess.files: role for guess in found if (role := guess.axis.roles.get("time")) and role.column is not None
              and role.unit_likelihood >= SURE}  # fmt: skip
    for guess in found:  # each axis of a file has its clock
        if (
            (clock := clocks.get(guess.files))
            and (role := guess.axis.roles.get("time"))
            and role.column == clock.column
        ):
            guess.axis.roles["time"] = clock
    for guess, other in ((g, o) for g in found for o in found if g is not o and g.files == o.files):
        _as_beside(guess, other)
    for k, guess in enumerate(found):  # what is of the same files, of another motion or in other units, is another axis
        others = [g.axis.name for g in found[:k] if g.files == guess.files or _other_units(g, guess)]
        names = chain([guess.axis.name], (f"{guess.axis.name}{n}" for n in count(2)))
        guess.axis.name = next(name for name in names if name not in others)
    return found


def _as_beside(guess: Guess, other: Guess) -> None:
    """Give an axis without a reference the columns that are named as position and reference of another: yref, y."""
    (a, b), names = (other.axis.name, guess.axis.name), [column.name for column in guess.table.columns]
    roles, taken = other.axis.roles, dict[str, int]()
    for channel in ("position", "reference"):
        if (role := roles.get(channel)) is None or role.column is None or "reference" in guess.axis.roles:
            return
        name = other.table.columns[role.column].name
        alike = (name[:n] + b + name[n + 1 :] for n, letter in enumerate(name) if letter == a)
        if (found := next((text for text in alike if text in names), None)) is None:
            return
        taken[channel] = names.index(found)
    kept = {channel: role for channel, role in guess.axis.roles.items() if role.column not in taken.values()}
    guess.axis.roles = kept | {channel: replace(roles[channel], column=n) for channel, n in taken.items()}


def _units_said(columns: Iterable[Column]) -> dict[str, str]:
    """Return the unit of each quantity to which the columns of a folder give a single one."""
    said: dict[str, set[str]] = {}
    for column in columns:
        if (of := spoken(column)).quantity and (unit := column.unit or of.unit):
            said.setdefault(of.quantity, set()).add(unit)
    return {quantity: units.pop() for quantity, units in said.items() if len(units) == 1}


def _agree(found: Sequence[Guess], said: Mapping[str, str]) -> None:
    """Take what some files of a folder show for those whose columns have the same names: inputs, units of positions.

    said: The unit of each quantity that the columns of the folder say, and of which none says another.
    """
    driven = ((g, g.axis.roles["input"]) for g in found if "input" in g.axis.roles)
    inputs = {g.plain(role.column): role for g, role in driven if role.unit_likelihood >= SURE}
    for guess in found:  # u_x beside files with F and u, though alone it may be logged in place of a force
        roles = guess.axis.roles
        force = roles.get("force")
        means = force and of_axis(guess.table.columns[force.column or 0], guess.axis.name).means
        of = inputs.get(guess.plain(force.column)) if force and force.unit != "A" else None
        of = next(iter(inputs.values())) if means == "input" and len(inputs) == 1 else of  # x_u beside u_ctrl
        if force and means == "input" and said.keys() >= {"force", "input"}:
            of = replace(force, channel="input", unit=said["input"])
        if force and of:
            roles["input"] = replace(of, column=force.column, sign=force.sign, others=force.others)
            del roles["force"]
            guess.axis.motion = "rotary" if rotates(guess.axis.motion) else "linear"
    moved = [(g, g.plain(role.column), role) for g in found if (role := g.axis.roles.get("position"))]
    slides = any(g.named and not rotates(g.axis.motion) for g in found)  # so is an axis beside them without a name
    for guess, name, role in moved:
        other, _, known = max((p for p in moved if p[1] == name), key=lambda p: p[2].unit_likelihood)
        unit, unit_said = (rotates(other.axis.motion), known.unit), said.get("position", "")
        if role.column is None or guess.table.columns[role.column].unit:
            unit_said = ""
        if known.unit_likelihood < SURE and unit_said:
            unit = not converts(unit_said, "position"), unit_said
        if other is guess and not guess.named and slides:
            unit = next(((False, r.position) for r in guess.axis.readings if not rotates(r.motion)), unit)
        readings = [r for r in guess.axis.readings if (rotates(r.motion), r.position) == unit]
        readings = [r for r in readings if r.time == said.get("time")] or readings
        differs = other is not guess or unit[0] != rotates(guess.axis.motion) or unit[1] == unit_said
        if role.unit_likelihood < SURE and differs and readings:
            clock, share = (
                guess.axis.roles.get("time"),
                readings[0].weight / max(sum(r.weight for r in readings), 1e-300),
            )
            likely = BESIDE if unit[1] == unit_said else 0.0
            take_reading(guess.axis, readings[0], max(known.unit_likelihood, likely))
            if clock and clock.unit_likelihood < SURE:  # which a position does not tell
                guess.axis.roles["time"] = replace(guess.axis.roles["time"], unit_likelihood=share)
    for guess in found:
        for channel in ("time", "force"):
            role = guess.axis.roles.get(channel)
            if role is None or role.column is None or role.unit_likelihood >= SURE:
                continue
            column, others = guess.table.columns[role.column], dict.fromkeys((role.unit, *role.units))
            known_unit = "" if column.unit else said.get(spoken(column).quantity or "", "")
            if known_unit in others:
                others.pop(known_unit)
                why = "as in the files beside it"
                taken = replace(role, unit=known_unit, unit_likelihood=BESIDE, units=tuple(others), why=why)
                guess.axis.roles[channel] = taken
                if channel == "force":
                    guess.axis.motion = in_units_of("rotary" if rotates(guess.axis.motion) else "linear", known_unit)


def _take_over(guess: Guess, alike: Sequence[Guess]) -> None:
    """Give a guess what its values left open and files of its axis surely show of the same columns."""
    columns = guess.table.columns
    for other in alike:
        for channel, role in other.axis.roles.items():
            sure = role.column is not None and min(role.likelihood, role.unit_likelihood) >= SURE
            column = other.table.columns[role.column or 0]
            n = columns.index(column) if sure and column in columns else None
            held = guess.axis.roles.get(channel)
            lacks = n not in guess.axis.columns if held is None else held.column == n and held.unit_likelihood < SURE
            if n is not None and lacks:
                why = f"as in {other.files[0].name}"
                guess.axis.roles[channel] = replace(role, column=n, why=why, others={}, turn=0.0)


def _other_units(guess: Guess, other: Guess) -> bool:
    """Return whether records cannot be of one axis: of another motion, or with forces of other names without units."""
    both = guess, other
    forces = [g.axis.roles.get("force") for g in both]
    unknown = [role is not None and role.unit_likelihood < SURE for role in forces]
    names = [g.plain(f.column).rpartition(".")[2] for g, f in zip(both, forces, strict=True) if f is not None]
    logged = (
        {column.name.rpartition(".")[2] for column in g.table.columns} for g in reversed(both)
    )  # u_x beside F, of a drive with both
    alike = len({*names}) < 2 or any(name in of for name, of in zip(names, logged, strict=False))
    return guess.axis.motion != other.axis.motion or (all(unknown) and not alike)


def _of_group(members: Sequence[ForeignTable]) -> Iterator[Guess]:
    """Yield the guess for each axis of tables that have the same columns."""
    first, names = members[0], tuple(dict.fromkeys(table.path for table in members))
    by_name = _chosen(first)
    if _holds_means(first, by_name):
        yield _with_name(Guess(names, first, _chosen_means(first), False, FORCE_VELOCITY))
        return
    clocks = [clock.unit if (clock := said_clock(table.constants)) else "" for table in members]
    apart = len({*clocks}) > 1  # each file states its period
    alike = [table for table, clock in zip(members, clocks, strict=True) if clock == clocks[0]] if apart else members
    if len(axes := axes_of(alike[:MOST_FILES])) <= 1:
        axes = [_filled(first, axes[0], by_name) if axes else by_name]
    for axis in axes:
        if (time := axis.roles.get("time")) and time.column is None and time.unit:
            known = time.field or not apart  # else each file has another, and no field that a mapping can name
            wanted = time if apart else replace(time, field="")
            axis.roles["time"] = wanted if known else replace(time, unit="", unit_likelihood=0.0)
    found = [_with_name(Guess(names, first, axis, False), alone=len(axes) == 1) for axis in axes]
    forces = [(guess, guess.axis.roles["force"]) for guess in found if "force" in guess.axis.roles]
    sure = {guess.stem(force.column): force.unit for guess, force in forces if force.unit_likelihood > SURE}
    for guess, force in forces:  # as the drive of another axis logs it under the same name
        unit = sure.get(guess.stem(force.column), "N")
        if force.unit_likelihood < SURE and not unit.startswith("N"):
            guess.axis.roles["force"] = replace(force, unit=unit, unit_likelihood=0.97, units=())
            guess.axis.motion = in_units_of("rotary" if rotates(guess.axis.motion) else "linear", unit)
    yield from found


def _filled(table: ForeignTable, axis: AxisColumns, by_name: AxisColumns) -> AxisColumns:
    """Return what the values show of an axis, and the names that they leave open."""
    taken = axis.columns
    for channel, role in by_name.roles.items():
        n, by_unit = role.column or 0, "unit" in role.why and channel == "input"
        constant = channel in {"force", "input"} and is_supply(next(table.read([n])).columns[0], by_unit=by_unit)
        known = constant or spoken(table.columns[n]).quantity == "other"  # no input; what is of the axis, values show
        shown = channel == "velocity" or (channel == "position" and (axis.rests or "velocity" in axis.roles))
        if channel not in axis.roles and role.column not in taken and not (role.others or known or shown):
            axis.roles[channel] = role
    return axis


def _with_name(guess: Guess, *, alone: bool = True) -> Guess:
    """Return a guess with the name of its axis: from columns or files, else x."""
    name = guess.table.said.get("axis") or axis_of(*(bare(guess.table.columns[n]) for n in guess.axis.columns))
    shown = tags(guess.table.columns)
    known = {*"xyz"} if alone else {*shown} - {None}
    name = name or next((shown[n] for n in guess.axis.columns if shown[n] in known), None)
    if name is None and alone:
        stems, folders = zip(
            *((path.name.split(".")[0], f"axis {path.parent.name}") for path in guess.files), strict=True
        )
        name = axis_of_file(guess.files[0]) or said_axis(guess.table.constants) or axis_of(*stems) or axis_of(*folders)
        turns = rotates(guess.axis.motion) and guess.axis.motion_likelihood >= SURE
        name = None if name in {*"abc"} and not turns else name  # it is of runs
    name = f"axis{name}" if name and name.isdigit() else name
    guess.axis.name = name or ("x" if alone else f"axis{guess.axis.name}")
    return replace(guess, named=name is not None)


def proposal(paths: Sequence[Path], *, join: bool = False, assume: bool = False) -> str:
    """Return the text of a mapping that files may have, with what is uncertain in comments.

    assume: Take the likeliest of what is not sure.
    """
    with ExitStack() as files:  # a table is read as long as its file is open
        return mapping_text(guesses(files_of(paths), files, join=join), assume=assume)


def mapping_text(found: Sequence[Guess], *, assume: bool = False) -> str:
    """Return the text of the mapping of guesses: of several axes, or several kinds of files, in parts."""
    names = list(dict.fromkeys(path.name for guess in found for path in guess.files))
    more, join = ["…"] * (len(names) > 3), bool(found[0].joined)
    lines = [
        f"fric: {MappingDocument.type_name()}",
        f"# Guessed from {', '.join([*names[:3], *more])}. Look at every line; "
        "lines that say ? are for you to fill in. Then",
        f"#   fric ingest {' '.join([shlex.join(names[:3]), *more])} {'--join ' * join}--map THIS.yaml -o LOG.h5",
    ]
    if len(found) == 1:
        lines += _part(found[0], assume)
    else:
        lines.append("parts:")
        groups = len({guess.files for guess in found})
        for guess in found:
            part = _part(guess, assume)
            if groups > 1:
                part = [f"files: {_quoted(_pattern(guess, found))}", *part]
            lines += [f"{'  - ' if n == 0 else '    '}{line}" for n, line in enumerate(part)]
    return "\n".join(printable(line, 10_000) for line in lines) + "\n"


def _pattern(guess: Guess, found: Sequence[Guess]) -> str | list[str]:
    """Return a pattern of the names of files that fits these and none of the others; else their names."""
    matched = sorted({path.name for path in guess.files})
    first, last = matched[0], matched[-1]
    common = next(first[:n] for n in range(len(first), -1, -1) if last.startswith(first[:n]))
    others = {path.name for other in found for path in other.files} - {*matched}
    for pattern in (f"*{guess.files[0].suffix}", f"{common}*") if len(matched) > 1 else ():
        if all(fnmatch(name, pattern) for name in matched) and not any(fnmatch(name, pattern) for name in others):
            return pattern
    return matched if len(matched) > 1 else matched[0]


def _part(guess: Guess, assume: bool) -> list[str]:
    """Return the lines of the mapping of one guess."""
    axis, other = guess.axis, "linear" if rotates(guess.axis.motion) else "rotary"
    kind = f"kind: {guess.kind}" if guess.kind else f"# kind: {KINDS[0]}"
    force = axis.roles.get("force")
    plain = force is not None and not (assume or _known_unit(force, axis.motion))
    motion = axis.motion.partition("/")[0] if plain else axis.motion
    of_force = f"/{unit}: its forces are in {unit}" if (unit := motion.partition("/")[2]) else ""
    lines = [
        f"axis: {axis.name or 'x'}                     # {'by the names' if guess.named else 'guessed'}",
        f"motion: {motion}                # or {other}{of_force}",
        f"{kind}      # the experiment, where all files are of one; there are {', '.join(KINDS)}",
        "columns:",
    ]
    written: set[str] = set()
    parts = guess.joined or ((guess.table, axis),)
    for channel in FORCE_VELOCITY_DIMENSIONS if guess.kind else CHANNELS:
        for table, guess_of_table in parts:
            if channel in written or channel not in (kept := wanted_roles(guess_of_table)):
                continue
            written.add(channel)
            file = table.path.name if guess.joined and channel != "time" else ""
            lines.append(_line(table, kept[channel], axis.motion, file, assume=assume))
    if "time" not in written and not guess.kind:
        lines.append('  time: {rate: "? Hz"}      # no column looks like it: say the sampling rate, or the period')
    for channel in ("position", "force"):
        if channel not in written and not (channel == "position" and "velocity" in written):
            lines.append(f"  # {channel}: {{column: ?, unit: {si_unit(channel_dimension(channel), axis.motion)}}}")
    taken = {(table.path, role.column) for table, part in parts for role in wanted_roles(part).values()}
    left = [column.name for table, _ in parts for n, column in enumerate(table.columns) if (table.path, n) not in taken]
    if left:
        lines.append(f"# not read: {', '.join(left)}")
    if guess.table.constants:
        said = ", ".join(f"{k} = {v}" for k, v in guess.table.constants.items())
        lines.append(f"# the file says, for use as {{fields}}: {printable(said, 600)}")
    return lines


def _holds_means(table: ForeignTable, guess: AxisColumns) -> bool:
    """Return whether a table looks like mean forces at velocities: both, no time, and a deviation, an error or n.

    Without these three its velocities are in order, as no motion has them.
    """
    names = {OF_MEANS.get(plain_name(column.name), plain_name(column.name)) for column in table.columns}
    timed = guess.roles.get("time")
    named = timed is not None and timed.column is not None and named_as(table.columns[timed.column]) == "time"
    if named or not {"velocity", "force"} <= guess.roles.keys():
        return False
    if {"n", "deviation", "error"} & names:
        return True
    values = next((block.columns[0] for block in table.read([guess.roles["velocity"].column or 0])), np.empty(0))
    return 4 < len(values) < MOST_MEANS and int(np.count_nonzero(np.diff(np.sign(np.diff(values))))) <= 2


def _chosen_means(table: ForeignTable) -> AxisColumns:
    names = [OF_MEANS.get(plain_name(column.name), plain_name(column.name)) for column in table.columns]
    beside = [channel for channel in FORCE_VELOCITY_DIMENSIONS if channel in {"deviation", "error", "n"} & {*names}]
    columns = {channel: [names.index(channel)] for channel in beside}
    taken = [n for found in columns.values() for n in found]
    for channel in ("velocity", "force"):
        found = [names.index(channel)] if channel in names else looking_like(table, channel, taken)
        if found:
            columns[channel] = found
    return _by_names(table, columns)


def _chosen(table: ForeignTable) -> AxisColumns:
    """Return a column for each channel that looks like it by its name or unit, and what else does."""
    chosen: dict[str, list[int]] = {}
    for channel in LIKELY:
        if found := looking_like(table, channel, tuple(group[0] for group in chosen.values())):
            chosen[channel] = found
    return _by_names(table, chosen)


def _by_names(table: ForeignTable, columns: dict[str, list[int]]) -> AxisColumns:
    motion = _motion([table.columns[column[0]] for column in columns.values()])
    roles = {}
    for channel, (n, *others) in columns.items():
        column, measured = table.columns[n], _dimension(channel)
        fits = channel == "n" or converts(column.unit, measured, motion)
        why = "by its name" if named_as(column) in {channel, measured} else "by its unit"
        sure = 0.5 if others or not (fits or measures(column, measured)) else 0.97
        roles[channel] = Role(
            channel, n, (column.unit or "") if fits else "", sure, float(fits), why, others=dict.fromkeys(others, 1)
        )
    return AxisColumns("", motion, 1.0, roles)


def _motion(columns: Sequence[Column]) -> Motion:
    """Return the motion that more of the units are of."""
    units = [(column.unit, channel) for column in columns for channel in ("position", "velocity", "force")]
    return max(MOTIONS, key=lambda motion: sum(converts(*of, motion) for of in units))


def _line(table: ForeignTable, role: Role, motion: Motion, file: str, *, assume: bool) -> str:
    """Return the line of a channel, with its reasons and alternatives."""
    if role.column is None:
        known = role.unit and (assume or role.unit_likelihood >= SURE)
        why = role.why if role.unit else "no column looks like it: say the rate, or the period"
        why += f": {role.unit} ({role.unit_likelihood:.0%})" if role.unit and not known else ""
        period = f"period: {_quoted(role.unit if known else '? ms')}"
        return f"  time: {{{(known and role.field) or period}}}      # {why}"
    column = table.columns[role.column]
    unique = [other.name for other in table.columns].count(column.name) == 1
    named = _quoted(column.name) if unique and column.name.isprintable() and column.name else str(role.column)
    said = f", file: {_quoted(file)}" if file else ""
    if role.channel == "n":
        return f"  n: {{column: {named}}}      # samples of each mean"
    measured = _dimension(role.channel)
    si = si_unit(measured, motion)
    why = role.why
    if is_scale(role.unit):  # what one logged unit is
        unit = f"scale: {_quoted(role.unit)}"
    elif _known_unit(role, motion) or (assume and role.unit):
        unit = f"unit: {_quoted(role.unit)}"
        why += "" if role.unit_likelihood >= SURE else f"; in {role.unit} by likelihood ({role.unit_likelihood:.0%})"
    elif column.unit and not converts(column.unit, measured, motion):
        unit = f'scale: "? {si}"'
        why += f'; logged in {column.unit}: say what one of these is, as in scale: "0.1 {si}"'
    else:
        likely = ", ".join(text for text in (role.unit, *role.units) if text)
        unit = 'unit: "?"'
        given = f"says {column.unit}, which the values contradict" if column.unit else "gives no unit"
        why += f"; the file {given}: {likely or 'as ' + si}"
    why += f" ({role.likelihood:.0%} sure)" if role.likelihood < SURE else ""
    why += "".join(f"; or {_other(table, role, k)}" for k in role.others)
    sign = ""
    if role.sign < 0:
        sign, why = ", sign: -1", why + "; turned, for it counts the other way"
    elif measured == "force" and assume:
        sign = ", sign: 1"
    elif measured == "force":
        why += "; add sign: -1 where it counts the other way"
    wraps = f", wraps: {role.turn:.9g}" if role.turn and role.channel in {"position", "reference"} else ""
    return f"  {role.channel}: {{column: {named}, {unit}{sign}{wraps}{said}}}      # {why}"


@dataclass(frozen=True)
class Guessed:
    """The guesses for files whose headers do not define their columns."""

    found: tuple[Guess, ...]

    @property
    def sure(self) -> bool:
        """Whether nothing is open."""
        return all(guess.sure for guess in self.found)

    @property
    def usable(self) -> tuple[Guess, ...]:
        """Those that can be read where the likeliest is taken."""
        return tuple(guess for guess in self.found if guess.whole)

    def text(self) -> str:
        """Return the mapping with the likeliest of what is open."""
        return mapping_text(self.usable, assume=True)

    def notices(self, mapping: str = "") -> list[Notice]:
        """Return what was assumed, and what was sure."""
        assumed, sure = dict[str, list[str]](), dict[str, dict[Path, None]]()
        for guess in self.usable:
            columns, roles = guess.table.columns, guess.axis.roles.items()
            named = [(f'{k} is "{columns[r.column].name}"', r.sign < 0) for k, r in roles if r.column is not None]
            turned = [f"{text}, turned" for text, against in named if against]
            means = [f"check {mapping}"] if mapping else [text for text, against in named if not against]
            if guess.open:
                assumed.setdefault(first_of(guess.files), []).extend([*guess.open, *turned])
            else:
                sure.setdefault(", ".join([*means, *turned]), {}).update(dict.fromkeys(guess.files))
        of_files = assumed.items()
        found = [MAPPING_ASSUMED.found(files=files, what="; ".join(what), mapping=mapping) for files, what in of_files]
        return found + [MAPPING_PROPOSED.found(means=how, files=first_of([*files])) for how, files in sure.items()]

    def asked(self) -> list[Notice]:
        """Return what is open, a notice for files of one kind."""
        return [
            MAPPING_OPEN.found(files=first_of(guess.files), what="; ".join(guess.open) or "another of its axes")
            for guess in self.found
        ]

    def error(self) -> FricError:
        """Return all that is open in one error, with the mapping to fill in."""
        files = list(dict.fromkeys(path for guess in self.found for path in guess.files))
        n = len({settled for guess in self.found for settled in guess.open.values()})
        what = f"{len(files)} files do not say what their" if len(files) > 1 else "it does not say what its"
        asked = f"{n} question{'s are' if n > 1 else ' is'} open" if n else NO_FORCE
        return FricError(
            f"{what} columns are: {asked}", where="" if len(files) > 1 else first_of(files),
            hint="Say `assume=True` to take the likeliest, or fill in this mapping and give it with `mapping=` "
            "(fric ingest FILES --propose MAP.yaml writes it).", form=mapping_text(self.found),
        )  # fmt: skip


def first_of(files: Sequence[Path]) -> str:
    """Return the first of files as the user has it, and how many more there are; of one that was joined its parts."""
    first = str(files[0])
    if files[0].parent.name == JOINED:
        with suppress(FricError), open_file(files[0]) as opened:
            first = text(opened.attrs, JOINED, first)
    return first + (f" and {len(files) - 1} more" if len(files) > 1 else "")


def guessed(
    paths: Sequence[Path], files: ExitStack, kind: Kind | None = None, motion: Motion | None = None, *,
    assume: bool = False, every: bool = False, refused: dict[Path, str] | None = None, beside: Iterable[Path] = (),
) -> Guessed:  # fmt: skip
    """Return the guesses for those files whose header does not define their columns, or for ``every`` file.

    Those of fric, and files whose header cannot be read, are skipped. In a file whose header defines all but the force
    (a current counts as force), the force is taken where it is sure, or where the likeliest is to be ``assume``d.

    beside: Other files of the folder, whose units are those of columns without.
    """
    asking, free = [], set[Path]()
    for path in paths:
        try:
            said = not is_hdf5(path) and (None if every else says_all(path, kind, motion))
        except FricError:
            continue
        if said is None or said == "force":
            asking.append(path)
            free |= {path} if said else set()
    found = guesses(asking, files, refused=refused, beside=chain(*map(_columns, beside))) if asking else []
    for guess in found if kind == "frequency-response" else ():  # it has an input, by its name alone where need be
        roles, columns = guess.axis.roles, guess.table.columns
        named = [n for n, column in enumerate(columns) if spoken(column).quantity == "input"]
        if len(named) == 1:
            if (push := roles.get("force")) and push.column in named:
                del roles["force"]
                guess.axis.motion = "rotary" if rotates(guess.axis.motion) else "linear"
            roles["input"] = Role("input", named[0], columns[named[0]].unit or "V", 1.0, 1.0, "by its name")
    return Guessed(tuple(g for g in found if assume or g.sure or g.contradicts or not free.issuperset(g.files)))


def _columns(path: Path) -> list[Column]:
    with suppress(FricError), closing(tables(path, None)) as opened:
        return [*next(opened).columns]
    return []


def says_all(path: Path, kind: Kind | None = None, motion: Motion | None = None) -> str | None:
    """Return the channel that the header of a foreign file lacks: none, or the ``force``; None where unreadable."""
    left: str | None = None
    with closing(tables(path, None)) as opened:
        for table in opened:
            try:
                chosen = plan(table, None, kind, motion, {})
            except FricError:
                if left is not None and RECORD in table.said:  # of other columns, as a circle
                    continue
                return None
            left = left or ""
            rest = [column for n, column in enumerate(table.columns) if n not in chosen.wanted]
            if chosen.form == "time" and not {"force", "input"} & chosen.origins.keys():
                left = left or ("force" if any(spoken(column).quantity == "force" for column in rest) else "")
    return left


def axes_said(path: Path) -> list[str | None]:
    """Return the axes that a foreign file names for its tables; None alone where it has one table, or names none."""
    with suppress(FricError, StopIteration), closing(tables(path, None)) as opened:
        return [*next(opened).said.get(OF_SEVERAL, "").split()] or [None]
    return [None]
