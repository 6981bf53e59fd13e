"""`fric simulate circle`: the circular test under compensation schemes."""

from functools import partial
from pathlib import Path
from typing import Annotated, Any

import typer

import fric
from fric.cli.completion import axes
from fric.cli.console import ERR, Interruption, finish, interruption
from fric.cli.options import (
    Force,
    Gain,
    Implausible,
    Json,
    Lead,
    MachineFile,
    NominalFiles,
    Plot,
    RunFile,
    SchemeNames,
    SchemesFile,
    lead_given,
    option,
)
from fric.cli.simulate import monte_carlo as many


def circle(
    machine: MachineFile,
    scheme: SchemeNames = "all",
    velocity: Annotated[str, option("Feed along the circle.")] = "100 mm/s",
    radius: Annotated[str, option("Radius of the circle.")] = "30 mm",
    revolutions: Annotated[int, option("Revolutions; the last is looked at.")] = 2,
    clockwise: Annotated[bool, option("Turn clockwise.", "--clockwise")] = False,
    axis: Annotated[
        str | None, option("Simulate one axis alone; the other follows its reference.", autocompletion=axes)
    ] = None,
    friction: NominalFiles = None,
    gain: Gain = None,
    lead: Lead = None,
    friction_model: Annotated[
        str | None, option("Model that the machine has, of those in its file; else the richest.", metavar="NAME")
    ] = None,
    schemes: SchemesFile = None,
    monte_carlo: many.Machines = None,
    spread: many.SpreadFile = None,
    from_intervals: many.FromIntervals = False,
    measured: many.Measured = None,
    seed: many.Seed = 0,
    accuracy: many.Accuracy = "0.005 um",
    workers: many.Workers = None,
    scheduler: many.Scheduler = None,
    output: RunFile = None,
    plot: Plot = None,
    plot_reversal: Annotated[
        Path | None, option("Draw error and voltages over time near a reversal.", metavar="FIG")
    ] = None,
    force: Force = False,
    implausible: Implausible = "error",
    json: Json = False,
) -> None:
    """Run a circular test under compensation schemes: the quadrant glitches that each leaves.

    With --monte-carlo the test runs on many machines: how the glitch of each scheme is distributed over them, and how
    often each scheme is the best. Ctrl-C keeps the machines that are done.
    """
    if monte_carlo is None and (spread or from_intervals or workers or scheduler):
        raise typer.BadParameter("--spread, --from-intervals, --workers and --scheduler go with --monte-carlo")
    if measured and not from_intervals:
        raise typer.BadParameter("--measured goes with --monte-carlo and --from-intervals")
    if friction_model and from_intervals:
        raise typer.BadParameter("--friction-model does not go with --from-intervals")

    interrupted: list[Interruption] = []

    def run(advance: Any) -> Any:
        nominal_files: dict[str, Any] = {"nominal_files": friction or (), "gain": gain, "lead": lead_given(lead)}
        if from_intervals:
            subject: Any = fric.read_identified(machine, **nominal_files)
        else:
            subject = fric.read_machine(machine, friction_model=friction_model, **nominal_files)
        circles = partial(
            fric.circle, subject, scheme, velocity=velocity, radius=radius, revolutions=revolutions,
            clockwise=clockwise, axis=axis, known=schemes, advance=advance,
        )  # fmt: skip
        if monte_carlo is None:
            return circles()
        with interruption() as asked:
            interrupted.append(asked)
            return circles(
                machines=monte_carlo, measured=measured or (), spread=spread, seed=seed, accuracy=accuracy,
                workers=workers, scheduler=scheduler, interrupted=asked,
            )  # fmt: skip

    reversal = {plot_reversal: lambda made: made.reversal_figure()}
    try:
        made = finish(run, output, plot, json=json, force=force, doing="circles", also=reversal, writes="HDF5")
    except fric.FricError as error:
        if not any(asked() for asked in interrupted):
            raise
        ERR.print(f"interrupted: {error}", markup=False)
        raise typer.Exit(interrupted[0].status) from None
    if made.cut_short:
        ERR.print(
            f"interrupted: {len(made.many)} of {monte_carlo} machines are done, and are kept: "
            f"what --monte-carlo {len(made.many)} gives"
        )
        raise typer.Exit(interrupted[0].status)
