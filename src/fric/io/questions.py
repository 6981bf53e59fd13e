"""What physics leaves open of foreign logs, as questions: at most three, each with a picture of its columns."""

from collections.abc import Callable, Sequence
from contextlib import closing, suppress
from dataclasses import dataclass, replace
from functools import partial
from math import pi
from pathlib import Path
from typing import Any

import numpy as np

from fric.arrays import Real
from fric.documents.mapping import MappingDocument
from fric.documents.yaml import read_document
from fric.errors import FricError
from fric.io.propose import NEEDED, Guess, Guessed, first_of, wanted_roles
from fric.io.readers import tables
from fric.io.readers.base import Column
from fric.io.roles import SURE, AxisColumns, Role, take_reading
from fric.io.words import Reading, is_electrical, named_as
from fric.output import folder_made, written
from fric.units import PLAIN, Motion, converts, factor, in_units_of, is_scale, parse, rotates

MOST_POLES = 1000  # Pole pairs of a motor, at most
MOST_QUESTIONS = 3  # Largest number of questions; of the rest the likeliest answer is taken
NAME = "fric-mapping"  # Name of the mapping that answers become, in the folder of the logs
NO_TIME = Role("time", None, "", 1.0, 0.0, "as was answered")
_DOTS = np.array([[0x01, 0x08], [0x02, 0x10], [0x04, 0x20], [0x40, 0x80]])  # Bits of the dots of a character of braille


@dataclass(frozen=True)
class Question:
    """A question, and its answers with their meanings, the likeliest first."""

    text: str
    choices: Sequence[tuple[str, Any]]
    apply: Callable[[Any], None]  # Receives the meaning of an answer
    pictures: Sequence[Sequence[str]] = ()  # One, or one for each answer
    understood: Callable[[str], Any] = lambda _: None  # The meaning of other text; None where it has none

    def take(self, answer: str) -> bool:
        """Take an answer: a number, other text, or nothing for the first; return whether it is valid."""
        answer = answer.strip() or "1"
        number = int(answer) if answer.isdecimal() and len(answer) < 3 else 0
        found = self.choices[number - 1][1] if 0 < number <= len(self.choices) else self.understood(answer)
        if found is None:  # n for N
            found = next((value for text, value in self.choices if text.casefold() == answer.casefold()), None)
        if found is not None:
            self.apply(found)
        return found is not None

    def lines(self, *, drawn: bool) -> list[str]:
        """Return the question as lines of a terminal, with its pictures or without."""
        each = drawn and len(self.pictures) > 1
        lines = [self.text, *(self.pictures[0] if drawn and len(self.pictures) == 1 else ())]
        for n, (text, _) in enumerate(self.choices):
            lines += [f"  {n + 1}  {text}", *(f"     {line}" for line in (self.pictures[n] if each else ()))]
        return lines


@dataclass(frozen=True)
class Review:
    """Shows all that is guessed at once, in place of questions about columns."""

    state: Callable[[Guessed], Guessed]  # Returns what the user states in place of guesses
    others: Callable[[Question], None] | None = None  # Puts other questions; the first answer is taken without it

    def __call__(self, question: Question) -> None:
        """Put a question that is not about columns."""
        if self.others is None:
            question.take("")
        else:
            self.others(question)


Ask = Callable[[Question], None]  # Puts a question to the user, and has it take the answer; or shows all at once


def answered(guess: Guessed, ask: Ask, *places: Path, spent: int = 0) -> tuple[Path | None, Guessed]:
    """Ask what is open of files, and write the mapping of them all beside them; no file where nothing was asked.

    guess: What is guessed; the answers are put into it.
    places: Folders: the mapping is written into the first that lets it.
    spent: How many questions were asked before.
    """
    if isinstance(ask, Review):
        guess = ask.state(guess) if guess.found else guess
        return (_written(guess.text(), *places) if guess.found else None), guess
    count, most = 0, MOST_QUESTIONS - spent
    while count < most and (question := next(filter(None, (make(guess.found) for make in _ORDER)), None)):
        ask(question)
        count += 1
    return (_written(guess.text(), *places) if count and guess.usable else None), guess


def _written(text: str, *places: Path) -> Path | None:
    """Write a mapping into the first folder that lets it, and return its path."""
    for place in places:
        names = (place / f"{NAME}{f'-{n}' if n > 1 else ''}.yaml" for n in range(1, 1000))
        path = next(name for name in names if not name.exists())
        try:
            written(folder_made(place) / path.name, text)
            return path
        except FricError:
            if place is places[-1]:
                raise
    return None


def beside(path: Path) -> tuple[Path, list[str | None]] | None:
    """Return the mapping of earlier answers that is beside a file and fits it, and the axes that it has of the file."""
    folders = (path.parent, path.absolute().parent.parent)
    for file in [file for folder in folders for file in sorted(folder.glob(f"{NAME}*.yaml"))]:
        if axes := axes_mapped(read_document(file, MappingDocument), path):
            return file, axes
    return None


def axes_mapped(mapping: MappingDocument, path: Path) -> list[str | None]:
    """Return the axes that a mapping has of a file; none where it does not fit, or the file is no log."""
    with suppress(FricError), closing(tables(path, mapping.format)) as opened:
        names = [column.name for column in next(opened).columns]
        return list(dict.fromkeys(part.axis for part in mapping.all_of(path, names) if part.fits(path, names)))
    return []


def _named(guesses: Sequence[Guess]) -> str:
    """Return the axes and files of guesses, for a question."""
    axes = list(dict.fromkeys(guess.axis.name for guess in guesses))
    files = list(dict.fromkeys(Path(path.name) for guess in guesses for path in guess.files))
    text = f"axis {axes[0]}" if len(axes) == 1 else f"axes {', '.join(axes[:6])}"
    return f"{text} ({first_of(files)})"


def _of_rate(found: Sequence[Guess], *, known: bool = False) -> Question | None:
    """Ask for the sampling rate of files without a time; or whether the one ``known`` by their motion is right."""
    moving = [guess for guess in found if not guess.kind and {"position", "velocity"} & guess.axis.roles.keys()]
    times = [(guess, guess.axis.roles.get("time", NO_TIME)) for guess in moving]
    timeless = [(guess, of) for guess, of in times if of.column is None and bool(of.unit) == known]
    asked = [guess for guess, of in timeless if not known or of.unit_likelihood < SURE]

    def apply(period: float) -> None:
        for guess in asked:
            guess.axis.roles["time"] = replace(NO_TIME, unit=f"{period:.9g} s", unit_likelihood=1.0)

    if not asked:
        return None
    text, role = f"No column is the time. At which rate was {_named(asked)} sampled?", asked[0].axis.roles.get("time")
    choices = [(f"{role.unit} a sample, {role.why}", sampling_period(role.unit))] if known and role else []
    choices += [(rate, sampling_period(rate)) for rate in ("1 kHz", "4 kHz", "2 kHz", "500 Hz", "100 Hz")]
    return Question(text, choices, apply, understood=sampling_period)


def sampling_period(text: str) -> float | None:
    """Return a sampling period [s] from a rate or a period with its unit; None where it is neither."""
    for dimension, power in (("frequency", -1), ("time", 1)):
        with suppress(FricError, ZeroDivisionError):
            return found if 0.0 < (found := parse(text, dimension) ** power) < 1e3 else None
    return None


def _of_column(found: Sequence[Guess]) -> Question | None:
    """Ask which column a channel is."""
    open_ones = [
        (guess, role) for guess in found for role in wanted_roles(guess.axis).values()
        if role.channel in NEEDED and role.column is not None and role.likelihood < SURE
        and (role.others or role.channel == "time")
    ]  # fmt: skip
    if not open_ones:
        return None
    guess, role = open_ones[0]
    sure = replace(role, others={}, likelihood=1.0)
    taken = [sure, *(replace(sure, column=n, sign=sign) for n, sign in role.others.items())][:4]
    alike = [(other, its) for other, its in open_ones if other.stems(its) == guess.stems(role)]
    none = [("none, it was not logged", NO_TIME)] if role.channel == "time" and not role.others else []

    def apply(chosen: Role) -> None:
        for other, its in alike:
            if chosen is NO_TIME:
                other.axis.roles["time"] = chosen
                continue
            signs = {**its.others, its.column or 0: its.sign}
            n = next(n for n in signs if other.stem(n) == guess.stem(chosen.column))
            turned = chosen.sign * role.sign if chosen.column == role.column else 1
            other.axis.roles[its.channel] = replace(its, column=n, sign=turned * signs[n], others={}, likelihood=1.0)

    return Question(
        f"Which column is the {role.channel} of {_named([other for other, _ in alike])}?",
        [*((f"'{guess.table.columns[it.column or 0].name}'{', turned' * (it.sign < 0)}", it) for it in taken), *none],
        apply,
        [picture(_column(guess, role.column)) for role in taken],
    )


def _of_poles(found: Sequence[Guess]) -> Question | None:
    """Ask for the pole pairs of a motor whose velocity counts electrical turns; a position beside it is left out."""
    asked: list[tuple[Guess, Column]] = []
    for guess in found:
        speeds = [column for column in guess.table.columns if is_electrical(column) and named_as(column) == "velocity"]
        roles = [guess.axis.roles[of] for of in ("position", "velocity") if of in guess.axis.roles]
        asked += [(guess, column) for column in speeds[:1] if roles and not any(role.unit for role in roles)]
    if not asked:
        return None
    first, speed = asked[0]

    def apply(pairs: int) -> None:
        for guess, column in asked:
            turns = column.unit if converts(column.unit, "velocity", "rotary") else "rpm"
            n, unit, axis = guess.table.columns.index(column), f"{1.0 / pairs:.9g} {turns}", guess.axis
            axis.roles["velocity"] = Role("velocity", n, unit, 1.0, 1.0, "as was answered")
            axis.motion, axis.motion_likelihood = in_units_of("rotary", axis.motion.partition("/")[2]), 1.0
            axis.roles.pop("position", None)

    return Question(
        f"'{speed.name}' counts electrical turns. How many pole pairs has the motor of "
        f"{_named([guess for guess, _ in asked])}? Type any number.",
        [(f"{pairs} pole pair{'s' * (pairs > 1)}", pairs) for pairs in (1, 2, 3, 4)],
        apply,
        [picture(_column(first, first.table.columns.index(speed)))],
        lambda text: int(text) if text.isdecimal() and 0 < int(text) < MOST_POLES else None,
    )


def _of_units(found: Sequence[Guess]) -> Question | None:
    """Ask for the units of a motion, and with them whether it is linear or rotary."""
    if not (asked := [guess for guess in found if _is_open(guess)]):
        return None
    first, readings = asked[0], asked[0].axis.readings
    asked = [guess for guess in asked if replace(guess.axis.readings[0], weight=readings[0].weight) == readings[0]]
    likely = [reading for n, reading in enumerate(readings[:4]) if n < 2 or reading.weight > 0.02]

    position = _column(first, (first.axis.roles.get("position") or first.axis.roles["velocity"]).column)
    counts = "position" in first.axis.roles and bool(np.all(np.rint(position) == position))
    place = first.axis.roles.get("position", NO_TIME)
    volts = place.column is not None and converts(first.table.columns[place.column].unit, "input")
    speed = first.axis.roles.get("velocity", NO_TIME)
    said = speed.unit if speed.unit_likelihood >= SURE and converts(speed.unit, "velocity", "rotary") else ""

    def apply(reading: Reading) -> None:
        for axis in (guess.axis for guess in asked):
            if is_scale(reading.position) and not said:  # what a count is, and not what a speed is in
                axis.roles.pop("velocity", None)
            if not reading.velocity and axis.factor:  # nor does it tell the sampling period then
                axis.factor, axis.roles["time"] = None, NO_TIME
            take_reading(axis, reading)
        for guess in (guess for guess in found if guess not in asked and guess.files == first.files):
            of_clock = tuple(other for other in guess.axis.readings if other.time == reading.time)
            guess.axis.readings = of_clock or guess.axis.readings
            if of_clock and (time := guess.axis.roles.get("time")) and time.column is not None:
                guess.axis.roles["time"] = replace(time, unit=reading.time, unit_likelihood=1.0)

    def understood(text: str) -> Reading | None:
        if counts and text.isdecimal() and 0 < int(text) < 2**40:
            return replace(readings[0], motion="rotary", position=f"{1.0 / int(text):.9g} rev", velocity=said)
        if (volts or counts) and is_scale(text):
            moves = (motion for motion in PLAIN if converts(text.partition(" ")[2], "position", motion))
            return next((replace(readings[0], motion=motion, position=text, velocity="") for motion in moves), None)
        return next((r for r in readings if text in {r.position, r.velocity, r.motion}), None)

    return Question(
        f"In which units is the motion of {_named(asked)}?"
        + " Or how many counts has a turn, or what is a count, as 0.5 um?" * counts
        + " Or what does one volt mean, as 0.5 mm?" * volts,
        [(_meaning(first, reading), reading) for reading in likely],
        apply,
        [picture(position)],
        understood,
    )


def _is_open(guess: Guess) -> bool:
    """Return whether units of the motion are open."""
    roles = wanted_roles(guess.axis)
    shown = [roles[channel] for channel in ("time", "position", "velocity") if channel in roles]
    unsure = any(role.unit_likelihood < SURE for role in shown if role.column is not None)
    return unsure and len(guess.axis.readings) > 1


def _meaning(guess: Guess, reading: Reading) -> str:
    """Return units, and what they make of the motion in words that a technician can hold against the machine."""
    units = {"position": reading.position, "velocity": reading.velocity, "time": reading.time}
    columns = {
        channel: _column(guess, role.column) * factor(units[channel], channel, reading.motion)
        for channel, role in guess.axis.roles.items()
        if role.column is not None and units.get(channel)
    }
    size, words = (0.5 / pi, "turns") if rotates(reading.motion) else (1e3, "mm")
    speed, unit = (30.0 / pi, "rpm") if rotates(reading.motion) else (1e3, "mm/s")
    meanings = [f"moves {_round(np.ptp(columns['position']) * size)} {words}"] if "position" in columns else []
    if "velocity" in columns:
        meanings.append(f"{_round(np.quantile(np.abs(columns['velocity']), 0.98) * speed)} {unit} at most")
    meanings += [f"in {_round(np.ptp(columns['time']))} s"] if "time" in columns else []
    named = ", ".join(f"{channel} in {units[channel]}" for channel in columns)
    return f"{reading.motion}, {named}: {', '.join(meanings)} ({reading.weight:.0%})"


def _round(value: float) -> str:
    return f"{value:.0f}" if 100 <= value < 1e7 else f"{value:.3g}"


def _of_force(found: Sequence[Guess]) -> Question | None:
    """Ask for the unit of a force."""
    forces = [(guess, guess.axis.roles["force"]) for guess in found if "force" in guess.axis.roles and not guess.kind]
    forces = [(guess, role) for guess, role in forces if role.column is not None and role.unit_likelihood < SURE]
    if not forces:
        return None
    guess, first = forces[0]
    asked = [guess.axis for guess, role in forces if (role.unit, role.units) == (first.unit, first.units)]

    def motion(axis: AxisColumns, unit: str) -> Motion:
        return in_units_of("rotary" if rotates(axis.motion) else "linear", unit)

    def understood(unit: str) -> str | None:
        plain = unit.partition(" ")[2] if is_scale(unit) else unit
        return unit if all(converts(plain, "force", motion(axis, unit)) for axis in asked) else None

    def apply(unit: str) -> None:
        for axis in asked:
            axis.roles["force"] = replace(axis.roles["force"], unit=unit, unit_likelihood=1.0)
            axis.motion = motion(axis, unit)

    choices = [(unit, unit) for unit in (first.unit, *first.units) if understood(unit)]
    text = f"In which unit is '{guess.table.columns[first.column or 0].name}', the force of {_named([guess])}?"
    return Question(text, choices, apply, [picture(_column(guess, first.column))], understood) if choices else None


_ORDER = (_of_rate, _of_column, _of_poles, _of_units, _of_force, partial(_of_rate, known=True))


def _column(guess: Guess, n: int | None) -> Real:
    """Return the first values of a column that are numbers."""
    values = np.concatenate([block.columns[0] for block in guess.table.read([n or 0])])
    return values if len(values := values[np.isfinite(values)]) else np.zeros(1)


def picture(values: Real, width: int = 60, height: int = 8) -> list[str]:
    """Return a curve as lines of braille, of two by four dots a character, with its ends behind the first and last."""
    low, high = float(values.min()), float(values.max())
    rows = np.round((high - values) / ((high - low) or 1.0) * (4 * height - 1)).astype(int)
    edges = np.linspace(0, len(rows) - 1, 2 * width + 1).astype(int)
    dots = np.zeros((4 * height, 2 * width), int)
    for k in range(2 * width):
        part = rows[edges[k] : edges[k + 1] + 1]
        dots[part.min() : part.max() + 1, k] = 1
    bits = (dots.reshape(height, 4, width, 2) * _DOTS[None, :, None, :]).sum(axis=(1, 3))
    lines = ["".join(chr(0x2800 + item) for item in line) for line in bits]
    lines[0], lines[-1] = f"{lines[0]} {high:.4g}", f"{lines[-1]} {low:.4g}"
    return lines
