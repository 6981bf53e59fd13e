"""`fric auto`: the whole way in one command."""

from __future__ import annotations

import sys
from contextlib import redirect_stdout
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import fric
from fric.cli.console import ERR, OUT, finish
from fric.cli.options import Implausible, Json, argument, option
from fric.errors import printable

if TYPE_CHECKING:
    from fric.automatic.steps import Step


def run_here(step: Step) -> None:
    """Make a step, with its progress; what it prints goes to standard error: standard output is for the end."""
    with redirect_stdout(sys.stderr):
        finish(step.make, doing=step.name)
        OUT.print(f"wrote {' and '.join(printable(str(path)) for path in step.leaves)}", markup=False)


def auto(
    logs: Annotated[list[Path], argument("Logs and circle tests, or folders of them.", metavar="LOGS…")],
    output: Annotated[Path, option("Folder for all that is made.", "-o", "--output", metavar="DIR")],
    machine: Annotated[
        Path | None, option("The machine; made of what is identified, else.", metavar="MACHINE.yaml")
    ] = None,
    circle: Annotated[list[Path] | None, option("A measured circle; repeatable.", metavar="CIRCLE.h5")] = None,
    tolerance: Annotated[str | None, option('Glitch that is allowed, as "5 um".', metavar="LENGTH")] = None,
    mapping: Annotated[
        str | None, option("What the columns of foreign logs mean.", "--map", metavar="MAP.yaml")
    ] = None,
    implausible: Implausible = "error",
    workers: Annotated[int | None, option("Of a fleet: processes at a time; one a core, else.", min=1)] = None,
    scheduler: Annotated[
        str | None, option("Of a fleet: a Dask scheduler, as tcp://host:8786.", metavar="ADDRESS")
    ] = None,
    json: Json = False,
) -> None:
    """Go the whole way: recognise, ingest, identify, design, simulate, compare with the measured circle, report.

    Each step is an ordinary command, printed as it is run and kept in DIR/steps.sh. What cannot be done says which
    record is missing. Steps whose inputs have not changed are not run again.

    A folder of many machines (DIR/machine/date/…) is a fleet: each axis is identified at each date, on all cores or a
    Dask cluster, and DIR/fleet.html tells which changed beyond their intervals.
    """
    finish(
        lambda advance: fric.auto(
            *logs, output=output, machine=machine, circles=circle or (), tolerance=tolerance, mapping=mapping,
            workers=workers, scheduler=scheduler, advance=advance, run=run_here,
            say=lambda text: ERR.print(text, markup=False),
        ),
        json=json, doing="machines" if len(logs) == 1 and logs[0].is_dir() else "",
    )  # fmt: skip
