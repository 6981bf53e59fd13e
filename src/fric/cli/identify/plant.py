"""`fric identify plant`: eq. (1) from frequency responses, or from an ordinary motion."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

import typer

import fric
from fric.cli.console import finish
from fric.cli.options import Force, Implausible, Json, LogFiles, Plot

RESPONSE, MOTION = "Frequency responses", "Motion"


def plant(
    logs: LogFiles,
    output: Annotated[Path, typer.Option("-o", "--output", metavar="PLANT.yaml", help="Plant file to write.")],
    method: Annotated[
        Literal["auto", "response", "motion"], typer.Option(help="From frequency responses, or from a motion.")
    ] = "auto",
    force_constant: Annotated[
        str | None, typer.Option(metavar="K_F", help='Force constant, as "548 N/V", where no force was logged.')
    ] = None,
    mass: Annotated[
        str | None,
        typer.Option(metavar="MASS", help='Moving mass where you know it, as "85 kg": K_f/B is held against it.'),
    ] = None,
    coherence: Annotated[
        float, typer.Option(min=0, max=1, help="Least coherence of a frequency.", rich_help_panel=RESPONSE)
    ] = 0.5,
    lowest: Annotated[
        str | None, typer.Option(metavar="FREQUENCY", help='Lowest frequency, as "5 Hz".', rich_help_panel=RESPONSE)
    ] = None,
    highest: Annotated[
        str | None, typer.Option(metavar="FREQUENCY", help='Highest frequency, as "300 Hz".', rich_help_panel=RESPONSE)
    ] = None,
    period: Annotated[
        str | None,
        typer.Option(metavar="TIME", help="Period of the excitation; found if not given.", rich_help_panel=RESPONSE),
    ] = None,
    segment: Annotated[
        str | None,
        typer.Option(metavar="TIME", help="Length of Welch's segments, for no period.", rich_help_panel=RESPONSE),
    ] = None,
    hold: Annotated[
        str,
        typer.Option(
            metavar="RATE|auto|none",
            help='Rate of the hold before the plant, as "4 kHz"; auto: that of a record, none for a table.',
            rich_help_panel=RESPONSE,
        ),
    ] = "auto",
    direction: Annotated[
        Literal["both", "each"],
        typer.Option(help="One friction and an offset, or friction of each direction.", rich_help_panel=MOTION),
    ] = "both",
    delay: Annotated[
        str | None,
        typer.Option(
            metavar="TIME",
            help='T_d, which no motion shows, as "0.65 ms": the force acts so much later than it is logged.',
            rich_help_panel=MOTION,
        ),
    ] = None,
    cutoff: Annotated[
        str | None,
        typer.Option(metavar="FREQUENCY", help="Corner of the zero-phase filter.", rich_help_panel=MOTION),
    ] = None,
    decimation: Annotated[
        int | None, typer.Option(min=1, help="One sample of so many is kept.", rich_help_panel=MOTION)
    ] = None,
    border: Annotated[
        int | None, typer.Option(min=0, help="Samples left out at the start.", rich_help_panel=MOTION)
    ] = None,
    plot: Plot = None,
    implausible: Implausible = "error",
    json: Json = False,
    force: Force = False,
) -> None:
    """Identify the plant A, B, T_d (eq. 1) and K_f, from frequency responses or from an ordinary motion."""
    given: dict[str, Any] = {
        "coherence": coherence,
        "lowest": lowest,
        "highest": highest,
        "period": period,
        "segment": segment,
    }
    given |= {"hold": hold, "direction": direction, "delay": delay, "cutoff": cutoff, "decimation": decimation}
    finish(
        lambda _: fric.identify_plant(
            *logs, method=method, force_constant=force_constant, border=border, mass=mass, **given
        ),
        output, plot, json=json, force=force, doing="plant",
    )  # fmt: skip
