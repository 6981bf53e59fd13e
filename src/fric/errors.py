"""The one exception that fric raises on purpose."""

from collections.abc import Iterable

MOST = 400
"""Characters of each part of a message at most."""


def printable(text: str, most: int = MOST) -> str:
    """Return a text on one line that a terminal shows as it is: without control characters, and cut in its middle."""
    clean = "".join(one if one.isprintable() else " " if one.isspace() else "\N{REPLACEMENT CHARACTER}" for one in text)
    return clean if len(clean) <= most else f"{clean[: 2 * most // 3]} … {clean[-(most // 3) :]}"


class FricError(Exception):
    """An input, or the data in it, does not allow what was asked.

    The message is one or two lines: what is wrong, where (file, line, column or record), and what to do.
    The command line prints it and leaves with exit status 1.

    Parameters
    ----------
    what
        What is wrong, in the user's words.
    where
        File, line, column or record it was found in; empty where there is none.
    hint
        What the user can do about it.
    """

    def __init__(self, what: str, *, where: str = "", hint: str = "") -> None:
        self.what, self.where, self.hint = what, where, hint
        head = f"{printable(where)}: {printable(what)}" if where else printable(what)
        super().__init__(f"{head}\n{printable(hint)}" if hint else head)

    def at(self, where: str) -> "FricError":
        """Return the same error, told with the place where it was found (outermost place first)."""
        return FricError(self.what, where=f"{where}: {self.where}" if self.where else where, hint=self.hint)


def near(given: str, known: Iterable[str]) -> str:
    """Return the question whether a name that is near was meant, with a blank behind it; nothing where none is."""
    from difflib import get_close_matches

    folded = {name.casefold(): name for name in known}
    found = get_close_matches(str(given).casefold(), folded, n=1, cutoff=0.65)
    return f"Is it {folded[found[0]]}? " if found else ""
