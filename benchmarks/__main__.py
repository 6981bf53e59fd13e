"""Run the benchmarks: `python -m benchmarks [--machines N] [--write PAGE.md] [NAME …]`, all where none is named."""

from __future__ import annotations

import argparse
from importlib import import_module
from inspect import signature
from pathlib import Path
from pkgutil import iter_modules

import benchmarks


def main() -> None:
    found = [
        module.name
        for module in iter_modules(benchmarks.__path__)
        if not module.name.startswith("_") and not module.ispkg
    ]  # reality has a command of its own
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME", help=", ".join(found))
    parser.add_argument("--machines", type=int, help="of benchmarks over many machines: how many")
    parser.add_argument("--seed", type=int, help="of the same: another draw")
    parser.add_argument("--write", type=Path, metavar="PAGE.md", help="write the tables here")
    given = parser.parse_args()
    page = ["# Measured on many machines", "", "Made by `python -m benchmarks " + " ".join(given.names) + "`."]
    for name in given.names or found:
        print(f"\n{name}")
        module = import_module(f"benchmarks.{name}")
        asked = {key: getattr(given, key) for key in signature(module.run).parameters if getattr(given, key, None)}
        page += ["", f"## {name}", "", (module.__doc__ or "").strip(), "", "| | measured | target |", "|---|---|---|"]
        for what, measured, target in module.run(**asked):
            print(f"  {what:<90} {measured:>24}   target {target}", flush=True)
            page.append(f"| {what} | {measured} | {target} |")
    if given.write:
        given.write.write_text("\n".join(page) + "\n", encoding="utf-8")


main()
