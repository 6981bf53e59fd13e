"""A command, made from its verb: its parameters, what a terminal adds, the layout of its help; and groups of them."""

import re
import tomllib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, cached_property, reduce
from importlib import import_module
from inspect import Parameter, Signature
from itertools import chain
from os import path
from pathlib import Path
from types import NoneType
from typing import Annotated, Any, Literal, get_args, get_origin

import typer
from typer.core import TyperCommand, TyperGroup

from fric.cli import completion
from fric.cli.console import finish
from fric.errors import FLAGS, FricError, as_options, near
from fric.output import refuse_existing
from fric.verb import UNIONS, Argument, VerbForm, dimensions_of, kinds_of

_HELP = tomllib.loads(Path(__file__).with_name("help.toml").read_text("utf-8"))
PARTS: Mapping[str, Mapping[str, str]] = _HELP["parts"]
EXAMPLES: Mapping[str, Sequence[str]] = _HELP["examples"]
GROUPS: Mapping[str, Mapping[str, Sequence[str]]] = _HELP["groups"]
PREFIXES = {"Circle": "For circles", "Of a fleet": "For a fleet"}  # The same by the begin of an option's help
WIDTH = 80  # Largest width of a line of an example [columns]
OUTPUT = ("output", "plot", "plot_reversal", "json", "force", "help")  # Options for the places of results, listed last


UsageError: Any = typer.BadParameter.__base__  # Error of a command line: Typer names those of single values alone


def listed(homes: Mapping[str, Any], name: str, text_of: Any) -> dict[str, list[tuple[str, str]]]:
    """Return commands by part, each with a short description; by default the first sentence of its help."""
    parts = {"Commands": PARTS.get(f"fric {name}", {})}
    if name == "fric":
        parts = {title: known for title, known in PARTS.items() if not title.startswith("fric ")}
    found = {title: [(key, text) for key, text in known.items() if key in homes] for title, known in parts.items()}
    known = {key for rows in found.values() for key, _ in rows}
    more = ((key, " ".join(text_of(key).partition("\n\n")[0].split())) for key in homes if key not in known)
    found[list(found)[-1]] += more
    return found


def command_of(ctx: Any) -> str:
    """Return the name of a command without that of the program: ``identify gms``."""
    names = list[str]()
    while ctx.parent is not None:
        ctx, names = ctx.parent, [str(ctx.info_name), *names]
    return " ".join(names) or str(ctx.info_name).removeprefix("fric ")


class HelpfulCommand(TyperCommand):
    """A command whose help has its options in groups, and examples."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Read the arguments; an option of one value that is given twice is refused, not overwritten."""
        order: list[Any] = self.make_parser(ctx).parse_args([*args])[2]
        given = [of for of in order if of.param_type_name == "option" and not (of.multiple or of.is_flag or of.count)]
        if again := next((of for n, of in enumerate(given) if of in given[:n]), None):
            raise UsageError(f"{max(again.opts, key=len)} is given twice, and takes one value.", ctx=ctx)
        return list(super().parse_args(ctx, args))

    def collect_usage_pieces(self, ctx: Any) -> list[str]:
        """Return places, required options, and the others in one word: ``LOGS… -o DIR [OPTIONS]``."""
        places, asked = list[str](), list[str]()
        for param in self.get_params(ctx):
            name = (param.metavar or str(param.name).upper()).strip("…")
            if param.param_type_name == "argument":
                name = f"{name}…" if param.nargs == -1 else name
                places.append(name if param.required else f"[{name}]")
            elif param.required:
                asked += [min(param.opts, key=len), name]
        return [*places, *asked, "[OPTIONS]"]

    def format_options(self, ctx: Any, formatter: Any) -> None:
        """Write places, then options by group."""
        named = {option: title for title, options in GROUPS.get(command_of(ctx), {}).items() for option in options}
        groups: dict[str, list[tuple[str, str]]] = {"Arguments": [], "Options": []}
        for param in self.get_params(ctx):
            if (record := param.get_help_record(ctx)) is None:
                continue
            names, text = record
            head, colon, rest = text.partition(": ")
            title = "Options" if param.param_type_name == "option" else "Arguments"
            if param.name in OUTPUT:
                title = "Output"
            elif colon and head in PREFIXES:
                title, text = PREFIXES[head], rest[0].upper() + rest[1:]
            title = named.get(str(param.name), title)
            if title == "Arguments":
                names = names.partition(" <")[0]
            groups.setdefault(title, []).append((names, text))
        groups["Output"] = groups.pop("Output", [])
        for title, records in groups.items():
            if records:
                with formatter.section(title):
                    formatter.write_dl(records)

    def format_epilog(self, ctx: Any, formatter: Any) -> None:
        """Write the examples; a long line is continued as in a shell."""
        if lines := EXAMPLES.get(command_of(ctx)):
            formatter.write("\nExamples:\n")
            for line in lines:
                words = re.split(r" (?=-)", f"  fric {line}")  # an option and its value stay together
                formatter.write(reduce(_continued, words) + "\n")


def _continued(text: str, words: str) -> str:
    """Return a command with more words, on a new line where they do not fit."""
    fits = len(text.rpartition("\n")[2]) + len(words) + 3 <= WIDTH
    return f"{text} {words}" if fits else f"{text} \\\n      {words}"


METAVARS = {  # Placeholder of a quantity in a help text, by its dimension
    "time": "TIME", "frequency": "FREQUENCY", "position": "LENGTH", "velocity": "SPEED", "force": "FORCE",
    "angle": "ANGLE", "gain": "GAIN", "mass": "MASS", "input": "VOLTAGE", "acceleration": "ACCELERATION",
    "force per input": "K_F", "rate": "GAIN", "velocity gain": "GAIN", "position gain": "GAIN",
}  # fmt: skip
PLACEHOLDERS: Mapping[Any, str] = {int: "N", float: "X", str: "TEXT"}  # The same of other values, by their type


def option(help: str, *names: str, **settings: Any) -> Any:
    """Return an option with its help, under these names or the parameter's; the rest is as in `typer.Option`."""
    return typer.Option(*names, help=help, **settings)


def argument(help: str, **settings: Any) -> Any:
    """Return an argument with its help; the rest is as in `typer.Argument`."""
    return typer.Argument(help=help, **settings)


def parameter(name: str, hint: Any, default: Any = Parameter.empty) -> Parameter:
    """Return a parameter of a command's function."""
    return Parameter(name, Parameter.KEYWORD_ONLY, annotation=hint, default=default)


def flag(name: str, help: str, *names: str) -> Parameter:
    """Return an option that is off by default, under these names or the parameter's."""
    return parameter(name, Annotated[bool, option(help, *names or (f"--{name.replace('_', '-')}",))], False)


def file_option(name: str, help: str, metavar: str) -> Parameter:
    """Return an option that takes a file, by default none."""
    return parameter(name, Annotated[Path | None, option(help, metavar=metavar)], None)


def parameter_of(given: Argument, flags: str = "", *, place: bool = False) -> Parameter:
    """Return the parameter of a command for an argument of its verb.

    flags: Names of the option, if they differ from that of the argument.
    """
    kinds, default = kinds_of(given.hint), given.default
    read, many = _read(given.hint)
    many = many or given.several
    settings: dict[str, Any] = {"min": _first(kinds, "least"), "max": _first(kinds, "most")}
    metavar = _first(kinds, "metavar") or next(filter(None, map(METAVARS.get, dimensions_of(given.hint))), None)
    if complete := _first(kinds, "complete"):
        settings["autocompletion"] = completion.of(complete)
    if place:
        if metavar:
            settings["metavar"] = f"{metavar}…" if given.several else metavar
        settings = {key: value for key, value in settings.items() if value is not None}
        made: Any = argument(given.help, **settings)
    else:
        names = flags.split() or ([f"--{given.name.replace('_', '-')}"] if read is not bool or not default else [])
        made = option(given.help, *names, metavar=metavar or PLACEHOLDERS.get(read), **settings)
    if many:
        read, default = list[read], None if default == () else default  # type: ignore[valid-type]
    if given.several and default is Parameter.empty:
        return parameter(given.name, Annotated[read, made])
    if isinstance(default, str) and read is Path:
        default = Path(default)
    return parameter(given.name, Annotated[read | None if default is None else read, made], default)


def _first(kinds: Any, name: str) -> Any:
    return next((value for kind in kinds if (value := getattr(kind, name)) not in {None, ""}), None)


def _read(hint: Any) -> tuple[Any, bool]:
    """Return the type that a text of the line is read as, and whether there may be several."""
    stated = _first(kinds_of(hint), "read")
    if stated is not None:
        return (get_args(stated)[0], True) if get_origin(stated) is list else (stated, False)
    origin, inner = get_origin(hint), get_args(hint)
    if origin is Annotated:
        return _read(inner[0])
    if origin in UNIONS:
        ways = [item for item in inner if item is not NoneType]
        if Path in ways:
            return Path, False
        return (str, False) if str in ways else _read(ways[0])
    if origin is Literal or hint in {str, int, float, bool, Path}:
        return hint, False
    raise TypeError(f"nothing says what a command reads {hint} as")


def values_of(given: Mapping[str, Any]) -> dict[str, Any]:
    """Return the given values; the verb has defaults for the others. No file is named as an option is."""
    for word in (str(value) for value in given.values() if isinstance(value, Path)):
        if word.startswith("--"):
            raise FricError(f"'{word}' is an option, and no file", hint="Give the file, then the option.")
    return {name: value for name, value in given.items() if value is not None and value != []}


READ_MACHINE = "fric.documents.machine_files:read_machine"
GIVEN = {"advance", "interrupted", "force"}  # Arguments of verbs that the command supplies


def _lift(given: str) -> str:
    from fric.plausibility import lift  # with NumPy, which `--help` need not

    lift(given == "ok")
    return given


JSON = flag("json", "Print one JSON object on standard output, nothing else.")
PLOT = file_option("plot", "Draw a figure, or that of a name; .png, .svg or .pdf.", "[VIEW=]FIG")
Implausible = Annotated[
    Literal["error", "ok"],
    option("Treat implausible values, as of a wrong unit, as an error, or accept them.", callback=_lift),
]


@dataclass(frozen=True)
class Output:
    """The output of ``-o``, if the verb itself writes nothing."""

    metavar: str
    help: str
    required: bool = True
    writes: str = "YAML"  # Its format, as `fric.output.FORMATS` calls it; empty for a folder
    holds: str = ""  # A file that a folder always holds: refused before the work where it exists

    def parameter(self) -> Parameter:
        """Return it as a parameter of a command's function."""
        made = option(self.help, "-o", "--output", metavar=self.metavar)
        return parameter("output", Annotated[Path, made] if self.required else Annotated[Path | None, made],
                         Parameter.empty if self.required else None)  # fmt: skip


@dataclass(frozen=True)
class Command:
    """A command and its verb."""

    verb: str  # Module and name of the verb
    output: Output | None = None  # What ``-o`` writes
    plot: bool = False  # Whether there is a figure to draw
    plausible: bool = True  # Whether what is read is held against physics
    replaces: bool = True  # Whether ``--force`` replaces outputs that exist
    doing: str = ""  # Text of the progress bar
    flags: Mapping[str, str] = field(default_factory=dict)  # Names of options by argument, if they differ
    places: Sequence[str] = ()  # Arguments with a default that are positional nevertheless
    options: Sequence[str] = ()  # Arguments that are options though Python takes them by position
    without: Sequence[str] = ()  # Arguments that only Python has
    bound: Mapping[str, Any] = field(default_factory=dict)  # Arguments that the command supplies
    optional: Sequence[str] = ()  # Arguments without default that the line may omit: the called function supplies them
    # Arguments of other verbs, by verb; those of `READ_MACHINE` are used to read the machine first
    further: Mapping[str, Sequence[str]] = field(default_factory=dict)
    text: str = ""  # The help, if it is neither that of the verb nor in the table of words
    helps: Mapping[str, str] = field(default_factory=dict)  # The help of options, if not that of their arguments
    terminal: Sequence[Parameter] = ()  # Further parameters that only a terminal has
    run: str = ""  # Module and name of the function that is called instead of the verb, with the given values

    @cached_property
    def form(self) -> VerbForm:
        """The description of the verb."""
        return VerbForm(self.verb)

    @property
    def help(self) -> str:
        """The help of the command."""
        name = self.form.name
        text = self.text or _HELP["text"].get(name, self.form.text)
        return self.worded("\n\n".join(filter(None, (text, _HELP["more"].get(name)))))

    def function(self) -> Callable[..., None]:
        """Return the function that Typer makes the command of."""

        def command(**given: Any) -> None:
            try:
                values = values_of(given)
                found(self.run)(self, values) if self.run else self.end(self.call(values), values)
            except FricError as error:
                what, where, hint = map(self.worded, (error.what, error.where, error.hint))
                raise FricError(what, where=where, hint=hint, form=error.form) from None

        command.__doc__ = self.help
        taken = self.parameters()
        command.__signature__ = Signature(taken)  # type: ignore[attr-defined]
        command.__annotations__ = {parameter.name: parameter.annotation for parameter in taken}
        return command

    def parameters(self) -> list[Parameter]:
        """Return the parameters: places, output, options, and what all commands share."""
        form = self.form
        asked = [form[name] for name in form.names if name not in {*GIVEN, *self.without, *self.bound}]
        asked += [VerbForm(verb)[name] for verb, names in self.further.items() for name in names]
        asked = [replace(argument, default=None) if argument.name in self.optional else argument for argument in asked]
        placed = [
            argument for argument in asked if argument.several or argument.name in self.places
            or (argument.positional and argument.default is Parameter.empty and argument.name not in self.options)
        ]  # fmt: skip
        named = [argument for argument in asked if argument not in placed]
        made = [self._parameter(argument, place=True) for argument in placed]
        made += [self.output.parameter()] if self.output else []
        made += [self._parameter(argument) for argument in named]
        made += self.terminal
        made += [PLOT] if self.plot else []
        made += [parameter("implausible", Implausible, "error")] if self.plausible else []
        force = flag("force", self.helps.get("force", "Replace an output that exists."))
        return [*made, JSON, *([force] if self.replaces else [])]

    def _parameter(self, argument: Any, *, place: bool = False) -> Parameter:
        text = self.worded(self.helps.get(argument.name, argument.help))
        return parameter_of(replace(argument, help=text), self.flags.get(argument.name, ""), place=place)

    def call(self, given: Mapping[str, Any], read: str = READ_MACHINE) -> Callable[..., Any]:
        """Return a function that calls the verb with the values given; its argument is the progress callback.

        Where the command has options that change the machine, ``read`` reads the machine first.
        """
        names = set(self.form.names)

        def make(advance: Any, **beside: Any) -> Any:
            values = {**self.bound, **{name: item for name, item in given.items() if name in names}, **beside}
            if beliefs := self.further.get(READ_MACHINE):
                instead = {name: item for name, item in given.items() if name in beliefs}
                values["machine"] = found(read)(given["machine"], **instead)
            if "advance" in names:
                values["advance"] = advance
            arguments = self.form.names
            several = next((name for name in arguments if self.form[name].several), None)
            if several is None:
                return found(self.verb)(**values)
            before = [values.pop(name) for name in arguments[: arguments.index(several)]]
            return found(self.verb)(*before, *values.pop(several, ()), **values)

        return make

    def worded(self, text: str) -> str:
        """Return a text with its arguments named as options of this command."""
        return as_options(text, FLAGS | dict(self.flags))

    def end(self, make: Callable[[Any], Any], given: Mapping[str, Any], **beside: Any) -> Any:
        """Make the result, write, plot and print it, as `fric.cli.console.finish`; return the result."""
        output = given.get("output") if self.output else None
        settings: dict[str, Any] = {"doing": self.doing, "worded": self.worded}
        if self.output and self.output.writes:
            settings |= {"output": output, "writes": self.output.writes}
        else:
            settings["into"] = output
            if output is not None and self.output and self.output.holds:
                held = output / self.output.holds
                refuse_existing(*[held] * path.exists(held), force=given.get("force", False))
        settings |= {"plot": given.get("plot"), "json": given["json"], "force": given.get("force", False)}
        return finish(make, **settings | beside)


def found(home: str) -> Callable[..., Any]:
    """Return the object named ``module:name``."""
    module, _, name = home.partition(":")
    return getattr(import_module(module), name)


Home = str | Command | typer.Typer  # A command: of its verb, ``module:function`` if written by hand, or a group
PLAIN: dict[str, Any] = {"rich_markup_mode": None, "pretty_exceptions_enable": False}
"""Rich's help would make ``fric --help`` take 2.4 times as long as to import Typer, in place of 1.4."""


def group(name: str, text: str, homes: Mapping[str, Home], **settings: Any) -> typer.Typer:
    """Return a group of commands.

    homes: Where each of its commands is, by name, in the order of the help.
    """

    @cache
    def made(command: str) -> Any:
        home = homes[command]
        if isinstance(home, typer.Typer):
            return typer.main.get_command(home)
        alone = typer.Typer(add_completion=False, **PLAIN)
        alone.command(command, cls=HelpfulCommand)(home.function() if isinstance(home, Command) else found(home))
        return typer.main.get_command(alone)

    inner = homes

    class Group(TyperGroup):
        """A group whose commands are made when they are asked for: to make all takes as long as to import Typer."""

        homes = inner

        def list_commands(self, ctx: Any) -> list[str]:
            return [key for rows in listed(homes, name, str).values() for key, _ in rows]

        def get_command(self, ctx: Any, cmd_name: str) -> Any:
            if cmd_name not in homes:
                return None
            command = made(cmd_name)
            rows = listed({cmd_name: None}, name, lambda _: command.help)  # in the words of the list of commands
            ((_, command.short_help),) = chain(*rows.values())
            return command

        def resolve_command(self, ctx: Any, args: list[str]) -> Any:
            if args[0] not in homes and not args[0].startswith("-"):
                groups = [key for key, home in homes.items() if isinstance(home, typer.Typer)]
                inside = [f"{key} {args[0]}" for key in groups if args[0] in homes[key].info.cls.homes]  # type: ignore[union-attr]
                there = f"Is it `fric {inside[0]}`?" if inside else f"Commands: {', '.join(self.list_commands(ctx))}."
                ctx.fail(f"there is no command '{args[0]}'. {near(args[0], homes)}{there}")
            return super().resolve_command(ctx, args)

        def format_commands(self, ctx: Any, formatter: Any) -> None:
            for title, rows in listed(homes, name, lambda key: made(key).help).items():
                with formatter.section(title):
                    formatter.write_dl(rows)

    settings = {"add_completion": False} | PLAIN | settings
    app = typer.Typer(name=name, cls=Group, help=text, no_args_is_help=True, **settings)
    app.callback()(lambda: None)  # without one Typer takes a group that is yet empty for a command
    return app
