"""`fric example`: what comes with fric, copied to be tried and edited."""

from pathlib import Path
from typing import Annotated

import fric
from fric.cli.completion import examples
from fric.cli.console import finish
from fric.cli.options import Force, Json, argument, option


def example(
    output: Annotated[Path, option("Folder to copy it into.", "-o", "--output", metavar="DIR")],
    name: Annotated[
        str, argument("rig: logs, mapping, machine; or xy-table, …", metavar="NAME", autocompletion=examples)
    ] = "rig",
    json: Json = False,
    force: Force = False,
) -> None:
    """Copy an example: logs, mapping and machine of the virtual rig, or a machine, mapping or schemes by name."""
    finish(lambda _: fric.example(name, output=output, force=force), json=json)
