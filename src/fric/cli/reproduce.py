"""`fric reproduce`: the paper from end to end."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

import fric
from fric.cli.console import OUT, print_json, progress
from fric.cli.options import Json
from fric.cli.simulate.circle import print_circle
from fric.units import readable


def reproduce(
    output: Annotated[
        Path, typer.Option("-o", "--output", metavar="DIR", help="Folder for logs, YAML, runs, figures and the page.")
    ] = Path("reproduction"),
    machine: Annotated[
        Path | None, typer.Option("--machine", metavar="MACHINE.yaml", help="A machine of your own; else the paper's.")
    ] = None,
    seed: Annotated[int, typer.Option("--seed", min=0, help="Seed of all noise.")] = 1,
    json: Json = False,
) -> None:
    """Run the paper from end to end: experiments, identification, design, six schemes, and a page beside the paper.

    Steps whose inputs have not changed are not run again.
    """
    given = machine or fric.paper_machine()
    with progress("reproduce", total=fric.reproduction_steps()) as advance:
        done = fric.reproduce_paper(given, output, seed=seed, advance=lambda *_: advance())
    if json:
        feeds = {f"{feed:g}": fric.circle_document(runs) for feed, runs in done.runs.items()}
        print_json({"page": str(done.page), "steps": done.steps, "made": done.made, "feeds": feeds})
        return
    subject = fric.read_machine(given)
    for feed, runs in done.runs.items():
        radius = runs[0].circle.radius
        title = f"{subject.name}: {readable(radius, 'm')} at {readable(feed, 'm/s')}; glitches in µm"
        print_circle(runs, subject.published_glitches(radius, feed), title)
    OUT.print(f"{done.made} of {done.steps} steps were run, the rest was up to date")
    OUT.print(f"{done.page}")
