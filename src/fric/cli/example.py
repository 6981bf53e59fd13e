"""`fric example`: what comes with fric, copied to be tried and edited."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

import fric
from fric.cli.completion import examples
from fric.cli.console import finish
from fric.cli.options import Force, Json


def example(
    output: Annotated[Path, typer.Option("-o", "--output", metavar="DIR", help="Folder to copy it into.")],
    name: Annotated[
        str,
        typer.Argument(metavar="NAME", help="rig: logs, mapping, machine; or xy-table, …", autocompletion=examples),
    ] = "rig",
    json: Json = False,
    force: Force = False,
) -> None:
    """Copy an example: logs, mapping and machine of the virtual rig, or a machine, mapping or schemes by name."""
    finish(lambda _: fric.example(name, output=output, force=force), json=json)
