"""`fric design controller`: a cascade by gain and phase margin."""

from __future__ import annotations

from math import inf
from pathlib import Path
from typing import Annotated, Literal

import typer

import fric
from fric.cli.console import OUT, print_json
from fric.cli.design.shared import PlantArgument, print_margins, print_written
from fric.cli.options import Force, Json, Plot
from fric.errors import FricError


def controller(
    plant_file: PlantArgument,
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
    as_json: Json = False,
    force: Force = False,
) -> None:
    """Design the cascade P/PI of an axis by gain and phase margin of its sampled loops.

    The velocity loop's crossover is the highest at which it has both margins; the corner of its PI is 1/10 of it, and
    K_v/2π a third, or less where the position loop needs it. A design that is unstable or misses its margins is
    refused, with the nearest that holds.
    """
    fric.refuse_existing(output, plot, force=force)
    document = fric.read_document(plant_file, fric.PlantDocument)
    motion = document.motion
    plant = document.linear(motion)
    asked = fric.Requirement(fric.parse(phase_margin, "angle"), fric.parse_gain(gain_margin))
    rate, low_pass = fric.parse(sampling, "frequency"), fric.parse(velocity_filter, "frequency")
    largest = inf if limit is None else fric.parse(limit, "input")
    gains = [K_v, K_p, K_i]
    if any(gain is not None for gain in gains):
        if None in gains or crossover is not None:
            raise FricError("gains are checked all together", mend="Give --K_p, --K_i and --K_v, and no --crossover.")
        dimensions = ("rate", "velocity gain", "position gain")
        v, p, i = (fric.parse(str(gain), kind, motion) for gain, kind in zip(gains, dimensions, strict=True))
        design = fric.check_cascade(plant, fric.Cascade(v, p, i, low_pass, rate, largest), asked)
    else:
        design = fric.design_cascade(
            plant,
            asked,
            sampling=rate,
            velocity_filter=low_pass,
            limit=largest,
            corner_ratio=corner_ratio,
            separation=separation,
            crossover=None if crossover is None else fric.parse(crossover, "frequency"),
        )
    tree = fric.controller_tree(design, document.axis, motion)
    loops = design.loops()
    if output:
        fric.write_document(output, tree, force=force)
    if plot:
        draw = {"bode": fric.bode_figure, "nyquist": fric.nyquist_figure, "nichols": fric.nichols_figure}[view]
        fric.save_figure(draw(loops.values(), rate / 2), plot, force=force)
    if as_json:
        print_json(tree)
        return
    for name in ("K_p", "K_i", "K_v"):
        OUT.print(f"{name}  {fric.readable(tree[name]['value'], tree[name]['unit'], 4)}")
    print_margins(tree["margins"], {name: loop.title for name, loop in loops.items()})
    print_written(output, plot)
