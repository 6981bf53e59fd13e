"""`fric reproduce`: the paper from end to end."""

from pathlib import Path
from typing import Annotated

import fric
from fric.cli.console import finish
from fric.cli.options import Json, option


def reproduce(
    output: Annotated[
        Path, option("Folder for logs, YAML, runs, figures and the page.", "-o", "--output", metavar="DIR")
    ] = Path("reproduction"),
    machine: Annotated[Path, option("A machine of your own; else the paper's.", metavar="MACHINE.yaml")] = Path(
        "xy-table"
    ),
    seed: Annotated[int, option("Seed of all noise.", min=0)] = 1,
    json: Json = False,
) -> None:
    """Run the paper from end to end: experiments, identification, design, six schemes, and a page beside the paper.

    Steps whose inputs have not changed are not run again.
    """
    finish(
        lambda advance: fric.reproduce_paper(output, machine, seed=seed, advance=advance), json=json, doing="reproduce"
    )
