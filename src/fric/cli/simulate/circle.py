"""`fric simulate circle`: the circular test under compensation schemes."""

from __future__ import annotations

import json as js
from typing import Annotated, Any

import typer

import fric
from fric.cli.console import print_json, print_table, print_warnings, progress
from fric.cli.options import BelievedFriction, Force, Gain, Json, MachineFile, Plot, RunFile, SchemeNames, SchemesFile
from fric.units import parse, readable


def circle(
    machine: MachineFile,
    scheme: SchemeNames = "all",
    velocity: Annotated[str, typer.Option("--velocity", help="Feed along the circle.")] = "100 mm/s",
    radius: Annotated[str, typer.Option("--radius", help="Radius of the circle.")] = "30 mm",
    revolutions: Annotated[int, typer.Option("--revolutions", help="Revolutions; the last is looked at.")] = 2,
    clockwise: Annotated[bool, typer.Option("--clockwise", help="Turn clockwise.")] = False,
    axis: Annotated[
        str | None, typer.Option("--axis", help="Simulate one axis alone; the other follows its reference exactly.")
    ] = None,
    friction: BelievedFriction = None,
    gain: Gain = None,
    schemes: SchemesFile = None,
    output: RunFile = None,
    plot: Plot = None,
    force: Force = False,
    json: Json = False,
) -> None:
    """Run a circular test under compensation schemes: the quadrant glitches that each leaves."""
    fric.refuse_existing(output, plot, force=force)
    subject = fric.read_machine(machine, believed=friction or (), gain=gain)
    test = fric.Circle(parse(radius, "position"), parse(velocity, "velocity"), revolutions, -1 if clockwise else 1)
    chosen = fric.choose_schemes(scheme, fric.read_schemes(schemes) if schemes else None)
    runs = []
    with progress("schemes", total=len(chosen)) as advance:
        for wanted in chosen:
            runs.append(fric.run_circle(subject, wanted, test, only=axis))
            advance()
    if output is not None:
        fric.write_runs(output, runs, js.dumps(fric.provenance()), force=force)
    if plot is not None:
        fric.save_figure(fric.polar_figure(runs), plot, force=force)
    print_warnings(dict.fromkeys(f"scheme {run.scheme.name}: {warning}" for run in runs for warning in run.warnings))
    if json:
        print_json(fric.circle_document(runs))
        return
    published = subject.published_glitches(test.radius, test.feed)
    quadrants = ("+x", "+y", "-x", "-y")
    columns = ["scheme", *quadrants, "glitch", "rms", "range", "reduction", *(["paper"] if published else [])]
    title = f"{subject.name}: {readable(test.radius, 'm')} at {readable(test.feed, 'm/s')}; glitches in µm"
    print_table(columns, [_row(run, runs, published) for run in runs], title)


def _row(run: Any, runs: list[Any], published: Any) -> list[str]:
    found = run.circularity
    microns = [*found.quadrants, found.glitch, found.rms, found.range]
    reduction = fric.reduction(run, runs)
    row = [f"({run.scheme.name}) {run.scheme.title}", *(f"{value * 1e6:.1f}" for value in microns)]
    row.append("" if reduction is None else f"{reduction:.0%}")
    if published:
        row.append(f"{published[run.scheme.name] * 1e6:.0f}" if run.scheme.name in published else "")
    return row
