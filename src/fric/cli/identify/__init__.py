"""The group `fric identify`: one subcommand a file."""

from __future__ import annotations

import typer

from fric.cli.group import Group
from fric.cli.identify import by_replay
from fric.cli.identify.gms import gms
from fric.cli.identify.plant import plant
from fric.cli.identify.static import static

app = typer.Typer(name="identify", cls=Group, help="Identify friction and plant from logs.", no_args_is_help=True)
app.command()(plant)
app.command()(static)
app.command()(gms)

for _model in by_replay.MODELS:
    if _model not in {command.name or getattr(command.callback, "__name__", "") for command in app.registered_commands}:
        app.command(_model)(by_replay.command(_model))
app.command("replay")(by_replay.command())
