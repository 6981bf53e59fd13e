"""The group `fric simulate`: virtual experiments and the circular test."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import typer

import fric
from fric.cli.console import OUT, print_json, print_table, print_warnings, progress
from fric.cli.options import Force, Json, Plot
from fric.units import parse, readable

app = typer.Typer(name="simulate", help="Virtual experiments, and the circular test.", no_args_is_help=True)

MachineFile = Annotated[Path, typer.Argument(metavar="MACHINE.yaml", help="The machine, as in configs/.")]


@app.command()
def experiment(
    machine: MachineFile,
    output: Annotated[Path, typer.Option("-o", "--output", metavar="LOG.h5", help="The log file to write.")],
    kind: Annotated[
        str,
        typer.Option(
            "--kind",
            metavar="KIND",
            help="constant-velocity, presliding-sine, sliding-sine, frequency-response, or all.",
        ),
    ],
    axis: Annotated[str, typer.Option("--axis", help="The axis that is moved.")] = "x",
    seed: Annotated[int, typer.Option("--seed", min=0, help="Seed of all that is random.")] = 0,
    samples: Annotated[
        int | None, typer.Option("--samples", min=100, help="Samples that the drive's trace holds, for each record.")
    ] = None,
    speeds: Annotated[
        str | None, typer.Option("--speeds", help='Speeds, as "0.1 mm/s, 1 mm/s"; the paper\'s 17 where not given.')
    ] = None,
    amplitudes: Annotated[
        str | None, typer.Option("--amplitudes", help='Amplitudes of the pre-sliding sines, as "15 um, 450 um".')
    ] = None,
    encoder: Annotated[
        str | None, typer.Option("--encoder", help='Encoder step instead of the machine\'s; "0 um" for none.')
    ] = None,
    noise: Annotated[
        str | None, typer.Option("--noise", help='Force noise (rms) instead of the machine\'s; "0 N" for none.')
    ] = None,
    force: Force = False,
    json: Json = False,
) -> None:
    """Make an identification experiment on a virtual axis, logged as a real drive logs it."""
    fric.refuse_existing(output, force=force)
    subject = fric.read_machine(machine).axis(axis)
    if encoder is not None:
        subject = replace(subject, encoder=fric.Encoder(parse(encoder, "position", subject.motion)))
    if noise is not None:
        subject = replace(subject, force_noise=parse(noise, "force", subject.motion))
    settings: dict[str, Any] = {"samples": samples} if samples is not None else {}
    if speeds is not None:
        settings["speeds"] = [parse(text, "velocity", subject.motion) for text in speeds.split(",")]
    if amplitudes is not None:
        settings["amplitudes"] = [parse(text, "position", subject.motion) for text in amplitudes.split(",")]
    records = []
    with progress("experiments") as advance:
        for log in fric.experiment(subject, kind, seed=seed, **settings):
            records.append(replace(log, source=machine.name))
            advance()
    fric.write_logs(output, records, force=force)
    if json:
        print_json({"axis": axis, "records": {log.name: {"kind": log.kind, "samples": len(log)} for log in records}})
        return
    rows = [(log.name, str(log.kind), str(len(log)), readable(log.time[-1], "s")) for log in records]
    print_table(("record", "kind", "samples", "time"), rows)
    OUT.print(f"{output}: {len(records)} records of axis {axis}")


@app.command()
def circle(
    machine: MachineFile,
    scheme: Annotated[str, typer.Option("--scheme", help="A scheme's name, several as a,d,f, or all.")] = "all",
    velocity: Annotated[str, typer.Option("--velocity", help="Feed along the circle.")] = "100 mm/s",
    radius: Annotated[str, typer.Option("--radius", help="Radius of the circle.")] = "30 mm",
    revolutions: Annotated[int, typer.Option("--revolutions", help="Revolutions; the last is looked at.")] = 2,
    clockwise: Annotated[bool, typer.Option("--clockwise", help="Turn clockwise.")] = False,
    axis: Annotated[
        str | None, typer.Option("--axis", help="Simulate one axis alone; the other follows its reference exactly.")
    ] = None,
    friction: Annotated[
        list[str] | None,
        typer.Option("--friction", metavar="AXIS=FRICTION.yaml", help="Friction that the controller believes."),
    ] = None,
    gain: Annotated[
        float | None, typer.Option("--gain", help="Gain of the friction feedforward, instead of the machine's.")
    ] = None,
    schemes: Annotated[
        Path | None, typer.Option("--schemes", metavar="SCHEMES.yaml", help="Schemes of your own; else the paper's.")
    ] = None,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="RUN.h5", help="Keep traces and metrics in this file.")
    ] = None,
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
        fric.write_runs(output, runs, force=force)
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
    first = next(
        (other.circularity.glitch for other in runs if not (other.scheme.friction or other.scheme.observer)), None
    )
    microns = [*found.quadrants, found.glitch, found.rms, found.range]
    name = f"({run.scheme.name}) {run.scheme.title}"
    reduction = "" if first is None or found.glitch == first else f"{1 - found.glitch / first:.0%}"
    row = [name, *(f"{value * 1e6:.1f}" for value in microns), reduction]
    if published:
        row.append(f"{published[run.scheme.name] * 1e6:.0f}" if run.scheme.name in published else "")
    return row
