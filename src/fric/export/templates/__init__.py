"""Files of controllers as templates, and what fills them."""

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
