"""Machines from their files, and what else a run takes."""

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from fric.control.scheme import Scheme, choose_schemes
from fric.documents.identified import Identified
from fric.documents.machine_files import read_machine
from fric.documents.schemes import read_schemes
from fric.results.given import path_of
from fric.simulate.machine import Machine
from fric.verb import refused


def machine_of(verb: str, given: Any) -> Machine:
    """Return the machine that is given as itself, as identified, as its file, or by the name of a bundled one."""
    if isinstance(given, Identified):
        return given.machine
    if isinstance(given, Machine):
        return given
    return read_machine(path_of(verb, "a machine, or its file", given))


def schemes_of(verb: str, asked: Any, known: Any = None) -> list[Scheme]:
    """Return the schemes that are asked for by their names, or given as themselves.

    Parameters
    ----------
    verb
        What they are for, in the words of an error.
    asked
        A scheme, several, or names as in ``a,c,f`` or ``all``.
    known
        Schemes by name, or their file; the paper's where not given.
    """
    if isinstance(asked, Scheme):
        return [asked]
    if isinstance(known, str | Path):
        known = read_schemes(Path(known))
    if known is not None and not (
        isinstance(known, Mapping) and all(isinstance(one, Scheme) for one in known.values())
    ):
        raise refused(verb, "schemes by name, or their file", known)
    if isinstance(asked, str):
        return choose_schemes(asked, known)
    if not isinstance(asked, Iterable):
        raise refused(verb, "names of schemes, as a,c,f or all", asked)
    found: list[Scheme] = []
    for one in asked:
        found += schemes_of(verb, one, known)
    return found
