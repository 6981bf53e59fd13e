"""The description of a public verb: Python checks its annotations, and a command is made from them."""

import ast
import os
import re
import sys
from collections.abc import Callable, Container, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property, wraps
from importlib import import_module
from inspect import CO_VARARGS, BoundArguments, Parameter, cleandoc, formatannotation, signature, unwrap
from math import isfinite
from numbers import Integral, Real
from pathlib import Path
from types import FunctionType, NoneType, UnionType
from typing import Annotated, Any, ForwardRef, Literal, ParamSpec, TypeVar, Union, get_args, get_origin

from fric.errors import FLAGS, FricError, Typed, near, of_path

P = ParamSpec("P")
R = TypeVar("R")
T = TypeVar("T")
UNIONS = {Union, UnionType}  # Origins of `Union[A, B]` and of ``A | B``
WORDS = {str: "a text", Path: "a path", float: "a number", int: "a whole number", bool: "True or False", NoneType: ""}


@dataclass(frozen=True)
class Kind:
    """What an annotation says of an argument beside its type: ``Annotated[int, Kind(least=0, most=9)]``."""

    read: Any = None  # What a command reads it as, where the type leaves that open
    metavar: str | None = None  # Name of the value in a help text, in capitals
    complete: str = ""  # What the shell completes it from: a name in `fric.cli.completion`, or ``module:name``
    least: float | None = None  # Both bounds of a number, which belong to the range
    most: float | None = None

    def holds(self, given: Any) -> bool:
        """Return whether a number is within the bounds."""
        if self.least is None or self.most is None or not isinstance(given, Real):
            return True
        return not given < self.least and given <= self.most

    def words(self) -> str:
        """Return the bounds in words."""
        return "" if self.most is None else f" from {self.least:.10g} to {self.most:.10g}"


def verb(function: Callable[P, R]) -> Callable[P, R]:
    """Return a function that raises a `FricError` where an argument does not fit its annotation."""
    made, code = _checked(function, function.__name__), unwrap(function).__code__
    count = code.co_argcount + code.co_kwonlyargcount + bool(code.co_flags & CO_VARARGS)
    made.__doc__ = documented(cleandoc(function.__doc__ or ""), code.co_varnames[:count], SHARED)
    seen = signature(made)
    taken = [
        parameter.replace(annotation=_Shown(parameter.annotation), default=_shown(parameter.default))
        for parameter in seen.parameters.values()
    ]
    made.__signature__ = seen.replace(parameters=taken)  # type: ignore[attr-defined]
    return made


@dataclass(frozen=True)
class _Shown:
    """An annotation as ``help`` shows it: the type alone."""

    hint: Any

    def __repr__(self) -> str:
        return _type_text(self.hint)


class _Unnamed:
    """A function that is a default, as ``help`` shows it."""

    def __repr__(self) -> str:
        return "..."


def _shown(default: Any) -> Any:
    return _Unnamed() if isinstance(default, FunctionType) else default


def _type_text(hint: Any) -> str:
    origin, inner = get_origin(hint), get_args(hint)
    if origin is Annotated:
        return _type_text(inner[0])
    if origin in UNIONS:
        return " | ".join(map(_type_text, inner))
    if isinstance(hint, str | ForwardRef):
        return str(getattr(hint, "__forward_arg__", hint))
    return "None" if hint is NoneType else formatannotation(hint)


def documented(doc: str, names: Iterable[str], shared: Mapping[str, str]) -> str:
    """Return a docstring with the sections ``Parameters`` and ``Raises``, for its lines as ``name: what it is``.

    shared: Descriptions of arguments that it does not describe.
    """
    names = list(names)
    known = {*names, "Raises FricError"}
    lines = [line for line in _DESCRIBED.finditer(doc) if known.issuperset(line[1].split(", "))]
    described = {line[1]: line[2] for line in lines}
    raises = {name[7:]: described.pop(name) for name in list(described) if name == "Raises FricError"}
    taken = ", ".join(described).split(", ")
    described |= {name: shared[name] for name in names if name in shared and name not in taken}
    found = doc[: lines[0].start()].rstrip() if lines else doc
    for title, entries in (("Parameters", described), ("Raises", raises)):
        if entries:
            found += f"\n\n{title}\n{'-' * len(title)}"
            found += "".join(f"\n{name}\n    {text}" for name, text in entries.items())
    return found


_DESCRIBED = re.compile(r"^(Raises FricError|\w+(?:, \w+)*): (.+(?:\n    .+)*)", re.MULTILINE)

SHARED: Mapping[str, str] = {  # What arguments of these names are, where the docstring of a verb says nothing of them
    "accuracy": "Largest error of a glitch by the integration; 0 is exact.",
    "advance": "Is called with the number of further steps that are done, and with their total.",
    "axis": "Name of the axis.",
    "blocks": "Slip blocks, for models that have any.",
    "circles": "Circle tests, or run files of `fric simulate circle`. Measured circles are taken, too.",
    "controller": "The controller; by default that of `fric design controller`. A `Cascade`, its file or its result.",
    "encoder": "Of two encoders, the one whose position friction is identified on.",
    "force": "Replace an output that exists.",
    "gain": "Gain of the friction feedforward, instead of the machine's. On all axes.",
    "interrupted": "Is called after each run; if it returns true, only the runs done so far are kept.",
    "known": "Schemes of your own; else the paper's. By name, or their file.",
    "lead": (
        'Lead of the feedforward over the reference, as "0.6 ms", or auto for the nominal plant\'s delay; '
        "instead of the machine's. A number is in seconds."
    ),
    "logs": "Log files of one axis. Records are taken, too.",
    "machine": "A machine file, or a bundled machine such as xy-table. A `Machine` is taken, too.",
    "nominal_files": (
        "Nominal friction of an axis, or its plant, controller, observer or block; repeatable. Files that its "
        "controllers use instead of the machine's, each as ``AXIS=FILE.yaml``. The true axis does not change."
    ),
    "peak_sensitivity": "Largest Ms of the whole loop. A number is a factor.",
    "plant": "The plant, whose linear damping is subtracted. Its file or its result.",
    "record": "The record of LOG.h5 that holds it.",
    "scheduler": "Run on this Dask cluster.",
    "scheme": "Scheme of a run file to use.",
    "schemes": "A scheme's name, several as a,d,f, or all. Or schemes themselves.",
    "seed": "Seed of the coarse search.",
    "static": "A friction file whose static map is kept. Its result is taken, too.",
    "workers": "Parallel processes; by default one per core.",
}


def typed(kind: type[T]) -> type[T]:
    """Return a class whose constructor raises a `FricError` where an argument does not fit its annotation."""
    kind.__init__ = _checked(kind.__init__, kind.__name__)  # type: ignore[method-assign]
    return kind


def _checked(function: Callable[P, R], called: str) -> Callable[P, R]:
    @wraps(function)
    def checked(*args: P.args, **kwargs: P.kwargs) -> R:
        bound = _check(function, called, *args, **kwargs)
        for name, given in bound.arguments.items():
            if isinstance(given, str) and dimensions_of(_hints(function)[name]):
                bound.arguments[name] = Typed(given)
                bound.arguments[name].argument = name
        try:
            made = function(*bound.args, **bound.kwargs)
        except UnfitError as error:
            later = (f"takes {name} as" for name, given in [*bound.arguments.items()][1:] if given is error.given)
            raise FricError(f"{called} {error.what.replace('takes', next(later, 'takes'), 1)}") from None
        except OSError as error:
            raise of_path(error) from None
        if "fric.cli" not in sys.modules:
            sys.modules["fric"].explain_loaded()  # objects of classes that nobody asked for by name
        return made

    return checked


def _check(function: Callable[P, Any], called: str, *args: P.args, **kwargs: P.kwargs) -> BoundArguments:
    """Return the arguments by name; a `FricError` names one which is missing, unknown, or does not fit its hint."""
    try:
        bound = _signature(function).bind(*args, **kwargs)
    except TypeError:
        raise _unbound(function, called, args, kwargs) from None
    for name, given in bound.arguments.items():
        hint = _hints(function)[name]
        texts = given if isinstance(given, list | tuple) else [given]
        if function.__name__ != "__init__" and not all(map(_encodable, texts)):  # a name that is held is printed clean
            raise FricError(f"`{name}=` of {called} holds a character that no file's name has", hint="Type it anew.")
        if not _fits(given, hint):
            if isinstance(given, str) and (choices := _choices(hint)):
                what = f"{called} takes {name} as {_words(hint)}, and was given '{given}'"
                raise FricError(what, hint=near(given, choices))
            raise refused(called, f"{name} as {_words(hint)}", given)
        default = _signature(function).parameters[name].default
        if isinstance(given, list | tuple) and not given and isinstance(default, str):
            raise FricError(f"`{name}=` of {called} is empty", hint=f"Leave it out for '{default}'.")
        if not all(kind.holds(given) for kind in kinds_of(hint)):
            raise FricError(f"{called} takes {name} as {_words(hint)}, and was given {given}")
    return bound


def _encodable(given: Any) -> bool:
    """Return whether a text or path can be given to the system: not with a lone surrogate, or a null."""
    try:
        return not isinstance(given, str | Path) or b"\0" not in os.fsencode(given)
    except UnicodeEncodeError:
        return False


MEANT = {flag.removeprefix("--").replace("-", "_"): name for name, flag in FLAGS.items()} | {"feed": "velocity"}
"""Arguments by the names that options have."""


def _unbound(function: Callable[..., Any], called: str, args: Sequence[Any], kwargs: Mapping[str, Any]) -> FricError:
    """Return the error of arguments that are missing, not known, given twice, or too many."""
    of = {"self", "cls"} & _signature(function).parameters.keys()
    known = {name: parameter for name, parameter in _signature(function).parameters.items() if name not in of}
    has = f"Its arguments are {', '.join(known)}." if known else "It has no argument."
    for name in kwargs:
        if name not in known:
            meant = f"Is it {MEANT[name]}? " if MEANT.get(name) in known else near(name, known)
            return FricError(f"{called} has no argument '{name}'", hint=meant + has)
    places = [name for name, parameter in known.items() if parameter.kind in {Parameter.POSITIONAL_OR_KEYWORD}]
    given = args[len(of) :]
    if len(given) > len(places) and Parameter.VAR_POSITIONAL not in {parameter.kind for parameter in known.values()}:
        return FricError(f"{called} takes {len(places)} arguments by their place, and was given {len(given)}",
                         hint=f"Give the others by name. {has}")  # fmt: skip
    here = {*places[: len(given)], *kwargs}
    if twice := [name for name in places[: len(given)] if name in kwargs]:
        return FricError(f"{called} was given {' and '.join(twice)} twice", hint="Give it once.")
    lacks = [name for name, parameter in known.items() if parameter.default is Parameter.empty and name not in here
             and parameter.kind is not Parameter.VAR_POSITIONAL]  # fmt: skip
    return FricError(f"{called} needs {', '.join(lacks)}", hint=has)


def explained(kind: type[T]) -> type[T]:
    """Return a class whose constructor and methods raise a `FricError` that names the argument, not a `TypeError`.

    Arguments are looked at once a call has failed, which makes it as fast as before. Docstrings get their sections.
    """
    kind.__doc__ = documented(cleandoc(kind.__doc__ or ""), signature(kind).parameters, {})
    for base in kind.__mro__:
        for name, member in [*vars(base).items()]:
            method = getattr(member, "__func__", member)
            if not (isinstance(method, FunctionType) and method.__module__.startswith("fric.")):
                continue
            if method.__doc__:
                method.__doc__ = documented(cleandoc(method.__doc__), signature(method).parameters, {})
            checks = hasattr(method, "explains" if name == "__init__" else "__wrapped__")
            if not checks and (name == "__init__" or not name.startswith("_")):
                made = _explaining(method)
                setattr(base, name, made if member is method else type(member)(made))
    return kind


def _explaining(method: Callable[P, R]) -> Callable[P, R]:
    @wraps(method)
    def explaining(*args: P.args, **kwargs: P.kwargs) -> R:
        try:
            return method(*args, **kwargs)
        except (TypeError, AttributeError, ValueError, ArithmeticError):
            owner: Any = args[0] if args else method
            owner = owner if isinstance(owner, type) else type(owner)
            called = owner.__name__ if method.__name__ == "__init__" else f"{owner.__name__}.{method.__name__}"
            _check(method, called, *args, **kwargs)
            raise

    explaining.explains = True  # type: ignore[attr-defined]
    return explaining


class UnfitError(FricError):
    """What a verb was given is of no type that it takes; its name is put before this.

    wanted: What it takes.
    given: What it was given.
    """

    def __init__(self, wanted: str, given: Any) -> None:
        kind = type(given).__name__
        if isinstance(given, list | tuple) and given:
            kind += f" of {', '.join(sorted({type(item).__name__ for item in given}))}"
        what = "None" if given is None else f"{'an' if kind[0].lower() in 'aeiou' else 'a'} {kind}"
        super().__init__(f"takes {wanted}, and was given {what}")
        self.given = given


def refused(name: str, wanted: str, given: Any) -> FricError:
    """Return the error of an argument of a wrong type, in a sentence."""
    return FricError(f"{name} {UnfitError(wanted, given).what}")


def useless(goes_with: str, **given: Any) -> None:
    """Raise a `FricError` where an argument is given that says nothing here, and what it goes with."""
    for name, value in given.items():
        if value is not None:
            raise FricError(f"`{name}=` goes with {goes_with}", hint="Leave it out.")


def require_numbers(holder: Any, names: Iterable[str], several: Container[str] = ()) -> None:
    """Raise the error of a wrong type where a field is no number, or of those in ``several`` one of its values.

    Other numbers than those of Python and NumPy, such as fractions, become floats, which is what is compiled for.
    """
    for name in names:
        given = getattr(holder, name)
        if name in several:
            right = isinstance(given, Iterable) and all(map(is_number, given))
        else:
            right = isinstance(given, float) or is_number(given)
            if right and not isinstance(given, float | int):
                object.__setattr__(holder, name, float(given))
        if not right:
            raise refused(type(holder).__name__, f"{name} as {'numbers' if name in several else 'a number'}", given)


@cache
def _range(text: str) -> tuple[float, float, str]:
    low, high = map(float, text[1:-1].split(","))
    least = f"{'at least' if text[0] == '[' else 'above'} {low:g}" if isfinite(low) else ""
    most = f"{'at most' if text[-1] == ']' else 'below'} {high:g}" if isfinite(high) else "finite" * (text[-1] == ")")
    return low, high, " and ".join(filter(None, (least, most)))


def require_within(holder: Any, of: str, where: str = "", **ranges: str) -> None:
    """Raise a `FricError` where a field is no number in its range, such as ``(0, inf]`` of those above 0.

    of: What the fields are of, in the words of a message.
    """
    require_numbers(holder, ranges)
    for name, text in ranges.items():
        value, (low, high, words) = getattr(holder, name), _range(text)
        if not (low < value < high or (text[0] == "[" and value == low) or (text[-1] == "]" and value == high)):
            given = f"{value:g}" if not abs(value) > 1e15 else "beyond all drives"
            raise FricError(f"{name} of {of} is {given}", where=where, hint=f"{name} must be {words}.")


def is_number(given: Any) -> bool:
    """Return whether a double holds it, as most of NumPy's numbers; no truth value or time is a number."""
    if isinstance(given, int):
        return not isinstance(given, bool) and abs(given) <= sys.float_info.max
    return isinstance(given, Real) and getattr(getattr(given, "dtype", None), "char", "d") not in "gm"


_signature = cache(signature)


@cache
def _hints(function: Callable[..., Any]) -> dict[str, Any]:
    """Return the annotations as types; Any where an annotation needs an import that only type checkers make."""
    found = {}
    for name, parameter in _signature(function).parameters.items():
        if isinstance(hint := parameter.annotation, str):
            try:
                hint = eval(hint, function.__globals__)
            except NameError:
                hint = Any
        if parameter.kind is Parameter.VAR_POSITIONAL:
            hint = Iterable[hint]  # type: ignore[valid-type]
        found[name] = Any if parameter.kind is Parameter.VAR_KEYWORD or hint is Parameter.empty else hint
    return found


def _fits(given: Any, hint: Any) -> bool:
    origin, inner = get_origin(hint), get_args(hint)
    if origin is Annotated:
        return _fits(given, inner[0])
    if origin in UNIONS:
        return any(_fits(given, item) for item in inner)
    if origin is Literal:
        return isinstance(given, str) and given in inner
    if hint is float:
        return is_number(given)
    if hint is int:
        return isinstance(given, Integral) and not isinstance(given, bool)
    if getattr(origin, "__name__", "") == "ndarray":  # whoever keeps an array tells what it is
        return True
    if getattr(hint, "_is_protocol", False) or origin is Callable:
        return callable(given) or (origin is not Callable and "__call__" not in vars(hint))
    if isinstance(origin, type) and issubclass(origin, Iterable):
        right = isinstance(given, origin) and not isinstance(given, str | bytes) and getattr(given, "ndim", 1) != 0
        if origin is tuple and ... not in inner:
            return right and len(given) == len(inner) and all(map(_fits, given, inner))
        if isinstance(given, Mapping) and issubclass(origin, Mapping):
            return all(_fits(name, inner[0]) and _fits(item, inner[1]) for name, item in given.items())
        again = given if hasattr(given, "__len__") else ()  # of an iterator nothing is read ahead
        return right and all(_fits(item, inner[0]) for item in again)
    return hint is Any or not isinstance(hint, type) or isinstance(given, hint)


def kinds_of(hint: Any) -> list[Kind]:
    """Return the metadata of an annotation besides the type, outermost first; of an optional type, too."""
    origin, inner = get_origin(hint), get_args(hint)
    if origin is Annotated:
        return [*(kind for kind in inner[:0:-1] if isinstance(kind, Kind)), *kinds_of(inner[0])]
    return [kind for item in inner for kind in kinds_of(item)] if origin in UNIONS and NoneType in inner else []


def dimensions_of(hint: Any) -> list[str]:
    """Return the texts in the metadata of an annotation, such as the dimension of a quantity; also if optional."""
    origin, inner = get_origin(hint), get_args(hint)
    if origin is Annotated:
        return [*(text for text in inner[1:] if isinstance(text, str)), *dimensions_of(inner[0])]
    return [text for item in inner for text in dimensions_of(item)] if origin in UNIONS and NoneType in inner else []


def _choices(hint: Any) -> list[str]:
    """Return the texts that an annotation admits, each by its name."""
    inner = get_args(hint)
    return list(inner) if get_origin(hint) is Literal else [text for item in inner for text in _choices(item)]


def _words(hint: Any) -> str:
    origin, inner = get_origin(hint), get_args(hint)
    if origin is Annotated:
        return _words(inner[0]) + "".join(kind.words() for kind in kinds_of(hint))
    if origin in UNIONS:
        return " or ".join(filter(None, map(_words, inner)))
    if origin is Literal:
        return " or ".join(inner)
    if isinstance(origin, type) and issubclass(origin, Iterable):
        named = issubclass(origin, Mapping)
        return f"a {'mapping' if named else 'list'}, of {_words(inner[named])} each"
    return WORDS.get(hint, getattr(hint, "__name__", str(hint)))


@dataclass(frozen=True)
class Argument:
    """One argument of a verb, as its source states it."""

    name: str
    hint: Any  # The annotation
    default: Any  # The default, or `inspect.Parameter.empty`
    positional: bool  # Whether it may be given by its place
    several: bool  # Whether it collects all positional arguments
    help: str  # The first sentence of its description


def folders(room: str) -> list[str]:
    """Return the folders of a room of fric, which need not be imported for it: ``fric.results``."""
    known = sys.modules.get(room)
    return list(known.__path__) if known else [str(Path(__file__).parent.joinpath(*room.split(".")[1:]))]


def verbs_in(room: str) -> dict[str, str]:
    """Return module and name of each verb in the files of a room, by name; the files are read, not imported."""
    files = sorted(path for folder in folders(room) for path in Path(folder).glob("*.py"))
    named = ((path.stem, re.findall(r"^@verb\ndef (\w+)", path.read_text("utf-8"), re.MULTILINE)) for path in files)
    return {name: f"{room}.{stem}:{name}" for stem, names in named for name in names}


class VerbForm:
    """The source of a verb: its text, and its arguments in their order.

    The source is read, not imported: a command's help waits for no library. What its annotations name is imported from
    where the source states it; those of an argument are read when they are needed.

    home: Module and name: ``fric.results.identify:identify_static``.
    """

    def __init__(self, home: str) -> None:
        self.module, _, self.name = home.partition(":")
        room, _, file = self.module.rpartition(".")
        places = (Path(folder) / f"{file}.py" for folder in folders(room))
        self._source = next(place for place in places if place.is_file()).read_text(encoding="utf-8")
        begin = self._source.index(f"\ndef {self.name}(") + 1
        self._quotes = self._source.index('\n    """', begin) + 5
        self._end = self._source.index('"""', self._quotes + 3) + 3
        self._head = self._source[begin : self._end]

    @cached_property
    def text(self) -> str:
        """What it does: the docstring up to its first section."""
        return self._doc[0].strip()

    @cached_property
    def names(self) -> list[str]:
        """The names of the arguments, in their order."""
        return list(self._arguments)

    def __getitem__(self, name: str) -> Argument:
        found, default, by_name = self._arguments[name]
        assert found.annotation is not None
        return Argument(
            name, self._value(found.annotation), Parameter.empty if default is None else self._value(default),
            not by_name, found is self._taken.vararg, self._sentences.get(name, ""),
        )  # fmt: skip

    @cached_property
    def _taken(self) -> ast.arguments:
        (found,) = ast.parse(self._head).body
        assert isinstance(found, ast.FunctionDef)
        return found.args

    @cached_property
    def _arguments(self) -> dict[str, tuple[ast.arg, ast.expr | None, bool]]:
        """Each argument, its default, and whether it is given by name alone."""
        taken = self._taken
        places = [*taken.args, *filter(None, [taken.vararg])]
        defaults = [*[None] * (len(taken.args) - len(taken.defaults)), *taken.defaults, *[None] * bool(taken.vararg)]
        placed = {found.arg: (found, default, False) for found, default in zip(places, defaults, strict=True)}
        named = zip(taken.kwonlyargs, taken.kw_defaults, strict=True)
        return placed | {found.arg: (found, default, True) for found, default in named}

    @cached_property
    def _doc(self) -> list[str]:
        """The docstring, by sections: the text, then each section behind its title."""
        doc = documented(cleandoc(self._source[self._quotes + 3 : self._end - 3]), self.names, SHARED)
        return re.split(r"^(\w+)\n-{4,}\n", doc, flags=re.MULTILINE)

    @cached_property
    def _sentences(self) -> dict[str, str]:
        """The first sentence of the description of each argument."""
        if "Parameters" not in self._doc:
            return {}
        found: dict[str, str] = {}
        pieces = re.split(r"^(\w[\w, ]*)\n", self._doc[self._doc.index("Parameters") + 1], flags=re.MULTILINE)
        for names, text in zip(pieces[1::2], pieces[2::2], strict=True):
            first = re.split(r"(?<=[.?…])\s+(?=[A-Z`])", " ".join(text.split()), maxsplit=1)[0]
            found |= dict.fromkeys(names.split(", "), first)
        return found

    def _value(self, expression: ast.expr) -> Any:
        """Return the object of an annotation or a default; its names are imported from where the source has them."""
        names = {node.id for node in ast.walk(expression) if isinstance(node, ast.Name)}
        known = {name: self._imported(name) for name in names}
        return eval(ast.unparse(expression), {name: value for name, value in known.items() if value is not None})

    def _imported(self, name: str) -> Any:
        if name in self._constants:
            return self._value(ast.parse(self._constants[name], mode="eval").body)
        return getattr(import_module(self._homes[name]), name) if name in self._homes else None

    @cached_property
    def _constants(self) -> dict[str, str]:
        """What the source assigns in a line, by name."""
        return dict(re.findall(r"^(\w+)(?::[^=\n]+)? = (.+)$", self._source, re.MULTILINE))

    @cached_property
    def _homes(self) -> dict[str, str]:
        """The module of each name that the source imports from a module."""
        lines = re.findall(r"^from (\S+) import (?:\(([^)]*)\)|(.+))$", self._source, re.MULTILINE)
        return {name: module for module, *names in lines for name in re.findall(r"\w+", "".join(names))}
