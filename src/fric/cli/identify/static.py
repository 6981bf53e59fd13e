"""`fric identify static`: the Stribeck map from strokes at constant velocity."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

import typer

import fric
from fric.cli.console import OUT, print_json, print_table, print_warnings
from fric.cli.options import Force, Json, LogFiles, PlantFile, Plot
from fric.errors import FricError
from fric.units import readable


def static(
    logs: LogFiles,
    output: Annotated[Path, typer.Option("-o", "--output", metavar="FRICTION.yaml", help="Friction file to write.")],
    plant: PlantFile = None,
    delta: Annotated[str, typer.Option(metavar="VALUE|free", help="Stribeck shape factor, fixed or free.")] = "1",
    direction: Annotated[
        Literal["both", "each"], typer.Option(help="One map and an offset, or a map for each direction.")
    ] = "both",
    weights: Annotated[
        Literal["error", "equal"], typer.Option(help="Weigh strokes by their errors and scatter, or all the same.")
    ] = "error",
    average: Annotated[
        Literal["robust", "median"], typer.Option(help="Force of a stroke: Huber's robust mean, or the median.")
    ] = "robust",
    form: Annotated[
        Literal["auto", "coulomb", "stribeck"],
        typer.Option(help="Coulomb plus viscous friction, eq. (2), or what predicts held-out strokes better."),
    ] = "auto",
    plot: Plot = None,
    json: Json = False,
    force: Force = False,
) -> None:
    """Identify the static friction map F_c, F_s, v_s, delta, sigma (eq. 2) from constant-velocity strokes."""
    fric.refuse_existing(output, plot, force=force)
    records = fric.read_logs(logs)
    fit = fric.identify_static(
        records,
        plant=fric.read_plant(plant, axis=records[0].axis, motion=records[0].motion) if plant else None,
        delta=_shape_factor(delta),
        direction=direction,
        weights=weights,
        average=average,
        form=form,
    )
    document = fric.static_tree(fit, records)
    if plot:
        fric.save_figure(fric.draw_static_map(fit), plot, force=force)
    fric.write_document(output, document, force=force)
    if json:
        print_json(document)
    else:
        _print(document, output, plot)
    print_warnings(document["warnings"])


def _shape_factor(given: str) -> float | None:
    if given == "free":
        return None
    try:
        value = float(given)
    except ValueError:
        value = 0.0
    if not 0.1 <= value <= 4.0:
        raise FricError(f"delta '{given}' is not a shape factor", mend="Give a number from 0.1 to 4, or 'free'.")
    return value


def _print(document: dict[str, Any], output: Path, plot: Path | None) -> None:
    for key, title in (("static", ""), ("static_negative", "negative direction"), ("at_speed", "at one speed")):
        if key in document:
            print_table(("", "value", "95 % interval", "unit"), fric.estimate_rows(document[key]), title=title or None)
    fit = document["fit"]
    told = f"{fit['points']} strokes"
    if "rmse" in fit:
        told += f", rmse {readable(**fit['rmse'])}, R² {fit['r2']:.4f}"
    OUT.print(told)
    OUT.print(f"wrote {output}" + (f" and {plot}" if plot else ""))
