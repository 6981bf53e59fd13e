"""Run the bench: `python -m benchmarks.reality [--seeds N] [--minutes N] [--to FOLDER] [--write PAGE.md] [FLAW …]`.

What was run stands in the folder, one JSON file a machine, and is not run again as long as code and machine are the
same: so the bench can be run in pieces.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from benchmarks.reality.ablation import sections
from benchmarks.reality.bench import STEPS, Row, run_all
from benchmarks.reality.page import page
from benchmarks.reality.results import Results
from benchmarks.reality.session import CLEAN, flaws
from fric.cli.console import progress
from fric.simulate.processes import default_workers

NAMES = [*flaws(), CLEAN]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("flaws", nargs="*", default=NAMES, metavar="FLAW", help=", ".join(NAMES))
    parser.add_argument("--seeds", type=int, default=40)
    parser.add_argument("--workers", type=int, default=default_workers())
    parser.add_argument("--minutes", type=float, default=float("inf"), help="begin no session after this time")
    parser.add_argument("--to", type=Path, default=Path("build/reality"), metavar="FOLDER", help="of the results")
    parser.add_argument("--any-version", action="store_true", help="keep what older code gave")
    parser.add_argument("--write", type=Path, metavar="PAGE.md", help="write the table here")
    given = parser.parse_args()
    results = {flaw: Results(given.to, flaw, any_version=given.any_version) for flaw in given.flaws}
    missing = [(flaw, one.missing(given.seeds)) for flaw, one in results.items()]
    with progress("sessions") as advance:
        advance(0, total=sum(len(seeds) for _, seeds in missing))
        for outcomes in run_all(missing, given.workers, given.minutes):
            results[outcomes[0].flaw].add(outcomes)
            advance(len(outcomes))
    rows = [Row(flaw, tuple(one.outcomes)) for flaw, one in results.items() if one.outcomes]
    if given.write:
        given.write.write_text(page(rows) + sections(given.to), encoding="utf-8")
    for row in rows:
        verdicts = "  ".join(f"{step} {row.verdict(step):<8}" for step in STEPS)
        print(f"{row.flaw:<20} {len(row.outcomes):>3} seeds  {verdicts}", flush=True)
    return any(row.verdict(step) in {"silent", "open"} for row in rows for step in STEPS)


if __name__ == "__main__":
    sys.exit(main())
