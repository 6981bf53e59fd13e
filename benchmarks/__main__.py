"""Run the benchmarks: all of them, or those named on the command line."""

from __future__ import annotations

import sys
from importlib import import_module
from pkgutil import iter_modules

import benchmarks


def main(names: list[str]) -> None:
    found = [
        module.name
        for module in iter_modules(benchmarks.__path__)
        if not module.name.startswith("_") and not module.ispkg
    ]  # reality has a command of its own
    for name in names or found:
        print(f"\n{name}")
        for what, measured, target in import_module(f"benchmarks.{name}").run():
            print(f"  {what:<90} {measured:>24}   target {target}", flush=True)


main(sys.argv[1:])
