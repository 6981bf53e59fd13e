"""A figure as a part of a page: SVG that the page's script zooms, reads and switches; no two figures share an id."""

import io
import json
import re
from html import escape
from typing import Any

import matplotlib as mpl
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.legend import Legend
from matplotlib.projections.polar import PolarAxes

from fric.figures.style import DRAWING, STYLE, laid_out

STROKE = 1.4  # Pixels for a point of a line's width, for every size and zoom of a figure on the page
_NOTHING = dict.fromkeys(("Creator", "Date", "Format", "Type"))
_LINES = re.compile(r"(stroke-width|stroke-dasharray|stroke-dashoffset): ([^;\"]+)")


def embedded(figure: Figure, key: str, alt: str) -> str:
    """Return a figure as an element of a page, the same text each time.

    Text stays text. An artist's ``gid`` that has a colon becomes ``data-name``, for the page's script; other ids are
    those of the drawing, made unique by the key, or left out. ``data-panels`` holds for each panel its frame in the
    drawing, its labels, and its limits, from which the script reads the numbers under the pointer. Curves and their
    entries in a legend get the same number in ``curve:N`` and ``legend:N``, unless they have a name.

    key: What its ids begin with; no other figure of the page has it.
    alt: What it shows, for those who do not see it.
    """
    _name_curves(figure)
    named = any(
        ":" in str(artist.get_gid()) and "curve:" not in str(artist.get_gid()) for artist in figure.findobj(Artist)
    )
    out = io.StringIO()
    # what the script magnifies must have all its points; else points that lie within a fiftieth of one go
    rules = STYLE | {"svg.fonttype": "none", "path.simplify": not named, "path.simplify_threshold": 0.02}
    with mpl.rc_context(rules), laid_out(figure, DRAWING):
        figure.savefig(out, format="svg", metadata=_NOTHING)
    width, height = (72 * float(inches) for inches in figure.get_size_inches())
    text = out.getvalue()
    text = text[text.index("<svg") :]
    text = text[text.index(">") + 1 :]
    text = re.sub(r"\s*<(metadata|defs)>\s*(<style|<rdf:RDF).*?</\1>", "", text, count=2, flags=re.DOTALL)
    text = re.sub(r"<!--.*?-->", "", text, flags=re.DOTALL)
    used = set(re.findall(r"(?:url\(|href=\")#([^\")]+)", text))

    def tag(found: re.Match[str]) -> str:
        one = _LINES.sub(lambda line: f"{line[1]}: {_wider(line[2])}", found[0])
        one = re.sub(r"-?\d+\.\d{3,}(?!\d*e)", lambda number: f"{float(number[0]):.2f}".rstrip("0").rstrip("."), one)
        one = re.sub(r"font-family: 'DejaVu Sans', [^;\"]+;? ?", "", one)  # the page shows it once
        one = re.sub(r'\sid="([^"]*)"', lambda name: _named(name[1], key, used), one)
        one = one.replace("url(#", f"url(#{key}-").replace("xlink:href=", "href=").replace('href="#', f'href="#{key}-')
        return re.sub(r"\s+", " ", one)

    text = re.sub(r"<[^>]+>", tag, text)
    text = re.sub(r">\s*\n\s*<", "><", text)
    panels = escape(json.dumps([_panel(figure, axes, width, height) for axes in figure.axes], separators=(",", ":")))
    return (
        f'<svg class="plot" role="img" tabindex="0" aria-label="{escape(alt)}" data-panels="{panels}" '
        f'viewBox="0 0 {width:g} {height:g}" style="max-width: {1.25 * width:.0f}pt">{text}'
    )


def _wider(lengths: str) -> str:
    """Return widths of lines, or lengths of dashes, as the page draws them."""
    return ",".join(f"{STROKE * float(text):.2f}" for text in lengths.split(","))


def _named(name: str, key: str, used: set[str]) -> str:
    return f' data-name="{name}"' if ":" in name else f' id="{key}-{name}"' if name in used else ""


def _name_curves(figure: Figure) -> None:
    """Give curves and their entries in legends a common number."""
    legends = [legend for legend in figure.findobj(Legend) if isinstance(legend, Legend)]
    shown = {text.get_text() for legend in legends for text in legend.get_texts()}
    numbers = {label: n for n, label in enumerate(sorted(shown))}
    named: dict[str, list[Artist]] = {}
    for axes in figure.axes:
        for container in axes.containers:
            named.setdefault(str(container.get_label()), []).extend(_leaves(container))
        for artist in axes.get_children():
            named.setdefault(str(artist.get_label()), []).append(artist)
    for legend in legends:
        for handle, text in zip(legend.legend_handles, legend.get_texts(), strict=True):
            drawn = named.get(text.get_text(), [])
            if drawn and not any(
                artist.get_gid() for artist in drawn if not str(artist.get_gid()).startswith("curve:")
            ):
                for artist in drawn:
                    artist.set_gid(f"curve:{numbers[text.get_text()]}")
                for part in (handle, text):
                    if part is not None:
                        part.set_gid(f"legend:{numbers[text.get_text()]}")


def _leaves(container: Any) -> list[Artist]:
    return [
        item for part in container for item in (part if isinstance(part, tuple | list) else [part]) if item is not None
    ]


def _panel(figure: Figure, axes: Axes, width: float, height: float) -> dict[str, Any]:
    """Return the frame of a panel in the drawing, and its scales."""

    def place(x: float, y: float) -> list[float]:
        across, up = figure.transFigure.inverted().transform(axes.transData.transform((x, y)))
        return [round(float(across) * width, 3), round(float((1 - up) * height), 3)]

    if isinstance(axes, PolarAxes):
        low, high = axes.get_ylim()
        centre, rim = place(0.0, low), place(0.0, high)
        return {"centre": centre, "rim": round(rim[0] - centre[0], 3), "r": [low, high]}
    box = axes.get_position()
    return {
        "frame": [round(v, 3) for v in (box.x0 * width, (1 - box.y1) * height, box.x1 * width, (1 - box.y0) * height)],
        "x": [*axes.get_xlim(), axes.get_xscale(), axes.get_xlabel()],
        "y": [*axes.get_ylim(), axes.get_yscale(), axes.get_ylabel()],
    }
