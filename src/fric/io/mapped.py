"""Which mapping foreign files are read with, where none is given: by their header, or as fric would guess it."""

from collections.abc import Sequence
from contextlib import ExitStack, closing
from dataclasses import dataclass
from pathlib import Path

from fric.columns import Kind
from fric.documents.mapping import MappingDocument
from fric.documents.yaml import read_text
from fric.errors import FricError
from fric.flaws.files import MAPPING_ASSUMED, MAPPING_OPEN, MAPPING_PROPOSED
from fric.io.channels import plan
from fric.io.propose import Guess, asked, assumption, guesses, is_sure, mapping_text
from fric.io.quantities import spoken
from fric.io.readers import tables
from fric.io.readers.base import OF_SEVERAL
from fric.io.recognise import is_hdf5
from fric.notice import Notice
from fric.units import Motion


@dataclass(frozen=True)
class Guessed:
    """What is guessed of files whose headers do not say what their columns are."""

    found: tuple[Guess, ...]

    @property
    def sure(self) -> bool:
        """Whether nothing is open."""
        return all(map(is_sure, self.found))

    @property
    def usable(self) -> tuple[Guess, ...]:
        """Those that can be read where the likeliest is taken."""
        return tuple(one for one in self.found if one.whole)

    def text(self) -> str:
        """Return the mapping with the likeliest of what is open."""
        return mapping_text(self.usable, assume=True)

    def mapping(self) -> MappingDocument:
        """Return the mapping with the likeliest of what is open."""
        return read_text(self.text(), MappingDocument)

    def notices(self, mapping: str = "") -> list[Notice]:
        """Return what was assumed, and what was sure."""
        told = []
        for one in self.usable:
            files = _files(one)
            roles = one.axis.roles.items()
            means = ", ".join(f'{k} is "{one.table.columns[r.column].name}"' for k, r in roles if r.column is not None)
            if what := assumption(one):
                told.append(MAPPING_ASSUMED.found(files=files, what=what, mapping=mapping))
            else:
                told.append(MAPPING_PROPOSED.found(mapping=mapping or "by its values", columns=means, files=files))
        return told

    def asked(self) -> list[Notice]:
        """Return what is open, a notice for files of one kind."""
        return [
            MAPPING_OPEN.found(files=_files(one), what=assumption(one) or "another of its axes") for one in self.found
        ]

    def error(self) -> FricError:
        """Return all that is open in one error."""
        return asked(self.found)


def _files(guess: Guess) -> str:
    return f"{guess.files[0]}" + (f" and {len(guess.files) - 1} more" if len(guess.files) > 1 else "")


def guessed(
    paths: Sequence[Path],
    files: ExitStack,
    kind: Kind | None = None,
    motion: Motion | None = None,
    *,
    assume: bool = False,
) -> Guessed:
    """Return what is guessed of those files whose header does not say what their columns are.

    Files that do not read, and those of fric's own, are none of them. Of a file whose header says all but the force
    (a current is one), that is taken where it is sure, or the likeliest is ``assume``d.
    """
    asking, free = [], set[Path]()
    for path in paths:
        try:
            said = not is_hdf5(path) and says_all(path, kind, motion)
        except FricError:
            continue
        if said is None or said == "force":
            asking.append(path)
            free |= {path} if said else set()
    found = guesses(asking, files) if asking else []
    return Guessed(tuple(one for one in found if assume or is_sure(one) or not free.issuperset(one.files)))


def says_all(path: Path, kind: Kind | None = None, motion: Motion | None = None) -> str | None:
    """Return what the header of a foreign file leaves out: nothing, or the ``force``; None where it does not read."""
    left = ""
    with closing(tables(path, None)) as opened:
        for table in opened:
            try:
                chosen = plan(table, None, kind, motion, {})
            except FricError:
                return None
            rest = [column for n, column in enumerate(table.columns) if n not in chosen.wanted]
            if chosen.form == "time" and not {"force", "input"} & chosen.origins.keys():
                left = left or ("force" if any(spoken(column).quantity == "force" for column in rest) else "")
    return left


def axes_said(path: Path) -> list[str | None]:
    """Return the axes that a foreign file says it has tables of; None alone where it has one, or says none."""
    try:
        with closing(tables(path, None)) as opened:
            for table in opened:
                return list(table.said.get(OF_SEVERAL, "").split()) or [None]
    except FricError:
        pass
    return [None]
