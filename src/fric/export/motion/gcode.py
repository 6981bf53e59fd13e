"""G-code: straight blocks in inverse time (G93), so that a motion lasts as long as it was planned, and circles.

A block of G93 says how often it fits into a minute. The last digit is rounded down, so that no block is faster than
its motion; positions are rounded to what the control takes.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from math import floor, log10, sqrt

import numpy as np

from fric.export.motion.base import Arc, Dialect, Move, shown_scale
from fric.planning.waypoints import waypoints

LETTERS = "XYZABCUVW"

BLOCK = 16e-3
"""Time of a block at least [s]: sixty a second reach any control in time."""


@dataclass(frozen=True)
class Words:
    """How a control spells what all have."""

    ending: str  # Of the file
    decimals: int  # Digits of a position behind the point [mm, degrees]
    remark: str  # A comment, with ``{}`` for its text
    # first, last: lines before and behind, ``{number}`` and ``{name}`` filled in
    first: tuple[str, ...]
    last: tuple[str, ...]
    dwell: str  # A rest, with ``{}`` for its seconds

    def head(self, number: int, name: str, *remarks: str) -> Iterator[str]:
        """Yield the lines before a program's motion."""
        yield from (line.format(number=1000 + number, name=name.upper()) for line in self.first)
        yield from (self.remark.format(text) for text in (name, *remarks, "zero is the middle of the travel"))

    def file(self, name: str, lines: Iterator[str]) -> Mapping[str, str]:
        """Return a program as a file."""
        return {f"{name}.{self.ending}": "\n".join([*lines, *self.last]) + "\n"}


def rounded_down(value: float) -> str:
    """Return a positive number in six digits, never more than it is."""
    size = 10.0 ** (floor(log10(value)) - 5)
    return f"{floor(value / size * (1 + 1e-12)) * size:.{max(0, 5 - floor(log10(value)))}f}"


def letter(axis: str) -> str:
    """Return the letter that an axis has in G-code: its own, or X."""
    return axis.upper() if axis.upper() in LETTERS and len(axis) == 1 else "X"


def _move(words: Words, move: Move) -> Iterator[str]:
    scale, _ = shown_scale(move.motion)
    points, named = waypoints(move.reference, BLOCK), letter(move.axis)
    at = [f"{scale * z:.{words.decimals}f}" for z in points.position]
    begin, end = move.log
    remarks = [f"axis {move.axis}; log from {begin:.3f} to {end:.3f} s of the motion"]
    if move.excitation is not None:
        remarks.append(f"add the voltage of {move.name}-voltage.csv from the begin of the motion on")
    yield from words.head(move.number, move.name, *remarks)
    yield f"G94 G1 {named}{at[0]} F{rounded_down(60 * scale * move.approach)}"
    for n, lasting in enumerate(np.diff(points.time), 1):
        if at[n] == at[n - 1]:
            yield words.dwell.format(f"{lasting:.4f}")
        else:
            yield f"G93 G1 {named}{at[n]} F{rounded_down(60 / lasting)}"
    yield "G94"


def _arc(words: Words, arc: Arc) -> Iterator[str]:
    x, y = map(letter, arc.axes)
    edge = f"{1e3 * arc.radius / sqrt(2):.{words.decimals}f}"
    yield from words.head(arc.number, arc.name, f"{arc.revolutions} circles each way behind one that begins at rest")
    feed = 6e4 * arc.feed
    yield f"G94 G17 G1 {x}{edge} {y}-{edge} F{rounded_down(6e4 * arc.approach)}"
    for code in ("G3", "G2"):
        yield words.dwell.format("1.0000")
        for _ in range(arc.revolutions + 1):
            yield f"{code} {x}{edge} {y}-{edge} I-{edge} J{edge} F{rounded_down(feed)}"


def dialect(name: str, doc: str, words: Words) -> Dialect:
    """Return the dialect that a control's words make."""
    return Dialect(
        name, doc, lambda move: words.file(move.name, _move(words, move)),
        lambda arc: words.file(arc.name, _arc(words, arc)),
    )  # fmt: skip


LINUXCNC = dialect(
    "linuxcnc", "G-code for LinuxCNC",
    Words("ngc", 6, "({})", ("G21 G90 G40 G49 G64 P0.0005 Q0",), ("M2",), "G4 P{}"),
)  # fmt: skip
FANUC = dialect(
    "fanuc", "G-code for Fanuc and what is like it (inverse time, increments of 0.1 µm)",
    Words("nc", 4, "({})", ("%", "O{number} ({name})", "G21 G90 G40 G49 G64 G54"), ("M30", "%"), "G4 X{}"),
)  # fmt: skip
SIEMENS = dialect(
    "siemens", "G-code for SINUMERIK",
    Words("mpf", 6, "; {}", ("; %_N_{name}_MPF", "G71 G90 G40 G64 G54"), ("M30",), "G4 F{}"),
)  # fmt: skip
