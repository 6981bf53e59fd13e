"""Planned motions for controllers: G-code in three dialects, tables in structured text, columns of CSV."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from math import floor, log10, sqrt

import numpy as np

from fric.arrays import Real
from fric.export.base import identifier, render
from fric.reference import Reference
from fric.units import Motion, rotates

SHORTEST = 8e-3  # Least time between two points [s]
TOLERANCE = 1e-7  # Largest deviation of straight pieces from the motion [m, rad], if the least time allows it
EVEN = 1e-6  # Share of the largest acceleration up to which the speed counts as constant
LETTERS = "XYZABCUVW"
BLOCK = 16e-3  # Least time of a block [s]: any control can process sixty per second
ROWS = 2048  # Largest number of rows of a motion; of a longer motion every n-th sample is written


@dataclass(frozen=True, eq=False)
class Waypoints:
    """Points of a motion, around the middle of its travel."""

    time: Real  # time, position, velocity: instants [s], positions [m] and velocities [m/s] there, each of shape (n,)
    position: Real
    velocity: Real


def waypoints(motion: Reference, shortest: float = SHORTEST) -> Waypoints:
    """Return the points of a motion, centred on zero.

    Straight pieces between them keep its speed, and change speed by no more than its acceleration allows: each piece
    has the mean speed of the motion over it.

    shortest: Time between two points at least [s].
    """
    a, sampling = motion.acceleration, motion.sampling
    even = np.abs(a) <= EVEN * float(np.abs(a).max(initial=0.0))
    bounds = [0, *(np.flatnonzero(np.diff(even.astype(int))) + 1).tolist(), len(a) - 1]
    least = max(round(shortest * sampling), 1)
    kept = [0]
    for first, last in pairwise(bounds):
        if even[first] and last - first > 2 * least:
            if first - kept[-1] >= least:
                kept.append(first)
            if len(a) - 1 - last >= least:
                kept.append(last)
            continue
        top = float(np.abs(a[first : last + 1]).max(initial=0.0))
        each = max(least, int(np.sqrt(8 * TOLERANCE / top) * sampling) if top > 0 else last - first)
        kept += [n for n in range(kept[-1] + each, last - least + 1, each) if n > first]
    kept.append(len(a) - 1)
    middle = 0.5 * float(motion.position.max() + motion.position.min())
    return Waypoints(motion.time[kept], motion.position[kept] - middle, motion.velocity[kept])


@dataclass(frozen=True, eq=False)
class Move:
    """A record: an axis runs along a motion around the middle of its travel, the zero of the work offset."""

    number: int  # number, name: number in the plan, from 1, and name of the record
    name: str
    axis: str  # axis, motion: name of the axis, and whether it is linear or rotary
    motion: Motion
    reference: Reference  # The motion
    log: tuple[float, float]  # The part that is logged [s]
    approach: float  # Speed with which its begin is approached, from anywhere in the travel [m/s, rad/s]
    excitation: Real | None = None  # Voltage added to the control voltage [V], shape (n,); None where there is none

    @cached_property
    def points(self) -> Waypoints:
        """The motion as a few points."""
        return waypoints(self.reference)

    @property
    def ends(self) -> tuple[float, float]:
        """Its begin and end, from the middle of the travel [m, rad]."""
        return float(self.points.position[0]), float(self.points.position[-1])


@dataclass(frozen=True)
class Arc:
    """Whole circles of two axes around the middle of their travel, begun and ended 45° before the first reversal."""

    number: int  # number, name: as of a `Move`
    name: str
    axes: tuple[str, str]  # Names of both axes
    radius: float  # radius, feed: radius [m] and speed [m/s]
    feed: float
    revolutions: int  # Circles each way: the first begins at rest
    approach: float  # As of a `Move` [m/s]

    @property
    def ends(self) -> tuple[float, float]:
        """Begin and end of the axes [m], at equal distances from the middle."""
        return self.radius / sqrt(2.0), self.radius / sqrt(2.0)


def shown_scale(motion: Motion) -> tuple[float, str]:
    """Return the factor and the unit of a position for people and machine tools: mm, or degrees."""
    return (1e3, "mm") if not rotates(motion) else (57.29577951308232, "deg")


def rounded_down(value: float) -> str:
    """Return a positive number rounded down to six digits."""
    size = 10.0 ** (floor(log10(value)) - 5)
    return f"{floor(value / size * (1 + 1e-12)) * size:.{max(0, 5 - floor(log10(value)))}f}"


def letter(axis: str) -> str:
    """Return the letter of an axis in G-code: its name, or X."""
    return axis.upper() if axis.upper() in LETTERS and len(axis) == 1 else "X"


@dataclass(frozen=True)
class GCode:
    """The G-code of a control."""

    name: str
    ending: str  # Of the file
    decimals: int  # Digits of a position behind the point [mm, degrees]
    remark: str  # A comment, with ``{}`` for its text
    first: tuple[str, ...]  # first, last: lines before and behind, ``{number}`` and ``{name}`` filled in
    last: tuple[str, ...]
    dwell: str  # A rest, with ``{}`` for its seconds

    def move(self, move: Move) -> Mapping[str, str]:
        """Return the program of a move."""
        scale, _ = shown_scale(move.motion)
        points, named = waypoints(move.reference, BLOCK), letter(move.axis)
        at = [f"{scale * z:.{self.decimals}f}" for z in points.position]
        begin, end = move.log
        remarks = [f"axis {move.axis}; log from {begin:.3f} to {end:.3f} s of the motion"]
        if move.excitation is not None:
            remarks.append(f"add the voltage of {move.name}-voltage.csv from the begin of the motion on")
        lines = [f"G94 G1 {named}{at[0]} F{rounded_down(60 * scale * move.approach)}"]
        for n, lasting in enumerate(np.diff(points.time), 1):
            still = at[n] == at[n - 1]
            lines.append(self.dwell.format(f"{lasting:.4f}") if still else
                         f"G93 G1 {named}{at[n]} F{rounded_down(60 / lasting)}")  # fmt: skip
        return self._file(move, remarks, [*lines, "G94"])

    def arc(self, arc: Arc) -> Mapping[str, str]:
        """Return the program of circles."""
        x, y = map(letter, arc.axes)
        edge = f"{1e3 * arc.radius / sqrt(2):.{self.decimals}f}"
        lines = [f"G94 G17 G1 {x}{edge} {y}-{edge} F{rounded_down(6e4 * arc.approach)}"]
        for code in ("G3", "G2"):
            turn = f"{code} {x}{edge} {y}-{edge} I-{edge} J{edge} F{rounded_down(6e4 * arc.feed)}"
            lines += [self.dwell.format("1.0000"), *[turn] * (arc.revolutions + 1)]
        return self._file(arc, [f"{arc.revolutions} circles each way behind one that begins at rest"], lines)

    def _file(self, of: Move | Arc, remarks: list[str], lines: list[str]) -> Mapping[str, str]:
        head = [line.format(number=1000 + of.number, name=of.name.upper()) for line in self.first]
        head += map(self.remark.format, (of.name, *remarks, "zero is the middle of the travel"))
        return {f"{of.name}.{self.ending}": "\n".join([*head, *lines, *self.last]) + "\n"}


LINUXCNC = GCode("linuxcnc", "ngc", 6, "({})", ("G21 G90 G40 G49 G64 P0.0005 Q0",), ("M2",), "G4 P{}")
# Fanuc and what is like it: inverse time, increments of 0.1 µm
FANUC = GCode("fanuc", "nc", 4, "({})", ("%", "O{number} ({name})", "G21 G90 G40 G49 G64 G54"), ("M30", "%"), "G4 X{}")
SIEMENS = GCode("siemens", "mpf", 6, "; {}", ("; %_N_{name}_MPF", "G71 G90 G40 G64 G54"), ("M30",), "G4 F{}")


@dataclass(frozen=True)
class PointFiles:
    """Files of points in time, which hold no circles."""

    name: str
    move: Callable[[Move], Mapping[str, str]]  # Returns the files of a move by name

    def arc(self, arc: Arc) -> Mapping[str, str]:
        """Return nothing."""
        return {}


def table_files(move: Move) -> Mapping[str, str]:
    """Return a move's function block for TwinCAT and CODESYS; time [s], positions [mm, degrees] around the middle."""
    scale, unit = shown_scale(move.motion)
    points = move.points
    columns = {
        "times": [f"{t:.6f}" for t in points.time],
        "positions": [f"{scale * z:.9f}" for z in points.position],
        "velocities": [f"{scale * v:.9f}" for v in points.velocity],
    }
    return {f"{move.name}.st": render("motion.st.j2", move=move, name=identifier(move.name), unit=unit, **columns)}


def csv_files(move: Move) -> Mapping[str, str]:
    """Return the motion of a plan in SI, with time from 0 on, and the voltage at the controller's rate."""
    m, unit = move.reference, "m" if not rotates(move.motion) else "rad"
    head = f"time [s],position [{unit}],velocity [{unit}/s],acceleration [{unit}/s^2]"
    columns = np.column_stack([m.time, m.position, m.velocity, m.acceleration])[:: -(-len(m) // ROWS)]
    files = {f"{move.name}.csv": _text(head, columns)}
    if move.excitation is not None:
        files[f"{move.name}-voltage.csv"] = _text("time [s],voltage [V]", np.column_stack([m.time, move.excitation]))
    return files


def _text(head: str, columns: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> str:
    return "\n".join([head, *(",".join(f"{value:.9g}" for value in row) for row in columns)]) + "\n"


DIALECTS: dict[str, GCode | PointFiles] = {  # The dialects by name
    dialect.name: dialect
    for dialect in (LINUXCNC, FANUC, SIEMENS, PointFiles("table", table_files), PointFiles("csv", csv_files))
}
