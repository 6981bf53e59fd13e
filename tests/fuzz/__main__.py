"""`make fuzz`: so many mutated inputs; prints seed, counts and what failed, and keeps the record."""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter
from datetime import UTC, datetime
from pathlib import Path
from tempfile import TemporaryDirectory

from tests.fuzz.kills import run_kills
from tests.fuzz.mutation import replayed, run
from tests.fuzz.reading import READ

CORPUS, RECORD = Path(__file__).parent / "corpus", Path(__file__).parent / "record.md"


def main() -> int:
    """Run, tell, and return the exit status: 1 where anything failed."""
    asked = argparse.ArgumentParser(description=__doc__)
    asked.add_argument("--count", type=int, default=20_000)
    asked.add_argument("--seed", type=int, default=int(datetime.now(UTC).strftime("%Y%m%d")))
    asked.add_argument("--kinds", default=",".join(READ), help="only these kinds")
    asked.add_argument("--workers", type=int, default=1, help="processes; the same inputs with any number of them")
    asked.add_argument(
        "--kills", type=int, default=0, help="kill commands so often at random times, in place of inputs"
    )
    given = asked.parse_args()
    if given.kills:
        return _kills(given.kills, given.seed)
    print(f"seed {given.seed}, {given.count} inputs", flush=True)
    counts: Counter[str] = Counter()
    failures: Counter[str] = Counter()
    seen: set[tuple[str, ...]] = set()
    begun = time.monotonic()
    kinds = frozenset(given.kinds.split(","))
    for kind, source, n, failed in run(given.count, given.seed, kinds, given.workers):
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


def _kills(count: int, seed: int) -> int:
    """Kill commands at random times, tell each, keep the record, and return 1 where anything was wrong."""
    killed, left, failed = Counter[str](), 0, 0
    print(f"seed {seed}, {count} kills", flush=True)
    with TemporaryDirectory() as folder:
        for name, after, draft, wrong in run_kills(count, seed, Path(folder)):
            killed[name], left, failed = killed[name] + 1, left + draft, failed + bool(wrong)
            print(f"{name} after {after:.2f} s{', with a draft left' * draft}: {wrong or 'well'}", flush=True)
    told = ", ".join(f"{name} {number}" for name, number in killed.items())
    line = f"| {datetime.now(UTC):%Y-%m-%d} | {seed} | {killed.total()} kills | {told}; {left} left a draft | "
    with RECORD.open("a", encoding="utf-8") as file:
        file.write(line + (f"{failed} went wrong |\n" if failed else "none failed |\n"))
    return int(bool(failed))


if __name__ == "__main__":
    sys.exit(main())
