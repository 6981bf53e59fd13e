"""The one exception that fric raises on purpose."""

import errno
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from functools import wraps
from typing import ParamSpec, TypeVar

P = ParamSpec("P")
R = TypeVar("R")
MOST_CHARACTERS = 400  # Characters of each part of a message at most
FLAGS = {"circles": "--circle", "controllers": "--controller", "mapping": "--map", "machines": "--monte-carlo"}
"""Options of most commands whose name differs from that of their argument."""
REWORDED = {  # What pydantic says of a value, and what a user reads
    "Value error, ": "", "Input should be a valid integer": "give a whole number",
    "Input should be a valid string": "give a text", "Input should be greater than or equal to": "give at least",
    "Input should be a valid": "give a", "Input should be less than or equal to": "give at most",
    "Input should": "it should",
}  # fmt: skip


def clean(text: str) -> str:
    """Return a text that is safe in a terminal, a page, a document and the name of a file.

    All text from outside passes through this function. It keeps line ends and removes every other character that does
    not print: control characters, escape sequences and lone surrogates, which no encoding holds.
    """
    if text.replace("\n", "").isprintable():
        return str(text)
    blank = "\N{REPLACEMENT CHARACTER}"
    return "".join(text if text.isprintable() or text == "\n" else " " if text.isspace() else blank for text in text)


def printable(text: str, most: int = MOST_CHARACTERS) -> str:
    """Return a text as `clean` does, on one line, and cut in its middle."""
    line = clean(text).replace("\n", " ")
    return line if len(line) <= most else f"{line[: 2 * most // 3]} … {line[-(most // 3) :]}"


def require_name(name: str, where: str = "", what: str = "an axis") -> str:
    """Return the name of an axis or of a scheme, which files, groups, shell scripts and programs are named by.

    what: What it names, with its article.
    Raises FricError: When it holds more than letters, digits and a few signs: a name from a foreign file could
        otherwise write files elsewhere, or add lines to a program.
    """
    if not re.fullmatch(r"\w[\w .+-]{0,39}", name) or name == "monte_carlo":  # A group of the files of runs
        hint = "Take letters, digits, spaces and _ . + -, 40 at most, a letter or a digit first."
        raise FricError(f"'{name}' is not a name of {what}", where=where, hint=hint)
    return name


def reworded(said: str) -> str:
    """Return what pydantic says of a value in the words of a user."""
    said = said.partition(", unable to parse")[0]
    for words, shown in REWORDED.items():
        said = said.replace(words, shown)
    return said


def as_options(text: str, flags: Mapping[str, str] = FLAGS) -> str:
    """Return a text with arguments, as ```load='5 N'```, replaced by the options of the command line."""

    def option_of(found: re.Match[str]) -> str:
        flag = flags.get(found[1], f"--{found[1].replace('_', '-')}")
        flag = next(text for text in flag.split() if text.startswith("--"))
        value = found[2].strip("'")
        shown = "" if value in {"", "True"} else f" '{value}'" if " " in value else f" {value}"
        return flag + shown

    text = text.replace("`with fric.lifted():`", "--implausible ok")
    return re.sub(r"`([A-Za-z]\w*)=([^`]*)`", option_of, text)


class FricError(Exception):
    """An input, or the data in it, does not allow what was asked.

    The message is one or two lines: what is wrong, where (file, line, column or record), and what to do.
    The command line prints it and leaves with exit status 1.

    what: What is wrong, in the user's words.
    where: File, line, column or record it was found in; empty where there is none.
    hint: What the user can do about it.
    form: A file to fill in, shown in full below.
    """

    def __init__(self, what: str, *, where: str = "", hint: str = "", form: str = "") -> None:
        self.what, self.where, self.hint, self.form = what, where, hint, form
        head = f"{printable(where)}: {printable(what)}" if where else printable(what)
        super().__init__("\n".join([head, *([printable(hint)] if hint else []), *([clean(form)] if form else [])]))

    def at(self, where: str) -> "FricError":
        """Return the same error with the place where it was found (outermost place first)."""
        place = f"{where}: {self.where}" if self.where not in {"", where} else where
        return FricError(self.what, where=place, hint=self.hint, form=self.form)


@contextmanager
def found_in(where: str) -> Iterator[None]:
    """Add the place to an error of a block, where it was found; nothing where the place is empty."""
    try:
        yield
    except FricError as error:
        raise error.at(where) if where else error from None


def of_path(error: OSError) -> OSError | FricError:
    """Return the error of a path that the system does not take; any other is returned as it is."""
    if error.filename is None or error.errno not in {errno.ENAMETOOLONG, errno.ELOOP, errno.EACCES, errno.EPERM}:
        return error
    hint = "Give a shorter path, or that of a file that you may read."
    return FricError(error.strerror or "", where=str(error.filename), hint=hint)


class Typed(str):
    """A quantity as it was typed, which names its argument where it is refused."""

    argument = ""


def names(read: Callable[P, R]) -> Callable[P, R]:
    """Return a function that reads a quantity, whose errors name the argument that it was typed for."""

    @wraps(read)
    def reading(*args: P.args, **kwargs: P.kwargs) -> R:
        try:
            return read(*args, **kwargs)
        except FricError as error:
            if isinstance(args[0], Typed) and not error.where:
                raise error.at(f"`{args[0].argument}=`") from None
            raise

    return reading


def near(given: str, known: Iterable[str]) -> str:
    """Return the question whether a similar name was meant, followed by a blank; empty if no name is similar."""
    from difflib import get_close_matches

    folded = {name.casefold(): name for name in known}
    found = get_close_matches(str(given).casefold(), folded, n=1, cutoff=0.65)
    return f"Is it {folded[found[0]]}? " if found else ""


def require_known(name: str, known: Iterable[str], what: str, there: str = "There are", where: str = "") -> None:
    """Raise a `FricError` with a similar name and all there are, if a name is not known: ``there is no target``."""
    if name not in known:
        hint = f"{near(name, known)}{there} {', '.join(known) or 'none'}."
        raise FricError(f"{what} '{name}'", where=where, hint=hint)
