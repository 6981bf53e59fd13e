"""`fric validate`: a recorded motion replayed by the identified axis."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

import fric
from fric.cli.console import OUT, print_json, print_table
from fric.cli.options import Force, Json, LogFiles, Plot
from fric.errors import FricError
from fric.units import parse, readable


def validate(
    logs: LogFiles,
    plant: Annotated[Path, typer.Option("--plant", metavar="PLANT.yaml", help="The identified plant.")],
    controller: Annotated[
        Path | None,
        typer.Option(metavar="CONTROLLER.yaml", help="The drive's own controller; without it, the open loop alone."),
    ] = None,
    friction: Annotated[
        Path | None,
        typer.Option(metavar="FRICTION.yaml", help="The identified friction; else Coulomb, from the plant's own fit."),
    ] = None,
    model: Annotated[
        str | None, typer.Option(metavar="NAME", help="The friction file's model, where it holds several.")
    ] = None,
    load: Annotated[
        str | None, typer.Option(metavar="FORCE", help='Constant load, as "-3.2 N"; else the identified offset.')
    ] = None,
    plot: Plot = None,
    json: Json = False,
    force: Force = False,
) -> None:
    """Replay a recorded motion in closed loop and in open loop, and score it against the record."""
    fric.refuse_existing(plot, force=force)
    records = fric.read_logs(logs)
    axis, motion = records[0].axis, records[0].motion
    if model and not friction:
        raise FricError("--model names a model of a friction file", mend="Give that file with --friction.")
    identified = fric.read_plant(plant, axis=axis, motion=motion)
    cascade = fric.read_cascade(controller, axis=axis, motion=motion) if controller else None
    done = []
    for log in records:
        if friction:
            law, offset = fric.friction_and_load(friction, model, log.name, axis=axis, motion=motion)
        else:
            law, offset = fric.coulomb_of_plant(plant, motion=motion)
        weight = parse(load, "force", motion) if load else offset
        if cascade:
            done.append(fric.validate_closed_loop(log, identified, cascade, law, weight))
        done.append(fric.validate_open_loop(log, identified, law, weight))
    document = fric.validation_tree(done, records)
    if plot:
        fric.save_figure(fric.draw_validation(done[0]), plot, force=force)
    if json:
        print_json(document)
    else:
        _print(document, plot)


def _print(document: dict[str, Any], plot: Path | None) -> None:
    rows = [
        (
            f"{found['record']}, {found['loop']} loop, {found['friction']}",
            name,
            f"{100 * signal['relative']:.4g} %",
            readable(signal["rms"], signal["unit"]),
        )
        for found in document["validations"]
        for name, signal in found["signals"].items()
    ]
    print_table(("", "signal", "relative error", "rms error"), rows)
    if plot:
        OUT.print(f"wrote {plot}")
