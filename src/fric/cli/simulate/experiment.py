"""`fric simulate experiment`: an identification experiment on a virtual axis."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

import fric
from fric.cli.completion import axes
from fric.cli.console import finish
from fric.cli.options import Force, Implausible, Json, MachineFile


def experiment(
    machine: MachineFile,
    output: Annotated[Path, typer.Option("-o", "--output", metavar="LOG.h5", help="The log file to write.")],
    kind: Annotated[
        str | None,
        typer.Option(
            "--kind",
            metavar="KIND",
            help="constant-velocity, presliding-sine, sliding-sine, frequency-response, or all.",
        ),
    ] = None,
    plan: Annotated[
        Path | None, typer.Option("--plan", metavar="PLAN", help="The records of a plan: plan.yaml, or its folder.")
    ] = None,
    axis: Annotated[str, typer.Option("--axis", help="The axis that is moved.", autocompletion=axes)] = "x",
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
    frequency: Annotated[str | None, typer.Option("--frequency", help='Frequency of the sines, as "0.1 Hz".')] = None,
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
    implausible: Implausible = "error",
    json: Json = False,
) -> None:
    """Make an identification experiment on a virtual axis, logged as a real drive logs it."""
    given: dict[str, Any] = {"seed": seed, "samples": samples, "speeds": speeds, "amplitudes": amplitudes, "mean": mean}
    given |= {"frequency": frequency, "peaks": peaks, "encoder": encoder, "noise": noise}
    finish(
        lambda advance: fric.experiment(machine, kind, axis, plan=plan, advance=advance, **given),
        output, json=json, force=force, doing="experiments", writes="HDF5",
    )  # fmt: skip
