"""Tune: friction, delay and K_f differ (`configs/spread.yaml`)

Two circles of 30 mm with scheme (f), at 100 and 10 mm/s. *All known* is the floor: the controllers believe exactly the
friction and the plant that the machine has, with lead. At 10 mm/s the loop passes the falling branch of the Stribeck
curve slowly. Where friction may fall at most 0.8 times as steeply as it does (`falling-friction`), errors grow there by
themselves from what the encoder does not show: of these machines p95 is made. How large the errors become is chance: on
circles that are 0.3 counts of the encoder larger, exact knowledge leaves more. Up to 3 % less than the friction is fed
forward there, and `--loop` designs such loops anew within M_s = 6 dB. [How](circles.md#tune).
"""

from __future__ import annotations

from benchmarks._machines import Study
from benchmarks._tuned import MACHINES, rows, tuned


def run(study: Study) -> list[tuple[str, str, str]]:
    """Tune machines."""
    tasks = [("xy-table.yaml", "spread.yaml", study.seed, n) for n in range(study.number(MACHINES))]
    return rows(study.run(tuned, tasks), ("0.5", "1.1"))
