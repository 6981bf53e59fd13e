"""`fric identify plant`: eq. (1) from frequency responses, or from an ordinary motion."""

from pathlib import Path
from typing import Annotated, Literal

import fric
from fric.cli.console import finish
from fric.cli.options import Force, Implausible, Json, LogFiles, Plot, option


def plant(
    logs: LogFiles,
    output: Annotated[Path, option("Plant file to write.", "-o", "--output", metavar="PLANT.yaml")],
    method: Annotated[
        Literal["auto", "response", "motion"], option("From frequency responses, or from a motion.")
    ] = "auto",
    force_constant: Annotated[
        str | None, option('Force constant, as "548 N/V", where no force was logged.', metavar="K_F")
    ] = None,
    mass: Annotated[
        str | None, option('Moving mass where you know it, as "85 kg": K_f/B is held against it.', metavar="MASS")
    ] = None,
    coherence: Annotated[float, option("Least coherence of a frequency.", min=0, max=1)] = 0.5,
    lowest: Annotated[str | None, option('Lowest frequency, as "5 Hz".', metavar="FREQUENCY")] = None,
    highest: Annotated[str | None, option('Highest frequency, as "300 Hz".', metavar="FREQUENCY")] = None,
    period: Annotated[str | None, option("Period of the excitation; found if not given.", metavar="TIME")] = None,
    segment: Annotated[str | None, option("Length of Welch's segments, for no period.", metavar="TIME")] = None,
    hold: Annotated[
        str,
        option(
            'Rate of the hold before the plant, as "4 kHz"; auto: that of a record, none for a table.',
            metavar="RATE|auto|none",
        ),
    ] = "auto",
    direction: Annotated[
        Literal["both", "each"], option("One friction and an offset, or friction of each direction.")
    ] = "both",
    delay: Annotated[
        str | None,
        option(
            'T_d, which no motion shows, as "0.65 ms": the force acts so much later than it is logged.', metavar="TIME"
        ),
    ] = None,
    cutoff: Annotated[str | None, option("Corner of the zero-phase filter.", metavar="FREQUENCY")] = None,
    decimation: Annotated[int | None, option("One sample of so many is kept.", min=1)] = None,
    border: Annotated[int | None, option("Samples left out at the start.", min=0)] = None,
    plot: Plot = None,
    implausible: Implausible = "error",
    json: Json = False,
    force: Force = False,
) -> None:
    """Identify the plant A, B, T_d (eq. 1) and K_f, from frequency responses or from an ordinary motion."""
    finish(
        lambda _: fric.identify_plant(
            *logs, method=method, force_constant=force_constant, mass=mass, coherence=coherence, lowest=lowest,
            highest=highest, period=period, segment=segment, hold=hold, direction=direction, delay=delay, cutoff=cutoff,
            decimation=decimation, border=border,
        ),
        output, plot, json=json, force=force, doing="plant",
    )  # fmt: skip
