"""`fric simulate path`: any smooth contour under compensation schemes."""

from __future__ import annotations

import json as js
from pathlib import Path
from typing import Annotated, Any

import typer

import fric
from fric.cli.console import print_json, print_table, print_warnings, progress
from fric.cli.options import (
    BelievedFriction,
    Force,
    Gain,
    Json,
    Lead,
    MachineFile,
    Plot,
    RunFile,
    SchemeNames,
    SchemesFile,
    lead_given,
)
from fric.units import parse, readable


def path(
    machine: MachineFile,
    points: Annotated[Path, typer.Argument(metavar="PATH.csv", help="Points of the path, headed 'x [mm], y [mm]'.")],
    scheme: SchemeNames = "all",
    velocity: Annotated[str, typer.Option("--velocity", help="Feed along the path.")] = "100 mm/s",
    friction: BelievedFriction = None,
    gain: Gain = None,
    lead: Lead = None,
    schemes: SchemesFile = None,
    output: RunFile = None,
    plot: Plot = None,
    force: Force = False,
    json: Json = False,
) -> None:
    """Follow a contour given by points under compensation schemes: the glitch at each reversal of an axis."""
    fric.refuse_existing(output, plot, force=force)
    subject = fric.read_machine(machine, believed=friction or (), gain=gain, lead=lead_given(lead))
    followed = fric.read_path(points, parse(velocity, "velocity"))
    chosen = fric.choose_schemes(scheme, fric.read_schemes(schemes) if schemes else None)
    runs = []
    with progress("schemes", total=len(chosen)) as advance:
        for wanted in chosen:
            runs.append(fric.run_path(subject, wanted, followed))
            advance()
    if output is not None:
        fric.write_runs(output, runs, js.dumps(fric.provenance() | {"machine": subject.name}), force=force)
    if plot is not None:
        fric.save_figure(fric.path_figure(runs), plot, force=force)
    print_warnings(dict.fromkeys(f"scheme {run.scheme.name}: {warning}" for run in runs for warning in run.warnings))
    if json:
        print_json(fric.path_document(runs))
        return
    title = f"{subject.name}: {points.name} at {readable(followed.feed, 'm/s')}; contour error in µm"
    print_table(["scheme", "glitch", "rms", "range", "reduction"], [_row(run, runs) for run in runs], title)
    worst = max(runs, key=lambda run: run.contour.glitch)
    names = tuple(worst.traces)
    rows = [
        [f"{names[turn.axis]} turns at {turn.x * 1e3:z.1f}, {turn.y * 1e3:z.1f} mm"]
        + [f"{run.contour.reversals[n].glitch * 1e6:.1f}" for run in runs]
        for n, turn in enumerate(worst.contour.reversals)
    ]
    if rows:
        print_table(["reversal", *(f"({run.scheme.name})" for run in runs)], rows, "glitch at each reversal in µm")


def _row(run: Any, runs: list[Any]) -> list[str]:
    microns = [run.contour.glitch, run.contour.rms, run.contour.range]
    reduction = fric.reduction(run, runs)
    row = [f"({run.scheme.name}) {run.scheme.title}", *(f"{value * 1e6:.1f}" for value in microns)]
    return [*row, "" if reduction is None else f"{reduction:.0%}"]
