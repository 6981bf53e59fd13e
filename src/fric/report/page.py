"""Rendering of pages: the templates of this folder, and filters that format numbers for people."""

import re
from base64 import b64encode
from collections.abc import Mapping
from functools import cache
from math import isfinite
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

import fric
from fric.errors import as_options, clean
from fric.io.recognise import REPORT_MARK
from fric.report.collect import ReportInput, as_data
from fric.report.view import view
from fric.units import readable


@cache
def environment() -> Environment:
    """Return the environment that every page of fric is rendered with.

    A page extends ``base.html.j2``. Text is escaped, a name that is not given is an error. Filters: ``readable``
    (``2.2e-5 | readable("m")`` is ``22 µm``), ``micrometres`` (a length as a bare
    number of µm, one decimal), ``percent`` (of a relative difference), ``embedded``
    (bytes of a picture as a ``data:`` address).
    """
    made = Environment(
        loader=PackageLoader("fric.report"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        finalize=_shown,
    )
    made.filters |= {
        "readable": readable,
        "micrometres": micrometres,
        "embedded": embedded,
        "percent": percent,
        "limit": limit,
        "minus": minus,
    }
    made.policies["json.dumps_kwargs"] = {"separators": (",", ":")}
    made.globals["version"] = fric.__version__
    return made


def _shown(value: Any) -> Any:
    if isinstance(value, Markup):
        return Markup(clean(value))
    return clean(as_options(value)) if isinstance(value, str) else value


def micrometres(length: float, *, sign: bool = False) -> str:
    """Return a length [m] in µm with one decimal: ``micrometres(-9.13e-6) == "−9.1"``."""
    return minus(f"{length * 1e6:{'+' if sign else ''}.1f}")


def percent(share: float) -> str:
    """Return a relative difference in per cent with its sign: ``percent(-0.021) == "−2.1 %"``."""
    text = f"{100 * share:+.1f} %"
    return "0.0 %" if text in {"+0.0 %", "-0.0 %"} else minus(text)


def limit(value: float, unit: str) -> str:
    """Return a limit of an interval for people; an infinite limit is open."""
    return minus(readable(value, unit)) if isfinite(value) else "open"


def minus(text: str) -> str:
    """Return a text with minus signs for the hyphens before numbers and quadrants."""
    return re.sub(r"(?<!\S)-(?=[\dxy])", "−", text)


def embedded(picture: bytes, media: str = "image/svg+xml") -> str:
    """Return a picture as a ``data:`` address, so that the page needs no other file."""
    return f"data:{media};base64,{b64encode(picture).decode()}"


def render_report(inputs: ReportInput, title: str = "") -> str:
    """Return the report of what was collected as one HTML page that needs nothing else."""
    return render_view(view(inputs), inputs, title or _title(inputs))


def render_view(
    seen: Mapping[str, Any], inputs: ReportInput, title: str, template: str = "report.html.j2", **more: Any
) -> str:
    """Return a page by the report's template, or by a template that extends it with more data."""
    return (
        environment()
        .get_template(template)
        .render(view=seen, maps=inputs.maps, title=title, data=as_data(inputs), mark=Markup(REPORT_MARK), **more)
    )


def _title(inputs: ReportInput) -> str:
    machines = dict.fromkeys(str(test.provenance.get("machine", "")) for test in inputs.tests)
    names = [name for name in machines if name]
    axes = inputs.axes()
    parts = names + ([f"axis {axes[0]}" if len(axes) == 1 else f"axes {', '.join(axes)}"] if axes else [])
    return "Friction report: " + "; ".join(parts or ["contours"])
