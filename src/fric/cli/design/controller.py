"""`fric design controller`: a cascade by gain and phase margin."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

import typer

import fric
from fric.cli.console import finish
from fric.cli.options import Force, Implausible, Json, PlantArgument, Plot


def controller(
    plant: PlantArgument,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="CONTROLLER.yaml", help="The controller file to write.")
    ] = None,
    phase_margin: Annotated[
        str, typer.Option(metavar="ANGLE", help="That velocity and position loop have at least.")
    ] = "60 deg",
    gain_margin: Annotated[
        str, typer.Option(metavar="GAIN", help="That velocity and position loop have at least.")
    ] = "13.8 dB",
    sampling: Annotated[str, typer.Option(metavar="FREQUENCY", help="Of the controller.")] = "4 kHz",
    velocity_filter: Annotated[
        str, typer.Option(metavar="FREQUENCY", help="Corner of the low-pass on the velocity.")
    ] = "500 Hz",
    limit: Annotated[str | None, typer.Option(metavar="VOLTAGE", help="Saturation of the control voltage.")] = None,
    corner_ratio: Annotated[float, typer.Option(help="Crossover of the velocity loop over corner of its PI.")] = 10.0,
    separation: Annotated[float, typer.Option(help="Crossover of the velocity loop over K_v/2π, at least.")] = 3.0,
    crossover: Annotated[
        str | None, typer.Option(metavar="FREQUENCY", help="Of the velocity loop; the highest where not given.")
    ] = None,
    K_p: Annotated[
        str | None, typer.Option("--K_p", metavar="GAIN", help="With K_i and K_v: check gains, do not seek them.")
    ] = None,
    K_i: Annotated[str | None, typer.Option("--K_i", metavar="GAIN", help="As in '3156 V/m'.")] = None,
    K_v: Annotated[str | None, typer.Option("--K_v", metavar="GAIN", help="As in '126 1/s'.")] = None,
    plot: Plot = None,
    view: Annotated[Literal["bode", "nyquist", "nichols"], typer.Option(help="The figure that --plot draws.")] = "bode",
    implausible: Implausible = "error",
    as_json: Json = False,
    force: Force = False,
) -> None:
    """Design the cascade P/PI of an axis by gain and phase margin of its sampled loops.

    The velocity loop's crossover is the highest at which it has both margins; the corner of its PI is 1/10 of it, and
    K_v/2π a third, or less where the position loop needs it. A design that is unstable or misses its margins is
    refused, with the nearest that holds.
    """
    given: dict[str, Any] = {
        "phase_margin": phase_margin,
        "gain_margin": gain_margin,
        "sampling": sampling,
        "limit": limit,
    }
    given |= {"velocity_filter": velocity_filter, "corner_ratio": corner_ratio, "separation": separation}
    gains = (K_v, K_p, K_i) if K_v or K_p or K_i else None
    finish(
        lambda _: fric.design_controller(plant, crossover=crossover, gains=gains, view=view, **given),
        output, plot, json=as_json, force=force,
    )  # fmt: skip
