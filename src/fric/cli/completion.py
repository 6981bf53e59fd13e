"""What the shell completes: names of schemes, axes, records, document types, examples and pages.

Each is asked by the shell in a process of its own; what does not read completes to nothing.
"""

import re
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from importlib import import_module
from pathlib import Path

import typer

_PLAIN = re.compile(r"[\w.,:+@%=-]+")  # What a shell takes as it stands: a name out of a file could be a command
Words = Sequence[str]  # The words of the line so far, without those that name commands


def _completes(names: Callable[[Words], Iterable[str]]) -> Callable[[typer.Context, str], list[str]]:
    """Return a completion by what the other words of the line give."""

    def complete(ctx: typer.Context, incomplete: str) -> list[str]:
        with suppress(Exception):
            # of a line that ends in an option the other options are parsed, and its words are left as they are
            words = [*ctx.args, *(("--schemes", str(schemes)) if (schemes := ctx.params.get("known")) else ())]
            return [name for name in names(words) if name.startswith(incomplete) and _PLAIN.fullmatch(name)]
        return []

    return complete


def _schemes(words: Words) -> Iterable[str]:
    from fric.control.scheme import PAPER_SCHEMES
    from fric.documents.schemes import read_schemes

    schemes = words[words.index("--schemes") + 1] if "--schemes" in words else None
    return [*(read_schemes(Path(schemes)) if schemes else PAPER_SCHEMES), "all"]


def _axes(words: Words) -> Iterable[str]:
    import fric

    for word in words:
        with suppress(fric.FricError):
            return fric.read_machine(Path(word)).axes
    return []


def _records(words: Words) -> Iterable[str]:
    from fric.io.safe_hdf5 import open_file

    for word in words:
        if word.endswith(".h5"):
            with open_file(Path(word)) as file:
                yield from file["records"]


def _listed(home: str) -> Callable[[Words], Iterable[str]]:
    """Return what lists the names that a function of fric gives, as ``module:function``."""
    module, _, function = home.partition(":")
    return lambda words: getattr(import_module(module), function)()


schemes, axes, records = _completes(_schemes), _completes(_axes), _completes(_records)
types, examples, topics = (
    _completes(_listed(f"fric.documents{home}")) for home in (":document_types", ".bundled:examples", ".bundled:topics")
)
