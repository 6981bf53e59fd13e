"""`fric simulate experiment`: an identification experiment on a virtual axis."""

from pathlib import Path
from typing import Annotated

import fric
from fric.cli.completion import axes
from fric.cli.console import finish
from fric.cli.options import Force, Implausible, Json, MachineFile, option


def experiment(
    machine: MachineFile,
    output: Annotated[Path, option("The log file to write.", "-o", "--output", metavar="LOG.h5")],
    kind: Annotated[
        str | None,
        option("constant-velocity, presliding-sine, sliding-sine, frequency-response, or all.", metavar="KIND"),
    ] = None,
    plan: Annotated[Path | None, option("The records of a plan: plan.yaml, or its folder.", metavar="PLAN")] = None,
    axis: Annotated[str, option("The axis that is moved.", autocompletion=axes)] = "x",
    seed: Annotated[int, option("Seed of all that is random.", min=0)] = 0,
    samples: Annotated[int | None, option("Samples that the drive's trace holds, for each record.", min=100)] = None,
    speeds: Annotated[str | None, option('Speeds, as "0.1 mm/s, 1 mm/s"; the paper\'s 17 where not given.')] = None,
    amplitudes: Annotated[str | None, option('Amplitudes of the pre-sliding sines, as "15 um, 450 um".')] = None,
    frequency: Annotated[str | None, option('Frequency of the sines, as "0.1 Hz".')] = None,
    mean: Annotated[
        str | None,
        option('Mean speed of sliding-sine and frequency-response; of the latter "0 mm/s" is rest.'),
    ] = None,
    peaks: Annotated[
        str | None, option('Peak speeds of the multisine, a record each, as "5 mm/s, 15 mm/s"; else mean/2.')
    ] = None,
    encoder: Annotated[str | None, option('Encoder step instead of the machine\'s; "0 um" for none.')] = None,
    noise: Annotated[str | None, option('Force noise (rms) instead of the machine\'s; "0 N" for none.')] = None,
    force: Force = False,
    implausible: Implausible = "error",
    json: Json = False,
) -> None:
    """Make an identification experiment on a virtual axis, logged as a real drive logs it."""
    finish(
        lambda advance: fric.experiment(
            machine, kind, axis, plan=plan, seed=seed, samples=samples, speeds=speeds, amplitudes=amplitudes,
            frequency=frequency, mean=mean, peaks=peaks, encoder=encoder, noise=noise, advance=advance,
        ),
        output, json=json, force=force, doing="experiments", writes="HDF5",
    )  # fmt: skip
