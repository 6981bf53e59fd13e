"""Pages are rendered here: the templates of this folder, and what they need to tell numbers to people."""

from __future__ import annotations

from base64 import b64encode
from functools import cache

from jinja2 import Environment, PackageLoader, StrictUndefined

import fric
from fric.units import readable, significant


@cache
def environment() -> Environment:
    """Return the environment that every page of fric is rendered with.

    A page extends ``base.html.j2``. Text is escaped, a name that is not given is an error. Filters: ``readable``
    (``2.2e-5 | readable("m")`` is ``22 µm``), ``significant`` (digits of a number), ``micrometres`` (a length as a bare
    number of µm, one decimal), ``percent`` (of a relative difference), ``embedded``
    (bytes of a picture as a ``data:`` address).
    """
    made = Environment(
        loader=PackageLoader("fric.report"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    made.filters |= {
        "readable": readable,
        "significant": significant,
        "micrometres": micrometres,
        "embedded": embedded,
        "percent": percent,
    }
    made.globals["version"] = fric.__version__
    return made


def micrometres(length: float, *, sign: bool = False) -> str:
    """Return a length [m] in µm with one decimal: ``micrometres(-9.13e-6) == "−9.1"``."""
    told = f"{length * 1e6:{'+' if sign else ''}.1f}"
    return told.replace("-", "−")


def percent(share: float) -> str:
    """Return a relative difference in per cent with its sign: ``percent(-0.021) == "−2.1 %"``."""
    told = f"{100 * share:+.1f} %"
    return "0.0 %" if told in {"+0.0 %", "-0.0 %"} else told.replace("-", "−")


def embedded(picture: bytes, media: str = "image/svg+xml") -> str:
    """Return a picture as a ``data:`` address, so that the page needs no other file."""
    return f"data:{media};base64,{b64encode(picture).decode()}"
