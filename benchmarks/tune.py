"""Tune: friction, delay and K_f differ (`configs/spread.yaml`)

Two circles of 30 mm with scheme (f) are recorded, at 100 and 10 mm/s.

At 10 mm/s the loop passes slowly through speeds at which friction falls. Where friction may fall at most 0.8 times as
steeply as it does (`falling-friction`), errors grow that the encoder does not show. These machines set the 95th
percentile. How large the errors become is chance: on circles that are 0.3 counts larger, even exact knowledge leaves
more. On such machines up to 3 % less than the friction is fed forward, and `--loop` designs the gains anew within
M_s = 6 dB. [How](circles.md#tune).
"""

from __future__ import annotations

from benchmarks._machines import Study
from benchmarks._tuned import MACHINES, rows, tuned


def run(study: Study) -> list[tuple[str, str, str]]:
    """Tune machines."""
    tasks = [("xy-table.yaml", "spread.yaml", study.seed, n) for n in range(study.number(MACHINES))]
    return rows(study.run(tuned, tasks), ("0.5", "1.1"))
