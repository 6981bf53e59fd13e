"""The group `fric design`: one subcommand a file."""

from __future__ import annotations

import typer

from fric.cli.design import block, controller, observer
from fric.cli.group import Group

app = typer.Typer(
    name="design",
    cls=Group,
    help="Design controller, disturbance observer and other control blocks of an axis.",
    no_args_is_help=True,
)
app.command()(controller.controller)
app.command()(observer.observer)
app.command()(block.block)
