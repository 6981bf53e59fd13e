"""`fric design observer`: a disturbance observer as fast as the unmodelled dynamics and the whole loop allow."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

import typer

import fric
from fric.cli.completion import records
from fric.cli.console import finish
from fric.cli.options import Force, Implausible, Json, PlantArgument, Plot

Filter = Literal["binomial2", "binomial3", "binomial4", "butterworth2", "butterworth3", "umeno-hori"]


def observer(
    plant: PlantArgument,
    log: Annotated[
        Path | None,
        typer.Argument(
            metavar="[LOG.h5]",
            help="A frequency response, or a record to take it from; without it Q is held below --first-mode.",
        ),
    ] = None,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="OBSERVER.yaml", help="The observer file to write.")
    ] = None,
    filter_name: Annotated[Filter, typer.Option("--filter", help="The shape of Q.")] = "binomial2",
    controller: Annotated[
        Path | None,
        typer.Option(metavar="CONTROLLER.yaml", help="The controller; by `fric design controller` where not given."),
    ] = None,
    cutoff: Annotated[
        str | None,
        typer.Option(metavar="FREQUENCY", help="Of Q, 1/(2πτ), where it is given; the largest allowed where not."),
    ] = None,
    bandwidth: Annotated[
        str | None, typer.Option(metavar="FREQUENCY", help="Of Q, −3 dB, where that is given instead of the cutoff.")
    ] = None,
    peak_sensitivity: Annotated[
        str, typer.Option(metavar="GAIN", help="Ms that the whole loop may have at most.")
    ] = "6 dB",
    resonances: Annotated[
        list[str] | None,
        typer.Option(
            "--resonance",
            metavar="FREQUENCY,DAMPING[,SHARE]",
            help="A mode that the plant does not have, as in '280 Hz, 0.02, 0.1'; can be given more than once.",
        ),
    ] = None,
    first_mode: Annotated[
        str | None,
        typer.Option(
            metavar="FREQUENCY", help="The lowest structural mode, as '80 Hz', where no response was measured."
        ),
    ] = None,
    record: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="The record of LOG.h5 that holds it.", autocompletion=records),
    ] = None,
    averages: Annotated[
        int, typer.Option(min=1, help="Records that a table's coherence was averaged over, for its confidence.")
    ] = 1,
    plot: Plot = None,
    view: Annotated[
        Literal["q", "bode", "nyquist", "nichols"], typer.Option(help="The figure that --plot draws; q is Fig. 7.")
    ] = "q",
    implausible: Implausible = "error",
    as_json: Json = False,
    force: Force = False,
) -> None:
    """Design the disturbance observer of an axis: how far its filter Q may reach.

    Two limits are told: |T·Delta| ≤ 1 at every frequency (eq. (8)), with the confidence of the response, and the
    peak sensitivity of the whole loop. The smaller is taken. Without a measured response no bandwidth is recommended: Q
    is held below the first mode, as --first-mode says or as it is assumed.
    """
    given: dict[str, Any] = {"filter": filter_name, "controller": controller, "cutoff": cutoff, "bandwidth": bandwidth}
    given |= {"peak_sensitivity": peak_sensitivity, "record": record, "averages": averages, "view": view}
    given["first_mode"] = first_mode
    finish(
        lambda _: fric.design_observer(plant, log, resonances=resonances or (), **given),
        output, plot, json=as_json, force=force,
    )  # fmt: skip
