"""What a page tells of measured circles: the diagnosis with predicted beside measured, and its picture."""

from collections.abc import Sequence
from dataclasses import dataclass

from fric.notice import Notice
from fric.report.plots import Drawn, pictures
from fric.report.report_input import Measured
from fric.results.text import Table
from fric.units import readable


@dataclass(frozen=True)
class MeasuredView:
    """What the page says of one measured circle."""

    title: str
    source: str
    scheme: str  # that is predicted; empty without a prediction
    agrees: bool | None  # whether all quadrants are as predicted; None without a prediction
    glitch: float  # the largest that was measured [m]
    tables: Sequence[Table]
    warnings: Sequence[Notice]
    picture: Drawn  # the figure of `fric diagnose`
    further: Sequence[Drawn]


def measured_view(measured: Measured, key: str) -> MeasuredView:
    """Return what is told of a measured circle; its figures are called by the key."""
    result = measured.result
    test, held = result.found.test, result.held
    alt = "The radial deviation as a polar plot, and over time at each reversal"
    alt += f"{', measured and predicted' if held else ''}; the numbers stand in the tables."
    caption = "Left the deviation of the radius around its centre, right the glitch over the time after each reversal"
    caption += f"{': measured whole, predicted dashed' if held else ''}."
    return MeasuredView(
        f"Circle of {readable(test.radius, 'm')} at {readable(test.feed, 'm/s')}", measured.source,
        held.scheme if held else "", held.all_agree if held else None,
        measured.glitch,
        [piece for piece in result.report() if isinstance(piece, Table)], result.warnings,
        Drawn(f"{key}-diagnosis", "", caption, alt, result.figure()), pictures(result.found, key),
    )  # fmt: skip


def gravest_first(warnings: Sequence[Notice]) -> list[Notice]:
    """Return warnings, the gravest first."""
    return sorted(warnings, key=lambda one: ("wrong", "doubt", "note").index(one.severity))
