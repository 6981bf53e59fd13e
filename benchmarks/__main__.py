"""Run the benchmarks: `python -m benchmarks [--machines N] [--minutes N] [--to FOLDER] [--write PAGE.md] [NAME …]`.

All are run where none is named. What machines gave stands in the folder, and is not run again as long as the code is
the same: so many of them can be run in pieces.
"""

from __future__ import annotations

import argparse
from importlib import import_module
from inspect import signature
from pathlib import Path
from pkgutil import iter_modules

import benchmarks
from benchmarks._machines import Study
from fric.simulate.processes import default_workers


def main() -> None:
    found = [
        module.name
        for module in iter_modules(benchmarks.__path__)
        if not module.name.startswith("_") and not module.ispkg
    ]  # reality has a command of its own
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME", help=", ".join(found))
    parser.add_argument("--machines", type=int, help="of benchmarks over many machines: how many")
    parser.add_argument("--seed", type=int, default=0, help="of the same: another draw")
    parser.add_argument("--workers", type=int, default=default_workers(), help="of the same: processes")
    parser.add_argument("--minutes", type=float, default=float("inf"), help="of the same: begin no machine after this")
    parser.add_argument("--to", type=Path, default=Study.folder, metavar="FOLDER", help="of what they gave")
    parser.add_argument("--any-version", action="store_true", help="take what older code gave too")
    parser.add_argument("--title", default="Measured on many machines", help="of the page")
    parser.add_argument("--write", type=Path, metavar="PAGE.md", help="write the tables here")
    given = parser.parse_args()
    study = Study(given.machines, given.seed, given.to, given.workers, given.minutes, given.any_version)
    names = given.names or found
    words = " ".join([*names, *([f"--machines {given.machines}"] if given.machines else [])])
    page = [f"# {given.title}", "", f"Made by `python -m benchmarks {words} --write PAGE.md`, with seed {given.seed}."]
    page += ["Glitches in µm: median / 95th percentile / largest."]
    for name in names:
        print(f"\n{name}")
        module = import_module(f"benchmarks.{name}")
        asked = {key: study for key in signature(module.run).parameters if key == "study"}
        head, _, text = (module.__doc__ or name).strip().partition("\n")
        page += ["", f"## {head}", *([text.rstrip()] if text else []), "", "| | measured | target |", "|---|---|---|"]
        for what, measured, target in module.run(**asked):
            print(f"  {what:<90} {measured:>24}   target {target}", flush=True)
            page.append(f"| {what} | {measured} | {target} |")
    if given.write:
        given.write.write_text("\n".join(page) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
