"""`fric design controller`: a cascade by gain and phase margin."""

from pathlib import Path
from typing import Annotated, Literal

import fric
from fric.cli.console import finish
from fric.cli.options import Force, Implausible, Json, PlantArgument, Plot, option


def controller(
    plant: PlantArgument,
    output: Annotated[
        Path | None, option("The controller file to write.", "-o", "--output", metavar="CONTROLLER.yaml")
    ] = None,
    phase_margin: Annotated[str, option("That velocity and position loop have at least.", metavar="ANGLE")] = "60 deg",
    gain_margin: Annotated[str, option("That velocity and position loop have at least.", metavar="GAIN")] = "13.8 dB",
    sampling: Annotated[str, option("Of the controller.", metavar="FREQUENCY")] = "4 kHz",
    velocity_filter: Annotated[str, option("Corner of the low-pass on the velocity.", metavar="FREQUENCY")] = "500 Hz",
    limit: Annotated[str | None, option("Saturation of the control voltage.", metavar="VOLTAGE")] = None,
    corner_ratio: Annotated[float, option("Crossover of the velocity loop over corner of its PI.")] = 10.0,
    separation: Annotated[float, option("Crossover of the velocity loop over K_v/2π, at least.")] = 3.0,
    crossover: Annotated[
        str | None, option("Of the velocity loop; the highest where not given.", metavar="FREQUENCY")
    ] = None,
    K_p: Annotated[
        str | None, option("With K_i and K_v: check gains, do not seek them.", "--K_p", metavar="GAIN")
    ] = None,
    K_i: Annotated[str | None, option("As in '3156 V/m'.", "--K_i", metavar="GAIN")] = None,
    K_v: Annotated[str | None, option("As in '126 1/s'.", "--K_v", metavar="GAIN")] = None,
    plot: Plot = None,
    view: Annotated[Literal["bode", "nyquist", "nichols"], option("The figure that --plot draws.")] = "bode",
    implausible: Implausible = "error",
    as_json: Json = False,
    force: Force = False,
) -> None:
    """Design the cascade P/PI of an axis by gain and phase margin of its sampled loops.

    The velocity loop's crossover is the highest at which it has both margins; the corner of its PI is 1/10 of it, and
    K_v/2π a third, or less where the position loop needs it. A design that is unstable or misses its margins is
    refused, with the nearest that holds.
    """
    gains = (K_v, K_p, K_i) if K_v or K_p or K_i else None
    finish(
        lambda _: fric.design_controller(
            plant, phase_margin=phase_margin, gain_margin=gain_margin, sampling=sampling, limit=limit,
            velocity_filter=velocity_filter, corner_ratio=corner_ratio, separation=separation, crossover=crossover,
            gains=gains, view=view,
        ),
        output, plot, json=as_json, force=force,
    )  # fmt: skip
