"""A group of commands, each of which is made where it is asked for: Click's way of loading subcommands lazily."""

from collections.abc import Mapping
from functools import cache
from typing import Any

import typer
from typer.core import TyperGroup

from fric.cli.command import Command, found

Home = str | Command | typer.Typer
"""A command as its verb makes it, ``module:function`` of one that is written by hand, or a group."""

PLAIN: dict[str, Any] = {"rich_markup_mode": None, "pretty_exceptions_enable": False}
"""Rich's help would make ``fric --help`` take 2.4 times as long as to import Typer, in place of 1.4."""


def group(name: str, text: str, homes: Mapping[str, Home], **settings: Any) -> typer.Typer:
    """Return a group of commands.

    name, text: Its name and its help.
    homes: Where each of its commands is, by name, in the order of the help.
    settings: What else `typer.Typer` takes.
    """

    @cache
    def made(command: str) -> Any:
        home = homes[command]
        if isinstance(home, typer.Typer):
            return typer.main.get_command(home)
        alone = typer.Typer(add_completion=False, **PLAIN)
        alone.command(command)(home.function() if isinstance(home, Command) else found(home))
        return typer.main.get_command(alone)

    class Group(TyperGroup):
        """A group whose commands are made when they are asked for: to make all takes as long as to import Typer."""

        def list_commands(self, ctx: Any) -> list[str]:
            return list(homes)

        def get_command(self, ctx: Any, cmd_name: str) -> Any:
            return made(cmd_name) if cmd_name in homes else None

    app = typer.Typer(
        name=name, cls=Group, help=text, no_args_is_help=True, **{"add_completion": False} | PLAIN | settings
    )
    app.callback()(lambda: None)  # without one Typer takes a group that is yet empty for a command
    return app
