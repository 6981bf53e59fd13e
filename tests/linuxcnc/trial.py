"""Circles in a real LinuxCNC, with exported compensation switched on by and by, and the same loops in simulation."""

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from math import sqrt
from pathlib import Path

import numpy as np

from fric.contour import circularity
from fric.control.scheme import Scheme
from fric.errors import FricError
from fric.reference import Reference
from fric.results.base import Advance, silent
from fric.results.export import TriedCircle
from fric.simulate.axis import run_axis
from fric.simulate.contour_run import pair
from fric.simulate.machine import Machine

from .bench import Program, Recording, build_bench, render, run_session


def trial_schemes(scheme: Scheme) -> list[Scheme]:
    """Return what a trial of a scheme switches on: nothing, its feedforward, and all of it."""
    made = [replace(scheme, name="none", title="none", friction=None, blocks=())]
    ahead = tuple(b.name for b in scheme.block_types if b.kind == "feedforward")
    if scheme.blocks != ahead and scheme.feeds_forward:
        made.append(replace(scheme, name="feedforward", title="feedforward", blocks=ahead))
    return [*made, scheme]


def circles(feeds: Sequence[float], radius: float) -> Program:
    """Return a program that runs a circle clockwise and counter-clockwise at each feed [m/s], of a radius [m]."""
    edge, fastest = radius / sqrt(2), max(feeds)
    text = render(
        "circle.ngc.j2", radius=f"{1e3 * radius:g}", start=repr(-1e3 * edge), offset=repr(1e3 * edge),
        circles=[(f"{feed * 6e4:.9g}", 2 if feed > 0.05 else 1) for feed in feeds],
    )  # fmt: skip
    return Program(text, 2 * fastest, 6 * fastest**2 / radius + 10 * fastest, 4 * radius, whole=False)


def try_in_linuxcnc(
    machine: Machine,
    scheme: Scheme,
    folder: Path,
    *,
    feeds: Sequence[float] = (0.1, 0.01),
    radius: float = 0.03,
    advance: Advance = silent,
) -> list[TriedCircle]:
    """Run circles in LinuxCNC with a scheme switched on by and by, and the same loops in simulation.

    Parameters
    ----------
    machine
        The machine: its axes are the plant, its controllers' nominal parts the compensation.
    scheme
        What is exported.
    folder
        Where the bench is written and its records are left.
    feeds, radius
        Speeds [m/s] and radius [m] of the circles; each is run clockwise and counter-clockwise.
    advance
        Is told of each session.

    Raises
    ------
    FricError
        When LinuxCNC is not installed, a component does not build, a session fails, or rows of its record are lost.
    """
    build_bench(machine, scheme, circles(feeds, radius), folder)
    chosen = trial_schemes(scheme)
    advance(0, total=len(chosen))

    def session(one: Scheme) -> list[TriedCircle]:
        arcs = _arcs(machine, one, run_session(machine, one, scheme, folder), feeds, radius)
        advance()
        return arcs

    with ThreadPoolExecutor(len(chosen)) as pool:  # a session waits for its own clock, and takes little of a processor
        return [arc for arcs in pool.map(session, chosen) for arc in arcs]


def _arcs(
    machine: Machine, scheme: Scheme, record: Recording, feeds: Sequence[float], radius: float
) -> list[TriedCircle]:
    line = record.line
    starts = np.flatnonzero((line != 0) & (np.append(0, line[:-1]) != line))
    ends = [s + int(np.argmin(line[s:] == line[s])) if (line[s:] != line[s]).any() else len(line) for s in starts]
    found = []
    asked = [(feed, direction) for feed in feeds for direction in (-1, 1)]
    if len(starts) != len(asked):
        raise FricError(f"the record holds {len(starts)} arcs, and {len(asked)} were run", where=scheme.name)
    for (feed, direction), first, last in zip(asked, starts, ends, strict=True):
        true, simulated = [], []
        for n, name in enumerate(pair(machine)):
            r, v, a, z = (
                record.channel(one, n)[first:last] for one in ("reference", "velocity", "acceleration", "position")
            )
            simulated.append(run_axis(machine.axis(name), Reference(record.sampling, r, v, a), scheme).position)
            true.append(z)
        measured, expected = (circularity(x, y, radius) for x, y in (true, simulated))
        found.append(TriedCircle(scheme, feed, direction, measured, expected))
    return found
