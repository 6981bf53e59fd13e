"""Make golden outputs, and compare two folders of them: `python -m tests.golden make DIR`, `… compare BEFORE AFTER`."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from tests.golden.cases import SETS, Golden
from tests.golden.compare import differences


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.golden", description=__doc__)
    commands = parser.add_subparsers(dest="command", required=True)
    make = commands.add_parser("make", help="run the verbs, and keep what --json prints")
    make.add_argument("folder", type=Path)
    make.add_argument("sets", nargs="*", choices=[*SETS, []], metavar="SET", help=f"of {', '.join(SETS)}; all if none")
    make.add_argument("--quick", action="store_true", help="fewer machines and no long fits: under a minute")
    make.add_argument("--seeds", type=int, default=1, help="sessions on each machine with a flaw")
    make.add_argument("--records", type=Path, help="their records; made where they are not (default: DIR/../records)")
    compare = commands.add_parser("compare", help="print each value that differs; the status is 1 where one does")
    compare.add_argument("before", type=Path)
    compare.add_argument("after", type=Path)
    compare.add_argument("--within", type=float, default=1e-9, help="relative difference of numbers that are alike")
    given = parser.parse_args()
    if given.command == "make":
        records = given.records or given.folder.parent / "records"
        golden = Golden(given.folder, records, quick=given.quick, seeds=given.seeds)
        for name in given.sets or SETS:
            SETS[name](golden)
        return 0
    found = list(differences(given.before, given.after, given.within))
    print("\n".join(found) or "no difference")
    return bool(found)


if __name__ == "__main__":
    sys.exit(main())
