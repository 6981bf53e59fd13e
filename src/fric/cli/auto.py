"""`fric auto`: the whole way in one command."""

import sys
from collections.abc import Sequence
from contextlib import redirect_stdout
from pathlib import Path
from typing import Annotated

import typer

import fric
from fric.cli.console import ERR, finish
from fric.cli.options import Implausible, Json, argument, option


def run_here(words: Sequence[str]) -> None:
    """Run a command in this process; what it prints goes to standard error: standard output is for the end."""
    from fric.cli.main import app

    with redirect_stdout(sys.stderr):
        status = typer.main.get_command(app).main(list(words), prog_name="fric", standalone_mode=False)
    if status:
        raise fric.FricError(f"it ended with status {status}")


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
