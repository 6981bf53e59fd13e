"""Which samples of a record are near a reversal: in time, or within some pre-sliding lengths."""

import numpy as np

from fric.arrays import Mask
from fric.identify.records.prepared import Prepared

NEAR = 0.3
"""Time after a reversal that counts as near it [s]."""
LENGTHS = 10.0
"""Pre-sliding lengths after a reversal that count as near it."""


def presliding_length(record: Prepared) -> float:
    """Return the way after a reversal [m] on which the force has made nine tenths of its turn, the median of all.

    Where a record has no two reversals, a hundredth of its way.
    """
    z, found = record.motion.position, []
    for begin, end in zip(record.reversals[:-1], record.reversals[1:], strict=True):
        force = record.force[begin:end]
        if len(force) < 8:
            continue
        tail = float(np.median(force[len(force) // 2 :]))
        share = (force - force[0]) / (tail - force[0]) if tail != force[0] else np.zeros_like(force)
        passed = np.flatnonzero(share >= 0.9)
        if len(passed):
            found.append(abs(float(z[begin + passed[0]] - z[begin])))
    return float(np.median(found)) if found else 0.01 * float(np.ptp(z))


def near_reversals(record: Prepared, presliding: float) -> Mask:
    """Return which samples come within 0.3 s or ten pre-sliding lengths [m] after a reversal, shape (n,)."""
    near = np.zeros(len(record.force), bool)
    t, z = record.motion.time, record.motion.position
    for begin, end in zip(record.reversals, [*record.reversals[1:], len(t)], strict=True):
        part = slice(int(begin), int(end))
        near[part] = (t[part] - t[begin] < NEAR) | (np.abs(z[part] - z[begin]) < LENGTHS * presliding)
    return near
