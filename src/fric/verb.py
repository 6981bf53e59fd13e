"""What a public verb or constructor is given of a wrong type ends in a sentence, by its own annotations."""

from collections.abc import Callable, Container, Iterable, Mapping
from functools import cache, wraps
from inspect import Parameter, signature
from numbers import Integral, Real
from pathlib import Path
from types import NoneType, UnionType
from typing import Any, Literal, ParamSpec, TypeVar, Union, get_args, get_origin

from fric.errors import FricError

P = ParamSpec("P")
R = TypeVar("R")
T = TypeVar("T")
WORDS = {str: "a text", Path: "a path", float: "a number", int: "a whole number", bool: "True or False", NoneType: ""}
NUMBERS: dict[Any, type] = {float: Real, int: Integral}
"""NumPy's numbers too; no truth value is a number."""


def verb(function: Callable[P, R]) -> Callable[P, R]:
    """Return a function that raises a `FricError` where an argument is not what its annotation says."""
    return _checked(function, function.__name__)


def typed(kind: type[T]) -> type[T]:
    """Return a class whose constructor raises a `FricError` where an argument is not what its annotation says."""
    kind.__init__ = _checked(kind.__init__, kind.__name__)  # type: ignore[method-assign]
    return kind


def _checked(function: Callable[P, R], called: str) -> Callable[P, R]:
    @wraps(function)
    def checked(*args: P.args, **kwargs: P.kwargs) -> R:
        for name, given in _signature(function).bind(*args, **kwargs).arguments.items():
            hint = _hints(function)[name]
            if not _fits(given, hint):
                raise refused(called, f"{name} as {_words(hint)}", given)
        return function(*args, **kwargs)

    return checked


def refused(name: str, wanted: str, given: Any) -> FricError:
    """Return the error of an argument of a wrong type, in a sentence."""
    kind = type(given).__name__
    what = "None" if given is None else f"{'an' if kind[0].lower() in 'aeiou' else 'a'} {kind}"
    return FricError(f"{name} takes {wanted}, and was given {what}")


def require_numbers(holder: Any, names: Iterable[str], several: Container[str] = ()) -> None:
    """Raise the error of a wrong type where a field is no number, or of those in ``several`` one of its values."""
    for name in names:
        given = getattr(holder, name)
        if name in several:
            right = isinstance(given, Iterable) and all(map(_is_number, given))
        else:
            right = isinstance(given, float) or _is_number(given)
        if not right:
            raise refused(type(holder).__name__, f"{name} as {'numbers' if name in several else 'a number'}", given)


def _is_number(given: Any) -> bool:
    return isinstance(given, float) or (isinstance(given, Real) and not isinstance(given, bool))


_signature = cache(signature)


@cache
def _hints(function: Callable[..., Any]) -> dict[str, Any]:
    """Return what the annotations say; anything where one waits for an import of type checkers alone."""
    found = {}
    for name, one in _signature(function).parameters.items():
        hint = one.annotation
        if isinstance(hint, str):
            try:
                hint = eval(hint, function.__globals__)
            except NameError:
                hint = Any
        if one.kind is Parameter.VAR_POSITIONAL:
            hint = Iterable[hint]  # type: ignore[valid-type]
        found[name] = Any if one.kind is Parameter.VAR_KEYWORD or hint is Parameter.empty else hint
    return found


def _fits(given: Any, hint: Any) -> bool:
    origin, inner = get_origin(hint), get_args(hint)
    if origin in {Union, UnionType}:
        return any(_fits(given, one) for one in inner)
    if origin is Literal:
        return isinstance(given, str) and given in inner
    if hint in NUMBERS:
        return isinstance(given, NUMBERS[hint]) and not isinstance(given, bool)
    if getattr(hint, "_is_protocol", False) or origin is Callable:
        return callable(given)
    if isinstance(origin, type) and issubclass(origin, Iterable):
        right = isinstance(given, origin) and not isinstance(given, str | bytes)
        return right and (issubclass(origin, Mapping) or all(_fits(one, inner[0]) for one in _again(given)))
    return hint is Any or not isinstance(hint, type) or isinstance(given, hint)


def _again(given: Any) -> Iterable[Any]:
    """Return what can be read twice; of an iterator nothing is read ahead."""
    return given if hasattr(given, "__len__") else ()


def _words(hint: Any) -> str:
    origin, inner = get_origin(hint), get_args(hint)
    if origin in {Union, UnionType}:
        return " or ".join(filter(None, map(_words, inner)))
    if origin is Literal:
        return " or ".join(inner)
    if isinstance(origin, type) and issubclass(origin, Iterable) and not issubclass(origin, Mapping):
        return f"a list, of {_words(inner[0])} each"
    return WORDS.get(hint, getattr(hint, "__name__", str(hint)))
