"""Files of a target from templates."""

import textwrap
from functools import cache
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined

import fric


@cache
def _environment() -> Environment:
    made = Environment(
        loader=PackageLoader("fric.export"), undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True,
        keep_trailing_newline=True, autoescape=False,
    )  # fmt: skip
    made.filters["wrapped"] = wrapped
    return made


def render(template: str, **values: Any) -> str:
    """Return a template of this package, filled."""
    return _environment().get_template(template).render(version=fric.__version__, **values)


def wrapped(items: list[str], indent: int = 4, width: int = 110) -> str:
    """Return texts separated by commas, in lines of bounded length."""
    margin = " " * indent
    return textwrap.fill(", ".join(items), width, initial_indent=margin, subsequent_indent=margin).strip()


def remark(text: str) -> str:
    """Return a text as a comment of any language, without characters that could end the comment or a line."""
    return " ".join("".join(c if c.isascii() and (c.isalnum() or c in "_.,:+-=<>") else " " for c in text).split())


def identifier(text: str) -> str:
    """Return a text as an identifier of any language: letters, digits and single underscores."""
    made = "".join(c.lower() if c.isascii() and c.isalnum() else "_" for c in text).strip("_")
    while "__" in made:
        made = made.replace("__", "_")
    return made or "axis"
