"""What the shell completes: names of schemes, axes, records, document types, examples and pages.

Each is asked by the shell in a process of its own; what does not read completes to nothing.
"""

import re
import sys
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
    """Return what lists the names that fric has, or a function of it returns, as ``module:name``."""
    module, _, name = home.partition(":")

    def listed(_: Words) -> Iterable[str]:
        names = getattr(import_module(module), name)
        return names() if callable(names) else names

    return listed


def _machines(_: Words) -> Iterable[str]:
    from fric.documents.bundled import bundled

    return [*bundled("machine"), *(path.name for pattern in ("*.yaml", "*.yml") for path in Path().glob(pattern))]


def of(home: str) -> Callable[[typer.Context, str], list[str]]:
    """Return a completion by its name here, or by the place of the names in fric, as ``module:name``."""
    return _completes(_listed(home)) if ":" in home else getattr(sys.modules[__name__], home)


schemes, axes, records, machines = map(_completes, (_schemes, _axes, _records, _machines))
types, examples, topics = (
    of(f"fric.documents{home}") for home in (":document_types", ".bundled:examples", ".bundled:topics")
)
