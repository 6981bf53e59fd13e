"""What physics leaves open of foreign logs, as questions: at most three, each with a picture of its columns."""

from collections.abc import Callable, Sequence
from contextlib import closing, suppress
from dataclasses import dataclass, replace
from math import pi
from pathlib import Path

import numpy as np

from fric.arrays import Real
from fric.documents.mapping import MappingDocument
from fric.documents.yaml import read_document
from fric.errors import FricError
from fric.io.propose import NEEDED, Guess, Guessed, wanted_roles
from fric.io.readers import tables
from fric.io.roles import SURE, Role, take_reading
from fric.io.words import Reading
from fric.output import staged
from fric.units import converts, factor, in_units_of, parse, rotates

MOST = 3
"""Questions that are asked at most; of what is open then the likeliest is taken."""
NAME = "fric-mapping"
"""Name of the mapping that answers become, in the folder of the logs."""
RATES = ("1 kHz", "4 kHz", "2 kHz", "500 Hz", "100 Hz")
_DOTS = np.array([[0x01, 0x08], [0x02, 0x10], [0x04, 0x20], [0x40, 0x80]])
"""Bits of the dots of a character of braille."""


@dataclass(frozen=True)
class Choice:
    """An answer: its text, what follows from it, and a picture of its column where choices are columns."""

    text: str
    take: Callable[[], None]
    picture: Sequence[str] = ()


@dataclass(frozen=True)
class Question:
    """A question and its answers, the likeliest first; ``free`` takes what is typed in place of a number."""

    text: str
    choices: Sequence[Choice]
    free: Callable[[str], Callable[[], None] | None] = lambda _: None
    picture: Sequence[str] = ()

    def take(self, answer: str) -> bool:
        """Take an answer: a number, what ``free`` understands, or nothing for the first; say whether it is any."""
        answer = answer.strip() or "1"
        number = int(answer) if answer.isdecimal() and len(answer) < 3 else 0
        taken = self.choices[number - 1].take if 0 < number <= len(self.choices) else self.free(answer)
        if taken is not None:
            taken()
        return taken is not None


Ask = Callable[[Question], None]
"""Puts a question to the user, and has it take the answer."""


def answered(guess: Guessed, ask: Ask, *places: Path) -> Path | None:
    """Ask what is open of files, and write the mapping of them all beside them; None where nothing was asked.

    guess: What is guessed; the answers are put into it.
    ask: Puts a question.
    places: Folders: the mapping is written into the first that lets it.
    Raises FricError: When the mapping cannot be written.
    """
    count = 0
    while count < MOST and (question := next(filter(None, (make(guess.found) for make in _ORDER)), None)):
        ask(question)
        count += 1
    if not count or not guess.usable:
        return None
    for place in places:
        names = (place / f"{NAME}{f'-{n}' if n > 1 else ''}.yaml" for n in range(1, 1000))
        path = next(name for name in names if not name.exists())
        try:
            with staged(path) as draft:
                draft.write_text(guess.text(), encoding="utf-8")
            return path
        except (FricError, OSError):
            if place is places[-1]:
                raise
    return None


def beside(path: Path) -> tuple[Path, list[str | None]] | None:
    """Return the mapping of earlier answers that is beside a file and fits it, and the axes that it has of the file."""
    folders = (path.parent, path.absolute().parent.parent)
    for file in [file for folder in folders for file in sorted(folder.glob(f"{NAME}*.yaml"))]:
        document = read_document(file, MappingDocument)
        with closing(tables(path, None)) as opened:
            names = [column.name for column in next(opened).columns]
        if parts := [one for one in document.parts or [document] if one.fits(path, names)]:
            return file, [one.axis for one in parts]
    return None


def _named(guesses: Sequence[Guess]) -> str:
    """Return the axes and files of guesses, for a question."""
    axes = list(dict.fromkeys(one.axis.name for one in guesses))
    files = list(dict.fromkeys(path.name for one in guesses for path in one.files))
    text = f"axis {axes[0]}" if len(axes) == 1 else f"axes {', '.join(axes[:6])}"
    return f"{text} ({files[0]}{f' and {len(files) - 1} more' if len(files) > 1 else ''})"


def _of_rate(found: Sequence[Guess]) -> Question | None:
    """Ask for the sampling rate of files without a time."""
    lacking = [
        one for one in found
        if not one.kind and {"position", "velocity"} & one.axis.roles.keys()
        and ("time" not in one.axis.roles or not _unit(one, "time"))
    ]  # fmt: skip

    def take(text: str) -> Callable[[], None] | None:
        period = 0.0
        for dimension in ("frequency", "time"):
            with suppress(FricError, ZeroDivisionError):
                period = period or parse(text, dimension) ** (-1 if dimension == "frequency" else 1)
        if not 0.0 < period < 1e3:
            return None
        role = Role("time", None, f"{period:.9g} s", 1.0, 1.0, "as was answered")
        return lambda: [one.axis.roles.update(time=role) for one in lacking].clear()

    choices = [Choice(rate, taken) for rate in RATES if (taken := take(rate))]
    return Question(f"No column is the time. At which rate was {_named(lacking)} sampled?", choices, take) if (
        lacking) else None  # fmt: skip


def _unit(guess: Guess, channel: str) -> str:
    role = guess.axis.roles[channel]
    return role.unit or ("?" if role.column is not None else "")


def _of_column(found: Sequence[Guess]) -> Question | None:
    """Ask which column a channel is."""
    for guess in found:
        for channel in NEEDED:
            role = wanted_roles(guess.axis).get(channel)
            if role is None or role.column is None or role.likelihood >= SURE or not role.others:
                continue
            choices = [
                Choice(f"'{guess.table.columns[n].name}'", _taking(guess, replace(role, column=n, sign=sign, others={},
                       likelihood=1.0)), picture(_column(guess, n)))
                for n, sign in ({role.column: role.sign} | dict(role.others)).items()
            ]  # fmt: skip
            return Question(f"Which column is the {channel} of {_named([guess])}?", choices[:4])
    return None


def _taking(guess: Guess, role: Role) -> Callable[[], None]:
    return lambda: guess.axis.roles.update({role.channel: role})


def _of_units(found: Sequence[Guess]) -> Question | None:
    """Ask for the units of a motion, and with them whether it is linear or rotary."""
    if not (asked := [one for one in found if _is_open(one)]):
        return None
    first = asked[0]
    asked = [one for one in asked if _units(one) == _units(first)]
    likely = [one for one in first.axis.readings if one.weight > 0.02][:4]

    def taking(reading: Reading) -> Callable[[], None]:
        def take() -> None:
            for one in asked:
                take_reading(one.axis, reading)

        return take

    def free(text: str) -> Callable[[], None] | None:
        fits = [one for one in first.axis.readings if text in {one.position, one.velocity, one.motion}]
        return taking(fits[0]) if fits else None

    choices = [
        Choice(_meaning(first, one), taking(one)) for one in (likely if len(likely) > 1 else first.axis.readings[:2])
    ]
    moved = first.axis.roles.get("position") or first.axis.roles["velocity"]
    return Question(
        f"In which units is the motion of {_named(asked)}?", choices, free, picture(_column(first, moved.column))
    )


def _is_open(guess: Guess) -> bool:
    """Say whether units of the motion are open."""
    roles = wanted_roles(guess.axis)
    shown = [roles[channel] for channel in ("time", "position", "velocity") if channel in roles]
    unsure = any(one.unit_likelihood < SURE for one in shown if one.column is not None)
    return unsure and len(guess.axis.readings) > 1


def _units(guess: Guess) -> tuple[str, ...]:
    """Return the likeliest units of the motion."""
    reading = guess.axis.readings[0]
    return reading.motion, reading.time, reading.position, reading.velocity


def _meaning(guess: Guess, reading: Reading) -> str:
    """Return units, and what they make of the motion in words that a technician can hold against the machine."""
    roles, turns = guess.axis.roles, rotates(reading.motion)
    units = {"position": reading.position, "velocity": reading.velocity, "time": reading.time}
    named = [f"{channel} in {units[channel]}" for channel in units if channel in roles and units[channel]]
    told = []
    if p := roles.get("position"):
        span = float(np.ptp(_column(guess, p.column))) * factor(reading.position, "position", reading.motion)
        told.append(f"moves {_round(span / (2 * pi))} turns" if turns else f"moves {_round(1e3 * span)} mm")
    v = roles.get("velocity")
    if v and reading.velocity:
        top = float(np.quantile(np.abs(_column(guess, v.column)), 0.98))
        top *= factor(reading.velocity, "velocity", reading.motion)
        told.append(f"{_round(top * 30 / pi)} rpm at most" if turns else f"{_round(1e3 * top)} mm/s at most")
    clock = roles.get("time")
    if clock and clock.column is not None:
        span = float(np.ptp(_column(guess, clock.column))) * factor(reading.time or "s", "time")
        told.append(f"in {_round(span)} s")
    return f"{reading.motion}, {', '.join(named)}: {', '.join(told)} ({reading.weight:.0%})"


def _round(value: float) -> str:
    return f"{value:.0f}" if 100 <= value < 1e7 else f"{value:.3g}"


def _of_force(found: Sequence[Guess]) -> Question | None:
    """Ask for the unit of a force."""
    forces = [(one, one.axis.roles["force"]) for one in found if "force" in one.axis.roles and not one.kind]
    forces = [(one, role) for one, role in forces if role.column is not None and role.unit_likelihood < SURE]
    if not forces:
        return None
    guess, first = forces[0]
    asked = [one for one, role in forces if (role.unit, role.units) == (first.unit, first.units)]

    def taking(unit: str) -> Callable[[], None] | None:
        motions = {
            one.axis.name: in_units_of("rotary" if rotates(one.axis.motion) else "linear", unit) for one in asked
        }
        if not all(converts(unit, "force", motion) for motion in motions.values()):
            return None

        def take() -> None:
            for one in asked:
                role = one.axis.roles["force"]
                one.axis.roles["force"] = replace(role, unit=unit, unit_likelihood=1.0)
                one.axis.motion = motions[one.axis.name]

        return take

    choices = [Choice(unit, taken) for unit in (first.unit, *first.units) if (taken := taking(unit))]
    values, name = _column(guess, first.column), guess.table.columns[first.column or 0].name
    text = f"In which unit is '{name}', the force of {_named(asked)}?"
    return Question(text, choices, taking, picture(values)) if choices else None


_ORDER = (_of_rate, _of_column, _of_units, _of_force)


def _column(guess: Guess, n: int | None) -> Real:
    """Return the first values of a column that are numbers."""
    blocks = list(guess.table.read([n or 0]))
    values = np.concatenate([block.columns[0] for block in blocks]) if blocks else np.zeros(1)
    values = values[np.isfinite(values)]
    return values if len(values) else np.zeros(1)


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
    lines = ["".join(chr(0x2800 + one) for one in line) for line in bits]
    lines[0], lines[-1] = f"{lines[0]} {high:.4g}", f"{lines[-1]} {low:.4g}"
    return lines
