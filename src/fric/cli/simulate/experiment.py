"""`fric simulate experiment`: an identification experiment on a virtual axis."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import typer

import fric
from fric.cli.console import OUT, print_json, print_table, progress
from fric.cli.options import Force, Json, MachineFile
from fric.units import parse, readable


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
    mean: Annotated[
        str | None,
        typer.Option(
            "--mean", help='Mean speed of sliding-sine and frequency-response; of the latter "0 mm/s" is rest.'
        ),
    ] = None,
    peaks: Annotated[
        str | None,
        typer.Option("--peaks", help='Peak speeds of the multisine, a record each, as "5 mm/s, 15 mm/s"; else mean/2.'),
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
    if mean is not None:
        settings["mean"] = parse(mean, "velocity", subject.motion)
    if peaks is not None:
        settings["peaks"] = [parse(text, "velocity", subject.motion) for text in peaks.split(",")]
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
