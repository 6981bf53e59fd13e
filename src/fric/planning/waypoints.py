"""A motion as a few points in time for a controller: constant speed is a single piece."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from fric.arrays import Real
from fric.reference import Reference

SHORTEST = 8e-3
"""Time between two points at least [s]."""

TOLERANCE = 1e-7
"""Largest deviation of straight pieces from the motion [m, rad], where the shortest time allows."""

EVEN = 1e-6
"""Share of the largest acceleration up to which the speed counts as constant."""


@dataclass(frozen=True, eq=False)
class Waypoints:
    """Points of a motion, around the middle of its travel."""

    # time, position, velocity: instants [s], positions [m] and velocities [m/s] there, each of shape (n,)
    time: Real
    position: Real
    velocity: Real


def waypoints(motion: Reference, shortest: float = SHORTEST) -> Waypoints:
    """Return the points of a motion, centred on zero.

    Straight pieces between them keep its speed, and change speed by no more than its acceleration allows: each piece
    has the mean speed of the motion over it.

    motion: The motion.
    shortest: Time between two points at least [s].
    """
    a, sampling = motion.acceleration, motion.sampling
    even = np.abs(a) <= EVEN * float(np.abs(a).max(initial=0.0))
    edges = np.flatnonzero(np.diff(even.astype(int))) + 1
    bounds = [0, *edges.tolist(), len(a) - 1]
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
