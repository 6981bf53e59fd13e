"""`fric learn`: a repeated circle learned by the measured inverse."""

from pathlib import Path
from typing import Annotated, Any

import typer

import fric
from fric.cli.console import finish
from fric.cli.options import Force, Implausible, Json, Plot, argument, option


def learn(
    given: Annotated[Path, argument("A machine; or a recorded circle.", metavar="MACHINE.yaml|CIRCLE.h5")],
    output: Annotated[
        Path | None, option("Run file of the rounds; or feedforward of the next.", "-o", "--output", metavar="OUT.h5")
    ] = None,
    rounds: Annotated[int | None, option("In simulation: circles to learn from.")] = None,
    velocity: Annotated[str, option("In simulation: feed along the circle.")] = "100 mm/s",
    radius: Annotated[str, option("In simulation: radius of the circle.")] = "30 mm",
    clockwise: Annotated[bool, option("In simulation: turn clockwise.", "--clockwise")] = False,
    observer: Annotated[
        bool, option("In simulation: the disturbance observer is on.", "--observer/--no-observer")
    ] = True,
    machine: Annotated[
        Path | None, option("Of a circle: its machine; a run file tells it.", metavar="MACHINE.yaml")
    ] = None,
    before: Annotated[Path | None, option("Of a circle: the feedforward it was run with.", metavar="TABLE.h5")] = None,
    scheme: Annotated[str | None, option("Of a run file, the scheme that is taken.")] = None,
    share: Annotated[float | None, option("Share of a round that is taken over; else by the feed.")] = None,
    bandwidth: Annotated[str | None, option("Up to what frequency is learned; else by the feed.")] = None,
    plot: Plot = None,
    force: Force = False,
    implausible: Implausible = "error",
    json: Json = False,
) -> None:
    """Learn a repeated circle: the voltage against friction that the next round feeds forward, without a model of it.

    With --rounds all rounds are simulated on a machine, and what was learned is tried on another feed and radius: it
    does not carry over. From a recorded circle comes the feedforward of the next one.
    """
    nothing = rounds is None and machine is None and given.suffix != ".h5"
    if nothing or (rounds is not None and machine is not None):
        raise typer.BadParameter("give a machine with --rounds, or a circle with --machine")

    def run(advance: Any) -> Any:
        return fric.learn(
            given, rounds=rounds, machine=machine, before=before, scheme=scheme, velocity=velocity, radius=radius,
            clockwise=clockwise, share=share, bandwidth=bandwidth, observer=observer, advance=advance,
        )  # fmt: skip

    finish(run, output, plot, json=json, force=force, doing="circles", writes="HDF5")
