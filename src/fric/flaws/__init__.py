"""The catalogue of flaws of records, models and predictions: a file for each family, an entry for each flaw.

An entry also says what the flaw widens in a prediction and whether a measured circle settles it.
"""

import re
from collections.abc import Mapping
from importlib import import_module
from types import ModuleType

from fric.flaws.base import Flaw
from fric.notice import Notice

FAMILIES: tuple[ModuleType, ...] = tuple(
    import_module(f"{__name__}.{name}")
    for name in (
        "channel", "unit", "drift", "static_map", "response", "blocks", "circle", "prediction", "files",
    )
)  # fmt: skip
"""The families, in the order of the page."""


def _listed() -> Mapping[str, Flaw]:
    flaws = [flaw for family in FAMILIES for flaw in entries(family)]
    found = {flaw.code: flaw for flaw in flaws}
    if len(found) < len(flaws):
        raise ValueError("two flaws have one code")
    return found


def entries(family: ModuleType) -> list[Flaw]:
    """Return the flaws of a family."""
    tables = [
        item if isinstance(item, Mapping) else {"": item} for name, item in vars(family).items() if name.isupper()
    ]
    return [flaw for table in tables for flaw in table.values() if isinstance(flaw, Flaw)]


CATALOGUE: Mapping[str, Flaw] = _listed()  # Every flaw by its code

_PLAIN = Flaw("", "doubt", "")


def flaw_of(notice: Notice) -> Flaw:
    """Return the flaw of a notice; an empty flaw where its code is not known."""
    return CATALOGUE.get(notice.code, _PLAIN)


def entry(flaw: Flaw, head: str = "##") -> str:
    """Return what `fric help CODE` and the page say of a flaw, as Markdown."""
    severity = flaw.severity if isinstance(flaw.severity, str) else "by its size"
    facts = [f"severity: {severity}"]
    facts += [f"widens {name} by {share:.0%}" for name, share in flaw.widens.items()]
    facts += ["a measured circle settles it"] * flaw.circle_settles
    facts += ["no observer is trusted with it"] * flaw.no_response
    facts += [f"threshold: {flaw.source}"] * bool(flaw.source)
    texts = [f"{head} {flaw.code}", _template(flaw.says), _template(flaw.mend), f"*{'; '.join(facts)}*"]
    return "\n\n".join(filter(None, texts)) + "\n"


def _template(text: str) -> str:
    """Return a sentence with its values as names: ``{size:2}`` is *size*, ``{rate:rises|falls}`` is rises/falls."""
    text = re.sub(r"{(\w+)(?::[^{}|]*)?}", r"*\1*", text)
    return re.sub(r"{\w+:([^{}|]*)\|([^{}]*)}", _choice, text)


def _choice(found: re.Match[str]) -> str:
    shown = [text for text in found.groups() if text]
    return "/".join(shown) if len(shown) > 1 else f"[{shown[0]}]"


def page() -> str:
    """Return the page of all flaws, as Markdown."""
    head = """# Warnings by their codes

Made from `fric.flaws` by `make docs`; `fric help CODE` shows one entry. A *note* is good to know; with a *doubt* a
number may be off by more than its interval; with *wrong* it is, until mended. Values are in italics. `load=` is an
argument, and `--load` the option of the command line. Each warning in `warnings_coded` has `code`, `severity`, `text`,
and where there are any `values`, `where` and `carried` (a file that was read said it first).
"""
    chapters = (
        "\n".join([f"\n## {(family.__doc__ or '').partition(chr(10))[0]}\n", *(entry(flaw, "###") for flaw in flaws)])
        for family in FAMILIES
        if (flaws := entries(family))
    )
    return head + "".join(chapters)
