"""A group of commands that looks at its own options only where one is given."""

from __future__ import annotations

from typing import Any

from typer.core import TyperGroup


class Group(TyperGroup):
    """A group whose options cost nothing unless one is given.

    Typer passes each option of each group above a command through pydantic, the help option and those that were not
    given as well. To import it takes as long as all of Typer, before the command's own help is printed.
    """

    _wanted = True

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
