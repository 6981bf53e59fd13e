"""`fric reproduce`: the paper from end to end."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

import fric
from fric.cli.console import finish
from fric.cli.options import Json


def reproduce(
    output: Annotated[
        Path, typer.Option("-o", "--output", metavar="DIR", help="Folder for logs, YAML, runs, figures and the page.")
    ] = Path("reproduction"),
    machine: Annotated[
        Path, typer.Option("--machine", metavar="MACHINE.yaml", help="A machine of your own; else the paper's.")
    ] = Path("xy-table"),
    seed: Annotated[int, typer.Option("--seed", min=0, help="Seed of all noise.")] = 1,
    json: Json = False,
) -> None:
    """Run the paper from end to end: experiments, identification, design, six schemes, and a page beside the paper.

    Steps whose inputs have not changed are not run again.
    """
    finish(
        lambda advance: fric.reproduce_paper(output, machine, seed=seed, advance=advance), json=json, doing="reproduce"
    )
