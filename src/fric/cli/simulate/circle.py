"""`fric simulate circle`: the circular test under compensation schemes."""

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
from fric.cli.simulate import monte_carlo as many
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
    lead: Lead = None,
    friction_model: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="Model that the machine has, of those in its file; else the richest."),
    ] = None,
    schemes: SchemesFile = None,
    monte_carlo: many.Machines = None,
    spread: many.SpreadFile = None,
    from_intervals: many.FromIntervals = False,
    seed: many.Seed = 0,
    accuracy: many.Accuracy = "0.005 um",
    workers: many.Workers = None,
    scheduler: many.Scheduler = None,
    output: RunFile = None,
    plot: Plot = None,
    plot_reversal: Annotated[
        Path | None,
        typer.Option("--plot-reversal", metavar="FIG", help="Draw error and voltages over time near a reversal."),
    ] = None,
    force: Force = False,
    json: Json = False,
) -> None:
    """Run a circular test under compensation schemes: the quadrant glitches that each leaves.

    With --monte-carlo the test runs on many machines: how the glitch of each scheme is distributed over them, and how
    often each scheme is the best. Ctrl-C keeps the machines that are done.
    """
    fric.refuse_existing(output, plot, plot_reversal, force=force)
    if monte_carlo is None and (spread or from_intervals or workers or scheduler):
        raise typer.BadParameter("--spread, --from-intervals, --workers and --scheduler go with --monte-carlo")
    given: dict[str, Any] = {"believed": friction or (), "gain": gain, "lead": lead_given(lead)}
    identified = fric.read_identified(machine, **given) if from_intervals else None
    if friction_model and from_intervals:
        raise typer.BadParameter("--friction-model does not go with --from-intervals")
    subject = identified.machine if identified else fric.read_machine(machine, **given, friction_model=friction_model)
    spreads = fric.read_spreads(spread) if spread else None
    test = fric.Circle(parse(radius, "position"), parse(velocity, "velocity"), revolutions, -1 if clockwise else 1)
    chosen = fric.choose_schemes(scheme, fric.read_schemes(schemes) if schemes else None)
    runs = []
    with progress("schemes", total=len(chosen)) as advance:
        for wanted in chosen:
            runs.append(fric.run_circle(subject, wanted, test, only=axis))
            advance()
    found = None
    if monte_carlo is not None:
        study = fric.Study(
            subject,
            tuple(chosen),
            test,
            seed,
            **({} if spreads is None else {"spreads": spreads}),
            intervals=identified.intervals if identified else {},
            covariances=identified.covariances if identified else {},
            only=axis,
            accuracy=parse(accuracy, "position"),
        )
        found = many.run_study(study, monte_carlo, workers, scheduler)
    if output is not None:
        made = fric.provenance() | {"machine": subject.name}
        fric.write_runs(output, runs, js.dumps(made), many=found, force=force)
    if plot is not None:
        nominal = {run.scheme.name: run.circularity.glitch for run in runs}
        figure = fric.polar_figure(runs) if found is None else fric.monte_carlo_figure(found, nominal)
        fric.save_figure(figure, plot, force=force)
    if plot_reversal is not None:
        fric.save_figure(fric.reversal_figure(runs), plot_reversal, force=force)
    if identified:
        print_warnings(identified.warnings)
    print_warnings(dict.fromkeys(f"scheme {run.scheme.name}: {warning}" for run in runs for warning in run.warnings))
    print_warnings(found.warnings() if found else ())
    if json:
        told = fric.circle_document(runs)
        print_json(told | ({"monte_carlo": fric.monte_carlo_document(found)} if found else {}))
        return _end(found)
    published = None if axis else subject.published_glitches(test.radius, test.feed)
    where = f"{readable(test.radius, 'm')} at {readable(test.feed, 'm/s')}"
    where += ", clockwise" if clockwise else ""
    where += f", {axis} alone; glitches in µm" if axis else "; glitches in µm"
    if found:
        title = f"{subject.name}: {len(found)} machines, {where}"
        many.print_distributions(found, runs, published, title, intervals=from_intervals)
        return _end(found)
    print_circle(runs, published, f"{subject.name}: {where}")
    return None


def print_circle(runs: list[Any], published: Any, title: str) -> None:
    """Print what each scheme leaves in the quadrants, and what was published where something was."""
    quadrants = ("+x", "+y", "-x", "-y")
    columns = ["scheme", *quadrants, "glitch", "rms", "range", "reduction", *(["paper"] if published else [])]
    print_table(columns, [_row(run, runs, published) for run in runs], title)


def _end(found: Any) -> None:
    """End with status 1 where a study was cut short."""
    if found is not None and len(found) < found.asked:
        raise typer.Exit(1)


def _row(run: Any, runs: list[Any], published: Any) -> list[str]:
    found = run.circularity
    microns = [*found.quadrants, found.glitch, found.rms, found.range]
    reduction = fric.reduction(run, runs)
    row = [f"({run.scheme.name}) {run.scheme.title}", *(f"{value * 1e6:.1f}" for value in microns)]
    row.append("" if reduction is None else f"{reduction:.0%}")
    if published:
        row.append(f"{published[run.scheme.name] * 1e6:.0f}" if run.scheme.name in published else "")
    return row
