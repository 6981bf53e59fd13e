"""Between which values the records could show a parameter at all."""

from collections.abc import Sequence

import numpy as np

from fric.errors import FricError
from fric.identify.records.judgement import identifiability_of
from fric.identify.records.prepared import Prepared
from fric.identify.records.resolution import noise_level
from fric.identify.replay.coordinates import Ranges


def search_ranges(records: Sequence[Prepared]) -> Ranges:
    """Return, by dimension, between which values the records could show a parameter at all.

    Forces up to twice that logged (where no branch slides, from the largest that was seen to twenty times that),
    velocities up to three times the fastest, lengths from the encoder's step or noise (but at least 1e-4 of the stroke)
    to the stroke, and what is made of these.
    """
    force = max(float(np.quantile(np.abs(r.force[r.used] - np.median(r.force[r.used])), 0.99)) for r in records)
    speeds = np.concatenate([np.abs(r.motion.velocity[r.used]) for r in records])
    fastest = float(np.quantile(speeds, 0.99))
    strokes = [float(np.ptp(r.motion.position)) for r in records]
    stroke = max(strokes)
    grain = [
        max(r.motion.step, 4.0 * noise_level(r.log.position)) if r.log.position is not None else 0.0 for r in records
    ]
    seen = identifiability_of(records)
    finest = min(max(g, 1e-4 * s) for g, s in zip(grain, strokes, strict=True))
    duration = max(float(r.motion.time[-1] - r.motion.time[0]) for r in records)
    dt = min(float(np.median(np.diff(r.motion.time))) for r in records)
    if not (force > 0 and fastest > 0):
        raise FricError("the records hold no force or no motion", where=records[0].log.where)
    return {
        "force": (0.01 * force, 2.0 * force) if seen.slides else (seen.peak, 20.0 * force),
        "velocity": (1e-4 * fastest, 3.0 * fastest),
        "viscous": (0.0, 100.0 * force / fastest),
        "position": (finest, stroke),
        "stiffness": (0.1 * force / stroke, 2.0 * force / finest),
        "force rate": (force / duration, force / dt),
        "rate": (1.0 / duration, 1.0 / dt),
        "frequency": (1.0 / duration, 0.5 / dt),
        "time": (dt, duration),
    }
