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
EFFECTS: Mapping[object, str] = {
    "note": "Good to know; no number is wrong by it.",
    "doubt": "A number may be off by more than its interval.",
    "wrong": "A number is off by more than its interval, until this is mended.",
}
"""What each severity means for the result."""
NAMED = {"level": "the level of friction", "k": "the stiffnesses"}  # Parameters without a symbol of their own


def _listed() -> Mapping[str, Flaw]:
    flaws = [flaw for family in FAMILIES for flaw in entries(family)]
    if len(found := {flaw.code: flaw for flaw in flaws}) < len(flaws):
        raise ValueError("two flaws have one code")
    return found


def entries(family: ModuleType) -> list[Flaw]:
    """Return the flaws of a family."""
    tables = [one if isinstance(one, Mapping) else {"": one} for name, one in vars(family).items() if name.isupper()]
    return [flaw for table in tables for flaw in table.values() if isinstance(flaw, Flaw)]


CATALOGUE: Mapping[str, Flaw] = _listed()  # Every flaw by its code


def flaw_of(notice: Notice) -> Flaw:
    """Return the flaw of a notice; an empty flaw where its code is not known."""
    return CATALOGUE.get(notice.code, Flaw("", "doubt", ""))


def entry(flaw: Flaw, head: str = "##") -> str:
    """Return what `fric help CODE` and the page say of a flaw, as Markdown: what was found, its effect, what to do."""
    effects = [EFFECTS.get(flaw.severity, "Severity depends on size: a note makes no number wrong, a doubt can.")]
    shares = [(name, f"[{by}]" if isinstance(by, str) else f"{by:.0%}") for name, by in flaw.widens.items()]
    errors = [f"{share} in {NAMED.get(name, name)}" for name, share in shares]
    effects += [f"Predictions allow for an error of {' and '.join(errors)}."] * bool(errors)
    effects += ["Varied machines that are fitted to a measured circle allow for it."] * flaw.circle_settles
    effects += ["No observer is trusted with it."] * flaw.no_response
    names = ", ".join(f"`{name}`" for name in dict.fromkeys(re.findall(r"{(\w+)", flaw.says + flaw.mend)))
    texts = [f"{head} {flaw.code}", _explained(flaw.says) or "The warning itself says what was found.",
             f"Effect: {' '.join(effects)}", f"To do: {mend}" if (mend := _explained(flaw.mend)) else "",
             f"[x] stands for the value of x; files hold {names}." * bool(names)]  # fmt: skip
    return "\n\n".join(filter(None, texts)) + "\n"


def _explained(text: str) -> str:
    """Return a sentence with the name of each value in brackets, as of ``{size:2}``; empty where it has no words."""
    text = re.sub(r"{(\w+)(?::[^{}|]*?(%)?)?}", lambda value: f"[{value[1]}]{' %' * bool(value[2])}", text)
    text = re.sub(r"{\w+:([^{}|]*)\|([^{}]*)}", _choice, text).strip()
    return text if re.search(r"[^\W\d]{2}", re.sub(r"\[\w+\]", "", text)) else ""


def _choice(found: re.Match[str]) -> str:
    """Return both ways of ``{rate:rises|falls}``; of what is said in some cases alone a sentence or an alternative."""
    first, *other = [text for text in found.groups() if text]
    if other and first[0] in ",:;[":
        return other[0] if re.fullmatch(r"\[\w+\]", first) else first
    if not other and not first.endswith("."):
        return first if first.startswith(", or ") else ""
    last = re.sub(r"^[A-Z](?=[a-z ])", lambda begin: begin[0].lower(), (other or [first])[0].strip())
    return f"{first} {'Or' if first.endswith('.') else 'or'} {last}" if other else f" In some cases, {last}"


def page() -> str:
    """Return the page of all flaws, as Markdown."""
    head = """# Warnings by their codes

Made from `fric.flaws` by `make docs`; `fric help CODE` shows one entry. In place of the brackets a warning has values.
`load=` is an argument, and `--load` the option of the command line. Each warning in `warnings_coded` has `code`,
`severity` (`note`, `doubt` or `wrong`), `text`, and where there are any `values`, `where` and `carried` (a file that
was read said it first).
"""
    chapters = (
        "\n".join([f"\n## {(family.__doc__ or '').partition(chr(10))[0]}\n", *(entry(flaw, "###") for flaw in flaws)])
        for family in FAMILIES
        if (flaws := entries(family))
    )
    return (head + "".join(chapters)).replace("] [", "] \\[")  # else Markdown takes both for a link
