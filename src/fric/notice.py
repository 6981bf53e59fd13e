"""What a record cannot tell, or a result must not be trusted for: a text with a code and a severity."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal, get_args

from fric.errors import FricError

Severity = Literal["note", "doubt", "wrong"]
"""``note``: good to know; ``doubt``: a number may be off by more than its interval; ``wrong``: it is, until mended."""


class Notice(str):
    """A warning as data: it reads as its text, and carries a code for programs and a severity.

    Parameters
    ----------
    text
        One or two sentences for people: what is the matter, and what to do.
    code
        What programs know it by, as ``force-lags`` or ``v_s-open``: lower case, words joined by hyphens, and the same
        for every size of the same matter.
    severity
        See `Severity`.

    Raises
    ------
    FricError
        When the severity is none of these.
    """

    __slots__ = ("code", "severity")

    code: str
    severity: Severity

    def __new__(cls, text: str, code: str = "", severity: Severity = "doubt") -> Notice:
        """Return the notice."""
        if severity not in get_args(Severity):
            raise FricError(f"'{severity}' is no severity", hint=f"There are {', '.join(get_args(Severity))}.")
        made = super().__new__(cls, text)
        made.code, made.severity = code, severity
        return made

    def __reduce__(self) -> tuple[type[Notice], tuple[str, str, Severity]]:
        """Return what a copy in another process is made from."""
        return Notice, (str(self), self.code, self.severity)

    @classmethod
    def of(cls, given: str | Mapping[str, Any]) -> Notice:
        """Return a text as a notice, or what `as_dict` gave; one that is a notice already stays what it is."""
        if isinstance(given, str):
            return given if isinstance(given, Notice) else cls(given)
        return cls(given["text"], given["code"], given["severity"])

    def as_dict(self) -> dict[str, str]:
        """Return code, severity and text, as ``warnings_coded`` holds them in documents."""
        return {"code": self.code, "severity": self.severity, "text": str(self)}
