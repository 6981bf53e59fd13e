"""A flaw: one entry of the catalogue, and the notice that it becomes where it is found."""

from collections.abc import Callable, Mapping
from dataclasses import KW_ONLY, dataclass, field
from math import inf
from string import Formatter
from types import SimpleNamespace
from typing import Any

from fric.estimate import Estimate
from fric.notice import Notice, Severity
from fric.units import readable

LISTED = 8  # Elements of a list that a sentence names at most
SMALL = 0.01  # Share of the friction up to which a variation over place or time is only a note
HALF_WIDTHS = 1.0  # Half-widths of the tightest interval of a level above which the variation makes an estimate wrong


def by_size(size: float, level: float, half_width: float) -> Severity:
    """Return how bad it is that a force varies by a size, where a level with an interval was identified [N]."""
    if level == inf:
        return "doubt"
    if size <= SMALL * abs(level):
        return "note"
    return "wrong" if size > HALF_WIDTHS * half_width else "doubt"


@dataclass(frozen=True)
class Flaw:
    """What can be wrong with records, or with results made from them. A new flaw is a new entry in its family.

    Sentences are templates of `str.format`. ``{size}`` and ``{size:2}`` give an `Estimate` with its unit, to 3 and to
    2 digits; ``{share:.2g%}`` percent to two digits; ``{rate:rises|falls}`` the first where the value is true, of a
    number where it is positive; a list is given with commas.
    """

    code: str  # Lower case, words joined by hyphens; the same for every size of the same flaw
    severity: Severity | Callable[[Any], Severity]  # How bad it is, or a function of its values (as attributes)
    says: str  # What is wrong, with named values
    mend: str = ""  # What to do
    _: KW_ONLY
    widens: Mapping[str, float | str] = field(default_factory=dict)
    """By parameter, the error of a prediction: 95 % lie within this share, or that of this value, to either side."""
    circle_settles: bool = False
    """Whether a measured circle settles it: each machine that is drawn has the level of friction of that circle."""
    no_response: bool = False  # Whether it means that the response was not measured, so that an observer is a guess
    disagrees: bool = False  # Whether it means that a measured circle is not as predicted
    word: tuple[str, str] = ("", "")
    """Of a flaw that every session has: the row of the table, and the words shown there instead of a warning."""

    def found(self, where: str = "", /, **values: Any) -> Notice:
        """Return the notice that it was found.

        where: Record, file or axis.
        values: What sentence and severity name: numbers, texts, `Estimate` for what has a unit, and lists of these.
        """
        severity = self.severity if isinstance(self.severity, str) else self.severity(SimpleNamespace(**values))
        says = " ".join(filter(None, (_WORDS.format(self.says, **values), _WORDS.format(self.mend, **values))))
        return Notice(says, self.code, severity, {name: _python(value) for name, value in values.items()}, where)


class _Words(Formatter):
    def format_field(self, value: Any, format_spec: str) -> str:
        if "|" in format_spec:
            true = value > 0 if isinstance(value, int | float) else bool(value)
            return format_spec.split("|")[not true]
        if value is None:
            return ""
        if isinstance(value, list | tuple):
            shown = [self.format_field(item, format_spec) for item in value[:LISTED]]
            return ", ".join([*shown, "…"] if len(value) > LISTED else shown)
        if isinstance(value, Estimate):
            return readable(float(value), value.unit, int(format_spec or 3))
        if format_spec.endswith("g%"):
            return f"{format(100 * value, format_spec[:-1])} %"
        return str(format(value, format_spec))


_WORDS = _Words()


def _python(value: Any) -> Any:
    """Return a value with Python's numbers in place of NumPy's."""
    if isinstance(value, list | tuple):
        return [_python(item) for item in value]
    return value.item() if hasattr(value, "item") else value
