"""Run the bench: `python -m benchmarks.prediction [--seeds 2] [--drawn 20 --seed 7] [--minutes N] [MACHINE …]`.

What was run is kept in the folder, and is not run again as long as code and machines are the same: so the bench can be
run in pieces. ``--same-logs`` keeps what was identified, and predicts anew.
"""

from __future__ import annotations

import argparse
import json
import shutil
import sys
from hashlib import sha256
from pathlib import Path
from time import monotonic

import numpy as np

from benchmarks.prediction.bench import Outcome, Pair, outcome
from benchmarks.reality.session import MACHINES, flaws
from fric.simulate.contour_run import Circle

WIDE, HELD, STEP = 1.5e-6, 0.9, 1e-7
"""Width that the median of the trusted intervals of (c) to (f) may have [m], share of pairs that they must hold, and
the encoder's step, by which a recommended scheme may be worse than none [m]."""
SOURCE = Path(__file__).parents[2] / "src" / "fric"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("flaws", nargs="*", metavar="MACHINE", help="of configs/reality; all where none is named")
    parser.add_argument("--machines", type=int, default=24, help="machines that are drawn for a prediction")
    parser.add_argument("--feed", type=float, default=100.0, help="mm/s")
    parser.add_argument("--radius", type=float, default=30.0, help="mm")
    parser.add_argument("--seeds", type=int, default=1, help="sessions on each machine of configs/reality")
    parser.add_argument("--drawn", type=int, default=0, help="machines with two or three flaws that are drawn")
    parser.add_argument("--seed", type=int, default=7, help="of these")
    parser.add_argument("--minutes", type=float, default=float("inf"), help="begin no machine after this time")
    parser.add_argument("--to", type=Path, default=Path("build/prediction"), metavar="FOLDER", help="of the results")
    parser.add_argument("--same-logs", action="store_true", help="keep what older code identified, and predict anew")
    parser.add_argument("--any-version", action="store_true", help="keep what older code predicted too")
    given = parser.parse_args()
    circle = Circle(radius=given.radius * 1e-3, feed=given.feed * 1e-3)
    files = [
        *sorted(SOURCE.rglob("*.py")),
        *sorted(MACHINES.glob("*.yaml")),
        *sorted(Path(__file__).parent.glob("*.py")),
    ]
    version = sha256(b"".join(file.read_bytes() for file in files)).hexdigest()[:12]
    kept = given.to / "outcomes.jsonl"
    given.to = given.to.resolve()  # a machine file names its parts by where it is itself
    given.to.mkdir(parents=True, exist_ok=True)
    known = _known(kept, None if given.any_version else version)
    if not (given.same_logs or given.any_version) and not any(known):
        for folder in (path for path in given.to.iterdir() if path.is_dir()):
            shutil.rmtree(folder)
    named = given.flaws or ([] if given.drawn and given.seeds == 0 else flaws())
    tasks = [(name, seed) for seed in range(given.seeds) for name in named]
    tasks += [(str(n), given.seed) for n in range(given.drawn)]
    began, found = monotonic(), []
    for name, seed in tasks:
        key = f"{name} {seed} {given.machines} {circle.radius:g} {circle.feed:g}"
        if key not in known:
            if monotonic() - began > 60 * given.minutes:
                continue
            known[key] = outcome(name, seed, given.to, circle, given.machines)
            with kept.open("a", encoding="utf-8") as file:
                file.write(json.dumps([version, key, known[key].as_dict()]) + "\n")
        found.append(known[key])
        _tell(known[key])
    print(f"{len(found)} of {len(tasks)} sessions are run")
    return _judge(found) if found else 1


def _known(kept: Path, version: str | None) -> dict[str, Outcome]:
    if not kept.exists():
        return {}
    lines = [json.loads(line) for line in kept.read_text(encoding="utf-8").splitlines()]
    return {key: Outcome.of(one) for made, key, one in lines if version in (None, made)}


def _tell(one: Outcome) -> None:
    choice = f"recommended ({one.choice})" if one.choice else "nothing recommended"
    told = one.failure or f"{choice}, {', '.join(one.why) or 'trusted'}"
    print(f"{one.name}: {' '.join(told.split())}")
    for pair in one.pairs:
        limits = f"{pair.low * 1e6:6.2f} … {pair.high * 1e6:6.2f}"
        held = "held" if pair.covered else "missed, and not trusted" if pair.why else "MISSED"
        cycles = ", limit cycle" if pair.cycles else ""
        print(f"  ({pair.scheme}) {limits}  done {pair.done * 1e6:6.2f}  {held}{cycles}  {', '.join(pair.why)}")
    sys.stdout.flush()


def _judge(found: list[Outcome]) -> int:
    pairs = [pair for one in found for pair in one.pairs]
    trusted = [pair for pair in pairs if not pair.why]
    good = _share([pair.covered or bool(pair.why) for pair in pairs])
    widths = [pair.high - pair.low for pair in trusted if pair.scheme in "cdef"]
    print(f"{len(pairs)} pairs of machine and scheme, {len(trusted)} trusted; held or not trusted {good:.1%}")
    print(f"of the trusted {_share([pair.covered for pair in trusted]):.1%} are held, of the others ", end="")
    print(f"{_share([pair.covered for pair in pairs if pair.why]):.1%}")
    width = float(np.median(widths)) if widths else 0.0
    print(f"trusted intervals of (c) to (f): median width {width * 1e6:.2f} µm, {len(widths)} of them")
    bad = 0
    for label, ones in (("trusted", [one for one in found if one.choice and not one.why]),
                        ("not trusted", [one for one in found if one.choice and one.why])):  # fmt: skip
        ran = [(one, one.chosen, one.bare) for one in ones]
        cycles = [one.name for one, chosen, _ in ran if chosen is None or chosen.cycles]
        worse = [one.name for one, chosen, bare in ran if _worse(chosen, bare)]
        over = [one.name for one, chosen, _ in ran if chosen is None or chosen.done > one.under]
        print(f"{len(ones)} verdicts that are {label}: limit cycles {cycles}; worse than none {worse}; ", end="")
        print(f"over what they say {over}")
        bad += len(cycles) + len(worse)
    refused, nothing = (sum(bool(one.failure) for one in found), sum(not one.choice for one in found))
    print(f"{refused} machines refused, {nothing - refused} more without a choice")
    return int(good < HELD or width > WIDE or bad > 0)


def _worse(chosen: Pair | None, bare: Pair | None) -> bool:
    return chosen is None or (bare is not None and chosen.done > bare.done + STEP)


def _share(of: list[bool]) -> float:
    return float(np.mean(of)) if of else 1.0


if __name__ == "__main__":
    sys.exit(main())
