"""`fric report`: one HTML page from runs, documents, logs and earlier reports."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

import fric
from fric.cli.console import finish
from fric.cli.options import Force, Json


def report(
    files: Annotated[
        list[Path],
        typer.Argument(
            metavar="FILE…",
            help="Runs, documents of friction, plant, controller and observer, logs to draw points from, or earlier "
            "reports: each is recognised by its content. Of two of one kind the earlier is compared with the later.",
        ),
    ],
    output: Annotated[Path, typer.Option("-o", "--output", metavar="REPORT.html", help="The page to write.")],
    title: Annotated[str, typer.Option("--title", help="Heading of the page.")] = "",
    json: Json = False,
    force: Force = False,
) -> None:
    """Make one self-contained HTML page: what was identified, what a circle shows, what to use, and what drifted."""
    finish(lambda _: fric.make_report(*files, title=title), output, json=json, force=force, doing="page")
