"""`fric tune`: what the controllers of a machine believe, refitted to recorded circles."""

from pathlib import Path
from typing import Annotated, Any

import typer

import fric
from fric.cli.console import finish
from fric.cli.diagnose import CircleFiles
from fric.cli.options import Force, Implausible, Json, MachineFile, option


def tune(
    machine: MachineFile,
    circles: CircleFiles,
    output: Annotated[Path, option("Folder for what is written.", "-o", "--output", metavar="DIR")],
    scheme: Annotated[str | None, option("Of a run file, the scheme that is taken.")] = None,
    loop: Annotated[
        bool, option("Design gains anew where friction that falls with speed makes errors grow.", "--loop")
    ] = False,
    force: Force = False,
    implausible: Implausible = "error",
    json: Json = False,
) -> None:
    """Refit what the controllers believe to recorded circles: friction, plant, delay; with lead.

    Give one fast and one slow circle, as at 100 and 10 mm/s, with reference, position and voltage of both axes. DIR
    gets machine.yaml with the new nominal parameters, a friction and a plant file of each axis, and a figure of its
    reversals. What explains the circles no better than the nominal parameters is refused. With --loop machine.yaml gets
    new gains too, where the loop does not hold friction that falls with speed: at 10 mm/s errors would grow whatever is
    fed forward.
    """

    def run(advance: Any) -> fric.TuneResult:
        made = fric.tune(machine, *circles, scheme=scheme, loop=loop, advance=advance)
        made.save(output, force=force)
        return made

    made = finish(run, json=json, doing="tuning")
    if not made.found.improves:
        raise typer.Exit(1)
