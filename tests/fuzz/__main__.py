"""`make fuzz`: so many mutated inputs; prints seed, counts and what failed, and keeps the record."""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter
from datetime import UTC, datetime
from pathlib import Path

from tests.fuzz.mutation import replayed, run
from tests.fuzz.reading import READ

CORPUS, RECORD = Path(__file__).parent / "corpus", Path(__file__).parent / "record.md"


def main() -> int:
    """Run, tell, and return the exit status: 1 where anything failed."""
    asked = argparse.ArgumentParser(description=__doc__)
    asked.add_argument("--count", type=int, default=20_000)
    asked.add_argument("--seed", type=int, default=int(datetime.now(UTC).strftime("%Y%m%d")))
    asked.add_argument("--kinds", default=",".join(READ), help="only these kinds")
    given = asked.parse_args()
    print(f"seed {given.seed}, {given.count} inputs", flush=True)
    counts: Counter[str] = Counter()
    failures: Counter[str] = Counter()
    seen: set[tuple[str, ...]] = set()
    begun = time.monotonic()
    for kind, source, n, failed in run(given.count, given.seed, frozenset(given.kinds.split(","))):
        counts[kind] += 1
        if failed:
            failures[failed.partition(":")[0]] += 1
            told = (kind, source.suffix, failed.strip().splitlines()[-1][:60])
            if told not in seen:  # the first of its kind
                seen.add(told)
                print(f"{kind} {source.name} number {n}: {failed}", flush=True)
                kept = CORPUS / f"{kind}-{given.seed}-{n}{''.join(source.suffixes)}"
                if source.exists():
                    kept.write_bytes(replayed(kind, source, given.seed, n))
    told = ", ".join(f"{kind} {count}" for kind, count in sorted(counts.items()))
    worst = ", ".join(f"{count} {what}" for what, count in failures.items()) or "none failed"
    line = f"| {datetime.now(UTC):%Y-%m-%d} | {given.seed} | {counts.total()} | {told} | {worst} |"
    print(line, f"in {time.monotonic() - begun:.0f} s")
    with RECORD.open("a", encoding="utf-8") as file:
        file.write(line + "\n")
    return int(bool(failures))


if __name__ == "__main__":
    sys.exit(main())
