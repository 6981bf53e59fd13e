"""Run the bench: `python -m benchmarks.reality [--seeds N] [--workers N] [--write PAGE.md] [FLAW …]`."""

from __future__ import annotations

import argparse
import json
import sys
from collections import defaultdict
from pathlib import Path

from benchmarks.reality.bench import STEPS, Outcome, Row, run_all
from benchmarks.reality.page import page
from benchmarks.reality.session import flaws
from fric.cli.console import progress
from fric.simulate.processes import default_workers

NAMES = flaws()


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("flaws", nargs="*", default=NAMES, metavar="FLAW", help=", ".join(NAMES))
    parser.add_argument("--seeds", type=int, default=40)
    parser.add_argument("--workers", type=int, default=default_workers())
    parser.add_argument("--write", type=Path, metavar="PAGE.md", help="write the table here")
    parser.add_argument("--errors", type=Path, metavar="OUT.json", help="write every number with its truth here")
    given = parser.parse_args()
    found: dict[str, list[Outcome]] = defaultdict(list)
    with progress("sessions", total=len(given.flaws) * given.seeds) as advance:
        for outcomes in run_all(given.flaws, given.seeds, given.workers):
            for outcome in outcomes:
                found[outcome.flaw].append(outcome)
            advance(len(outcomes))
    rows = [Row(flaw, tuple(sorted(found[flaw], key=lambda o: o.seed))) for flaw in given.flaws]
    text = page(rows)
    if given.write:
        given.write.write_text(text, encoding="utf-8")
    if given.errors:
        given.errors.write_text(
            json.dumps([_plain(o) for row in rows for o in row.outcomes], indent=1), encoding="utf-8"
        )
    for row in rows:
        print(f"{row.flaw:<20} " + "  ".join(f"{step} {row.verdict(step):<8}" for step in STEPS), flush=True)
    return any(row.verdict(step) == "silent" for row in rows for step in STEPS)


def _plain(outcome: Outcome) -> dict[str, object]:
    return {"flaw": outcome.flaw, "seed": outcome.seed} | {
        name: {
            "numbers": {key: [n.value, n.low, n.high, n.truth] for key, n in step.numbers.items()},
            "notices": [notice.as_dict() for notice in step.notices],
            "failure": step.failure,
            "crash": step.crash,
        }
        for name, step in outcome.steps.items()
    }


if __name__ == "__main__":
    sys.exit(main())
