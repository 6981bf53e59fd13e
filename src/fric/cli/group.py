"""A group of commands that makes a command where one is asked for, and looks at its own options where one is given."""

from collections.abc import Iterator, Mapping
from inspect import getdoc
from typing import Any

import typer
from typer.core import TyperCommand, TyperGroup

from fric.cli.command import Command, found

Home = str | Command | typer.Typer
"""A command as its verb makes it, ``module:function`` of one that is written by hand, or a group."""


class _Commands(Mapping[str, Any]):
    """The commands of a group, each made by Typer when it is asked for.

    Typer reads the annotations of every parameter of every command before it looks at the line: of 30 commands that
    takes three times as long as to import Typer.
    """

    def __init__(self, homes: Mapping[str, Home]) -> None:
        self._homes, self._made = homes, dict[str, Any]()

    def __iter__(self) -> Iterator[str]:
        return iter(self._homes)

    def __len__(self) -> int:
        return len(self._homes)

    def __getitem__(self, name: str) -> Any:
        if name not in self._made:
            made = self._found(name)
            if not isinstance(made, typer.Typer):
                alone = typer.Typer(add_completion=False, rich_markup_mode=None, pretty_exceptions_enable=False)
                alone.command(name)(made)
                made = alone
            self._made[name] = typer.main.get_command(made)
        return self._made[name]

    def summary(self, name: str, width: int) -> str:
        """Return the first sentence of a command's help, in so many characters."""
        home = self._homes[name]
        made = home if isinstance(home, Command) else self._found(name)
        text = (
            made.help
            if isinstance(made, Command)
            else made.info.help
            if isinstance(made, typer.Typer)
            else getdoc(made)
        )
        return TyperCommand(name, help=text).get_short_help_str(width)

    def _found(self, name: str) -> Any:
        home = self._homes[name]
        if isinstance(home, Command):
            return home.function()
        return found(home) if isinstance(home, str) else home


def group(name: str, text: str, homes: Mapping[str, Home], **settings: Any) -> typer.Typer:
    """Return a group of commands.

    Parameters
    ----------
    name, text
        Its name and its help.
    homes
        Where each of its commands is, by name, in the order of the help.
    settings
        What else `typer.Typer` takes.
    """

    class Group(TyperGroup):
        """A group whose commands and options cost nothing unless one is given.

        Typer passes each option of each group above a command through pydantic, the help option and those that were
        not given as well. To import it takes as long as all of Typer, before the command's own help is printed.
        """

        _wanted = True

        def __init__(self, **given: Any) -> None:
            super().__init__(**given)
            self.commands: Any = _Commands(homes)

        def list_commands(self, ctx: Any) -> list[str]:
            return list(self.commands)

        def format_commands(self, ctx: Any, formatter: Any) -> None:
            width = formatter.width - 6 - max(map(len, self.commands))
            with formatter.section("Commands"):
                formatter.write_dl([(one, self.commands.summary(one, width)) for one in self.commands])

        def get_params(self, ctx: Any) -> Any:
            """Return the options of the group; none while a line is parsed that gives none."""
            return super().get_params(ctx) if self._wanted else []

        def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
            """Parse a line: options of the group where it begins with one, the command and its line otherwise."""
            self._wanted = not args or args[0].startswith("-")
            try:
                return super().parse_args(ctx, args)
            finally:
                self._wanted = True

    made = typer.Typer(
        name=name, cls=Group, help=text, no_args_is_help=True, pretty_exceptions_enable=False,
        rich_markup_mode=None,  # Rich's help costs 80 ms
        **{"add_completion": False} | settings,
    )  # fmt: skip
    made.callback()(lambda: None)  # without one Typer takes a group that is yet empty for a command
    return made
