"""`python -m benchmarks.prediction [--machines N] [--feed MM/S] [FLAW …]`: coverage and width of what is predicted."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from benchmarks.prediction.bench import Outcome, identify, outcome
from benchmarks.reality.session import flaws, machine_with
from fric.simulate.circle import Circle

WIDE = 1.5e-6
"""Width that the median of the trusted intervals of (c) to (f) may have [m]."""


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("flaws", nargs="*", default=flaws(), metavar="FLAW")
    parser.add_argument("--machines", type=int, default=40, help="machines that are drawn")
    parser.add_argument("--feed", type=float, default=100.0, help="mm/s")
    parser.add_argument("--radius", type=float, default=30.0, help="mm")
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    circle = Circle(radius=given.radius * 1e-3, feed=given.feed * 1e-3)
    found: list[Outcome] = []
    with TemporaryDirectory() as name:
        folder = Path(name)
        second = identify(machine_with("base").axis("y"), folder / "y", given.seed)
        for flaw in given.flaws:
            found.append(outcome(flaw, folder, second, circle, given.machines, given.seed))
            _tell(found[-1])
    return _judge(found)


def _tell(one: Outcome) -> None:
    print(f"{one.flaw}: {one.failure or 'least trusted: ' + (one.recommended or 'none')}")
    for pair in one.pairs:
        limits = f"{pair.low * 1e6:6.2f} … {pair.high * 1e6:6.2f}"
        verdict = "covered" if pair.covered else "MISSED" if not pair.why else "missed, and not trusted"
        print(
            f"  ({pair.scheme}) {limits}  done {pair.done * 1e6:6.2f}  {verdict}  {', '.join(dict.fromkeys(pair.why))}"
        )
    sys.stdout.flush()


def _judge(found: list[Outcome]) -> int:
    pairs = [pair for one in found for pair in one.pairs]
    trusted = [pair for pair in pairs if not pair.why]
    good = np.mean([pair.covered or bool(pair.why) for pair in pairs])
    widths = [pair.high - pair.low for pair in trusted if pair.scheme in "cdef"]
    print(f"{len(pairs)} pairs, {len(trusted)} trusted; covered or not trusted {good:.1%}")
    if trusted:
        print(f"of the trusted {np.mean([pair.covered for pair in trusted]):.1%} are covered")
    if widths:
        print(f"trusted intervals of (c) to (f): median width {np.median(widths) * 1e6:.2f} µm, {len(widths)} of them")
    wide = bool(widths) and float(np.median(widths)) > WIDE
    return int(good < 0.9 or wide)


if __name__ == "__main__":
    sys.exit(main())
