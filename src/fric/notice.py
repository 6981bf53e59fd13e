"""Warnings: a flaw of a record or a result, with its values and its place."""

from collections.abc import Iterable, Mapping
from math import isfinite
from types import MappingProxyType
from typing import Any, Literal, get_args

from fric.errors import require_known

Severity = Literal["note", "doubt", "wrong"]
"""``note``: good to know; ``doubt``: a number may be off by more than its interval; ``wrong``: it is, until mended."""


class Notice(str):
    """A warning as data: it reads as its text, and carries what programs need. `fric.flaws.Flaw.found` makes it.

    says: The problem, and what to do.
    code: Code of the flaw in `fric.flaws.CATALOGUE`, such as ``force-lags``; empty for a text of an old file.
    severity: See `Severity`.
    values: Numbers, texts and `Estimate` that the sentence names.
    where: Record, file or axis that it was found in; the prefix of the sentence.
    carried: Whether the warning was read from a document.
    Raises FricError: When the severity is none of these.
    """

    __slots__ = ("carried", "code", "severity", "values", "where")

    code: str
    severity: Severity
    values: Mapping[str, Any]
    where: str
    carried: bool

    def __new__(
        cls, says: str, code: str, severity: Severity, values: Mapping[str, Any] = MappingProxyType({}),
        where: str = "", carried: bool = False,
    ) -> "Notice":  # fmt: skip
        """Return the notice."""
        require_known(str(severity), get_args(Severity), "there is no severity")
        made = super().__new__(cls, f"{where}: {says}" if where else says)
        made.code, made.severity, made.values, made.where, made.carried = code, severity, values, where, carried
        return made

    @property
    def head(self) -> str:
        """The word before it on a screen."""
        return "note:" if self.severity == "note" else "warning:"

    @property
    def says(self) -> str:
        """The sentence without its place."""
        return str(self)[len(self.where) + 2 :] if self.where else str(self)

    def at(self, where: str, *, severity: Severity | None = None, carried: bool = False) -> "Notice":
        """Return the same, found in a place (outermost place first)."""
        where = ": ".join(filter(None, (where, self.where)))
        return Notice(self.says, self.code, severity or self.severity, self.values, where, carried or self.carried)

    def __reduce__(self) -> tuple[Any, ...]:
        """Return the arguments for a copy in another process."""
        return Notice, (self.says, self.code, self.severity, dict(self.values), self.where, self.carried)

    @classmethod
    def of(cls, given: str | Mapping[str, Any]) -> "Notice":
        """Return a text as a doubt, or what `as_dict` gave; a notice stays what it is."""
        if isinstance(given, str):
            return given if isinstance(given, Notice) else cls(given, "", "doubt")
        says, code, severity, where = (given.get(name, "") for name in ("text", "code", "severity", "where"))
        values, carried = given.get("values", {}), given.get("carried", False)
        return cls(says.removeprefix(f"{where}: "), code, severity, values, where, carried)

    def as_dict(self) -> dict[str, Any]:
        """Return it as an entry of ``warnings_coded`` in documents, without empty keys."""
        more = {"values": _plain(self.values), "where": self.where, "carried": self.carried}
        head = {"code": self.code, "severity": self.severity, "text": str(self)}
        return head | {name: item for name, item in more.items() if item}


def once(notices: Iterable[Notice]) -> tuple[Notice, ...]:
    """Return notices without duplicates."""
    return tuple(dict.fromkeys(notices))


def _plain(value: Any) -> Any:
    """Return a value of a notice as JSON holds it; a number with a unit as ``{value, unit}``."""
    if isinstance(value, Mapping):
        return {name: _plain(item) for name, item in value.items()}
    if hasattr(value, "as_dict"):
        return _plain(value.as_dict())
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    return None if isinstance(value, float) and not isfinite(value) else value


def enumerated(names: Iterable[str], width: int = 60) -> str:
    """Return names separated by commas, as many as a width takes and at least one, and how many more there are."""
    every = list(names)
    shown = len(every)
    while shown > 1 and len(", ".join(every[:shown])) > width - len(f" and {len(every)} more") * (shown < len(every)):
        shown -= 1
    return ", ".join(every[:shown]) + f" and {len(every) - shown} more" * (shown < len(every))
