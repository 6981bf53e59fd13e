"""The parameters of a Typer command, from the arguments of a verb."""

from collections.abc import Iterator, Mapping
from inspect import Parameter
from pathlib import Path
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

import typer

from fric.cli import completion
from fric.results.kinds import METAVARS
from fric.verb import Argument, kinds_of


def option(help: str, *names: str, **settings: Any) -> Any:
    """Return an option with its help, under these names or that of the parameter, as `typer.Option` takes the rest."""
    return typer.Option(*names, help=help, **settings)


def argument(help: str, **settings: Any) -> Any:
    """Return an argument with its help, as `typer.Argument` takes the rest."""
    return typer.Argument(help=help, **settings)


def parameter(name: str, hint: Any, default: Any = Parameter.empty) -> Parameter:
    """Return a parameter of a command's function."""
    return Parameter(name, Parameter.KEYWORD_ONLY, annotation=hint, default=default)


def parameter_of(given: Argument, flags: str = "", *, place: bool = False) -> Parameter:
    """Return what a command takes for an argument of its verb.

    given: The argument.
    flags: Names of the option, where that of the argument is not its name.
    place: Whether it is given by its place, not by a name.
    """
    kinds, default = kinds_of(given.hint), given.default
    read, many = _read(given.hint)
    many = many or given.several
    settings: dict[str, Any] = {"min": _first(kinds, "least"), "max": _first(kinds, "most")}
    metavar = _first(kinds, "metavar") or next(filter(None, map(METAVARS.get, _dimensions(given.hint))), None)
    if complete := _first(kinds, "complete"):
        settings["autocompletion"] = getattr(completion, complete)
    if place:
        if metavar:
            settings["metavar"] = f"{metavar}…" if given.several else metavar
        settings = {key: value for key, value in settings.items() if value is not None}
        made: Any = argument(given.help, **settings)
    else:
        names = flags.split() or ([f"--{given.name.replace('_', '-')}"] if read is not bool or not default else [])
        made = option(given.help, *names, metavar=metavar, **settings)
    if many:
        read, default = list[read], None if default == () else default  # type: ignore[valid-type]
    if given.several and default is Parameter.empty:
        return parameter(given.name, Annotated[read, made])
    if isinstance(default, str) and read is Path:
        default = Path(default)
    return parameter(given.name, Annotated[read | None if default is None else read, made], default)


def _first(kinds: Any, name: str) -> Any:
    return next((value for kind in kinds if (value := getattr(kind, name)) not in {None, ""}), None)


def _dimensions(hint: Any) -> Iterator[str]:
    if get_origin(hint) is Annotated:
        inner, *beside = get_args(hint)
        yield from (text for text in beside if isinstance(text, str))
        yield from _dimensions(inner)


def _read(hint: Any) -> tuple[Any, bool]:
    """Return what a text of the line is read as, and whether there may be several."""
    stated = _first(kinds_of(hint), "read")
    if stated is not None:
        return (get_args(stated)[0], True) if get_origin(stated) is list else (stated, False)
    origin, inner = get_origin(hint), get_args(hint)
    if origin is Annotated:
        return _read(inner[0])
    if origin in {Union, UnionType}:
        ways = [item for item in inner if item is not NoneType]
        if Path in ways:
            return Path, False
        return (str, False) if str in ways else _read(ways[0])
    if origin is Literal or hint in {str, int, float, bool, Path}:
        return hint, False
    raise TypeError(f"nothing says what a command reads {hint} as")


def values_of(given: Mapping[str, Any]) -> dict[str, Any]:
    """Return what was given; of what was not the verb has its default."""
    return {name: value for name, value in given.items() if value is not None and value != []}
