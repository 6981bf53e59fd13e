"""A command, made from its verb: what a terminal adds to it, and what is done around it."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from importlib import import_module
from inspect import Parameter, Signature
from pathlib import Path
from typing import Annotated, Any, Literal

from fric.cli.console import finish
from fric.cli.signature import option, parameter, parameter_of, values_of
from fric.errors import FLAGS, FricError, as_options
from fric.verb import Form

READ_MACHINE = "fric.documents.machine_files:read_machine"
GIVEN = {"advance", "interrupted", "force"}
"""Arguments of verbs that a command gives itself."""


def _lift(given: str) -> str:
    from fric.plausibility import lift  # with NumPy, which `--help` need not

    lift(given == "ok")
    return given


Json = Annotated[bool, option("Print one JSON object on standard output, nothing else.", "--json")]
Plot = Annotated[
    Path | None, option("Draw a figure, or that of a name; .png, .svg or .pdf.", "--plot", metavar="[VIEW=]FIG")
]
Implausible = Annotated[
    Literal["error", "ok"],
    option("What no drive can be, as with a wrong unit: an error, or taken as it is.", callback=_lift),
]


@dataclass(frozen=True)
class Output:
    """What ``-o`` writes, where the verb itself writes nothing.

    metavar, help: Its name and its help.
    required: Whether it must be given.
    writes: Its format, as `fric.output.FORMATS` calls it; empty for a folder.
    """

    metavar: str
    help: str
    required: bool = True
    writes: str = "YAML"

    def parameter(self) -> Parameter:
        """Return it as a parameter of a command's function."""
        made = option(self.help, "-o", "--output", metavar=self.metavar)
        return parameter("output", Annotated[Path, made] if self.required else Annotated[Path | None, made],
                         Parameter.empty if self.required else None)  # fmt: skip


@dataclass(frozen=True)
class Command:
    """A command and its verb.

    verb: Module and name of the verb.
    output: What ``-o`` writes.
    plot, plausible, replaces: Whether there is a figure to draw, whether what is read is held against physics, and
        whether ``--force`` replaces outputs that exist.
    doing: What a progress bar says meanwhile.
    flags: Names of options, by argument, where they are not the argument's.
    places: Arguments with a default that are given by their place nevertheless.
    options: Arguments that are given by a name though Python takes them by their place.
    without: Arguments that only Python has.
    bound: Arguments that the command gives.
    optional: Arguments that the line need not give though the verb has no default: the function that is called sees to
        it.
    further: Arguments of other verbs, by verb; with some of `READ_MACHINE` the machine is read by them first.
    text: The help, where it is not that of the verb; ``more`` follows it.
    helps: The help of options, by argument, where the first sentence of its description is not.
    own: What only a terminal has: further parameters.
    run: Where the function is that is called in place of the verb and its end, with what was given.
    """

    verb: str
    output: Output | None = None
    plot: bool = False
    plausible: bool = True
    replaces: bool = True
    doing: str = ""
    flags: Mapping[str, str] = field(default_factory=dict)
    places: Sequence[str] = ()
    options: Sequence[str] = ()
    without: Sequence[str] = ()
    bound: Mapping[str, Any] = field(default_factory=dict)
    optional: Sequence[str] = ()
    further: Mapping[str, Sequence[str]] = field(default_factory=dict)
    text: str = ""
    more: str = ""
    helps: Mapping[str, str] = field(default_factory=dict)
    own: Sequence[Parameter] = ()
    run: str = ""

    @cached_property
    def form(self) -> Form:
        """What the verb says of itself."""
        return Form(self.verb)

    @property
    def help(self) -> str:
        """The help of the command."""
        return self.worded("\n\n".join(filter(None, (self.text or self.form.text, self.more))))

    def function(self) -> Callable[..., None]:
        """Return the function that Typer makes the command of."""

        def command(**given: Any) -> None:
            values = values_of(given)
            try:
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
        asked += [Form(verb)[name] for verb, names in self.further.items() for name in names]
        asked = [replace(argument, default=None) if argument.name in self.optional else argument for argument in asked]
        placed = [
            argument
            for argument in asked
            if argument.several
            or argument.name in self.places
            or (argument.positional and argument.default is Parameter.empty and argument.name not in self.options)
        ]
        named = [argument for argument in asked if argument not in placed]
        made = [self._parameter(argument, place=True) for argument in placed]
        made += [self.output.parameter()] if self.output else []
        made += [self._parameter(argument) for argument in named]
        made += self.own
        made += [parameter("plot", Plot, None)] if self.plot else []
        made += [parameter("implausible", Implausible, "error")] if self.plausible else []
        made.append(parameter("json", Json, False))
        force = option(self.helps.get("force", "Replace an output that exists."), "--force")
        return [*made, *([parameter("force", Annotated[bool, force], False)] if self.replaces else [])]

    def _parameter(self, one: Any, *, place: bool = False) -> Parameter:
        text = self.worded(self.helps.get(one.name, one.help))
        return parameter_of(replace(one, help=text), self.flags.get(one.name, ""), place=place)

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
        """Return a text that names arguments with the options that they are here."""
        return as_options(text, FLAGS | dict(self.flags))

    def end(self, make: Callable[[Any], Any], given: Mapping[str, Any], **beside: Any) -> Any:
        """Make the result, write, plot and print it, as `fric.cli.console.finish`; return the result."""
        output = given.get("output") if self.output else None
        settings: dict[str, Any] = {"doing": self.doing, "worded": self.worded}
        if self.output and self.output.writes:
            settings |= {"output": output, "writes": self.output.writes}
        else:
            settings["into"] = output
        settings |= {"plot": given.get("plot"), "json": given["json"], "force": given.get("force", False)}
        return finish(make, **settings | beside)


def found(home: str) -> Callable[..., Any]:
    """Return what a module has by a name: ``module:name``."""
    module, _, name = home.partition(":")
    return getattr(import_module(module), name)
