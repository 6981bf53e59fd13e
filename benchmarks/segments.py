"""Finding steady segments: 34 strokes of 30 000 samples, beside sorting the same positions with numpy."""

from __future__ import annotations

from time import process_time

import numpy as np

from fric.log import Log
from fric.records.segments import steady_segments

RATE, SAMPLES, STEP = 4000.0, 30_000, 2.5e-7
SPEEDS = np.geomspace(1e-5, 3e-2, 17)


def _strokes() -> list[Log]:
    rng = np.random.default_rng(0)
    time = np.arange(SAMPLES) / RATE
    logs = []
    for velocity in np.concatenate([SPEEDS, -SPEEDS]):
        ramp = np.clip((time - 0.2) / 0.05, 0.0, 1.0) * np.clip((time[-1] - 0.2 - time) / 0.05, 0.0, 1.0)
        position = STEP * np.floor(np.cumsum(velocity * ramp) / RATE / STEP)
        logs.append(Log(time=time, position=position, force=100.0 * ramp + rng.standard_normal(SAMPLES)))
    return logs


def run() -> list[tuple[str, str, str]]:
    """Return what was measured, beside the target."""
    logs = _strokes()
    found = [steady_segments(log) for log in logs]
    start = process_time()
    for log in logs:
        steady_segments(log)
    search = process_time() - start
    start = process_time()
    for log in logs:
        np.sort(log.position)
    baseline = process_time() - start
    whole = sum(len(segments) == 1 for segments in found)
    return [
        ("steady segments of 34 strokes of 30 000 samples", f"{search:.3f} s", "< 0.3 s"),
        ("the same, in sorts of the positions by numpy", f"{search / baseline:.1f}", ""),
        ("strokes found as one stretch", f"{whole} of {len(logs)}", "34 of 34"),
    ]
