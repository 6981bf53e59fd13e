"""`fric report`: one HTML page from runs, documents, logs and earlier reports."""

from pathlib import Path
from typing import Annotated, Any

import fric
from fric.cli.console import finish
from fric.cli.options import Force, Json, argument, option


def report(
    files: Annotated[
        list[Path],
        argument(
            "Runs, measured circles, the machine (file, or bundled name) to hold them against, documents of "
            "friction, plant, controller and observer, logs to draw points from, or earlier reports: each is "
            "recognised by its content. Of two of one kind the earlier is compared with the later.",
            metavar="FILE…",
        ),
    ],
    output: Annotated[Path, option("The page to write.", "-o", "--output", metavar="REPORT.html")],
    title: Annotated[str, option("Heading of the page.")] = "",
    circle: Annotated[
        list[Path] | None,
        option("A measured circle, or a run that stands for one; repeatable.", metavar="CIRCLE.h5"),
    ] = None,
    tolerance: Annotated[
        str | None, option('Glitch that is allowed, as "5 um": pass or not.', metavar="LENGTH")
    ] = None,
    json: Json = False,
    force: Force = False,
) -> None:
    """Make one self-contained HTML page: what to use, what a circle shows, what was identified, and what drifted.

    Where the controllers of a run know exactly what is true of its machine, machines are drawn around it first. A
    measured circle that is not as predicted is told, and no scheme is recommended until that is explained.
    """
    given: dict[str, Any] = {"circles": circle or (), "title": title, "tolerance": tolerance}
    finish(
        lambda advance: fric.make_report(*files, **given, advance=advance),
        output, json=json, force=force, doing="machines", writes="HTML",
    )  # fmt: skip
