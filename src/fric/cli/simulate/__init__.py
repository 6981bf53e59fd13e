"""The group `fric simulate`: one subcommand a file."""

from __future__ import annotations

import typer

from fric.cli.group import Group
from fric.cli.simulate import circle, circle_map, experiment, path

app = typer.Typer(name="simulate", cls=Group, help="Virtual experiments, and the circular test.", no_args_is_help=True)
app.command()(experiment.experiment)
app.command()(circle.circle)
app.command()(path.path)
app.command("map")(circle_map.circle_map)
