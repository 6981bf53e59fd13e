"""Tune: the shape differs too (`configs/spread-shape.yaml`)

Each alpha, each k, F_s/F_c, v_s, delta, sigma, A, mass and load differ by 20 to 30 %.

Where the loop does not hold falling friction, the largest glitch of drawn machines counts: what may be worse than the
recorded circle is refused. Blocks whose slip displacements are within a factor of 1.65 cannot be separated, and have
wide intervals.
"""

from __future__ import annotations

from benchmarks._machines import Study
from benchmarks._tuned import MACHINES, rows, tuned


def run(study: Study) -> list[tuple[str, str, str]]:
    """Tune machines."""
    tasks = [("xy-table.yaml", "spread-shape.yaml", study.seed, n) for n in range(study.number(MACHINES))]
    return rows(study.run(tuned, tasks), ("1.1", "2"))
